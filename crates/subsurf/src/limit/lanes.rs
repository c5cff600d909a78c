//! One polynomial patch at many parameters, one after the other: the vector lanes are four control points with up to four
//! components each, so that a sample fills them however few others lie on its patch.
//!
//! Patches come as the control points of [`SubPatch`]: sixteen of a bicubic patch, or the fifteen coefficients of a
//! quartic one, see [`EXPONENTS`](super::box_spline::EXPONENTS). Values of more than four components are evaluated in parts.
//! Loops are written out, since closures given to the standard library are not compiled for the machine's own vectors.

use super::bspline::{ORDERS, WEIGHTS, weight};
use super::plan::{ControlPoints, Fine, Pose, SubPatch};
use crate::kernel::{LANES, PART, Part};
use crate::real::Real;
use crate::scheme::SplitKind;
use fearless_simd::Simd;

/// Control points, four rows of four: of point `4 j + i` component `c` at `4 i + c` of row `j`.
pub(super) type Panel<T> = [[T; LANES]; 4];

/// Factors of derivatives: those in the face's `u`, then `v`, from those in the piece's `s` and `t`.
pub(super) type Turn<T> = [[T; 2]; 2];

/// The factors of a piece; none where derivatives stay as they are.
#[inline(always)]
pub(super) fn turns<T: Real>(pose: Pose, split: SplitKind) -> Option<Turn<T>> {
    if pose.is_plain() {
        return None;
    }
    let [u, v] = pose.jacobian(split);
    Some([[T::from_f64(u[0]), T::from_f64(u[1])], [T::from_f64(v[0]), T::from_f64(v[1])]])
}

/// A part of a sub-patch of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece<T> {
    pub panel: Panel<T>,
    /// What the control points are relative to.
    pub origin: Part<T>,
    /// Factors of derivatives.
    pub turn: Option<Turn<T>>,
    /// What further control points are for; they are in a panel of their own.
    pub fine: Option<Fine>,
}

impl<T: Real> Piece<T> {
    /// That of a face whose ring is given relative to `base`.
    #[inline(always)]
    pub fn new<S: Simd, const N: usize>(
        simd: S,
        matrices: &SubPatch<T>,
        turn: Option<Turn<T>>,
        base: Part<T>,
        ring: impl Fn(usize) -> Part<T> + Copy,
    ) -> Self {
        let (mut panel, mut origin) = ([[T::default(); LANES]; 4], base);
        match &matrices.points {
            ControlPoints::Chosen(chosen) => {
                for (k, point) in panel.as_flattened_mut().as_chunks_mut().0.iter_mut().enumerate() {
                    *point = ring(usize::from(chosen[k]));
                }
            }
            ControlPoints::Weighted(blocks) => panel = weighted::<T, S, N>(simd, blocks, ring),
        }
        if let Some(weights) = &matrices.origin {
            let mut sum = [T::default(); PART];
            for p in 0..weights.len() {
                let (w, point) = (weights[p], ring(p));
                for c in 0..PART {
                    sum[c] = sum[c] + w * point[c];
                }
            }
            for c in 0..PART {
                origin[c] = base[c] + sum[c];
            }
        }
        Self { panel, origin, turn, fine: matrices.fine.as_ref().map(|(fine, _)| *fine) }
    }

    /// A sample in the piece's own parameters, `s` and number `k` of those that `across` was made of: position,
    /// derivatives in the face's parameters `u`, `v` (`R = 3`), and `uu`, `uv`, `vv` (`R = 6`).
    #[inline(always)]
    pub fn sample<S: Simd, const R: usize, const W: usize>(
        &self,
        simd: S,
        split: SplitKind,
        finer: Option<&Panel<T>>,
        [s, t]: [T; 2],
        (across, k): (&Curves<T, W>, usize),
    ) -> [Part<T>; R] {
        let fine = match (self.fine, finer) {
            (Some(fine), Some(finer)) => Some((fine, finer)),
            _ => None,
        };
        let mut values = match split {
            SplitKind::Quads => bicubic::<T, S, R, W>(simd, &self.panel, fine, s, across, k),
            SplitKind::Triangles => quartic::<T, R>(&self.panel, fine, s, t),
        };
        for c in 0..PART {
            values[0][c] = self.origin[c] + values[0][c];
        }
        if let Some([u, v]) = &self.turn {
            if R > 1 {
                let [s, t] = [values[1], values[2]];
                for c in 0..PART {
                    values[1][c] = u[0] * s[c] + u[1] * t[c];
                    values[2][c] = v[0] * s[c] + v[1] * t[c];
                }
            }
            if R > 3 {
                let [ss, st, tt] = [values[3], values[4], values[5]];
                // Products of powers of two, so exact.
                for (r, [a, b]) in [[u, u], [u, v], [v, v]].into_iter().enumerate() {
                    let bend = [a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[1] * b[1]];
                    for c in 0..PART {
                        values[3 + r][c] = bend[0] * ss[c] + bend[1] * st[c] + bend[2] * tt[c];
                    }
                }
            }
        }
        values
    }
}

