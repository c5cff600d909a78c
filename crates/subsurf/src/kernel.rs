//! The loops where the time goes: weights of many samples times the control points of one face, in the caller's precision.
//!
//! They are plain Rust over blocks of [`LANES`] samples, which the compiler turns into vector instructions of the machine that
//! runs them ([`vectorized`]). Every sample's sum is formed in the same order at any vector width, products and sums are rounded one by one
//! (no fused multiply-add), so that all machines give the same bits. Only where the compiler does badly, at bringing the
//! components of a block's samples side by side ([`Lanes::interleave`]), does a machine's own permutation replace them.

use crate::real::Real;
use fearless_simd::{Level, Simd, dispatch};

mod interleave;
mod normal;

pub use interleave::Lanes;
pub(crate) use normal::unit_normals;

/// Samples of a block: one 512-bit vector of `f32`.
pub(crate) const LANES: usize = 16;

/// Runs `work` compiled for the best vector instructions that this machine has. What `work` calls must be
/// `#[inline(always)]`, and so must `work` itself, to be compiled that way.
#[inline(always)]
pub(crate) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    dispatch!(Level::new(), simd => simd.vectorize(work))
}

/// Weights of samples over the points of a ring, in blocks: `blocks[b * points + p][k]` is the weight of point `p` in sample
/// `LANES * b + k`. Zeros fill the last block.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Matrix<T> {
    blocks: Vec<[T; LANES]>,
    points: usize,
    samples: usize,
}

impl<T: Real> Matrix<T> {
    /// `samples` rows over `points` points; `weight(sample, point)` is rounded to `T`.
    pub fn new(samples: usize, points: usize, weight: impl Fn(usize, usize) -> f64) -> Self {
        let block = |b: usize, p: usize| {
            std::array::from_fn(|k| {
                let sample = LANES * b + k;
                T::from_f64(if sample < samples { weight(sample, p) } else { 0.0 })
            })
        };
        let blocks = (0..samples.div_ceil(LANES)).flat_map(|b| (0..points).map(move |p| block(b, p))).collect();
        Self { blocks, points, samples }
    }

    /// Number of rows.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.blocks[..])
    }

    /// `out[i] = base + Σ weight(i, p) · ring[p]`.
    ///
    /// # Panics
    /// If `ring` has not one entry per point.
    #[inline(always)]
    pub fn apply<const N: usize>(&self, ring: &[[T; N]], base: [T; N], out: &mut [[T; N]]) {
        assert_eq!(ring.len(), self.points, "one value per point of the ring");
        for (block, out) in self.blocks.chunks_exact(self.points.max(1)).zip(out.chunks_mut(LANES)) {
            T::interleave(&based(sums(block, ring), base), out);
        }
    }

    /// The weights of block `b`, point by point.
    #[inline(always)]
    pub fn block(&self, b: usize) -> &[[T; LANES]] {
        &self.blocks[b * self.points..(b + 1) * self.points]
    }
}

/// `base` added to every sample.
#[inline(always)]
pub(crate) fn based<T: Real, const N: usize>(mut sums: [[T; LANES]; N], base: [T; N]) -> [[T; LANES]; N] {
    for c in 0..N {
        for k in 0..LANES {
            sums[c][k] = base[c] + sums[c][k];
        }
    }
    sums
}

/// One block's sums, component by component.
#[inline(always)]
pub(crate) fn sums<T: Real, const N: usize>(block: &[[T; LANES]], ring: &[[T; N]]) -> [[T; LANES]; N] {
    let mut sums = [[T::default(); LANES]; N];
    for (weights, point) in block.iter().zip(ring) {
        for c in 0..N {
            for k in 0..LANES {
                sums[c][k] = sums[c][k] + weights[k] * point[c];
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vector_instructions_give_the_bits_of_plain_sums() {
        fn check<T: Real>() {
            let weight = |i: usize, p: usize| ((7 * i + 3 * p) % 11) as f64 / 7.0 - 0.5;
            for (samples, points) in [(1, 1), (16, 5), (49, 16), (64, 23)] {
                let ring: Vec<[T; 3]> =
                    (0..points).map(|p| [0.1, 0.7, -1.3].map(|x| T::from_f64(x * (p as f64 + 0.3)))).collect();
                let base = [1.5, -2.5, 0.1].map(T::from_f64);
                let matrix = Matrix::<T>::new(samples, points, weight);
                let mut out = vec![[T::default(); 3]; samples];
                vectorized(
                    #[inline(always)]
                    || matrix.apply(&ring, base, &mut out),
                );
                for (i, out) in out.iter().enumerate() {
                    let plain: [T; 3] = std::array::from_fn(|c| {
                        let mut sum = T::default();
                        (0..points).for_each(|p| sum = sum + T::from_f64(weight(i, p)) * ring[p][c]);
                        base[c] + sum
                    });
                    assert_eq!(*out, plain, "sample {i} of {samples} over {points}");
                }
            }
        }
        check::<f32>();
        check::<f64>();
    }
}
