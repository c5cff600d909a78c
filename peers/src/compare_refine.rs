//! `peers compare-refine`: our refinement against OpenSubdiv's, element by element, on every shape and level.
//!
//! Connectivity, flags and their order must be the same; positions are compared in both precisions, as a fraction of
//! the diagonal of the control points' box. Both sides get sharpness rounded to single precision, which is what
//! OpenSubdiv stores.

use crate::opensubdiv::{self, Origin, OsdLevel, VertexOrder};
use crate::random_shapes::random_shape;
use crate::shape::{Shape, shapes};
use std::path::Path;
use subsurf::{Edge, Face, Level, Vertex};

const LEVELS: u32 = 5;
/// OpenSubdiv takes the mean of decaying sharpnesses, the weight of the rule that decays, in single precision.
const F64_BOUND: f64 = 1e-7;
/// Ours in single precision against OpenSubdiv's in double, which both stand for. (Against its own single precision,
/// which rounds every partial sum, the largest difference is 1.1e-6.)
const F32_BOUND: f64 = 1e-6;
/// OpenSubdiv forms Chaikin's averages of numbers up to 10 in single precision, five times over.
const SHARPNESS_BOUND: f64 = 4e-6;

/// What is compared of one level.
pub struct LevelView {
    pub faces: Vec<Vec<u32>>,
    pub holes: Vec<bool>,
    pub edges: Vec<[u32; 2]>,
    pub edge_sharpness: Vec<f64>,
    pub edge_non_manifold: Vec<bool>,
    pub vertex_sharpness: Vec<f64>,
    pub vertex_non_manifold: Vec<bool>,
    pub positions: Vec<[f64; 3]>,
    pub positions_f32: Vec<[f32; 3]>,
}

/// Worst differences of one level, and what does not match at all.
#[derive(Default)]
pub struct Difference {
    pub sharpness: f64,
    pub f64: f64,
    pub f32: f64,
    pub mismatches: Vec<String>,
}

/// Prefixes of the regression shapes: all schemes.
pub const SCHEMES: [&str; 3] = ["catmark_", "bilinear_", "loop_"];

/// All regression shapes.
pub fn regression_shapes(models: &Path) -> Result<(), String> {
    run(shapes(models, &SCHEMES)?.into_iter(), LEVELS)
}

/// Any files.
pub fn files(levels: u32, paths: &[&str]) -> Result<(), String> {
    let shapes: Result<Vec<Shape>, String> = paths.iter().map(|path| Shape::read(Path::new(path))).collect();
    run(shapes?.into_iter(), levels)
}

/// `count` random meshes made from the small regression shapes.
pub fn random(models: &Path, count: u64, first_seed: u64) -> Result<(), String> {
    let mut models = shapes(models, &SCHEMES)?;
    models.retain(|shape| shape.counts.len() < 100);
    run((first_seed..first_seed + count).map(|seed| random_shape(&models, seed)), 3)
}

fn run(shapes: impl Iterator<Item = Shape>, levels: u32) -> Result<(), String> {
    println!("{:32} level  vertices     edges     faces  sharpness  f64/diagonal  f32/diagonal", "shape");
    let (mut failures, mut worst) = (0, Difference::default());
    for shape in shapes.map(round_sharpness) {
        let theirs = opensubdiv::refine(&shape, levels, VertexOrder::VerticesFirst)?;
        let ours = match refine(&shape, levels) {
            Ok(levels) => levels,
            Err(message) => {
                println!("{:32} FAILED: {message}", shape.name);
                failures += 1;
                continue;
            }
        };
        let diagonal = shape.diagonal();
        let until = first_extrapolation(&theirs).unwrap_or(theirs.len());
        if until < theirs.len() {
            println!("{:32} compared below level {until}, where OpenSubdiv extrapolates", shape.name);
        }
        for (number, (theirs, ours)) in theirs.iter().zip(&ours).take(until).enumerate() {
            let theirs = view(theirs);
            let d = compare(ours, &theirs, diagonal);
            println!(
                "{:32} {number:5} {:9} {:9} {:9}  {:9.1e}  {:12.1e}  {:12.1e}{}",
                shape.name,
                theirs.positions.len(),
                theirs.edges.len(),
                theirs.faces.len(),
                d.sharpness,
                d.f64,
                d.f32,
                if d.mismatches.is_empty() { "" } else { "  FAILED" }
            );
            d.mismatches.iter().for_each(|m| println!("    {m}"));
            failures += usize::from(!d.mismatches.is_empty());
            worst.sharpness = worst.sharpness.max(d.sharpness);
            worst.f64 = worst.f64.max(d.f64);
            worst.f32 = worst.f32.max(d.f32);
        }
    }
    println!(
        "worst: sharpness {:.1e}, f64 {:.1e}, f32 {:.1e}; OpenSubdiv {}",
        worst.sharpness,
        worst.f64,
        worst.f32,
        opensubdiv::version()
    );
    if failures == 0 { Ok(()) } else { Err(format!("{failures} levels differ")) }
}

