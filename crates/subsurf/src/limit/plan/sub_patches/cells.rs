//! Which piece of a quad a place lies in, without a way down its patch tree: a grid of cells, of which most lie in one piece.
//!
//! A place belongs to a cell in the face's own parameters, and cells turn with the face, so that nothing is rounded. What a cell
//! does not decide, next to special vertices and along sharp creases, is found in the tree.

use super::{Plan, Pose, Slot, Spot, SubPatch};
use crate::limit::turn::turned;
use crate::real::Real;
use crate::scheme::SplitKind;

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
    /// Which nothing else fills: the tree's own stays empty.
    pub(super) slot: Slot,
    number: u32,
    /// In a face whose corner 0 is the plan's.
    pose: Pose,
    /// Parameters turned to the piece and `speed` times as large, where the piece's own are zero.
    origin: [f64; 2],
    across: [f64; 2],
    /// A place of it in such a face.
    inside: [f64; 2],
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
    /// None where places at corners of nodes are told apart from all others, or no cell lies in one piece.
    pub(super) fn new(plan: Plan<'_>) -> Option<Self> {
        if plan.plans.split != SplitKind::Quads {
            return None;
        }
        let mut cells = Self { piece: [UNDECIDED; SIDE * SIDE], pieces: Box::default() };
        let mut pieces = Vec::new();
        cells.fill(plan, [0, 0], SIDE, &mut pieces)?;
        cells.pieces = pieces.into();
        (!cells.pieces.is_empty()).then_some(cells)
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
            let ([p, q], [from, to]) = (spot.pose.speed, spot.across);
            spot.s.abs() + p * half <= 0.5 && from <= spot.t - q * half && spot.t + q * half <= to
        };
        if let Some(spot) = found.filter(covers) {
            let known = pieces.iter().position(|piece| piece.number == spot.number);
            let piece = known.unwrap_or(pieces.len());
            if known.is_none() {
                let (a, b) = turned(SplitKind::Quads, u, v, spot.pose.turn);
                let [p, q] = spot.pose.speed;
                let origin = [p * a - spot.s, q * b - spot.t];
                let (slot, number, pose) = (Slot::default(), spot.number, spot.pose);
                pieces.push(CellPiece { slot, number, pose, origin, across: spot.across, inside: [u, v] });
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

    /// Something of every matrix that is at hand, so that all are on their way before one is used.
    #[inline(always)]
    pub fn first_numbers<T: Real>(&self) -> f64 {
        let mut sum = 0.0;
        for piece in &self.pieces {
            if let Some(SubPatch::Weighted(blocks)) = piece.matrix::<T>() {
                sum += blocks.first().map_or(0.0, |block| block[0].to_f64());
            }
        }
        sum
    }

    /// Heap memory in bytes, matrices left out.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.pieces[..])
    }

    /// The piece with a number in the patch tree.
    pub(super) fn piece_in_tree(&self, number: u32) -> Option<&CellPiece> {
        self.pieces.iter().find(|piece| piece.number == number)
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
        self.slot.of::<T>().get()
    }

    /// A place in the piece.
    #[inline]
    pub fn spot(&self, [u, v]: [f64; 2], turn: u8) -> Spot<'_> {
        let [s, t] = self.map(turn).at(u, v);
        Spot {
            slot: &self.slot,
            number: self.number,
            s,
            t,
            pose: self.pose(turn),
            across: self.across,
            inside: (self.inside, 0),
        }
    }
}

impl<'a> Plan<'a> {
    /// The cells of the plan, where it has some.
    #[inline]
    pub fn cells(self) -> Option<&'a Cells> {
        self.plans.parts.trees[self.number].cells.get_or_init(|| Cells::new(self)).as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limit::PatchTable;
    use crate::scheme::Scheme;
    use crate::shapes;

    #[test]
    fn cells_name_the_pieces_that_the_tree_finds() {
        let mut decided = [0, 0];
        for shape in shapes::all() {
            let table = PatchTable::new(&shape.mesh, Scheme::CatmullClark).unwrap();
            for (plan, turn) in (0..table.plan_count()).flat_map(|plan| (0..4).map(move |turn| (plan, turn))) {
                let plan = table.plan(plan);
                let Some(cells) = plan.cells() else { continue };
                // On both sides of every change of cells, but not on it, where a place has several pieces.
                for k in 0..=4 * SIDE * SIDE {
                    let [u, v] = [k % (2 * SIDE), k / (2 * SIDE)].map(|k| (k as f64 + 0.1) / (2 * SIDE) as f64);
                    if u > 1.0 || v > 1.0 {
                        continue;
                    }
                    let [found] = cells.find(&[u], &[v], turn);
                    decided[usize::from(found != UNDECIDED)] += 1;
                    let Some(piece) = cells.piece(found) else { continue };
                    let (own, expected) = (piece.spot([u, v], turn), plan.spot_in_tree(u, v, turn).0.unwrap());
                    assert_eq!(own.number, expected.number, "{}: {u}, {v}, {turn}", shape.name);
                    assert_eq!(own.pose, expected.pose, "{}: {u}, {v}, {turn}", shape.name);
                    // A few roundings, as many times as large as the piece is smaller than the face.
                    let most = 4.0 * f64::EPSILON * SIDE as f64;
                    assert!((own.s - expected.s).abs() < most && (own.t - expected.t).abs() < most);
                }
            }
        }
        assert!(decided[1] > 8 * decided[0], "{decided:?}");
    }

    #[test]
    fn cells_of_a_face_begin_and_end_with_it() {
        for (x, cell) in [(0.0, 0), (1e-300, 0), (0.5, 4), (0.49, 3), (1.0 - f64::EPSILON / 2.0, 7), (1.0, 7)] {
            assert_eq!(along(x), cell, "{x}");
        }
    }
}
