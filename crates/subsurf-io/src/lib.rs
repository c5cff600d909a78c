//! Control meshes from files, surfaces to files.

#![forbid(unsafe_code)]

mod gltf;
mod line;
mod number;
mod obj;
mod obj_tag;
mod obj_write;
mod output;
mod ply;
mod read_error;
mod scene;
mod source_lines;
mod weld;
mod words;
mod write_error;

pub use gltf::write_glb;
pub use obj::read_obj;
pub use obj_write::write_obj;
pub use output::{Attribute, FaceSizes, OutputError, OutputMesh, Real};
pub use ply::write_ply;
pub use read_error::{LineError, ReadError};
pub use scene::{Channel, FileRules, ReadOptions, Scene, Scheme, Warning, WarningKind};
pub use source_lines::SourceLines;
pub use write_error::{EncodeError, WriteError};
