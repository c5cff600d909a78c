//! What feature-adaptive patches cost: points to refine each frame, the masks that refine them, and the patches' own
//! tables.

use super::features::Around;
use super::sparse_level::{Choice, SparseLevel};
use super::{AdaptiveKind, AdaptiveRefinement};
use crate::scheme::{Scheme, SplitKind};

/// Counts and memory of the tables that a renderer keeps: a patch has the 32-bit indices of its control points and
/// eight bytes of parameters, with single-crease patches four more; a refined point has a mask over the points of the level
/// before, eight bytes a weight with its index and four bytes a point. The weights of end caps are left out.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub struct AdaptiveSize {
    /// Patches of all kinds.
    pub patches: usize,
    /// Patches that approximate the surface: end caps, and all where sharpness was cut short.
    pub approximate: usize,
    /// Patches where sharpness was cut short.
    pub cut_short: usize,
    /// Points that are refined each frame.
    pub refined_points: usize,
    /// Control points that end caps add to them: 20 each, 18 under Loop (Gregory patches, none shared).
    pub end_cap_points: usize,
    /// Bytes of the patches' indices and parameters.
    pub patch_bytes: usize,
    /// Bytes of masks.
    pub mask_bytes: usize,
    /// Bytes of all points that patches refer to, three 32-bit numbers each, those of the control mesh included.
    pub point_bytes: usize,
}

impl AdaptiveRefinement {
    /// Counts and memory.
    pub fn size(&self) -> AdaptiveSize {
        let (regular, end_cap) = match self.scheme {
            Scheme::CatmullClark => (16, 20),
            Scheme::Loop => (12, 18),
            Scheme::Bilinear => (4, 4),
        };
        let mut size = AdaptiveSize { patches: self.patches.len(), ..AdaptiveSize::default() };
        let mut end_caps = 0;
        for placed in &self.patches {
            let is_cap = placed.shape.kind == AdaptiveKind::EndCap;
            end_caps += usize::from(is_cap);
            size.cut_short += usize::from(placed.shape.cut_short);
            size.approximate += usize::from(is_cap || placed.shape.cut_short);
        }
        let per_patch = if self.options.single_crease { 12 } else { 8 };
        size.refined_points = self.vertices[1..].iter().sum();
        size.end_cap_points = end_caps * end_cap;
        size.patch_bytes = 4 * (regular * (size.patches - end_caps) + end_cap * end_caps) + per_patch * size.patches;
        size.mask_bytes = 8 * self.mask_weights.iter().sum::<usize>() + 4 * size.refined_points;
        size.point_bytes = 12 * (self.vertices[0] + size.refined_points + size.end_cap_points);
        size
    }
}

/// Number of weights in the masks of the next level's points.
pub(super) fn mask_weights(level: &SparseLevel, choice: &Choice, around: &[Around]) -> usize {
    let quads = level.scheme().split() == SplitKind::Quads;
    let linear = level.scheme() == Scheme::Bilinear;
    // Vertices that faces add to the smooth masks of their vertices and edges: all but the two at an edge.
    let mut beside_vertex = vec![0u32; level.vertex_count()];
    let mut beside_edge = vec![0u32; level.edge_ends.len()];
    let mut total = 0;
    for f in 0..level.face_count() {
        let corners = level.corners(f);
        let sides = corners.len();
        let touched = corners.clone().any(|c| choice.vertex[level.vertex[c] as usize]);
        total += if quads && touched { sides } else { 0 };
        for c in corners {
            beside_vertex[level.vertex[c] as usize] += sides as u32 - 2;
            beside_edge[level.edge[c] as usize] += sides as u32 - 2;
        }
    }
    for v in (0..level.vertex_count()).filter(|&v| choice.vertex[v]) {
        let pinned = level.vertex_sharpness[v] > 0.0 || linear;
        total += match around[v].sharp() {
            _ if pinned => 1,
            0 | 1 => 1 + beside_vertex[v] as usize,
            2 => 3,
            _ => 1,
        };
    }
    for (e, ends) in level.edge_ends.iter().enumerate() {
        if ends.iter().any(|&v| choice.vertex[v as usize]) {
            let sharp = level.edge_sharpness[e] >= 1.0 || linear;
            total += if sharp { 2 } else { 2 + beside_edge[e] as usize };
        }
    }
    total
}
