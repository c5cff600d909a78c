//! Steps of refinement of sixteen square grids of quads side by side, one in each lane: whatever a vertex's place, its value is
//! the same sum for all of them. Along the sides of the squares every lane may have a rule of its own.
//!
//! A lattice of size s holds the points (i, j) with -1 ≤ i, j ≤ s + 1, row by row: those of the square, and one beyond all round.

use super::{LANES, level};
use crate::real::Real;
use fearless_simd::{Simd, dispatch};

/// Weights of the new vertices along a row of edges.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct RowRule<T> {
    /// The new vertex on an edge: of each end, of the centroid of each of the two faces.
    pub edge: [T; 2],
    /// An old vertex in the row: its own; of each neighbour in the row, of each across it, of each of the four centroids.
    pub vertex: [T; 4],
}

/// A point of sixteen grids.
pub(crate) type Sixteen<T, const N: usize> = [[T; LANES]; N];

/// The rules of one side of all squares.
#[derive(Clone, Copy)]
pub(crate) struct SideRules<T> {
    pub edge: [[T; LANES]; 2],
    pub vertex: [[T; LANES]; 4],
}

/// Points of a lattice.
pub(crate) const fn lattice_points(size: usize) -> usize {
    (size + 3) * (size + 3)
}

/// Where the point (i, j) of a lattice is.
pub(crate) const fn lattice_point(size: usize, i: isize, j: isize) -> usize {
    ((j + 1) * (size as isize + 3) + i + 1) as usize
}

/// From a lattice of `size` to one of twice the size: all its points that are on the squares, and where `beyond` those round them.
/// `sides` have other rules than `rule`; side 0 is j = 0, side 1 i = size, side 2 j = size, side 3 i = 0. Where two of
/// them meet, and next to there beyond the squares, the result is that of the later.
pub(crate) fn refine_lattice<T: Real, const N: usize>(
    from: &[Sixteen<T, N>],
    size: usize,
    rule: &RowRule<T>,
    sides: [Option<&SideRules<T>>; 4],
    beyond: bool,
    to: &mut [Sixteen<T, N>],
) {
    let (from, to) = (&from[..lattice_points(size)], &mut to[..lattice_points(2 * size)]);
    dispatch!(level(), simd => simd.vectorize(
        #[inline(always)]
        || {
            // Small lattices by loops of known length.
            match size {
                1 if beyond => refine_all(simd, from, 1, rule, true, to),
                2 if !beyond => refine_all(simd, from, 2, rule, false, to),
                2 => refine_all(simd, from, 2, rule, true, to),
                _ => refine_all(simd, from, size, rule, beyond, to),
            }
            for side in 0..4 {
                if let Some(rules) = sides[side] {
                    refine_side(simd, from, size, side, rules, beyond, to);
                }
            }
        }
    ));
}

