//! From faces to half-edge tables, in linear time and in parallel: half-edges are [matched](super::matching) into edges,
//! edges numbered in the order in which the faces first name them, and what the rules make sharp is made sharp.
//!
//! Rules for meshes that are no manifold follow OpenSubdiv 3.7 (`vtr/level.cpp`, `far/topologyRefinerFactory.cpp`):
//! the result is the same surface, and [`Topology`] reports what was found.

use super::edges::{Edges, twinless};
use super::matching::{FaceList, Matching};
use super::{EdgeFlags, FaceOf, FanSize, Interpolation, NONE, SharpnessColumn, Topology};
use crate::index::{Edge, HalfEdge, Vertex};
use crate::mesh::{ControlMesh, MeshError, clamp_sharpness};
use crate::tags::{Boundary, INFINITE_SHARPNESS, Tags};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

pub(super) fn from_mesh(mesh: &ControlMesh) -> Result<Topology, MeshError> {
    let face_offset = copied(mesh.face_offsets());
    let origin = copied(mesh.corners());
    let vertex_count = mesh.vertex_count();
    let face = FaceOf::new(&face_offset);
    let list = FaceList { vertex_count, face_offset: &face_offset, origin: &origin, face: &face };
    let mut matching = Matching::new(list);
    let creases = &mesh.tags().creases;
    let mut creased = Vec::with_capacity(creases.len());
    for (crease, c) in creases.iter().enumerate() {
        let [a, b] = c.vertices;
        creased.push(matching.find(a, b).ok_or(MeshError::CreaseNotOnEdge { crease, a, b })?);
    }
    let edges = matching.take_edges();
    let mut edge_sharpness = SharpnessColumn::smooth(edges.vertices.len());
    for (h, c) in creased.into_iter().zip(creases) {
        edge_sharpness.set(edges.of_half_edge[h as usize] as usize, clamp_sharpness(c.sharpness));
    }
    let (flags, open, twinless) = flags(&matching, &edges);
    let mut vertex_sharpness = SharpnessColumn::smooth(vertex_count);
    for c in &mesh.tags().corners {
        vertex_sharpness.set(c.vertex as usize, clamp_sharpness(c.sharpness));
    }
    let mut hole = vec![false; mesh.face_count()];
    subsurf_memory::advise(&mut hole);
    for &f in &mesh.tags().holes {
        hole[f as usize] = true;
    }
    // Fans start at their first half-edge without a twin, where there is one.
    let mut vertex_half_edge = matching.first_outgoing;
    for &h in twinless.iter().rev() {
        vertex_half_edge[origin[h as usize] as usize] = h;
    }
    let mut topology = Topology {
        vertex_count,
        face_offset,
        origin,
        face,
        edge: edges.of_half_edge,
        twin: matching.twin,
        edge_vertices: edges.vertices,
        edge_half_edge: edges.half_edge,
        edge_flags: flags,
        edge_sharpness,
        vertex_half_edge,
        vertex_non_manifold: Vec::new(),
        vertex_sharpness,
        sharp_offset: Vec::new(),
        sharp_edges: Vec::new(),
        hole,
        rules: mesh.tags().rules,
        foreign_sharpness: BTreeMap::new(),
        across_seam: BTreeMap::new(),
        interpolation: Interpolation::Smooth,
        far_half: BTreeMap::new(),
        edits: Default::default(),
        fan_sizes: Vec::new(),
    };
    topology.apply_tags(mesh.tags(), &open);
    Ok(topology)
}

