//! Which half-edges lie on one edge: found in one scan over the faces, in linear time.
//!
//! Every edge is filed under one of its ends, in a short chain of the edges that are met there. Threads share the work by
//! vertices: each scans the faces in order and files what belongs to its own range of vertices; pieces of the face list
//! that name none of those are skipped. So there is nothing to sort and nothing to lock, and the result does not depend on
//! the number of threads. One thread alone meets edges in the order in which they are numbered, and numbers them in passing.

use super::build::{filled, shared};
use super::edges::Edges;
use super::{FaceOf, NONE};
use crate::limit::KeyHasher;
use rayon::prelude::*;
use std::cell::Cell;
use std::collections::{BTreeMap, HashMap};
use std::hash::BuildHasherDefault;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// The edges of a list of faces. The *leader* of an edge is its first half-edge.
pub(super) struct Matching {
    /// The other half-edge of edges with two faces in opposite directions; elsewhere [`NONE`].
    pub twin: Vec<u32>,
    /// First outgoing half-edge of every vertex.
    pub first_outgoing: Vec<u32>,
    /// Half-edges of non-manifold edges but the leaders, ascending, with their leaders.
    pub followers: Vec<(u32, u32)>,
    /// Leaders of non-manifold edges, ascending, and whether the edge has one face only.
    pub non_manifold: Vec<(u32, bool)>,
    /// Numbers of edges by half-edge, where one share holds all edges; else empty.
    edge: Vec<u32>,
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

/// Faces whose vertices are looked at together when work is shared out.
const PIECE: usize = 1024;
/// Fewer half-edges than this are one thread's work.
const FEW: usize = 1 << 14;

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

    fn pieces(&self) -> impl IndexedParallelIterator<Item = Range<usize>> + use<> {
        let faces = self.face_offset.len() - 1;
        (0..faces.div_ceil(PIECE)).into_par_iter().map(move |p| p * PIECE..((p + 1) * PIECE).min(faces))
    }
}

/// The end of an edge that it is filed under, then the other. Either end has its turn, so that neither order of numbers nor
/// large valence loads one range with most edges.
#[inline(always)]
fn filed(a: u32, b: u32) -> (u32, u32) {
    if (a ^ b) & 1 == u32::from(a < b) { (b, a) } else { (a, b) }
}

/// Where what is found about half-edges is noted.
trait Notes {
    fn twin(&self, h: u32) -> u32;
    fn set_twin(&self, h: u32, twin: u32);
    /// The edge of a half-edge, by its number within the share.
    fn set_edge(&self, h: u32, edge: u32);
}

/// By one thread for all half-edges.
struct Alone<'a> {
    twin: &'a [Cell<u32>],
    edge: &'a [Cell<u32>],
}

impl Notes for Alone<'_> {
    #[inline(always)]
    fn twin(&self, h: u32) -> u32 {
        self.twin[h as usize].get()
    }
    #[inline(always)]
    fn set_twin(&self, h: u32, twin: u32) {
        self.twin[h as usize].set(twin);
    }
    #[inline(always)]
    fn set_edge(&self, h: u32, edge: u32) {
        self.edge[h as usize].set(edge);
    }
}

/// By several threads, none of which writes where another reads. Numbers within shares are not kept.
struct Together<'a> {
    twin: &'a [AtomicU32],
}

impl Notes for Together<'_> {
    #[inline(always)]
    fn twin(&self, h: u32) -> u32 {
        self.twin[h as usize].load(Relaxed)
    }
    #[inline(always)]
    fn set_twin(&self, h: u32, twin: u32) {
        self.twin[h as usize].store(twin, Relaxed);
    }
    #[inline(always)]
    fn set_edge(&self, _: u32, _: u32) {}
}

/// The edges that are filed under one range of vertices, numbered as they are met.
struct Share {
    vertices: Range<u32>,
    /// By vertex, the first edge of its chain.
    head: Vec<u32>,
    /// By edge, the next one of its chain.
    next: Vec<u32>,
    ends: Vec<[u32; 2]>,
    leader: Vec<u32>,
    /// Edges at vertices whose chains are full.
    crowded: HashMap<(u32, u32), u32, BuildHasherDefault<KeyHasher>>,
    /// Non-manifold edges but those with equal ends.
    unusual: BTreeMap<u32, Unusual>,
    followers: Vec<(u32, u32)>,
    non_manifold: Vec<(u32, bool)>,
}

struct Unusual {
    faces: u32,
    last_face: u32,
}

/// Longest chain. Longer ones make poles slow, shorter ones call for the map at ordinary vertices.
const LONGEST: usize = 24;

/// Some faces, and the least and the largest of the vertices that they name.
struct Span {
    faces: Range<usize>,
    least: u32,
    most: u32,
}

/// A half-edge, its ends, and the first half-edge of its face.
#[derive(Clone, Copy)]
struct Side {
    h: u32,
    a: u32,
    b: u32,
    first: u32,
}

