//! Bicubic patches in powers of their parameters, which count from the middle: `Σ c_ij s^i t^j` with `s` and `t` in
//! `[-1/2, 1/2]`, so that Horner's rule loses no digits. A curve and its derivatives take fewer operations than weights of
//! control points and sums over them; and what is constant or linear stays out of the coefficients of higher powers.
//!
//! Coefficient `4 j + i` is that of `s^i t^j`; so stand the points of [`bspline`](super::bspline), of which they are made.

use crate::kernel::LANES;
use crate::real::Real;
use fearless_simd::Simd;

/// Where parameters count from.
pub(super) const MIDDLE: f64 = 0.5;

/// Coefficients of a curve over its control points: of the outer two and of the inner two, added up for even powers and
/// subtracted, later less earlier, for odd ones.
const FROM_POINTS: [[f64; 2]; 4] =
    [[1.0 / 48.0, 23.0 / 48.0], [1.0 / 8.0, 5.0 / 8.0], [0.25, -0.25], [1.0 / 6.0, -0.5]];

/// Coefficients of a curve from its control points.
pub(super) fn curve_coefficients(p: [f64; 4]) -> [f64; 4] {
    let sums = [[p[0] + p[3], p[1] + p[2]], [p[3] - p[0], p[2] - p[1]]];
    std::array::from_fn(|k| FROM_POINTS[k][0] * sums[k % 2][0] + FROM_POINTS[k][1] * sums[k % 2][1])
}

/// Coefficients of a patch from its control points.
pub(super) fn coefficients(points: &[f64; LANES]) -> [f64; LANES] {
    let curve = curve_coefficients;
    let rows: [[f64; 4]; 4] = std::array::from_fn(|j| curve(std::array::from_fn(|i| points[4 * j + i])));
    let columns: [[f64; 4]; 4] = std::array::from_fn(|i| curve(std::array::from_fn(|j| rows[j][i])));
    std::array::from_fn(|k| columns[k % 4][k / 4])
}

/// The same of parts of points, row by row: four curves at a time, side by side.
#[inline(always)]
pub(super) fn coefficients_of<T: Real, S: Simd>(simd: S, points: [[T::Four<S>; 4]; 4]) -> [T::Block<S>; 4] {
    let along = curves::<T, S>(simd, columns::<T, S>(simd, points));
    let mut rows = points;
    for k in 0..4 {
        rows[k] = T::parted(simd, along[k]);
    }
    curves::<T, S>(simd, columns::<T, S>(simd, rows))
}

/// The columns of four rows of four parts.
#[inline(always)]
fn columns<T: Real, S: Simd>(simd: S, rows: [[T::Four<S>; 4]; 4]) -> [T::Block<S>; 4] {
    let mut out = [T::splat(simd, T::default()); 4];
    for i in 0..4 {
        out[i] = T::joined(simd, [rows[0][i], rows[1][i], rows[2][i], rows[3][i]]);
    }
    out
}

/// Coefficients of four curves from their control points.
#[inline(always)]
fn curves<T: Real, S: Simd>(simd: S, p: [T::Block<S>; 4]) -> [T::Block<S>; 4] {
    let sums = [
        [T::plus(simd, p[0], p[3]), T::plus(simd, p[1], p[2])],
        [T::minus(simd, p[3], p[0]), T::minus(simd, p[2], p[1])],
    ];
    let mut out = p;
    for k in 0..4 {
        let [outer, inner] = sums[k % 2];
        let [a, b] = FROM_POINTS[k];
        out[k] = T::plus(simd, scaled::<T, S>(simd, a, outer), scaled::<T, S>(simd, b, inner));
    }
    out
}

#[inline(always)]
fn scaled<T: Real, S: Simd>(simd: S, factor: f64, x: T::Block<S>) -> T::Block<S> {
    T::times(simd, T::splat(simd, T::from_f64(factor)), x)
}

/// Powers at `x`: values, first and second derivatives.
pub(super) fn powers(x: f64) -> [[f64; 4]; 3] {
    [[1.0, x, x * x, x * x * x], [0.0, 1.0, 2.0 * x, 3.0 * x * x], [0.0, 0.0, 2.0, 6.0 * x]]
}

/// Value and derivatives of a patch at `(s, t)`: those that rows of `R` vectors have, see
/// [`ORDERS`](super::bspline::ORDERS). Lanes are the components of four coefficients.
#[inline(always)]
pub(super) fn evaluate<T: Real, S: Simd, const R: usize>(
    simd: S,
    rows: &[T::Block<S>; 4],
    s: T,
    t: T,
) -> [T::Four<S>; R] {
    // In t for all four powers of s.
    let [value, slope, bend] = horner_in_blocks::<T, S, R>(simd, *rows, T::splat(simd, t));
    let s = T::four(simd, [s; 4]);
    let along = horner::<T, S, R>(simd, T::parted(simd, value), s);
    let mut out = [along[0]; R];
    if R > 1 {
        let across = horner::<T, S, R>(simd, T::parted(simd, slope), s);
        (out[1], out[2]) = (along[1], across[0]);
        if R > 3 {
            let bend = horner::<T, S, R>(simd, T::parted(simd, bend), s);
            (out[3], out[4], out[5]) = (along[2], across[1], bend[0]);
        }
    }
    out
}

