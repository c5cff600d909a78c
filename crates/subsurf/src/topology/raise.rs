//! By how much the finite sharpness round a face may be lowered together without any one-step rule noticing.
//!
//! The rules of one refinement step look at a finite sharpness `s` only as far as it is at most 1: a larger one means
//! "sharp now and sharp after the step", whatever its value, and `s - 1` one level down. So where the lowest finite
//! sharpness round a face is above 2, all of them may be lowered by a whole number, the *raise*, that leaves the lowest
//! in (1, 2]; what lies round the face is then a *base* with a raise, and base + raise refines like the base does, to
//! base + (raise - 1). Subtracting whole numbers from numbers below 10 is exact.
//!
//! Under Chaikin's rule nothing is lowered: its averages move the fractions at every level.

use super::Topology;
use crate::index::{Edge, Face, Vertex};
use crate::sharpness::is_semi_sharp;
use crate::tags::Creasing;

impl Topology {
    /// The lowest finite sharpness at the corners of a face, of edges, vertices and whatever else the rules see there.
    fn lowest_semi_sharpness(&self, face: Face) -> Option<f64> {
        let at = |&v: &u32| {
            let v = Vertex(v);
            let edges = self.sharp_edges(v).iter().map(|&e| self.edge_sharpness(Edge(e)));
            let others = self.foreign_sharpness(v).iter().chain(self.across_seam(v)).copied();
            std::iter::once(self.vertex_sharpness(v)).chain(edges).chain(others)
        };
        self.face_vertices(face).iter().flat_map(at).filter(|&s| is_semi_sharp(s)).min_by(f64::total_cmp)
    }

    /// The whole number that lowers the lowest finite sharpness at the corners of a face into (0, 1]; 0 where there is
    /// none. A raise is this less 1, and not below 0.
    pub(crate) fn excess(&self, face: Face) -> u8 {
        if self.rules.creasing == Creasing::Chaikin {
            return 0;
        }
        self.lowest_semi_sharpness(face).map_or(0, |s| s.ceil() as u8 - 1)
    }

    /// True where finite sharpness has a say at the corners of a face.
    pub(crate) fn is_semi_sharp(&self, face: Face) -> bool {
        self.lowest_semi_sharpness(face).is_some()
    }
}

/// Sharpness `s` with all that is finite lowered by `raise`.
pub(crate) fn lowered(s: f64, raise: i8) -> f64 {
    if is_semi_sharp(s) { (s - f64::from(raise)).max(0.0) } else { s }
}
