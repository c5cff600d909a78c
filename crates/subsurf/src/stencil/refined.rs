//! The rows of all vertices of a refinement, written one after another: where a vertex is numbered says which control face it
//! lies on and where there, and the weights there are the same for all faces with equal surroundings.

use super::csr::{self, Csr};
use super::level_by_level;
use super::{StencilError, StencilOptions};
use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::mesh::MeshError;
use crate::real::Real;
use crate::refine::{
    Ascending, Composer, Counts, FaceRings, Level, Numbering, Owner, PLAIN, Placed, Region, TileTrees, WeightRows,
    fill_regular, ring_bounds, runs_forward,
};
use crate::scheme::{Scheme, SplitKind};
use crate::topology::Topology;
use rayon::prelude::*;
use std::ops::Range;

/// Rows that a thread takes at a time, at least. Larger: uneven loads; smaller: overhead of tasks.
const CHUNK: usize = 4096;

/// Rows and weights of the levels that the options ask for, over the vertices of `control`.
pub(crate) fn rows<W: Real>(
    control: &Level,
    depth: u32,
    options: &StencilOptions,
) -> Result<(Csr, Vec<W>), StencilError> {
    let wanted = if options.all_levels { 1..=depth } else { depth..=depth };
    let (t, split) = (control.topology(), control.scheme().split());
    if depth == 0 {
        return identity(t.vertex_count(), !options.all_levels, options.most_weights);
    }
    check_estimate(control, wanted.clone(), options)?;
    let mut counts = Counts::of(t);
    for _ in 0..depth {
        counts = counts.refined(split)?;
    }
    let sharpened = TileTrees::sharpened(t, depth);
    let t = sharpened.as_ref().unwrap_or(t);
    let Some(rings) = FaceRings::new(t, control.scheme(), true)? else {
        return level_by_level::rows(control, depth, options);
    };
    let rings = rings.ascending();
    let level = |depth| LevelRows::new(t, control.scheme(), &rings, depth);
    let levels: Vec<LevelRows<'_, W>> = wanted.map(level).collect();
    write(&levels, t.vertex_count(), options.most_weights)
}

/// Level 0: every vertex is its own control point.
fn identity<W: Real>(control_points: usize, is_wanted: bool, most: usize) -> Result<(Csr, Vec<W>), StencilError> {
    let rows = if is_wanted { control_points } else { 0 };
    csr::check_count(rows, most)?;
    let csr = Csr { offsets: (0..=rows as u32).collect(), indices: (0..rows as u32).collect(), control_points };
    Ok((csr, vec![W::from_f64(1.0); rows]))
}

/// Control points that all rings together may have beyond 64 per face: a gigabyte. A pole of valence n has n rings of
/// 2 n points; 2^28 allows one of 11,000.
const MOST_RING_POINTS: usize = 1 << 28;

/// Refuses more weights than are allowed. Those that are zero are counted in: vertices of a face times its ring.
fn check_estimate(
    control: &Level,
    wanted: std::ops::RangeInclusive<u32>,
    options: &StencilOptions,
) -> Result<(), StencilError> {
    let t = control.topology();
    let rings: Vec<usize> = ring_bounds(t).collect();
    let (count, limit) = (rings.iter().sum(), MOST_RING_POINTS + 64 * t.face_count());
    if count > limit {
        let what = "control points round its faces (a vertex of n faces needs n² of them)";
        return Err(MeshError::TooLarge { what, count, limit }.into());
    }
    // Beyond level 20 one face alone has more weights than are ever allowed.
    let wanted = *wanted.start().min(&20)..=*wanted.end().min(&20);
    let vertices = |f: Face, level: u32| -> usize {
        match control.scheme().split() {
            SplitKind::Quads => t.sides(f) << (2 * (level - 1)),
            SplitKind::Triangles => (1usize << (2 * level)).div_ceil(2),
        }
    };
    let of_face = |(f, ring): (u32, &usize)| {
        let vertices: usize = wanted.clone().map(|level| vertices(Face(f), level)).sum();
        vertices.saturating_mul(*ring)
    };
    let count = (0..).zip(&rings).map(of_face).fold(0, usize::saturating_add);
    csr::check_count(count, options.most_weights)
}

/// Weights of all cells of a face over its ring.
struct Pattern<W> {
    width: usize,
    weights: Vec<W>,
    /// By cell: number of weights that are not zero.
    nonzero: Vec<u32>,
}

