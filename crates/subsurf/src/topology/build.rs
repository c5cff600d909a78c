//! From faces to half-edge tables: half-edges are dropped into one bucket per smaller end vertex and each bucket is
//! sorted, so the work is linear in the mesh and parallel over buckets.
//!
//! Rules for meshes that are no manifold follow OpenSubdiv 3.7 (`vtr/level.cpp`, `far/topologyRefinerFactory.cpp`):
//! the result is the same surface, and [`Topology`] reports what was found.

use super::{EdgeFlags, Interpolation, NONE, Topology};
use crate::index::{Edge, HalfEdge, Vertex};
use crate::mesh::{ControlMesh, MAX_COUNT, MeshError, clamp_sharpness};
use crate::tags::{Boundary, INFINITE_SHARPNESS, Tags};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU8, AtomicU32, AtomicU64, Ordering::Relaxed};

pub(super) fn from_mesh(mesh: &ControlMesh) -> Result<Topology, MeshError> {
    let mut topology = unsharpened(mesh)?;
    topology.apply_tags(mesh.tags());
    Ok(topology)
}

/// Tables with the tags' sharpness only.
fn unsharpened(mesh: &ControlMesh) -> Result<Topology, MeshError> {
    let origin = mesh.corners().to_vec();
    let face_offset = mesh.face_offsets().to_vec();
    let face = faces_of_corners(&face_offset, origin.len());
    let pairs = EdgePairs::new(mesh.vertex_count(), &face_offset, &origin, &face);
    let edges = pairs.number()?;

    let mut edge_sharpness = vec![0.0; edges.vertices.len()];
    for (crease, c) in mesh.tags().creases.iter().enumerate() {
        let [a, b] = c.vertices;
        let h = pairs.find(a, b).ok_or(MeshError::CreaseNotOnEdge { crease, a, b })?;
        edge_sharpness[edges.of_half_edge[h as usize] as usize] = clamp_sharpness(c.sharpness);
    }
    let mut vertex_sharpness = vec![0.0; mesh.vertex_count()];
    for c in &mesh.tags().corners {
        vertex_sharpness[c.vertex as usize] = clamp_sharpness(c.sharpness);
    }
    let mut hole = vec![false; mesh.face_count()];
    for &f in &mesh.tags().holes {
        hole[f as usize] = true;
    }
    let twin: Vec<u32> = pairs.twin.into_iter().map(AtomicU32::into_inner).collect();
    let vertex_half_edge = leading_half_edges(mesh.vertex_count(), &origin, &twin);
    Ok(Topology {
        vertex_count: mesh.vertex_count(),
        face_offset,
        origin,
        face,
        edge: edges.of_half_edge,
        twin,
        edge_vertices: edges.vertices,
        edge_half_edge: edges.half_edge,
        edge_flags: edges.flags,
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
    })
}

fn faces_of_corners(face_offset: &[u32], corners: usize) -> Vec<u32> {
    let mut face = vec![0u32; corners];
    for (f, w) in face_offset.windows(2).enumerate() {
        face[w[0] as usize..w[1] as usize].fill(f as u32);
    }
    face
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

/// Which half-edges belong to one edge.
struct EdgePairs<'a> {
    face_offset: &'a [u32],
    origin: &'a [u32],
    face: &'a [u32],
    /// Half-edges by smaller end vertex, each bucket ascending: the larger end in the upper half of the number, the
    /// half-edge in the lower.
    bucket_offset: Vec<u32>,
    bucket: Vec<u64>,
    twin: Vec<AtomicU32>,
    /// First half-edge of the edge that a half-edge belongs to.
    leader: Vec<AtomicU32>,
    /// At leaders: 1 boundary, 2 non-manifold.
    flags: Vec<AtomicU8>,
}

/// Edges numbered by first appearance.
struct Edges {
    of_half_edge: Vec<u32>,
    vertices: Vec<[u32; 2]>,
    half_edge: Vec<u32>,
    flags: Vec<EdgeFlags>,
}

/// One edge while its half-edges are being collected.
struct Instance {
    leader: u32,
    faces: u32,
    last_face: u32,
    last: u32,
    non_manifold: bool,
}

impl<'a> EdgePairs<'a> {
    fn new(vertices: usize, face_offset: &'a [u32], origin: &'a [u32], face: &'a [u32]) -> Self {
        let count = origin.len();
        let atomics = |value: u32| -> Vec<AtomicU32> { (0..count).map(|_| AtomicU32::new(value)).collect() };
        let mut pairs = Self {
            face_offset,
            origin,
            face,
            bucket_offset: vec![0; vertices + 1],
            bucket: Vec::new(),
            twin: atomics(NONE),
            leader: atomics(0),
            flags: (0..count).map(|_| AtomicU8::new(0)).collect(),
        };
        pairs.fill_buckets();
        pairs.match_buckets();
        pairs
    }

