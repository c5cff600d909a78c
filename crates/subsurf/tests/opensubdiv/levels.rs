//! Classical refinement against OpenSubdiv's, element by element.

use crate::opensubdiv_shapes::{Shape, index, indices, point, rows, shapes, sharpness};
use crate::reference::{apart, diagonal, has_fractions};
use serde_json::Value;
use subsurf::{Creasing, Edge, Face, Level, Topology, Vertex};

/// 64-bit FNV-1a over the bytes of the words, low byte first.
fn fnv1a(words: impl IntoIterator<Item = u32>) -> String {
    let bytes = words.into_iter().flat_map(u32::to_le_bytes);
    let hash = bytes.fold(0xcbf2_9ce4_8422_2325u64, |h, byte| (h ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3));
    format!("{hash:016x}")
}

/// A list must have the reference's length, first entries and hash.
fn same_list(what: &str, ours: &[Vec<u32>], words: Vec<u32>, theirs: &Value) {
    assert_eq!(ours.len() as u64, theirs["count"].as_u64().unwrap(), "{what}: how many");
    for (i, (a, b)) in ours.iter().zip(rows(&theirs["first"])).enumerate() {
        let b = b.as_u64().map_or_else(|| indices(b), |b| vec![b as u32]);
        assert_eq!(*a, b, "{what} {i}");
    }
    assert_eq!(fnv1a(words), theirs["hash"].as_str().unwrap(), "{what}: an entry beyond those listed differs");
}

/// The elements of positive sharpness and their values. `slack` is what OpenSubdiv's single precision may add.
fn same_sharpness(what: &str, ours: impl Iterator<Item = f64>, theirs: &Value, slack: f64) {
    let ours: Vec<(u32, f64)> = (0..).zip(ours).filter(|&(_, s)| s > 0.0).collect();
    assert_eq!(ours.len() as u64, theirs["count"].as_u64().unwrap(), "{what}: how many");
    let first = rows(&theirs["first"]);
    for (a, b) in ours.iter().zip(first) {
        assert_eq!(a.0, index(&b[0]), "{what}: which");
        // OpenSubdiv keeps a control mesh's values above 10, which mean the same as 10.
        let theirs = sharpness(&b[1]).min(10.0);
        assert!((a.1 - theirs).abs() <= slack, "{what} {}: {} and {theirs}", a.0, a.1);
    }
    if slack == 0.0 && first.len() < ours.len() {
        let words = ours.iter().flat_map(|&(i, s)| [i, (s as f32).to_bits()]);
        assert_eq!(fnv1a(words), theirs["hash"].as_str().unwrap(), "{what}: an entry beyond those listed differs");
    }
}

fn flags(count: usize, flag: impl Fn(u32) -> bool) -> Vec<u32> {
    (0..count as u32).filter(|&i| flag(i)).collect()
}

fn same_flags(what: &str, ours: Vec<u32>, theirs: &Value) {
    let lists: Vec<Vec<u32>> = ours.iter().map(|&i| vec![i]).collect();
    same_list(what, &lists, ours, theirs);
}

