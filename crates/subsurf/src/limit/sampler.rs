//! Samples of one patch: its ring is gathered once, each sub-patch's control points are formed once, and samples of a
//! sub-patch are evaluated side by side. One location by itself takes the same way in `f64`.

use super::LimitSurface;
use super::batch::Exceptional;
use super::lanes::{Block, Piece};
use super::plan::{Plan, Spot};
use crate::kernel::vectorized;
use crate::real::{Real, round};

/// Samples side by side. Larger: more idle lanes where sub-patches are small; smaller: vectors are not filled.
const WIDTH: usize = 8;

/// What samples that no sub-patch covers have for a number.
const NONE: u32 = u32::MAX;

/// A patch and its samples.
pub(super) struct Sampler<T, const N: usize> {
    patch: usize,
    /// The ring relative to the base.
    ring: Vec<[T; N]>,
    base: [T; N],
    /// Sub-patches that were met, and what tells them apart.
    pieces: Vec<Piece<T, N>>,
    names: Vec<usize>,
    /// Samples in order: number of the sub-patch, and parameters there.
    found: Vec<(u32, T, T)>,
    /// Samples by sub-patch.
    sorted: Sorted<T>,
    exceptional: Vec<Exceptional>,
}

/// Samples with their parameters.
struct Sorted<T> {
    /// End of the samples of every sub-patch.
    ends: Vec<u32>,
    samples: Vec<u32>,
    s: Vec<T>,
    t: Vec<T>,
}

impl<T: Real, const N: usize> Default for Sampler<T, N> {
    fn default() -> Self {
        Self {
            patch: usize::MAX,
            ring: Vec::new(),
            base: [T::default(); N],
            pieces: Vec::new(),
            names: Vec::new(),
            found: Vec::new(),
            sorted: Sorted { ends: Vec::new(), samples: Vec::new(), s: Vec::new(), t: Vec::new() },
            exceptional: Vec::new(),
        }
    }
}

impl<T: Real, const N: usize> Sampler<T, N> {
    /// The exceptional samples so far, in order, if the first sample is number `first`.
    pub fn take_exceptional(&mut self, first: usize) -> Vec<Exceptional> {
        let mut all = std::mem::take(&mut self.exceptional);
        all.sort_unstable_by_key(|e| e.sample);
        all.iter_mut().for_each(|e| e.sample += first);
        all
    }

    /// Goes to a patch; false in holes.
    pub fn meet<V: Real>(&mut self, surface: &LimitSurface<'_, V, N>, patch: usize) -> bool {
        if surface.table.patch_plan(patch).is_none() {
            return false;
        }
        self.patch = patch;
        let ring = surface.table.ring(patch);
        let point = |v: u32| -> [T; N] {
            let value = &surface.points[v as usize];
            std::array::from_fn(|c| T::from_f64(value[c].to_f64()))
        };
        let base = point(ring[0]);
        self.base = base;
        self.ring.clear();
        self.ring.extend(ring.iter().map(|&v| {
            let point = point(v);
            std::array::from_fn(|c| point[c] - base[c])
        }));
        self.pieces.clear();
        self.names.clear();
        true
    }

    /// Writes the rows of samples in a hole.
    pub fn skip<const R: usize>(&mut self, samples: &[u32], rows: &mut [[[T; N]; R]]) {
        for &i in samples {
            rows[i as usize] = [[T::default(); N]; R];
            self.exceptional.push(Exceptional { sample: i as usize, derivatives: None });
        }
    }

    /// Evaluates samples of the patch, at parameters `[u, v]`.
    pub fn run<V: Real, const R: usize>(
        &mut self,
        surface: &LimitSurface<'_, V, N>,
        samples: &[u32],
        place: impl Fn(u32) -> [f64; 2],
        rows: &mut [[[T; N]; R]],
    ) {
        let table = surface.table;
        let plan = table.plan(table.patch_plan(self.patch).expect("holes have no samples"));
        let turn = table.turn(self.patch);
        let split = table.scheme().split();
        if let Some(spot) = plan.whole_spot(turn) {
            if self.pieces.is_empty() {
                let piece = self.piece(plan, &spot, (0.5, 0.25, turn), surface);
                self.pieces.push(piece);
            }
            self.sorted.whole(samples, |i| {
                let [u, v] = place(i);
                spot.whole(split, u, v)
            });
            return self.evaluate(rows);
        }
        self.found.clear();
        for &i in samples {
            let [u, v] = place(i);
            let Some(spot) = plan.spot(u, v, turn) else {
                self.found.push((NONE, T::default(), T::default()));
                self.exception(surface, [u, v], i, rows);
                continue;
            };
            let name = spot.piece();
            let number = match self.names.iter().position(|&known| known == name) {
                Some(number) => number,
                None => {
                    let piece = self.piece(plan, &spot, (u, v, turn), surface);
                    self.pieces.push(piece);
                    self.names.push(name);
                    self.names.len() - 1
                }
            };
            self.found.push((number as u32, T::from_f64(spot.s), T::from_f64(spot.t)));
        }
        self.sorted.sort(samples, &self.found, self.pieces.len());
        self.evaluate(rows);
    }

