//! One polynomial piece at many parameters. One after the other, the vector lanes are the components of four coefficients, so
//! that a sample fills them however few others lie on its piece; where many do, the lanes are sixteen samples. Both ways do the
//! same operations in the same order, so that they give the same bits.
//!
//! Pieces come as the coefficients of [`SubPatch`](super::plan::SubPatch): sixteen of a bicubic patch, see [`powers`](super::powers), or fifteen of a
//! quartic one, see [`EXPONENTS`](super::box_spline::EXPONENTS). Values of more than four components are evaluated in parts.
//! Loops are written out, since closures given to the standard library are not compiled for the machine's own vectors.

use super::plan::Pose;
use super::powers;
use crate::kernel::{LANES, PART, Part, transposed};
use crate::real::Real;
use crate::scheme::SplitKind;
use fearless_simd::Simd;

/// Coefficients, four rows of four: of number `4 j + i` component `c` at `4 i + c` of row `j`.
pub(super) type Panel<T> = [[T; LANES]; 4];

/// The same as vectors.
pub(super) type Rows<T, S> = [<T as crate::kernel::Lanes>::Block<S>; 4];

/// Factors of derivatives: those in the face's `u`, then `v`, from those in the piece's `s` and `t`.
pub(super) type Turn<T> = [[T; 2]; 2];

/// The factors of a piece; none where derivatives stay as they are.
#[inline(always)]
pub(super) fn turns<T: Real>(pose: Pose, split: SplitKind) -> Option<Turn<T>> {
    if pose.is_plain() {
        return None;
    }
    let [u, v] = pose.jacobian(split);
    Some([[T::from_f64(u[0]), T::from_f64(u[1])], [T::from_f64(v[0]), T::from_f64(v[1])]])
}

/// A part of a piece of a face, on lines of the cache.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Piece<T> {
    pub panel: Panel<T>,
    pub frame: Frame<T>,
}

/// How a part of a piece lies.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Frame<T> {
    /// What the coefficients are relative to.
    pub base: Part<T>,
    /// Factors of derivatives.
    pub turn: Option<Turn<T>>,
}

impl<T: Real> Frame<T> {
    /// A sample at the piece's own parameters: position, derivatives in the face's parameters `u`, `v` (`R = 3`), and `uu`,
    /// `uv`, `vv` (`R = 6`).
    #[inline(always)]
    pub fn sample<S: Simd, const R: usize>(
        &self,
        simd: S,
        split: SplitKind,
        rows: &Rows<T, S>,
        [s, t]: [T; 2],
    ) -> [Part<T>; R] {
        let mut values = match split {
            SplitKind::Quads => powers::evaluate::<T, S, R>(simd, rows, s, t),
            SplitKind::Triangles => quartic::<T, S, R>(simd, rows, s, t),
        };
        values[0] = T::four_plus(simd, T::four(simd, self.base), values[0]);
        if let Some([u, v]) = &self.turn {
            if R > 1 {
                let [s, t] = [values[1], values[2]];
                values[1] = T::four_plus(simd, scaled::<T, S>(simd, u[0], s), scaled::<T, S>(simd, u[1], t));
                values[2] = T::four_plus(simd, scaled::<T, S>(simd, v[0], s), scaled::<T, S>(simd, v[1], t));
            }
            if R > 3 {
                let [ss, st, tt] = [values[3], values[4], values[5]];
                // Products of powers of two, so exact.
                for (r, [a, b]) in [[u, u], [u, v], [v, v]].into_iter().enumerate() {
                    let bend = [a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[1] * b[1]];
                    let sum = T::four_plus(simd, scaled::<T, S>(simd, bend[0], ss), scaled::<T, S>(simd, bend[1], st));
                    values[3 + r] = T::four_plus(simd, sum, scaled::<T, S>(simd, bend[2], tt));
                }
            }
        }
        let mut out = [[T::default(); PART]; R];
        for r in 0..R {
            out[r] = T::part(simd, values[r]);
        }
        out
    }
}

