//! From grids of values, face by face, to the order of a level's vertices: every face writes what is its own, the vertices inside
//! it and those of the edges and vertices that it is the first face of.

use super::face_rings::PLAIN;
use super::numbering::{Owner, Region};
use super::parts::{Task, Writer, write_by_faces};
use super::split::runs_forward;
use super::tile::Tile;
use super::uniform::Sources;
use super::values::{Filler, PADDING};
use crate::index::Face;
use crate::kernel::vectorized;
use crate::real::Real;
use std::ops::Range;

/// All values of the level.
pub(super) fn refine<T: Real, const N: usize>(sources: &Sources<'_, T>, values: &[[T; N]], out: &mut [[T; N]]) {
    let (t, regions) = (sources.control, &sources.numbering.regions);
    write_by_faces(t, regions, values, out, || Worker::new(sources, values));
}

impl<T: Real, const N: usize> Writer<T, N> for Worker<'_, T, N> {
    fn write(&mut self, task: Task<'_, T, N>) -> Vec<(u32, [T; N])> {
        vectorized(
            #[inline(always)]
            || self.write_all(task),
        )
    }
}

/// Consecutive vertices of a face in one part.
struct Run<'a> {
    part: usize,
    /// Vertices of the part for every half-edge or edge.
    each: usize,
    /// Their cells in order.
    cells: &'a [u32],
}

struct Worker<'a, T, const N: usize> {
    sources: &'a Sources<'a, T>,
    values: &'a [[T; N]],
    /// The vertices inside a face that is one tile, and inside a corner of another.
    inside: [Vec<Run<'a>>; 2],
    filler: Filler<'a, T, N>,
    ring: Vec<[T; N]>,
    /// Values of all cells of a face.
    grid: Vec<[T; N]>,
}

impl<'a, T: Real, const N: usize> Worker<'a, T, N> {
    fn new(sources: &'a Sources<'a, T>, values: &'a [[T; N]]) -> Self {
        let numbering = sources.numbering;
        let runs = |tile: &'a Tile| {
            let regions = numbering.regions.iter().zip(&tile.ranges).enumerate().skip(1);
            let inside = regions.filter(|(_, (region, range))| region.owner == Owner::HalfEdges && !range.is_empty());
            let run = |(k, (region, range)): (usize, (&Region, &Range<usize>))| Run {
                part: k - 1,
                each: region.each,
                cells: &tile.order[range.clone()],
            };
            inside.map(run).collect()
        };
        Self {
            sources,
            values,
            inside: [runs(&numbering.whole), runs(&numbering.corner)],
            filler: Filler::new(sources.trees, sources.maps),
            ring: Vec::new(),
            grid: Vec::new(),
        }
    }

    #[inline(always)]
    fn write_all(&mut self, task: Task<'_, T, N>) -> Vec<(u32, [T; N])> {
        let Sources { control: t, numbering, .. } = *self.sources;
        let Task { faces, first_edge, mut parts, edges } = task;
        let first_half_edge = t.face_offset[faces.start];
        let is_apart = !edges.is_empty();
        let mut edges = edges.iter_mut();
        let mut corners = Vec::new();
        for f in faces.clone().map(Face::new) {
            let sides = t.sides(f);
            self.fill(f, sides);
            let grid = &self.grid[..];
            let is_whole = numbering.is_whole(sides);
            let tile = if is_whole { &numbering.whole } else { &numbering.corner };
            let tiles = if is_whole { 1 } else { sides };
            let first = (t.first(f) - first_half_edge) as usize;
            for run in &self.inside[usize::from(!is_whole)] {
                let part = &mut parts[run.part][run.each * first..][..tiles * run.cells.len()];
                for (grid, part) in grid.chunks(tile.cells()).zip(part.chunks_exact_mut(run.cells.len())) {
                    part.iter_mut().zip(run.cells).for_each(|(value, &cell)| *value = grid[cell as usize]);
                }
            }
            if let Some(region) = numbering.centres {
                parts[region - 1][f.index() - faces.start] = grid[tile.centre];
            }
            for (side, h) in (0..sides).map(|side| (side, t.half_edge(f, side))) {
                let v = t.origin[h.index()];
                if t.vertex_half_edge[v as usize] == h.0 {
                    corners.push((v, grid[numbering.on_side(sides, side, 0)]));
                }
                let e = t.edge[h.index()];
                if t.edge_half_edge[e as usize] != h.0 {
                    continue;
                }
                let cells = numbering.side_cells(sides, side, runs_forward(t, h));
                if is_apart {
                    cells.iter().zip(&mut edges).for_each(|(&cell, value)| *value = grid[cell as usize]);
                    continue;
                }
                let mut cells = &cells[..];
                for &(region, each) in &numbering.edge_regions {
                    let (own, rest) = cells.split_at(each);
                    cells = rest;
                    let part = &mut parts[region - 1][each * (e as usize - first_edge)..][..each];
                    part.iter_mut().zip(own).for_each(|(value, &cell)| *value = grid[cell as usize]);
                }
            }
        }
        corners
    }

    /// Values of all cells of a face.
    #[inline(always)]
    fn fill(&mut self, f: Face, sides: usize) {
        let Sources { rings, numbering, .. } = *self.sources;
        let (group, ring) = (rings.group(f), rings.ring(f));
        let is_whole = numbering.is_whole(sides);
        let tile = if is_whole { &numbering.whole } else { &numbering.corner };
        self.grid.resize(tile.cells() * if is_whole { 1 } else { sides } + PADDING, [T::default(); N]);
        // A corner of the face.
        let base = self.values[ring[if group == PLAIN { 5 } else { 0 }] as usize];
        let apart = |v: u32| -> [T; N] {
            let p = &self.values[v as usize];
            std::array::from_fn(|c| p[c] - base[c])
        };
        if group == PLAIN {
            let ring: &[u32; 16] = ring.try_into().expect("a plain quad's ring has sixteen points");
            return self.filler.plain(&ring.map(apart), base, tile.size, &mut self.grid);
        }
        self.ring.clear();
        self.ring.extend(ring.iter().map(|&v| apart(v)));
        self.filler.root(group as usize, &self.ring, base, tile.size, &mut self.grid);
    }
}
