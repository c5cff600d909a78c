//! Which vector instructions the loops run with: those of the machine, or narrower ones on request.

#![expect(clippy::disallowed_methods, reason = "all others ask here")]

use fearless_simd::Level;
use std::sync::OnceLock;

/// Decided by the first loop that runs, or by a limit before that.
static LEVEL: OnceLock<Level> = OnceLock::new();

/// What loops are compiled for in this process.
#[inline(always)]
pub(crate) fn level() -> Level {
    *LEVEL.get_or_init(Level::new)
}

/// Limits vector instructions to so many bits in this process, and returns how many bits they have from now on: 128 (what every
/// machine of the kind has), 256 (AVX2) or 512 (AVX-512). To compare machines: results are the same bits at any width. It has an effect
/// before anything else of this crate runs, and once; machines do not get wider by it, nor narrower than what this crate was compiled
/// for (`target-cpu`), than what ran before, or than 128 bits.
///
/// ```
/// let bits = subsurf::limit_vector_bits(256);
/// assert!(bits <= 256 || cfg!(target_feature = "avx512f"));
/// ```
pub fn limit_vector_bits(most: u32) -> u32 {
    bits(*LEVEL.get_or_init(|| at_most(Level::new(), most)))
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fn at_most(level: Level, bits: u32) -> Level {
    match (bits, level.as_avx2()) {
        (512.., _) => level,
        (256.., Some(avx2)) => Level::Avx2(avx2),
        _ => Level::baseline(),
    }
}

#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
fn at_most(level: Level, _: u32) -> Level {
    level
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fn bits(level: Level) -> u32 {
    match (level.as_avx512(), level.as_avx2()) {
        (Some(_), _) => 512,
        (None, Some(_)) => 256,
        (None, None) => 128,
    }
}

#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
fn bits(_: Level) -> u32 {
    128
}
