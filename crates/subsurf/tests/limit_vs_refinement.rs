//! The closed forms of Catmull-Clark subdivision against brute-force subdivision round the location, on random meshes and all shapes.

mod brute_force;
mod random_mesh;

use brute_force::compare::{Worst, check};
use random_mesh::{Recipe, for_all, random_points, recipe};
use std::collections::HashSet;
use subsurf::shapes::Shape;
use subsurf::{ControlMesh, Corner, Crease, Creasing, Face, Location, Method, Scheme, Tags, shapes};

fn check_recipe(recipe: &Recipe, method: Method, worst: &Worst) -> Result<(), String> {
    let made = recipe.mesh();
    check(&made.mesh, Scheme::CatmullClark, &made.positions, &recipe.locations(&made.mesh), method, worst)
        .map_err(|e| format!("{e}\nfaces {:?}\ntags {:?}", made.mesh.faces().collect::<Vec<_>>(), made.mesh.tags()))
}

fn random_meshes(cases: u32, seed: u64, method: Method) {
    let worst = Worst::default();
    for_all(recipe(), cases, seed, |recipe| check_recipe(recipe, method, &worst));
    worst.print(&format!("{cases} random meshes, {method:?}"));
}

#[test]
fn deflated_powers_give_the_limit_of_refinement_on_random_meshes() {
    random_meshes(250, 1, Method::Deflated);
}

#[test]
fn the_eigenbasis_gives_the_limit_of_refinement_on_random_meshes() {
    random_meshes(250, 2, Method::Eigenbasis);
}

/// All shapes at fixed places: corners, edges, middle lines, deep at vertices and anywhere.
#[test]
fn the_limit_is_that_of_refinement_on_all_shapes() {
    const PLACES: [(f64, f64); 9] = [
        (0.0, 0.0),
        (0.5, 0.5),
        (1.0, 0.3),
        (0.7, 0.0),
        (0.37, 0.81),
        (1e-12, 3e-12),
        (1.0 - 1e-7, 1e-8),
        (0.999, 1.0 - 2e-4),
        (1e-5, 0.9999),
    ];
    let worst = Worst::default();
    for shape in shapes::all().iter().filter(|s| s.mesh.faces().all(visits_no_vertex_twice)) {
        for (k, method) in [Method::Deflated, Method::Eigenbasis].into_iter().enumerate() {
            let faces = (0..shape.mesh.face_count()).step_by(1 + shape.mesh.face_count() / 40);
            let at: Vec<Location> = faces
                .flat_map(|f| {
                    let sides = shape.mesh.face_vertices(f).len();
                    let subfaces = if sides == 4 { 1 } else { sides as u32 };
                    // Each face at three places, other ones from face to face and method to method.
                    (0..subfaces).flat_map(move |subface| {
                        (0..3).map(move |i| {
                            let (u, v) = PLACES[(f + subface as usize + 3 * i + k) % 9];
                            Location { face: Face::new(f), subface, u, v }
                        })
                    })
                })
                .collect();
            check(&shape.mesh, Scheme::CatmullClark, &shape.positions, &at, method, &worst)
                .unwrap_or_else(|e| panic!("{}: {e}", shape.name));
        }
    }
    worst.print("all shapes");
}

fn visits_no_vertex_twice(face: &[u32]) -> bool {
    face.iter().collect::<HashSet<_>>().len() == face.len()
}

/// Checks one mesh at every corner of every face, in the middle and deep at the corners.
fn check_everywhere(shape: &Shape) {
    let at: Vec<Location> = (0..shape.mesh.face_count())
        .flat_map(|f| {
            let sides = shape.mesh.face_vertices(f).len();
            let subfaces = if sides == 4 { 1 } else { sides as u32 };
            let places = [0.0, 1e-6, 0.5, 0.8, 1.0].map(|u| [0.0, 2e-6, 0.3, 1.0].map(|v| (u, v))).concat();
            (0..subfaces).flat_map(move |subface| {
                places.clone().into_iter().map(move |(u, v)| Location { face: Face::new(f), subface, u, v })
            })
        })
        .collect();
    for method in [Method::Deflated, Method::Eigenbasis] {
        check(&shape.mesh, Scheme::CatmullClark, &shape.positions, &at, method, &Worst::default())
            .unwrap_or_else(|e| panic!("{}: {e}", shape.name));
    }
}

fn creases(list: &[(u32, u32, f64)]) -> Tags {
    Tags { creases: list.iter().map(|&(a, b, s)| Crease::new(a, b, s)).collect(), ..Tags::default() }
}

