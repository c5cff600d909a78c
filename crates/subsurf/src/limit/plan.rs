//! A plan: everything that the limit of one face depends on except positions. Faces with equal surroundings share it.
//!
//! A plan is a tree. A node is either split into four children, the level's explicit refinement, or a leaf:
//! a bicubic patch, a patch along one semi-sharp crease, or a special vertex with its closed form. Every leaf has its
//! control points as sparse rows over the face's ring. The tree is at most `⌈sharpness⌉ + 2` levels deep: each level
//! takes one from every finite sharpness, makes all faces quads, and parts special vertices.

mod compile;

use super::box_spline;
use super::bspline::{cubic, tensor};
use super::corner::Corner;
use super::linear_boundary::LinearBoundary;
use super::rows::Rows;
use super::single_crease;
use super::special::{AtVertex, Method, PointWeights, SpecialVertex};
use super::turn::{turn_back_quad, turn_back_triangle, turned_quad, turned_triangle};
use crate::scheme::SplitKind;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// The special vertices that plans refer to, each made once.
#[derive(Default)]
pub(crate) struct SpecialVertices {
    made: Mutex<HashMap<Corner, Arc<SpecialVertex>>>,
    method: Method,
}

impl SpecialVertices {
    pub fn new(method: Method) -> Self {
        Self { made: Mutex::default(), method }
    }

    pub fn get(&self, corner: Corner) -> Arc<SpecialVertex> {
        // A smooth or pinned vertex looks the same from all its faces: their numbering starts at the face itself.
        if let Some(made) = self.lock().get(&corner) {
            return made.clone();
        }
        let new = Arc::new(SpecialVertex::new(corner, self.method));
        self.lock().entry(corner).or_insert(new).clone()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<Corner, Arc<SpecialVertex>>> {
        self.made.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// Every kind that was made, sorted.
    pub fn all(&self) -> Vec<Arc<SpecialVertex>> {
        let mut all: Vec<_> = self.lock().values().cloned().collect();
        all.sort_by_key(|s| s.corner);
        all
    }
}

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

enum Node {
    Split([u32; 4]),
    Leaf(u32),
}

struct Leaf {
    shape: LeafShape,
    /// The leaf's control points over the ring.
    points: Rows,
}

enum LeafShape {
    /// The face's own corners, bilinear in a quad and linear in a triangle.
    Linear,
    /// Sixteen points in the order of [`bspline`](super::bspline), or twelve in that of
    /// [`box_spline`](super::box_spline).
    Regular,
    /// Sixteen points turned so that the crease runs along v = 1, between corners `turn + 2` and `turn + 3`.
    SingleCrease { turn: u8, sharpness: f64 },
    /// Points of a special vertex at corner `turn`.
    Special { turn: u8, vertex: Arc<SpecialVertex> },
    /// A face with a side on a boundary that is kept piecewise linear: the leaf's own surroundings.
    LinearBoundary(Box<LinearBoundary>),
}

impl LeafShape {
    /// Heap memory in bytes, shared special vertices left out.
    fn bytes(&self) -> usize {
        match self {
            LeafShape::LinearBoundary(form) => form.bytes(),
            _ => 0,
        }
    }
}

/// A compiled plan.
pub(crate) struct Plan {
    split: SplitKind,
    ring: usize,
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    root: u32,
}

/// A leaf, and the place in it.
struct Found<'a> {
    leaf: &'a Leaf,
    depth: u32,
    /// Leaf parameters per face parameter; negative in triangles that are turned upside down.
    speed: f64,
    u: f64,
    v: f64,
}

/// The child that holds `(u, v)`: its number, the place in it, and -1 where it is turned upside down.
pub(super) fn descend(split: SplitKind, u: f64, v: f64) -> (usize, f64, f64, f64) {
    match (split, u >= 0.5, v >= 0.5) {
        (_, true, false) | (SplitKind::Triangles, true, true) => (1, 2.0 * u - 1.0, 2.0 * v, 1.0),
        (SplitKind::Triangles, false, true) => (2, 2.0 * u, 2.0 * v - 1.0, 1.0),
        (SplitKind::Triangles, ..) if u + v > 0.5 => (3, 1.0 - 2.0 * u, 1.0 - 2.0 * v, -1.0),
        (SplitKind::Quads, true, true) => (2, 2.0 * u - 1.0, 2.0 * v - 1.0, 1.0),
        (SplitKind::Quads, false, true) => (3, 2.0 * u, 2.0 * v - 1.0, 1.0),
        _ => (0, 2.0 * u, 2.0 * v, 1.0),
    }
}

/// Weights over a face's ring at one location.
pub(crate) type RingWeights = PointWeights;

impl Plan {
    /// Number of control points of the ring.
    pub fn ring(&self) -> usize {
        self.ring
    }

