//! Samples of patches. One that is a regular piece is evaluated as a whole, sixteen samples at a time, one a lane; elsewhere
//! samples find their pieces lot by lot, the coefficients of each are formed once, and samples come one after the other, since
//! few share a piece.

use super::LimitSurface;
use super::batch::Exceptional;
use super::lanes::{Frame, Piece, from_points, turns, weighted};
use super::places::{LOT, Places, Run};
use super::plan::{Plan, Spot, SubPatch};
use super::turn::turned_points;
use crate::kernel::{LANES, PART, Part, Parts, level, put, put_sixteen, vectorized};
use crate::real::{Real, round};
use crate::scheme::SplitKind;
use fearless_simd::{Simd, dispatch};
use std::ops::Range;

/// Fewest samples of a piece that are evaluated a lane each, where sixteen numbers fit into one vector. Larger: more that are
/// evaluated one by one; smaller: lanes stand idle. In double precision nothing would be gained: 12.7 ns a sample become 16.
#[inline(always)]
fn fewest<T>() -> usize {
    if size_of::<T>() == 4 { 6 } else { usize::MAX }
}

/// Samples of patches.
pub(super) struct Sampler<T> {
    /// The patch of the sub-patches that were met.
    patch: usize,
    /// Its ring relative to its first point, part after part; gathered when a sub-patch needs it.
    ring: Vec<Part<T>>,
    /// Sub-patches that were met, all parts of each.
    pieces: Vec<Piece<T>>,
    /// By a sub-patch's number in its plan.
    met: Vec<Met>,
    visit: u32,
    /// Patches that are one bicubic piece.
    whole: Vec<Whole>,
    /// The plan of the last one.
    chosen: Chosen,
    exceptional: Vec<Exceptional>,
}

/// A sub-patch that was met: in which visit, and its place among the pieces.
#[derive(Clone, Copy, Default)]
struct Met {
    visit: u32,
    piece: u32,
}

/// A plan that is one piece of chosen control points, as it lies in a face.
#[derive(Clone, Copy)]
struct Chosen {
    plan: usize,
    turn: u8,
    /// Number of points of the ring.
    ring: usize,
    /// In the order of the face's own parameters.
    points: [u8; LANES],
}

