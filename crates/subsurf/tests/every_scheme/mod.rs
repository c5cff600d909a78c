//! Laws that hold under every scheme: checked on all shapes and on random meshes.

use crate::random_mesh::{Mesh, for_all, recipe};
use subsurf::shapes;
use subsurf::{ControlMesh, Scheme, Tags};

pub type Law = fn(&ControlMesh, &[[f64; 3]], Scheme) -> Result<(), String>;

/// Checks a law on all shapes and on as many random meshes, which the seed tells, under all schemes.
pub fn everywhere(cases: u32, seed: u64, law: Law) {
    let quads = shapes::all().into_iter().chain(shapes::tagged());
    let triangles = || shapes::all_triangles().into_iter().chain([shapes::pillow()]);
    for shape in quads.chain(triangles()) {
        for scheme in [Scheme::CatmullClark, Scheme::Bilinear] {
            law(&shape.mesh, &shape.positions, scheme).unwrap_or_else(|e| panic!("{} {scheme:?}: {e}", shape.name));
        }
    }
    for shape in triangles() {
        law(&shape.mesh, &shape.positions, Scheme::Loop).unwrap_or_else(|e| panic!("{} Loop: {e}", shape.name));
    }
    for_all(recipe(), cases, seed, |recipe| {
        let Mesh { mesh, positions } = recipe.mesh();
        law(&mesh, &positions, Scheme::CatmullClark)?;
        law(&mesh, &positions, Scheme::Bilinear)?;
        law(&triangulated(&mesh), &positions, Scheme::Loop).map_err(|e| format!("Loop: {e}"))
    });
}

/// The mesh with its faces cut into triangles from their first corners, every third one a hole where it has holes.
fn triangulated(mesh: &ControlMesh) -> ControlMesh {
    let fan = |face: &[u32]| (1..face.len() - 1).map(|i| [face[0], face[i], face[i + 1]]).collect::<Vec<_>>();
    let faces: Vec<[u32; 3]> = mesh.faces().flat_map(fan).collect();
    let holes = if mesh.tags().holes.is_empty() { 0 } else { faces.len() as u32 };
    let tags = Tags { holes: (0..holes).step_by(3).collect(), ..mesh.tags().clone() };
    ControlMesh::from_counts(mesh.vertex_count(), &vec![3; faces.len()], faces.concat(), tags).unwrap()
}
