//! Sixteen numbers at once, one per sample: one vector of the machine or several.

use super::LANES;
use fearless_simd::{Level, Simd, SimdBase, SimdFrom, f32x4, f32x16, f64x4, f64x8, u8x64};

/// What vector kernels ask of a number. All operations round as those of single numbers do.
#[doc(hidden)]
pub trait Lanes: Sized + Copy + Default {
    /// One number per sample of a block.
    type Block<S: Simd>: Copy;

    /// Squared lengths below this have lost digits to underflow.
    const SMALLEST_SQUARE: Self;

    fn splat<S: Simd>(simd: S, x: Self) -> Self::Block<S>;
    fn load<S: Simd>(simd: S, x: &[Self; LANES]) -> Self::Block<S>;
    fn store<S: Simd>(simd: S, x: Self::Block<S>, out: &mut [Self; LANES]);
    fn plus<S: Simd>(simd: S, a: Self::Block<S>, b: Self::Block<S>) -> Self::Block<S>;
    fn minus<S: Simd>(simd: S, a: Self::Block<S>, b: Self::Block<S>) -> Self::Block<S>;
    fn times<S: Simd>(simd: S, a: Self::Block<S>, b: Self::Block<S>) -> Self::Block<S>;
    /// `1 / √x`, by a root and a division.
    fn inverse_root<S: Simd>(simd: S, x: Self::Block<S>) -> Self::Block<S>;
    /// The samples, as bits, where `a > b`.
    fn above<S: Simd>(simd: S, a: Self::Block<S>, b: Self::Block<S>) -> u32;
    /// Sums of the lanes 0 4 8 12, 1 5 9 13, 2 6 10 14 and 3 7 11 15: of `(0 + 8) + (4 + 12)`, to name the order.
    fn quarters<S: Simd>(simd: S, x: Self::Block<S>) -> [Self; 4];
    /// Lanes of both in turn, `a0 b0 a1 b1 …`: the first sixteen and the last.
    fn zip<S: Simd>(simd: S, a: Self::Block<S>, b: Self::Block<S>) -> [Self::Block<S>; 2];
    /// The way back: the lanes with even numbers of both, and the odd ones.
    fn unzip<S: Simd>(simd: S, a: Self::Block<S>, b: Self::Block<S>) -> [Self::Block<S>; 2];
    /// Four numbers less four others, in one step.
    fn apart<S: Simd>(simd: S, a: [Self; 4], b: [Self; 4]) -> [Self; 4];
    /// Four numbers in double precision.
    fn wide<S: Simd>(simd: S, x: [Self; 4]) -> f64x4<S>;
    /// Stores three components sample by sample: `x y z x y z …`.
    fn store_xyz<S: Simd>(simd: S, xyz: [Self::Block<S>; 3], out: &mut [[Self; 3]; LANES]);
}

impl Lanes for f32 {
    type Block<S: Simd> = f32x16<S>;

    const SMALLEST_SQUARE: Self = 1e-30;

    #[inline(always)]
    fn splat<S: Simd>(simd: S, x: Self) -> f32x16<S> {
        simd.splat_f32x16(x)
    }

    #[inline(always)]
    fn load<S: Simd>(simd: S, x: &[Self; LANES]) -> f32x16<S> {
        f32x16::simd_from(simd, *x)
    }

    #[inline(always)]
    fn store<S: Simd>(_: S, x: f32x16<S>, out: &mut [Self; LANES]) {
        out.copy_from_slice(x.as_slice());
    }

    #[inline(always)]
    fn plus<S: Simd>(simd: S, a: f32x16<S>, b: f32x16<S>) -> f32x16<S> {
        simd.add_f32x16(a, b)
    }

    #[inline(always)]
    fn minus<S: Simd>(simd: S, a: f32x16<S>, b: f32x16<S>) -> f32x16<S> {
        simd.sub_f32x16(a, b)
    }

    #[inline(always)]
    fn times<S: Simd>(simd: S, a: f32x16<S>, b: f32x16<S>) -> f32x16<S> {
        simd.mul_f32x16(a, b)
    }

