//! The quartic box spline of Loop subdivision over the regular triangular grid (Stam 1998), and its 12 control points.
//!
//! ```text
//!   v=2    8 --- 11                      the patch is the triangle 3 6 7, in the plane of (u, v), where the grid's
//!          | \   | \                     third direction is (-1, 1)
//!   v=1    4 --- 7 --- 10
//!            \   | \   | \               ring of 3 from 6: 6 7 4 1 0 2
//!   v=0    1 --- 3 --- 6 --- 9           ring of 6 from 7: 7 3 2 5 9 10
//!            \   | \   | \   |           ring of 7 from 3: 3 6 10 11 8 4
//!   v=-1         0 --- 2 --- 5
//!        u=-1    0     1     2
//! ```

use super::bspline::ORDERS;
use std::sync::LazyLock;

/// `(c, i, j, k)`: `c w^i u^j v^k / 12` with `w = 1 - u - v`, for each of the 12 basis functions.
const TERMS: [&[(f64, u8, u8, u8)]; 12] = [
    &[(1.0, 4, 0, 0), (2.0, 3, 1, 0)],
    &[(1.0, 4, 0, 0), (2.0, 3, 0, 1)],
    &[
        (1.0, 4, 0, 0),
        (2.0, 3, 0, 1),
        (6.0, 3, 1, 0),
        (6.0, 2, 1, 1),
        (12.0, 2, 2, 0),
        (6.0, 1, 2, 1),
        (6.0, 1, 3, 0),
        (2.0, 0, 3, 1),
        (1.0, 0, 4, 0),
    ],
    &[
        (6.0, 4, 0, 0),
        (24.0, 3, 0, 1),
        (24.0, 2, 0, 2),
        (8.0, 1, 0, 3),
        (1.0, 0, 0, 4),
        (24.0, 3, 1, 0),
        (60.0, 2, 1, 1),
        (36.0, 1, 1, 2),
        (6.0, 0, 1, 3),
        (24.0, 2, 2, 0),
        (36.0, 1, 2, 1),
        (12.0, 0, 2, 2),
        (8.0, 1, 3, 0),
        (6.0, 0, 3, 1),
        (1.0, 0, 4, 0),
    ],
    &[
        (1.0, 4, 0, 0),
        (6.0, 3, 0, 1),
        (12.0, 2, 0, 2),
        (6.0, 1, 0, 3),
        (1.0, 0, 0, 4),
        (2.0, 3, 1, 0),
        (6.0, 2, 1, 1),
        (6.0, 1, 1, 2),
        (2.0, 0, 1, 3),
    ],
    &[(2.0, 1, 3, 0), (1.0, 0, 4, 0)],
    &[
        (1.0, 4, 0, 0),
        (6.0, 3, 0, 1),
        (12.0, 2, 0, 2),
        (6.0, 1, 0, 3),
        (1.0, 0, 0, 4),
        (8.0, 3, 1, 0),
        (36.0, 2, 1, 1),
        (36.0, 1, 1, 2),
        (8.0, 0, 1, 3),
        (24.0, 2, 2, 0),
        (60.0, 1, 2, 1),
        (24.0, 0, 2, 2),
        (24.0, 1, 3, 0),
        (24.0, 0, 3, 1),
        (6.0, 0, 4, 0),
    ],
    &[
        (1.0, 4, 0, 0),
        (8.0, 3, 0, 1),
        (24.0, 2, 0, 2),
        (24.0, 1, 0, 3),
        (6.0, 0, 0, 4),
        (6.0, 3, 1, 0),
        (36.0, 2, 1, 1),
        (60.0, 1, 1, 2),
        (24.0, 0, 1, 3),
        (12.0, 2, 2, 0),
        (36.0, 1, 2, 1),
        (24.0, 0, 2, 2),
        (6.0, 1, 3, 0),
        (8.0, 0, 3, 1),
        (1.0, 0, 4, 0),
    ],
    &[(2.0, 1, 0, 3), (1.0, 0, 0, 4)],
    &[(2.0, 0, 3, 1), (1.0, 0, 4, 0)],
    &[
        (2.0, 1, 0, 3),
        (1.0, 0, 0, 4),
        (6.0, 1, 1, 2),
        (6.0, 0, 1, 3),
        (6.0, 1, 2, 1),
        (12.0, 0, 2, 2),
        (2.0, 1, 3, 0),
        (6.0, 0, 3, 1),
        (1.0, 0, 4, 0),
    ],
    &[(1.0, 0, 0, 4), (2.0, 0, 1, 3)],
];

