//! One step from level m ≥ 1 to the next, each vertex written where it is numbered: those inside control faces, on control
//! edges, and control vertices. All that lies inside a face or on an edge is a grid of quads of which at most one row is
//! sharp, so that only control vertices need to know their surroundings.

mod inside;
mod rows;
mod stars;

use super::super::numbering::{Counts, Owner, Region, along_edge, regions};
use super::super::tile::Tile;
use super::grid::{Grid, fine_slot};
use super::places::Places;
use super::rules::{RowGrid, SharpEdges, Special};
use super::sides::{Sides, Walk};
use crate::index::{Face, Vertex};
use crate::kernel::{RowRule, vectorized};
use crate::mask::{Mask, is_linear};
use crate::real::Real;
use crate::scheme::{Scheme, SplitKind};
use crate::topology::{FaceOf, Topology};
use inside::quads_at_once;
use rayon::prelude::*;
use rows::EDGES;
use stars::star;
use std::ops::Range;

/// Vertices that a task writes, about. Fixed; larger: uneven loads; smaller: overhead of tasks.
const CHUNK: usize = 4096;
/// Control vertices of a task: each of them takes a walk round it.
const VERTICES: usize = 512;
/// Vertices of a region that belong to one face or corner, in order.
struct Target {
    /// Among the parts of a task.
    part: usize,
    each: usize,
    /// Where their values are in the refined grid.
    slots: Vec<u32>,
}

/// One step.
pub(super) struct Step {
    from: Places,
    regions: Vec<Region>,
    /// Inside a quad, and inside a corner of any other face.
    whole: Vec<Target>,
    corner: Vec<Target>,
    /// The new vertices along an edge, region by region, as slots of the first edge of a row.
    along: Vec<u32>,
    smooth: RowRule<f64>,
    is_linear: bool,
    sharp: SharpEdges,
    special: Special,
}

/// What one task writes: consecutive elements, and by region of these their vertices.
struct Task<'a, V> {
    owner: Owner,
    elements: Range<usize>,
    parts: Vec<&'a mut [V]>,
}

impl Step {
    /// From level `level`, whose sharpness `t` has. `special` are the vertices that do not follow the smooth rule; rules of rows
    /// are read off `grids`.
    pub fn new(
        t: &Topology,
        sides: &Sides,
        scheme: Scheme,
        level: u32,
        special: &[u32],
        grids: &mut [RowGrid; 2],
    ) -> Self {
        let from = Places::new(Counts::of(t), level);
        let regions = regions(Counts::of(t), SplitKind::Quads, level + 1);
        let is_linear = is_linear(t, scheme);
        let (n, half) = (from.size, from.size / 2);
        let inside = |owner: Owner| owner == Owner::HalfEdges || owner == Owner::Faces;
        let part = |region: usize| regions[..region].iter().filter(|r| inside(r.owner)).count();
        let targets = |tile: &Tile, width: usize, rows: usize| -> Vec<Target> {
            let ranges =
                tile.ranges.iter().enumerate().filter(|(r, range)| inside(regions[*r].owner) && !range.is_empty());
            let slot = |&cell: &u32| {
                let (i, j) = (cell as usize % (tile.size + 1), cell as usize / (tile.size + 1));
                fine_slot(width, rows, [i, j]) as u32
            };
            let target = |(region, range): (usize, &Range<usize>)| Target {
                part: part(region),
                each: regions[region].each,
                slots: tile.order[range.clone()].iter().map(slot).collect(),
            };
            ranges.map(target).collect()
        };
        let whole = targets(&Tile::whole(SplitKind::Quads, level + 1), n + 1, (n + 1) * quads_at_once(n));
        let corner = targets(&Tile::corner(level + 1), half + 2, half + 1);
        let width = EDGES * (n + 1);
        let along = along_edge(level + 1).concat();
        let along = along.iter().map(|&place| fine_slot(width, 3, [place as usize, 2]) as u32).collect();
        let mut rows = Special::default();
        if !is_linear {
            let mut mask = Mask::default();
            special.iter().for_each(|&v| rows.push(v, star(t, sides, scheme, &from, Vertex(v), &mut mask).into_iter()));
        }
        Self {
            from,
            regions,
            whole,
            corner,
            along,
            smooth: grids[0].rule(0.0),
            is_linear,
            sharp: SharpEdges::new(t, scheme, grids),
            special: rows,
        }
    }