/// The same of component `c` at sixteen places, one a lane, with the same bits; coefficient `4 j + i` is entry `4 i + c` of
/// row `j`.
#[inline(always)]
pub(super) fn evaluate_sixteen<T: Real, S: Simd, const R: usize>(
    simd: S,
    rows: &[[T; LANES]; 4],
    c: usize,
    s: T::Block<S>,
    t: T::Block<S>,
) -> [T::Block<S>; R] {
    let (mut value, mut slope, mut bend) = ([s; 4], [s; 4], [s; 4]);
    for i in 0..4 {
        let mut column = [s; 4];
        for j in 0..4 {
            column[j] = T::splat(simd, rows[j][4 * i + c]);
        }
        [value[i], slope[i], bend[i]] = horner_in_blocks::<T, S, R>(simd, column, t);
    }
    let along = horner_in_blocks::<T, S, R>(simd, value, s);
    let mut out = [along[0]; R];
    if R > 1 {
        let across = horner_in_blocks::<T, S, R>(simd, slope, s);
        (out[1], out[2]) = (along[1], across[0]);
        if R > 3 {
            let bend = horner_in_blocks::<T, S, R>(simd, bend, s);
            (out[3], out[4], out[5]) = (along[2], across[1], bend[0]);
        }
    }
    out
}

/// [`horner`] of sixteen curves at once.
#[inline(always)]
fn horner_in_blocks<T: Real, S: Simd, const R: usize>(
    simd: S,
    c: [T::Block<S>; 4],
    s: T::Block<S>,
) -> [T::Block<S>; 3] {
    let cubic = T::times(simd, c[3], s);
    let above = T::plus(simd, cubic, c[2]);
    let below = T::plus(simd, T::times(simd, above, s), c[1]);
    let value = T::plus(simd, T::times(simd, below, s), c[0]);
    let mut out = [value; 3];
    if R > 1 {
        let twice = T::plus(simd, cubic, above);
        out[1] = T::plus(simd, T::times(simd, twice, s), below);
        if R > 3 {
            let half = T::plus(simd, cubic, twice);
            out[2] = T::plus(simd, half, half);
        }
    }
    out
}

/// Value and derivatives of a curve, as many as rows of `R` vectors need.
#[inline(always)]
fn horner<T: Real, S: Simd, const R: usize>(simd: S, c: [T::Four<S>; 4], s: T::Four<S>) -> [T::Four<S>; 3] {
    let cubic = T::four_times(simd, c[3], s);
    let above = T::four_plus(simd, cubic, c[2]);
    let below = T::four_plus(simd, T::four_times(simd, above, s), c[1]);
    let value = T::four_plus(simd, T::four_times(simd, below, s), c[0]);
    let mut out = [value; 3];
    if R > 1 {
        let twice = T::four_plus(simd, cubic, above);
        out[1] = T::four_plus(simd, T::four_times(simd, twice, s), below);
        if R > 3 {
            let half = T::four_plus(simd, cubic, twice);
            out[2] = T::four_plus(simd, half, half);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::{Part, PartLanes, level};
    use crate::limit::bspline::{cubic, tensor};
    use fearless_simd::dispatch;

    #[test]
    fn powers_give_the_patch_of_the_control_points() {
        let points: [f64; LANES] = std::array::from_fn(|k| ((7 * k + 3) % 16) as f64 / 8.0 - 1.0);
        let own = coefficients(&points);
        let parts = |i: usize| [points[i], -points[i], 1.0, 0.0];
        for (s, t) in [(0.0, 0.0), (1.0, 0.0), (0.25, 1.0), (0.6, 0.3)] {
            let expected = tensor(&cubic(s), &cubic(t), 6).map(|w| (0..16).map(|k| w[k] * points[k]).sum::<f64>());
            let (s, t) = (s - MIDDLE, t - MIDDLE);
            let by_basis = tensor(&powers(s), &powers(t), 6).map(|w| (0..16).map(|k| w[k] * own[k]).sum::<f64>());
            let by_vectors: [Part<f64>; 6] = dispatch!(level(), simd => {
                let points = std::array::from_fn(|j| std::array::from_fn(|i| f64::four(simd, parts(4 * j + i))));
                evaluate::<f64, _, 6>(simd, &coefficients_of::<f64, _>(simd, points), s, t).map(|x| f64::part(simd, x))
            });
            for order in 0..6 {
                // Some forty operations on numbers up to 10.
                let [x, y, one, zero] = by_vectors[order];
                assert!((by_basis[order] - expected[order]).abs() < 1e-13);
                assert!((x - expected[order]).abs() < 1e-13 && x == -y && zero == 0.0);
                assert!((one - if order == 0 { 1.0 } else { 0.0 }).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn sixteen_places_have_the_bits_of_each_by_itself() {
        fn check<T: Real + PartLanes, const R: usize>() {
            let number = |k: usize, m: usize| T::from_f64(((m * k + 5) % 23) as f64 / 23.0 - 0.5);
            let panel: [[T; LANES]; 4] = std::array::from_fn(|j| std::array::from_fn(|k| number(16 * j + k, 7)));
            let (s, t): ([T; LANES], [T; LANES]) =
                (std::array::from_fn(|k| number(k, 3)), std::array::from_fn(|k| number(k, 11)));
            dispatch!(level(), simd => for c in 0..4 {
                let [all_s, all_t] = [T::load(simd, &s), T::load(simd, &t)];
                let all: [[T; LANES]; R] = evaluate_sixteen::<T, _, R>(simd, &panel, c, all_s, all_t).map(|block| {
                    let mut out = [T::default(); LANES];
                    T::store(simd, block, &mut out);
                    out
                });
                for k in 0..LANES {
                    let rows = panel.map(|row| T::load(simd, &row));
                    let alone = evaluate::<T, _, R>(simd, &rows, s[k], t[k]).map(|x| T::part(simd, x)[c]);
                    assert_eq!(all.map(|lanes| lanes[k]), alone);
                }
            });
        }
        check::<f32, 1>();
        check::<f32, 3>();
        check::<f32, 6>();
        check::<f64, 6>();
    }
}
