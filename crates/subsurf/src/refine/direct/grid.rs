//! Grids of values and what one step makes of them.

use crate::kernel::{FineGrid, LANES, RowRule, refine_grid};
use crate::real::Real;

/// A grid of values, row by row, and what one step makes of it.
pub(super) struct Grid<T, const N: usize> {
    pub width: usize,
    /// Values from one kind of new vertices to the next.
    area: usize,
    pub points: Vec<[T; N]>,
    /// Which values the points are.
    pub ids: Vec<u32>,
    /// Old vertices, those on edges along rows, on edges across rows, face points; each where its old vertex, or the lower left
    /// one round it, is.
    pub fine: Vec<[T; N]>,
}

/// Values of one kind of new vertices, with room for whole blocks to be written and their neighbours to be read.
fn area(width: usize, rows: usize) -> usize {
    width * (rows + 1) + 1 + LANES
}

/// Where the vertex at (i, j) of the refined grid is among the fine values.
pub(super) fn fine_slot(width: usize, rows: usize, [i, j]: [usize; 2]) -> usize {
    (i % 2 + 2 * (j % 2)) * area(width, rows) + (j / 2) * width + i / 2
}

impl<T: Real, const N: usize> Grid<T, N> {
    pub fn new(width: usize, rows: usize) -> Self {
        let (area, zero) = (area(width, rows), [T::default(); N]);
        Self { width, area, points: vec![zero; area], ids: vec![0; area], fine: vec![zero; 4 * area] }
    }

    /// Reads the points of some rows.
    #[inline(always)]
    pub fn read(&mut self, rows: usize, values: &[[T; N]]) {
        let ids = &self.ids[..rows * self.width];
        self.points.iter_mut().zip(ids).for_each(|(point, &id)| *point = values[id as usize]);
    }

    /// Of some rows: all face points; edge points on rows but the first and the last; vertex points on these rows but at their ends; and
    /// edge points across rows, but along both sides, where they are asked for.
    #[inline(always)]
    pub fn refine(&mut self, rows: usize, rule: &RowRule<T>, across: bool) {
        let size = [self.width * N, rows, N];
        let (old, rest) = self.fine.as_flattened_mut().split_at_mut(self.area * N);
        let (along_rows, rest) = rest.split_at_mut(self.area * N);
        let (upward, faces) = rest.split_at_mut(self.area * N);
        let across_rows = across.then_some(upward);
        refine_grid(self.points.as_flattened(), size, rule, FineGrid { old, along_rows, across_rows, faces });
    }

    /// Again the new vertices of `count` edges of the middle one of three rows, from column `first` on, by a rule of their own;
    /// sums are relative to the old vertex, so that constants come out exactly whatever the weights.
    #[inline(always)]
    pub fn refine_row(&mut self, rule: &RowRule<T>, first: usize, count: usize) {
        let (width, area, none) = (self.width, self.area, T::default());
        let (p, [end, centroid]) = (&self.points, rule.edge);
        let [_, beside, beyond, around] = rule.vertex;
        for at in width + first..width + first + count {
            let (own, next) = (p[at], p[at + 1]);
            let face = |fine: &[[T; N]], at: usize, c: usize| fine[3 * area + at][c] - own[c];
            for c in 0..N {
                let mut sum = end * (next[c] - own[c]);
                if centroid != none {
                    sum = sum + centroid * (face(&self.fine, at, c) + face(&self.fine, at - width, c));
                }
                self.fine[area + at][c] = own[c] + sum;
            }
            if at == width + first {
                continue;
            }
            for c in 0..N {
                let pair = |a: usize, b: usize| (p[a][c] - own[c]) + (p[b][c] - own[c]);
                let mut sum = beside * pair(at - 1, at + 1);
                if around != none {
                    let f = |at: usize| face(&self.fine, at, c);
                    let faces = (f(at - width - 1) + f(at - width)) + (f(at - 1) + f(at));
                    sum = sum + (beyond * pair(at - width, at + width) + around * faces);
                }
                self.fine[at][c] = own[c] + sum;
            }
        }
    }
}
