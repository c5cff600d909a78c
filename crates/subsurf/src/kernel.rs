//! The loops where the time goes: weights of many samples times the control points of one face, in the caller's precision.
//!
//! They work on blocks of [`LANES`] samples, in vector instructions of the machine that runs them. Every sample's sum is
//! formed in the same order at any vector width, products and sums are rounded one by one (no fused multiply-add), so that
//! all machines give the same bits.

use crate::real::Real;
use fearless_simd::{Simd, dispatch};

mod block;
mod distinct;
mod lattice;
mod lined;
mod normal;
mod parts;
mod surface;
mod width;

pub use block::Lanes;
use block::store_each;
pub(crate) use distinct::are_distinct;
pub(crate) use lattice::{RowRule, SideRules, Sixteen, lattice_point, lattice_points, refine_lattice, turn, turn_back};
pub(crate) use lined::Lined;
pub(crate) use normal::unit_normals_of;
pub use parts::{PART, Part, PartLanes};
pub(crate) use parts::{Parts, by_component, put, put_first, put_sixteen, rounded, transposed};
pub(crate) use surface::{Ring, Samples, SurfaceMatrix};
pub(crate) use width::level;
pub use width::limit_vector_bits;

/// Samples of a block: one 512-bit vector of `f32`.
pub(crate) const LANES: usize = 16;

/// Runs `work` compiled for the best vector instructions that this machine has. What `work` calls must be
/// `#[inline(always)]`, and so must `work` itself, to be compiled that way.
#[inline(always)]
pub(crate) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    dispatch!(level(), simd => simd.vectorize(work))
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
    pub fn apply<const N: usize>(&self, ring: &[[T; N]], base: [T; N], out: &mut [[T; N]]) {
        self.apply_some(ring, base, |_| true, out);
    }

    /// The same for some blocks of samples only.
    ///
    /// # Panics
    /// If `ring` has not one entry per point.
    pub fn apply_some<const N: usize>(
        &self,
        ring: &[[T; N]],
        base: [T; N],
        wanted: impl Fn(usize) -> bool,
        out: &mut [[T; N]],
    ) {
        assert_eq!(ring.len(), self.points, "one value per point of the ring");
        dispatch!(level(), simd => simd.vectorize(
            #[inline(always)]
            || {
                let blocks = self.blocks.chunks_exact(self.points.max(1)).zip(out.chunks_mut(LANES));
                for (_, (block, out)) in blocks.enumerate().filter(#[inline(always)] |(b, _)| wanted(*b)) {
                    store::<T, _, N>(simd, block_sums::<T, _, N>(simd, block, ring, base), out);
                }
            }
        ));
    }
}

/// `base + Σ weight · ring` of one block, component by component.
#[inline(always)]
fn block_sums<T: Real, S: Simd, const N: usize>(
    simd: S,
    block: &[[T; LANES]],
    ring: &[[T; N]],
    base: [T; N],
) -> [T::Block<S>; N] {
    let mut sums = [T::splat(simd, T::default()); N];
    for (weights, point) in block.iter().zip(ring) {
        let weights = T::load(simd, weights);
        for c in 0..N {
            sums[c] = T::plus(simd, sums[c], T::times(simd, weights, T::splat(simd, point[c])));
        }
    }
    for c in 0..N {
        sums[c] = T::plus(simd, T::splat(simd, base[c]), sums[c]);
    }
    sums
}

#[inline(always)]
fn store<T: Real, S: Simd, const N: usize>(simd: S, sums: [T::Block<S>; N], out: &mut [[T; N]]) {
    if N == 3
        && let Ok(out) = <&mut [T; 3 * LANES]>::try_from(out.as_flattened_mut())
        && let Some(out) = out.as_chunks_mut::<3>().0.as_chunks_mut::<LANES>().0.first_mut()
    {
        return T::store_xyz(simd, [sums[0], sums[1 % N], sums[2 % N]], out);
    }
    store_each::<T, S, N>(simd, sums, out);
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
