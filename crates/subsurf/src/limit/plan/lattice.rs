//! The points of a grid over a face, as they lie in a part of it: every `step`-th line of `cells` in both directions, in the
//! part's own parameters.
//!
//! Halving a part doubles the step, so that parts of one size hold the same points wherever the grid's lines fall on their
//! sides: on a grid of `2^k` cells all do. Sides belong to both of two neighbours.

use super::corners;
use crate::scheme::SplitKind;

/// Points `(start + step · i) / cells`, i and j from 0, as far as they lie in the part.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Lattice {
    start: [u32; 2],
    step: u32,
}

/// What all lattices of a grid have in common.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Grid {
    pub cells: u32,
    pub split: SplitKind,
}

impl Grid {
    /// Number of a grid point: row by row from (0, 0).
    #[inline]
    pub fn index(self, point: [u32; 2]) -> usize {
        self.index_in(Lattice::WHOLE, point)
    }

    /// Number of columns; in triangles those of the lowest row.
    fn columns(self, lattice: Lattice) -> usize {
        let taken = match self.split {
            SplitKind::Quads => lattice.start[0],
            SplitKind::Triangles => lattice.start[0] + lattice.start[1],
        };
        if taken > self.cells { 0 } else { ((self.cells - taken) / lattice.step + 1) as usize }
    }

    /// Number of points before row `j`.
    fn before(self, lattice: Lattice, j: usize) -> usize {
        match self.split {
            SplitKind::Quads => j * self.columns(lattice),
            // Every row is shorter by one than the row below.
            SplitKind::Triangles => j * self.columns(lattice) - j * j.saturating_sub(1) / 2,
        }
    }

    fn rows(self, lattice: Lattice) -> usize {
        match self.split {
            SplitKind::Quads => ((self.cells - lattice.start[1]) / lattice.step + 1) as usize,
            SplitKind::Triangles => self.columns(lattice),
        }
    }

    pub(super) fn len(self, lattice: Lattice) -> usize {
        self.before(lattice, self.rows(lattice))
    }

    /// Number of a point of a lattice.
    #[inline]
    pub(super) fn index_in(self, lattice: Lattice, [a, b]: [u32; 2]) -> usize {
        let [i, j] = [a - lattice.start[0], b - lattice.start[1]].map(|x| (x / lattice.step) as usize);
        self.before(lattice, j) + i
    }

    /// The points of a lattice in order.
    pub(super) fn points_of(self, lattice: Lattice) -> impl Iterator<Item = [u32; 2]> {
        let Lattice { start, step } = lattice;
        (0..self.rows(lattice)).flat_map(move |j| {
            let width = self.before(lattice, j + 1) - self.before(lattice, j);
            (0..width).map(move |i| [start[0] + step * i as u32, start[1] + step * j as u32])
        })
    }

    /// Parameters of a point.
    pub(super) fn uv(self, point: [u32; 2]) -> [f64; 2] {
        point.map(|x| f64::from(x) / f64::from(self.cells))
    }

    /// The child that a point goes to; one of them where it lies between several.
    pub(super) fn child_of(self, [a, b]: [u32; 2]) -> usize {
        let half = |x: u32| 2 * x >= self.cells;
        match (self.split, half(a), half(b)) {
            (SplitKind::Quads, false, false) => 0,
            (SplitKind::Quads, true, true) => 2,
            (_, true, _) => 1,
            (SplitKind::Quads, ..) => 3,
            (SplitKind::Triangles, _, true) => 2,
            (SplitKind::Triangles, ..) if 2 * (a + b) > self.cells => 3,
            (SplitKind::Triangles, ..) => 0,
        }
    }

    /// A point in the parameters of the child that holds it.
    pub(super) fn in_child(self, child: usize, point: [u32; 2]) -> [u32; 2] {
        let n = self.cells;
        if self.split == SplitKind::Triangles && child == 3 {
            return point.map(|x| n - 2 * x);
        }
        let far = far_sides(self.split, child);
        [0, 1].map(|k| 2 * point[k] - if far[k] { n } else { 0 })
    }

    /// A point in parameters turned so that corner `turn` comes first.
    pub(super) fn turned(self, point: [u32; 2], turn: u8) -> [u32; 2] {
        if turn == 0 { point } else { self.turn(point, turn).map(|x| x as u32) }
    }