/// Control points from their weights over the ring.
#[inline(always)]
pub(super) fn weighted<T: Real, S: Simd, const N: usize>(
    simd: S,
    blocks: &[[T; LANES]],
    ring: impl Fn(usize) -> Part<T> + Copy,
) -> Panel<T> {
    // Even and odd points apart, so that additions need not wait for each other.
    let mut sides = [[T::splat(simd, T::default()); PART]; 2];
    let even = blocks.len() & !1;
    for p in (0..even).step_by(2) {
        for side in 0..2 {
            let (weights, point) = (T::load(simd, &blocks[p + side]), ring(p + side));
            for c in 0..if N < PART { N } else { PART } {
                sides[side][c] = T::plus(simd, sides[side][c], T::times(simd, weights, T::splat(simd, point[c])));
            }
        }
    }
    if even < blocks.len() {
        let (weights, point) = (T::load(simd, &blocks[even]), ring(even));
        for c in 0..if N < PART { N } else { PART } {
            sides[0][c] = T::plus(simd, sides[0][c], T::times(simd, weights, T::splat(simd, point[c])));
        }
    }
    let mut sums = sides[0];
    for c in 0..if N < PART { N } else { PART } {
        sums[c] = T::plus(simd, sums[c], sides[1][c]);
    }
    // From one component of all points to all components of one.
    let ([xz, yw], mut panel) = ([[sums[0], sums[2]], [sums[1], sums[3]]], [[T::default(); LANES]; 4]);
    let (xz, yw) = (T::zip(simd, xz[0], xz[1]), T::zip(simd, yw[0], yw[1]));
    for half in 0..2 {
        let [low, high] = T::zip(simd, xz[half], yw[half]);
        T::store(simd, low, &mut panel[2 * half]);
        T::store(simd, high, &mut panel[2 * half + 1]);
    }
    panel
}

/// Weights of curves at `W` parameters, by order of differentiation and control point.
pub(super) type Curves<T, const W: usize> = [[[T; W]; 4]; 3];

/// Weights up to a derivative: as many orders as rows of `R` vectors need.
#[inline(always)]
pub(super) fn curves<T: Real, const R: usize, const W: usize>(t: &[T; W]) -> Curves<T, W> {
    let mut weights = [[[T::default(); W]; 4]; 3];
    for i in 0..4 {
        for order in 0..1 + R / 3 {
            for k in 0..W {
                weights[order][i][k] = weight(t[k], i)[order];
            }
        }
    }
    weights
}

/// A sample of a bicubic patch, some derivatives from finer control points.
#[inline(always)]
fn bicubic<T: Real, S: Simd, const R: usize, const W: usize>(
    simd: S,
    panel: &Panel<T>,
    fine: Option<(Fine, &Panel<T>)>,
    s: T,
    across: &Curves<T, W>,
    k: usize,
) -> [Part<T>; R] {
    let along = along(simd, s);
    let rows = combined::<T, S, R, W>(simd, panel, across, k);
    let mut values = [[T::default(); PART]; R];
    match fine {
        None => {
            for r in 0..R {
                let (in_s, in_t) = ORDERS[r];
                values[r] = T::quarters(simd, T::times(simd, along[in_s], rows[in_t]));
            }
        }
        Some((fine, finer)) => {
            let finer = combined::<T, S, R, W>(simd, finer, across, k);
            for r in 0..R {
                let (in_s, in_t) = ORDERS[r];
                let rows = if fine.serves(r) { &finer } else { &rows };
                values[r] = T::quarters(simd, T::times(simd, along[in_s], rows[in_t]));
            }
        }
    }
    values
}