impl<W: Real> Pattern<W> {
    fn new(rows: &WeightRows) -> Self {
        let count = |row: &[f64]| row.iter().map(|&w| u32::from(w != 0.0)).sum();
        Self {
            width: rows.width,
            weights: rows.weights.iter().map(|&w| W::from_f64(w)).collect(),
            nonzero: rows.weights.chunks_exact(rows.width).map(count).collect(),
        }
    }

    #[inline(always)]
    fn row(&self, cell: usize) -> &[W] {
        &self.weights[cell * self.width..(cell + 1) * self.width]
    }
}

/// Everything that the rows of one level are made from.
struct LevelRows<'a, W> {
    control: &'a Topology,
    rings: &'a Ascending<'a>,
    numbering: Numbering,
    /// By group.
    patterns: Vec<Pattern<W>>,
    plain: Pattern<W>,
}

/// Rows of consecutive elements of a region.
#[derive(Clone)]
struct Elements {
    region: usize,
    elements: Range<u32>,
    rows: usize,
}

impl<'a, W: Real> LevelRows<'a, W> {
    fn new(t: &'a Topology, scheme: Scheme, rings: &'a Ascending<'a>, depth: u32) -> Self {
        let trees = TileTrees::compile(t, scheme, &rings.rings.representatives, depth);
        let composer = Composer { trees: &trees, split: scheme.split() };
        let groups = (0..rings.rings.representatives.len()).into_par_iter();
        let patterns = groups.map(|group| Pattern::new(&composer.node(0, group))).collect();
        let size = 1usize << depth;
        let mut plain = WeightRows::zeros((size + 1) * (size + 1), 16);
        fill_regular(&trees.regular, &WeightRows::identity(16), Placed::alone(size), size, &mut plain);
        let numbering = Numbering::new(t, scheme.split(), depth);
        Self { control: t, rings, numbering, patterns, plain: Pattern::new(&plain) }
    }

    /// The rows of the level in order, in tasks.
    fn tasks(&self) -> Vec<Elements> {
        let t = self.control;
        let counts = Counts::of(t);
        let mut tasks = Vec::new();
        for (region, Region { owner, each, .. }) in self.numbering.regions.iter().enumerate() {
            let count = match owner {
                Owner::Vertices => counts.vertices,
                Owner::Faces => counts.faces,
                Owner::HalfEdges => counts.half_edges,
                Owner::Edges => counts.edges,
            };
            let step = CHUNK.div_ceil(*each);
            tasks.extend((0..count).step_by(step).map(|start| {
                let end = (start + step).min(count);
                Elements { region, elements: start as u32..end as u32, rows: each * (end - start) }
            }));
        }
        tasks
    }

    /// Visits the rows of a task in order: the face that a vertex lies on with its cells there, or none for a vertex without
    /// faces.
    #[inline(always)]
    fn visit(&self, task: &Elements, mut visit: impl FnMut(Option<Face>, u32, &[u32], usize)) {
        let (t, numbering) = (self.control, &self.numbering);
        let Region { owner, each, .. } = numbering.regions[task.region];
        let tile_of = |f: Face| if numbering.is_whole(t.sides(f)) { &numbering.whole } else { &numbering.corner };
        let side_of = |h: HalfEdge| (t.face(h), (h.0 - t.first(t.face(h))) as usize);
        for element in task.elements.clone() {
            match owner {
                Owner::Vertices => match t.outgoing(Vertex(element)) {
                    None => visit(None, element, &[0], 0),
                    Some(h) => {
                        let (f, side) = side_of(h);
                        visit(Some(f), element, &[numbering.on_side(t.sides(f), side, 0) as u32], 0);
                    }
                },
                Owner::Faces => visit(Some(Face(element)), element, &[tile_of(Face(element)).centre as u32], 0),
                Owner::HalfEdges => {
                    let (f, corner) = side_of(HalfEdge(element));
                    let tile = tile_of(f);
                    let cells = &tile.order[tile.ranges[task.region].clone()];
                    if numbering.is_whole(t.sides(f)) {
                        visit(Some(f), element, &cells[corner * each..][..each], 0);
                    } else {
                        visit(Some(f), element, cells, corner * tile.cells());
                    }
                }
                Owner::Edges => {
                    let h = HalfEdge(t.edge_half_edge[Edge(element).index()]);
                    let (f, side) = side_of(h);
                    let cells = numbering.side_cells(t.sides(f), side, runs_forward(t, h));
                    // Regions before this one have each - 1 vertices per edge.
                    visit(Some(f), element, &cells[each - 1..][..each], 0);
                }
            }
        }
    }

