//! A point of the next level over the vertices of this one: its mask, with face centroids written out.

use crate::index::{Edge, Face, Vertex};
use crate::mask::{Mask, edge_mask, vertex_mask};
use crate::scheme::{Scheme, SplitKind};
use crate::topology::Topology;

/// What a refined point belongs to.
#[derive(Clone, Copy)]
pub(crate) enum Parent {
    Vertex(Vertex),
    Face(Face),
    Edge(Edge),
}

impl Parent {
    /// Number of vertices of the next level.
    pub fn count(t: &Topology, scheme: Scheme) -> usize {
        let faces = if scheme.split() == SplitKind::Quads { t.face_count() } else { 0 };
        t.vertex_count() + faces + t.edge_count()
    }

    /// Of vertex `v` of the next level.
    pub fn of(t: &Topology, scheme: Scheme, v: u32) -> Self {
        let vertices = t.vertex_count() as u32;
        let faces = if scheme.split() == SplitKind::Quads { t.face_count() as u32 } else { 0 };
        match v {
            v if v < vertices => Self::Vertex(Vertex(v)),
            v if v < vertices + faces => Self::Face(Face(v - vertices)),
            v => Self::Edge(Edge(v - vertices - faces)),
        }
    }
}

/// Appends the terms of a refined point over the vertices of `t`; a vertex may come several times.
pub(crate) fn refined_point(
    t: &Topology,
    scheme: Scheme,
    parent: Parent,
    mask: &mut Mask,
    terms: &mut Vec<(u32, f64)>,
) {
    mask.clear();
    match parent {
        Parent::Vertex(v) => vertex_mask(t, scheme, v, mask),
        Parent::Edge(e) => edge_mask(t, scheme, e, mask),
        Parent::Face(f) => mask.face(f, 1.0),
    }
    terms.extend(mask.vertices.iter().filter(|term| term.1 != 0.0));
    for &(f, weight) in mask.faces.iter().filter(|term| term.1 != 0.0) {
        let corners = t.face_vertices(Face(f));
        let each = weight / corners.len() as f64;
        terms.extend(corners.iter().map(|&v| (v, each)));
    }
}
