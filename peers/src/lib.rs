//! Other implementations of subdivision surfaces beside ours: reference numbers, comparison.

pub mod adaptive;
pub mod compare_adaptive;
pub mod compare_refine;
pub mod conformance;
pub mod dump_channels;
pub mod dump_limits;
pub mod dump_reference;
pub mod opensubdiv;
pub mod performance;
pub mod random_shapes;
pub mod shape;

use std::path::{Path, PathBuf};

/// OpenSubdiv's regression shapes: the folder that `OPENSUBDIV_SHAPES` names, or else one beside the repository.
pub fn shapes_folder() -> PathBuf {
    if let Some(folder) = std::env::var_os("OPENSUBDIV_SHAPES") {
        return PathBuf::from(folder);
    }
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/models/opensubdiv_shapes")
}
