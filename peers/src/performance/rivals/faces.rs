//! OpenSubdiv's Bfr: one `Surface<float>` a face, at its default approximation (2 levels at smooth features, 6 at sharp
//! ones).

#![allow(unsafe_code)]

use super::patches::Frames;
use crate::opensubdiv::{CShape, PeerShape, or_error};
use crate::shape::Shape;
use std::ffi::{c_char, c_int};

#[repr(C)]
struct PeerFaces {
    _opaque: [u8; 0],
}

unsafe extern "C" {
    fn peer_faces(shape: *const PeerShape, error: *mut c_char, size: c_int) -> *mut PeerFaces;
    fn peer_faces_free(faces: *mut PeerFaces);
    fn peer_faces_init(faces: *mut PeerFaces, cached: c_int);
    fn peer_faces_prepare(faces: *mut PeerFaces, control: *const [f32; 3]);
    fn peer_faces_eval(
        faces: *const PeerFaces,
        of: *const c_int,
        uv: *const [f32; 2],
        count: c_int,
        position: *mut [f32; 3],
        du: *mut [f32; 3],
        dv: *mut [f32; 3],
    );
    fn peer_faces_parameters(faces: *const PeerFaces, face: c_int, subface: c_int, local: *const f32, uv: *mut f32);
}

/// A place in the domain of a face.
#[derive(Clone, Debug, Default)]
pub struct FacePlaces {
    faces: Vec<c_int>,
    uv: Vec<[f32; 2]>,
}

/// The surfaces of all faces of a mesh.
pub struct FaceSurfaces {
    surfaces: *mut PeerFaces,
    control: usize,
    faces: usize,
    prepared: bool,
}

impl Drop for FaceSurfaces {
    fn drop(&mut self) {
        // SAFETY: made by peer_faces, freed once.
        unsafe { peer_faces_free(self.surfaces) }
    }
}

impl FaceSurfaces {
    /// The mesh, with no surface initialised yet.
    ///
    /// # Errors
    /// What OpenSubdiv says when it refuses the mesh.
    pub fn new(mesh: &CShape<'_>, shape: &Shape) -> Result<Self, String> {
        or_error(shape, |error, size| {
            // SAFETY: the lists of `mesh` have the lengths it says; OpenSubdiv copies them.
            let surfaces = unsafe { peer_faces(&mesh.peer, error, size) };
            let (control, faces) = (shape.positions.len(), shape.counts.len());
            (!surfaces.is_null()).then_some(Self { surfaces, control, faces, prepared: false })
        })
    }

    /// `InitVertexSurface` of every face, from a new factory.
    pub fn init(&mut self, cached: bool) {
        // SAFETY: the surfaces are ours alone.
        unsafe { peer_faces_init(self.surfaces, c_int::from(cached)) };
    }

    /// `PreparePatchPoints` of every face: once per frame.
    pub fn prepare(&mut self, control: &[[f32; 3]]) {
        assert_eq!(control.len(), self.control, "one point per control point");
        // SAFETY: as above, and the array has one point per vertex.
        unsafe { peer_faces_prepare(self.surfaces, control.as_ptr()) };
        self.prepared = true;
    }

    /// Places in the domains of their faces, from faces, sub-faces and parameters there; surfaces are initialised.
    pub fn places(&self, at: impl Iterator<Item = (u32, u32, [f32; 2])>) -> FacePlaces {
        let mut places = FacePlaces::default();
        for (face, subface, local) in at {
            assert!((face as usize) < self.faces, "face {face} exists");
            let mut uv = [0.0; 2];
            // SAFETY: the face exists; two numbers are read and written.
            unsafe {
                let (face, subface) = (face as c_int, subface as c_int);
                peer_faces_parameters(self.surfaces, face, subface, local.as_ptr(), uv.as_mut_ptr());
            }
            places.faces.push(face as c_int);
            places.uv.push(uv);
        }
        places
    }

    /// `Surface::Evaluate` of position and first derivatives, patch points prepared.
    pub fn eval(&self, places: &FacePlaces, out: &mut Frames) {
        assert!(self.prepared, "patch points are computed first");
        let [position, du, dv] = out.pointers(places.faces.len());
        let count = places.faces.len() as c_int;
        // SAFETY: faces exist, as `places` has seen; the arrays have one row per place.
        unsafe {
            peer_faces_eval(self.surfaces, places.faces.as_ptr(), places.uv.as_ptr(), count, position, du, dv);
        }
    }
}
