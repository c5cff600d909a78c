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

use super::local_step::LocalStep;
use std::sync::OnceLock;

/// Most points for which powers are stored. Larger: a pole of valence `n` costs `n³` to build; smaller: evaluation next
/// to valence 20 takes time proportional to the depth. Chosen on `shapes::interior_vertex(n)`, where the two cost the
/// same at depth 25 for 60 points.
pub(crate) const DENSE_LIMIT: usize = 64;

/// Depths are below 1075: the smallest positive `f64` is `2^-1074`.
const BITS: usize = 11;

/// The matrix whose powers are wanted, and its left eigenvector for the eigenvalue 1.
#[derive(Clone, Copy)]
pub(crate) struct Deflated<'a> {
    /// `A`.
    pub step: &'a LocalStep,
    /// `l`, over the points of the ring: the others have no weight.
    pub limit: &'a [f64],
}

/// `A - 1 lᵀ`, less other modes, divided by `scale`, and its powers.
#[derive(Clone, Debug)]
pub(crate) struct DeflatedPowers {
    /// `λ`.
    pub scale: f64,
    /// What else is taken out of `A`: right and left eigenvectors `r`, `l` of the eigenvalue 1/2, with `l·r = 1`.
    linear: Vec<(Vec<f64>, Vec<f64>)>,
    is_stored: bool,
    /// `R^(2^k)` where powers are stored at all, from the first need on.
    powers: OnceLock<Box<Powers>>,
}

type Powers = [OnceLock<Vec<f64>>; BITS];

impl DeflatedPowers {
    /// Those of a matrix over so many points.
    pub fn new(points: usize, scale: f64, linear: Vec<(Vec<f64>, Vec<f64>)>) -> Self {
        Self { scale, linear, is_stored: points <= DENSE_LIMIT, powers: OnceLock::new() }
    }

    /// `R^(2^bit)`.
    fn power<'a>(&self, of: Deflated<'_>, powers: &'a Powers, bit: usize) -> &'a [f64] {
        let k = of.step.points;
        powers[bit].get_or_init(|| {
            if bit > 0 {
                return square(self.power(of, powers, bit - 1), k);
            }
            let unit = |i: usize| (0..k).map(|j| f64::from(u8::from(i == j))).collect::<Vec<f64>>();
            (0..k).flat_map(|i| self.sparse_step(of, &unit(i))).collect()
        })
    }

    /// True where powers are stored, and a depth costs at most eleven products.
    pub fn is_stored(&self) -> bool {
        self.is_stored
    }

    /// `row · R`.
    fn sparse_step(&self, Deflated { step, limit }: Deflated<'_>, row: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; row.len()];
        step.left_multiply(row, &mut out);
        let mut take_out = |part: f64, l: &[f64]| out.iter_mut().zip(l).for_each(|(o, l)| *o -= part * l);
        take_out(row.iter().sum(), limit);
        for (r, l) in &self.linear {
            take_out(0.5 * row.iter().zip(r).map(|(x, y)| x * y).sum::<f64>(), l);
        }
        out.iter_mut().for_each(|o| *o /= self.scale);
        out
    }

    /// `row · R^m` in place.
    pub fn apply(&self, of: Deflated<'_>, m: u32, row: &mut Vec<f64>) {
        if !self.is_stored {
            for _ in 0..m {
                *row = self.sparse_step(of, row);
            }
            return;
        }
        let powers = self.powers.get_or_init(Box::default);
        let k = row.len();
        for bit in (0..BITS).filter(|bit| m >> bit & 1 == 1) {
            let power = self.power(of, powers, bit);
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
        let linear: usize = self.linear.iter().map(|(r, l)| size_of_val(&r[..]) + size_of_val(&l[..])).sum();
        let powers = self.powers.get().into_iter().flat_map(|powers| powers.iter());
        linear + powers.map(|p| size_of_val(p) + p.get().map_or(0, |p| size_of_val(&p[..]))).sum::<usize>()
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