/// `x^p` for p from 0 to 4, each with its first and second derivative.
fn powers(x: f64) -> [[f64; 3]; 5] {
    let (x2, x3) = (x * x, x * x * x);
    [[1.0, 0.0, 0.0], [x, 1.0, 0.0], [x2, 2.0 * x, 2.0], [x3, 3.0 * x2, 6.0 * x], [x2 * x2, 4.0 * x3, 12.0 * x2]]
}

/// Weights for the first `count` entries of [`ORDERS`](super::bspline::ORDERS) over the 12 control points; the last
/// four places stay zero.
pub(crate) fn basis(u: f64, v: f64, count: usize) -> [[f64; 16]; 6] {
    let mut out = [[0.0; 16]; 6];
    let powers = [(1.0 - u) - v, u, v].map(powers);
    for k in 0..TERMS.len() {
        add_function(k, &powers, count, &mut out);
    }
    out
}

/// The same for the functions in `some` alone; those of the others stay zero.
pub(crate) fn some_of_basis(some: &[usize], u: f64, v: f64, count: usize) -> [[f64; 16]; 6] {
    let mut out = [[0.0; 16]; 6];
    let powers = [(1.0 - u) - v, u, v].map(powers);
    some.iter().for_each(|&k| add_function(k, &powers, count, &mut out));
    out
}

/// Where the powers of [`POLYNOMIALS`] are centred, so that they stay small all over the triangle.
pub(crate) const CENTRE: f64 = 1.0 / 3.0;

/// Number of powers `x^p y^q` up to the fourth degree.
pub(crate) const POWERS: usize = 15;

/// Exponents of the powers, by rising p: 1, y .. y⁴, x, xy .. xy³, x², ..
pub(crate) const EXPONENTS: [(usize, usize); POWERS] = {
    let mut all = [(0, 0); POWERS];
    let (mut k, mut p) = (0, 0);
    while p <= 4 {
        let mut q = 0;
        while p + q <= 4 {
            all[k] = (p, q);
            k += 1;
            q += 1;
        }
        p += 1;
    }
    all
};

/// The basis functions as polynomials in `x = u - 1/3` and `y = v - 1/3`: coefficient of every power in every function.
pub(crate) static POLYNOMIALS: LazyLock<[[f64; 12]; POWERS]> = LazyLock::new(|| {
    let mut out = [[0.0; 12]; POWERS];
    let factors = [[CENTRE, -1.0, -1.0], [CENTRE, 1.0, 0.0], [CENTRE, 0.0, 1.0]];
    for (function, terms) in TERMS.iter().enumerate() {
        for &(c, i, j, k) in *terms {
            // One factor after the other: constant, x and y times what is there.
            let mut product = [[0.0; 6]; 6];
            product[0][0] = c / 12.0;
            for (factor, times) in factors.iter().zip([i, j, k]) {
                for _ in 0..times {
                    for p in (0..=4).rev() {
                        for q in (0..=4 - p).rev() {
                            let before = product[p][q];
                            product[p + 1][q] += factor[1] * before;
                            product[p][q + 1] += factor[2] * before;
                            product[p][q] = factor[0] * before;
                        }
                    }
                }
            }
            for (row, &(p, q)) in out.iter_mut().zip(&EXPONENTS) {
                row[function] += product[p][q];
            }
        }
    }
    out
});

/// The powers at `(x, y)`, and their derivatives: the first `count` entries of [`ORDERS`](super::bspline::ORDERS).
pub(crate) fn powers_at(x: f64, y: f64, count: usize) -> [[f64; 16]; 6] {
    let mut out = [[0.0; 16]; 6];
    let (x, y) = (powers(x), powers(y));
    for (row, &(i, j)) in out.iter_mut().zip(&ORDERS).take(count) {
        for (k, &(p, q)) in EXPONENTS.iter().enumerate() {
            row[k] = x[p][i] * y[q][j];
        }
    }
    out
}

