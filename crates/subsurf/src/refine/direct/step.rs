//! One step from level m ≥ 1 to the next, each vertex written where it is numbered: those inside control faces, on control
//! edges, and control vertices. All that lies inside a face or on an edge is a grid of quads of which at most one row is
//! sharp, so that only control vertices need to know their surroundings.

use super::super::numbering::{Counts, Owner, Region, along_edge, regions};
use super::super::tile::Tile;
use super::grid::{Grid, fine_slot};
use super::places::Places;
use super::rules::{RowGrid, SharpEdges, Special, fan, rounded};
use super::sides::{Sides, Walk};
use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::kernel::{RowRule, vectorized};
use crate::mask::{Mask, is_linear, vertex_mask};
use crate::real::Real;
use crate::scheme::catmull_clark::smooth_neighbour;
use crate::scheme::{Scheme, SplitKind};
use crate::topology::{FaceOf, NONE, Topology};
use rayon::prelude::*;
use std::ops::Range;

/// Vertices that a task writes, about. Fixed; larger: uneven loads; smaller: overhead of tasks.
const CHUNK: usize = 4096;
/// Control vertices of a task: each of them takes a walk round it.
const VERTICES: usize = 512;
/// Edges whose rows are refined side by side. Larger: more than the nearest cache holds; smaller: vectors that are not full.
const EDGES: usize = 16;

