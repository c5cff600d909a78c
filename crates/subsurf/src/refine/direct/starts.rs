//! Where squares start: quads that touch quads alone at their control points, all other faces at level 1, of which only what they
//! need is made.

use crate::index::Face;
use crate::topology::{FaceOf, Topology};

/// The level at which each face starts.
pub(super) struct Starts {
    /// By control vertex. Empty where all faces are quads.
    is_late: Vec<bool>,
    /// True where some quad starts at its control points.
    pub has_early: bool,
}

/// Elements of the control mesh whose vertices of level 1 are needed, in ascending order.
pub(super) struct Needed {
    pub faces: Vec<u32>,
    pub edges: Vec<u32>,
    pub vertices: Vec<u32>,
}

impl Starts {
    pub fn new(t: &Topology) -> Self {
        if matches!(t.face, FaceOf::Quads) {
            return Self { is_late: Vec::new(), has_early: true };
        }
        let mut is_late = vec![false; t.vertex_count()];
        for f in (0..t.face_count()).map(Face::new).filter(|&f| t.sides(f) != 4) {
            t.face_vertices(f).iter().for_each(|&v| is_late[v as usize] = true);
        }
        let mut out = Self { is_late, has_early: false };
        out.has_early = (0..t.face_count()).any(|f| !out.is_late_face(t, Face::new(f)));
        if !out.has_early {
            out.is_late.fill(true);
        }
        out
    }

    /// True for a control vertex that is a corner of a face that is no quad, or where no quad starts at its control points.
    #[inline(always)]
    pub fn is_late(&self, v: u32) -> bool {
        self.is_late.get(v as usize) == Some(&true)
    }

    fn is_late_face(&self, t: &Topology, f: Face) -> bool {
        t.face_vertices(f).iter().any(|&v| self.is_late(v))
    }

    /// What faces read that start at level 1: the vertices in and round them.
    pub fn needed(&self, t: &Topology) -> Needed {
        let mut is_corner = vec![false; t.vertex_count()];
        for f in (0..t.face_count()).map(Face::new).filter(|&f| self.is_late_face(t, f)) {
            t.face_vertices(f).iter().for_each(|&v| is_corner[v as usize] = true);
        }
        let touches = |vertices: &[u32]| vertices.iter().any(|&v| is_corner[v as usize]);
        Needed {
            faces: ascending(t.face_count(), |f| touches(t.face_vertices(Face::new(f)))),
            edges: ascending(t.edge_count(), |e| touches(&t.edge_vertices[e])),
            vertices: ascending(t.vertex_count(), |v| is_corner[v]),
        }
    }
}

/// The numbers below `count` of which something is true.
fn ascending(count: usize, is: impl Fn(usize) -> bool) -> Vec<u32> {
    (0..count).filter(|&i| is(i)).map(|i| i as u32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::ControlMesh;
    use crate::shapes;
    use crate::tags::Tags;

    /// Seven by seven quads, the middle one of which is two triangles.
    fn cut_grid() -> Topology {
        let grid = shapes::grid(7, 7).mesh;
        let cut = |(f, face): (usize, &[u32])| match *face {
            [a, b, c, d] if f == 24 => vec![vec![a, b, c], vec![c, d, a]],
            _ => vec![face.to_vec()],
        };
        let faces: Vec<Vec<u32>> = grid.faces().enumerate().flat_map(cut).collect();
        Topology::new(&ControlMesh::new(&faces, Tags::default()).unwrap()).unwrap()
    }

    #[test]
    fn what_touches_a_triangle_starts_late_and_needs_what_touches_it() {
        let t = cut_grid();
        let starts = Starts::new(&t);
        let late = (0..t.face_count()).filter(|&f| starts.is_late_face(&t, Face::new(f))).count();
        // Two triangles and the ring round them; round their sixteen vertices another ring. Of these vertices' edges twelve run
        // each way between them, one is the cut, and four leave on every side.
        assert_eq!((starts.has_early, late), (true, 10));
        let Needed { faces, edges, vertices } = starts.needed(&t);
        assert_eq!((faces.len(), vertices.len(), edges.len()), (26, 16, 2 * 12 + 1 + 4 * 4));
    }

    #[test]
    fn all_quads_start_early_and_no_triangles_do() {
        let of = |mesh: &ControlMesh| Starts::new(&Topology::new(mesh).unwrap());
        assert!(of(&shapes::cube().mesh).has_early && !of(&shapes::cube().mesh).is_late(3));
        for shape in shapes::all_triangles() {
            let starts = of(&shape.mesh);
            assert!(!starts.has_early && starts.is_late(0), "{}", shape.name);
        }
    }
}
