//! The smooth rules of Catmull, Clark 1978.

use crate::index::{Edge, HalfEdge, Vertex};
use crate::mask::Mask;
use crate::tags::Triangles;
use crate::topology::Topology;

/// Weight of each face centroid where triangles are smoothed, per side that is a triangle (OpenSubdiv's fit).
const SMOOTH_TRIANGLE: f64 = 0.470;

/// A quarter each of the two ends and of the two face centroids; with smoothed triangles `f = (t0 + t1) / 2` on each
/// centroid, `t = 0.47` for a triangle and `0.25` for any other face, and the rest on the ends.
pub(super) fn smooth_edge_mask(t: &Topology, e: Edge, weight: f64, mask: &mut Mask) {
    let h = HalfEdge(t.edge_half_edge[e.index()]);
    let twin = t.twin(h).expect("a smooth edge has two faces");
    let faces = [t.face(h), t.face(twin)];
    let mut centroid = 0.25;
    if t.rules().triangles == Triangles::Smooth && faces.iter().any(|&f| t.sides(f) == 3) {
        centroid = 0.5 * faces.map(|f| if t.sides(f) == 3 { SMOOTH_TRIANGLE } else { 0.25 }).iter().sum::<f64>();
    }
    for v in t.edge_vertices(e) {
        mask.vertex(v, weight * (0.5 - centroid));
    }
    for f in faces {
        mask.face(f, weight * centroid);
    }
}

/// `(n-2)/n v + 1/n² Σ edge ends + 1/n² Σ face centroids`, `n` the valence.
pub(super) fn smooth_vertex_mask(t: &Topology, v: Vertex, weight: f64, mask: &mut Mask) {
    let start = t.outgoing(v).expect("a smooth vertex has faces");
    let from = (mask.vertices.len(), mask.faces.len());
    let mut h = start;
    loop {
        mask.along(t.edge(h), t.origin(t.next(h)), 0.0);
        mask.face(t.face(h), 0.0);
        h = t.turn_left(h).expect("a smooth vertex lies inside the mesh");
        if h == start {
            break;
        }
    }
    let n = mask.faces.len() - from.1;
    let each = smooth_neighbour(n, weight);
    mask.vertices[from.0..].iter_mut().for_each(|term| term.1 = each);
    mask.faces[from.1..].iter_mut().for_each(|term| term.1 = each);
    let n = n as f64;
    mask.vertex(v, weight * (n - 2.0) / n);
}

/// Of a smooth vertex of valence `n`, the weight of each edge end and of each face centroid round it, out of `weight`.
#[inline(always)]
pub(crate) fn smooth_neighbour(n: usize, weight: f64) -> f64 {
    weight / (n * n) as f64
}