#[inline(always)]
fn refine_all<T: Real, S: Simd, const N: usize>(
    simd: S,
    from: &[Sixteen<T, N>],
    size: usize,
    rule: &RowRule<T>,
    beyond: bool,
    to: &mut [Sixteen<T, N>],
) {
    // Counted from the point beyond: old vertex p goes to 2 p - 1, what lies between p and p + 1 to 2 p.
    let (width, fine) = (size + 3, 2 * size + 3);
    let quarter = T::splat(simd, T::from_f64(0.25));
    let [end, centroid] = [T::splat(simd, rule.edge[0]), T::splat(simd, rule.edge[1])];
    for q in 0..size + 2 {
        let (near, far) = (&from[q * width..][..width], &from[(q + 1) * width..][..width]);
        let out = &mut to[2 * q * fine..][..fine];
        let is_needed = beyond || 0 < q && q < size + 1;
        for c in 0..N {
            let mut column = T::plus(simd, T::load(simd, &near[0][c]), T::load(simd, &far[0][c]));
            let mut face = T::splat(simd, T::default());
            for p in 0..width - 1 {
                let next = T::plus(simd, T::load(simd, &near[p + 1][c]), T::load(simd, &far[p + 1][c]));
                let before = face;
                face = T::times(simd, quarter, T::plus(simd, column, next));
                T::store(simd, face, &mut out[2 * p][c]);
                if p > 0 && is_needed {
                    let faces = T::times(simd, centroid, T::plus(simd, before, face));
                    T::store(simd, T::plus(simd, T::times(simd, end, column), faces), &mut out[2 * p - 1][c]);
                }
                column = next;
            }
        }
    }
    let [own, beside, across, around] = rule.vertex;
    let [own, beside] = [T::splat(simd, own), T::splat(simd, beside)];
    let [across, around] = [T::splat(simd, across), T::splat(simd, around)];
    let (first, last) = if beyond { (0, size + 1) } else { (1, size) };
    for q in 1..size + 2 {
        let row = |q: usize| &from[q * width..][..width];
        let (below, at, above) = (row(q - 1), row(q), row(q + 1));
        let (lower, rest) = to[(2 * q - 2) * fine..].split_at_mut(fine);
        let (out, upper) = rest.split_at_mut(fine);
        let (lower, upper) = (&lower[..fine], &upper[..fine]);
        for c in 0..N {
            let mut left = T::splat(simd, T::default());
            let mut point = T::load(simd, &at[0][c]);
            let mut faces_left = T::splat(simd, T::default());
            for p in 0..width - 1 {
                let right = T::load(simd, &at[p + 1][c]);
                let faces = T::plus(simd, T::load(simd, &lower[2 * p][c]), T::load(simd, &upper[2 * p][c]));
                if first <= p && p <= last {
                    let ends = T::times(simd, end, T::plus(simd, point, right));
                    T::store(simd, T::plus(simd, ends, T::times(simd, centroid, faces)), &mut out[2 * p][c]);
                }
                if p > 0 {
                    let ends = T::times(simd, beside, T::plus(simd, left, right));
                    let sides = T::plus(simd, T::load(simd, &below[p][c]), T::load(simd, &above[p][c]));
                    let sides = T::times(simd, across, sides);
                    let faces = T::times(simd, around, T::plus(simd, faces_left, faces));
                    let neighbours = T::plus(simd, T::plus(simd, ends, sides), faces);
                    T::store(simd, T::plus(simd, T::times(simd, own, point), neighbours), &mut out[2 * p - 1][c]);
                }
                (left, point, faces_left) = (point, right, faces);
            }
        }
    }
}

/// The new vertices along a side again; sums are relative to the old vertex, so that constants come out exactly whatever the
/// weights.
#[inline(always)]
fn refine_side<T: Real, S: Simd, const N: usize>(
    simd: S,
    from: &[Sixteen<T, N>],
    size: usize,
    side: usize,
    rules: &SideRules<T>,
    beyond: bool,
    to: &mut [Sixteen<T, N>],
) {
    // Where the row starts, the distance to the next point, and that to the row beside it.
    let row = |size: usize| {
        let width = size + 3;
        match side {
            0 => (width, 1, width),
            1 => (size + 1, width, 1),
            2 => ((size + 1) * width, 1, width),
            _ => (1, width, 1),
        }
    };
    let ((start, step, aside), (fine_start, fine_step, fine_aside)) = (row(size), row(2 * size));
    let [end, centroid] = [T::load(simd, &rules.edge[0]), T::load(simd, &rules.edge[1])];
    let [_, beside, across, around] = rules.vertex;
    let [beside, across] = [T::load(simd, &beside), T::load(simd, &across)];
    let around = T::load(simd, &around);
    let (first, last) = if beyond { (0, size + 1) } else { (1, size) };
    for c in 0..N {
        for p in 0..size + 2 {
            let at = start + p * step;
            let fine = fine_start + 2 * p * fine_step;
            let own = T::load(simd, &from[at][c]);
            if first <= p && p <= last {
                let faces = T::plus(
                    simd,
                    apart::<T, S>(simd, &to[fine - fine_aside][c], own),
                    apart::<T, S>(simd, &to[fine + fine_aside][c], own),
                );
                let next = T::times(simd, end, apart::<T, S>(simd, &from[at + step][c], own));
                let sum = T::plus(simd, next, T::times(simd, centroid, faces));
                T::store(simd, T::plus(simd, own, sum), &mut to[fine][c]);
            }
            if p > 0 {
                let ends = T::plus(
                    simd,
                    apart::<T, S>(simd, &from[at - step][c], own),
                    apart::<T, S>(simd, &from[at + step][c], own),
                );
                let sides = T::plus(
                    simd,
                    apart::<T, S>(simd, &from[at - aside][c], own),
                    apart::<T, S>(simd, &from[at + aside][c], own),
                );
                let before = fine - 2 * fine_step;
                let below = T::plus(
                    simd,
                    apart::<T, S>(simd, &to[before - fine_aside][c], own),
                    apart::<T, S>(simd, &to[fine - fine_aside][c], own),
                );
                let above = T::plus(
                    simd,
                    apart::<T, S>(simd, &to[before + fine_aside][c], own),
                    apart::<T, S>(simd, &to[fine + fine_aside][c], own),
                );
                let faces = T::times(simd, around, T::plus(simd, below, above));
                let far = T::plus(simd, T::times(simd, across, sides), faces);
                let sum = T::plus(simd, T::times(simd, beside, ends), far);
                T::store(simd, T::plus(simd, own, sum), &mut to[fine - fine_step][c]);
            }
        }
    }
}

