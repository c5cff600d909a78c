//! Many locations at once: samples of one face share its control points, samples of one sub-patch its coefficients.
//!
//! A row is what [`LimitSurface::eval`] gives, with sums in the precision of the control points instead of `f64`. It has
//! the same bits in any batch, in any order, on any number of threads.

use super::LimitSurface;
use super::by_patch::ByPatch;
use super::jet::{Derivatives, Jet, Location};
use super::places::{Places, TOGETHER};
use super::sampler::Sampler;
use crate::compiled::{JetRows, as_rows_mut};
use crate::index::Face;
use crate::real::Real;
use rayon::prelude::*;

/// Fewest locations that a thread takes at a time, and most. Larger: fewer threads, more scratch memory; smaller: fewer
/// samples of a face together where their order is random.
const CHUNK: [usize; 2] = [1 << 12, 1 << 22];

/// Locations that are looked at together for how often faces change, and how many times at most. Larger: memory is read twice;
/// smaller: chance decides.
const PROBE: usize = 256;
const MOST_PROBES: usize = 16;

/// A sample of a batch whose row is not simply position and derivatives.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Exceptional {
    /// Its number in the batch.
    pub sample: usize,
    /// What its derivatives are, as in [`Jet::derivatives`]; none in holes, whose rows are zero.
    /// [`LimitSurface::eval`] says more of the place: whether it has a tangent plane, for one. Second derivatives in its row
    /// are zero.
    pub derivatives: Option<Derivatives>,
}

impl<'a, T: Real, const N: usize> LimitSurface<'a, T, N> {
    /// Position, first and second derivatives at many locations, in parallel: what
    /// [`eval_second`](Self::eval_second) gives at each.
    ///
    /// # Panics
    /// As [`eval`](Self::eval).
    pub fn eval_many(&self, locations: &[Location]) -> Vec<Option<Jet<N>>> {
        let mut rows = vec![[[0.0; N]; 6]; locations.len()];
        subsurf_memory::advise(&mut rows);
        let exceptional = if const { N == 3 } {
            let (rows, _) = as_rows_mut(rows.as_flattened_mut()).as_chunks_mut();
            T::compiled_batch_in_f64(&self.of_threes(), locations, rows)
        } else {
            self.rows_into(locations, &mut rows)
        };
        let regular = |&[position, du, dv, uu, uv, vv]: &[[f64; N]; 6]| {
            Some(Jet::regular([position, du, dv], Some([uu, uv, vv])))
        };
        let mut jets: Vec<Option<Jet<N>>> = subsurf_memory::with_capacity(locations.len());
        rows.par_iter().map(regular).collect_into_vec(&mut jets);
        exceptional.iter().for_each(|e| jets[e.sample] = self.eval_second(locations[e.sample]));
        jets
    }

    /// Position (`R = 1`), first derivatives in u, v (`R = 3`) and second ones in uu, uv, vv (`R = 6`) at many locations,
    /// in the precision of the control points, in parallel. Returns the samples that are special vertices or lie in
    /// holes, in order.
    ///
    /// Locations on the same face are evaluated together where they follow each other; where they do not, they are
    /// brought together first, so that any order is fast.
    ///
    /// ```
    /// use subsurf::{Location, PatchTable, Scheme, shapes};
    ///
    /// let cube = shapes::cube();
    /// let patches = PatchTable::new(&cube.mesh, Scheme::CatmullClark)?;
    /// let surface = patches.surface(&cube.positions);
    ///
    /// let locations = [Location::new(1, 0.25, 0.5), Location::new(0, 0.125, 0.75), Location::new(0, 0.0, 0.0)];
    /// let mut rows = [[[0.0; 3]; 3]; 3];
    /// let exceptional = surface.eval_into(&locations, &mut rows);
    /// let [position, du, dv] = rows[0];
    /// # let jet = surface.eval(locations[0]).expect("no hole");
    /// # assert_eq!([position, du, dv], [jet.position, jet.du, jet.dv]);
    ///
    /// assert_eq!(exceptional.len(), 1);
    /// assert_eq!(exceptional[0].sample, 2); // a corner, of valence 3
    /// # Ok::<(), subsurf::MeshError>(())
    /// ```
    ///
    /// # Panics
    /// As [`eval`](Self::eval), and if there is not one row per location.
    pub fn eval_into<const R: usize>(&self, locations: &[Location], rows: &mut [[[T; N]; R]]) -> Vec<Exceptional> {
        check_rows::<R>(locations.len(), rows.len());
        if const { N == 3 } {
            return T::compiled_batch(&self.of_threes(), locations, JetRows::new(rows));
        }
        self.rows_into(locations, rows)
    }

    /// The same, or with sums in another precision; one row per location.
    pub(crate) fn rows_into<S: Real, const R: usize>(
        &self,
        locations: &[Location],
        rows: &mut [[[S; N]; R]],
    ) -> Vec<Exceptional> {
        let share = locations.len().div_ceil(rayon::current_num_threads());
        let chunk = share.clamp(CHUNK[0], CHUNK[1]);
        let found: Vec<Vec<Exceptional>> = (locations.par_chunks(chunk).zip(rows.par_chunks_mut(chunk)).enumerate())
            .map_init(Chunk::<S>::default, |scratch, (i, (locations, rows))| {
                scratch.evaluate(self, locations, rows, i * chunk)
            })
            .collect();
        found.concat()
    }

