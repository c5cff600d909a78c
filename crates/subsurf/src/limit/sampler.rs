//! Samples of patches. One that is a regular piece is evaluated as a whole, sixteen samples at a time, one a lane; elsewhere
//! samples find their pieces lot by lot, the coefficients of each are formed once, and samples come one after the other, since
//! few share a piece.

use super::LimitSurface;
use super::at_pole::LastPole;
use super::batch::Exceptional;
use super::lanes::{Frame, Piece, from_points, turns, weighted, weighted_twice};
use super::places::{LOT, Places, Run};
use super::plan::{Cells, PieceMap, Plan, Spot, SubPatch};
use super::turn::turned_points;
use crate::kernel::{LANES, PART, Part, Parts, level, put, put_sixteen};
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

/// Samples of a patch whose pieces are found at once. Larger: lots are cut short; smaller: patches of sixteen samples, more or less,
/// take two turns.
const AT_ONCE: usize = 2 * LANES;

/// Most pieces at hand before those of other patches are given up. Larger: they leave the nearest cache; smaller: lots are cut short.
const MOST_PIECES: usize = 32;

/// Plans that are remembered to have been touched. Larger: what they remember has left the cache meanwhile; smaller: touched in vain.
const TOUCHED: usize = 64;

/// Samples of patches.
pub struct Sampler<T> {
    /// The patch whose pieces are being met.
    patch: usize,
    /// Its ring relative to its first point, part after part.
    ring: Vec<Part<T>>,
    /// The first point, part after part.
    base: Vec<Part<T>>,
    /// Pieces of this patch and of some before: all parts of each, and where they lie.
    pieces: Vec<Piece<T>>,
    maps: Vec<PieceMap>,
    count: usize,
    /// By a piece's number among those that cover cells, and by its number in the patch tree.
    met: [Met; 256],
    met_in_tree: Vec<Met>,
    visit: u32,
    /// Patches that are one bicubic piece of points of the ring.
    whole: Vec<Whole>,
    /// The plan of the last one.
    chosen: Chosen,
    /// Patches that are not, with their plans.
    pieced: Vec<(Run, usize)>,
    /// Plans whose matrices were touched lately, by the last digits of their numbers.
    touched: [usize; TOUCHED],
    exceptional: Vec<Exceptional>,
    last_pole: LastPole,
}

/// A piece that was met: in which visit, and its place among the pieces at hand.
#[derive(Clone, Copy, Default)]
struct Met {
    visit: u32,
    piece: u32,
}

