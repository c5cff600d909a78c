//! Sparse rows over control points, without their weights: which control points each output depends on. Tables share
//! it, and so do the loops that apply weights.

use super::StencilError;
use crate::mesh::MAX_COUNT;
use crate::real::{Real, add_scaled};
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
            for (i, out) in out.iter_mut().enumerate() {
                *out = self.row::<W, T, N, K, FIRST_IS_POSITION>(chunk * CHUNK + i, weights, control);
            }
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
        let one = |&i: &u32| self.row::<W, T, N, K, FIRST_IS_POSITION>(i as usize, weights, control);
        if rows.len() < CHUNK {
            return rows.iter().for_each(|i| out[*i as usize] = one(i));
        }
        let moved: Vec<[[T; N]; K]> = rows.par_iter().with_min_len(CHUNK / 4).map(one).collect();
        rows.iter().zip(moved).for_each(|(&i, value)| out[i as usize] = value);
    }

    /// One output. Sums are formed in `f64`, relative to the row's first control point; a row without any gives zeros.
    ///
    /// Of `f32` weights and values too: sums in `f32` take as long (the loop waits for control points, not for sums),
    /// with twice the error; not relative to a point they save a third of the time, for eight times the error, and
    /// more away from the origin.
    #[inline(always)]
    fn row<W: Real, T: Real, const N: usize, const K: usize, const FIRST_IS_POSITION: bool>(
        &self,
        row: usize,
        weights: [&[W]; K],
        control: &[[T; N]],
    ) -> [[T; N]; K] {
        let range = self.range(row);
        let indices = &self.indices[range.clone()];
        // As many weights as indices, so that the compiler need not ask.
        let weights = weights.map(|w| &w[range.clone()][..indices.len()]);
        let Some(&first) = indices.first() else { return [[T::default(); N]; K] };
        let base = control[first as usize].map(T::to_f64);
        let apart = |p: u32| -> [f64; N] {
            let p = &control[p as usize];
            std::array::from_fn(|i| p[i].to_f64() - base[i])
        };
        // Two sums side by side, so that additions need not wait for each other.
        let (mut sum, mut other) = ([[0.0; N]; K], [[0.0; N]; K]);
        let (pairs, odd) = indices.as_chunks::<2>();
        let weight_pairs = weights.map(|w| &w.as_chunks::<2>().0[..pairs.len()]);
        for (j, &[p, q]) in pairs.iter().enumerate() {
            let (p, q) = (apart(p), apart(q));
            for k in 0..K {
                let [a, b] = weight_pairs[k][j];
                add_scaled(&mut sum[k], a.to_f64(), &p);
                add_scaled(&mut other[k], b.to_f64(), &q);
            }
        }
        if let [p] = odd {
            let p = apart(*p);
            (0..K).for_each(|k| add_scaled(&mut sum[k], weights[k][indices.len() - 1].to_f64(), &p));
        }
        (0..K).for_each(|k| add_scaled(&mut sum[k], 1.0, &other[k]));
        if FIRST_IS_POSITION {
            (0..N).for_each(|i| sum[0][i] += base[i]);
        }
        sum.map(|s| s.map(T::from_f64))
    }
}

/// Ends of rows of the given lengths, starting with 0.
pub(super) fn offsets(
    lengths: impl Iterator<Item = usize>,
    rows: usize,
    most: usize,
) -> Result<Vec<u32>, StencilError> {
    let mut out = Vec::with_capacity(rows + 1);
    let mut end = 0usize;
    out.push(0);
    for length in lengths {
        end += length;
        // A count that wraps is refused below.
        out.push(end as u32);
    }
    check_count(end, most)?;
    Ok(out)
}

/// Refuses more weights than are allowed, or than 32 bits can count.
pub(super) fn check_count(count: usize, most: usize) -> Result<(), StencilError> {
    let limit = most.min(MAX_COUNT);
    if count > limit {
        return Err(StencilError::TooLarge { count: count as u64, limit: limit as u64 });
    }
    Ok(())
}
