//! The points of a grid that lie in a node of a patch tree, in the node's parameters.
//!
//! Over a quad they are the crossings of two families of lines, however deep the node lies and however it is turned: two
//! numbers a family say which. Halves of triangles are no such crossings, so that points are listed there.

use super::super::grid::Grid;
use crate::scheme::SplitKind;
use crate::topology::NONE;

/// A grid point in the parameters of a node, and its number among those that are wanted.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Sample {
    pub number: u32,
    pub at: [u32; 2],
}

/// Points of a grid over a face that are wanted, by their numbers.
pub(crate) struct GridPoints(Wanted);

enum Wanted {
    /// By grid point of the face, row by row, its number; and which corner of the face is the plan's corner 0.
    Crossings { numbers: Vec<u32>, turn: u8 },
    /// Those of the plan.
    List(Vec<Sample>),
}

impl GridPoints {
    /// Points of a face of `cells` facets a side, whose corner `turn` is the corner 0 of its plan; numbered as they come.
    pub fn new(points: &[[u32; 2]], cells: u32, split: SplitKind, turn: u8) -> Self {
        let grid = Grid { cells, split };
        let numbered = (0..).zip(points);
        Self(match split {
            SplitKind::Quads => {
                let lines = cells as usize + 1;
                let mut numbers = vec![NONE; lines * lines];
                numbered.for_each(|(number, &[i, j])| numbers[j as usize * lines + i as usize] = number);
                Wanted::Crossings { numbers, turn }
            }
            SplitKind::Triangles => {
                let list = numbered.map(|(number, &at)| Sample { number, at: grid.turned(at, turn) });
                Wanted::List(list.collect())
            }
        })
    }

    /// All of them.
    pub(super) fn region(&self, cells: u32) -> Region<'_> {
        match &self.0 {
            Wanted::List(list) => Region::List(list),
            Wanted::Crossings { numbers, turn } => {
                let n = cells as i32;
                let axis = |stride: i32| Axis { start: 0, step: 1, count: n + 1, stride };
                let all = Crossings { numbers, first: 0, axes: [axis(1), axis(n + 1)] };
                Region::Crossings(all.turned(n, *turn))
            }
        }
    }
}

/// Those in a node.
#[derive(Clone, Copy)]
pub(super) enum Region<'s> {
    Crossings(Crossings<'s>),
    List(&'s [Sample]),
}

/// Lines of equal u, and lines of equal v; some of their crossings are wanted.
#[derive(Clone, Copy)]
pub(super) struct Crossings<'s> {
    numbers: &'s [u32],
    /// Where the crossing of the first two lines stands in `numbers`.
    first: i32,
    axes: [Axis; 2],
}

/// A family of lines, in cells of the grid. There are fewer than 2¹⁶ cells, as their points have numbers of 32 bits.
#[derive(Clone, Copy)]
struct Axis {
    start: i32,
    /// A power of two, or the negative of one; anything where there are less than two lines.
    step: i32,
    count: i32,
    /// From line to line in the numbers.
    stride: i32,
}

impl Axis {
    /// Below or above the middle of `n` cells, in the parameters of that half; the middle lies above. With the number of the first
    /// line.
    #[inline(always)]
    fn half(self, n: i32, is_above: bool) -> (i32, Self) {
        let Self { start, step, count, .. } = self;
        let is_up = step > 0;
        let shift = step.unsigned_abs().trailing_zeros() + 1;
        // Lines come from below or from above; so many lie in the half where they begin.
        let there = if is_up { (n - 2 * start + 2 * step - 1) >> shift } else { ((2 * start - n) >> shift) + 1 };
        let there = there.clamp(0, count);
        let (first, count) = if is_up == is_above { (there, count - there) } else { (0, there) };
        let start = 2 * (start + first * step) - if is_above { n } else { 0 };
        // Steps that nothing takes are kept from growing.
        (first, Self { start, step: if count > 1 { 2 * step } else { 1 }, count, ..self })
    }

    /// Counted from the other end of `n` cells.
    #[inline(always)]
    fn reversed(self, n: i32) -> Self {
        Self { start: n - self.start, step: -self.step, ..self }
    }

    #[inline(always)]
    fn at(self, line: i32) -> u32 {
        (self.start + line * self.step) as u32
    }
}

