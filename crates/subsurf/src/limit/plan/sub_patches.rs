//! Regular sub-patches: every location but a special vertex lies in a piece of its face that one polynomial patch covers.
//!
//! The pieces of a plan are the leaves of its patch tree: a regular leaf is one, a leaf along a semi-sharp crease has
//! three, one at a special vertex has three for every depth. A piece's coefficients are a small dense matrix times the
//! face's ring, the same for all faces of the plan. Which piece a place lies in is looked up in a grid of `cells`; what that leaves
//! open is found in the tree. Matrices are made when a location first needs them and kept up to
//! [`MOST_BYTES`] in all, beyond that made anew each time: what is computed does not depend on what is kept.
//!
//! Under Catmull-Clark a piece has the sixteen coefficients of [`powers`](super::super::powers), or the points of its ring that
//! are its control points; under Loop the fifteen coefficients of
//! [`POLYNOMIALS`](super::super::box_spline::POLYNOMIALS). Not covered, and left to [`Plan::weights`]: depths beyond
//! [`DEEPEST_PIECE`] (one random location in 4^8), linear leaves, semi-sharp creases under Loop, what ends on a boundary that is kept
//! linear, and rings of more than [`MOST_POINTS`] points.

mod cells;
mod matrix;

pub(crate) use cells::{Cells, PieceMap};
pub(crate) use matrix::KeptCoefficients;

use super::{Body, Leaf, LeafShape, Link, Place, Plan, Plans, corners};
use crate::kernel::LANES;
use crate::limit::box_spline::CENTRE;
use crate::limit::powers::MIDDLE;
use crate::limit::single_crease;
use crate::limit::special::SpecialVertex;
use crate::real::Real;
use crate::scheme::SplitKind;
use std::any::Any;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, OnceLock};

/// Memory for all matrices of a table. Larger: memory of meshes with thousands of plans; smaller: such meshes are
/// evaluated as slowly as without matrices.
const MOST_BYTES: usize = 128 << 20;

/// Largest depth at a special vertex with matrices. Larger: memory, three matrices a depth; smaller: more locations that take
/// the general way, a quarter of the rest per depth.
const DEEPEST_PIECE: u32 = 7;

/// Number of pieces at a special vertex.
const PIECES_AT_VERTEX: usize = 3 * (DEEPEST_PIECE as usize + 1);

/// Largest depth of a leaf in a patch tree with matrices: more than `⌈sharpness⌉ + 2` only along linear boundaries.
const DEEPEST_LEAF: u32 = 14;

/// Largest ring whose pieces have matrices, of 32 KiB in `f64`.
const MOST_POINTS: usize = 256;

/// Weights of a piece's coefficients over the ring, one block of [`LANES`] coefficients per point of the ring.
pub(crate) type Blocks<T> = Box<[[T; LANES]]>;

/// What a piece is made of.
#[derive(Debug)]
pub(crate) enum SubPatch<T> {
    /// Control points of a bicubic patch, which are points of the ring.
    Chosen([u8; LANES]),
    /// Coefficients of the piece's polynomial.
    Weighted(Blocks<T>),
}

/// Where a location lies.
#[derive(Clone, Copy)]
pub(crate) struct Spot<'a> {
    slot: &'a Slot,
    number: u32,
    /// Parameters of the piece, from its centre.
    pub s: f64,
    pub t: f64,
    /// How the piece's parameters lie in the face.
    pub pose: Pose,
    /// From where to where the piece goes in `t`; in `s` it goes all the way.
    across: [f64; 2],
    /// A place that the tree says is in the piece, and the face's turn there.
    inside: ([f64; 2], u8),
}

/// How the parameters of a piece lie in the face: turned by so many corners, then so many times as fast.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Pose {
    pub(super) turn: u8,
    pub(super) speed: [f64; 2],
}

impl Pose {
    /// True where the piece's derivatives are the face's.
    #[inline(always)]
    pub fn is_plain(self) -> bool {
        self.turn == 0 && self.speed == [1.0; 2]
    }

