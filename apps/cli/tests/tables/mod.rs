//! Meshes whose patch tables are counted and weighed.

use std::path::Path;
use subsurf::{ControlMesh, PatchTable, Scheme, Tags};

/// A mesh of the project's own assets.
pub fn asset(name: &str) -> ControlMesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets").join(name);
    subsurf_io::read(&path, &subsurf_io::ReadOptions::default()).unwrap().mesh
}

/// A torus of `n` by `n` quads.
pub fn torus(n: u32) -> ControlMesh {
    let at = |i: u32, j: u32| i % n * n + j % n;
    let faces = (0..n * n).map(|f| (f / n, f % n));
    let corners = faces.flat_map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect();
    ControlMesh::from_counts((n * n) as usize, &vec![4; (n * n) as usize], corners, Tags::default()).unwrap()
}

/// Its patch table.
pub fn table(mesh: &ControlMesh) -> PatchTable {
    PatchTable::new(mesh, Scheme::CatmullClark).unwrap()
}
