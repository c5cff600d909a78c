//! Exact evaluation in a face at a special vertex, constant in the depth: parameters `(a, b)` with the vertex at the
//! origin give weights over the canonical points of [`corner`](super::corner).
//!
//! At depth `m` (the largest with `max(a, b) < 2^-m`; under Loop `a + b`) the location lies in a regular child of the `m`-th subdivision:
//! `s = b(t)ᵀ X_c A^m C`, first derivatives times `2^(m+1)`, second times `4^(m+1)` (Stam 1998; Lacewell, Burley 2007),
//! with `A^m` in one of two closed forms, see [`Method`].

use super::box_spline;
use super::bspline::{cubic, tensor};
use super::corner::{Corner, Kind};
use super::deflated::{Deflated, DeflatedPowers};
use super::eigen::EigenForm;
use super::jet::Derivatives;
use super::local_step::LocalStep;
use super::plan::KeptCoefficients;
use super::tangent::{self, EvenMode};
use crate::scheme::SplitKind;
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

/// Which closed form of the powers of the local step is used.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Method {
    /// Deflated powers: for every kind of vertex, accurate to rounding.
    #[default]
    Deflated,
    /// Stam's eigenbasis at interior vertices and the Jordan form of Lacewell and Burley 2007 at boundaries, creases
    /// and corners. Darts, pinned interior vertices and Loop subdivision, which neither covers, use deflated powers, and so do
    /// vertices of more than 120 faces, whose bases would be dense matrices of their size.
    Eigenbasis,
}

/// Everything that the faces at one kind of special vertex share.
#[derive(Debug)]
pub(crate) struct SpecialVertex {
    pub corner: Corner,
    step: LocalStep,
    /// Limit position mask, over the ring; no other point has a weight.
    limit: Arc<[f64]>,
    deflated: DeflatedPowers,
    /// For second derivatives where the mode of eigenvalue 1/2 is linear and would drown them; made when it is first needed.
    second: OnceLock<DeflatedPowers>,
    eigen: Option<EigenForm>,
    /// Made at the first deep location, where powers are not stored.
    deep: OnceLock<Option<EigenForm>>,
    /// Made when what holds at the vertex itself is first asked for.
    tangents: OnceLock<tangent::Tangents>,
    /// Of a dart, one for all its faces; made when one of them first needs it.
    even: Option<Arc<OnceLock<EvenMode>>>,
    /// True where what all faces at the vertex share is counted here.
    is_first: bool,
    /// Of the pieces that were met.
    coefficients: KeptCoefficients,
}

/// Depth from which on a vertex without stored powers uses its eigenbasis, so that few locations cost more than this many
/// sparse steps. Larger: time; smaller: two dense matrices of `K²` for vertices that are only tessellated. Darts, pinned
/// vertices and Loop vertices of more than 58 faces have no eigenbasis here and take one sparse step per level, and so do
/// vertices of more than [`MOST_EIGEN`] points.
const DEEP: u32 = 16;

/// Most points for which there is an eigenbasis. Larger: memory, two dense matrices of `K²`, for every face of a sector of its
/// own; smaller: time at depths beyond `K / 7`, where sparse steps of `7 K` take longer than two products of `K²`.
const MOST_EIGEN: usize = 256;

/// Most faces of a sharp sector or dart whose special vertices are made each from its own neighbourhood. Larger: memory and time,
/// since a vertex of `n` faces then has `n` masks of `2 n` weights; smaller: bookkeeping for the many vertices of few faces.
const MOST_APART: u32 = 28;

/// Weights over some points, for position, `u`, `v`, `uu`, `uv`, `vv`.
#[derive(Clone, Debug, Default)]
pub(crate) struct PointWeights {
    pub rows: [Vec<f64>; 6],
    pub at_vertex: Option<AtVertex>,
}

/// The regular child of the face in which a location lies.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RegularChild {
    /// How many times the face has been halved before.
    pub depth: u32,
    /// Which of the three.
    pub index: usize,
    /// The location in the child.
    pub u: f64,
    pub v: f64,
    /// -1 in a triangle that is turned upside down.
    pub flip: f64,
}

/// What holds at a special vertex itself.
#[derive(Clone, Debug)]
pub(crate) struct AtVertex {
    pub derivatives: Derivatives,
    /// Two directions that span the tangent plane, `t0 × t1` on the outer side; none where there is no such plane.
    pub plane: Option<[Vec<f64>; 2]>,
    pub unique_normal: bool,
}

