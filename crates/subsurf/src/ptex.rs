//! Ptex faces: the squares (triangles under Loop) that a face-by-face texture is stored in (Burley, Lacewell 2008, "Ptex:
//! per-face texture mapping for production rendering"), with their numbers and their neighbours.
//!
//! Faces are gone through in order: a quad is one Ptex face, another face one per corner; under Loop a triangle is one.
//! These are the patches of a [`PatchTable`](crate::PatchTable), and have its numbers. Parameters are those of
//! [`Location`]. Edge i of a Ptex face runs from its corner i to the next: in a square along v = 0, u = 1, v = 1, u = 0.
//!
//! ```text
//!            2                       1
//!   (0,1) ◀──────── (1,1)       centre ◀── edge point     sub-face of an n-gon: edges 0 and 3 are
//!     │               ▲      2  │          ▲              halves of the face's own, edges 1 and 2
//!   3 │               │ 1       │  sub-face│ 1            lie inside it
//!     ▼               │         ▼          │
//!   (0,0) ────────▶ (1,0)       ●───────▶ edge point
//!            0                corner   0
//! ```

use crate::index::{Face, HalfEdge};
use crate::limit::Location;
use crate::scheme::Scheme;
use crate::topology::Topology;

/// The Ptex faces of a mesh.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct PtexFaces {
    /// First Ptex face of every face, and their number at the end.
    first: Vec<u32>,
    /// Corners of a face that is one Ptex face.
    whole: usize,
}

/// One edge of one Ptex face.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct PtexEdge {
    /// The Ptex face.
    pub ptex_face: u32,
    /// Which of its edges.
    pub edge: u8,
}

impl PtexFaces {
    /// Numbers the Ptex faces of a control mesh.
    pub fn new(topology: &Topology, scheme: Scheme) -> Self {
        let whole = scheme.patch_sides();
        let mut first = Vec::with_capacity(topology.face_count() + 1);
        first.push(0u32);
        for f in 0..topology.face_count() {
            let sides = topology.sides(Face::new(f));
            // At most one per corner, and corners fit into 32 bits.
            first.push(first[f] + if sides == whole { 1 } else { sides as u32 });
        }
        Self { first, whole }
    }

    /// How many there are, those of holes included.
    pub fn count(&self) -> usize {
        self.first[self.first.len() - 1] as usize
    }

    /// How many Ptex faces a face has: 1, or one per corner.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn subfaces(&self, face: Face) -> u32 {
        self.first[face.index() + 1] - self.first[face.index()]
    }

    /// The number of a face's sub-face.
    ///
    /// # Panics
    /// If there is no such face or sub-face.
    pub fn id(&self, face: Face, subface: u32) -> u32 {
        assert!(subface < self.subfaces(face), "face {face} has no sub-face {subface}");
        self.first[face.index()] + subface
    }

    /// The face and sub-face behind a number.
    ///
    /// # Panics
    /// If there is no such Ptex face.
    pub fn face(&self, id: u32) -> (Face, u32) {
        assert!((id as usize) < self.count(), "there is no Ptex face {id}: there are {}", self.count());
        let face = self.first.partition_point(|&first| first <= id) - 1;
        (Face::new(face), id - self.first[face])
    }

    /// A location as Ptex face, u and v.
    ///
    /// # Panics
    /// As [`id`](Self::id).
    pub fn of_location(&self, at: Location) -> (u32, f64, f64) {
        (self.id(at.face, at.subface), at.u, at.v)
    }

    /// The location of a place on a Ptex face.
    ///
    /// # Panics
    /// As [`face`](Self::face).
    pub fn location(&self, id: u32, u: f64, v: f64) -> Location {
        let (face, subface) = self.face(id);
        Location { face, subface, u, v }
    }

    /// What lies across the edges of a Ptex face: none at boundaries and non-manifold edges, and none across the fourth
    /// edge of a triangle.
    ///
    /// Where a quad meets an n-gon, two sub-faces lie across its edge; the one at the start of the edge is given, as
    /// OpenSubdiv does. It leads back to the quad, and so does the other.
    ///
    /// `topology` is the one that the numbers were made for.
    ///
    /// # Panics
    /// As [`face`](Self::face).
    pub fn neighbours(&self, topology: &Topology, id: u32) -> [Option<PtexEdge>; 4] {
        let (face, subface) = self.face(id);
        let sides = topology.sides(face);
        if sides == self.whole {
            return std::array::from_fn(|i| {
                (i < sides).then(|| self.at_start(topology, topology.half_edge(face, i))).flatten()
            });
        }
        let j = subface as usize;
        let (next, prev) = ((j + 1) % sides, (j + sides - 1) % sides);
        let inside = |j: usize, edge| Some(PtexEdge { ptex_face: self.id(face, j as u32), edge });
        [
            self.at_start(topology, topology.half_edge(face, j)),
            inside(next, 2),
            inside(prev, 1),
            self.at_end(topology, topology.half_edge(face, prev)),
        ]
    }

    /// What lies across `h` near its start.
    fn at_start(&self, t: &Topology, h: HalfEdge) -> Option<PtexEdge> {
        let twin = t.twin(h)?;
        if t.sides(t.face(twin)) == self.whole {
            return Some(self.edge_of_whole(t, twin));
        }
        // The twin ends where `h` starts: at the sub-face of its next corner.
        Some(PtexEdge { ptex_face: self.id(t.face(twin), corner(t, t.next(twin))), edge: 3 })
    }

    /// What lies across `h` near its end.
    fn at_end(&self, t: &Topology, h: HalfEdge) -> Option<PtexEdge> {
        let twin = t.twin(h)?;
        if t.sides(t.face(twin)) == self.whole {
            return Some(self.edge_of_whole(t, twin));
        }
        Some(PtexEdge { ptex_face: self.id(t.face(twin), corner(t, twin)), edge: 0 })
    }

    fn edge_of_whole(&self, t: &Topology, h: HalfEdge) -> PtexEdge {
        PtexEdge { ptex_face: self.id(t.face(h), 0), edge: corner(t, h) as u8 }
    }
}

