//! Well-spread sample points, the same for every run and any number of threads.
//!
//! The Sobol' (0, 2)-sequence, shuffled and Owen-scrambled by hashes of pixel and purpose: Burley, "Practical
//! hash-based Owen scrambling", JCGT 2020. Its first 2ᵏ points fill any 2ᵏ equal boxes of area 2⁻ᵏ evenly.

use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// The samples of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    seed: u32,
}

impl Sampler {
    /// The sampler of a pixel.
    pub fn new(x: u32, y: u32) -> Self {
        Self { seed: hash(x.wrapping_add(hash(y.wrapping_add(0x9e37_79b9)))) }
    }

    /// The `index`-th point in the unit square. Sequences of different `purpose` are independent.
    pub fn point(&self, purpose: u32, index: u32) -> Vec2 {
        let seed = hash(self.seed ^ purpose.wrapping_mul(0x9e37_79b9));
        let index = scramble(index, seed);
        // First dimension: van der Corput; second: the Sobol' matrix of the polynomial x + 1.
        let x = index.reverse_bits();
        let y = pascal(index).reverse_bits();
        let (x, y) = (scramble(x, hash(seed ^ 0xa511_e9b3)), scramble(y, hash(seed ^ 0x63d8_3595)));
        Vec2::new(unit(x), unit(y))
    }
}

/// Multiplies by the matrix of binomials modulo 2, the generator of the second Sobol' dimension: output bit i is the sum
/// of the input bits j with C(j, i) odd, that is, with every bit of the number i also in j (Lucas 1878).
fn pascal(mut x: u32) -> u32 {
    for (shift, mask) in [(1, 0xaaaa_aaaa_u32), (2, 0xcccc_cccc), (4, 0xf0f0_f0f0), (8, 0xff00_ff00), (16, 0xffff_0000)]
    {
        x ^= (x & mask) >> shift;
    }
    x
}

/// The upper 24 bits as a number in [0, 1).
fn unit(x: u32) -> f32 {
    (x >> 8) as f32 / (1 << 24) as f32
}

/// A 32-bit mixing function (constants of the "lowbias32" search by Wellons, 2018).
fn hash(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// Nested uniform scrambling: each bit is flipped or not depending on the bits above it, so that aligned blocks of
/// 2ᵏ numbers stay together (Laine and Karras 2011, with Burley's constants), done on the reversed number.
fn scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits().wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

/// An offset from the pixel's centre, in pixels, distributed as a tent of the given radius. Averaging samples spread
/// like this is the same as weighting samples with the tent.
pub fn tent(point: Vec2, radius: f32) -> Vec2 {
    let side = |x: f32| if x < 0.5 { (2.0 * x).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * x).sqrt() };
    Vec2::new(side(point.x), side(point.y)) * radius
}

/// A direction about `normal` with density cos / π.
pub fn cosine(point: Vec2, normal: Vec3) -> Vec3 {
    let (a, b) = normal.any_orthonormal_pair();
    let (radius, angle) = (point.x.sqrt(), TAU * point.y);
    a * (radius * angle.cos()) + b * (radius * angle.sin()) + normal * (1.0 - point.x).sqrt()
}

/// A direction within a cone about `axis`, uniform over the disc of radius tan(half angle) at distance 1.
pub fn cone(point: Vec2, axis: Vec3, tangent: f32) -> Vec3 {
    let (a, b) = axis.any_orthonormal_pair();
    let (radius, angle) = (tangent * point.x.sqrt(), TAU * point.y);
    (axis + a * (radius * angle.cos()) + b * (radius * angle.sin())).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_points_fill_all_boxes_of_a_sixteenth() {
        for seed in 0..20 {
            let points: Vec<Vec2> = (0..16).map(|i| Sampler::new(seed, 7).point(1, i)).collect();
            for (columns, rows) in [(16, 1), (8, 2), (4, 4), (2, 8), (1, 16)] {
                let mut boxes: Vec<u32> =
                    points.iter().map(|p| (p.x * columns as f32) as u32 * rows + (p.y * rows as f32) as u32).collect();
                boxes.sort_unstable();
                assert_eq!(boxes, (0..16).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn warped_points_keep_to_their_shapes() {
        let axis = Vec3::new(1.0, 2.0, -2.0) / 3.0;
        for i in 0..64 {
            let point = Sampler::new(1, 2).point(0, i);
            assert!(tent(point, 1.5).abs().max_element() <= 1.5);
            assert!((cosine(point, axis).length() - 1.0).abs() < 1e-5 && cosine(point, axis).dot(axis) >= 0.0);
            assert!(cone(point, axis, 0.1).dot(axis) >= 1.0 / (1.0f32 + 0.01).sqrt() - 1e-5);
        }
    }
}