/// A fraction stays fully sharp under Chaikin's rule while both its halves do, so that the limit at one end depends on
/// the creases at the other, beyond the faces round the vertex.
#[test]
fn a_fraction_under_chaikin_sees_the_creases_at_both_ends() {
    for beyond in [0.0, 4.0] {
        let mut tags = creases(&[(11, 12, 0.25), (12, 13, 9.0), (10, 11, beyond)]);
        tags.rules.creasing = Creasing::Chaikin;
        check_everywhere(&shapes::grid(4, 4).tagged(format!("crease {beyond} beyond a fraction"), tags));
    }
}

#[test]
fn the_eigenbasis_takes_pinned_vertices_of_any_valence() {
    for n in [2, 3, 4, 5, 9] {
        let tags = Tags { corners: vec![Corner::new(0, 10.0)], ..Tags::default() };
        check_everywhere(&shapes::interior_vertex(n).tagged(format!("pinned valence {n}"), tags));
    }
}

/// Sharp edges of one sheet shape the others through their common vertex, whether they decay or not.
#[test]
fn creases_on_one_sheet_of_several_are_seen_by_the_others() {
    for (s, t) in [(10.0, 0.0), (2.5, 0.0), (0.75, 10.0), (1.5, 3.25)] {
        let tags = creases(&[(1, 4, s), (1, 10, t)]);
        check_everywhere(&shapes::three_sheets().tagged(format!("creases {s} and {t} across sheets"), tags));
    }
}

/// The same where the common vertex is pinned: Chaikin's averages go over all its edges.
#[test]
fn chaikin_averages_at_a_pinned_vertex_go_over_all_sheets() {
    let mut tags = creases(&[(1, 4, 2.5), (1, 10, 0.75)]);
    tags.corners.push(Corner::new(1, 10.0));
    tags.rules.creasing = Creasing::Chaikin;
    check_everywhere(&shapes::three_sheets().tagged("Chaikin across sheets", tags));
}

/// Face 0 meets the faces on both sides of the semi-sharp edge 1-3 through vertex 1, but at vertex 3 they are another sheet.
#[test]
fn a_sheet_that_is_met_through_another_corner_is_still_another_sheet() {
    let faces = vec![vec![1, 0, 3, 2], vec![3, 1, 2], vec![1, 3, 0], vec![2, 3, 0]];
    let tags = creases(&[(1, 3, 3.0)]);
    let mesh = ControlMesh::new(&faces, tags).unwrap();
    check_everywhere(&Shape { name: "sheets that meet twice".to_owned(), mesh, positions: random_points(4, 7) });
}

/// A crease one row from the boundary, from an infinite crease and from another one, along which the closed form of a
/// single crease holds or does not.
#[test]
fn creases_one_row_from_boundaries_and_other_creases_are_exact() {
    let row = |y: u32, s: f64| (0..5u32).map(move |x| (y * 6 + x, y * 6 + x + 1, s));
    for s in [0.3, 1.0, 2.5, 9.99] {
        for rows in [vec![(1, s)], vec![(1, s), (2, s)], vec![(1, s), (2, 10.0)], vec![(1, s), (2, 0.5 * s)]] {
            let tags = creases(&rows.iter().flat_map(|&(y, s)| row(y, s)).collect::<Vec<_>>());
            let height = if rows.len() == 1 { 2 } else { 3 };
            check_everywhere(&shapes::grid(5, height).tagged(format!("creases along rows {rows:?}"), tags));
        }
    }
}

/// Ends of creases, creases through extraordinary vertices, creases of different sharpness that meet and semi-sharp corners,
/// at both sides of every whole number: the ways down pass the same node as often as the sharpness says.
#[test]
fn special_semi_sharp_vertices_are_exact_at_every_sharpness() {
    for (s, n) in [(1.0, 3), (2.25, 5), (3.0, 3), (9.9, 5)] {
        let star = shapes::interior_vertex(n);
        let [first, second, across] = [1, 4, 7];
        let end = creases(&[(0, first, s)]);
        let through = creases(&[(0, first, s), (0, across, s)]);
        let meeting = creases(&[(0, first, s), (0, across, 0.5 * s + 0.125), (0, second, 10.0)]);
        let corner = Tags { corners: vec![Corner::new(0, s)], ..creases(&[(0, first, 1.75)]) };
        for (name, tags) in [("end", end), ("through", through), ("meeting", meeting), ("corner", corner)] {
            check_everywhere(&star.tagged(format!("{name} at valence {n}, sharpness {s}"), tags));
        }
    }
}

#[test]
#[ignore = "minutes"]
fn the_limit_is_that_of_refinement_on_many_random_meshes() {
    for seed in 0..20 {
        random_meshes(1000, 100 + seed, if seed % 4 == 3 { Method::Eigenbasis } else { Method::Deflated });
    }
}
