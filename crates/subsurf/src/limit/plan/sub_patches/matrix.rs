//! The matrix of a piece: its control points over the points of its leaf, and these, step by step upwards, over the ring;
//! at last from control points to coefficients.

use super::super::{Child, End, Leaf, LeafShape, Place, Plan, Split, corners};
use super::SubPatch;
use crate::kernel::LANES;
use crate::limit::box_spline::{EXPONENTS, POLYNOMIALS};
use crate::limit::powers;
use crate::limit::single_crease;
use crate::real::Real;
use crate::scheme::SplitKind;

impl Plan<'_> {
    /// Makes the matrix of the piece that holds `(u, v)`.
    pub(super) fn piece<T: Real>(self, u: f64, v: f64, turn: u8) -> SubPatch<T> {
        let mut way: Vec<(usize, &Split, &Child)> = Vec::new();
        let (end, at, last) = self.walk(u, v, turn, 0, |node, split, child| way.push((node.ring, split, child)));
        let End::Leaf(leaf) = end else { unreachable!("the ends of linear boundaries have no pieces") };
        let over_ring = |local: &[[f64; LANES]]| {
            let mut blocks = vec![[0.0; LANES]; last.ring];
            multiply(local, 0..local.len(), |i| leaf.points.row(i), &mut blocks);
            for &(ring, split, child) in way.iter().rev() {
                let mut above = vec![[0.0; LANES]; ring];
                multiply(
                    &blocks,
                    split.ring(child).iter().map(|&row| row as usize),
                    |i| split.points.row(i),
                    &mut above,
                );
                blocks = above;
            }
            blocks
        };
        let split = self.plans.split;
        let local = leaf.pieces(split, at);
        let is_plain = split == SplitKind::Quads && matches!(leaf.shape, LeafShape::Regular) && at.depth == 0;
        if is_plain && let Some(chosen) = chosen(&over_ring(&local.points)) {
            return SubPatch::Chosen(chosen);
        }
        // Over the leaf's points first: on the way up no coefficient meets another, so that small ones keep their digits.
        let coefficients = over_ring(&local.coefficients(split));
        SubPatch::Weighted(coefficients.iter().map(|block| block.map(T::from_f64)).collect())
    }
}

/// Powers of s and t that coefficient `k` belongs to.
fn exponents(split: SplitKind, k: usize) -> (usize, usize) {
    match split {
        SplitKind::Quads => (k % 4, k / 4),
        SplitKind::Triangles => EXPONENTS.get(k).copied().unwrap_or_default(),
    }
}

/// Which coefficients have control points of their own, since those of the position would lose digits.
#[derive(Clone, Copy)]
enum Fine {
    /// What is neither constant nor linear: at a special vertex with linear modes, which these leave out.
    Bent,
    /// What changes with t: next to a semi-sharp crease, relative to the crease.
    Across,
}

impl Fine {
    /// True if the coefficient of `s^p t^q` comes from them.
    fn serves(self, (p, q): (usize, usize)) -> bool {
        match self {
            Self::Bent => p + q > 1,
            Self::Across => q > 0,
        }
    }
}

/// Control points of a piece over the points of its leaf.
struct LocalPoints {
    points: Vec<[f64; LANES]>,
    /// What they are relative to, if to something.
    origin: Option<Vec<f64>>,
    fine: Option<(Fine, Vec<[f64; LANES]>)>,
}

impl LocalPoints {
    /// The coefficients of the piece over the points of its leaf.
    fn coefficients(self, split: SplitKind) -> Vec<[f64; LANES]> {
        let of = |mut blocks: Vec<[f64; LANES]>| {
            if split == SplitKind::Quads {
                blocks.iter_mut().for_each(|block| *block = powers::coefficients(block));
            }
            blocks
        };
        let mut all = of(self.points);
        if let Some(origin) = self.origin {
            all.iter_mut().zip(&origin).for_each(|(block, w)| block[0] += w);
        }
        if let Some((which, fine)) = self.fine {
            for (block, fine) in all.iter_mut().zip(of(fine)) {
                for k in (0..LANES).filter(|&k| which.serves(exponents(split, k))) {
                    block[k] = fine[k];
                }
            }
        }
        all
    }
}

