//! Which half-edges lie on one edge: found in one scan over the faces, in linear time.
//!
//! Threads share the faces: each scans its own and files every edge under one of its ends, in a short chain of the edges that are
//! met there. Then the chains at vertices that several have met are [put together](joined). So there is nothing to sort and nothing
//! to lock, nobody looks at all faces, and the result does not depend on the number of threads. Only where faces of several threads
//! meet in an edge that is not manifold does one thread do it all again.

mod joined;
mod share;

use super::edges::Edges;
use super::{FaceOf, NONE};
use rayon::prelude::*;
use share::{Own, Share};
use std::ops::Range;

/// The edges of a list of faces. The *leader* of an edge is its first half-edge.
pub(super) struct Matching {
    /// The other half-edge of edges with two faces in opposite directions; elsewhere [`NONE`].
    pub twin: Vec<u32>,
    /// First outgoing half-edge of every vertex.
    pub first_outgoing: Vec<u32>,
    /// Leaders of non-manifold edges, ascending, and whether the edge has one face only.
    pub non_manifold: Vec<(u32, bool)>,
    /// Number of the edge of every half-edge.
    edge: Vec<u32>,
    /// The first one holds all edges by number.
    shares: Vec<Share>,
}

/// Faces as they are given.
#[derive(Clone, Copy)]
pub(super) struct FaceList<'a> {
    pub vertex_count: usize,
    pub face_offset: &'a [u32],
    pub origin: &'a [u32],
    pub face: &'a FaceOf,
}

/// Fewer half-edges than this are one thread's work.
const FEW: usize = 1 << 14;

/// How often each vertex is in the tables of a thread, on average, at most; eight bytes each. Larger: memory, where faces are far from
/// one another in the list; smaller: fewer threads there.
const MOST_OFTEN: usize = 8;

impl FaceList<'_> {
    /// Calls `visit` with the first half-edge and the corners of faces in order.
    #[inline(always)]
    fn each(&self, faces: Range<usize>, mut visit: impl FnMut(u32, &[u32])) {
        match self.face {
            FaceOf::Quads => {
                let corners = self.origin[4 * faces.start..4 * faces.end].as_chunks::<4>().0;
                corners.iter().zip(faces).for_each(|(face, f)| visit(4 * f as u32, face));
            }
            FaceOf::Triangles => {
                let corners = self.origin[3 * faces.start..3 * faces.end].as_chunks::<3>().0;
                corners.iter().zip(faces).for_each(|(face, f)| visit(3 * f as u32, face));
            }
            FaceOf::Listed(_) => {
                for w in self.face_offset[faces.start..=faces.end].windows(2) {
                    visit(w[0], &self.origin[w[0] as usize..w[1] as usize]);
                }
            }
        }
    }

    fn face_count(&self) -> usize {
        self.face_offset.len() - 1
    }

    fn half_edges(&self, faces: &Range<usize>) -> Range<usize> {
        self.face_offset[faces.start] as usize..self.face_offset[faces.end] as usize
    }

    /// All faces in so many parts of about as many half-edges.
    fn parts(&self, parts: usize) -> Vec<Range<usize>> {
        let bound = |k: usize| match k {
            0 => 0,
            _ => self.face_offset.partition_point(|&first| (first as usize) < k * self.origin.len() / parts),
        };
        (0..parts).map(|k| bound(k)..if k + 1 == parts { self.face_count() } else { bound(k + 1) }).collect()
    }

    /// From the least to the largest of the vertices that some faces name.
    fn vertices(&self, faces: &Range<usize>) -> Range<u32> {
        let corners = &self.origin[self.half_edges(faces)];
        let (least, end) = corners.iter().fold((NONE, 0), |(a, b), &v| (v.min(a), b.max(v + 1)));
        least.min(end)..end
    }

    /// The faces of so many threads and their vertices; of fewer where these overlap too much.
    fn shares(&self, threads: usize) -> Vec<(Range<usize>, Range<u32>)> {
        let mut parts = threads;
        loop {
            let shares: Vec<_> =
                self.parts(parts).into_par_iter().map(|faces| (self.vertices(&faces), faces)).collect();
            let entries: usize = shares.iter().map(|(vertices, _)| vertices.len()).sum();
            if parts <= MOST_OFTEN || entries <= MOST_OFTEN * self.vertex_count {
                return shares.into_iter().map(|(vertices, faces)| (faces, vertices)).collect();
            }
            parts = parts.div_ceil(2);
        }
    }
}

