//! Ctrl-C while a file is being written: what is half done goes.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::Once;

/// Status of a program that an interrupt ended, as shells count it: 128 and the signal's number.
const INTERRUPTED: i32 = 130;

static ONCE: Once = Once::new();

/// From now on an interrupt removes the half-written file beside `path` and ends the program.
pub fn clean_up(path: &Path) {
    let path = path.to_owned();
    ONCE.call_once(|| {
        // Where no handler can be installed the file stays behind under its temporary name.
        let _ = ctrlc::set_handler(move || {
            temporaries(&path).iter().for_each(|file| drop(fs::remove_file(file)));
            process::exit(INTERRUPTED);
        });
    });
}

/// The files that this process writes beside `path` until they are complete.
fn temporaries(path: &Path) -> Vec<PathBuf> {
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let Some(name) = path.file_name() else { return Vec::new() };
    let mut prefix = OsString::from(".");
    prefix.push(name);
    prefix.push(format!(".tmp-{}-", process::id()));
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let is_ours = |file: &PathBuf| {
        let name = file.file_name().unwrap_or_default().as_encoded_bytes();
        name.starts_with(prefix.as_encoded_bytes())
    };
    entries.map(|entry| entry.path()).filter(is_ours).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_this_process_s_files_beside_the_path_are_found() {
        let folder = std::env::temp_dir().join(format!("subsurf-interrupt-{}", process::id()));
        fs::create_dir_all(&folder).unwrap();
        let ours = folder.join(format!(".a.obj.tmp-{}-0", process::id()));
        for file in [&ours, &folder.join(".a.obj.tmp-1-0"), &folder.join("a.obj.x"), &folder.join(".b.obj.tmp-2-0")] {
            fs::write(file, "").unwrap();
        }
        let folder_found = temporaries(&folder.join("a.obj"));
        assert_eq!(folder_found, [ours]);
        fs::remove_dir_all(&folder).unwrap();
    }
}
