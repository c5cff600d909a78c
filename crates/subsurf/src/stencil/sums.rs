//! The loops that apply a table: sums of control points, weighted by its rows.
//!
//! A sum is formed in the wider precision of weights and values, relative to the row's first control point, so that constants
//! come out exactly and no digits are lost far from the origin: `Σ wᵢ pᵢ = p₀ + Σ wᵢ (pᵢ − p₀)` where weights sum to one, and
//! without `p₀` in front where they sum to zero.
//!
//! Where points are needed several times each they are copied first, filled up to four numbers: one check of an index and one
//! load then read a point. Most rows of one kind of sum have one of few lengths, those of face, edge and vertex points of quads
//! and of what they become a level below, and follow others of the same: they have loops of known length, and two sums, so that
//! additions need not wait for each other.

use super::csr::{CHUNK, Csr};
use crate::kernel::{PART, Part, Parts, level, put_first, rounded};
use crate::real::Real;
use crate::threads::is_alone;
use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;

/// Values that one task copies, at least.
const COPIED: usize = 16 << 10;

/// A part of all values, components from number `first` on.
pub(super) fn padded<T: Real, P: Real, const N: usize>(values: &[[T; N]], first: usize) -> Vec<Part<P>> {
    let mut out = subsurf_memory::with_capacity(values.len());
    let part = |value: &[T; N]| {
        let mut part = [P::default(); PART];
        for c in first..N.min(first + PART) {
            part[c - first] = P::from_f64(value[c].to_f64());
        }
        part
    };
    if values.len() <= COPIED || is_alone() {
        out.extend(values.iter().map(part));
    } else {
        values.par_iter().with_min_len(COPIED).map(part).collect_into_vec(&mut out);
    }
    out
}

/// Points by number.
pub(super) trait Points<P: Real> {
    fn point<S: Simd>(&self, simd: S, number: u32) -> P::Four<S>;
}

impl<P: Real> Points<P> for [Part<P>] {
    #[inline(always)]
    fn point<S: Simd>(&self, simd: S, number: u32) -> P::Four<S> {
        P::four(simd, self[number as usize])
    }
}

impl<P: Real, T: Real, const N: usize> Points<P> for Parts<'_, T, N> {
    #[inline(always)]
    fn point<S: Simd>(&self, simd: S, number: u32) -> P::Four<S> {
        P::converted(simd, self.at(number as usize))
    }
}

/// `K` arrays of weights over the same rows. `FIRST_IS_POSITION` tells whether the first one's rows sum to one; all others sum
/// to zero.
#[derive(Clone, Copy)]
pub(super) struct Sums<'a, W, const K: usize, const FIRST_IS_POSITION: bool> {
    pub rows: &'a Csr,
    pub weights: [&'a [W]; K],
}