fn corner(t: &Topology, h: HalfEdge) -> u32 {
    h.0 - t.first(t.face(h))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limit::PatchTable;
    use crate::shapes::{self, Shape};

    fn everything() -> impl Iterator<Item = (Shape, Topology, Scheme)> {
        let quads = shapes::all().into_iter().map(|s| (s, Scheme::CatmullClark));
        let triangles = shapes::all_triangles().into_iter().map(|s| (s, Scheme::Loop));
        quads.chain(triangles).map(|(shape, scheme)| {
            let topology = Topology::new(&shape.mesh).unwrap();
            (shape, topology, scheme)
        })
    }

    #[test]
    fn numbers_are_those_of_the_patch_table_and_lead_back() {
        for (shape, topology, scheme) in everything() {
            let ptex = PtexFaces::new(&topology, scheme);
            let table = PatchTable::new(&shape.mesh, scheme).unwrap();
            assert_eq!(ptex.count(), table.patch_count(), "{}", shape.name);
            for id in 0..ptex.count() as u32 {
                let at = ptex.location(id, 0.25, 0.5);
                assert_eq!(table.patch(at.face, at.subface), id as usize, "{}", shape.name);
                assert_eq!(ptex.of_location(at), (id, 0.25, 0.5));
            }
        }
    }

    #[test]
    fn neighbours_are_symmetric_but_for_which_sub_face_a_quad_names() {
        for (shape, topology, scheme) in everything() {
            let ptex = PtexFaces::new(&topology, scheme);
            let is_whole = |id: u32| topology.sides(ptex.face(id).0) == scheme.patch_sides();
            for id in 0..ptex.count() as u32 {
                for (edge, across) in ptex.neighbours(&topology, id).into_iter().enumerate() {
                    let Some(across) = across else { continue };
                    let back = ptex.neighbours(&topology, across.ptex_face)[across.edge as usize];
                    let back = back.unwrap_or_else(|| panic!("{}: {id} {edge} {across:?}", shape.name));
                    if is_whole(across.ptex_face) && !is_whole(id) {
                        assert_eq!(ptex.face(back.ptex_face).0, ptex.face(id).0, "{}", shape.name);
                    } else {
                        assert_eq!(back, PtexEdge { ptex_face: id, edge: edge as u8 }, "{}", shape.name);
                    }
                }
            }
        }
    }

    #[test]
    fn neighbours_share_the_corners_of_their_edge() {
        // Corner by corner on the limit surface, which is continuous: the edge's start here is its end there, and its
        // end the start; where one side is a quad and the other half of its edge, one of the two.
        for (shape, _, scheme) in everything() {
            let table = PatchTable::new(&shape.mesh, scheme).unwrap();
            let t = table.topology();
            let ptex = PtexFaces::new(t, scheme);
            let surface = table.surface(&shape.positions);
            let sides = scheme.patch_sides();
            let point = |e: PtexEdge, end: usize| {
                let corners =
                    if sides == 4 { [(0, 0), (1, 0), (1, 1), (0, 1)] } else { [(0, 0), (1, 0), (0, 1), (0, 0)] };
                let (u, v) = corners[(e.edge as usize + end) % sides];
                surface.position(ptex.location(e.ptex_face, f64::from(u), f64::from(v)))
            };
            // Points of the unit-sized shapes agree up to the rounding of sums of some dozen terms.
            let near = |a: Option<[f64; 3]>, b: Option<[f64; 3]>| match (a, b) {
                (Some(a), Some(b)) => (0..3).all(|i| (a[i] - b[i]).abs() < 1e-12),
                _ => true, // a hole has no surface
            };
            for id in 0..ptex.count() as u32 {
                for (edge, across) in ptex.neighbours(t, id).into_iter().enumerate() {
                    let (Some(across), own) = (across, PtexEdge { ptex_face: id, edge: edge as u8 }) else { continue };
                    let whole = |e: PtexEdge| t.sides(ptex.face(e.ptex_face).0) == sides;
                    let ends = [near(point(own, 0), point(across, 1)), near(point(own, 1), point(across, 0))];
                    let fits = if whole(own) == whole(across) { ends[0] && ends[1] } else { ends[0] || ends[1] };
                    assert!(fits, "{}: {own:?} {across:?}", shape.name);
                }
            }
        }
    }

    #[test]
    fn an_edge_without_a_neighbour_is_a_boundary_or_not_manifold() {
        for (shape, topology, scheme) in everything() {
            let ptex = PtexFaces::new(&topology, scheme);
            for id in 0..ptex.count() as u32 {
                let (face, subface) = ptex.face(id);
                let sides = topology.sides(face);
                let own: Vec<Option<HalfEdge>> = if sides == scheme.patch_sides() {
                    (0..sides).map(|i| Some(topology.half_edge(face, i))).collect()
                } else {
                    let at = topology.half_edge(face, subface as usize);
                    vec![Some(at), None, None, Some(topology.prev(at))]
                };
                for (edge, h) in own.into_iter().enumerate() {
                    let single = h.is_some_and(|h| {
                        let e = topology.edge(h);
                        topology.is_boundary(e) || topology.is_non_manifold_edge(e)
                    });
                    assert_eq!(ptex.neighbours(&topology, id)[edge].is_none(), single, "{}", shape.name);
                }
            }
        }
    }
}
