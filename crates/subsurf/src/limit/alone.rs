//! One location by itself: the way of [`sampler`](super::sampler) in `f64`, with nothing kept for others.

use super::LimitSurface;
use super::lanes::{Frame, from_points, turns, weighted};
use super::plan::{Plan, Spot, SubPatch};
use super::powers::MIDDLE;
use super::turn::turned_points;
use crate::kernel::{Lanes, PART, Part, Parts, level, put};
use crate::real::Real;
use crate::scheme::SplitKind;
use fearless_simd::{Simd, dispatch};

impl<T: Real, const N: usize> LimitSurface<'_, T, N> {
    /// Position and derivatives at a location in a regular sub-patch.
    #[inline]
    pub(super) fn at_spot<const R: usize>(
        &self,
        patch: usize,
        plan: Plan<'_>,
        spot: &Spot<'_>,
        [u, v]: [f64; 2],
    ) -> [[f64; N]; R] {
        let (ring, split, face_turn) = (self.table.ring(patch), self.table.scheme().split(), self.table.turn(patch));
        let mut row = [[0.0; N]; R];
        plan.with_piece(spot, |matrix: &SubPatch<f64>| {
            dispatch!(level(), simd => simd.vectorize(
                #[inline(always)]
                || {
                    for first in (0..N).step_by(PART) {
                        let points = Parts::new(self.points, first);
                        let base: Part<f64> = points.rounded(ring[0] as usize);
                        let values = alone::<_, N, R>(
                            simd,
                            (matrix, spot, split),
                            ([u, v], face_turn),
                            base,
                            #[inline(always)]
                            |p| f64::apart(simd, points.rounded(ring[p] as usize), base),
                        );
                        put(&values, first, &mut row);
                    }
                }
            ));
        });
        row
    }
}

/// One sample of a piece whose ring is given relative to `base`.
#[inline(always)]
fn alone<S: Simd, const N: usize, const R: usize>(
    simd: S,
    (matrix, spot, split): (&SubPatch<f64>, &Spot<'_>, SplitKind),
    ([u, v], turn): ([f64; 2], u8),
    base: Part<f64>,
    ring: impl Fn(usize) -> Part<f64> + Copy,
) -> [Part<f64>; R] {
    match matrix {
        SubPatch::Chosen(points) => {
            let rows = from_points::<f64, S>(simd, &turned_points(points, turn), ring);
            Frame { base, turn: None }.sample(simd, split, &rows, [u - MIDDLE, v - MIDDLE])
        }
        SubPatch::Weighted(blocks) => {
            let rows = weighted::<f64, S, N>(simd, blocks, ring);
            Frame { base, turn: turns(spot.pose, split) }.sample(simd, split, &rows, [spot.s, spot.t])
        }
    }
}