    /// `∂s/∂u ∂t/∂u` and `∂s/∂v ∂t/∂v`.
    #[inline(always)]
    pub fn jacobian(self, split: SplitKind) -> [[f64; 2]; 2] {
        // (a, b) = (u, v), (v, 1 - u), (1 - u, 1 - v), (1 - v, u).
        static QUADS: [[[f64; 2]; 2]; 4] = [
            [[1.0, 0.0], [0.0, 1.0]],
            [[0.0, -1.0], [1.0, 0.0]],
            [[-1.0, 0.0], [0.0, -1.0]],
            [[0.0, 1.0], [-1.0, 0.0]],
        ];
        // (a, b) = (u, v), (v, 1 - u - v), (1 - u - v, u).
        static TRIANGLES: [[[f64; 2]; 2]; 3] =
            [[[1.0, 0.0], [0.0, 1.0]], [[0.0, -1.0], [1.0, -1.0]], [[-1.0, 1.0], [-1.0, 0.0]]];
        let [u, v] = match split {
            SplitKind::Quads => QUADS[usize::from(self.turn & 3)],
            SplitKind::Triangles => TRIANGLES[usize::from(self.turn)],
        };
        let [p, q] = self.speed;
        [[p * u[0], q * u[1]], [p * v[0], q * v[1]]]
    }

    /// Second derivatives in the face's parameters, as combinations of those in the piece's: `ss`, `st`, `tt`.
    pub fn second(self, split: SplitKind) -> [[f64; 3]; 3] {
        let [u, v] = self.jacobian(split);
        let product = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a * c, a * d + b * c, b * d];
        [product(u, u), product(u, v), product(v, v)]
    }
}

/// The matrices of one piece.
#[derive(Default)]
struct Slot {
    single: OnceLock<SubPatch<f32>>,
    double: OnceLock<SubPatch<f64>>,
}

impl Slot {
    fn of<T: Real>(&self) -> &OnceLock<SubPatch<T>> {
        let both: [&dyn Any; 2] = [&self.single, &self.double];
        both.into_iter().find_map(|slot| slot.downcast_ref()).expect("values are f32 or f64")
    }
}

impl Spot<'_> {
    /// Tells pieces of one plan apart: a small number.
    #[inline]
    pub fn piece(&self) -> u32 {
        self.number
    }
}

/// The pieces of all plans, as far as they were met.
pub(crate) struct SubPatches {
    trees: Vec<Root>,
    bytes: AtomicUsize,
    made: AtomicUsize,
}

impl SubPatches {
    /// For no plans yet.
    pub fn new() -> Self {
        Self { trees: Vec::new(), bytes: AtomicUsize::new(0), made: AtomicUsize::new(0) }
    }

    /// Room for so many plans, those of before as they are.
    pub fn grow(&mut self, plans: usize) {
        self.trees.resize_with(plans, Root::default);
    }

    /// Bytes of all matrices that are kept.
    pub fn bytes(&self) -> usize {
        self.bytes.load(Relaxed)
    }

    /// Bytes of what tells pieces apart, patch trees and cells, with room for their matrices.
    pub fn search_bytes(&self) -> usize {
        self.trees.capacity() * size_of::<Root>() + self.trees.iter().map(Root::bytes).sum::<usize>()
    }

    /// How many matrices were made so far.
    pub fn made(&self) -> usize {
        self.made.load(Relaxed)
    }

    /// True if a matrix of so many bytes may be kept.
    fn reserve(&self, bytes: usize) -> bool {
        self.bytes.fetch_update(Relaxed, Relaxed, |kept| (kept + bytes <= MOST_BYTES).then_some(kept + bytes)).is_ok()
    }
}

/// The patch tree of a plan, its cells, and how many pieces it has so far.
#[derive(Default)]
struct Root {
    tree: OnceLock<Tree>,
    cells: OnceLock<Option<Cells>>,
    pieces: AtomicU32,
}

impl Root {
    /// Heap memory in bytes, matrices left out.
    fn bytes(&self) -> usize {
        self.tree.get().map_or(0, Tree::bytes) + self.cells.get().and_then(Option::as_ref).map_or(0, Cells::bytes)
    }
}

/// Part of a patch tree.
enum Tree {
    Leaf(Pieces),
    Branch(Branch),
    /// Nothing here has matrices.
    Closed,
}

struct Branch {
    /// Nodes of the children, and their turns.
    links: Box<[(Link, u8)]>,
    /// True where a location at a corner ends.
    has_ends: bool,
    depth: u32,
    children: Box<[OnceLock<Tree>]>,
}

/// The pieces of a leaf.
struct Pieces {
    kind: Kind,
    slots: Box<[Slot]>,
    /// Number of the first one in the plan.
    first: u32,
}

enum Kind {
    Whole,
    SingleCrease {
        turn: u8,
        joints: [f64; 2],
        /// `2^k` in the three segments.
        speed: [f64; 3],
    },
    Special {
        turn: u8,
        vertex: Arc<SpecialVertex>,
    },
}

