//! A frame cut into chunks of faces, each with the parts of the result that it fills, whatever the number of threads.

use super::layout::Layout;
use super::output::Output;
use crate::index::{Face, HalfEdge};
use crate::topology::Topology;
use std::ops::Range;

/// A chunk of faces, and what they fill: at vertices, inside edges and inside faces; and the further normals along creases that
/// they see without owning them.
pub(super) struct Task<'o, T, const N: usize> {
    pub faces: Range<u32>,
    pub vertices: Output<'o, T, N>,
    pub edges: Output<'o, T, N>,
    pub inside: Output<'o, T, N>,
    /// The half-edges of these creases.
    seen: &'o [HalfEdge],
    pub further: &'o mut [[T; 3]],
}

/// Cuts points and normals at vertices, the `rest` of them inside edges and faces, and further normals along half-edges, all of
/// which come in the order of faces.
pub(super) fn tasks<'o, T: Copy, const N: usize>(
    layout: &Layout<'_>,
    mut vertices: Output<'o, T, N>,
    rest: Output<'o, T, N>,
    (mut seen, mut further): (&'o [HalfEdge], &'o mut [[T; 3]]),
) -> Vec<Task<'o, T, N>> {
    let t = layout.table.topology();
    let (mut edges, mut inside) = rest.split(layout.edge_points());
    let along_edge = further.len().checked_div(seen.len()).unwrap_or(0);
    let mut tasks = Vec::new();
    for faces in layout.face_chunks() {
        let (own_vertices, other_vertices) = vertices.split(layout.vertex_range(&faces).len());
        let (own_edges, other_edges) = edges.split(layout.edge_range(&faces).len());
        let (own_inside, other_inside) = inside.split(layout.face_range(&faces).len());
        let (own_seen, other_seen) = seen.split_at(seen.partition_point(|&h| t.face(h).0 < faces.end));
        let (own_further, other_further) = further.split_at_mut(own_seen.len() * along_edge);
        (vertices, edges, inside) = (other_vertices, other_edges, other_inside);
        (seen, further) = (other_seen, other_further);
        tasks.push(Task {
            faces,
            vertices: own_vertices,
            edges: own_edges,
            inside: own_inside,
            seen: own_seen,
            further: own_further,
        });
    }
    tasks
}

impl<'o, T: Copy, const N: usize> Task<'o, T, N> {
    /// The half-edges along which a face gives further normals. Faces come in order.
    #[inline]
    pub fn seen_by(&mut self, face: Face, t: &Topology) -> &'o [HalfEdge] {
        let count = self.seen.iter().take_while(|&&h| t.face(h) == face).count();
        let (now, later) = self.seen.split_at(count);
        self.seen = later;
        now
    }

    /// Fills the first further normals, which are left out from then on.
    pub fn put_further(&mut self, normals: &[[T; 3]]) {
        self.further[..normals.len()].copy_from_slice(normals);
        self.skip_further(normals.len());
    }

    pub fn skip_further(&mut self, count: usize) {
        self.further = &mut std::mem::take(&mut self.further)[count..];
    }
}
