//! Jordan blocks of S, the ring's own block, in closed form.
//!
//! A wave of angle θ from one edge of the ring to the next, d = cos(θ/2), has `e_i ~ sin or cos(i θ)` and
//! `f_i ~ α sin or cos((i + 1/2) θ)` with `α = ±√(4 + d²) - d` and eigenvalue `λ = ((√(4 + d²) ± d) / 4)²`. The product
//! of the two eigenvalues is 1/16, that of the two α is -4. In the weights 1 for `e_i` and 1/4 for `f_i`, S is symmetric
//! on the waves, so they are their own duals.
//!
//! Smooth: θ = 2π j / n, cosines and sines, and three modes with one value each at v, all `e_i`, all `f_i`.
//! Sector of k faces: θ = π j / k, sines, and the three modes of the curve (e_0, v, e_k), which drive the waves inside.

use std::f64::consts::PI;

/// A Jordan block over the ring: columns of U0, the eigenvector last, and the rows of its inverse.
pub(super) struct RingBlock {
    pub(super) eigenvalue: f64,
    pub(super) right: Vec<Vec<f64>>,
    pub(super) left: Vec<Vec<f64>>,
}

impl RingBlock {
    fn simple(eigenvalue: f64, right: Vec<f64>, left: Vec<f64>) -> Self {
        Self { eigenvalue, right: vec![right], left: vec![left] }
    }
}

/// The blocks of a smooth vertex of valence `n`, all of size 1 (Stam 1998): S is symmetric in the weights n² : 4 : 1 for
/// v, `e_i`, `f_i`.
pub(super) fn smooth(n: usize) -> Vec<RingBlock> {
    let mut blocks = constant_modes(n);
    for j in 1..=n / 2 {
        for sign in signs(2 * j, n) {
            for shift in [n, 0] {
                // cos(x) = sin(x + π/2); at the highest frequency the cosine lives on the edges, the sine on the faces.
                let wave = Wave::new(2 * j, n, sign, shift);
                let right = wave.fill(2 * n + 1, n, 0..n, 1.0);
                let left = wave.fill(2 * n + 1, n, 0..n, 0.25);
                blocks.push(normalized(wave.eigenvalue, right, left));
            }
        }
    }
    blocks
}

/// The three modes that have one value at v, one at all `e_i` and one at all `f_i`. Eigenvalues 1 and
/// `(3n - 7 ± √(5n² - 30n + 49)) / (8n)`; vectors from the cross product of two rows of the 3 × 3 matrix.
fn constant_modes(n: usize) -> Vec<RingBlock> {
    let valence = n as f64;
    let root = (5.0 * valence * valence - 30.0 * valence + 49.0).sqrt();
    let eigenvalues =
        [1.0, (3.0 * valence - 7.0 + root) / (8.0 * valence), (3.0 * valence - 7.0 - root) / (8.0 * valence)];
    let fill = |v, e, f| {
        let mut x = vec![v];
        for _ in 0..n {
            x.extend([e, f]);
        }
        x
    };
    eigenvalues
        .map(|mu| {
            // The constant as exact ones: its differences are exactly 0.
            let (v, e, f) = if mu == 1.0 {
                (1.0, 1.0, 1.0)
            } else {
                ((0.5 - mu) * (0.25 - mu) - 1.0 / 16.0, 3.0 / 8.0 * mu - 1.0 / 16.0, 1.0 / 16.0 + mu / 4.0)
            };
            normalized(mu, fill(v, e, f), fill(v, 4.0 * e / (valence * valence), f / (valence * valence)))
        })
        .into()
}

/// A block whose left vector is known up to its length.
fn normalized(eigenvalue: f64, right: Vec<f64>, mut left: Vec<f64>) -> RingBlock {
    let length = super::dot(&left, &right);
    left.iter_mut().for_each(|x| *x /= length);
    RingBlock::simple(eigenvalue, right, left)
}

/// The blocks of a sector of `k` faces along a smooth curve. `apply` multiplies a ring vector by S.
///
/// Curve modes (v, e_0, e_k): 1; 1/2 with (0, 1, -1); 1/4 with (1, -2, -2).
pub(super) fn crease(k: usize, apply: impl Fn(&[f64]) -> Vec<f64>) -> Vec<RingBlock> {
    let constant = [2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0];
    let modes = [
        CurveMode { eigenvalue: 0.5, symmetric: false, right: [0.0, 1.0, -1.0], left: [0.0, 0.5, -0.5] },
        CurveMode {
            eigenvalue: 0.25,
            symmetric: true,
            right: [1.0, -2.0, -2.0],
            left: [1.0 / 3.0, -1.0 / 6.0, -1.0 / 6.0],
        },
    ];
    sector(k, constant, modes, apply)
}

/// The blocks of a sector of `k` faces at a vertex that stays. `apply` multiplies a ring vector by S.
///
/// Curve modes (v, e_0, e_k): 1; 1/2 with (0, 1, 1) and (0, 1, -1).
pub(super) fn corner(k: usize, apply: impl Fn(&[f64]) -> Vec<f64>) -> Vec<RingBlock> {
    let modes = [
        CurveMode { eigenvalue: 0.5, symmetric: true, right: [0.0, 1.0, 1.0], left: [-1.0, 0.5, 0.5] },
        CurveMode { eigenvalue: 0.5, symmetric: false, right: [0.0, 1.0, -1.0], left: [0.0, 0.5, -0.5] },
    ];
    sector(k, [1.0, 0.0, 0.0], modes, apply)
}

/// An eigenvector of the curve through (v, e_0, e_k), and whether swapping its ends keeps it.
struct CurveMode {
    eigenvalue: f64,
    symmetric: bool,
    right: [f64; 3],
    left: [f64; 3],
}

