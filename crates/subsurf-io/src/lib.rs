//! Control meshes from files, surfaces to files.

#![forbid(unsafe_code)]
#![allow(dead_code)]

mod line;
mod number;
mod obj_write;
mod output;
mod write_error;

pub use obj_write::write_obj;
pub use output::{Attribute, FaceSizes, OutputError, OutputMesh, Real};
pub use write_error::{EncodeError, WriteError};
