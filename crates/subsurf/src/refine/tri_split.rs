//! The triangle split: every triangle becomes four, in OpenSubdiv's order.
//!
//! ```text
//!            v2                    child 0: v0 E0 E2      child c has the old vertex at corner c
//!           /  \                   child 1: E0 v1 E1      child 3, the middle: E1 E2 E0
//!         / c=2  \
//!       E2 ────── E1               In child c, from half-edge h = c of the parent:
//!      /  \  3  /  \                 a: v_c → E_c        half of edge c
//!    / c=0  \ / c=1  \               b: E_c → E_{c-1}    inside, edge c of the face
//!  v0 ────── E0 ────── v1            d: E_{c-1} → v_c    half of edge c - 1
//! ```

use super::split::{SHARE, Split, half, runs_forward};
use crate::index::HalfEdge;
use crate::topology::{NONE, Topology};
use rayon::prelude::*;

/// Child half-edge `k` places after the one that starts at the old vertex, in the child at the origin of `h`.
fn at(h: HalfEdge, k: u32) -> u32 {
    let (face, corner) = (h.0 / 3, h.0 % 3);
    12 * face + 3 * corner + (corner + k) % 3
}

fn a(h: HalfEdge) -> u32 {
    at(h, 0)
}

fn b(h: HalfEdge) -> u32 {
    at(h, 1)
}

fn d(h: HalfEdge) -> u32 {
    at(h, 2)
}

/// The topology one level down; all faces of `t` are triangles.
pub(super) fn child(t: &Topology) -> Topology {
    let half_edges = t.half_edge_count();
    let edge_point = |h: HalfEdge| t.vertex_count() as u32 + t.edge(h).0;
    let mut origin = vec![0u32; 4 * half_edges];
    let mut edge = vec![0u32; 4 * half_edges];
    let mut twin = vec![NONE; 4 * half_edges];
    let rows = origin.par_chunks_exact_mut(12).zip(edge.par_chunks_exact_mut(12)).zip(twin.par_chunks_exact_mut(12));
    rows.enumerate().with_min_len(SHARE).for_each(|(f, ((origin, edge), twin))| {
        let base = 12 * f as u32;
        for c in 0..3u32 {
            let h = HalfEdge(3 * f as u32 + c);
            let prev = t.prev(h);
            let local = |child: u32| (child - base) as usize;
            origin[local(a(h))] = t.origin(h).0;
            origin[local(b(h))] = edge_point(h);
            origin[local(d(h))] = edge_point(prev);
            edge[local(a(h))] = half(half_edges, t.edge(h), !runs_forward(t, h));
            edge[local(b(h))] = h.0;
            edge[local(d(h))] = half(half_edges, t.edge(prev), runs_forward(t, prev));
            twin[local(a(h))] = t.twin(h).map_or(NONE, |g| d(t.next(g)));
            twin[local(d(h))] = t.twin(prev).map_or(NONE, a);
            // The middle triangle's side k = c + 1 faces child c.
            let middle = 9 + (c + 1) % 3;
            origin[middle as usize] = edge_point(prev);
            edge[middle as usize] = h.0;
            twin[local(b(h))] = base + middle;
            twin[middle as usize] = b(h);
        }
    });
    let inside = (0..half_edges as u32).into_par_iter().map(HalfEdge);
    Split {
        sides: 3,
        origin,
        edge,
        twin,
        outwards: |_, h| a(h),
        inwards: |_, h| d(h),
        inside: inside.map(|h| ([edge_point(h), edge_point(t.prev(h))], b(h))).collect(),
        face_points: Vec::new(),
        parent_face: (0..4 * t.face_count() as u32).map(|f| f / 4).collect(),
    }
    .finish(t)
}
