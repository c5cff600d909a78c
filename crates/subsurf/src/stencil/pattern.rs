//! The rows of one control face: every vertex that refinement makes on the face, on its edges and at its corners, over
//! the face's ring. Masks composed level by level; the only place where stencil weights are computed.
//!
//! The places of a face at level `k` are told from the faces of level `k - 1` that lie in it, in their order:
//!
//! ```text
//!   place of the j-th face with n corners, within the face's 1 + 2 n places
//!     0        the face point
//!     1 + 2 c  the vertex point at corner c
//!     2 + 2 c  the edge point on the edge from corner c
//! ```
//!
//! Under Loop, which has no face points, place 0 is empty. A vertex shared by faces has a place in each of them.

use crate::index::{Edge, Face, Vertex};
use crate::mask::{Mask, edge_mask, vertex_mask};
use crate::refine::Level;
use crate::scheme::SplitKind;
use crate::topology::Topology;
use std::ops::Range;

/// Rows of one control face over its ring, dense, by level; levels that were not asked for are empty.
pub(super) struct Pattern {
    pub levels: Vec<Rows>,
}

/// Rows of one level.
#[derive(Default)]
pub(super) struct Rows {
    /// The row of every place; empty for the face points' places under Loop.
    pub places: Vec<Row>,
    /// As many weights to a row as the ring has points.
    pub weights: Vec<f64>,
}

/// Where a row starts among the weights, and how many of its weights are not zero.
#[derive(Clone, Copy, Default)]
pub(super) struct Row {
    pub start: u32,
    pub nonzero: u32,
}

/// The faces of a refinement that lie in one face of its base, which is `depth` levels up.
pub(super) fn faces_within(base: &Topology, split: SplitKind, face: Face, depth: usize) -> Range<u32> {
    let first = base.first(face);
    match (split, depth) {
        (_, 0) => face.0..face.0 + 1,
        (SplitKind::Triangles, _) => face.0 << (2 * depth)..(face.0 + 1) << (2 * depth),
        (SplitKind::Quads, _) => {
            let shift = 2 * (depth - 1);
            first << shift..(first + base.sides(face) as u32) << shift
        }
    }
}

/// Computes patterns; its memory is reused from face to face.
pub(super) struct Composer<'a> {
    /// Levels 0 to N - 1 of a refinement to level N.
    levels: &'a [Level],
    /// What is asked of every level from 0 to N.
    needs: Vec<Need>,
    mask: Mask,
}

/// The vertices of one level that are needed, and how they come from the level before.
#[derive(Default)]
struct Need {
    vertices: Vec<u32>,
    slots: Slots,
    /// By needed vertex: end of its terms.
    term_end: Vec<(u32, u32)>,
    /// Slots of the level before, with weights.
    from_vertices: Vec<(u32, f64)>,
    /// Slots of face points of the same level, with weights.
    from_faces: Vec<(u32, f64)>,
    /// Rows over the ring.
    rows: Vec<f64>,
}

impl Need {
    fn slot(&mut self, v: u32) -> u32 {
        self.slots.get_or_insert(v, &mut self.vertices)
    }
}

/// Vertex → slot, cleared in no time.
#[derive(Default)]
struct Slots {
    round: u32,
    /// Round and slot, by vertex.
    of: Vec<(u32, u32)>,
}

impl Slots {
    fn clear(&mut self, len: usize) {
        if self.of.len() < len || self.round == u32::MAX {
            self.of = vec![(0, 0); len];
            self.round = 0;
        }
        self.round += 1;
    }

    fn get_or_insert(&mut self, v: u32, list: &mut Vec<u32>) -> u32 {
        let entry = &mut self.of[v as usize];
        if entry.0 != self.round {
            *entry = (self.round, list.len() as u32);
            list.push(v);
        }
        entry.1
    }
}

impl<'a> Composer<'a> {
    pub fn new(levels: &'a [Level]) -> Self {
        Self { levels, needs: (0..=levels.len()).map(|_| Need::default()).collect(), mask: Mask::default() }
    }

    /// The pattern of a face of level 0, for the levels of `wanted`. The ring must hold all control points that the face
    /// depends on.
    pub fn pattern(&mut self, face: Face, ring: &[u32], wanted: Range<usize>) -> Pattern {
        let finest = self.levels.len();
        for (level, need) in self.needs.iter_mut().enumerate() {
            need.vertices.clear();
            need.slots.clear(match level {
                0 => self.levels[0].topology().vertex_count(),
                _ => Children::of(&self.levels[level - 1]).count(),
            });
        }
        for (slot, &v) in ring.iter().enumerate() {
            let given = self.needs[0].slot(v);
            debug_assert_eq!(given as usize, slot, "a ring names no point twice");
        }
        let mut out = Pattern { levels: (0..=finest).map(|_| Rows::default()).collect() };
        let places: Vec<_> = wanted.clone().map(|level| self.seed(face, level)).collect();
        let own: Vec<usize> = self.needs.iter().map(|need| need.vertices.len()).collect();
        for level in (1..=finest).rev() {
            self.expand(level);
        }
        debug_assert_eq!(
            self.needs[0].vertices.len(),
            ring.len(),
            "the ring holds all points that the face depends on"
        );
        for level in 1..=finest {
            self.compose(level, ring.len());
        }
        for (level, places) in wanted.zip(places) {
            let weights = self.needs[level].rows[..own[level] * ring.len()].to_vec();
            let nonzero = |row: &[f64]| row.iter().map(|&w| u32::from(w != 0.0)).sum();
            let nonzero: Vec<u32> = weights.chunks_exact(ring.len()).map(nonzero).collect();
            let row = |slot: u32| Row { start: slot * ring.len() as u32, nonzero: nonzero[slot as usize] };
            let places = places.iter().map(|slot| slot.map_or(Row::default(), row)).collect();
            out.levels[level] = Rows { places, weights };
        }
        out
    }

