//! What refinement does inside a face, as a tree of small linear maps: the points of the face's ring give those of the
//! next level round it, among them the rings of the face's children, and so on.
//!
//! Faces with equal surroundings share a node, on every level, whoever their parents are; so below the first level or two
//! a mesh has a handful of nodes, of which quads on a regular grid are one. All weights are those of [`mask`](crate::mask).
//! A *tile* is a node together with the number of levels that are still to come below it.

use super::face_rings::Distinct;
use super::plain::{is_plain, plain_ring};
use super::refined;
use crate::index::{Edge, Face, Vertex};
use crate::mask::{Mask, edge_mask, vertex_mask};
use crate::mesh::ControlMesh;
use crate::scheme::{Scheme, SplitKind};
use crate::tags::Tags;
use crate::topology::{Cutter, Interpolation, NONE, Surroundings, Topology, Walk};
use rayon::prelude::*;

/// Nodes a thread takes at a time. Fixed, so that nodes get the same numbers for any number of threads.
const CHUNK: usize = 16;

/// The trees of some faces, tier by tier: tier `d` is `d` levels below the faces.
pub(super) struct TileTrees {
    pub tiers: Vec<Vec<Node>>,
    /// Coefficients of one refinement step of a regular grid, along one axis.
    pub regular: RegularStep,
}

/// One step of refinement.
#[derive(Debug, PartialEq)]
pub(super) struct Node {
    /// Number of points of the ring.
    pub ring: usize,
    /// By refined point: end of its terms.
    term_end: Vec<u32>,
    /// Positions in the ring with their weights.
    terms: Vec<(u32, f64)>,
    pub children: Vec<Child>,
}

/// A child of a node.
#[derive(Debug, PartialEq)]
pub(super) struct Child {
    pub kind: ChildKind,
    /// Its ring, or corners, among the refined points.
    pub ring: Box<[u32]>,
}

/// How a child goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ChildKind {
    /// As a node of the next tier.
    Node(u32),
    /// As a regular grid: a quad with four plain corners, its ring that of [`plain_ring`].
    Regular,
    /// No more: its ring is its corners.
    Corners,
}

impl Node {
    /// Number of refined points.
    pub fn points(&self) -> usize {
        self.term_end.len()
    }

    /// Terms of a refined point.
    pub fn terms(&self, point: usize) -> &[(u32, f64)] {
        let start = if point == 0 { 0 } else { self.term_end[point - 1] };
        &self.terms[start as usize..self.term_end[point] as usize]
    }

    fn bytes(&self) -> usize {
        let children: usize = self.children.iter().map(|c| size_of::<Child>() + 4 * c.ring.len()).sum();
        4 * self.term_end.len() + size_of_val(&self.terms[..]) + children
    }
}

/// Refinement of a regular grid is the same along both axes, one after the other: from four points in a row at −1, 0, 1, 2
/// to five at −½, 0, ½, 1, 1½.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RegularStep(pub [[f64; 4]; 5]);

impl RegularStep {
    /// Read off the mask of one edge of a regular grid: along the edge it is that of a new point between two old ones,
    /// across the edge that of an old one.
    fn of(scheme: Scheme, interpolation: Interpolation) -> Self {
        let quad = |i: u32| [i, i + 1, i + 5, i + 4];
        let faces: Vec<[u32; 4]> = (0..3).flat_map(|j| (0..3).map(move |i| quad(4 * j + i))).collect();
        let mesh = ControlMesh::new(&faces, Tags::default()).expect("a grid is a mesh");
        let mut t = Topology::new(&mesh).expect("a grid has no creases");
        t.interpolation = interpolation;
        // The first edge of the face in the middle runs from 5 to 6.
        let mut point = Vec::new();
        let e = t.edge(t.half_edge(Face(4), 0));
        refined_point(&t, scheme, Parent::Edge(e), &mut Mask::default(), &mut point);
        let sum =
            |is_there: &dyn Fn(u32) -> bool| point.iter().filter(|term| is_there(term.0)).map(|term| term.1).sum();
        let edge: [f64; 4] = std::array::from_fn(|x| sum(&|v| v as usize % 4 == x));
        let vertex: [f64; 4] = std::array::from_fn(|y| sum(&|v| v as usize / 4 == y));
        let place = |weights: &[f64], first: usize| {
            let mut row = [0.0; 4];
            row[first..first + weights.len()].copy_from_slice(weights);
            row
        };
        let (edge, vertex) = (&edge[1..3], &vertex[..3]);
        Self([place(edge, 0), place(vertex, 0), place(edge, 1), place(vertex, 1), place(edge, 2)])
    }

