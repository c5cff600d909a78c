//! One level of sparse refinement: the children of the faces that were chosen, *complete* ones, and those other children
//! that complete their one-rings. What lies further away does not exist here, so memory grows with the features and
//! not with the level.
//!
//! A vertex of a complete face has all its faces and edges. The others do not, and nothing is asked about them.

use super::features::{Around, VertexTag};
use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::ptex::PtexFaces;
use crate::scheme::{Scheme, SplitKind};
use crate::sharpness::{decay, half_among};
use crate::tags::{Creasing, INFINITE_SHARPNESS};
use crate::topology::{EdgeFlags, NONE, Topology};

/// Where a face of a level lies in the control mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub ptex_face: u32,
    /// The children on the way from the Ptex face, two bits each, the last one in the lowest bits.
    pub path: u32,
    /// How many there are.
    pub steps: u8,
}

impl Place {
    fn child(self, child: u32) -> Self {
        Self { path: self.path << 2 | child, steps: self.steps + 1, ..self }
    }
}

/// What the level's tables need to know of the rules.
#[derive(Clone, Copy, Debug)]
pub(super) struct SplitRules {
    pub scheme: Scheme,
    pub creasing: Creasing,
}

/// Connectivity and sharpness of one level.
pub(super) struct SparseLevel {
    rules: SplitRules,
    pub depth: u32,
    /// First corner of every face, and the number of corners at the end.
    pub first: Vec<u32>,
    /// Per corner its vertex, the edge that starts there, and the number of faces between the infinitely sharp edges on
    /// both sides of the face there, where the vertex's tag makes that matter.
    pub vertex: Vec<u32>,
    pub edge: Vec<u32>,
    pub sector: Vec<u8>,
    pub place: Vec<Place>,
    /// Faces that are part of the surface and have all their neighbours.
    pub complete: Vec<bool>,
    pub edge_ends: Vec<[u32; 2]>,
    pub edge_sharpness: Vec<f64>,
    pub edge_flags: Vec<EdgeFlags>,
    pub vertex_tag: Vec<VertexTag>,
    pub vertex_sharpness: Vec<f64>,
}

impl SparseLevel {
    /// Level 0: everything.
    pub fn control_mesh(t: &Topology, scheme: Scheme, ptex: &PtexFaces) -> Self {
        let half_edges = || (0..t.half_edge_count()).map(HalfEdge::new);
        let place = |f: usize| Place { ptex_face: ptex.id(Face::new(f), 0), path: 0, steps: 0 };
        Self {
            rules: SplitRules { scheme, creasing: t.rules().creasing },
            depth: 0,
            first: t.face_offsets().to_vec(),
            vertex: t.corners().to_vec(),
            edge: half_edges().map(|h| t.edge(h).0).collect(),
            sector: half_edges().map(|h| sector(t, h)).collect(),
            place: (0..t.face_count()).map(place).collect(),
            complete: (0..t.face_count()).map(|f| !t.is_hole(Face::new(f))).collect(),
            edge_ends: t.edge_vertices.clone(),
            edge_sharpness: t.edge_sharpness.iter().collect(),
            edge_flags: t.edge_flags.clone(),
            vertex_tag: VertexTag::of_control_mesh(t, scheme),
            vertex_sharpness: t.vertex_sharpness.iter().collect(),
        }
    }

    pub fn face_count(&self) -> usize {
        self.place.len()
    }

    pub fn vertex_count(&self) -> usize {
        self.vertex_tag.len()
    }

    pub fn scheme(&self) -> Scheme {
        self.rules.scheme
    }

    /// The corners of a face.
    pub fn corners(&self, f: usize) -> std::ops::Range<usize> {
        self.first[f] as usize..self.first[f + 1] as usize
    }