    /// One patch, its control points at hand for many samples; none in holes.
    ///
    /// # Panics
    /// If there is no such sub-face.
    pub fn patch(&self, face: Face, subface: u32) -> Option<LimitPatch<'a, T, N>> {
        let patch = self.table().patch(face, subface);
        self.table().patch_plan(patch)?;
        Some(LimitPatch { surface: *self, patch, sampler: Sampler::default(), places: Places::new() })
    }
}

/// Checks what `eval_into` was given.
fn check_rows<const R: usize>(samples: usize, rows: usize) {
    const { assert!(R == 1 || R == 3 || R == 6, "rows have 1, 3 or 6 vectors") };
    assert_eq!(samples, rows, "one row per sample");
}

/// One patch of a limit surface, for many samples: see [`LimitSurface::patch`].
pub struct LimitPatch<'a, T, const N: usize> {
    surface: LimitSurface<'a, T, N>,
    patch: usize,
    sampler: Sampler<T>,
    places: Places<T>,
}

impl<T: Real, const N: usize> LimitPatch<'_, T, N> {
    /// As [`LimitSurface::eval_into`], at parameters `[u, v]` of this patch, on one thread; with the same bits.
    ///
    /// # Panics
    /// If parameters lie outside the face, or if there is not one row per sample.
    pub fn eval_into<const R: usize>(&mut self, places: &[[f64; 2]], rows: &mut [[[T; N]; R]]) -> Vec<Exceptional> {
        check_rows::<R>(places.len(), rows.len());
        for (start, some) in (0..).step_by(TOGETHER).zip(places.chunks(TOGETHER)) {
            let patch = self.patch;
            self.places.set(self.surface.table(), some.len(), move |k| (some[k], (start + k) as u32, ()), |()| patch);
            if const { N == 3 } {
                T::compiled_patch_batch(&mut self.sampler, &self.surface.of_threes(), &self.places, JetRows::new(rows));
            } else {
                self.sampler.run(&self.surface, &self.places, rows);
            }
        }
        self.sampler.take_exceptional(0)
    }
}

/// Reusable memory of one thread.
struct Chunk<T> {
    sampler: Sampler<T>,
    by_patch: ByPatch,
    /// Some of them, and the ends of their rows.
    places: Places<T>,
    touched: Vec<[T; 2]>,
}

impl<T: Real> Default for Chunk<T> {
    fn default() -> Self {
        Self {
            sampler: Sampler::default(),
            by_patch: ByPatch::default(),
            places: Places::new(),
            touched: vec![[T::default(); 2]; TOGETHER],
        }
    }
}

impl<T: Real> Chunk<T> {
    /// Evaluates a chunk of locations, the first of which is number `first` of the batch.
    fn evaluate<V: Real, const N: usize, const R: usize>(
        &mut self,
        surface: &LimitSurface<'_, V, N>,
        locations: &[Location],
        rows: &mut [[[T; N]; R]],
        first: usize,
    ) -> Vec<Exceptional> {
        let Self { sampler, by_patch, places, touched } = self;
        let table = surface.table();
        let is_same = |a: &Location, b: &Location| (a.face == b.face) & (a.subface == b.subface);
        // How often faces change, in some places.
        let (mut changes, mut pairs) = (0, 0);
        for some in locations.chunks(PROBE).step_by(locations.len().div_ceil(MOST_PROBES * PROBE).max(1)) {
            for pair in some.windows(2) {
                changes += usize::from(!is_same(&pair[0], &pair[1]));
            }
            pairs += some.len();
        }
        if 4 * changes <= pairs {
            let mut number = 0;
            while number < locations.len() {
                let some = &locations[number..];
                places.set(
                    table,
                    some.len(),
                    #[inline(always)]
                    move |k| ([some[k].u, some[k].v], (number + k) as u32, (some[k].face, some[k].subface)),
                    |(face, subface)| table.patch(face, subface),
                );
                sampler.run(surface, places, rows);
                number += places.count();
            }
            return sampler.take_exceptional(first);
        }
        by_patch.fill(table, locations);
        for number in 0..by_patch.buckets() {
            let bucket = &by_patch.bucket(number);
            let mut start = 0;
            while start < bucket.len() {
                places.set(
                    table,
                    bucket.len() - start,
                    #[inline(always)]
                    move |k| bucket.place(start + k),
                    |patch| patch as usize,
                );
                // Rows lie all over the place, so many reads at a time, that they are at hand when they are written.
                for (touched, &row) in touched.iter_mut().zip(&places.number[..places.count()]) {
                    let row = rows[row as usize].as_flattened();
                    *touched = [row.first(), row.last()].map(|end| end.copied().unwrap_or_default());
                }
                sampler.run(surface, places, rows);
                start += places.count();
            }
        }
        sampler.take_exceptional(first)
    }
}