    /// Asks for all places of a face; returns their slots.
    fn seed(&mut self, face: Face, level: usize) -> Vec<Option<u32>> {
        let split = self.levels[0].scheme().split();
        let within = faces_within(self.levels[0].topology(), split, face, level - 1);
        let parent = self.levels[level - 1].topology();
        let ids = Children::of(&self.levels[level - 1]);
        let need = &mut self.needs[level];
        let mut places = Vec::new();
        for f in within.map(Face) {
            places.push(ids.face_point(f).map(|v| need.slot(v)));
            for h in (0..parent.sides(f)).map(|c| parent.half_edge(f, c)) {
                places.push(Some(need.slot(parent.origin(h).0)));
                places.push(Some(need.slot(ids.edge_point(parent.edge(h)))));
            }
        }
        places
    }

    /// Asks for what the needed vertices of a level come from, and notes the masks' terms.
    fn expand(&mut self, level: usize) {
        let parent = &self.levels[level - 1];
        let (t, scheme, ids) = (parent.topology(), parent.scheme(), Children::of(parent));
        let [.., before, need] = &mut self.needs[..=level] else { unreachable!("level 0 comes from nowhere") };
        need.term_end.clear();
        need.from_vertices.clear();
        need.from_faces.clear();
        // The list grows by face points on the way.
        let mut next = 0;
        while let Some(&v) = need.vertices.get(next) {
            next += 1;
            self.mask.clear();
            match ids.parent(v) {
                Parent::Vertex(v) => vertex_mask(t, scheme, v, &mut self.mask),
                Parent::Edge(e) => edge_mask(t, scheme, e, &mut self.mask),
                Parent::Face(f) => {
                    let corners = t.face_vertices(f);
                    let each = 1.0 / corners.len() as f64;
                    corners.iter().for_each(|&v| self.mask.vertex(Vertex(v), each));
                }
            }
            for &(v, w) in self.mask.vertices.iter().filter(|term| term.1 != 0.0) {
                need.from_vertices.push((before.slot(v), w));
            }
            for &(f, w) in self.mask.faces.iter().filter(|term| term.1 != 0.0) {
                let point = ids.face_point(Face(f)).expect("masks over faces make face points");
                let slot = need.slot(point);
                need.from_faces.push((slot, w));
            }
            need.term_end.push((need.from_vertices.len() as u32, need.from_faces.len() as u32));
        }
    }

    /// Rows of a level from those of the level before: face points, then what is made of them.
    fn compose(&mut self, level: usize, ring: usize) {
        let [.., before, need] = &mut self.needs[..=level] else { unreachable!("level 0 comes from nowhere") };
        // What an earlier face left there is overwritten.
        need.rows.resize(need.rows.len().max(need.vertices.len() * ring), 0.0);
        let mut sum = vec![0.0; ring];
        for with_faces in [false, true] {
            let mut start = (0, 0);
            for (slot, &end) in need.term_end.iter().enumerate() {
                let from_vertices = &need.from_vertices[start.0 as usize..end.0 as usize];
                let from_faces = &need.from_faces[start.1 as usize..end.1 as usize];
                start = end;
                if from_faces.is_empty() == with_faces {
                    continue;
                }
                if level == 1 {
                    sum.fill(0.0);
                    from_vertices.iter().for_each(|&(p, w)| sum[p as usize] += w);
                } else {
                    sum_rows(&mut sum, from_vertices, &before.rows);
                }
                from_faces.iter().for_each(|&(p, w)| add_row(&mut sum, w, &need.rows[p as usize * ring..][..ring]));
                need.rows[slot * ring..(slot + 1) * ring].copy_from_slice(&sum);
            }
        }
    }
}

/// `sum = Σ weight · row`.
fn sum_rows(sum: &mut [f64], terms: &[(u32, f64)], rows: &[f64]) {
    let ring = sum.len();
    sum.fill(0.0);
    terms.iter().for_each(|&(p, w)| add_row(sum, w, &rows[p as usize * ring..][..ring]));
}

#[inline]
fn add_row(sum: &mut [f64], weight: f64, row: &[f64]) {
    sum.iter_mut().zip(row).for_each(|(s, x)| *s += weight * x);
}

/// How the vertices of the next level are numbered: vertex points, face points (not under Loop), edge points.
#[derive(Clone, Copy)]
pub(super) struct Children {
    vertices: u32,
    faces: u32,
    edges: u32,
}

/// What a vertex of the next level belongs to.
#[derive(Clone, Copy)]
pub(super) enum Parent {
    Vertex(Vertex),
    Face(Face),
    Edge(Edge),
}

impl Children {
    pub fn of(level: &Level) -> Self {
        let t = level.topology();
        let faces = if level.scheme().split() == SplitKind::Quads { t.face_count() as u32 } else { 0 };
        Self { vertices: t.vertex_count() as u32, faces, edges: t.edge_count() as u32 }
    }

    pub fn count(self) -> usize {
        self.vertices as usize + self.faces as usize + self.edges as usize
    }

    fn face_point(self, f: Face) -> Option<u32> {
        (f.0 < self.faces).then_some(self.vertices + f.0)
    }

    fn edge_point(self, e: Edge) -> u32 {
        self.vertices + self.faces + e.0
    }

    pub fn parent(self, v: u32) -> Parent {
        if v < self.vertices {
            Parent::Vertex(Vertex(v))
        } else if v < self.vertices + self.faces {
            Parent::Face(Face(v - self.vertices))
        } else {
            Parent::Edge(Edge(v - self.vertices - self.faces))
        }
    }
}
