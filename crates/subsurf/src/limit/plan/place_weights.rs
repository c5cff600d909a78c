//! Weights of one location in a regular sub-patch: a basis of sixteen functions times the sub-patch's matrix, lanes over
//! the basis.

use super::Plan;
use super::sub_patches::{Blocks, ControlPoints, Spot, SubPatch};
use crate::kernel::{LANES, Lanes};
use fearless_simd::{Level, Simd, dispatch};

impl<'a> Plan<'a> {
    /// Weights over the ring at a spot, which is that of `at`, for the first `count` entries of
    /// [`ORDERS`](crate::limit::bspline::ORDERS) (1, 3 or 6), one row after the other: those of [`weights`](Self::weights) to
    /// rounding, at a fraction of the cost.
    pub fn weights_in_piece(self, spot: &Spot<'a>, at: (f64, f64, u8), count: usize, out: &mut Vec<f64>) {
        let ring = self.ring();
        out.clear();
        out.resize(count * ring, 0.0);
        self.with_piece(spot, at, |matrices: &SubPatch<f64>| {
            let basis = self.basis(spot, count);
            dispatch!(Level::new(), simd => simd.vectorize(
                #[inline(always)]
                || {
                    for (order, row) in out.chunks_exact_mut(ring).enumerate() {
                        match (&matrices.fine, &matrices.points) {
                            (Some((fine, blocks)), _) if fine.serves(order) => product(simd, &basis[order], blocks, row),
                            (_, ControlPoints::Weighted(blocks)) => product(simd, &basis[order], blocks, row),
                            (_, ControlPoints::Chosen(points)) => {
                                for k in 0..LANES {
                                    row[usize::from(points[k])] = basis[order][k];
                                }
                            }
                        }
                    }
                }
            ));
            if let Some(origin) = &matrices.origin {
                out.iter_mut().zip(origin).for_each(|(sum, w)| *sum += w);
            }
        });
        self.turn(spot.pose, out);
    }
}

/// `row[p] = Σ basis[k] · blocks[p][k]`.
#[inline(always)]
fn product<S: Simd>(simd: S, basis: &[f64; LANES], blocks: &Blocks<f64>, row: &mut [f64]) {
    let basis = f64::load(simd, basis);
    for p in 0..if blocks.len() < row.len() { blocks.len() } else { row.len() } {
        let [a, b, c, d] = f64::quarters(simd, f64::times(simd, basis, f64::load(simd, &blocks[p])));
        row[p] = (a + c) + (b + d);
    }
}