    #[inline(always)]
    fn inverse_root<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
        simd.div_f32x16(simd.splat_f32x16(1.0), simd.sqrt_f32x16(x))
    }

    #[inline(always)]
    fn above<S: Simd>(simd: S, a: f32x16<S>, b: f32x16<S>) -> u32 {
        simd.to_bitmask_mask32x16(simd.simd_gt_f32x16(a, b)) as u32
    }

    #[inline(always)]
    fn quarters<S: Simd>(simd: S, x: f32x16<S>) -> [Self; 4] {
        let (low, high) = simd.split_f32x16(x);
        let (low, high) = simd.split_f32x8(simd.add_f32x8(low, high));
        simd.add_f32x4(low, high).into()
    }

    #[inline(always)]
    fn zip<S: Simd>(simd: S, a: f32x16<S>, b: f32x16<S>) -> [f32x16<S>; 2] {
        [simd.zip_low_f32x16(a, b), simd.zip_high_f32x16(a, b)]
    }

    #[inline(always)]
    fn unzip<S: Simd>(simd: S, a: f32x16<S>, b: f32x16<S>) -> [f32x16<S>; 2] {
        [simd.unzip_low_f32x16(a, b), simd.unzip_high_f32x16(a, b)]
    }

    #[inline(always)]
    fn apart<S: Simd>(simd: S, a: [Self; 4], b: [Self; 4]) -> [Self; 4] {
        simd.sub_f32x4(f32x4::simd_from(simd, a), f32x4::simd_from(simd, b)).into()
    }

    #[inline(always)]
    fn wide<S: Simd>(simd: S, x: [Self; 4]) -> f64x4<S> {
        let (low, high) = simd.widen_f32x4(f32x4::simd_from(simd, x));
        simd.combine_f64x2(low, high)
    }

    #[inline(always)]
    fn store_xyz<S: Simd>(simd: S, xyz: [f32x16<S>; 3], out: &mut [[Self; 3]; LANES]) {
        if has_permutations(simd) {
            let [x, y, z] = xyz;
            for (part, [first, second]) in out.as_flattened_mut().as_chunks_mut::<16>().0.iter_mut().zip(&THREE_F32) {
                let xy = simd.concat_swizzle_dyn_f32x16(x, y, u8x64::simd_from(simd, *first));
                let xyz = simd.concat_swizzle_dyn_f32x16(xy, z, u8x64::simd_from(simd, *second));
                part.copy_from_slice(xyz.as_slice());
            }
        } else {
            store_each::<Self, S, 3>(simd, xyz, out);
        }
    }
}

impl Lanes for f64 {
    type Block<S: Simd> = [f64x8<S>; 2];

    const SMALLEST_SQUARE: Self = 1e-280;

    #[inline(always)]
    fn splat<S: Simd>(simd: S, x: Self) -> [f64x8<S>; 2] {
        [simd.splat_f64x8(x); 2]
    }

    #[inline(always)]
    fn load<S: Simd>(simd: S, x: &[Self; LANES]) -> [f64x8<S>; 2] {
        let [low, high] = [0, 1].map(
            #[inline(always)]
            |half| f64x8::simd_from(simd, x.as_chunks::<8>().0[half]),
        );
        [low, high]
    }

    #[inline(always)]
    fn store<S: Simd>(_: S, x: [f64x8<S>; 2], out: &mut [Self; LANES]) {
        for half in 0..2 {
            out.as_chunks_mut::<8>().0[half].copy_from_slice(x[half].as_slice());
        }
    }

    #[inline(always)]
    fn plus<S: Simd>(simd: S, a: [f64x8<S>; 2], b: [f64x8<S>; 2]) -> [f64x8<S>; 2] {
        [simd.add_f64x8(a[0], b[0]), simd.add_f64x8(a[1], b[1])]
    }

    #[inline(always)]
    fn minus<S: Simd>(simd: S, a: [f64x8<S>; 2], b: [f64x8<S>; 2]) -> [f64x8<S>; 2] {
        [simd.sub_f64x8(a[0], b[0]), simd.sub_f64x8(a[1], b[1])]
    }

    #[inline(always)]
    fn times<S: Simd>(simd: S, a: [f64x8<S>; 2], b: [f64x8<S>; 2]) -> [f64x8<S>; 2] {
        [simd.mul_f64x8(a[0], b[0]), simd.mul_f64x8(a[1], b[1])]
    }

    #[inline(always)]
    fn inverse_root<S: Simd>(simd: S, x: [f64x8<S>; 2]) -> [f64x8<S>; 2] {
        let one = simd.splat_f64x8(1.0);
        [simd.div_f64x8(one, simd.sqrt_f64x8(x[0])), simd.div_f64x8(one, simd.sqrt_f64x8(x[1]))]
    }

    #[inline(always)]
    fn above<S: Simd>(simd: S, a: [f64x8<S>; 2], b: [f64x8<S>; 2]) -> u32 {
        let low = simd.to_bitmask_mask64x8(simd.simd_gt_f64x8(a[0], b[0])) as u32;
        low | (simd.to_bitmask_mask64x8(simd.simd_gt_f64x8(a[1], b[1])) as u32) << 8
    }

