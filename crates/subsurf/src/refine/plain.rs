//! Where refinement is that of a regular grid: quads whose four corners are smooth and surrounded by four quads each.
//! Their sixteen control points are found by a few steps between half-edges, without a walk round the corners.

use crate::index::{Face, HalfEdge, Vertex};
use crate::topology::Topology;

/// True for an interior vertex of four quads with nothing sharp.
pub(super) fn is_plain(t: &Topology, v: Vertex) -> bool {
    let Some(start) = t.outgoing(v) else { return false };
    if t.vertex_non_manifold[v.index()] || t.vertex_sharpness(v) > 0.0 || !t.sharp_edges(v).is_empty() {
        return false;
    }
    let mut h = start;
    for step in 0..4 {
        match t.turn_left(h) {
            // Fans of one or two faces close early.
            Some(left) if t.sides(t.face(h)) == 4 && (step == 3 || left != start) => h = left,
            _ => return false,
        }
    }
    h == start && t.foreign_sharpness(v).is_empty()
}

/// The control points of a quad with four plain corners, row by row. A mesh may be so small that some are the same.
///
/// ```text
///   12 ── 13 ── 14 ── 15
///    |     |     |     |
///    8 ─── 9 ── 10 ── 11        9 and 10 are the corners 3 and 2 of the face,
///    |     |face |     |        5 and 6 its corners 0 and 1
///    4 ─── 5 ─── 6 ─── 7
///    |     |     |     |
///    0 ─── 1 ─── 2 ─── 3
/// ```
pub(super) fn plain_ring(t: &Topology, face: Face) -> [u32; 16] {
    /// Where a side's neighbour puts its two points, first that next to corner `side`, and the corner's diagonal.
    const PLACES: [[usize; 3]; 4] = [[1, 2, 0], [7, 11, 3], [14, 13, 15], [8, 4, 12]];
    let first = t.first(face);
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| t.origin[first as usize + i]);
    let mut ring = [0; 16];
    [ring[5], ring[6], ring[10], ring[9]] = [a, b, c, d];
    let across = |h: u32| HalfEdge(t.twin[h as usize]);
    for (side, [near, far, diagonal]) in PLACES.into_iter().enumerate() {
        // From corner `side` away from the face, then to the other corner.
        let away = t.next(across(first + side as u32));
        let along = t.next(away);
        ring[near] = t.origin(along).0;
        ring[far] = t.origin(t.next(along)).0;
        ring[diagonal] = t.origin(t.prev(across(away.0))).0;
    }
    ring
}
