//! What refinement does inside a face, as a tree of small linear maps: the points of the face's ring give those of the
//! next level round it, among them the rings of the face's children, and so on.
//!
//! Faces with equal surroundings share a node, on every level, whoever their parents are; so below the first level or two
//! a mesh has a handful of nodes, of which quads on a regular grid are one. All weights are those of [`mask`](crate::mask).
//! A *tile* is a node together with the number of levels that are still to come below it.

use super::compose::{Placed, cells_of, corners};
use super::face_rings::Distinct;
use super::plain::{is_plain, plain_ring};
use super::refined;
use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::mask::{Mask, edge_mask, vertex_mask};
use crate::mesh::ControlMesh;
use crate::scheme::{Scheme, SplitKind};
use crate::tags::{Creasing, INFINITE_SHARPNESS, Tags};
use crate::topology::{Cutter, Interpolation, NONE, Surroundings, Topology, Walk};
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::{Mutex, PoisonError};

/// Nodes a thread takes at a time. Fixed, so that nodes get the same numbers for any number of threads.
const CHUNK: usize = 16;

/// The trees of some faces, tier by tier: tier `d` is `d` levels below the faces.
pub(crate) struct TileTrees {
    pub tiers: Vec<Vec<Node>>,
    /// Coefficients of one refinement step of a regular grid, along one axis.
    pub regular: RegularStep,
}

/// One step of refinement, or two where no more are to come.
#[derive(Debug, PartialEq)]
pub(crate) struct Node {
    /// Number of points of the ring.
    pub ring: usize,
    /// The refined points over the ring.
    pub points: Rows,
    pub children: Vec<Child>,
    /// All vertices of the tile over the refined points, where two steps are to come; there are no children then.
    pub cells: Option<Rows>,
}

/// Sparse rows of weights; a row may name a point several times.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Rows {
    ends: Vec<u32>,
    terms: Vec<(u32, f64)>,
}

impl Rows {
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    pub fn terms(&self, row: usize) -> &[(u32, f64)] {
        let start = if row == 0 { 0 } else { self.ends[row - 1] };
        &self.terms[start as usize..self.ends[row] as usize]
    }

    fn push(&mut self, terms: impl Iterator<Item = (u32, f64)>) {
        self.terms.extend(terms);
        self.ends.push(self.terms.len() as u32);
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.ends[..]) + size_of_val(&self.terms[..])
    }
}

/// A child of a node.
#[derive(Debug, PartialEq)]
pub(crate) struct Child {
    pub kind: ChildKind,
    /// Its ring, or corners, among the refined points.
    pub ring: Box<[u32]>,
}

/// How a child goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ChildKind {
    /// As a node of the next tier.
    Node(u32),
    /// As a regular grid: a quad with four plain corners; its ring is that of [`plain_ring`].
    Regular,
    /// No more: its ring is its corners.
    Corners,
}

impl Node {
    /// True where the face is one tile; otherwise each child is one.
    pub fn is_tile(&self) -> bool {
        self.cells.is_some() || self.children.len() == 4
    }

    fn bytes(&self) -> usize {
        let children: usize = self.children.iter().map(|c| size_of::<Child>() + 4 * c.ring.len()).sum();
        self.points.bytes() + self.cells.as_ref().map_or(0, Rows::bytes) + children
    }
}

/// Refinement of a regular grid is the same along both axes, one after the other: from four points in a row at −1, 0, 1, 2
/// to five at −½, 0, ½, 1, 1½.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RegularStep(pub [[f64; 4]; 5]);

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