impl Tree {
    fn new(plans: &Plans, Link { node, raise }: Link, depth: u32, pieces: &AtomicU32) -> Self {
        match &plans.nodes[node as usize].body {
            Body::Leaf(leaf) => Pieces::new(leaf, raise, pieces).map_or(Self::Closed, Self::Leaf),
            Body::Split(_) if depth >= DEEPEST_LEAF => Self::Closed,
            Body::Split(split) => {
                let links: Box<[_]> = split.children().iter().map(|c| (c.link(raise), c.turn)).collect();
                let children = links.iter().map(|_| OnceLock::new()).collect();
                Self::Branch(Branch { links, has_ends: split.ends.is_some(), depth, children })
            }
        }
    }

    /// Heap memory in bytes, matrices left out.
    fn bytes(&self) -> usize {
        match self {
            Self::Closed => 0,
            Self::Leaf(pieces) => size_of_val(&pieces.slots[..]),
            Self::Branch(Branch { links, children, .. }) => {
                let below = children.iter().filter_map(OnceLock::get).map(Self::bytes);
                size_of_val(&links[..]) + size_of_val(&children[..]) + below.sum::<usize>()
            }
        }
    }
}

impl Pieces {
    fn new(leaf: &Leaf, raise: u8, pieces: &AtomicU32) -> Option<Self> {
        if !leaf.creases.is_empty() {
            return None;
        }
        let (kind, count) = match &leaf.shape {
            // A sum over three or four corners is as fast, and exact in the middle.
            LeafShape::Linear => return None,
            LeafShape::Regular => (Kind::Whole, 1),
            LeafShape::SingleCrease { turn, sharpness } => {
                let sharpness = sharpness + f64::from(raise);
                let speed = [0, 1, 2].map(|k| 2f64.powi(single_crease::piece(sharpness, k).0));
                (Kind::SingleCrease { turn: *turn, joints: single_crease::joints(sharpness), speed }, 3)
            }
            LeafShape::Special { turn, vertex } => {
                (Kind::Special { turn: *turn, vertex: vertex.clone() }, PIECES_AT_VERTEX)
            }
        };
        let first = pieces.fetch_add(count as u32, Relaxed);
        Some(Self { kind, slots: (0..count).map(|_| Slot::default()).collect(), first })
    }

    #[inline]
    fn spot(&self, split: SplitKind, at: Place, inside: ([f64; 2], u8)) -> Option<Spot<'_>> {
        let total = |leaf_turn: u8| wrapped(at.turn + leaf_turn, split);
        let mut across = [0.0, 1.0];
        let (number, turn, s, t, speed) = match &self.kind {
            Kind::Whole => {
                let (a, b) = at.turned(split, at.turn);
                (0, at.turn, a, b, [at.speed; 2])
            }
            Kind::SingleCrease { turn, joints, speed } => {
                let turn = total(*turn);
                let (a, _) = at.turned(split, turn);
                // The distance from the crease, exact next to it.
                let (_, distance) = at.turned(split, (turn + 2) % 4);
                let number = usize::from(distance < joints[0]) + usize::from(distance < joints[1]);
                let [near, far] = [[joints[0], 1.0], [joints[1], joints[0]], [0.0, joints[1]]][number];
                across = [1.0 - speed[number] * far, 1.0 - speed[number] * near];
                (number, turn, a, 1.0 - speed[number] * distance, [at.speed, at.speed * speed[number]])
            }
            Kind::Special { turn, vertex } => {
                let turn = total(*turn);
                let (a, b) = at.turned(split, turn);
                let child = vertex.child(a, b).filter(|child| child.depth <= DEEPEST_PIECE)?;
                let speed = at.speed * child.flip * f64::from(2u32 << child.depth);
                (3 * child.depth as usize + child.index, turn, child.u, child.v, [speed; 2])
            }
        };
        let centre = centre(split);
        let pose = Pose { turn, speed };
        let (slot, number) = (&self.slots[number], self.first + number as u32);
        let across = [across[0] - centre, across[1] - centre];
        Some(Spot { slot, number, s: s - centre, t: t - centre, pose, across, inside })
    }
}

/// Where the parameters of a piece are zero.
#[inline(always)]
fn centre(split: SplitKind) -> f64 {
    match split {
        SplitKind::Quads => MIDDLE,
        SplitKind::Triangles => CENTRE,
    }
}