    /// The sharp edges round every vertex, as far as rules depend on them.
    pub fn around_vertices(&self) -> Vec<Around> {
        let mut around = vec![Around::default(); self.vertex_count()];
        for (ends, &s) in self.edge_ends.iter().zip(&self.edge_sharpness).filter(|(_, s)| **s > 0.0) {
            around[ends[0] as usize].add(s);
            if ends[1] != ends[0] {
                around[ends[1] as usize].add(s);
            }
        }
        for f in 0..self.face_count() {
            let corners = self.corners(f);
            let mut before = self.edge[corners.end - 1];
            for c in corners {
                let both = [before, self.edge[c]].map(|e| self.edge_sharpness[e as usize] > 0.0);
                around[self.vertex[c] as usize].turns |= both == [true; 2];
                before = self.edge[c];
            }
        }
        around
    }

    /// What refining the chosen faces means for everything else. At the deepest level nothing is refined any more, and no
    /// face needs others beside it.
    pub fn choose(&self, chosen: Vec<bool>, to_deepest: bool) -> Choice {
        let mut vertex = vec![false; self.vertex_count()];
        let mut edge = vec![false; self.edge_ends.len()];
        let mut faces = 0;
        for f in (0..self.face_count()).filter(|&f| chosen[f]) {
            faces += self.corners(f).len();
            for c in self.corners(f) {
                vertex[self.vertex[c] as usize] = true;
                edge[self.edge[c] as usize] = true;
            }
        }
        if self.rules.scheme.split() == SplitKind::Triangles {
            // Four children from three corners.
            faces += faces / 3;
        }
        for f in (0..self.face_count()).filter(|&f| !chosen[f] && !to_deepest) {
            faces += self.corners(f).filter(|&c| vertex[self.vertex[c] as usize]).count();
        }
        Choice { face: chosen, vertex, edge, faces, to_deepest }
    }

    /// The next level: children of the chosen faces, and the ones that their vertices need beside them.
    pub fn refine(&self, choice: &Choice, around: &[Around]) -> Self {
        let mut child = Self {
            rules: self.rules,
            depth: self.depth + 1,
            first: vec![0],
            vertex: Vec::with_capacity(4 * choice.faces),
            edge: Vec::with_capacity(4 * choice.faces),
            sector: Vec::with_capacity(4 * choice.faces),
            place: Vec::with_capacity(choice.faces),
            complete: Vec::with_capacity(choice.faces),
            edge_ends: Vec::new(),
            edge_sharpness: Vec::new(),
            edge_flags: Vec::new(),
            vertex_tag: Vec::new(),
            vertex_sharpness: Vec::new(),
        };
        let points = Points {
            of_vertex: self.vertex_points(choice, &mut child),
            of_face: self.face_points(choice, &mut child),
            of_edge: self.edge_points(choice, &mut child),
        };
        let halves = self.halve_edges(choice, around, &points, &mut child);
        match self.rules.scheme.split() {
            SplitKind::Quads => self.split_to_quads(choice, &points, &halves, &mut child),
            SplitKind::Triangles => self.split_to_triangles(choice, &points, &halves, &mut child),
        }
        child
    }

    fn vertex_points(&self, choice: &Choice, child: &mut Self) -> Vec<u32> {
        let point = |v: usize| {
            choice.vertex[v].then(|| child.add_vertex(self.vertex_tag[v].inherited(), decay(self.vertex_sharpness[v])))
        };
        (0..self.vertex_count()).map(point).map(|point| point.unwrap_or(NONE)).collect()
    }

    fn face_points(&self, choice: &Choice, child: &mut Self) -> Vec<u32> {
        if self.rules.scheme.split() == SplitKind::Triangles {
            return Vec::new();
        }
        let touched = |f: usize| self.corners(f).any(|c| choice.vertex[self.vertex[c] as usize]);
        let point = |f: usize| {
            let tag = VertexTag { extraordinary: self.corners(f).len() != 4, ..VertexTag::default() };
            if touched(f) { child.add_vertex(tag, 0.0) } else { NONE }
        };
        (0..self.face_count()).map(point).collect()
    }

    fn edge_points(&self, choice: &Choice, child: &mut Self) -> Vec<u32> {
        let point = |e: usize| {
            let touched = self.edge_ends[e].iter().any(|&v| choice.vertex[v as usize]);
            let tag = VertexTag::on_edge(self.edge_flags[e], self.edge_sharpness[e] >= INFINITE_SHARPNESS);
            if touched { child.add_vertex(tag, 0.0) } else { NONE }
        };
        (0..self.edge_ends.len()).map(point).collect()
    }

