//! Points of any list four components at a time, as vector lanes want them, and such parts as vectors.

use super::LANES;
use super::block::Lanes;
use crate::real::Real;
use fearless_simd::{Simd, SimdFrom, f32x4, f64x4};

/// Components of a part: values of more have several.
pub const PART: usize = 4;

/// Up to four components of a value; what lies beyond the last one is of no use.
pub type Part<T> = [T; PART];

/// What loops over parts ask of a number. All operations round as those of single numbers do.
#[doc(hidden)]
pub trait PartLanes: Lanes {
    /// A part: one number per component.
    type Four<S: Simd>: Copy;
    /// The wider of two precisions.
    type Wider<O: Real>: Real;

    /// A part in this precision, which `T` fits into or is rounded to.
    fn converted<T: Real, S: Simd>(simd: S, part: Part<T>) -> Self::Four<S>;
    fn four<S: Simd>(simd: S, part: Part<Self>) -> Self::Four<S>;
    fn part<S: Simd>(simd: S, x: Self::Four<S>) -> Part<Self>;
    fn four_times<S: Simd>(simd: S, a: Self::Four<S>, b: Self::Four<S>) -> Self::Four<S>;
    fn four_plus<S: Simd>(simd: S, a: Self::Four<S>, b: Self::Four<S>) -> Self::Four<S>;
    fn four_minus<S: Simd>(simd: S, a: Self::Four<S>, b: Self::Four<S>) -> Self::Four<S>;
    /// Four parts side by side.
    fn joined<S: Simd>(simd: S, parts: [Self::Four<S>; 4]) -> Self::Block<S>;
    /// The four parts of a block.
    fn parted<S: Simd>(simd: S, x: Self::Block<S>) -> [Self::Four<S>; 4];
}

impl PartLanes for f32 {
    type Four<S: Simd> = f32x4<S>;
    type Wider<O: Real> = O;

    #[inline(always)]
    fn converted<T: Real, S: Simd>(simd: S, part: Part<T>) -> f32x4<S> {
        f32x4::simd_from(simd, rounded(part))
    }

    #[inline(always)]
    fn four<S: Simd>(simd: S, part: Part<Self>) -> f32x4<S> {
        f32x4::simd_from(simd, part)
    }

    #[inline(always)]
    fn part<S: Simd>(_: S, x: f32x4<S>) -> Part<Self> {
        x.into()
    }

    #[inline(always)]
    fn four_times<S: Simd>(simd: S, a: f32x4<S>, b: f32x4<S>) -> f32x4<S> {
        simd.mul_f32x4(a, b)
    }

    #[inline(always)]
    fn four_plus<S: Simd>(simd: S, a: f32x4<S>, b: f32x4<S>) -> f32x4<S> {
        simd.add_f32x4(a, b)
    }

    #[inline(always)]
    fn four_minus<S: Simd>(simd: S, a: f32x4<S>, b: f32x4<S>) -> f32x4<S> {
        simd.sub_f32x4(a, b)
    }

    #[inline(always)]
    fn joined<S: Simd>(simd: S, [a, b, c, d]: [f32x4<S>; 4]) -> Self::Block<S> {
        simd.combine_f32x8(simd.combine_f32x4(a, b), simd.combine_f32x4(c, d))
    }

    #[inline(always)]
    fn parted<S: Simd>(simd: S, x: Self::Block<S>) -> [f32x4<S>; 4] {
        let (low, high) = simd.split_f32x16(x);
        let ((a, b), (c, d)) = (simd.split_f32x8(low), simd.split_f32x8(high));
        [a, b, c, d]
    }
}

impl PartLanes for f64 {
    type Four<S: Simd> = f64x4<S>;
    type Wider<O: Real> = f64;

    #[inline(always)]
    fn converted<T: Real, S: Simd>(simd: S, part: Part<T>) -> f64x4<S> {
        T::wide(simd, part)
    }

