//! The quad split: every corner of every face becomes a quad, and its half-edges follow from the parent's by index
//! arithmetic alone (after Dupuy, Vanhoey 2021), which keeps OpenSubdiv's order.
//!
//! Half-edge `h` of the parent starts at `V`; its child is face `h` of the next level:
//!
//! ```text
//!   E(prev h) ◀── c ─── F           a: V → E(h)         half of edge(h)
//!       │               ▲           b: E(h) → F         inside, edge h
//!       d       h       b           c: F → E(prev h)    inside, edge prev(h)
//!       ▼               │           d: E(prev h) → V    half of edge(prev h)
//!       V ──── a ───▶ E(h)
//! ```
//!
//! In a quad the child's corner `j` is the parent's corner `j`, so that (u,v) axes keep their direction; elsewhere the
//! old vertex comes first.

use super::split::{SHARE, Split, half, runs_forward};
use crate::index::HalfEdge;
use crate::topology::{NONE, Topology};
use rayon::prelude::*;

/// The child face of one half-edge.
#[derive(Clone, Copy)]
struct Child {
    first: u32,
    /// Corner that holds the old vertex.
    turn: u32,
}

impl Child {
    fn of(t: &Topology, h: HalfEdge) -> Self {
        let face = t.face(h);
        let turn = if t.sides(face) == 4 { h.0 - t.first(face) } else { 0 };
        Self { first: 4 * h.0, turn }
    }

    /// Corner where half-edge `a` (0), `b` (1), `c` (2) or `d` (3) starts.
    fn corner(self, k: u32) -> usize {
        ((self.turn + k) & 3) as usize
    }

    fn half_edge(self, k: u32) -> u32 {
        self.first + self.corner(k) as u32
    }
}

const A: u32 = 0;
const B: u32 = 1;
const C: u32 = 2;
const D: u32 = 3;

/// The topology one level down.
pub(super) fn child(t: &Topology) -> Topology {
    let (vertices, faces) = (t.vertex_count(), t.face_count());
    let half_edges = t.half_edge_count();
    let face_point = |f: u32| vertices as u32 + f;
    let edge_point = |e: u32| (vertices + faces) as u32 + e;

    let mut origin = vec![0u32; 4 * half_edges];
    let mut edge = vec![0u32; 4 * half_edges];
    let mut twin = vec![NONE; 4 * half_edges];
    let rows = origin.par_chunks_exact_mut(4).zip(edge.par_chunks_exact_mut(4)).zip(twin.par_chunks_exact_mut(4));
    rows.enumerate().with_min_len(SHARE).for_each(|(h, ((origin, edge), twin))| {
        let h = HalfEdge(h as u32);
        let (next, prev) = (t.next(h), t.prev(h));
        let [a, b, c, d] = [A, B, C, D].map(|k| Child::of(t, h).corner(k));
        let (e_h, e_prev) = (t.edge(h), t.edge(prev));
        origin[a] = t.origin(h).0;
        origin[b] = edge_point(e_h.0);
        origin[c] = face_point(t.face(h).0);
        origin[d] = edge_point(e_prev.0);
        edge[a] = half(half_edges, e_h, !runs_forward(t, h));
        edge[b] = h.0;
        edge[c] = prev.0;
        edge[d] = half(half_edges, e_prev, runs_forward(t, prev));
        twin[a] = t.twin(h).map_or(NONE, |g| Child::of(t, t.next(g)).half_edge(D));
        twin[b] = Child::of(t, next).half_edge(C);
        twin[c] = Child::of(t, prev).half_edge(B);
        twin[d] = t.twin(prev).map_or(NONE, |g| Child::of(t, g).half_edge(A));
    });

    let inside = (0..half_edges as u32)
        .into_par_iter()
        .with_min_len(SHARE)
        .map(HalfEdge)
        .map(|h| ([face_point(t.face(h).0), edge_point(t.edge(h).0)], Child::of(t, h).half_edge(B)));
    let face_points = t.face_offset[..faces].iter().map(|&h| Child::of(t, HalfEdge(h)).half_edge(C));
    Split {
        sides: 4,
        origin,
        edge,
        twin,
        outwards: |t, h| Child::of(t, h).half_edge(A),
        inwards: |t, h| Child::of(t, h).half_edge(D),
        inside: inside.collect(),
        face_points: face_points.collect(),
        parent_face: (0..half_edges as u32).map(|h| t.face(HalfEdge(h)).0).collect(),
    }
    .finish(t)
}
