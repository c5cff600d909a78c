//! Compiles OpenSubdiv's CPU parts (sdc, vtr, far, bfr) and our C interface to them into one static library.
//!
//! The sources are those of `OPENSUBDIV_SOURCE` (a folder that contains `opensubdiv/version.h`), or else the ones
//! vendored in the crate `opensubdiv-petite-sys`.

use std::path::{Path, PathBuf};
use std::process::Command;

const SHIMS: [&str; 4] = ["shim/opensubdiv.cpp", "shim/surface.cpp", "shim/face_varying.cpp", "shim/adaptive.cpp"];

fn main() {
    println!("cargo:rerun-if-changed=shim");
    println!("cargo:rerun-if-env-changed=OPENSUBDIV_SOURCE");
    let root = match std::env::var_os("OPENSUBDIV_SOURCE") {
        Some(folder) => PathBuf::from(folder),
        None => vendored(),
    };
    assert!(
        root.join("opensubdiv/version.h").exists(),
        "no OpenSubdiv sources in {}: set OPENSUBDIV_SOURCE to a folder that contains opensubdiv/version.h",
        root.display()
    );

    let mut build = cc::Build::new();
    build.cpp(true).std("c++14").opt_level(2).include(&root).warnings(false).files(SHIMS);
    if std::env::var_os("CARGO_FEATURE_ASSERTS").is_none() {
        build.define("NDEBUG", None);
    }
    build.file(root.join("opensubdiv/version.cpp"));
    for part in ["sdc", "vtr", "far", "bfr"] {
        for source in sources(&root.join("opensubdiv").join(part)) {
            build.file(source);
        }
    }
    build.compile("peer_opensubdiv");
}

/// The folder of the vendored sources. `cargo metadata` downloads the package if need be.
fn vendored() -> PathBuf {
    let manifest = Path::new(&std::env::var_os("CARGO_MANIFEST_DIR").unwrap()).join("Cargo.toml");
    let output = Command::new(std::env::var_os("CARGO").unwrap())
        .args(["metadata", "--format-version", "1", "--locked", "--manifest-path"])
        .arg(&manifest)
        .output()
        .expect("cargo metadata runs");
    assert!(
        output.status.success(),
        "OpenSubdiv's sources come from the crate opensubdiv-petite-sys, which could not be fetched (without network, \
         set OPENSUBDIV_SOURCE to a folder that contains opensubdiv/version.h):\n{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("cargo metadata prints JSON");
    let package = metadata["packages"]
        .as_array()
        .into_iter()
        .flatten()
        .find(|p| p["name"] == "opensubdiv-petite-sys")
        .expect("Cargo.toml names opensubdiv-petite-sys");
    Path::new(package["manifest_path"].as_str().unwrap()).with_file_name("OpenSubdiv")
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap_or_else(|e| panic!("{}: {e}", folder.display()))
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "cpp"))
        .collect();
    files.sort();
    files
}
