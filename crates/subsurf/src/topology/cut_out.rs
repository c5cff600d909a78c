//! What surrounds one face: the faces at its corners, in a canonical order, as a comparable key and as a small topology
//! of its own. The limit of the face depends on nothing else.

use super::{EdgeFlags, Interpolation, NONE, Topology};
use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::mask::other_end;
use crate::sharpness::edge_half;
use crate::tags::{Creasing, INFINITE_SHARPNESS};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// New numbers by old ones.
type Numbers = HashMap<u32, u32, BuildHasherDefault<NumberHasher>>;

/// Spreads numbers that follow each other.
#[derive(Default)]
struct NumberHasher(u64);

impl Hasher for NumberHasher {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&b| self.write_u32(u32::from(b)));
    }
    fn write_u32(&mut self, x: u32) {
        self.0 = (self.0 ^ u64::from(x)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(32);
    }
}

/// Reusable memory of [`Topology::surroundings`]: which vertices and faces the current walk has met.
#[derive(Default)]
pub(crate) struct Walk {
    vertex_slot: Stamps,
    face_slot: Stamps,
}

/// An array of slots that is cleared in no time.
#[derive(Default)]
struct Stamps {
    round: u32,
    slot: Vec<(u32, u32)>,
}

impl Stamps {
    fn clear(&mut self, len: usize) {
        if self.slot.len() < len || self.round == u32::MAX {
            self.slot = vec![(0, 0); len];
            self.round = 0;
        }
        self.round += 1;
    }

    fn get(&self, i: u32) -> Option<u32> {
        let (round, slot) = self.slot[i as usize];
        (round == self.round).then_some(slot)
    }

    fn set(&mut self, i: u32, slot: u32) {
        self.slot[i as usize] = (self.round, slot);
    }
}

/// The faces round one face.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surroundings {
    /// The vertices of all these faces, the face's own corners first. They are the *ring* of the face.
    pub ring: Vec<u32>,
    /// One half-edge of every face, the face itself first.
    pub faces: Vec<u32>,
    /// Equal keys mean equal limit masks over the ring.
    pub key: Vec<u32>,
}

impl Topology {
    /// Walks round the corners of `face`, starting at corner `start`.
    ///
    /// Round each corner the walk goes counter-clockwise from the face to the end of the fan, then clockwise from the
    /// face; faces and vertices are listed in the order of their first visit. The key lists, for every face met, its
    /// ring positions, and for every corner of the face the sharpness of vertex and spokes.
    pub(crate) fn surroundings(&self, face: Face, start: usize, walk: &mut Walk, out: &mut Surroundings) {
        let sides = self.sides(face);
        out.ring.clear();
        out.faces.clear();
        out.key.clear();
        walk.vertex_slot.clear(self.vertex_count);
        walk.face_slot.clear(self.face_count());
        let corner = |i: usize| self.half_edge(face, (start + i) % sides);
        self.visit(corner(0), walk, out);
        for i in 0..sides {
            let own = corner(i);
            out.key.push(u32::MAX);
            let mut at = own;
            let closed = loop {
                match self.turn_left(at) {
                    None => break false,
                    Some(h) if h == own => break true,
                    Some(h) => {
                        self.visit(h, walk, out);
                        at = h;
                    }
                }
            };
            out.key.push(u32::MAX - 1 - u32::from(closed));
            if !closed {
                at = own;
                while let Some(h) = self.turn_right(at) {
                    self.visit(h, walk, out);
                    at = h;
                }
            }
            self.note_sharpness(own, closed, &mut out.key);
        }
    }

    fn visit(&self, h: HalfEdge, walk: &mut Walk, out: &mut Surroundings) {
        let face = self.face(h);
        if let Some(slot) = walk.face_slot.get(face.0) {
            out.key.push(slot);
            return;
        }
        walk.face_slot.set(face.0, out.faces.len() as u32);
        out.faces.push(h.0);
        out.key.push(u32::MAX - 3);
        out.key.push(self.sides(face) as u32);
        let mut at = h;
        loop {
            let v = self.origin(at).0;
            let slot = walk.vertex_slot.get(v).unwrap_or_else(|| {
                let slot = out.ring.len() as u32;
                walk.vertex_slot.set(v, slot);
                out.ring.push(v);
                slot
            });
            out.key.push(slot);
            at = self.next(at);
            if at == h {
                break;
            }
        }
    }

