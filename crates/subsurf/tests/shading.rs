//! Laws of shading normals: what the blend weight is at extraordinary vertices, where fields part, and that nothing
//! depends on the number of threads.

use subsurf::shapes::{self, Shape};
use subsurf::{
    Averaging, Blend, Crease, Face, Location, NormalField, PatchTable, Power, Rates, Scheme, ShadingError,
    ShadingNormals, ShadingOptions, Tags, TessellateOptions,
};

const BLENDS: [Blend; 4] = [Blend::A1, Blend::A2, Blend::A3, Blend::A4];

fn with(field: NormalField) -> ShadingOptions {
    ShadingOptions { field, ..ShadingOptions::default() }
}

fn blend(blend: Blend) -> ShadingOptions {
    with(NormalField::Blended(blend))
}

fn table((shape, scheme): &(Shape, Scheme)) -> PatchTable {
    PatchTable::new(&shape.mesh, *scheme).unwrap()
}

/// A vertex of valence `n` whose first face is face 0, the vertex being its corner 0.
fn around(n: u32) -> [(Shape, Scheme); 2] {
    [(shapes::interior_vertex(n), Scheme::CatmullClark), (shapes::interior_triangles(n), Scheme::Loop)]
}

/// All shapes but the degenerate ones, whose limit normals are noise.
fn every_shape() -> Vec<(Shape, Scheme)> {
    let quads = shapes::all().into_iter().map(|s| (s, Scheme::CatmullClark));
    let all = quads.chain(shapes::all_triangles().into_iter().map(|s| (s, Scheme::Loop)));
    all.filter(|(s, _)| !s.name.starts_with("degenerate")).collect()
}

/// Some places of every face that is no hole, its corners included.
fn places(table: &PatchTable) -> Vec<Location> {
    let mut out = Vec::new();
    for f in (0..table.topology().face_count() as u32).map(Face).filter(|&f| !table.topology().is_hole(f)) {
        for subface in 0..table.subfaces(f) {
            for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (0.25, 0.0), (0.3, 0.6), (0.11, 0.07)] {
                out.push(Location { face: f, subface, u, v });
            }
        }
    }
    out
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn a2_is_the_vertex_s_own_limit_weight_and_a1_is_one() {
    for n in [3, 5, 7, 12] {
        for case in around(n) {
            let patches = table(&case);
            let at = Location::new(0, 0.0, 0.0);
            let b = |kind| ShadingNormals::new(&patches, &case.0.positions, &blend(kind)).unwrap().blend_weight(at);
            let x = f64::from(n);
            // Halstead, Kass, DeRose 1993; Loop 1987.
            let beta = (0.625 - (0.375 + 0.25 * (std::f64::consts::TAU / x).cos()).powi(2)) / x;
            let own = if case.1 == Scheme::Loop { 1.0 / (1.0 + 8.0 * x * beta / 3.0) } else { x / (x + 5.0) };
            assert!((b(Blend::A2) - own).abs() < 1e-14, "valence {n} {:?}", case.1);
            assert_eq!(b(Blend::A1), 1.0);
        }
    }
}

#[test]
fn blend_weights_lie_between_zero_and_one_and_vanish_where_all_is_regular() {
    for case in every_shape() {
        let patches = table(&case);
        for kind in BLENDS {
            let shading = ShadingNormals::new(&patches, &case.0.positions, &blend(kind)).unwrap();
            for at in places(&patches) {
                let b = shading.blend_weight(at);
                assert!((0.0..=1.0).contains(&b), "{} {kind:?} {at:?}: {b}", case.0.name);
            }
        }
    }
    let grid = (shapes::grid(4, 3), Scheme::CatmullClark);
    let patches = table(&grid);
    let surface = patches.surface(&grid.0.positions);
    for kind in BLENDS {
        let shading = ShadingNormals::new(&patches, &grid.0.positions, &blend(kind)).unwrap();
        for at in places(&patches) {
            let jet = surface.eval(at).unwrap();
            assert_eq!(shading.normal(at, &jet), jet.normal());
        }
    }
}

