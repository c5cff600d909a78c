//! Half-edge tables with effective sharpness: what refinement and limit evaluation read.
//!
//! Half-edge `h = offset(f) + i` runs from corner `i` of face `f` to corner `i + 1`; the face lies on its left.
//!
//! ```text
//!            prev(h) ↖   face
//!   origin(h) ────── h ──────▶ origin(next(h))
//!             ◀── twin(h) ───   other face
//! ```
//!
//! Edges are numbered in the order in which the faces first name them, as OpenSubdiv does. An edge that is not shared
//! by exactly two faces in opposite directions has no twins and is infinitely sharp; each of its faces then sees a
//! boundary. Sharpness here is *effective*: clamped to `[0, 10]`, boundary and non-manifold rules applied.

mod build;
mod channel;
mod check;
mod cut_out;
mod cutter;
mod edges;
mod face_of;
mod fan_size;
mod matching;
mod raise;
mod sharpness_column;
mod splice;
mod tables;

pub(crate) use channel::{ChannelTopology, Interpolation};
pub(crate) use cut_out::{Around, Surroundings, Walk};
pub(crate) use cutter::Cutter;
pub(crate) use face_of::FaceOf;
pub(crate) use fan_size::FanSize;
pub(crate) use raise::{Lowest, lowered};
pub(crate) use sharpness_column::SharpnessColumn;
pub(crate) use splice::{Edits, Piece};
pub(crate) use tables::Tables;

use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::mesh::{ControlMesh, MeshError};
use crate::tags::{INFINITE_SHARPNESS, Rules};
use std::collections::BTreeMap;
use std::ops::Range;

/// Absent half-edge in the packed tables; never leaves this module and its children.
pub(crate) const NONE: u32 = u32::MAX;

/// What is unusual about an edge.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(crate) struct EdgeFlags {
    /// Fewer than two faces.
    pub boundary: bool,
    /// More than two faces, two in the same direction, twice in one face, or both ends equal.
    pub non_manifold: bool,
}

/// The connectivity of one level: the control mesh itself or one of its refinements.
#[derive(Clone, Debug)]
pub struct Topology {
    pub(crate) vertex_count: usize,
    pub(crate) face_offset: Vec<u32>,
    /// Per half-edge: origin, face, edge, twin.
    pub(crate) origin: Vec<u32>,
    pub(crate) face: FaceOf,
    pub(crate) edge: Vec<u32>,
    pub(crate) twin: Vec<u32>,
    pub(crate) edge_vertices: Vec<[u32; 2]>,
    /// One half-edge of every edge.
    pub(crate) edge_half_edge: Vec<u32>,
    pub(crate) edge_flags: Vec<EdgeFlags>,
    pub(crate) edge_sharpness: SharpnessColumn,
    /// One outgoing half-edge per vertex; the one that leads the fan where the fan is open.
    pub(crate) vertex_half_edge: Vec<u32>,
    pub(crate) vertex_non_manifold: Vec<bool>,
    pub(crate) vertex_sharpness: SharpnessColumn,
    /// Sharp edges (sharpness > 0) at every vertex: `sharp_edges[sharp_offset[v]..sharp_offset[v + 1]]`, ascending.
    pub(crate) sharp_offset: Vec<u32>,
    pub(crate) sharp_edges: Vec<u32>,
    pub(crate) hole: Vec<bool>,
    pub(crate) rules: Rules,
    /// Sharpness of edges at a vertex that are not part of its fan, yet count as its sharp edges: where a table holds a
    /// cut-out of a mesh and the vertex lies on a non-manifold crease, and where one face-varying value depends on
    /// another.
    pub(crate) foreign_sharpness: BTreeMap<u32, Vec<f64>>,
    /// Semi-sharp edges that matter to Chaikin's averages at a vertex and to nothing else: those on the other side of a
    /// seam of a face-varying channel.
    pub(crate) across_seam: BTreeMap<u32, Vec<f64>>,
    /// How values over this table are interpolated.
    pub(crate) interpolation: Interpolation,
    /// By edge and end: sharpness of the edge's half there, one level down. Only where a table holds a cut-out of a mesh,
    /// creasing is Chaikin's, and other edges at that end, which this table does not hold, have a say.
    pub(crate) far_half: BTreeMap<(u32, u32), f64>,
    /// What edits left behind.
    pub(crate) edits: Edits,
    /// By vertex, as the tables were built; empty where it was not found then, or somebody took it.
    pub(crate) fan_sizes: Vec<FanSize>,
}

