//! Laws of tessellations over all shapes: watertight by index, on the surface, the same on any number of threads.

use std::collections::HashMap;
use subsurf::shapes::{self, Shape};
use subsurf::{
    Face, Facets, Location, PatchTable, Rates, Real, Scheme, TessellateError, TessellateOptions, Tessellation,
};

fn facets<T>(t: &Tessellation<T>) -> impl Iterator<Item = &[u32]> {
    t.face_offsets.windows(2).map(|w| &t.corners[w[0] as usize..w[1] as usize])
}

/// Vertices - edges + faces, of used vertices; and the number of edges that are not shared by two faces in opposite
/// directions.
fn euler(faces: impl Iterator<Item = Vec<u32>>) -> (i64, usize) {
    let (mut edges, mut used, mut count) =
        (HashMap::<(u32, u32), [u32; 2]>::new(), std::collections::HashSet::new(), 0);
    for f in faces {
        count += 1;
        for i in 0..f.len() {
            let (a, b) = (f[i], f[(i + 1) % f.len()]);
            used.insert(a);
            edges.entry((a.min(b), a.max(b))).or_default()[usize::from(a > b)] += 1;
        }
    }
    let open = edges.values().filter(|n| **n != [1, 1]).count();
    (used.len() as i64 - edges.len() as i64 + count, open)
}

fn all_rates() -> Vec<Rates> {
    vec![
        Rates::Uniform(1),
        Rates::Uniform(2),
        Rates::Uniform(5),
        Rates::Uniform(8),
        Rates::Tolerance(0.02),
        Rates::Tolerance(0.1),
        Rates::EdgeLength(0.4),
    ]
}

fn tessellate((shape, scheme): &(Shape, Scheme), rates: Rates, facets: Facets) -> Tessellation<f64> {
    let table = PatchTable::new(&shape.mesh, *scheme).unwrap();
    let options = TessellateOptions { rates, facets, normals: true, places: true, ..TessellateOptions::default() };
    table.surface(&shape.positions).tessellate(&options).unwrap()
}

fn of_both_schemes(quads: Vec<Shape>, triangles: Vec<Shape>) -> Vec<(Shape, Scheme)> {
    let quads = quads.into_iter().map(|s| (s, Scheme::CatmullClark));
    quads.chain(triangles.into_iter().map(|s| (s, Scheme::Loop))).collect()
}

/// Shapes whose faces repeat no vertex, and whose tessellations have no two edges between the same points.
fn proper_shapes() -> Vec<(Shape, Scheme)> {
    let all = of_both_schemes(shapes::all(), shapes::all_triangles());
    all.into_iter().filter(|(s, _)| !s.name.starts_with("degenerate")).collect()
}

fn plain_shapes() -> Vec<(Shape, Scheme)> {
    let quads = vec![shapes::cube(), shapes::grid(4, 3), shapes::interior_vertex(5), shapes::cone(5)];
    let triangles = vec![shapes::cube().triangulated(), shapes::interior_triangles(5), shapes::interior_triangles(9)];
    of_both_schemes(quads, triangles)
}

