//! What all splits share: parent vertices live on, every edge falls into two halves at a new vertex, and sharpness decays.

use crate::index::{Edge, HalfEdge, Vertex};
use crate::sharpness::{decay, edge_half, foreign_half, seam_half};
use crate::topology::{EdgeFlags, FaceOf, NONE, SharpnessColumn, Topology};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Elements that a thread takes at least: topologies of a few faces, of which plans are made, are split by one.
pub(super) const SHARE: usize = 1024;

/// The tables that differ from split to split. Child vertices are those of parent vertices, then `face_points` (all
/// faces' or none), then those of edges; child edges are `inside` faces, then the halves of parent edges.
pub(super) struct Split {
    /// Corners of every child face.
    pub sides: u32,
    pub origin: Vec<u32>,
    pub edge: Vec<u32>,
    pub twin: Vec<u32>,
    /// Parent half-edge to the child half-edge that starts at its origin, along it.
    pub outwards: fn(&Topology, HalfEdge) -> u32,
    /// Parent half-edge to the child half-edge that ends at its origin, along the previous half-edge.
    pub inwards: fn(&Topology, HalfEdge) -> u32,
    /// Ends of the edges inside faces, and a half-edge of each.
    pub inside: Vec<([u32; 2], u32)>,
    /// One outgoing half-edge per face point.
    pub face_points: Vec<u32>,
    /// Parent face of every child face.
    pub parent_face: Vec<u32>,
}

/// True where `h` runs from its edge's first end to the second.
#[inline]
pub(crate) fn runs_forward(t: &Topology, h: HalfEdge) -> bool {
    t.origin(h) == t.edge_vertices(t.edge(h))[0]
}

/// The number of half `second` of edge `e` among child edges, of which `inside` lie inside faces.
pub(super) fn half(inside: usize, e: Edge, second: bool) -> u32 {
    (inside + 2 * e.index() + usize::from(second)) as u32
}

impl Split {
    /// Completes the child's tables.
    pub fn finish(self, t: &Topology) -> Topology {
        let (vertices, edges) = (t.vertex_count(), t.edge_count());
        let first_edge_point = vertices + self.face_points.len();
        let mut edge_vertices: Vec<[u32; 2]> = Vec::with_capacity(self.inside.len() + 2 * edges);
        edge_vertices.par_extend(self.inside.par_iter().with_min_len(SHARE).map(|i| i.0));
        edge_vertices.par_extend((0..2 * edges).into_par_iter().with_min_len(SHARE).map(|k| {
            let e = Edge((k / 2) as u32);
            [(first_edge_point + k / 2) as u32, t.edge_vertices(e)[k % 2].0]
        }));
        let mut edge_half_edge: Vec<u32> = Vec::with_capacity(self.inside.len() + 2 * edges);
        edge_half_edge.par_extend(self.inside.par_iter().with_min_len(SHARE).map(|i| i.1));
        edge_half_edge.par_extend((0..2 * edges).into_par_iter().with_min_len(SHARE).map(|k| {
            let h = HalfEdge(t.edge_half_edge[k / 2]);
            if runs_forward(t, h) == (k % 2 == 0) { (self.outwards)(t, h) } else { (self.inwards)(t, t.next(h)) }
        }));
        let mut edge_flags = Vec::with_capacity(self.inside.len() + 2 * edges);
        edge_flags.resize(self.inside.len(), EdgeFlags::default());
        edge_flags.extend(t.edge_flags.iter().flat_map(|&f| [f, f]));
        let mut edge_sharpness = SharpnessColumn::smooth(self.inside.len() + 2 * edges);
        for e in t.edge_sharpness.sharp() {
            for (k, v) in t.edge_vertices(Edge(e as u32)).into_iter().enumerate() {
                edge_sharpness.set(self.inside.len() + 2 * e + k, edge_half(t, Edge(e as u32), v));
            }
        }

        let vertex_count = first_edge_point + edges;
        let mut vertex_sharpness = SharpnessColumn::smooth(vertex_count);
        t.vertex_sharpness.sharp().for_each(|v| vertex_sharpness.set(v, decay(t.vertex_sharpness.get(v))));
        let mut vertex_non_manifold = t.vertex_non_manifold.clone();
        vertex_non_manifold.resize(first_edge_point, false);
        vertex_non_manifold.extend(t.edge_flags.iter().map(|f| f.non_manifold));
        // Where a fan was open, so is the child's, at the same side.
        let mut vertex_half_edge: Vec<u32> = Vec::with_capacity(vertex_count);
        let own = (0..vertices as u32).into_par_iter().with_min_len(SHARE);
        vertex_half_edge.par_extend(own.map(|v| t.outgoing(Vertex(v)).map_or(NONE, |h| (self.outwards)(t, h))));
        vertex_half_edge.extend_from_slice(&self.face_points);
        let on_edges = t.edge_half_edge.par_iter().with_min_len(SHARE);
        vertex_half_edge.par_extend(on_edges.map(|&h| (self.inwards)(t, t.next(HalfEdge(h)))));

        let half_edges = self.origin.len() as u32;
        let mut child = Topology {
            vertex_count,
            face_offset: (0..=half_edges / self.sides).map(|f| self.sides * f).collect(),
            origin: self.origin,
            face: FaceOf::uniform(self.sides, half_edges as usize),
            edge: self.edge,
            twin: self.twin,
            edge_vertices,
            edge_half_edge,
            edge_flags,
            edge_sharpness,
            vertex_half_edge,
            vertex_non_manifold,
            vertex_sharpness,
            sharp_offset: Vec::new(),
            sharp_edges: Vec::new(),
            hole: self.parent_face.iter().map(|&f| t.hole[f as usize]).collect(),
            rules: t.rules,
            foreign_sharpness: t.foreign_sharpness.keys().map(|&v| (v, foreign_half(t, Vertex(v)))).collect(),
            across_seam: t.across_seam.keys().map(|&v| (v, seam_half(t, Vertex(v)))).collect(),
            interpolation: t.interpolation,
            // A new vertex on an edge has no sharp edges but the edge's halves, and the child holds both.
            far_half: BTreeMap::new(),
            edits: Default::default(),
            fan_sizes: Vec::new(),
        };
        child.index_sharp_edges();
        child
    }
}
