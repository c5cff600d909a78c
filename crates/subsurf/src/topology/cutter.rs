//! Cuts the surroundings of a face out of a mesh, as a topology of their own, into memory that is used again.

use super::cut_out::Around;
use super::{
    EdgeFlags, Edits, FaceOf, Interpolation, NONE, SharpnessColumn, Surroundings, Tables, Topology, Walk, lowered,
};
use crate::index::{Face, HalfEdge, Vertex};
use crate::sharpness::edge_half;
use crate::tags::{INFINITE_SHARPNESS, Rules};
use std::collections::BTreeMap;

/// Reusable memory, and the last topology that was cut out.
pub(crate) struct Cutter {
    cut: Topology,
    /// Half-edges of the whole by those of the cut, likewise edges.
    half_edges: Vec<u32>,
    edges: Vec<u32>,
    /// Edges of the cut that have no twins in the whole and several faces there.
    non_manifold: Vec<u32>,
}

impl Default for Cutter {
    fn default() -> Self {
        Self { cut: empty(), half_edges: Vec::new(), edges: Vec::new(), non_manifold: Vec::new() }
    }
}

impl Cutter {
    /// Makes the surrounding faces a topology of their own. Face 0 is the face itself, turned so that its walk's first
    /// corner is corner 0; vertex `i` is the ring's `i`-th. Finite sharpness is lowered as it is in the key.
    ///
    /// At the face's own corners everything is as in `t`. The outer rim is cut: its edges are boundaries. `walk` is the one
    /// that gave `around`, and has done nothing since.
    pub fn cut_out(&mut self, t: &impl Tables, around: &Surroundings, walk: &Walk) {
        self.faces(t, around, walk);
        let own = own_corners(&self.cut);
        self.edges(t, around, own);
        self.vertices(t, around, own);
    }

    /// Makes some faces a topology of their own, each turned so that the half-edge that stands for it comes first. At the
    /// first `own` vertices of the ring, all of whose faces round some corner are there, everything is as in `t`.
    pub fn part(t: &impl Tables, around: &Surroundings, own: usize) -> Topology {
        let (mut cutter, walk) = (Self::default(), Walk::over(t, around));
        cutter.faces(t, around, &walk);
        cutter.edges(t, around, own as u32);
        cutter.vertices(t, around, own as u32);
        cutter.take()
    }

    /// The last topology.
    pub fn cut(&self) -> &Topology {
        &self.cut
    }

    /// Gives away the last topology.
    pub fn take(&mut self) -> Topology {
        std::mem::replace(&mut self.cut, empty())
    }

    /// Takes back the memory of a topology.
    pub fn give_back(&mut self, cut: Topology) {
        self.cut = cut;
    }

    /// Half-edges in their new order, each face from its walk's first corner on.
    fn faces(&mut self, t: &impl Tables, around: &Surroundings, walk: &Walk) {
        let Self { cut, half_edges, .. } = self;
        let lists = [&mut *half_edges, &mut cut.face_offset, &mut cut.origin, &mut cut.twin];
        for list in lists {
            list.clear();
            // Most faces are quads.
            list.reserve(4 * around.faces.len() + 1);
        }
        cut.face_offset.push(0);
        for &h in &around.faces {
            let mut at = HalfEdge(h);
            loop {
                half_edges.push(at.0);
                cut.origin.push(walk.vertex(t.origin(at)).unwrap_or(NONE));
                at = t.next(at);
                if at.0 == h {
                    break;
                }
            }
            cut.face_offset.push(half_edges.len() as u32);
        }
        cut.face.refill(&cut.face_offset);
        // A half-edge of a face in the list lies as far behind the face's listed one as it does in the whole.
        let new = |h: HalfEdge| {
            let face = t.face(h);
            let slot = walk.face(face)? as usize;
            let sides = t.sides(face) as u32;
            Some(cut.face_offset[slot] + (h.0 + sides - around.faces[slot]) % sides)
        };
        cut.twin.extend(half_edges.iter().map(|&h| t.twin(HalfEdge(h)).and_then(new).unwrap_or(NONE)));
    }