/// Samples of a patch that is one piece of chosen control points.
#[derive(Clone, Copy)]
struct Whole {
    run: Run,
    chosen: Chosen,
}

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
            whole: Vec::new(),
            chosen: Chosen { plan: usize::MAX, turn: 0, ring: 0, points: [0; LANES] },
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
    fn meet(&mut self, patch: usize) {
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

    /// Evaluates samples. Rows in holes are zero.
    pub fn run<V: Real, const N: usize, const R: usize>(
        &mut self,
        surface: &LimitSurface<'_, V, N>,
        places: &Places<T>,
        out: &mut [[[T; N]; R]],
    ) {
        let table = surface.table;
        self.whole.clear();
        for run in places.runs() {
            let Some(plan) = table.patch_plan(run.patch) else {
                places.number[run.start..run.end].iter().for_each(|&sample| self.skip(sample, out));
                continue;
            };
            let turn = table.turn(run.patch);
            let (number, plan) = (plan, table.plan(plan));
            let is_known = (number, turn) == (self.chosen.plan, self.chosen.turn);
            let spot = if is_known { None } else { plan.whole_spot(turn) };
            if is_known || spot.is_some_and(|spot| self.is_chosen(plan, &spot, number, turn)) {
                self.whole.push(Whole { run, chosen: self.chosen });
                continue;
            }
            self.meet(run.patch);
            if let Some(spot) = spot.filter(|_| table.scheme().split() == SplitKind::Quads) {
                if self.pieces.is_empty() {
                    self.add_piece(surface, plan, &spot, [0.5, 0.25]);
                }
                self.evaluate_only(&spot, run, places, out);
                continue;
            }
            for start in (run.start..run.end).step_by(LOT) {
                self.evaluate_lot(surface, plan, places, start..(start + LOT).min(run.end), out);
            }
        }
        self.evaluate_whole(surface, places, out);
    }

    /// Looks whether a plan is one piece of chosen control points, which are then at hand.
    fn is_chosen<'a>(&mut self, plan: Plan<'a>, spot: &Spot<'a>, number: usize, turn: u8) -> bool {
        plan.with_piece::<T, _>(spot, (0.5, 0.25, turn), |matrix| {
            let SubPatch::Chosen(points) = matrix else { return false };
            self.chosen = Chosen { plan: number, turn, ring: plan.ring(), points: turned_points(points, turn) };
            true
        })
    }

    /// Evaluates samples of any pieces, up to [`LOT`].
    fn evaluate_lot<'a, V: Real, const N: usize, const R: usize>(
        &mut self,
        surface: &LimitSurface<'a, V, N>,
        plan: Plan<'a>,
        places: &Places<T>,
        range: Range<usize>,
        out: &mut [[[T; N]; R]],
    ) {
        let table = surface.table;
        let turn = table.turn(self.patch);
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
                        let piece = &self.pieces[lot.piece[k] as usize + part];
                        let sample = piece.frame.sample::<_, R>(simd, split, &piece.rows(simd), lot.at[k]);
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
            let SubPatch::Weighted(blocks) = matrix else {
                unreachable!("plans of chosen points have no other pieces")
            };
            dispatch!(level(), simd => simd.vectorize(
                #[inline(always)]
                || {
                    for part in 0..N.div_ceil(PART) {
                        let points = Parts::new(surface.points, PART * part);
                        let base: Part<T> = points.rounded(ring[0] as usize);
                        let start = part * ring.len();
                        if self.ring.len() == start {
                            for &point in ring {
                                self.ring.push(T::apart(simd, points.rounded(point as usize), base));
                            }
                        }
                        let gathered = &self.ring[start..start + ring.len()];
                        let rows = weighted::<T, _, N>(simd, blocks, #[inline(always)] |p| gathered[p]);
                        let mut piece = Piece::default();
                        piece.set(simd, &rows, Frame { base, turn });
                        self.pieces.push(piece);
                    }
                }
            ));
        });
    }

    /// Evaluates patches that are one piece of chosen control points. The coefficients of the next patch are formed before a
    /// patch is evaluated: so they are read from memory, number by number, where the compiler would otherwise take them apart in
    /// registers; and what waits for memory, here to be read and there to be written, waits side by side.
    fn evaluate_whole<V: Real, const N: usize, const R: usize>(
        &self,
        surface: &LimitSurface<'_, V, N>,
        places: &Places<T>,
        out: &mut [[[T; N]; R]],
    ) {
        dispatch!(level(), simd => simd.vectorize(
            #[inline(always)]
            || {
                let mut records = [[[T::default(); PART]; LANES]; 6];
                let mut pieces = [Piece::default(); 2];
                for part in 0..N.div_ceil(PART) {
                    let points = Parts::new(surface.points, PART * part);
                    for next in 0..=self.whole.len() {
                        if let Some(Whole { run, chosen }) = self.whole.get(next) {
                            let ring = surface.table.ring_of(run.patch, chosen.ring);
                            let base: Part<T> = points.rounded(ring[0] as usize);
                            let rows = from_points::<T, _>(
                                simd,
                                &chosen.points,
                                #[inline(always)]
                                |p| T::apart(simd, points.rounded(ring[p] as usize), base),
                            );
                            pieces[next & 1].set(simd, &rows, Frame { base, turn: None });
                        }
                        let Some(before) = next.checked_sub(1) else { continue };
                        let (run, piece) = (self.whole[before].run, &pieces[before & 1]);
                        let mut start = run.start;
                        while run.end - start >= fewest::<T>()
                            && let Some((s, t)) = places.sixteen(start)
                        {
                            let end = if run.end - start < LANES { run.end } else { start + LANES };
                            let [s, t] = [T::load(simd, s), T::load(simd, t)];
                            let planes = piece.sixteen::<_, N, R>(simd, s, t);
                            put_sixteen(simd, &planes, PART * part, (&mut records, &places.number[start..end]), out);
                            start = end;
                        }
                        if start < run.end {
                            let rows = piece.rows(simd);
                            for k in start..run.end {
                                let at = [places.s[k], places.t[k]];
                                let sample = piece.frame.sample::<_, R>(simd, SplitKind::Quads, &rows, at);
                                put(&sample, PART * part, &mut out[places.number[k] as usize]);
                            }
                        }
                    }
                }
            }
        ));
    }

    /// Evaluates samples of a patch that is one piece, which is at hand; the spot is any of it.
    fn evaluate_only<const N: usize, const R: usize>(
        &self,
        spot: &Spot<'_>,
        run: Run,
        places: &Places<T>,
        out: &mut [[[T; N]; R]],
    ) {
        dispatch!(level(), simd => simd.vectorize(
            #[inline(always)]
            || {
                for (part, piece) in self.pieces.iter().enumerate() {
                    let rows = piece.rows(simd);
                    for k in run.start..run.end {
                        let (mut u, mut v) = ([places.u[k]], [places.v[k]]);
                        spot.whole(SplitKind::Quads, &mut u, &mut v);
                        let at = [T::from_f64(u[0]), T::from_f64(v[0])];
                        let sample = piece.frame.sample::<_, R>(simd, SplitKind::Quads, &rows, at);
                        put(&sample, PART * part, &mut out[places.number[k] as usize]);
                    }
                }
            }
        ));
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