    #[inline(always)]
    fn four<S: Simd>(simd: S, part: Part<Self>) -> f64x4<S> {
        f64x4::simd_from(simd, part)
    }

    #[inline(always)]
    fn part<S: Simd>(_: S, x: f64x4<S>) -> Part<Self> {
        x.into()
    }

    #[inline(always)]
    fn four_times<S: Simd>(simd: S, a: f64x4<S>, b: f64x4<S>) -> f64x4<S> {
        simd.mul_f64x4(a, b)
    }

    #[inline(always)]
    fn four_plus<S: Simd>(simd: S, a: f64x4<S>, b: f64x4<S>) -> f64x4<S> {
        simd.add_f64x4(a, b)
    }

    #[inline(always)]
    fn four_minus<S: Simd>(simd: S, a: f64x4<S>, b: f64x4<S>) -> f64x4<S> {
        simd.sub_f64x4(a, b)
    }

    #[inline(always)]
    fn joined<S: Simd>(simd: S, [a, b, c, d]: [f64x4<S>; 4]) -> Self::Block<S> {
        [simd.combine_f64x4(a, b), simd.combine_f64x4(c, d)]
    }

    #[inline(always)]
    fn parted<S: Simd>(simd: S, x: Self::Block<S>) -> [f64x4<S>; 4] {
        let ((a, b), (c, d)) = (simd.split_f64x8(x[0]), simd.split_f64x8(x[1]));
        [a, b, c, d]
    }
}

/// A part of every value of a list.
#[derive(Clone, Copy)]
pub(crate) struct Parts<'a, V, const N: usize> {
    values: &'a [[V; N]],
    /// First component.
    first: usize,
    /// Of the last value, filled up.
    last: Part<V>,
}

impl<'a, V: Real, const N: usize> Parts<'a, V, N> {
    /// Components from number `first` on.
    #[inline(always)]
    pub fn new(values: &'a [[V; N]], first: usize) -> Self {
        let mut out = Self { values, first, last: [V::default(); PART] };
        if !values.is_empty() {
            out.last = out.one_by_one(values.len() - 1);
        }
        out
    }

    /// The part of value `number`.
    #[inline(always)]
    pub fn at(&self, number: usize) -> Part<V> {
        // Four numbers at once; those of the last value are not followed by others.
        if N == PART || N + 1 == PART {
            let start = N * number;
            match self.values.as_flattened().get(start..start + PART) {
                Some(&[a, b, c, d]) => [a, b, c, d],
                _ => {
                    assert!(number < self.values.len(), "value {number} of {}", self.values.len());
                    self.last
                }
            }
        } else {
            self.one_by_one(number)
        }
    }

    /// The part of value `number`, in another precision.
    #[inline(always)]
    pub fn rounded<T: Real>(&self, number: usize) -> Part<T> {
        rounded(self.at(number))
    }

    #[inline(always)]
    fn one_by_one(&self, number: usize) -> Part<V> {
        let mut part = [V::default(); PART];
        for c in 0..PART {
            if self.first + c < N {
                part[c] = self.values[number][self.first + c];
            }
        }
        part
    }
}

/// A part in another precision.
#[inline(always)]
pub(crate) fn rounded<V: Real, T: Real>(from: Part<V>) -> Part<T> {
    let mut part = [T::default(); PART];
    for c in 0..PART {
        part[c] = T::from_f64(from[c].to_f64());
    }
    part
}

/// Writes a part of some values that follow each other, components from number `first` on.
#[inline(always)]
pub(crate) fn put<T: Real, const N: usize, const R: usize>(parts: &[Part<T>; R], first: usize, out: &mut [[T; N]; R]) {
    put_first::<T, N, R>(parts, first, out.as_flattened_mut());
}

