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

use crate::index::{Edge, HalfEdge, Vertex};
use crate::sharpness::{decay, edge_half, foreign_half};
use crate::topology::{EdgeFlags, NONE, Topology};
use rayon::prelude::*;
use std::collections::BTreeMap;

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
    let (vertices, faces, edges) = (t.vertex_count(), t.face_count(), t.edge_count());
    let half_edges = t.half_edge_count();
    let face_point = |f: u32| vertices as u32 + f;
    let edge_point = |e: u32| (vertices + faces) as u32 + e;
    let half = |e: Edge, second: bool| (half_edges + 2 * e.index() + usize::from(second)) as u32;

    let mut origin = vec![0u32; 4 * half_edges];
    let mut edge = vec![0u32; 4 * half_edges];
    let mut twin = vec![NONE; 4 * half_edges];
    let rows = origin.par_chunks_exact_mut(4).zip(edge.par_chunks_exact_mut(4)).zip(twin.par_chunks_exact_mut(4));
    rows.enumerate().for_each(|(h, ((origin, edge), twin))| {
        let h = HalfEdge(h as u32);
        let (next, prev) = (t.next(h), t.prev(h));
        let [a, b, c, d] = [A, B, C, D].map(|k| Child::of(t, h).corner(k));
        let (e_h, e_prev) = (t.edge(h), t.edge(prev));
        origin[a] = t.origin(h).0;
        origin[b] = edge_point(e_h.0);
        origin[c] = face_point(t.face(h).0);
        origin[d] = edge_point(e_prev.0);
        edge[a] = half(e_h, !runs_forward(t, h));
        edge[b] = h.0;
        edge[c] = prev.0;
        edge[d] = half(e_prev, runs_forward(t, prev));
        twin[a] = t.twin(h).map_or(NONE, |g| Child::of(t, t.next(g)).half_edge(D));
        twin[b] = Child::of(t, next).half_edge(C);
        twin[c] = Child::of(t, prev).half_edge(B);
        twin[d] = t.twin(prev).map_or(NONE, |g| Child::of(t, g).half_edge(A));
    });

    let inside = (0..half_edges as u32).into_par_iter().map(|h| {
        let h = HalfEdge(h);
        [face_point(t.face(h).0), edge_point(t.edge(h).0)]
    });
    let halves = (0..2 * edges).into_par_iter().map(|k| {
        let e = Edge((k / 2) as u32);
        [edge_point(e.0), t.edge_vertices(e)[k % 2].0]
    });
    let edge_vertices: Vec<[u32; 2]> = inside.chain(halves).collect();
    let mut edge_flags = vec![EdgeFlags::default(); half_edges];
    edge_flags.extend(t.edge_flags.iter().flat_map(|&f| [f, f]));
    let mut edge_sharpness = vec![0.0; half_edges];
    edge_sharpness.par_extend((0..2 * edges).into_par_iter().map(|k| {
        let e = Edge((k / 2) as u32);
        edge_half(t, e, t.edge_vertices(e)[k % 2])
    }));

    let child_vertices = vertices + faces + edges;
    let mut vertex_sharpness: Vec<f64> = t.vertex_sharpness.iter().map(|&s| decay(s)).collect();
    vertex_sharpness.resize(child_vertices, 0.0);
    let mut vertex_non_manifold = t.vertex_non_manifold.clone();
    vertex_non_manifold.resize(vertices + faces, false);
    vertex_non_manifold.extend(t.edge_flags.iter().map(|f| f.non_manifold));

    let mut child = Topology {
        vertex_count: child_vertices,
        face_offset: (0..=half_edges as u32).map(|f| 4 * f).collect(),
        origin,
        face: (0..4 * half_edges as u32).map(|h| h / 4).collect(),
        edge,
        twin,
        edge_vertices,
        edge_half_edge: first_half_edges(t),
        edge_flags,
        edge_sharpness,
        vertex_half_edge: leading_half_edges(t),
        vertex_non_manifold,
        vertex_sharpness,
        sharp_offset: Vec::new(),
        sharp_edges: Vec::new(),
        hole: t.face.iter().map(|&f| t.hole[f as usize]).collect(),
        rules: t.rules,
        foreign_sharpness: t.foreign_sharpness.keys().map(|&v| (v, foreign_half(t, Vertex(v)))).collect(),
        // A new vertex on an edge has no sharp edges but the edge's halves, and the child holds both.
        far_half: BTreeMap::new(),
    };
    child.index_sharp_edges();
    child
}

/// True where `h` runs from its edge's first end to the second.
fn runs_forward(t: &Topology, h: HalfEdge) -> bool {
    t.origin(h) == t.edge_vertices(t.edge(h))[0]
}

/// One half-edge of every child edge.
fn first_half_edges(t: &Topology) -> Vec<u32> {
    let mut first: Vec<u32> = (0..t.half_edge_count() as u32).map(|h| Child::of(t, HalfEdge(h)).half_edge(B)).collect();
    first.extend(t.edge_half_edge.iter().flat_map(|&h| {
        let h = HalfEdge(h);
        let halves = [Child::of(t, h).half_edge(A), Child::of(t, t.next(h)).half_edge(D)];
        if runs_forward(t, h) { halves } else { [halves[1], halves[0]] }
    }));
    first
}

/// One outgoing half-edge per child vertex; where the parent's fan was open, so is the child's, at the same side.
fn leading_half_edges(t: &Topology) -> Vec<u32> {
    let vertices =
        (0..t.vertex_count() as u32).map(|v| t.outgoing(Vertex(v)).map_or(NONE, |h| Child::of(t, h).half_edge(A)));
    let faces = t.face_offset[..t.face_count()].iter().map(|&h| Child::of(t, HalfEdge(h)).half_edge(C));
    let edges = t.edge_half_edge.iter().map(|&h| Child::of(t, t.next(HalfEdge(h))).half_edge(D));
    vertices.chain(faces).chain(edges).collect()
}
