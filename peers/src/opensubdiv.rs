//! OpenSubdiv behind a safe interface: uniform refinement with full topology, limits, and evaluation.

#![allow(unsafe_code)]

use crate::shape::{Scheme, Shape};
use std::ffi::{CStr, c_char, c_int};
use subsurf::{Boundary, Creasing, FaceVarying, Triangles};

#[repr(C)]
struct PeerShape {
    vertex_count: c_int,
    face_count: c_int,
    counts: *const c_int,
    indices: *const c_int,
    crease_count: c_int,
    crease_vertices: *const c_int,
    crease_sharpness: *const f32,
    corner_count: c_int,
    corner_vertices: *const c_int,
    corner_sharpness: *const f32,
    hole_count: c_int,
    holes: *const c_int,
    scheme: c_int,
    boundary: c_int,
    creasing: c_int,
    triangles: c_int,
    face_varying: c_int,
}

#[repr(C)]
pub(crate) struct PeerRefiner {
    _opaque: [u8; 0],
}

unsafe extern "C" {
    safe fn peer_version() -> c_int;
    fn peer_refine(
        shape: *const PeerShape,
        levels: c_int,
        faces_first: c_int,
        error: *mut c_char,
        error_size: c_int,
    ) -> *mut PeerRefiner;
    fn peer_free(refiner: *mut PeerRefiner);
    fn peer_level_counts(refiner: *const PeerRefiner, level: c_int, counts: *mut c_int);
    fn peer_level_faces(
        refiner: *const PeerRefiner,
        level: c_int,
        counts: *mut u32,
        vertices: *mut u32,
        edges: *mut u32,
        holes: *mut bool,
    );
    fn peer_level_edges(
        refiner: *const PeerRefiner,
        level: c_int,
        vertices: *mut [u32; 2],
        sharpness: *mut f32,
        non_manifold: *mut bool,
        face_counts: *mut u32,
    );
    fn peer_level_vertices(
        refiner: *const PeerRefiner,
        level: c_int,
        sharpness: *mut f32,
        non_manifold: *mut bool,
        rules: *mut u8,
    );
    fn peer_level_origins(refiner: *const PeerRefiner, level: c_int, kinds: *mut u8, parents: *mut u32);
    fn peer_positions_f64(refiner: *const PeerRefiner, points: *mut [f64; 3]);
    fn peer_positions_f32(refiner: *const PeerRefiner, points: *mut [f32; 3]);
    fn peer_limit(
        refiner: *const PeerRefiner,
        points: *const [f64; 3],
        position: *mut [f64; 3],
        tangent1: *mut [f64; 3],
        tangent2: *mut [f64; 3],
    );
    fn peer_eval(
        refiner: *const PeerRefiner,
        points: *const [f64; 3],
        samples: c_int,
        ptex_faces: *const c_int,
        uv: *const [f64; 2],
        approx_smooth: c_int,
        approx_sharp: c_int,
        jets: *mut Jet,
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

/// Position and first derivatives.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
#[repr(C)]
pub struct Jet {
    pub position: [f64; 3],
    pub du: [f64; 3],
    pub dv: [f64; 3],
}

/// A point of the surface: a ptex face (a quad is one; under Catmull-Clark an n-gon is n, one per corner) and
/// coordinates in its unit square.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Sample {
    pub ptex_face: u32,
    pub uv: [f64; 2],
}

/// How closely irregular faces are evaluated: depth of isolation at smooth and at sharp features.
#[derive(Clone, Copy, Debug)]
pub struct Approximation {
    pub smooth: u32,
    pub sharp: u32,
}

impl Default for Approximation {
    /// The deepest that OpenSubdiv offers.
    fn default() -> Self {
        Self { smooth: 10, sharp: 10 }
    }
}

pub(crate) struct Refiner(pub(crate) *mut PeerRefiner);

impl Drop for Refiner {
    fn drop(&mut self) {
        // SAFETY: the pointer came from peer_refine and is freed once.
        unsafe { peer_free(self.0) }
    }
}

impl Refiner {
    pub(crate) fn new(shape: &Shape, levels: u32, order: VertexOrder) -> Result<Self, String> {
        assert!(levels < 16, "OpenSubdiv stores the level in four bits");
        let ints = |values: &[u32]| -> Vec<c_int> { values.iter().map(|&v| v as c_int).collect() };
        let (counts, indices, holes) = (ints(&shape.counts), ints(&shape.indices), ints(&shape.tags.holes));
        let total: u32 = shape.counts.iter().sum();
        assert_eq!(total as usize, indices.len(), "face sizes add up");
        let vertices = shape.positions.len();
        assert!(shape.indices.iter().all(|&v| (v as usize) < vertices), "faces name vertices that exist");
        let crease_vertices = ints(&shape.tags.creases.iter().flat_map(|c| c.vertices).collect::<Vec<_>>());
        let crease_sharpness: Vec<f32> = shape.tags.creases.iter().map(|c| c.sharpness as f32).collect();
        let corner_vertices = ints(&shape.tags.corners.iter().map(|c| c.vertex).collect::<Vec<_>>());
        let corner_sharpness: Vec<f32> = shape.tags.corners.iter().map(|c| c.sharpness as f32).collect();
        let rules = shape.tags.rules;
        let peer = PeerShape {
            vertex_count: vertices as c_int,
            face_count: counts.len() as c_int,
            counts: counts.as_ptr(),
            indices: indices.as_ptr(),
            crease_count: crease_sharpness.len() as c_int,
            crease_vertices: crease_vertices.as_ptr(),
            crease_sharpness: crease_sharpness.as_ptr(),
            corner_count: corner_sharpness.len() as c_int,
            corner_vertices: corner_vertices.as_ptr(),
            corner_sharpness: corner_sharpness.as_ptr(),
            hole_count: holes.len() as c_int,
            holes: holes.as_ptr(),
            scheme: match shape.scheme {
                Scheme::Bilinear => 0,
                Scheme::CatmullClark => 1,
                Scheme::Loop => 2,
            },
            boundary: match rules.boundary {
                Boundary::None => 0,
                Boundary::EdgeOnly => 1,
                Boundary::EdgeAndCorner => 2,
            },
            creasing: match rules.creasing {
                Creasing::Uniform => 0,
                Creasing::Chaikin => 1,
            },
            triangles: match rules.triangles {
                Triangles::CatmullClark => 0,
                Triangles::Smooth => 1,
            },
            face_varying: match rules.face_varying {
                FaceVarying::None => 0,
                FaceVarying::CornersOnly => 1,
                FaceVarying::CornersPlus1 => 2,
                FaceVarying::CornersPlus2 => 3,
                FaceVarying::Boundaries => 4,
                FaceVarying::All => 5,
            },
        };
        let mut error = [0 as c_char; 1000];
        let faces_first = (order == VertexOrder::FacesFirst) as c_int;
        // SAFETY: the arrays live until the call returns and have the lengths given; OpenSubdiv copies them. Tags that
        // name no element are refused by it.
        let refiner =
            unsafe { peer_refine(&peer, levels as c_int, faces_first, error.as_mut_ptr(), error.len() as c_int) };
        if refiner.is_null() {
            // SAFETY: peer_refine terminates the text.
            let text = unsafe { CStr::from_ptr(error.as_ptr()) };
            return Err(format!("{}: OpenSubdiv refuses it: {}", shape.name, text.to_string_lossy()));
        }
        Ok(Self(refiner))
    }

    /// Vertices, edges, faces, face corners.
    fn counts(&self, level: u32) -> [usize; 4] {
        let mut counts = [0; 4];
        // SAFETY: the level exists, the array has four entries.
        unsafe { peer_level_counts(self.0, level as c_int, counts.as_mut_ptr()) };
        counts.map(|n| n as usize)
    }

    fn level(&self, level: u32) -> OsdLevel {
        let [vertices, edges, faces, corners] = self.counts(level);
        let mut l = OsdLevel {
            face_counts: vec![0; faces],
            face_vertices: vec![0; corners],
            face_edges: vec![0; corners],
            holes: vec![false; faces],
            edges: vec![[0; 2]; edges],
            edge_sharpness: vec![0.0; edges],
            edge_non_manifold: vec![false; edges],
            edge_face_counts: vec![0; edges],
            vertex_sharpness: vec![0.0; vertices],
            vertex_non_manifold: vec![false; vertices],
            vertex_rules: vec![0; vertices],
            vertex_origins: vec![],
            positions: vec![],
            positions_f32: vec![],
        };
        let (mut kinds, mut parents) = (vec![u8::MAX; vertices], vec![0; vertices]);
        let n = level as c_int;
        // SAFETY: every array has the length that peer_level_counts gives for this level.
        unsafe {
            peer_level_faces(
                self.0,
                n,
                l.face_counts.as_mut_ptr(),
                l.face_vertices.as_mut_ptr(),
                l.face_edges.as_mut_ptr(),
                l.holes.as_mut_ptr(),
            );
            peer_level_edges(
                self.0,
                n,
                l.edges.as_mut_ptr(),
                l.edge_sharpness.as_mut_ptr(),
                l.edge_non_manifold.as_mut_ptr(),
                l.edge_face_counts.as_mut_ptr(),
            );
            peer_level_vertices(
                self.0,
                n,
                l.vertex_sharpness.as_mut_ptr(),
                l.vertex_non_manifold.as_mut_ptr(),
                l.vertex_rules.as_mut_ptr(),
            );
            if level > 0 {
                peer_level_origins(self.0, n, kinds.as_mut_ptr(), parents.as_mut_ptr());
            }
        }
        if level > 0 {
            let origin = |(&kind, &parent): (&u8, &u32)| match kind {
                0 => Origin::Vertex(parent),
                1 => Origin::Edge(parent),
                2 => Origin::Face(parent),
                _ => panic!("a vertex of level {level} has no parent"),
            };
            l.vertex_origins = kinds.iter().zip(&parents).map(origin).collect();
        }
        l
    }
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

/// OpenSubdiv's limit of the vertices of `level`, in their order: position, and two tangents as `du` and `dv`.
///
/// # Errors
/// What OpenSubdiv says when it refuses the mesh.
pub fn limit(shape: &Shape, level: u32, order: VertexOrder) -> Result<Vec<Jet>, String> {
    let finest = refine(shape, level, order)?.pop().expect("level 0 at least");
    let refiner = Refiner::new(shape, level, order)?;
    let n = finest.positions.len();
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
    Ok((0..n).map(|i| Jet { position: position[i], du: tangent1[i], dv: tangent2[i] }).collect())
}

/// Position and derivatives of the limit surface by OpenSubdiv's `Bfr::Surface<double>`; NaN on holes. Samples of the
/// same face should follow one another.
///
/// # Errors
/// What OpenSubdiv says when it refuses the mesh.
pub fn eval(shape: &Shape, samples: &[Sample], approximation: Approximation) -> Result<Vec<Jet>, String> {
    let refiner = Refiner::new(shape, 0, VertexOrder::default())?;
    let faces: Vec<c_int> = samples.iter().map(|s| s.ptex_face as c_int).collect();
    let uv: Vec<[f64; 2]> = samples.iter().map(|s| s.uv).collect();
    let mut jets = vec![Jet::default(); samples.len()];
    // SAFETY: the arrays have one entry a sample; faces out of range are left NaN.
    unsafe {
        peer_eval(
            refiner.0,
            shape.positions.as_ptr(),
            samples.len() as c_int,
            faces.as_ptr(),
            uv.as_ptr(),
            approximation.smooth as c_int,
            approximation.sharp as c_int,
            jets.as_mut_ptr(),
        );
    }
    Ok(jets)
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
            let jets = limit(&shape, 2, VertexOrder::default()).unwrap();
            assert!(jets.iter().all(|j| j.position.iter().all(|x| x.is_finite())), "{}", shape.name);
            let sample = |f| Sample { ptex_face: f, uv: [0.25, 0.5] };
            let samples: Vec<Sample> = (0..shape.counts.len() as u32).map(sample).collect();
            let jets = eval(&shape, &samples, Approximation::default()).unwrap();
            // All but the faces that boundary rule "none" and tags turn into holes have a surface.
            assert!(jets.iter().any(|j| j.position.iter().all(|x| x.is_finite())), "{}", shape.name);
        }
    }
}
