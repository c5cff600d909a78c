//! Samples of one patch: its ring is gathered once, each sub-patch's control points are formed once. One location by itself
//! takes the same way in `f64`.

use super::LimitSurface;
use super::batch::Exceptional;
use super::fours::Fours;
use super::lanes::{Panel, Piece, curves, turns, weighted};
use super::places::Places;
use super::plan::{ControlPoints, Plan, Spot, SubPatch};
use crate::kernel::{LANES, Lanes, PART, Part, Parts, put, vectorized};
use crate::real::{Real, round};
use crate::scheme::SplitKind;
use fearless_simd::{Level, Simd, dispatch};
use std::ops::Range;

/// A patch and its samples.
pub(super) struct Sampler<T> {
    patch: usize,
    /// The ring relative to its first point, part after part; gathered when a sub-patch needs it.
    ring: Vec<Part<T>>,
    /// Sub-patches that were met, all parts of each.
    pieces: Vec<Piece<T>>,
    /// Their finer control points; nothing of use where there are none.
    finer: Vec<Panel<T>>,
    /// By a sub-patch's number in its plan.
    met: Vec<Met>,
    visit: u32,
    /// Number of the lot.
    lots: u32,
    exceptional: Vec<Exceptional>,
}

/// A sub-patch that was met: in which visit, and its place among the pieces; in which lot, and its number there.
#[derive(Clone, Copy, Default)]
struct Met {
    visit: u32,
    piece: u32,
    lot: u32,
    group: u32,
}

/// Samples that are put in order together. Larger: memory on the stack; smaller: fewer samples of a piece at a time.
pub(super) const LOT: usize = 2 * LANES;

/// Samples of pieces; room for a whole block after the last.
struct Lot<T> {
    count: usize,
    s: [T; LOT + LANES],
    t: [T; LOT + LANES],
    sample: [u32; LOT],
}

impl<T: Real> Lot<T> {
    #[inline(always)]
    fn new() -> Self {
        let zero = [T::default(); LOT + LANES];
        Self { count: 0, s: zero, t: zero, sample: [0; LOT] }
    }
}

/// The samples of a lot in the order of their pieces.
struct Groups {
    count: usize,
    /// First of the pieces of every group.
    piece: [u32; LOT],
    /// Number of samples.
    size: [u32; LOT],
    /// Of every sample.
    group: [u32; LOT],
}

impl<T> Default for Sampler<T> {
    fn default() -> Self {
        Self {
            patch: usize::MAX,
            ring: Vec::new(),
            pieces: Vec::new(),
            finer: Vec::new(),
            met: Vec::new(),
            visit: 0,
            lots: 0,
            exceptional: Vec::new(),
        }
    }
}

impl<T: Real> Sampler<T> {
    /// The exceptional samples so far, in order, if the first sample is number `first`.
    pub fn take_exceptional(&mut self, first: usize) -> Vec<Exceptional> {
        let mut all = std::mem::take(&mut self.exceptional);
        all.sort_unstable_by_key(|e| e.sample);
        all.iter_mut().for_each(|e| e.sample += first);
        all
    }

    /// Goes to a patch, or stays there.
    #[inline]
    pub fn meet(&mut self, patch: usize) {
        if patch == self.patch {
            return;
        }
        self.patch = patch;
        self.ring.clear();
        self.pieces.clear();
        self.finer.clear();
        self.visit = self.visit.checked_add(1).unwrap_or_else(|| {
            self.met.clear();
            1
        });
    }