    #[inline(always)]
    fn quarters<S: Simd>(simd: S, x: [f64x8<S>; 2]) -> [Self; 4] {
        let (low, high) = simd.split_f64x8(simd.add_f64x8(x[0], x[1]));
        simd.add_f64x4(low, high).into()
    }

    #[inline(always)]
    fn zip<S: Simd>(simd: S, a: [f64x8<S>; 2], b: [f64x8<S>; 2]) -> [[f64x8<S>; 2]; 2] {
        let (low, high) = (simd.zip_low_f64x8(a[0], b[0]), simd.zip_high_f64x8(a[0], b[0]));
        [[low, high], [simd.zip_low_f64x8(a[1], b[1]), simd.zip_high_f64x8(a[1], b[1])]]
    }

    #[inline(always)]
    fn unzip<S: Simd>(simd: S, a: [f64x8<S>; 2], b: [f64x8<S>; 2]) -> [[f64x8<S>; 2]; 2] {
        let even = [simd.unzip_low_f64x8(a[0], a[1]), simd.unzip_low_f64x8(b[0], b[1])];
        [even, [simd.unzip_high_f64x8(a[0], a[1]), simd.unzip_high_f64x8(b[0], b[1])]]
    }

    #[inline(always)]
    fn apart<S: Simd>(simd: S, a: [Self; 4], b: [Self; 4]) -> [Self; 4] {
        simd.sub_f64x4(f64x4::simd_from(simd, a), f64x4::simd_from(simd, b)).into()
    }

    #[inline(always)]
    fn wide<S: Simd>(simd: S, x: [Self; 4]) -> f64x4<S> {
        f64x4::simd_from(simd, x)
    }

    #[inline(always)]
    fn store_xyz<S: Simd>(simd: S, xyz: [[f64x8<S>; 2]; 3], out: &mut [[Self; 3]; LANES]) {
        if has_permutations(simd) {
            for (half, out) in out.as_flattened_mut().as_chunks_mut::<24>().0.iter_mut().enumerate() {
                for (part, [first, second]) in out.as_chunks_mut::<8>().0.iter_mut().zip(&THREE_F64) {
                    let [x, y, z] = [xyz[0][half], xyz[1][half], xyz[2][half]];
                    let xy = simd.concat_swizzle_dyn_f64x8(x, y, u8x64::simd_from(simd, *first));
                    let xyz = simd.concat_swizzle_dyn_f64x8(xy, z, u8x64::simd_from(simd, *second));
                    part.copy_from_slice(xyz.as_slice());
                }
            }
        } else {
            store_each::<Self, S, 3>(simd, xyz, out);
        }
    }
}

/// True where the machine takes any sixteen of thirty-two numbers in one step.
#[inline(always)]
fn has_permutations<S: Simd>(simd: S) -> bool {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let Level::Avx512(_) = simd.level() {
        return true;
    }
    let _ = simd;
    false
}

/// Stores components number by number.
#[inline(always)]
pub(super) fn store_each<T: Lanes, S: Simd, const N: usize>(simd: S, x: [T::Block<S>; N], out: &mut [[T; N]]) {
    let mut planes = [[T::default(); LANES]; N];
    for c in 0..N {
        T::store(simd, x[c], &mut planes[c]);
    }
    for (k, out) in out.iter_mut().enumerate().take(LANES) {
        for c in 0..N {
            out[c] = planes[c][k];
        }
    }
}

/// Bytes to take for each third of the result: from `x` followed by `y`, then from that followed by `z`.
type Three = [[[u8; 64]; 2]; 3];
const THREE_F32: Three = three(16);
const THREE_F64: Three = three(8);

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
    use crate::kernel::level;
    use crate::real::Real;
    use fearless_simd::dispatch;

    #[test]
    fn components_come_side_by_side() {
        fn check<T: Real>() {
            let planes: [[T; LANES]; 3] =
                std::array::from_fn(|c| std::array::from_fn(|k| T::from_f64((100 * c + k) as f64)));
            let mut out = [[T::default(); 3]; LANES];
            dispatch!(level(), simd => T::store_xyz(simd, [0, 1, 2].map(|c| T::load(simd, &planes[c])), &mut out));
            for (k, out) in out.iter().enumerate() {
                assert_eq!(*out, [0, 1, 2].map(|c| T::from_f64((100 * c + k) as f64)));
            }
        }
        check::<f32>();
        check::<f64>();
    }
}
