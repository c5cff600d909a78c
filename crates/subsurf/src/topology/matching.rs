//! Which half-edges lie on one edge: found in one scan over the faces, in linear time.
//!
//! Every edge is filed under one of its ends, in a short chain of the edges that are met there. Threads share the work by
//! vertices: each scans the faces in order and files what belongs to its own range of vertices; pieces of the face list
//! that name none of those are skipped. So there is nothing to sort and nothing to lock, and the result does not depend on
//! the number of threads.

use super::build::{filled, shared};
use super::{FaceOf, NONE};
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// The edges of a list of faces, before they have numbers. The *leader* of an edge is its first half-edge.
pub(super) struct Matching {
    /// The other half-edge of edges with two faces in opposite directions; elsewhere [`NONE`].
    pub twin: Vec<u32>,
    /// First outgoing half-edge of every vertex.
    pub first_outgoing: Vec<u32>,
    /// Half-edges of non-manifold edges but the leaders, ascending, with their leaders.
    pub followers: Vec<(u32, u32)>,
    /// Leaders of non-manifold edges, ascending, and whether the edge has one face only.
    pub non_manifold: Vec<(u32, bool)>,
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
    #[inline]
    fn each(&self, faces: Range<usize>, mut visit: impl FnMut(u32, &[u32])) {
        match self.face {
            FaceOf::Quads => {
                let corners = &self.origin[4 * faces.start..4 * faces.end];
                corners.chunks_exact(4).zip(faces).for_each(|(face, f)| visit(4 * f as u32, face));
            }
            FaceOf::Triangles => {
                let corners = &self.origin[3 * faces.start..3 * faces.end];
                corners.chunks_exact(3).zip(faces).for_each(|(face, f)| visit(3 * f as u32, face));
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
#[inline]
fn filed(a: u32, b: u32) -> (u32, u32) {
    if (a ^ b) & 1 == u32::from(a < b) { (b, a) } else { (a, b) }
}

/// The edges that are filed under one range of vertices.
struct Share {
    vertices: Range<u32>,
    ends: Vec<End>,
    edges: Vec<Filed>,
    /// Edges at vertices whose chains are full.
    crowded: HashMap<(u32, u32), u32>,
    /// Non-manifold edges but those with equal ends.
    unusual: BTreeMap<u32, Unusual>,
    followers: Vec<(u32, u32)>,
    non_manifold: Vec<(u32, bool)>,
}

/// What is known of a vertex: the first edge of its chain, and its first outgoing half-edge.
#[derive(Clone, Copy)]
struct End {
    head: u32,
    outgoing: u32,
}

/// An edge in its chain.
struct Filed {
    other: u32,
    next: u32,
    leader: u32,
}

struct Unusual {
    faces: u32,
    last_face: u32,
}

/// Longest chain. Longer ones make poles slow, shorter ones call for the map at ordinary vertices.
const LONGEST: usize = 24;

impl Share {
    fn new(list: FaceList<'_>, vertices: Range<u32>, spans: &[[u32; 2]], twin: &[AtomicU32]) -> Self {
        let mut share = Self {
            ends: filled(vertices.len(), End { head: NONE, outgoing: NONE }),
            edges: subsurf_memory::with_capacity(2 * vertices.len() + vertices.len() / 8),
            crowded: HashMap::new(),
            unusual: BTreeMap::new(),
            followers: Vec::new(),
            non_manifold: Vec::new(),
            vertices,
        };
        let faces = list.face_offset.len() - 1;
        for (piece, &[least, most]) in spans.iter().enumerate() {
            if most < share.vertices.start || least >= share.vertices.end {
                continue;
            }
            list.each(piece * PIECE..((piece + 1) * PIECE).min(faces), |first, corners| {
                let mut a = corners[0];
                for i in 0..corners.len() {
                    let b = if i + 1 == corners.len() { corners[0] } else { corners[i + 1] };
                    share.visit(list, first + i as u32, a, b, twin);
                    a = b;
                }
            });
        }
        for (&edge, state) in &share.unusual {
            share.non_manifold.push((share.edges[edge as usize].leader, state.faces < 2));
        }
        share
    }

    /// Takes in half-edge `h` from `a` to `b`.
    #[inline]
    fn visit(&mut self, list: FaceList<'_>, h: u32, a: u32, b: u32, twin: &[AtomicU32]) {
        let start = self.vertices.start;
        if let Some(end) = self.ends.get_mut(a.wrapping_sub(start) as usize)
            && end.outgoing == NONE
        {
            end.outgoing = h;
        }
        let (own, other) = filed(a, b);
        let Some(&End { head, .. }) = self.ends.get(own.wrapping_sub(start) as usize) else { return };
        if a == b {
            // Both ends equal: an edge of its own, whatever else there is.
            self.non_manifold.push((h, true));
            return;
        }
        let (mut edge, mut length) = (head, 0);
        while edge != NONE {
            let filed = &self.edges[edge as usize];
            if filed.other == other {
                return self.join(list, edge, h, a, twin);
            }
            edge = filed.next;
            length += 1;
        }
        if length >= LONGEST {
            return self.visit_crowded(list, h, a, (own, other), twin);
        }
        self.ends[(own - start) as usize].head = self.edges.len() as u32;
        self.edges.push(Filed { other, next: head, leader: h });
    }

    /// The same where the chain is full.
    #[cold]
    fn visit_crowded(&mut self, list: FaceList<'_>, h: u32, a: u32, ends: (u32, u32), twin: &[AtomicU32]) {
        match self.crowded.get(&ends) {
            Some(&edge) => self.join(list, edge, h, a, twin),
            None => {
                self.crowded.insert(ends, self.edges.len() as u32);
                self.edges.push(Filed { other: ends.1, next: NONE, leader: h });
            }
        }
    }

    /// Half-edge `h`, which starts at `a`, is a further one of an edge.
    #[inline]
    fn join(&mut self, list: FaceList<'_>, edge: u32, h: u32, a: u32, twin: &[AtomicU32]) {
        let leader = self.edges[edge as usize].leader;
        let is_other_side = list.origin[leader as usize] != a && list.face.get(leader) != list.face.get(h);
        let is_single = twin[leader as usize].load(Relaxed) == NONE;
        if is_other_side && is_single && (self.unusual.is_empty() || !self.unusual.contains_key(&edge)) {
            twin[leader as usize].store(h, Relaxed);
            twin[h as usize].store(leader, Relaxed);
        } else {
            self.join_unusual(list, edge, h, twin);
        }
    }

    /// Half-edge `h` makes the edge non-manifold, or it was so before: it has two faces already, or `h` runs the same way, or
    /// its last face is that of `h`, which then has an edge of its own there.
    #[cold]
    fn join_unusual(&mut self, list: FaceList<'_>, edge: u32, h: u32, twin: &[AtomicU32]) {
        let leader = self.edges[edge as usize].leader;
        let state = self.unusual.entry(edge).or_insert_with(|| {
            let second = twin[leader as usize].swap(NONE, Relaxed);
            if second == NONE {
                return Unusual { faces: 1, last_face: list.face.get(leader) };
            }
            twin[second as usize].store(NONE, Relaxed);
            self.followers.push((second, leader));
            Unusual { faces: 2, last_face: list.face.get(second) }
        });
        let f = list.face.get(h);
        if state.last_face == f {
            self.non_manifold.push((h, true));
        } else {
            *state = Unusual { faces: state.faces + 1, last_face: f };
            self.followers.push((h, leader));
        }
    }

    fn find(&self, own: u32, other: u32) -> Option<u32> {
        let mut edge = self.ends[(own - self.vertices.start) as usize].head;
        while edge != NONE {
            let filed = &self.edges[edge as usize];
            if filed.other == other {
                return Some(filed.leader);
            }
            edge = filed.next;
        }
        self.crowded.get(&(own, other)).map(|&edge| self.edges[edge as usize].leader)
    }
}

impl Matching {
    pub fn new(list: FaceList<'_>) -> Self {
        let half_edges = list.origin.len();
        let threads = if half_edges < FEW { 1 } else { rayon::current_num_threads() };
        let spans: Vec<[u32; 2]> = if threads == 1 {
            vec![[0, NONE]; (list.face_offset.len() - 1).div_ceil(PIECE)]
        } else {
            let corners = |f: Range<usize>| list.face_offset[f.start] as usize..list.face_offset[f.end] as usize;
            let span = |faces| list.origin[corners(faces)].iter().fold([NONE, 0], |[a, b], &v| [a.min(v), b.max(v)]);
            list.pieces().map(span).collect()
        };
        let twin = shared(half_edges, NONE);
        let bound = |k: usize| (k * list.vertex_count / threads) as u32;
        let mut shares: Vec<Share> =
            (0..threads).into_par_iter().map(|k| Share::new(list, bound(k)..bound(k + 1), &spans, &twin)).collect();
        let mut out = Self {
            twin: twin.into_iter().map(AtomicU32::into_inner).collect(),
            first_outgoing: subsurf_memory::with_capacity(list.vertex_count),
            followers: Vec::new(),
            non_manifold: Vec::new(),
            shares: Vec::new(),
        };
        for share in &mut shares {
            out.first_outgoing.extend(share.ends.iter().map(|end| end.outgoing));
            out.followers.append(&mut share.followers);
            out.non_manifold.append(&mut share.non_manifold);
        }
        out.followers.sort_unstable();
        out.non_manifold.sort_unstable();
        out.shares = shares;
        out
    }

    /// Leader of the first edge between `a` and `b`.
    pub fn find(&self, a: u32, b: u32) -> Option<u32> {
        let (own, other) = filed(a, b);
        self.shares[self.shares.partition_point(|s| s.vertices.end <= own)].find(own, other)
    }

    /// Gives back the memory that [`find`](Self::find) needs.
    pub fn forget(&mut self) {
        self.shares = Vec::new();
    }
}