impl Met {
    /// True at the first call of a visit, after which the piece is number `next`; without a branch.
    #[inline(always)]
    fn meet(&mut self, visit: u32, next: usize) -> bool {
        let is_new = self.visit != visit;
        self.piece = if is_new { next as u32 } else { self.piece };
        self.visit = visit;
        is_new
    }
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

/// Samples whose pieces are found before any is evaluated.
struct Lot<T> {
    count: usize,
    at: [[T; 2]; LOT],
    /// The sample's piece, and its number.
    piece: [u32; LOT],
    sample: [u32; LOT],
}

impl<T> Default for Sampler<T> {
    fn default() -> Self {
        Self {
            patch: usize::MAX,
            ring: Vec::new(),
            base: Vec::new(),
            pieces: Vec::new(),
            maps: Vec::new(),
            count: 0,
            met: [Met::default(); 256],
            met_in_tree: Vec::new(),
            visit: 0,
            whole: Vec::new(),
            chosen: Chosen { plan: usize::MAX, turn: 0, ring: 0, points: [0; LANES] },
            pieced: Vec::new(),
            touched: [usize::MAX; TOUCHED],
            exceptional: Vec::new(),
            last_pole: LastPole::default(),
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

    /// Evaluates samples. Rows in holes are zero.
    pub fn run<V: Real, const N: usize, const R: usize>(
        &mut self,
        surface: &LimitSurface<'_, V, N>,
        places: &Places<T>,
        out: &mut [[[T; N]; R]],
    ) {
        let table = surface.table;
        self.whole.clear();
        self.pieced.clear();
        for run in places.runs() {
            let Some(number) = table.patch_plan(run.patch) else {
                places.number[run.start..run.end].iter().for_each(|&sample| self.skip(sample, out));
                continue;
            };
            let turn = table.turn(run.patch);
            if (number, turn) == (self.chosen.plan, self.chosen.turn)
                || self.is_chosen(table.plan(number), number, turn)
            {
                self.whole.push(Whole { run, chosen: self.chosen });
            } else {
                self.pieced.push((run, number));
            }
        }
        self.evaluate_whole(surface, places, out);
        if !self.pieced.is_empty() {
            self.evaluate_pieced(surface, places, out);
        }
    }

    /// Looks whether a plan is one piece of chosen control points, which are then at hand.
    fn is_chosen(&mut self, plan: Plan<'_>, number: usize, turn: u8) -> bool {
        let Some(spot) = plan.whole_spot(turn) else { return false };
        plan.with_piece::<T, _>(&spot, |matrix| {
            let SubPatch::Chosen(points) = matrix else { return false };
            self.chosen = Chosen { plan: number, turn, ring: plan.ring(), points: turned_points(points, turn) };
            true
        })
    }

    /// Evaluates patches of any pieces, lot by lot: pieces are found, those that are new are formed, and once there are samples
    /// enough they are evaluated. Matrices are touched beforehand: where every face has a plan of its own, they come from far
    /// away, and each is known only once its plan is.
    fn evaluate_pieced<V: Real, const N: usize, const R: usize>(
        &mut self,
        surface: &LimitSurface<'_, V, N>,
        places: &Places<T>,
        out: &mut [[[T; N]; R]],
    ) {
        let pieced = std::mem::take(&mut self.pieced);
        let split = surface.table.scheme().split();
        for &(_, number) in &pieced {
            let touched = &mut self.touched[number % TOUCHED];
            if *touched != number
                && let Some(cells) = surface.table.plan(number).cells()
            {
                std::hint::black_box(cells.first_numbers::<T>());
            }
            *touched = number;
        }
        dispatch!(level(), simd => simd.vectorize(
            #[inline(always)]
            || {
                let mut lot = Lot { count: 0, at: [[T::default(); 2]; LOT], piece: [0; LOT], sample: [0; LOT] };
                for &(run, number) in &pieced {
                    if run.patch != self.patch {
                        if self.count > MOST_PIECES {
                            self.evaluate_lot(simd, &mut lot, split, out);
                            self.count = 0;
                        }
                        self.go_to(simd, surface, run.patch, surface.table.plan(number).ring());
                    }
                    for start in (run.start..run.end).step_by(AT_ONCE) {
                        if lot.count + AT_ONCE > LOT {
                            self.evaluate_lot(simd, &mut lot, split, out);
                        }
                        let end = if run.end - start < AT_ONCE { run.end } else { start + AT_ONCE };
                        let plan = surface.table.plan(number);
                        self.find_pieces(simd, surface, plan, (places, start..end), &mut lot, out);
                    }
                }
                self.evaluate_lot(simd, &mut lot, split, out);
            }
        ));
        self.pieced = pieced;
    }

    /// Reads the ring of a patch, of so many points.
    #[inline(always)]
    fn go_to<S: Simd, V: Real, const N: usize>(
        &mut self,
        simd: S,
        surface: &LimitSurface<'_, V, N>,
        patch: usize,
        points: usize,
    ) {
        self.patch = patch;
        self.visit = self.visit.checked_add(1).unwrap_or_else(|| {
            self.met.fill(Met::default());
            self.met_in_tree.clear();
            1
        });
        let ring = surface.table.ring_of(patch, points);
        let parts = N.div_ceil(PART);
        if self.ring.len() < parts * ring.len() {
            self.ring.resize(parts * ring.len(), Part::default());
        }
        self.base.resize(parts, Part::default());
        for part in 0..parts {
            let points = Parts::new(surface.points, PART * part);
            let base: Part<T> = points.rounded(ring[0] as usize);
            let relative = &mut self.ring[part * ring.len()..][..ring.len()];
            for p in 0..ring.len() {
                relative[p] = T::apart(simd, points.rounded(ring[p] as usize), base);
            }
            self.base[part] = base;
        }
    }

    /// Finds the pieces of up to [`AT_ONCE`] samples of the patch, and forms those that are new.
    #[inline(always)]
    fn find_pieces<S: Simd, V: Real, const N: usize, const R: usize>(
        &mut self,
        simd: S,
        surface: &LimitSurface<'_, V, N>,
        plan: Plan<'_>,
        (places, range): (&Places<T>, Range<usize>),
        lot: &mut Lot<T>,
        out: &mut [[[T; N]; R]],
    ) {
        let turn = surface.table.turn(self.patch);
        let (count, samples) = (range.len(), lot.count..lot.count + range.len());
        let (u, v, number) = (&places.u[range.clone()], &places.v[range.clone()], &places.number[range.clone()]);
        // One more than can be met.
        self.make_room(self.count + AT_ONCE + 1, N.div_ceil(PART));
        let cells = plan.cells();
        let mut found = [[u8::MAX; LANES]; AT_ONCE / LANES];
        if let Some(cells) = cells {
            for half in 0..count.div_ceil(LANES) {
                let start = range.start + LANES * half;
                // There is room behind the last sample.
                if let (Some(u), Some(v)) = (places.u[start..].first_chunk(), places.v[start..].first_chunk()) {
                    found[half] = cells.find(u, v, turn);
                }
            }
        }
        let found = &found.as_flattened()[..count];
        // Numbers for new pieces; what no cell decides gets one too, which nothing is done with.
        let (first, visit) = (self.count, self.visit);
        let mut next = first;
        let mut new = [0; AT_ONCE + 1];
        let (piece, at) = (&mut lot.piece[samples.clone()], &mut lot.at[samples.clone()]);
        let met = &mut self.met;
        for k in 0..count {
            let met = &mut met[usize::from(found[k])];
            new[next - first] = found[k];
            next += usize::from(met.meet(visit, next));
            piece[k] = met.piece;
        }
        lot.sample[samples.clone()].copy_from_slice(number);
        self.count = next;
        if let Some(cells) = cells {
            self.form_pieces(simd, surface, (plan, cells, turn), first, &new);
        }
        for k in 0..count {
            let [s, t] = self.maps[piece[k] as usize].at(u[k], v[k]);
            at[k] = [T::from_f64(s), T::from_f64(t)];
        }
        lot.count = samples.end;
        if found.contains(&u8::MAX) {
            self.find_others(surface, plan, (found, u, v), samples.start, lot, out);
        }
    }

    /// Finds the pieces of samples that no cell decides, by the patch tree.
    #[inline(never)]
    fn find_others<V: Real, const N: usize, const R: usize>(
        &mut self,
        surface: &LimitSurface<'_, V, N>,
        plan: Plan<'_>,
        (found, u, v): (&[u8], &[f64], &[f64]),
        start: usize,
        lot: &mut Lot<T>,
        out: &mut [[[T; N]; R]],
    ) {
        let turn = surface.table.turn(self.patch);
        // Backwards, so that the last sample may take the place of one that has no piece.
        for k in (0..found.len()).rev() {
            if found[k] != u8::MAX {
                continue;
            }
            let sample = start + k;
            if let Some((piece, at)) = self.find_in_tree(surface, plan, [u[k], v[k]], turn) {
                (lot.piece[sample], lot.at[sample]) = (piece, at);
                continue;
            }
            self.exception(surface, [u[k], v[k]], lot.sample[sample], out);
            lot.count -= 1;
            let last = lot.count;
            (lot.piece[sample], lot.at[sample], lot.sample[sample]) = (lot.piece[last], lot.at[last], lot.sample[last]);
        }
    }

    /// Makes room for so many pieces.
    #[inline(always)]
    fn make_room(&mut self, pieces: usize, parts: usize) {
        if self.maps.len() < pieces {
            self.maps.resize(pieces, PieceMap::default());
            self.pieces.resize(pieces * parts, Piece::default());
        }
    }

    /// Forms the coefficients of new pieces, from number `first` on.
    #[inline(always)]
    fn form_pieces<S: Simd, V: Real, const N: usize>(
        &mut self,
        simd: S,
        surface: &LimitSurface<'_, V, N>,
        (plan, cells, turn): (Plan<'_>, &Cells, u8),
        first: usize,
        new: &[u8; AT_ONCE + 1],
    ) {
        let parts = N.div_ceil(PART);
        // A piece that waits for another, to be formed together.
        let mut waiting: Option<(usize, &[[T; LANES]])> = None;
        for number in first..self.count {
            let Some(piece) = cells.piece(new[number - first]) else { continue };
            self.maps[number] = piece.map(turn);
            let turns = turns(piece.pose(turn), SplitKind::Quads);
            for part in 0..parts {
                self.pieces[number * parts + part].frame = Frame { base: self.base[part], turn: turns };
            }
            let Some(SubPatch::Weighted(blocks)) = piece.matrix::<T>() else {
                self.form_first(surface, plan, &piece.spot([0.5; 2], turn), number);
                continue;
            };
            let Some((before, blocks_before)) = waiting.take() else {
                waiting = Some((number, blocks));
                continue;
            };
            for part in 0..parts {
                let ring = &self.ring[part * blocks.len()..][..blocks.len()];
                let [a, b] = weighted_twice::<T, S, N>(simd, [blocks_before, blocks], ring);
                self.pieces[before * parts + part].set_rows(simd, &a);
                self.pieces[number * parts + part].set_rows(simd, &b);
            }
        }
        if let Some((number, blocks)) = waiting {
            self.form::<_, N>(simd, number, blocks);
        }
    }

    /// Forms one piece.
    #[inline(always)]
    fn form<S: Simd, const N: usize>(&mut self, simd: S, number: usize, blocks: &[[T; LANES]]) {
        let parts = N.div_ceil(PART);
        for part in 0..parts {
            let ring = &self.ring[part * blocks.len()..][..blocks.len()];
            let rows = weighted::<T, S, N>(
                simd,
                blocks,
                #[inline(always)]
                |p| ring[p],
            );
            self.pieces[number * parts + part].set_rows(simd, &rows);
        }
    }

    /// Forms a piece whose matrix may have to be made.
    #[inline(never)]
    fn form_first<V: Real, const N: usize>(
        &mut self,
        surface: &LimitSurface<'_, V, N>,
        plan: Plan<'_>,
        spot: &Spot<'_>,
        number: usize,
    ) {
        let parts = N.div_ceil(PART);
        let turn = turns(spot.pose, surface.table.scheme().split());
        for part in 0..parts {
            self.pieces[number * parts + part].frame = Frame { base: self.base[part], turn };
        }
        plan.with_piece::<T, _>(spot, |matrix| {
            let SubPatch::Weighted(blocks) = matrix else {
                unreachable!("plans of chosen points have no other pieces")
            };
            dispatch!(level(), simd => simd.vectorize(
                #[inline(always)]
                || self.form::<_, N>(simd, number, blocks)
            ));
        });
    }

    /// The piece of a place that no cell decides, and the place in it; none where there is no piece.
    fn find_in_tree<V: Real, const N: usize>(
        &mut self,
        surface: &LimitSurface<'_, V, N>,
        plan: Plan<'_>,
        [u, v]: [f64; 2],
        turn: u8,
    ) -> Option<(u32, [T; 2])> {
        let spot = plan.spot(u, v, turn)?;
        let number = spot.piece() as usize;
        if number >= self.met_in_tree.len() {
            self.met_in_tree.resize(number + 1, Met::default());
        }
        if self.met_in_tree[number].meet(self.visit, self.count) {
            self.make_room(self.count + 1, N.div_ceil(PART));
            self.form_first(surface, plan, &spot, self.count);
            self.count += 1;
        }
        Some((self.met_in_tree[number].piece, [T::from_f64(spot.s), T::from_f64(spot.t)]))
    }

    /// Evaluates the samples of a lot.
    #[inline(always)]
    fn evaluate_lot<S: Simd, const N: usize, const R: usize>(
        &self,
        simd: S,
        lot: &mut Lot<T>,
        split: SplitKind,
        out: &mut [[[T; N]; R]],
    ) {
        let parts = N.div_ceil(PART);
        for k in 0..lot.count {
            for part in 0..parts {
                let piece = &self.pieces[lot.piece[k] as usize * parts + part];
                let sample = piece.frame.sample::<_, R>(simd, split, &piece.rows(simd), lot.at[k]);
                put(&sample, PART * part, &mut out[lot.sample[k] as usize]);
            }
        }
        lot.count = 0;
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
        let jet = surface.patch_jet(self.patch, [u, v], 6, &mut self.last_pole).expect("holes have no samples");
        let second = jet.second.unwrap_or([[0.0; N]; 3]);
        let all = [jet.position, jet.du, jet.dv, second[0], second[1], second[2]];
        rows[sample as usize] = std::array::from_fn(|r| round(all[r]));
        // Second derivatives are missing at special vertices alone.
        if jet.second.is_none() {
            self.exceptional.push(Exceptional { sample: sample as usize, derivatives: Some(jet.derivatives) });
        }
    }
}
