//! Deflated powers: the closed form in the depth at a special vertex.
//!
//! With `l` the left eigenvector of the local step `A` for eigenvalue 1 (the limit position mask) and `λ` the size of the
//! next eigenvalue,
//!
//! ```text
//!   R = (A - 1 lᵀ) / λ,     A^m = 1 lᵀ + λ^m R^m   (m ≥ 1)
//! ```
//!
//! `R^m` is a product of at most eleven stored matrices `R^(2^k)`, each made when it is first needed: what is tessellated
//! needs two or three. There are no eigenvectors, Jordan blocks or
//! tolerances; positions and first derivatives are accurate to rounding at every depth, because neither the constant
//! part nor the factor `λ^m` ever mixes with the rest. Above [`DENSE_LIMIT`] points the powers are not stored: one
//! sparse step costs `7 K`, and `m` of them undercut a few dense products of `K²`; deep locations there go by the
//! eigenbasis instead (see [`special`](super::special)).

use super::rows::Rows;
use std::sync::OnceLock;

/// Most points for which powers are stored. Larger: a pole of valence `n` costs `n³` to build; smaller: evaluation next
/// to valence 20 takes time proportional to the depth. Chosen on `shapes::interior_vertex(n)`, where the two cost the
/// same at depth 25 for 60 points.
pub(crate) const DENSE_LIMIT: usize = 64;

/// Depths are below 1075: the smallest positive `f64` is `2^-1074`.
const BITS: usize = 11;

/// `A - Σ_i w_i r_i l_iᵀ`, divided by `scale`, and its powers.
#[derive(Clone, Debug)]
pub(crate) struct DeflatedPowers {
    /// `λ`.
    pub scale: f64,
    /// What is taken out of `A`: `(w, r, l)`, eigenvalue and its right and left eigenvectors with `l·r = 1`.
    modes: Vec<(f64, Vec<f64>, Vec<f64>)>,
    /// `R^(2^k)` where powers are stored at all, from the first need on.
    powers: Option<Box<[OnceLock<Vec<f64>>; BITS]>>,
}

impl DeflatedPowers {
    pub fn new(a: &Rows, scale: f64, modes: Vec<(f64, Vec<f64>, Vec<f64>)>) -> Self {
        let powers = (a.len() <= DENSE_LIMIT).then(Box::default);
        Self { scale, modes, powers }
    }

    /// `R^(2^bit)`.
    fn power<'a>(&self, a: &Rows, powers: &'a [OnceLock<Vec<f64>>; BITS], bit: usize) -> &'a [f64] {
        let k = a.len();
        powers[bit].get_or_init(|| {
            if bit > 0 {
                return square(self.power(a, powers, bit - 1), k);
            }
            let unit = |i: usize| (0..k).map(|j| f64::from(u8::from(i == j))).collect::<Vec<f64>>();
            (0..k).flat_map(|i| self.sparse_step(a, &unit(i))).collect()
        })
    }

    /// True where powers are stored, and a depth costs at most eleven products.
    pub fn is_stored(&self) -> bool {
        self.powers.is_some()
    }

    /// `row · R`.
    fn sparse_step(&self, a: &Rows, row: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; row.len()];
        a.left_multiply(row, &mut out);
        for (w, r, l) in &self.modes {
            let part: f64 = w * row.iter().zip(r).map(|(x, y)| x * y).sum::<f64>();
            out.iter_mut().zip(l).for_each(|(o, l)| *o -= part * l);
        }
        out.iter_mut().for_each(|o| *o /= self.scale);
        out
    }

    /// `row · R^m` in place.
    pub fn apply(&self, a: &Rows, m: u32, row: &mut Vec<f64>) {
        let Some(powers) = &self.powers else {
            for _ in 0..m {
                *row = self.sparse_step(a, row);
            }
            return;
        };
        let k = row.len();
        for bit in (0..BITS).filter(|bit| m >> bit & 1 == 1) {
            let power = self.power(a, powers, bit);
            let mut out = vec![0.0; k];
            for (w, line) in row.iter().zip(power.chunks_exact(k)) {
                if *w != 0.0 {
                    out.iter_mut().zip(line).for_each(|(o, x)| *o += w * x);
                }
            }
            *row = out;
        }
    }

    /// Heap memory in bytes, by now.
    pub fn bytes(&self) -> usize {
        let modes: usize = self.modes.iter().map(|m| 8 * (m.1.len() + m.2.len())).sum();
        let powers = self.powers.iter().flat_map(|powers| powers.iter());
        modes + powers.map(|p| size_of_val(p) + p.get().map_or(0, |p| 8 * p.len())).sum::<usize>()
    }
}

fn square(a: &[f64], k: usize) -> Vec<f64> {
    let mut c = vec![0.0; k * k];
    for i in 0..k {
        let out = &mut c[i * k..(i + 1) * k];
        for j in 0..k {
            let w = a[i * k + j];
            if w != 0.0 {
                out.iter_mut().zip(&a[j * k..(j + 1) * k]).for_each(|(o, x)| *o += w * x);
            }
        }
    }
    c
}
