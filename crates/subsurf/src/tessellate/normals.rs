//! Which facet corners need a normal of their own: the further sides of infinitely sharp creases, and the faces at cone
//! points.

use super::layout::Layout;
use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::limit::PatchTable;
use crate::tags::INFINITE_SHARPNESS;
use std::collections::BTreeMap;

/// Normals beyond one per point: those at corners, then those along edges in the order of the faces that see them, so that a face
/// gives them when it is evaluated, and all of them are one run of the result.
#[derive(Default)]
pub(super) struct Sides {
    /// Face corners (named by their half-edge) whose normal is not that of the vertex's owner: index among the extra ones.
    corner: BTreeMap<u32, u32>,
    /// Half-edges along which normals are not those of the edge's owner: first index among the extra ones.
    edge: BTreeMap<u32, u32>,
    /// By face, whether any of its corners or half-edges is among these; empty where there are none.
    is_touched: Vec<bool>,
    /// What evaluates each extra normal.
    pub sources: Vec<Source>,
    /// Number of points, where extra normals start.
    points: u32,
}

/// Where an extra normal is evaluated.
#[derive(Clone, Copy)]
pub(super) enum Source {
    Corner(HalfEdge),
    Edge(HalfEdge, u32),
}

impl Sides {
    pub fn new(table: &PatchTable, layout: &Layout<'_>) -> Self {
        let t = table.topology();
        let mut sides = Self { points: layout.points() as u32, ..Self::default() };
        sides.fill(table, layout);
        if sides.extra() > 0 {
            sides.is_touched = vec![false; t.face_count()];
            for &h in sides.corner.keys().chain(sides.edge.keys()) {
                sides.is_touched[t.face(HalfEdge(h)).index()] = true;
            }
        }
        sides
    }

    fn fill(&mut self, table: &PatchTable, layout: &Layout<'_>) {
        let (t, sides) = (table.topology(), self);
        let in_hole = |h: HalfEdge| t.is_hole(t.face(h));
        let mut is_split = vec![false; t.vertex_count()];
        let sharp = t.edge_sharpness.sharp().flat_map(|e| t.edge_vertices[e]);
        for v in sharp.chain(t.vertex_sharpness.sharp().map(|v| v as u32)) {
            is_split[v as usize] = may_be_split(table, Vertex(v)) && layout.owner_of_vertex(Vertex(v)).is_some();
        }
        let mut leaders: BTreeMap<u32, u32> = BTreeMap::new();
        let all = if is_split.contains(&true) { t.half_edge_count() as u32 } else { 0 };
        for h in (0..all).map(HalfEdge).filter(|&h| is_split[t.origin(h).index()] && !in_hole(h)) {
            let owner = layout.owner_of_vertex(t.origin(h)).expect("its own faces are outside holes");
            let leader = sector_leader(table, h);
            if leader == sector_leader(table, owner) {
                continue;
            }
            let index = *leaders.entry(leader.0).or_insert_with(|| {
                sides.sources.push(Source::Corner(h));
                sides.sources.len() as u32 - 1
            });
            sides.corner.insert(h.0, index);
        }
        let is_inner = |e: &usize| t.is_infinitely_sharp(Edge(*e as u32)) && !t.is_boundary(Edge(*e as u32));
        if t.edge_sharpness.sharp().find(is_inner).is_none() {
            return;
        }
        let sharp = layout.edges().filter(|&(e, _)| t.is_infinitely_sharp(e));
        let others = |(e, owner)| half_edges_of(table, e).into_iter().filter(move |&h| h != owner && !in_hole(h));
        let mut further: Vec<HalfEdge> = sharp.flat_map(others).collect();
        further.sort_unstable();
        for h in further {
            sides.edge.insert(h.0, sides.sources.len() as u32);
            sides.sources.extend((1..layout.rates.edge(t.edge(h))).map(|k| Source::Edge(h, k)));
        }
    }

    /// True where all corners of a face have the normals of their points.
    pub fn is_plain(&self, face: Face) -> bool {
        self.is_touched.get(face.index()).is_none_or(|touched| !touched)
    }

    pub fn extra(&self) -> usize {
        self.sources.len()
    }

    /// The face corners that extra normals are evaluated at; those come first.
    pub fn corners(&self) -> impl Iterator<Item = HalfEdge> + '_ {
        self.sources.iter().map_while(|source| match *source {
            Source::Corner(h) => Some(h),
            Source::Edge(..) => None,
        })
    }

    /// The half-edges that extra normals are evaluated along, in their order.
    pub fn edges(&self) -> impl Iterator<Item = HalfEdge> + '_ {
        self.sources.iter().filter_map(|source| match *source {
            Source::Edge(h, 1) => Some(h),
            _ => None,
        })
    }

    /// The normal of point `k` along half-edge `h`, ends included.
    pub fn at(&self, layout: &Layout<'_>, h: HalfEdge, k: u32, point: u32) -> u32 {
        let t = layout.table.topology();
        match k {
            0 => self.corner(h, point),
            k if k == layout.rates.edge(t.edge(h)) => self.corner(t.next(h), point),
            k => self.along(h, k, point),
        }
    }

    /// The normal of the corner at the start of `h`, whose point is `point`.
    pub fn corner(&self, h: HalfEdge, point: u32) -> u32 {
        self.corner.get(&h.0).map_or(point, |i| self.points + i)
    }

    /// The normal of point `k` along half-edge `h`, whose point is `point`.
    pub fn along(&self, h: HalfEdge, k: u32, point: u32) -> u32 {
        self.edge.get(&h.0).map_or(point, |first| self.points + first + k - 1)
    }
}

/// False where all faces at a vertex surely are of one sector.
fn may_be_split(table: &PatchTable, v: Vertex) -> bool {
    let t = table.topology();
    let sharp = || t.sharp_edges(v).iter().map(|&e| Edge(e)).filter(|&e| t.is_infinitely_sharp(e));
    match sharp().count() {
        // A boundary passes the vertex.
        2 if !t.is_non_manifold_vertex(v) && sharp().all(|e| t.is_boundary(e)) => false,
        count => count >= 2 || t.vertex_sharpness(v) >= INFINITE_SHARPNESS,
    }
}

/// The half-edge that stands for the sector at the start of `h`: at cone points every corner is its own.
fn sector_leader(table: &PatchTable, h: HalfEdge) -> HalfEdge {
    let t = table.topology();
    let sharp = |h: HalfEdge| t.is_infinitely_sharp(t.edge(h));
    let mut first = h;
    while !sharp(first) {
        match t.turn_right(first) {
            Some(next) if next != h => first = next,
            // All the way round without a sharp edge: a cone point.
            _ => return h,
        }
    }
    // A single sharp edge at a pinned vertex: the sector wraps round it, with no tangent plane.
    let mut last = first;
    while !sharp(t.prev(last)) {
        match t.turn_left(last) {
            Some(next) => last = next,
            None => break,
        }
    }
    if t.edge(t.prev(last)) == t.edge(first) { h } else { first }
}

/// All sides of an edge.
fn half_edges_of(table: &PatchTable, e: Edge) -> Vec<HalfEdge> {
    let t = table.topology();
    let first = HalfEdge(t.edge_half_edge[e.index()]);
    match t.twin(first) {
        Some(twin) => vec![first, twin],
        None if t.is_boundary(e) => vec![first],
        // Non-manifold: rare enough to search.
        None => (0..t.half_edge_count() as u32).map(HalfEdge).filter(|&h| t.edge(h) == e).collect(),
    }
}
