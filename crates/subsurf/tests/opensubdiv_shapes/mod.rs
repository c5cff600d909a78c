//! OpenSubdiv's regression shapes as `tests/golden/opensubdiv` holds them.

// Every test that includes this module uses a part of it.
#![allow(dead_code)]

use serde_json::Value;
use std::path::Path;
use subsurf::{Boundary, ControlMesh, Corner, Crease, Creasing, Rules, Scheme, Tags, Triangles};

/// A shape as the reference file gives it.
pub struct Shape {
    pub name: String,
    pub scheme: Scheme,
    pub mesh: ControlMesh,
    pub positions: Vec<[f64; 3]>,
    pub levels: Vec<Value>,
}

pub fn rows(v: &Value) -> &[Value] {
    v.as_array().unwrap()
}

pub fn index(v: &Value) -> u32 {
    v.as_u64().unwrap() as u32
}

pub fn indices(v: &Value) -> Vec<u32> {
    rows(v).iter().map(index).collect()
}

pub fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

/// Sharpness as OpenSubdiv stores it; the files' decimals are the shortest that name the single-precision number.
pub fn sharpness(v: &Value) -> f64 {
    f64::from(number(v) as f32)
}

pub fn point(v: &Value) -> [f64; 3] {
    [0, 1, 2].map(|i| number(&v[i]))
}

pub fn read(path: &Path) -> Shape {
    let mut json: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let mesh = &json["mesh"];
    let rules = Rules {
        boundary: match mesh["boundary"].as_str().unwrap() {
            "none" => Boundary::None,
            "edge-only" => Boundary::EdgeOnly,
            _ => Boundary::EdgeAndCorner,
        },
        creasing: if mesh["creasing"] == "chaikin" { Creasing::Chaikin } else { Creasing::Uniform },
        triangles: if mesh["triangles"] == "smooth" { Triangles::Smooth } else { Triangles::CatmullClark },
        ..Rules::default()
    };
    let crease = |c: &Value| Crease::new(index(&c[0]), index(&c[1]), sharpness(&c[2]));
    let tags = Tags {
        creases: rows(&mesh["sharp_edges"]).iter().map(crease).collect(),
        corners: rows(&mesh["sharp_vertices"]).iter().map(|c| Corner::new(index(&c[0]), sharpness(&c[1]))).collect(),
        holes: indices(&mesh["holes"]),
        rules,
    };
    let positions: Vec<[f64; 3]> = rows(&mesh["positions"]).iter().map(point).collect();
    let (counts, corners) = (indices(&mesh["face_counts"]), indices(&mesh["corners"]));
    Shape {
        name: json["shape"].as_str().unwrap().to_owned(),
        scheme: match json["scheme"].as_str().unwrap() {
            "bilinear" => Scheme::Bilinear,
            "loop" => Scheme::Loop,
            _ => Scheme::CatmullClark,
        },
        mesh: ControlMesh::from_counts(positions.len(), &counts, corners, tags).unwrap(),
        positions,
        levels: match json["levels"].take() {
            Value::Array(levels) => levels,
            other => panic!("levels: {other}"),
        },
    }
}

pub fn shapes() -> Vec<Shape> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/opensubdiv");
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "json"));
    paths.sort();
    let shapes: Vec<Shape> = paths.iter().map(|p| read(p)).collect();
    assert!(shapes.len() >= 60, "only {} reference files", shapes.len());
    shapes
}