/// Sixteen numbers less others.
#[inline(always)]
fn apart<T: Real, S: Simd>(simd: S, x: &[T; LANES], from: T::Block<S>) -> T::Block<S> {
    T::minus(simd, T::load(simd, x), from)
}

/// Rows of sixteen lanes to lanes of rows: number k of lane l goes to `out[l * stride + k]`. There are whole sixteens of rows.
pub(crate) fn turn<T: Real>(from: &[[T; LANES]], rows: &[u32], stride: usize, out: &mut [T]) {
    dispatch!(level(), simd => simd.vectorize(
        #[inline(always)]
        || {
            let mut between = [[T::default(); LANES]; LANES];
            for (block, rows) in rows.as_chunks::<LANES>().0.iter().enumerate() {
                for k in 0..LANES / 4 {
                    let row = [rows[k], rows[k + 4], rows[k + 8], rows[k + 12]].map(|row| &from[row as usize]);
                    shuffle_into(simd, row, &mut between, k);
                }
                for k in 0..LANES / 4 {
                    let row = [&between[k], &between[k + 4], &between[k + 8], &between[k + 12]];
                    let [a, b, c, d] = shuffled::<T, _>(simd, row);
                    let at = 4 * k * stride + LANES * block;
                    T::store(simd, a, &mut out[at..].as_chunks_mut().0[0]);
                    T::store(simd, b, &mut out[at + stride..].as_chunks_mut().0[0]);
                    T::store(simd, c, &mut out[at + 2 * stride..].as_chunks_mut().0[0]);
                    T::store(simd, d, &mut out[at + 3 * stride..].as_chunks_mut().0[0]);
                }
            }
        }
    ));
}

/// The way back: number k of lane l comes from `from[l * stride + k]`, where `from` has sixteen lanes and `stride` is a
/// multiple of sixteen.
pub(crate) fn turn_back<T: Real>(from: &[T], out: &mut [[T; LANES]]) {
    let stride = from.len() / LANES;
    dispatch!(level(), simd => simd.vectorize(
        #[inline(always)]
        || {
            let mut between = [[T::default(); LANES]; LANES];
            for (block, out) in out[..stride].as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
                for k in 0..LANES / 4 {
                    let at = k * stride + LANES * block;
                    let rows = [
                        &from[at..].as_chunks().0[0],
                        &from[at + 4 * stride..].as_chunks().0[0],
                        &from[at + 8 * stride..].as_chunks().0[0],
                        &from[at + 12 * stride..].as_chunks().0[0],
                    ];
                    shuffle_into(simd, rows, &mut between, k);
                }
                for k in 0..LANES / 4 {
                    shuffle_into(simd, [&between[k], &between[k + 4], &between[k + 8], &between[k + 12]], out, k);
                }
            }
        }
    ));
}

/// Of rows k, k + 4, k + 8 and k + 12 the rows 4 k to 4 k + 3 after two perfect shuffles of all sixteen; four shuffles make columns
/// of rows. All sixteen at once do not fit the registers in double precision.
#[inline(always)]
fn shuffled<T: Real, S: Simd>(simd: S, rows: [&[T; LANES]; 4]) -> [T::Block<S>; 4] {
    let [a, b] = T::zip(simd, T::load(simd, rows[0]), T::load(simd, rows[2]));
    let [c, d] = T::zip(simd, T::load(simd, rows[1]), T::load(simd, rows[3]));
    let ([p, q], [r, s]) = (T::zip(simd, a, c), T::zip(simd, b, d));
    [p, q, r, s]
}

