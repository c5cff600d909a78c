//! The closed forms of Loop subdivision against brute-force subdivision round the location, on random triangle meshes and
//! all shapes.

mod brute_force;
mod random_mesh;

use brute_force::{Worst, check};
use random_mesh::{for_all, triangle_recipe};
use std::collections::BTreeSet;
use subsurf::shapes::Shape;
use subsurf::{Face, Location, Method, Scheme, shapes};

fn random_meshes(cases: u32, seed: u64, method: Method) {
    let worst = Worst::default();
    for_all(triangle_recipe(), cases, seed, |recipe| {
        let made = recipe.mesh();
        check(&made.mesh, Scheme::Loop, &made.positions, &recipe.locations(&made.mesh), method, &worst)
            .map_err(|e| format!("{e}\nfaces {:?}\ntags {:?}", made.mesh.faces().collect::<Vec<_>>(), made.mesh.tags()))
    });
    worst.print(&format!("{cases} random triangle meshes, {method:?}"));
}

#[test]
fn deflated_powers_give_the_limit_of_refinement_on_random_triangle_meshes() {
    random_meshes(150, 3, Method::Deflated);
}

#[test]
fn the_eigenbasis_gives_the_limit_of_refinement_on_random_triangle_meshes() {
    random_meshes(150, 4, Method::Eigenbasis);
}

#[test]
#[ignore = "minutes"]
fn the_limit_is_that_of_refinement_on_many_random_triangle_meshes() {
    for seed in 0..20 {
        random_meshes(1000, 200 + seed, if seed % 4 == 3 { Method::Eigenbasis } else { Method::Deflated });
    }
}

/// Corners, sides, the middle, deep at vertices and beside sides, and anywhere.
const PLACES: [(f64, f64); 13] = [
    (0.0, 0.0),
    (1.0, 0.0),
    (0.0, 1.0),
    (0.5, 0.5),
    (0.3, 0.0),
    (0.0, 0.7),
    (0.21, 0.37),
    (1e-12, 3e-12),
    (1.0 - 1e-7, 1e-8),
    (2e-4, 0.999),
    (0.4, 1e-3),
    (1e-5, 0.6),
    (0.45, 0.55 - 1e-4),
];

/// Checks one mesh at `places` on every face.
fn check_places(shape: &Shape, places: &[(f64, f64)], method: Method, worst: &Worst) {
    let at: Vec<Location> = (0..shape.mesh.face_count())
        .flat_map(|f| places.iter().map(move |&(u, v)| Location { face: Face::new(f), subface: 0, u, v }))
        .collect();
    check(&shape.mesh, Scheme::Loop, &shape.positions, &at, method, worst)
        .unwrap_or_else(|e| panic!("{}: {e}", shape.name));
}

/// True where no face visits a vertex twice and no two have the same vertices.
fn is_simple(shape: &Shape) -> bool {
    let mut known = BTreeSet::new();
    shape.mesh.faces().all(|face| {
        let vertices: BTreeSet<u32> = face.iter().copied().collect();
        vertices.len() == face.len() && known.insert(vertices)
    })
}

#[test]
fn the_limit_is_that_of_refinement_on_all_triangle_shapes() {
    let worst = Worst::default();
    for (k, shape) in shapes::all_triangles().iter().filter(|s| is_simple(s)).enumerate() {
        let (first, method) = (k % 13, if k % 2 == 0 { Method::Deflated } else { Method::Eigenbasis });
        // Three places a face, other ones from shape to shape.
        let places: Vec<(f64, f64)> = (0..3).map(|i| PLACES[(first + 5 * i) % 13]).collect();
        check_places(shape, &places, method, &worst);
    }
    worst.print("all triangle shapes");
}