/// The first level with an edge of sharpness above 1 in the level before, one half of which is smooth: possible only
/// with Chaikin's rule. There OpenSubdiv (3.5 to 3.7, `Sdc::Scheme::ComputeEdgeVertexMask`) takes the edge's sharpness
/// as the weight of the crease rule without limiting it to 1, and so gives the smooth rule a negative weight.
pub fn first_extrapolation(levels: &[OsdLevel]) -> Option<usize> {
    (1..levels.len()).find(|&number| {
        let (parent, child) = (&levels[number - 1], &levels[number]);
        // Edges inside faces join an edge point with a face point or, under Loop, with another edge point.
        let half_of = |edge: &[u32; 2]| match edge.map(|v| child.vertex_origins[v as usize]) {
            [Origin::Edge(e), Origin::Vertex(_)] | [Origin::Vertex(_), Origin::Edge(e)] => {
                parent.edge_sharpness[e as usize]
            }
            _ => 0.0,
        };
        child.edges.iter().zip(&child.edge_sharpness).any(|(edge, &s)| s == 0.0 && half_of(edge) > 1.0)
    })
}

/// Sharpness as OpenSubdiv stores it.
pub fn round_sharpness(mut shape: Shape) -> Shape {
    shape.tags.creases.iter_mut().for_each(|c| c.sharpness = f64::from(c.sharpness as f32));
    shape.tags.corners.iter_mut().for_each(|c| c.sharpness = f64::from(c.sharpness as f32));
    shape
}

/// Our refinement.
pub fn refine(shape: &Shape, levels: u32) -> Result<Vec<LevelView>, String> {
    let text = |e: subsurf::MeshError| e.to_string();
    let mut level = Level::new(&shape.mesh()?, shape.our_scheme()).map_err(text)?;
    let mut positions = shape.positions.clone();
    let mut positions_f32: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| x as f32)).collect();
    let mut views = vec![];
    loop {
        let t = level.topology();
        let (faces, edges, vertices) = (t.face_count() as u32, t.edge_count() as u32, t.vertex_count() as u32);
        views.push(LevelView {
            faces: (0..faces).map(|f| t.face_vertices(Face(f)).to_vec()).collect(),
            holes: (0..faces).map(|f| t.is_hole(Face(f))).collect(),
            edges: (0..edges).map(|e| t.edge_vertices(Edge(e)).map(|v| v.0)).collect(),
            edge_sharpness: (0..edges).map(|e| t.edge_sharpness(Edge(e))).collect(),
            edge_non_manifold: (0..edges).map(|e| t.is_non_manifold_edge(Edge(e))).collect(),
            vertex_sharpness: (0..vertices).map(|v| t.vertex_sharpness(Vertex(v))).collect(),
            vertex_non_manifold: (0..vertices).map(|v| t.is_non_manifold_vertex(Vertex(v))).collect(),
            positions: positions.clone(),
            positions_f32: positions_f32.clone(),
        });
        if level.depth() == levels {
            return Ok(views);
        }
        positions = level.refine_values(&positions);
        positions_f32 = level.refine_values(&positions_f32);
        level = level.refine().map_err(text)?;
    }
}

