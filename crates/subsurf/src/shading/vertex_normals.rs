//! The unit normals at which subdivision of normals starts: per sector, the faces' normals weighted by their areas, or
//! the mean of normals that the mesh brings along.

use crate::index::Face;
use crate::real::Real;
use crate::topology::Topology;
use rayon::prelude::*;

/// Per vertex of `cut`: the sum of the vector areas of its faces, at unit length; zero where they cancel. `whole` has the
/// same faces, with `positions` at its vertices. Holes count: they shape the surface as other faces do.
pub(super) fn of_positions(whole: &Topology, cut: &Topology, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let scale = unit_scale(positions);
    let areas: Vec<[f64; 3]> = (0..whole.face_count() as u32)
        .into_par_iter()
        .map(|f| vector_area(whole.face_vertices(Face(f)), positions, scale))
        .collect();
    mean(cut, |h| areas[cut.face.get(h as u32) as usize])
}

/// Per vertex of `cut`: the mean of the normals `normals[corners[h]]` at its face corners, at unit length.
pub(super) fn of_corners<T: Real>(cut: &Topology, normals: &[[T; 3]], corners: &[u32]) -> Vec<[f64; 3]> {
    mean(cut, |h| unit(normals[corners[h] as usize].map(T::to_f64)))
}

fn mean(cut: &Topology, at_corner: impl Fn(usize) -> [f64; 3]) -> Vec<[f64; 3]> {
    let mut sum = vec![[0.0; 3]; cut.vertex_count()];
    for (h, &v) in cut.corners().iter().enumerate() {
        add(&mut sum[v as usize], at_corner(h));
    }
    sum.into_par_iter().map(unit).collect()
}

/// A power of two that brings the largest coordinate near 1, so that areas of tiny and huge meshes neither vanish nor
/// overflow.
fn unit_scale(positions: &[[f64; 3]]) -> f64 {
    let size = positions.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
    let scale = (-size.log2().floor()).exp2();
    if scale.is_normal() { scale } else { 1.0 }
}

/// Half the sum of `(a - o) × (b - o)` over a polygon's sides, with `o` its first corner, lengths times `scale`.
fn vector_area(corners: &[u32], positions: &[[f64; 3]], scale: f64) -> [f64; 3] {
    let o = positions[corners[0] as usize];
    let from_o = |v: u32| std::array::from_fn::<f64, 3, _>(|i| (positions[v as usize][i] - o[i]) * scale);
    let mut sum = [0.0; 3];
    for side in corners[1..].windows(2) {
        let (a, b) = (from_o(side[0]), from_o(side[1]));
        let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        add(&mut sum, cross.map(|x| 0.5 * x));
    }
    sum
}

fn add(sum: &mut [f64; 3], v: [f64; 3]) {
    (0..3).for_each(|i| sum[i] += v[i]);
}

/// `v` at unit length; zero where it has none.
pub(super) fn unit(v: [f64; 3]) -> [f64; 3] {
    let size = v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if size == 0.0 || !size.is_finite() {
        return [0.0; 3];
    }
    let v = v.map(|x| x / size);
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|x| x / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    #[test]
    fn normals_of_the_cube_point_along_its_diagonals() {
        let cube = shapes::cube();
        let t = Topology::new(&cube.mesh).unwrap();
        for (n, p) in of_positions(&t, &t, &cube.positions).iter().zip(&cube.positions) {
            (0..3).for_each(|i| assert!((n[i] - p[i] / 3f64.sqrt()).abs() < 1e-15));
        }
    }

    #[test]
    fn normals_do_not_depend_on_the_size_of_the_mesh() {
        let cube = shapes::cube();
        let t = Topology::new(&cube.mesh).unwrap();
        let natural = of_positions(&t, &t, &cube.positions);
        for exponent in [-600, -100, 100, 600] {
            let positions: Vec<[f64; 3]> = cube.positions.iter().map(|p| p.map(|x| x * 2f64.powi(exponent))).collect();
            assert_eq!(of_positions(&t, &t, &positions), natural, "2^{exponent}");
        }
    }

    #[test]
    fn the_vector_area_of_a_polygon_does_not_depend_on_its_first_corner() {
        // A flat L-shape in the plane z = 2: area 3, seen from above.
        let l = [[0.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 1.0, 2.0], [1.0, 1.0, 2.0], [1.0, 2.0, 2.0], [0.0, 2.0, 2.0]];
        for start in 0..6 {
            let corners: Vec<u32> = (0..6).map(|i| (i + start) % 6).collect();
            assert_eq!(vector_area(&corners, &l, 1.0), [0.0, 0.0, 3.0]);
        }
    }

    #[test]
    fn a_vector_without_length_stays_zero() {
        assert_eq!(unit([0.0; 3]), [0.0; 3]);
        assert_eq!(unit([1e-200, 0.0, 0.0]), [1.0, 0.0, 0.0]);
    }
}
