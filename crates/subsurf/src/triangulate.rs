//! Cuts polygons into triangles, for Loop subdivision.
//!
//! A polygon loses one ear after the other: the triangle of three neighbouring corners whose diagonal is shortest. A quad
//! so is cut along its shorter diagonal. Diagonals that are equal to seven digits count as equal, and the first corners
//! win: quads of a regular grid are all cut the same way, which makes its vertices regular.
//!
//! Left for last are ears that would fold over (against the polygon's mean normal), that hold another corner, or whose
//! diagonal is an edge of the mesh already. Polygons of more than [`LARGEST`] corners are halved from their first corner
//! until they have fewer; where those are concave, parts may fold over.

use crate::index::Face;
use crate::mesh::{ControlMesh, MAX_COUNT, MeshError};
use crate::real::Real;
use crate::tags::{Boundary, Corner, INFINITE_SHARPNESS, Tags};
use crate::topology::Topology;
use std::collections::HashSet;

/// Most corners of a polygon that is cut ear by ear, at a cost of the square of their number, of the cube where many ears
/// would fold over. Larger: seconds for one polygon; smaller: more long diagonals.
const LARGEST: usize = 128;

/// A mesh in triangles, and where they come from.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangulated {
    /// The same vertices, edges and tags, with more edges. Parts of a hole are holes. Vertices that the boundary rule
    /// [`Boundary::EdgeAndCorner`] pins because they have one face, and that have several triangles now, are tagged as
    /// infinitely sharp corners.
    pub mesh: ControlMesh,
    /// The face that each triangle is part of.
    pub faces: Vec<u32>,
    /// For every corner of every triangle the corner it was, an index into [`ControlMesh::corners`] of the mesh before:
    /// indices of texture coordinates and other channels follow it.
    pub corners: Vec<u32>,
}

impl ControlMesh {
    /// The mesh with every polygon cut into triangles along its shortest diagonals, which depend on `positions`. Use one
    /// cut for all frames of an animation.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`] where the triangles' corners would overflow 32-bit indices, and those of [`Topology::new`]:
    /// a crease along what only becomes an edge by the cut is refused.
    ///
    /// # Panics
    /// If `positions` has not one row per vertex.
    pub fn triangulated<T: Real>(&self, positions: &[[T; 3]]) -> Result<Triangulated, MeshError> {
        assert_eq!(positions.len(), self.vertex_count(), "one position per vertex of the mesh");
        let count = self.corners().len() as u64 * 3 - 6 * self.face_count() as u64;
        if count > MAX_COUNT as u64 {
            let what = "corners once its faces are triangles";
            return Err(MeshError::TooLarge { what, count: count as usize, limit: MAX_COUNT });
        }
        let mut cutter = Cutter::new(self, positions);
        let (mut faces, mut corners) = (Vec::new(), Vec::with_capacity(count as usize));
        for (f, face) in self.faces().enumerate() {
            let first = self.face_offsets()[f];
            for triangle in cutter.cut(face) {
                faces.push(f as u32);
                corners.extend(triangle.map(|i| first + i as u32));
            }
        }
        let vertices: Vec<u32> = corners.iter().map(|&c| self.corners()[c as usize]).collect();
        let tags = self.tags_of_parts(&Topology::new(self)?, &faces, &vertices);
        let mesh = Self::from_counts(self.vertex_count(), &vec![3; faces.len()], vertices, tags)?;
        Ok(Triangulated { mesh, faces, corners })
    }

    /// Holes are those of the whole faces, by tag or by the boundary rule.
    fn tags_of_parts(&self, whole: &Topology, faces: &[u32], vertices: &[u32]) -> Tags {
        let mut tags = self.tags().clone();
        tags.holes = (0..faces.len() as u32).filter(|&t| whole.is_hole(Face(faces[t as usize]))).collect();
        if tags.rules.boundary == Boundary::EdgeAndCorner {
            let [before, now] = [self.corners(), vertices].map(|list| {
                let mut count = vec![0u32; self.vertex_count()];
                list.iter().for_each(|&v| count[v as usize] += 1);
                count
            });
            let pinned = (0..self.vertex_count()).filter(|&v| before[v] == 1 && now[v] > 1);
            tags.corners.extend(pinned.map(|v| Corner::new(v as u32, INFINITE_SHARPNESS)));
        }
        tags
    }
}

struct Cutter<'a, T> {
    positions: &'a [[T; 3]],
    /// The mesh's edges and the diagonals so far, smaller vertex first.
    edges: HashSet<(u32, u32)>,
}

impl<'a, T: Real> Cutter<'a, T> {
    fn new(mesh: &ControlMesh, positions: &'a [[T; 3]]) -> Self {
        let mut edges = HashSet::new();
        if mesh.faces().any(|face| face.len() > 3) {
            for face in mesh.faces() {
                for i in 0..face.len() {
                    edges.insert(edge(face[i], face[(i + 1) % face.len()]));
                }
            }
        }
        Self { positions, edges }
    }

