//! From components to samples: blocks are summed component by component (`x x x …`, `y y y …`, `z z z …`) and stored
//! sample by sample (`x y z x y z …`).

use super::LANES;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::{Level, Simd, SimdBase, SimdFrom, f32x16, f64x8, u8x64};

/// What blocks of samples ask of a number beyond sums and products.
pub trait Lanes: Sized + Copy + Default {
    /// Squared lengths below this have lost digits to underflow.
    const SMALLEST_SQUARE: Self;

    /// Square root.
    #[doc(hidden)]
    fn root(self) -> Self;

    /// `1 / self`.
    #[doc(hidden)]
    fn inverse(self) -> Self;

    /// `out[k][c] = planes[c][k]` for as many samples as `out` has, at most [`LANES`].
    #[doc(hidden)]
    fn interleave<const N: usize>(planes: &[[Self; LANES]; N], out: &mut [[Self; N]]);
}

impl Lanes for f32 {
    const SMALLEST_SQUARE: Self = 1e-30;

    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn inverse(self) -> Self {
        1.0 / self
    }

    #[inline(always)]
    fn interleave<const N: usize>(planes: &[[Self; LANES]; N], out: &mut [[Self; N]]) {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        if N == 3
            && let Some(simd) = Level::new().as_avx512()
            && let Ok(out) = <&mut [f32; 48]>::try_from(out.as_flattened_mut())
        {
            let [x, y, z] = [0, 1, 2].map(
                #[inline(always)]
                |c| f32x16::simd_from(simd, planes[c]),
            );
            for (part, [first, second]) in out.as_chunks_mut::<16>().0.iter_mut().zip(&THREE_F32) {
                let xy = simd.concat_swizzle_dyn_f32x16(x, y, u8x64::simd_from(simd, *first));
                let xyz = simd.concat_swizzle_dyn_f32x16(xy, z, u8x64::simd_from(simd, *second));
                part.copy_from_slice(xyz.as_slice());
            }
            return;
        }
        plain(planes, out);
    }
}

impl Lanes for f64 {
    const SMALLEST_SQUARE: Self = 1e-280;

    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn inverse(self) -> Self {
        1.0 / self
    }

    #[inline(always)]
    fn interleave<const N: usize>(planes: &[[Self; LANES]; N], out: &mut [[Self; N]]) {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        if N == 3
            && let Some(simd) = Level::new().as_avx512()
            && let Ok(out) = <&mut [f64; 48]>::try_from(out.as_flattened_mut())
        {
            for (half, out) in out.as_chunks_mut::<24>().0.iter_mut().enumerate() {
                let [x, y, z] = [0, 1, 2].map(
                    #[inline(always)]
                    |c| f64x8::simd_from(simd, planes[c].as_chunks::<8>().0[half]),
                );
                for (part, [first, second]) in out.as_chunks_mut::<8>().0.iter_mut().zip(&THREE_F64) {
                    let xy = simd.concat_swizzle_dyn_f64x8(x, y, u8x64::simd_from(simd, *first));
                    let xyz = simd.concat_swizzle_dyn_f64x8(xy, z, u8x64::simd_from(simd, *second));
                    part.copy_from_slice(xyz.as_slice());
                }
            }
            return;
        }
        plain(planes, out);
    }
}

/// Element by element.
#[inline(always)]
fn plain<T: Copy, const N: usize>(planes: &[[T; LANES]; N], out: &mut [[T; N]]) {
    if let Ok(out) = <&mut [[T; N]; LANES]>::try_from(&mut *out) {
        for k in 0..LANES {
            for c in 0..N {
                out[k][c] = planes[c][k];
            }
        }
        return;
    }
    for (k, out) in out.iter_mut().enumerate().take(LANES) {
        for c in 0..N {
            out[c] = planes[c][k];
        }
    }
}

/// Bytes to take for each third of the result: from `x` followed by `y`, then from that followed by `z`.
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
type Three = [[[u8; 64]; 2]; 3];
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
const THREE_F32: Three = three(16);
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
const THREE_F64: Three = three(8);

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
const fn three(lanes: usize) -> Three {
    let mut bytes = [[[0; 64]; 2]; 3];
    let size = 64 / lanes;
    let mut at = 0;
    while at < 3 * lanes {
        let (part, lane, component, sample) = (at / lanes, at % lanes, at % 3, at / 3);
        // The first step leaves lanes of z to the second, which leaves the others where they are.
        let first = if component == 1 { lanes + sample } else { sample };
        let second = if component == 2 { lanes + sample } else { lane };
        let mut b = 0;
        while b < size {
            bytes[part][0][lane * size + b] = (first * size + b) as u8;
            bytes[part][1][lane * size + b] = (second * size + b) as u8;
            b += 1;
        }
        at += 1;
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::vectorized;
    use crate::real::Real;

    #[test]
    fn components_come_side_by_side_for_any_number_of_samples() {
        fn check<T: Real, const N: usize>() {
            let planes: [[T; LANES]; N] =
                std::array::from_fn(|c| std::array::from_fn(|k| T::from_f64((100 * c + k) as f64)));
            for samples in 0..=LANES {
                let mut out = vec![[T::default(); N]; samples];
                vectorized(
                    #[inline(always)]
                    || T::interleave(&planes, &mut out),
                );
                for (k, out) in out.iter().enumerate() {
                    assert_eq!(*out, std::array::from_fn(|c| T::from_f64((100 * c + k) as f64)));
                }
            }
        }
        check::<f32, 3>();
        check::<f64, 3>();
        check::<f32, 2>();
        check::<f64, 4>();
        check::<f32, 1>();
    }
}
