//! The reference files: `tests/golden/opensubdiv/README.md` describes them.

use serde_json::Value;
use std::path::{Path, PathBuf};
use subsurf::{
    Boundary, ControlMesh, Corner, Crease, Creasing, Edge, Rules, Scheme, Tags, Topology, Triangles, Vertex,
};

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

fn read(path: &Path) -> Shape {
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

/// The reference files of a subfolder, in order.
fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/opensubdiv").join(folder);
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "json"));
    paths.sort();
    paths
}

/// Every shape that has a file in a subfolder, with that file.
pub fn shapes_with(folder: &str) -> Vec<(Shape, Value)> {
    let json = |path: &PathBuf| serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    files(folder)
        .iter()
        .map(|path| {
            let shape = path.parent().unwrap().with_file_name(path.file_name().unwrap());
            (read(&shape), json(path))
        })
        .collect()
}

pub fn shapes() -> Vec<Shape> {
    let shapes: Vec<Shape> = files("").iter().map(|p| read(p)).collect();
    assert!(shapes.len() >= 60, "only {} reference files", shapes.len());
    shapes
}

/// Diagonal of the box round the control points.
pub fn diagonal(points: &[[f64; 3]]) -> f64 {
    let extent = |k: usize| {
        let of = |f: fn(f64, f64) -> f64| points.iter().map(|p| p[k]).reduce(f).unwrap();
        of(f64::max) - of(f64::min)
    };
    [0, 1, 2].map(extent).iter().map(|x| x * x).sum::<f64>().sqrt()
}

pub fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// True where a sharpness is no whole number: OpenSubdiv takes the weight of a rule that decays in single precision.
pub fn has_fractions(t: &Topology) -> bool {
    let edges = (0..t.edge_count() as u32).map(|e| t.edge_sharpness(Edge(e)));
    edges.chain((0..t.vertex_count() as u32).map(|v| t.vertex_sharpness(Vertex(v)))).any(|s| s.fract() != 0.0)
}
