//! Classical refinement, level by level, in OpenSubdiv's default order. The independent reference for everything else,
//! and what users want who edit or exchange refined meshes.
//!
//! Order of a level's vertices: one for every parent vertex, then one for every parent face (not under Loop), then one
//! for every parent edge. Edges: those inside parent faces, then the halves of parent edges. Faces: parent by parent,
//! corner by corner, and under Loop the middle one last.

mod compile;
mod compose;
mod direct;
mod face_rings;
mod next_level;
mod numbering;
mod parts;
mod plain;
mod quad_split;
mod refined_point;
mod scatter;
mod split;
mod tile;
mod tile_trees;
mod tri_split;
mod uniform;
mod values;

pub(crate) use compose::{Composer, Placed, WeightRows, fill_regular};
pub(crate) use face_rings::{Ascending, FaceRings, PLAIN, ring_bounds};
pub(crate) use numbering::{Counts, Numbering, Owner, Region};
pub(crate) use refined_point::{Parent, refined_point};
pub(crate) use split::runs_forward;
pub(crate) use tile_trees::TileTrees;
pub use uniform::{RefinementSize, UniformRefinement};

pub(crate) use next_level::{NextHalfEdges, NextLevel};

use crate::index::{Edge, Face, Vertex};
use crate::mask::{Mask, edge_mask, vertex_mask};
use crate::mesh::{ControlMesh, MAX_COUNT, MeshError};
use crate::real::{Real, add_scaled, round};
use crate::scheme::{Scheme, SplitKind};
use crate::tags::Boundary;
use crate::topology::Topology;
use rayon::prelude::*;

/// One level of refinement: a topology whose sharpness has decayed `depth` times.
#[derive(Clone, Debug)]
pub struct Level {
    topology: Topology,
    scheme: Scheme,
    depth: u32,
}

impl Level {
    /// Level 0: the control mesh itself.
    ///
    /// # Errors
    /// Those of [`Topology::new`].
    pub fn new(mesh: &ControlMesh, scheme: Scheme) -> Result<Self, MeshError> {
        Ok(Self::from_topology(scheme_topology(mesh, scheme)?, scheme))
    }

    /// Level 0 from a topology that is at hand; under Loop all its faces must be triangles.
    pub fn from_topology(topology: Topology, scheme: Scheme) -> Self {
        Self { topology, scheme, depth: 0 }
    }

    /// The tables of this level.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The tables by themselves.
    pub fn into_topology(self) -> Topology {
        self.topology
    }

    /// The scheme that refines it.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// How many refinements lie behind.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// The next level's topology.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`] where it would overflow 32-bit indices.
    pub fn refine(&self) -> Result<Self, MeshError> {
        self.check_child()?;
        Ok(Self { topology: refined(&self.topology, self.scheme), scheme: self.scheme, depth: self.depth + 1 })
    }

    /// Refuses to go on where the next level would overflow 32-bit indices.
    pub(crate) fn check_child(&self) -> Result<(), MeshError> {
        let t = &self.topology;
        let (face_points, inside) = match self.scheme.split() {
            SplitKind::Quads => (t.face_count(), t.half_edge_count()),
            SplitKind::Triangles => (0, t.half_edge_count()),
        };
        let counts = [
            ("vertices", t.vertex_count() + face_points + t.edge_count()),
            ("corners", 4 * t.half_edge_count()),
            ("edges", 2 * t.edge_count() + inside),
        ];
        for (what, count) in counts {
            if count > MAX_COUNT {
                return Err(MeshError::TooLarge { what, count, limit: MAX_COUNT });
            }
        }
        Ok(())
    }

    /// The next level's values from this level's, one row per vertex. Sums are formed in `f64`.
    ///
    /// # Panics
    /// If `values` has not one row per vertex of this level.
    pub fn refine_values<T: Real, const N: usize>(&self, values: &[[T; N]]) -> Vec<[T; N]> {
        let t = &self.topology;
        assert_eq!(values.len(), t.vertex_count(), "one value per vertex of the level");
        let faces = if self.scheme.split() == SplitKind::Quads { t.face_count() } else { 0 };
        let centroids: Vec<[f64; N]> =
            (0..faces).into_par_iter().map(|f| centroid(t.face_vertices(Face(f as u32)), values)).collect();
        let apply = |mask: &Mask| {
            let mut sum = [0.0; N];
            mask.vertices.iter().for_each(|&(v, w)| add_scaled(&mut sum, w, &values[v as usize]));
            mask.faces.iter().for_each(|&(f, w)| add_scaled(&mut sum, w, &centroids[f as usize]));
            round(sum)
        };
        let mut refined = Vec::with_capacity(t.vertex_count() + faces + t.edge_count());
        refined.par_extend((0..t.vertex_count() as u32).into_par_iter().map_init(Mask::default, |mask, v| {
            vertex_mask(t, self.scheme, Vertex(v), mask);
            apply(mask)
        }));
        refined.par_extend(centroids.par_iter().map(|&c| round::<T, N>(c)));
        refined.par_extend((0..t.edge_count() as u32).into_par_iter().map_init(Mask::default, |mask, e| {
            edge_mask(t, self.scheme, Edge(e), mask);
            apply(mask)
        }));
        refined
    }
}

