//! The topology of a face-varying channel: the mesh's own faces, with values in the place of vertices. Faces that agree
//! about the values at both ends of an edge stay joined there; elsewhere runs a seam, which is a boundary of the channel.
//!
//! So a channel is refined and evaluated by the same code as a mesh. What is special to face-varying values is which of
//! them are made sharp (the rules of [`FaceVarying`]), and that happens once, here: rules as in OpenSubdiv 3.7
//! (`vtr/fvarLevel.cpp`, `vtr/fvarRefinement.cpp`).

use super::build::leading_half_edges;
use super::{EdgeFlags, NONE, SharpnessColumn, Topology};
use crate::index::{Edge, HalfEdge, Vertex};
use crate::tags::{Boundary, Creasing, FaceVarying, INFINITE_SHARPNESS};
use std::collections::{BTreeMap, HashMap};

/// How values over a topology are interpolated.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub(crate) enum Interpolation {
    /// By the scheme's rules.
    #[default]
    Smooth,
    /// By the scheme's rules inside, linearly along boundaries, at every level.
    LinearBoundaries,
    /// Linearly everywhere.
    Linear,
}

/// A channel's topology, and which value every one of its vertices holds.
pub(crate) struct ChannelTopology {
    pub topology: Topology,
    /// Vertices `i < value_count` hold value `i`; those beyond hold values that several vertices of the mesh share.
    pub copies: Vec<u32>,
}

impl Topology {
    /// The same tables with linear interpolation.
    pub(crate) fn with_linear_values(&self) -> Topology {
        Topology { interpolation: Interpolation::Linear, ..self.clone() }
    }

    /// The topology of a channel that has value `corners[h]` at the start of half-edge `h`.
    pub(crate) fn channel(&self, value_count: usize, corners: &[u32], rule: FaceVarying) -> ChannelTopology {
        let (origin, copies) = self.channel_vertices(value_count, corners);
        let vertex_count = value_count + copies.len();
        let is_seam = self.seams(&origin);
        let edges = ChannelEdges::new(self, &origin, &is_seam);
        let twin: Vec<u32> =
            (0..origin.len()).map(|h| if is_seam[self.edge[h] as usize] { NONE } else { self.twin[h] }).collect();
        // Values that no corner uses stay as isolated vertices do.
        let mut vertex_sharpness: SharpnessColumn = std::iter::repeat_n(INFINITE_SHARPNESS, vertex_count).collect();
        let mut vertex_non_manifold = vec![true; vertex_count];
        for (&v, &value) in self.origin.iter().zip(&origin) {
            vertex_sharpness.set(value as usize, self.vertex_sharpness.get(v as usize));
            vertex_non_manifold[value as usize] = self.vertex_non_manifold[v as usize];
        }
        let mut channel = Topology {
            vertex_count,
            face_offset: self.face_offset.clone(),
            face: self.face.clone(),
            edge: edges.of_half_edge,
            vertex_half_edge: leading_half_edges(vertex_count, &origin, &twin),
            origin,
            twin,
            edge_vertices: edges.vertices,
            edge_half_edge: edges.half_edge,
            edge_flags: edges.flags,
            edge_sharpness: edges.sharpness,
            vertex_non_manifold,
            vertex_sharpness,
            sharp_offset: Vec::new(),
            sharp_edges: Vec::new(),
            hole: self.hole.clone(),
            rules: self.rules,
            foreign_sharpness: BTreeMap::new(),
            across_seam: BTreeMap::new(),
            interpolation: match rule {
                FaceVarying::All => Interpolation::Linear,
                FaceVarying::Boundaries => Interpolation::LinearBoundaries,
                _ => Interpolation::Smooth,
            },
            far_half: BTreeMap::new(),
            edits: Default::default(),
            fan_sizes: Vec::new(),
        };
        channel.rules.face_varying = rule;
        Sharpener { mesh: self, rule }.sharpen(&mut channel, &is_seam);
        channel.index_sharp_edges();
        ChannelTopology { topology: channel, copies }
    }

    /// The channel's vertex at every corner. A value that two vertices of the mesh use is one vertex of the channel for
    /// each: the second and later ones are appended, with the value that they copy.
    fn channel_vertices(&self, value_count: usize, corners: &[u32]) -> (Vec<u32>, Vec<u32>) {
        let mut user = vec![NONE; value_count];
        let mut further: HashMap<(u32, u32), u32> = HashMap::new();
        let mut copies = Vec::new();
        let mut origin = Vec::with_capacity(corners.len());
        for (&v, &value) in self.origin.iter().zip(corners) {
            let first = &mut user[value as usize];
            if *first == NONE {
                *first = v;
            }
            origin.push(if *first == v {
                value
            } else {
                *further.entry((v, value)).or_insert_with(|| {
                    copies.push(value);
                    (value_count + copies.len() - 1) as u32
                })
            });
        }
        (origin, copies)
    }

