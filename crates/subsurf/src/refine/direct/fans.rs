//! Vertices that are not regular, each with its fan, refined by itself: the vertex, the ends of its edges and
//! the vertices across its faces follow from the same ones a level above. They are control vertices of any
//! valence, sharpness or number of sheets, and the centres of control faces that are no quads. They start where all their faces are quads.

mod lanes;
mod tables;
mod values;

use super::rules::{Creases, Special};
use super::starts::Starts;
use crate::index::{Edge, HalfEdge, Vertex};
use crate::mask::{Mask, vertex_mask};
use crate::scheme::Scheme;
use crate::topology::{FaceOf, NONE, Topology};
use std::collections::BTreeMap;
use std::ops::Range;
pub(super) use tables::FanTables;
pub(super) use values::FanValues;

/// Faces of a fan that are searched one by one. Larger: long searches at poles; smaller: more in the map.
const LISTED: usize = 16;

/// A face of a fan.
#[derive(Clone, Copy)]
struct FanFace {
    /// The half-edge at the face's corner: the vertex's, or where the vertex is a centre, the one across.
    h: u32,
    /// Its edges at the vertex among those of the fan, clockwise one first.
    sides: [u32; 2],
    /// The next edges beyond these, or [`NONE`].
    beyond: [u32; 2],
}

/// Where the values of a fan are found that the lattice of a face lacks.
#[derive(Clone, Copy)]
pub(super) struct FanCorner {
    /// Among those that are kept, the first of the fan's, and how many there are at each level.
    kept: u32,
    points: u32,
    /// The ends of the edges next to the face's, clockwise and counter-clockwise, among the fan's edges, or [`NONE`].
    pub beyond: [u32; 2],
}

/// All fans.
#[derive(Default)]
pub(super) struct Fans {
    /// By control vertex one more than its fan, 0 for a regular one.
    of_vertex: Vec<u32>,
    /// Control vertices with fans, then control faces whose centres have them.
    owners: Vec<u32>,
    centres: usize,
    /// By fan, and at last: its first edge and its first face.
    starts: Vec<[u32; 2]>,
    /// Control edges, and their kinds.
    edges: Vec<[u32; 2]>,
    faces: Vec<FanFace>,
    /// Position of a face by half-edge, in fans with many.
    positions: BTreeMap<u32, u32>,
    /// By level from `start` on: rules of vertices that do not follow the smooth one. Terms are the vertex, the ends, the new face points.
    rows: Vec<Special>,
    /// By fan its rule among those of each level, or [`NONE`].
    row_of: Vec<u32>,
    /// By fan of a vertex: some of its faces are no quads, so that it starts at level 1.
    is_late: Vec<bool>,
    start: usize,
    depth: usize,
}

impl Fans {
    /// Of a mesh whose rules are not linear, from one level to another.
    pub fn new(t: &Topology, creases: &Creases, starts: &Starts, levels: Range<usize>) -> Self {
        let of_vertex = vec![0; t.vertex_count()];
        let (start, depth) = (levels.start, levels.end);
        let mut out = Self { of_vertex, starts: vec![[0, 0]], start, depth, ..Self::default() };
        let mut corners = vec![0u8; t.vertex_count()];
        t.origin.iter().for_each(|&v| corners[v as usize] = corners[v as usize].saturating_add(1));
        let is_special = |v: usize| {
            corners[v] != 4
                || t.sharp_offset[v] != t.sharp_offset[v + 1]
                || t.vertex_sharpness.code(v) != 0
                || t.vertex_non_manifold[v]
        };
        let mut apart = t.vertex_non_manifold.contains(&true).then(|| {
            let mut apart: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
            let half_edges = t.origin.iter().zip(0..).filter(|(v, _)| t.vertex_non_manifold[**v as usize]);
            half_edges.for_each(|(&v, h)| apart.entry(v).or_default().push(h));
            apart
        });
        let kind = |e: u32| [e, creases.kind(t, Edge(e))];
        let mut around = Vec::new();
        for v in (0..t.vertex_count()).filter(|&v| corners[v] > 0 && is_special(v)) {
            out.of_vertex[v] = out.owners.len() as u32 + 1;
            around.clear();
            if let Some(list) = apart.as_mut().and_then(|apart| apart.remove(&(v as u32))) {
                out.add_sheets(t, &list, kind);
            } else {
                let is_closed = t.walk_fan(Vertex(v as u32), |h| around.push(h.0));
                out.add_fan(t, &around, is_closed, kind);
            }
            out.list_positions();
            out.close(v as u32);
            out.is_late.push(starts.is_late(v as u32));
        }
        out.centres = out.owners.len();
        if !matches!(t.face, FaceOf::Quads) {
            for (f, ends) in t.face_offset.windows(2).enumerate().filter(|(_, ends)| ends[1] - ends[0] != 4) {
                let n = ends[1] - ends[0];
                out.edges.extend((ends[0]..ends[1]).map(|h| kind(t.edge[h as usize])).map(|[e, _]| [e, 0]));
                let turned = |k: u32, by: u32| (k + by) % n;
                out.faces.extend((0..n).map(|k| FanFace {
                    h: ends[0] + k,
                    sides: [turned(k, n - 1), k],
                    beyond: [turned(k, 2 * n - 2), turned(k, 1)],
                }));
                out.close(f as u32);
            }
        }
        out
    }

