//! Subdivision surfaces, evaluated exactly.
//!
//! A coarse *control mesh* describes a smooth *limit surface*. This crate evaluates the surface itself, at any point, with
//! derivatives, next to extraordinary vertices, creases, boundaries and corners alike; no approximating patches, no
//! isolation depth.
//!
//! The tour, in the order of the pipeline:
//!
//! 1. [`ControlMesh`]: faces, and [`Tags`] (creases, corners, holes, rules). Checked once, in the constructor.
//! 2. [`Topology`]: half-edge tables, built in linear time.
//! 3. [`Level`]: classical refinement, level by level, in OpenSubdiv's order; [`UniformRefinement`]: a deep level at once.
//! 4. [`PatchTable`]: for every face a plan and a ring of control points; once per connectivity.
//! 5. [`LimitSurface`]: a table with positions (or any attribute); once per frame. Evaluates a [`Location`] to a [`Jet`].
//! 6. [`Tessellation`]: the limit surface as a watertight mesh.
//! 7. [`ShadingNormals`]: normals to shade with, smoother than the surface's own round extraordinary vertices.
//!
//! A [`Channel`] holds face-varying (or varying) values over the same faces; it is refined by 3 and evaluated by 4 to 6.
//!
//! Beside it, [`StencilTable`] and [`LimitStencilTable`] tabulate refined and limit points as weighted sums of control
//! points, for connectivity that stays and attributes that change.
//!
//! ```
//! use subsurf::{ControlMesh, Crease, Location, PatchTable, Scheme, Tags};
//!
//! let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
//! let positions: Vec<[f64; 3]> =
//!     (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| 2.0 * f64::from(bit) - 1.0)).collect();
//!
//! let tags = Tags { creases: vec![Crease::new(4, 5, 2.5)], ..Tags::default() };
//! let mesh = ControlMesh::new(&faces, tags)?;
//! let patches = PatchTable::new(&mesh, Scheme::CatmullClark)?; // once per connectivity
//! let surface = patches.surface(&positions); // once per frame
//!
//! let jet = surface.eval_second(Location::new(1, 0.25, 0.5)).expect("face 1 is no hole");
//! let normal = jet.normal().expect("the surface is smooth there");
//! let (k1, k2) = jet.principal_curvatures().expect("curvature is finite there");
//! assert!(normal[2] > 0.9 && k1 <= 0.0 && k2 < k1);
//! # Ok::<(), subsurf::MeshError>(())
//! ```
//!
//! Values are `[T; N]` with `T` = `f32` or `f64` and any `N`: positions, colours, weights have the same functions. Those of points,
//! `N = 3`, are compiled with this crate, others with the program that calls them, which takes up to half a minute. Everything
//! parallel gives the same bits on any number of threads.

#![forbid(unsafe_code)]

mod adaptive;
mod channel;
mod compiled;
mod edit;
mod index;
mod kernel;
mod limit;
mod mask;
mod mesh;
mod ptex;
mod real;
mod refine;
mod scheme;
mod shading;
pub mod shapes;
mod sharpness;
mod stencil;
mod tags;
mod tessellate;
mod threads;
mod topology;
mod triangulate;

pub use adaptive::{
    AdaptiveError, AdaptiveKind, AdaptiveOptions, AdaptivePatch, AdaptiveRefinement, AdaptiveSize, MAX_ISOLATION,
};
pub use channel::{Channel, ChannelError};
pub use edit::{EditError, Edited, TableEditor};
pub use index::{Edge, Face, HalfEdge, Vertex};
pub use kernel::limit_vector_bits;
pub use limit::{
    Curvature, Derivatives, EvaluationSize, Exceptional, Jet, LimitPatch, LimitSurface, Location, MOST_POLE_BYTES,
    Method, PatchKind, PatchTable, Spectrum, TableSize,
};
pub use mesh::{ControlMesh, MAX_COUNT, MeshError, Pole};
pub use ptex::{PtexEdge, PtexFaces};
pub use real::Real;
pub use refine::{Level, RefinementSize, UniformRefinement};
pub use scheme::Scheme;
pub use shading::{Averaging, Blend, NormalField, Power, ShadingError, ShadingNormals, ShadingOptions};
pub use stencil::{
    Dependents, LimitStencilOptions, LimitStencilTable, Orders, Part, StencilError, StencilOptions, StencilTable,
};
pub use tags::{Boundary, Corner, Crease, Creasing, FaceVarying, INFINITE_SHARPNESS, Rules, Tags, Triangles};
pub use tessellate::{
    FINEST, Facets, Places, Rates, TessellateError, TessellateOptions, TessellatedChannel, Tessellation, Tessellator,
};
pub use topology::Topology;
pub use triangulate::Triangulated;

/// The README's example runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

/// The examples for those who know OpenSubdiv run as tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/from-opensubdiv.md")]
struct FromOpenSubdiv;
