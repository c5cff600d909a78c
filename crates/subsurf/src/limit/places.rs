//! Parameters of many samples, read from wherever they are and checked before anything is evaluated, and where one patch
//! follows another among them.

use super::patch_table::PatchTable;
use super::powers::MIDDLE;
use crate::kernel::{LANES, vectorized};
use crate::real::Real;

/// Samples whose parameters are read and checked together. Larger: they do not stay in the cache; smaller: fewer reads at
/// a time.
pub(super) const TOGETHER: usize = 256;

/// Samples whose sub-patches are found before any is evaluated; so much room is behind the last sample. Larger: memory on the
/// stack; smaller: more calls.
pub(super) const LOT: usize = 4 * LANES;

/// Parameters of samples and their numbers.
pub struct Places<T> {
    /// Parameters of faces.
    pub u: Vec<f64>,
    pub v: Vec<f64>,
    /// Parameters of pieces: those of a piece that covers its face, until others take their place.
    pub s: Vec<T>,
    pub t: Vec<T>,
    pub number: Vec<u32>,
    /// Where runs start, and where the last ends.
    starts: Vec<Start>,
}

/// The first sample of a run.
#[derive(Clone, Copy, Default)]
struct Start {
    sample: u32,
    patch: u32,
}

/// Samples of one patch that follow each other.
#[derive(Clone, Copy)]
pub struct Run {
    pub start: usize,
    pub end: usize,
    pub patch: usize,
}

impl<T: Real> Places<T> {
    pub fn new() -> Self {
        let (wide, own) = (vec![0.0; TOGETHER + LOT], vec![T::default(); TOGETHER + LOT]);
        Self {
            u: wide.clone(),
            v: wide,
            s: own.clone(),
            t: own,
            number: vec![0; TOGETHER],
            starts: Vec::with_capacity(TOGETHER + 1),
        }
    }

    /// Takes samples in, as many as there is room for, and whole patches where there are several: parameters, numbers, and what
    /// tells patches apart, of which `patch` makes numbers.
    ///
    /// # Panics
    /// If parameters lie outside of faces.
    #[inline(always)]
    pub fn set<K: PartialEq + Copy>(
        &mut self,
        table: &PatchTable,
        count: usize,
        each: impl Fn(usize) -> ([f64; 2], u32, K) + Copy,
        patch: impl Fn(K) -> usize,
    ) {
        let count = count.min(TOGETHER);
        self.starts.resize(count + 1, Start::default());
        let (u, v, number) = (&mut self.u[..count], &mut self.v[..count], &mut self.number[..count]);
        let (s, t, starts) = (&mut self.s[..count], &mut self.t[..count], &mut self.starts[..=count]);
        // By value, so that nothing that is written may be what it reads.
        let runs = vectorized(
            #[inline(always)]
            move || {
                let mut runs = 0;
                let mut last = None;
                for k in 0..count {
                    let key;
                    ([u[k], v[k]], number[k], key) = each(k);
                    // Written in any case, and kept where another patch begins.
                    starts[runs].sample = k as u32;
                    runs += usize::from(last != Some(key));
                    last = Some(key);
                }
                table.check_all(u, v);
                for k in 0..count {
                    (s[k], t[k]) = (T::from_f64(u[k] - MIDDLE), T::from_f64(v[k] - MIDDLE));
                }
                runs
            },
        );
        self.starts[runs].sample = count as u32;
        // The last patch may have more samples than there was room for.
        let runs = if runs > 1 && count == TOGETHER { runs - 1 } else { runs };
        self.starts.truncate(runs + 1);
        for start in &mut self.starts[..runs] {
            start.patch = patch(each(start.sample as usize).2) as u32;
        }
    }

    /// How many samples were taken in.
    pub fn count(&self) -> usize {
        self.starts.last().map_or(0, |end| end.sample as usize)
    }

    /// Samples of one patch that follow each other, run by run.
    pub fn runs(&self) -> impl ExactSizeIterator<Item = Run> + '_ {
        let run = |at: &[Start]| Run {
            start: at[0].sample as usize,
            end: at[1].sample as usize,
            patch: at[0].patch as usize,
        };
        self.starts.windows(2).map(run)
    }

    /// Parameters of pieces of sixteen samples from `start` on; there may be fewer.
    #[inline(always)]
    pub fn sixteen(&self, start: usize) -> Option<(&[T; LANES], &[T; LANES])> {
        Some((self.s.get(start..)?.first_chunk()?, self.t.get(start..)?.first_chunk()?))
    }
}
