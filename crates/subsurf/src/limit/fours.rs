//! Four samples of one bicubic piece at a time. Lane `4 c + k` of a block is component `c` of sample `k`: weights of four
//! samples are repeated, the components of a control point are spread, and no lane waits for another.
//!
//! Products and sums come in the order of [`Piece::sample`], which gives the same bits one sample at a time.

use super::bspline::ORDERS;
use super::lanes::{Curves, Panel, Piece, Turn, curves, weighted};
use super::plan::{ControlPoints, Fine, SubPatch};
use crate::kernel::{LANES, PART, Part, put};
use crate::real::Real;
use fearless_simd::Simd;

/// Samples of a block.
const FOUR: usize = LANES / PART;

/// Sixteen control points, rows of four, or rows that are combined.
type Spread<T, S> = [[<T as crate::kernel::Lanes>::Block<S>; 4]; 4];

/// A part of a bicubic piece, each component four times.
pub(super) struct Fours<T: Real, S: Simd> {
    panel: Spread<T, S>,
    /// Those of some derivatives alone.
    finer: Option<(Fine, Spread<T, S>)>,
    origin: T::Block<S>,
    turn: Option<Turn<T>>,
}

impl<T: Real, S: Simd> Fours<T, S> {
    #[inline(always)]
    pub fn new(simd: S, piece: &Piece<T>, finer: Option<&Panel<T>>) -> Self {
        let finer = match (piece.fine, finer) {
            (Some(fine), Some(finer)) => Some((fine, spread::<T, S>(simd, finer))),
            _ => None,
        };
        let origin = components::<T, S>(simd, piece.origin);
        Self { panel: spread::<T, S>(simd, &piece.panel), finer, origin, turn: piece.turn }
    }

    /// That of a face which is one piece, from its ring relative to `base`.
    #[inline(always)]
    pub fn whole<const N: usize>(
        simd: S,
        matrices: &SubPatch<T>,
        turn: Option<Turn<T>>,
        base: Part<T>,
        ring: impl Fn(usize) -> Part<T> + Copy,
    ) -> Self {
        let mut panel = [[T::splat(simd, T::default()); 4]; 4];
        match &matrices.points {
            ControlPoints::Chosen(chosen) => {
                for k in 0..LANES {
                    panel[k / 4][k % 4] = components::<T, S>(simd, ring(usize::from(chosen[k])));
                }
            }
            ControlPoints::Weighted(blocks) => panel = spread::<T, S>(simd, &weighted::<T, S, N>(simd, blocks, ring)),
        }
        Self { panel, finer: None, origin: components::<T, S>(simd, base), turn }
    }

    /// Evaluates samples at `s`, `t`, as many as have numbers, and writes components from number `first` on to their rows.
    #[inline(always)]
    pub fn evaluate<const N: usize, const R: usize, const W: usize>(
        &self,
        simd: S,
        (s, t): (&[T; W], &[T; W]),
        number: &[u32],
        first: usize,
        rows: &mut [[[T; N]; R]],
    ) {
        let (along, across) = (curves::<T, R, W>(s), curves::<T, R, W>(t));
        for four in number.chunks(FOUR).zip(0..W / FOUR) {
            let (number, at) = (four.0, FOUR * four.1);
            let values = self.four::<R, W>(simd, &along, &across, at);
            let mut samples = [[[T::default(); PART]; R]; FOUR];
            for r in 0..R {
                let turned = T::turned(simd, values[r]);
                for k in 0..FOUR {
                    samples[k][r] = turned[k];
                }
            }
            // As long as the samples are, so that they need not be stored to be chosen from.
            for k in 0..FOUR {
                if k < number.len() {
                    put(&samples[k], first, &mut rows[number[k] as usize]);
                }
            }
        }
    }

    /// The four samples from number `at` on of those that the weights are for.
    #[inline(always)]
    fn four<const R: usize, const W: usize>(
        &self,
        simd: S,
        along: &Curves<T, W>,
        across: &Curves<T, W>,
        at: usize,
    ) -> [T::Block<S>; R] {
        let orders = 1 + R / 3;
        let mut rows = [[T::splat(simd, T::default()); 4]; 3];
        let mut values = [T::splat(simd, T::default()); R];
        for order in 0..orders {
            rows[order] = combined(simd, &self.panel, &across[order], at);
        }
        for r in 0..R {
            let (in_s, in_t) = ORDERS[r];
            values[r] = sum(simd, &along[in_s], &rows[in_t], at);
        }
        if let Some((fine, panel)) = &self.finer {
            for order in 0..orders {
                rows[order] = combined(simd, panel, &across[order], at);
            }
            for r in 0..R {
                let (in_s, in_t) = ORDERS[r];
                if fine.serves(r) {
                    values[r] = sum(simd, &along[in_s], &rows[in_t], at);
                }
            }
        }
        values[0] = T::plus(simd, self.origin, values[0]);
        if let Some(turn) = &self.turn {
            turned(simd, turn, &mut values);
        }
        values
    }
}

