//! The local subdivision step at a special vertex: the matrix `A` from the control points of one face there to those of
//! its child at the vertex, and the control points `X_c` of the three regular children, as combinations of the same
//! points. Both are read off the refinement masks, run once on a mesh that has nothing but the vertex's neighbourhood.

use super::corner::{Corner, Kind, grid_points, special_points};
use super::rows::{Combination, Rows};
use crate::index::{Edge, Face, Vertex};
use crate::mask::{Mask, edge_mask, vertex_mask};
use crate::mesh::ControlMesh;
use crate::refine::Level;
use crate::scheme::Scheme;
use crate::tags::{Boundary, Corner as CornerTag, Crease, INFINITE_SHARPNESS, Rules, Tags};
use crate::topology::Topology;

/// `A` and `X_1 X_2 X_3` over the points of [`special_points`].
#[derive(Clone, Debug)]
pub(crate) struct LocalStep {
    /// Number of points `K`.
    pub points: usize,
    /// How many of them belong to the ring of the vertex.
    pub ring: usize,
    /// `K × K`.
    pub a: Rows,
    /// `16 × K` each; child `c` is the quadrant at the face's corner `c`.
    pub x: [Rows; 3],
}

impl LocalStep {
    pub fn new(special: Corner) -> Self {
        let (mesh, ring) = neighbourhood(special);
        let parent = Level::new(&mesh, Scheme::CatmullClark).expect("the neighbourhood is a mesh");
        let t = parent.topology();
        let own = t.half_edge(Face(special.i), 0);
        let order = special_points(t, own);
        let points = order.len();
        // Canonical position of every vertex of the mesh.
        let mut position = vec![u32::MAX; t.vertex_count()];
        for (k, point) in order.iter().enumerate() {
            let [(v, _)] = point[..] else { unreachable!("the neighbourhood has no extrapolated points") };
            position[v as usize] = k as u32;
        }
        let child = parent.refine().expect("the neighbourhood is small");
        let step = |points: &[Combination]| -> Vec<Combination> {
            points.iter().map(|p| ParentPoints { t, position: &position }.of(p)).collect()
        };
        let kids = [0, 1, 2, 3].map(|c| t.half_edge(Face(special.i), c));
        // Child c is face kids[c] of the next level; its corner c is the old vertex.
        let first = |c: usize| child.topology().half_edge(Face(kids[c].0), 0);
        let a = Rows::new(points, &step(&special_points(child.topology(), first(0))));
        let x = [1, 2, 3].map(|c| {
            let grid = grid_points(child.topology(), first(c), false).map(|p| p.expect("a full grid"));
            Rows::new(points, &step(&grid))
        });
        Self { points, ring, a, x }
    }
}

/// Child points as combinations of the canonical parent points.
struct ParentPoints<'a> {
    t: &'a Topology,
    position: &'a [u32],
}

impl ParentPoints<'_> {
    fn of(&self, point: &Combination) -> Combination {
        let mut sum = Vec::new();
        for &(v, w) in point {
            child_vertex(self.t, Scheme::CatmullClark, v, &mut |parent, x| {
                let p = self.position[parent as usize];
                assert!(p != u32::MAX, "vertex {parent} lies outside the neighbourhood");
                sum.push((p, w * x));
            });
        }
        sum
    }
}

/// Terms of child vertex `v` over the vertices of its parent level.
pub(crate) fn child_vertex(t: &Topology, scheme: Scheme, v: u32, term: &mut dyn FnMut(u32, f64)) {
    let (vertices, faces) = (t.vertex_count() as u32, t.face_count() as u32);
    let mut mask = Mask::default();
    if v < vertices {
        vertex_mask(t, scheme, Vertex(v), &mut mask);
    } else if v < vertices + faces {
        mask.face(Face(v - vertices), 1.0);
    } else {
        edge_mask(t, scheme, Edge(v - vertices - faces), &mut mask);
    }
    mask.vertices.iter().for_each(|&(p, w)| term(p, w));
    for &(f, w) in &mask.faces {
        let corners = t.face_vertices(Face(f));
        corners.iter().for_each(|&p| term(p, w / corners.len() as f64));
    }
}

