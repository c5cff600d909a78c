//! A plan: everything that the limit of one face depends on except positions. Faces with equal surroundings share it.
//!
//! Plans are nodes. A node either is a leaf (a bicubic patch, a patch along one semi-sharp crease, or a special vertex with
//! its closed form; under Loop a quartic patch or a special vertex, with any semi-sharp creases on top), or is split into
//! four children by one step of explicit refinement. A child is a node again, with its points as sparse rows over those of
//! its parent; children with equal surroundings are one node, whoever their parents are. So what a crease of sharpness s
//! needs beyond its first levels is made once for a whole mesh, and ways down are at most `⌈sharpness⌉ + 2` nodes long:
//! each level takes one from every finite sharpness, makes all faces quads, and parts special vertices. Only along
//! boundaries that are kept linear are they longer.
//!
//! Finite sharpness counts up to a whole number only, the *raise* (see `topology/raise.rs`): a node stands for all its
//! raises, a plan is a node with a raise, and the way down takes one from the raise at every level. So the end of a crease
//! of sharpness 9.5 has the nodes that one of sharpness 2.5 has: where a raise is left, the node leads back to itself.

mod compile;
mod face_mesh;
mod fan;
mod fan_mesh;
mod grid;
mod grid_weights;
mod leaf;
mod leaf_basis;
mod place_weights;
mod points;
mod pole;
mod refined_points;
mod special_vertices;
mod sub_patches;
mod template;

pub(super) use compile::Numbers;
pub(super) use fan::may_have_fans;
pub(crate) use grid_weights::{GridMaker, GridPoints, GridScratch, GridValues, MOST_RING};
use points::Points;
pub(crate) use pole::AtPole;

use super::box_spline;
use super::bspline::{cubic, tensor};
use super::linear_boundary::LinearEnds;
use super::rows::Rows;
use super::single_crease;
use super::special::{AtVertex, PointWeights, SpecialVertex};
use super::triangle_crease::TriangleCrease;
use super::turn::{turn_back_quad, turn_back_triangle, turned};
use crate::scheme::SplitKind;
pub(crate) use special_vertices::SpecialVertices;
use std::collections::HashSet;
use std::sync::Arc;
pub(crate) use sub_patches::{Cells, KeptCoefficients, PieceMap, Pose, Spot, SubPatch, SubPatches};

/// What kind of patch covers a location.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum PatchKind {
    /// A bicubic B-spline patch, a quartic box-spline patch under Loop, or a bilinear one.
    Regular,
    /// A patch along one semi-sharp crease, in closed form.
    SingleCrease,
    /// A patch at a special vertex, in closed form.
    Special,
}

/// The plans of a mesh, and the nodes that they share.
pub(crate) struct Plans {
    split: SplitKind,
    nodes: Vec<Node>,
    plans: Vec<Link>,
    /// What fast evaluation tabulates of them.
    parts: SubPatches,
}

/// A node, and by how much all finite sharpness there is higher than in the node.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
struct Link {
    node: u32,
    raise: u8,
}

struct Node {
    /// Number of control points.
    ring: usize,
    body: Body,
}

enum Body {
    Leaf(Leaf),
    Split(Split),
}

/// One step of refinement.
struct Split {
    /// The refined points that some child needs, over those of the node.
    points: Points,
    children: [Child; 4],
    /// All four, or of a face that is no quad one: the sub-face at the first corner, which has the same parameters.
    count: u8,
    /// What ends the way along a boundary that is kept linear.
    ends: Option<Box<LinearEnds>>,
}

#[derive(Clone, Copy)]
struct Child {
    /// Where to go from the node as it is, and from the node raised by 1. Every further raise is passed on. Nodes and raises are
    /// kept apart, so that they take less room.
    nodes: [u32; 2],
    raises: [u8; 2],
    /// Which corner of the child is the node's corner 0.
    turn: u8,
    /// Which of the children it is.
    number: u8,
}

struct Leaf {
    shape: LeafShape,
    /// The leaf's control points over the node's, the creases' bends last.
    points: Arc<Rows>,
    /// Number of points without bends.
    patch_points: usize,
    /// Semi-sharp creases under Loop, which the shape takes for infinitely sharp.
    creases: Vec<TriangleCrease>,
}