    /// The next level's values from those of this level.
    pub fn refine<T: Real, const N: usize>(&self, t: &Topology, sides: &Sides, values: &[[T; N]], out: &mut [[T; N]]) {
        if matches!(t.face, FaceOf::Quads) {
            self.run(Walk::<true> { t, sides }, values, out);
        } else {
            self.run(Walk::<false> { t, sides }, values, out);
        }
    }

    fn run<T: Real, const N: usize, const QUADS: bool>(
        &self,
        walk: Walk<'_, QUADS>,
        values: &[[T; N]],
        out: &mut [[T; N]],
    ) {
        let n = self.from.size;
        let scratch = || Scratch {
            quads: Vec::new(),
            face: Grid::new(n + 1, (n + 1) * quads_at_once(n)),
            corner: Grid::new(n / 2 + 2, n / 2 + 1),
            rows: Grid::new(EDGES * (n + 1), 3),
        };
        self.tasks(walk.t, out).into_par_iter().for_each_init(scratch, |scratch, mut task| match task.owner {
            Owner::Edges => vectorized(
                #[inline(always)]
                || self.edges(walk, values, &mut scratch.rows, &mut task),
            ),
            Owner::Vertices => vectorized(
                #[inline(always)]
                || self.vertices(walk, values, &mut task),
            ),
            Owner::Faces | Owner::HalfEdges => vectorized(
                #[inline(always)]
                || self.faces(walk, values, scratch, &mut task),
            ),
        });
    }

    /// The output in the parts of tasks.
    fn tasks<'a, V>(&self, t: &Topology, out: &'a mut [V]) -> Vec<Task<'a, V>> {
        let size = 2 * self.from.size;
        let cut = |owner: Owner, count: usize, each: usize| {
            let step = CHUNK.div_ceil(each);
            (0..count).step_by(step).map(move |start| Task {
                owner,
                elements: start..(start + step).min(count),
                parts: Vec::new(),
            })
        };
        let mut faces: Vec<Task<'a, V>> = cut(Owner::Faces, t.face_count(), size * size).collect();
        let mut edges: Vec<Task<'a, V>> = cut(Owner::Edges, t.edge_count(), size).collect();
        let mut vertices: Vec<Task<'a, V>> = cut(Owner::Vertices, t.vertex_count(), CHUNK / VERTICES).collect();
        let mut rest = out;
        for region in &self.regions {
            let tasks = match region.owner {
                Owner::Faces | Owner::HalfEdges => &mut faces,
                Owner::Edges => &mut edges,
                Owner::Vertices => &mut vertices,
            };
            for task in tasks {
                let Range { start, end } = task.elements;
                let elements = match region.owner {
                    Owner::HalfEdges => (t.face_offset[end] - t.face_offset[start]) as usize,
                    _ => end - start,
                };
                let (part, tail) = rest.split_at_mut(region.each * elements);
                rest = tail;
                task.parts.push(part);
            }
        }
        // Side by side what lies near each other, as most meshes are numbered, so that it is read once.
        faces.append(&mut edges);
        faces.append(&mut vertices);
        faces.sort_by_key(|task| {
            let count = match task.owner {
                Owner::Faces | Owner::HalfEdges => t.face_count(),
                Owner::Edges => t.edge_count(),
                Owner::Vertices => t.vertex_count(),
            };
            ((task.elements.start as u64) << 31) / count as u64
        });
        faces
    }

    /// Vertices with rules of their own.
    pub fn special(&self) -> usize {
        self.special.owners.len()
    }

    /// Of what grows with the control mesh.
    pub fn mesh_bytes(&self) -> usize {
        self.sharp.bytes() + self.special.bytes()
    }

    pub fn bytes(&self) -> usize {
        let slots = self.whole.iter().chain(&self.corner).map(|target| target.slots.len()).sum::<usize>();
        self.from.bytes() + 4 * (slots + self.along.len())
    }
}

/// Memory that is used again and again.
struct Scratch<T, const N: usize> {
    /// The quads whose grids follow each other.
    quads: Vec<Face>,
    face: Grid<T, N>,
    corner: Grid<T, N>,
    rows: Grid<T, N>,
}
