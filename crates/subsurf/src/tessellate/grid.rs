//! The samples of one patch of a uniform tessellation, in the order in which they are summed: inside the patch row by row,
//! then along some of its sides, then at its corners.
//!
//! ```text
//!   corner 3 ── side 2 ── corner 2        sides run from their corner to the next, corners left out;
//!      │                     │            under Loop there are three of each.
//!    side 3     inside     side 1         Grid point (i, j) lies at u = i / cells, v = j / cells
//!      │                     │            of the plan, whose corner 0 may be any corner of a face.
//!   corner 0 ── side 0 ── corner 1
//! ```

use super::patch_grid::PatchGrid;
use crate::kernel::LANES;
use std::ops::Range;

/// Which parts of a patch are wanted: bit `s` its side `s`, bit `4 + c` its corner `c`. The inside always is.
pub(super) type Parts = u8;

pub(super) const fn side(s: u8) -> Parts {
    1 << s
}

pub(super) const fn corner(c: u8) -> Parts {
    16 << c
}

/// Every side, no corner.
pub(super) const EVERY_SIDE: Parts = 0x0f;

/// Every side and corner.
pub(super) const ALL: Parts = 0xff;

#[derive(Debug)]
pub(super) struct GridSamples {
    cells: u32,
    is_triangle: bool,
    parts: Parts,
    /// Grid points.
    points: Vec<[u32; 2]>,
    inside: usize,
    side_at: [usize; 4],
    corner_at: [usize; 4],
    /// By block, the parts that have a sample in it; every one where samples inside do.
    block_parts: Vec<Parts>,
}

impl GridSamples {
    /// The samples inside a patch of `cells × cells` facets and on some of its sides and corners.
    pub fn new(cells: u32, is_triangle: bool, parts: Parts) -> Self {
        let grid = PatchGrid { cells: [cells; 2], first: 0, is_triangle };
        let mut points: Vec<[u32; 2]> = grid.interior().map(|(i, j)| [i, j]).collect();
        let sides: u8 = if is_triangle { 3 } else { 4 };
        let mut of_part = vec![ALL; points.len()];
        let inside = points.len();
        let (mut side_at, mut corner_at) = ([0; 4], [0; 4]);
        for s in (0..sides).filter(|&s| parts & side(s) != 0) {
            side_at[s as usize] = points.len();
            points.extend((1..cells).map(|k| on_side(is_triangle, cells, s, k)));
            of_part.resize(points.len(), side(s));
        }
        for c in (0..sides).filter(|&c| parts & corner(c) != 0) {
            corner_at[c as usize] = points.len();
            points.push(on_side(is_triangle, cells, c, 0));
            of_part.push(corner(c));
        }
        let block_parts = of_part.chunks(LANES).map(|parts| parts.iter().fold(0, |all, p| all | p)).collect();
        Self { cells, is_triangle, parts, points, inside, side_at, corner_at, block_parts }
    }

    pub fn len(&self) -> usize {
        self.points.len()
    }

    pub fn blocks(&self) -> usize {
        self.block_parts.len()
    }

    /// True where a block holds samples of some of these parts, or samples inside.
    #[inline(always)]
    pub fn uses(&self, block: usize, parts: Parts) -> bool {
        self.block_parts[block] == ALL || self.block_parts[block] & parts != 0
    }

    /// Number of samples along sides, all of them one after the other.
    pub fn along_sides(&self) -> usize {
        (self.parts & EVERY_SIDE).count_ones() as usize * (self.cells as usize - 1)
    }

    /// Number of samples inside, which come first.
    pub fn inside(&self) -> usize {
        self.inside
    }

    pub fn side(&self, s: usize) -> Range<usize> {
        self.side_at[s]..self.side_at[s] + self.cells as usize - 1
    }

    /// Grid points.
    pub fn points(&self) -> &[[u32; 2]] {
        &self.points
    }

    pub fn corner(&self, c: usize) -> usize {
        self.corner_at[c]
    }

    /// A grid point of a face whose corner `turn` is the plan's corner 0, in the plan.
    pub fn in_plan(is_triangle: bool, cells: u32, [i, j]: [u32; 2], turn: u8) -> [u32; 2] {
        let n = cells;
        match (is_triangle, turn) {
            (_, 0) => [i, j],
            (false, 1) => [j, n - i],
            (false, 2) => [n - i, n - j],
            (false, _) => [n - j, i],
            (true, 1) => [j, n - i - j],
            (true, _) => [n - i - j, i],
        }
    }

