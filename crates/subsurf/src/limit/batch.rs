//! Many locations at once: samples of one face share its control points, samples of one sub-patch fill the lanes of
//! vector instructions.
//!
//! A row is what [`LimitSurface::eval`] gives, with sums in the precision of the control points instead of `f64`. It has
//! the same bits in any batch, in any order, on any number of threads.

use super::LimitSurface;
use super::jet::{Derivatives, Jet, Location};
use super::lanes::Piece;
use super::plan::{Plan, Pose, Spot};
use crate::index::Face;
use crate::kernel::{LANES, vectorized};
use crate::real::{Real, round};
use crate::scheme::SplitKind;
use rayon::prelude::*;

/// Fewest locations that a thread takes at a time, and most. Larger: fewer threads, more scratch memory; smaller: fewer samples of a face
/// together where their order is random.
const CHUNK: [usize; 2] = [1 << 12, 1 << 18];

/// A sample of a batch whose row is not simply position and derivatives.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Exceptional {
    /// Its number in the batch.
    pub sample: usize,
    /// What its derivatives are, as in [`Jet::derivatives`]; none in holes, whose rows are zero. [`LimitSurface::eval`] says more
    /// of the place: whether it has a tangent plane, for one. Second derivatives in its row are zero.
    pub derivatives: Option<Derivatives>,
}

impl<T: Real, const N: usize> LimitSurface<'_, T, N> {
    /// Position, first and second derivatives at many locations, in parallel: what
    /// [`eval_second`](Self::eval_second) gives at each.
    ///
    /// # Panics
    /// As [`eval`](Self::eval).
    pub fn eval_many(&self, locations: &[Location]) -> Vec<Option<Jet<N>>> {
        locations.par_iter().map(|&at| self.eval_second(at)).collect()
    }

    /// Position (`R = 1`), first derivatives in u, v (`R = 3`) and second ones in uu, uv, vv (`R = 6`) at many locations,
    /// in the precision of the control points. Returns the samples that are special vertices or lie in holes, in order.
    ///
    /// Locations on the same face are evaluated together where they follow each other; where they do not, they are
    /// brought together first, so that any order is fast.
    ///
    /// ```
    /// # use subsurf::*;
    /// # let mesh = shapes::cube();
    /// # let patches = PatchTable::new(&mesh, Scheme::CatmullClark)?;
    /// # let positions: Vec<[f32; 3]> =
    /// #     (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32)).collect();
    /// let surface = patches.surface(&positions);
    /// let locations = [Location::new(1, 0.25, 0.5), Location::new(0, 0.125, 0.75)];
    /// let mut rows = [[[0.0; 3]; 3]; 2];
    /// assert!(surface.eval_into(&locations, &mut rows).is_empty());
    /// let [position, du, dv] = rows[0];
    /// # assert!(position.iter().chain(&du).chain(&dv).all(|x| x.is_finite()));
    /// # Ok::<(), MeshError>(())
    /// ```
    ///
    /// # Panics
    /// As [`eval`](Self::eval), and if there is not one row per location.
    pub fn eval_into<const R: usize>(&self, locations: &[Location], rows: &mut [[[T; N]; R]]) -> Vec<Exceptional> {
        const { assert!(R == 1 || R == 3 || R == 6, "rows have 1, 3 or 6 vectors") };
        assert_eq!(locations.len(), rows.len(), "one row per location");
        let share = locations.len().div_ceil(rayon::current_num_threads());
        let chunk = share.clamp(CHUNK[0], CHUNK[1]);
        let found: Vec<Vec<Exceptional>> = (locations.par_chunks(chunk).zip(rows.par_chunks_mut(chunk)).enumerate())
            .map_init(Scratch::default, |scratch, (i, (locations, rows))| {
                scratch.chunk(self, locations, rows);
                scratch.take_exceptional(i * chunk)
            })
            .collect();
        found.concat()
    }

    /// One patch, its control points at hand for many samples; none in holes.
    ///
    /// # Panics
    /// If there is no such sub-face.
    pub fn patch(&self, face: Face, subface: u32) -> Option<LimitPatch<'_, T, N>> {
        let patch = self.table.patch(face, subface);
        self.table.patch_plan(patch)?;
        let mut scratch = Scratch::default();
        scratch.meet(self, patch);
        Some(LimitPatch { surface: self, face, subface, patch, scratch })
    }

    /// The jet of a location in a regular sub-patch.
    #[inline]
    pub(super) fn piece_jet<const R: usize>(
        &self,
        patch: usize,
        plan: Plan<'_>,
        spot: &Spot<'_>,
        at: Location,
    ) -> [[f64; N]; R] {
        let split = self.table.scheme().split();
        let ring = self.table.ring(patch);
        let base = self.points[ring[0] as usize].map(T::to_f64);
        let point = |p: usize| -> [f64; N] {
            let value = self.points[ring[p] as usize];
            std::array::from_fn(|c| value[c].to_f64() - base[c])
        };
        plan.with_piece::<f64, _>(spot, (at.u, at.v, self.table.turn(patch)), |matrices| {
            vectorized(
                #[inline(always)]
                || {
                    let piece = Piece::new(matrices, spot.pose, split, base, point);
                    piece.block::<R, 1>(&[spot.s], &[spot.t]).map(|row| row.map(|[x]| x))
                },
            )
        })
    }
}

