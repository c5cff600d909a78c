//! Files that appear whole or not at all: written beside their place under another name, renamed when complete.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU32, Ordering};

/// A file being written. [`commit`](Self::commit) puts it in its place; dropping it before removes it.
///
/// A symbolic link stays and its target is replaced, with the permissions it had. What is no regular file, such as a
/// pipe or a device, is written directly.
#[derive(Debug)]
pub struct AtomicFile {
    file: File,
    /// Where the text goes now and where it belongs; `None` when written directly or already in place.
    pending: Option<(PathBuf, PathBuf)>,
}

/// Tells apart the files that one process writes at a time.
static COUNTER: AtomicU32 = AtomicU32::new(0);

impl AtomicFile {
    /// Starts to write the file at `path`.
    ///
    /// # Errors
    /// If `path` is a folder or write-protected, or its folder is missing or cannot be written.
    pub fn create(path: &Path) -> io::Result<Self> {
        let existing = match fs::metadata(path) {
            Ok(metadata) => Some(metadata),
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            Err(error) => return Err(error),
        };
        let target = match &existing {
            Some(metadata) if metadata.is_dir() => return Err(ErrorKind::IsADirectory.into()),
            Some(metadata) if !metadata.is_file() => {
                let file = OpenOptions::new().write(true).open(path)?;
                return Ok(Self { file, pending: None });
            }
            Some(metadata) if metadata.permissions().readonly() => return Err(ErrorKind::PermissionDenied.into()),
            Some(_) => fs::canonicalize(path)?,
            None => path.to_owned(),
        };
        let Some(name) = target.file_name() else { return Err(ErrorKind::IsADirectory.into()) };
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".tmp-{}-{}", process::id(), COUNTER.fetch_add(1, Ordering::Relaxed)));
        let temporary = target.with_file_name(hidden);
        let file = OpenOptions::new().write(true).create_new(true).open(&temporary)?;
        let this = Self { file, pending: Some((temporary, target)) };
        if let Some(metadata) = existing {
            this.file.set_permissions(metadata.permissions())?;
        }
        Ok(this)
    }

    /// Puts the complete file in its place.
    ///
    /// # Errors
    /// If the system refuses; then nothing is left.
    pub fn commit(mut self) -> io::Result<()> {
        self.file.flush()?;
        if let Some((temporary, target)) = &self.pending {
            fs::rename(temporary, target)?;
            self.pending = None;
        }
        Ok(())
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if let Some((temporary, _)) = &self.pending {
            // Nothing can be done about a file that will not go.
            let _ = fs::remove_file(temporary);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An empty folder that goes with the test.
    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("subsurf-io-{name}-{}", process::id()));
            fs::create_dir_all(&path).unwrap();
            Self(path)
        }

        fn names(&self) -> Vec<String> {
            let names = fs::read_dir(&self.0).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
            let mut names: Vec<_> = names.collect();
            names.sort();
            names
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            fs::remove_dir_all(&self.0).unwrap();
        }
    }

    #[test]
    fn a_file_appears_when_committed_and_replaces_what_was_there() {
        let folder = Folder::new("commit");
        let path = folder.0.join("a.obj");
        fs::write(&path, "old").unwrap();
        let mut file = AtomicFile::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        file.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(folder.names(), ["a.obj"]);
    }

    #[test]
    fn a_dropped_file_leaves_nothing() {
        let folder = Folder::new("drop");
        let mut file = AtomicFile::create(&folder.0.join("a.obj")).unwrap();
        file.write_all(b"half").unwrap();
        drop(file);
        assert!(folder.names().is_empty());
    }

    #[test]
    fn folders_and_protected_files_are_refused() {
        let folder = Folder::new("refuse");
        assert_eq!(AtomicFile::create(&folder.0).unwrap_err().kind(), ErrorKind::IsADirectory);
        let missing = folder.0.join("none").join("a.obj");
        assert_eq!(AtomicFile::create(&missing).unwrap_err().kind(), ErrorKind::NotFound);
        let path = folder.0.join("a.obj");
        fs::write(&path, "kept").unwrap();
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        assert_eq!(AtomicFile::create(&path).unwrap_err().kind(), ErrorKind::PermissionDenied);
        assert_eq!(folder.names(), ["a.obj"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_links_and_devices_are_written_directly() {
        let folder = Folder::new("link");
        let (path, link) = (folder.0.join("a.obj"), folder.0.join("link.obj"));
        fs::write(&path, "old").unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        let mut file = AtomicFile::create(&link).unwrap();
        file.write_all(b"new").unwrap();
        file.commit().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"new");
        let mut null = AtomicFile::create(Path::new("/dev/null")).unwrap();
        null.write_all(b"gone").unwrap();
        null.commit().unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
