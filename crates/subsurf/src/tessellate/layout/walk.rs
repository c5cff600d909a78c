//! The walk over all faces that decides which of them evaluates each vertex and edge: the first that comes to it.

use super::{CHUNK, PatchRates};
use crate::index::{Edge, Face, HalfEdge};
use crate::limit::PatchTable;
use crate::scheme::SplitKind;
use crate::tessellate::grid::{self, Parts};
use crate::tessellate::patch_grid::inner_points;
use crate::topology::NONE;
use subsurf_memory::{with_capacity, zeroed};

/// What a walk over all faces finds.
pub(super) struct Walked {
    /// By vertex, the corner that comes to it first, and how many vertices come before.
    pub vertex_owner: Vec<u32>,
    pub vertex_slot: Vec<u32>,
    pub owned: Vec<Parts>,
    pub face_first: Vec<u32>,
    pub chunk_starts: Vec<[u32; 2]>,
    pub counts: [u64; 3],
}

/// Tells which half-edge comes to an edge first.
pub(super) trait FirstEdges {
    /// True where nobody came before, who has left `points` points behind; none where this cannot be said.
    fn is_first(&mut self, e: Edge, h: HalfEdge, points: u32) -> Option<bool>;

    /// True where all that was said holds.
    fn is_complete(&self) -> bool;
}

/// Edges that are numbered as faces come to them.
pub(super) struct InOrder<'a> {
    next: u32,
    table: &'a PatchTable,
}

impl<'a> InOrder<'a> {
    pub fn new(table: &'a PatchTable) -> Self {
        Self { next: 0, table }
    }
}

impl FirstEdges for InOrder<'_> {
    #[inline(always)]
    fn is_first(&mut self, e: Edge, h: HalfEdge, _: u32) -> Option<bool> {
        if e.0 < self.next {
            return Some(false);
        }
        let fits = e.0 == self.next && self.table.topology().edge_half_edge[e.index()] == h.0;
        self.next += 1;
        fits.then_some(true)
    }

    fn is_complete(&self) -> bool {
        self.next as usize == self.table.topology().edge_count()
    }
}

/// Edges in any order.
pub(super) struct AnyOrder {
    pub owner: Vec<u32>,
    pub first: Vec<u32>,
}

impl AnyOrder {
    pub fn new(edges: usize) -> Self {
        Self { owner: vec![NONE; edges], first: vec![0; edges] }
    }
}

impl FirstEdges for AnyOrder {
    #[inline(always)]
    fn is_first(&mut self, e: Edge, h: HalfEdge, points: u32) -> Option<bool> {
        let is_first = self.owner[e.index()] == NONE;
        if is_first {
            (self.owner[e.index()], self.first[e.index()]) = (h.0, points);
        }
        Some(is_first)
    }

    fn is_complete(&self) -> bool {
        true
    }
}

/// Goes over all faces in order, and notes what each comes to first; none where `edges` cannot say.
pub(super) fn walk(table: &PatchTable, rates: &PatchRates, edges: &mut impl FirstEdges) -> Option<Walked> {
    let t = table.topology();
    let is_triangle = table.scheme().split() == SplitKind::Triangles;
    let [mut vertex_owner, mut vertex_slot] = [0; 2].map(|_| with_capacity(t.vertex_count()));
    vertex_owner.resize(t.vertex_count(), NONE);
    vertex_slot.resize(t.vertex_count(), NONE);
    let mut owned = zeroed(table.patch_count());
    let mut face_first = with_capacity(t.face_count() + 1);
    let mut chunk_starts = Vec::with_capacity(t.face_count() / CHUNK as usize + 2);
    // Counts that do not fit 32 bits are refused by `check`.
    let mut counts = [0u64; 3];
    for f in (0..t.face_count() as u32).map(Face) {
        if f.0 % CHUNK == 0 {
            chunk_starts.push([counts[0], counts[1]].map(|count| count as u32));
        }
        face_first.push(counts[2] as u32);
        if t.is_hole(f) {
            continue;
        }
        let (first, sides) = (t.first(f), t.sides(f) as u32);
        let (patch, subfaces) = (table.patch(f, 0), table.subfaces(f));
        for side in 0..sides {
            let h = HalfEdge(first + side);
            let v = t.origin(h).index();
            if vertex_owner[v] == NONE {
                (vertex_owner[v], vertex_slot[v]) = (h.0, counts[0] as u32);
                counts[0] += 1;
                if subfaces == 1 {
                    owned[patch] |= grid::corner(side as u8);
                } else {
                    owned[patch + side as usize] |= grid::corner(0);
                }
            }
            let e = t.edge(h);
            if !edges.is_first(e, h, counts[1] as u32)? {
                continue;
            }
            counts[1] += u64::from(rates.edge(e)) - 1;
            if subfaces == 1 {
                owned[patch] |= grid::side(side as u8);
            } else {
                owned[patch + side as usize] |= grid::side(0);
                owned[patch + ((side + 1) % sides) as usize] |= grid::side(3);
            }
        }
        let cells = rates.patch(patch, subfaces).map(u64::from);
        let (nu, inner) = (cells[0], inner_points(is_triangle, cells));
        let n = u64::from(subfaces);
        // Sub-faces share the centre and the points inside their spokes.
        let inside = if n == 1 { inner } else { n.saturating_mul(nu - 1 + inner).saturating_add(1) };
        counts[2] = counts[2].saturating_add(inside);
    }
    face_first.push(counts[2] as u32);
    chunk_starts.push([counts[0], counts[1]].map(|count| count as u32));
    edges.is_complete().then_some(Walked { vertex_owner, vertex_slot, owned, face_first, chunk_starts, counts })
}
