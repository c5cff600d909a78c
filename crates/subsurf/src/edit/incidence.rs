//! All faces at a vertex, those of other fans included: lists through the half-edges, changed in time linear in the valence.

use crate::index::{HalfEdge, Vertex};
use crate::topology::{NONE, Topology};

pub(super) struct Incidence {
    /// One outgoing half-edge of every vertex.
    first: Vec<u32>,
    /// The next one with the same origin.
    next: Vec<u32>,
}

impl Incidence {
    pub fn new(t: &Topology) -> Self {
        let mut all = Self { first: vec![NONE; t.vertex_count()], next: vec![NONE; t.half_edge_count()] };
        (0..t.half_edge_count() as u32).rev().map(HalfEdge).for_each(|h| all.link(h, t.origin(h)));
        all
    }

    pub fn push_vertex(&mut self) {
        self.first.push(NONE);
    }

    pub fn link(&mut self, h: HalfEdge, v: Vertex) {
        if h.index() >= self.next.len() {
            self.next.resize(h.index() + 1, NONE);
        }
        self.next[h.index()] = std::mem::replace(&mut self.first[v.index()], h.0);
    }

    pub fn unlink(&mut self, h: HalfEdge, v: Vertex) {
        let after = std::mem::replace(&mut self.next[h.index()], NONE);
        if self.first[v.index()] == h.0 {
            self.first[v.index()] = after;
            return;
        }
        let mut at = self.first[v.index()];
        while at != NONE {
            if self.next[at as usize] == h.0 {
                self.next[at as usize] = after;
                return;
            }
            at = self.next[at as usize];
        }
    }

    /// The outgoing half-edges of `v`, in no order.
    pub fn at(&self, v: Vertex) -> impl Iterator<Item = HalfEdge> + '_ {
        let mut at = self.first[v.index()];
        std::iter::from_fn(move || {
            let h = at;
            (h != NONE).then(|| {
                at = self.next[h as usize];
                HalfEdge(h)
            })
        })
    }
}