impl TileTrees {
    /// A topology whose edges and vertices of a sharpness that outlasts `levels` steps are infinitely sharp, which changes
    /// nothing on the way and makes more faces alike; none where it would be the same one.
    pub fn sharpened(t: &Topology, levels: u32) -> Option<Topology> {
        let outlasts = |s: f64| s > f64::from(levels) && s < INFINITE_SHARPNESS;
        // Chaikin's averages leave infinitely sharp edges out; across seams, too, they are sharpnesses that count.
        let is_uniform = t.rules.creasing == Creasing::Uniform && t.foreign_sharpness.is_empty();
        if !is_uniform || !t.edge_sharpness.distinct().chain(t.vertex_sharpness.distinct()).any(outlasts) {
            return None;
        }
        let mut t = t.clone();
        for column in [&mut t.edge_sharpness, &mut t.vertex_sharpness] {
            column.change_values(|s| if outlasts(s) { INFINITE_SHARPNESS } else { s });
        }
        Some(t)
    }

    /// The trees of some faces of a mesh, `levels` steps deep, in parallel. The root of the i-th face is node `i` of tier 0.
    pub fn compile(t: &Topology, scheme: Scheme, faces: &[Face], levels: u32) -> Self {
        let regular = RegularStep::of(scheme, t.interpolation);
        let mut source = Source { t: Cow::Borrowed(t), faces: faces.to_vec() };
        let mut tiers = Vec::new();
        for left in (1..=levels).rev() {
            // The last refinement needs no topology, but its points' masks.
            if left > 1 {
                source = source.reduced();
            }
            let fine = (left > 1).then(|| refined(&source.t, scheme));
            let compiler = Compiler { t: &source.t, fine: fine.as_ref(), scheme, left };
            let (nodes, faces) = compiler.nodes(&source.faces);
            tiers.push(nodes);
            if let Some(fine) = fine {
                source = Source { t: Cow::Owned(fine), faces };
            }
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

/// The faces that nodes of one tier are made for, one for each, and a topology that holds their surroundings.
struct Source<'a> {
    t: Cow<'a, Topology>,
    faces: Vec<Face>,
}

impl Source<'_> {
    /// Without what does not surround the faces, where that is much.
    fn reduced(self) -> Self {
        // Nine faces lie round most quads.
        if 18 * self.faces.len() > self.t.face_count() {
            return self;
        }
        let t = &*self.t;
        let (mut walk, mut around) = (Walk::default(), Surroundings::default());
        let (mut part, mut own) = (Surroundings::default(), 0);
        let mut number = vec![NONE; t.face_count()];
        let mut is_listed = vec![false; t.vertex_count()];
        for &f in &self.faces {
            for &v in t.face_vertices(f) {
                if !std::mem::replace(&mut is_listed[v as usize], true) {
                    part.ring.push(v);
                }
            }
        }
        own += part.ring.len();
        for &f in &self.faces {
            t.surroundings(f, 0, &mut walk, &mut around);
            for g in around.faces.iter().map(|&h| t.face(HalfEdge(h))) {
                if number[g.index()] == NONE {
                    number[g.index()] = part.faces.len() as u32;
                    part.faces.push(t.first(g));
                }
            }
            for &v in &around.ring {
                if !std::mem::replace(&mut is_listed[v as usize], true) {
                    part.ring.push(v);
                }
            }
        }
        let faces = self.faces.iter().map(|f| Face(number[f.index()])).collect();
        Self { t: Cow::Owned(Cutter::part(t, &part, own)), faces }
    }
}

/// Makes the nodes of one tier.
struct Compiler<'a> {
    t: &'a Topology,
    /// One level down; none where that is the last one.
    fine: Option<&'a Topology>,
    scheme: Scheme,
    /// Levels from here to the last one.
    left: u32,
}

/// The nodes of some faces, those of their children numbered within the chunk.
struct Compiled {
    nodes: Vec<Node>,
    /// Distinct keys of children in order of appearance, each with its first face.
    new: Vec<(Box<[u32]>, Face)>,
}

/// Memory that is used again and again.
#[derive(Default)]
struct Scratch {
    walk: Walk,
    around: Surroundings,
    fine_walk: Walk,
    mask: Mask,
    /// Position in the ring, by vertex.
    ring_slot: Vec<u32>,
    /// Position among the refined points, by vertex one level down.
    point_slot: Vec<u32>,
    points: Vec<u32>,
    point: Vec<(u32, f64)>,
}

