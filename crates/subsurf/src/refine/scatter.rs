//! From grids of values, face by face, to the order of a level's vertices: every face writes what is its own, the vertices inside
//! it and those of the edges and vertices that it is the first face of.

use super::face_rings::PLAIN;
use super::numbering::{Owner, Region};
use super::split::runs_forward;
use super::tile::Tile;
use super::uniform::{Sources, zeroed};
use super::values::{Filler, PADDING};
use crate::index::Face;
use crate::kernel::vectorized;
use crate::real::Real;
use rayon::prelude::*;
use std::ops::Range;

/// Control faces of a task. Fixed; larger: uneven loads; smaller: overhead of tasks.
const CHUNK: usize = 256;

/// Values of the vertices that some faces own.
struct Task<'a, T, const N: usize> {
    faces: Range<usize>,
    /// The first of the edges that these faces own, in the order of owners.
    first_edge: usize,
    /// By region of faces, half-edges or edges: the part that belongs to these faces.
    parts: Vec<&'a mut [[T; N]]>,
    /// Where edges are not numbered in the order of their owners: their values, edge by edge.
    edges: &'a mut [[T; N]],
}

/// All values of the level.
pub(super) fn refine<T: Real, const N: usize>(sources: &Sources<'_, T>, values: &[[T; N]], out: &mut [[T; N]]) {
    let t = sources.control;
    let regions = &sources.numbering.regions;
    let owners = &t.edge_half_edge;
    let sorted = (!owners.is_sorted()).then(|| {
        let mut sorted: Vec<(u32, u32)> = owners.iter().zip(0..).map(|(&h, e)| (h, e)).collect();
        sorted.par_sort_unstable();
        sorted
    });
    let owned_before = |h: u32| match &sorted {
        None => owners.partition_point(|&owner| owner < h),
        Some(sorted) => sorted.partition_point(|&(owner, _)| owner < h),
    };
    let per_edge = (1 << sources.trees.tiers.len()) - 1;
    let mut edge_values = zeroed(if sorted.is_some() { per_edge * t.edge_count() } else { 0 });

    // Cut the output into regions, and these into the parts of tasks.
    let (vertices, mut rest) = out.split_at_mut(t.vertex_count());
    vertices.copy_from_slice(values);
    let mut edge_rest = &mut edge_values[..];
    let mut edge_regions = Vec::new();
    let mut tasks: Vec<Task<'_, T, N>> = Vec::with_capacity(t.face_count().div_ceil(CHUNK));
    let mut edge = 0;
    for start in (0..t.face_count()).step_by(CHUNK) {
        let faces = start..(start + CHUNK).min(t.face_count());
        let end = owned_before(t.face_offset[faces.end]);
        let own = if sorted.is_some() { per_edge * (end - edge) } else { 0 };
        let (edges, tail) = edge_rest.split_at_mut(own);
        edge_rest = tail;
        tasks.push(Task { faces, first_edge: edge, parts: Vec::with_capacity(regions.len()), edges });
        edge = end;
    }
    let ends: Vec<usize> = tasks.iter().skip(1).map(|task| task.first_edge).chain([edge]).collect();
    for region in &regions[1..] {
        if region.owner == Owner::Edges && sorted.is_some() {
            let (part, tail) = rest.split_at_mut(region.each * t.edge_count());
            rest = tail;
            edge_regions.push(part);
        }
        for (task, &edge_end) in tasks.iter_mut().zip(&ends) {
            let count = match region.owner {
                Owner::Faces => task.faces.len(),
                Owner::HalfEdges => (t.face_offset[task.faces.end] - t.face_offset[task.faces.start]) as usize,
                Owner::Edges if sorted.is_none() => edge_end - task.first_edge,
                Owner::Edges | Owner::Vertices => 0,
            };
            let (part, tail) = rest.split_at_mut(region.each * count);
            rest = tail;
            task.parts.push(part);
        }
    }

    let corners: Vec<Vec<(u32, [T; N])>> =
        tasks.into_par_iter().map_init(|| Worker::new(sources, values), Worker::run).collect();
    corners.iter().flatten().for_each(|&(v, value)| vertices[v as usize] = value);
    if let Some(sorted) = sorted {
        let mut rank = vec![0u32; sorted.len()];
        sorted.iter().zip(0..).for_each(|(&(_, e), at)| rank[e as usize] = at);
        let mut skip = 0;
        for region in edge_regions {
            let each = region.len() / t.edge_count();
            region.par_chunks_mut(each).zip(&rank).with_min_len(CHUNK).for_each(|(part, &rank)| {
                part.copy_from_slice(&edge_values[per_edge * rank as usize + skip..][..each]);
            });
            skip += each;
        }
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

    /// Writes a task's parts; returns the values of the control vertices that its faces own.
    fn run(&mut self, task: Task<'_, T, N>) -> Vec<(u32, [T; N])> {
        vectorized(
            #[inline(always)]
            || self.write(task),
        )
    }

    #[inline(always)]
    fn write(&mut self, task: Task<'_, T, N>) -> Vec<(u32, [T; N])> {
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
