//! By how much the finite sharpness round a face may be lowered together without any one-step rule noticing.
//!
//! The rules of one refinement step look at a finite sharpness `s` only as far as it is at most 1: a larger one means
//! "sharp now and sharp after the step", whatever its value, and `s - 1` one level down. So where the lowest finite
//! sharpness round a face is above 2, all of them may be lowered by a whole number, the *raise*, that leaves the lowest
//! in (1, 2]; what lies round the face is then a *base* with a raise, and base + raise refines like the base does, to
//! base + (raise - 1). Subtracting whole numbers from numbers below 10 is exact.
//!
//! Under Chaikin's rule nothing is lowered: its averages move the fractions at every level.

use super::Tables;
use crate::index::Face;
use crate::sharpness::is_semi_sharp;
use crate::tags::Creasing;

/// The lowest finite sharpness at the corners of a face, of edges, vertices and whatever else the rules see there.
fn lowest_semi_sharpness(t: &impl Tables, face: Face) -> Option<f64> {
    let mut lowest = f64::INFINITY;
    let mut note = |s: f64| lowest = if is_semi_sharp(s) { lowest.min(s) } else { lowest };
    for v in (0..t.sides(face)).map(|c| t.origin(t.half_edge(face, c))) {
        note(t.vertex_sharpness(v));
        t.sharp_edges(v).for_each(|e| note(t.edge_sharpness(e)));
        [t.foreign_sharpness(v), t.across_seam(v)].iter().for_each(|list| list.iter().for_each(|&s| note(s)));
    }
    (lowest < f64::INFINITY).then_some(lowest)
}

/// The lowest finite sharpness at the corners of a face, if there is one that may be lowered.
#[derive(Clone, Copy, Default, PartialEq, Debug)]
pub(crate) struct Lowest(Option<f64>);

impl Lowest {
    pub fn of(t: &impl Tables, face: Face) -> Self {
        let is_movable = t.rules().creasing == Creasing::Uniform;
        Self(if is_movable { lowest_semi_sharpness(t, face) } else { None })
    }

    /// The lowest of these that is finite.
    pub fn among(sharpness: impl Iterator<Item = f64>) -> Self {
        Self(sharpness.filter(|&s| is_semi_sharp(s)).reduce(f64::min))
    }

    /// The whole number that lowers it into (0, 1]; 0 where there is none.
    pub fn excess(self) -> u8 {
        self.0.map_or(0, |s| s.ceil() as u8 - 1)
    }

    /// By how much all finite sharpness can be lowered without any rule noticing.
    pub fn raise(self) -> u8 {
        self.excess().saturating_sub(1)
    }

    /// True where the next step takes the lowest sharpness to 0, or part of it.
    pub fn ends(self) -> bool {
        self.0.is_some_and(|s| s <= 1.0)
    }
}

/// Sharpness `s` with all that is finite lowered by `raise`.
pub(crate) fn lowered(s: f64, raise: i8) -> f64 {
    if is_semi_sharp(s) { (s - f64::from(raise)).max(0.0) } else { s }
}