/// The larger of two errors; none is larger than one that is not a number.
fn worse(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

#[test]
fn the_euler_characteristic_of_the_cage_is_kept() {
    for pair in proper_shapes() {
        let (shape, scheme) = &pair;
        let table = PatchTable::new(&shape.mesh, *scheme).unwrap();
        let kept = (0..shape.mesh.face_count()).filter(|&f| !table.topology().is_hole(Face(f as u32)));
        let cage = euler(kept.map(|f| shape.mesh.face_vertices(f).to_vec()));
        for rates in all_rates() {
            for kind in [Facets::Quads, Facets::Triangles] {
                let mesh = tessellate(&pair, rates, kind);
                let fine = euler(facets(&mesh).map(<[u32]>::to_vec));
                assert_eq!(fine.0, cage.0, "{} {rates:?} {kind:?}", shape.name);
                if cage.1 == 0 {
                    assert_eq!(fine.1, 0, "{} {rates:?} {kind:?} is not closed", shape.name);
                }
            }
        }
    }
}

#[test]
fn every_facet_corner_lies_on_the_surface_at_its_place() {
    for pair in of_both_schemes(shapes::all(), shapes::all_triangles()) {
        for rates in [Rates::Uniform(2), Rates::Uniform(5), Rates::Tolerance(0.05), Rates::EdgeLength(0.5)] {
            corners_lie_at_their_places(&pair, rates);
        }
    }
    // So fine that faces which lie otherwise in their plans list their samples together.
    for shape in [shapes::cube(), shapes::interior_vertex(5)] {
        corners_lie_at_their_places(&(shape, Scheme::CatmullClark), Rates::Uniform(128));
    }
}

fn corners_lie_at_their_places(pair: &(Shape, Scheme), rates: Rates) {
    let (shape, scheme) = pair;
    let table = PatchTable::new(&shape.mesh, *scheme).unwrap();
    let surface = table.surface(&shape.positions);
    let mesh = tessellate(pair, rates, Facets::Quads);
    let places = mesh.places.as_ref().unwrap();
    assert_eq!(places.facet.len() + 1, mesh.face_offsets.len());
    for (facet, range) in mesh.face_offsets.windows(2).enumerate() {
        let (face, subface) = places.facet[facet];
        for c in range[0] as usize..range[1] as usize {
            let [u, v] = places.corner_uv[c];
            let at = Location { face: Face(face), subface, u, v };
            let p = surface.position(at).unwrap();
            let q = mesh.positions[mesh.corners[c] as usize];
            let is_near = (0..3).all(|i| (p[i] - q[i]).abs() < 1e-13);
            assert!(is_near, "{} {rates:?} {at:?}: {p:?} {q:?}", shape.name);
        }
    }
}

#[test]
fn facets_are_seen_from_the_side_of_their_normals() {
    for pair in plain_shapes() {
        let shape = &pair.0;
        for rates in all_rates() {
            let mesh = tessellate(&pair, rates, Facets::Triangles);
            let normals = if mesh.normal_corners.is_empty() { &mesh.corners } else { &mesh.normal_corners };
            for (k, f) in facets(&mesh).enumerate() {
                let [a, b, c] = [0, 1, 2].map(|i| mesh.positions[f[i] as usize]);
                let (p, q) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
                let n = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
                let size = n.iter().map(|x| x * x).sum::<f64>().sqrt();
                let first = mesh.face_offsets[k] as usize;
                let m = mesh.normals[normals[first] as usize];
                let cosine = (0..3).map(|i| n[i] * m[i]).sum::<f64>() / size;
                assert!(cosine > 0.2, "{} {rates:?} facet {k}: {cosine}", shape.name);
            }
        }
    }
}

#[test]
fn one_and_two_threads_give_the_same_bits() {
    for pair in of_both_schemes(shapes::all(), shapes::all_triangles()) {
        for rates in [Rates::Uniform(4), Rates::Tolerance(0.05)] {
            let on = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| tessellate(&pair, rates, Facets::Quads))
            };
            assert!(on(1) == on(2), "{} {rates:?}", pair.0.name);
        }
    }
}

/// Distance from `p` to the nearest point of a triangle: the squared distance is a convex quadratic in the two
/// barycentric parameters, so golden-section searches nest.
fn nearest(p: [f64; 3], t: [[f64; 3]; 3]) -> f64 {
    let far = |s: f64, r: f64| {
        (0..3).map(|i| (p[i] - t[0][i] - s * (t[1][i] - t[0][i]) - r * (t[2][i] - t[0][i])).powi(2)).sum::<f64>()
    };
    least(1.0, &|s| least(1.0 - s, &|r| far(s, r))).sqrt()
}

/// The least value of a convex function on `[0, end]`.
fn least(end: f64, f: &dyn Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut a, mut b) = (0.0, end);
    for _ in 0..30 {
        let (x, y) = (b - ratio * (b - a), a + ratio * (b - a));
        if f(x) < f(y) { b = y } else { a = x }
    }
    f(0.5 * (a + b))
}

