//! Why a verb could not be done: one message each, which names what is wrong and what to do.

use crate::eval::TableError;
use crate::render::picture::PictureError;
use std::io;
use subsurf::{AdaptiveError, ChannelError, MeshError, ShadingError, TessellateError};
use subsurf_io::{ReadError, WriteError};
use thiserror::Error;

/// What ends the program with a status other than 0.
#[derive(Debug, Error)]
pub enum Failure {
    /// Wrong usage that the argument parser cannot see.
    #[error("{0}")]
    Usage(&'static str),
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Something that is wrong with a mesh once its topology is known.
    #[error("{name}: {source}")]
    Mesh { name: String, source: MeshError },
    #[error("{name}: level {level} is too large: {source}")]
    Level { name: String, level: u32, source: MeshError },
    #[error("{name}: {source}")]
    Baseline { name: String, source: AdaptiveError },
    #[error("{name}: {source}")]
    Tessellate { name: String, source: TessellateError },
    #[error("{name}: {source}")]
    Picture { name: String, source: PictureError },
    #[error("{name}: {source}")]
    Shading { name: String, source: ShadingError },
    #[error("{name} has no vertex normals; leave out --file-normals")]
    NoNormals { name: String },
    #[error(transparent)]
    Table(#[from] TableError),
    #[error("this build has no GPU support yet; leave out --device gpu")]
    Gpu,
    #[error("{name}: reading {format} files is not supported yet; convert it to .obj")]
    InputFormat { name: String, format: &'static str },
    #[error("{name}: pictures are written as PNG; let the name end in .png")]
    PictureName { name: String },
    #[error("{name}: tables are written as CSV; let the name end in .csv")]
    TableName { name: String },
    #[error("{name}: vertex {vertex} at {position:?} does not fit into 32-bit numbers; use --precision f64")]
    Precision { name: String, vertex: usize, position: [f64; 3] },
    #[error("{name}: texture coordinates: {source}")]
    Texture { name: String, source: ChannelError },
    #[error("{name}: texture coordinate {index}, {value:?}, does not fit into 32-bit numbers; use --precision f64")]
    TexturePrecision { name: String, index: usize, value: [f64; 2] },
    #[error("{name} has no texture coordinates; leave out --texture")]
    NoTexture { name: String },
    #[error(
        "{name}: every face is a hole, so the surface is empty; take hole tags out, or try --boundary edge-and-corner"
    )]
    OnlyHoles { name: String },
    #[error("{name}: {what} needs about {needed}, but {available} of memory are available; ask for less")]
    Memory { name: String, what: String, needed: Bytes, available: Bytes },
    #[error("cannot start {threads} threads: {reason}; use fewer")]
    Threads { threads: usize, reason: String },
    #[error("standard output: writing failed: {0}")]
    StandardOutput(io::Error),
    /// Nobody reads our standard output any more, which is not our failure.
    #[error("standard output was closed")]
    Closed,
}

impl Failure {
    /// From a failure to write to standard output.
    pub fn from_stdout(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::Closed,
            _ => Self::StandardOutput(error),
        }
    }

    /// Exit status of the program.
    pub fn status(&self) -> u8 {
        match self {
            Self::Closed => 0,
            Self::Usage(_) => 2,
            _ => 1,
        }
    }
}

/// A number of bytes, shown with a unit.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Bytes(pub u64);

impl std::fmt::Display for Bytes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        const UNITS: [&str; 7] = ["bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];
        let mut size = self.0 as f64;
        let mut unit = 0;
        while size >= 1000.0 && unit + 1 < UNITS.len() {
            size /= 1024.0;
            unit += 1;
        }
        let digits = if unit == 0 || size >= 100.0 { 0 } else { 1 };
        write!(f, "{size:.digits$} {}", UNITS[unit])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_have_a_unit_and_few_digits() {
        let text = |bytes| Bytes(bytes).to_string();
        assert_eq!(
            [text(12), text(1536), text(300 << 20), text(u64::MAX)],
            ["12 bytes", "1.5 KiB", "300 MiB", "16.0 EiB"]
        );
    }
}