    /// (smaller, larger) end vertex of half-edge `h`.
    fn ends(&self, h: u32) -> (u32, u32) {
        let f = self.face[h as usize] as usize;
        let next = if h + 1 == self.face_offset[f + 1] { self.face_offset[f] } else { h + 1 };
        let (a, b) = (self.origin[h as usize], self.origin[next as usize]);
        (a.min(b), a.max(b))
    }

    fn fill_buckets(&mut self) {
        let half_edges = self.origin.len() as u32;
        let count: Vec<AtomicU32> = (0..self.bucket_offset.len()).map(|_| AtomicU32::new(0)).collect();
        (0..half_edges).into_par_iter().for_each(|h| {
            count[self.ends(h).0 as usize].fetch_add(1, Relaxed);
        });
        let mut start = 0;
        for (offset, n) in self.bucket_offset.iter_mut().zip(&count) {
            *offset = start;
            start += n.swap(start, Relaxed);
        }
        // Which half-edge gets which slot of its bucket depends on the threads; the sort below makes up for it.
        let slots: Vec<AtomicU64> = (0..half_edges).map(|_| AtomicU64::new(0)).collect();
        (0..half_edges).into_par_iter().for_each(|h| {
            let (small, large) = self.ends(h);
            let slot = count[small as usize].fetch_add(1, Relaxed);
            slots[slot as usize].store(u64::from(large) << 32 | u64::from(h), Relaxed);
        });
        self.bucket = slots.into_iter().map(AtomicU64::into_inner).collect();
    }

    fn match_buckets(&mut self) {
        let mut bucket = std::mem::take(&mut self.bucket);
        let mut rest: &mut [u64] = &mut bucket;
        let mut slices = Vec::new();
        // Cut into pieces of whole buckets, a few thousand half-edges each.
        let (mut from, mut first) = (0u32, 0usize);
        for v in 1..self.bucket_offset.len() {
            let end = self.bucket_offset[v];
            if end - from >= 4096 || v + 1 == self.bucket_offset.len() {
                let (piece, tail) = rest.split_at_mut((end - from) as usize);
                slices.push((first, v, piece));
                rest = tail;
                (from, first) = (end, v);
            }
        }
        slices.into_par_iter().for_each(|(first, last, piece)| {
            let base = self.bucket_offset[first];
            for v in first..last {
                let range = self.bucket_offset[v] - base..self.bucket_offset[v + 1] - base;
                let one = &mut piece[range.start as usize..range.end as usize];
                one.sort_unstable();
                for run in one.chunk_by(|g, h| g >> 32 == h >> 32) {
                    self.match_run(v as u32, run);
                }
            }
        });
        self.bucket = bucket;
    }

    /// All half-edges between one pair of vertices, ascending.
    fn match_run(&self, smaller: u32, run: &[u64]) {
        let degenerate = run[0] >> 32 == u64::from(smaller);
        let half_edge = |entry: u64| entry as u32;
        let start = |h: u32| Instance {
            leader: h,
            faces: 1,
            last_face: self.face[h as usize],
            last: h,
            non_manifold: degenerate,
        };
        let lead = |h: u32, leader: u32| self.leader[h as usize].store(leader, Relaxed);
        let finish = |edge: &Instance| {
            let flags = u8::from(edge.faces < 2) | u8::from(edge.non_manifold) << 1;
            self.flags[edge.leader as usize].store(flags, Relaxed);
            if edge.faces == 2 && !edge.non_manifold {
                self.twin[edge.leader as usize].store(edge.last, Relaxed);
                self.twin[edge.last as usize].store(edge.leader, Relaxed);
            }
        };
        let leader = half_edge(run[0]);
        let mut first = start(leader);
        lead(leader, leader);
        for h in run[1..].iter().map(|&entry| half_edge(entry)) {
            let f = self.face[h as usize];
            if degenerate || first.last_face == f {
                // Both ends equal, or the face has used the edge already: an edge of its own.
                first.non_manifold = true;
                lead(h, h);
                finish(&Instance { non_manifold: true, ..start(h) });
            } else {
                lead(h, first.leader);
                let same_way = self.origin[h as usize] == self.origin[first.leader as usize];
                first.non_manifold |= first.faces >= 2 || same_way;
                first.faces += 1;
                (first.last_face, first.last) = (f, h);
            }
        }
        finish(&first);
    }