#[test]
fn normals_are_of_unit_length_and_there_wherever_the_surface_has_one() {
    let kinds = BLENDS.map(NormalField::Blended);
    for case in every_shape() {
        let patches = table(&case);
        let surface = patches.surface(&case.0.positions);
        for field in [NormalField::Limit, NormalField::Subdivided, kinds[0], kinds[1], kinds[2], kinds[3]] {
            let shading = ShadingNormals::new(&patches, &case.0.positions, &with(field)).unwrap();
            for at in places(&patches) {
                let jet = surface.eval(at).unwrap();
                let n = shading.normal(at, &jet);
                assert!(n.is_some() || jet.normal().is_none(), "{} {field:?} {at:?}", case.0.name);
                if let Some(n) = n {
                    assert!((apart(n, [0.0; 3]) - 1.0).abs() < 1e-14, "{} {field:?} {at:?}", case.0.name);
                }
            }
        }
    }
}

#[test]
fn blend_weights_and_normals_agree_on_both_sides_of_edges_that_are_not_sharp() {
    for case in every_shape() {
        let patches = table(&case);
        let t = patches.topology();
        let surface = patches.surface(&case.0.positions);
        let late = ShadingOptions { normals_level: 1, weights_level: 0, ..blend(Blend::A4) };
        let round = ShadingOptions { averaging: Averaging::Spherical(1), ..blend(Blend::A2) };
        for options in [with(NormalField::Subdivided), blend(Blend::A1), blend(Blend::A4), late, round] {
            let shading = ShadingNormals::new(&patches, &case.0.positions, &options).unwrap();
            for h in (0..t.half_edge_count() as u32).map(subsurf::HalfEdge) {
                let Some(twin) = t.twin(h) else { continue };
                if t.is_infinitely_sharp(t.edge(h)) || [h, twin].iter().any(|&h| t.is_hole(t.face(h))) {
                    continue;
                }
                // A quarter along the edge, as seen from both faces.
                let [a, b] = [(h, 0.25), (twin, 0.75)].map(|(h, along)| {
                    let at = along_edge(&patches, h, along);
                    (shading.blend_weight(at), shading.normal(at, &surface.eval(at).unwrap()))
                });
                let (Some(m), Some(n)) = (a.1, b.1) else { continue };
                // Two sums of weights in different order; limit normals next to extraordinary vertices lose a digit or two.
                assert!((a.0 - b.0).abs() < 1e-12 && apart(m, n) < 1e-9, "{} {options:?} {h:?}", case.0.name);
            }
        }
    }
}

/// The place at `along` of half-edge `h`.
fn along_edge(patches: &PatchTable, h: subsurf::HalfEdge, along: f64) -> Location {
    let t = patches.topology();
    let ends = [h, t.next(h)].map(|h| patches.corner_location(h));
    if patches.subfaces(t.face(h)) == 1 {
        let mix = |a: f64, b: f64| a + along * (b - a);
        return Location { u: mix(ends[0].u, ends[1].u), v: mix(ends[0].v, ends[1].v), ..ends[0] };
    }
    if along <= 0.5 { Location { u: 2.0 * along, ..ends[0] } } else { Location { v: 2.0 * (1.0 - along), ..ends[1] } }
}