impl<T: Real> Piece<T> {
    /// Takes coefficients in.
    #[inline(always)]
    pub fn set<S: Simd>(&mut self, simd: S, rows: &Rows<T, S>, frame: Frame<T>) {
        self.set_rows(simd, rows);
        self.frame = frame;
    }

    /// The same, the frame as it is.
    #[inline(always)]
    pub fn set_rows<S: Simd>(&mut self, simd: S, rows: &Rows<T, S>) {
        for j in 0..4 {
            T::store(simd, rows[j], &mut self.panel[j]);
        }
    }

    /// The coefficients as vectors.
    #[inline(always)]
    pub fn rows<S: Simd>(&self, simd: S) -> Rows<T, S> {
        let mut rows = [T::splat(simd, T::default()); 4];
        for j in 0..4 {
            rows[j] = T::load(simd, &self.panel[j]);
        }
        rows
    }

    /// [`Frame::sample`] of a bicubic piece at sixteen places, one a lane, with the same bits: component by component.
    #[inline(always)]
    pub fn sixteen<S: Simd, const N: usize, const R: usize>(
        &self,
        simd: S,
        s: T::Block<S>,
        t: T::Block<S>,
    ) -> [[T::Block<S>; PART]; R] {
        let mut out = [[s; PART]; R];
        for c in 0..if N < PART { N } else { PART } {
            let mut values = powers::evaluate_sixteen::<T, S, R>(simd, &self.panel, c, s, t);
            values[0] = T::plus(simd, T::splat(simd, self.frame.base[c]), values[0]);
            if let Some(turn) = &self.frame.turn {
                values = turned_sixteen::<T, S, R>(simd, turn, values);
            }
            for r in 0..R {
                out[r][c] = values[r];
            }
        }
        out
    }
}

/// Derivatives in the face's parameters from those in the piece's.
#[inline(always)]
fn turned_sixteen<T: Real, S: Simd, const R: usize>(
    simd: S,
    [u, v]: &Turn<T>,
    mut values: [T::Block<S>; R],
) -> [T::Block<S>; R] {
    if R > 1 {
        let [s, t] = [values[1], values[2]];
        values[1] = T::plus(simd, scaled_block::<T, S>(simd, u[0], s), scaled_block::<T, S>(simd, u[1], t));
        values[2] = T::plus(simd, scaled_block::<T, S>(simd, v[0], s), scaled_block::<T, S>(simd, v[1], t));
    }
    if R > 3 {
        let [ss, st, tt] = [values[3], values[4], values[5]];
        for (r, [a, b]) in [[u, u], [u, v], [v, v]].into_iter().enumerate() {
            let bend = [a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[1] * b[1]];
            let sum = T::plus(simd, scaled_block::<T, S>(simd, bend[0], ss), scaled_block::<T, S>(simd, bend[1], st));
            values[3 + r] = T::plus(simd, sum, scaled_block::<T, S>(simd, bend[2], tt));
        }
    }
    values
}

#[inline(always)]
fn scaled_block<T: Real, S: Simd>(simd: S, factor: T, x: T::Block<S>) -> T::Block<S> {
    T::times(simd, T::splat(simd, factor), x)
}

#[inline(always)]
fn scaled<T: Real, S: Simd>(simd: S, factor: T, x: T::Four<S>) -> T::Four<S> {
    T::four_times(simd, T::four(simd, [factor; PART]), x)
}

/// Coefficients from control points, which are points of the ring.
#[inline(always)]
pub(super) fn from_points<T: Real, S: Simd>(
    simd: S,
    chosen: &[u8; LANES],
    ring: impl Fn(usize) -> Part<T> + Copy,
) -> Rows<T, S> {
    let mut points = [[T::four(simd, [T::default(); PART]); 4]; 4];
    for j in 0..4 {
        for i in 0..4 {
            points[j][i] = T::four(simd, ring(usize::from(chosen[4 * j + i])));
        }
    }
    powers::coefficients_of::<T, S>(simd, points)
}

