//! The eigenbasis of the local subdivision matrix: Stam's for smooth extraordinary vertices, and the Jordan normal form
//! of Lacewell and Burley for the sectors of boundaries, creases and corners. Catmull-Clark only.
//!
//! Sources: J. Stam, "Exact evaluation of Catmull-Clark subdivision surfaces at arbitrary parameter values" (1998);
//! D. Lacewell, B. Burley, "Exact evaluation of Catmull-Clark subdivision surfaces near B-spline boundaries" (2007).
//!
//! `A` takes the K control points of the face between `e_i` and `e_{i+1}` of a vertex `v` to those of its child at `v`.
//! Point order: `v e_0 f_0 e_1 f_1 …` round the vertex, then the outer points in the face's coordinates
//! `(2,-1) (2,0) (2,1) (2,2) (1,2) (0,2) (-1,2)`, of which the first is absent where the edge `v e_i` is sharp and the
//! last where `v e_{i+1}` is. The ring does not depend on the outer points:
//!
//! ```text
//!     A = | S   0  | = T J T⁻¹      T = | U0  0 |      J: blocks (eigenvalue, size, start), never a matrix
//!         | S11 S12|                    | U1  W |
//! ```
//!
//! Where this departs from the papers:
//! - U0, W and their inverses are closed forms (Fourier and sine modes), not the output of a numerical eigensolver.
//! - 2007, Figure 4 has edges N = faces + 1: N = 2 is defective too (index 2, eigenvalue 1/4) and N = 3 is not, so
//!   "N not in {7, 11, …}" should read {3, 7, 11, …}. Pinned corners, not in the paper, are covered.
//! - 2007, `w = pinv(S - λ) v_r` needs the `v_r` in the range of `S - λ`. At a corner λ = 1/2 has three vectors and
//!   blocks {2, 1}, and an arbitrary eigenvector is wrong; here the chain starts at the mode that the curve drives.
//! - The eigenvalue 1 is kept apart: it carries the limit position, and its derivatives are exactly 0. Everything else
//!   is relative to the subdominant eigenvalue to the m, so derivatives keep their digits at any depth.
//! - Valence 2 is a chain through S12, at 1/8. No other eigenvalue of S that S12 shares is: the systems are consistent.
//!
//! Darts are in neither paper, and most have complex pairs of eigenvalues: they have no form here.

mod outer;
mod ring;
#[cfg(test)]
mod tests;

use super::corner::Kind;
use outer::OuterModes;

/// One Jordan block of `J`: rows and columns `start .. start + size`, of size 1 or 2. A block of size 2 has its one below
/// the diagonal: `A x = μ x + u` with x in column `start` and the eigenvector u after it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Block {
    pub(crate) eigenvalue: f64,
    pub(crate) size: usize,
    pub(crate) start: usize,
}

/// The decomposition `A = T J T⁻¹` of one local subdivision matrix.
///
/// Storage is that of `T` and `T⁻¹` without their zero blocks, plus one [`Block`] for every one or two of the K columns.
#[derive(Clone, Debug)]
pub(crate) struct EigenForm {
    blocks: Vec<Block>,
    /// T: columns are (generalised) eigenvectors.
    right: BlockTriangular,
    /// T⁻¹: rows are the dual functionals; row 0 is the limit position.
    left: BlockTriangular,
    scale: f64,
}

impl EigenForm {
    /// The form of `a`, the K × K local subdivision matrix in row-major order, whose first `ring_len` points are the
    /// ring. `n` is the valence of a smooth vertex (at least 2) or the number of faces of a sector (at least 1), `i` the
    /// number of the face in it.
    ///
    /// Of `a`, the rows of the outer points are used, and those of the ring where the sharp curve drives the inside.
    ///
    /// `None` where the kind has no such form (darts, pinned interior vertices).
    ///
    /// # Panics
    /// If `a` is not K × K.
    pub(crate) fn new(kind: Kind, n: usize, i: usize, a: &[f64], ring_len: usize) -> Option<Self> {
        if matches!(kind, Kind::Dart | Kind::Pinned) {
            return None;
        }
        let inside = |edge| kind == Kind::Smooth || (edge != 0 && edge != n);
        let mut outer = OuterModes::new(inside(i), inside(i + 1));
        let points = ring_len + outer.len();
        assert_eq!(a.len(), points * points, "the matrix of {kind:?} {n}, face {i} has {points} rows");
        let (ring_rows, outer_rows) = a.split_at(ring_len * points);
        let mut ring = match kind {
            Kind::Smooth => ring::smooth(n),
            Kind::Crease => ring::crease(n, |x| multiply(ring_rows, points, x)),
            Kind::Corner => ring::corner(n, |x| multiply(ring_rows, points, x)),
            Kind::Dart | Kind::Pinned => unreachable!("no such form"),
        };
        // The order of the paper's Figure 4; the constant comes first.
        ring.sort_by(|a, b| b.eigenvalue.abs().total_cmp(&a.eigenvalue.abs()));
        // Valence 2: the ring's last eigenvalue is S12's 1/8, and its vector drives the outer points' there.
        let through_outer = kind == Kind::Smooth && n == 2;
        if through_outer {
            outer.lead_with(&multiply(outer_rows, points, &ring[ring.len() - 1].right[0]));
        }

        let mut blocks = Vec::with_capacity(points);
        let mut right = BlockTriangular::zeros(ring_len, outer.len());
        let mut left = BlockTriangular::zeros(ring_len, outer.len());
        let mut start = 0;
        for block in &ring {
            blocks.push(Block { eigenvalue: block.eigenvalue, size: block.right.len(), start });
            let mut eigenvector: Option<Vec<f64>> = None;
            for (offset, (column, row)) in block.right.iter().zip(&block.left).enumerate().rev() {
                let at = start + offset;
                // The outer part of the column, in the basis of S12's eigenvectors. The constant is all ones.
                let driven = outer.coefficients(&multiply(outer_rows, points, column));
                let extension = outer.extend(block.eigenvalue, &driven, eigenvector.as_deref());
                let outside = if at == 0 { vec![1.0; outer.len()] } else { outer.combine(&extension) };
                for (p, &x) in column.iter().chain(&outside).enumerate() {
                    *right.at(p, at) = x;
                }
                for (p, &x) in row.iter().enumerate() {
                    *left.at(at, p) = x;
                    for (mode, &y) in extension.iter().enumerate() {
                        *left.at(ring_len + mode, p) -= y * x;
                    }
                }
                eigenvector = Some(extension);
            }
            start += block.right.len();
        }
        for (mode, &eigenvalue) in outer.eigenvalues.iter().enumerate() {
            match blocks.last_mut() {
                Some(last) if through_outer && mode == 0 => last.size = 2,
                _ => blocks.push(Block { eigenvalue, size: 1, start: ring_len + mode }),
            }
            for p in 0..outer.len() {
                *right.at(ring_len + p, ring_len + mode) = outer.right[mode][p];
                *left.at(ring_len + mode, ring_len + p) = outer.left[mode][p];
            }
        }
        let scale = blocks[1..].iter().map(|block| block.eigenvalue.abs()).fold(0.0, f64::max);
        Some(Self { blocks, right, left, scale })
    }

