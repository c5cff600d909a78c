//! Weights of one location in a regular sub-patch: a basis of sixteen functions times the sub-patch's matrix, lanes over
//! the basis.

use super::Plan;
use super::sub_patches::{Blocks, Pose, Spot, SubPatch};
use crate::kernel::{LANES, Lanes, level};
use crate::limit::box_spline;
use crate::limit::bspline::{cubic, tensor};
use crate::limit::powers::{MIDDLE, powers};
use crate::scheme::SplitKind;
use fearless_simd::{Simd, dispatch};

impl<'a> Plan<'a> {
    /// Weights over the ring at a spot, for the first `count` entries of
    /// [`ORDERS`](crate::limit::bspline::ORDERS) (1, 3 or 6), one row after the other: those of [`weights`](Self::weights) to
    /// rounding, at a fraction of the cost.
    pub fn weights_in_piece(self, spot: &Spot<'a>, count: usize, out: &mut Vec<f64>) {
        let ring = self.ring();
        out.clear();
        out.resize(count * ring, 0.0);
        self.with_piece(spot, |matrix: &SubPatch<f64>| match matrix {
            SubPatch::Weighted(blocks) => {
                let basis = self.basis(spot, count);
                dispatch!(level(), simd => simd.vectorize(
                    #[inline(always)]
                    || {
                        for (order, row) in out.chunks_exact_mut(ring).enumerate() {
                            product(simd, &basis[order], blocks, row);
                        }
                    }
                ));
            }
            SubPatch::Chosen(points) => {
                let basis = tensor(&cubic(spot.s + MIDDLE), &cubic(spot.t + MIDDLE), count);
                for (basis, row) in basis.iter().zip(out.chunks_exact_mut(ring)) {
                    for k in 0..LANES {
                        // Where a mesh winds round in three faces, two control points are one vertex.
                        row[usize::from(points[k])] += basis[k];
                    }
                }
            }
        });
        self.turn(spot.pose, out);
    }

    /// What a sub-patch's coefficients are multiplied by at a place.
    #[inline(always)]
    fn basis(self, spot: &Spot<'_>, count: usize) -> [[f64; 16]; 6] {
        match self.plans.split {
            SplitKind::Quads => tensor(&powers(spot.s), &powers(spot.t), count),
            SplitKind::Triangles => box_spline::powers_at(spot.s, spot.t, count),
        }
    }

    /// Derivatives of one place, all rows one after the other, from the parameters of its sub-patch to those of the face.
    pub(super) fn turn(self, pose: Pose, rows: &mut [f64]) {
        if pose.is_plain() {
            return;
        }
        let (turn, bend) = (pose.jacobian(self.plans.split), pose.second(self.plans.split));
        let ring = self.ring();
        for p in 0..if rows.len() > ring { ring } else { 0 } {
            let [s, t] = [rows[ring + p], rows[2 * ring + p]];
            (rows[ring + p], rows[2 * ring + p]) = (turn[0][0] * s + turn[0][1] * t, turn[1][0] * s + turn[1][1] * t);
        }
        for p in 0..if rows.len() > 3 * ring { ring } else { 0 } {
            let [ss, st, tt] = [3, 4, 5].map(|order| rows[order * ring + p]);
            for (r, [a, b, c]) in bend.iter().enumerate() {
                rows[(3 + r) * ring + p] = a * ss + b * st + c * tt;
            }
        }
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

#[cfg(test)]
mod tests {
    use crate::limit::PatchTable;
    use crate::scheme::Scheme;
    use crate::shapes::{self, Shape};

    /// Places on all sides of every change of sub-patch, down to beyond the deepest that has matrices.
    fn places(scheme: Scheme) -> Vec<[f64; 2]> {
        let mut at =
            vec![[0.3, 0.6], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.5], [0.0, 0.7], [0.6, 0.3], [0.2, 0.2]];
        for depth in 1..11 {
            let d = 2f64.powi(-depth);
            at.extend([[0.7 * d, 0.2 * d], [0.3 * d, 0.6 * d], [0.1 * d, 1.0 - 0.7 * d], [1.0 - 0.8 * d, 0.15 * d]]);
            at.extend([[0.5 * d, d], [0.4 * d, 0.4 * d]]);
            if scheme != Scheme::Loop {
                at.extend([[1.0 - 0.6 * d, 1.0 - 0.7 * d], [0.3, 1.0 - 0.9 * d], [1.0 - 0.9 * d, 0.3]]);
            }
        }
        at
    }

    fn agrees(shape: &Shape, scheme: Scheme) {
        let table = PatchTable::new(&shape.mesh, scheme).unwrap();
        let mut alone = Vec::new();
        for plan in 0..table.plan_count() {
            let plan = table.plan(plan);
            for [u, v] in places(scheme) {
                let Some(spot) = plan.spot(u, v, 0) else { continue };
                plan.weights_in_piece(&spot, 6, &mut alone);
                let single = plan.weights(u, v, 0, 6);
                for (order, row) in alone.chunks_exact(plan.ring()).enumerate() {
                    let size = single.rows[order].iter().fold(1.0, |m: f64, w| m.max(w.abs()));
                    for (a, b) in row.iter().zip(&single.rows[order]) {
                        // A hundred products; each level of a patch tree, up to twelve with creases, doubles what single
                        // locations lose per differentiation.
                        let times = [0, 1, 1, 2, 2, 2][order];
                        let rounding = 100.0 * f64::EPSILON * 4096f64.powi(times);
                        assert!((a - b).abs() <= rounding * size, "{} at {u}, {v}, order {order}: {a} {b}", shape.name);
                    }
                }
            }
        }
    }

    #[test]
    fn weights_by_sub_patches_are_those_of_single_locations() {
        for shape in shapes::all() {
            agrees(&shape, Scheme::CatmullClark);
            agrees(&shape, Scheme::Bilinear);
        }
        shapes::all_triangles().iter().for_each(|shape| agrees(shape, Scheme::Loop));
        for (columns, rows) in [(3, 3), (3, 6)] {
            agrees(&shapes::torus(columns, rows), Scheme::CatmullClark);
        }
    }
}
