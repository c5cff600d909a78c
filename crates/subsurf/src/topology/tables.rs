//! What walks round a face read: half-edge tables that are stored, or computed from those one level up.

use super::{EdgeFlags, Interpolation, NONE, Topology};
use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::tags::Rules;
use std::borrow::Cow;

/// Half-edge tables with effective sharpness; see [`Topology`] for the meaning of each.
pub(crate) trait Tables: Sized {
    fn vertex_count(&self) -> usize;
    fn rules(&self) -> &Rules;
    fn interpolation(&self) -> Interpolation;
    fn sides(&self, face: Face) -> usize;
    fn half_edge(&self, face: Face, corner: usize) -> HalfEdge;
    fn face(&self, h: HalfEdge) -> Face;
    fn origin(&self, h: HalfEdge) -> Vertex;
    fn edge(&self, h: HalfEdge) -> Edge;
    fn twin(&self, h: HalfEdge) -> Option<HalfEdge>;
    fn next(&self, h: HalfEdge) -> HalfEdge;
    fn prev(&self, h: HalfEdge) -> HalfEdge;
    fn edge_vertices(&self, e: Edge) -> [Vertex; 2];
    fn edge_flags(&self, e: Edge) -> EdgeFlags;
    fn edge_sharpness(&self, e: Edge) -> f64;
    fn vertex_sharpness(&self, v: Vertex) -> f64;
    fn is_non_manifold_vertex(&self, v: Vertex) -> bool;
    /// Ascending.
    fn sharp_edges(&self, v: Vertex) -> impl Iterator<Item = Edge>;
    fn foreign_sharpness(&self, v: Vertex) -> Cow<'_, [f64]>;
    fn across_seam(&self, v: Vertex) -> Cow<'_, [f64]>;
    /// Sharpness of the half of an edge at one end, where it is known and not to be computed.
    fn far_half(&self, e: Edge, v: Vertex) -> Option<f64>;

    /// True where `v` lies on a boundary that is kept piecewise linear.
    fn is_on_linear_boundary(&self, v: Vertex) -> bool {
        self.interpolation() == Interpolation::LinearBoundaries
            && self.sharp_edges(v).any(|e| self.edge_flags(e).boundary)
    }

    fn turn_left(&self, h: HalfEdge) -> Option<HalfEdge> {
        self.twin(self.prev(h))
    }

    fn turn_right(&self, h: HalfEdge) -> Option<HalfEdge> {
        self.twin(h).map(|t| self.next(t))
    }
}

impl Tables for Topology {
    fn vertex_count(&self) -> usize {
        self.vertex_count
    }
    fn rules(&self) -> &Rules {
        &self.rules
    }
    fn interpolation(&self) -> Interpolation {
        self.interpolation
    }
    #[inline]
    fn sides(&self, face: Face) -> usize {
        self.sides(face)
    }
    #[inline]
    fn half_edge(&self, face: Face, corner: usize) -> HalfEdge {
        self.half_edge(face, corner)
    }
    #[inline]
    fn face(&self, h: HalfEdge) -> Face {
        Face(self.face.get(h.0))
    }
    #[inline]
    fn origin(&self, h: HalfEdge) -> Vertex {
        Vertex(self.origin[h.index()])
    }
    #[inline]
    fn edge(&self, h: HalfEdge) -> Edge {
        Edge(self.edge[h.index()])
    }
    #[inline]
    fn twin(&self, h: HalfEdge) -> Option<HalfEdge> {
        let t = self.twin[h.index()];
        (t != NONE).then_some(HalfEdge(t))
    }
    #[inline]
    fn next(&self, h: HalfEdge) -> HalfEdge {
        self.next(h)
    }
    #[inline]
    fn prev(&self, h: HalfEdge) -> HalfEdge {
        self.prev(h)
    }
    fn edge_vertices(&self, e: Edge) -> [Vertex; 2] {
        self.edge_vertices(e)
    }
    fn edge_flags(&self, e: Edge) -> EdgeFlags {
        self.edge_flags[e.index()]
    }
    fn edge_sharpness(&self, e: Edge) -> f64 {
        self.edge_sharpness.get(e.index())
    }
    fn vertex_sharpness(&self, v: Vertex) -> f64 {
        self.vertex_sharpness.get(v.index())
    }
    fn is_non_manifold_vertex(&self, v: Vertex) -> bool {
        self.vertex_non_manifold[v.index()]
    }
    fn sharp_edges(&self, v: Vertex) -> impl Iterator<Item = Edge> {
        self.sharp_edges(v).iter().map(|&e| Edge(e))
    }
    fn foreign_sharpness(&self, v: Vertex) -> Cow<'_, [f64]> {
        Cow::Borrowed(self.foreign_sharpness(v))
    }
    fn across_seam(&self, v: Vertex) -> Cow<'_, [f64]> {
        Cow::Borrowed(self.across_seam(v))
    }
    fn far_half(&self, e: Edge, v: Vertex) -> Option<f64> {
        self.far_half.get(&(e.0, v.0)).copied()
    }
}
