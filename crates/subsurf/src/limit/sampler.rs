//! Samples of one patch: its ring is gathered once, each sub-patch's coefficients are formed once. One location by itself
//! takes the same way in `f64`.

use super::LimitSurface;
use super::batch::Exceptional;
use super::lanes::{Frame, Panel, Piece, Rows, rows, turns};
use super::places::Places;
use super::plan::{Plan, Spot, SubPatch};
use crate::kernel::{LANES, Lanes, PART, Part, Parts, level, put, vectorized};
use crate::real::{Real, round};
use crate::scheme::SplitKind;
use fearless_simd::{Simd, dispatch};
use std::ops::Range;

/// A patch and its samples.
pub(super) struct Sampler<T> {
    patch: usize,
    /// The ring relative to its first point, part after part; gathered when a sub-patch needs it.
    ring: Vec<Part<T>>,
    /// Sub-patches that were met, all parts of each.
    pieces: Vec<Piece<T>>,
    /// By a sub-patch's number in its plan.
    met: Vec<Met>,
    visit: u32,
    exceptional: Vec<Exceptional>,
}

/// A sub-patch that was met: in which visit, and its place among the pieces.
#[derive(Clone, Copy, Default)]
struct Met {
    visit: u32,
    piece: u32,
}

/// Samples whose sub-patches are found before any is evaluated. Larger: memory on the stack; smaller: more calls.
pub(super) const LOT: usize = 2 * LANES;

/// Samples of pieces.
struct Lot<T> {
    count: usize,
    at: [[T; 2]; LOT],
    /// First of the sample's pieces, and its number.
    piece: [u32; LOT],
    sample: [u32; LOT],
}

impl<T> Default for Sampler<T> {
    fn default() -> Self {
        Self {
            patch: usize::MAX,
            ring: Vec::new(),
            pieces: Vec::new(),
            met: Vec::new(),
            visit: 0,
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
        out: &mut [[[T; N]; R]],
    ) {
        let table = surface.table;
        let Some(plan) = table.patch_plan(self.patch) else {
            return places.number[range].iter().for_each(|&sample| self.skip(sample, out));
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
                |matrix| whole(surface, table.ring_of(self.patch, plan.ring()), matrix, &spot, places, range, out),
            );
        }
        let mut start = range.start;
        while start < range.end {
            let end = (start + LOT).min(range.end);
            self.evaluate_lot(surface, places, start..end, out);
            start = end;
        }
    }

