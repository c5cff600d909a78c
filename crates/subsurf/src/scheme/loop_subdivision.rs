//! The smooth rules of Loop 1987.

use crate::index::{Edge, HalfEdge, Vertex};
use crate::mask::Mask;
use crate::topology::Topology;
use std::f64::consts::PI;

/// Weight of each neighbour of a smooth vertex of valence `n`: `β = (5/8 - (3/8 + cos(2π/n)/4)²) / n`, Loop's original.
pub(crate) fn beta(n: u32) -> f64 {
    let n = f64::from(n);
    let c = 0.375 + 0.25 * (2.0 * PI / n).cos();
    (0.625 - c * c) / n
}

/// 3/8 of each end and 1/8 of the two opposite vertices.
pub(super) fn smooth_edge_mask(t: &Topology, e: Edge, weight: f64, mask: &mut Mask) {
    let h = HalfEdge(t.edge_half_edge[e.index()]);
    let twin = t.twin(h).expect("a smooth edge has two faces");
    for v in t.edge_vertices(e) {
        mask.vertex(v, 0.375 * weight);
    }
    for side in [h, twin] {
        mask.vertex(t.origin(t.prev(side)), 0.125 * weight);
    }
}

/// `β` of each neighbour and the rest of the vertex itself.
pub(super) fn smooth_vertex_mask(t: &Topology, v: Vertex, weight: f64, mask: &mut Mask) {
    let start = t.outgoing(v).expect("a smooth vertex has faces");
    let from = mask.vertices.len();
    let mut h = start;
    loop {
        mask.vertex(t.origin(t.next(h)), 0.0);
        h = t.turn_left(h).expect("a smooth vertex lies inside the mesh");
        if h == start {
            break;
        }
    }
    let n = mask.vertices.len() - from;
    // At valence 6 the cosine is 1/2 exactly, and so are the box spline's weights.
    let each = if n == 6 { 1.0 / 16.0 } else { beta(n as u32) };
    mask.vertices[from..].iter_mut().for_each(|term| term.1 = weight * each);
    mask.vertex(v, weight * (1.0 - n as f64 * each));
}