#[test]
fn fields_part_at_infinitely_sharp_creases_and_give_way_at_semi_sharp_ones() {
    let fan = shapes::interior_vertex(5);
    // A crease through the extraordinary vertex: spokes 0 and 2, three rings each.
    let crease = |s: f64| {
        let spoke = |k: u32| [(0, 1 + 3 * k), (1 + 3 * k, 2 + 3 * k), (2 + 3 * k, 3 + 3 * k)];
        let creases = [spoke(0), spoke(2)].concat().into_iter().map(|(a, b)| Crease::new(a, b, s)).collect();
        fan.tagged("crease through valence 5", Tags { creases, ..Tags::default() })
    };
    let sharp = crease(10.0);
    let patches = PatchTable::new(&sharp.mesh, Scheme::CatmullClark).unwrap();
    let surface = patches.surface(&sharp.positions);
    let shading = ShadingNormals::new(&patches, &sharp.positions, &ShadingOptions::default()).unwrap();
    // Faces 0 and 36 lie on the two sides of spoke 0. The sector of three faces is extraordinary, that of two is not.
    let [inside, outside] = [Location::new(36, 0.0, 0.3), Location::new(0, 0.3, 0.0)];
    assert!(shading.blend_weight(inside) > 0.9 && shading.blend_weight(outside) == 0.0);
    let outer = surface.eval(outside).unwrap();
    assert_eq!(shading.normal(outside, &outer), outer.normal());

    let semi = crease(2.5);
    let patches = PatchTable::new(&semi.mesh, Scheme::CatmullClark).unwrap();
    let surface = patches.surface(&semi.positions);
    for field in [NormalField::Subdivided, NormalField::Blended(Blend::A4)] {
        let shading = ShadingNormals::new(&patches, &semi.positions, &with(field)).unwrap();
        for u in [0.0, 0.2, 1.0] {
            let at = Location::new(0, u, 0.0);
            let jet = surface.eval(at).unwrap();
            assert_eq!(shading.normal(at, &jet), jet.normal(), "{field:?}");
        }
    }
    // With the crease left whole, the vertex is an extraordinary one as ever.
    let whole = ShadingOptions { crease_sharpness: 10.0, ..ShadingOptions::default() };
    let shading = ShadingNormals::new(&patches, &semi.positions, &whole).unwrap();
    assert_eq!(shading.blend_weight(Location::new(0, 0.0, 0.0)), 1.0);
    // What is infinitely sharp parts the fields whatever is asked for.
    let sharp = crease(10.0);
    let patches = PatchTable::new(&sharp.mesh, Scheme::CatmullClark).unwrap();
    let at = Location::new(0, 0.5, 0.0);
    let of = |crease_sharpness: f64| {
        let options = ShadingOptions { field: NormalField::Subdivided, crease_sharpness, ..ShadingOptions::default() };
        ShadingNormals::new(&patches, &sharp.positions, &options).unwrap().subdivided(at)
    };
    assert_eq!(of(10.0), of(1e9));
    assert!(of(10.0).is_some());
}

#[test]
fn a3_starts_where_extraordinary_vertices_are_apart() {
    let level = |shape: &Shape, scheme, options: &ShadingOptions| {
        let patches = PatchTable::new(&shape.mesh, scheme).unwrap();
        ShadingNormals::new(&patches, &shape.positions, options).unwrap().weights_level()
    };
    let quads = Scheme::CatmullClark;
    // Apart already; all corners of the cube extraordinary; beside polygons.
    assert_eq!(level(&shapes::interior_vertex(5), quads, &blend(Blend::A3)), 0);
    assert_eq!(level(&shapes::cube(), quads, &blend(Blend::A3)), 1);
    assert_eq!(level(&shapes::cone(5), quads, &blend(Blend::A3)), 2);
    assert_eq!(level(&shapes::cube().triangulated(), Scheme::Loop, &blend(Blend::A3)), 1);
    for kind in [Blend::A1, Blend::A2, Blend::A4] {
        assert_eq!(level(&shapes::cube(), quads, &blend(kind)), 0);
        assert_eq!(level(&shapes::cone(5), quads, &blend(kind)), 1);
    }
    let finer = ShadingOptions { weights_level: 2, ..blend(Blend::A4) };
    assert_eq!(level(&shapes::cube(), quads, &finer), 2);
}

#[test]
fn centres_of_polygons_count_as_extraordinary() {
    let cone = (shapes::cone(7), Scheme::CatmullClark);
    let patches = table(&cone);
    for kind in [Blend::A3, Blend::A4] {
        let shading = ShadingNormals::new(&patches, &cone.0.positions, &blend(kind)).unwrap();
        for f in 0..8 {
            let b = shading.blend_weight(Location { face: Face(f), subface: 1, u: 1.0, v: 1.0 });
            assert!((b - 1.0).abs() < 1e-14, "{kind:?} face {f}");
        }
    }
}

