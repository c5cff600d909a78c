//! A scheme is a topological split plus masks. This is the only place that tells schemes apart.

pub(crate) mod catmull_clark;
pub(crate) mod loop_subdivision;

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
    /// Quartic box splines generalised to any triangle mesh (Loop 1987). Faces that are no triangles are refused.
    Loop,
    /// Every corner becomes a quad, nothing is smoothed. Sharpness has no effect, and a boundary makes no holes.
    Bilinear,
}

/// How faces are split.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) enum SplitKind {
    /// Every corner becomes a quad.
    Quads,
    /// Every triangle becomes four.
    Triangles,
}

impl Scheme {
    pub(crate) fn split(self) -> SplitKind {
        match self {
            Scheme::CatmullClark | Scheme::Bilinear => SplitKind::Quads,
            Scheme::Loop => SplitKind::Triangles,
        }
    }

    /// Corners of the faces that are one patch each; others are sub-divided into as many patches as they have corners.
    pub(crate) fn patch_sides(self) -> usize {
        match self.split() {
            SplitKind::Quads => 4,
            SplitKind::Triangles => 3,
        }
    }

    /// Adds `weight` times the mask of a smooth edge.
    pub(crate) fn smooth_edge_mask(self, t: &Topology, e: Edge, weight: f64, mask: &mut Mask) {
        match self.split() {
            SplitKind::Quads => catmull_clark::smooth_edge_mask(t, e, weight, mask),
            SplitKind::Triangles => loop_subdivision::smooth_edge_mask(t, e, weight, mask),
        }
    }

    /// Adds `weight` times the mask of a smooth interior vertex.
    pub(crate) fn smooth_vertex_mask(self, t: &Topology, v: Vertex, weight: f64, mask: &mut Mask) {
        match self.split() {
            SplitKind::Quads => catmull_clark::smooth_vertex_mask(t, v, weight, mask),
            SplitKind::Triangles => loop_subdivision::smooth_vertex_mask(t, v, weight, mask),
        }
    }
}
