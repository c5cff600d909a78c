//! Points of a grid over a face, in cells, and where they lie in the parts of a patch tree: in the part's own parameters, again
//! in cells. Halving keeps them whole numbers.

use super::corners;
use crate::scheme::SplitKind;

/// A grid of `cells` facets a side.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Grid {
    pub cells: u32,
    pub split: SplitKind,
}

impl Grid {
    /// Parameters of a point.
    pub fn uv(self, point: [u32; 2]) -> [f64; 2] {
        point.map(|x| f64::from(x) / f64::from(self.cells))
    }

    /// The child that a point goes to; one of them where it lies between several.
    #[inline]
    pub fn child_of(self, [a, b]: [u32; 2]) -> usize {
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
    #[inline]
    pub fn in_child(self, child: usize, point: [u32; 2]) -> [u32; 2] {
        let n = self.cells;
        let far = match (self.split, child) {
            (SplitKind::Triangles, 3) => return point.map(|x| n - 2 * x),
            (_, 0) => [0, 0],
            (_, 1) => [n, 0],
            (SplitKind::Quads, 2) => [n, n],
            _ => [0, n],
        };
        [2 * point[0] - far[0], 2 * point[1] - far[1]]
    }

    /// A point in parameters turned so that corner `turn` comes first, as [`turned`](super::turned).
    #[inline]
    pub fn turned(self, [a, b]: [u32; 2], turn: u8) -> [u32; 2] {
        let n = self.cells;
        match (self.split, usize::from(turn) % corners(self.split)) {
            (_, 0) => [a, b],
            (SplitKind::Quads, 1) => [b, n - a],
            (SplitKind::Quads, 2) => [n - a, n - b],
            (SplitKind::Quads, _) => [n - b, a],
            (SplitKind::Triangles, 1) => [b, n - a - b],
            (SplitKind::Triangles, _) => [n - a - b, a],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Place, turned};
    use super::*;

    #[test]
    fn points_lie_where_their_parameters_do() {
        for split in [SplitKind::Quads, SplitKind::Triangles] {
            for cells in [1, 2, 4, 8, 32] {
                let grid = Grid { cells, split };
                let all = (0..=cells).flat_map(|j| (0..=cells).map(move |i| [i, j]));
                for point in all.filter(|p| split == SplitKind::Quads || p[0] + p[1] <= cells) {
                    // Powers of two: parameters are exact.
                    let [u, v] = grid.uv(point);
                    let child = grid.child_of(point);
                    let below = grid.in_child(child, point);
                    let start = Place { u, v, turn: 0, depth: 0, raise: 0, speed: 1.0 };
                    let (number, at) = start.descend(split);
                    assert_eq!((number, [at.u, at.v]), (child, grid.uv(below)), "{grid:?} {point:?}");
                    for turn in 0..corners(split) as u8 {
                        let (a, b) = turned(split, u, v, turn);
                        assert_eq!([a, b], grid.uv(grid.turned(point, turn)), "{grid:?} {point:?} turn {turn}");
                    }
                }
            }
        }
    }
}