    /// `row := row · (A^m - 1 lᵀ) / scale^m`, `l` the limit mask. Any depth m will do: the papers' clamping of (u,v) away
    /// from the vertex is not needed. Nothing for `m = 0`. With `without_half` the modes of eigenvalue 1/2 are left out too: for second
    /// derivatives where those modes are linear functions.
    pub(crate) fn apply(&self, m: u32, row: &mut [f64], without_half: bool) {
        if m == 0 {
            return;
        }
        let mut coefficients = self.right.left_multiply(row);
        // The constant is apart.
        coefficients[0] = 0.0;
        for block in &self.blocks {
            if without_half && block.eigenvalue == 0.5 {
                coefficients[block.start..block.start + block.size].fill(0.0);
            }
            let [diagonal, below] = self.relative_power(block, m);
            for at in block.start..block.start + block.size {
                let next = if at + 1 < block.start + block.size { coefficients[at + 1] } else { 0.0 };
                coefficients[at] = diagonal * coefficients[at] + below * next;
            }
        }
        row.copy_from_slice(&self.left.left_multiply(&coefficients));
    }

    /// The subdominant eigenvalue: the largest magnitude after 1.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// The blocks of `J`: those of the ring by decreasing magnitude, then those of the outer points. The first is the
    /// constant.
    #[cfg(test)]
    pub(crate) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Bytes held by the decomposition.
    pub(crate) fn storage_bytes(&self) -> usize {
        size_of_val(&*self.blocks) + self.right.storage_bytes() + self.left.storage_bytes()
    }

    /// The diagonal `(μ/λ)^m` and subdiagonal `m μ^(m-1) / λ^m` of the block's power over `λ^m`, λ = scale.
    fn relative_power(&self, block: &Block, m: u32) -> [f64; 2] {
        let ratio = block.eigenvalue / self.scale;
        let exponent = i32::try_from(m).expect("a depth fits into 31 bits");
        [ratio.powi(exponent), f64::from(m) * ratio.powi(exponent - 1) / self.scale]
    }
}

/// A K × K matrix whose upper right block is zero and not stored.
#[derive(Clone, Debug)]
struct BlockTriangular {
    ring: usize,
    points: usize,
    /// ring × ring.
    upper: Vec<f64>,
    /// (points - ring) × points.
    lower: Vec<f64>,
}

impl BlockTriangular {
    fn zeros(ring: usize, outer: usize) -> Self {
        let points = ring + outer;
        Self { ring, points, upper: vec![0.0; ring * ring], lower: vec![0.0; outer * points] }
    }

    /// The entry at a row and a column outside the zero block.
    fn at(&mut self, row: usize, column: usize) -> &mut f64 {
        if row < self.ring {
            &mut self.upper[row * self.ring + column]
        } else {
            &mut self.lower[(row - self.ring) * self.points + column]
        }
    }

    /// The stored part of a row.
    fn row(&self, row: usize) -> &[f64] {
        if row < self.ring {
            &self.upper[row * self.ring..][..self.ring]
        } else {
            &self.lower[(row - self.ring) * self.points..][..self.points]
        }
    }

    /// `row · self`.
    fn left_multiply(&self, row: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.points];
        for (r, w) in row.iter().enumerate().filter(|(_, w)| **w != 0.0) {
            out.iter_mut().zip(self.row(r)).for_each(|(o, x)| *o += w * x);
        }
        out
    }

    fn storage_bytes(&self) -> usize {
        size_of_val(&*self.upper) + size_of_val(&*self.lower)
    }
}

/// Rows of `width` numbers times the column `x`, which may be shorter.
fn multiply(rows: &[f64], width: usize, x: &[f64]) -> Vec<f64> {
    rows.chunks_exact(width).map(|row| dot(row, x)).collect()
}

/// `Σ a[p] b[p]` over the shorter of the two.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
