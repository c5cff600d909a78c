//! Sparse rows over control points, without their weights: which control points each output depends on. Tables share
//! it, and so do the loops that apply weights.

use super::StencilError;
use crate::kernel::{PART, Part, Parts, level, put};
use crate::mesh::MAX_COUNT;
use crate::real::Real;
use fearless_simd::{Simd, dispatch, f64x4};
use rayon::prelude::*;

/// Rows that a thread takes at a time. Larger: uneven loads; smaller: overhead of tasks.
pub(super) const CHUNK: usize = 1024;

/// Compressed sparse rows: row `i` has the control points `indices[offsets[i]..offsets[i + 1]]`, ascending.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Csr {
    pub offsets: Vec<u32>,
    pub indices: Vec<u32>,
    pub control_points: usize,
}

impl Csr {
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    #[inline]
    pub fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.offsets[row] as usize..self.offsets[row + 1] as usize
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        4 * (self.offsets.len() + self.indices.len())
    }

    fn check(&self, control: usize) {
        assert_eq!(control, self.control_points, "one row of control values per control point of the table");
    }

    /// Applies `K` arrays of weights at once, each parallel to the indices. `FIRST_IS_POSITION` tells whether the first
    /// one's rows sum to one; all others sum to zero.
    pub fn apply_into<W: Real, T: Real, const N: usize, const K: usize, const FIRST_IS_POSITION: bool>(
        &self,
        weights: [&[W]; K],
        control: &[[T; N]],
        out: &mut [[[T; N]; K]],
    ) {
        self.check(control.len());
        assert_eq!(out.len(), self.len(), "one row of output per row of the table");
        out.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
            dispatch!(level(), simd => simd.vectorize(
                #[inline(always)]
                || {
                    for (i, out) in out.iter_mut().enumerate() {
                        self.row::<W, T, _, N, K, FIRST_IS_POSITION>(simd, chunk * CHUNK + i, weights, control, out);
                    }
                }
            ));
        });
    }

    /// Applies the weights to the rows of a list alone.
    pub fn update<W: Real, T: Real, const N: usize, const K: usize, const FIRST_IS_POSITION: bool>(
        &self,
        weights: [&[W]; K],
        control: &[[T; N]],
        rows: &[u32],
        out: &mut [[[T; N]; K]],
    ) {
        self.check(control.len());
        assert_eq!(out.len(), self.len(), "one row of output per row of the table");
        let some = |rows: &[u32], out: &mut dyn FnMut(u32, [[T; N]; K])| {
            dispatch!(level(), simd => simd.vectorize(
                #[inline(always)]
                || {
                    for &i in rows {
                        let mut row = [[T::default(); N]; K];
                        self.row::<W, T, _, N, K, FIRST_IS_POSITION>(simd, i as usize, weights, control, &mut row);
                        out(i, row);
                    }
                }
            ));
        };
        if rows.len() < CHUNK {
            return some(rows, &mut |i, row| out[i as usize] = row);
        }
        let moved = rows.par_chunks(CHUNK / 4).map(|rows| {
            let mut moved = Vec::with_capacity(rows.len());
            some(rows, &mut |_, row| moved.push(row));
            moved
        });
        let moved: Vec<_> = moved.collect();
        rows.iter().zip(moved.iter().flatten()).for_each(|(&i, value)| out[i as usize] = *value);
    }

    /// One output. Sums are formed in `f64`, relative to the row's first control point; a row without any gives zeros.
    ///
    /// Of `f32` weights and values too: sums in `f32` have twice the error, and not relative to a point eight times the
    /// error, and more away from the origin.
    #[inline(always)]
    fn row<W: Real, T: Real, S: Simd, const N: usize, const K: usize, const FIRST_IS_POSITION: bool>(
        &self,
        simd: S,
        row: usize,
        weights: [&[W]; K],
        control: &[[T; N]],
        out: &mut [[T; N]; K],
    ) {
        let range = self.range(row);
        let indices = &self.indices[range.clone()];
        if indices.is_empty() {
            *out = [[T::default(); N]; K];
            return;
        }
        // As many weights as indices, so that the compiler need not ask.
        let mut own: [&[W]; K] = [&[]; K];
        for k in 0..K {
            own[k] = &weights[k][range.start..range.end][..indices.len()];
        }
        for first in (0..N).step_by(PART) {
            let points = Parts::new(control, first);
            let base = T::wide(simd, points.at(indices[0] as usize));
            // Two sums side by side, so that additions need not wait for each other.
            let zero = simd.splat_f64x4(0.0);
            let mut sums = [[zero; K]; 2];
            let even = indices.len() & !1;
            for j in (0..even).step_by(2) {
                for side in 0..2 {
                    add(simd, &mut sums[side], &points, indices[j + side], base, &own, j + side);
                }
            }
            if even < indices.len() {
                add(simd, &mut sums[0], &points, indices[even], base, &own, even);
            }
            let mut parts = [[T::default(); PART]; K];
            for k in 0..K {
                let mut sum = simd.add_f64x4(sums[0][k], sums[1][k]);
                if FIRST_IS_POSITION && k == 0 {
                    sum = simd.add_f64x4(sum, base);
                }
                let sum: Part<f64> = sum.into();
                for c in 0..PART {
                    parts[k][c] = T::from_f64(sum[c]);
                }
            }
            put(&parts, first, out);
        }
    }
}

/// Adds the `j`-th term, the control point `point` relative to `base`, to all sums.
#[inline(always)]
fn add<W: Real, T: Real, S: Simd, const N: usize, const K: usize>(
    simd: S,
    sums: &mut [f64x4<S>; K],
    points: &Parts<'_, T, N>,
    point: u32,
    base: f64x4<S>,
    weights: &[&[W]; K],
    j: usize,
) {
    let apart = simd.sub_f64x4(T::wide(simd, points.at(point as usize)), base);
    for k in 0..K {
        let term = simd.mul_f64x4(simd.splat_f64x4(weights[k][j].to_f64()), apart);
        sums[k] = simd.add_f64x4(sums[k], term);
    }
}

/// Refuses more weights than are allowed, or than 32 bits can count.
pub(super) fn check_count(count: usize, most: usize) -> Result<(), StencilError> {
    let limit = most.min(MAX_COUNT);
    if count > limit {
        return Err(StencilError::TooLarge { count: count as u64, limit: limit as u64 });
    }
    Ok(())
}
