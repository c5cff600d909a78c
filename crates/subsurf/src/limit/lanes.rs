//! One polynomial patch at many parameters: a lane per sample, plain Rust that becomes vector instructions under
//! [`vectorized`](crate::kernel::vectorized). A sample's bits depend neither on the number of lanes nor on its neighbours.
//!
//! Patches come as the control points of [`SubPatch`]: sixteen of a bicubic patch, or the fifteen coefficients of a
//! quartic one, see [`EXPONENTS`](super::box_spline::EXPONENTS).

use super::bspline::cubic;
use super::plan::{ControlPoints, Pose, SubPatch};
use crate::kernel::LANES;
use crate::real::Real;
use crate::scheme::SplitKind;

/// Control points, component by component.
pub(crate) type Control<T, const N: usize> = [[T; LANES]; N];

/// Rows of position, and of `∂u ∂v` (`R = 3`), and of `∂uu ∂uv ∂vv` (`R = 6`), component by component, `W` samples.
pub(crate) type Block<T, const N: usize, const R: usize, const W: usize> = [[[T; W]; N]; R];

/// A sub-patch of one face: its control points and how it lies in the face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece<T, const N: usize> {
    split: SplitKind,
    points: Control<T, N>,
    second: Option<Control<T, N>>,
    /// What the control points are relative to.
    origin: [T; N],
    /// Derivatives in the face's parameters from those in the piece's: first ones, and second ones.
    turn: [[T; 2]; 2],
    bend: [[T; 3]; 3],
}

impl<T: Real, const N: usize> Piece<T, N> {
    /// The piece of a face whose ring is given relative to `base`.
    #[inline(always)]
    pub fn new(
        matrices: &SubPatch<T>,
        pose: Pose,
        split: SplitKind,
        base: [T; N],
        ring: impl Fn(usize) -> [T; N],
    ) -> Self {
        let mut origin = base;
        if let Some(weights) = &matrices.origin {
            let mut sum = [T::default(); N];
            for (p, &w) in weights.iter().enumerate() {
                let point = ring(p);
                (0..N).for_each(|c| sum[c] = sum[c] + w * point[c]);
            }
            (0..N).for_each(|c| origin[c] = base[c] + sum[c]);
        }
        let weighted = |blocks: &[[T; LANES]]| {
            let mut points = [[T::default(); LANES]; N];
            for (p, weights) in blocks.iter().enumerate() {
                let point = ring(p);
                for c in 0..N {
                    for k in 0..LANES {
                        points[c][k] = points[c][k] + weights[k] * point[c];
                    }
                }
            }
            points
        };
        let points = match &matrices.points {
            ControlPoints::Chosen(chosen) => {
                let mut points = [[T::default(); LANES]; N];
                for (k, &p) in chosen.iter().enumerate() {
                    let point = ring(usize::from(p));
                    (0..N).for_each(|c| points[c][k] = point[c]);
                }
                points
            }
            ControlPoints::Weighted(blocks) => weighted(blocks),
        };
        let second = matrices.second.as_ref().map(|blocks| weighted(blocks));
        let turn = pose.jacobian(split).map(|row| row.map(T::from_f64));
        let bend = pose.second(split).map(|row| row.map(T::from_f64));
        Self { split, points, second, origin, turn, bend }
    }

    /// Position and derivatives at parameters of the piece.
    #[inline(always)]
    pub fn block<const R: usize, const W: usize>(&self, s: &[T; W], t: &[T; W]) -> Block<T, N, R, W> {
        let second = self.second.as_ref().unwrap_or(&self.points);
        let mut rows = match self.split {
            SplitKind::Quads => bicubic::<T, N, R, W>(&self.points, second, s, t),
            SplitKind::Triangles => quartic::<T, N, R, W>(&self.points, second, s, t),
        };
        for c in 0..N {
            for k in 0..W {
                rows[0][c][k] = self.origin[c] + rows[0][c][k];
                if R > 1 {
                    let [s, t] = [rows[1][c][k], rows[2][c][k]];
                    rows[1][c][k] = self.turn[0][0] * s + self.turn[0][1] * t;
                    rows[2][c][k] = self.turn[1][0] * s + self.turn[1][1] * t;
                }
                if R > 3 {
                    let [ss, st, tt] = [rows[3][c][k], rows[4][c][k], rows[5][c][k]];
                    for (r, [a, b, d]) in self.bend.iter().enumerate() {
                        rows[3 + r][c][k] = *a * ss + *b * st + *d * tt;
                    }
                }
            }
        }
        rows
    }
}

