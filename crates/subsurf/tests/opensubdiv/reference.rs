//! The reference files beside the shapes, and how to compare: `tests/golden/opensubdiv/README.md` describes them.

use crate::opensubdiv_shapes::{Shape, read};
use serde_json::Value;
use std::path::{Path, PathBuf};
use subsurf::{Edge, Topology, Vertex};

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

/// The larger of two errors; none is larger than one that is not a number.
pub fn worse(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// True where a sharpness is no whole number: OpenSubdiv takes the weight of a rule that decays in single precision.
pub fn has_fractions(t: &Topology) -> bool {
    let edges = (0..t.edge_count() as u32).map(|e| t.edge_sharpness(Edge(e)));
    edges.chain((0..t.vertex_count() as u32).map(|v| t.vertex_sharpness(Vertex(v)))).any(|s| s.fract() != 0.0)
}