impl<W: Real, const K: usize, const FIRST_IS_POSITION: bool> Sums<'_, W, K, FIRST_IS_POSITION> {
    /// The outputs of all rows, components from number `first` on.
    pub fn all<T: Real, P: Real, const N: usize>(
        &self,
        points: &(impl Points<P> + Sync + ?Sized),
        first: usize,
        out: &mut [[[T; N]; K]],
    ) {
        let rows = |(chunk, out): (usize, &mut [[[T; N]; K]])| {
            dispatch!(level(), simd => simd.vectorize(
                #[inline(always)]
                || self.consecutive::<T, P, _, N>(simd, chunk * CHUNK, points, first, out)
            ));
        };
        if out.len() <= CHUNK || is_alone() {
            out.chunks_mut(CHUNK).enumerate().for_each(rows);
        } else {
            out.par_chunks_mut(CHUNK).enumerate().for_each(rows);
        }
    }

    /// The outputs of consecutive rows from number `start` on.
    #[inline(always)]
    fn consecutive<T: Real, P: Real, S: Simd, const N: usize>(
        &self,
        simd: S,
        start: usize,
        points: &(impl Points<P> + ?Sized),
        first: usize,
        out: &mut [[[T; N]; K]],
    ) {
        let mut i = 0;
        while i < out.len() {
            i += match (K, self.rows.range(start + i).len()) {
                (1, 4) => self.run::<T, P, S, N, 4>(simd, start + i, points, first, &mut out[i..]),
                (1, 6) => self.run::<T, P, S, N, 6>(simd, start + i, points, first, &mut out[i..]),
                (1, 9) => self.run::<T, P, S, N, 9>(simd, start + i, points, first, &mut out[i..]),
                (1, 12) => self.run::<T, P, S, N, 12>(simd, start + i, points, first, &mut out[i..]),
                (1, 16) => self.run::<T, P, S, N, 16>(simd, start + i, points, first, &mut out[i..]),
                _ => {
                    let (indices, weights) = self.terms(start + i);
                    let sums = sum::<W, T, P, S, K, FIRST_IS_POSITION, 1>(simd, indices, weights, points);
                    put_first::<T, N, K>(&sums, first, out[i..].as_flattened_mut().as_flattened_mut());
                    1
                }
            };
        }
    }

    /// The outputs of all rows from number `start` on that have `LENGTH` terms, up to the first with another number; returns
    /// how many these are.
    #[inline(always)]
    fn run<T: Real, P: Real, S: Simd, const N: usize, const LENGTH: usize>(
        &self,
        simd: S,
        start: usize,
        points: &(impl Points<P> + ?Sized),
        first: usize,
        out: &mut [[[T; N]; K]],
    ) -> usize {
        for i in 0..out.len() {
            let range = self.rows.range(start + i);
            if range.len() != LENGTH {
                return i;
            }
            let indices: &[u32; LENGTH] = self.rows.indices[range.clone()].first_chunk().expect("as many");
            let mut own: [&[W]; K] = [&[]; K];
            for k in 0..K {
                own[k] = self.weights[k][range.clone()].first_chunk::<LENGTH>().expect("as many");
            }
            let sums = sum::<W, T, P, S, K, FIRST_IS_POSITION, 2>(simd, indices, own, points);
            put_first::<T, N, K>(&sums, first, out[i..].as_flattened_mut().as_flattened_mut());
        }
        out.len()
    }

    /// One output, with the bits that it has among others.
    #[inline(always)]
    pub fn row<T: Real, P: Real, S: Simd>(&self, simd: S, row: usize, points: &impl Points<P>) -> [Part<T>; K] {
        let (indices, weights) = self.terms(row);
        if matches!((K, indices.len()), (1, 4 | 6 | 9 | 12 | 16)) {
            sum::<W, T, P, S, K, FIRST_IS_POSITION, 2>(simd, indices, weights, points)
        } else {
            sum::<W, T, P, S, K, FIRST_IS_POSITION, 1>(simd, indices, weights, points)
        }
    }

    /// Control points and weights of a row.
    #[inline(always)]
    fn terms(&self, row: usize) -> (&[u32], [&[W]; K]) {
        let range = self.rows.range(row);
        let indices = &self.rows.indices[range.clone()];
        // As many weights as indices, so that the compiler need not ask.
        let mut own: [&[W]; K] = [&[]; K];
        for k in 0..K {
            own[k] = &self.weights[k][range.start..range.end][..indices.len()];
        }
        (indices, own)
    }
}

/// The sums of one row, in `SIDES` parts; zeros where it has no terms.
#[inline(always)]
fn sum<W, T, P, S, const K: usize, const FIRST_IS_POSITION: bool, const SIDES: usize>(
    simd: S,
    indices: &[u32],
    weights: [&[W]; K],
    points: &(impl Points<P> + ?Sized),
) -> [Part<T>; K]
where
    W: Real,
    T: Real,
    P: Real,
    S: Simd,
{
    let mut parts = [[T::default(); PART]; K];
    let Some(&base) = indices.first() else { return parts };
    let base = points.point(simd, base);
    let mut sums = [[P::four(simd, [P::default(); PART]); K]; SIDES];
    for i in 1..indices.len() {
        let apart = P::four_minus(simd, points.point(simd, indices[i]), base);
        let sums = &mut sums[i % SIDES];
        for k in 0..K {
            let weight = P::four(simd, [P::from_f64(weights[k][i].to_f64()); PART]);
            sums[k] = P::four_plus(simd, sums[k], P::four_times(simd, weight, apart));
        }
    }
    for k in 0..K {
        let mut sum = sums[0][k];
        for side in 1..SIDES {
            sum = P::four_plus(simd, sum, sums[side][k]);
        }
        if FIRST_IS_POSITION && k == 0 {
            sum = P::four_plus(simd, base, sum);
        }
        parts[k] = rounded(P::part(simd, sum));
    }
    parts
}