    /// The halves of edges at chosen vertices, by edge and end.
    fn halve_edges(&self, choice: &Choice, around: &[Around], points: &Points, child: &mut Self) -> Vec<[u32; 2]> {
        let half = |e: usize, end: usize| {
            let v = self.edge_ends[e][end] as usize;
            if !choice.vertex[v] {
                return NONE;
            }
            let (count, sum) = around[v].semi_sharp();
            let s = half_among(self.rules.creasing, self.edge_sharpness[e], count, sum);
            child.add_edge([points.of_edge[e], points.of_vertex[v]], s, self.edge_flags[e])
        };
        let mut half = half;
        (0..self.edge_ends.len()).map(|e| [half(e, 0), half(e, 1)]).collect()
    }

    /// Corners and edges of children are those of `refine/quad_split.rs`.
    fn split_to_quads(&self, choice: &Choice, points: &Points, halves: &[[u32; 2]], child: &mut Self) {
        let mut inside = Vec::new();
        for f in (0..self.face_count()).filter(|&f| points.of_face[f] != NONE && !choice.ends(f)) {
            let corners = self.corners(f);
            let sides = corners.len();
            let is_quad = sides == 4;
            let before = |c: usize| if c == corners.start { corners.end - 1 } else { c - 1 };
            // The edge from each edge point to the face point, where a child needs it.
            inside.clear();
            inside.extend(corners.clone().map(|c| {
                let e = self.edge[c];
                let end = self.vertex[if c + 1 == corners.end { corners.start } else { c + 1 }];
                let needed = [self.vertex[c], end].iter().any(|&v| choice.vertex[v as usize]);
                let ends = [points.of_face[f], points.of_edge[e as usize]];
                if needed { child.add_edge(ends, 0.0, EdgeFlags::default()) } else { NONE }
            }));
            for (i, c) in corners.clone().enumerate().filter(|(_, c)| choice.vertex[self.vertex[*c] as usize]) {
                let p = before(c);
                let (e, e_before) = (self.edge[c] as usize, self.edge[p] as usize);
                let at = if is_quad { i } else { 0 };
                let mut vertices = [
                    points.of_vertex[self.vertex[c] as usize],
                    points.of_edge[e],
                    points.of_face[f],
                    points.of_edge[e_before],
                ];
                let mut edges = [
                    self.half_at(halves, e, self.vertex[c], true),
                    inside[i],
                    inside[(i + sides - 1) % sides],
                    self.half_at(halves, e_before, self.vertex[c], false),
                ];
                let mut sectors = [self.sector[c], 2, 4, 2];
                vertices.rotate_right(at);
                edges.rotate_right(at);
                sectors.rotate_right(at);
                let place = if is_quad {
                    self.place[f].child(i as u32)
                } else {
                    Place { ptex_face: self.place[f].ptex_face + i as u32, ..self.place[f] }
                };
                child.add_face(&vertices, &edges, &sectors, place, choice.face[f]);
            }
        }
    }

