//! Unit normals of a block of samples from their derivatives.

use super::{LANES, level};
use crate::real::Real;
use fearless_simd::{Simd, dispatch};

/// Square of the least part of the control points' extent that counts as a derivative, or as the part of one that is
/// perpendicular to the other: what rounding leaves of a normal is the weights' precision over that part. Larger: more
/// samples for the careful way, those of faces drawn out to more than 1 : 250 first; smaller: at 1.6e-5, normals in `f32`
/// keep four digits.
const LEAST_SQ: f64 = 1.6e-5;

/// `du × dv` at unit length, component by component; and the samples, as bits, where that cannot be told with certainty:
/// derivatives nearly parallel, next to nothing beside the control points' `extent`, or beyond the range of squares. Their
/// normals are to be had otherwise.
#[inline(always)]
pub(super) fn unit_normals<T: Real, S: Simd>(
    simd: S,
    a: [T::Block<S>; 3],
    b: [T::Block<S>; 3],
    extent: T::Block<S>,
) -> ([T::Block<S>; 3], u32) {
    let n = [minor::<T, S>(simd, a, b, 1, 2), minor::<T, S>(simd, a, b, 2, 0), minor::<T, S>(simd, a, b, 0, 1)];
    let n_sq = square::<T, S>(simd, n);
    // |a × b| > least · extent · (|a|, |b|): what is perpendicular to the longer one is large enough.
    let longest = T::plus(simd, square::<T, S>(simd, a), square::<T, S>(simd, b));
    let part = T::times(simd, T::splat(simd, T::from_f64(LEAST_SQ)), T::times(simd, extent, extent));
    let least = T::times(simd, part, longest);
    // Also false where something is not a number, or all are infinite.
    let sure = T::above(simd, n_sq, least) & T::above(simd, n_sq, T::splat(simd, T::SMALLEST_SQUARE));
    let scale = T::inverse_root(simd, n_sq);
    (
        [T::times(simd, n[0], scale), T::times(simd, n[1], scale), T::times(simd, n[2], scale)],
        !sure & ((1 << LANES) - 1),
    )
}

#[inline(always)]
fn minor<T: Real, S: Simd>(simd: S, a: [T::Block<S>; 3], b: [T::Block<S>; 3], i: usize, j: usize) -> T::Block<S> {
    T::minus(simd, T::times(simd, a[i], b[j]), T::times(simd, a[j], b[i]))
}

#[inline(always)]
fn square<T: Real, S: Simd>(simd: S, v: [T::Block<S>; 3]) -> T::Block<S> {
    let [x, y, z] = [T::times(simd, v[0], v[0]), T::times(simd, v[1], v[1]), T::times(simd, v[2], v[2])];
    T::plus(simd, T::plus(simd, x, y), z)
}

#[inline(always)]
fn load<T: Real, S: Simd>(simd: S, v: &[[T; LANES]; 3]) -> [T::Block<S>; 3] {
    [T::load(simd, &v[0]), T::load(simd, &v[1]), T::load(simd, &v[2])]
}

/// The same from memory, to samples side by side.
pub(crate) fn unit_normals_of<T: Real>(
    du: &[[T; LANES]; 3],
    dv: &[[T; LANES]; 3],
    extent: &[T; LANES],
    out: &mut [[T; 3]; LANES],
) -> u32 {
    dispatch!(level(), simd => simd.vectorize(
        #[inline(always)]
        || {
            let (unit, unsure) = unit_normals::<T, _>(simd, load::<T, _>(simd, du), load::<T, _>(simd, dv), T::load(simd, extent));
            T::store_xyz(simd, unit, out);
            unsure
        }
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_are_exact_to_rounding_or_reported() {
        fn check<T: Real>(rounding: f64) {
            let at = |k: usize, c: usize, s: f64| (1.3 * k as f64 + 2.1 * c as f64 + s).sin();
            for size in [1e-200, 1e-20, 1e-6, 1.0, 1e6, 1e20, 1e200] {
                let [du, dv] = [0.0, 0.7].map(|s| -> [[T; LANES]; 3] {
                    std::array::from_fn(|c| std::array::from_fn(|k| T::from_f64(size * at(k, c, s))))
                });
                let mut normals = [[T::default(); 3]; LANES];
                let unsure = unit_normals_of(&du, &dv, &[T::from_f64(3.0 * size); LANES], &mut normals);
                for k in (0..LANES).filter(|k| unsure >> k & 1 == 0) {
                    let [a, b] = [&du, &dv].map(|d| [0, 1, 2].map(|c| d[c][k].to_f64()));
                    let exact = crate::limit::unit_normal(a, b).unwrap();
                    for c in 0..3 {
                        // Each product of the cross product is off by its rounding, and the lengths' product is at
                        // most 80 times as large as it.
                        let off = (normals[k][c].to_f64() - exact[c]).abs();
                        assert!(off < 400.0 * rounding, "size {size:e} sample {k}: off by {off:e}");
                    }
                }
                if (1e-6..1e7).contains(&size) {
                    assert_eq!(unsure, 0, "nothing is wrong with derivatives of size {size:e}");
                }
            }
        }
        check::<f32>(f64::from(f32::EPSILON));
        check::<f64>(f64::EPSILON);
    }

    #[test]
    fn parallel_and_vanishing_derivatives_are_reported() {
        let du = [[1.0f32; LANES], [2.0; LANES], [3.0; LANES]];
        let mut dv = du;
        dv[0][5] = 9.0;
        dv[2][7] = f32::NAN;
        assert_eq!(unit_normals_of(&du, &dv, &[1.0; LANES], &mut [[0.0; 3]; LANES]), !(1 << 5) & 0xffff);
        assert_eq!(
            unit_normals_of(&[[0.0f64; LANES]; 3], &[[1.0; LANES]; 3], &[1.0; LANES], &mut [[0.0; 3]; LANES]),
            0xffff
        );
        // Derivatives at right angles that are nothing beside control points a million away.
        let (du, dv) = ([[1.0f64; LANES], [0.0; LANES], [0.0; LANES]], [[0.0; LANES], [1.0; LANES], [0.0; LANES]]);
        assert_eq!(unit_normals_of(&du, &dv, &[1e6; LANES], &mut [[0.0; 3]; LANES]), 0xffff);
        assert_eq!(unit_normals_of(&du, &dv, &[10.0; LANES], &mut [[0.0; 3]; LANES]), 0);
    }
}
