//! The limit surface, exactly: at any location, for any attribute.

mod alone;
mod at_pole;
mod batch;
mod box_spline;
mod bspline;
mod by_patch;
mod corner;
mod deflated;
mod eigen;
mod fan_class;
mod fans;
mod gather;
mod jet;
mod lanes;
mod level;
mod linear_boundary;
mod local_step;
mod patch_table;
mod places;
pub(crate) mod plan;
mod plan_key;
mod pole;
mod pole_memory;
mod powers;

mod rows;
mod sampler;
mod single_crease;
mod smooth_ring;
mod special;
mod spectrum;
mod tangent;
mod triangle_crease;
mod triangle_points;
mod turn;

pub use batch::{Exceptional, LimitPatch};
pub(crate) use bspline::cubic;
pub(crate) use jet::unit_normal;
pub use jet::{Curvature, Derivatives, Jet, Location};
pub(crate) use local_step::child_vertex;
pub(crate) use patch_table::Known;
pub use patch_table::{EvaluationSize, PatchTable, TableSize};
pub(crate) use places::Places;
pub use plan::PatchKind;
pub(crate) use plan_key::KeyHasher;
pub use pole_memory::MOST_POLE_BYTES;
pub(crate) use pole_memory::check_edit;
pub(crate) use sampler::Sampler;
pub(crate) use special::AtVertex;
pub use special::Method;
pub use spectrum::Spectrum;

use crate::compiled::{as_rows, row_of_three};
use crate::real::{Real, add_scaled};
pub(crate) use at_pole::LastPole;
use plan::Plan;
pub(crate) use plan::RingWeights;

/// What becomes of derivatives at a special vertex, vectors that span the tangent plane, and whether that is the only one.
type State<const N: usize> = (Derivatives, Option<[[f64; N]; 2]>, bool);

/// A patch table with control points: cheap to make, once per animation frame.
///
/// Sums are formed in `f64` relative to one control point of the face, so that a constant has derivatives of exactly zero
/// and distance from the origin costs no digits.
#[derive(Clone, Copy)]
pub struct LimitSurface<'a, T, const N: usize> {
    table: &'a PatchTable,
    points: &'a [[T; N]],
}

impl<'a, T: Real, const N: usize> LimitSurface<'a, T, N> {
    pub(crate) fn new(table: &'a PatchTable, points: &'a [[T; N]]) -> Self {
        assert_eq!(points.len(), table.topology().vertex_count(), "one control point per vertex of the mesh");
        Self { table, points }
    }

