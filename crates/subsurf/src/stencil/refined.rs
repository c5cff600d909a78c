//! The rows of all vertices of a refinement: every vertex is looked up in the pattern of one face that it lies on.
//!
//! A vertex of level `k` belongs to a vertex, a face or an edge of level `k - 1`; one half-edge there says which face of
//! level `k - 1` holds it and where, and index arithmetic leads from that face to the control face. So rows are written
//! one after another, in the order of refinement.

use super::csr::{self, Csr};
use super::groups::{Ascending, FaceGroups};
use super::pattern::{Children, Composer, Parent, Pattern, Row, Rows, faces_within};
use super::{StencilError, StencilOptions};
use crate::index::{Edge, Face, HalfEdge};
use crate::real::Real;
use crate::refine::Level;
use crate::scheme::SplitKind;
use crate::topology::Topology;
use rayon::prelude::*;
use std::ops::Range;

/// Rows and weights of the levels that the options ask for, over the vertices of `control`.
pub(super) fn rows<W: Real>(
    control: &Level,
    depth: usize,
    options: &StencilOptions,
) -> Result<(Csr, Vec<W>), StencilError> {
    if depth == 0 {
        return identity(control, wanted(depth, options), options.most_weights);
    }
    let groups = FaceGroups::new(control.topology())?;
    check_estimate(control, &groups, depth, options)?;
    let mut levels = vec![control.clone()];
    while levels.len() < depth {
        levels.push(levels[levels.len() - 1].refine()?);
    }
    write(&levels, &groups, options)
}

/// The same where levels 0 to N - 1 are at hand.
pub(super) fn rows_of_levels<W: Real>(
    levels: &[Level],
    options: &StencilOptions,
) -> Result<(Csr, Vec<W>), StencilError> {
    let groups = FaceGroups::new(levels[0].topology())?;
    check_estimate(&levels[0], &groups, levels.len(), options)?;
    write(levels, &groups, options)
}

fn write<W: Real>(
    levels: &[Level],
    groups: &FaceGroups,
    options: &StencilOptions,
) -> Result<(Csr, Vec<W>), StencilError> {
    let wanted = wanted(levels.len(), options);
    // The last level's topology is not needed, but its vertices must be countable.
    levels[levels.len() - 1].check_child()?;
    let patterns: Vec<Pattern> = groups
        .representatives
        .par_iter()
        .map_init(|| Composer::new(levels), |composer, &f| composer.pattern(f, groups.ring(f), wanted.clone()))
        .collect();
    Writer { levels, rings: groups.ascending(), patterns: &patterns }.write(wanted, options.most_weights)
}

fn wanted(depth: usize, options: &StencilOptions) -> Range<usize> {
    if options.all_levels { 1..depth + 1 } else { depth..depth + 1 }
}

/// Level 0: every vertex is its own control point.
fn identity<W: Real>(base: &Level, wanted: Range<usize>, most: usize) -> Result<(Csr, Vec<W>), StencilError> {
    let control_points = base.topology().vertex_count();
    let rows = if wanted.contains(&0) { control_points } else { 0 };
    csr::check_count(rows, most)?;
    let csr = Csr { offsets: (0..=rows as u32).collect(), indices: (0..rows as u32).collect(), control_points };
    Ok((csr, vec![W::from_f64(1.0); rows]))
}

/// Refuses more weights than are allowed. Those that are zero are counted in: vertices of a face times its ring.
fn check_estimate(
    base: &Level,
    groups: &FaceGroups,
    depth: usize,
    options: &StencilOptions,
) -> Result<(), StencilError> {
    let t = base.topology();
    // Beyond level 20 one face alone has more weights than are ever allowed.
    let wanted = wanted(depth.min(20), options);
    let vertices = |f: Face, level: usize| -> usize {
        match base.scheme().split() {
            SplitKind::Quads => t.sides(f).saturating_mul(power_of_four(level - 1)),
            SplitKind::Triangles => power_of_four(level).div_ceil(2),
        }
    };
    let of_face = |f: Face| {
        let vertices = wanted.clone().map(|level| vertices(f, level)).fold(0, usize::saturating_add);
        vertices.saturating_mul(groups.ring(f).len())
    };
    let count = (0..t.face_count() as u32).map(|f| of_face(Face(f))).fold(0, usize::saturating_add);
    csr::check_count(count, options.most_weights)
}

fn power_of_four(n: usize) -> usize {
    u32::try_from(n).ok().and_then(|n| 4usize.checked_pow(n)).unwrap_or(usize::MAX)
}

/// Number of vertices of the next level.
pub(super) fn child_vertex_count(level: &Level) -> usize {
    Children::of(level).count()
}

struct Writer<'a> {
    levels: &'a [Level],
    rings: Ascending<'a>,
    patterns: &'a [Pattern],
}

/// Where a vertex of some level lies: a control face, and the place in it.
#[derive(Clone, Copy)]
struct Place {
    face: Face,
    place: usize,
}

