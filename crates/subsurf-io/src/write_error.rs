//! Why a mesh could not be written.

use crate::output::OutputError;
use std::io::{self, ErrorKind};
use std::path::Path;
use thiserror::Error;

/// Why a mesh could not be written to a stream.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// The mesh is none.
    #[error(transparent)]
    Mesh(#[from] OutputError),
    /// The stream took no more.
    #[error("writing failed: {0}")]
    Io(#[from] io::Error),
}

/// Why a file could not be written. No part of it is left behind.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The folder does not exist.
    #[error("{name}: there is no such folder; make it first")]
    NoFolder {
        /// The path as given.
        name: String,
    },
    /// A file lies where the path needs a folder.
    #[error("{name}: the path goes through a file; name a folder instead of it")]
    NotAFolder {
        /// The path as given.
        name: String,
    },
    /// A folder of that name exists.
    #[error("{name}: is a folder; give a file name")]
    IsDirectory {
        /// The path as given.
        name: String,
    },
    /// The system does not let us write there.
    #[error("{name}: permission denied; choose a writable place")]
    PermissionDenied {
        /// The path as given.
        name: String,
    },
    /// The name does not end as a supported format does.
    #[error("{name}: cannot tell the format from the name; supported for writing: .obj, .ply, .glb")]
    UnknownFormat {
        /// The path as given.
        name: String,
    },
    /// Writing failed midway.
    #[error("{name}: writing failed: {source}")]
    Io {
        /// The path as given.
        name: String,
        /// What the system says.
        source: io::Error,
    },
    /// The mesh cannot be written in this format.
    #[error("{name}: {source}")]
    Mesh {
        /// The path as given.
        name: String,
        /// What is wrong with the mesh.
        source: OutputError,
    },
}

impl WriteError {
    /// The error for a failure of the system on the file at `path`.
    pub fn from_io(path: &Path, source: io::Error) -> Self {
        let name = path.display().to_string();
        match source.kind() {
            ErrorKind::NotFound => Self::NoFolder { name },
            ErrorKind::NotADirectory => Self::NotAFolder { name },
            ErrorKind::IsADirectory => Self::IsDirectory { name },
            ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => Self::PermissionDenied { name },
            _ => Self::Io { name, source },
        }
    }

    pub(crate) fn from_encode(path: &Path, error: EncodeError) -> Self {
        match error {
            EncodeError::Io(source) => Self::from_io(path, source),
            EncodeError::Mesh(source) => Self::Mesh { name: path.display().to_string(), source },
        }
    }
}