#[test]
fn a_tessellation_has_the_normals_of_its_places() {
    for case in every_shape() {
        let patches = table(&case);
        let surface = patches.surface(&case.0.positions);
        for options in [
            blend(Blend::A4),
            ShadingOptions { normals_level: 1, weights_level: 2, ..blend(Blend::A2) },
            with(NormalField::Subdivided),
        ] {
            let shading = ShadingNormals::new(&patches, &case.0.positions, &options).unwrap();
            let tessellate =
                TessellateOptions { rates: Rates::Uniform(4), places: true, ..TessellateOptions::default() };
            let plain = surface.tessellate(&tessellate).unwrap();
            let mesh = surface.tessellate_shaded(&tessellate, &shading).unwrap();
            assert_eq!((&plain.positions, &plain.corners), (&mesh.positions, &mesh.corners));
            assert_eq!(plain.normal_corners, mesh.normal_corners);
            let places = mesh.places.as_ref().unwrap();
            let normal_of = if mesh.normal_corners.is_empty() { &mesh.corners } else { &mesh.normal_corners };
            for (facet, ends) in mesh.face_offsets.windows(2).enumerate() {
                let (face, subface) = places.facet[facet];
                for c in ends[0] as usize..ends[1] as usize {
                    let [u, v] = places.corner_uv[c];
                    let at = Location { face: Face(face), subface, u, v };
                    let jet = surface.eval(at).unwrap();
                    let Some(want) = shading.normal(at, &jet).filter(|_| jet.unique_plane && jet.normal().is_some())
                    else {
                        continue;
                    };
                    let got = mesh.normals[normal_of[c] as usize];
                    // Limit normals of the two faces at an edge agree to rounding, less beside large valences.
                    assert!(apart(got, want) < 1e-7, "{} {at:?}: {got:?} {want:?}", case.0.name);
                }
            }
        }
    }
}

#[test]
fn shading_is_the_same_on_any_number_of_threads() {
    let case = (shapes::cone(7), Scheme::CatmullClark);
    let patches = table(&case);
    let surface = patches.surface(&case.0.positions);
    let options = ShadingOptions { averaging: Averaging::Spherical(2), ..ShadingOptions::default() };
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let shading = ShadingNormals::new(&patches, &case.0.positions, &options).unwrap();
            surface.tessellate_shaded(&TessellateOptions::default(), &shading).unwrap()
        })
    };
    let one = run(1);
    assert!(one == run(2) && one == run(5));
}

#[test]
fn powers_differ_from_place_to_place_and_blend_in_between() {
    let case = (shapes::cube(), Scheme::CatmullClark);
    let patches = table(&case);
    let new = |power| {
        ShadingNormals::new(&patches, &case.0.positions, &ShadingOptions { power, ..ShadingOptions::default() })
            .unwrap()
    };
    let middle = Location::new(0, 0.5, 0.5);
    let uniform = new(Power::PerFace(vec![2.0; 6]));
    let same = new(Power::Uniform(2.0));
    let jet = patches.surface(&case.0.positions).eval(middle).unwrap();
    assert_eq!(uniform.power(middle), 2.0);
    assert_eq!(uniform.normal(middle, &jet), same.normal(middle, &jet));
    let mixed = new(Power::PerFace(vec![1.0, 2.0, 2.0, 2.0, 2.0, 2.0]));
    let (low, high) = (mixed.power(middle), mixed.power(Location::new(1, 0.5, 0.5)));
    assert!(1.0 < low && low < high && high <= 2.0, "{low} {high}");
}

#[test]
fn normals_of_the_mesh_are_taken_where_it_has_some() {
    let case = (shapes::cube(), Scheme::CatmullClark);
    let patches = table(&case);
    let options = with(NormalField::Subdivided);
    // One normal per corner, all those of a vertex the same: the vertex's direction from the middle.
    let corners: Vec<u32> = patches.topology().corners().to_vec();
    let own = ShadingNormals::from_normals(&patches, &case.0.positions, &corners, &options).unwrap();
    let computed = ShadingNormals::new(&patches, &case.0.positions, &options).unwrap();
    for at in places(&patches) {
        // Area-weighted normals of the cube are its diagonals too, up to rounding.
        assert!(apart(own.subdivided(at).unwrap(), computed.subdivided(at).unwrap()) < 1e-15);
    }
    let refuse = |corners: &[u32], options: &ShadingOptions| {
        ShadingNormals::from_normals(&patches, &case.0.positions, corners, options).err().unwrap()
    };
    assert!(matches!(refuse(&corners[1..], &options), ShadingError::CornerCount { given: 23, expected: 24 }));
    assert!(matches!(refuse(&[9; 24], &options), ShadingError::NormalOutOfRange { corner: 0, normal: 9, normals: 8 }));
    let later = ShadingOptions { normals_level: 1, ..options };
    assert!(matches!(refuse(&corners, &later), ShadingError::OwnNormalsLevel { level: 1 }));
}

