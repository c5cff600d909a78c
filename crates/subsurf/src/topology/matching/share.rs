//! The edges of some of the faces, met in order.

use super::super::build::filled;
use super::super::{FaceOf, NONE};
use super::FaceList;
use crate::limit::KeyHasher;
use std::collections::{BTreeMap, HashMap};
use std::hash::BuildHasherDefault;
use std::ops::Range;

/// Faces, and what is noted of their half-edges.
pub(super) struct Own<'a> {
    pub faces: Range<usize>,
    /// Their first half-edge.
    pub first: u32,
    /// The other half-edge of its edge.
    pub twin: &'a mut [u32],
    /// Its edge, by its number within the share.
    pub edge: &'a mut [u32],
}

impl<'a> Own<'a> {
    /// For each of the parts that make up the list.
    pub fn of_parts(
        list: FaceList<'_>,
        parts: Vec<Range<usize>>,
        mut twin: &'a mut [u32],
        mut edge: &'a mut [u32],
    ) -> Vec<Self> {
        let of_part = |faces: Range<usize>| {
            let own = list.half_edges(&faces);
            Self {
                faces,
                first: own.start as u32,
                twin: twin.split_off_mut(..own.len()).unwrap_or_default(),
                edge: edge.split_off_mut(..own.len()).unwrap_or_default(),
            }
        };
        parts.into_iter().map(of_part).collect()
    }

    #[inline(always)]
    pub fn twin(&self, h: u32) -> u32 {
        self.twin[(h - self.first) as usize]
    }

    #[inline(always)]
    pub fn set_twin(&mut self, h: u32, twin: u32) {
        self.twin[(h - self.first) as usize] = twin;
    }

    #[inline(always)]
    fn set_edge(&mut self, h: u32, edge: u32) {
        self.edge[(h - self.first) as usize] = edge;
    }
}

/// The edges of some faces, numbered as they are met.
pub(super) struct Share {
    /// From the least to the largest that the faces name, at least.
    pub vertices: Range<u32>,
    /// By vertex, its first outgoing half-edge.
    pub outgoing: Vec<u32>,
    /// By vertex, the first edge of its chain: the edges that are filed under it.
    pub head: Vec<u32>,
    /// By edge, the next one of its chain.
    next: Vec<u32>,
    /// By edge, from where to where its leader runs.
    pub ends: Vec<[u32; 2]>,
    pub leader: Vec<u32>,
    /// Edges at vertices whose chains are full.
    crowded: HashMap<(u32, u32), u32, BuildHasherDefault<KeyHasher>>,
    /// Non-manifold edges but those with equal ends.
    unusual: BTreeMap<u32, Unusual>,
    /// Leaders of non-manifold edges, and whether the edge has one face only.
    pub non_manifold: Vec<(u32, bool)>,
}

struct Unusual {
    faces: u32,
    last_face: u32,
}

/// Longest chain. Longer ones make poles slow, shorter ones call for the map at ordinary vertices.
const LONGEST: usize = 24;

/// A half-edge, its ends, and the first half-edge of its face.
#[derive(Clone, Copy)]
struct Side {
    h: u32,
    a: u32,
    b: u32,
    first: u32,
}

/// The end of an edge that it is filed under, then the other. Either end has its turn, so that neither order of numbers nor
/// large valence makes most chains long.
#[inline(always)]
fn filed(a: u32, b: u32) -> (u32, u32) {
    if (a ^ b) & 1 == u32::from(a < b) { (b, a) } else { (a, b) }
}

impl Share {
    /// Files the edges of the faces of `own`, which name no other vertices than `vertices`.
    pub fn new(list: FaceList<'_>, vertices: Range<u32>, own: &mut Own<'_>) -> Self {
        // Half of all half-edges, where there are few boundaries; more room is made when it is needed. The first share holds all
        // edges in the end; memory that is not touched costs nothing.
        let room = |half_edges: usize| (0.52 * half_edges as f64) as usize;
        let all = if own.first == 0 { room(list.origin.len()) } else { room(own.twin.len()) };
        let mut share = Self {
            outgoing: filled(vertices.len(), NONE),
            head: filled(vertices.len(), NONE),
            next: subsurf_memory::with_capacity(room(own.twin.len())),
            ends: subsurf_memory::with_capacity(all),
            leader: subsurf_memory::with_capacity(all),
            crowded: HashMap::default(),
            unusual: BTreeMap::new(),
            non_manifold: Vec::new(),
            vertices,
        };
        list.each(own.faces.clone(), |first, corners| {
            let mut a = corners[0];
            for i in 0..corners.len() {
                let b = if i + 1 == corners.len() { corners[0] } else { corners[i + 1] };
                share.visit(list.face, Side { h: first + i as u32, a, b, first }, own);
                a = b;
            }
        });
        for (&edge, state) in &share.unusual {
            share.non_manifold.push((share.leader[edge as usize], state.faces < 2));
        }
        share
    }