    /// Which edges of the mesh are seams: its faces disagree about the value at either end.
    fn seams(&self, value: &[u32]) -> Vec<bool> {
        let at_ends = |h: HalfEdge| {
            let (a, b) = (value[h.index()], value[self.next(h).index()]);
            if self.origin(h) == self.edge_vertices(self.edge(h))[0] { [a, b] } else { [b, a] }
        };
        let mut is_seam = vec![false; self.edge_count()];
        for h in (0..self.half_edge_count() as u32).map(HalfEdge) {
            let e = self.edge(h);
            let first = HalfEdge(self.edge_half_edge[e.index()]);
            if first != h && at_ends(first) != at_ends(h) {
                is_seam[e.index()] = true;
            }
        }
        is_seam
    }
}

/// Edges of a channel: those of the mesh in order, a seam once for each of its faces.
struct ChannelEdges {
    of_half_edge: Vec<u32>,
    vertices: Vec<[u32; 2]>,
    half_edge: Vec<u32>,
    flags: Vec<EdgeFlags>,
    sharpness: SharpnessColumn,
}

impl ChannelEdges {
    fn new(mesh: &Topology, origin: &[u32], is_seam: &[bool]) -> Self {
        let mut sides = vec![0u32; mesh.edge_count()];
        for &e in &mesh.edge {
            sides[e as usize] = if is_seam[e as usize] { sides[e as usize] + 1 } else { 1 };
        }
        let mut next = 0u32;
        let mut first = sides;
        for count in &mut first {
            next += std::mem::replace(count, next);
        }
        let count = next as usize;
        let mut out = Self {
            of_half_edge: Vec::with_capacity(origin.len()),
            vertices: vec![[0; 2]; count],
            half_edge: vec![NONE; count],
            flags: vec![EdgeFlags::default(); count],
            sharpness: SharpnessColumn::smooth(count),
        };
        for h in (0..origin.len() as u32).map(HalfEdge) {
            let old = mesh.edge(h).index();
            let new = first[old] as usize;
            if is_seam[old] {
                first[old] += 1;
                out.flags[new] = EdgeFlags { boundary: true, non_manifold: false };
                out.sharpness.set(new, INFINITE_SHARPNESS);
            } else {
                out.flags[new] = mesh.edge_flags[old];
                out.sharpness.set(new, mesh.edge_sharpness.get(old));
            }
            if out.half_edge[new] == NONE {
                out.half_edge[new] = h.0;
                let (a, b) = (origin[h.index()], origin[mesh.next(h).index()]);
                let forward = is_seam[old] || mesh.origin(h) == mesh.edge_vertices(Edge(old as u32))[0];
                out.vertices[new] = if forward { [a, b] } else { [b, a] };
            }
            out.of_half_edge.push(new as u32);
        }
        out
    }
}

/// One value at a vertex with a seam: the faces that share it.
#[derive(Default)]
struct Span {
    value: u32,
    faces: u32,
    /// Faces of the fan that starts at the value's leading half-edge.
    fan_faces: u32,
    /// Sharpness of the edges between these faces that is not zero.
    sharp: Vec<f64>,
}

impl Span {
    fn is_torn(&self) -> bool {
        self.faces != self.fan_faces
    }

    fn has_infinite(&self) -> bool {
        self.sharp.iter().any(|&s| s >= INFINITE_SHARPNESS)
    }
}

/// Makes values sharp as the channel's rule has it.
struct Sharpener<'a> {
    mesh: &'a Topology,
    rule: FaceVarying,
}