/// Number `k` of these four shuffles, to where its rows belong.
#[inline(always)]
fn shuffle_into<T: Real, S: Simd>(simd: S, rows: [&[T; LANES]; 4], out: &mut [[T; LANES]], k: usize) {
    let out = &mut out[4 * k..4 * k + 4];
    for (block, out) in shuffled::<T, S>(simd, rows).into_iter().zip(out) {
        T::store(simd, block, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers without a pattern.
    fn numbers(count: usize) -> Vec<Sixteen<f64, 2>> {
        let number = |i: usize| ((i * 7919 + 13) % 1013) as f64 / 31.0;
        (0..count).map(|p| std::array::from_fn(|c| std::array::from_fn(|k| number(32 * p + 16 * c + k)))).collect()
    }

    const SMOOTH: RowRule<f64> = RowRule { edge: [0.25, 0.25], vertex: [0.5, 0.0625, 0.0625, 0.0625] };

    #[test]
    fn a_step_is_the_tensor_product_of_two_on_curves() {
        for size in [1, 2, 5] {
            let from = numbers(lattice_points(size));
            let mut to = vec![[[0.0; LANES]; 2]; lattice_points(2 * size)];
            refine_lattice(&from, size, &SMOOTH, [None; 4], true, &mut to);
            // A uniform cubic B-spline: old points and weights of the new point i.
            let terms = |i: isize| match i.rem_euclid(2) {
                0 => vec![(i / 2 - 1, 0.125), (i / 2, 0.75), (i / 2 + 1, 0.125)],
                _ => vec![((i - 1) / 2, 0.5), ((i + 1) / 2, 0.5)],
            };
            let end = 2 * size as isize + 1;
            for (i, j) in (-1..=end).flat_map(|j| (-1..=end).map(move |i| (i, j))) {
                for lane in [0, 7, 15] {
                    let column = |i: isize| {
                        terms(j).iter().map(|t| t.1 * from[lattice_point(size, i, t.0)][1][lane]).sum::<f64>()
                    };
                    let expected = terms(i).iter().map(|t| t.1 * column(t.0)).sum::<f64>();
                    let found = to[lattice_point(2 * size, i, j)][1][lane];
                    // A few roundings of numbers below 33.
                    assert!((found - expected).abs() < 1e-13, "({i}, {j}) of {size}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn a_side_with_the_rule_of_all_others_changes_nothing_but_rounding() {
        for size in [1, 3] {
            let from = numbers(lattice_points(size));
            let same = SideRules { edge: SMOOTH.edge.map(|x| [x; LANES]), vertex: SMOOTH.vertex.map(|x| [x; LANES]) };
            for side in 0..4 {
                let refined = |sides: [Option<&SideRules<f64>>; 4]| {
                    let mut to = vec![[[0.0; LANES]; 2]; lattice_points(2 * size)];
                    refine_lattice(&from, size, &SMOOTH, sides, true, &mut to);
                    to
                };
                let mut sides = [None; 4];
                sides[side] = Some(&same);
                let (a, b) = (refined([None; 4]), refined(sides));
                let mut pairs = a.as_flattened().as_flattened().iter().zip(b.as_flattened().as_flattened());
                // A few roundings of numbers below 33.
                assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-13));
                assert_ne!(a, b, "side {side} is not computed");
            }
        }
    }

    #[test]
    fn lanes_become_rows() {
        let from: Vec<[f32; LANES]> = (0..40).map(|r| std::array::from_fn(|k| (100 * r + k) as f32)).collect();
        let rows: Vec<u32> = (0..32).map(|i| (i * 7 + 3) % 40).collect();
        let mut out = vec![0.0; LANES * rows.len()];
        turn(&from, &rows, rows.len(), &mut out);
        for (lane, out) in out.chunks(rows.len()).enumerate() {
            assert!(out.iter().zip(&rows).all(|(&x, &r)| x == (100 * r + lane as u32) as f32));
        }
        let mut back = vec![[0.0; LANES]; rows.len()];
        turn_back(&out, &mut back);
        assert!(back.iter().zip(&rows).all(|(row, &r)| *row == from[r as usize]));
    }
}