    /// Finds the leaf at `(u, v)`, parameters of a face whose corner `turn` is the plan's corner 0.
    fn leaf(&self, u: f64, v: f64, turn: u8) -> Found<'_> {
        let mut found = Found { leaf: &self.leaves[0], depth: 0, speed: 1.0, u, v };
        let mut node = self.root;
        while let Node::Split(children) = self.nodes[node as usize] {
            let (child, u, v, flip) = descend(self.split, found.u, found.v);
            (found.u, found.v) = (u, v);
            let turn = usize::from(turn);
            let own = match self.split {
                SplitKind::Quads => (child + 4 - turn) % 4,
                SplitKind::Triangles if child == 3 => 3,
                SplitKind::Triangles => (child + 3 - turn) % 3,
            };
            node = children[own];
            found.depth += 1;
            found.speed *= 2.0 * flip;
        }
        if let Node::Leaf(leaf) = self.nodes[node as usize] {
            found.leaf = &self.leaves[leaf as usize];
        }
        found
    }

    /// Which kind of leaf covers `(u, v)`, and at which depth.
    pub fn patch_kind(&self, u: f64, v: f64, turn: u8) -> (PatchKind, u32) {
        let found = self.leaf(u, v, turn);
        let kind = match found.leaf.shape {
            LeafShape::Linear | LeafShape::Regular => PatchKind::Regular,
            LeafShape::SingleCrease { .. } => PatchKind::SingleCrease,
            LeafShape::Special { .. } | LeafShape::LinearBoundary(_) => PatchKind::Special,
        };
        (kind, found.depth)
    }

    /// Weights over the ring for the first `count` entries of [`ORDERS`](super::bspline::ORDERS) (1, 3 or 6) at `(u, v)`,
    /// parameters of a face whose corner `turn` is the plan's corner 0.
    pub fn weights(&self, u: f64, v: f64, turn: u8, count: usize) -> RingWeights {
        let Found { leaf, speed, u, v, .. } = self.leaf(u, v, turn);
        let corners = match self.split {
            SplitKind::Quads => 4,
            SplitKind::Triangles => 3,
        };
        let total = |leaf_turn: u8| (turn + leaf_turn) % corners;
        let turned = |turn: u8| match self.split {
            SplitKind::Quads => turned_quad(u, v, turn),
            SplitKind::Triangles => turned_triangle(u, v, turn),
        };
        let (local, turn) = match &leaf.shape {
            LeafShape::Linear => {
                let (a, b) = turned(turn);
                (linear(self.split, a, b), turn)
            }
            LeafShape::LinearBoundary(form) => {
                let (a, b) = turned(turn);
                (form.weights(a, b, count), turn)
            }
            LeafShape::Regular => {
                let (a, b) = turned(turn);
                let weights = match self.split {
                    SplitKind::Quads => tensor(&cubic(a), &cubic(b), count),
                    SplitKind::Triangles => box_spline::basis(a, b, count),
                };
                (dense(weights, count, leaf.points.len()), turn)
            }
            LeafShape::SingleCrease { turn, sharpness } => {
                let turn = total(*turn);
                let (a, _) = turned(turn);
                // The distance from the crease, exact next to it.
                let (_, distance) = turned((turn + 2) % 4);
                let across = single_crease::curve(distance, *sharpness);
                (dense(tensor(&cubic(a), &across, count), count, 16), turn)
            }
            LeafShape::Special { turn, vertex } => {
                let turn = total(*turn);
                let (a, b) = turned(turn);
                (vertex.weights(a, b, count), turn)
            }
        };
        let local = match self.split {
            SplitKind::Quads => turn_back_quad(local, turn),
            SplitKind::Triangles => turn_back_triangle(local, turn),
        };
        self.on_ring(leaf, local, speed, count)
    }

    /// Leaf weights to ring weights, with the factor `speed` per differentiation.
    fn on_ring(&self, leaf: &Leaf, local: PointWeights, speed: f64, count: usize) -> RingWeights {
        let through = |row: &[f64], factor: f64| {
            let mut out = vec![0.0; self.ring];
            leaf.points.left_multiply(row, &mut out);
            if factor != 1.0 {
                out.iter_mut().for_each(|w| *w *= factor);
            }
            out
        };
        let mut out = RingWeights::default();
        for order in 0..count {
            let times = [0, 1, 1, 2, 2, 2][order];
            out.rows[order] = through(&local.rows[order], speed.powi(times));
        }
        out.at_vertex = local
            .at_vertex
            .map(|at| AtVertex { plane: at.plane.map(|plane| plane.map(|row| through(&row, 1.0))), ..at });
        out
    }

    /// True where one spline patch covers the face.
    pub fn is_regular(&self) -> bool {
        self.leaves.len() == 1 && matches!(self.leaves[0].shape, LeafShape::Regular)
    }

    /// The sixteen control points over the ring, where one bicubic patch covers the face.
    pub fn regular_points(&self) -> Option<&Rows> {
        (self.is_regular() && self.split == SplitKind::Quads).then(|| &self.leaves[0].points)
    }

    /// Heap memory in bytes, shared special vertices left out.
    pub fn bytes(&self) -> usize {
        self.leaves.iter().map(|leaf| leaf.points.bytes() + leaf.shape.bytes() + size_of::<Leaf>()).sum::<usize>()
            + self.nodes.len() * size_of::<Node>()
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