impl SpecialVertex {
    pub fn new(corner: Corner, method: Method) -> Self {
        Self::with_step(corner, LocalStep::new(corner), method, None)
    }

    /// A dart from all its faces.
    pub fn all_at_dart(split: SplitKind, n: u32, method: Method) -> Vec<Self> {
        let mut all = Vec::<Self>::with_capacity(n as usize);
        for (i, step) in (0..n).zip(LocalStep::all_at_dart(split, n)) {
            all.push(Self::with_step(Corner { split, kind: Kind::Dart, n, i }, step, method, all.first()));
        }
        all
    }

    /// True where what faces at a vertex share is taken from the vertex as its face 0 sees it.
    pub fn is_of_many(corner: Corner) -> bool {
        corner.n > MOST_APART && !matches!(corner.kind, Kind::Smooth | Kind::Pinned)
    }

    /// The vertex as another face sees it; this one is as face 0 does.
    pub fn for_other_face(&self, corner: Corner, method: Method) -> Self {
        Self::with_step(corner, self.step.of_other_face(corner), method, Some(self))
    }

    /// `first` is the vertex from its first face, where other faces take from it what depends on the valence alone.
    fn with_step(corner: Corner, step: LocalStep, method: Method, first: Option<&Self>) -> Self {
        let limit = match first {
            // The ring is the same.
            Some(first) => first.limit.clone(),
            None => {
                let limit = tangent::limit_mask(corner, &step);
                debug_assert!(limit[step.ring..].iter().all(|&w| w == 0.0));
                limit[..step.ring].into()
            }
        };
        let even = first.and_then(|first| first.even.clone());
        let even = even.or_else(|| (corner.kind == Kind::Dart).then(Arc::default));
        let deflated = DeflatedPowers::new(step.points, subdominant(corner), Vec::new());
        let eigen = if method == Method::Eigenbasis { eigen_form(corner, &step) } else { None };
        let (second, deep, tangents) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        let coefficients = KeptCoefficients::default();
        let is_first = first.is_none();
        Self { corner, step, limit, deflated, second, eigen, deep, tangents, even, is_first, coefficients }
    }

    /// The even mode of a dart, the same bits whichever face asks first.
    fn even(&self) -> Option<&EvenMode> {
        let even = self.even.as_ref()?;
        Some(even.get_or_init(|| EvenMode::new(self.corner, &self.step, &self.limit)))
    }

