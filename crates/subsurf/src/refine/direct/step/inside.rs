//! The vertices inside control faces: those inside a quad are a grid with its rim, and several such grids are refined at once, one
//! after the other; other faces are refined corner by corner.

use super::super::grid::Grid;
use super::super::rules::rounded;
use super::super::sides::Walk;
use super::stars::smooth_vertex;
use super::{Scratch, Step, Task};
use crate::index::Face;
use crate::kernel::RowRule;
use crate::real::Real;

/// Quads whose grids are refined one after the other at once, by the pieces of their edges: some 256 points. Larger: more than
/// the nearest cache holds; smaller: vectors that are not full.
pub(super) fn quads_at_once(size: usize) -> usize {
    (256 / ((size + 1) * (size + 1))).max(1)
}

impl Step {
    #[inline(always)]
    pub(super) fn faces<T: Real, const N: usize, const QUADS: bool>(
        &self,
        walk: Walk<'_, QUADS>,
        values: &[[T; N]],
        scratch: &mut Scratch<T, N>,
        task: &mut Task<'_, [T; N]>,
    ) {
        let (rule, from, Walk { t, sides }) = (rounded(&self.smooth), &self.from, walk);
        let first_half_edge = t.face_offset[task.elements.start];
        let (grid, rows) = (&mut scratch.face, from.size + 1);
        let (cells, most) = (rows * rows, quads_at_once(from.size));
        let mut quads = task.elements.clone().map(Face::new);
        loop {
            let some = &mut scratch.quads;
            some.clear();
            while let Some(f) = if some.len() < most { quads.next() } else { None } {
                if !QUADS && t.sides(f) != 4 {
                    let at = (t.first(f) - first_half_edge) as usize;
                    let walk = Walk { t, sides };
                    let centre = self.corners(walk, values, &mut scratch.corner, &rule, f, at, &mut task.parts);
                    task.parts[0][f.index() - task.elements.start] = centre;
                    continue;
                }
                from.of_quad(t, sides, f, &mut grid.ids[some.len() * cells..][..cells]);
                some.push(f);
            }
            if some.is_empty() {
                return;
            }
            grid.read(some.len() * rows, values);
            grid.refine(some.len() * rows, &rule, true);
            for target in &self.whole {
                let part = &mut task.parts[target.part];
                for (f, i) in some.iter().zip(0u32..) {
                    let at = match target.part {
                        0 => f.index() - task.elements.start,
                        _ => target.each * (t.first(*f) - first_half_edge) as usize,
                    };
                    let first = i * cells as u32;
                    let out = part[at..][..target.slots.len()].iter_mut();
                    out.zip(&target.slots).for_each(|(out, &slot)| *out = grid.fine[(first + slot) as usize]);
                }
            }
        }
    }

    /// The vertices inside a face that is no quad, but its centre, whose value is returned: corner by corner, each with its
    /// spoke, beyond which lies the next corner. `at` is the face's first half-edge among those of the task.
    #[allow(clippy::too_many_arguments)]
    fn corners<T: Real, const N: usize>(
        &self,
        walk: Walk<'_, false>,
        values: &[[T; N]],
        grid: &mut Grid<T, N>,
        rule: &RowRule<T>,
        f: Face,
        at: usize,
        parts: &mut [&mut [[T; N]]],
    ) -> [T; N] {
        let (from, half, t) = (&self.from, self.from.size / 2, walk.t);
        let sides = t.sides(f);
        for k in 0..sides {
            let h = t.half_edge(f, k);
            for b in 0..=half {
                for a in 0..=half {
                    grid.points[b * grid.width + a] = values[from.cell(walk, h, a, b) as usize];
                }
                grid.points[b * grid.width + half + 1] = values[from.cell(walk, t.next(h), b, half - 1) as usize];
            }
            grid.refine(half + 1, rule, true);
            for target in &self.corner {
                let part = &mut parts[target.part][target.each * (at + k)..][..target.slots.len()];
                part.iter_mut().zip(&target.slots).for_each(|(out, &slot)| *out = grid.fine[slot as usize]);
            }
        }
        let corners = || (0..sides).map(|k| t.half_edge(f, k));
        let own = values[from.cell(walk, t.half_edge(f, 0), half, half) as usize];
        if self.is_linear {
            return own;
        }
        let ends = corners().map(|h| values[from.cell(walk, h, half, half - 1) as usize]);
        smooth_vertex(own, ends.zip(corners().map(|h| values[from.cell(walk, h, half - 1, half - 1) as usize])))
    }
}