    /// Evaluates some samples of the patch. Rows in holes are zero.
    #[inline]
    pub fn run<V: Real, const N: usize, const R: usize>(
        &mut self,
        surface: &LimitSurface<'_, V, N>,
        places: &Places,
        range: Range<usize>,
        rows: &mut [[[T; N]; R]],
    ) {
        let table = surface.table;
        let Some(plan) = table.patch_plan(self.patch) else {
            return places.number[range].iter().for_each(|&sample| self.skip(sample, rows));
        };
        let plan = table.plan(plan);
        let turn = table.turn(self.patch);
        let split = table.scheme().split();
        if let Some(spot) = plan.whole_spot(turn).filter(|_| split == SplitKind::Quads) {
            let at = (0.5, 0.25, turn);
            return plan.with_piece(
                &spot,
                at,
                #[inline(always)]
                |matrices| whole(surface, table.ring_of(self.patch, plan.ring()), matrices, &spot, places, range, rows),
            );
        }
        let mut start = range.start;
        while start < range.end {
            let end = (start + LOT).min(range.end);
            self.evaluate_lot(surface, places, start..end, rows);
            start = end;
        }
    }

    /// Evaluates samples of any pieces, up to [`LOT`].
    fn evaluate_lot<'a, V: Real, const N: usize, const R: usize>(
        &mut self,
        surface: &LimitSurface<'a, V, N>,
        places: &Places,
        range: Range<usize>,
        rows: &mut [[[T; N]; R]],
    ) {
        let table = surface.table;
        let Some(plan) = table.patch_plan(self.patch) else { return };
        let (plan, turn) = (table.plan(plan), table.turn(self.patch));
        let all_at_vertex = match (places.u[range.start..].first_chunk(), places.v[range.start..].first_chunk()) {
            (Some(u), Some(v)) => vectorized(
                #[inline(always)]
                || plan.spots_at_vertex::<LOT>(u, v, turn),
            ),
            _ => None,
        };
        let start = range.start;
        self.lots = self.lots.checked_add(1).unwrap_or_else(|| {
            self.met.iter_mut().for_each(|met| met.lot = 0);
            1
        });
        let mut lot = Lot::new();
        let mut groups = Groups { count: 0, piece: [0; LOT], size: [0; LOT], group: [0; LOT] };
        for k in range {
            let (i, [u, v]) = (places.number[k], [places.u[k], places.v[k]]);
            let spot = match &all_at_vertex {
                Some(all) => all.get(k - start),
                None => plan.spot(u, v, turn),
            };
            let Some(spot) = spot else {
                self.exception(surface, [u, v], i, rows);
                continue;
            };
            let number = spot.piece() as usize;
            if number >= self.met.len() {
                self.met.resize(number + 1, Met::default());
            }
            if self.met[number].visit != self.visit {
                let piece = self.pieces.len() as u32;
                self.met[number] = Met { visit: self.visit, piece, ..Met::default() };
                self.add_piece(surface, plan, &spot, [u, v]);
            }
            let met = &mut self.met[number];
            if met.lot != self.lots {
                (met.lot, met.group) = (self.lots, groups.count as u32);
                groups.piece[groups.count] = met.piece;
                groups.count += 1;
            }
            groups.size[met.group as usize] += 1;
            groups.group[lot.count] = met.group;
            (lot.s[lot.count], lot.t[lot.count]) = (T::from_f64(spot.s), T::from_f64(spot.t));
            lot.sample[lot.count] = i;
            lot.count += 1;
        }
        self.evaluate_groups(&sorted(&lot, &groups), &groups, table.scheme().split(), rows);
    }

    /// Evaluates the groups of a lot, which is in their order.
    fn evaluate_groups<const N: usize, const R: usize>(
        &self,
        lot: &Lot<T>,
        groups: &Groups,
        split: SplitKind,
        rows: &mut [[[T; N]; R]],
    ) {
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || {
                let mut start = 0;
                for group in 0..groups.count {
                    let end = start + groups.size[group] as usize;
                    let number = &lot.sample[start..end];
                    for part in 0..N.div_ceil(PART) {
                        let place = groups.piece[group] as usize + part;
                        let piece = &self.pieces[place];
                        let finer = if piece.fine.is_some() { Some(&self.finer[place]) } else { None };
                        if split == SplitKind::Triangles || number.len() == 1 {
                            for k in start..end {
                                let [s, t] = [lot.s[k], lot.t[k]];
                                let across = curves::<T, R, 1>(&[t]);
                                let sample = piece.sample::<_, R, 1>(simd, split, finer, [s, t], (&across, 0));
                                put(&sample, PART * part, &mut rows[lot.sample[k] as usize]);
                            }
                            continue;
                        }
                        let fours = Fours::new(simd, piece, finer);
                        for (number, at) in number.chunks(4).zip((start..).step_by(4)) {
                            if let (Some(s), Some(t)) = (lot.s[at..].first_chunk(), lot.t[at..].first_chunk()) {
                                fours.evaluate::<N, R, 4>(simd, (s, t), number, PART * part, rows);
                            }
                        }
                    }
                    start = end;
                }
            }
        ));
    }

    /// Forms the control points of the sub-patch at a spot, which is that of `u`, `v`.
    fn add_piece<V: Real, const N: usize>(
        &mut self,
        surface: &LimitSurface<'_, V, N>,
        plan: Plan<'_>,
        spot: &Spot<'_>,
        [u, v]: [f64; 2],
    ) {
        let table = surface.table;
        let (ring, split) = (table.ring(self.patch), table.scheme().split());
        let turn = turns(spot.pose, split);
        plan.with_piece::<T, _>(spot, (u, v, table.turn(self.patch)), |matrices| {
            dispatch!(Level::new(), simd => simd.vectorize(
                #[inline(always)]
                || {
                    for part in 0..N.div_ceil(PART) {
                        let points = Parts::new(surface.points, PART * part);
                        let base: Part<T> = points.rounded(ring[0] as usize);
                        if let (ControlPoints::Chosen(_), None, None) = (&matrices.points, &matrices.origin, &matrices.fine) {
                            self.pieces.push(Piece::new::<_, N>(
                                simd,
                                matrices,
                                turn,
                                base,
                                #[inline(always)]
                                |p| T::apart(simd, points.rounded(ring[p] as usize), base),
                            ));
                            continue;
                        }
                        let start = part * ring.len();
                        if self.ring.len() == start {
                            for &point in ring {
                                self.ring.push(T::apart(simd, points.rounded(point as usize), base));
                            }
                        }
                        let gathered = &self.ring[start..start + ring.len()];
                        self.pieces.push(Piece::new::<_, N>(simd, matrices, turn, base, #[inline(always)] |p| gathered[p]));
                        if let Some((_, blocks)) = &matrices.fine {
                            self.finer.resize(self.pieces.len() - 1, [[T::default(); LANES]; 4]);
                            self.finer.push(weighted::<T, _, N>(simd, blocks, #[inline(always)] |p| gathered[p]));
                        }
                    }
                }
            ));
        });
    }

    /// Writes the row of a sample in a hole.
    #[cold]
    fn skip<const N: usize, const R: usize>(&mut self, sample: u32, rows: &mut [[[T; N]; R]]) {
        rows[sample as usize] = [[T::default(); N]; R];
        self.exceptional.push(Exceptional { sample: sample as usize, derivatives: None });
    }

    /// Evaluates a sample that no sub-patch covers.
    #[cold]
    fn exception<V: Real, const N: usize, const R: usize>(
        &mut self,
        surface: &LimitSurface<'_, V, N>,
        [u, v]: [f64; 2],
        sample: u32,
        rows: &mut [[[T; N]; R]],
    ) {
        let jet = surface.patch_jet(self.patch, u, v, 6).expect("holes have no samples");
        let second = jet.second.unwrap_or([[0.0; N]; 3]);
        let all = [jet.position, jet.du, jet.dv, second[0], second[1], second[2]];
        rows[sample as usize] = std::array::from_fn(|r| round(all[r]));
        // Second derivatives are missing at special vertices alone.
        if jet.second.is_none() {
            self.exceptional.push(Exceptional { sample: sample as usize, derivatives: Some(jet.derivatives) });
        }
    }
}

/// Evaluates samples of a face that is one bicubic piece.
#[inline]
fn whole<T: Real, V: Real, const N: usize, const R: usize>(
    surface: &LimitSurface<'_, V, N>,
    ring: &[u32],
    matrices: &SubPatch<T>,
    spot: &Spot<'_>,
    places: &Places,
    range: Range<usize>,
    rows: &mut [[[T; N]; R]],
) {
    dispatch!(Level::new(), simd => simd.vectorize(
        #[inline(always)]
        || {
            for first in (0..N).step_by(PART) {
                let points = Parts::new(surface.points, first);
                let base: Part<T> = points.rounded(ring[0] as usize);
                let fours = Fours::whole::<N>(
                    simd,
                    matrices,
                    turns(spot.pose, SplitKind::Quads),
                    base,
                    #[inline(always)]
                    |p| T::apart(simd, points.rounded(ring[p] as usize), base),
                );
                let mut start = range.start;
                while start < range.end {
                    let end = if range.end - start < LANES { range.end } else { start + LANES };
                    if let (Some(&u), Some(&v)) = (places.u[start..].first_chunk(), places.v[start..].first_chunk()) {
                        let (mut u, mut v) = (u, v);
                        spot.whole::<LANES>(SplitKind::Quads, &mut u, &mut v);
                        let (mut s, mut t) = ([T::default(); LANES], [T::default(); LANES]);
                        for k in 0..LANES {
                            (s[k], t[k]) = (T::from_f64(u[k]), T::from_f64(v[k]));
                        }
                        fours.evaluate(simd, (&s, &t), &places.number[start..end], first, rows);
                    }
                    start = end;
                }
            }
        }
    ));
}

/// A lot in the order of its groups.
fn sorted<T: Real>(lot: &Lot<T>, groups: &Groups) -> Lot<T> {
    let (mut sorted, mut next, mut start) = (Lot::new(), [0; LOT], 0);
    for group in 0..groups.count {
        next[group] = start;
        start += groups.size[group] as usize;
    }
    for k in 0..lot.count {
        let to = &mut next[groups.group[k] as usize];
        (sorted.s[*to], sorted.t[*to], sorted.sample[*to]) = (lot.s[k], lot.t[k], lot.sample[k]);
        *to += 1;
    }
    sorted.count = lot.count;
    sorted
}

impl<T: Real, const N: usize> LimitSurface<'_, T, N> {
    /// Position and derivatives at a location in a regular sub-patch.
    #[inline]
    pub(super) fn at_spot<const R: usize>(
        &self,
        patch: usize,
        plan: Plan<'_>,
        spot: &Spot<'_>,
        [u, v]: [f64; 2],
    ) -> [[f64; N]; R] {
        let (ring, split) = (self.table.ring(patch), self.table.scheme().split());
        let mut row = [[0.0; N]; R];
        plan.with_piece(spot, (u, v, self.table.turn(patch)), |matrices: &SubPatch<f64>| {
            dispatch!(Level::new(), simd => simd.vectorize(
                #[inline(always)]
                || {
                    for first in (0..N).step_by(PART) {
                        let points = Parts::new(self.points, first);
                        let base: Part<f64> = points.rounded(ring[0] as usize);
                        let values = alone::<_, N, R>(
                            simd,
                            (matrices, spot, split),
                            base,
                            #[inline(always)]
                            |p| f64::apart(simd, points.rounded(ring[p] as usize), base),
                        );
                        put(&values, first, &mut row);
                    }
                }
            ));
        });
        row
    }
}

/// One sample of a piece whose ring is given relative to `base`.
#[inline(always)]
fn alone<S: Simd, const N: usize, const R: usize>(
    simd: S,
    (matrices, spot, split): (&SubPatch<f64>, &Spot<'_>, SplitKind),
    base: Part<f64>,
    ring: impl Fn(usize) -> Part<f64> + Copy,
) -> [Part<f64>; R] {
    let piece = Piece::new::<_, N>(simd, matrices, turns(spot.pose, split), base, ring);
    let finer = match &matrices.fine {
        Some((_, blocks)) => Some(weighted::<f64, _, N>(simd, blocks, ring)),
        None => None,
    };
    piece.sample(simd, split, finer.as_ref(), [spot.s, spot.t], (&curves::<f64, R, 1>(&[spot.t]), 0))
}