impl Sharpener<'_> {
    fn sharpen(&self, channel: &mut Topology, is_seam: &[bool]) {
        let mut corners = self.corners_at_seams(channel, is_seam);
        corners.sort_unstable();
        for corners in corners.chunk_by(|a, b| a.0 == b.0) {
            let v = Vertex(corners[0].0);
            let spans = spans(channel, corners);
            let pinned = self.mesh.vertex_non_manifold[v.index()] || self.sharpens_all(&spans, v);
            for span in &spans {
                let value = span.value as usize;
                channel.vertex_non_manifold[value] = self.mesh.vertex_non_manifold[v.index()] || span.is_torn();
                let lonely = span.faces == 1 && self.rule != FaceVarying::None;
                if pinned || lonely || span.is_torn() || span.has_infinite() {
                    channel.vertex_sharpness.set(value, INFINITE_SHARPNESS);
                }
            }
            self.bind(channel, v, &spans, pinned);
        }
    }

    /// Face corners, as (vertex, value, half-edge), at vertices whose values do not follow the vertex's own rule.
    fn corners_at_seams(&self, channel: &Topology, is_seam: &[bool]) -> Vec<(u32, u32, u32)> {
        let mesh = self.mesh;
        let mut differs = vec![false; mesh.vertex_count()];
        for (e, _) in is_seam.iter().enumerate().filter(|(_, seam)| **seam) {
            mesh.edge_vertices[e].iter().for_each(|&v| differs[v as usize] = true);
        }
        // A bow-tie may have several values and no seam.
        let mut value = vec![NONE; mesh.vertex_count()];
        for (&v, &own) in mesh.origin.iter().zip(&channel.origin) {
            let first = &mut value[v as usize];
            differs[v as usize] |= *first != NONE && *first != own;
            *first = own;
        }
        // Rounded corners of the mesh are not rounded in the channel, but by one rule.
        if mesh.rules.boundary != Boundary::EdgeAndCorner && self.rule != FaceVarying::None {
            let faces = mesh.faces_per_vertex();
            (0..mesh.vertex_count()).filter(|&v| faces[v] == 1).for_each(|v| differs[v] = true);
        }
        let corners = mesh.origin.iter().zip(&channel.origin).enumerate();
        corners.filter(|(_, (v, _))| differs[**v as usize]).map(|(h, (&v, &own))| (v, own, h as u32)).collect()
    }

    /// True where every value at the vertex is sharp.
    fn sharpens_all(&self, spans: &[Span], v: Vertex) -> bool {
        let plus2 = self.rule == FaceVarying::CornersPlus2;
        if !plus2 && self.rule != FaceVarying::CornersPlus1 {
            return false;
        }
        match spans {
            // A seam ends here.
            [_] => plus2 && !self.mesh.sharp_edges(v).iter().any(|&e| self.mesh.is_boundary(Edge(e))),
            [a, b] => {
                let disturbed = |s: &Span| s.has_infinite() || s.is_torn() || (plus2 && s.faces == 1);
                disturbed(a) || disturbed(b)
            }
            _ => true,
        }
    }

    /// Hands on what lies beyond the seam: sharpness that a value depends on, and that Chaikin's averages take in.
    fn bind(&self, channel: &mut Topology, v: Vertex, spans: &[Span], pinned: bool) {
        let plus = matches!(self.rule, FaceVarying::CornersPlus1 | FaceVarying::CornersPlus2);
        let depends = plus && spans.len() == 2 && !pinned;
        let chaikin = self.mesh.rules.creasing == Creasing::Chaikin;
        let is_finite = |s: &f64| *s > 0.0 && *s < INFINITE_SHARPNESS;
        for (i, span) in spans.iter().enumerate() {
            let mut bound = Vec::new();
            if depends && !span.sharp.iter().any(is_finite) {
                bound = spans[1 - i].sharp.iter().copied().filter(is_finite).collect();
            }
            if chaikin {
                let own: Vec<f64> = span.sharp.iter().chain(&bound).copied().filter(is_finite).collect();
                let all = self.mesh.sharp_edges(v).iter().map(|&e| self.mesh.edge_sharpness(Edge(e))).filter(is_finite);
                let others = without(all.collect(), &own);
                if !others.is_empty() {
                    channel.across_seam.insert(span.value, others);
                }
            }
            if !bound.is_empty() {
                channel.foreign_sharpness.insert(span.value, bound);
            }
        }
    }
}

/// `all` less one entry for each of `own`.
fn without(mut all: Vec<f64>, own: &[f64]) -> Vec<f64> {
    for s in own {
        if let Some(at) = all.iter().position(|x| x == s) {
            all.remove(at);
        }
    }
    all
}

/// The values at one vertex, from its corners (vertex, value, half-edge) in ascending order.
fn spans(channel: &Topology, corners: &[(u32, u32, u32)]) -> Vec<Span> {
    let span = |corners: &[(u32, u32, u32)]| {
        let value = Vertex(corners[0].1);
        let edge = |h: u32| channel.edge(HalfEdge(h));
        let sharp = corners
            .iter()
            .filter(|c| channel.twin(HalfEdge(c.2)).is_some())
            .map(|c| channel.edge_sharpness(edge(c.2)))
            .filter(|&s| s > 0.0)
            .collect();
        Span { value: value.0, faces: corners.len() as u32, fan_faces: channel.fan_faces(value), sharp }
    };
    corners.chunk_by(|a, b| a.1 == b.1).map(span).collect()
}