#[test]
fn options_that_do_not_fit_are_refused_by_name() {
    let cube = shapes::cube();
    let patches = PatchTable::new(&cube.mesh, Scheme::CatmullClark).unwrap();
    let refuse = |options: ShadingOptions| ShadingNormals::new(&patches, &cube.positions, &options).err().unwrap();
    let power = |power| ShadingOptions { power, ..ShadingOptions::default() };
    assert!(matches!(refuse(power(Power::Uniform(0.0))), ShadingError::BadPower { what: "all", .. }));
    let nan = vec![1.0, f64::NAN, 1.0, 1.0, 1.0, 1.0];
    assert!(matches!(refuse(power(Power::PerFace(nan))), ShadingError::BadPower { what: "face", index: 1, .. }));
    let short = ShadingError::PowerCount { what: "vertices", given: 3, expected: 8 };
    assert_eq!(refuse(power(Power::PerVertex(vec![1.0; 3]))), short);
    let cut = |crease_sharpness| ShadingOptions { crease_sharpness, ..ShadingOptions::default() };
    assert!(matches!(refuse(cut(-1.0)), ShadingError::BadCreaseSharpness { .. }));
    let deep = ShadingOptions { normals_level: 40, ..ShadingOptions::default() };
    assert!(matches!(refuse(deep), ShadingError::TooDeep { what: "normals", .. }));
}

#[test]
fn a_flat_mesh_has_one_normal_whatever_the_field() {
    let mut shape = shapes::interior_vertex(5);
    shape.positions.iter_mut().for_each(|p| p[2] = 0.0);
    let patches = PatchTable::new(&shape.mesh, Scheme::CatmullClark).unwrap();
    let surface = patches.surface(&shape.positions);
    for field in [NormalField::Subdivided, NormalField::Blended(Blend::A1), NormalField::Blended(Blend::A4)] {
        let shading = ShadingNormals::new(&patches, &shape.positions, &with(field)).unwrap();
        for at in places(&patches) {
            let n = shading.normal(at, &surface.eval(at).unwrap()).unwrap();
            assert!(apart(n, [0.0, 0.0, 1.0]) < 1e-14);
        }
    }
}

#[test]
fn other_positions_give_what_they_would_have_given_from_the_start() {
    let case = (shapes::cone(5), Scheme::CatmullClark);
    let patches = table(&case);
    let moved: Vec<[f32; 3]> =
        case.0.positions.iter().map(|p| [p[1], 2.0 * p[2], p[0] + p[1]].map(|x| x as f32)).collect();
    for options in [
        ShadingOptions::default(),
        ShadingOptions { normals_level: 1, averaging: Averaging::Spherical(1), ..blend(Blend::A3) },
    ] {
        let first = ShadingNormals::new(&patches, &case.0.positions, &options).unwrap();
        let (later, direct) = (first.with_positions(&moved), ShadingNormals::new(&patches, &moved, &options).unwrap());
        for at in places(&patches) {
            assert_eq!(later.subdivided(at), direct.subdivided(at));
            assert_eq!(later.blend_weight(at), first.blend_weight(at));
        }
    }
}

#[test]
fn finer_start_levels_bring_subdivided_normals_to_those_of_the_surface() {
    for case in [(shapes::interior_vertex(5), Scheme::CatmullClark), (shapes::interior_triangles(7), Scheme::Loop)] {
        let patches = table(&case);
        let surface = patches.surface(&case.0.positions);
        let farthest = |normals_level| {
            let options = ShadingOptions { normals_level, ..with(NormalField::Subdivided) };
            let shading = ShadingNormals::new(&patches, &case.0.positions, &options).unwrap();
            let far =
                |at: &Location| apart(shading.subdivided(*at).unwrap(), surface.eval(*at).unwrap().normal().unwrap());
            places(&patches).iter().map(far).fold(0.0, |most: f64, x| if x > most || x.is_nan() { x } else { most })
        };
        let apart = [0, 1, 2, 3].map(farthest);
        // Vertex normals of a level miss those of the surface by its facets' size, or less.
        assert!(apart.windows(2).all(|w| w[1] < 0.8 * w[0]), "{}: {apart:?}", case.0.name);
    }
}
