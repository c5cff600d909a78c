//! What refinement does inside a face, as a tree of small linear maps: the points of the face's ring give those of the
//! next level round it, among them the rings of the face's children, and so on.
//!
//! Faces with equal surroundings share a node, on every level, whoever their parents are; so below the first level or two
//! a mesh has a handful of nodes, of which quads on a regular grid are one. All weights are those of [`mask`](crate::mask).
//! A *tile* is a node together with the number of levels that are still to come below it.

use super::compile::{Compiler, Source};
use super::refined;
use super::refined_point::{Parent, refined_point};
use crate::index::Face;
use crate::mask::Mask;
use crate::mesh::ControlMesh;
use crate::scheme::Scheme;
use crate::tags::{Creasing, INFINITE_SHARPNESS, Tags};
use crate::topology::{Interpolation, Topology};
use std::borrow::Cow;

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

    pub fn push(&mut self, terms: impl Iterator<Item = (u32, f64)>) {
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