    /// The triangles of a face, as corners of the face.
    fn cut(&mut self, face: &[u32]) -> Vec<[usize; 3]> {
        let mut triangles = Vec::with_capacity(face.len() - 2);
        let mut parts = vec![(0..face.len()).collect::<Vec<usize>>()];
        while let Some(mut part) = parts.pop() {
            if part.len() > LARGEST {
                let middle = part.len() / 2;
                self.edges.insert(edge(face[part[0]], face[part[middle]]));
                let first = part[0];
                let mut rest = part.split_off(middle);
                part.push(rest[0]);
                rest.push(first);
                parts.extend([rest, part]);
                continue;
            }
            while part.len() > 3 {
                let at = self.best_ear(face, &part);
                let n = part.len();
                let (before, after) = (part[(at + n - 1) % n], part[(at + 1) % n]);
                self.edges.insert(edge(face[before], face[after]));
                triangles.push([before, part[at], after]);
                part.remove(at);
            }
            triangles.push([part[0], part[1], part[2]]);
        }
        // From the lowest corner on, as the face runs.
        for triangle in &mut triangles {
            let lowest = (0..3).min_by_key(|&k| triangle[k]).unwrap_or(0);
            triangle.rotate_left(lowest);
        }
        triangles
    }

    /// Which of the corners that are left is cut off next.
    fn best_ear(&self, face: &[u32], left: &[usize]) -> usize {
        let n = left.len();
        let points: Vec<[f64; 3]> = left.iter().map(|&i| self.positions[face[i] as usize].map(T::to_f64)).collect();
        let up = mean_normal(&points);
        let around = |at: usize| ((at + n - 1) % n, (at + 1) % n);
        let length = |at: usize| {
            let (before, after) = around(at);
            let diagonal = minus(points[after], points[before]);
            // In a quad, cutting off corner 1 is what makes the first corner's diagonal.
            (rounded(dot(diagonal, diagonal)), before)
        };
        let is_good = |at: usize| {
            let (before, after) = around(at);
            let [a, b, c] = [before, at, after].map(|k| points[k]);
            let turns = |a, b, c| dot(cross(minus(b, a), minus(c, a)), up);
            let holds = |&p: &[f64; 3]| {
                ![a, b, c].contains(&p) && turns(a, b, p) >= 0.0 && turns(b, c, p) >= 0.0 && turns(c, a, p) >= 0.0
            };
            let is_edge = self.edges.contains(&edge(face[left[before]], face[left[after]]));
            turns(a, b, c) > 0.0 && !is_edge && !points.iter().any(holds)
        };
        let mut ears: Vec<usize> = (0..n).collect();
        ears.sort_by_cached_key(|&at| length(at));
        ears.iter().copied().find(|&at| is_good(at)).unwrap_or(ears[0])
    }
}

