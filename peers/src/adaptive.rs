//! OpenSubdiv's feature-adaptive refinement and Ptex adjacency behind a safe interface.

#![allow(unsafe_code)]

use crate::opensubdiv::{PeerRefiner, Refiner, VertexOrder};
use crate::shape::Shape;
use std::ffi::c_int;

/// A patch of OpenSubdiv's patch table.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
#[repr(C)]
pub struct OsdPatch {
    pub ptex_face: c_int,
    /// Corner 0 in units of the patch; of triangles that are turned upside down counted from (1,1).
    pub u: c_int,
    pub v: c_int,
    pub depth: c_int,
    pub regular: c_int,
    pub sides: c_int,
    pub non_quad_root: c_int,
    pub sharpness: f32,
}

#[repr(C)]
struct PeerAdaptive {
    _opaque: [u8; 0],
}

unsafe extern "C" {
    fn peer_adaptive(refiner: *mut PeerRefiner, isolation: c_int, single_crease: c_int) -> *mut PeerAdaptive;
    fn peer_adaptive_free(adaptive: *mut PeerAdaptive);
    fn peer_adaptive_counts(adaptive: *const PeerAdaptive, counts: *mut i64, sizes: *mut i64);
    fn peer_adaptive_fill(adaptive: *const PeerAdaptive, patches: *mut OsdPatch, vertices: *mut c_int);
    fn peer_ptex_faces(refiner: *const PeerRefiner) -> c_int;
    fn peer_ptex_adjacency(refiner: *const PeerRefiner, first: *mut c_int, faces: *mut c_int, edges: *mut c_int);
}

/// What OpenSubdiv makes of a mesh.
pub struct OsdAdaptive {
    pub patches: Vec<OsdPatch>,
    /// Vertices by level, those of the control mesh first.
    pub vertices: Vec<usize>,
    /// Control-point indices of all patches.
    pub indices: usize,
    /// Points that end caps add (shared between neighbours).
    pub end_cap_points: usize,
    /// Weights of masks from level to level.
    pub mask_weights: usize,
    /// Weights of the end caps' points over refined points.
    pub end_cap_weights: usize,
    /// Weights of all refined points and end caps over control points.
    pub stencil_weights: usize,
}

/// Feature-adaptive refinement and patch table, with infinitely-sharp patches and Gregory end caps.
///
/// # Errors
/// What OpenSubdiv says when it refuses the mesh.
pub fn refine(shape: &Shape, isolation: u32, single_crease: bool) -> Result<OsdAdaptive, String> {
    assert!((1..=10).contains(&isolation), "patches keep ten bits per parameter");
    let refiner = Refiner::new(shape, 0, VertexOrder::default())?;
    let (mut counts, mut sizes) = ([0i64; 2], [0i64; 5]);
    // SAFETY: the refiner has no levels yet; the arrays have the lengths that the first call gives.
    unsafe {
        let adaptive = peer_adaptive(refiner.0, isolation as c_int, single_crease as c_int);
        peer_adaptive_counts(adaptive, counts.as_mut_ptr(), sizes.as_mut_ptr());
        let mut patches = vec![OsdPatch::default(); counts[0] as usize];
        let mut vertices = vec![0; counts[1] as usize];
        peer_adaptive_fill(adaptive, patches.as_mut_ptr(), vertices.as_mut_ptr());
        peer_adaptive_free(adaptive);
        let [indices, end_cap_points, mask_weights, end_cap_weights, stencil_weights] = sizes.map(|n| n as usize);
        Ok(OsdAdaptive {
            patches,
            vertices: vertices.into_iter().map(|n| n as usize).collect(),
            indices,
            end_cap_points,
            mask_weights,
            end_cap_weights,
            stencil_weights,
        })
    }
}

/// First Ptex face of every face, and for every Ptex face what lies across its four edges: face and edge there.
pub type PtexAdjacency = (Vec<u32>, Vec<[Option<(u32, u8)>; 4]>);

/// Ptex numbers and neighbours.
///
/// # Errors
/// What OpenSubdiv says when it refuses the mesh.
pub fn ptex(shape: &Shape) -> Result<PtexAdjacency, String> {
    let refiner = Refiner::new(shape, 0, VertexOrder::default())?;
    // SAFETY: the arrays have an entry for every face, four for every Ptex face.
    unsafe {
        let count = peer_ptex_faces(refiner.0) as usize;
        let mut first = vec![0; shape.counts.len()];
        let (mut faces, mut edges) = (vec![[-1; 4]; count], vec![[0; 4]; count]);
        peer_ptex_adjacency(refiner.0, first.as_mut_ptr(), faces.as_mut_ptr().cast(), edges.as_mut_ptr().cast());
        let across = |(faces, edges): (&[c_int; 4], &[c_int; 4])| {
            std::array::from_fn(|i| (faces[i] >= 0).then_some((faces[i] as u32, edges[i] as u8)))
        };
        Ok((first.into_iter().map(|id| id as u32).collect(), faces.iter().zip(&edges).map(across).collect()))
    }
}
