//! A scheme is a topological split plus masks. This is the only place that tells schemes apart.

mod catmull_clark;

use crate::index::{Edge, Vertex};
use crate::mask::Mask;
use crate::topology::Topology;

/// Which subdivision surface a control mesh describes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[non_exhaustive]
pub enum Scheme {
    /// Bicubic B-splines generalised to any mesh (Catmull, Clark 1978).
    #[default]
    CatmullClark,
    /// Every corner becomes a quad, nothing is smoothed. Sharpness has no effect, and a boundary makes no holes.
    Bilinear,
}

impl Scheme {
    /// True where all rules are the linear ones.
    pub(crate) fn ignores_sharpness(self) -> bool {
        self == Scheme::Bilinear
    }

    /// Adds `weight` times the mask of a smooth edge.
    pub(crate) fn smooth_edge_mask(self, t: &Topology, e: Edge, weight: f64, mask: &mut Mask) {
        catmull_clark::smooth_edge_mask(t, e, weight, mask);
    }

    /// Adds `weight` times the mask of a smooth interior vertex.
    pub(crate) fn smooth_vertex_mask(self, t: &Topology, v: Vertex, weight: f64, mask: &mut Mask) {
        catmull_clark::smooth_vertex_mask(t, v, weight, mask);
    }
}
