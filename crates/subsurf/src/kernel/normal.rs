//! Unit normals of a block of samples from their derivatives.

use super::LANES;
use crate::real::Real;

/// Squared sine of the angle between the derivatives below which their cross product has lost too many digits: what
/// rounding leaves of a normal is the weights' precision over the sine. Larger: more samples for the careful way; smaller:
/// at 1e-4, normals in `f32` keep four digits.
const LEAST_SINE_SQ: f64 = 1e-4;

/// `du × dv` at unit length, component by component; and the samples, as bits, where that cannot be told with certainty:
/// derivatives nearly parallel, zero, or beyond the range of squares. Their normals are to be had otherwise.
#[inline(always)]
pub(crate) fn unit_normals<T: Real>(du: &[[T; LANES]], dv: &[[T; LANES]]) -> ([[T; LANES]; 3], u32) {
    let (least, smallest) = (T::from_f64(LEAST_SINE_SQ), T::SMALLEST_SQUARE);
    let mut normals = [[T::default(); LANES]; 3];
    let mut sure = [false; LANES];
    for k in 0..LANES {
        let (a, b) = ([du[0][k], du[1][k], du[2][k]], [dv[0][k], dv[1][k], dv[2][k]]);
        let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let square = |v: [T; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let n_sq = square(n);
        // Also false where something is not finite.
        sure[k] = (n_sq > least * (square(a) * square(b))) & (n_sq > smallest);
        let scale = n_sq.root().inverse();
        for c in 0..3 {
            normals[c][k] = n[c] * scale;
        }
    }
    let mut unsure = 0;
    for k in 0..LANES {
        unsure |= u32::from(!sure[k]) << k;
    }
    (normals, unsure)
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
                let (normals, unsure) = unit_normals(&du, &dv);
                for k in (0..LANES).filter(|k| unsure >> k & 1 == 0) {
                    let [a, b] = [&du, &dv].map(|d| [0, 1, 2].map(|c| d[c][k].to_f64()));
                    let exact = crate::limit::unit_normal(a, b).unwrap();
                    for c in 0..3 {
                        // Each product of the cross product is off by its rounding, the sine being 0.01 at least.
                        let off = (normals[c][k].to_f64() - exact[c]).abs();
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
    fn parallel_and_zero_derivatives_are_reported() {
        let du = [[1.0f32; LANES], [2.0; LANES], [3.0; LANES]];
        let mut dv = du;
        dv[0][5] = 9.0;
        dv[2][7] = f32::NAN;
        assert_eq!(unit_normals(&du, &dv).1, !(1 << 5) & 0xffff);
        assert_eq!(unit_normals(&[[0.0f64; LANES]; 3], &[[1.0; LANES]; 3]).1, 0xffff);
    }
}