/// Derivatives in the face's parameters from those in the piece's.
#[inline(always)]
fn turned<T: Real, S: Simd, const R: usize>(simd: S, [u, v]: &Turn<T>, values: &mut [T::Block<S>; R]) {
    if R > 1 {
        let [s, t] = [values[1], values[2]];
        values[1] = T::plus(simd, scaled(simd, u[0], s), scaled(simd, u[1], t));
        values[2] = T::plus(simd, scaled(simd, v[0], s), scaled(simd, v[1], t));
    }
    if R > 3 {
        let [ss, st, tt] = [values[3], values[4], values[5]];
        // Products of powers of two, so exact.
        for (r, [a, b]) in [[u, u], [u, v], [v, v]].into_iter().enumerate() {
            let bend = [a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[1] * b[1]];
            let sum = T::plus(simd, scaled(simd, bend[0], ss), scaled(simd, bend[1], st));
            values[3 + r] = T::plus(simd, sum, scaled(simd, bend[2], tt));
        }
    }
}

#[inline(always)]
fn scaled<T: Real, S: Simd>(simd: S, factor: T, a: T::Block<S>) -> T::Block<S> {
    T::times(simd, T::splat(simd, factor), a)
}

/// Each of sixteen numbers four times.
#[inline(always)]
fn fourfold<T: Real, S: Simd>(simd: S, x: T::Block<S>) -> [T::Block<S>; 4] {
    let [low, high] = T::zip(simd, x, x);
    let ([a, b], [c, d]) = (T::zip(simd, low, low), T::zip(simd, high, high));
    [a, b, c, d]
}

/// Each component four times.
#[inline(always)]
fn components<T: Real, S: Simd>(simd: S, part: Part<T>) -> T::Block<S> {
    let four = T::repeat(simd, &part);
    let [two, _] = T::zip(simd, four, four);
    T::zip(simd, two, two)[0]
}

#[inline(always)]
fn spread<T: Real, S: Simd>(simd: S, panel: &Panel<T>) -> Spread<T, S> {
    let mut all = [[T::splat(simd, T::default()); 4]; 4];
    for j in 0..4 {
        all[j] = fourfold::<T, S>(simd, T::load(simd, &panel[j]));
    }
    all
}

/// The weights of one control point in four samples, for all components.
#[inline(always)]
fn repeated<T: Real, S: Simd, const W: usize>(simd: S, weights: &[T; W], at: usize) -> T::Block<S> {
    let mut four = [T::default(); FOUR];
    if let Some(chunk) = weights[at..].first_chunk() {
        four = *chunk;
    }
    T::repeat(simd, &four)
}

/// The rows of control points, combined.
#[inline(always)]
fn combined<T: Real, S: Simd, const W: usize>(
    simd: S,
    panel: &Spread<T, S>,
    weights: &[[T; W]; 4],
    at: usize,
) -> [T::Block<S>; 4] {
    let first = repeated(simd, &weights[0], at);
    let mut sums = [first; 4];
    for i in 0..4 {
        sums[i] = T::times(simd, first, panel[0][i]);
    }
    for j in 1..4 {
        let weight = repeated(simd, &weights[j], at);
        for i in 0..4 {
            sums[i] = T::plus(simd, sums[i], T::times(simd, weight, panel[j][i]));
        }
    }
    sums
}

/// A row of control points times weights, in the order of [`Lanes::quarters`](crate::kernel::Lanes::quarters).
#[inline(always)]
fn sum<T: Real, S: Simd, const W: usize>(
    simd: S,
    weights: &[[T; W]; 4],
    row: &[T::Block<S>; 4],
    at: usize,
) -> T::Block<S> {
    let mut terms = *row;
    for i in 0..4 {
        terms[i] = T::times(simd, repeated(simd, &weights[i], at), row[i]);
    }
    T::plus(simd, T::plus(simd, terms[0], terms[2]), T::plus(simd, terms[1], terms[3]))
}
