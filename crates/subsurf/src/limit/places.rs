//! Parameters of many samples, read from wherever they are and checked before anything is evaluated.

use super::patch_table::PatchTable;
use super::sampler::LOT;
use crate::kernel::vectorized;

/// Samples whose parameters are read and checked together. Larger: they do not stay in the cache; smaller: fewer reads at
/// a time.
pub(super) const TOGETHER: usize = 512;

/// Parameters of samples and their numbers.
pub(super) struct Places {
    /// Parameters; room for a whole lot after the last.
    pub u: Vec<f64>,
    pub v: Vec<f64>,
    pub number: Vec<u32>,
}

impl Places {
    pub fn new() -> Self {
        let zeros = vec![0.0; TOGETHER + LOT];
        Self { u: zeros.clone(), v: zeros, number: Vec::with_capacity(TOGETHER) }
    }

    /// Takes samples in: parameters and numbers.
    ///
    /// # Panics
    /// If parameters lie outside of faces.
    #[inline(always)]
    pub fn set(&mut self, table: &PatchTable, count: usize, each: impl Fn(usize) -> ([f64; 2], u32)) {
        let count = count.min(TOGETHER);
        self.number.clear();
        self.number.resize(count, 0);
        let (us, vs) = (&mut self.u[..count], &mut self.v[..count]);
        for (k, ((u, v), number)) in us.iter_mut().zip(vs).zip(&mut self.number).enumerate() {
            ([*u, *v], *number) = each(k);
        }
        vectorized(
            #[inline(always)]
            || table.check_all(&self.u[..count], &self.v[..count]),
        );
    }
}
