//! Evaluation at vertices of many faces, where rings are too large for matrices: what a face's control points are there,
//! refined level by level, may be kept for its next location.

use super::LimitSurface;
use super::plan::{AtPole, Plan};
use super::pole::PoleValues;
use super::special::{AtVertex, PointWeights};
use crate::real::Real;

/// Numbers to a vector.
const W: usize = 4;

/// Of one surface, values at the vertex of many faces that was met last, by patch and leaf of its plan: locations that
/// follow each other often lie in one face.
#[derive(Default)]
pub(crate) struct LastPole(Option<((usize, u64), PoleValues<W>)>);

impl<T: Real, const N: usize> LimitSurface<'_, T, N> {
    /// Rows of the jet, each of `N` components, at parameters of a patch that lie at a vertex of many faces.
    pub(super) fn at_pole(
        &self,
        patch: usize,
        plan: Plan<'_>,
        [u, v]: [f64; 2],
        count: usize,
        LastPole(last): &mut LastPole,
    ) -> Option<PointWeights> {
        let place = plan.at_pole(u, v, self.table.turn(patch))?;
        let base = self.points[self.table.ring(patch)[0] as usize].map(T::to_f64);
        let key = (patch, place.path);
        let (_, values) = match last.take() {
            Some(known) if known.0 == key => last.insert(known),
            _ => last.insert((key, self.values_at(patch, &place))),
        };
        let mut rows = rows(values, &place, count, N);
        rows.rows[0].iter_mut().zip(base).for_each(|(x, base)| *x += base);
        Some(place.in_face(rows))
    }

    /// Values at the points of the vertex, relative to the first control point of the patch.
    fn values_at(&self, patch: usize, place: &AtPole<'_>) -> PoleValues<W> {
        let chunks = N.div_ceil(W).max(1);
        let ring = self.table.ring(patch);
        let base = self.points[ring[0] as usize].map(T::to_f64);
        let mut control = vec![[0.0; W]; ring.len() * chunks];
        for (row, &number) in control.chunks_exact_mut(chunks).zip(ring) {
            let point = &self.points[number as usize];
            (0..N).for_each(|c| row[c / W][c % W] = point[c].to_f64() - base[c]);
        }
        PoleValues::new(place.vertex, &place.points(control, chunks), chunks)
    }
}

/// Rows of `components` numbers in the parameters at the vertex.
fn rows(values: &mut PoleValues<W>, place: &AtPole<'_>, count: usize, components: usize) -> PointWeights {
    let row = |values: &[[f64; W]]| values.as_flattened()[..components].to_vec();
    let mut jet = Default::default();
    let mut out = PointWeights::default();
    if values.jet(place.vertex, place.at, count, &mut jet) {
        out.rows.iter_mut().zip(&jet).take(count).for_each(|(out, values)| *out = row(values));
        return out;
    }
    let weights = place.vertex.weights(0.0, 0.0, count);
    out.rows[0] = row(values.limit());
    for (out, weights) in out.rows.iter_mut().zip(&weights.rows).take(count).skip(1) {
        *out = row(&values.difference(weights));
    }
    out.at_vertex = weights.at_vertex.map(|at| {
        let plane = at.plane.map(|plane| plane.map(|weights| row(&values.difference(&weights))));
        AtVertex { plane, ..at }
    });
    out
}
