//! OpenSubdiv behind a safe interface: uniform refinement with full topology, limits, evaluation, face-varying values.

#![allow(unsafe_code)]

mod face_varying;
mod refiner;
mod surface;

pub use face_varying::{ChannelLevel, limit_channel, refine_channel, takes_one_value_for_two};
pub use surface::{Approximation, EndCap, Jet, Sample, eval, eval_patches};

use crate::shape::Shape;
pub(crate) use refiner::{CShape, PeerRefiner, PeerShape, Refiner, or_error};
use std::ffi::c_int;

unsafe extern "C" {
    safe fn peer_version() -> c_int;
    fn peer_positions_f64(refiner: *const PeerRefiner, points: *mut [f64; 3]);
    fn peer_positions_f32(refiner: *const PeerRefiner, points: *mut [f32; 3]);
    fn peer_limit(
        refiner: *const PeerRefiner,
        points: *const [f64; 3],
        position: *mut [f64; 3],
        tangent1: *mut [f64; 3],
        tangent2: *mut [f64; 3],
    );
}

/// "3.7.0" and the like.
pub fn version() -> String {
    let number = peer_version();
    format!("{}.{}.{}", number / 10000, number / 100 % 100, number % 100)
}

/// Where the vertices of a refined level stand.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum VertexOrder {
    /// Children of vertices, then of faces, then of edges: OpenSubdiv's default.
    #[default]
    VerticesFirst,
    /// Children of faces, then of edges, then of vertices.
    FacesFirst,
}

/// Which element of the level before a vertex comes from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Origin {
    Vertex(u32),
    Edge(u32),
    Face(u32),
}

/// One refinement level. Everything is in OpenSubdiv's order.
#[derive(Clone, Debug)]
pub struct OsdLevel {
    pub face_counts: Vec<u32>,
    /// Vertices of all face corners.
    pub face_vertices: Vec<u32>,
    /// Edge from each face corner to the next.
    pub face_edges: Vec<u32>,
    pub holes: Vec<bool>,
    pub edges: Vec<[u32; 2]>,
    pub edge_sharpness: Vec<f32>,
    pub edge_non_manifold: Vec<bool>,
    pub edge_face_counts: Vec<u32>,
    pub vertex_sharpness: Vec<f32>,
    pub vertex_non_manifold: Vec<bool>,
    /// `Sdc::Crease::Rule`: 1 smooth, 2 dart, 4 crease, 8 corner.
    pub vertex_rules: Vec<u8>,
    /// Empty at level 0.
    pub vertex_origins: Vec<Origin>,
    pub positions: Vec<[f64; 3]>,
    /// Interpolated in single precision from the level before, itself in single precision.
    pub positions_f32: Vec<[f32; 3]>,
}

/// A vertex in the limit: its position, and two tangents.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Limit {
    pub position: [f64; 3],
    pub tangents: [[f64; 3]; 2],
}

/// Refines `shape` `levels` times; the result starts with level 0.
///
/// # Errors
/// What OpenSubdiv says when it refuses the mesh.
pub fn refine(shape: &Shape, levels: u32, order: VertexOrder) -> Result<Vec<OsdLevel>, String> {
    let refiner = Refiner::new(shape, levels, order)?;
    let mut all: Vec<OsdLevel> = (0..=levels).map(|level| refiner.level(level)).collect();

    let total = all.iter().map(|l| l.vertex_sharpness.len()).sum();
    let mut points = shape.positions.clone();
    let mut points_f32: Vec<[f32; 3]> = points.iter().map(|p| p.map(|x| x as f32)).collect();
    points.resize(total, [0.0; 3]);
    points_f32.resize(total, [0.0; 3]);
    // SAFETY: the arrays hold all levels' points.
    unsafe {
        peer_positions_f64(refiner.0, points.as_mut_ptr());
        peer_positions_f32(refiner.0, points_f32.as_mut_ptr());
    }
    let mut start = 0;
    for level in &mut all {
        let range = start..start + level.vertex_sharpness.len();
        level.positions = points[range.clone()].to_vec();
        level.positions_f32 = points_f32[range.clone()].to_vec();
        start = range.end;
    }
    Ok(all)
}