#[test]
fn tolerances_are_kept_at_the_middle_of_facets_and_sides() {
    for pair in plain_shapes() {
        let (shape, scheme) = &pair;
        let table = PatchTable::new(&shape.mesh, *scheme).unwrap();
        let surface = table.surface(&shape.positions);
        for tolerance in [0.03, 0.003] {
            let mesh = tessellate(&pair, Rates::Tolerance(tolerance), Facets::Triangles);
            let places = mesh.places.as_ref().unwrap();
            let mut worst = 0.0f64;
            for (k, w) in mesh.face_offsets.windows(2).enumerate() {
                let range = w[0] as usize..w[1] as usize;
                let n = range.len() as f64;
                let middle = |of: &dyn Fn(usize) -> f64| range.clone().map(of).sum::<f64>() / n;
                let (face, subface) = places.facet[k];
                let [u, v] = [0, 1].map(|i| middle(&|c| places.corner_uv[c][i]));
                let p = surface.position(Location { face: Face(face), subface, u, v }).unwrap();
                let to_facet = |k: usize| {
                    let first = mesh.face_offsets[k] as usize;
                    nearest(p, [0, 1, 2].map(|c| mesh.positions[mesh.corners[first + c] as usize]))
                };
                let mut far = to_facet(k);
                if far > tolerance {
                    // Next to an extraordinary vertex parameters drift: another facet of the face lies below the point.
                    let same = (0..places.facet.len()).filter(|&other| places.facet[other] == places.facet[k]);
                    far = same.map(to_facet).fold(far, f64::min);
                }
                worst = worse(worst, far);
            }
            assert!(worst <= tolerance, "{} {tolerance}: {worst}", shape.name);
        }
    }
}

#[test]
fn infinitely_sharp_creases_have_two_normals_and_one_point() {
    let creased = shapes::tagged().into_iter().find(|s| s.name == "single crease, infinite").unwrap();
    let mesh = tessellate(&(creased, Scheme::CatmullClark), Rates::Uniform(4), Facets::Quads);
    // Four edges of four facets: 3 inner points each, and 3 inner vertices; the two ends lie on the boundary, where the
    // crease's end is a corner with a sector on either side.
    assert_eq!(mesh.normals.len(), mesh.positions.len() + 4 * 3 + 3 + 2);
    assert_eq!(mesh.normal_corners.len(), mesh.corners.len());
    let smooth = tessellate(&(shapes::cube(), Scheme::CatmullClark), Rates::Uniform(4), Facets::Quads);
    assert_eq!(smooth.normals.len(), smooth.positions.len());
    assert!(smooth.normal_corners.is_empty());
}

#[test]
fn what_cannot_be_reached_or_held_is_refused_at_once() {
    let car = (shapes::interior_vertex(5), Scheme::CatmullClark);
    let table = PatchTable::new(&car.0.mesh, car.1).unwrap();
    let refuse = |rates, most_points| {
        let options = TessellateOptions { rates, most_points, ..TessellateOptions::default() };
        table.surface(&car.0.positions).tessellate(&options).unwrap_err()
    };
    let most = u64::MAX;
    for rates in [Rates::Tolerance(1e-12), Rates::EdgeLength(1e-9)] {
        assert!(matches!(refuse(rates, most), TessellateError::TooFine { .. }), "{rates:?}");
    }
    assert!(matches!(refuse(Rates::EdgeLength(0.01), 1000), TessellateError::TooLarge { .. }));
    for rate in [1_000_000, u32::MAX - 1, u32::MAX] {
        assert!(matches!(refuse(Rates::Uniform(rate), most), TessellateError::TooLarge { .. }));
    }
    assert!(matches!(refuse(Rates::Uniform(0), most), TessellateError::ZeroRate));
    for rates in [Rates::Tolerance(f64::NAN), Rates::Tolerance(-1.0), Rates::EdgeLength(0.0)] {
        assert!(matches!(refuse(rates, most), TessellateError::NotPositive { .. }), "{rates:?}");
    }
}

fn rounded(points: &[[f64; 3]]) -> Vec<[f32; 3]> {
    points.iter().map(|p| p.map(|x| x as f32)).collect()
}

/// Whether one frame by itself is that of a tessellator: the same facets, and samples to rounding, since faces that are alike are summed in
/// another order there.
fn agrees<T: Real>(shape: &Shape, once: &Tessellation<T>, many: &Tessellation<T>, rounding: f64) {
    let mut same = once.clone();
    (same.positions, same.normals) = (many.positions.clone(), many.normals.clone());
    assert!(same == *many, "{}", shape.name);
    let far = |points: &[[T; 3]]| points.as_flattened().iter().fold(0.0, |m: f64, x| m.max(x.to_f64().abs()));
    let extent = shape.positions.as_flattened().iter().fold(far(&once.positions), |m, x| m.max(x.abs()));
    let off = |a: &[[T; 3]], b: &[[T; 3]]| {
        let pairs = a.as_flattened().iter().zip(b.as_flattened());
        pairs.map(|(a, b)| (a.to_f64() - b.to_f64()).abs()).fold(0.0, worse)
    };
    // Some twenty products of weights that sum to one, rounded one by one.
    let [points, normals] = [off(&once.positions, &many.positions), off(&once.normals, &many.normals)];
    assert!(points < 8.0 * rounding * extent, "{}: {points:e}", shape.name);
    // Normals are told from derivatives of 1/250 of the ring's extent and more.
    assert!(normals < 2000.0 * rounding, "{}: {normals:e}", shape.name);
}