/// Coefficients from their weights over the ring.
#[inline(always)]
pub(super) fn weighted<T: Real, S: Simd, const N: usize>(
    simd: S,
    blocks: &[[T; LANES]],
    ring: impl Fn(usize) -> Part<T> + Copy,
) -> Rows<T, S> {
    let mut sums = [T::splat(simd, T::default()); PART];
    for p in 0..blocks.len() {
        let (weights, point) = (T::load(simd, &blocks[p]), ring(p));
        for c in 0..if N < PART { N } else { PART } {
            sums[c] = T::plus(simd, sums[c], T::times(simd, weights, T::splat(simd, point[c])));
        }
    }
    transposed::<T, S>(simd, sums)
}

/// The same of two pieces at once, with the same bits: points are read once, and one sum need not wait for the other.
#[inline(always)]
pub(super) fn weighted_twice<T: Real, S: Simd, const N: usize>(
    simd: S,
    blocks: [&[[T; LANES]]; 2],
    ring: &[Part<T>],
) -> [Rows<T, S>; 2] {
    let mut sums = [[T::splat(simd, T::default()); PART]; 2];
    for ((first, second), point) in blocks[0].iter().zip(blocks[1]).zip(ring) {
        let weights = [T::load(simd, first), T::load(simd, second)];
        for c in 0..if N < PART { N } else { PART } {
            let x = T::splat(simd, point[c]);
            for i in 0..2 {
                sums[i][c] = T::plus(simd, sums[i][c], T::times(simd, weights[i], x));
            }
        }
    }
    [transposed::<T, S>(simd, sums[0]), transposed::<T, S>(simd, sums[1])]
}

/// A sample of a quartic patch: Horner's rule in t, then in s, derivatives alongside.
#[inline(always)]
fn quartic<T: Real, S: Simd, const R: usize>(simd: S, rows: &Rows<T, S>, s: T, t: T) -> [T::Four<S>; R] {
    let mut panel = [[T::default(); LANES]; 4];
    for j in 0..4 {
        T::store(simd, rows[j], &mut panel[j]);
    }
    let [value, first, bend] = horner(&panel, s, t);
    let mut values = [T::four(simd, value[0]); R];
    if R > 1 {
        (values[1], values[2]) = (T::four(simd, value[1]), T::four(simd, first[0]));
    }
    if R > 3 {
        (values[3], values[4]) = (T::four(simd, value[2]), T::four(simd, first[1]));
        values[5] = T::four(simd, bend[0]);
    }
    values
}

/// The derivatives of a quartic: entry `[i][j]` is `i` times in t and `j` times in s, up to the second.
#[inline(always)]
fn horner<T: Real>(panel: &Panel<T>, s: T, t: T) -> [[Part<T>; 3]; 3] {
    const FIRST: [usize; 5] = [0, 5, 9, 12, 14];
    let two = T::from_f64(2.0);
    let mut out = [[[T::default(); PART]; 3]; 3];
    for p in [4, 3, 2, 1, 0] {
        // The polynomial in t that stands at s^p.
        let mut column = [[T::default(); PART]; 3];
        for q in [4, 3, 2, 1, 0] {
            if p + q <= 4 {
                let k = FIRST[p] + q;
                for c in 0..PART {
                    column[2][c] = column[2][c] * t + two * column[1][c];
                    column[1][c] = column[1][c] * t + column[0][c];
                    column[0][c] = column[0][c] * t + panel[k / 4][4 * (k % 4) + c];
                }
            }
        }
        for i in 0..3 {
            for c in 0..PART {
                out[i][2][c] = out[i][2][c] * s + two * out[i][1][c];
                out[i][1][c] = out[i][1][c] * s + out[i][0][c];
                out[i][0][c] = out[i][0][c] * s + column[i][c];
            }
        }
    }
    out
}