/// [`put`] at the beginning of a longer list, given as its numbers, which is written in order: numbers of the value behind may
/// be overwritten.
#[inline(always)]
pub(crate) fn put_first<T: Real, const N: usize, const R: usize>(parts: &[Part<T>; R], first: usize, flat: &mut [T]) {
    for r in 0..R {
        // Four numbers at once, where the next overwrite what does not belong there.
        if N <= PART
            && let Some(four) = flat[N * r..].first_chunk_mut::<PART>()
        {
            *four = parts[r];
        } else {
            for c in 0..PART {
                if first + c < N {
                    flat[N * r + first + c] = parts[r][c];
                }
            }
        }
    }
}

/// Components of sixteen values side by side: what is written before it is read.
pub(crate) type Records<T> = [[Part<T>; LANES]; 6];

/// Writes a part of sixteen values, one a lane, or of as many as have numbers, each by its number: vector `r` of a value has
/// `planes[r][c]` as component `first + c`. `records` is memory to work in.
#[inline(always)]
pub(crate) fn put_sixteen<T: Real, S: Simd, const N: usize, const R: usize>(
    simd: S,
    planes: &[[T::Block<S>; PART]; R],
    first: usize,
    (records, numbers): (&mut Records<T>, &[u32]),
    out: &mut [[[T; N]; R]],
) {
    // Groups of four numbers that follow each other: of all vectors together where one part is all there is.
    let (groups, width) = if N <= PART { ((R * N).div_ceil(PART), R * N) } else { (R, PART * R) };
    for g in 0..groups {
        let mut four = planes[0];
        for k in 0..PART {
            let i = if PART * g + k < width { PART * g + k } else { PART * g };
            four[k] = if N <= PART { planes[i / N][i % N] } else { planes[i / PART][i % PART] };
        }
        let blocks = transposed::<T, S>(simd, four);
        for (quarter, block) in records[g].as_chunks_mut::<4>().0.iter_mut().zip(blocks) {
            if let Some(quarter) = quarter.as_flattened_mut().first_chunk_mut::<LANES>() {
                T::store(simd, block, quarter);
            }
        }
    }
    for k in 0..if numbers.len() < LANES { numbers.len() } else { LANES } {
        let row = out[numbers[k] as usize].as_flattened_mut();
        for g in 0..groups {
            if N <= PART {
                if PART * g + PART <= R * N
                    && let Some(four) = row[PART * g..].first_chunk_mut::<PART>()
                {
                    *four = records[g][k];
                } else {
                    for c in 0..R * N - PART * g {
                        row[PART * g + c] = records[g][k][c];
                    }
                }
            } else {
                for c in 0..PART {
                    if first + c < N {
                        row[N * g + first + c] = records[g][k][c];
                    }
                }
            }
        }
    }
}

/// Four components of sixteen parts, component by component, to parts side by side.
#[inline(always)]
pub(crate) fn transposed<T: Real, S: Simd>(simd: S, c: [T::Block<S>; PART]) -> [T::Block<S>; 4] {
    let [xz, yw] = [T::zip(simd, c[0], c[2]), T::zip(simd, c[1], c[3])];
    let ([a, b], [c, d]) = (T::zip(simd, xz[0], yw[0]), T::zip(simd, xz[1], yw[1]));
    [a, b, c, d]
}

