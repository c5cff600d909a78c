//! Subdivision surfaces, evaluated exactly.

#![forbid(unsafe_code)]

mod index;
mod limit;
mod mesh;
mod tags;

pub use index::{Edge, Face, HalfEdge, Vertex};
pub use mesh::{ControlMesh, MAX_COUNT, MeshError};
pub use tags::{Boundary, Corner, Crease, Creasing, FaceVarying, INFINITE_SHARPNESS, Rules, Tags, Triangles};