impl Topology {
    /// Builds the tables in time linear in the mesh, in parallel; the result does not depend on the number of threads.
    ///
    /// # Errors
    /// [`MeshError::CreaseNotOnEdge`] where a crease names two vertices that no edge joins, and
    /// [`MeshError::TooLarge`] where edges overflow 32-bit indices.
    pub fn new(mesh: &ControlMesh) -> Result<Self, MeshError> {
        // One entry into the thread pool for all that follows.
        rayon::scope(|_| build::from_mesh(mesh))
    }

    /// Number of vertices, isolated ones included.
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// Number of edges.
    pub fn edge_count(&self) -> usize {
        self.edge_vertices.len()
    }

    /// Number of faces, holes included.
    pub fn face_count(&self) -> usize {
        self.face_offset.len() - 1
    }

    /// Number of half-edges, which is that of face corners.
    pub fn half_edge_count(&self) -> usize {
        self.origin.len()
    }

    /// The rules that this topology was built with.
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    /// The vertices of a face, counter-clockwise.
    pub fn face_vertices(&self, face: Face) -> &[u32] {
        let first = self.first(face) as usize;
        &self.origin[first..first + self.sides(face)]
    }

    /// Start of every face in [`corners`](Self::corners), and the end of the last one.
    pub fn face_offsets(&self) -> &[u32] {
        &self.face_offset
    }

    /// The vertices of all face corners, face after face.
    pub fn corners(&self) -> &[u32] {
        &self.origin
    }

    /// Number of corners of a face.
    #[inline]
    pub fn sides(&self, face: Face) -> usize {
        match self.face {
            FaceOf::Quads => 4,
            FaceOf::Triangles => 3,
            FaceOf::Listed(_) => (self.face_offset[face.index() + 1] - self.face_offset[face.index()]) as usize,
        }
    }

    /// Number of corners of the face of a half-edge.
    #[inline]
    pub(crate) fn sides_at(&self, h: HalfEdge) -> usize {
        self.face.sides(h.0, &self.face_offset)
    }

    /// True for a face that shapes its neighbours but is not part of the surface.
    pub fn is_hole(&self, face: Face) -> bool {
        self.hole[face.index()]
    }

    /// The half-edge at corner `corner` of a face.
    #[inline]
    pub fn half_edge(&self, face: Face, corner: usize) -> HalfEdge {
        HalfEdge(self.first(face) + corner as u32)
    }

    #[inline]
    pub(crate) fn first(&self, face: Face) -> u32 {
        self.face.first(face.0, &self.face_offset)
    }

    /// The face on the left of a half-edge.
    #[inline]
    pub fn face(&self, h: HalfEdge) -> Face {
        Face(self.face.get(h.0))
    }

    /// Where a half-edge starts.
    #[inline]
    pub fn origin(&self, h: HalfEdge) -> Vertex {
        Vertex(self.origin[h.index()])
    }

    /// The edge that a half-edge is a side of.
    #[inline]
    pub fn edge(&self, h: HalfEdge) -> Edge {
        Edge(self.edge[h.index()])
    }

    /// The other side of a manifold edge; none at boundaries and non-manifold edges.
    #[inline]
    pub fn twin(&self, h: HalfEdge) -> Option<HalfEdge> {
        let t = self.twin[h.index()];
        (t != NONE).then_some(HalfEdge(t))
    }

