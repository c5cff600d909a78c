//! Points of one face and their normals: weights of many samples times the face's control points.

use super::normal::unit_normals;
use super::{LANES, block_sums, level, store};
use crate::real::Real;
use fearless_simd::{Simd, dispatch};

/// Weights of position, and of two derivatives where normals are wanted, over the points of a ring, in blocks:
/// `blocks[(b * points + p) * orders + order][k]` is the weight of point `p` in sample `LANES * b + k`. What fills up the
/// last block is not used.
#[derive(Debug, Default)]
pub(crate) struct SurfaceMatrix<T> {
    blocks: Vec<[T; LANES]>,
    points: usize,
    samples: usize,
    orders: usize,
}

/// The control points of a face, by their numbers.
#[derive(Clone, Copy)]
pub(crate) struct Ring<'a, T, const N: usize> {
    pub numbers: &'a [u32],
    pub control: &'a [[T; N]],
}

/// Where samples go, in whole blocks.
pub(crate) struct Samples<'o, T, const N: usize> {
    pub points: &'o mut [[T; N]],
    /// Unit normals; empty where they are not wanted.
    pub normals: &'o mut [[T; 3]],
    /// By block, the samples, as bits, whose normals are to be had otherwise, see [`normal`](super::normal).
    pub unsure: &'o mut [u32],
}

impl<T: Real> SurfaceMatrix<T> {
    /// Makes room for other weights: of position alone or, with 3 `orders`, of derivatives too.
    pub fn resize(&mut self, samples: usize, points: usize, orders: usize) {
        self.blocks.resize(samples.div_ceil(LANES) * points * orders, [T::default(); LANES]);
        *self = Self { blocks: std::mem::take(&mut self.blocks), points, samples, orders };
    }

    /// Number of control points.
    pub fn points(&self) -> usize {
        self.points
    }

    /// Weights of block `b`: point by point, orders side by side.
    pub fn block_mut(&mut self, b: usize) -> &mut [[T; LANES]] {
        let size = self.points * self.orders;
        &mut self.blocks[b * size..(b + 1) * size]
    }

    /// Evaluates the samples in some blocks; true where some normals are to be had otherwise. Sums are relative to the
    /// ring's first point; `relative` is memory for as many points as there are.
    ///
    /// # Panics
    /// If a slice is too short, or there are normals of points with less than three components.
    pub fn evaluate<const N: usize>(
        &self,
        ring: Ring<'_, T, N>,
        relative: &mut [[T; N]],
        wanted: impl Fn(usize) -> bool,
        out: Samples<'_, T, N>,
    ) -> bool {
        dispatch!(level(), simd => simd.vectorize(
            #[inline(always)]
            || self.evaluate_with(simd, ring, relative, wanted, out)
        ))
    }

    /// [`evaluate`](Self::evaluate) within a loop that is compiled for the machine's vectors.
    #[inline(always)]
    pub fn evaluate_with<S: Simd, const N: usize>(
        &self,
        simd: S,
        ring: Ring<'_, T, N>,
        relative: &mut [[T; N]],
        wanted: impl Fn(usize) -> bool,
        out: Samples<'_, T, N>,
    ) -> bool {
        let relative = &mut relative[..self.points];
        match self.orders {
            1 => {
                let (base, _) = ring.gather::<false>(relative);
                self.positions(simd, relative, base, wanted, out)
            }
            _ => {
                let (base, extent) = ring.gather::<true>(relative);
                self.with_normals(simd, relative, (base, extent), wanted, out)
            }
        }
    }

    #[inline(always)]
    fn positions<S: Simd, const N: usize>(
        &self,
        simd: S,
        ring: &[[T; N]],
        base: [T; N],
        wanted: impl Fn(usize) -> bool,
        out: Samples<'_, T, N>,
    ) -> bool {
        let blocks = self.blocks.chunks_exact(self.points).zip(out.points.chunks_mut(LANES));
        for (b, (block, out)) in blocks.enumerate() {
            if wanted(b) {
                store::<T, _, N>(simd, block_sums::<T, _, N>(simd, block, ring, base), out);
            }
        }
        false
    }

    #[inline(always)]
    fn with_normals<S: Simd, const N: usize>(
        &self,
        simd: S,
        ring: &[[T; N]],
        (base, extent): ([T; N], T),
        wanted: impl Fn(usize) -> bool,
        out: Samples<'_, T, N>,
    ) -> bool {
        let Samples { points, normals, unsure } = out;
        let extent = T::splat(simd, extent);
        let out = points.chunks_mut(LANES).zip(normals.chunks_mut(LANES));
        let mut any = 0;
        for (b, (block, (points, normals))) in self.blocks.chunks_exact(3 * self.points).zip(out).enumerate() {
            if !wanted(b) {
                continue;
            }
            let zero = T::splat(simd, T::default());
            let mut sums = [[zero; N]; 3];
            for (weights, point) in block.as_chunks::<3>().0.iter().zip(ring) {
                let weights = [T::load(simd, &weights[0]), T::load(simd, &weights[1]), T::load(simd, &weights[2])];
                for c in 0..N {
                    let x = T::splat(simd, point[c]);
                    for order in 0..3 {
                        sums[order][c] = T::plus(simd, sums[order][c], T::times(simd, weights[order], x));
                    }
                }
            }
            let [mut position, du, dv] = sums;
            for c in 0..N {
                position[c] = T::plus(simd, T::splat(simd, base[c]), position[c]);
            }
            store::<T, _, N>(simd, position, points);
            let (du, dv) = ([du[0], du[1 % N], du[2 % N]], [dv[0], dv[1 % N], dv[2 % N]]);
            let (unit, mut bits) = unit_normals::<T, _>(simd, du, dv, extent);
            // The last block may be filled up.
            bits &= u32::MAX >> (32 - (self.samples - b * LANES).min(LANES) as u32);
            unsure[b] = bits;
            any |= bits;
            store::<T, _, 3>(simd, unit, normals);
        }
        any != 0
    }
}

impl<T: Real, const N: usize> Ring<'_, T, N> {
    /// Writes the points relative to the first, which is returned; and, if asked for, the largest of their components.
    #[inline(always)]
    fn gather<const EXTENT: bool>(self, out: &mut [[T; N]]) -> ([T; N], T) {
        let zero = T::default();
        let base = self.control[self.numbers[0] as usize];
        let mut most = [zero; N];
        for i in 0..out.len() {
            let point = &self.control[self.numbers[i] as usize];
            for c in 0..N {
                let x = point[c] - base[c];
                out[i][c] = x;
                if EXTENT {
                    most[c] = larger(most[c], larger(x, zero - x));
                }
            }
        }
        let mut extent = zero;
        for c in 0..N {
            extent = larger(extent, most[c]);
        }
        (base, extent)
    }
}

#[inline(always)]
fn larger<T: Real>(a: T, b: T) -> T {
    if b > a { b } else { a }
}
