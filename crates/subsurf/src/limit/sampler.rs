//! Samples of one patch: its ring is gathered once, each sub-patch's control points are formed once. One location by itself
//! takes the same way in `f64`.

use super::batch::Exceptional;
use super::lanes::{Panel, Piece, curves, turns, weighted};
use super::plan::{ControlPoints, Plan, Spot, SubPatch};
use super::{LimitSurface, PatchTable};
use crate::kernel::{LANES, Lanes, PART, Part, Parts, put};
use crate::real::{Real, round};
use crate::scheme::SplitKind;
use fearless_simd::{Level, Simd, dispatch};

/// A patch and its samples.
pub(super) struct Sampler<T> {
    patch: usize,
    /// The ring relative to its first point, part after part; gathered when a sub-patch needs it.
    ring: Vec<Part<T>>,
    /// Sub-patches that were met, all parts of each.
    pieces: Vec<Piece<T>>,
    /// Their finer control points; nothing of use where there are none.
    finer: Vec<Panel<T>>,
    /// By a sub-patch's number in its plan: the visit in which it was met, and its place among the pieces.
    met: Vec<[u32; 2]>,
    visit: u32,
    exceptional: Vec<Exceptional>,
}

/// Up to [`LANES`] samples of pieces.
struct Lot<T> {
    count: usize,
    s: [T; LANES],
    t: [T; LANES],
    piece: [u32; LANES],
    sample: [u32; LANES],
}

impl<T: Real> Lot<T> {
    #[inline(always)]
    fn new() -> Self {
        let zero = [T::default(); LANES];
        Self { count: 0, s: zero, t: zero, piece: [0; LANES], sample: [0; LANES] }
    }
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

    /// Evaluates samples of the patch: the `k`-th is number `sample(k)`, at the parameters `place(k)`. Rows in holes are zero.
    #[inline]
    pub fn run<V: Real, const N: usize, const R: usize>(
        &mut self,
        surface: &LimitSurface<'_, V, N>,
        count: usize,
        sample: impl Fn(usize) -> u32,
        place: impl Fn(usize) -> [f64; 2],
        rows: &mut [[[T; N]; R]],
    ) {
        let table = surface.table;
        let Some(plan) = table.patch_plan(self.patch) else {
            return (0..count).for_each(|k| {
                let [u, v] = place(k);
                table.check_parameters(u, v);
                self.skip(sample(k), rows);
            });
        };
        let plan = table.plan(plan);
        let turn = table.turn(self.patch);
        let split = table.scheme().split();
        let mut lot = Lot::new();
        if let Some(spot) = plan.whole_spot(turn) {
            if self.pieces.is_empty() {
                self.add_piece(surface, plan, &spot, [0.5, 0.25]);
            }
            return self.evaluate_whole(table, &spot, count, sample, place, rows);
        }
        for number in 0..count {
            let (i, [u, v]) = (sample(number), place(number));
            table.check_parameters(u, v);
            let Some(spot) = plan.spot(u, v, turn) else {
                self.exception(surface, [u, v], i, rows);
                continue;
            };
            let number = spot.piece() as usize;
            let piece = match self.met.get(number) {
                Some(&[visit, piece]) if visit == self.visit => piece,
                _ => {
                    if number >= self.met.len() {
                        self.met.resize(number + 1, [0; 2]);
                    }
                    let piece = self.pieces.len() as u32;
                    self.met[number] = [self.visit, piece];
                    self.add_piece(surface, plan, &spot, [u, v]);
                    piece
                }
            };
            let k = lot.count;
            (lot.s[k], lot.t[k]) = (T::from_f64(spot.s), T::from_f64(spot.t));
            (lot.piece[k], lot.sample[k]) = (piece, i);
            lot.count += 1;
            if lot.count == LANES {
                self.evaluate(&lot, split, rows);
                lot.count = 0;
            }
        }
        if lot.count > 0 {
            self.evaluate(&lot, split, rows);
        }
    }

    /// Evaluates samples of a piece that is the whole patch.
    fn evaluate_whole<const N: usize, const R: usize>(
        &self,
        table: &PatchTable,
        spot: &Spot<'_>,
        count: usize,
        sample: impl Fn(usize) -> u32,
        place: impl Fn(usize) -> [f64; 2],
        rows: &mut [[[T; N]; R]],
    ) {
        let split = table.scheme().split();
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || {
                let mut start = 0;
                while start < count {
                    let lanes = if count - start < LANES { count - start } else { LANES };
                    let (mut u, mut v, mut samples) = ([0.0; LANES], [0.0; LANES], [0; LANES]);
                    for k in 0..lanes {
                        samples[k] = sample(start + k);
                        [u[k], v[k]] = place(start + k);
                    }
                    table.check_all(&u, &v);
                    spot.whole(split, &mut u, &mut v);
                    let (mut s, mut t) = ([T::default(); LANES], [T::default(); LANES]);
                    for k in 0..LANES {
                        (s[k], t[k]) = (T::from_f64(u[k]), T::from_f64(v[k]));
                    }
                    let across = curves::<T, LANES>(&t);
                    for part in 0..N.div_ceil(PART) {
                        let piece = &self.pieces[part];
                        for k in 0..lanes {
                            let row = &mut rows[samples[k] as usize];
                            put(&piece.sample::<_, R, LANES>(simd, split, None, [s[k], t[k]], (&across, k)), PART * part, row);
                        }
                    }
                    start += LANES;
                }
            }
        ));
    }

    /// Evaluates a lot.
    fn evaluate<const N: usize, const R: usize>(&self, lot: &Lot<T>, split: SplitKind, rows: &mut [[[T; N]; R]]) {
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || {
                let across = curves::<T, LANES>(&lot.t);
                for k in 0..if lot.count < LANES { lot.count } else { LANES } {
                    let row = &mut rows[lot.sample[k] as usize];
                    for part in 0..N.div_ceil(PART) {
                        let number = lot.piece[k] as usize + part;
                        let piece = &self.pieces[number];
                        let finer = if piece.fine.is_some() { Some(&self.finer[number]) } else { None };
                        let at = [lot.s[k], lot.t[k]];
                        put(&piece.sample::<_, R, LANES>(simd, split, finer, at, (&across, k)), PART * part, row);
                    }
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
    piece.sample(simd, split, finer.as_ref(), [spot.s, spot.t], (&curves(&[spot.t]), 0))
}