    /// The following half-edge of the same face.
    #[inline]
    pub fn next(&self, h: HalfEdge) -> HalfEdge {
        HalfEdge(self.face.next(h.0, &self.face_offset))
    }

    /// The preceding half-edge of the same face.
    #[inline]
    pub fn prev(&self, h: HalfEdge) -> HalfEdge {
        HalfEdge(self.face.prev(h.0, &self.face_offset))
    }

    /// The next outgoing half-edge counter-clockwise round the origin of `h`; none where the fan ends.
    #[inline]
    pub fn turn_left(&self, h: HalfEdge) -> Option<HalfEdge> {
        self.twin(self.prev(h))
    }

    /// The next outgoing half-edge clockwise round the origin of `h`; none where the fan ends.
    #[inline]
    pub fn turn_right(&self, h: HalfEdge) -> Option<HalfEdge> {
        self.twin(h).map(|t| self.next(t))
    }

    /// Visits the outgoing half-edges of the fan that starts at the vertex's leading one, counter-clockwise; true where the
    /// fan is closed.
    #[inline]
    pub(crate) fn walk_fan(&self, v: Vertex, visit: impl FnMut(HalfEdge)) -> bool {
        match self.face {
            FaceOf::Quads => self.walk_fan_by(v, |h| h & !3 | h.wrapping_sub(1) & 3, visit),
            _ => self.walk_fan_by(v, |h| self.face.prev(h, &self.face_offset), visit),
        }
    }

    #[inline]
    fn walk_fan_by(&self, v: Vertex, prev: impl Fn(u32) -> u32, mut visit: impl FnMut(HalfEdge)) -> bool {
        let start = self.vertex_half_edge[v.index()];
        let mut at = start;
        while at != NONE {
            visit(HalfEdge(at));
            at = self.twin[prev(at) as usize];
            if at == start {
                return true;
            }
        }
        false
    }

    /// An outgoing half-edge of a vertex, the clockwise-most one where the fan is open; none for isolated vertices.
    pub fn outgoing(&self, v: Vertex) -> Option<HalfEdge> {
        let h = self.vertex_half_edge[v.index()];
        (h != NONE).then_some(HalfEdge(h))
    }

    /// The two ends of an edge: of a control mesh in the direction of its first face, of a refined level the new
    /// vertex first.
    pub fn edge_vertices(&self, e: Edge) -> [Vertex; 2] {
        self.edge_vertices[e.index()].map(Vertex)
    }

    /// Effective sharpness of an edge, in `[0, 10]`.
    #[inline]
    pub fn edge_sharpness(&self, e: Edge) -> f64 {
        self.edge_sharpness.get(e.index())
    }

    /// Effective sharpness of a vertex, in `[0, 10]`.
    #[inline]
    pub fn vertex_sharpness(&self, v: Vertex) -> f64 {
        self.vertex_sharpness.get(v.index())
    }

    /// True for an edge with fewer than two faces.
    pub fn is_boundary(&self, e: Edge) -> bool {
        self.edge_flags[e.index()].boundary
    }

    /// True for an edge with more than two faces, two faces in the same direction, twice in one face, or equal ends.
    pub fn is_non_manifold_edge(&self, e: Edge) -> bool {
        self.edge_flags[e.index()].non_manifold
    }

    /// True for a vertex whose faces do not form one fan, or that has a non-manifold edge or no face.
    pub fn is_non_manifold_vertex(&self, v: Vertex) -> bool {
        self.vertex_non_manifold[v.index()]
    }

    /// The sharp edges at a vertex, ascending.
    #[inline]
    pub(crate) fn sharp_edges(&self, v: Vertex) -> &[u32] {
        if let Some(list) = self.edits.sharp_edges(v.0) {
            return list;
        }
        &self.sharp_edges[self.sharp_offset[v.index()] as usize..self.sharp_offset[v.index() + 1] as usize]
    }

