//! One polynomial patch at many parameters: a lane per sample, plain Rust that becomes vector instructions under
//! [`vectorized`](crate::kernel::vectorized). A sample's bits depend neither on the number of lanes nor on its neighbours.
//!
//! Patches come as the control points of [`SubPatch`]: sixteen of a bicubic patch, or the fifteen coefficients of a
//! quartic one, see [`EXPONENTS`](super::box_spline::EXPONENTS). Loops are written out, since closures given to the
//! standard library are not compiled for the machine's own vectors.

use super::bspline::{ORDERS, cubic};
use super::plan::{ControlPoints, Fine, Pose, SubPatch};
use crate::kernel::LANES;
use crate::real::Real;
use crate::scheme::SplitKind;

/// Control points, component by component.
pub(crate) type Control<T, const N: usize> = [[T; LANES]; N];

/// Rows of position, and of `∂u ∂v` (`R = 3`), and of `∂uu ∂uv ∂vv` (`R = 6`), component by component, `W` samples.
pub(crate) type Block<T, const N: usize, const R: usize, const W: usize> = [[[T; W]; N]; R];

/// Factors of first and second derivatives.
type Turn<T> = ([[T; 2]; 2], [[T; 3]; 3]);

/// A sub-patch of one face: its control points and how it lies in the face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece<T, const N: usize> {
    split: SplitKind,
    points: Control<T, N>,
    fine: Option<(Fine, Control<T, N>)>,
    /// What the control points are relative to.
    origin: [T; N],
    /// Derivatives in the face's parameters from those in the piece's, first and second ones; none where they are the same.
    turn: Option<Turn<T>>,
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
            for p in 0..weights.len() {
                let (w, point) = (weights[p], ring(p));
                for c in 0..N {
                    sum[c] = sum[c] + w * point[c];
                }
            }
            for c in 0..N {
                origin[c] = base[c] + sum[c];
            }
        }
        let points = match &matrices.points {
            ControlPoints::Chosen(chosen) => {
                let mut points = [[T::default(); LANES]; N];
                for k in 0..LANES {
                    let point = ring(usize::from(chosen[k]));
                    for c in 0..N {
                        points[c][k] = point[c];
                    }
                }
                points
            }
            ControlPoints::Weighted(blocks) => weighted(blocks, &ring),
        };
        let fine = match &matrices.fine {
            Some((fine, blocks)) => Some((*fine, weighted(blocks, &ring))),
            None => None,
        };
        Self { split, points, fine, origin, turn: turns(pose, split) }
    }

    /// Position and derivatives at parameters of the piece.
    #[inline(always)]
    pub fn block<const R: usize, const W: usize>(&self, s: &[T; W], t: &[T; W]) -> Block<T, N, R, W> {
        let mut rows = match (self.split, &self.fine) {
            (SplitKind::Quads, None) => bicubic::<T, N, R, W>(&self.points, s, t),
            (SplitKind::Quads, Some((fine, points))) => parted::<T, N, R, W>(&self.points, *fine, points, s, t),
            (SplitKind::Triangles, None) => quartic::<T, N, R, W>(&self.points, &self.points, s, t),
            (SplitKind::Triangles, Some((_, points))) => quartic::<T, N, R, W>(&self.points, points, s, t),
        };
        for c in 0..N {
            for k in 0..W {
                rows[0][c][k] = self.origin[c] + rows[0][c][k];
            }
        }
        if let Some((turn, bend)) = &self.turn {
            for c in 0..N {
                for k in 0..W {
                    if R > 1 {
                        let [s, t] = [rows[1][c][k], rows[2][c][k]];
                        rows[1][c][k] = turn[0][0] * s + turn[0][1] * t;
                        rows[2][c][k] = turn[1][0] * s + turn[1][1] * t;
                    }
                    if R > 3 {
                        let [ss, st, tt] = [rows[3][c][k], rows[4][c][k], rows[5][c][k]];
                        for r in 0..3 {
                            rows[3 + r][c][k] = bend[r][0] * ss + bend[r][1] * st + bend[r][2] * tt;
                        }
                    }
                }
            }
        }
        rows
    }
}

/// The factors of derivatives, unless they stay as they are.
#[inline(always)]
fn turns<T: Real>(pose: Pose, split: SplitKind) -> Option<Turn<T>> {
    if pose.is_plain() {
        return None;
    }
    let (jacobian, second) = (pose.jacobian(split), pose.second(split));
    let (mut turn, mut bend) = ([[T::default(); 2]; 2], [[T::default(); 3]; 3]);
    for i in 0..2 {
        for j in 0..2 {
            turn[i][j] = T::from_f64(jacobian[i][j]);
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            bend[i][j] = T::from_f64(second[i][j]);
        }
    }
    Some((turn, bend))
}