#[test]
fn a_tessellator_gives_every_frame_what_tessellating_it_gives_to_rounding() {
    for (shape, scheme) in of_both_schemes(shapes::all(), shapes::all_triangles()) {
        let table = PatchTable::new(&shape.mesh, scheme).unwrap();
        for normals in [false, true] {
            let options = TessellateOptions { rates: Rates::Uniform(6), normals, ..TessellateOptions::default() };
            let tessellator = table.tessellator(&shape.positions, &options).unwrap();
            let in_single = table.tessellator(&rounded(&shape.positions), &options).unwrap();
            for frame in 1..3 {
                let moved: Vec<[f64; 3]> = shape
                    .positions
                    .iter()
                    .map(|&[x, y, z]| [x + 0.1 * y * f64::from(frame), y - 0.2 * z, z + 0.3 * x * x])
                    .collect();
                let many = tessellator.evaluate(&moved);
                agrees(&shape, &table.surface(&moved).tessellate(&options).unwrap(), &many, f64::EPSILON);
                let mut points = vec![[f64::NAN; 3]; tessellator.point_count()];
                let mut unit = vec![[f64::NAN; 3]; tessellator.normal_count()];
                tessellator.evaluate_into(&moved, &mut points, &mut unit);
                assert!(points == many.positions && unit == many.normals, "{} frame {frame}", shape.name);
                let moved = rounded(&moved);
                let once = table.surface(&moved).tessellate(&options).unwrap();
                agrees(&shape, &once, &in_single.evaluate(&moved), f64::from(f32::EPSILON));
            }
        }
    }
}

#[test]
fn single_precision_is_off_by_roundings_of_the_face_alone() {
    let far = f32::EPSILON as f64;
    for (shape, scheme) in of_both_schemes(shapes::all(), shapes::all_triangles()) {
        let table = PatchTable::new(&shape.mesh, scheme).unwrap();
        for rate in [4, 8, 32] {
            let options = TessellateOptions { rates: Rates::Uniform(rate), ..TessellateOptions::default() };
            let single = rounded(&shape.positions);
            let double: Vec<[f64; 3]> = single.iter().map(|p| p.map(f64::from)).collect();
            let (single, double) = (
                table.surface(&single).tessellate(&options).unwrap(),
                table.surface(&double).tessellate(&options).unwrap(),
            );
            let extent = shape.positions.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
            for (a, b) in single.positions.iter().zip(&double.positions) {
                // Some twenty products of weights that sum to one, rounded one by one.
                let off = (0..3).map(|c| (f64::from(a[c]) - b[c]).abs()).fold(0.0, worse);
                assert!(off < 8.0 * far * extent, "{} rate {rate}: {off:e}", shape.name);
            }
            for (a, b) in single.normals.iter().zip(&double.normals) {
                // Where what is perpendicular between derivatives is less than 1/250 of the ring's extent, normals are
                // evaluated in f64; else the rounding of some twenty products is at most so many times as large.
                let off = (0..3).map(|c| (f64::from(a[c]) - b[c]).abs()).fold(0.0, worse);
                assert!(off < 2e-4, "{} rate {rate}: {a:?} {b:?}", shape.name);
            }
        }
    }
}

#[test]
fn distance_from_the_origin_costs_positions_one_rounding_and_normals_only_what_it_costs_control_points() {
    let cube = shapes::cube();
    let table = PatchTable::new(&cube.mesh, Scheme::CatmullClark).unwrap();
    let tessellate = |shift: f32| {
        // Halves are exact a million away.
        let control: Vec<[f32; 3]> =
            rounded(&cube.positions).iter().map(|p| p.map(|x| 0.5 * x.round() + shift)).collect();
        table.surface(&control).tessellate(&TessellateOptions::default()).unwrap()
    };
    let (near, far) = (tessellate(0.0), tessellate(1_048_576.0));
    assert!(near.normals == far.normals, "differences of control points are the same");
    for (a, b) in near.positions.iter().zip(&far.positions) {
        (0..3).for_each(|c| assert!((a[c] - (b[c] - 1_048_576.0)).abs() <= 0.0626, "{a:?} {b:?}"));
    }
}
