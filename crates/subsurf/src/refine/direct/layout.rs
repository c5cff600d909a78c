//! Where the points of a refined square go: a square is a control quad or the corner of another face, with
//!
//! ```text
//!   3: E(prev h) ── 2: centre            side 0 from corner 0 to 1, and so on; side 0 runs along h, side 3 against
//!       │              │  spoke of h     prev(h) reversed. A quad's corners are its vertices, h its first half-edge.
//!   0: V ────────── 1: E(h)
//! ```

use super::super::numbering::{Owner, Region, along_edge};
use super::super::tile::Tile;
use crate::kernel::{LANES, lattice_point};
use crate::scheme::SplitKind;

/// Consecutive points of a square that follow each other in a region.
pub(super) struct Run {
    /// Among the parts of a task.
    pub part: usize,
    /// Vertices of the region for every element.
    pub each: usize,
    /// Of these, how many come before: where a half-edge runs with its edge, and where it runs against it.
    pub skip: [usize; 2],
    pub count: usize,
}

/// What lies along a control edge, from the middle out: the halves of an edge are numbered alike, so that a half-edge that runs
/// against its edge only changes places with the other.
pub(super) struct Side {
    /// Where its points start in [`Layout::points`].
    pub start: usize,
    pub runs: Vec<Run>,
}

/// What a side takes of its edge.
struct Order {
    points: Vec<[usize; 2]>,
    /// The region of edges among these, and the rest of a [`Run`].
    runs: Vec<(usize, [usize; 2], usize)>,
}

/// The order in which a square's points are written.
pub(super) struct Layout {
    /// Places in the lattice of the last level: those inside, along sides, and at corners.
    pub points: Vec<u32>,
    /// Points from one square to the next, in whole sixteens whatever the number of components.
    pub stride: usize,
    pub inside: Vec<Run>,
    /// Of a quad the four sides; of a corner the half of its own half-edge, with its middle, and that of the one before.
    pub sides: Vec<Side>,
    /// Where corners start.
    pub corners: usize,
}

impl Layout {
    /// Control quads at level `depth`, whose regions these are.
    pub fn quad(regions: &[Region], depth: u32) -> Self {
        let end = 1usize << depth;
        let places = along_edge(depth);
        let cell = |side: usize, along: usize| match side {
            0 => [along, 0],
            1 => [end, along],
            2 => [end - along, end],
            _ => [0, end - along],
        };
        let halves = |half: usize| [[0, half], [half, 0]].map(|skip| (half, skip));
        let runs = (1..depth as usize).flat_map(|m| halves(1 << (m - 1)).map(|(half, skip)| (m, skip, half)));
        let runs: Vec<_> = [(0, [0, 0], 1)].into_iter().chain(runs).collect();
        let sides = (0..4).map(|side| Order {
            points: places.iter().flatten().map(|&i| cell(side, i as usize)).collect(),
            runs: runs.clone(),
        });
        Self::new(regions, &Tile::whole(SplitKind::Quads, depth), end, sides.collect())
    }

    /// Corners of other faces.
    pub fn corner(regions: &[Region], depth: u32) -> Self {
        let end = 1usize << (depth - 1);
        let places = along_edge(depth);
        // The first half of each region's places is near an edge's first end; the first region is the middle.
        let halves = || places.iter().enumerate().skip(1).map(|(m, places)| (m, places.len() / 2, places));
        let along = || halves().flat_map(|(_, half, places)| &places[..half]).map(|&i| i as usize);
        let runs = |is_second: bool| {
            halves().map(move |(m, half, _)| (m, if is_second { [half, 0] } else { [0, half] }, half))
        };
        // Its own half-edge starts here, the one before ends here.
        let own = Order {
            points: [end].into_iter().chain(along()).map(|i| [i, 0]).collect(),
            runs: [(0, [0, 0], 1)].into_iter().chain(runs(false)).collect(),
        };
        let before = Order { points: along().map(|i| [0, i]).collect(), runs: runs(true).collect() };
        Self::new(regions, &Tile::corner(depth), end, vec![own, before])
    }

    fn new(regions: &[Region], tile: &Tile, end: usize, sides: Vec<Order>) -> Self {
        let point = |[i, j]: [usize; 2]| lattice_point(end, i as isize, j as isize) as u32;
        let (mut points, mut inside) = (Vec::new(), Vec::new());
        for (k, (region, range)) in
            regions.iter().zip(&tile.ranges).enumerate().filter(|(_, (_, range))| !range.is_empty())
        {
            inside.push(Run { part: k - 1, each: region.each, skip: [0, 0], count: range.len() });
            let cells = tile.order[range.clone()].iter().map(|&cell| cell as usize);
            points.extend(cells.map(|cell| point([cell % (end + 1), cell / (end + 1)])));
        }
        let edges: Vec<_> = (0..regions.len()).filter(|&k| regions[k].owner == Owner::Edges).collect();
        let run = |(m, skip, count): (usize, [usize; 2], usize)| Run {
            part: edges[m] - 1,
            each: regions[edges[m]].each,
            skip,
            count,
        };
        let mut out_sides = Vec::new();
        for Order { points: along, runs } in sides {
            out_sides.push(Side { start: points.len(), runs: runs.into_iter().map(run).collect() });
            points.extend(along.into_iter().map(point));
        }
        let corners = points.len();
        points.extend([[0, 0], [end, 0], [end, end], [0, end]].map(point));
        let stride = points.len().next_multiple_of(LANES);
        Self { points, stride, inside, sides: out_sides, corners }
    }

    pub fn bytes(&self) -> usize {
        let sides = self.sides.iter().map(|side| size_of_val(&side.runs[..]));
        4 * self.points.len() + size_of_val(&self.inside[..]) + sides.sum::<usize>()
    }
}