    /// Coefficients of the `2^levels + 1` points between 0 and 1 after so many steps.
    pub fn repeated(&self, levels: u32) -> Vec<[f64; 4]> {
        if levels == 0 {
            return vec![[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        }
        let finer = self.repeated(levels - 1);
        let half = |first: usize, row: &[f64; 4]| -> [f64; 4] {
            std::array::from_fn(|x| (0..4).map(|k| row[k] * self.0[first + k][x]).sum())
        };
        let left = finer.iter().map(|row| half(0, row));
        left.chain(finer[1..].iter().map(|row| half(1, row))).collect()
    }
}

/// What a refined point belongs to.
#[derive(Clone, Copy)]
enum Parent {
    Vertex(Vertex),
    Face(Face),
    Edge(Edge),
}

impl Parent {
    /// Of vertex `v` of the next level.
    fn of(t: &Topology, scheme: Scheme, v: u32) -> Self {
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
fn refined_point(t: &Topology, scheme: Scheme, parent: Parent, mask: &mut Mask, terms: &mut Vec<(u32, f64)>) {
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

impl TileTrees {
    /// The trees of some faces of a mesh, `levels` steps deep, in parallel. The root of the i-th face is node `i` of tier 0.
    pub fn compile(t: &Topology, scheme: Scheme, faces: &[Face], levels: u32) -> Self {
        let regular = RegularStep::of(scheme, t.interpolation);
        let cut = |f: &Face, walk: &mut Walk, around: &mut Surroundings, cutter: &mut Cutter| {
            t.surroundings(*f, 0, walk, around);
            cutter.cut_out(t, around, walk);
            cutter.take()
        };
        let mut sources: Vec<Topology> = faces
            .par_iter()
            .map_init(Default::default, |(walk, around, cutter), f| cut(f, walk, around, cutter))
            .collect();
        let mut tiers = Vec::new();
        for left in (1..=levels).rev() {
            let chunks: Vec<Compiled> =
                sources.par_chunks(CHUNK).map(|chunk| Compiled::of_chunk(chunk, scheme, left)).collect();
            sources = Vec::new();
            let (mut nodes, mut known) = (Vec::new(), Distinct::default());
            for Compiled { nodes: mut compiled, new } in chunks {
                let mut renumber = Vec::with_capacity(new.len());
                for (key, source) in new {
                    let (number, is_new) = known.number_owned(key);
                    renumber.push(number);
                    sources.extend(is_new.then_some(source));
                }
                for child in compiled.iter_mut().flat_map(|node| &mut node.children) {
                    if let ChildKind::Node(number) = &mut child.kind {
                        *number = renumber[*number as usize];
                    }
                }
                nodes.append(&mut compiled);
            }
            tiers.push(nodes);
        }
        Self { tiers, regular }
    }

    /// Number of nodes of all tiers.
    pub fn nodes(&self) -> usize {
        self.tiers.iter().map(Vec::len).sum()
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        let node = |node: &Node| size_of::<Node>() + node.bytes();
        self.tiers.iter().flatten().map(node).sum()
    }
}

/// The nodes of some faces, those of their children numbered within the chunk.
struct Compiled {
    nodes: Vec<Node>,
    /// Distinct keys of children in order of appearance, each with the child's surroundings.
    new: Vec<(Box<[u32]>, Topology)>,
}

impl Compiled {
    fn of_chunk(sources: &[Topology], scheme: Scheme, left: u32) -> Self {
        let mut compiler = Compiler {
            scheme,
            left,
            known: Distinct::default(),
            new: Vec::new(),
            walk: Walk::default(),
            cutter: Cutter::default(),
            around: Surroundings::default(),
            mask: Mask::default(),
        };
        let nodes = sources.iter().map(|source| compiler.node(source)).collect();
        Self { nodes, new: compiler.new }
    }
}

struct Compiler {
    scheme: Scheme,
    /// Levels from the nodes to the last one.
    left: u32,
    known: Distinct<Box<[u32]>>,
    new: Vec<(Box<[u32]>, Topology)>,
    walk: Walk,
    cutter: Cutter,
    around: Surroundings,
    mask: Mask,
}

impl Compiler {
    /// The node of face 0 of a small topology whose vertices are the face's ring.
    fn node(&mut self, t: &Topology) -> Node {
        let fine = refined(t, self.scheme);
        let count = match self.scheme.split() {
            SplitKind::Quads => t.sides(Face(0)),
            SplitKind::Triangles => 4,
        };
        let mut slots = Slots { of: vec![NONE; fine.vertex_count()], points: Vec::new() };
        let children = (0..count as u32).map(|f| self.child(&fine, Face(f), &mut slots)).collect();
        let (mut terms, mut term_end) = (Vec::new(), Vec::with_capacity(slots.points.len()));
        for &v in &slots.points {
            refined_point(t, self.scheme, Parent::of(t, self.scheme, v), &mut self.mask, &mut terms);
            term_end.push(terms.len() as u32);
        }
        Node { ring: t.vertex_count(), term_end, terms, children }
    }

    fn child(&mut self, t: &Topology, face: Face, slots: &mut Slots) -> Child {
        if self.left == 1 {
            return Child { kind: ChildKind::Corners, ring: slots.of_all(t.face_vertices(face)) };
        }
        let is_regular =
            self.scheme.split() == SplitKind::Quads && t.face_vertices(face).iter().all(|&v| is_plain(t, Vertex(v)));
        if is_regular {
            return Child { kind: ChildKind::Regular, ring: slots.of_all(&plain_ring(t, face)) };
        }
        t.surroundings(face, 0, &mut self.walk, &mut self.around);
        let (number, is_new) = self.known.number(&self.around.key);
        if is_new {
            self.cutter.cut_out(t, &self.around, &self.walk);
            self.new.push((self.around.key.clone().into(), self.cutter.take()));
        }
        Child { kind: ChildKind::Node(number), ring: slots.of_all(&self.around.ring) }
    }
}

/// The refined points that children need, in the order in which they ask for them.
struct Slots {
    /// By vertex of the refined topology.
    of: Vec<u32>,
    points: Vec<u32>,
}

impl Slots {
    fn of_all(&mut self, vertices: &[u32]) -> Box<[u32]> {
        let mut slot = |v: u32| {
            let slot = &mut self.of[v as usize];
            if *slot == NONE {
                *slot = self.points.len() as u32;
                self.points.push(v);
            }
            *slot
        };
        vertices.iter().map(|&v| slot(v)).collect()
    }
}