impl Share {
    /// Files what begins or ends in `vertices`; `outgoing` are the first outgoing half-edges of these.
    fn new(list: FaceList<'_>, vertices: Range<u32>, spans: &[Span], notes: &impl Notes, outgoing: &mut [u32]) -> Self {
        // Half of all half-edges, where there are few boundaries; more room is made when it is needed.
        let part = vertices.len() as f64 / list.vertex_count.max(1) as f64;
        let edges = (0.52 * part * list.origin.len() as f64) as usize;
        let mut share = Self {
            head: filled(vertices.len(), NONE),
            next: subsurf_memory::with_capacity(edges),
            ends: subsurf_memory::with_capacity(edges),
            leader: subsurf_memory::with_capacity(edges),
            crowded: HashMap::default(),
            unusual: BTreeMap::new(),
            followers: Vec::new(),
            non_manifold: Vec::new(),
            vertices,
        };
        for span in spans {
            if span.most < share.vertices.start || span.least >= share.vertices.end {
                continue;
            }
            list.each(span.faces.clone(), |first, corners| {
                let mut a = corners[0];
                for i in 0..corners.len() {
                    let b = if i + 1 == corners.len() { corners[0] } else { corners[i + 1] };
                    share.visit(list, Side { h: first + i as u32, a, b, first }, notes, outgoing);
                    a = b;
                }
            });
        }
        for (&edge, state) in &share.unusual {
            share.non_manifold.push((share.leader[edge as usize], state.faces < 2));
        }
        share
    }

    /// Takes in a half-edge.
    #[inline(always)]
    fn visit(&mut self, list: FaceList<'_>, side: Side, notes: &impl Notes, outgoing: &mut [u32]) {
        let Side { h, a, b, .. } = side;
        let start = self.vertices.start;
        if let Some(outgoing) = outgoing.get_mut(a.wrapping_sub(start) as usize) {
            *outgoing = h.min(*outgoing);
        }
        let (own, other) = filed(a, b);
        let Some(&head) = self.head.get(own.wrapping_sub(start) as usize) else { return };
        if a == b {
            // Both ends equal: an edge of its own, whatever else there is.
            return self.add_own(side, notes);
        }
        let (mut edge, mut length) = (head, 0);
        while edge != NONE {
            let [c, d] = self.ends[edge as usize];
            if c ^ d == a ^ b {
                return self.join(list, side, edge, notes);
            }
            edge = self.next[edge as usize];
            length += 1;
        }
        if length >= LONGEST {
            return self.visit_crowded(list, side, (own, other), notes);
        }
        self.head[(own - start) as usize] = self.next.len() as u32;
        self.push(side, head, notes);
    }

    /// Adds an edge.
    #[inline(always)]
    fn push(&mut self, Side { h, a, b, .. }: Side, next: u32, notes: &impl Notes) {
        notes.set_twin(h, NONE);
        notes.set_edge(h, self.next.len() as u32);
        self.next.push(next);
        self.ends.push([a, b]);
        self.leader.push(h);
    }

    /// The same where the chain is full.
    #[cold]
    fn visit_crowded(&mut self, list: FaceList<'_>, side: Side, ends: (u32, u32), notes: &impl Notes) {
        match self.crowded.get(&ends) {
            Some(&edge) => self.join(list, side, edge, notes),
            None => {
                self.crowded.insert(ends, self.next.len() as u32);
                self.push(side, NONE, notes);
            }
        }
    }

    /// Takes in a further half-edge of an edge.
    #[inline(always)]
    fn join(&mut self, list: FaceList<'_>, side: Side, edge: u32, notes: &impl Notes) {
        let leader = self.leader[edge as usize];
        let is_other_side = self.ends[edge as usize][0] != side.a && leader < side.first;
        let is_single = notes.twin(leader) == NONE;
        if is_other_side && is_single && (self.unusual.is_empty() || !self.unusual.contains_key(&edge)) {
            notes.set_twin(leader, side.h);
            notes.set_twin(side.h, leader);
            notes.set_edge(side.h, edge);
        } else {
            self.join_unusual(list, side, edge, notes);
        }
    }

    /// A half-edge that makes the edge non-manifold, or it was so before: it has two faces already, or `side` runs the same way, or
    /// its last face is that of `side`, which then has an edge of its own there.
    #[cold]
    fn join_unusual(&mut self, list: FaceList<'_>, side: Side, edge: u32, notes: &impl Notes) {
        let leader = self.leader[edge as usize];
        let state = self.unusual.entry(edge).or_insert_with(|| {
            let second = notes.twin(leader);
            if second == NONE {
                return Unusual { faces: 1, last_face: list.face.get(leader) };
            }
            notes.set_twin(leader, NONE);
            notes.set_twin(second, NONE);
            self.followers.push((second, leader));
            Unusual { faces: 2, last_face: list.face.get(second) }
        });
        let f = list.face.get(side.h);
        if state.last_face == f {
            self.add_own(side, notes);
        } else {
            *state = Unusual { faces: state.faces + 1, last_face: f };
            self.followers.push((side.h, leader));
            notes.set_twin(side.h, NONE);
            notes.set_edge(side.h, edge);
        }
    }

