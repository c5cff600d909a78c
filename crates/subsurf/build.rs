//! Sets `cfg(shared_data)` where the reference tables lie beside the repository; tests that read them are
//! reported as ignored elsewhere.

use std::path::Path;

fn main() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/golden");
    println!("cargo:rustc-check-cfg=cfg(shared_data)");
    println!("cargo:rerun-if-changed=build.rs");
    if golden.exists() {
        println!("cargo:rustc-cfg=shared_data");
    }
}