/// What is unusual about edges; those that are, ascending; half-edges without twins, ascending.
fn flags(matching: &Matching, edges: &Edges) -> (Vec<EdgeFlags>, Vec<u32>, Vec<u32>) {
    let mut flags = filled(edges.half_edge.len(), EdgeFlags::default());
    let mut open = Vec::new();
    let twinless = twinless(&matching.twin);
    for &h in &twinless {
        let e = edges.of_half_edge[h as usize];
        if edges.half_edge[e as usize] == h {
            let unusual = matching.non_manifold.binary_search_by_key(&h, |u| u.0).ok();
            let boundary = unusual.is_none_or(|at| matching.non_manifold[at].1);
            flags[e as usize] = EdgeFlags { boundary, non_manifold: unusual.is_some() };
            open.push(e);
        }
    }
    (flags, open, twinless)
}

/// The half-edge that starts each vertex's fan: the first one without a twin, else the first.
pub(super) fn leading_half_edges(vertices: usize, origin: &[u32], twin: &[u32]) -> Vec<u32> {
    let mut lead = vec![NONE; vertices];
    lead_fans(origin, twin, &mut lead);
    lead
}

/// The same into a table of nothing.
pub(super) fn lead_fans(origin: &[u32], twin: &[u32], lead: &mut [u32]) {
    for (h, &v) in origin.iter().enumerate().rev() {
        let old = lead[v as usize];
        if twin[h] == NONE || old == NONE || twin[old as usize] != NONE {
            lead[v as usize] = h as u32;
        }
    }
}

/// Elements that a thread takes at a time.
pub(super) const SHARE: usize = 1 << 14;

/// A copy in large pages.
fn copied(numbers: &[u32]) -> Vec<u32> {
    let mut out = subsurf_memory::with_capacity(numbers.len());
    numbers.par_iter().with_min_len(SHARE).copied().collect_into_vec(&mut out);
    out
}

/// As many equal values, in large pages.
pub(super) fn filled<T: Clone>(len: usize, value: T) -> Vec<T> {
    let mut out = subsurf_memory::with_capacity(len);
    out.resize(len, value);
    out
}

impl Topology {
    /// Sharpens what the rules make sharp, and turns faces into holes.
    fn apply_tags(&mut self, tags: &Tags, open: &[u32]) {
        let vertices = || (0..self.vertex_count as u32).into_par_iter().with_min_len(SHARE).map(Vertex);
        let (fans, in_fans) = FanSize::all(self);
        let faces_in = |v: Vertex| fans[v.index()].faces(self, v);
        // Where fans leave no corner out, they hold all faces of every vertex.
        let all = if in_fans == self.origin.len() { None } else { Some(self.faces_per_vertex()) };
        let faces = |v: Vertex| all.as_ref().map_or_else(|| faces_in(v), |all| all[v.index()] as usize);
        let vertex_non_manifold = match &all {
            None => fans.iter().map(|fan| fan.is_empty()).collect(),
            Some(_) => vertices().map(|v| faces_in(v) != faces(v) || faces(v) == 0).collect(),
        };
        let lonely: Vec<u32> = match tags.rules.boundary {
            Boundary::EdgeAndCorner => {
                let lonely = |v: &Vertex| faces(*v) == 1 && self.fan_edges_of_one_face(*v);
                vertices().filter(lonely).map(|v| v.0).collect()
            }
            _ => Vec::new(),
        };
        (self.vertex_non_manifold, self.fan_sizes) = (vertex_non_manifold, fans);
        let non_manifold: Vec<u32> =
            open.iter().copied().filter(|&e| self.edge_flags[e as usize].non_manifold).collect();
        for &e in &non_manifold {
            self.edge_vertices[e as usize].iter().for_each(|&v| self.vertex_non_manifold[v as usize] = true);
        }
        if tags.rules.boundary == Boundary::None {
            self.make_boundary_faces_holes(open);
        }
        let creased = self.non_manifold_creases(&non_manifold);
        for &e in open {
            self.edge_sharpness.set(e as usize, INFINITE_SHARPNESS);
        }
        for v in lonely {
            self.vertex_sharpness.set(v as usize, INFINITE_SHARPNESS);
        }
        // Looked for all at once, since most meshes have none.
        if self.vertex_non_manifold.contains(&true) {
            for (v, _) in self.vertex_non_manifold.iter().enumerate().filter(|(_, non_manifold)| **non_manifold) {
                if !creased.contains(&(v as u32)) {
                    self.vertex_sharpness.set(v, INFINITE_SHARPNESS);
                }
            }
        }
        self.index_sharp_edges();
    }