    /// Half-edge of the first edge between `a` and `b`.
    fn find(&self, a: u32, b: u32) -> Option<u32> {
        let (small, large) = (a.min(b) as usize, a.max(b));
        let bucket = &self.bucket[self.bucket_offset[small] as usize..self.bucket_offset[small + 1] as usize];
        let at = bucket.partition_point(|&entry| entry >> 32 < u64::from(large));
        bucket.get(at).filter(|&&entry| entry >> 32 == u64::from(large)).map(|&entry| entry as u32)
    }

    fn number(&self) -> Result<Edges, MeshError> {
        let count = self.leader.iter().enumerate().filter(|(h, l)| l.load(Relaxed) as usize == *h).count();
        if count > MAX_COUNT {
            return Err(MeshError::TooLarge { what: "edges", count, limit: MAX_COUNT });
        }
        let mut edges = Edges {
            of_half_edge: vec![0; self.leader.len()],
            vertices: Vec::with_capacity(count),
            half_edge: Vec::with_capacity(count),
            flags: Vec::with_capacity(count),
        };
        for h in 0..self.leader.len() {
            let leader = self.leader[h].load(Relaxed) as usize;
            if leader != h {
                edges.of_half_edge[h] = edges.of_half_edge[leader];
                continue;
            }
            edges.of_half_edge[h] = edges.half_edge.len() as u32;
            let f = self.face[h] as usize;
            let next = if h as u32 + 1 == self.face_offset[f + 1] { self.face_offset[f] as usize } else { h + 1 };
            let flags = self.flags[h].load(Relaxed);
            edges.half_edge.push(h as u32);
            edges.vertices.push([self.origin[h], self.origin[next]]);
            edges.flags.push(EdgeFlags { boundary: flags & 1 != 0, non_manifold: flags & 2 != 0 });
        }
        Ok(edges)
    }
}

impl Topology {
    /// Sharpens what the rules make sharp, and turns faces into holes.
    fn apply_tags(&mut self, tags: &Tags) {
        let face_count = self.faces_per_vertex();
        self.vertex_non_manifold = (0..self.vertex_count as u32)
            .into_par_iter()
            .map(|v| self.fan_faces(Vertex(v)) != face_count[v as usize] || face_count[v as usize] == 0)
            .collect();
        for (flags, ends) in self.edge_flags.iter().zip(&self.edge_vertices) {
            if flags.non_manifold {
                ends.iter().for_each(|&v| self.vertex_non_manifold[v as usize] = true);
            }
        }
        if tags.rules.boundary == Boundary::None {
            self.make_boundary_faces_holes();
        }
        let creased = self.non_manifold_creases();
        for (s, flags) in self.edge_sharpness.iter_mut().zip(&self.edge_flags) {
            if flags.boundary || flags.non_manifold {
                *s = INFINITE_SHARPNESS;
            }
        }
        for v in 0..self.vertex_count {
            let pinned_corner = tags.rules.boundary == Boundary::EdgeAndCorner
                && face_count[v] == 1
                && self.fan_edges_of_one_face(Vertex(v as u32));
            let non_manifold = self.vertex_non_manifold[v] && !creased.contains(&(v as u32));
            if pinned_corner || non_manifold {
                self.vertex_sharpness[v] = INFINITE_SHARPNESS;
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
        let Some(start) = self.outgoing(v) else { return 0 };
        let mut count = 1;
        let mut h = self.turn_left(start);
        while let Some(next) = h.filter(|&h| h != start) {
            count += 1;
            h = self.turn_left(next);
        }
        count
    }

    /// True where the only face at `v` meets it with two different edges.
    fn fan_edges_of_one_face(&self, v: Vertex) -> bool {
        self.outgoing(v).is_some_and(|h| self.edge(h) != self.edge(self.prev(h)))
    }

    /// Boundary rule "none": faces at a vertex with a boundary edge that is not tagged infinitely sharp are holes.
    fn make_boundary_faces_holes(&mut self) {
        let mut open = vec![false; self.vertex_count];
        for (e, flags) in self.edge_flags.iter().enumerate() {
            if flags.boundary && self.edge_sharpness[e] < INFINITE_SHARPNESS {
                self.edge_vertices[e].iter().for_each(|&v| open[v as usize] = true);
            }
        }
        for (h, &v) in self.origin.iter().enumerate() {
            if open[v as usize] {
                self.hole[self.face[h] as usize] = true;
            }
        }
    }

    /// Non-manifold vertices inside a crease along which several sheets meet: they stay smooth along the crease.
    /// Exactly two non-manifold edges with equally many faces, no boundary, and every sheet runs from one to the other.
    fn non_manifold_creases(&self) -> std::collections::BTreeSet<u32> {
        let mut edges: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (e, _) in self.edge_flags.iter().enumerate().filter(|(_, f)| f.non_manifold) {
            self.edge_vertices[e].iter().for_each(|&v| edges.entry(v).or_default().push(e as u32));
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
