//! Why a table of places could not be read.

use super::places::BLOCK;
use std::io;
use thiserror::Error;

/// Why a table could not be read; lines count from 1.
#[derive(Debug, Error)]
pub enum TableError {
    #[error("{name}: reading failed: {source}")]
    Io { name: String, source: io::Error },
    #[error("{name}: there is no such file; check the path")]
    NotFound { name: String },
    #[error("{name}: is a folder; name a file in it")]
    IsDirectory { name: String },
    #[error("{name}: permission denied; make the file readable")]
    PermissionDenied { name: String },
    #[error("{name}:{line}: {source}")]
    Row { name: String, line: u64, source: RowError },
}

/// What is wrong with a line.
#[derive(Clone, PartialEq, Debug, Error)]
pub enum RowError {
    #[error("the table is empty; begin with the header face,subface,u,v")]
    NoHeader,
    #[error("the header has no column {0}; it needs face,subface,u,v")]
    NoColumn(&'static str),
    #[error("the header names the column {0} twice; remove one")]
    TwoColumns(&'static str),
    #[error("the row has {found} fields where the header has {needed}; is the file cut off?")]
    FieldCount { found: usize, needed: usize },
    #[error("{name} is `{word}`; give a whole number from 0 on")]
    BadIndex { name: &'static str, word: String },
    #[error("{name} is `{word}`; give a number from 0 to 1")]
    BadParameter { name: &'static str, word: String },
    #[error("u + v is {sum}; in a triangle it is at most 1")]
    BeyondTriangle { sum: f64 },
    #[error("there is no face {face}; the mesh has {faces}, counted from 0")]
    NoFace { face: u32, faces: usize },
    #[error("face {face} has no sub-face {subface}; it has {subfaces}, counted from 0")]
    NoSubface { face: u32, subface: u32, subfaces: u32 },
    #[error("face {face} is a hole: the surface has no point there; leave the row out")]
    Hole { face: u32 },
    #[error("the line is longer than {BLOCK} bytes; is this a CSV file?")]
    TooLong,
}

impl TableError {
    /// The error for a failure of the system on the file called `name`.
    pub fn from_io(name: &str, source: io::Error) -> Self {
        let name = name.to_owned();
        match source.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => Self::NotFound { name },
            io::ErrorKind::IsADirectory => Self::IsDirectory { name },
            io::ErrorKind::PermissionDenied => Self::PermissionDenied { name },
            _ => Self::Io { name, source },
        }
    }
}

/// `word` as text fit for a message.
pub fn quoted(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(&word[..word.len().min(LONGEST)]).escape_debug().to_string();
    if word.len() > LONGEST { text + "…" } else { text }
}