impl Matching {
    pub fn new(list: FaceList<'_>) -> Self {
        let threads = if list.origin.len() < FEW { 1 } else { rayon::current_num_threads() };
        Self::with_threads(list, threads)
    }

    /// The same, the faces shared out to so many threads.
    fn with_threads(list: FaceList<'_>, threads: usize) -> Self {
        let half_edges = list.origin.len();
        let (mut twin, mut edge) = (subsurf_memory::zeroed(half_edges), subsurf_memory::zeroed(half_edges));
        if threads > 1 {
            let (faces, vertices): (Vec<_>, Vec<_>) = list.shares(threads).into_iter().unzip();
            let mut owns = Own::of_parts(list, faces, &mut twin, &mut edge);
            let share = |(own, vertices): (&mut Own<'_>, _)| Share::new(list, vertices, own);
            let mut shares: Vec<Share> = owns.par_iter_mut().zip(vertices).map(share).collect();
            if let Some(first_outgoing) = joined::join(list, &mut shares, &mut owns) {
                return Self::of_shares(shares, twin, edge, first_outgoing);
            }
        }
        let mut own = Own { faces: 0..list.face_count(), first: 0, twin: &mut twin, edge: &mut edge };
        let mut share = Share::new(list, 0..list.vertex_count as u32, &mut own);
        let first_outgoing = std::mem::take(&mut share.outgoing);
        Self::of_shares(vec![share], twin, edge, first_outgoing)
    }

    fn of_shares(mut shares: Vec<Share>, twin: Vec<u32>, edge: Vec<u32>, first_outgoing: Vec<u32>) -> Self {
        let mut non_manifold: Vec<_> =
            shares.iter_mut().flat_map(|share| std::mem::take(&mut share.non_manifold)).collect();
        non_manifold.sort_unstable();
        Self { twin, first_outgoing, non_manifold, edge, shares }
    }

    /// Leader of the first edge between `a` and `b`, before edges are taken.
    pub fn find(&self, a: u32, b: u32) -> Option<u32> {
        // Shares come in the order of their faces.
        self.shares.iter().find_map(|share| share.find(a, b).map(|edge| share.leader[edge as usize]))
    }

    /// The edges by number. What else is known of them is forgotten.
    pub fn take_edges(&mut self) -> Edges {
        let Share { mut ends, mut leader, .. } = std::mem::take(&mut self.shares).swap_remove(0);
        ends.shrink_to_fit();
        leader.shrink_to_fit();
        Edges { of_half_edge: std::mem::take(&mut self.edge), vertices: ends, half_edge: leader }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::ControlMesh;
    use crate::shapes;
    use crate::tags::Tags;

    /// Everything that is asked of a matching.
    #[derive(PartialEq, Debug)]
    struct Found {
        twin: Vec<u32>,
        first_outgoing: Vec<u32>,
        non_manifold: Vec<(u32, bool)>,
        /// Leaders between the ends of every half-edge, from either end, and between vertices without an edge.
        found: Vec<Option<u32>>,
        edge_of_half_edge: Vec<u32>,
        edge_vertices: Vec<[u32; 2]>,
        edge_half_edge: Vec<u32>,
    }

    impl Found {
        fn new(list: FaceList<'_>, threads: usize) -> Self {
            let mut matching = Matching::with_threads(list, threads);
            let mut found = Vec::new();
            for (h, &a) in list.origin.iter().enumerate() {
                let b = list.origin[list.face.next(h as u32, list.face_offset) as usize];
                found.extend([matching.find(a, b), matching.find(b, a)]);
                found.push(matching.find(a, (7 * h % list.vertex_count) as u32));
            }
            let edges = matching.take_edges();
            Self {
                twin: matching.twin,
                first_outgoing: matching.first_outgoing,
                non_manifold: matching.non_manifold,
                found,
                edge_of_half_edge: edges.of_half_edge,
                edge_vertices: edges.vertices,
                edge_half_edge: edges.half_edge,
            }
        }
    }

    fn is_the_same_for_any_number_of_threads(what: &str, faces: &[Vec<u32>]) {
        let origin = faces.concat();
        let mut face_offset = vec![0];
        faces.iter().for_each(|face| face_offset.push(face_offset.last().unwrap() + face.len() as u32));
        // One vertex has no face.
        let vertex_count = *origin.iter().max().unwrap() as usize + 2;
        let face = FaceOf::new(&face_offset);
        let list = FaceList { vertex_count, face_offset: &face_offset, origin: &origin, face: &face };
        let one = Found::new(list, 1);
        for threads in [2, 3, 7, 64] {
            let several = Found::new(list, threads);
            assert!(several == one, "{what}, {threads} threads: {several:?} instead of {one:?}");
        }
    }

    fn faces(shape: &shapes::Shape) -> Vec<Vec<u32>> {
        shape.mesh.faces().map(<[u32]>::to_vec).collect()
    }

    /// How many threads found the edges in the end.
    fn threads_that_serve(faces: &[Vec<u32>], threads: usize) -> usize {
        let mesh = ControlMesh::new(faces, Tags::default()).unwrap();
        let face = FaceOf::new(mesh.face_offsets());
        let (vertex_count, face_offset, origin) = (mesh.vertex_count(), mesh.face_offsets(), mesh.corners());
        Matching::with_threads(FaceList { vertex_count, face_offset, origin, face: &face }, threads).shares.len()
    }

    #[test]
    fn one_thread_does_the_work_of_several_only_where_edges_are_odd_between_them() {
        let mut pole = faces(&shapes::cone(300));
        // Without its base, whose edges lie at all the others.
        pole.pop();
        for (name, list) in [("grid", faces(&shapes::grid(30, 30))), ("pole", pole)] {
            assert_eq!(threads_that_serve(&list, 3), 3, "{name}");
            // Neighbours far from one another in the list.
            let scattered: Vec<_> = (0..7).flat_map(|k| list.iter().skip(k).step_by(7).cloned()).collect();
            assert_eq!(threads_that_serve(&scattered, 3), 3, "{name}, scattered");
            is_the_same_for_any_number_of_threads(name, &scattered);
            // Three faces at an edge, among the faces of one thread, then of two.
            let mut odd = list.clone();
            odd.insert(11, list[10].clone());
            assert_eq!(threads_that_serve(&odd, 3), 3, "{name}, a face twice");
            odd.remove(11);
            odd.push(list[10].clone());
            assert_eq!(threads_that_serve(&odd, 3), 1, "{name}, a face at the end too");
            is_the_same_for_any_number_of_threads(name, &odd);
        }
    }

    #[test]
    fn few_threads_serve_where_all_would_need_tables_of_all_vertices() {
        let list = faces(&shapes::grid(30, 30));
        assert_eq!(threads_that_serve(&list, 64), 64);
        let scattered: Vec<_> = (0..31).flat_map(|k| list.iter().skip(k).step_by(31).cloned()).collect();
        assert_eq!(threads_that_serve(&scattered, 64), MOST_OFTEN);
    }

    #[test]
    fn edges_do_not_depend_on_the_number_of_threads() {
        let mut all = shapes::all();
        all.extend(shapes::all_triangles());
        // A pole with more edges than a chain takes.
        all.extend([shapes::three_sheets(), shapes::cone(300)]);
        all.iter().for_each(|shape| is_the_same_for_any_number_of_threads(&shape.name, &faces(shape)));
    }

    #[test]
    fn edges_of_long_lists_do_not_depend_on_the_number_of_threads() {
        // Several pieces, some of which threads skip, and odd edges in the last one.
        let grid = shapes::grid(70, 70);
        let mut list = faces(&grid);
        for odd in [shapes::three_sheets(), shapes::degenerate_faces(), shapes::cone(60)] {
            let first = list.iter().flatten().max().unwrap() + 1;
            list.extend(faces(&odd).into_iter().map(|face| face.into_iter().map(|v| v + first).collect::<Vec<_>>()));
        }
        is_the_same_for_any_number_of_threads("grid and odd shapes", &list);
        list.reverse();
        is_the_same_for_any_number_of_threads("odd shapes and grid", &list);
    }

    #[test]
    fn edges_of_faces_in_disorder_do_not_depend_on_the_number_of_threads() {
        // Few vertices: edges of many faces, faces that name a vertex or an edge twice, chains that are full.
        for vertices in [3u64, 5, 12, 90] {
            let mut x = vertices;
            let mut next = |n: u64| {
                x = x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                ((x >> 33) % n) as u32
            };
            let faces: Vec<Vec<u32>> = (0..2000).map(|_| (0..3 + next(3)).map(|_| next(vertices)).collect()).collect();
            is_the_same_for_any_number_of_threads(&format!("faces of {vertices} vertices"), &faces);
        }
    }
}
