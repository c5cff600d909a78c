//! Where results go: files that appear whole or not at all, or standard output.

use crate::args::Common;
use crate::failure::Failure;
use crate::interrupt;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use subsurf_io::{AtomicFile, EncodeError, Format, OutputMesh, Real, WriteError, write, write_to};

/// A place for a result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Output {
    StandardOutput,
    File(PathBuf),
}

impl Output {
    /// From what follows `-o`, where `-` is standard output, which `--json` must not need as well.
    pub fn new(path: &Path, common: &Common) -> Result<Self, Failure> {
        if path.as_os_str() != "-" {
            return Ok(Self::File(path.to_owned()));
        }
        if common.json {
            return Err(Failure::Usage("--json and -o - both write to standard output; give -o a file"));
        }
        Ok(Self::StandardOutput)
    }

    /// As a name for machines.
    pub fn name(&self) -> String {
        match self {
            Self::StandardOutput => "-".to_owned(),
            Self::File(path) => path.display().to_string(),
        }
    }

    /// Refuses early a file whose name does not end in `.extension`, or that could not be written later.
    pub fn check_extension(&self, extension: &str, failure: impl Fn(String) -> Failure) -> Result<(), Failure> {
        let Self::File(path) = self else { return Ok(()) };
        let has_extension = path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension));
        if has_extension || is_stream(path) { self.check() } else { Err(failure(path.display().to_string())) }
    }

    fn check(&self) -> Result<(), Failure> {
        let Self::File(path) = self else { return Ok(()) };
        // A pipe must not be opened twice.
        if is_stream(path) {
            return Ok(());
        }
        interrupt::clean_up(path);
        AtomicFile::create(path).map(drop).map_err(|error| write_error(path, error).into())
    }

    /// Refuses early a mesh file of unknown format, or one that could not be written.
    pub fn check_mesh(&self) -> Result<(), Failure> {
        match self {
            Self::File(path) if Format::from_path(path).is_none() => {
                Err(WriteError::UnknownFormat { name: path.display().to_string() }.into())
            }
            _ => self.check(),
        }
    }

    /// True where the format keeps creases, corners and holes.
    pub fn keeps_tags(&self) -> bool {
        match self {
            Self::StandardOutput => true,
            Self::File(path) => Format::from_path(path) == Some(Format::Obj),
        }
    }

    /// Writes a mesh, as OBJ to standard output.
    pub fn write_mesh<T: Real>(&self, mesh: &OutputMesh<'_, T>) -> Result<(), Failure> {
        match self {
            Self::File(path) => Ok(write(path, mesh)?),
            Self::StandardOutput => match write_to(io::stdout().lock(), Format::Obj, mesh) {
                Ok(()) => Ok(()),
                Err(EncodeError::Io(error)) => Err(Failure::from_stdout(error)),
                Err(EncodeError::Mesh(source)) => {
                    Err(WriteError::Mesh { name: "standard output".to_owned(), source }.into())
                }
                Err(error) => Err(Failure::StandardOutput(io::Error::other(error))),
            },
        }
    }

    /// Lets `fill` write a file or to standard output; a file appears only if all goes well.
    pub fn write_with(&self, fill: impl FnOnce(&mut dyn Write) -> Result<(), FillError>) -> Result<(), Failure> {
        match self {
            Self::StandardOutput => {
                let mut out = BufWriter::with_capacity(1 << 16, io::stdout().lock());
                let filled = fill(&mut out).and_then(|()| Ok(out.flush()?));
                filled.map_err(|error| error.into_failure(Failure::from_stdout))
            }
            Self::File(path) => {
                let failed = |error| write_error(path, error).into();
                let file = AtomicFile::create(path).map_err(failed)?;
                let mut out = BufWriter::with_capacity(1 << 18, file);
                fill(&mut out).map_err(|error| error.into_failure(failed))?;
                let file = out.into_inner().map_err(|error| failed(error.into_error()))?;
                file.commit().map_err(failed)
            }
        }
    }
}

/// Why a result was not written: the stream failed, or what was to be written.
pub enum FillError {
    Stream(io::Error),
    Content(Failure),
}

impl From<io::Error> for FillError {
    fn from(error: io::Error) -> Self {
        Self::Stream(error)
    }
}

impl From<Failure> for FillError {
    fn from(failure: Failure) -> Self {
        Self::Content(failure)
    }
}

impl FillError {
    fn into_failure(self, stream: impl FnOnce(io::Error) -> Failure) -> Failure {
        match self {
            Self::Stream(error) => stream(error),
            Self::Content(failure) => failure,
        }
    }
}

/// A pipe, a device or the like.
fn is_stream(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

fn write_error(path: &Path, source: io::Error) -> WriteError {
    WriteError::from_io(path, source)
}
