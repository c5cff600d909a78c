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
        let mut out = subsurf_memory::with_capacity(t.half_edge_count());
        let half_edges = (0..t.half_edge_count() as u32).into_par_iter().with_min_len(SHARE);
        half_edges.map(side).collect_into_vec(&mut out);
        Self(out)
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

/// What lies round a half-edge.
pub(super) struct Beside {
    pub next: HalfEdge,
    pub prev: HalfEdge,
    pub face: u32,
    /// At which corner of a quad it starts; none in other faces.
    pub corner: Option<usize>,
}

impl<const QUADS: bool> Walk<'_, QUADS> {
    #[inline(always)]
    pub fn beside(&self, h: HalfEdge) -> Beside {
        if QUADS {
            let (first, corner) = (h.0 & !3, h.0 & 3);
            let at = |corner: u32| HalfEdge(first | corner & 3);
            return Beside {
                next: at(corner + 1),
                prev: at(corner.wrapping_sub(1)),
                face: h.0 / 4,
                corner: Some(corner as usize),
            };
        }
        let face = self.t.face(h).0;
        let (first, end) = (self.t.face_offset[face as usize], self.t.face_offset[face as usize + 1]);
        Beside {
            next: HalfEdge(if h.0 + 1 == end { first } else { h.0 + 1 }),
            prev: HalfEdge(if h.0 == first { end - 1 } else { h.0 - 1 }),
            face,
            corner: (end - first == 4).then_some((h.0 - first) as usize),
        }
    }

    /// The other side of a half-edge; itself where there is none.
    #[inline(always)]
    pub fn across(&self, h: HalfEdge) -> HalfEdge {
        self.t.twin(h).unwrap_or(h)
    }
}
