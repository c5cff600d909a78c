//! Uniform cubic B-splines, and the 4×4 control points of a bicubic patch.
//!
//! ```text
//!   v=2   12   13   14   15        control point 4 (y + 1) + (x + 1) lies at (x, y);
//!   v=1    8    9---10   11        the patch is the square 5 6 10 9:
//!   v=0    4    5----6    7        (u,v) = (0,0) near 5, (1,0) near 6,
//!   v=-1   0    1    2    3        (1,1) near 10, (0,1) near 9
//! ```

use crate::real::Real;

/// Curve weights as polynomials in `x = t` or `x = 1 - t`, control point by control point, so that a loop over lanes does one
/// thing in all of them: `a + x² (b + c x)`, its derivative in t `x (d + e x)` and second derivative `f + g x`.
struct Weights {
    /// `x` at `t = 0`, and how it grows.
    pub x: [[f64; 4]; 2],
    pub value: [[f64; 4]; 3],
    pub slope: [[f64; 4]; 2],
    pub bend: [[f64; 4]; 2],
}

/// `-0` is what adds nothing, to any number and for the compiler too.
const WEIGHTS: Weights = Weights {
    x: [[1.0, -0.0, 1.0, -0.0], [-1.0, 1.0, -1.0, 1.0]],
    value: [[-0.0, 2.0 / 3.0, 2.0 / 3.0, -0.0], [-0.0, -1.0, -1.0, -0.0], [1.0 / 6.0, 0.5, 0.5, 1.0 / 6.0]],
    slope: [[-0.0, -2.0, 2.0, -0.0], [-0.5, 1.5, -1.5, 0.5]],
    bend: [[-0.0, -2.0, -2.0, -0.0], [1.0, 3.0, 3.0, 1.0]],
};

/// Weight of control point `i` at `t`: value, first and second derivative.
#[inline(always)]
fn weight<T: Real>(t: T, i: usize) -> [T; 3] {
    // Constants one by one: closures are not compiled for the machine's own vectors.
    let Weights { x, value: [a, b, c], slope: [d, e], bend: [f, g] } = WEIGHTS;
    let x = T::from_f64(x[0][i]) + T::from_f64(x[1][i]) * t;
    [
        T::from_f64(a[i]) + x * x * (T::from_f64(b[i]) + T::from_f64(c[i]) * x),
        x * (T::from_f64(d[i]) + T::from_f64(e[i]) * x),
        T::from_f64(f[i]) + T::from_f64(g[i]) * x,
    ]
}

/// Weights of position, first and second derivative at `t` in `[0, 1]` over four consecutive control points.
#[inline(always)]
pub(crate) fn cubic<T: Real>(t: T) -> [[T; 4]; 3] {
    let mut weights = [[T::default(); 4]; 3];
    for i in 0..4 {
        let at = weight(t, i);
        for order in 0..3 {
            weights[order][i] = at[order];
        }
    }
    weights
}

/// Which derivative: (times in u, times in v), in the order in which jets store them.
pub(crate) const ORDERS: [(usize, usize); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];

/// Tensor products of curve weights `across` (u) and `along` (v), for the first `count` entries of [`ORDERS`].
pub(crate) fn tensor(u: &[[f64; 4]; 3], v: &[[f64; 4]; 3], count: usize) -> [[f64; 16]; 6] {
    let mut weights = [[0.0; 16]; 6];
    for (row, &(du, dv)) in weights.iter_mut().zip(&ORDERS).take(count) {
        for y in 0..4 {
            for x in 0..4 {
                row[4 * y + x] = u[du][x] * v[dv][y];
            }
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_and_derivative_weights_to_zero() {
        for i in 0..=64 {
            let [p, d, dd] = cubic(f64::from(i) / 64.0);
            assert!((p.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            assert!(d.iter().sum::<f64>().abs() < 1e-15 && dd.iter().sum::<f64>().abs() < 1e-15);
        }
    }

    #[test]
    fn cubics_are_reproduced() {
        // The spline with control values (x³ - x) at the integers is x³.
        for i in 0..=16 {
            let t = f64::from(i) / 16.0;
            let [p, d, dd] = cubic(t);
            let sum = |w: [f64; 4]| (0..4).map(|k| w[k] * ((k as f64 - 1.0).powi(3) - (k as f64 - 1.0))).sum::<f64>();
            assert!((sum(p) - t.powi(3)).abs() < 1e-14);
            assert!((sum(d) - 3.0 * t * t).abs() < 1e-14 && (sum(dd) - 6.0 * t).abs() < 1e-14);
        }
    }
}
