//! Uniform refinement in one call: the vertices, faces and values of a level straight from the control mesh, without the topology of
//! the levels between.

use super::direct::Direct;
use super::face_rings::FaceRings;
use super::numbering::{Counts, Numbering};
use super::tile_trees::TileTrees;
use super::values::Maps;
use super::{Level, scheme_topology};
use crate::compiled::{as_rows, as_rows_mut};
use crate::index::{Face, HalfEdge};
use crate::mesh::{ControlMesh, MeshError};
use crate::real::Real;
use crate::scheme::{Scheme, SplitKind};
use crate::topology::Topology;
use rayon::prelude::*;
use std::any::{Any, TypeId};
use std::sync::OnceLock;

/// A level of refinement without those between: how its vertices are made of the control points, and its faces, in the order of
/// [`Level`]. Made once per connectivity; takes values of any attribute.
///
/// Values are those of [`Level::refine_values`] repeated, up to rounding: sums are formed in the precision of the values, which
/// adds a few units in the last place per level. Constants come out exactly.
///
/// ```
/// use subsurf::{Scheme, UniformRefinement, shapes};
///
/// let cube = shapes::cube();
/// let refinement = UniformRefinement::new(&cube.mesh, Scheme::CatmullClark, 3)?; // once per connectivity
/// let corners = refinement.corners(); // four to a face
/// let points = refinement.refine(&cube.positions); // once per frame, of any attribute
/// assert_eq!((corners.len(), points.len()), (4 * 384, 386));
/// # Ok::<(), subsurf::MeshError>(())
/// ```
pub struct UniformRefinement {
    control: Topology,
    scheme: Scheme,
    depth: u32,
    counts: Counts,
    numbering: Numbering,
    method: Method,
}

/// How values are refined.
enum Method {
    /// Sixteen faces at a time down to the last level, without the levels' topology: whatever [`Direct`] takes.
    Direct(Box<Direct>),
    Trees(Box<Plan>),
    /// Level by level: these are levels 0 to depth - 1.
    Levels(Vec<Level>),
}

/// What is made once per connectivity.
struct Plan {
    rings: FaceRings,
    trees: TileTrees,
    single: OnceLock<Maps<f32>>,
    double: OnceLock<Maps<f64>>,
}

/// To make the tree of a group takes as long as to refine so many vertices level by level. Larger: more meshes with many kinds
/// of faces are refined level by level, slower from the second time on and with more memory; smaller: refining once takes longer
/// on such meshes.
const VERTICES_PER_GROUP: usize = 64;

impl Plan {
    /// None where trees do not pay.
    fn new(control: &Topology, scheme: Scheme, depth: u32, counts: Counts) -> Result<Option<Self>, MeshError> {
        if depth == 0 {
            return Ok(None);
        }
        let sharpened = TileTrees::sharpened(control, depth);
        let t = sharpened.as_ref().unwrap_or(control);
        let Some(rings) = FaceRings::new(t, scheme, false)? else { return Ok(None) };
        if VERTICES_PER_GROUP * rings.representatives.len() > counts.vertices {
            return Ok(None);
        }
        let trees = TileTrees::compile(t, scheme, &rings.representatives, depth);
        Ok(Some(Self { rings, trees, single: OnceLock::new(), double: OnceLock::new() }))
    }

    fn maps<T: Real>(&self, split: SplitKind) -> &Maps<T> {
        let single = || self.single.get_or_init(|| Maps::new(&self.trees, split)) as &dyn Any;
        let double = || self.double.get_or_init(|| Maps::new(&self.trees, split)) as &dyn Any;
        let maps = if TypeId::of::<T>() == TypeId::of::<f32>() { single() } else { double() };
        maps.downcast_ref().expect("values are f32 or f64")
    }
}

/// Bytes a half-edge that tables take while they are made, about. They are asked for in huge pages: larger, memory is prepared that is
/// not used; smaller, more of the tables come in small pages.
const BUILD_BYTES: usize = 40;

impl UniformRefinement {
    /// The level `depth` steps below the control mesh; 0 is the mesh itself.
    ///
    /// # Errors
    /// Those of [`Topology::new`], and [`MeshError::TooLarge`] where the level would overflow 32-bit indices.
    pub fn new(mesh: &ControlMesh, scheme: Scheme, depth: u32) -> Result<Self, MeshError> {
        let half_edges = mesh.corners().len();
        let faces = 4usize.saturating_pow(depth.saturating_sub(1)).saturating_mul(half_edges);
        // One set of points in single precision, hardly more of them than faces, and the faces.
        subsurf_memory::reserve(faces.saturating_mul(size_of::<[f32; 3]>() + size_of::<[u32; 4]>()));
        // One entry into the thread pool for all that follows, and one thread's memory for the tables.
        rayon::scope(|_| {
            subsurf_memory::reserve(half_edges.saturating_mul(BUILD_BYTES));
            Self::from_topology(scheme_topology(mesh, scheme)?, scheme, depth)
        })
    }