fn same_topology(name: &str, t: &Topology, theirs: &Value, depth: u32) {
    let what = |kind: &str| format!("{name} level {depth}, {kind}");
    t.check().unwrap_or_else(|e| panic!("{}: {e}", what("check")));
    assert_eq!(t.vertex_count() as u64, theirs["vertices"].as_u64().unwrap(), "{}", what("vertices"));
    let faces: Vec<Vec<u32>> = (0..t.face_count() as u32).map(|f| t.face_vertices(Face(f)).to_vec()).collect();
    let words = faces.iter().flat_map(|f| std::iter::once(f.len() as u32).chain(f.iter().copied())).collect();
    same_list(&what("face"), &faces, words, &theirs["faces"]);
    let edges: Vec<Vec<u32>> =
        (0..t.edge_count() as u32).map(|e| t.edge_vertices(Edge(e)).map(|v| v.0).to_vec()).collect();
    same_list(&what("edge"), &edges, edges.concat(), &theirs["edges"]);
    // Chaikin's averages of numbers up to 10 are formed in single precision there, once per level.
    let slack = if t.rules().creasing == Creasing::Chaikin { 4e-6 } else { 0.0 };
    let sharpness = (0..t.edge_count() as u32).map(|e| t.edge_sharpness(Edge(e)));
    same_sharpness(&what("edge sharpness"), sharpness, &theirs["sharp_edges"], slack);
    let sharpness = (0..t.vertex_count() as u32).map(|v| t.vertex_sharpness(Vertex(v)));
    same_sharpness(&what("vertex sharpness"), sharpness, &theirs["sharp_vertices"], 0.0);
    let holes = flags(t.face_count(), |f| t.is_hole(Face(f)));
    same_flags(&what("hole"), holes, &theirs["holes"]);
    let edges = flags(t.edge_count(), |e| t.is_non_manifold_edge(Edge(e)));
    same_flags(&what("non-manifold edge"), edges, &theirs["non_manifold_edges"]);
    let vertices = flags(t.vertex_count(), |v| t.is_non_manifold_vertex(Vertex(v)));
    same_flags(&what("non-manifold vertex"), vertices, &theirs["non_manifold_vertices"]);
}

fn levels(shape: &Shape) -> Vec<Level> {
    let mut levels = vec![Level::new(&shape.mesh, shape.scheme).unwrap()];
    while levels.len() < shape.levels.len() {
        levels.push(levels[levels.len() - 1].refine().unwrap());
    }
    levels
}

#[test]
fn connectivity_order_sharpness_and_flags_are_those_of_opensubdiv_on_levels_0_to_3() {
    for shape in shapes() {
        for (level, theirs) in levels(&shape).iter().zip(&shape.levels) {
            same_topology(&shape.name, level.topology(), theirs, level.depth());
        }
    }
}

#[test]
fn positions_are_those_of_opensubdiv_on_levels_1_to_3() {
    let (mut worst, mut worst_fraction, mut worst_f32) = (0.0f64, 0.0f64, 0.0f64);
    for shape in shapes() {
        let size = diagonal(&shape.positions);
        let mut points = shape.positions.clone();
        let mut single: Vec<[f32; 3]> = points.iter().map(|p| p.map(|x| x as f32)).collect();
        let mut fractions = false;
        for (level, theirs) in levels(&shape).iter().zip(&shape.levels[1..]) {
            fractions |= has_fractions(level.topology());
            points = level.refine_values(&points);
            single = level.refine_values(&single);
            // Plain sums in double precision: a few roundings a level. Fractions: a weight rounded to single precision,
            // 6e-8 at most, times a difference of points.
            let bound = if fractions { 2e-8 } else { 1e-12 };
            let stride = theirs["position_stride"].as_u64().unwrap() as usize;
            let expected = rows(&theirs["positions"]);
            assert_eq!(expected.len(), points.len().div_ceil(stride));
            for (v, p) in (0..).step_by(stride).zip(expected) {
                let what = format!("{} level {} vertex {v}", shape.name, level.depth() + 1);
                let error = apart(points[v], point(p)) / size;
                assert!(error <= bound, "{what}: {error:e}");
                // Control points and each level's results are rounded to single precision: 6e-8 of a coordinate each.
                let error_f32 = apart(single[v].map(f64::from), point(p)) / size;
                assert!(error_f32 <= 1e-6, "{what} in f32: {error_f32:e}");
                let slot = if fractions { &mut worst_fraction } else { &mut worst };
                *slot = slot.max(error);
                worst_f32 = worst_f32.max(error_f32);
            }
        }
    }
    println!("worst: f64 {worst:.1e}, with fractions {worst_fraction:.1e}, f32 {worst_f32:.1e} of the box");
}