    /// Evaluates the sorted samples.
    fn evaluate<const R: usize>(&self, rows: &mut [[[T; N]; R]]) {
        let (pieces, sorted) = (&self.pieces, &self.sorted);
        vectorized(
            #[inline(always)]
            || sorted.evaluate(pieces, rows),
        );
    }

    /// Forms the control points of the sub-patch at a spot.
    fn piece<V: Real>(
        &self,
        plan: Plan<'_>,
        spot: &Spot<'_>,
        at: (f64, f64, u8),
        surface: &LimitSurface<'_, V, N>,
    ) -> Piece<T, N> {
        let split = surface.table.scheme().split();
        plan.with_piece::<T, _>(spot, at, |matrices| {
            vectorized(
                #[inline(always)]
                || {
                    Piece::new(
                        matrices,
                        spot.pose,
                        split,
                        self.base,
                        #[inline(always)]
                        |p| self.ring[p],
                    )
                },
            )
        })
    }

    /// Evaluates a sample that no sub-patch covers.
    #[cold]
    fn exception<V: Real, const R: usize>(
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

impl<T: Real> Sorted<T> {
    /// Takes samples that are all in one sub-patch, at `local` parameters.
    fn whole(&mut self, samples: &[u32], local: impl Fn(u32) -> [f64; 2]) {
        self.ends.clear();
        self.ends.push(samples.len() as u32);
        self.samples.clear();
        self.samples.extend_from_slice(samples);
        self.s.resize(samples.len(), T::default());
        self.t.resize(samples.len(), T::default());
        for ((&sample, s), t) in samples.iter().zip(&mut self.s).zip(&mut self.t) {
            let [a, b] = local(sample);
            (*s, *t) = (T::from_f64(a), T::from_f64(b));
        }
    }

    /// Sorts samples by sub-patch.
    fn sort(&mut self, samples: &[u32], found: &[(u32, T, T)], pieces: usize) {
        self.ends.clear();
        self.ends.resize(pieces + 1, 0);
        for &(number, ..) in found.iter().filter(|at| at.0 != NONE) {
            self.ends[number as usize + 1] += 1;
        }
        (0..pieces).for_each(|p| self.ends[p + 1] += self.ends[p]);
        let count = self.ends[pieces] as usize;
        self.samples.resize(count, 0);
        self.s.resize(count, T::default());
        self.t.resize(count, T::default());
        for (&sample, &(number, s, t)) in samples.iter().zip(found).filter(|(_, at)| at.0 != NONE) {
            // Starts become ends.
            let at = self.ends[number as usize] as usize;
            self.ends[number as usize] += 1;
            (self.samples[at], self.s[at], self.t[at]) = (sample, s, t);
        }
        self.ends.pop();
    }

    #[inline(always)]
    fn evaluate<const N: usize, const R: usize>(&self, pieces: &[Piece<T, N>], rows: &mut [[[T; N]; R]]) {
        let mut at = 0;
        for number in 0..self.ends.len() {
            let end = self.ends[number] as usize;
            while at < end {
                let count = if end - at < WIDTH { end - at } else { WIDTH };
                let (mut s, mut t) = ([T::default(); WIDTH], [T::default(); WIDTH]);
                s[..count].copy_from_slice(&self.s[at..at + count]);
                t[..count].copy_from_slice(&self.t[at..at + count]);
                write(&pieces[number].block::<R, WIDTH>(&s, &t), &self.samples[at..at + count], rows);
                at += count;
            }
        }
    }
}

/// Writes the rows of a block's samples.
#[inline(always)]
fn write<T: Real, const N: usize, const R: usize, const W: usize>(
    block: &Block<T, N, R, W>,
    samples: &[u32],
    rows: &mut [[[T; N]; R]],
) {
    for k in 0..samples.len() {
        let row = &mut rows[samples[k] as usize];
        for r in 0..R {
            for c in 0..N {
                row[r][c] = block[r][c][k];
            }
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
        let split = self.table.scheme().split();
        let ring = self.table.ring(patch);
        let points = self.points;
        let mut base = [0.0; N];
        (0..N).for_each(|c| base[c] = points[ring[0] as usize][c].to_f64());
        plan.with_piece::<f64, _>(spot, (u, v, self.table.turn(patch)), |matrices| {
            vectorized(
                #[inline(always)]
                || {
                    let piece = Piece::new(
                        matrices,
                        spot.pose,
                        split,
                        base,
                        #[inline(always)]
                        |p| {
                            let point = &points[ring[p] as usize];
                            let mut relative = [0.0; N];
                            for c in 0..N {
                                relative[c] = point[c].to_f64() - base[c];
                            }
                            relative
                        },
                    );
                    let block = piece.block::<R, 1>(&[spot.s], &[spot.t]);
                    let mut rows = [[0.0; N]; R];
                    for r in 0..R {
                        for c in 0..N {
                            rows[r][c] = block[r][c][0];
                        }
                    }
                    rows
                },
            )
        })
    }
}