    /// The same from a topology that is at hand: of a mesh, a [`Level`] or a [`Channel`](crate::Channel). Under Loop all its
    /// faces must be triangles.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`] where the level would overflow 32-bit indices.
    pub fn from_topology(mut control: Topology, scheme: Scheme, depth: u32) -> Result<Self, MeshError> {
        // Patch tables use them, refinement does not.
        control.fan_sizes = Vec::new();
        let split = scheme.split();
        let mut counts = Counts::of(&control);
        for _ in 0..depth {
            counts = counts.refined(split)?;
        }
        let numbering = Numbering::new(&control, split, depth);
        // One entry into the thread pool for all that follows.
        let direct = |control: &mut Topology| rayon::scope(|_| Direct::new(control, scheme, depth));
        let is_wasteful = Direct::is_wasteful(&control, depth);
        let mut chosen = if is_wasteful { None } else { direct(&mut control)?.map(|d| Method::Direct(Box::new(d))) };
        if chosen.is_none() {
            chosen = Plan::new(&control, scheme, depth, counts)?.map(|plan| Method::Trees(Box::new(plan)));
        }
        if chosen.is_none() && is_wasteful {
            chosen = direct(&mut control)?.map(|d| Method::Direct(Box::new(d)));
        }
        let method = match chosen {
            Some(method) => method,
            None => {
                let mut levels = Vec::with_capacity(depth as usize);
                for _ in 0..depth {
                    let first = || Ok(Level::from_topology(control.clone(), scheme));
                    let next = levels.last().map_or_else(first, Level::refine);
                    levels.push(next?);
                }
                Method::Levels(levels)
            }
        };
        Ok(Self { control, scheme, depth, counts, numbering, method })
    }

    /// The control mesh's half-edge tables.
    pub fn control(&self) -> &Topology {
        &self.control
    }

    /// The scheme that refines it.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// How many steps of refinement this is.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Number of vertices of the level.
    pub fn vertex_count(&self) -> usize {
        self.counts.vertices
    }

    /// Number of faces of the level.
    pub fn face_count(&self) -> usize {
        self.counts.faces
    }

    /// Number of edges of the level.
    pub fn edge_count(&self) -> usize {
        self.counts.edges
    }

    /// Corners of every face of the level, 4, or 3 under Loop; none at depth 0, where faces are those of the control mesh.
    pub fn sides(&self) -> Option<usize> {
        (self.depth > 0).then(|| self.scheme.patch_sides())
    }

    /// Start of every face in [`corners`](Self::corners), and the end of the last one.
    pub fn face_offsets(&self) -> Vec<u32> {
        match self.sides() {
            None => self.control.face_offsets().to_vec(),
            Some(sides) => {
                let mut out = subsurf_memory::with_capacity(self.counts.faces + 1);
                let faces = (0..self.counts.faces as u32 + 1).into_par_iter();
                faces.map(|f| f * sides as u32).collect_into_vec(&mut out);
                out
            }
        }
    }