    /// The fan of a vertex with one run of faces, counter-clockwise.
    fn add_fan(&mut self, t: &Topology, around: &[u32], is_closed: bool, kind: impl Fn(u32) -> [u32; 2]) {
        let n = around.len() as u32;
        self.edges.extend(around.iter().map(|&h| kind(t.edge[h as usize])));
        if !is_closed {
            let last = t.prev(HalfEdge(around[around.len() - 1]));
            self.edges.push(kind(t.edge(last).0));
        }
        for (i, &h) in (0..n).zip(around) {
            let (sides, beyond) = match is_closed {
                true => ([i, (i + 1) % n], [(i + n - 1) % n, (i + 2) % n]),
                false => ([i, i + 1], [i.checked_sub(1).unwrap_or(NONE), if i + 2 > n { NONE } else { i + 2 }]),
            };
            self.faces.push(FanFace { h, sides, beyond });
        }
    }

    /// The faces at any vertex, in no order; what lies across an edge without a twin is not asked for.
    fn add_sheets(&mut self, t: &Topology, around: &[u32], kind: impl Fn(u32) -> [u32; 2]) {
        let start = self.edges.len();
        let sides = |h: u32| [HalfEdge(h), t.prev(HalfEdge(h))];
        let mut edges: Vec<u32> = around.iter().flat_map(|&h| sides(h).map(|h| t.edge(h).0)).collect();
        edges.sort_unstable();
        edges.dedup();
        let at = |h: HalfEdge| edges.binary_search(&t.edge(h).0).map_or(NONE, |i| i as u32);
        for &h in around {
            let [out, back] = sides(h);
            let beyond = [t.twin(out).map(|h| t.next(h)), t.twin(back).map(|h| t.prev(h))];
            self.faces.push(FanFace { h, sides: [at(out), at(back)], beyond: beyond.map(|h| h.map_or(NONE, at)) });
        }
        self.edges.extend(edges.into_iter().map(kind));
        debug_assert!(self.edges.len() > start);
    }

    /// Makes the faces of the fan at hand, that of a vertex, findable where they are many.
    fn list_positions(&mut self) {
        let faces = &self.faces[self.starts[self.owners.len()][1] as usize..];
        if faces.len() > LISTED {
            self.positions.extend(faces.iter().zip(0..).map(|(face, i)| (face.h, i)));
        }
    }

    /// Ends the list of a fan's edges and faces.
    fn close(&mut self, owner: u32) {
        self.owners.push(owner);
        self.starts.push([self.edges.len() as u32, self.faces.len() as u32]);
    }

