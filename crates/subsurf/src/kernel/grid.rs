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
    let FineGrid { old, along_rows, mut across_rows, faces } = out;
    let count = end.div_ceil(LANES);
    let (a, b, c, d) = (blocks(p, 0, count), blocks(p, n, count), blocks(p, row, count), blocks(p, row + n, count));
    let to = &mut faces.as_chunks_mut::<LANES>().0[..count];
    let quarter = T::splat(simd, T::from_f64(0.25));
    for i in 0..count {
        let near = T::plus(simd, T::load(simd, &a[i]), T::load(simd, &b[i]));
        let far = T::plus(simd, T::load(simd, &c[i]), T::load(simd, &d[i]));
        T::store(simd, T::times(simd, quarter, T::plus(simd, near, far)), &mut to[i]);
    }
    // On the first row there are edges across it alone.
    let [end_weight, side_weight] = [T::splat(simd, rule.edge[0]), T::splat(simd, rule.edge[1])];
    if let Some(across) = &mut across_rows {
        let count = row.div_ceil(LANES);
        let (a, b, f, g) =
            (blocks(p, n, count), blocks(p, row + n, count), blocks(faces, n, count), blocks(faces, 0, count));
        let to = &mut across[n..].as_chunks_mut::<LANES>().0[..count];
        for i in 0..count {
            let ends = T::times(simd, end_weight, T::plus(simd, T::load(simd, &a[i]), T::load(simd, &b[i])));
            let sides = T::times(simd, side_weight, T::plus(simd, T::load(simd, &f[i]), T::load(simd, &g[i])));
            T::store(simd, T::plus(simd, ends, sides), &mut to[i]);
        }
    }
    // From the second row's second point on; its first edge along the row comes by itself.
    let first = row + n;
    let count = end.saturating_sub(row).div_ceil(LANES);
    let (v, left, right) = (blocks(p, first, count), blocks(p, first - n, count), blocks(p, first + n, count));
    let (below, above) = (blocks(p, first - row, count), blocks(p, first + row, count));
    let (f, g) = (blocks(faces, first - row - n, count), blocks(faces, first - row, count));
    let (h, k) = (blocks(faces, first - n, count), blocks(faces, first, count));
    let old = &mut old[first..].as_chunks_mut::<LANES>().0[..count];
    let [own, beside, beyond, centroid] = rule.vertex;
    let [own, beside, beyond, centroid] =
        [T::splat(simd, own), T::splat(simd, beside), T::splat(simd, beyond), T::splat(simd, centroid)];
    for c in 0..n {
        let at = row + c;
        let ends = rule.edge[0] * (p[at] + p[at + n]);
        along_rows[at] = ends + rule.edge[1] * (faces[at] + faces[at - row]);
    }
    let along = &mut along_rows[first..].as_chunks_mut::<LANES>().0[..count];
    let across = match &mut across_rows {
        Some(across) => &mut across[first..].as_chunks_mut::<LANES>().0[..count],
        None => Default::default(),
    };
    for i in 0..count {
        let (point, right, above) = (T::load(simd, &v[i]), T::load(simd, &right[i]), T::load(simd, &above[i]));
        let (f, g) = (T::load(simd, &f[i]), T::load(simd, &g[i]));
        let (h, k) = (T::load(simd, &h[i]), T::load(simd, &k[i]));
        let ends = T::times(simd, end_weight, T::plus(simd, point, right));
        let sides = T::times(simd, side_weight, T::plus(simd, k, g));
        T::store(simd, T::plus(simd, ends, sides), &mut along[i]);
        if let Some(across) = across.get_mut(i) {
            let ends = T::times(simd, end_weight, T::plus(simd, point, above));
            let sides = T::times(simd, side_weight, T::plus(simd, k, h));
            T::store(simd, T::plus(simd, ends, sides), across);
        }
        let ends = T::times(simd, beside, T::plus(simd, T::load(simd, &left[i]), right));
        let sides = T::times(simd, beyond, T::plus(simd, T::load(simd, &below[i]), above));
        let around = T::times(simd, centroid, T::plus(simd, T::plus(simd, f, g), T::plus(simd, h, k)));
        let own = T::times(simd, own, point);
        T::store(simd, T::plus(simd, own, T::plus(simd, T::plus(simd, ends, sides), around)), &mut old[i]);
    }
}

/// So many blocks from a place on.
#[inline(always)]
fn blocks<T>(from: &[T], start: usize, count: usize) -> &[[T; LANES]] {
    &from[start..].as_chunks().0[..count]
}