/// One task: rows of one level and what they write to.
struct Task<'a, W> {
    level: usize,
    vertices: Range<u32>,
    indices: &'a mut [u32],
    weights: &'a mut [W],
}

impl Writer<'_> {
    fn write<W: Real>(&self, wanted: Range<usize>, most: usize) -> Result<(Csr, Vec<W>), StencilError> {
        let base = self.levels[0].topology();
        let counts: Vec<(usize, usize)> =
            wanted.map(|level| (level, child_vertex_count(&self.levels[level - 1]))).collect();
        let rows = counts.iter().map(|c| c.1).sum();
        let lengths: Vec<u32> = counts
            .iter()
            .flat_map(|&(level, count)| {
                (0..count as u32).into_par_iter().map(move |v| self.length(level, v)).collect::<Vec<_>>()
            })
            .collect();
        let offsets = csr::offsets(lengths.iter().map(|&n| n as usize), rows, most)?;
        drop(lengths);

        let total = offsets[rows] as usize;
        let mut indices = vec![0u32; total];
        let mut weights = vec![W::default(); total];
        let mut tasks = Vec::new();
        let (mut index_rest, mut weight_rest) = (&mut indices[..], &mut weights[..]);
        let mut first = 0;
        for (level, count) in counts {
            for start in (0..count).step_by(csr::CHUNK) {
                let end = (start + csr::CHUNK).min(count);
                let length = (offsets[first + end] - offsets[first + start]) as usize;
                let (i, tail) = index_rest.split_at_mut(length);
                index_rest = tail;
                let (w, tail) = weight_rest.split_at_mut(length);
                weight_rest = tail;
                tasks.push(Task { level, vertices: start as u32..end as u32, indices: i, weights: w });
            }
            first += count;
        }
        tasks.into_par_iter().for_each(|task| self.fill(task));
        Ok((Csr { offsets, indices, control_points: base.vertex_count() }, weights))
    }

    fn length(&self, level: usize, v: u32) -> u32 {
        match self.place(level, v) {
            Some(Place { face, place }) => self.rows(level, face).places[place].nonzero,
            None => 1,
        }
    }

    fn fill<W: Real>(&self, task: Task<'_, W>) {
        let (mut indices, mut weights) = (task.indices, task.weights);
        for v in task.vertices {
            let Some(Place { face, place }) = self.place(task.level, v) else {
                // A vertex without faces stays where it is, level after level, and so does its number.
                (indices[0], weights[0]) = (v, W::from_f64(1.0));
                (indices, weights) = (&mut indices[1..], &mut weights[1..]);
                continue;
            };
            let ring = self.rings.ring(face);
            let rows = self.rows(task.level, face);
            let Row { start, nonzero } = rows.places[place];
            let (row, nonzero) = (&rows.weights[start as usize..][..ring.len()], nonzero as usize);
            let (i, index_rest) = indices.split_at_mut(nonzero);
            let (w, weight_rest) = weights.split_at_mut(nonzero);
            (indices, weights) = (index_rest, weight_rest);
            // What is not zero, without a branch: a zero is overwritten by what follows.
            let mut next = 0;
            for &(point, slot) in ring {
                if next == nonzero {
                    break;
                }
                let weight = row[slot as usize];
                (i[next], w[next]) = (point, W::from_f64(weight));
                next += usize::from(weight != 0.0);
            }
        }
    }

    #[inline]
    fn rows(&self, level: usize, face: Face) -> &Rows {
        &self.patterns[self.rings.groups.group(face)].levels[level]
    }

    /// A place of vertex `v` of level `level`; none for a vertex without faces.
    #[inline]
    fn place(&self, level: usize, v: u32) -> Option<Place> {
        let parent = &self.levels[level - 1];
        let t = parent.topology();
        let (h, odd) = match Children::of(parent).parent(v) {
            Parent::Vertex(v) => (t.outgoing(v)?, 1),
            Parent::Edge(e) => (edge_side(t, e), 2),
            Parent::Face(f) => return Some(self.in_face(level, f, 0)),
        };
        let f = t.face(h);
        Some(self.in_face(level, f, odd + 2 * (h.0 - t.first(f)) as usize))
    }

    /// The control face of a face of the level before `level`, with the place there.
    #[inline]
    fn in_face(&self, level: usize, f: Face, place: usize) -> Place {
        let (base, split) = (self.levels[0].topology(), self.levels[0].scheme().split());
        let face = match (split, level) {
            (_, 1) => f,
            (SplitKind::Triangles, _) => Face(f.0 >> (2 * (level - 1))),
            (SplitKind::Quads, _) => base.face(HalfEdge(f.0 >> (2 * (level - 2)))),
        };
        let before = f.0 - faces_within(base, split, face, level - 1).start;
        // Faces before this one in the same control face have as many corners: there is but one at level 0.
        let places = 1 + 2 * self.levels[level - 1].topology().sides(f);
        Place { face, place: before as usize * places + place }
    }
}

fn edge_side(t: &Topology, e: Edge) -> HalfEdge {
    HalfEdge(t.edge_half_edge[e.index()])
}