enum LeafShape {
    /// The face's own corners, bilinear in a quad and linear in a triangle.
    Linear,
    /// Sixteen points in the order of [`bspline`](super::bspline), or twelve in that of
    /// [`box_spline`](super::box_spline).
    Regular,
    /// Sixteen points turned so that the crease runs along v = 1, between corners `turn + 2` and `turn + 3`.
    SingleCrease {
        turn: u8,
        /// To which the raise is to be added.
        sharpness: f64,
    },
    /// Points of a special vertex at corner `turn`.
    Special { turn: u8, vertex: Arc<SpecialVertex> },
}

impl Plans {
    /// Number of plans of faces.
    pub fn len(&self) -> usize {
        self.plans.len()
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    pub fn get(&self, plan: usize) -> Plan<'_> {
        Plan { plans: self, number: plan, start: self.plans[plan] }
    }

    /// What evaluation has tabulated.
    pub fn sub_patches(&self) -> &SubPatches {
        &self.parts
    }

    /// Heap memory in bytes, shared special vertices and what evaluation tabulates left out.
    pub fn bytes(&self) -> usize {
        // What nodes share is counted once.
        let mut met = HashSet::new();
        let mut once = |of: *const u8, bytes: usize| if met.insert(of) { bytes } else { 0 };
        let body = |node: &Node| match &node.body {
            Body::Leaf(leaf) => {
                let points = size_of::<Rows>() + leaf.points.bytes();
                once(Arc::as_ptr(&leaf.points).cast(), points) + size_of_val(&leaf.creases[..])
            }
            Body::Split(split) => {
                let ends = split.ends.as_ref().map_or(0, |ends| size_of::<LinearEnds>() + ends.bytes());
                split.points.bytes(&mut once) + ends
            }
        };
        let lists = self.nodes.capacity() * size_of::<Node>() + self.plans.capacity() * size_of::<Link>();
        self.nodes.iter().map(body).sum::<usize>() + lists
    }
}

/// A place on the way down from a face to a leaf.
#[derive(Clone, Copy)]
struct Place {
    u: f64,
    v: f64,
    /// Which corner of the face is the node's corner 0.
    turn: u8,
    depth: u32,
    /// Of the node.
    raise: u8,
    /// Parameters here per face parameter; negative in triangles that are turned upside down.
    speed: f64,
}

impl Place {
    #[inline]
    fn turned(self, split: SplitKind, turn: u8) -> (f64, f64) {
        turned(split, self.u, self.v, turn)
    }

    /// The corner of the plan that is nearest, and its number in the ring.
    fn nearest_corner(self, split: SplitKind) -> usize {
        let (a, b) = self.turned(split, self.turn);
        match (split, a >= 0.5, b >= 0.5) {
            (_, false, false) => 0,
            (_, true, false) | (SplitKind::Triangles, true, true) => 1,
            (SplitKind::Quads, true, true) => 2,
            (SplitKind::Triangles, false, true) => 2,
            (SplitKind::Quads, false, true) => 3,
        }
    }

    /// The child that holds the place, and the place in it: parameters keep the face's orientation.
    #[inline]
    fn descend(self, split: SplitKind) -> (usize, Self) {
        let (u, v) = (self.u, self.v);
        if split == SplitKind::Quads {
            // Corners 0, 1, 2, 3 have bits 00, 10, 11, 01; nothing branches on where the place happens to be.
            let (in_u, in_v) = (u8::from(u >= 0.5), u8::from(v >= 0.5));
            let own = (((3 * in_v) ^ in_u) + 4 - self.turn) & 3;
            let (u, v) = (2.0 * u - f64::from(in_u), 2.0 * v - f64::from(in_v));
            return (usize::from(own), Self { u, v, depth: self.depth + 1, speed: 2.0 * self.speed, ..self });
        }
        let (child, u, v, flip) = match (u >= 0.5, v >= 0.5) {
            (true, _) => (1, 2.0 * u - 1.0, 2.0 * v, 1.0),
            (false, true) => (2, 2.0 * u, 2.0 * v - 1.0, 1.0),
            _ if u + v > 0.5 => (3, 1.0 - 2.0 * u, 1.0 - 2.0 * v, -1.0),
            _ => (0, 2.0 * u, 2.0 * v, 1.0),
        };
        let own = if child == 3 { 3 } else { (child + 3 - usize::from(self.turn)) % 3 };
        (own, Self { u, v, depth: self.depth + 1, speed: 2.0 * flip * self.speed, ..self })
    }
}

