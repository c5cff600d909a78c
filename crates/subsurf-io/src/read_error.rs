//! Why a file could not be read: each message names the file, the line where there is one, and what to do.

use std::io::{self, ErrorKind};
use std::path::Path;
use subsurf::MeshError;
use thiserror::Error;

/// Why a file could not be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// No file of that name.
    #[error("{name}: there is no such file; check the path")]
    NotFound {
        /// The path as given.
        name: String,
    },
    /// A folder where a file was expected.
    #[error("{name}: is a folder; name a file in it")]
    IsDirectory {
        /// The path as given.
        name: String,
    },
    /// The system does not let us read it.
    #[error("{name}: permission denied; make the file readable")]
    PermissionDenied {
        /// The path as given.
        name: String,
    },
    /// The name does not end as a supported format does.
    #[error("{name}: cannot tell the format from the name; supported for reading: .obj")]
    UnknownFormat {
        /// The path as given.
        name: String,
    },
    /// Reading failed midway.
    #[error("{name}: reading failed: {source}")]
    Io {
        /// The path or name as given.
        name: String,
        /// What the system says.
        source: io::Error,
    },
    /// A line that makes no sense.
    #[error("{name}:{line}: {source}")]
    Line {
        /// The path or name as given.
        name: String,
        /// Counted from 1.
        line: u32,
        /// What is wrong with it.
        source: LineError,
    },
    /// Nothing to subdivide.
    #[error("{name}: {}", no_faces(*lines, *vertices))]
    NoFaces {
        /// The path or name as given.
        name: String,
        /// How many lines there are.
        lines: u32,
        /// How many vertices they have.
        vertices: usize,
    },
    /// The lines are fine, the mesh they make is not.
    #[error("{name}{}: {source}", line.map_or(String::new(), |line| format!(":{line}")))]
    Mesh {
        /// The path or name as given.
        name: String,
        /// The line of the face or tag, counted from 1.
        line: Option<u32>,
        /// What is wrong with it; faces, vertices and tags are counted from 0.
        source: MeshError,
    },
    /// The text is not in a byte-wise encoding.
    #[error("{name}: the text is UTF-16; save it as UTF-8 or ASCII")]
    Utf16 {
        /// The path or name as given.
        name: String,
    },
}

impl ReadError {
    /// The error for a failure of the system on the file called `name`.
    pub(crate) fn from_io(name: &str, source: io::Error) -> Self {
        let name = name.to_owned();
        match source.kind() {
            ErrorKind::NotFound | ErrorKind::NotADirectory => Self::NotFound { name },
            ErrorKind::IsADirectory => Self::IsDirectory { name },
            ErrorKind::PermissionDenied => Self::PermissionDenied { name },
            _ => Self::Io { name, source },
        }
    }

    pub(crate) fn unknown_format(path: &Path) -> Self {
        Self::UnknownFormat { name: path.display().to_string() }
    }
}

/// What was found instead of faces.
fn no_faces(lines: u32, vertices: usize) -> String {
    match (lines, vertices) {
        (0, _) => "the file is empty; an OBJ file with vertices (v) and faces (f) is needed".to_owned(),
        (_, 0) => format!("no vertices (v) and no faces (f) in {lines} lines; is this another format than OBJ?"),
        _ => format!("{vertices} vertices but no faces; at least one (f) is needed"),
    }
}

/// What is wrong with a line.
#[derive(Clone, PartialEq, Debug, Error)]
#[non_exhaustive]
pub enum LineError {
    /// A word that should be a number.
    #[error("`{word}` is not a number, in {statement}")]
    BadNumber {
        /// The statement's keyword.
        statement: &'static str,
        /// The word as it stands, shortened.
        word: String,
    },
    /// Fewer numbers than the statement needs.
    #[error("{statement} needs {needed} numbers, found {found}; is the file cut off?")]
    TooFewNumbers {
        /// The statement's keyword.
        statement: &'static str,
        /// How many it needs.
        needed: usize,
        /// How many there are.
        found: usize,
    },
    /// Not-a-number or an infinite number.
    #[error("`{word}` is not a finite number, in {statement}; {advice}")]
    NotFinite {
        /// The statement's keyword.
        statement: &'static str,
        /// The word as it stands, shortened.
        word: String,
        /// What to write instead.
        advice: &'static str,
    },
    /// A word of a face that is not `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    #[error("`{word}` is not a face corner; write v, v/vt, v//vn or v/vt/vn")]
    BadCorner {
        /// The word as it stands, shortened.
        word: String,
    },
    /// A face of fewer than three corners.
    #[error("the face has {corners} corners; a face needs at least 3")]
    FaceTooSmall {
        /// How many it has.
        corners: usize,
    },
    /// An index of 0.
    #[error("a face names {what} 0; they are counted from 1, or backwards from -1")]
    IndexZero {
        /// "vertex", "texture coordinate" or "normal".
        what: &'static str,
    },
    /// An index of something that does not exist.
    #[error("a face names {what} {index}, but there are {count}")]
    IndexOutOfRange {
        /// "vertex", "texture coordinate" or "normal".
        what: &'static str,
        /// As it stands in the file.
        index: i64,
        /// How many the whole file has; for an index that counts backwards, how many stand before the face.
        count: usize,
    },
    /// A face that has texture coordinates or normals at some corners only.
    #[error("the face has a {what} at some corners only; give one at each or at none")]
    MixedCorners {
        /// "texture coordinate" or "normal".
        what: &'static str,
    },
    /// A tag without a proper head.
    #[error("a tag reads `t name ints/floats/strings values…`, for example `t crease 2/1/0 0 1 2.5`")]
    BadTagHead,
    /// A tag whose head does not count its values.
    #[error("the {tag} tag announces {announced} values, but {found} follow")]
    TagValueCount {
        /// The tag's name.
        tag: &'static str,
        /// Sum of the counts in the head.
        announced: u64,
        /// How many follow.
        found: usize,
    },
    /// A tag that announces the wrong number of integers, sharpnesses or words.
    #[error("the {tag} tag needs {needed}")]
    TagShape {
        /// The tag's name.
        tag: &'static str,
        /// What it needs.
        needed: &'static str,
    },
    /// A value of a tag that is not one of those it may have.
    #[error("`{word}` is no value of the {tag} tag; use {allowed}")]
    BadTagValue {
        /// The tag's name.
        tag: &'static str,
        /// The word as it stands, shortened.
        word: String,
        /// What it may be.
        allowed: &'static str,
    },
}

/// `word` as text fit for a message.
pub(crate) fn quoted(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(&word[..word.len().min(LONGEST)]).escape_debug().to_string();
    if word.len() > LONGEST { text + "…" } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_names_file_line_and_trouble() {
        let source = LineError::IndexOutOfRange { what: "vertex", index: 9, count: 8 };
        let error = ReadError::Line { name: "cube.obj".into(), line: 12, source };
        assert_eq!(error.to_string(), "cube.obj:12: a face names vertex 9, but there are 8");
        let source = MeshError::CreaseNotOnEdge { crease: 1, a: 0, b: 2 };
        let error = ReadError::Mesh { name: "cube.obj".into(), line: None, source };
        assert_eq!(error.to_string(), "cube.obj: crease 1 names vertices 0 and 2, but no edge joins them");
    }

    #[test]
    fn quoted_words_are_short_and_printable() {
        assert_eq!(quoted(b"1\x00\xff"), "1\\0\u{fffd}");
        assert!(quoted(&[b'x'; 1000]).chars().count() < 50);
    }
}