/// The mesh of one special vertex: its faces, and the outer layer round face `i`. Vertices come in canonical order,
/// then those that only close the mesh. Returns the number of ring points too.
fn neighbourhood(Corner { kind, n, i }: Corner) -> (ControlMesh, usize) {
    let closed = kind.is_closed();
    let spokes = if closed { n } else { n + 1 };
    let spoke = |j: u32| 1 + 2 * (j % spokes);
    let diagonal = |j: u32| 2 + 2 * (j % n);
    let ring = 1 + spokes + n;
    let mut next = ring;
    let mut new = || {
        next += 1;
        next - 1
    };
    let mut faces: Vec<[u32; 4]> = (0..n).map(|j| [0, spoke(j), diagonal(j), spoke(j + 1)]).collect();
    let [sharp_u, sharp_v] = [i == 0, i + 1 == n].map(|end| end && !matches!(kind, Kind::Smooth | Kind::Pinned));
    let (a, f, b) = (spoke(i), diagonal(i), spoke(i + 1));
    let below = (!sharp_u).then(&mut new);
    let [p20, p21, p22, p12, p02] = std::array::from_fn(|_| new());
    let above = (!sharp_v).then(&mut new);
    faces.extend([[a, p20, p21, f], [f, p21, p22, p12], [f, p12, p02, b]]);
    if let Some(p) = below {
        faces.push([a, diagonal(i + n - 1), p, p20]);
    }
    if let Some(p) = above {
        faces.push([b, p02, p, diagonal(i + 1)]);
    }
    let mut tags = Tags { rules: Rules { boundary: Boundary::EdgeOnly, ..Rules::default() }, ..Tags::default() };
    match kind {
        Kind::Corner | Kind::Pinned => tags.corners.push(CornerTag::new(0, INFINITE_SHARPNESS)),
        Kind::Dart => {
            // The crease goes on beyond e_0 where the face touches it, with one more face behind it.
            tags.creases.push(Crease::new(0, spoke(0), INFINITE_SHARPNESS));
            if sharp_u {
                tags.creases.push(Crease::new(a, p20, INFINITE_SHARPNESS));
                faces.push([a, diagonal(n - 1), new(), p20]);
            }
            if sharp_v {
                tags.creases.push(Crease::new(b, p02, INFINITE_SHARPNESS));
                faces.push([b, p02, new(), diagonal(0)]);
            }
        }
        Kind::Smooth | Kind::Crease => {}
    }
    let counts = vec![4; faces.len()];
    let mesh = ControlMesh::from_counts(next as usize, &counts, faces.concat(), tags).expect("a valid mesh");
    (mesh, ring as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_keeps_constants_and_the_ring_to_itself() {
        for kind in [Kind::Smooth, Kind::Dart, Kind::Crease, Kind::Corner, Kind::Pinned] {
            let least = match kind {
                Kind::Smooth | Kind::Dart | Kind::Pinned => 2,
                Kind::Crease | Kind::Corner => 1,
            };
            for n in least..12 {
                for i in 0..if matches!(kind, Kind::Smooth | Kind::Pinned) { 1 } else { n } {
                    let step = LocalStep::new(Corner { kind, n, i });
                    let rounding = step.points as f64 * f64::EPSILON;
                    for k in 0..step.points {
                        assert!((step.a.row(k).map(|t| t.1).sum::<f64>() - 1.0).abs() < rounding, "{kind:?} {n} {i}");
                        assert!(k >= step.ring || step.a.row(k).all(|t| (t.0 as usize) < step.ring));
                    }
                    for x in &step.x {
                        (0..16).for_each(|k| assert!((x.row(k).map(|t| t.1).sum::<f64>() - 1.0).abs() < rounding));
                    }
                }
            }
        }
    }
}
