//! Bilinear surfaces against their formula, on random meshes: polygons, boundaries, holes and non-manifold edges.

mod random_mesh;

use random_mesh::{Mesh, Recipe, for_all, recipe};
use subsurf::{
    Boundary, ControlMesh, Derivatives, Face, Level, Location, PatchTable, Rates, Scheme, TessellateOptions,
};

type Point = [f64; 3];

fn mean(points: &[Point]) -> Point {
    [0, 1, 2].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64)
}

/// Corners of a patch: of a quad its own; of a sub-face its corner, the middles of two edges, and the centre between.
fn patch_corners(mesh: &ControlMesh, points: &[Point], face: usize, subface: usize) -> [Point; 4] {
    let corners: Vec<Point> = mesh.face_vertices(face).iter().map(|&v| points[v as usize]).collect();
    let n = corners.len();
    if n == 4 {
        return [0, 1, 2, 3].map(|i| corners[i]);
    }
    let [own, next, before] = [subface, subface + 1, subface + n - 1].map(|i| corners[i % n]);
    [own, mean(&[own, next]), mean(&corners), mean(&[before, own])]
}

/// Position, derivatives in u and v, and the mixed second derivative.
fn formula([a, b, c, d]: [Point; 4], u: f64, v: f64) -> [Point; 4] {
    let at = |wa: f64, wb: f64, wc: f64, wd: f64| [0, 1, 2].map(|k| wa * a[k] + wb * b[k] + wc * c[k] + wd * d[k]);
    let (s, t) = (1.0 - u, 1.0 - v);
    [at(s * t, u * t, u * v, s * v), at(-t, t, v, -v), at(-s, -u, u, s), at(1.0, -1.0, 1.0, -1.0)]
}

fn distance(a: Point, b: Point) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Sums of four terms of size one, a dozen control points each where a polygon has as many.
const ROUNDING: f64 = 1e-14;

fn is_near(a: Point, b: Point) -> bool {
    distance(a, b) <= ROUNDING
}

fn random(cases: u32, seed: u64, law: impl Fn(&Recipe, &Mesh, &PatchTable) -> Result<(), String>) {
    for_all(recipe(), cases, seed, |recipe| {
        let made = recipe.mesh();
        let table = PatchTable::new(&made.mesh, Scheme::Bilinear).map_err(|e| e.to_string())?;
        law(recipe, &made, &table)
    });
}

#[test]
fn positions_and_derivatives_are_those_of_the_formula() {
    random(300, 21, |recipe, made, table| {
        let surface = table.surface(&made.positions);
        for at in recipe.locations(&made.mesh) {
            let jet = match surface.eval_second(at) {
                None if recipe.tags(&recipe.faces(), made.positions.len()).holes.contains(&at.face.0) => continue,
                None => return Err(format!("{at:?} is in no hole")),
                Some(jet) => jet,
            };
            let corners = patch_corners(&made.mesh, &made.positions, at.face.index(), at.subface as usize);
            let [p, du, dv, duv] = formula(corners, at.u, at.v);
            let [uu, uv, vv] = jet.second.ok_or("second derivatives are always there")?;
            let zero = [0.0; 3];
            for (ours, theirs) in [(jet.position, p), (jet.du, du), (jet.dv, dv), (uu, zero), (uv, duv), (vv, zero)] {
                if !is_near(ours, theirs) {
                    return Err(format!("{at:?}: {ours:?}, not {theirs:?}"));
                }
            }
            if jet.derivatives != Derivatives::Finite {
                return Err(format!("{at:?}: {:?}", jet.derivatives));
            }
        }
        Ok(())
    });
}

#[test]
fn the_boundary_rule_none_makes_no_holes() {
    let shape = subsurf::shapes::grid(3, 2);
    let mut rules = shape.mesh.tags().rules;
    rules.boundary = Boundary::None;
    let table = PatchTable::new(&shape.mesh.clone().with_rules(rules), Scheme::Bilinear).unwrap();
    assert_eq!(table.size().patches, 6);
}

#[test]
fn vertices_of_every_level_lie_on_the_surface() {
    random(60, 22, |_, made, table| {
        let surface = table.surface(&made.positions);
        let mut level = Level::new(&made.mesh, Scheme::Bilinear).map_err(|e| e.to_string())?;
        let mut values = made.positions.clone();
        for _ in 0..3 {
            let limit = surface.limit_of_level(&level, &values);
            if let Some(v) = (0..values.len()).find(|&v| !is_near(values[v], limit[v])) {
                return Err(format!("level {}: vertex {v} moves", level.depth()));
            }
            values = level.refine_values(&values);
            level = level.refine().map_err(|e| e.to_string())?;
        }
        Ok(())
    });
}

/// Patches meet at edges, so that a corner of a facet has the normal of its own patch.
#[test]
fn every_facet_corner_has_the_normal_of_its_own_patch() {
    random(60, 23, |recipe, made, table| {
        let rates = if recipe.seed % 3 == 0 { Rates::Tolerance(0.05) } else { Rates::Uniform(2) };
        let options = TessellateOptions { rates, places: true, ..TessellateOptions::default() };
        let mesh = table.surface(&made.positions).tessellate(&options).map_err(|e| e.to_string())?;
        if mesh.normal_corners.len() != mesh.corners.len() {
            return Err("not every facet corner has a normal".to_owned());
        }
        let places = mesh.places.as_ref().ok_or("no places")?;
        for (facet, ends) in mesh.face_offsets.windows(2).enumerate() {
            let (face, subface) = places.facet[facet];
            let corners = patch_corners(&made.mesh, &made.positions, face as usize, subface as usize);
            for i in ends[0] as usize..ends[1] as usize {
                let [u, v] = places.corner_uv[i];
                let [p, du, dv, _] = formula(corners, u, v);
                let (normal, expected) = (mesh.normals[mesh.normal_corners[i] as usize], cross(du, dv));
                let length = distance(expected, [0.0; 3]);
                // Where du and dv are nearly parallel their product has lost what it would be compared with.
                let is_same = distance(normal, expected.map(|x| x / length)) <= 1e-11;
                if length > 1e-3 && !is_same {
                    return Err(format!("face {face} sub-face {subface} at ({u}, {v}): normal {normal:?}"));
                }
                if !is_near(mesh.positions[mesh.corners[i] as usize], p) {
                    return Err(format!("face {face} sub-face {subface} at ({u}, {v}) lies elsewhere"));
                }
            }
        }
        Ok(())
    });
}

#[test]
fn a_flat_box_has_flat_normals_at_its_corners_and_along_its_edges() {
    let cube = subsurf::shapes::cube();
    let table = PatchTable::new(&cube.mesh, Scheme::Bilinear).unwrap();
    let mesh = table.surface(&cube.positions).tessellate(&TessellateOptions::default()).unwrap();
    for ends in mesh.face_offsets.windows(2) {
        let of = |i: u32| mesh.normals[mesh.normal_corners[i as usize] as usize];
        assert!((ends[0]..ends[1]).all(|i| of(i) == of(ends[0])));
        // Unit vectors along the axes, of whatever sign.
        assert_eq!(of(ends[0]).map(f64::abs).iter().sum::<f64>(), 1.0);
    }
    let jet = table.surface(&cube.positions).eval(Location { face: Face::new(1), subface: 0, u: 0.0, v: 0.0 }).unwrap();
    assert_eq!(jet.normal(), Some([0.0, 0.0, 1.0]));
}
