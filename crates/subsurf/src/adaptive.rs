//! Feature-adaptive refinement (Nießner, Loop, Meyer, DeRose 2012, "Feature-adaptive GPU rendering of Catmull-Clark
//! subdivision surfaces"): the usual way to bring subdivision surfaces to patches, here as a baseline to measure
//! [`PatchTable`](crate::PatchTable) against. Nothing in this crate evaluates these patches.
//!
//! Faces next to features (extraordinary vertices, creases, corners, n-gons) are refined, level by level; the others become
//! spline patches where they are. What is still irregular at the deepest level, the *isolation* level, is covered by
//! end caps, which approximate. Semi-sharp creases are refined until they have decayed, so the number of patches doubles
//! with every step of sharpness, unless single-crease patches (Nießner, Loop, Greiner 2012, "Efficient evaluation of
//! semi-smooth creases in Catmull-Clark subdivision surfaces") take them over.
//!
//! The patches are those of OpenSubdiv 3.7's `Far::PatchTableFactory` with infinitely-sharp patches. One thing is
//! different: it can treat a smooth corner of a boundary (rule "edge-only") as a sharp one, an approximation that is on by
//! default (`generateLegacySharpCornerPatches`); here it never is.
//!
//! Refinement is sparse: a level holds the children of faces that were refined, and the ring of faces round them.

mod features;
mod size;
mod sparse_level;

pub use size::AdaptiveSize;

use crate::index::Face;
use crate::limit::Location;
use crate::mesh::{ControlMesh, MeshError};
use crate::ptex::PtexFaces;
use crate::refine::scheme_topology;
use crate::scheme::{Scheme, SplitKind};
use crate::tags::INFINITE_SHARPNESS;
use crate::topology::Topology;
use features::{Features, PatchShape, Verdict};
use rayon::prelude::*;
use sparse_level::{Place, SparseLevel};

/// The deepest isolation level; OpenSubdiv's too, whose patches keep ten bits per parameter.
pub const MAX_ISOLATION: u32 = 10;

/// Faces that one level may have: about two gigabytes.
const MOST_FACES: usize = 1 << 24;

/// How far and for what features are refined.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct AdaptiveOptions {
    /// The deepest level, in `1..=MAX_ISOLATION`. What is irregular there gets an end cap, and sharpness that is left
    /// there is dropped.
    pub isolation: u32,
    /// Stop refining where one semi-sharp crease runs along a side of a regular quad. Of no effect under Loop.
    pub single_crease: bool,
}

impl Default for AdaptiveOptions {
    /// Ten levels, which bring every sharpness to its end, with single-crease patches.
    fn default() -> Self {
        Self { isolation: MAX_ISOLATION, single_crease: true }
    }
}

impl AdaptiveOptions {
    /// As many levels as finite sharpness needs to decay on this mesh, at least 4 and at most [`MAX_ISOLATION`].
    pub fn for_sharpness_of(t: &Topology, single_crease: bool) -> Self {
        let finite = t.edge_sharpness.iter().chain(t.vertex_sharpness.iter()).filter(|s| *s < INFINITE_SHARPNESS);
        let most = finite.fold(0.0f64, f64::max);
        Self { isolation: (most.ceil() as u32).clamp(4, MAX_ISOLATION), single_crease }
    }
}

/// Why there are no feature-adaptive patches.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AdaptiveError {
    /// The isolation level is 0 or too deep.
    #[error("the isolation level is {isolation}: it must be 1 to {MAX_ISOLATION}")]
    Isolation {
        /// As given.
        isolation: u32,
    },
    /// A level has too many faces.
    #[error(
        "level {level} of feature-adaptive refinement would have {faces} faces, more than {limit}: take a lower \
         isolation level, lower sharpness or single-crease patches"
    )]
    TooManyFaces {
        /// The level.
        level: u32,
        /// Its faces.
        faces: usize,
        /// How many there may be.
        limit: usize,
    },
    /// The mesh cannot be subdivided.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// What kind of patch feature-adaptive refinement makes of a face.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum AdaptiveKind {
    /// A spline patch: bicubic, quartic under Loop, bilinear.
    Regular,
    /// A spline patch that ends at boundaries or infinitely sharp creases.
    Boundary,
    /// A bicubic patch along one semi-sharp crease.
    SingleCrease,
    /// An approximating patch (Gregory, say) of what is irregular at the deepest level.
    EndCap,
}

impl AdaptiveKind {
    /// Every kind, in the order of [`AdaptiveRefinement::counts`].
    pub const ALL: [Self; 4] = [Self::Regular, Self::Boundary, Self::SingleCrease, Self::EndCap];
}

