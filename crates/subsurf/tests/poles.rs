//! Vertices with hundreds of faces: exact as any other, and in cost no worse than the square of their valence.

mod brute_force;
mod random_mesh;

use brute_force::{Soup, apart, diagonal};
use random_mesh::{Base, random_points};
use subsurf::{
    Boundary, ControlMesh, Corner, Crease, Derivatives, Face, LimitStencilTable, Location, MOST_POLE_BYTES, MeshError,
    Method, PatchTable, Pole, Rates, Rules, Scheme, TableSize, Tags, TessellateOptions,
};

fn mesh(base: Base, tags: Tags) -> ControlMesh {
    ControlMesh::new(&base.faces(), tags).unwrap()
}

/// Places at the pole, which is corner 0: the pole itself, deep beside it, and away from it.
const PLACES: [(f64, f64); 6] = [(0.0, 0.0), (1e-12, 2e-12), (0.0, 1e-6), (1e-3, 2e-4), (0.5, 0.5), (0.9, 0.95)];

/// Checks a few faces round the pole against brute force, in positions and derivatives.
fn is_exact(what: &str, mesh: &ControlMesh, faces: &[u32]) {
    let points = random_points(mesh.vertex_count(), 3);
    let soup = Soup::new(mesh, Scheme::CatmullClark, &points);
    let table = PatchTable::with_method(mesh, Scheme::CatmullClark, Method::Deflated).unwrap();
    let surface = table.surface(&points);
    let single: Vec<[f32; 3]> = points.iter().map(|p| p.map(|x| x as f32)).collect();
    let box_size = diagonal(&points);
    let mut worst = [0.0f64; 4];
    for (k, &(u, v)) in PLACES.iter().enumerate() {
        let at = Location { face: Face(faces[k % faces.len()]), subface: 0, u, v };
        let (jet, truth) = (surface.eval_second(at).unwrap(), soup.eval(at).unwrap());
        let mut errors = [apart(jet.position, truth.position) / box_size, 0.0, 0.0, 0.0];
        if let Some(second) = jet.second {
            [errors[1], errors[2]] = truth.derivative_errors(jet.du, jet.dv, second);
        }
        let rounded = table.surface(&single).position(at).unwrap().map(|x| f64::from(x as f32));
        errors[3] = apart(rounded, truth.position) / box_size;
        // The bounds of the smaller valences hold: the masks of a pole are sums of more, smaller terms.
        for (error, bound) in errors.iter().zip([1e-12, 1e-10, 1e-8, 1e-6]) {
            assert!(*error <= bound, "{what}, {at:?}: errors {errors:?}");
        }
        (0..4).for_each(|k| worst[k] = worst[k].max(errors[k]));
    }
    println!(
        "{what}: position {:.1e}, first {:.1e}, second {:.1e}, f32 {:.1e}",
        worst[0], worst[1], worst[2], worst[3]
    );
}

#[test]
fn a_pole_of_100_quads_is_exact() {
    is_exact("100 quads", &mesh(Base::Fan(100, 2), Tags::default()), &[0, 4, 396]);
}

#[test]
fn a_pole_of_360_quads_is_exact() {
    is_exact("360 quads", &mesh(Base::Fan(360, 1), Tags::default()), &[0, 77]);
}

#[test]
fn a_pole_of_360_triangles_is_exact() {
    is_exact("360 triangles", &mesh(Base::Umbrella(360), Tags::default()), &[0, 359]);
}

#[test]
fn a_boundary_vertex_of_100_faces_is_exact() {
    let sector = Base::Sector(100, 1);
    is_exact("boundary of 100", &mesh(sector, Tags::default()), &[0, 1, 50, 99]);
    let pinned = Tags { corners: vec![Corner::new(0, 10.0)], ..Tags::default() };
    is_exact("corner of 100", &mesh(sector, pinned), &[0, 49, 99]);
    let rules = Rules { boundary: Boundary::EdgeOnly, ..Rules::default() };
    is_exact(
        "semi-sharp corner of 100",
        &{
            let corners = vec![Corner::new(0, 1.5)];
            mesh(sector, Tags { corners, rules, ..Tags::default() })
        },
        &[0, 99],
    );
}

