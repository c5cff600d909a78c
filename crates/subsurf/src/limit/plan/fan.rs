//! Below the first step a quad's surroundings follow from the fan at one of its vertices.
//!
//! The child of a quad at a vertex `v` has `v` at its first corner; its other corners are new: an edge point, a face point and an
//! edge point, with four quads each (two on a boundary), and nothing sharp but the halves of the two edges at `v` and what goes on
//! beyond them, as sharp. So all that rules can see is the fan at `v`: how many faces, which of them is the parent, and the
//! sharpness of vertex and spokes. Its key is that, its ring can be listed without a walk:
//!
//! ```text
//!    (-1,2)---(0,2)----(1,2)---(2,2)       ring: v e_0 f_0 e_1 f_1 .., closed fans end with f_{n-1}, open ones with e_n;
//!      |        |        |       |          then (2,-1) (2,0) (2,1) (2,2) (1,2) (0,2) (-1,2)
//!   f_{i+1}--e_{i+1}---f_i----(2,1)         without (2,-1) where v-e_i is a boundary,
//!      |        |        |       |          without (-1,2) where v-e_{i+1} is one
//!   e_{i+2}-----v-------e_i----(2,0)
//!               |        |       |
//!            e_{i-1}--f_{i-1}--(2,-1)
//! ```
//!
//! That holds under Catmull-Clark with uniform creasing round manifold vertices.

use crate::index::{Face, HalfEdge};
use crate::scheme::Scheme;
use crate::sharpness::{decay, edge_half};
use crate::tags::Creasing;
use crate::topology::{Interpolation, Lowest, Topology, lowered};

/// First number of a fan's key; the keys of walks begin otherwise.
const FAN: u32 = u32::MAX - 16;

/// The fan at the first corner of a quad with new vertices at the others.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct CornerFan {
    pub shape: FanShape,
    /// Sharpness of the vertex.
    pub vertex: f64,
    /// Spokes that are sharp, and their sharpness.
    pub spokes: Vec<(u32, f64)>,
}

/// A fan without its sharpness.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct FanShape {
    pub is_closed: bool,
    /// Number of faces.
    pub faces: u32,
    /// Which of them is the quad, counted from the clockwise-most; 0 in closed fans.
    pub own: u32,
}

/// True if the children of the quad whose corners are at the origins of `own` are known by their fans.
pub(super) fn has_fans(t: &Topology, own: &[HalfEdge], scheme: Scheme) -> bool {
    may_have_fans(t, scheme)
        && own.len() == 4
        && own.iter().all(|&h| {
            let v = t.origin(h);
            // A face that is its own neighbour all the way round has no fan to speak of.
            let is_alone = t.turn_left(h) == Some(h);
            !t.is_non_manifold_vertex(v) && t.foreign_sharpness(v).is_empty() && !is_alone
        })
}

/// True if quads of `t` are known by fans at all.
pub(in crate::limit) fn may_have_fans(t: &Topology, scheme: Scheme) -> bool {
    let is_uniform = t.rules().creasing == Creasing::Uniform;
    scheme == Scheme::CatmullClark && t.interpolation == Interpolation::Smooth && is_uniform
}

impl CornerFan {
    /// Reads the fan at the origin of `h`, as it is one level down, and lists the ring of the child there, in the numbers of
    /// that level's vertices.
    pub fn below(&mut self, t: &Topology, h: HalfEdge, mut ring: Option<&mut Vec<u32>>) {
        let v = t.origin(h);
        let face_point = |f: Face| t.vertex_count() as u32 + f.0;
        let edge_point = |h: HalfEdge| (t.vertex_count() + t.face_count()) as u32 + t.edge(h).0;
        let mut list = |number: u32| {
            if let Some(ring) = ring.as_deref_mut() {
                ring.push(number);
            }
        };
        self.spokes.clear();
        self.vertex = decay(t.vertex_sharpness(v));
        // Clockwise to the first spoke, or once round.
        let (mut first, mut own) = (h, 0);
        let is_closed = loop {
            match t.turn_right(first) {
                None => break false,
                Some(back) if back == h => break true,
                Some(back) => (first, own) = (back, own + 1),
            }
        };
        if is_closed {
            (first, own) = (h, 0);
        }
        list(v.0);
        let mut faces = 0;
        let mut spoke = |number: u32, h: HalfEdge| {
            let s = edge_half(t, t.edge(h), v);
            if s > 0.0 {
                self.spokes.push((number, s));
            }
        };
        let mut at = first;
        loop {
            spoke(faces, at);
            list(edge_point(at));
            list(face_point(t.face(at)));
            faces += 1;
            match t.turn_left(at) {
                Some(next) if next == first => break,
                Some(next) => at = next,
                None => {
                    let last = t.prev(at);
                    spoke(faces, last);
                    list(edge_point(last));
                    break;
                }
            }
        }
        self.shape = FanShape { is_closed, faces, own };
        let (right, left) = (t.next(h), t.prev(h));
        let far = t.next(right);
        if let Some(across) = t.twin(h) {
            list(edge_point(t.prev(across)));
        }
        [t.origin(right).0, edge_point(right), t.origin(far).0, edge_point(far), t.origin(left).0]
            .into_iter()
            .for_each(&mut list);
        if let Some(across) = t.twin(left) {
            list(edge_point(t.next(across)));
        }
    }