    /// The directions at the vertex; at one of many faces not kept, since each of these has its own.
    fn tangents(&self) -> Cow<'_, tangent::Tangents> {
        let new = || tangent::Tangents::new(self.corner, &self.step, self.even());
        match Self::is_of_many(self.corner) {
            true => Cow::Owned(new()),
            false => Cow::Borrowed(self.tangents.get_or_init(new)),
        }
    }

    fn second(&self) -> Option<&DeflatedPowers> {
        self.parts_second().then(|| {
            self.second.get_or_init(|| {
                let linear = tangent::linear_modes(self.corner, &self.step, self.even());
                DeflatedPowers::new(self.points(), after_linear(self.corner), linear)
            })
        })
    }

    /// The step from the points of one face to those of its child at the vertex.
    pub fn step(&self) -> &LocalStep {
        &self.step
    }

    /// `λ`, by which powers of the step shrink.
    pub fn scale(&self) -> f64 {
        self.deflated.scale
    }

    /// What is kept of its pieces.
    pub fn kept_coefficients(&self) -> &KeptCoefficients {
        &self.coefficients
    }

    /// Number of canonical points.
    pub fn points(&self) -> usize {
        self.step.points
    }

    /// The regular child that holds `(a, b)`; none at the vertex itself.
    #[inline]
    pub fn child(&self, a: f64, b: f64) -> Option<RegularChild> {
        let big = match self.corner.split {
            SplitKind::Quads => a.max(b),
            SplitKind::Triangles => a + b,
        };
        if big <= 0.0 {
            return None;
        }
        let depth = depth(big);
        let [a, b] = [a, b].map(|x| scale_up(x, depth));
        let (index, u, v, flip) = match self.corner.split {
            SplitKind::Quads => {
                let (cu, cv) = (u8::from(a >= 0.5), u8::from(b >= 0.5));
                // 0, 1 and 2 at (1, 0), (1, 1) and (0, 1), without a branch.
                let index = usize::from(2 - cu * (2 - cv));
                (index, 2.0 * a - f64::from(cu), 2.0 * b - f64::from(cv), 1.0)
            }
            SplitKind::Triangles if a >= 0.5 => (0, 2.0 * a - 1.0, 2.0 * b, 1.0),
            SplitKind::Triangles if b >= 0.5 => (1, 2.0 * a, 2.0 * b - 1.0, 1.0),
            SplitKind::Triangles => (2, 1.0 - 2.0 * a, 1.0 - 2.0 * b, -1.0),
        };
        Some(RegularChild { depth, index, u, v, flip })
    }

    /// Control points of a regular child over the canonical points, one row each: those of the position and
    /// first derivatives, at depths above 0 relative to the limit position; with `second` those of what bends, constant and linear
    /// parts left out.
    pub fn child_points(&self, depth: u32, index: usize, second: bool) -> Vec<Vec<f64>> {
        let point = |&k: &u32| {
            let mut row = vec![0.0; self.points()];
            self.step.row(k as usize).for_each(|(c, w)| row[c as usize] = w);
            if depth > 0 {
                let times = if second { 2 } else { 0 };
                let factor = self.power(depth, times, &mut row) * 2f64.powi(-times * depth as i32);
                row.iter_mut().for_each(|w| *w *= factor);
            }
            row
        };
        self.step.child(index).iter().map(point).collect()
    }

    /// The limit position over the points of the ring, which come first.
    pub fn limit(&self) -> &[f64] {
        &self.limit
    }

    /// True where second derivatives have control points of their own.
    pub fn parts_second(&self) -> bool {
        tangent::has_linear_modes(self.corner)
    }

    /// Weights for the first `count` entries of [`ORDERS`](super::bspline::ORDERS) at `(a, b)`.
    pub fn weights(&self, a: f64, b: f64, count: usize) -> PointWeights {
        let Some(RegularChild { depth: m, index, u, v, flip }) = self.child(a, b) else { return self.at_vertex(count) };
        let basis = match self.corner.split {
            SplitKind::Quads => tensor(&cubic(u), &cubic(v), count),
            SplitKind::Triangles => box_spline::basis(u, v, count),
        };
        let mut out = PointWeights::default();
        for order in 0..count {
            let mut row = vec![0.0; self.points()];
            self.step.left_multiply_child(index, &basis[order], &mut row);
            let times = [0, 1, 1, 2, 2, 2][order];
            let factor = if m == 0 { 1.0 } else { self.power(m, times, &mut row) };
            let factor = factor * (2.0 * flip).powi(times);
            row.iter_mut().for_each(|w| *w *= factor);
            if order == 0 && m > 0 {
                row.iter_mut().zip(self.limit()).for_each(|(w, l)| *w += l);
            }
            out.rows[order] = row;
        }
        if count > 1 && out.rows[1..count].iter().flatten().any(|w| !w.is_finite()) {
            return self.at_vertex(count);
        }
        out
    }

    /// `row · (A^m - constant)` up to the factor that is returned, times `2^m` per differentiation.
    fn power(&self, m: u32, times: i32, row: &mut Vec<f64>) -> f64 {
        let growth = 2f64.powi(times);
        let deep = m > DEEP.max(self.points() as u32 / 7) && !self.deflated.is_stored();
        let eigen = if deep && self.eigen.is_none() {
            self.deep.get_or_init(|| eigen_form(self.corner, &self.step)).as_ref()
        } else {
            self.eigen.as_ref()
        };
        if let Some(eigen) = eigen {
            eigen.apply(m, row, times == 2 && self.parts_second());
            return (growth * eigen.scale()).powi(m as i32);
        }
        let second = if times == 2 { self.second() } else { None };
        let deflated = second.unwrap_or(&self.deflated);
        deflated.apply(Deflated { step: &self.step, limit: &self.limit }, m, row);
        (growth * deflated.scale).powi(m as i32)
    }

    fn at_vertex(&self, count: usize) -> PointWeights {
        let mut out = PointWeights::default();
        out.rows[0] = vec![0.0; self.points()];
        out.rows[0][..self.limit.len()].copy_from_slice(&self.limit);
        for row in &mut out.rows[3..count.max(3)] {
            *row = vec![0.0; self.points()];
        }
        let tangent::Tangents { directions, derivatives, plane, unique_normal } = self.tangents().into_owned();
        if count > 1 {
            [out.rows[1], out.rows[2]] = directions;
        }
        out.at_vertex = Some(AtVertex { derivatives, plane, unique_normal });
        out
    }

    /// Heap memory in bytes, the tangents left out.
    pub fn bytes(&self) -> usize {
        let powers = match &self.eigen {
            Some(eigen) => eigen.storage_bytes(),
            None => self.deflated.bytes() + self.second.get().map_or(0, DeflatedPowers::bytes),
        };
        let shared = if self.is_first {
            let even = self.even.as_ref().and_then(|even| even.get());
            self.step.ring_bytes() + even.map_or(0, EvenMode::bytes) + size_of_val(&self.limit[..])
        } else {
            0
        };
        self.step.bytes() + powers + shared + self.coefficients.bytes()
    }
}