#[test]
fn a_dart_of_valence_100_is_exact() {
    let dart = |s| mesh(Base::Fan(100, 1), Tags { creases: vec![Crease::new(0, 1, s)], ..Tags::default() });
    is_exact("dart of 100", &dart(10.0), &[0, 1, 50, 99]);
    is_exact("semi-sharp dart of 100", &dart(1.5), &[0, 99]);
}

#[test]
fn sectors_whose_rings_have_no_matrices_are_exact() {
    let sector = Base::Sector(200, 1);
    is_exact("boundary of 200", &mesh(sector, Tags::default()), &[0, 2, 100, 199]);
    let pinned = Tags { corners: vec![Corner::new(0, 10.0)], ..Tags::default() };
    is_exact("corner of 200", &mesh(sector, pinned), &[0, 99, 197]);
    let dart = Tags { creases: vec![Crease::new(0, 1, 10.0)], ..Tags::default() };
    is_exact("dart of 200", &mesh(Base::Fan(200, 1), dart), &[0, 1, 100, 198]);
}

/// Poles whose rings are too large for matrices, and a few faces there.
fn wide_poles() -> Vec<(&'static str, Scheme, ControlMesh, Vec<u32>)> {
    let crease = |ends: &[u32], s: f64| ends.iter().map(|&e| Crease::new(0, e, s)).collect();
    let creases = |ends: &[u32], s: f64| Tags { creases: crease(ends, s), ..Tags::default() };
    let pinned = Tags { corners: vec![Corner::new(0, 10.0)], ..Tags::default() };
    let (quads, triangles) = (Scheme::CatmullClark, Scheme::Loop);
    let (fan, umbrella) = (Base::Fan(200, 2), Base::Umbrella(300));
    vec![
        ("quads", quads, mesh(fan, Tags::default()), vec![0, 4, 400]),
        ("two creases", quads, mesh(fan, creases(&[1, 201], 10.0)), vec![0, 4, 200, 396]),
        ("a semi-sharp dart", quads, mesh(fan, creases(&[1], 1.5)), vec![0, 4, 8, 796]),
        ("pinned", quads, mesh(fan, pinned.clone()), vec![0, 40]),
        ("triangles in quads", quads, mesh(umbrella, Tags::default()), vec![0, 299]),
        ("triangles", triangles, mesh(umbrella, Tags::default()), vec![0, 1, 299]),
        ("a dart of triangles", triangles, mesh(umbrella, creases(&[1], 10.0)), vec![0, 1, 150, 299]),
        ("two creases of triangles", triangles, mesh(umbrella, creases(&[1, 151], 10.0)), vec![0, 75, 149, 150]),
        ("pinned triangles", triangles, mesh(umbrella, pinned), vec![0, 7]),
    ]
}

#[test]
fn values_at_a_pole_are_what_weights_give() {
    let places = [(0.0, 0.0), (0.0, 1e-6), (1e-3, 2e-4), (0.3, 0.1), (0.25, 0.5), (0.0, 0.6), (0.5, 0.5), (3e-9, 1e-9)];
    for (what, scheme, mesh, faces) in wide_poles() {
        let points = random_points(mesh.vertex_count(), 5);
        let table = PatchTable::new(&mesh, scheme).unwrap();
        let surface = table.surface(&points);
        let at = |&face: &u32| places.map(|(u, v)| Location { face: Face(face), subface: 0, u, v });
        let at: Vec<Location> = faces.iter().flat_map(at).collect();
        let stencils = LimitStencilTable::<f64>::new(&table, &at).unwrap();
        for (i, (place, [position, du, dv])) in at.iter().zip(stencils.frames(&points)).enumerate() {
            let jet = surface.eval(*place).unwrap();
            assert!(apart(jet.position, position) < 1e-13, "{what} {place:?}");
            let Some(normal) = jet.normal() else { continue };
            let size = du.iter().chain(&dv).fold(0.0, |m: f64, x| m.max(x.abs()));
            if stencils.derivatives(i) == Some(Derivatives::Finite) {
                // A few hundred roundings, and up to thirty levels.
                let is_near = [(jet.du, du), (jet.dv, dv)].iter().all(|&(a, b)| apart(a, b) < 1e-11 * size);
                assert!(is_near, "{what} {place:?}");
            }
            let cross = [0, 1, 2].map(|k| {
                let (a, b) = ((k + 1) % 3, (k + 2) % 3);
                du[a] * dv[b] - du[b] * dv[a]
            });
            let length = cross.iter().map(|x| x * x).sum::<f64>().sqrt();
            // What is lost where derivatives are nearly parallel.
            let thin = size * size / length;
            assert!(apart(normal, cross.map(|x| x / length)) < 1e-11 * thin, "{what} {place:?}");
        }
    }
}

