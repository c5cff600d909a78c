//! Whether sixteen numbers are all different: each is compared with those up to half the way round from it, all at once.

use super::level;
use fearless_simd::{Simd, SimdBase, SimdMask, dispatch, u32x16};

/// For all starts of sixteen numbers in `all`, whether these are all different.
///
/// # Panics
/// If there are not sixteen numbers from a start on.
pub(crate) fn are_distinct(all: &[u32], starts: &[u32], out: &mut Vec<bool>) {
    out.clear();
    out.resize(starts.len(), false);
    dispatch!(level(), simd => simd.vectorize(
        #[inline(always)]
        || {
            for (&start, out) in starts.iter().zip(&mut *out) {
                *out = is_distinct(simd, &all[start as usize..][..16]);
            }
        }
    ));
}

#[inline(always)]
fn is_distinct<S: Simd>(simd: S, numbers: &[u32]) -> bool {
    let own = u32x16::from_slice(simd, numbers);
    let mut same = own.simd_eq(own.slide::<1>(own));
    same |= own.simd_eq(own.slide::<2>(own));
    same |= own.simd_eq(own.slide::<3>(own));
    same |= own.simd_eq(own.slide::<4>(own));
    same |= own.simd_eq(own.slide::<5>(own));
    same |= own.simd_eq(own.slide::<6>(own));
    same |= own.simd_eq(own.slide::<7>(own));
    same |= own.simd_eq(own.slide::<8>(own));
    !same.any_true()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_two_equal_numbers_are_found() {
        let mut all: Vec<u32> = (0..16).map(|i| 7 * i + 3).collect();
        let starts = [0];
        let mut out = Vec::new();
        are_distinct(&all, &starts, &mut out);
        assert_eq!(out, [true]);
        for (i, j) in (0..16).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let old = all[i];
            all[i] = all[j];
            are_distinct(&all, &starts, &mut out);
            assert_eq!(out, [false], "{i} {j}");
            all[i] = old;
        }
    }
}