/// The way back: sixteen parts to lanes, component by component.
#[inline(always)]
pub(crate) fn by_component<T: Real, S: Simd>(simd: S, parts: impl Fn(usize) -> Part<T>) -> [T::Block<S>; PART] {
    // No `map`, which is not compiled for the vectors of the machine.
    let mut joined = [T::splat(simd, T::default()); 4];
    for quarter in 0..4 {
        let [a, b, c, d] = [parts(4 * quarter), parts(4 * quarter + 1), parts(4 * quarter + 2), parts(4 * quarter + 3)];
        joined[quarter] = T::joined(simd, [T::four(simd, a), T::four(simd, b), T::four(simd, c), T::four(simd, d)]);
    }
    let [a, b, c, d] = joined;
    let ([xz, yw], [zx, wy]) = (T::unzip(simd, a, b), T::unzip(simd, c, d));
    let ([x, z], [y, w]) = (T::unzip(simd, xz, zx), T::unzip(simd, yw, wy));
    [x, y, z, w]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::level;
    use fearless_simd::dispatch;

    fn check<const N: usize>() {
        let values: Vec<[f32; N]> = (0..5).map(|i| std::array::from_fn(|c| (10 * i + c) as f32)).collect();
        let mut out = [[0.0; N]; 5];
        for first in (0..N).step_by(PART) {
            let parts = Parts::new(&values, first);
            put(&[0, 1, 2, 3, 4].map(|i| parts.rounded::<f64>(i)), first, &mut out);
        }
        assert_eq!(out.map(|value| value.map(|x| x as f32)), values[..]);
    }

    #[test]
    fn parts_that_are_put_are_the_values() {
        check::<1>();
        check::<2>();
        check::<3>();
        check::<4>();
        check::<5>();
        check::<9>();
    }

    /// The rows of `count` samples, put sixteen at once and one by one, in an order of their own.
    fn sixteen_as_alone<T: Real, const N: usize, const R: usize>(count: usize) {
        let value = |k: usize, r: usize, c: usize| T::from_f64((100 * k + 10 * r + c) as f64);
        let numbers: Vec<u32> = (0..count as u32).map(|k| 5 * k % 17).collect();
        let untouched = [[T::from_f64(-1.0); N]; R];
        let (mut together, mut alone) = ([untouched; 17], [untouched; 17]);
        for first in (0..N).step_by(PART) {
            dispatch!(level(), simd => {
                let plane = |r, c| T::load(simd, &std::array::from_fn(|k| value(k, r, first + c)));
                let planes = std::array::from_fn(|r| std::array::from_fn(|c| plane(r, c)));
                let mut records = [[[T::default(); PART]; LANES]; 6];
                put_sixteen(simd, &planes, first, (&mut records, &numbers), &mut together);
            });
            for (k, &number) in numbers.iter().enumerate() {
                let parts = std::array::from_fn(|r| std::array::from_fn(|c| value(k, r, first + c)));
                put::<T, N, R>(&parts, first, &mut alone[number as usize]);
            }
        }
        assert_eq!(together, alone);
    }

    #[test]
    fn sixteen_rows_are_those_put_one_by_one_and_no_other_is_touched() {
        for count in [0, 1, 7, 16] {
            sixteen_as_alone::<f32, 1, 1>(count);
            sixteen_as_alone::<f32, 2, 3>(count);
            sixteen_as_alone::<f32, 3, 1>(count);
            sixteen_as_alone::<f32, 3, 3>(count);
            sixteen_as_alone::<f64, 3, 6>(count);
            sixteen_as_alone::<f32, 4, 6>(count);
            sixteen_as_alone::<f32, 5, 3>(count);
            sixteen_as_alone::<f64, 9, 6>(count);
        }
    }

    #[test]
    fn sixteen_parts_come_back_from_their_components() {
        fn check<T: Real>() {
            let part = |k: usize| [0, 1, 2, 3].map(|c| T::from_f64((10 * k + c) as f64));
            dispatch!(level(), simd => {
                let components = by_component::<T, _>(simd, part);
                for (c, component) in components.into_iter().enumerate() {
                    let mut lanes = [T::default(); LANES];
                    T::store(simd, component, &mut lanes);
                    assert_eq!(lanes, std::array::from_fn(|k| part(k)[c]));
                }
                for (quarter, block) in transposed::<T, _>(simd, components).into_iter().enumerate() {
                    let mut parts = [T::default(); LANES];
                    T::store(simd, block, &mut parts);
                    assert_eq!(parts.as_chunks::<PART>().0, &[0, 1, 2, 3].map(|k| part(4 * quarter + k)));
                }
            });
        }
        check::<f32>();
        check::<f64>();
    }
}
