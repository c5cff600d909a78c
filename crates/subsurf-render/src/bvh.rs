//! A bounding volume hierarchy over triangles: nodes of four children, leaves of up to four triangles.
//!
//! Both are stored lane by lane ("structure of arrays"), so that four boxes or four triangles are tested by the same
//! few vector instructions on any target, without `unsafe` and without run-time dispatch.
//!
//! The build splits by the surface area heuristic over bins (Wald, "On fast construction of SAH-based bounding volume
//! hierarchies", 2007). The tree, and so every hit, is the same for any number of threads.

mod build;
mod traverse;

use glam::Vec3;

pub use traverse::Stack;

/// Children of a node, and triangles of a leaf.
const LANES: usize = 4;

/// One number per lane. The alignment lets the compiler keep it in one vector register.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(16))]
struct Lanes([f32; LANES]);

/// A child: an inner node, a leaf or nothing. Leaves are marked by the highest bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Child(u32);

impl Child {
    const LEAF: u32 = 1 << 31;

    fn node(index: usize) -> Self {
        Self(index as u32)
    }

    fn leaf(index: usize) -> Self {
        Self(index as u32 | Self::LEAF)
    }

    fn as_leaf(self) -> Option<usize> {
        (self.0 & Self::LEAF != 0).then_some((self.0 & !Self::LEAF) as usize)
    }
}

/// Boxes of four children. An absent child has an inside-out box, which no ray enters.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Node {
    /// `bounds[axis][0]` are the lower and `bounds[axis][1]` the upper sides.
    bounds: [[Lanes; 2]; 3],
    children: [Child; LANES],
}

/// Up to four triangles. An absent triangle is a point, which no ray hits.
#[derive(Clone, Copy, Debug)]
struct Leaf {
    /// `corners[k][axis]`
    corners: [[Lanes; 3]; 3],
    triangles: [u32; LANES],
}

/// A half-line, followed up to `reach` (in units of the length of `direction`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where the ray starts.
    pub origin: Vec3,
    /// Where it goes; need not have length one, must not be zero.
    pub direction: Vec3,
    /// Hits beyond this multiple of `direction` do not count; may be infinite.
    pub reach: f32,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the triangle, as given to [`Bvh::new`].
    pub triangle: u32,
    /// Weights of the triangle's corners; they add up to one.
    pub barycentric: [f32; 3],
    /// In units of the length of the ray's direction.
    pub distance: f32,
}

/// The triangles of a mesh, arranged for ray casting.
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
}

impl Bvh {
    /// Arranges `triangles` over `positions`.
    ///
    /// # Panics
    /// If a triangle names a position that does not exist, or if there are more than 2³⁰ triangles.
    pub fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        build::build(positions, triangles)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A small generator for tests: splitmix64 (Steele et al. 2014), numbers in [0, 1).
    pub struct Random(pub u64);

    impl Random {
        pub fn next(&mut self) -> f32 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = self.0;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
        }

        pub fn point(&mut self) -> Vec3 {
            Vec3::new(self.next(), self.next(), self.next())
        }
    }

    /// Möller and Trumbore 1997 in double precision: distance, or `None`.
    fn hit_one(ray: &Ray, corners: [Vec3; 3]) -> Option<f64> {
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let (e1, e2) = (b - a, c - a);
        let p = direction.cross(e2);
        let det = e1.dot(p);
        if det == 0.0 {
            return None;
        }
        let s = origin - a;
        let u = s.dot(p) / det;
        let q = s.cross(e1);
        let v = direction.dot(q) / det;
        let t = e2.dot(q) / det;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t <= f64::from(ray.reach)).then_some(t)
    }

    fn soup(count: usize, size: f32, random: &mut Random) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let mut positions = Vec::new();
        for _ in 0..count {
            let center = random.point();
            for _ in 0..3 {
                positions.push((center + (random.point() - 0.5) * size).to_array());
            }
        }
        let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        (positions, triangles)
    }

    #[test]
    fn a_ray_meets_the_triangle_that_brute_force_finds() {
        let mut random = Random(1);
        for (count, size) in [(1, 0.8), (3, 0.8), (7, 0.5), (50, 0.4), (2000, 0.1)] {
            let (positions, triangles) = soup(count, size, &mut random);
            let bvh = Bvh::new(&positions, &triangles);
            let mut stack = Stack::new();
            let (mut hits, mut disagreements) = (0, 0);
            for _ in 0..500 {
                let origin = random.point() * 3.0 - 1.0;
                let direction = random.point() - origin;
                let ray = Ray { origin, direction, reach: if random.next() < 0.5 { f32::INFINITY } else { 0.7 } };
                let expected = triangles
                    .iter()
                    .filter_map(|t| hit_one(&ray, t.map(|i| Vec3::from(positions[i as usize]))))
                    .min_by(f64::total_cmp);
                let found = bvh.nearest(&ray, &mut stack);
                assert_eq!(bvh.blocked(&ray, &mut stack), found.is_some());
                match (expected, found) {
                    (None, None) => {}
                    (Some(t), Some(hit)) => {
                        hits += 1;
                        // Single against double precision, coordinates of order one, some triangles seen edge-on.
                        disagreements += usize::from((t - f64::from(hit.distance)).abs() > 1e-4);
                        let on_triangle = triangles[hit.triangle as usize]
                            .iter()
                            .zip(hit.barycentric)
                            .fold(Vec3::ZERO, |sum, (&i, w)| sum + Vec3::from(positions[i as usize]) * w);
                        assert!((on_triangle - (origin + direction * hit.distance)).length() < 1e-3);
                    }
                    _ => disagreements += 1,
                }
            }
            assert!(count < 50 || hits > 100, "{hits} hits");
            // A ray through an edge may fall to either side of it in single precision.
            assert!(disagreements <= 1, "{disagreements} of 500 differ with {count} triangles");
        }
    }

    #[test]
    fn rays_along_axes_find_a_box_from_all_sides() {
        let positions: Vec<[f32; 3]> =
            (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32]).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        let bvh = Bvh::new(&positions, &triangles);
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                // The centre ray meets the diagonal, the shared edge of two triangles.
                let mut direction = Vec3::ZERO;
                direction[axis] = side;
                let ray = Ray { origin: Vec3::splat(0.5) - direction * 2.0, direction, reach: f32::INFINITY };
                let hit = bvh.nearest(&ray, &mut Stack::new()).expect("the box is closed");
                assert!((hit.distance - 1.5).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn many_triangles_in_one_place_still_make_a_tree() {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let triangles = vec![[0, 1, 2]; 5000];
        let bvh = Bvh::new(&positions, &triangles);
        let ray = Ray { origin: Vec3::new(0.2, 0.2, 1.0), direction: Vec3::NEG_Z, reach: f32::INFINITY };
        assert_eq!(bvh.nearest(&ray, &mut Stack::new()).map(|hit| hit.distance), Some(1.0));
    }

    #[test]
    fn no_triangles_give_no_hits() {
        let bvh = Bvh::new(&[], &[]);
        let ray = Ray { origin: Vec3::ZERO, direction: Vec3::X, reach: f32::INFINITY };
        assert_eq!(bvh.nearest(&ray, &mut Stack::new()), None);
    }
}