    /// Sharpness at the origin of `own` as far as it is not zero: of the vertex, of the spokes in walking order, of
    /// edges of other sheets.
    fn note_sharpness(&self, own: HalfEdge, closed: bool, key: &mut Vec<u32>) {
        let v = self.origin(own);
        let (s, sharp) = (self.vertex_sharpness(v), self.sharp_edges(v));
        if s == 0.0 && sharp.is_empty() && self.foreign_sharpness(v).is_empty() {
            return;
        }
        let mut note = |s: f64| key.extend([(s.to_bits() >> 32) as u32, s.to_bits() as u32]);
        note(s);
        let mut seen = Vec::with_capacity(8);
        let mut spoke = |e: Edge, seen: &mut Vec<u32>| {
            note(self.edge_sharpness(e));
            if self.interpolation == Interpolation::LinearBoundaries {
                // Where sheets meet, an edge without twin is no boundary.
                note(f64::from(self.is_boundary(e)));
            }
            if self.far_end_matters(e) {
                note(edge_half(self, e, other_end(self, e, v)));
            }
            seen.push(e.0);
        };
        spoke(self.edge(own), &mut seen);
        let mut at = own;
        loop {
            spoke(self.edge(self.prev(at)), &mut seen);
            match self.turn_left(at).filter(|&h| h != own) {
                Some(h) => at = h,
                None => break,
            }
        }
        if !closed {
            at = own;
            while let Some(h) = self.turn_right(at) {
                spoke(self.edge(h), &mut seen);
                at = h;
            }
        }
        let foreign = self.foreign_edges(v, &seen);
        for others in [&foreign[..], self.across_seam(v)] {
            key.push(others.len() as u32);
            others.iter().for_each(|s| key.extend([(s.to_bits() >> 32) as u32, s.to_bits() as u32]));
        }
    }

    /// True where the new vertex on edge `e` depends on all sharp edges at both ends: under Chaikin's rule, whose
    /// fractions are sharp while both halves of the edge stay so.
    fn far_end_matters(&self, e: Edge) -> bool {
        let s = self.edge_sharpness(e);
        self.rules.creasing == Creasing::Chaikin && s > 0.0 && s < INFINITE_SHARPNESS
    }

    /// Sharpness of the sharp edges at `v` that are not among `known`.
    fn foreign_edges(&self, v: Vertex, known: &[u32]) -> Vec<f64> {
        // On a pinned vertex they change nothing but Chaikin's averages, and a manifold vertex has none of its own.
        if self.vertex_sharpness(v) >= INFINITE_SHARPNESS && self.rules.creasing == Creasing::Uniform {
            return Vec::new();
        }
        if !self.vertex_non_manifold[v.index()] {
            return self.foreign_sharpness(v).to_vec();
        }
        let others = self.sharp_edges(v).iter().filter(|e| !known.contains(e)).map(|&e| self.edge_sharpness(Edge(e)));
        others.chain(self.foreign_sharpness(v).iter().copied()).collect()
    }

    /// The surrounding faces as a topology of their own. Face 0 is the face itself, turned so that its walk's first
    /// corner is corner 0; vertex `i` is the ring's `i`-th.
    ///
    /// At the face's own corners everything is as in `self`. The outer rim is cut: its edges are boundaries.
    pub(crate) fn cut_out(&self, around: &Surroundings) -> Topology {
        // The face's own corners come first in the ring; a degenerate face names one twice.
        let mut own = 0;
        let mut at = HalfEdge(around.faces[0]);
        for _ in 0..self.sides(self.face(at)) {
            own = own.max(1 + around.ring.iter().position(|&v| v == self.origin(at).0).unwrap_or(0));
            at = self.next(at);
        }
        self.part(around, own)
    }