/// One patch of a limit surface, for many samples: see [`LimitSurface::patch`].
pub struct LimitPatch<'a, T, const N: usize> {
    surface: &'a LimitSurface<'a, T, N>,
    face: Face,
    subface: u32,
    patch: usize,
    scratch: Scratch<T, N>,
}

impl<T: Real, const N: usize> LimitPatch<'_, T, N> {
    /// As [`LimitSurface::eval_into`], at parameters `[u, v]` of this patch; with the same bits.
    ///
    /// # Panics
    /// If parameters lie outside the face, or if there is not one row per sample.
    pub fn eval_into<const R: usize>(&mut self, samples: &[[f64; 2]], rows: &mut [[[T; N]; R]]) -> Vec<Exceptional> {
        const { assert!(R == 1 || R == 3 || R == 6, "rows have 1, 3 or 6 vectors") };
        assert_eq!(samples.len(), rows.len(), "one row per sample");
        let scratch = &mut self.scratch;
        scratch.ids.clear();
        scratch.ids.extend(0..samples.len() as u32);
        let ids = std::mem::take(&mut scratch.ids);
        let place = |i: u32| {
            let [u, v] = samples[i as usize];
            Location { face: self.face, subface: self.subface, u, v }
        };
        (0..samples.len() as u32).for_each(|i| _ = self.surface.table.checked_patch(place(i)));
        scratch.run(self.surface, self.patch, &ids, place, rows);
        scratch.ids = ids;
        scratch.take_exceptional(0)
    }
}

/// Reusable memory of one thread.
struct Scratch<T, const N: usize> {
    /// The patch that was met last: its ring, relative to the base.
    ring: Vec<[T; N]>,
    base: [T; N],
    /// Pieces of that patch.
    pieces: Vec<(usize, Piece<T, N>)>,
    /// Samples of a chunk, those of a patch together.
    ids: Vec<u32>,
    patches: Vec<u32>,
    /// Samples of a patch, in order: piece and parameters; then those of a piece together.
    groups: Vec<(u32, T, T)>,
    sorted: Sorted<T>,
    exceptional: Vec<Exceptional>,
}

/// Samples sorted by piece.
#[derive(Default)]
struct Sorted<T> {
    s: Vec<T>,
    t: Vec<T>,
    ids: Vec<u32>,
}

impl<T: Real, const N: usize> Default for Scratch<T, N> {
    fn default() -> Self {
        Self {
            ring: Vec::new(),
            base: [T::default(); N],
            pieces: Vec::new(),
            ids: Vec::new(),
            patches: Vec::new(),
            groups: Vec::new(),
            sorted: Sorted { s: Vec::new(), t: Vec::new(), ids: Vec::new() },
            exceptional: Vec::new(),
        }
    }
}

impl<T: Real, const N: usize> Scratch<T, N> {
    fn take_exceptional(&mut self, first: usize) -> Vec<Exceptional> {
        let mut all = std::mem::take(&mut self.exceptional);
        all.sort_unstable_by_key(|e| e.sample);
        all.iter_mut().for_each(|e| e.sample += first);
        all
    }

    /// Evaluates a chunk of locations.
    fn chunk<const R: usize>(
        &mut self,
        surface: &LimitSurface<'_, T, N>,
        locations: &[Location],
        rows: &mut [[[T; N]; R]],
    ) {
        let mut ids = std::mem::take(&mut self.ids);
        let mut patches = std::mem::take(&mut self.patches);
        patches.clear();
        patches.extend(locations.iter().map(|&at| surface.table.checked_patch(at) as u32));
        ids.clear();
        ids.extend(0..locations.len() as u32);
        let changes = patches.windows(2).filter(|pair| pair[0] != pair[1]).count();
        if 4 * changes > locations.len() {
            sort_by_patch(&mut ids, &patches);
        }
        for run in ids.chunk_by(|&a, &b| patches[a as usize] == patches[b as usize]) {
            let patch = patches[run[0] as usize] as usize;
            if surface.table.patch_plan(patch).is_none() {
                for &id in run {
                    rows[id as usize] = [[T::default(); N]; R];
                    self.exceptional.push(Exceptional { sample: id as usize, derivatives: None });
                }
                continue;
            }
            self.meet(surface, patch);
            self.run(surface, patch, run, |id| locations[id as usize], rows);
        }
        (self.ids, self.patches) = (ids, patches);
    }

    /// Goes to another patch.
    fn meet(&mut self, surface: &LimitSurface<'_, T, N>, patch: usize) {
        let ring = surface.table.ring(patch);
        self.base = surface.points[ring[0] as usize];
        self.ring.clear();
        let base = self.base;
        self.ring.extend(ring.iter().map(|&v| {
            let point = surface.points[v as usize];
            std::array::from_fn(|c| point[c] - base[c])
        }));
        self.pieces.clear();
    }