    /// Adds the rules from the next level on, whose sharpness `t` has. `special` are the vertices that do not follow the smooth one.
    pub fn add_rows(&mut self, t: &Topology, scheme: Scheme, special: &[u32]) {
        let (mut rows, mut mask, mut ends) = (Special::default(), Mask::default(), Vec::new());
        self.row_of.resize(self.owners.len(), NONE);
        for &v in special {
            // A vertex without a face stays where it is.
            let Some(fan) = self.of_vertex[v as usize].checked_sub(1) else { continue };
            self.row_of[fan as usize] = rows.owners.len() as u32;
            if self.rows.is_empty() && self.starts_at(fan as usize) > self.start {
                // No rule of quads applies yet, nor is any asked for.
                rows.push_from((0, 0.0), fan, std::iter::empty());
                continue;
            }
            vertex_mask(t, scheme, Vertex(v), &mut mask);
            let [edges, faces] = self.range(fan as usize);
            ends.clear();
            ends.extend(self.edges[edges.clone()].iter().zip(1..).map(|(edge, id)| (edge[0], id)));
            ends.sort_unstable();
            let end = |e: u32| match e {
                NONE => 0,
                e => ends[ends.binary_search_by_key(&e, |end| end.0).expect("an edge of the vertex")].1,
            };
            let own = mask.vertices.iter().zip(&mask.edges).map(|(&(_, weight), &e)| (end(e), weight));
            // The mask lists faces as the fan does, if at all.
            debug_assert!(mask.faces.iter().zip(&self.faces[faces]).all(|(term, face)| term.0 == t.face.get(face.h)));
            let faces = mask.faces.iter().zip(1 + edges.len() as u32..).map(|(&(_, weight), id)| (id, weight));
            // The vertex first: sums are relative to it.
            rows.push_from((0, 0.0), fan, own.filter(|term| term.0 > 0).chain(faces));
        }
        self.rows.push(rows);
    }

    fn range(&self, fan: usize) -> [Range<usize>; 2] {
        let (start, end) = (self.starts[fan], self.starts[fan + 1]);
        [start[0] as usize..end[0] as usize, start[1] as usize..end[1] as usize]
    }

    /// The fan of a control vertex that is not regular.
    #[inline(always)]
    pub fn of_vertex(&self, v: u32) -> Option<u32> {
        self.of_vertex.get(v as usize).and_then(|fan| fan.checked_sub(1))
    }

    /// The fan of the centre of a face that is no quad.
    pub fn of_centre(&self, f: u32) -> Option<u32> {
        self.owners[self.centres..].binary_search(&f).ok().map(|i| (self.centres + i) as u32)
    }

    /// Where the face with a half-edge lies in a fan.
    #[inline(always)]
    pub fn corner(&self, tables: Option<&FanTables>, fan: u32, h: u32) -> FanCorner {
        let faces = &self.faces[self.starts[fan as usize][1] as usize..self.starts[fan as usize + 1][1] as usize];
        let at = if fan as usize >= self.centres {
            (h - faces[0].h) as usize
        } else if faces.len() > LISTED {
            self.positions[&h] as usize
        } else {
            faces.iter().position(|face| face.h == h).unwrap_or(0)
        };
        let points = 1 + self.starts[fan as usize + 1][0] - self.starts[fan as usize][0];
        let kept = tables.map_or(self.kept_before(fan as usize) as u32, |tables| tables.places[fan as usize][1]);
        FanCorner { kept, points, beyond: faces[at].beyond }
    }

    /// How many values are kept of a fan, and where tables do not say it of all that come before.
    fn kept_of(&self, fan: usize) -> usize {
        self.kept_before(fan + 1) - self.kept_before(fan)
    }

    fn kept_before(&self, fan: usize) -> usize {
        (self.starts[fan][0] as usize + fan) * self.between()
    }

    /// The rule of a vertex that does not follow the smooth one, among those of each level.
    #[inline(always)]
    fn row(&self, fan: usize) -> Option<usize> {
        Some(self.row_of[fan]).filter(|&row| row != NONE).map(|row| row as usize)
    }

    /// The level at which a fan starts.
    #[inline(always)]
    fn starts_at(&self, fan: usize) -> usize {
        usize::from(self.is_late.get(fan) != Some(&false))
    }

    /// Levels between the first and the last.
    fn between(&self) -> usize {
        (self.depth - self.start).saturating_sub(1)
    }

    /// Vertices with rules of their own, summed over the levels.
    pub fn special(&self) -> usize {
        let applied = |(rows, at): (&Special, usize)| {
            rows.owners.iter().filter(|&&fan| at >= self.starts_at(fan as usize)).count()
        };
        self.rows.iter().zip(self.start..).map(applied).sum()
    }

    pub fn bytes(&self) -> usize {
        4 * (self.of_vertex.len() + self.owners.len() + self.row_of.len() + 2 * self.positions.len())
            + self.is_late.len()
            + size_of_val(&self.starts[..])
            + size_of_val(&self.edges[..])
            + size_of_val(&self.faces[..])
            + self.rows.iter().map(Special::bytes).sum::<usize>()
    }
}
