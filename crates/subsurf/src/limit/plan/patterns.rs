//! Weights of many locations of one plan, sub-patch by sub-patch: a basis of sixteen functions times the sub-patch's
//! matrix, a lane per location.

use super::Plan;
use super::sub_patches::{Blocks, ControlPoints, Pose, Spot, SubPatch};
use crate::kernel::vectorized;
use crate::limit::box_spline;
use crate::limit::bspline::{cubic, tensor};
use crate::scheme::SplitKind;

/// Locations at a time: one 512-bit vector of `f64`.
const WIDTH: usize = 8;

/// Sixteen basis functions at [`WIDTH`] locations.
type Basis = [[f64; WIDTH]; 16];

impl<'a> Plan<'a> {
    /// Weights over the ring for the first `count` entries of [`ORDERS`](crate::limit::bspline::ORDERS) (1, 3 or 6) at
    /// parameters `[u, v]` of a face whose first corner is the plan's: weight `(place * count + order) * ring + point`.
    ///
    /// They are those of [`weights`](Self::weights) to rounding, at a fraction of the cost where places share
    /// sub-patches. At special vertices they are exactly those; what else holds there, the latter tells.
    pub fn weights_at(self, places: &[[f64; 2]], count: usize) -> Vec<f64> {
        let ring = self.ring();
        let mut out = vec![0.0; places.len() * count * ring];
        let mut groups: Vec<(Spot<'a>, Vec<(usize, Spot<'a>)>)> = Vec::new();
        for (i, &[u, v]) in places.iter().enumerate() {
            let Some(spot) = self.spot(u, v, 0) else {
                let weights = self.weights(u, v, 0, count);
                for (order, row) in weights.rows.iter().enumerate().take(count) {
                    out[(i * count + order) * ring..][..ring].copy_from_slice(row);
                }
                continue;
            };
            match groups.iter_mut().find(|(first, _)| first.piece() == spot.piece()) {
                Some((_, group)) => group.push((i, spot)),
                None => groups.push((spot, vec![(i, spot)])),
            }
        }
        for (spot, group) in &groups {
            let [u, v] = places[group[0].0];
            self.with_piece::<f64, _>(spot, (u, v, 0), |matrices| {
                for part in group.chunks(WIDTH) {
                    vectorized(
                        #[inline(always)]
                        || self.fill(matrices, part, count, &mut out),
                    );
                    part.iter().for_each(|&(i, _)| self.turn(spot.pose, &mut out[i * count * ring..][..count * ring]));
                }
            });
        }
        out
    }

    /// Writes the weights of up to [`WIDTH`] places of one sub-patch, derivatives in its own parameters.
    #[inline(always)]
    fn fill(self, matrices: &SubPatch<f64>, places: &[(usize, Spot<'a>)], count: usize, out: &mut [f64]) {
        let ring = self.ring();
        let mut bases: [Basis; 6] = [[[0.0; WIDTH]; 16]; 6];
        for (lane, (_, spot)) in places.iter().enumerate() {
            let rows = self.basis(spot, count);
            for (basis, row) in bases.iter_mut().zip(&rows).take(count) {
                (0..16).for_each(|k| basis[k][lane] = row[k]);
            }
        }
        for (order, basis) in bases.iter().enumerate().take(count) {
            let mut put = |point: usize, sums: &[f64; WIDTH], add: f64| {
                for (lane, (i, _)) in places.iter().enumerate() {
                    out[(i * count + order) * ring + point] = sums[lane] + add;
                }
            };
            let mut product = |blocks: &Blocks<f64>| {
                for (point, block) in blocks.iter().enumerate() {
                    let mut sums = [0.0; WIDTH];
                    for k in 0..16 {
                        for lane in 0..WIDTH {
                            sums[lane] += block[k] * basis[k][lane];
                        }
                    }
                    let origin = matrices.origin.as_ref().filter(|_| order == 0);
                    put(point, &sums, origin.map_or(0.0, |weights| weights[point]));
                }
            };
            match (&matrices.fine, &matrices.points) {
                (Some((fine, blocks)), _) if fine.serves(order) => product(blocks),
                (_, ControlPoints::Weighted(blocks)) => product(blocks),
                (_, ControlPoints::Chosen(points)) => {
                    points.iter().zip(basis).for_each(|(&point, sums)| put(usize::from(point), sums, 0.0));
                }
            }
        }
    }

    /// Basis functions of a sub-patch at a place.
    #[inline(always)]
    pub(super) fn basis(self, spot: &Spot<'_>, count: usize) -> [[f64; 16]; 6] {
        match self.plans.split {
            SplitKind::Quads => tensor(&cubic(spot.s), &cubic(spot.t), count),
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
        let places = places(scheme);
        for plan in 0..table.plan_count() {
            let plan = table.plan(plan);
            let ring = plan.ring();
            let all = plan.weights_at(&places, 6);
            for (i, &[u, v]) in places.iter().enumerate() {
                let single = plan.weights(u, v, 0, 6);
                for order in 0..6 {
                    let row = &all[(6 * i + order) * ring..][..ring];
                    let size = single.rows[order].iter().fold(1.0, |m: f64, w| m.max(w.abs()));
                    if let Some(spot) = plan.spot(u, v, 0) {
                        let mut alone = Vec::new();
                        plan.weights_in_piece(&spot, (u, v, 0), 6, &mut alone);
                        let rounding = 64.0 * f64::EPSILON * 4096.0 * 4096.0 * size;
                        for (a, b) in row.iter().zip(&alone[order * ring..][..ring]) {
                            assert!((a - b).abs() <= rounding, "{} at {u}, {v}, order {order}: {a} {b}", shape.name);
                        }
                    }
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
    }
}
