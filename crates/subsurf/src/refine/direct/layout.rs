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
    /// Of these, how many come before.
    pub skip: usize,
    pub count: usize,
}

/// What lies along a control edge.
pub(super) struct Side {
    /// Where its points start in [`Layout::points`].
    pub start: usize,
    /// Of a half-edge that runs with its edge, and of one that runs against it.
    pub runs: [Vec<Run>; 2],
    /// The points of the latter.
    pub backward: Vec<u32>,
}

/// What a side takes of its edge, for each direction.
struct Order {
    points: [Vec<[usize; 2]>; 2],
    /// By region of edges: how many of an edge's vertices come before, and how many are taken.
    shares: [Vec<(usize, usize)>; 2],
}

/// The order in which a square's points are written.
pub(super) struct Layout {
    /// Places in the lattice of the last level: those inside, along sides, and at corners; then others, up to whole sixteens
    /// whatever the number of components.
    pub points: Vec<u32>,
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
        let whole: Vec<(usize, usize)> = places.iter().map(|places| (0, places.len())).collect();
        let sides = (0..4).map(|side| {
            let points = |backward: bool| {
                let along = places.iter().flatten().map(move |&i| if backward { end - i as usize } else { i as usize });
                along.map(move |i| cell(side, i)).collect()
            };
            Order { points: [points(false), points(true)], shares: [whole.clone(), whole.clone()] }
        });
        Self::new(regions, &Tile::whole(SplitKind::Quads, depth), end, sides.collect())
    }

    /// Corners of other faces.
    pub fn corner(regions: &[Region], depth: u32) -> Self {
        let end = 1usize << (depth - 1);
        let places = along_edge(depth);
        // The first half of each region's places is near an edge's first end; the first region is the middle.
        let half = |is_second: bool, has_middle: bool| -> Vec<(usize, usize)> {
            let deeper = (1..depth).map(|m| (usize::from(is_second) << (m - 1), 1 << (m - 1)));
            [(0, usize::from(has_middle))].into_iter().chain(deeper).collect()
        };
        let points = |shares: &[(usize, usize)], is_second: bool| -> Vec<usize> {
            let along = places.iter().zip(shares).flat_map(|(places, &(skip, count))| &places[skip..skip + count]);
            along.map(|&i| if is_second { 2 * end - i as usize } else { i as usize }).collect()
        };
        // Its own half-edge starts here, the one before ends here.
        let order = |seconds: [bool; 2], has_middle: bool, cell: fn(usize) -> [usize; 2]| {
            let shares = seconds.map(|is_second| half(is_second, has_middle));
            let points = [0, 1].map(|k| points(&shares[k], seconds[k]).into_iter().map(cell).collect());
            Order { points, shares }
        };
        let sides = vec![order([false, true], true, |i| [i, 0]), order([true, false], false, |i| [0, i])];
        Self::new(regions, &Tile::corner(depth), end, sides)
    }

    fn new(regions: &[Region], tile: &Tile, end: usize, sides: Vec<Order>) -> Self {
        let point = |[i, j]: [usize; 2]| lattice_point(end, i as isize, j as isize) as u32;
        let (mut points, mut inside) = (Vec::new(), Vec::new());
        for (k, (region, range)) in
            regions.iter().zip(&tile.ranges).enumerate().filter(|(_, (_, range))| !range.is_empty())
        {
            inside.push(Run { part: k - 1, each: region.each, skip: 0, count: range.len() });
            let cells = tile.order[range.clone()].iter().map(|&cell| cell as usize);
            points.extend(cells.map(|cell| point([cell % (end + 1), cell / (end + 1)])));
        }
        let mut out_sides = Vec::new();
        for Order { points: [forward, backward], shares } in sides {
            let runs = shares.map(|shares| {
                let edges = regions.iter().enumerate().filter(|(_, region)| region.owner == Owner::Edges);
                let runs = edges.zip(shares).map(|((k, region), (skip, count))| Run {
                    part: k - 1,
                    each: region.each,
                    skip,
                    count,
                });
                runs.filter(|run| run.count > 0).collect()
            });
            out_sides.push(Side { start: points.len(), runs, backward: backward.into_iter().map(point).collect() });
            points.extend(forward.into_iter().map(point));
        }
        let corners = points.len();
        points.extend([[0, 0], [end, 0], [end, end], [0, end]].map(point));
        points.resize(points.len().next_multiple_of(LANES), 0);
        Self { points, inside, sides: out_sides, corners }
    }

    pub fn bytes(&self) -> usize {
        let runs = |runs: &Vec<Run>| size_of_val(&runs[..]);
        let side = |side: &Side| 4 * side.backward.len() + side.runs.iter().map(runs).sum::<usize>();
        4 * self.points.len() + runs(&self.inside) + self.sides.iter().map(side).sum::<usize>()
    }
}