    /// As [`turned`](super::super::turn::turned), in cells.
    fn turn(self, point: [u32; 2], turn: u8) -> [i64; 2] {
        let ([a, b], n) = (point.map(i64::from), i64::from(self.cells));
        match (self.split, usize::from(turn) % corners(self.split)) {
            (_, 0) => [a, b],
            (SplitKind::Quads, 1) => [b, n - a],
            (SplitKind::Quads, 2) => [n - a, n - b],
            (SplitKind::Quads, _) => [n - b, a],
            (SplitKind::Triangles, 1) => [b, n - a - b],
            (SplitKind::Triangles, _) => [n - a - b, a],
        }
    }

    /// The lattice in a child; none where no point lies there.
    pub(super) fn lattice_in_child(self, lattice: Lattice, child: usize) -> Option<Lattice> {
        let (n, step) = (i64::from(self.cells), 2 * i64::from(lattice.step));
        let middle = self.split == SplitKind::Triangles && child == 3;
        let far = far_sides(self.split, child);
        let first = |k: usize| {
            let doubled = 2 * i64::from(lattice.start[k]);
            (if middle { n - doubled } else { doubled - if far[k] { n } else { 0 } }).rem_euclid(step)
        };
        self.lattice([first(0), first(1)], step)
    }

    /// The lattice in parameters turned so that corner `turn` comes first.
    pub(super) fn lattice_turned(self, lattice: Lattice, turn: u8) -> Option<Lattice> {
        let step = i64::from(lattice.step);
        self.lattice(self.turn(lattice.start, turn).map(|x| x.rem_euclid(step)), step)
    }

    fn lattice(self, start: [i64; 2], step: i64) -> Option<Lattice> {
        let n = i64::from(self.cells);
        // What has one line at most in each direction is the same for all larger steps.
        let made = Lattice { start: start.map(|x| x.min(n + 1) as u32), step: step.min(n + 1) as u32 };
        (start[0] <= n && start[1] <= n && self.len(made) > 0).then_some(made)
    }

    /// True where a lattice has no two lines in any direction.
    pub(super) fn is_single(self, lattice: Lattice) -> bool {
        lattice.step > self.cells
    }
}

impl Lattice {
    /// All points of a grid.
    pub const WHOLE: Self = Self { start: [0, 0], step: 1 };
}

/// True, for u and v, where a child begins in the middle.
fn far_sides(split: SplitKind, child: usize) -> [bool; 2] {
    match (split, child) {
        (_, 0) => [false, false],
        (_, 1) => [true, false],
        (SplitKind::Quads, 2) => [true, true],
        _ => [false, true],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grids() -> impl Iterator<Item = Grid> {
        [SplitKind::Quads, SplitKind::Triangles]
            .into_iter()
            .flat_map(|split| [1, 2, 3, 5, 8, 12].map(|cells| Grid { cells, split }))
    }

    /// All lattices that parts down to some depth have.
    fn lattices(grid: Grid) -> Vec<Lattice> {
        let mut all = vec![Lattice::WHOLE];
        let mut at = 0;
        while at < all.len() {
            for child in 0..4 {
                let turns = (0..corners(grid.split) as u8).filter_map(|turn| {
                    grid.lattice_in_child(all[at], child).and_then(|below| grid.lattice_turned(below, turn))
                });
                let new: Vec<Lattice> = turns.filter(|l| !all.contains(l)).collect();
                all.extend(new);
            }
            at += 1;
        }
        all
    }

    #[test]
    fn a_point_has_the_number_of_its_turn() {
        for grid in grids() {
            for lattice in lattices(grid) {
                let points: Vec<[u32; 2]> = grid.points_of(lattice).collect();
                assert_eq!(points.len(), grid.len(lattice));
                for (i, &point) in points.iter().enumerate() {
                    assert_eq!(grid.index_in(lattice, point), i, "{grid:?} {lattice:?} {point:?}");
                }
            }
        }
    }

    #[test]
    fn every_point_is_in_the_lattice_of_the_child_that_it_goes_to() {
        for grid in grids() {
            for lattice in lattices(grid) {
                for point in grid.points_of(lattice) {
                    let child = grid.child_of(point);
                    let (below, at) = (grid.lattice_in_child(lattice, child).unwrap(), grid.in_child(child, point));
                    for turn in 0..corners(grid.split) as u8 {
                        let (lattice, at) = (grid.lattice_turned(below, turn).unwrap(), grid.turned(at, turn));
                        let found = grid.points_of(lattice).nth(grid.index_in(lattice, at));
                        assert_eq!(found, Some(at), "{grid:?} {lattice:?}");
                    }
                }
            }
        }
    }
}