impl Leaf {
    /// Control points of the piece that holds a place.
    fn pieces(&self, split: SplitKind, at: Place) -> LocalPoints {
        let total = |turn: u8| (at.turn + turn) % corners(split) as u8;
        let only = |rows: &[Vec<f64>]| LocalPoints { points: lanes(rows), origin: None, fine: None };
        let unit = |k: usize, n: usize| (0..n).map(|i| f64::from(u8::from(i == k))).collect::<Vec<f64>>();
        let polynomials = |rows: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let combine = |weights: &[f64; 12]| {
                let sum = |c: usize| weights.iter().zip(rows).map(|(w, row)| w * row[c]).sum();
                (0..rows[0].len()).map(sum).collect()
            };
            POLYNOMIALS.iter().map(combine).collect()
        };
        match (&self.shape, split) {
            (LeafShape::Linear, _) => unreachable!("linear leaves have no pieces"),
            (LeafShape::Regular, SplitKind::Quads) => only(&(0..16).map(|k| unit(k, 16)).collect::<Vec<_>>()),
            (LeafShape::Regular, SplitKind::Triangles) => {
                only(&polynomials(&(0..12).map(|k| unit(k, 12)).collect::<Vec<_>>()))
            }
            (LeafShape::SingleCrease { turn, sharpness }, _) => {
                let (_, distance) = at.turned(split, (total(*turn) + 2) % 4);
                let sharpness = sharpness + f64::from(at.raise);
                let (level, across) = single_crease::piece(sharpness, single_crease::piece_at(distance, sharpness));
                let points = |crease: f64| {
                    let point = |k: usize| {
                        let mut row = vec![0.0; 16];
                        (0..4).for_each(|y| row[4 * y + k % 4] = across[k / 4][y]);
                        row[8 + k % 4] += crease;
                        row
                    };
                    lanes(&(0..16).map(point).collect::<Vec<_>>())
                };
                let fine = (level > 0).then(|| (Fine::Across, points(0.0)));
                LocalPoints { points: points(1.0), origin: None, fine }
            }
            (LeafShape::Special { turn, vertex }, _) => {
                let (a, b) = at.turned(split, total(*turn));
                let child = vertex.child(a, b).expect("the vertex itself has no piece");
                let rows = |second: bool| {
                    let rows = vertex.child_points(child.depth, child.index, second);
                    lanes(&if split == SplitKind::Triangles { polynomials(&rows) } else { rows })
                };
                let is_deep = child.depth > 0;
                LocalPoints {
                    points: rows(false),
                    origin: is_deep.then(|| vertex.limit().to_vec()),
                    fine: (is_deep && vertex.parts_second()).then(|| (Fine::Bent, rows(true))),
                }
            }
        }
    }
}

/// Rows as lanes, column by column.
fn lanes(rows: &[Vec<f64>]) -> Vec<[f64; LANES]> {
    (0..rows[0].len()).map(|c| std::array::from_fn(|k| rows.get(k).map_or(0.0, |row| row[c]))).collect()
}

/// `out += leftᵀ · rows`, the row of each block by its index.
fn multiply<R: Iterator<Item = (u32, f64)>>(
    left: &[[f64; LANES]],
    index: impl IntoIterator<Item = usize>,
    row: impl Fn(usize) -> R,
    out: &mut [[f64; LANES]],
) {
    for (block, i) in left.iter().zip(index) {
        for (c, w) in row(i) {
            out[c as usize].iter_mut().zip(block).for_each(|(o, x)| *o += x * w);
        }
    }
}

/// The points of the ring that the control points are, if each is one.
fn chosen(blocks: &[[f64; LANES]]) -> Option<[u8; LANES]> {
    let mut chosen = [0; LANES];
    for (k, chosen) in chosen.iter_mut().enumerate() {
        let mut used = blocks.iter().enumerate().filter(|(_, block)| block[k] != 0.0);
        let (p, block) = used.next()?;
        if block[k] != 1.0 || used.next().is_some() {
            return None;
        }
        *chosen = u8::try_from(p).ok()?;
    }
    Some(chosen)
}
