//! OpenSubdiv's evaluation of the limit surface: Bfr's surfaces and Far's patch tables, both in double precision.

use super::VertexOrder;
use super::refiner::{CShape, PeerRefiner, PeerShape, Refiner, or_error};
use crate::shape::Shape;
use std::ffi::{c_char, c_int};

unsafe extern "C" {
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
    fn peer_eval_patches(
        shape: *const PeerShape,
        points: *const [f64; 3],
        level: c_int,
        end_cap: c_int,
        samples: c_int,
        ptex_faces: *const c_int,
        uv: *const [f64; 2],
        jets: *mut Jet,
        error: *mut c_char,
        error_size: c_int,
    ) -> bool;
}

/// Position, first and second derivatives.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
#[repr(C)]
pub struct Jet {
    pub position: [f64; 3],
    pub du: [f64; 3],
    pub dv: [f64; 3],
    /// In uu, uv, vv.
    pub second: [[f64; 3]; 3],
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

/// What stands in for the surface where isolation ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum EndCap {
    BSpline = 2,
    GregoryBasis = 3,
}

/// Position and derivatives by `Far::PatchTable`, its features isolated to `level` (10 at most); NaN on holes.
///
/// # Errors
/// What OpenSubdiv says when it refuses the mesh.
pub fn eval_patches(shape: &Shape, samples: &[Sample], level: u32, end_cap: EndCap) -> Result<Vec<Jet>, String> {
    assert!((1..=10).contains(&level), "isolation is between 1 and 10");
    let faces: Vec<c_int> = samples.iter().map(|s| s.ptex_face as c_int).collect();
    let uv: Vec<[f64; 2]> = samples.iter().map(|s| s.uv).collect();
    let mut jets = vec![Jet::default(); samples.len()];
    let c = CShape::new(shape);
    or_error(shape, |error, size| {
        // SAFETY: the arrays have one entry a sample, the points are the shape's; faces out of range are left NaN.
        let done = unsafe {
            peer_eval_patches(
                &c.peer,
                shape.positions.as_ptr(),
                level as c_int,
                end_cap as c_int,
                samples.len() as c_int,
                faces.as_ptr(),
                uv.as_ptr(),
                jets.as_mut_ptr(),
                error,
                size,
            )
        };
        done.then_some(())
    })?;
    Ok(jets)
}