    /// The control face that a face of the level lies in.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn control_face(&self, face: Face) -> Face {
        assert!(face.index() < self.counts.faces, "face {face} of {}", self.counts.faces);
        match (self.scheme.split(), self.depth) {
            (_, 0) => face,
            (SplitKind::Quads, depth) => self.control.face(HalfEdge(face.0 >> (2 * (depth - 1)))),
            (SplitKind::Triangles, depth) => Face(face.0 >> (2 * depth)),
        }
    }

    /// The vertices of all faces of the level, face after face, counter-clockwise.
    pub fn corners(&self) -> Vec<u32> {
        let mut out = subsurf_memory::zeroed(self.counts.half_edges);
        self.corners_into(&mut out);
        out
    }

    /// [`corners`](Self::corners) into memory that is at hand.
    ///
    /// # Panics
    /// If `out` has not one entry per corner.
    pub fn corners_into(&self, out: &mut [u32]) {
        assert_eq!(out.len(), self.counts.half_edges, "one entry per corner of the level");
        if self.depth == 0 {
            return out.copy_from_slice(self.control.corners());
        }
        self.numbering.write_corners(&self.control, out);
    }

    /// The level's values from those of the control mesh, one row per vertex, in parallel. Sums are formed in `T`. The second
    /// time, tables of some 60 bytes a control face may be made that take a quarter off the time of all that follow.
    ///
    /// # Panics
    /// If `values` has not one row per vertex of the control mesh.
    pub fn refine<T: Real, const N: usize>(&self, values: &[[T; N]]) -> Vec<[T; N]> {
        let mut out = zeroed(self.counts.vertices);
        self.refine_into(values, &mut out);
        out
    }

    /// [`refine`](Self::refine) into memory that is at hand.
    ///
    /// # Panics
    /// If `values` has not one row per vertex of the control mesh, or `out` not one per vertex of the level.
    pub fn refine_into<T: Real, const N: usize>(&self, values: &[[T; N]], out: &mut [[T; N]]) {
        assert_eq!(values.len(), self.control.vertex_count(), "one value per vertex of the control mesh");
        assert_eq!(out.len(), self.counts.vertices, "one value per vertex of the level");
        if const { N == 3 } {
            return T::compiled_refine(self, as_rows(values), as_rows_mut(out));
        }
        if const { N == 2 } {
            return T::compiled_refine_pairs(self, as_rows(values), as_rows_mut(out));
        }
        self.fill(values, out);
    }

    /// The level's values, in as much memory as they take.
    pub(crate) fn fill<T: Real, const N: usize>(&self, values: &[[T; N]], out: &mut [[T; N]]) {
        match &self.method {
            Method::Levels(levels) => {
                out.copy_from_slice(&refine_by_levels(levels, values, self.control.vertex_count()));
            }
            Method::Direct(direct) => direct.refine(&self.control, values, out),
            Method::Trees(plan) => {
                let maps = plan.maps::<T>(self.scheme.split());
                let (control, numbering) = (&self.control, &self.numbering);
                super::scatter::refine(
                    &Sources { control, rings: &plan.rings, trees: &plan.trees, maps, numbering },
                    values,
                    out,
                );
            }
        }
    }

    /// How much work there is, and memory.
    pub fn size(&self) -> RefinementSize {
        let bytes = self.numbering.bytes();
        match &self.method {
            Method::Levels(_) => RefinementSize { bytes, ..RefinementSize::default() },
            Method::Direct(direct) => RefinementSize {
                special_points: direct.special(),
                ring_bytes: direct.mesh_bytes(),
                bytes: bytes + direct.mesh_bytes() + direct.step_bytes(),
                ..RefinementSize::default()
            },
            Method::Trees(plan) => {
                let maps = plan.single.get().map_or(0, Maps::bytes) + plan.double.get().map_or(0, Maps::bytes);
                RefinementSize {
                    special_points: 0,
                    regular_faces: plan.rings.plain_faces(),
                    groups: plan.rings.representatives.len(),
                    nodes: plan.trees.nodes(),
                    ring_bytes: plan.rings.bytes(),
                    tree_bytes: plan.trees.bytes() + maps,
                    bytes: plan.rings.bytes() + plan.trees.bytes() + maps + bytes,
                }
            }
        }
    }
}

/// Figures about a refinement. Most meshes are refined without trees, and have special points only; those of the
/// trees are zero there, and all but the memory are zero where levels are kept whole.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub struct RefinementSize {
    /// Control vertices and edges with rules of their own, summed over the levels.
    pub special_points: usize,
    /// Control faces that are refined as regular grids.
    pub regular_faces: usize,
    /// Groups of equal surroundings among the others.
    pub groups: usize,
    /// Small linear maps that these and the faces below them have together.
    pub nodes: usize,
    /// Bytes of what grows with the mesh.
    pub ring_bytes: usize,
    /// Bytes of the maps, also in the precisions that have been used so far.
    pub tree_bytes: usize,
    /// Bytes of all, the control mesh's tables left out.
    pub bytes: usize,
}

/// Everything that values are made from.
pub(super) struct Sources<'a, T> {
    pub control: &'a Topology,
    pub rings: &'a FaceRings,
    pub trees: &'a TileTrees,
    pub maps: &'a Maps<T>,
    pub numbering: &'a Numbering,
}

/// Room for values, in huge pages where the system has them.
pub(super) fn zeroed<T: Real, const N: usize>(count: usize) -> Vec<[T; N]> {
    let mut out = vec![[T::default(); N]; count];
    subsurf_memory::advise(&mut out);
    out
}

fn refine_by_levels<T: Real, const N: usize>(levels: &[Level], values: &[[T; N]], count: usize) -> Vec<[T; N]> {
    assert_eq!(values.len(), count, "one value per vertex of the control mesh");
    levels.iter().fold(values.to_vec(), |values, level| level.refine_values(&values))
}