    /// Takes in a half-edge.
    #[inline(always)]
    fn visit(&mut self, faces: &FaceOf, side: Side, own: &mut Own<'_>) {
        let Side { h, a, b, .. } = side;
        let start = self.vertices.start;
        let outgoing = &mut self.outgoing[(a - start) as usize];
        *outgoing = h.min(*outgoing);
        let (at, other) = filed(a, b);
        let head = self.head[(at - start) as usize];
        if a == b {
            // Both ends equal: an edge of its own, whatever else there is.
            return self.add_own(side, own);
        }
        let (mut edge, mut length) = (head, 0);
        while edge != NONE {
            let [c, d] = self.ends[edge as usize];
            if c ^ d == a ^ b {
                return self.meet(faces, side, edge, own);
            }
            edge = self.next[edge as usize];
            length += 1;
        }
        if length >= LONGEST {
            return self.visit_crowded(faces, side, (at, other), own);
        }
        self.head[(at - start) as usize] = self.next.len() as u32;
        self.push(side, head, own);
    }

    /// Adds an edge.
    #[inline(always)]
    fn push(&mut self, Side { h, a, b, .. }: Side, next: u32, own: &mut Own<'_>) {
        own.set_twin(h, NONE);
        own.set_edge(h, self.next.len() as u32);
        self.next.push(next);
        self.ends.push([a, b]);
        self.leader.push(h);
    }

    /// The same where the chain is full.
    #[cold]
    fn visit_crowded(&mut self, faces: &FaceOf, side: Side, ends: (u32, u32), own: &mut Own<'_>) {
        match self.crowded.get(&ends) {
            Some(&edge) => self.meet(faces, side, edge, own),
            None => {
                self.crowded.insert(ends, self.next.len() as u32);
                self.push(side, NONE, own);
            }
        }
    }

    /// Takes in a further half-edge of an edge.
    #[inline(always)]
    fn meet(&mut self, faces: &FaceOf, side: Side, edge: u32, own: &mut Own<'_>) {
        let leader = self.leader[edge as usize];
        let is_other_side = self.ends[edge as usize][0] != side.a && leader < side.first;
        let is_single = own.twin(leader) == NONE;
        if is_other_side && is_single && !self.is_unusual(edge) {
            own.set_twin(leader, side.h);
            own.set_twin(side.h, leader);
            own.set_edge(side.h, edge);
        } else {
            self.meet_unusual(faces, side, edge, own);
        }
    }

    /// A half-edge that makes the edge non-manifold, or it was so before: it has two faces already, or `side` runs the same way, or
    /// its last face is that of `side`, which then has an edge of its own there.
    #[cold]
    fn meet_unusual(&mut self, faces: &FaceOf, side: Side, edge: u32, own: &mut Own<'_>) {
        let leader = self.leader[edge as usize];
        let state = self.unusual.entry(edge).or_insert_with(|| {
            let second = own.twin(leader);
            if second == NONE {
                return Unusual { faces: 1, last_face: faces.get(leader) };
            }
            own.set_twin(leader, NONE);
            own.set_twin(second, NONE);
            Unusual { faces: 2, last_face: faces.get(second) }
        });
        let f = faces.get(side.h);
        if state.last_face == f {
            self.add_own(side, own);
        } else {
            *state = Unusual { faces: state.faces + 1, last_face: f };
            own.set_twin(side.h, NONE);
            own.set_edge(side.h, edge);
        }
    }

    /// Adds a non-manifold edge that is this half-edge's own.
    #[cold]
    fn add_own(&mut self, side: Side, own: &mut Own<'_>) {
        self.push(side, NONE, own);
        self.non_manifold.push((side.h, true));
    }

    #[inline(always)]
    fn is_unusual(&self, edge: u32) -> bool {
        !self.unusual.is_empty() && self.unusual.contains_key(&edge)
    }

    /// True of an edge of one face with an end of its own.
    pub fn is_single(&self, edge: u32, own: &Own<'_>) -> bool {
        own.twin(self.leader[edge as usize]) == NONE && !self.is_unusual(edge)
    }

    /// The first edge that is filed under a vertex, or [`NONE`].
    #[inline(always)]
    pub fn first_at(&self, v: u32) -> u32 {
        self.head.get(v.wrapping_sub(self.vertices.start) as usize).map_or(NONE, |&head| head)
    }

    /// The edges that are filed under a vertex, but for crowded ones.
    pub fn chain(&self, v: u32) -> impl Iterator<Item = u32> {
        let listed = |edge: u32| (edge != NONE).then_some(edge);
        std::iter::successors(listed(self.first_at(v)), move |&edge| listed(self.next[edge as usize]))
    }

    /// The edges at vertices whose chains are full.
    pub fn crowded(&self) -> impl Iterator<Item = u32> {
        self.crowded.values().copied()
    }

    /// The first edge between two vertices that differ, if there is one.
    pub fn find(&self, a: u32, b: u32) -> Option<u32> {
        let (at, other) = filed(a, b);
        let is_it = |&edge: &u32| {
            let [c, d] = self.ends[edge as usize];
            c ^ d == a ^ b
        };
        self.chain(at).find(is_it).or_else(|| self.crowded.get(&(at, other)).copied())
    }
}
