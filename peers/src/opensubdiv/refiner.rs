//! A mesh handed to OpenSubdiv and refined there, as one C object.

use super::{Origin, OsdLevel, VertexOrder};
use crate::shape::{Scheme, Shape};
use std::ffi::{CStr, c_char, c_int};
use std::marker::PhantomData;
use subsurf::{Boundary, Creasing, FaceVarying, Triangles};

#[repr(C)]
pub(crate) struct PeerShape {
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
    value_count: c_int,
    value_indices: *const c_int,
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
}

/// A shape with its lists in C's integers, which must outlive what points at them.
pub(crate) struct CShape<'a> {
    pub(crate) peer: PeerShape,
    _lists: [Vec<c_int>; 6],
    _sharpness: [Vec<f32>; 2],
    _shape: PhantomData<&'a Shape>,
}

impl<'a> CShape<'a> {
    pub(crate) fn new(shape: &'a Shape) -> Self {
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
        let value_indices = shape.channel.as_ref().map_or(vec![], |c| ints(&c.indices));
        if let Some(channel) = &shape.channel {
            assert_eq!(channel.indices.len(), shape.indices.len(), "one value per face corner");
            assert!(channel.indices.iter().all(|&i| (i as usize) < channel.values.len()), "values exist");
        }
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
            value_count: shape.channel.as_ref().map_or(0, |c| c.values.len() as c_int),
            value_indices: value_indices.as_ptr(),
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
        let lists = [counts, indices, holes, crease_vertices, corner_vertices, value_indices];
        Self { peer, _lists: lists, _sharpness: [crease_sharpness, corner_sharpness], _shape: PhantomData }
    }
}

/// Runs `call` with room for an error text, which becomes the error where `call` returns none.
pub(crate) fn or_error<T>(shape: &Shape, call: impl FnOnce(*mut c_char, c_int) -> Option<T>) -> Result<T, String> {
    let mut error = [0 as c_char; 1000];
    call(error.as_mut_ptr(), error.len() as c_int).ok_or_else(|| {
        // SAFETY: the shim terminates the text.
        let text = unsafe { CStr::from_ptr(error.as_ptr()) };
        format!("{}: OpenSubdiv refuses it: {}", shape.name, text.to_string_lossy())
    })
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
        let c = CShape::new(shape);
        let faces_first = (order == VertexOrder::FacesFirst) as c_int;
        or_error(shape, |error, size| {
            // SAFETY: the arrays live until the call returns and have the lengths given; OpenSubdiv copies them. Tags
            // that name no element are refused by it.
            let refiner = unsafe { peer_refine(&c.peer, levels as c_int, faces_first, error, size) };
            (!refiner.is_null()).then_some(Self(refiner))
        })
    }

    /// Vertices, edges, faces, face corners.
    pub(super) fn counts(&self, level: u32) -> [usize; 4] {
        let mut counts = [0; 4];
        // SAFETY: the level exists, the array has four entries.
        unsafe { peer_level_counts(self.0, level as c_int, counts.as_mut_ptr()) };
        counts.map(|n| n as usize)
    }

    pub(super) fn level(&self, level: u32) -> OsdLevel {
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