    /// Evaluates samples of any pieces, up to [`LOT`].
    fn evaluate_lot<'a, V: Real, const N: usize, const R: usize>(
        &mut self,
        surface: &LimitSurface<'a, V, N>,
        places: &Places,
        range: Range<usize>,
        out: &mut [[[T; N]; R]],
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
        let mut lot = Lot { count: 0, at: [[T::default(); 2]; LOT], piece: [0; LOT], sample: [0; LOT] };
        for k in range {
            let (i, [u, v]) = (places.number[k], [places.u[k], places.v[k]]);
            let spot = match &all_at_vertex {
                Some(all) => all.get(k - start),
                None => plan.spot(u, v, turn),
            };
            let Some(spot) = spot else {
                self.exception(surface, [u, v], i, out);
                continue;
            };
            let number = spot.piece() as usize;
            if number >= self.met.len() {
                self.met.resize(number + 1, Met::default());
            }
            if self.met[number].visit != self.visit {
                self.met[number] = Met { visit: self.visit, piece: self.pieces.len() as u32 };
                self.add_piece(surface, plan, &spot, [u, v]);
            }
            lot.at[lot.count] = [T::from_f64(spot.s), T::from_f64(spot.t)];
            (lot.piece[lot.count], lot.sample[lot.count]) = (self.met[number].piece, i);
            lot.count += 1;
        }
        self.evaluate_pieces(&lot, table.scheme().split(), out);
    }

    /// Evaluates a lot.
    fn evaluate_pieces<const N: usize, const R: usize>(&self, lot: &Lot<T>, split: SplitKind, out: &mut [[[T; N]; R]]) {
        dispatch!(level(), simd => simd.vectorize(
            #[inline(always)]
            || {
                for k in 0..lot.count {
                    for part in 0..N.div_ceil(PART) {
                        let Piece { panel, frame } = &self.pieces[lot.piece[k] as usize + part];
                        let rows = load(simd, panel);
                        let sample = frame.sample::<_, R>(simd, split, &rows, lot.at[k]);
                        put(&sample, PART * part, &mut out[lot.sample[k] as usize]);
                    }
                }
            }
        ));
    }

    /// Forms the coefficients of the sub-patch at a spot, which is that of `u`, `v`.
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
        plan.with_piece::<T, _>(spot, (u, v, table.turn(self.patch)), |matrix| {
            dispatch!(level(), simd => simd.vectorize(
                #[inline(always)]
                || {
                    for part in 0..N.div_ceil(PART) {
                        let points = Parts::new(surface.points, PART * part);
                        let base: Part<T> = points.rounded(ring[0] as usize);
                        let start = part * ring.len();
                        if let (SubPatch::Weighted(_), true) = (matrix, self.ring.len() == start) {
                            for &point in ring {
                                self.ring.push(T::apart(simd, points.rounded(point as usize), base));
                            }
                        }
                        let made = match matrix {
                            SubPatch::Chosen(_) => rows::<T, _, N>(
                                simd,
                                matrix,
                                #[inline(always)]
                                |p| T::apart(simd, points.rounded(ring[p] as usize), base),
                            ),
                            SubPatch::Weighted(_) => {
                                let gathered = &self.ring[start..start + ring.len()];
                                rows::<T, _, N>(simd, matrix, #[inline(always)] |p| gathered[p])
                            }
                        };
                        let mut panel = [[T::default(); LANES]; 4];
                        for j in 0..4 {
                            T::store(simd, made[j], &mut panel[j]);
                        }
                        self.pieces.push(Piece { panel, frame: Frame { base, turn } });
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

#[inline(always)]
fn load<T: Real, S: Simd>(simd: S, panel: &Panel<T>) -> Rows<T, S> {
    let mut rows = [T::splat(simd, T::default()); 4];
    for j in 0..4 {
        rows[j] = T::load(simd, &panel[j]);
    }
    rows
}

/// Evaluates samples of a face that is one bicubic piece.
#[inline]
fn whole<T: Real, V: Real, const N: usize, const R: usize>(
    surface: &LimitSurface<'_, V, N>,
    ring: &[u32],
    matrix: &SubPatch<T>,
    spot: &Spot<'_>,
    places: &Places,
    range: Range<usize>,
    out: &mut [[[T; N]; R]],
) {
    dispatch!(level(), simd => simd.vectorize(
        #[inline(always)]
        || {
            for first in (0..N).step_by(PART) {
                let points = Parts::new(surface.points, first);
                let base: Part<T> = points.rounded(ring[0] as usize);
                let frame = Frame { base, turn: turns(spot.pose, SplitKind::Quads) };
                let rows = rows::<T, _, N>(
                    simd,
                    matrix,
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
                        for (k, &number) in places.number[start..end].iter().enumerate() {
                            let sample = frame.sample::<_, R>(simd, SplitKind::Quads, &rows, [s[k], t[k]]);
                            put(&sample, first, &mut out[number as usize]);
                        }
                    }
                    start = end;
                }
            }
        }
    ));
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
        plan.with_piece(spot, (u, v, self.table.turn(patch)), |matrix: &SubPatch<f64>| {
            dispatch!(level(), simd => simd.vectorize(
                #[inline(always)]
                || {
                    for first in (0..N).step_by(PART) {
                        let points = Parts::new(self.points, first);
                        let base: Part<f64> = points.rounded(ring[0] as usize);
                        let values = alone::<_, N, R>(
                            simd,
                            (matrix, spot, split),
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
    (matrix, spot, split): (&SubPatch<f64>, &Spot<'_>, SplitKind),
    base: Part<f64>,
    ring: impl Fn(usize) -> Part<f64> + Copy,
) -> [Part<f64>; R] {
    let rows = rows::<f64, S, N>(simd, matrix, ring);
    Frame { base, turn: turns(spot.pose, split) }.sample(simd, split, &rows, [spot.s, spot.t])
}