fn edge(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// A positive number to 24 binary digits, as something that sorts.
fn rounded(x: f64) -> u64 {
    (x.to_bits() + (1 << 28)) >> 29
}

/// Newell's normal: twice the area, seen from where the polygon runs counter-clockwise.
fn mean_normal(points: &[[f64; 3]]) -> [f64; 3] {
    let origin = points[0];
    let mut sum = [0.0; 3];
    for pair in points.windows(2) {
        let n = cross(minus(pair[0], origin), minus(pair[1], origin));
        (0..3).for_each(|k| sum[k] += n[k]);
    }
    sum
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;
    use crate::tags::Rules;

    fn flat(points: &[(f64, f64)]) -> Triangulated {
        let face: Vec<u32> = (0..points.len() as u32).collect();
        let positions: Vec<[f64; 3]> = points.iter().map(|&(x, y)| [x, y, 0.0]).collect();
        ControlMesh::new(&[face], Tags::default()).unwrap().triangulated(&positions).unwrap()
    }

    #[test]
    fn a_quad_is_cut_along_its_shorter_diagonal_and_a_square_from_its_first_corner() {
        let triangles = |points: &[(f64, f64)]| flat(points).mesh.faces().map(<[u32]>::to_vec).collect::<Vec<_>>();
        assert_eq!(triangles(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(triangles(&[(0.0, 0.0), (1.0, 0.0), (2.0, 1.0), (0.0, 1.0)]), [[1, 2, 3], [0, 1, 3]]);
        // The longer diagonal of an arrow head is the one inside it.
        assert_eq!(triangles(&[(0.0, 0.0), (1.0, 2.0), (0.0, 0.5), (-1.0, 2.0)]), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn triangles_of_a_concave_polygon_cover_it_once() {
        // A comb: teeth of different heights. Areas of triangles all turned one way add up to that of the polygon only
        // if none overlap.
        let mut comb: Vec<(f64, f64)> = vec![(9.0, 0.0)];
        for i in (0..9).rev() {
            comb.push((f64::from(i) + 0.7, 2.0 + f64::from(i % 4)));
            comb.push((f64::from(i), 1.0));
        }
        comb.push((0.0, 0.0));
        let area = |p: &[(f64, f64)]| -> f64 {
            (0..p.len()).map(|i| (p[i], p[(i + 1) % p.len()])).map(|(a, b)| 0.5 * (a.0 * b.1 - b.0 * a.1)).sum()
        };
        let parts: Vec<f64> = flat(&comb).mesh.faces().map(|t| area(&[0, 1, 2].map(|k| comb[t[k] as usize]))).collect();
        assert!(parts.iter().all(|&part| part > 0.0), "{parts:?}");
        // Rounding of twenty products of size 50.
        assert!((parts.iter().sum::<f64>() - area(&comb)).abs() < 1e-12);
    }

    #[test]
    fn a_polygon_of_any_size_becomes_two_triangles_fewer_than_it_has_corners() {
        for n in [3usize, 4, 5, LARGEST, LARGEST + 1, 1000] {
            let angle = |i: usize| 2.0 * std::f64::consts::PI * i as f64 / n as f64;
            let cut = flat(&(0..n).map(|i| (angle(i).cos(), angle(i).sin())).collect::<Vec<_>>());
            assert_eq!((cut.mesh.face_count(), cut.corners.len()), (n - 2, 3 * (n - 2)), "{n}");
            let mut sides = HashSet::new();
            for t in cut.mesh.faces() {
                (0..3).for_each(|i| assert!(sides.insert((t[i], t[(i + 1) % 3])), "{n}: an edge twice"));
            }
            assert!((0..n as u32).all(|i| sides.contains(&(i, (i + 1) % n as u32))), "{n}: an edge is lost");
        }
    }

    #[test]
    fn a_crease_on_no_edge_of_the_polygons_is_refused() {
        let tags = Tags { creases: vec![crate::tags::Crease::new(0, 2, 2.0)], ..Tags::default() };
        let quad = ControlMesh::new(&[[0, 1, 2, 3]], tags).unwrap();
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        assert!(matches!(quad.triangulated(&square), Err(MeshError::CreaseNotOnEdge { crease: 0, a: 0, b: 2 })));
    }

    #[test]
    fn the_boundary_rule_makes_holes_of_whole_polygons() {
        let shape = shapes::grid(3, 3);
        let mesh = shape.mesh.with_rules(Rules { boundary: Boundary::None, ..Rules::default() });
        let cut = mesh.triangulated(&shape.positions).unwrap();
        let (whole, parts) = (Topology::new(&mesh).unwrap(), Topology::new(&cut.mesh).unwrap());
        for (t, &f) in cut.faces.iter().enumerate() {
            assert_eq!(parts.is_hole(Face(t as u32)), whole.is_hole(Face(f)), "triangle {t}");
        }
    }

    #[test]
    fn corners_faces_creases_and_holes_are_those_of_the_polygons() {
        for shape in shapes::all() {
            let cut = shape.mesh.triangulated(&shape.positions).unwrap();
            let (old, new) = (&shape.mesh, &cut.mesh);
            assert_eq!(new.tags().creases, old.tags().creases, "{}", shape.name);
            for (i, &c) in cut.corners.iter().enumerate() {
                assert_eq!(new.corners()[i], old.corners()[c as usize], "{}", shape.name);
                let face = old.face_offsets().partition_point(|&o| o <= c) - 1;
                assert_eq!(face as u32, cut.faces[i / 3], "{}", shape.name);
            }
            let (old, new) = (Topology::new(old).unwrap(), Topology::new(new).unwrap());
            for (t, &f) in cut.faces.iter().enumerate() {
                assert_eq!(new.is_hole(Face(t as u32)), old.is_hole(Face(f)), "{}", shape.name);
            }
        }
    }

    #[test]
    fn a_corner_of_the_boundary_stays_pinned_though_it_has_two_triangles_now() {
        let grid = shapes::grid(2, 2);
        let pinned = |boundary| {
            let mesh = grid.mesh.clone().with_rules(Rules { boundary, ..Rules::default() });
            mesh.triangulated(&grid.positions).unwrap().mesh.tags().corners.len()
        };
        // Each diagonal of a corner quad takes in the grid's corner or leaves it with one triangle.
        let corner =
            |v: u32| grid.mesh.triangulated(&grid.positions).unwrap().mesh.faces().filter(|t| t.contains(&v)).count();
        let doubled = [0, 2, 6, 8].into_iter().filter(|&v| corner(v) == 2).count();
        assert!(doubled > 0);
        assert_eq!((pinned(Boundary::EdgeAndCorner), pinned(Boundary::EdgeOnly)), (doubled, 0));
    }

    #[test]
    fn faces_back_to_back_are_cut_along_different_diagonals() {
        let mesh = ControlMesh::new(&[[0, 1, 2, 3], [3, 2, 1, 0]], Tags::default()).unwrap();
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let cut = mesh.triangulated(&square).unwrap();
        let sides = |t: &[u32]| [0, 1, 2].map(|i| edge(t[i], t[(i + 1) % 3]));
        let count = |e| cut.mesh.faces().flat_map(sides).filter(|&side| side == e).count();
        assert_eq!((count((0, 2)), count((1, 3))), (2, 2));
    }
}