    /// True where these vertices are manifold and neither they nor edges at them are sharp; false also where a table was edited or cut
    /// out, so that each vertex must be looked at.
    pub(crate) fn nothing_is_sharp(&self, vertices: Range<usize>) -> bool {
        self.sharp_offset[vertices.start] == self.sharp_offset[vertices.end]
            && self.edits.is_empty()
            && self.foreign_sharpness.is_empty()
            && !self.vertex_sharpness.is_any_sharp(vertices.clone())
            && !self.vertex_non_manifold[vertices].contains(&true)
    }

    /// Sharpness of edges at `v` that this cut-out table does not hold.
    pub(crate) fn foreign_sharpness(&self, v: Vertex) -> &[f64] {
        if self.foreign_sharpness.is_empty() {
            return &[];
        }
        self.foreign_sharpness.get(&v.0).map_or(&[], Vec::as_slice)
    }

    /// Sharpness of edges beyond a seam at `v`, which Chaikin's averages take in.
    pub(crate) fn across_seam(&self, v: Vertex) -> &[f64] {
        if self.across_seam.is_empty() {
            return &[];
        }
        self.across_seam.get(&v.0).map_or(&[], Vec::as_slice)
    }

    /// Fills `sharp_offset` and `sharp_edges` from the edges' sharpness.
    pub(crate) fn index_sharp_edges(&mut self) {
        let Self { edge_vertices, edge_sharpness, sharp_offset: offset, sharp_edges: list, .. } = self;
        let edges = || edge_sharpness.sharp();
        // A degenerate edge (both ends equal) is listed once.
        let ends = |e: usize| {
            let [a, b] = edge_vertices[e];
            std::iter::once(a).chain((b != a).then_some(b))
        };
        // Counted two places further, so that filling moves every start to where it belongs.
        list.clear();
        if offset.capacity() == 0 {
            *offset = subsurf_memory::zeroed(self.vertex_count + 2);
        } else {
            offset.clear();
            offset.resize(self.vertex_count + 2, 0);
        }
        if edges().next().is_none() {
            // Zeros that are never touched take no memory.
            offset.pop();
            return;
        }
        edges().for_each(|e| ends(e).for_each(|v| offset[v as usize + 2] += 1));
        for v in 2..offset.len() {
            offset[v] += offset[v - 1];
        }
        list.resize(offset[self.vertex_count + 1] as usize, 0);
        for e in edges() {
            for v in ends(e) {
                let slot = &mut offset[v as usize + 1];
                list[*slot as usize] = e as u32;
                *slot += 1;
            }
        }
        offset.pop();
    }

    /// Heap memory of the tables in bytes; the maps are left out, which are empty but for odd meshes.
    pub(crate) fn bytes(&self) -> usize {
        let lists = [&self.face_offset, &self.origin, &self.edge, &self.twin, &self.edge_half_edge];
        let by_vertex = [&self.vertex_half_edge, &self.sharp_offset, &self.sharp_edges];
        let numbers: usize = lists.into_iter().chain(by_vertex).map(|list| 4 * list.capacity()).sum();
        let edges = size_of::<[u32; 2]>() * self.edge_vertices.capacity()
            + size_of::<EdgeFlags>() * self.edge_flags.capacity()
            + self.edge_sharpness.bytes();
        let vertices = self.vertex_non_manifold.capacity() + self.vertex_sharpness.bytes();
        let fans = size_of::<FanSize>() * self.fan_sizes.capacity();
        numbers + edges + vertices + fans + self.face.bytes() + self.hole.capacity() + self.edits.bytes()
    }

    /// True where the edge is infinitely sharp.
    #[inline]
    pub fn is_infinitely_sharp(&self, e: Edge) -> bool {
        self.edge_sharpness(e) >= INFINITE_SHARPNESS
    }
}