    /// The table behind the surface.
    pub fn table(&self) -> &'a PatchTable {
        self.table
    }

    /// The control points.
    pub fn points(&self) -> &'a [[T; N]] {
        self.points
    }

    /// Position and first derivatives; none in holes.
    ///
    /// # Panics
    /// If the location names no sub-face of the mesh, or its parameters lie outside the face.
    pub fn eval(&self, at: Location) -> Option<Jet<N>> {
        self.jet_alone(at, 3)
    }

    /// Position, first and second derivatives; none in holes.
    ///
    /// # Panics
    /// As [`eval`](Self::eval).
    pub fn eval_second(&self, at: Location) -> Option<Jet<N>> {
        self.jet_alone(at, 6)
    }

    /// The point of the limit surface; none in holes.
    ///
    /// # Panics
    /// As [`eval`](Self::eval).
    pub fn position(&self, at: Location) -> Option<[f64; N]> {
        if const { N == 3 } {
            return T::compiled_position(&self.of_threes(), at).map(row_of_three);
        }
        self.position_here(at)
    }

    fn jet_alone(&self, at: Location, count: usize) -> Option<Jet<N>> {
        if const { N == 3 } {
            return T::compiled_jet(&self.of_threes(), at, count).map(|jet| jet.map(row_of_three));
        }
        self.jet_here(at, count)
    }

    /// The same surface, if its points have three numbers.
    pub(crate) fn of_threes(&self) -> LimitSurface<'a, T, 3> {
        LimitSurface { table: self.table, points: as_rows(self.points) }
    }

    /// The first `count` vectors of the jet, 3 or 6, compiled where it is called.
    pub(crate) fn jet_here(&self, at: Location, count: usize) -> Option<Jet<N>> {
        self.patch_jet(self.table.checked_patch(at), [at.u, at.v], count, &mut LastPole::default())
    }

    /// The position, compiled where it is called.
    pub(crate) fn position_here(&self, at: Location) -> Option<[f64; N]> {
        self.position_after(at, &mut LastPole::default())
    }

    /// [`eval`](Self::eval), with what the location before left.
    pub(crate) fn eval_after(&self, at: Location, last: &mut LastPole) -> Option<Jet<N>> {
        self.patch_jet(self.table.checked_patch(at), [at.u, at.v], 3, last)
    }

    /// [`position`](Self::position), with what the location before left.
    pub(crate) fn position_after(&self, at: Location, last: &mut LastPole) -> Option<[f64; N]> {
        let patch = self.table.checked_patch(at);
        let plan = self.table.plan(self.table.patch_plan(patch)?);
        if let Some(spot) = plan.spot(at.u, at.v, self.table.turn(patch)) {
            let [position] = self.at_spot(patch, plan, &spot, [at.u, at.v]);
            return Some(position);
        }
        Some(self.rows(patch, plan, [at.u, at.v], 1, last).0[0])
    }

    /// The jet at parameters of a patch; second derivatives if `count` is 6.
    fn patch_jet(&self, patch: usize, [u, v]: [f64; 2], count: usize, last: &mut LastPole) -> Option<Jet<N>> {
        let plan = self.table.plan(self.table.patch_plan(patch)?);
        if let Some(spot) = plan.spot(u, v, self.table.turn(patch)) {
            return Some(if count > 3 {
                let [position, du, dv, uu, uv, vv] = self.at_spot(patch, plan, &spot, [u, v]);
                Jet::regular([position, du, dv], Some([uu, uv, vv]))
            } else {
                Jet::regular(self.at_spot(patch, plan, &spot, [u, v]), None)
            });
        }
        let ([position, du, dv, uu, uv, vv], at_vertex) = self.rows(patch, plan, [u, v], count, last);
        let second = (count > 3 && at_vertex.is_none()).then_some([uu, uv, vv]);
        let (derivatives, plane, unique_plane) = at_vertex.unwrap_or((Derivatives::Finite, Some([du, dv]), true));
        Some(Jet { position, du, dv, second, derivatives, plane, unique_plane })
    }

    /// The first `count` rows of the jet where no sub-patch covers the place, zeros for others; and at special vertices what
    /// becomes of derivatives, the tangent plane, and whether it is the only one.
    fn rows(
        &self,
        patch: usize,
        plan: Plan<'_>,
        [u, v]: [f64; 2],
        count: usize,
        last: &mut LastPole,
    ) -> ([[f64; N]; 6], Option<State<N>>) {
        if plan.is_wide()
            && let Some(values) = self.at_pole(patch, plan, [u, v], count, last)
        {
            let row = |values: &Vec<f64>| values.first_chunk().copied().unwrap_or([0.0; N]);
            let state =
                |at: &AtVertex| (at.derivatives, at.plane.as_ref().map(|[a, b]| [row(a), row(b)]), at.unique_normal);
            return (values.rows.each_ref().map(row), values.at_vertex.as_ref().map(state));
        }
        let weights = plan.weights(u, v, self.table.turn(patch), count);
        let row = |k: usize| if k < count { self.apply(patch, &weights.rows[k], k == 0) } else { [0.0; N] };
        let state = |at: &AtVertex| {
            let plane = at.plane.as_ref().map(|p| [0, 1].map(|k| self.apply(patch, &p[k], false)));
            (at.derivatives, plane, at.unique_normal)
        };
        (std::array::from_fn(row), weights.at_vertex.as_ref().map(state))
    }

    /// The weighted sum over a patch's ring. Weights sum to one for positions, to zero for derivatives.
    pub(crate) fn apply(&self, patch: usize, weights: &[f64], is_position: bool) -> [f64; N] {
        let ring = self.table.ring(patch);
        let base = self.points[ring[0] as usize].map(T::to_f64);
        let mut sum = [0.0; N];
        // Far from a vertex of many faces few points of the ring have weights.
        for (&v, &w) in ring.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
            let p = self.points[v as usize];
            for i in 0..N {
                sum[i] += w * (p[i].to_f64() - base[i]);
            }
        }
        if is_position {
            add_scaled(&mut sum, 1.0, &base);
        }
        sum
    }

    /// A patch's control points relative to the first of them, which is returned.
    pub(crate) fn gather(&self, patch: usize, out: &mut Vec<[f64; N]>) -> [f64; N] {
        let ring = self.table.ring(patch);
        let base = self.points[ring[0] as usize].map(T::to_f64);
        out.clear();
        out.extend(ring.iter().map(|&v| {
            let p = self.points[v as usize];
            std::array::from_fn(|i| p[i].to_f64() - base[i])
        }));
        base
    }
}
