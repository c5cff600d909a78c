//! Programs that run other implementations of subdivision surfaces beside ours. `peers` without arguments lists them.

use peers::opensubdiv::{self, VertexOrder};
use peers::shape::Shape;
use peers::{compare_adaptive, compare_refine, conformance, dump_reference, performance, shapes_folder};
use std::path::Path;
use std::process::ExitCode;

const USAGE: &str = "usage:
  peers compare-refine                     our refinement against OpenSubdiv's: regression shapes, levels 0 to 5
  peers compare-refine SHAPES_DIR          the same on the shapes of a folder, OBJ or OpenSubdiv's headers
  peers compare-refine LEVELS FILE...      the same on any files
  peers compare-random COUNT [FIRST_SEED]  the same on random meshes and tags, levels 0 to 3
  peers conformance OUT.md [SHAPES_DIR]    the same and the limit, every shape under every rule, as a document
  peers compare-adaptive                   our feature-adaptive baseline against OpenSubdiv's, isolation levels 1 to 6
  peers compare-adaptive LEVELS FILE.obj...  the same on any files, LEVELS 10 at most
  peers compare-adaptive-random COUNT      the same on random meshes and tags, levels 1 to 4
  peers compare-ptex                       Ptex numbers and neighbours
  peers dump-adaptive OUT_FILE             OpenSubdiv's adaptive counts and Ptex neighbours, for the core's tests
  peers dump-reference OUT_DIR             OpenSubdiv's refinement of the regression shapes, for the core's tests
  peers performance [OPTIONS]              ours timed beside all others; --help lists the options
  peers show FILE.obj LEVEL                OpenSubdiv's faces, edges and vertices of one level as text
Levels are 15 at most.";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match run(&words) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn run(words: &[&str]) -> Result<(), String> {
    match words {
        ["compare-refine"] => compare_refine::regression_shapes(&shapes_folder()),
        ["compare-refine", folder] if Path::new(folder).is_dir() => {
            compare_refine::regression_shapes(Path::new(folder))
        }
        ["compare-refine", levels, files @ ..] => compare_refine::files(number(levels)?, files),
        ["compare-random", count] => compare_refine::random(&shapes_folder(), number(count)?, 0),
        ["compare-random", count, seed] => compare_refine::random(&shapes_folder(), number(count)?, number(seed)?),
        ["conformance", out] => conformance::run(&shapes_folder(), Path::new(out)),
        ["conformance", out, shapes] => conformance::run(Path::new(shapes), Path::new(out)),
        ["compare-adaptive"] => compare_adaptive::regression_shapes(&shapes_folder()),
        ["compare-adaptive", levels, files @ ..] => compare_adaptive::files(number(levels)?, files),
        ["compare-adaptive-random", count] => compare_adaptive::random(&shapes_folder(), number(count)?, 0),
        ["compare-ptex"] => compare_adaptive::ptex(&shapes_folder()),
        ["dump-adaptive", out] => compare_adaptive::dump(&shapes_folder(), Path::new(out)),
        ["dump-reference", out] => dump_reference::run(&shapes_folder(), Path::new(out)),
        ["performance", "--help"] => {
            println!("{}", performance::USAGE);
            Ok(())
        }
        ["performance", options @ ..] => performance::run(options),
        ["performance-part", part @ ..] => performance::run_part(part),
        ["show", file, level] => show(file, number(level)?),
        _ => Err(USAGE.to_string()),
    }
}

fn number<T: std::str::FromStr<Err = std::num::ParseIntError>>(word: &str) -> Result<T, String> {
    word.parse().map_err(|e| format!("{word}: {e}"))
}

fn show(file: &str, level: u32) -> Result<(), String> {
    let shape = Shape::read(Path::new(file))?;
    let levels = opensubdiv::refine(&shape, level, VertexOrder::default())?;
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