    pub(super) fn faces_per_vertex(&self) -> Vec<u32> {
        let mut count = vec![0u32; self.vertex_count];
        self.origin.iter().for_each(|&v| count[v as usize] += 1);
        count
    }

    /// Number of faces in the fan that starts at the vertex's leading half-edge.
    pub(super) fn fan_faces(&self, v: Vertex) -> u32 {
        let mut count = 0;
        self.walk_fan(v, |_| count += 1);
        count
    }

    /// True where the only face at `v` meets it with two different edges.
    fn fan_edges_of_one_face(&self, v: Vertex) -> bool {
        self.outgoing(v).is_some_and(|h| self.edge(h) != self.edge(self.prev(h)))
    }

    /// Boundary rule "none": faces at a vertex with a boundary edge that is not tagged infinitely sharp are holes.
    fn make_boundary_faces_holes(&mut self, open: &[u32]) {
        let mut is_open = vec![false; self.vertex_count];
        for e in open.iter().map(|&e| e as usize) {
            if self.edge_flags[e].boundary && self.edge_sharpness.get(e) < INFINITE_SHARPNESS {
                self.edge_vertices[e].iter().for_each(|&v| is_open[v as usize] = true);
            }
        }
        for (&v, h) in self.origin.iter().zip(0..) {
            if is_open[v as usize] {
                self.hole[self.face.get(h) as usize] = true;
            }
        }
    }

    /// Non-manifold vertices inside a crease along which several sheets meet: they stay smooth along the crease.
    /// Exactly two non-manifold edges with equally many faces, no boundary, and every sheet runs from one to the other.
    fn non_manifold_creases(&self, non_manifold: &[u32]) -> BTreeSet<u32> {
        let mut edges: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for &e in non_manifold {
            self.edge_vertices[e as usize].iter().for_each(|&v| edges.entry(v).or_default().push(e));
        }
        edges.retain(|_, list| list.len() == 2 && list[0] != list[1]);
        if edges.is_empty() {
            return Default::default();
        }
        let mut corners: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (h, v) in self.origin.iter().enumerate().filter(|(_, v)| edges.contains_key(v)) {
            corners.entry(*v).or_default().push(h as u32);
        }
        let faces_at = |e: u32, corners: &[u32]| {
            let at = |h: &&u32| self.edge[**h as usize] == e || self.edge(self.prev(HalfEdge(**h))) == Edge(e);
            corners.iter().filter(at).count()
        };
        let mut edge_count: BTreeMap<u32, usize> = BTreeMap::new();
        self.edge_vertices.iter().flatten().for_each(|&v| *edge_count.entry(v).or_default() += 1);
        edges.retain(|v, list| {
            let corners = &corners[v];
            if corners.len() <= edge_count[v] {
                return false;
            }
            let (a, b) = (list[0], list[1]);
            if faces_at(a, corners) != faces_at(b, corners) {
                return false;
            }
            let mut visited = 0;
            for &h in corners {
                if self.twin(HalfEdge(h)).is_some() {
                    continue;
                }
                // One sheet: from its clockwise end to its counter-clockwise end.
                let mut last = HalfEdge(h);
                visited += 1;
                while let Some(next) = self.turn_left(last) {
                    last = next;
                    visited += 1;
                }
                let (from, to) = (self.edge(HalfEdge(h)).0, self.edge(self.prev(last)).0);
                if (from, to) != (a, b) && (from, to) != (b, a) {
                    return false;
                }
            }
            visited == corners.len()
        });
        edges.into_keys().collect()
    }
}