/// A bicubic patch, in its own parameters.
#[inline(always)]
fn bicubic<T: Real, const N: usize, const R: usize, const W: usize>(
    points: &Control<T, N>,
    second: &Control<T, N>,
    s: &[T; W],
    t: &[T; W],
) -> Block<T, N, R, W> {
    let (mut along, mut across) = ([[[T::default(); W]; 4]; 3], [[[T::default(); W]; 4]; 3]);
    for k in 0..W {
        let (a, b) = (cubic(s[k]), cubic(t[k]));
        for order in 0..3 {
            for i in 0..4 {
                along[order][i][k] = a[order][i];
                across[order][i][k] = b[order][i];
            }
        }
    }
    let mut rows = [[[T::default(); W]; N]; R];
    for c in 0..N {
        for j in 0..4 {
            let line = line(&points[c], j, &along[0]);
            add(&mut rows[0][c], &across[0][j], &line);
            if R > 1 {
                let slope = self::line(&points[c], j, &along[1]);
                add(&mut rows[1][c], &across[0][j], &slope);
                add(&mut rows[2][c], &across[1][j], &line);
            }
            if R > 3 {
                let [line, slope, bend] = [0, 1, 2].map(|order: usize| self::line(&second[c], j, &along[order]));
                add(&mut rows[3][c], &across[0][j], &bend);
                add(&mut rows[4][c], &across[1][j], &slope);
                add(&mut rows[5][c], &across[2][j], &line);
            }
        }
    }
    rows
}

/// Row `j` of control points, combined.
#[inline(always)]
fn line<T: Real, const W: usize>(points: &[T; LANES], j: usize, basis: &[[T; W]; 4]) -> [T; W] {
    let mut sum = [T::default(); W];
    for i in 0..4 {
        for k in 0..W {
            sum[k] = sum[k] + basis[i][k] * points[4 * j + i];
        }
    }
    sum
}

#[inline(always)]
fn add<T: Real, const W: usize>(sum: &mut [T; W], weight: &[T; W], value: &[T; W]) {
    for k in 0..W {
        sum[k] = sum[k] + weight[k] * value[k];
    }
}

/// A quartic patch, in its own parameters: Horner's rule in t, then in s, derivatives alongside.
#[inline(always)]
fn quartic<T: Real, const N: usize, const R: usize, const W: usize>(
    points: &Control<T, N>,
    second: &Control<T, N>,
    s: &[T; W],
    t: &[T; W],
) -> Block<T, N, R, W> {
    let mut rows = [[[T::default(); W]; N]; R];
    for c in 0..N {
        for k in 0..W {
            let [value, first, _] = horner(&points[c], s[k], t[k]);
            rows[0][c][k] = value[0];
            if R > 1 {
                (rows[1][c][k], rows[2][c][k]) = (value[1], first[0]);
            }
            if R > 3 {
                let [value, first, bend] = horner(&second[c], s[k], t[k]);
                (rows[3][c][k], rows[4][c][k], rows[5][c][k]) = (value[2], first[1], bend[0]);
            }
        }
    }
    rows
}

/// The derivatives of a quartic: entry `[i][j]` is `i` times in t and `j` times in s, up to the second.
#[inline(always)]
fn horner<T: Real>(coefficients: &[T; LANES], s: T, t: T) -> [[T; 3]; 3] {
    const FIRST: [usize; 5] = [0, 5, 9, 12, 14];
    let two = T::from_f64(2.0);
    let mut out = [[T::default(); 3]; 3];
    for p in (0..5).rev() {
        // The polynomial in t that stands at s^p.
        let mut column = [T::default(); 3];
        for q in (0..5 - p).rev() {
            column = [
                column[0] * t + coefficients[FIRST[p] + q],
                column[1] * t + column[0],
                column[2] * t + two * column[1],
            ];
        }
        for (out, value) in out.iter_mut().zip(column) {
            *out = [out[0] * s + value, out[1] * s + out[0], out[2] * s + two * out[1]];
        }
    }
    out
}
