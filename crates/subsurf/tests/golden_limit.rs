//! The exact evaluator against 36-digit truth: brute-force refinement in 70-digit arithmetic, no closed form involved.
//! The data lies in the `shared/golden` folder beside the repository, and a few cases of it in `tests/golden/limit`.

use serde_json::Value;
use std::path::{Path, PathBuf};
use subsurf::{
    Boundary, ControlMesh, Corner, Crease, Derivatives, Face, Location, Method, PatchTable, Rules, Scheme, Tags,
};

fn own_cases() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/limit")
}

fn shared_cases() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/golden")
}

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap_or_else(|| v.as_str().unwrap().parse().unwrap())
}

fn vector(v: &Value) -> [f64; 3] {
    [0, 1, 2].map(|i| number(&v[i]))
}

fn index(v: &Value) -> u32 {
    v.as_u64().unwrap() as u32
}

fn rows(v: &Value) -> &[Value] {
    v.as_array().unwrap()
}

struct Case {
    name: String,
    mesh: ControlMesh,
    positions: Vec<[f64; 3]>,
    json: Value,
}

fn load(path: &Path) -> Case {
    let json: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let faces: Vec<Vec<u32>> = rows(&json["faces"]).iter().map(|f| rows(f).iter().map(index).collect()).collect();
    let positions: Vec<[f64; 3]> = rows(&json["vertices"]).iter().map(vector).collect();
    let crease = |c: &Value| Crease::new(index(&c[0]), index(&c[1]), number(&c[2]));
    let boundary = match json["boundary"].as_str().unwrap() {
        "edge-only" => Boundary::EdgeOnly,
        _ => Boundary::EdgeAndCorner,
    };
    let tags = Tags {
        creases: rows(&json["edge_sharpness"]).iter().map(crease).collect(),
        corners: rows(&json["vertex_sharpness"]).iter().map(|c| Corner::new(index(&c[0]), number(&c[1]))).collect(),
        rules: Rules { boundary, ..Rules::default() },
        ..Tags::default()
    };
    let counts: Vec<u32> = faces.iter().map(|f| f.len() as u32).collect();
    let mesh = ControlMesh::from_counts(positions.len(), &counts, faces.concat(), tags).unwrap();
    Case { name: json["name"].as_str().unwrap().to_owned(), mesh, positions, json }
}

fn cases(folder: &Path, scheme: Scheme) -> Vec<Case> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    let is_case = |p: &PathBuf| {
        let name = p.file_name().unwrap().to_string_lossy().into_owned();
        name.starts_with(if scheme == Scheme::Loop { "loop_" } else { "cc_" }) && name.ends_with(".json")
    };
    paths.iter().filter(|p| is_case(p)).map(|p| load(p)).collect()
}

fn size(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    size([a[0] - b[0], a[1] - b[1], a[2] - b[2]])
}