/// Weights of curves at `s`, each four times: those of [`weight`].
#[inline(always)]
fn along<T: Real, S: Simd>(simd: S, s: T) -> [T::Block<S>; 3] {
    let [a, b, c] = WEIGHTS.value;
    let ([d, e], [f, g]) = (WEIGHTS.slope, WEIGHTS.bend);
    let x: T::Block<S> = fourfold::<T, S>(simd, &WEIGHTS.x[0]);
    let x = T::plus(simd, x, T::times(simd, fourfold::<T, S>(simd, &WEIGHTS.x[1]), T::splat(simd, s)));
    let linear = |a: &[f64; 4], b: &[f64; 4]| {
        T::plus(simd, fourfold::<T, S>(simd, a), T::times(simd, fourfold::<T, S>(simd, b), x))
    };
    [
        T::plus(simd, fourfold::<T, S>(simd, &a), T::times(simd, T::times(simd, x, x), linear(&b, &c))),
        T::times(simd, x, linear(&d, &e)),
        linear(&f, &g),
    ]
}

/// Four constants, each four times.
#[inline(always)]
fn fourfold<T: Real, S: Simd>(simd: S, constants: &[f64; 4]) -> T::Block<S> {
    let mut all = [T::default(); LANES];
    for k in 0..LANES {
        all[k] = T::from_f64(constants[k / 4]);
    }
    T::load(simd, &all)
}

/// The rows of a panel, combined with weights and their derivatives.
#[inline(always)]
fn combined<T: Real, S: Simd, const R: usize, const W: usize>(
    simd: S,
    panel: &Panel<T>,
    across: &Curves<T, W>,
    k: usize,
) -> [T::Block<S>; 3] {
    let mut sums = [T::splat(simd, T::default()); 3];
    for order in 0..1 + R / 3 {
        let mut sum = T::times(simd, T::splat(simd, across[order][0][k]), T::load(simd, &panel[0]));
        for j in 1..4 {
            sum = T::plus(simd, sum, T::times(simd, T::splat(simd, across[order][j][k]), T::load(simd, &panel[j])));
        }
        sums[order] = sum;
    }
    sums
}

/// A sample of a quartic patch: Horner's rule in t, then in s, derivatives alongside; second ones from control points of
/// their own where there are such.
#[inline(always)]
fn quartic<T: Real, const R: usize>(panel: &Panel<T>, fine: Option<(Fine, &Panel<T>)>, s: T, t: T) -> [Part<T>; R] {
    let mut values = [[T::default(); PART]; R];
    let [value, first, bend] = horner(panel, s, t);
    values[0] = value[0];
    if R > 1 {
        (values[1], values[2]) = (value[1], first[0]);
    }
    if R > 3 {
        let [value, first, bend] = match fine {
            Some((_, finer)) => horner(finer, s, t),
            None => [value, first, bend],
        };
        (values[3], values[4], values[5]) = (value[2], first[1], bend[0]);
    }
    values
}

/// The derivatives of a quartic: entry `[i][j]` is `i` times in t and `j` times in s, up to the second.
#[inline(always)]
fn horner<T: Real>(panel: &Panel<T>, s: T, t: T) -> [[Part<T>; 3]; 3] {
    const FIRST: [usize; 5] = [0, 5, 9, 12, 14];
    let two = T::from_f64(2.0);
    let mut out = [[[T::default(); PART]; 3]; 3];
    for p in [4, 3, 2, 1, 0] {
        // The polynomial in t that stands at s^p.
        let mut column = [[T::default(); PART]; 3];
        for q in [4, 3, 2, 1, 0] {
            if p + q <= 4 {
                let k = FIRST[p] + q;
                for c in 0..PART {
                    column[2][c] = column[2][c] * t + two * column[1][c];
                    column[1][c] = column[1][c] * t + column[0][c];
                    column[0][c] = column[0][c] * t + panel[k / 4][4 * (k % 4) + c];
                }
            }
        }
        for i in 0..3 {
            for c in 0..PART {
                out[i][2][c] = out[i][2][c] * s + two * out[i][1][c];
                out[i][1][c] = out[i][1][c] * s + out[i][0][c];
                out[i][0][c] = out[i][0][c] * s + column[i][c];
            }
        }
    }
    out
}