    /// Corners and edges of children are those of `refine/tri_split.rs`.
    fn split_to_triangles(&self, choice: &Choice, points: &Points, halves: &[[u32; 2]], child: &mut Self) {
        for f in (0..self.face_count()).filter(|&f| !choice.ends(f)) {
            let c0 = self.first[f] as usize;
            let v: [u32; 3] = std::array::from_fn(|i| self.vertex[c0 + i]);
            let e: [usize; 3] = std::array::from_fn(|i| self.edge[c0 + i] as usize);
            let kept = v.map(|v| choice.vertex[v as usize]);
            if kept == [false; 3] {
                continue;
            }
            let middle = e.iter().any(|&e| choice.edge[e]);
            let point = e.map(|e| points.of_edge[e]);
            // Inside edge c cuts off corner c.
            let inside: [u32; 3] = std::array::from_fn(|c| {
                let ends = [point[c], point[(c + 2) % 3]];
                if kept[c] || middle { child.add_edge(ends, 0.0, EdgeFlags::default()) } else { NONE }
            });
            for c in (0..3).filter(|&c| kept[c]) {
                let before = (c + 2) % 3;
                let mut vertices = [points.of_vertex[v[c] as usize], point[c], point[before]];
                let mut edges =
                    [self.half_at(halves, e[c], v[c], true), inside[c], self.half_at(halves, e[before], v[c], false)];
                let mut sectors = [self.sector[c0 + c], 3, 3];
                vertices.rotate_right(c);
                edges.rotate_right(c);
                sectors.rotate_right(c);
                child.add_face(&vertices, &edges, &sectors, self.place[f].child(c as u32), choice.face[f]);
            }
            if middle {
                let vertices = [point[1], point[2], point[0]];
                let edges = [inside[2], inside[0], inside[1]];
                child.add_face(&vertices, &edges, &[3; 3], self.place[f].child(3), choice.face[f]);
            }
        }
    }

    /// The half of `e` at its end `v`; where both ends are equal, the first half of the side that starts there.
    fn half_at(&self, halves: &[[u32; 2]], e: usize, v: u32, starts: bool) -> u32 {
        let ends = self.edge_ends[e];
        let first = if ends[0] == ends[1] { starts } else { ends[0] == v };
        halves[e][usize::from(!first)]
    }

    fn add_vertex(&mut self, tag: VertexTag, sharpness: f64) -> u32 {
        self.vertex_tag.push(tag);
        self.vertex_sharpness.push(sharpness);
        self.vertex_tag.len() as u32 - 1
    }

    fn add_edge(&mut self, ends: [u32; 2], sharpness: f64, flags: EdgeFlags) -> u32 {
        self.edge_ends.push(ends);
        self.edge_sharpness.push(sharpness);
        self.edge_flags.push(flags);
        self.edge_ends.len() as u32 - 1
    }

    fn add_face(&mut self, vertices: &[u32], edges: &[u32], sectors: &[u8], place: Place, complete: bool) {
        self.vertex.extend_from_slice(vertices);
        self.edge.extend_from_slice(edges);
        self.sector.extend_from_slice(sectors);
        self.first.push(self.vertex.len() as u32);
        self.place.push(place);
        self.complete.push(complete);
    }
}

/// Which elements are refined.
pub(super) struct Choice {
    pub face: Vec<bool>,
    /// Vertices and edges of chosen faces.
    pub vertex: Vec<bool>,
    pub edge: Vec<bool>,
    /// Faces that the next level has, but for those in the middle of incomplete triangles.
    pub faces: usize,
    /// The next level is the deepest.
    pub to_deepest: bool,
}

impl Choice {
    /// True for faces whose children cannot be needed.
    fn ends(&self, f: usize) -> bool {
        self.to_deepest && !self.face[f]
    }
}

/// The vertex of the next level for every vertex, face and edge; `NONE` where it is not needed.
struct Points {
    of_vertex: Vec<u32>,
    of_face: Vec<u32>,
    of_edge: Vec<u32>,
}

/// How many faces lie between the infinitely sharp edges (boundaries are) on both sides of a face's corner; all at the
/// vertex where there are none.
fn sector(t: &Topology, own: HalfEdge) -> u8 {
    let sharp = |e: Edge| t.is_infinitely_sharp(e);
    let mut count = 1u8;
    let mut at = own;
    while !sharp(t.edge(t.prev(at))) {
        match t.turn_left(at) {
            Some(h) if h != own => at = h,
            Some(_) => return count,
            None => break,
        }
        count = count.saturating_add(1);
    }
    at = own;
    while !sharp(t.edge(at)) {
        match t.turn_right(at) {
            Some(h) if h != own => at = h,
            _ => break,
        }
        count = count.saturating_add(1);
    }
    count
}

/// The number of faces at every vertex.
pub(super) fn faces_at_vertices(t: &Topology) -> Vec<u32> {
    let mut count = vec![0; t.vertex_count()];
    t.corners().iter().for_each(|&v| count[Vertex(v).index()] += 1);
    count
}