fn corners(split: SplitKind) -> usize {
    match split {
        SplitKind::Quads => 4,
        SplitKind::Triangles => 3,
    }
}

/// Weights over a face's ring at one location.
pub(crate) type RingWeights = PointWeights;

/// Where the way down from a face ends.
enum End<'a> {
    Leaf(&'a Leaf),
    /// On a boundary that is kept linear: weights over the node's points.
    Boundary(PointWeights),
}

/// The plan of a face.
#[derive(Clone, Copy)]
pub(crate) struct Plan<'a> {
    plans: &'a Plans,
    number: usize,
    start: Link,
}

/// Nodes on a way from which on derivative weights are cleared of what rounding adds to their sum, which would double with
/// every further node. Ways without a linear boundary are shorter.
const LONG: usize = 16;

impl<'a> Plan<'a> {
    fn root(self) -> &'a Node {
        &self.plans.nodes[self.start.node as usize]
    }

    /// Number of control points of the ring.
    pub fn ring(self) -> usize {
        self.root().ring
    }

    /// Goes down to the leaf at a place; `visit` sees every step on the way: the node that is left, how, and to which child.
    fn walk(
        self,
        u: f64,
        v: f64,
        turn: u8,
        count: usize,
        mut visit: impl FnMut(&'a Node, &'a Split, &'a Child),
    ) -> (End<'a>, Place, &'a Node) {
        let kind = self.plans.split;
        let mut at = Place { u, v, turn, depth: 0, raise: self.start.raise, speed: 1.0 };
        let mut node = self.root();
        loop {
            let split = match &node.body {
                Body::Leaf(leaf) => return (End::Leaf(leaf), at, node),
                Body::Split(split) => split,
            };
            if let Some(ends) = &split.ends {
                let (a, b) = at.turned(kind, at.turn);
                if let Some(weights) = ends.weights(kind, a, b, at.depth, node.ring, count) {
                    return (End::Boundary(weights), at, node);
                }
            }
            let child = match split.children() {
                [only] => only,
                children => {
                    let (child, below) = at.descend(kind);
                    at = below;
                    &children[child]
                }
            };
            visit(node, split, child);
            at.turn = (at.turn + child.turn) % corners(kind) as u8;
            let link = child.link(at.raise);
            at.raise = link.raise;
            node = &self.plans.nodes[link.node as usize];
        }
    }

    /// Which kind of leaf covers `(u, v)`, and at which depth.
    pub fn patch_kind(self, u: f64, v: f64, turn: u8) -> (PatchKind, u32) {
        let (end, at, _) = self.walk(u, v, turn, 0, |_, _, _| {});
        let kind = match end {
            End::Boundary(_) => PatchKind::Special,
            End::Leaf(leaf) => match leaf.shape {
                LeafShape::Special { .. } => PatchKind::Special,
                LeafShape::SingleCrease { .. } => PatchKind::SingleCrease,
                _ if !leaf.creases.is_empty() => PatchKind::SingleCrease,
                LeafShape::Linear | LeafShape::Regular => PatchKind::Regular,
            },
        };
        (kind, at.depth)
    }

    /// Weights over the ring for the first `count` entries of [`ORDERS`](super::bspline::ORDERS) (1, 3 or 6) at `(u, v)`,
    /// parameters of a face whose corner `turn` is the plan's corner 0.
    pub fn weights(self, u: f64, v: f64, turn: u8, count: usize) -> RingWeights {
        let mut way = Vec::new();
        let (end, at, last) = self.walk(u, v, turn, count, |node, split, child| way.push((node.ring, split, child)));
        let mut weights = match end {
            End::Leaf(leaf) => {
                let local = leaf.weights(self.plans.split, at, count);
                through(local, last.ring, count, |row, out| leaf.points.left_multiply(row, out))
            }
            End::Boundary(local) => turn_back(self.plans.split, local, at.turn),
        };
        let is_long = way.len() > LONG;
        for (ring, split, child) in way.into_iter().rev() {
            weights =
                through(weights, ring, count, |row, out| split.points.left_multiply_some(row, split.ring(child), out));
            if is_long {
                weights.rows[1..count].iter_mut().for_each(|row| clear_sum(row));
            }
        }
        let corner = Place { u, v, turn, depth: 0, raise: 0, speed: 1.0 }.nearest_corner(self.plans.split);
        let planes = weights.at_vertex.iter_mut().filter_map(|at| at.plane.as_mut()).flatten();
        weights.rows[1..].iter_mut().chain(planes).for_each(|row| give_excess(row, corner));
        if at.speed != 1.0 {
            for (row, times) in weights.rows.iter_mut().zip([0, 1, 1, 2, 2, 2]).take(count).skip(1) {
                let factor = at.speed.powi(times);
                row.iter_mut().for_each(|w| *w *= factor);
            }
        }
        weights
    }

    /// True where one spline patch covers the face.
    pub fn is_regular(self) -> bool {
        matches!(&self.root().body, Body::Leaf(leaf) if matches!(leaf.shape, LeafShape::Regular) && leaf.creases.is_empty())
    }

    /// The sixteen control points over the ring, where one bicubic patch covers the face.
    pub fn regular_points(self) -> Option<&'a Rows> {
        match &self.root().body {
            Body::Leaf(leaf) if self.is_regular() && self.plans.split == SplitKind::Quads => Some(&*leaf.points),
            _ => None,
        }
    }
}

