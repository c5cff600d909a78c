//! Half-edges with what every step asks of them at hand: their edge, and whether they run along it or against it.

use super::super::split::runs_forward;
use crate::index::{Edge, HalfEdge};
use crate::topology::Topology;
use rayon::prelude::*;

/// Half-edges that a thread takes at least.
const SHARE: usize = 1 << 13;

/// By half-edge, twice its edge, and one more where it runs against it. An edge count that can be refined can be doubled.
pub(super) struct Sides(Vec<u32>);

impl Sides {
    pub fn new(t: &Topology) -> Self {
        let side = |h: u32| {
            let h = HalfEdge(h);
            2 * t.edge(h).0 + u32::from(!runs_forward(t, h))
        };
        Self((0..t.half_edge_count() as u32).into_par_iter().with_min_len(SHARE).map(side).collect())
    }

    /// The edge of a half-edge, and whether this runs against it.
    #[inline(always)]
    pub fn get(&self, h: HalfEdge) -> (Edge, bool) {
        let side = self.0[h.index()];
        (Edge(side / 2), side % 2 == 1)
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.0[..])
    }
}

/// Steps between half-edges; `QUADS` where all faces are quads, so that they are computed.
#[derive(Clone, Copy)]
pub(super) struct Walk<'a, const QUADS: bool> {
    pub t: &'a Topology,
    pub sides: &'a Sides,
}

impl<const QUADS: bool> Walk<'_, QUADS> {
    #[inline(always)]
    pub fn next(&self, h: HalfEdge) -> HalfEdge {
        if QUADS { HalfEdge(h.0 & !3 | (h.0 + 1) & 3) } else { self.t.next(h) }
    }

    #[inline(always)]
    pub fn prev(&self, h: HalfEdge) -> HalfEdge {
        if QUADS { HalfEdge(h.0 & !3 | h.0.wrapping_sub(1) & 3) } else { self.t.prev(h) }
    }

    /// The face of a half-edge, and at which corner of a quad that starts.
    #[inline(always)]
    pub fn corner(&self, h: HalfEdge) -> (u32, Option<usize>) {
        if QUADS {
            return (h.0 / 4, Some(h.index() % 4));
        }
        let f = self.t.face(h);
        (f.0, (self.t.sides(f) == 4).then(|| (h.0 - self.t.first(f)) as usize))
    }

    /// The other side of a half-edge; itself where there is none.
    #[inline(always)]
    pub fn across(&self, h: HalfEdge) -> HalfEdge {
        self.t.twin(h).unwrap_or(h)
    }
}
