//! Sets `shared_models` when the folder of production models lies beside the repository, so that the tests over them
//! run there and are reported as ignored elsewhere.

use std::path::Path;

fn main() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/models");
    println!("cargo:rustc-check-cfg=cfg(shared_models)");
    println!("cargo:rerun-if-changed=build.rs");
    if models.is_dir() {
        println!("cargo:rerun-if-changed={}", models.display());
        println!("cargo:rustc-cfg=shared_models");
    }
}
