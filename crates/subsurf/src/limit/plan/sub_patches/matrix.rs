//! The matrix of a piece: its coefficients over the points of its leaf, and these, step by step upwards, over the ring. Over
//! the leaf's points they are the same for all regular leaves, and for all leaves at one kind of special vertex.

use super::super::{Child, End, Leaf, LeafShape, Place, Plan, Split, corners};
use super::{DEEPEST_PIECE, PIECES_AT_VERTEX, SubPatch};
use crate::kernel::{LANES, Lanes, level};
use crate::limit::box_spline::{EXPONENTS, POLYNOMIALS};
use crate::limit::powers;
use crate::limit::rows::Rows;
use crate::limit::single_crease;
use crate::limit::special::SpecialVertex;
use crate::real::Real;
use crate::scheme::SplitKind;
use fearless_simd::{Simd, dispatch};
use std::cell::RefCell;
use std::sync::{LazyLock, OnceLock};

/// Coefficients of a piece, as sums over points: a block for each.
type Coefficients = Box<[[f64; LANES]]>;

/// Most points of a special vertex that keeps coefficients. Larger: memory, up to 3 KiB a point for every way in which a face
/// lies at it; smaller: they are made for every plan anew.
const MOST_KEPT: usize = 32;

/// Of a regular quad, over its sixteen control points.
static BICUBIC: LazyLock<Coefficients> = LazyLock::new(|| {
    lanes(&(0..16).map(|k| unit(k, 16)).collect::<Vec<_>>()).iter().map(powers::coefficients).collect()
});

/// Of a regular triangle, over its twelve control points.
static QUARTIC: LazyLock<Coefficients> =
    LazyLock::new(|| lanes(&polynomials(&(0..12).map(|k| unit(k, 12)).collect::<Vec<_>>())).into());

thread_local! {
    /// Coefficients over the points of a node and of the one above.
    static SCRATCH: RefCell<[Vec<[f64; LANES]>; 2]> = RefCell::default();
}

impl Plan<'_> {
    /// Makes the matrix of the piece that holds `(u, v)`.
    pub(super) fn piece<T: Real>(self, u: f64, v: f64, turn: u8) -> SubPatch<T> {
        let mut way: Vec<(usize, &Split, &Child)> = Vec::with_capacity(8);
        let (end, at, last) = self.walk(u, v, turn, 0, |node, split, child| way.push((node.ring, split, child)));
        let End::Leaf(leaf) = end else { unreachable!("the ends of linear boundaries have no pieces") };
        let split = self.plans.split;
        let is_plain = split == SplitKind::Quads && matches!(leaf.shape, LeafShape::Regular) && way.is_empty();
        if is_plain && let Some(chosen) = chosen(&leaf.points) {
            return SubPatch::Chosen(chosen);
        }
        // Over the leaf's points first: on the way up no coefficient meets another, so that small ones keep their digits.
        leaf.with_coefficients(split, at, |local| {
            SCRATCH.with_borrow_mut(|[own, above]| {
                dispatch!(level(), simd => simd.vectorize(
                    #[inline(always)]
                    || {
                        own.clear();
                        own.resize(last.ring, [0.0; LANES]);
                        for (i, block) in local.iter().enumerate() {
                            let (columns, weights) = leaf.points.terms(i);
                            add(simd, block, columns, weights, own);
                        }
                        for &(ring, split, child) in way.iter().rev() {
                            above.clear();
                            above.resize(ring, [0.0; LANES]);
                            for (block, &row) in own.iter().zip(split.ring(child)) {
                                let (columns, weights) = split.points.terms(row as usize);
                                add(simd, block, columns, weights, above);
                            }
                            std::mem::swap(own, above);
                        }
                    }
                ));
                SubPatch::Weighted(own.iter().map(|block| block.map(T::from_f64)).collect())
            })
        })
    }
}

/// Adds the coefficients over a point to those over the points that it is a combination of.
#[inline(always)]
fn add<S: Simd>(simd: S, block: &[f64; LANES], columns: &[u32], weights: &[f64], out: &mut [[f64; LANES]]) {
    let block = f64::load(simd, block);
    for k in 0..if columns.len() < weights.len() { columns.len() } else { weights.len() } {
        let out = &mut out[columns[k] as usize];
        let sum = f64::plus(simd, f64::load(simd, out), f64::times(simd, f64::splat(simd, weights[k]), block));
        f64::store(simd, sum, out);
    }
}