/// OpenSubdiv's limit of the vertices of `level`, in their order: `PrimvarRefiner::Limit`.
///
/// # Errors
/// What OpenSubdiv says when it refuses the mesh. A vertex with more faces than any vertex has edges (as on an edge of
/// many faces), for whose tangents OpenSubdiv 3.7 writes beyond its buffers.
pub fn limit(shape: &Shape, level: u32, order: VertexOrder) -> Result<Vec<Limit>, String> {
    let finest = refine(shape, level, order)?.pop().expect("level 0 at least");
    let n = finest.positions.len();
    let (mut faces, mut edges) = (vec![0u32; n], vec![0u32; n]);
    finest.face_vertices.iter().for_each(|&v| faces[v as usize] += 1);
    finest.edges.iter().flatten().for_each(|&v| edges[v as usize] += 1);
    let most = edges.iter().copied().max().unwrap_or(0);
    if let Some(v) = faces.iter().position(|&n| n > most) {
        let (name, n) = (&shape.name, faces[v]);
        return Err(format!(
            "{name}: limit of level {level}: vertex {v} has {n} faces, and no vertex more than {most} edges"
        ));
    }
    let refiner = Refiner::new(shape, level, order)?;
    let [mut position, mut tangent1, mut tangent2] = [0; 3].map(|_| vec![[0.0; 3]; n]);
    // SAFETY: all arrays have as many points as the finest level.
    unsafe {
        peer_limit(
            refiner.0,
            finest.positions.as_ptr(),
            position.as_mut_ptr(),
            tangent1.as_mut_ptr(),
            tangent2.as_mut_ptr(),
        );
    }
    Ok((0..n).map(|i| Limit { position: position[i], tangents: [tangent1[i], tangent2[i]] }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> Shape {
        let text = "v -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 -1\nv 1 -1 -1\n\
            f 1 2 4 3\nf 3 4 6 5\nf 5 6 8 7\nf 7 8 2 1\nf 2 8 6 4\nf 7 1 3 5";
        Shape::parse("catmark_cube", text).unwrap()
    }

    #[test]
    fn a_refined_cube_has_its_known_counts_and_order() {
        let levels = refine(&cube(), 2, VertexOrder::VerticesFirst).unwrap();
        let counts: Vec<_> = levels.iter().map(|l| (l.positions.len(), l.edges.len(), l.holes.len())).collect();
        assert_eq!(counts, [(8, 12, 6), (26, 48, 24), (98, 192, 96)]);
        assert_eq!(levels[1].vertex_origins[0], Origin::Vertex(0));
        assert_eq!(levels[1].vertex_origins[8], Origin::Face(0));
        assert_eq!(levels[1].vertex_origins[14], Origin::Edge(0));
        assert_eq!(levels[1].positions[8], [0.0, 0.0, 1.0]);
        let levels = refine(&cube(), 1, VertexOrder::FacesFirst).unwrap();
        assert_eq!(levels[1].vertex_origins[0], Origin::Face(0));
    }

    #[test]
    fn limit_and_evaluation_agree_at_a_corner_of_a_face() {
        // A regular vertex appears at level 1 in the middle of face 0.
        let limit = limit(&cube(), 1, VertexOrder::VerticesFirst).unwrap()[8].position;
        let sample = Sample { ptex_face: 0, uv: [0.5, 0.5] };
        let eval = eval(&cube(), &[sample], Approximation::default()).unwrap()[0].position;
        for k in 0..3 {
            assert!((limit[k] - eval[k]).abs() < 1e-12, "{limit:?} {eval:?}");
        }
    }

    #[test]
    fn a_crease_that_is_no_edge_is_ignored() {
        let mut shape = cube();
        shape.tags.creases.push(subsurf::Crease::new(0, 5, 2.0));
        let levels = refine(&shape, 1, VertexOrder::default()).unwrap();
        assert!(levels[1].edge_sharpness.iter().all(|&s| s == 0.0));
    }

    #[test]
    #[ignore = "needs ../shared/models; cargo test -- --ignored"]
    fn limits_and_samples_of_every_regression_shape_are_finite() {
        for shape in crate::shape::shapes(&crate::shapes_folder(), &["catmark_", "bilinear_", "loop_"]).unwrap() {
            // An error where OpenSubdiv would write beyond its buffers.
            let limits = limit(&shape, 2, VertexOrder::default()).unwrap_or_default();
            assert!(limits.iter().all(|l| l.position.iter().all(|x| x.is_finite())), "{}", shape.name);
            let sample = |f| Sample { ptex_face: f, uv: [0.25, 0.5] };
            let samples: Vec<Sample> = (0..shape.counts.len() as u32).map(sample).collect();
            let jets = eval(&shape, &samples, Approximation::default()).unwrap();
            // All but the faces that boundary rule "none" and tags turn into holes have a surface.
            assert!(jets.iter().any(|j| j.position.iter().all(|x| x.is_finite())), "{}", shape.name);
        }
    }
}
