//! One step of refinement of a grid of quads: vectors run over a whole grid as one row of numbers, in which a neighbour has the
//! same distance everywhere. What they compute across the ends of rows means nothing.

use super::LANES;
use crate::real::Real;
use fearless_simd::{Level, Simd, dispatch};

/// Weights of the new vertices along a row of edges.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct RowRule<T> {
    /// The new vertex on an edge: of each end, of the centroid of each of the two faces.
    pub edge: [T; 2],
    /// An old vertex in the row: its own; of each neighbour in the row, of each across it, of each of the four centroids.
    pub vertex: [T; 4],
}

/// Which new vertices there are, each where its old vertex, or the lower left one round it, is.
pub(crate) struct FineGrid<'a, T> {
    pub old: &'a mut [T],
    pub along_rows: &'a mut [T],
    /// Not written where none.
    pub across_rows: Option<&'a mut [T]>,
    pub faces: &'a mut [T],
}

/// A grid of `rows` rows of `row` numbers, `n` to a point: all face points; edge points on rows but the first and the last, and
/// vertex points there but at the ends; and edge points across rows, but along both sides. Whole blocks are written: all
/// slices have a row, a point and a block more than the grid.
pub(crate) fn refine_grid<T: Real>(p: &[T], [row, rows, n]: [usize; 3], rule: &RowRule<T>, out: FineGrid<'_, T>) {
    dispatch!(Level::new(), simd => simd.vectorize(
        #[inline(always)]
        || refine::<T, _>(simd, p, row, (rows - 1) * row, n, rule, out)
    ));
}

#[inline(always)]
fn refine<T: Real, S: Simd>(
    simd: S,
    p: &[T],
    row: usize,
    end: usize,
    n: usize,
    rule: &RowRule<T>,
    out: FineGrid<'_, T>,
) {
    let FineGrid { old, along_rows, across_rows, faces } = out;
    let quarter = T::splat(simd, T::from_f64(0.25));
    for at in (0..end).step_by(LANES) {
        let near = T::plus(simd, load(simd, p, at), load(simd, p, at + n));
        let far = T::plus(simd, load(simd, p, at + row), load(simd, p, at + row + n));
        store::<T, S>(simd, T::times(simd, quarter, T::plus(simd, near, far)), faces, at);
    }
    edge_points(simd, p, faces, [row, end, n, row], rule, along_rows);
    if let Some(across) = across_rows {
        edge_points(simd, p, faces, [n, end, row, n], rule, across);
    }
    let [own, beside, beyond, centroid] = rule.vertex;
    let [own, beside, beyond, centroid] =
        [T::splat(simd, own), T::splat(simd, beside), T::splat(simd, beyond), T::splat(simd, centroid)];
    for at in (row + n..end).step_by(LANES) {
        let ends = T::plus(simd, load(simd, p, at - n), load(simd, p, at + n));
        let sides = T::plus(simd, load(simd, p, at - row), load(simd, p, at + row));
        let below = T::plus(simd, load(simd, faces, at - row - n), load(simd, faces, at - row));
        let above = T::plus(simd, load(simd, faces, at - n), load(simd, faces, at));
        let around = T::times(simd, centroid, T::plus(simd, below, above));
        let ends = T::plus(simd, T::times(simd, beside, ends), T::times(simd, beyond, sides));
        let own = T::times(simd, own, load(simd, p, at));
        store::<T, S>(simd, T::plus(simd, own, T::plus(simd, ends, around)), old, at);
    }
}

/// From `start` to `end`, edge points between a point and the one `step` further, with a face there and one `back` before.
#[inline(always)]
fn edge_points<T: Real, S: Simd>(
    simd: S,
    p: &[T],
    faces: &[T],
    [start, end, step, back]: [usize; 4],
    rule: &RowRule<T>,
    out: &mut [T],
) {
    let [own, centroid] = [T::splat(simd, rule.edge[0]), T::splat(simd, rule.edge[1])];
    for at in (start..end).step_by(LANES) {
        let ends = T::times(simd, own, T::plus(simd, load(simd, p, at), load(simd, p, at + step)));
        let sides = T::plus(simd, load(simd, faces, at), load(simd, faces, at - back));
        store::<T, S>(simd, T::plus(simd, ends, T::times(simd, centroid, sides)), out, at);
    }
}

#[inline(always)]
fn load<T: Real, S: Simd>(simd: S, from: &[T], at: usize) -> T::Block<S> {
    T::load(simd, from[at..].first_chunk().expect("there is room for whole blocks"))
}

#[inline(always)]
fn store<T: Real, S: Simd>(simd: S, x: T::Block<S>, to: &mut [T], at: usize) {
    T::store(simd, x, to[at..].first_chunk_mut().expect("there is room for whole blocks"));
}
