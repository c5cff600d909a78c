//! Which piece of a quad a place lies in, without a way down its patch tree: a grid of cells, of which most lie in one piece.
//!
//! A place belongs to a cell in the face's own parameters, and cells turn with the face, so that nothing is rounded. What a cell
//! does not decide, next to special vertices and along sharp creases, is found in the tree.

use super::{Pieces, Plan, Pose, Slot, Spot, SubPatch};
use crate::limit::turn::turned;
use crate::real::Real;
use crate::scheme::SplitKind;
use std::sync::Arc;

/// Cells along a side, as a power of two. Larger: memory, and time when a plan is first met; smaller: more places go down the
/// tree, at a special vertex one in `4^BITS`.
const BITS: u32 = 3;
const SIDE: usize = 1 << BITS;

/// A cell with several pieces, or none.
const UNDECIDED: u8 = u8::MAX;

/// The cells of a plan.
pub(crate) struct Cells {
    /// Row by row, where the plan's corner 0 is the first.
    piece: [u8; SIDE * SIDE],
    pieces: Box<[CellPiece]>,
}

/// A piece that covers a cell.
pub(crate) struct CellPiece {
    slots: Arc<[Slot]>,
    slot: u32,
    number: u32,
    /// In a face whose corner 0 is the plan's.
    pose: Pose,
    /// Parameters turned to the piece and `speed` times as large, where the piece's own are zero.
    origin: [f64; 2],
}

/// The parameters of a piece from those of its face: `(s, t) = start + u · ∂(s, t)/∂u + v · ∂(s, t)/∂v`. Factors are powers of two, so that
/// one rounding is all that digits suffer.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PieceMap {
    jacobian: [[f64; 2]; 2],
    start: [f64; 2],
}

impl PieceMap {
    #[inline(always)]
    pub fn at(&self, u: f64, v: f64) -> [f64; 2] {
        let [du, dv] = self.jacobian;
        [(u * du[0] + v * dv[0]) + self.start[0], (u * du[1] + v * dv[1]) + self.start[1]]
    }
}

impl Cells {
    /// None where places at corners of nodes are told apart from all others.
    pub(super) fn new(plan: Plan<'_>) -> Option<Self> {
        if plan.plans.split != SplitKind::Quads {
            return None;
        }
        let mut cells = Self { piece: [UNDECIDED; SIDE * SIDE], pieces: Box::default() };
        let mut pieces = Vec::new();
        cells.fill(plan, [0, 0], SIDE, &mut pieces)?;
        cells.pieces = pieces.into();
        Some(cells)
    }

    /// Finds the pieces of a square of cells.
    fn fill(&mut self, plan: Plan<'_>, [i, j]: [usize; 2], size: usize, pieces: &mut Vec<CellPiece>) -> Option<()> {
        let half = 0.5 * size as f64 / SIDE as f64;
        let [u, v] = [i, j].map(|k| k as f64 / SIDE as f64 + half);
        let (found, has_ends) = plan.spot_in_tree(u, v, 0);
        if has_ends {
            return None;
        }
        let covers = |spot: &Spot<'_>| {
            let [p, q] = spot.pose.speed;
            spot.s.abs() + p * half <= 0.5 && spot.t.abs() + q * half <= 0.5
        };
        if let Some(spot) = found.filter(covers) {
            let known = pieces.iter().position(|piece| piece.number == spot.number);
            let piece = known.unwrap_or(pieces.len());
            if known.is_none() {
                let (a, b) = turned(SplitKind::Quads, u, v, spot.pose.turn);
                let [p, q] = spot.pose.speed;
                let origin = [p * a - spot.s, q * b - spot.t];
                let (slots, slot) = (spot.slots.clone(), spot.slot);
                pieces.push(CellPiece { slots, slot, number: spot.number, pose: spot.pose, origin });
            }
            for row in j..j + size {
                self.piece[SIDE * row + i..][..size].fill(piece as u8);
            }
        } else if size > 1 {
            let half = size / 2;
            for (x, y) in [(0, 0), (half, 0), (0, half), (half, half)] {
                self.fill(plan, [i + x, j + y], half, pieces)?;
            }
        }
        Some(())
    }

    /// The pieces of places in a face whose corner `turn` is the plan's corner 0; where a cell does not decide, a number that
    /// has no [`piece`](Self::piece).
    #[inline(always)]
    pub fn find<const W: usize>(&self, u: &[f64; W], v: &[f64; W], turn: u8) -> [u8; W] {
        // As `turned` says, in cells: 1 - x is all bits the other way round.
        let flip = |flips: bool| if flips { SIDE as u32 - 1 } else { 0 };
        let (swap, flip_a, flip_b) = (turn & 1 == 1, flip(turn >= 2), flip(turn == 1 || turn == 2));
        let (first, second) = if swap { (v, u) } else { (u, v) };
        let mut cell = [0; W];
        for k in 0..W {
            cell[k] = (along(first[k]) ^ flip_a) | (along(second[k]) ^ flip_b) << BITS;
        }
        let mut piece = [0; W];
        for k in 0..W {
            piece[k] = self.piece[cell[k] as usize % (SIDE * SIDE)];
        }
        piece
    }

    /// A piece by its number among those that cover cells.
    #[inline(always)]
    pub fn piece(&self, number: u8) -> Option<&CellPiece> {
        self.pieces.get(usize::from(number))
    }
}