    /// Some faces as a topology of their own, each turned so that the half-edge that stands for it comes first. At the first
    /// `own` vertices of the ring, all of whose faces round some corner are there, everything is as in `self`.
    pub(crate) fn part(&self, around: &Surroundings, own: usize) -> Topology {
        let mut vertex_of = Numbers::default();
        around.ring.iter().enumerate().for_each(|(i, &v)| {
            vertex_of.insert(v, i as u32);
        });
        // Half-edges in their new order, each face from its walk's first corner on.
        let mut half_edges = Vec::new();
        let mut face_offset = vec![0u32];
        for &h in &around.faces {
            let mut at = HalfEdge(h);
            loop {
                half_edges.push(at.0);
                at = self.next(at);
                if at.0 == h {
                    break;
                }
            }
            face_offset.push(half_edges.len() as u32);
        }
        let new_of: Numbers = half_edges.iter().enumerate().map(|(i, &h)| (h, i as u32)).collect();
        let origin: Vec<u32> = half_edges.iter().map(|&h| vertex_of[&self.origin[h as usize]]).collect();
        let twin: Vec<u32> =
            half_edges.iter().map(|&h| new_of.get(&self.twin[h as usize]).copied().unwrap_or(NONE)).collect();
        let face = (0..around.faces.len())
            .flat_map(|f| std::iter::repeat_n(f as u32, (face_offset[f + 1] - face_offset[f]) as usize));
        let is_own = |v: u32| (v as usize) < own;

        // Edges keep their identity, so that the two faces of a non-manifold edge still share it.
        let mut edge_of = Numbers::default();
        let mut edge_old = Vec::new();
        let mut edge_half_edge = Vec::new();
        let edge: Vec<u32> = half_edges
            .iter()
            .enumerate()
            .map(|(i, &h)| {
                *edge_of.entry(self.edge[h as usize]).or_insert_with(|| {
                    edge_old.push(self.edge[h as usize]);
                    edge_half_edge.push(i as u32);
                    edge_old.len() as u32 - 1
                })
            })
            .collect();
        let edge_vertices: Vec<[u32; 2]> =
            edge_old.iter().map(|&e| self.edge_vertices[e as usize].map(|v| vertex_of[&v])).collect();
        let mut edge_sharpness: Vec<f64> = edge_old.iter().map(|&e| self.edge_sharpness[e as usize]).collect();
        let mut edge_flags = vec![EdgeFlags::default(); edge_old.len()];
        for (i, &e) in edge.iter().enumerate() {
            if twin[i] == NONE {
                let old = half_edges[i] as usize;
                edge_flags[e as usize] = match self.twin[old] {
                    NONE => self.edge_flags[self.edge[old] as usize],
                    _ => EdgeFlags { boundary: true, non_manifold: false },
                };
                if !edge_vertices[e as usize].iter().any(|&v| is_own(v)) {
                    edge_sharpness[e as usize] = INFINITE_SHARPNESS;
                }
            }
        }
        let old_edges: Vec<u32> = edge_old.clone();
        let foreign = |i: usize| {
            let list = self.foreign_edges(Vertex(around.ring[i]), &old_edges);
            (!list.is_empty()).then_some((i as u32, list))
        };
        let across_seam = |i: usize| {
            let list = self.across_seam(Vertex(around.ring[i]));
            (!list.is_empty()).then(|| (i as u32, list.to_vec()))
        };
        let far_half = edge_old.iter().zip(&edge_vertices).enumerate().flat_map(|(new, (&old, ends))| {
            let far = |&v: &u32| !is_own(v) && ends.iter().any(|&v| is_own(v)) && self.far_end_matters(Edge(old));
            let half = move |v: u32| ((new as u32, v), edge_half(self, Edge(old), Vertex(around.ring[v as usize])));
            ends.iter().copied().filter(far).map(half).collect::<Vec<_>>()
        });
        let far_half = far_half.collect();
        let vertex_count = around.ring.len();
        let mut cut = Topology {
            vertex_count,
            face: face.collect(),
            face_offset,
            vertex_half_edge: super::build::leading_half_edges(vertex_count, &origin, &twin),
            origin,
            edge,
            twin,
            edge_vertices,
            edge_half_edge,
            edge_flags,
            edge_sharpness,
            vertex_non_manifold: around.ring.iter().map(|&v| self.vertex_non_manifold[v as usize]).collect(),
            vertex_sharpness: around.ring.iter().map(|&v| self.vertex_sharpness[v as usize]).collect(),
            sharp_offset: Vec::new(),
            sharp_edges: Vec::new(),
            hole: vec![false; around.faces.len()],
            rules: self.rules,
            foreign_sharpness: (0..own).filter_map(foreign).collect(),
            across_seam: (0..own).filter_map(across_seam).collect(),
            interpolation: self.interpolation,
            far_half,
        };
        cut.index_sharp_edges();
        cut
    }
}