/// One patch of the baseline.
///
/// Place (a, b) on the patch, whose corners are (0,0), (1,0), (1,1), (0,1) (under Loop (0,0), (1,0), (0,1)), is
/// `(u + size · a, v + size · b)` on the sub-face.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct AdaptivePatch {
    /// The face of the control mesh that it is a part of.
    pub face: Face,
    /// 0 for quads (triangles under Loop), the corner for other faces.
    pub subface: u32,
    /// The level of refinement whose face it is. The sub-faces of an n-gon are faces of level 1.
    pub level: u32,
    /// First parameter of its corner 0, in `[0, 1]`.
    pub u: f64,
    /// Second parameter of its corner 0, in `[0, 1]`.
    pub v: f64,
    /// Length of its sides in the parameters of the sub-face; negative for triangles that are turned upside down.
    pub size: f64,
    /// What kind of patch it is.
    pub kind: AdaptiveKind,
    /// Bit i: its side i, from corner i on, is a boundary or infinitely sharp, or is the crease of a single-crease patch.
    pub sides: u8,
    /// Sharpness of a single-crease patch at its own level, in `(0, 10)`; 0 otherwise.
    pub sharpness: f64,
    /// True where sharpness is left that the patch does not show, because it would need deeper levels.
    pub cut_short: bool,
}

/// The patches of feature-adaptive refinement, and what they cost.
#[derive(Clone, Debug)]
pub struct AdaptiveRefinement {
    scheme: Scheme,
    options: AdaptiveOptions,
    ptex: PtexFaces,
    /// Sorted by Ptex face and path.
    patches: Vec<Placed>,
    vertices: Vec<usize>,
    mask_weights: Vec<usize>,
}

/// A patch and its place.
#[derive(Clone, Copy, Debug)]
struct Placed {
    place: Place,
    level: u8,
    shape: PatchShape,
}

impl Placed {
    /// Ptex face and path to the first place of the patch.
    fn key(&self) -> (u32, u32) {
        (self.place.ptex_face, self.place.path << (2 * (MAX_ISOLATION - u32::from(self.place.steps))))
    }
}

impl AdaptiveRefinement {
    /// Finds the patches of a mesh. Time and memory grow with the features, not with 4 to the isolation level.
    ///
    /// # Errors
    /// [`AdaptiveError`]: isolation levels out of range, meshes that [`Topology::new`] refuses, and too many faces.
    pub fn new(mesh: &ControlMesh, scheme: Scheme, options: AdaptiveOptions) -> Result<Self, AdaptiveError> {
        Self::from_topology(&scheme_topology(mesh, scheme)?, scheme, options)
    }

    /// Finds the patches of a control mesh whose topology is at hand, that of a [`PatchTable`](crate::PatchTable), say.
    ///
    /// # Errors
    /// As [`AdaptiveRefinement::new`].
    pub fn from_topology(t: &Topology, scheme: Scheme, options: AdaptiveOptions) -> Result<Self, AdaptiveError> {
        Self::find(t, scheme, options, MOST_FACES)
    }

    fn find(t: &Topology, scheme: Scheme, options: AdaptiveOptions, most_faces: usize) -> Result<Self, AdaptiveError> {
        let isolation = options.isolation;
        if !(1..=MAX_ISOLATION).contains(&isolation) {
            return Err(AdaptiveError::Isolation { isolation });
        }
        if scheme.split() == SplitKind::Triangles
            && let Some(face) = (0..t.face_count()).find(|&f| t.sides(Face::new(f)) != 3)
        {
            return Err(MeshError::NotATriangle { face, sides: t.sides(Face::new(face)) }.into());
        }
        let ptex = PtexFaces::new(t, scheme);
        let mut level = SparseLevel::control_mesh(t, scheme, &ptex);
        let (mut patches, mut vertices, mut mask_weights) = (Vec::new(), Vec::new(), vec![0]);
        loop {
            vertices.push(level.vertex_count());
            let around = level.around_vertices();
            let features = Features { level: &level, around: &around, single_crease: options.single_crease, isolation };
            let verdict = |f: usize| level.complete[f].then(|| features.verdict(f));
            let verdicts: Vec<Option<Verdict>> = (0..level.face_count()).into_par_iter().map(verdict).collect();
            patches.extend(verdicts.iter().zip(&level.place).filter_map(|(verdict, &place)| match verdict {
                Some(Verdict::Patch(shape)) => Some(Placed { place, level: level.depth as u8, shape: *shape }),
                _ => None,
            }));
            let chosen: Vec<bool> = verdicts.iter().map(|v| *v == Some(Verdict::Refine)).collect();
            if !chosen.contains(&true) {
                break;
            }
            let choice = level.choose(chosen, level.depth + 1 == isolation);
            if choice.faces > most_faces {
                return Err(AdaptiveError::TooManyFaces {
                    level: level.depth + 1,
                    faces: choice.faces,
                    limit: most_faces,
                });
            }
            mask_weights.push(size::mask_weights(&level, &choice, &around));
            level = level.refine(&choice, &around);
        }
        patches.par_sort_unstable_by_key(Placed::key);
        Ok(Self { scheme, options, ptex, patches, vertices, mask_weights })
    }

