//! Puts a piece that was built by itself back into the topology that it comes from. So an edit costs what it touches, and
//! the rules of topology are written once, in [`build`](super::build).
//!
//! A piece has all faces at its *touched* vertices, and all faces at the corners of those: what the rules say about
//! touched vertices, their edges and their faces is then the same in the piece and in the whole mesh.

use super::{EdgeFlags, FaceOf, Interpolation, NONE, SharpnessColumn, Topology};
use crate::index::{Face, Vertex};
use crate::tags::{INFINITE_SHARPNESS, Rules};
use std::collections::{BTreeMap, BTreeSet};

/// What edits leave behind in packed tables.
#[derive(Clone, Debug, Default)]
pub(crate) struct Edits {
    /// Sharp edges at vertices whose list is not the packed one any more.
    sharp: BTreeMap<u32, Vec<u32>>,
    /// Edges without faces, to be used again.
    free_edges: Vec<u32>,
    /// Faces that were taken out, after the number of their corners: holes that share no edge and no fan with any other face.
    removed: BTreeSet<(u32, u32)>,
}

impl Edits {
    #[inline]
    pub fn sharp_edges(&self, v: u32) -> Option<&[u32]> {
        if self.sharp.is_empty() { None } else { self.sharp.get(&v).map(Vec::as_slice) }
    }

    /// True where nothing was edited.
    pub fn is_empty(&self) -> bool {
        self.sharp.is_empty()
    }

    /// True where there are no elements that edits took out, either.
    pub fn leave_no_gaps(&self) -> bool {
        self.is_empty() && self.free_edges.is_empty() && self.removed.is_empty()
    }

    /// Heap memory in bytes, about.
    pub fn bytes(&self) -> usize {
        let lists: usize = self.sharp.values().map(|list| 32 + 4 * list.len()).sum();
        lists + 4 * self.free_edges.len() + 8 * self.removed.len()
    }
}

/// A part of a mesh as a topology of its own.
pub(crate) struct Piece {
    pub topology: Topology,
    /// Vertex and half-edge of the mesh by those of the piece.
    pub vertices: Vec<u32>,
    pub half_edges: Vec<u32>,
    /// Vertices of the piece whose tables may have changed.
    pub touched: Vec<u32>,
}

impl Topology {
    /// True for a face that an edit took out.
    pub(crate) fn is_removed(&self, face: Face) -> bool {
        self.edits.removed.contains(&(self.sides(face) as u32, face.0))
    }

    /// Takes a face out: its vertices and edges know nothing of it until the next splice. Returns its edges.
    pub(crate) fn take_out(&mut self, face: Face) -> Vec<u32> {
        self.fan_sizes.clear();
        let own = self.first(face) as usize..self.face_offset[face.index() + 1] as usize;
        let edges = self.edge[own.clone()].to_vec();
        self.twin[own].fill(NONE);
        self.hole[face.index()] = true;
        self.edits.removed.insert((self.sides(face) as u32, face.0));
        edges
    }

    /// Puts a face in, in the place of one of as many corners that was taken out, or behind all others. Its tables wait for the next splice.
    pub(crate) fn put_in(&mut self, vertices: &[u32]) -> Face {
        let sides = vertices.len() as u32;
        let reused = self.edits.removed.range((sides, 0)..(sides + 1, 0)).next().copied();
        let face = reused.map_or(self.face_count() as u32, |(_, face)| face);
        if reused.is_some() {
            self.edits.removed.remove(&(sides, face));
            self.hole[face as usize] = false;
        } else {
            let end = self.face_offset[face as usize] + sides;
            self.face.push(vertices.len(), &self.face_offset);
            self.face_offset.push(end);
            self.hole.push(false);
            for table in [&mut self.origin, &mut self.edge, &mut self.twin] {
                table.resize(end as usize, NONE);
            }
        }
        let first = self.first(Face(face)) as usize;
        self.origin[first..first + vertices.len()].copy_from_slice(vertices);
        self.edge[first..first + vertices.len()].fill(NONE);
        Face(face)
    }

    /// Vertices without faces.
    pub(crate) fn isolated(vertices: usize, rules: Rules) -> Self {
        Self {
            vertex_count: vertices,
            face_offset: vec![0],
            vertex_half_edge: vec![NONE; vertices],
            vertex_non_manifold: vec![true; vertices],
            vertex_sharpness: std::iter::repeat_n(INFINITE_SHARPNESS, vertices).collect(),
            sharp_offset: vec![0; vertices + 1],
            origin: Vec::new(),
            face: FaceOf::Quads,
            edge: Vec::new(),
            twin: Vec::new(),
            edge_vertices: Vec::new(),
            edge_half_edge: Vec::new(),
            edge_flags: Vec::new(),
            edge_sharpness: SharpnessColumn::smooth(0),
            sharp_edges: Vec::new(),
            hole: Vec::new(),
            rules,
            foreign_sharpness: BTreeMap::new(),
            across_seam: BTreeMap::new(),
            interpolation: Interpolation::Smooth,
            far_half: BTreeMap::new(),
            edits: Edits::default(),
            fan_sizes: Vec::new(),
        }
    }

