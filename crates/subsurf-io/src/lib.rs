//! Control meshes from files, surfaces to files.
//!
//! Reading: Wavefront OBJ with OpenSubdiv's subdivision tags, into a [`Scene`]. Writing: OBJ, PLY and glTF, from an
//! [`OutputMesh`] that borrows its arrays.
//!
//! ```
//! use subsurf_io::{Format, ReadOptions, read_obj, write_to};
//!
//! let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nt crease 2/1/0 0 1 2.5\n";
//! let scene = read_obj(text.as_bytes(), "quad.obj", &ReadOptions::default())?;
//! assert_eq!(scene.mesh.face_count(), 1);
//! assert_eq!(scene.mesh.tags().creases[0].sharpness, 2.5);
//! assert_eq!(scene.lines.crease(0), Some(6));
//!
//! let mut ply = Vec::new();
//! write_to(&mut ply, Format::Ply, &scene.output())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`read`] and [`write`](write()) take paths and choose the format by extension. A file that is written appears whole
//! or not at all. Errors name the file, the line and what to do; no input makes a reader panic, nor use much more memory
//! than the file is long.

#![forbid(unsafe_code)]

mod atomic_file;
mod format;
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

pub use atomic_file::AtomicFile;
pub use format::{Format, read, write, write_to};
pub use gltf::write_glb;
pub use obj::read_obj;
pub use obj_write::write_obj;
pub use output::{Attribute, FaceSizes, OutputError, OutputMesh, Real};
pub use ply::write_ply;
pub use read_error::{LineError, ReadError};
pub use scene::{Channel, FileRules, ReadOptions, Scene, Warning, WarningKind};
pub use source_lines::SourceLines;
pub use subsurf::Scheme;
pub use write_error::{EncodeError, WriteError};