impl Leaf {
    /// Calls `f` with the coefficients of the piece that holds a place, over the leaf's points.
    fn with_coefficients<R>(&self, split: SplitKind, at: Place, f: impl FnOnce(&[[f64; LANES]]) -> R) -> R {
        let total = |turn: u8| (at.turn + turn) % corners(split) as u8;
        match (&self.shape, split) {
            (LeafShape::Linear, _) => unreachable!("linear leaves have no pieces"),
            (LeafShape::Regular, SplitKind::Quads) => f(&BICUBIC),
            (LeafShape::Regular, SplitKind::Triangles) => f(&QUARTIC),
            (LeafShape::SingleCrease { turn, sharpness }, _) => {
                let (_, distance) = at.turned(split, (total(*turn) + 2) % 4);
                let sharpness = sharpness + f64::from(at.raise);
                f(&along_crease(sharpness, single_crease::piece_at(distance, sharpness)))
            }
            (LeafShape::Special { turn, vertex }, _) => {
                let (a, b) = at.turned(split, total(*turn));
                let child = vertex.child(a, b).expect("the vertex itself has no piece");
                let new = || at_vertex(vertex, child.depth, child.index, split);
                match vertex.kept_coefficients().of(child.depth, child.index) {
                    Some(kept) if vertex.points() <= MOST_KEPT => f(kept.get_or_init(new)),
                    _ => f(&new()),
                }
            }
        }
    }
}

/// Coefficients of the pieces at a special vertex over its canonical points, as far as they were met.
#[derive(Default, Debug)]
pub(crate) struct KeptCoefficients(OnceLock<Box<[OnceLock<Coefficients>]>>);

impl KeptCoefficients {
    /// Room for those of a piece.
    fn of(&self, depth: u32, index: usize) -> Option<&OnceLock<Coefficients>> {
        let all = self.0.get_or_init(|| (0..PIECES_AT_VERTEX).map(|_| OnceLock::new()).collect());
        all.get(3 * depth as usize + index).filter(|_| depth <= DEEPEST_PIECE)
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        let all = self.0.get().map_or(&[][..], |all| all);
        size_of_val(all) + all.iter().filter_map(OnceLock::get).map(|kept| size_of_val(&kept[..])).sum::<usize>()
    }
}

/// Coefficients of a segment along a crease: those across it by those along it, for what its control points are relative to the
/// crease, and the crease itself, which is constant across.
fn along_crease(sharpness: f64, number: usize) -> [[f64; LANES]; 16] {
    let (_, across) = single_crease::piece(sharpness, number);
    let mut out = [[0.0; LANES]; 16];
    for y in 0..4 {
        let mut t = powers::curve_coefficients([across[0][y], across[1][y], across[2][y], across[3][y]]);
        if y == 2 {
            t[0] += 1.0;
        }
        for x in 0..4 {
            let mut point = [0.0; 4];
            point[x] = 1.0;
            let s = powers::curve_coefficients(point);
            for k in 0..LANES {
                out[4 * y + x][k] = s[k % 4] * t[k / 4];
            }
        }
    }
    out
}

/// Coefficients of a regular child at a special vertex over the canonical points.
fn at_vertex(vertex: &SpecialVertex, depth: u32, index: usize, split: SplitKind) -> Coefficients {
    let of = |second: bool| -> Coefficients {
        let rows = vertex.child_points(depth, index, second);
        match split {
            SplitKind::Quads => lanes(&rows).iter().map(powers::coefficients).collect(),
            SplitKind::Triangles => lanes(&polynomials(&rows)).into(),
        }
    };
    let mut all = of(false);
    if depth > 0 {
        all.iter_mut().zip(vertex.limit()).for_each(|(block, w)| block[0] += w);
        if vertex.parts_second() {
            // What is neither constant nor linear has control points of its own, since those of the position would lose digits:
            // linear modes are left out.
            for (block, fine) in all.iter_mut().zip(&of(true)) {
                for k in 0..LANES {
                    let (p, q) = exponents(split, k);
                    block[k] = if p + q > 1 { fine[k] } else { block[k] };
                }
            }
        }
    }
    all
}

/// Powers of s and t that coefficient `k` belongs to.
fn exponents(split: SplitKind, k: usize) -> (usize, usize) {
    match split {
        SplitKind::Quads => (k % 4, k / 4),
        SplitKind::Triangles => EXPONENTS.get(k).copied().unwrap_or_default(),
    }
}

fn unit(k: usize, n: usize) -> Vec<f64> {
    (0..n).map(|i| f64::from(u8::from(i == k))).collect()
}

/// Coefficients of a triangle with these control points.
fn polynomials(points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let combine = |weights: &[f64; 12]| {
        let sum = |c: usize| weights.iter().zip(points).map(|(w, row)| w * row[c]).sum();
        (0..points[0].len()).map(sum).collect()
    };
    POLYNOMIALS.iter().map(combine).collect()
}

/// Rows as lanes, column by column.
fn lanes(rows: &[Vec<f64>]) -> Vec<[f64; LANES]> {
    (0..rows[0].len()).map(|c| std::array::from_fn(|k| rows.get(k).map_or(0.0, |row| row[c]))).collect()
}

/// The points of the ring that the control points are, if each is one.
fn chosen(points: &Rows) -> Option<[u8; LANES]> {
    let mut chosen = [0; LANES];
    for (k, chosen) in chosen.iter_mut().enumerate() {
        match points.terms(k) {
            (&[point], &[1.0]) => *chosen = u8::try_from(point).ok()?,
            _ => return None,
        }
    }
    Some(chosen)
}