impl Split {
    fn children(&self) -> &[Child] {
        &self.children[..usize::from(self.count)]
    }

    /// The control points of a child among the refined points.
    fn ring(&self, child: &Child) -> &[u32] {
        self.points.step.rings.get(usize::from(child.number))
    }
}

impl Link {
    /// The same node, one step higher.
    fn raised(self) -> Self {
        Self { raise: self.raise + 1, ..self }
    }
}

impl Child {
    const NONE: Self = Self { nodes: [0; 2], raises: [0; 2], turn: 0, number: 0 };

    fn new(links: [Link; 2], turn: u8, number: usize) -> Self {
        let [low, high] = links;
        Self { nodes: [low.node, high.node], raises: [low.raise, high.raise], turn, number: number as u8 }
    }

    /// Where a node that is raised by `raise` leads to.
    fn link(&self, raise: u8) -> Link {
        let ([low, high], [at_low, at_high]) = (self.nodes, self.raises);
        match raise {
            0 => Link { node: low, raise: at_low },
            _ => Link { node: high, raise: raise - 1 + at_high },
        }
    }
}

impl Leaf {
    /// A patch along one crease with another sharpness.
    fn with_sharpness(&self, s: f64) -> Self {
        let LeafShape::SingleCrease { turn, .. } = self.shape else { unreachable!("a patch along a crease") };
        let shape = LeafShape::SingleCrease { turn, sharpness: s };
        Self { shape, points: self.points.clone(), patch_points: self.patch_points, creases: Vec::new() }
    }