    /// The scheme.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// The options that the patches were made with.
    pub fn options(&self) -> AdaptiveOptions {
        self.options
    }

    /// The numbers of faces and sub-faces that patches are listed by.
    pub fn ptex_faces(&self) -> &PtexFaces {
        &self.ptex
    }

    /// Number of patches.
    pub fn patch_count(&self) -> usize {
        self.patches.len()
    }

    /// All patches, Ptex face by Ptex face, on each in the order of children of children.
    pub fn patches(&self) -> impl ExactSizeIterator<Item = AdaptivePatch> {
        self.patches.iter().map(|placed| self.describe(placed))
    }

    /// The patch that covers a place; none in holes. Where patches meet, the later one, as in the patch trees of
    /// [`PatchTable`](crate::PatchTable).
    ///
    /// # Panics
    /// If the location names no sub-face of the mesh.
    pub fn patch_at(&self, at: Location) -> Option<AdaptivePatch> {
        let ptex_face = self.ptex.id(at.face, at.subface);
        let (mut u, mut v, mut path) = (at.u, at.v, 0);
        for _ in 0..MAX_ISOLATION {
            path = path << 2 | self.descend(&mut u, &mut v);
        }
        let next = self.patches.partition_point(|placed| placed.key() <= (ptex_face, path));
        let found = &self.patches[next.checked_sub(1)?];
        (found.place.ptex_face == ptex_face).then(|| self.describe(found))
    }

    /// The child that a place lies in, and its parameters there.
    fn descend(&self, u: &mut f64, v: &mut f64) -> u32 {
        let (child, [cu, cv]) = match (self.scheme.split(), *u >= 0.5, *v >= 0.5) {
            (SplitKind::Quads, true, true) => (2, [1.0, 1.0]),
            (_, true, _) => (1, [1.0, 0.0]),
            (SplitKind::Quads, false, true) => (3, [0.0, 1.0]),
            (SplitKind::Triangles, false, true) => (2, [0.0, 1.0]),
            (SplitKind::Triangles, ..) if *u + *v > 0.5 => {
                (*u, *v) = (1.0 - 2.0 * *u, 1.0 - 2.0 * *v);
                return 3;
            }
            _ => (0, [0.0, 0.0]),
        };
        (*u, *v) = (2.0 * *u - cu, 2.0 * *v - cv);
        child
    }

    fn describe(&self, placed: &Placed) -> AdaptivePatch {
        let Placed { place, level, shape } = *placed;
        let (face, subface) = self.ptex.face(place.ptex_face);
        let (mut u, mut v, mut size) = (0.0, 0.0, 1.0);
        for step in (0..u32::from(place.steps)).rev() {
            size *= 0.5;
            let (a, b) = match (self.scheme.split(), place.path >> (2 * step) & 3) {
                (_, 0) => (0.0, 0.0),
                (_, 1) => (1.0, 0.0),
                (SplitKind::Quads, 2) => (1.0, 1.0),
                (SplitKind::Quads, _) | (SplitKind::Triangles, 2) => (0.0, 1.0),
                (SplitKind::Triangles, _) => (1.0, 1.0),
            };
            (u, v) = (u + size * a, v + size * b);
            if self.scheme.split() == SplitKind::Triangles && place.path >> (2 * step) & 3 == 3 {
                size = -size;
            }
        }
        AdaptivePatch {
            face,
            subface,
            level: u32::from(level),
            u,
            v,
            size,
            kind: shape.kind,
            sides: shape.sides,
            sharpness: shape.sharpness,
            cut_short: shape.cut_short,
        }
    }

    /// Number of patches by level and kind, kinds in the order of [`AdaptiveKind::ALL`].
    pub fn counts(&self) -> Vec<[usize; 4]> {
        let mut counts = vec![[0; 4]; self.vertices.len()];
        for placed in &self.patches {
            counts[usize::from(placed.level)][placed.shape.kind as usize] += 1;
        }
        counts
    }

    /// Number of vertices by level: at level 0 those of the control mesh, below those that were refined.
    pub fn vertices(&self) -> &[usize] {
        &self.vertices
    }
}

#[cfg(test)]
mod tests;
