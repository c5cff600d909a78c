//! Sparse rows over control points, without their weights: which control points each output depends on. Tables share
//! it, and so do the loops that apply weights.

use super::StencilError;
use super::sums::{Sums, padded};
use crate::compiled::{SumRows, as_rows};
use crate::kernel::{PART, Parts, level, put};
use crate::mesh::MAX_COUNT;
use crate::real::Real;
use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;

/// Terms a control point from which on points are copied and filled up before they are read. Larger: more tables whose points are
/// read as they are, at twice the time a term; smaller: copies that few terms use.
const COPIED: usize = 4;

/// Rows that a thread takes at a time. Larger: uneven loads; smaller: overhead of tasks.
pub(super) const CHUNK: usize = 1024;

/// Compressed sparse rows: row `i` has the control points `indices[offsets[i]..offsets[i + 1]]`, ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct Csr {
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
        if const { N == 3 && size_of::<W>() >= size_of::<T>() } {
            let out = SumRows::new::<N, K, FIRST_IS_POSITION>(out);
            return T::compiled_sums(self, &weights.map(W::compiled_numbers), as_rows(control), None, out);
        }
        self.all_sums::<W, T, N, K, FIRST_IS_POSITION>(weights, control, out);
    }

    /// What [`apply_into`](Self::apply_into) and [`update`](Self::update) give for points: of all rows, or of `some`.
    pub fn sums<W: Real, T: Real>(
        &self,
        weights: &[&[W]],
        control: &[[T; 3]],
        some: Option<&[u32]>,
        out: SumRows<'_, T>,
    ) {
        fn first<'a, const K: usize, W>(weights: &[&'a [W]]) -> [&'a [W]; K] {
            *weights.first_chunk().expect("as many parts as are asked for")
        }
        match (out, some) {
            (SumRows::Positions(out), None) => self.all_sums::<W, T, 3, 1, true>(first(weights), control, out),
            (SumRows::First(out), None) => self.all_sums::<W, T, 3, 2, false>(first(weights), control, out),
            (SumRows::Frames(out), None) => self.all_sums::<W, T, 3, 3, true>(first(weights), control, out),
            (SumRows::Second(out), None) => self.all_sums::<W, T, 3, 3, false>(first(weights), control, out),
            (SumRows::Positions(out), Some(rows)) => {
                self.some_sums::<W, T, 3, 1, true>(first(weights), control, rows, out);
            }
            (SumRows::Frames(out), Some(rows)) => {
                self.some_sums::<W, T, 3, 3, true>(first(weights), control, rows, out);
            }
            (SumRows::First(_) | SumRows::Second(_), Some(_)) => unreachable!("derivatives alone are not updated"),
        }
    }

    fn all_sums<W: Real, T: Real, const N: usize, const K: usize, const FIRST_IS_POSITION: bool>(
        &self,
        weights: [&[W]; K],
        control: &[[T; N]],
        out: &mut [[[T; N]; K]],
    ) {
        let sums = Sums::<W, K, FIRST_IS_POSITION> { rows: self, weights };
        for first in (0..N).step_by(PART) {
            if self.indices.len() < COPIED * control.len() {
                sums.all::<T, T::Wider<W>, N>(&Parts::new(control, first), first, out);
            } else {
                sums.all::<T, T::Wider<W>, N>(&padded::<T, T::Wider<W>, N>(control, first)[..], first, out);
            }
        }
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
        if const { N == 3 && size_of::<W>() >= size_of::<T>() } {
            let out = SumRows::new::<N, K, FIRST_IS_POSITION>(out);
            return T::compiled_sums(self, &weights.map(W::compiled_numbers), as_rows(control), Some(rows), out);
        }
        self.some_sums::<W, T, N, K, FIRST_IS_POSITION>(weights, control, rows, out);
    }

    fn some_sums<W: Real, T: Real, const N: usize, const K: usize, const FIRST_IS_POSITION: bool>(
        &self,
        weights: [&[W]; K],
        control: &[[T; N]],
        rows: &[u32],
        out: &mut [[[T; N]; K]],
    ) {
        let sums = Sums::<W, K, FIRST_IS_POSITION> { rows: self, weights };
        let some = |rows: &[u32], out: &mut dyn FnMut(u32, [[T; N]; K])| {
            dispatch!(level(), simd => simd.vectorize(
                #[inline(always)]
                || {
                    for &i in rows {
                        let mut row = [[T::default(); N]; K];
                        for first in (0..N).step_by(PART) {
                            let points = Parts::new(control, first);
                            put(&sums.row::<T, T::Wider<W>, _>(simd, i as usize, &points), first, &mut row);
                        }
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
}

/// Refuses more weights than are allowed, or than 32 bits can count.
pub(super) fn check_count(count: usize, most: usize) -> Result<(), StencilError> {
    let limit = most.min(MAX_COUNT);
    if count > limit {
        return Err(StencilError::TooLarge { count: count as u64, limit: limit as u64 });
    }
    Ok(())
}