impl Compiler<'_> {
    /// Nodes of some faces in order, and the first face of every group of children.
    fn nodes(&self, faces: &[Face]) -> (Vec<Node>, Vec<Face>) {
        let pool = Mutex::new(Vec::new());
        let lock = || pool.lock().unwrap_or_else(PoisonError::into_inner);
        let chunks: Vec<Compiled> = faces
            .par_chunks(CHUNK)
            .map(|faces| {
                let mut scratch = lock().pop().unwrap_or_else(|| Scratch {
                    ring_slot: vec![NONE; self.t.vertex_count()],
                    point_slot: vec![NONE; Parent::count(self.t, self.scheme)],
                    ..Scratch::default()
                });
                let (mut known, mut new) = (Distinct::default(), Vec::new());
                let nodes = faces.iter().map(|&f| self.node(f, &mut known, &mut new, &mut scratch)).collect();
                lock().push(scratch);
                Compiled { nodes, new }
            })
            .collect();
        let (mut nodes, mut children, mut known) = (Vec::with_capacity(faces.len()), Vec::new(), Distinct::default());
        for Compiled { nodes: mut compiled, new } in chunks {
            let mut renumber = Vec::with_capacity(new.len());
            for (key, face) in new {
                let (number, is_new) = known.number_owned(key);
                renumber.push(number);
                children.extend(is_new.then_some(face));
            }
            for child in compiled.iter_mut().flat_map(|node| &mut node.children) {
                if let ChildKind::Node(number) = &mut child.kind {
                    *number = renumber[*number as usize];
                }
            }
            nodes.append(&mut compiled);
        }
        (nodes, children)
    }

    fn node(
        &self,
        f: Face,
        known: &mut Distinct<Box<[u32]>>,
        new: &mut Vec<(Box<[u32]>, Face)>,
        scratch: &mut Scratch,
    ) -> Node {
        let t = self.t;
        t.surroundings(f, 0, &mut scratch.walk, &mut scratch.around);
        scratch.around.ring.iter().zip(0..).for_each(|(&v, slot)| scratch.ring_slot[v as usize] = slot);
        let ring = std::mem::take(&mut scratch.around.ring);

        let split = self.scheme.split();
        let mut faces = faces_within(t, split, f);
        let (mut children, mut cells) = (Vec::new(), None);
        match self.fine {
            Some(fine) if self.left == 2 && faces.len() == 4 => cells = Some(self.cells(fine, faces, scratch)),
            Some(fine) => {
                children.extend(faces.map(|child| Self::child(fine, self.scheme, child, known, new, scratch)));
            }
            None => children.extend(faces.by_ref().map(|child| {
                let corners = child_corners(t, split, f, child);
                Child { kind: ChildKind::Corners, ring: scratch.slots(&corners) }
            })),
        }
        let asked = std::mem::take(&mut scratch.points);
        let mut points = Rows::default();
        for &v in &asked {
            scratch.point_slot[v as usize] = NONE;
            scratch.point.clear();
            let parent = Parent::of(t, self.scheme, v);
            refined_point(t, self.scheme, parent, &mut scratch.mask, &mut scratch.point);
            points.push(scratch.point.iter().map(|&(v, w)| (scratch.ring_slot[v as usize], w)));
        }
        let node = Node { ring: ring.len(), points, children, cells };
        (scratch.points, scratch.around.ring) = (asked, ring);
        scratch.points.clear();
        node
    }

    /// All vertices two levels down of a face with four children, over the points one level down.
    fn cells(&self, fine: &Topology, children: impl Iterator<Item = Face>, scratch: &mut Scratch) -> Rows {
        let split = self.scheme.split();
        let whole = Placed::alone(4);
        let mut vertex = [NONE; 25];
        for (c, child) in children.enumerate() {
            for (g, grandchild) in faces_within(fine, split, child).enumerate() {
                let at = whole.child(split, 4, c).child(split, 2, g);
                let names = child_corners(fine, split, child, grandchild);
                corners(split).iter().zip(names).for_each(|(&(i, j), v)| vertex[at.cell(i, j)] = v);
            }
        }
        let mut rows = Rows::default();
        for (i, j) in cells_of(split, 4) {
            let mut point = std::mem::take(&mut scratch.point);
            point.clear();
            let parent = Parent::of(fine, self.scheme, vertex[whole.cell(i, j)]);
            refined_point(fine, self.scheme, parent, &mut scratch.mask, &mut point);
            rows.push(point.iter().map(|&(v, w)| (scratch.slot(v), w)));
            scratch.point = point;
        }
        rows
    }

    fn child(
        t: &Topology,
        scheme: Scheme,
        face: Face,
        known: &mut Distinct<Box<[u32]>>,
        new: &mut Vec<(Box<[u32]>, Face)>,
        scratch: &mut Scratch,
    ) -> Child {
        let is_regular =
            scheme.split() == SplitKind::Quads && t.face_vertices(face).iter().all(|&v| is_plain(t, Vertex(v)));
        if is_regular {
            return Child { kind: ChildKind::Regular, ring: scratch.slots(&plain_ring(t, face)) };
        }
        let mut around = std::mem::take(&mut scratch.around);
        t.surroundings(face, 0, &mut scratch.fine_walk, &mut around);
        let (number, is_new) = known.number(&around.key);
        if is_new {
            new.push((around.key.clone().into(), face));
        }
        let ring = scratch.slots(&around.ring);
        scratch.around = around;
        Child { kind: ChildKind::Node(number), ring }
    }
}