/// Quads whose grids are refined one after the other at once, by the pieces of their edges: some 256 points. Larger: more than
/// the nearest cache holds; smaller: vectors that are not full.
fn quads_at_once(size: usize) -> usize {
    (256 / ((size + 1) * (size + 1))).max(1)
}

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

    #[inline(always)]
    fn faces<T: Real, const N: usize, const QUADS: bool>(
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

    #[inline(always)]
    fn edges<T: Real, const N: usize, const QUADS: bool>(
        &self,
        walk: Walk<'_, QUADS>,
        values: &[[T; N]],
        grid: &mut Grid<T, N>,
        task: &mut Task<'_, [T; N]>,
    ) {
        let (rule, from, t) = (rounded(&self.smooth), &self.from, walk.t);
        let (n, width) = (from.size, grid.width);
        let first_edge = task.elements.start;
        for start in task.elements.clone().step_by(EDGES) {
            let some = start..(start + EDGES).min(task.elements.end);
            for (i, e) in some.clone().map(Edge::new).enumerate() {
                let column = i * (n + 1);
                let row = &mut grid.ids[width + column..][..n + 1];
                [row[0], row[n]] = t.edge_vertices[e.index()];
                for (v, &(start, each)) in row[1..n].iter_mut().zip(from.along(false)) {
                    *v = start + each * e.0;
                }
                let h = HalfEdge(t.edge_half_edge[e.index()]);
                from.beside(walk, h, &mut grid.ids[column..][..n + 1]);
                // Where there is one face only, what is taken to lie beyond does not matter.
                from.beside(walk, walk.across(h), &mut grid.ids[2 * width + column..][..n + 1]);
            }
            grid.read(3, values);
            grid.refine(3, &rule, false);
            for &(e, rule) in self.sharp.among(some.start as u32..some.end as u32) {
                grid.refine_row(&self.sharp.rule(rule), (e as usize - start) * (n + 1), n);
            }
            let mut slots = &self.along[..];
            for (region, part) in task.parts.iter_mut().enumerate() {
                let (own, rest) = slots.split_at(1 << region);
                slots = rest;
                let part = &mut part[(start - first_edge) << region..][..some.len() << region];
                for (i, out) in part.chunks_exact_mut(own.len()).enumerate() {
                    let column = (i * (n + 1)) as u32;
                    out.iter_mut().zip(own).for_each(|(out, &slot)| *out = grid.fine[(slot + column) as usize]);
                }
            }
        }
    }

    #[inline(always)]
    fn vertices<T: Real, const N: usize, const QUADS: bool>(
        &self,
        walk: Walk<'_, QUADS>,
        values: &[[T; N]],
        task: &mut Task<'_, [T; N]>,
    ) {
        let elements = task.elements.clone();
        let (own, out) = (&values[elements.clone()], &mut *task.parts[0]);
        if self.is_linear {
            return out.copy_from_slice(own);
        }
        for ((out, v), own) in out.iter_mut().zip(elements.start as u32..).zip(own) {
            let (mut ends, mut diagonals, mut valence) = ([T::default(); N], [T::default(); N], 0);
            let first = walk.t.vertex_half_edge[v as usize];
            let mut h = first;
            while h != NONE {
                let end = &values[self.from.on_half_edge(walk, HalfEdge(h), 1) as usize];
                let beside = walk.beside(HalfEdge(h));
                let diagonal = &values[self.from.diagonal(HalfEdge(h), &beside) as usize];
                for c in 0..N {
                    ends[c] = ends[c] + (end[c] - own[c]);
                    diagonals[c] = diagonals[c] + (diagonal[c] - own[c]);
                }
                valence += 1;
                h = walk.t.twin[beside.prev.index()];
                if h == first {
                    break;
                }
            }
            *out = smooth_sum(own, &ends, &diagonals, valence);
        }
        for row in self.special.among(elements.start as u32..elements.end as u32) {
            let value = |id: u32| values[id as usize];
            out[self.special.owners[row] as usize - elements.start] = self.special.apply(row, value);
        }
    }

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

/// A smooth vertex from the ends of its edges and the vertices across its faces, relative to its own value. Each centroid is the
/// mean of the vertex, two ends and the vertex across.
#[inline(always)]
fn smooth_sum<T: Real, const N: usize>(own: &[T; N], ends: &[T; N], diagonals: &[T; N], valence: usize) -> [T; N] {
    let each = smooth_neighbour(valence.max(1), 1.0);
    let (end, diagonal) = (T::from_f64(1.5 * each), T::from_f64(0.25 * each));
    let mut out = *own;
    for c in 0..N {
        out[c] = own[c] + (end * ends[c] + diagonal * diagonals[c]);
    }
    out
}

fn smooth_vertex<T: Real, const N: usize>(own: [T; N], around: impl Iterator<Item = ([T; N], [T; N])>) -> [T; N] {
    let (mut ends, mut diagonals, mut valence) = ([T::default(); N], [T::default(); N], 0);
    for (end, diagonal) in around {
        for c in 0..N {
            ends[c] = ends[c] + (end[c] - own[c]);
            diagonals[c] = diagonals[c] + (diagonal[c] - own[c]);
        }
        valence += 1;
    }
    smooth_sum(&own, &ends, &diagonals, valence)
}

/// The mask of a control vertex at a level, over the level's vertices.
fn star(t: &Topology, sides: &Sides, scheme: Scheme, from: &Places, v: Vertex, mask: &mut Mask) -> Vec<(u32, f64)> {
    vertex_mask(t, scheme, v, mask);
    let mut terms = vec![(v.0, 0.0)];
    for (&(_, weight), &e) in mask.vertices.iter().zip(&mask.edges) {
        terms.push((if e == NONE { v.0 } else { from.near_end(t, Edge(e), v) }, weight));
    }
    if !mask.faces.is_empty() {
        for (h, &(_, weight)) in fan(t, v).into_iter().zip(&mask.faces) {
            let beside = Walk::<false> { t, sides }.beside(h);
            let ends = [h, beside.prev].map(|h| from.near_end(t, t.edge(h), v));
            terms.extend([v.0, ends[0], ends[1], from.diagonal(h, &beside)].map(|id| (id, 0.25 * weight)));
        }
    }
    terms.sort_by_key(|term| (term.0 != v.0, term.0));
    terms.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        kept.1 += if same { next.1 } else { 0.0 };
        same
    });
    terms
}