#[inline]
fn wrapped(turn: u8, split: SplitKind) -> u8 {
    let corners = corners(split) as u8;
    if turn < corners { turn } else { turn - corners }
}

impl<'a> Plan<'a> {
    /// True where the ring is too large for matrices.
    pub fn is_wide(self) -> bool {
        self.ring() > MOST_POINTS
    }

    fn tree(self) -> (&'a Tree, &'a AtomicU32) {
        let Root { tree, pieces, .. } = &self.plans.parts.trees[self.number];
        let new = || match self.ring() {
            0..=MOST_POINTS => Tree::new(self.plans, self.start, 0, pieces),
            _ => Tree::Closed,
        };
        (tree.get_or_init(new), pieces)
    }

    /// Where `(u, v)` lies, parameters of a face whose corner `turn` is the plan's corner 0; none where there is no piece:
    /// at special vertices, and where [`Plan::weights`] is the only way.
    #[inline]
    pub fn spot(self, u: f64, v: f64, turn: u8) -> Option<Spot<'a>> {
        let cells = self.cells();
        if let Some(cells) = cells {
            let [piece] = cells.find(&[u], &[v], turn);
            if let Some(piece) = cells.piece(piece) {
                return Some(piece.spot([u, v], turn));
            }
        }
        let mut spot = self.spot_in_tree(u, v, turn).0?;
        if let Some(piece) = cells.and_then(|cells| cells.piece_in_tree(spot.number)) {
            spot.slot = &piece.slot;
        }
        Some(spot)
    }

    /// The same by the patch tree alone; and true where the way down may end at a corner.
    pub fn spot_in_tree(self, u: f64, v: f64, turn: u8) -> (Option<Spot<'a>>, bool) {
        let split = self.plans.split;
        let inside = ([u, v], turn);
        let mut at = Place { u, v, turn, depth: 0, raise: self.start.raise, speed: 1.0 };
        let (mut tree, pieces) = self.tree();
        let mut has_ends = false;
        loop {
            let branch = match tree {
                Tree::Closed => return (None, has_ends),
                Tree::Leaf(pieces) => return (pieces.spot(split, at, inside), has_ends),
                Tree::Branch(branch) => branch,
            };
            has_ends |= branch.has_ends;
            if branch.has_ends && [at.u, at.v].iter().all(|&x| x == 0.0 || x == 1.0) {
                return (None, has_ends);
            }
            let mut child = 0;
            if branch.children.len() > 1 {
                (child, at) = at.descend(split);
            }
            let (link, turn) = branch.links[child];
            at.turn = wrapped(at.turn + turn, split);
            tree = branch.children[child].get_or_init(|| Tree::new(self.plans, link, branch.depth + 1, pieces));
        }
    }

    /// A place in the piece that covers the face, if one does.
    #[inline]
    pub fn whole_spot(self, turn: u8) -> Option<Spot<'a>> {
        match self.tree().0 {
            Tree::Leaf(Pieces { kind: Kind::Whole, .. }) => self.spot(0.5, 0.25, turn),
            _ => None,
        }
    }

    /// Calls `f` with the matrix of the piece at a spot.
    #[inline]
    pub fn with_piece<T: Real, R>(self, spot: &Spot<'a>, f: impl FnOnce(&SubPatch<T>) -> R) -> R {
        let slot = spot.slot.of::<T>();
        match slot.get() {
            Some(made) => f(made),
            None => self.with_new_piece(slot, spot.inside, f),
        }
    }

    #[cold]
    fn with_new_piece<T: Real, R>(
        self,
        slot: &OnceLock<SubPatch<T>>,
        ([u, v], turn): ([f64; 2], u8),
        f: impl FnOnce(&SubPatch<T>) -> R,
    ) -> R {
        let made = self.piece::<T>(u, v, turn);
        let parts = &self.plans.parts;
        parts.made.fetch_add(1, Relaxed);
        let bytes = made.bytes();
        if !parts.reserve(bytes) {
            return f(&made);
        }
        if slot.set(made).is_err() {
            // Another thread was faster.
            parts.bytes.fetch_sub(bytes, Relaxed);
        }
        f(slot.get().expect("it was set"))
    }
}

impl<T> SubPatch<T> {
    /// Heap memory in bytes.
    fn bytes(&self) -> usize {
        match self {
            Self::Chosen(_) => 0,
            Self::Weighted(blocks) => size_of_val(&blocks[..]),
        }
    }
}
