//! Compiles OpenSubdiv's CPU parts (sdc, vtr, far, bfr, and of osd the CPU evaluator) and our C interface to them into
//! one static library.
//!
//! The sources are those of `OPENSUBDIV_SOURCE` (a folder that contains `opensubdiv/version.h`), or else the ones
//! vendored in the crate `opensubdiv-petite-sys`. Embree is linked where its header is found; `EMBREE_ROOT` names
//! another folder than `/usr` or `/usr/local` that has `include` and `lib`.

use std::path::{Path, PathBuf};
use std::process::Command;

const SHIMS: [&str; 8] = [
    "shim/opensubdiv.cpp",
    "shim/surface.cpp",
    "shim/face_varying.cpp",
    "shim/adaptive.cpp",
    "shim/clock.cpp",
    "shim/uniform.cpp",
    "shim/patches.cpp",
    "shim/faces.cpp",
];
const OSD: [&str; 3] = ["cpuEvaluator.cpp", "cpuKernel.cpp", "cpuPatchTable.cpp"];
/// As a release of OpenSubdiv is built: by CMake's release configuration, for every processor of the architecture.
const OPTIMIZATION: u32 = 3;

fn main() {
    println!("cargo:rerun-if-changed=shim");
    println!("cargo:rerun-if-env-changed=OPENSUBDIV_SOURCE");
    println!("cargo:rerun-if-env-changed=EMBREE_ROOT");
    println!("cargo:rustc-check-cfg=cfg(embree)");
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
    build.cpp(true).std("c++14").opt_level(OPTIMIZATION).include(&root).warnings(false).files(SHIMS);
    build.inherit_rustflags(false).force_frame_pointer(false);
    let asserts = std::env::var_os("CARGO_FEATURE_ASSERTS").is_some();
    if !asserts {
        build.define("NDEBUG", None);
    }
    build.file(root.join("opensubdiv/version.cpp"));
    for part in ["sdc", "vtr", "far", "bfr"] {
        for source in sources(&root.join("opensubdiv").join(part)) {
            build.file(source);
        }
    }
    build.files(OSD.map(|file| root.join("opensubdiv/osd").join(file)));
    let embree = embree();
    if let Some((root, major)) = &embree {
        if root != Path::new("/usr") {
            build.include(root.join("include"));
        }
        build.define("EMBREE_MAJOR", major.to_string().as_str()).file("shim/embree.cpp");
        println!("cargo:rustc-cfg=embree");
    }
    build.compile("peer_opensubdiv");
    if let Some((root, major)) = &embree {
        println!("cargo:rustc-link-search=native={}", root.join("lib").display());
        println!("cargo:rustc-link-lib=dylib=embree{major}");
    }

    let compiler = build.get_compiler();
    println!("cargo:rustc-env=PEERS_CXX={}", first_line(compiler.path()));
    let extra = std::env::var("CXXFLAGS").unwrap_or_default();
    let flags = format!("-O{OPTIMIZATION}{} {extra}", if asserts { "" } else { " -DNDEBUG" });
    println!("cargo:rustc-env=PEERS_CXX_FLAGS={}", flags.trim());
    println!("cargo:rustc-env=PEERS_RUSTC={}", first_line(Path::new(&std::env::var_os("RUSTC").unwrap())));
}

/// The folder that has Embree's `include` and `lib`, and its major version: the newest there is.
fn embree() -> Option<(PathBuf, u32)> {
    let root = std::env::var_os("EMBREE_ROOT").map(PathBuf::from);
    let roots: Vec<PathBuf> = root.into_iter().chain(["/usr/local", "/usr"].map(PathBuf::from)).collect();
    let found = |major: u32| {
        let header = format!("include/embree{major}/rtcore.h");
        roots.iter().find(|root| root.join(&header).exists()).map(|root| (root.clone(), major))
    };
    found(4).or_else(|| found(3))
}

/// What a compiler says of its version.
fn first_line(compiler: &Path) -> String {
    let output = Command::new(compiler).arg("--version").output();
    let text = output.map(|o| String::from_utf8_lossy(&o.stdout).into_owned()).unwrap_or_default();
    text.lines().next().unwrap_or("unknown").to_string()
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