/// The larger of two errors; none is larger than one that is not a number.
fn worse(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

fn diagonal(points: &[[f64; 3]]) -> f64 {
    let bound = |f: fn(f64, f64) -> f64| [0, 1, 2].map(|i| points.iter().map(|p| p[i]).reduce(f).unwrap());
    apart(bound(f64::min), bound(f64::max))
}

/// Largest errors of all cases in a folder; panics where one exceeds its bound.
fn check(folder: &Path, scheme: Scheme, method: Method) {
    let (mut samples, mut worst) = (0, [0.0f64; 4]);
    for case in cases(folder, scheme) {
        let table = PatchTable::with_method(&case.mesh, scheme, method).unwrap();
        let surface = table.surface(&case.positions);
        let single: Vec<[f32; 3]> = case.positions.iter().map(|p| p.map(|x| x as f32)).collect();
        let rounded: Vec<[f64; 3]> = single.iter().map(|p| p.map(f64::from)).collect();
        let exact_in_f32 = rounded == case.positions;
        let box_size = diagonal(&case.positions);
        for s in rows(&case.json["samples"]) {
            let (face, child) = (Face(index(&s["face"])), s.get("child").map(index));
            let at = Location { face, subface: child.unwrap_or(0), u: number(&s["u"]), v: number(&s["v"]) };
            let what = format!("{} {at:?} {method:?}", case.name);
            let jet = surface.eval_second(at).unwrap();
            assert_eq!(jet.derivatives, Derivatives::Finite, "{what}");
            let first = ["du", "dv"].map(|k| vector(&s[k]));
            let second = ["duu", "duv", "dvv"].map(|k| vector(&s[k]));
            let scale = first.iter().map(|&d| size(d)).fold(0.0, f64::max);
            let scale2 = second.iter().map(|&d| size(d)).fold(scale, f64::max);
            let ours = jet.second.unwrap();
            let p = apart(jet.position, vector(&s["p"])) / box_size;
            let d = worse(apart(jet.du, first[0]), apart(jet.dv, first[1])) / scale;
            let dd = (0..3).map(|k| apart(ours[k], second[k])).fold(0.0, worse) / scale2;
            assert!(p < 1e-14, "{what}: position {p:e}");
            assert!(d < 1e-12, "{what}: first derivatives {d:e}");
            assert!(dd < 1e-11, "{what}: second derivatives {dd:e}");
            worst = [worse(worst[0], p), worse(worst[1], d), worse(worst[2], dd), worst[3]];
            if exact_in_f32 {
                let jet = table.surface(&single).eval(at).unwrap();
                let error = apart(jet.position.map(|x| f64::from(x as f32)), vector(&s["p"])) / box_size;
                assert!(error < 1e-7, "{what}: position in f32 {error:e}");
                worst[3] = worse(worst[3], error);
            }
            samples += 1;
        }
        check_vertices(&case, &table);
    }
    assert!(samples > 50, "only {samples} samples in {}", folder.display());
    println!(
        "{method:?}: {samples} samples; position {:.1e}, first {:.1e}, second {:.1e}, f32 {:.1e}",
        worst[0], worst[1], worst[2], worst[3]
    );
}

/// Positions and normals at vertices, seen from each face.
fn check_vertices(case: &Case, table: &PatchTable) {
    let surface = table.surface(&case.positions);
    let box_size = diagonal(&case.positions);
    for limit in rows(&case.json["vertex_limits"]) {
        let v = index(&limit["vertex"]);
        for normal in rows(&limit["normals"]) {
            let face = Face(index(&normal["face"]));
            let corners = case.mesh.face_vertices(face.index());
            let corner = corners.iter().position(|&c| c == v).unwrap();
            let at = table.corner_location(table.topology().half_edge(face, corner));
            let jet = surface.eval(at).unwrap();
            let what = format!("{} vertex {v} from face {face}", case.name);
            let error = apart(jet.position, vector(&limit["p"])) / box_size;
            assert!(error < 1e-14, "{what}: {error:e}");
            match normal["n"].as_array() {
                None => assert!(!jet.unique_plane || jet.plane.is_none(), "{what} has no unique normal"),
                Some(_) => {
                    let n = jet.normal().unwrap_or_else(|| panic!("{what} has a normal"));
                    let error = apart(n, vector(&normal["n"]));
                    assert!(error < 1e-13, "{what}: normal {n:?} is off by {error:e}");
                }
            }
        }
    }
}

#[test]
fn own_golden_cases_are_met_by_deflated_powers() {
    check(&own_cases(), Scheme::CatmullClark, Method::Deflated);
}

#[test]
fn own_golden_cases_are_met_by_the_eigenbasis() {
    check(&own_cases(), Scheme::CatmullClark, Method::Eigenbasis);
}

#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shared golden data")]
fn all_golden_cases_are_met_by_deflated_powers() {
    check(&shared_cases(), Scheme::CatmullClark, Method::Deflated);
}

#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shared golden data")]
fn all_golden_cases_are_met_by_the_eigenbasis() {
    check(&shared_cases(), Scheme::CatmullClark, Method::Eigenbasis);
}

#[test]
fn own_golden_cases_of_loop_are_met() {
    check(&own_cases(), Scheme::Loop, Method::Deflated);
}

#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shared golden data")]
fn all_golden_cases_of_loop_are_met() {
    check(&shared_cases(), Scheme::Loop, Method::Deflated);
}