/// The topology one level down, whose counts fit.
pub(crate) fn refined(t: &Topology, scheme: Scheme) -> Topology {
    match scheme.split() {
        SplitKind::Quads => quad_split::child(t),
        SplitKind::Triangles => tri_split::child(t),
    }
}

impl Level {
    /// The next level's values from this level's, one per face: every child has its parent's.
    ///
    /// # Panics
    /// If `values` has not one entry per face of this level.
    pub fn refine_face_values<V: Clone>(&self, values: &[V]) -> Vec<V> {
        let t = &self.topology;
        assert_eq!(values.len(), t.face_count(), "one value per face of the level");
        match self.scheme.split() {
            SplitKind::Quads => {
                (0..t.half_edge_count() as u32).map(|h| values[t.face.get(h) as usize].clone()).collect()
            }
            SplitKind::Triangles => values.iter().flat_map(|v| std::iter::repeat_n(v.clone(), 4)).collect(),
        }
    }
}

fn centroid<T: Real, const N: usize>(corners: &[u32], values: &[[T; N]]) -> [f64; N] {
    let mut sum = [0.0; N];
    corners.iter().for_each(|&v| add_scaled(&mut sum, 1.0, &values[v as usize]));
    sum.map(|x| x / corners.len() as f64)
}

/// The mesh's topology as `scheme` sees it: Loop takes triangles only, and the boundary rule "none" makes holes only where
/// a face's neighbours shape it.
pub(crate) fn scheme_topology(mesh: &ControlMesh, scheme: Scheme) -> Result<Topology, MeshError> {
    if scheme.split() == SplitKind::Triangles
        && let Some(face) = mesh.faces().position(|f| f.len() != 3)
    {
        return Err(MeshError::NotATriangle { face, sides: mesh.face_vertices(face).len() });
    }
    if scheme == Scheme::Bilinear && mesh.tags().rules.boundary == Boundary::None {
        let mut rules = mesh.tags().rules;
        rules.boundary = Boundary::EdgeOnly;
        return Topology::new(&mesh.clone().with_rules(rules));
    }
    Topology::new(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    #[test]
    fn every_level_of_every_shape_keeps_the_invariants() {
        for shape in shapes::all().into_iter().chain(shapes::all_triangles()).chain([shapes::pillow()]) {
            for scheme in [Scheme::CatmullClark, Scheme::Loop, Scheme::Bilinear] {
                if scheme == Scheme::Loop && shape.mesh.faces().any(|f| f.len() != 3) {
                    continue;
                }
                let mut level = Level::new(&shape.mesh, scheme).unwrap();
                level.topology().check().unwrap_or_else(|e| panic!("{}: {e}", shape.name));
                for _ in 0..3 {
                    level = level.refine().unwrap();
                    level.topology().check().unwrap_or_else(|e| panic!("{} level {}: {e}", shape.name, level.depth()));
                }
            }
        }
    }

    #[test]
    fn values_of_faces_go_to_their_children() {
        for (shape, scheme) in [(shapes::cone(5), Scheme::CatmullClark), (shapes::pillow(), Scheme::Loop)] {
            let mut level = Level::new(&shape.mesh, scheme).unwrap();
            let mut names: Vec<usize> = (0..shape.mesh.face_count()).collect();
            for _ in 0..2 {
                let (t, next) = (level.topology(), level.refine().unwrap());
                let fine = level.refine_face_values(&names);
                assert_eq!(fine.len(), next.topology().face_count());
                // A child's old vertex is one of its parent's.
                for (f, name) in fine.iter().enumerate() {
                    let old = next
                        .topology()
                        .face_vertices(Face(f as u32))
                        .iter()
                        .find(|&&v| (v as usize) < t.vertex_count());
                    let parents = (0..t.face_count()).filter(|&p| names[p] == *name);
                    let mut of_parents = parents.flat_map(|p| t.face_vertices(Face(p as u32)));
                    assert!(old.is_none_or(|v| of_parents.any(|w| w == v)), "{}", shape.name);
                }
                (level, names) = (next, fine);
            }
        }
    }

    #[test]
    fn the_cube_refines_to_its_published_points() {
        // One Catmull-Clark step of the cube [-1,1]³: vertices shrink to 5/9, edge points to 3/4, face points stay.
        let cube = shapes::cube();
        let level = Level::new(&cube.mesh, Scheme::CatmullClark).unwrap();
        let values = level.refine_values(&cube.positions);
        assert_eq!(values.len(), 8 + 6 + 12);
        for (v, p) in cube.positions.iter().enumerate() {
            p.iter().zip(values[v]).for_each(|(a, b)| assert!((a * 5.0 / 9.0 - b).abs() < 1e-15));
        }
        for p in &values[8..14] {
            assert!(p.iter().all(|x| x.abs() <= 1.0) && p.iter().any(|x| x.abs() == 1.0), "{p:?}");
        }
        for p in &values[14..] {
            assert_eq!(p.iter().filter(|x| x.abs() == 0.75).count(), 2);
        }
    }
}