impl Scratch {
    /// Positions of vertices one level down among the refined points, which they join.
    fn slots(&mut self, vertices: &[u32]) -> Box<[u32]> {
        vertices.iter().map(|&v| self.slot(v)).collect()
    }

    fn slot(&mut self, v: u32) -> u32 {
        let slot = &mut self.point_slot[v as usize];
        if *slot == NONE {
            *slot = self.points.len() as u32;
            self.points.push(v);
        }
        *slot
    }
}

/// The children of a face.
fn faces_within(t: &Topology, split: SplitKind, f: Face) -> impl ExactSizeIterator<Item = Face> {
    let range = match split {
        SplitKind::Quads => t.first(f)..t.first(f) + t.sides(f) as u32,
        SplitKind::Triangles => 4 * f.0..4 * f.0 + 4,
    };
    (range.start..range.end).map(Face)
}

/// The corners of a child, as the splits number them.
fn child_corners(t: &Topology, split: SplitKind, f: Face, child: Face) -> Vec<u32> {
    let vertices = t.vertex_count() as u32;
    if split == SplitKind::Triangles {
        let corner = child.0 % 4;
        let on_edge = |c: u32| vertices + t.edge(HalfEdge(t.first(f) + c % 3)).0;
        let mut corners = [1, 2, 0].map(on_edge);
        if corner < 3 {
            corners = [0, 1, 2].map(|c| if c == corner { t.face_vertices(f)[c as usize] } else { 0 });
            corners[(corner as usize + 1) % 3] = on_edge(corner);
            corners[(corner as usize + 2) % 3] = on_edge(corner + 2);
        }
        return corners.to_vec();
    }
    let h = HalfEdge(child.0);
    let on_edge = |h: HalfEdge| vertices + t.face_count() as u32 + t.edge(h).0;
    let mut corners = [t.origin(h).0, on_edge(h), vertices + f.0, on_edge(t.prev(h))];
    if t.sides(f) == 4 {
        corners.rotate_right((h.0 - t.first(f)) as usize);
    }
    corners.to_vec()
}
