//! Values of one face at points of a grid, without weights: the way down the patch tree with the values at the face's control
//! points, relative to one of them, in `f64`. Up to four components are one vector.

use super::dense::{Control, Jacobian, Target};
use super::{GridMaker, GridPoints, GridScratch};
use crate::kernel::LANES;
use crate::real::Real;

/// Where the values of samples go, by their numbers.
pub(crate) struct GridValues<'o, T, const N: usize> {
    /// What control points are relative to.
    pub base: [f64; N],
    pub points: &'o mut [[T; N]],
    /// `∂u` and `∂v` of three components, in blocks of samples; empty where they are not wanted.
    pub derivatives: &'o mut [[[[f64; LANES]; 3]; 2]],
}

impl<const W: usize, T: Real, const N: usize> Target<W> for GridValues<'_, T, N> {
    #[inline(always)]
    fn chunks(&self) -> usize {
        N.div_ceil(W)
    }

    #[inline(always)]
    fn put<const K: usize>(
        &mut self,
        rows: &[[[f64; W]; K]; 3],
        chunk: usize,
        number: u32,
        jacobian: Jacobian,
        count: usize,
    ) {
        let number = number as usize;
        let point = &mut self.points[number];
        let first = chunk * W;
        for c in first..N.min(first + K * W) {
            point[c] = T::from_f64(self.base[c] + rows[0][(c - first) / W][(c - first) % W]);
        }
        // Normals are those of three components.
        if count == 1 || chunk > 0 {
            return;
        }
        let (block, lane) = (number / LANES, number % LANES);
        let [du, dv] = &mut self.derivatives[block];
        let [u, v] = jacobian;
        for c in 0..3 {
            let (s, t) = (rows[1][0][c], rows[2][0][c]);
            du[c][lane] = u[0] * s + u[1] * t;
            dv[c][lane] = v[0] * s + v[1] * t;
        }
    }
}

impl GridMaker<'_> {
    /// Evaluates grid points of a face of a plan, whose control points are rows of as many vectors as `N` numbers fill, relative to
    /// the base of `out`.
    pub fn evaluate<const W: usize, T: Real, const N: usize>(
        &self,
        plan: usize,
        control: &[[f64; W]],
        points: &GridPoints,
        scratch: &mut GridScratch<W>,
        out: &mut GridValues<'_, T, N>,
    ) {
        let start = self.plans.get(plan).start;
        let control = Control { matrix: control, some: None, jacobian: [[1.0, 0.0], [0.0, 1.0]], depth: 0 };
        self.node(start, control, points.region(self.grid.cells), scratch, out);
    }
}