/// The eigenbasis where there is one.
fn eigen_form(corner: Corner, step: &LocalStep) -> Option<EigenForm> {
    if corner.split == SplitKind::Triangles || step.points > MOST_EIGEN {
        return None;
    }
    EigenForm::new(corner.kind, corner.n as usize, corner.i as usize, &step.dense(), step.ring)
}

/// The largest `m ≥ 0` with `big < 2^-m`, or 0 for `big = 1`.
fn depth(big: f64) -> u32 {
    // `big = f · 2^e` with `f` in [1/2, 1), so that `m = -e`; without a branch that depends on where the location happens to be.
    let exponent = |x: f64| (x.to_bits() >> 52) as i32 - 1022;
    let e = if big >= f64::MIN_POSITIVE { exponent(big) } else { exponent(big * 2f64.powi(64)) - 64 };
    (-e).max(0) as u32
}

/// `x · 2^m` without overflow of the power.
fn scale_up(x: f64, m: u32) -> f64 {
    let power = |m: u32| f64::from_bits(u64::from(1023 + m) << 52);
    x * power(m / 2) * power(m - m / 2)
}

/// Size of the largest eigenvalue below 1; only a scale, any value within a third of it serves.
fn subdominant(corner: Corner) -> f64 {
    let wave = tangent::wave_eigenvalue(corner.split, tangent::angle(corner));
    match (corner.kind, corner.split) {
        (Kind::Smooth | Kind::Pinned, _) => wave,
        // The dart of valence 3 has an even mode of 0.398 beside its wave of 1/4.
        (Kind::Dart, SplitKind::Triangles) => wave.max(0.4),
        _ => wave.max(0.5),
    }
}

/// A scale near the largest eigenvalue after the linear modes.
fn after_linear(corner: Corner) -> f64 {
    match (corner.kind, corner.split, corner.n) {
        (Kind::Dart, ..) => 0.31,
        (_, SplitKind::Triangles, 2) => 0.375,
        _ => 0.25,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_pass_from_sparse_steps_to_the_eigenbasis_without_a_seam() {
        for (kind, n) in [(Kind::Smooth, 50), (Kind::Crease, 40), (Kind::Corner, 40)] {
            let corner = Corner { split: SplitKind::Quads, kind, n, i: if kind == Kind::Smooth { 0 } else { 3 } };
            let deflated = SpecialVertex::new(corner, Method::Deflated);
            let eigen = SpecialVertex::new(corner, Method::Eigenbasis);
            for m in [DEEP - 1, DEEP, DEEP + 1, 40] {
                let (a, b) = (0.7 * 2f64.powi(-(m as i32)), 0.3 * 2f64.powi(-(m as i32)));
                let (ours, theirs) = (deflated.weights(a, b, 3), eigen.weights(a, b, 3));
                for (x, y) in ours.rows[..3].iter().zip(&theirs.rows) {
                    let size = y.iter().fold(0.0, |s: f64, w| s.max(w.abs()));
                    // Up to 16 sparse steps of K roundings each on one side.
                    x.iter().zip(y).for_each(|(x, y)| assert!((x - y).abs() < 1e-12 * size, "{corner:?} depth {m}"));
                }
            }
            assert!(deflated.deep.get().is_some());
        }
    }

    #[test]
    fn depth_is_exact_down_to_the_smallest_number() {
        assert_eq!([1.0, 0.5, 0.4999, 0.25, 0.2499].map(depth), [0, 0, 1, 1, 2]);
        for m in 1..1074 {
            let x = if m < 1022 { 2f64.powi(-m) } else { 2f64.powi(-1000) * 2f64.powi(1000 - m) };
            assert_eq!(depth(x), m as u32 - 1, "2^-{m}");
            let scaled = scale_up(x, depth(x));
            assert_eq!(scaled, 0.5);
        }
    }
}
