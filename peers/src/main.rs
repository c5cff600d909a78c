//! Programs that run other implementations of subdivision surfaces beside ours. `peers` without arguments lists them.

mod opensubdiv;
mod shape;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str = "usage:
  peers show FILE.obj LEVEL     OpenSubdiv's faces, edges and vertices of one level as text";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match words.as_slice() {
        ["show", file, level] => level.parse().map_err(|e| format!("{level}: {e}")).and_then(|l| show(file, l)),
        _ => Err(USAGE.to_string()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

/// The shapes lie beside the repository.
fn shapes_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/models/opensubdiv_shapes")
}

fn show(file: &str, level: u32) -> Result<(), String> {
    let shape = shape::Shape::read(Path::new(file))?;
    let levels = opensubdiv::refine(&shape, level, opensubdiv::VertexOrder::default())?;
    let l = levels.last().expect("level 0 at least");
    let mut corner = 0;
    for (f, &n) in l.face_counts.iter().enumerate() {
        let end = corner + n as usize;
        let (vertices, edges) = (&l.face_vertices[corner..end], &l.face_edges[corner..end]);
        println!("face {f}: vertices {vertices:?} edges {edges:?}{}", if l.holes[f] { " hole" } else { "" });
        corner = end;
    }
    for (e, ends) in l.edges.iter().enumerate() {
        let flag = if l.edge_non_manifold[e] { " non-manifold" } else { "" };
        println!("edge {e}: {ends:?} sharpness {} faces {}{flag}", l.edge_sharpness[e], l.edge_face_counts[e]);
    }
    for (v, p) in l.positions.iter().enumerate() {
        let flag = if l.vertex_non_manifold[v] { " non-manifold" } else { "" };
        let origin = l.vertex_origins.get(v).map(|o| format!(" from {o:?}")).unwrap_or_default();
        println!("vertex {v}: {p:?} sharpness {} rule {}{flag}{origin}", l.vertex_sharpness[v], l.vertex_rules[v]);
    }
    Ok(())
}
