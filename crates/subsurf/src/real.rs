//! The two precisions of values. Weights are computed in `f64`; values are stored in what the caller chose.

use crate::compiled::CompiledHere;
use crate::kernel::PartLanes;
use std::ops::{Add, Mul, Sub};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// `f32` or `f64`.
pub trait Real:
    sealed::Sealed
    + PartLanes
    + CompiledHere
    + Copy
    + Send
    + Sync
    + PartialOrd
    + std::fmt::Debug
    + Default
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + 'static
{
    /// Rounds to this precision.
    fn from_f64(x: f64) -> Self;
    /// Exact.
    fn to_f64(self) -> f64;
}

impl Real for f32 {
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x as f32
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

impl Real for f64 {
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
}

/// `sum += weight · value`, in `f64`.
#[inline(always)]
pub(crate) fn add_scaled<T: Real, const N: usize>(sum: &mut [f64; N], weight: f64, value: &[T; N]) {
    for i in 0..N {
        sum[i] += weight * value[i].to_f64();
    }
}

/// Rounds to the caller's precision.
#[inline(always)]
pub(crate) fn round<T: Real, const N: usize>(value: [f64; N]) -> [T; N] {
    value.map(T::from_f64)
}