    /// Parameters in the plan.
    #[cfg(test)]
    fn uv(&self, sample: usize) -> [f64; 2] {
        self.points[sample].map(|k| f64::from(k) / f64::from(self.cells))
    }

    /// Parameters in a face whose corner `turn` is the plan's corner 0.
    pub fn uv_in_face(&self, sample: usize, turn: u8) -> [f64; 2] {
        let [a, b] = self.points[sample];
        let n = self.cells;
        let ij = match (self.is_triangle, turn) {
            (_, 0) => [a, b],
            (false, 1) => [n - b, a],
            (false, 2) => [n - a, n - b],
            (false, _) => [b, n - a],
            (true, 1) => [n - a - b, a],
            (true, _) => [b, n - a - b],
        };
        ij.map(|k| f64::from(k) / f64::from(n))
    }

    /// For every sample inside a face whose corner `turn` is the plan's corner 0, in the face's order, its place in the
    /// plan's.
    pub fn turned_inside(cells: u32, is_triangle: bool, turn: u8) -> Vec<u32> {
        let grid = PatchGrid { cells: [cells; 2], first: 0, is_triangle };
        let in_plan = |(i, j)| Self::in_plan(is_triangle, cells, [i, j], turn);
        grid.interior().map(in_plan).map(|[a, b]| grid.inner(a, b)).collect()
    }
}

/// Point `k` along a side.
fn on_side(is_triangle: bool, n: u32, s: u8, k: u32) -> [u32; 2] {
    match (is_triangle, s) {
        (_, 0) => [k, 0],
        (false, 1) => [n, k],
        (false, 2) => [n - k, n],
        (true, 1) => [n - k, k],
        _ => [0, n - k],
    }
}

/// A face's sides and corners as the plan numbers them, the plan's corner 0 being the face's corner `turn`.
pub(super) fn turned_parts(is_triangle: bool, parts: Parts, turn: u8) -> Parts {
    let (count, mask) = if is_triangle { (3, 0b111) } else { (4, 0b1111) };
    let turned = |bits: u8| ((bits & mask) >> turn | (bits & mask) << (count - turn)) & mask;
    turned(parts) | turned(parts >> 4) << 4
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_where_the_drawing_says() {
        for (is_triangle, sides) in [(false, 4u8), (true, 3)] {
            let samples = GridSamples::new(5, is_triangle, ALL);
            let point = |i: usize| samples.points[i];
            for s in 0..sides as usize {
                let [a, b] = [s, (s + 1) % sides as usize].map(|c| point(samples.corner(c)).map(i64::from));
                for (k, at) in samples.side(s).enumerate() {
                    let k = k as i64 + 1;
                    // The way from one corner to the next, in fifths.
                    assert_eq!(point(at).map(|x| 5 * i64::from(x)), [0, 1].map(|i| 5 * a[i] + k * (b[i] - a[i])));
                }
            }
            assert_eq!(samples.len(), if is_triangle { 21 } else { 36 });
        }
    }

    #[test]
    fn a_turned_face_finds_its_samples_in_the_plan() {
        for (is_triangle, sides) in [(false, 4u8), (true, 3)] {
            let samples = GridSamples::new(6, is_triangle, ALL);
            let plain: Vec<[f64; 2]> = (0..samples.inside()).map(|s| samples.uv(s)).collect();
            for turn in 0..sides {
                let table = GridSamples::turned_inside(6, is_triangle, turn);
                for (k, &s) in table.iter().enumerate() {
                    assert_eq!(samples.uv_in_face(s as usize, turn), plain[k], "turn {turn}");
                }
                // Side s of the face starts at its corner s, which is corner s - turn of the plan.
                for s in 0..sides {
                    let own = (s + sides - turn) % sides;
                    assert_eq!(turned_parts(is_triangle, side(s), turn), side(own));
                    let start = samples.uv_in_face(samples.corner(own as usize), turn);
                    assert_eq!(start, samples.uv(samples.corner(s as usize)));
                }
            }
        }
    }

    #[test]
    fn blocks_know_which_parts_they_hold() {
        let samples = GridSamples::new(8, false, ALL);
        assert_eq!((samples.inside(), samples.blocks()), (49, 6));
        for s in 0..4 {
            for at in samples.side(s as usize) {
                assert!(samples.uses(at / LANES, side(s)));
            }
        }
        assert!(samples.uses(0, 0) && samples.uses(3, 0) && !samples.uses(4, 0));
    }
}
