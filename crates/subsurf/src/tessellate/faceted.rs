//! Normals of bilinear tessellations. Patches meet at edges there, sub-faces of one polygon included, so that no two share
//! a normal: every patch has its own, one per point of its grid.

use super::facets::FacetArrays;
use crate::index::Face;
use crate::limit::Location;
use std::collections::BTreeMap;

/// Normals of facet corners, and where each is evaluated.
#[derive(Default)]
pub(super) struct PatchNormals {
    pub sources: Vec<Location>,
    /// Normal of every facet corner.
    pub corners: Vec<u32>,
}

impl PatchNormals {
    /// For facets that have places, patch by patch.
    pub fn of(facets: &FacetArrays) -> Self {
        let mut out = Self::default();
        // Points of the patch at hand by the bits of their parameters.
        let mut known: BTreeMap<[u64; 2], u32> = BTreeMap::new();
        let mut patch = None;
        for (ends, &(face, subface)) in facets.face_offsets.windows(2).zip(&facets.places.facet) {
            if patch.replace((face, subface)) != Some((face, subface)) {
                known.clear();
            }
            for &[u, v] in &facets.places.corner_uv[ends[0] as usize..ends[1] as usize] {
                let next = out.sources.len() as u32;
                let normal = *known.entry([u.to_bits(), v.to_bits()]).or_insert(next);
                if normal == next {
                    out.sources.push(Location { face: Face(face), subface, u, v });
                }
                out.corners.push(normal);
            }
        }
        out
    }
}