/// Adds function `k` from the powers of `w`, `u`, `v`.
fn add_function(k: usize, [w, u, v]: &[[[f64; 3]; 5]; 3], count: usize, out: &mut [[f64; 16]; 6]) {
    for &(c, i, j, l) in TERMS[k] {
        let (w, u, v) = (&w[usize::from(i)], &u[usize::from(j)], &v[usize::from(l)]);
        let c = c / 12.0;
        out[0][k] += c * w[0] * u[0] * v[0];
        if count > 1 {
            out[1][k] += c * (w[0] * u[1] - w[1] * u[0]) * v[0];
            out[2][k] += c * (w[0] * v[1] - w[1] * v[0]) * u[0];
        }
        if count > 3 {
            out[3][k] += c * (w[2] * u[0] - 2.0 * w[1] * u[1] + w[0] * u[2]) * v[0];
            out[4][k] += c * (w[2] * u[0] * v[0] - w[1] * (u[1] * v[0] + u[0] * v[1]) + w[0] * u[1] * v[1]);
            out[5][k] += c * (w[2] * v[0] - 2.0 * w[1] * v[1] + w[0] * v[2]) * u[0];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the control points lie in (u, v).
    const GRID: [[f64; 2]; 12] = [
        [0.0, -1.0],
        [-1.0, 0.0],
        [1.0, -1.0],
        [0.0, 0.0],
        [-1.0, 1.0],
        [2.0, -1.0],
        [1.0, 0.0],
        [0.0, 1.0],
        [-1.0, 2.0],
        [2.0, 0.0],
        [1.0, 1.0],
        [0.0, 2.0],
    ];

    #[test]
    fn weights_sum_to_one_and_linear_functions_are_reproduced() {
        let (o, e, f) = ([0.0, 0.0], [1.0, 0.0], [0.0, 1.0]);
        for i in 0..=8 {
            for j in 0..=8 - i {
                let (u, v) = (f64::from(i) / 8.0, f64::from(j) / 8.0);
                let w = basis(u, v, 6);
                let sum =
                    |row: usize, g: &dyn Fn([f64; 2]) -> f64| -> f64 { (0..12).map(|k| w[row][k] * g(GRID[k])).sum() };
                assert!((sum(0, &|_| 1.0) - 1.0).abs() < 1e-14);
                (1..6).for_each(|row| assert!(sum(row, &|_| 1.0).abs() < 1e-13));
                for axis in 0..2 {
                    let at = o[axis] + u * e[axis] + v * f[axis];
                    assert!((sum(0, &|p| p[axis]) - at).abs() < 1e-14);
                    assert!((sum(1, &|p| p[axis]) - e[axis]).abs() < 1e-13);
                    assert!((sum(2, &|p| p[axis]) - f[axis]).abs() < 1e-13);
                    (3..6).for_each(|row| assert!(sum(row, &|p| p[axis]).abs() < 1e-12));
                }
            }
        }
    }

    #[test]
    fn polynomials_are_the_basis() {
        for (u, v) in [(0.2, 0.3), (0.1, 0.7), (0.0, 0.0), (1.0, 0.0), (0.0, 1.0)] {
            let basis = basis(u, v, 1)[0];
            for k in 0..12 {
                let power = |(p, q): (usize, usize)| (u - CENTRE).powi(p as i32) * (v - CENTRE).powi(q as i32);
                let sum: f64 = POLYNOMIALS.iter().zip(EXPONENTS).map(|(row, e)| row[k] * power(e)).sum();
                // Fifteen terms of size below 1.
                assert!((sum - basis[k]).abs() < 2e-15, "function {k} at {u}, {v}");
            }
        }
    }

    #[test]
    fn derivatives_match_differences() {
        let h = 1e-5;
        for (u, v) in [(0.2, 0.3), (0.1, 0.7), (0.5, 0.25)] {
            let w = basis(u, v, 6);
            for (row, of, axis) in [(1, 0, 0), (2, 0, 1), (3, 1, 0), (4, 1, 1), (4, 2, 0), (5, 2, 1)] {
                let step = if axis == 0 { (h, 0.0) } else { (0.0, h) };
                let (plus, minus) = (basis(u + step.0, v + step.1, 6), basis(u - step.0, v - step.1, 6));
                for k in 0..12 {
                    let difference = (plus[of][k] - minus[of][k]) / (2.0 * h);
                    assert!((w[row][k] - difference).abs() < 1e-8, "row {row} point {k}");
                }
            }
        }
    }
}