    /// Evaluates samples `ids` of the patch that was met.
    fn run<const R: usize>(
        &mut self,
        surface: &LimitSurface<'_, T, N>,
        patch: usize,
        ids: &[u32],
        place: impl Fn(u32) -> Location,
        rows: &mut [[[T; N]; R]],
    ) {
        let table = surface.table;
        let plan = table.plan(table.patch_plan(patch).expect("holes have no samples"));
        let (turn, split) = (table.turn(patch), table.scheme().split());
        self.groups.clear();
        for &id in ids {
            let Location { u, v, .. } = place(id);
            let Some(spot) = plan.spot(u, v, turn) else {
                self.exception(surface, place(id), id, &mut rows[id as usize]);
                self.groups.push((u32::MAX, T::default(), T::default()));
                continue;
            };
            let known = self.pieces.iter().position(|(piece, _)| *piece == spot.piece());
            let number = known.unwrap_or_else(|| {
                self.pieces.push((spot.piece(), self.piece(plan, &spot, (u, v, turn), split)));
                self.pieces.len() - 1
            });
            self.groups.push((number as u32, T::from_f64(spot.s), T::from_f64(spot.t)));
        }
        let Sorted { s, t, ids: sorted } = &mut self.sorted;
        for (number, (_, piece)) in self.pieces.iter().enumerate() {
            s.clear();
            t.clear();
            sorted.clear();
            for (&id, &(group, a, b)) in ids.iter().zip(&self.groups) {
                if group == number as u32 {
                    s.push(a);
                    t.push(b);
                    sorted.push(id);
                }
            }
            vectorized(
                #[inline(always)]
                || blocks(piece, s, t, sorted, rows),
            );
        }
    }

    fn piece(&self, plan: Plan<'_>, spot: &Spot<'_>, at: (f64, f64, u8), split: SplitKind) -> Piece<T, N> {
        let (pose, ring): (Pose, &[[T; N]]) = (spot.pose, &self.ring);
        plan.with_piece::<T, _>(spot, at, |matrices| {
            vectorized(
                #[inline(always)]
                || Piece::new(matrices, pose, split, self.base, |p| ring[p]),
            )
        })
    }

    /// A sample that no piece covers.
    #[cold]
    fn exception<const R: usize>(
        &mut self,
        surface: &LimitSurface<'_, T, N>,
        at: Location,
        id: u32,
        row: &mut [[T; N]; R],
    ) {
        let jet = surface.eval_second(at).expect("holes have no samples");
        let second = jet.second.unwrap_or([[0.0; N]; 3]);
        let all = [jet.position, jet.du, jet.dv, second[0], second[1], second[2]];
        *row = std::array::from_fn(|r| round(all[r]));
        // Second derivatives are missing at special vertices alone.
        if jet.second.is_none() {
            self.exceptional.push(Exceptional { sample: id as usize, derivatives: Some(jet.derivatives) });
        }
    }
}

/// Evaluates the samples of one piece.
#[inline(always)]
fn blocks<T: Real, const N: usize, const R: usize>(
    piece: &Piece<T, N>,
    s: &[T],
    t: &[T],
    ids: &[u32],
    rows: &mut [[[T; N]; R]],
) {
    let mut at = 0;
    while ids.len() - at > LANES / 2 {
        block::<T, N, R, LANES>(piece, &s[at..], &t[at..], &ids[at..], rows);
        at = ids.len().min(at + LANES);
    }
    if at < ids.len() {
        block::<T, N, R, 8>(piece, &s[at..], &t[at..], &ids[at..], rows);
    }
}

/// Evaluates up to `W` samples.
#[inline(always)]
fn block<T: Real, const N: usize, const R: usize, const W: usize>(
    piece: &Piece<T, N>,
    s: &[T],
    t: &[T],
    ids: &[u32],
    rows: &mut [[[T; N]; R]],
) {
    let last = s.len() - 1;
    let [s, t] = [s, t].map(|x| std::array::from_fn::<T, W, _>(|k| x[k.min(last)]));
    let block = piece.block::<R, W>(&s, &t);
    for (k, &id) in ids.iter().take(W).enumerate() {
        rows[id as usize] = std::array::from_fn(|r| std::array::from_fn(|c| block[r][c][k]));
    }
}

/// Sorts samples by their patch, those of one patch in order: two passes of counting, or three.
fn sort_by_patch(ids: &mut Vec<u32>, patches: &[u32]) {
    const BITS: u32 = 11;
    let most = patches.iter().copied().max().unwrap_or(0);
    let mut other = vec![0; ids.len()];
    let mut shift = 0;
    while shift < 32 && most >> shift > 0 {
        let digit = |id: u32| (patches[id as usize] >> shift) as usize & ((1 << BITS) - 1);
        let mut start = [0u32; (1 << BITS) + 1];
        ids.iter().for_each(|&id| start[digit(id) + 1] += 1);
        (0..1 << BITS).for_each(|d| start[d + 1] += start[d]);
        for &id in &*ids {
            let at = &mut start[digit(id)];
            other[*at as usize] = id;
            *at += 1;
        }
        std::mem::swap(ids, &mut other);
        shift += BITS;
    }
}