    /// A half-edge with a non-manifold edge of its own.
    #[cold]
    fn add_own(&mut self, side: Side, notes: &impl Notes) {
        self.push(side, NONE, notes);
        self.non_manifold.push((side.h, true));
    }

    fn find(&self, own: u32, other: u32) -> Option<u32> {
        let mut edge = self.head[(own - self.vertices.start) as usize];
        while edge != NONE {
            let [a, b] = self.ends[edge as usize];
            if a ^ b == own ^ other {
                return Some(self.leader[edge as usize]);
            }
            edge = self.next[edge as usize];
        }
        self.crowded.get(&(own, other)).map(|&edge| self.leader[edge as usize])
    }
}

impl Matching {
    pub fn new(list: FaceList<'_>) -> Self {
        let threads = if list.origin.len() < FEW { 1 } else { rayon::current_num_threads() };
        Self::with_threads(list, threads)
    }

    /// The same, the vertices shared out to so many threads.
    fn with_threads(list: FaceList<'_>, threads: usize) -> Self {
        let half_edges = list.origin.len();
        let mut first_outgoing = filled(list.vertex_count, NONE);
        if threads == 1 {
            let (mut twin, mut edge) = (subsurf_memory::zeroed(half_edges), subsurf_memory::zeroed(half_edges));
            let notes = Alone {
                twin: Cell::from_mut(&mut twin[..]).as_slice_of_cells(),
                edge: Cell::from_mut(&mut edge[..]).as_slice_of_cells(),
            };
            let everything = Span { faces: 0..list.face_offset.len() - 1, least: 0, most: NONE };
            let all = 0..list.vertex_count as u32;
            let share = Share::new(list, all, &[everything], &notes, &mut first_outgoing);
            return Self::of_shares(vec![share], twin, edge, first_outgoing);
        }
        let span = |faces: Range<usize>| {
            let corners = &list.origin[list.face_offset[faces.start] as usize..list.face_offset[faces.end] as usize];
            let (least, most) = corners.iter().fold((NONE, 0), |(a, b), &v| (v.min(a), v.max(b)));
            Span { faces, least, most }
        };
        let spans: Vec<Span> = list.pieces().map(span).collect();
        let bound = |k: usize| k * list.vertex_count / threads;
        let mut parts = Vec::with_capacity(threads);
        let mut outgoing = &mut first_outgoing[..];
        for k in 0..threads {
            let own = outgoing.split_off_mut(..bound(k + 1) - bound(k)).unwrap_or_default();
            parts.push((bound(k) as u32..bound(k + 1) as u32, own));
        }
        let twin = shared(half_edges, 0);
        let notes = Together { twin: &twin };
        let share = |(part, outgoing): (_, &mut [u32])| Share::new(list, part, &spans, &notes, outgoing);
        let shares = parts.into_par_iter().map(share).collect();
        let twin = twin.into_iter().map(AtomicU32::into_inner).collect();
        Self::of_shares(shares, twin, Vec::new(), first_outgoing)
    }

    fn of_shares(mut shares: Vec<Share>, twin: Vec<u32>, edge: Vec<u32>, first_outgoing: Vec<u32>) -> Self {
        let (mut followers, mut non_manifold) = (Vec::new(), Vec::new());
        for share in &mut shares {
            followers.append(&mut share.followers);
            non_manifold.append(&mut share.non_manifold);
        }
        followers.sort_unstable();
        non_manifold.sort_unstable();
        Self { twin, first_outgoing, followers, non_manifold, edge, shares }
    }

    /// Leader of the first edge between `a` and `b`, before edges are taken.
    pub fn find(&self, a: u32, b: u32) -> Option<u32> {
        let (own, other) = filed(a, b);
        self.shares[self.shares.partition_point(|s| s.vertices.end <= own)].find(own, other)
    }

    /// The edges by number. What else is known of them is forgotten.
    pub fn take_edges(&mut self, list: FaceList<'_>) -> Edges {
        match std::mem::take(&mut self.shares).pop() {
            Some(Share { mut ends, mut leader, .. }) if !self.edge.is_empty() => {
                ends.shrink_to_fit();
                leader.shrink_to_fit();
                Edges { of_half_edge: std::mem::take(&mut self.edge), vertices: ends, half_edge: leader }
            }
            _ => Edges::number(list, &self.twin, &self.followers),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    /// Everything that is asked of a matching.
    #[derive(PartialEq, Debug)]
    struct Found {
        twin: Vec<u32>,
        first_outgoing: Vec<u32>,
        followers: Vec<(u32, u32)>,
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
            let edges = matching.take_edges(list);
            Self {
                twin: matching.twin,
                first_outgoing: matching.first_outgoing,
                followers: matching.followers,
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
        for threads in [2, 3, 7] {
            let several = Found::new(list, threads);
            assert!(several == one, "{what}, {threads} threads: {several:?} instead of {one:?}");
        }
    }

    fn faces(shape: &shapes::Shape) -> Vec<Vec<u32>> {
        shape.mesh.faces().map(<[u32]>::to_vec).collect()
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
