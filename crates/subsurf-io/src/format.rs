//! Which format a path means, and whole files read and written by it.

use crate::atomic_file::AtomicFile;
use crate::gltf::write_glb;
use crate::obj::read_obj;
use crate::obj_write::write_obj;
use crate::output::{OutputMesh, Real};
use crate::ply::write_ply;
use crate::read_error::ReadError;
use crate::scene::{ReadOptions, Scene};
use crate::write_error::{EncodeError, WriteError};
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

/// A format to write.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Format {
    /// Wavefront OBJ, with subdivision tags.
    Obj,
    /// PLY, binary little-endian.
    Ply,
    /// glTF 2.0 in one binary file.
    Glb,
}

impl Format {
    /// The format that the extension of `path` means, in upper or lower case.
    pub fn from_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_ascii_lowercase().to_str()? {
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "glb" => Some(Self::Glb),
            _ => None,
        }
    }
}

/// Reads the file at `path`, in the format its extension means: `.obj`.
///
/// # Errors
/// [`ReadError`] names the file, the line where there is one, and what to do.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Scene, ReadError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    // A folder opens like a file on some systems and only fails to be read.
    if fs::metadata(path).map_err(|error| ReadError::from_io(&name, error))?.is_dir() {
        return Err(ReadError::IsDirectory { name });
    }
    if Format::from_path(path) != Some(Format::Obj) {
        return Err(ReadError::unknown_format(path));
    }
    let file = File::open(path).map_err(|error| ReadError::from_io(&name, error))?;
    read_obj(file, &name, options)
}

/// Writes `mesh` to the file at `path`, in the format its extension means: `.obj`, `.ply` or `.glb`. The file appears
/// only when it is complete; a failure leaves what was there.
///
/// # Errors
/// [`WriteError`] names the file and what to do.
pub fn write<T: Real>(path: impl AsRef<Path>, mesh: &OutputMesh<'_, T>) -> Result<(), WriteError> {
    let path = path.as_ref();
    let Some(format) = Format::from_path(path) else {
        return Err(WriteError::UnknownFormat { name: path.display().to_string() });
    };
    let mut file = AtomicFile::create(path).map_err(|error| WriteError::from_io(path, error))?;
    write_to(&mut file, format, mesh).map_err(|error| WriteError::from_encode(path, error))?;
    file.commit().map_err(|error| WriteError::from_io(path, error))
}

/// Writes `mesh` to a stream.
///
/// # Errors
/// If the mesh is none or does not fit the format, or `out` takes no more.
pub fn write_to<T: Real>(out: impl Write, format: Format, mesh: &OutputMesh<'_, T>) -> Result<(), EncodeError> {
    match format {
        Format::Obj => write_obj(out, mesh),
        Format::Ply => write_ply(out, mesh),
        Format::Glb => write_glb(out, mesh),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::FaceSizes;

    #[test]
    fn the_extension_decides_in_either_case() {
        assert_eq!(Format::from_path(Path::new("a/b.OBJ")), Some(Format::Obj));
        assert_eq!(Format::from_path(Path::new("b.x.glb")), Some(Format::Glb));
        assert_eq!(Format::from_path(Path::new("obj")), None);
        assert_eq!(Format::from_path(Path::new("a.stl")), None);
    }

    #[test]
    fn a_file_that_cannot_be_read_is_named_with_the_reason() {
        let options = ReadOptions::default();
        assert!(matches!(read("no/such/file.obj", &options), Err(ReadError::NotFound { .. })));
        assert!(matches!(read(env!("CARGO_MANIFEST_DIR"), &options), Err(ReadError::IsDirectory { .. })));
        let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
        let error = read(manifest, &options).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("{manifest}: cannot tell the format from the name; supported for reading: .obj")
        );
    }

    #[test]
    fn a_failed_write_keeps_what_was_there_and_leaves_nothing_beside() {
        let folder = std::env::temp_dir().join(format!("subsurf-io-write-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.ply");
        fs::write(&path, "kept").unwrap();
        let mut mesh = OutputMesh {
            positions: &[[f32::NAN; 3]; 3],
            sizes: FaceSizes::Uniform(3),
            corners: &[0, 1, 2],
            normals: None,
            texture: None,
            tags: None,
        };
        assert!(matches!(write(&path, &mesh), Err(WriteError::Mesh { .. })));
        assert_eq!(fs::read(&path).unwrap(), b"kept");
        assert!(matches!(write(&folder, &mesh), Err(WriteError::UnknownFormat { .. })));
        assert!(matches!(write(folder.join("none/a.ply"), &mesh), Err(WriteError::NoFolder { .. })));
        mesh.positions = &[[0.0; 3]; 3];
        write(&path, &mesh).unwrap();
        assert!(fs::read(&path).unwrap().starts_with(b"ply\n"));
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }
}