/// OpenSubdiv's level as it is compared.
pub fn view(level: &OsdLevel) -> LevelView {
    let mut corners = level.face_vertices.iter().copied();
    // OpenSubdiv keeps a control mesh's values above 10, which mean the same as 10.
    let clamp = |&s: &f32| f64::from(s).min(subsurf::INFINITE_SHARPNESS);
    LevelView {
        faces: level.face_counts.iter().map(|&n| corners.by_ref().take(n as usize).collect()).collect(),
        holes: level.holes.clone(),
        edges: level.edges.clone(),
        edge_sharpness: level.edge_sharpness.iter().map(clamp).collect(),
        edge_non_manifold: level.edge_non_manifold.clone(),
        vertex_sharpness: level.vertex_sharpness.iter().map(clamp).collect(),
        vertex_non_manifold: level.vertex_non_manifold.clone(),
        positions: level.positions.clone(),
        positions_f32: level.positions_f32.clone(),
    }
}

/// Everything of one level, as a share of `diagonal` where it is a length.
pub fn compare(ours: &LevelView, theirs: &LevelView, diagonal: f64) -> Difference {
    let mut d = Difference::default();
    let m = &mut d.mismatches;
    same(m, "face", &ours.faces, &theirs.faces);
    same(m, "hole flag of face", &ours.holes, &theirs.holes);
    same(m, "edge", &ours.edges, &theirs.edges);
    same(m, "non-manifold flag of edge", &ours.edge_non_manifold, &theirs.edge_non_manifold);
    same(m, "non-manifold flag of vertex", &ours.vertex_non_manifold, &theirs.vertex_non_manifold);
    let scalar = |a: &f64, b: &f64| (a - b).abs();
    let edges = near(m, "sharpness of edge", &ours.edge_sharpness, &theirs.edge_sharpness, SHARPNESS_BOUND, scalar);
    let vertices =
        near(m, "sharpness of vertex", &ours.vertex_sharpness, &theirs.vertex_sharpness, SHARPNESS_BOUND, scalar);
    d.sharpness = edges.max(vertices);
    let distance = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt() / diagonal;
    d.f64 = near(m, "f64 position of vertex", &ours.positions, &theirs.positions, F64_BOUND, distance);
    let ours_f32: Vec<[f64; 3]> = ours.positions_f32.iter().map(|p| p.map(f64::from)).collect();
    d.f32 = near(m, "f32 position of vertex", &ours_f32, &theirs.positions, F32_BOUND, distance);
    d
}

/// Notes the first difference and how many there are.
fn same<T: PartialEq + std::fmt::Debug>(mismatches: &mut Vec<String>, what: &str, ours: &[T], theirs: &[T]) {
    let far = |a: &T, b: &T| if a == b { 0.0 } else { 1.0 };
    near(mismatches, what, ours, theirs, 0.0, far);
}

/// The largest distance; notes the first one above `bound` (or not a number) and how many there are.
fn near<T: std::fmt::Debug>(
    mismatches: &mut Vec<String>,
    what: &str,
    ours: &[T],
    theirs: &[T],
    bound: f64,
    distance: impl Fn(&T, &T) -> f64,
) -> f64 {
    if ours.len() != theirs.len() {
        mismatches.push(format!("{what}: ours are {}, theirs {}", ours.len(), theirs.len()));
    }
    let distances: Vec<f64> = ours.iter().zip(theirs).map(|(a, b)| distance(a, b)).collect();
    let far = |d: &f64| d.is_nan() || *d > bound;
    if let Some(first) = distances.iter().position(far) {
        let count = distances.iter().filter(|d| far(d)).count();
        mismatches.push(format!(
            "{what} {first}: ours {:?}, theirs {:?} ({count} of {} differ)",
            ours[first],
            theirs[first],
            ours.len()
        ));
    }
    distances.into_iter().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_difference_and_the_number_of_differences_are_told() {
        let mut mismatches = vec![];
        same(&mut mismatches, "edge", &[[0, 1], [1, 2], [2, 3]], &[[0, 1], [2, 1], [3, 2]]);
        assert_eq!(mismatches, ["edge 1: ours [1, 2], theirs [2, 1] (2 of 3 differ)"]);
    }

    #[test]
    fn a_difference_in_length_or_a_nan_is_a_mismatch() {
        let mut mismatches = vec![];
        near(&mut mismatches, "x", &[1.0, f64::NAN], &[1.0, 2.0, 3.0], 0.1, |a, b| (a - b).abs());
        assert_eq!(mismatches.len(), 2);
    }
}
