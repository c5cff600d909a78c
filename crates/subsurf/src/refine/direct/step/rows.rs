//! The vertices on control edges: the row along the edge with a row on each side, several edges side by side.

use super::super::grid::Grid;
use super::super::rules::rounded;
use super::super::sides::Walk;
use super::{Step, Task};
use crate::index::{Edge, HalfEdge};
use crate::real::Real;

/// Edges whose rows are refined side by side. Larger: more than the nearest cache holds; smaller: vectors that are not full.
pub(super) const EDGES: usize = 16;

impl Step {
    #[inline(always)]
    pub(super) fn edges<T: Real, const N: usize, const QUADS: bool>(
        &self,
        walk: Walk<'_, QUADS>,
        values: &[[T; N]],
        grid: &mut Grid<T, N>,
        task: &mut Task<'_, [T; N]>,
    ) {
        let (rule, from, t) = (rounded(&self.smooth), &self.from, walk.t);
        let (n, width) = (from.size, grid.width);
        let first_edge = task.elements.start;
        for start in task.elements.clone().step_by(EDGES) {
            let some = start..(start + EDGES).min(task.elements.end);
            for (i, e) in some.clone().map(Edge::new).enumerate() {
                let column = i * (n + 1);
                let row = &mut grid.ids[width + column..][..n + 1];
                [row[0], row[n]] = t.edge_vertices[e.index()];
                for (v, &(start, each)) in row[1..n].iter_mut().zip(from.along(false)) {
                    *v = start + each * e.0;
                }
                let h = HalfEdge(t.edge_half_edge[e.index()]);
                from.beside(walk, h, &mut grid.ids[column..][..n + 1]);
                // Where there is one face only, what is taken to lie beyond does not matter.
                from.beside(walk, walk.across(h), &mut grid.ids[2 * width + column..][..n + 1]);
            }
            grid.read(3, values);
            grid.refine(3, &rule, false);
            for &(e, rule) in self.sharp.among(some.start as u32..some.end as u32) {
                grid.refine_row(&self.sharp.rule(rule), (e as usize - start) * (n + 1), n);
            }
            let mut slots = &self.along[..];
            for (region, part) in task.parts.iter_mut().enumerate() {
                let (own, rest) = slots.split_at(1 << region);
                slots = rest;
                let part = &mut part[(start - first_edge) << region..][..some.len() << region];
                for (i, out) in part.chunks_exact_mut(own.len()).enumerate() {
                    let column = (i * (n + 1)) as u32;
                    out.iter_mut().zip(own).for_each(|(out, &slot)| *out = grid.fine[(slot + column) as usize]);
                }
            }
        }
    }
}
