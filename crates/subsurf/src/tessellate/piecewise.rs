//! Samples of a patch without a pattern at rates so high that to go [by values](super::by_values) would take bases of many points:
//! sub-patch by sub-patch, some at a time.

use super::evaluate::Evaluator;
use super::grid::{GridSamples, Parts};
use crate::index::Face;
use crate::kernel::{LANES, unit_normals_of};
use crate::limit::{LastPole, LimitPatch, Location};
use crate::real::{Real, round};

/// Samples at a time.
const SOME: usize = 64 * LANES;

impl<T: Real, const N: usize> Evaluator<'_, T, N> {
    /// Evaluates some parts of a patch; normals if there is room for them.
    pub(super) fn piecewise(
        &self,
        (face, subface): (Face, u32),
        samples: &GridSamples,
        parts: Parts,
        points: &mut [[T; N]],
        normals: &mut [[T; 3]],
    ) {
        let surface = self.sampler.surface();
        let patch = surface.table().patch(face, subface);
        let turn = surface.table().turn(patch);
        let mut limit = surface.patch(face, subface).expect("holes have no samples");
        let mut last = LastPole::default();
        let wanted: Vec<usize> = (0..samples.len()).filter(|s| samples.uses(s / LANES, parts)).collect();
        for wanted in wanted.chunks(SOME) {
            let places: Vec<[f64; 2]> = wanted.iter().map(|&s| samples.uv_in_face(s, turn)).collect();
            if normals.is_empty() {
                let mut rows = vec![[[T::default(); N]; 1]; wanted.len()];
                limit.eval_into(&places, &mut rows);
                wanted.iter().zip(&rows).for_each(|(&s, [point])| points[s] = *point);
                continue;
            }
            self.with_normals(&mut limit, patch, &places, |k, point, unit| {
                points[wanted[k]] = point;
                normals[wanted[k]] = unit.unwrap_or_else(|| {
                    let [u, v] = places[k];
                    round(self.sampler.single_after(Location { face, subface, u, v }, &mut last).1)
                });
            });
        }
    }

    /// Calls `put` with the number of each place, its point, and its normal where that is sure.
    fn with_normals(
        &self,
        limit: &mut LimitPatch<'_, T, N>,
        patch: usize,
        places: &[[f64; 2]],
        mut put: impl FnMut(usize, [T; N], Option<[T; 3]>),
    ) {
        let surface = self.sampler.surface();
        let ring = surface.table().ring(patch).iter().map(|&v| surface.points()[v as usize]);
        let base = surface.points()[surface.table().ring(patch)[0] as usize];
        let far = ring.flat_map(|p| (0..N).map(move |c| (p[c] - base[c]).to_f64().abs())).fold(0.0, f64::max);
        let extent = [T::from_f64(far); LANES];
        let mut rows = vec![[[T::default(); N]; 3]; places.len()];
        let mut exceptional = limit.eval_into(places, &mut rows).into_iter().map(|e| e.sample).peekable();
        for (b, rows) in rows.chunks(LANES).enumerate() {
            let [mut du, mut dv] = [[[T::default(); LANES]; 3]; 2];
            for (k, [_, u, v]) in rows.iter().enumerate() {
                (0..3).for_each(|c| (du[c][k], dv[c][k]) = (u[c % N], v[c % N]));
            }
            let mut unit = [[T::default(); 3]; LANES];
            let unsure = unit_normals_of(&du, &dv, &extent, &mut unit);
            for (k, [point, ..]) in rows.iter().enumerate() {
                let is_sure = exceptional.next_if_eq(&(b * LANES + k)).is_none() && unsure >> k & 1 == 0;
                put(b * LANES + k, *point, is_sure.then_some(unit[k]));
            }
        }
    }
}
