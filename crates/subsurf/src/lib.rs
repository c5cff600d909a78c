//! Subdivision surfaces, evaluated exactly.

#![forbid(unsafe_code)]

mod index;
mod limit;
mod mask;
mod mesh;
mod real;
mod refine;
mod scheme;
pub mod shapes;
mod sharpness;
mod tags;
mod tessellate;
mod topology;

pub use index::{Edge, Face, HalfEdge, Vertex};
pub use limit::{Curvature, Derivatives, Jet, LimitSurface, Location, Method, PatchKind, PatchTable, TableSize};
pub use mesh::{ControlMesh, MAX_COUNT, MeshError};
pub use real::Real;
pub use refine::Level;
pub use scheme::Scheme;
pub use tags::{Boundary, Corner, Crease, Creasing, FaceVarying, INFINITE_SHARPNESS, Rules, Tags, Triangles};
pub use tessellate::{FINEST, Facets, Places, Rates, TessellateError, TessellateOptions, Tessellation};
pub use topology::Topology;