/// Control points from their weights over the ring.
#[inline(always)]
fn weighted<T: Real, const N: usize>(blocks: &[[T; LANES]], ring: &impl Fn(usize) -> [T; N]) -> Control<T, N> {
    let mut points = [[T::default(); LANES]; N];
    for p in 0..blocks.len() {
        let (weights, point) = (&blocks[p], ring(p));
        for c in 0..N {
            for k in 0..LANES {
                points[c][k] = points[c][k] + weights[k] * point[c];
            }
        }
    }
    points
}

/// Weights of curves at `W` parameters, by order of differentiation and control point.
type Curves<T, const W: usize> = [[[T; W]; 4]; 3];

#[inline(always)]
fn curves<T: Real, const W: usize>(t: &[T; W]) -> Curves<T, W> {
    let mut weights = [[[T::default(); W]; 4]; 3];
    for k in 0..W {
        let basis = cubic(t[k]);
        for order in 0..3 {
            for i in 0..4 {
                weights[order][i][k] = basis[order][i];
            }
        }
    }
    weights
}

/// A bicubic patch, in its own parameters.
#[inline(always)]
fn bicubic<T: Real, const N: usize, const R: usize, const W: usize>(
    points: &Control<T, N>,
    s: &[T; W],
    t: &[T; W],
) -> Block<T, N, R, W> {
    let (along, across) = (curves(s), curves(t));
    let mut rows = [[[T::default(); W]; N]; R];
    for c in 0..N {
        for j in 0..4 {
            let value = line(&points[c], j, &along[0]);
            add(&mut rows[0][c], &across[0][j], &value);
            if R > 1 {
                let slope = line(&points[c], j, &along[1]);
                add(&mut rows[1][c], &across[0][j], &slope);
                add(&mut rows[2][c], &across[1][j], &value);
                if R > 3 {
                    let bend = line(&points[c], j, &along[2]);
                    add(&mut rows[3][c], &across[0][j], &bend);
                    add(&mut rows[4][c], &across[1][j], &slope);
                    add(&mut rows[5][c], &across[2][j], &value);
                }
            }
        }
    }
    rows
}

/// The same, some derivatives from finer control points.
#[inline(always)]
fn parted<T: Real, const N: usize, const R: usize, const W: usize>(
    points: &Control<T, N>,
    fine: Fine,
    finer: &Control<T, N>,
    s: &[T; W],
    t: &[T; W],
) -> Block<T, N, R, W> {
    let (along, across) = (curves(s), curves(t));
    let mut rows = [[[T::default(); W]; N]; R];
    for order in 0..R {
        let points = if fine.serves(order) { finer } else { points };
        let (in_s, in_t) = ORDERS[order];
        for c in 0..N {
            for j in 0..4 {
                let line = line(&points[c], j, &along[in_s]);
                add(&mut rows[order][c], &across[in_t][j], &line);
            }
        }
    }
    rows
}

/// Row `j` of control points, combined.
#[inline(always)]
fn line<T: Real, const W: usize>(points: &[T; LANES], j: usize, basis: &[[T; W]; 4]) -> [T; W] {
    let mut sum = [T::default(); W];
    for k in 0..W {
        sum[k] = basis[0][k] * points[4 * j];
    }
    for i in 1..4 {
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

/// A quartic patch, in its own parameters: Horner's rule in t, then in s, derivatives alongside; second ones from control
/// points of their own.
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
    let (zero, two) = (T::default(), T::from_f64(2.0));
    let mut out = [[zero; 3]; 3];
    for p in [4, 3, 2, 1, 0] {
        // The polynomial in t that stands at s^p.
        let mut column = [zero; 3];
        for q in [4, 3, 2, 1, 0] {
            if p + q <= 4 {
                column[2] = column[2] * t + two * column[1];
                column[1] = column[1] * t + column[0];
                column[0] = column[0] * t + coefficients[FIRST[p] + q];
            }
        }
        for i in 0..3 {
            out[i][2] = out[i][2] * s + two * out[i][1];
            out[i][1] = out[i][1] * s + out[i][0];
            out[i][0] = out[i][0] * s + column[i];
        }
    }
    out
}