/// The cell along a side.
#[inline(always)]
fn along(x: f64) -> u32 {
    // Between 1 and 2 all numbers have one exponent, and their digits begin with the cell's number.
    const BELOW_ONE: f64 = 1.0 - f64::EPSILON;
    let x = 1.0 + if x < BELOW_ONE { x } else { BELOW_ONE };
    (x.to_bits() >> (52 - BITS)) as u32 & (SIDE as u32 - 1)
}

impl CellPiece {
    /// How the piece's parameters follow from those of a face whose corner `turn` is the plan's corner 0.
    #[inline(always)]
    pub fn map(&self, turn: u8) -> PieceMap {
        // Turned parameters at the face's own corner 0.
        static AT_CORNER: [[f64; 2]; 4] = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
        let pose = self.pose(turn);
        let [a, b] = AT_CORNER[usize::from(pose.turn & 3)];
        let [p, q] = pose.speed;
        let start = [p * a - self.origin[0], q * b - self.origin[1]];
        PieceMap { jacobian: pose.jacobian(SplitKind::Quads), start }
    }

    /// How the piece lies in such a face.
    #[inline(always)]
    pub fn pose(&self, turn: u8) -> Pose {
        Pose { turn: (self.pose.turn + turn) & 3, ..self.pose }
    }

    /// The matrix, once it was made.
    #[inline(always)]
    pub fn matrix<T: Real>(&self) -> Option<&SubPatch<T>> {
        self.slots.get(self.slot as usize)?.of::<T>().get()
    }

    /// A place in the piece.
    #[inline]
    pub fn spot(&self, [u, v]: [f64; 2], turn: u8) -> Spot<'_> {
        let [s, t] = self.map(turn).at(u, v);
        Spot {
            slots: &self.slots,
            slot: self.slot,
            number: self.number,
            s,
            t,
            pose: self.pose(turn),
            inside: self.middle(),
        }
    }

    /// The middle of the piece, in a face whose corner 0 is the plan's.
    fn middle(&self) -> ([f64; 2], u8) {
        let [p, q] = self.pose.speed;
        let (u, v) = turned(SplitKind::Quads, self.origin[0] / p, self.origin[1] / q, (4 - self.pose.turn) & 3);
        ([u, v], 0)
    }
}

impl<'a> Plan<'a> {
    /// The cells of the plan, where it has some.
    #[inline]
    pub fn cells(self) -> Option<&'a Cells> {
        self.plans.parts.trees[self.number].cells.get_or_init(|| Cells::new(self).map(Box::new)).as_deref()
    }
}

impl Pieces {
    /// Room for the matrices of so many pieces.
    pub(super) fn slots(count: usize) -> Arc<[Slot]> {
        (0..count).map(|_| Slot::default()).collect()
    }
}