impl<'s> Crossings<'s> {
    /// As [`Grid::turned`].
    #[inline(always)]
    pub fn turned(self, n: i32, turn: u8) -> Self {
        let [u, v] = self.axes;
        let axes = match turn {
            0 => [u, v],
            1 => [v, u.reversed(n)],
            2 => [u.reversed(n), v.reversed(n)],
            _ => [v.reversed(n), u],
        };
        Self { axes, ..self }
    }

    /// Those in a child.
    #[inline(always)]
    pub fn child(self, n: i32, child: usize) -> Self {
        let [u, v] = self.axes;
        let ((line, u), (row, v)) = (u.half(n, child == 1 || child == 2), v.half(n, child >= 2));
        let first = self.first + line * self.axes[0].stride + row * self.axes[1].stride;
        Self { first, axes: [u, v], ..self }
    }

    /// True where none is wanted.
    #[inline(always)]
    pub fn is_empty(self) -> bool {
        (0..self.rows()).all(|row| self.row(row).is_empty())
    }

    /// Number of lines of equal v.
    #[inline(always)]
    pub fn rows(self) -> i32 {
        self.axes[1].count
    }

    /// One of these lines.
    #[inline(always)]
    pub fn row(self, row: i32) -> Row<'s> {
        let [u, v] = self.axes;
        let first = self.first + row * v.stride;
        Row { v: v.at(row), u, numbers: self.numbers, first }
    }
}

/// The points on a line of equal v.
#[derive(Clone, Copy)]
pub(super) struct Row<'s> {
    pub v: u32,
    u: Axis,
    numbers: &'s [u32],
    first: i32,
}

impl Row<'_> {
    #[inline(always)]
    fn number(self, line: i32) -> u32 {
        self.numbers[(self.first + line * self.u.stride) as usize]
    }

    /// True where none is wanted.
    #[inline(always)]
    pub fn is_empty(self) -> bool {
        let mut all = NONE;
        for line in 0..self.u.count {
            all &= self.number(line);
        }
        all == NONE
    }

    /// Calls `f` with the number and u of every point that is wanted.
    #[inline(always)]
    pub fn each(self, mut f: impl FnMut(u32, u32)) {
        for line in 0..self.u.count {
            let number = self.number(line);
            if number != NONE {
                f(number, self.u.at(line));
            }
        }
    }
}

impl Region<'_> {
    /// Calls `f` with every point.
    #[inline(always)]
    pub fn each(self, mut f: impl FnMut(Sample)) {
        match self {
            Region::List(list) => {
                for &sample in list {
                    f(sample);
                }
            }
            Region::Crossings(crossings) => {
                for row in 0..crossings.rows() {
                    let row = crossings.row(row);
                    row.each(
                        #[inline(always)]
                        |number, u| f(Sample { number, at: [u, row.v] }),
                    );
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossings_go_to_the_children_that_their_points_go_to() {
        fn check(region: Crossings<'_>, list: &[Sample], grid: Grid, depth: u32) {
            let mut all = Vec::new();
            Region::Crossings(region).each(|sample| all.push(sample));
            let sorted = |list: &[Sample]| {
                let mut list = list.to_vec();
                list.sort_by_key(|sample| sample.number);
                list
            };
            assert_eq!(sorted(&all), sorted(list), "depth {depth}");
            assert_eq!(region.is_empty(), list.is_empty());
            if depth == 5 {
                return;
            }
            for number in 0..4 {
                let child = region.child(grid.cells as i32, number);
                let turn = (depth as u8 + number as u8) % 4;
                let inside = list.iter().filter(|sample| grid.child_of(sample.at) == number);
                let below = |s: &Sample| Sample { at: grid.turned(grid.in_child(number, s.at), turn), ..*s };
                check(child.turned(grid.cells as i32, turn), &inside.map(below).collect::<Vec<_>>(), grid, depth + 1);
            }
        }
        for cells in [1, 3, 8, 12] {
            let grid = Grid { cells, split: SplitKind::Quads };
            // Every third point is not wanted.
            let points: Vec<[u32; 2]> =
                (0..=cells).flat_map(|j| (0..=cells).map(move |i| [i, j])).filter(|[i, j]| (i + j) % 3 > 0).collect();
            for turn in 0..4 {
                let list: Vec<Sample> =
                    (0..).zip(&points).map(|(number, &at)| Sample { number, at: grid.turned(at, turn) }).collect();
                let wanted = GridPoints::new(&points, cells, SplitKind::Quads, turn);
                let Region::Crossings(region) = wanted.region(cells) else { unreachable!("quads") };
                check(region, &list, grid, 0);
            }
        }
    }
}
