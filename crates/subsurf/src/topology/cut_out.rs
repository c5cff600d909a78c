//! What surrounds one face: the faces at its corners, in a canonical order, as a comparable key. The limit of the face
//! depends on nothing else.

use super::{Interpolation, Tables, Topology, lowered};
use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::sharpness::edge_half;
use crate::tags::{Creasing, INFINITE_SHARPNESS};

/// Reusable memory of [`Topology::surroundings`]: which vertices and faces the current walk has met.
#[derive(Default)]
pub(crate) struct Walk {
    vertex_slot: Slots,
    face_slot: Slots,
}

/// Slots by number: a hash table as large as what one walk meets, not as the mesh, and cleared in no time.
#[derive(Default)]
struct Slots {
    round: u32,
    count: usize,
    /// Number, round and slot; entries of earlier rounds are empty. A power of two, at most half of them in use.
    entries: Vec<(u32, u32, u32)>,
}

impl Slots {
    fn clear(&mut self) {
        if self.entries.is_empty() || self.round == u32::MAX {
            self.entries = vec![(0, 0, 0); self.entries.len().max(256)];
            self.round = 0;
        }
        self.round += 1;
        self.count = 0;
    }

    /// Where number `i` is, or would be.
    #[inline]
    fn place(&self, i: u32) -> usize {
        let mask = self.entries.len() - 1;
        let mut at = (i.wrapping_mul(0x9e37_79b9) >> 16) as usize ^ i as usize;
        loop {
            at &= mask;
            let (number, round, _) = self.entries[at];
            if round != self.round || number == i {
                return at;
            }
            at += 1;
        }
    }

    #[inline]
    fn get(&self, i: u32) -> Option<u32> {
        let (_, round, slot) = self.entries[self.place(i)];
        (round == self.round).then_some(slot)
    }

    #[inline]
    fn set(&mut self, i: u32, slot: u32) {
        if 2 * self.count >= self.entries.len() {
            let all = vec![(0, 0, 0); 2 * self.entries.len()];
            for (i, _, slot) in std::mem::replace(&mut self.entries, all).into_iter().filter(|e| e.1 == self.round) {
                let at = self.place(i);
                self.entries[at] = (i, self.round, slot);
            }
        }
        let at = self.place(i);
        self.count += usize::from(self.entries[at].1 != self.round);
        self.entries[at] = (i, self.round, slot);
    }
}

impl Walk {
    /// As if a walk had met faces and vertices in the order of the lists.
    pub(super) fn over(t: &impl Tables, around: &Surroundings) -> Self {
        let mut walk = Self::default();
        walk.vertex_slot.clear();
        walk.face_slot.clear();
        around.ring.iter().zip(0..).for_each(|(&v, slot)| walk.vertex_slot.set(v, slot));
        around.faces.iter().zip(0..).for_each(|(&h, slot)| walk.face_slot.set(t.face(HalfEdge(h)).0, slot));
        walk
    }

    /// Position in the ring of a vertex that the last walk met.
    pub(super) fn vertex(&self, v: Vertex) -> Option<u32> {
        self.vertex_slot.get(v.0)
    }

    /// Position among the faces of a face that the last walk met.
    pub(super) fn face(&self, f: Face) -> Option<u32> {
        self.face_slot.get(f.0)
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
    /// By how much finite sharpness is [lowered] in the key.
    pub raise: i8,
    /// Where sharpness stands in the key, two numbers each.
    sharpness: Vec<u32>,
}

impl Surroundings {
    /// Makes the key that of a plan: the walk's, then where sharpness stands in it, their number, and the raise.
    pub fn close_key(&mut self) {
        self.key.extend_from_slice(&self.sharpness);
        self.key.extend([self.sharpness.len() as u32, self.raise as u32]);
    }

    /// What [`close_key`](Self::close_key) has put together: the walk's key, where sharpness stands in it, and the raise.
    pub fn open_key(key: &[u32]) -> (&[u32], &[u32], u8) {
        let [lists @ .., count, raise] = key else { return (key, &[], 0) };
        let (walk, sharpness) = lists.split_at(lists.len() - *count as usize);
        (walk, sharpness, *raise as u8)
    }

    /// Where sharpness stands in the key.
    pub fn sharpness(&self) -> &[u32] {
        &self.sharpness
    }