    /// Edges keep their identity, so that the two faces of a non-manifold edge still share it.
    fn edges(&mut self, t: &impl Tables, around: &Surroundings, own: u32) {
        let Self { cut, half_edges, edges, non_manifold } = self;
        [&mut *edges, &mut *non_manifold, &mut cut.edge, &mut cut.edge_half_edge].into_iter().for_each(Vec::clear);
        cut.edge_vertices.clear();
        cut.edge_flags.clear();
        cut.edge_sharpness.clear();
        cut.far_half.clear();
        cut.edge.reserve(half_edges.len());
        // Euler's formula for a disc.
        let count = around.ring.len() + around.faces.len();
        edges.reserve(count);
        cut.edge_half_edge.reserve(count);
        cut.edge_vertices.reserve(count);
        cut.edge_flags.reserve(count);
        for (i, &h) in half_edges.iter().enumerate() {
            let (h, twin) = (HalfEdge(h), cut.twin[i]);
            if twin != NONE && (twin as usize) < i {
                cut.edge.push(cut.edge[twin as usize]);
                continue;
            }
            let old = t.edge(h);
            let flags = t.edge_flags(old);
            if flags.non_manifold
                && let Some(&known) = non_manifold.iter().find(|&&e| edges[e as usize] == old.0)
            {
                cut.edge.push(known);
                continue;
            }
            let e = edges.len() as u32;
            if flags.non_manifold {
                non_manifold.push(e);
            }
            // The half-edge runs from one end to the other.
            let next = cut.next(HalfEdge(i as u32)).index();
            let (from, to) = (cut.origin[i], cut.origin[next]);
            let is_forward = t.edge_vertices(old)[0] == t.origin(h);
            let ends = if is_forward { [from, to] } else { [to, from] };
            let is_own = ends.map(|v| v < own);
            let is_cut = twin == NONE && t.twin(h).is_some();
            let is_rim = twin == NONE && is_own == [false; 2];
            edges.push(old.0);
            cut.edge.push(e);
            cut.edge_half_edge.push(i as u32);
            cut.edge_vertices.push(ends);
            cut.edge_flags.push(match (is_cut, twin) {
                (true, _) => EdgeFlags { boundary: true, non_manifold: false },
                (false, NONE) => flags,
                (false, _) => EdgeFlags::default(),
            });
            let sharpness = if is_rim { INFINITE_SHARPNESS } else { lowered(t.edge_sharpness(old), around.raise) };
            cut.edge_sharpness.push(sharpness);
            if is_own != [is_own[0]; 2] && t.far_end_matters(old) {
                let far = ends[usize::from(is_own[0])];
                cut.far_half.insert((e, far), edge_half(t, old, Vertex(around.ring[far as usize])));
            }
        }
    }

    fn vertices(&mut self, t: &impl Tables, around: &Surroundings, own: u32) {
        let Self { cut, edges, .. } = self;
        let count = around.ring.len();
        cut.vertex_count = count;
        cut.vertex_half_edge.clear();
        cut.vertex_half_edge.resize(count, NONE);
        super::build::lead_fans(&cut.origin, &cut.twin, &mut cut.vertex_half_edge);
        let ring = || around.ring.iter().map(|&v| Vertex(v));
        cut.vertex_non_manifold.clear();
        cut.vertex_non_manifold.extend(ring().map(|v| t.is_non_manifold_vertex(v)));
        cut.vertex_sharpness.clear();
        ring().for_each(|v| cut.vertex_sharpness.push(lowered(t.vertex_sharpness(v), around.raise)));
        cut.foreign_sharpness.clear();
        cut.across_seam.clear();
        for (i, v) in ring().enumerate().take(own as usize) {
            let lists = [t.foreign_edges(v, edges).into(), t.across_seam(v)];
            for (list, of) in lists.into_iter().zip([&mut cut.foreign_sharpness, &mut cut.across_seam]) {
                if !list.is_empty() {
                    of.insert(i as u32, list.iter().map(|&s| lowered(s, around.raise)).collect());
                }
            }
        }
        cut.hole.clear();
        cut.hole.resize(around.faces.len(), false);
        cut.rules = *t.rules();
        cut.interpolation = t.interpolation();
        cut.index_sharp_edges();
    }
}

/// Number of vertices that are corners of face 0: they come first in the ring. A degenerate face names one twice.
fn own_corners(cut: &Topology) -> u32 {
    cut.face_vertices(Face(0)).iter().max().map_or(0, |&v| v + 1)
}

/// Tables without rows.
fn empty() -> Topology {
    Topology {
        vertex_count: 0,
        face_offset: Vec::new(),
        origin: Vec::new(),
        face: FaceOf::Quads,
        edge: Vec::new(),
        twin: Vec::new(),
        edge_vertices: Vec::new(),
        edge_half_edge: Vec::new(),
        edge_flags: Vec::new(),
        edge_sharpness: SharpnessColumn::smooth(0),
        vertex_half_edge: Vec::new(),
        vertex_non_manifold: Vec::new(),
        vertex_sharpness: SharpnessColumn::smooth(0),
        sharp_offset: Vec::new(),
        sharp_edges: Vec::new(),
        hole: Vec::new(),
        rules: Rules::default(),
        foreign_sharpness: BTreeMap::new(),
        across_seam: BTreeMap::new(),
        interpolation: Interpolation::default(),
        far_half: BTreeMap::new(),
        edits: Edits::default(),
        fan_sizes: Vec::new(),
    }
}