/// The blocks of a sector: the waves inside, and each curve mode `b` with eigenvalue β, continued into the inside by
/// `x = b + Σ x_j u_j`. S b - β b is `Σ s_j u_j`, so `x_j = s_j / (β - λ_j)`, and at `λ_j = β` the mode `s_j u_j` and x
/// are a chain: `S x = β x + s_j u_j`.
///
/// Only waves of the curve mode's own mirror symmetry are driven (odd j: symmetric). The equality of eigenvalues is exact
/// here: it happens at right angles only, where the closed form has no rounding.
fn sector(k: usize, constant: [f64; 3], curve: [CurveMode; 2], apply: impl Fn(&[f64]) -> Vec<f64>) -> Vec<RingBlock> {
    let len = 2 * k + 2;
    let on_curve = |[v, first, last]: [f64; 3]| {
        let mut x = vec![0.0; len];
        (x[0], x[1], x[len - 1]) = (v, first, last);
        x
    };
    let mut waves = vec![];
    for j in 1..=k {
        for sign in signs(j, k) {
            let wave = Wave::new(j, k, sign, 0);
            let block = normalized(wave.eigenvalue, wave.fill(len, k, 1..k, 1.0), wave.fill(len, k, 1..k, 0.25));
            waves.push((j % 2 == 1, block));
        }
    }

    // A wave's coefficient is its own functional less what the curve modes have of it.
    let constant_left = on_curve(constant);
    for (_, wave) in &mut waves {
        let share: f64 = wave.left[0].iter().sum();
        subtract(&mut wave.left[0], share, &constant_left);
    }
    let mut blocks = vec![RingBlock::simple(1.0, vec![1.0; len], constant_left)];
    for mode in curve {
        let mut x = on_curve(mode.right);
        let left = on_curve(mode.left);
        let mut drive = apply(&x);
        subtract(&mut drive, mode.eigenvalue, &x);
        let mut chained = None;
        for (number, (symmetric, wave)) in waves.iter_mut().enumerate() {
            if *symmetric != mode.symmetric {
                continue;
            }
            // `drive` vanishes on the curve, so the functional already less the constant is as good as its own.
            let source = super::dot(&wave.left[0], &drive);
            if wave.eigenvalue == mode.eigenvalue {
                chained = Some((number, source));
            } else {
                let share = source / (mode.eigenvalue - wave.eigenvalue);
                subtract(&mut x, -share, &wave.right[0]);
                subtract(&mut wave.left[0], share, &left);
            }
        }
        let Some((number, source)) = chained else {
            blocks.push(RingBlock::simple(mode.eigenvalue, x, left));
            continue;
        };
        let (_, mut block) = waves.swap_remove(number);
        block.right[0].iter_mut().for_each(|x| *x *= source);
        block.left[0].iter_mut().for_each(|x| *x /= source);
        block.right.insert(0, x);
        block.left.insert(0, left);
        blocks.push(block);
    }
    blocks.extend(waves.into_iter().map(|(_, wave)| wave));
    blocks
}

/// `x -= factor y`.
fn subtract(x: &mut [f64], factor: f64, y: &[f64]) {
    x.iter_mut().zip(y).for_each(|(x, y)| *x -= factor * y);
}

/// The signs that give different waves of angle π a / b: at π both are the same.
fn signs(a: usize, b: usize) -> impl Iterator<Item = f64> {
    [1.0, -1.0].into_iter().take(if a == b { 1 } else { 2 })
}

/// A wave of angle π a / b: `e_i = sin(π (a i + shift/2) / b)` and `f_i = α sin(π (a (i + 1/2) + shift/2) / b)`.
struct Wave {
    a: usize,
    b: usize,
    shift: usize,
    alpha: f64,
    eigenvalue: f64,
}

impl Wave {
    /// `0 < a <= b`, `sign` 1 or -1.
    fn new(a: usize, b: usize, sign: f64, shift: usize) -> Self {
        let d = cos_pi(a, 2 * b);
        let c = cos_pi(a, b);
        let alpha = sign * (4.0 + d * d).sqrt() - d;
        let larger = (5.0 + c + ((c + 9.0) * (c + 1.0)).sqrt()) / 16.0;
        let eigenvalue = if sign > 0.0 { larger } else { 1.0 / (16.0 * larger) };
        Self { a, b, shift, alpha, eigenvalue }
    }

    /// The wave over the points of a ring: the given edges and all `faces`, the latter times a weight.
    fn fill(&self, len: usize, faces: usize, edges: std::ops::Range<usize>, face_weight: f64) -> Vec<f64> {
        let mut x = vec![0.0; len];
        for i in edges {
            x[1 + 2 * i] = sin_pi(2 * i * self.a + self.shift, 2 * self.b);
        }
        for i in 0..faces {
            x[2 + 2 * i] = face_weight * self.alpha * sin_pi((2 * i + 1) * self.a + self.shift, 2 * self.b);
        }
        x
    }
}

/// `sin(π a / b)`, exact at multiples of a right angle.
fn sin_pi(a: usize, b: usize) -> f64 {
    cos_pi(2 * a + 3 * b, 2 * b)
}

/// `cos(π a / b)`, exact at multiples of a right angle.
fn cos_pi(a: usize, b: usize) -> f64 {
    let a = a % (2 * b);
    let a = a.min(2 * b - a);
    if 2 * a > b {
        -cos_pi(b - a, b)
    } else if 4 * a > b {
        ((b - 2 * a) as f64 / (2 * b) as f64 * PI).sin()
    } else {
        (a as f64 / b as f64 * PI).cos()
    }
}