    /// Makes the key that of the same surroundings lowered by `raise`. All finite sharpness there and here is above 0.
    pub fn lower(&mut self, raise: i8) {
        let by = raise - std::mem::replace(&mut self.raise, raise);
        for at in self.sharpness.iter().map(|&at| at as usize) {
            let s = f64::from_bits(u64::from(self.key[at]) << 32 | u64::from(self.key[at + 1]));
            self.key[at..at + 2].copy_from_slice(&number(lowered(s, by)));
        }
    }
}

/// A number in a key.
fn number(s: f64) -> [u32; 2] {
    let bits = s.to_bits();
    [(bits >> 32) as u32, bits as u32]
}

impl Topology {
    /// [`Walks`](Around::lowered_surroundings) round the corners of `face`, nothing lowered.
    pub(crate) fn surroundings(&self, face: Face, start: usize, walk: &mut Walk, out: &mut Surroundings) {
        self.lowered_surroundings(face, start, 0, walk, out);
    }
}

impl<T: Tables> Around for T {}

/// Walks round faces.
pub(crate) trait Around: Tables {
    /// Walks round the corners of `face`, starting at corner `start`; finite sharpness is lowered by `raise`.
    ///
    /// Round each corner the walk goes counter-clockwise from the face to the end of the fan, then clockwise from the
    /// face; faces and vertices are listed in the order of their first visit. The key lists, for every face met, its
    /// ring positions, and for every corner of the face the sharpness of vertex and spokes.
    fn lowered_surroundings(&self, face: Face, start: usize, raise: i8, walk: &mut Walk, out: &mut Surroundings) {
        out.raise = raise;
        let sides = self.sides(face);
        out.ring.clear();
        out.faces.clear();
        out.key.clear();
        out.sharpness.clear();
        walk.vertex_slot.clear();
        walk.face_slot.clear();
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
            self.note_sharpness(own, closed, out);
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
    fn note_sharpness(&self, own: HalfEdge, closed: bool, out: &mut Surroundings) {
        let Surroundings { key, raise, sharpness, .. } = out;
        let v = self.origin(own);
        let s = self.vertex_sharpness(v);
        if s == 0.0 && self.sharp_edges(v).next().is_none() && self.foreign_sharpness(v).is_empty() {
            return;
        }
        let mut note = |s: f64, key: &mut Vec<u32>| {
            sharpness.push(key.len() as u32);
            key.extend(number(lowered(s, *raise)));
        };
        note(s, key);
        let mut seen = Vec::with_capacity(8);
        let mut spoke = |e: Edge, seen: &mut Vec<u32>| {
            note(self.edge_sharpness(e), key);
            if self.interpolation() == Interpolation::LinearBoundaries {
                // Where sheets meet, an edge without twin is no boundary.
                key.push(self.edge_flags(e).boundary.into());
            }
            if self.far_end_matters(e) {
                note(edge_half(self, e, self.other_end(e, v)), key);
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
        for others in [&foreign[..], &self.across_seam(v)] {
            key.push(others.len() as u32);
            others.iter().for_each(|&s| note(s, key));
        }
    }

    /// The end of `e` that is not `v`.
    fn other_end(&self, e: Edge, v: Vertex) -> Vertex {
        let [a, b] = self.edge_vertices(e);
        if a == v { b } else { a }
    }

    /// True where the new vertex on edge `e` depends on all sharp edges at both ends: under Chaikin's rule, whose
    /// fractions are sharp while both halves of the edge stay so.
    fn far_end_matters(&self, e: Edge) -> bool {
        let s = self.edge_sharpness(e);
        self.rules().creasing == Creasing::Chaikin && s > 0.0 && s < INFINITE_SHARPNESS
    }

    /// Sharpness of the sharp edges at `v` that are not among `known`.
    fn foreign_edges(&self, v: Vertex, known: &[u32]) -> Vec<f64> {
        // On a pinned vertex they change nothing but Chaikin's averages, and a manifold vertex has none of its own.
        if self.vertex_sharpness(v) >= INFINITE_SHARPNESS && self.rules().creasing == Creasing::Uniform {
            return Vec::new();
        }
        if !self.is_non_manifold_vertex(v) {
            return self.foreign_sharpness(v).to_vec();
        }
        let others = self.sharp_edges(v).filter(|e| !known.contains(&e.0)).map(|e| self.edge_sharpness(e));
        others.chain(self.foreign_sharpness(v).iter().copied()).collect()
    }
}