    /// Weights over the leaf's points.
    fn weights(&self, split: SplitKind, at: Place, count: usize) -> PointWeights {
        let total = |leaf_turn: u8| (at.turn + leaf_turn) % corners(split) as u8;
        let (local, turn) = match &self.shape {
            LeafShape::Linear => {
                let (a, b) = at.turned(split, at.turn);
                (linear(split, a, b), at.turn)
            }
            LeafShape::Regular => {
                let (a, b) = at.turned(split, at.turn);
                let weights = match split {
                    SplitKind::Quads => tensor(&cubic(a), &cubic(b), count),
                    SplitKind::Triangles => box_spline::basis(a, b, count),
                };
                (dense(weights, count, self.patch_points), at.turn)
            }
            LeafShape::SingleCrease { turn, sharpness } => {
                let turn = total(*turn);
                let (a, _) = at.turned(split, turn);
                // The distance from the crease, exact next to it.
                let (_, distance) = at.turned(split, (turn + 2) % 4);
                let across = single_crease::curve(distance, sharpness + f64::from(at.raise));
                (dense(tensor(&cubic(a), &across, count), count, 16), turn)
            }
            LeafShape::Special { turn, vertex } => {
                let turn = total(*turn);
                let (a, b) = at.turned(split, turn);
                (vertex.weights(a, b, count), turn)
            }
        };
        let mut local = turn_back(split, local, turn);
        for crease in &self.creases {
            let turn = total(crease.turn);
            let (a, b) = at.turned(split, turn);
            let rows = crease.weights(a, b, at.raise, count);
            let bends = turn_back_triangle(PointWeights { rows, at_vertex: None }, turn);
            local.rows.iter_mut().zip(bends.rows).for_each(|(row, bends)| row.extend(bends));
        }
        local
    }
}

/// Derivatives in parameters turned by `turn` to derivatives in the face's own.
fn turn_back(split: SplitKind, weights: PointWeights, turn: u8) -> PointWeights {
    match split {
        SplitKind::Quads => turn_back_quad(weights, turn),
        SplitKind::Triangles => turn_back_triangle(weights, turn),
    }
}

/// Weights over points to weights over the `width` points that they are made of; `multiply` adds a row to the result.
pub(super) fn through(
    local: PointWeights,
    width: usize,
    count: usize,
    multiply: impl Fn(&[f64], &mut [f64]),
) -> PointWeights {
    let multiply = |row: &[f64]| {
        let mut out = vec![0.0; width];
        multiply(row, &mut out);
        out
    };
    let mut out = PointWeights::default();
    for (out, row) in out.rows.iter_mut().zip(&local.rows).take(count) {
        *out = multiply(row);
    }
    out.at_vertex =
        local.at_vertex.map(|at| AtVertex { plane: at.plane.map(|plane| plane.map(|row| multiply(&row))), ..at });
    out
}

/// Takes from the largest weight what the sum is off zero.
fn clear_sum(row: &mut [f64]) {
    let excess: f64 = row.iter().sum();
    if let Some(largest) = row.iter_mut().max_by(|a, b| a.abs().total_cmp(&b.abs())) {
        *largest -= excess;
    }
}

/// Takes what the sum is off zero from the weight of a corner of the face.
///
/// Where all points draw together at a corner that stays, after `d` levels the next ones differ by `4^-d` of their distance in
/// what derivatives see (Loop, valence 3), while the corner's own weight, which should be nearly nothing, has gathered roundings of
/// numbers near 1: at sharpness 10 these are `4^10 ε`, 1e-10 of the derivative. The other weights are right in all digits, and
/// tell what the corner's is.
fn give_excess(row: &mut [f64], corner: usize) {
    let excess: f64 = row.iter().sum();
    if let Some(weight) = row.get_mut(corner) {
        *weight -= excess;
    }
}

fn dense(weights: [[f64; 16]; 6], count: usize, points: usize) -> PointWeights {
    let mut out = PointWeights::default();
    for (row, weights) in out.rows.iter_mut().zip(&weights).take(count) {
        *row = weights[..points].to_vec();
    }
    out
}

/// Linear weights of the corners of a quad or triangle.
pub(super) fn linear(split: SplitKind, u: f64, v: f64) -> PointWeights {
    let (s, t) = (1.0 - u, 1.0 - v);
    let rows = match split {
        SplitKind::Quads => [
            vec![s * t, u * t, u * v, s * v],
            vec![-t, t, v, -v],
            vec![-s, -u, u, s],
            vec![0.0; 4],
            vec![1.0, -1.0, 1.0, -1.0],
            vec![0.0; 4],
        ],
        SplitKind::Triangles => [
            vec![1.0 - u - v, u, v],
            vec![-1.0, 1.0, 0.0],
            vec![-1.0, 0.0, 1.0],
            vec![0.0; 3],
            vec![0.0; 3],
            vec![0.0; 3],
        ],
    };
    PointWeights { rows, at_vertex: None }
}