    /// The lowest finite sharpness.
    pub fn lowest(&self) -> Lowest {
        Lowest::among(self.spokes.iter().map(|spoke| spoke.1).chain([self.vertex]))
    }

    /// The same fan with other values.
    pub fn with_values(&self, from: &[f64], to: &[f64]) -> Self {
        let change = |s: f64| from.iter().position(|&value| value == s).map_or(s, |at| to[at]);
        let spokes = self.spokes.iter().map(|&(spoke, s)| (spoke, change(s))).collect();
        Self { shape: self.shape, vertex: change(self.vertex), spokes }
    }

    /// The key, finite sharpness lowered by `raise`.
    pub fn key(&self, raise: i8, key: &mut Vec<u32>) {
        let FanShape { is_closed, faces, own } = self.shape;
        let number = |s: f64, key: &mut Vec<u32>| {
            let bits = lowered(s, raise).to_bits();
            key.extend([(bits >> 32) as u32, bits as u32]);
        };
        key.clear();
        key.extend([FAN, u32::from(is_closed), faces, own]);
        number(self.vertex, key);
        for &(spoke, s) in &self.spokes {
            key.push(spoke);
            number(s, key);
        }
    }

    /// Where sharpness stands in the key: that of the vertex, then of the spokes.
    pub fn places(spokes: usize) -> impl Iterator<Item = usize> {
        std::iter::once(4).chain((0..spokes).map(|j| 7 + 3 * j))
    }

    /// Where sharpness stands in this key of a fan.
    pub fn places_in(key: &[u32]) -> impl Iterator<Item = usize> {
        Self::places((key.len() - 6) / 3)
    }

    /// The fan of a key, if it is one of a fan.
    pub fn of_key(key: &[u32]) -> Option<Self> {
        let (&[FAN, is_closed, faces, own, high, low], spokes) = key.split_first_chunk()? else { return None };
        let number = |high: u32, low: u32| f64::from_bits(u64::from(high) << 32 | u64::from(low));
        let (spokes, _) = spokes.as_chunks();
        Some(Self {
            shape: FanShape { is_closed: is_closed == 1, faces, own },
            vertex: number(high, low),
            spokes: spokes.iter().map(|&[spoke, high, low]| (spoke, number(high, low))).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fan_is_known_from_its_key_and_lowering_changes_what_is_finite() {
        let shape = FanShape { is_closed: false, faces: 3, own: 1 };
        let fan = CornerFan { shape, vertex: 2.25, spokes: vec![(0, 10.0), (2, 4.5), (3, 10.0)] };
        let of_key = |raise: i8| {
            let mut key = Vec::new();
            fan.key(raise, &mut key);
            CornerFan::of_key(&key).unwrap()
        };
        assert_eq!(of_key(0), fan);
        let lower = CornerFan { shape, vertex: 1.25, spokes: vec![(0, 10.0), (2, 3.5), (3, 10.0)] };
        assert_eq!(of_key(1), lower);
        assert_eq!((fan.lowest().excess(), lower.lowest().excess()), (2, 1));
        assert_eq!(CornerFan::of_key(&[u32::MAX - 3, 4, 0, 1, 2, 3]), None);
    }
}