#[test]
fn tessellations_of_a_pole_lie_on_the_surface() {
    let options = TessellateOptions { rates: Rates::Uniform(6), places: true, ..TessellateOptions::default() };
    for (what, scheme, mesh, faces) in wide_poles() {
        let points = random_points(mesh.vertex_count(), 5);
        let table = PatchTable::new(&mesh, scheme).unwrap();
        let surface = table.surface(&points);
        let whole = surface.tessellate(&options).unwrap();
        let places = whole.places.as_ref().unwrap();
        for (f, &(face, subface)) in places.facet.iter().enumerate().filter(|(_, at)| faces.contains(&at.0)) {
            for c in whole.face_offsets[f] as usize..whole.face_offsets[f + 1] as usize {
                let [u, v] = places.corner_uv[c];
                let jet = surface.eval(Location { face: Face(face), subface, u, v }).unwrap();
                assert!(apart(jet.position, whole.positions[whole.corners[c] as usize]) < 1e-13, "{what} {u} {v}");
                let normals = if whole.normal_corners.is_empty() { &whole.corners } else { &whole.normal_corners };
                let Some(normal) = jet.normal().filter(|_| jet.derivatives == Derivatives::Finite) else { continue };
                let size = |d: [f64; 3]| d.iter().map(|x| x * x).sum::<f64>().sqrt();
                let thin = (size(jet.du) / size(jet.dv)).max(size(jet.dv) / size(jet.du));
                assert!(apart(normal, whole.normals[normals[c] as usize]) < 1e-10 * thin, "{what} {face} {u} {v}");
            }
        }
    }
}

fn table_size(n: u32) -> TableSize {
    PatchTable::new(&mesh(Base::Fan(n, 2), Tags::default()), Scheme::CatmullClark).unwrap().size()
}

#[test]
fn memory_for_a_pole_grows_no_worse_than_the_square_of_its_valence() {
    let bytes = [50, 100, 200, 400].map(|n| {
        let size = table_size(n);
        (size.patch_bytes + size.plan_bytes) as f64
    });
    for pair in bytes.windows(2) {
        // Four for the square; the rest for what does not grow.
        assert!(pair[1] / pair[0] <= 4.2, "bytes {bytes:?}");
    }
}

#[test]
fn a_pole_of_any_valence_has_few_plans() {
    // Its own faces look alike, and so do the rings further out: what costs is one ring per face.
    let [small, large] = [100, 400].map(table_size);
    assert_eq!(small.plans, large.plans);
}

#[test]
fn a_pole_whose_rings_do_not_fit_is_refused_without_a_walk_round_it_per_face() {
    // A walk per face, of as many steps as there are faces, would be 40 billion steps.
    let umbrella = mesh(Base::Umbrella(200_000), Tags::default());
    for scheme in [Scheme::CatmullClark, Scheme::Loop] {
        let error = PatchTable::new(&umbrella, scheme).map(|_| ()).unwrap_err();
        let MeshError::PoleTooLarge { pole, bytes, limit } = error else { panic!("{error}") };
        assert_eq!((pole, limit), (Pole::Vertex { vertex: 0, faces: 200_000 }, MOST_POLE_BYTES));
        assert!(bytes > limit && error.to_string().contains("has 200000 faces"), "{error}");
    }
}

#[test]
#[ignore = "a measurement; run it in release"]
fn build_times_and_memory_of_poles() {
    println!("valence  build ms  plans  patch bytes  plan bytes");
    for n in [45, 90, 180, 360, 720] {
        let mesh = mesh(Base::Fan(n, 2), Tags::default());
        let mut times: Vec<f64> = (0..5)
            .map(|_| {
                let start = std::time::Instant::now();
                std::hint::black_box(PatchTable::new(&mesh, Scheme::CatmullClark).unwrap());
                start.elapsed().as_secs_f64() * 1e3
            })
            .collect();
        times.sort_by(f64::total_cmp);
        let size = table_size(n);
        println!("{n:7} {:9.2} {:6} {:12} {:11}", times[2], size.plans, size.patch_bytes, size.plan_bytes);
    }
}