    /// Adds a vertex without faces.
    pub(crate) fn push_vertex(&mut self) -> Vertex {
        self.vertex_count += 1;
        self.vertex_half_edge.push(NONE);
        self.vertex_non_manifold.push(true);
        self.vertex_sharpness.push(INFINITE_SHARPNESS);
        self.sharp_offset.push(self.sharp_offset[self.vertex_count - 1]);
        Vertex(self.vertex_count as u32 - 1)
    }

    /// Takes over what the piece says about its touched vertices, their edges and faces. `orphans` are the edges of faces that
    /// were taken out.
    pub(crate) fn splice(&mut self, piece: &Piece, orphans: &[u32]) {
        self.fan_sizes.clear();
        let own = &piece.topology;
        let mut touched = vec![false; own.vertex_count];
        piece.touched.iter().for_each(|&v| touched[v as usize] = true);
        let in_mesh = |v: Vertex| piece.vertices[v.index()];
        let ends = |e: usize| own.edge_vertices[e].map(|v| piece.vertices[v as usize]);

        // The edges at touched vertices with their half-edges in the mesh.
        let mut sides: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
        for (local, &h) in piece.half_edges.iter().enumerate() {
            let e = own.edge[local] as usize;
            if own.edge_vertices[e].iter().any(|&v| touched[v as usize]) {
                sides.entry(e).or_default().push(h);
            }
        }
        // Old numbers stay with old edges; the rest get free ones.
        let old: BTreeSet<u32> =
            sides.values().flatten().map(|&h| self.edge[h as usize]).chain(orphans.iter().copied()).collect();
        let mut taken = BTreeSet::new();
        let mut number: BTreeMap<usize, u32> = BTreeMap::new();
        for (&e, list) in &sides {
            let same = |&id: &u32| {
                let known = (id != NONE).then(|| self.edge_vertices[id as usize]);
                known.is_some_and(|[a, b]| [[a, b], [b, a]].contains(&ends(e)))
            };
            if let Some(id) = list.iter().map(|&h| self.edge[h as usize]).filter(same).find(|id| !taken.contains(id)) {
                taken.insert(id);
                number.insert(e, id);
            }
        }
        let mut free: Vec<u32> = old.iter().copied().filter(|id| *id != NONE && !taken.contains(id)).rev().collect();
        for &e in sides.keys().filter(|e| !number.contains_key(e)).collect::<Vec<_>>() {
            let id = free.pop().or_else(|| self.edits.free_edges.pop()).unwrap_or_else(|| {
                self.edge_vertices.push([0; 2]);
                self.edge_half_edge.push(NONE);
                self.edge_flags.push(EdgeFlags::default());
                self.edge_sharpness.push(0.0);
                self.edge_vertices.len() as u32 - 1
            });
            number.insert(e, id);
        }
        for &id in &free {
            self.edge_half_edge[id as usize] = NONE;
            self.edge_flags[id as usize] = EdgeFlags::default();
            self.edge_sharpness.set(id as usize, 0.0);
        }
        self.edits.free_edges.extend(free);

        for (local, &h) in piece.half_edges.iter().enumerate() {
            if let Some(&id) = number.get(&(own.edge[local] as usize)) {
                self.edge[h as usize] = id;
                let twin = own.twin[local];
                self.twin[h as usize] = if twin == NONE { NONE } else { piece.half_edges[twin as usize] };
            }
        }
        let mut sharp: BTreeMap<u32, Vec<u32>> =
            piece.touched.iter().map(|&v| (piece.vertices[v as usize], Vec::new())).collect();
        for (&e, &id) in &number {
            self.edge_vertices[id as usize] = ends(e);
            self.edge_half_edge[id as usize] = piece.half_edges[own.edge_half_edge[e] as usize];
            self.edge_flags[id as usize] = own.edge_flags[e];
            self.edge_sharpness.set(id as usize, own.edge_sharpness.get(e));
            for v in ends(e) {
                let list = sharp.entry(v).or_default();
                if own.edge_sharpness.get(e) > 0.0 && !list.contains(&id) {
                    list.push(id);
                }
            }
        }
        for (v, mut list) in sharp {
            list.extend(self.sharp_edges(Vertex(v)).iter().filter(|id| !old.contains(id)));
            list.sort_unstable();
            self.edits.sharp.insert(v, list);
        }
        for &v in &piece.touched {
            let v = Vertex(v);
            let at = in_mesh(v) as usize;
            self.vertex_half_edge[at] = own.outgoing(v).map_or(NONE, |h| piece.half_edges[h.index()]);
            self.vertex_non_manifold[at] = own.vertex_non_manifold[v.index()];
            self.vertex_sharpness.set(at, own.vertex_sharpness.get(v.index()));
        }
        for f in (0..own.face_count() as u32).map(Face) {
            if own.face_vertices(f).iter().any(|&v| touched[v as usize]) {
                let in_mesh = self.face.get(piece.half_edges[own.first(f) as usize]);
                self.hole[in_mesh as usize] = own.is_hole(f);
            }
        }
    }
}