    #[inline(always)]
    fn pattern(&self, face: Face) -> &Pattern<W> {
        match self.rings.rings.group(face) {
            PLAIN => &self.plain,
            group => &self.patterns[group as usize],
        }
    }

    /// Ends of the task's rows, counted from its first.
    fn ends(&self, task: &Elements, ends: &mut [u32]) -> usize {
        let (mut end, mut ends) = (0usize, ends.iter_mut());
        self.visit(task, |face, _, cells, first| {
            let pattern = face.map(|f| self.pattern(f));
            for (&cell, to) in cells.iter().zip(&mut ends) {
                end += pattern.map_or(1, |pattern| pattern.nonzero[first + cell as usize] as usize);
                // What wraps is refused.
                *to = end as u32;
            }
        });
        end
    }

    fn fill(&self, task: &Elements, indices: &mut [u32], weights: &mut [W]) {
        let mut at = 0;
        self.visit(task, |face, element, cells, first| {
            let Some(face) = face else {
                // A vertex without faces stays where it is, level after level, and so does its number.
                (indices[at], weights[at]) = (element, W::from_f64(1.0));
                at += 1;
                return;
            };
            let (ring, pattern) = (self.rings.ring(face), self.pattern(face));
            for &cell in cells {
                let cell = first + cell as usize;
                let (row, nonzero) = (pattern.row(cell), pattern.nonzero[cell] as usize);
                let (i, w) = (&mut indices[at..at + nonzero], &mut weights[at..at + nonzero]);
                at += nonzero;
                if nonzero == row.len() {
                    for ((i, w), &(point, slot)) in i.iter_mut().zip(w).zip(ring) {
                        (*i, *w) = (point, row[slot as usize]);
                    }
                    continue;
                }
                // What is not zero, without a branch: a zero is overwritten by what follows.
                let mut next = 0;
                for &(point, slot) in ring {
                    if next == nonzero {
                        break;
                    }
                    let weight = row[slot as usize];
                    (i[next], w[next]) = (point, weight);
                    next += usize::from(weight != W::default());
                }
            }
        });
    }
}

fn write<W: Real>(
    levels: &[LevelRows<'_, W>],
    control_points: usize,
    most: usize,
) -> Result<(Csr, Vec<W>), StencilError> {
    let tasks: Vec<(&LevelRows<'_, W>, Elements)> =
        levels.iter().flat_map(|level| level.tasks().into_iter().map(move |task| (level, task))).collect();
    let rows = tasks.iter().map(|(_, task)| task.rows).sum::<usize>();
    // Ends of rows within their tasks first, then from the start.
    let mut offsets: Vec<u32> = subsurf_memory::zeroed(rows + 1);
    let lengths = || tasks.iter().map(|(_, task)| task.rows);
    let counts: Vec<usize> = cut(&mut offsets[1..], lengths())
        .into_par_iter()
        .zip(&tasks)
        .map(|(ends, (level, task))| level.ends(task, ends))
        .collect();
    let total = counts.iter().sum();
    csr::check_count(total, most)?;
    let mut end = 0;
    let starts: Vec<u32> = counts
        .iter()
        .map(|&count| {
            let start = end as u32;
            end += count;
            start
        })
        .collect();
    cut(&mut offsets[1..], lengths())
        .into_par_iter()
        .zip(starts)
        .for_each(|(ends, start)| ends.iter_mut().for_each(|e| *e += start));

    let mut indices: Vec<u32> = subsurf_memory::zeroed(total);
    let mut weights = vec![W::default(); total];
    subsurf_memory::advise(&mut weights);
    let index_parts = cut(&mut indices, counts.iter().copied());
    let weight_parts = cut(&mut weights, counts.iter().copied());
    let parts = index_parts.into_par_iter().zip(weight_parts).zip(&tasks);
    parts.for_each(|((indices, weights), (level, task))| level.fill(task, indices, weights));
    Ok((Csr { offsets, indices, control_points }, weights))
}

/// A slice in parts of the given lengths.
fn cut<V>(mut rest: &mut [V], lengths: impl Iterator<Item = usize>) -> Vec<&mut [V]> {
    let part = |length| {
        let (part, tail) = std::mem::take(&mut rest).split_at_mut(length);
        rest = tail;
        part
    };
    lengths.map(part).collect()
}
