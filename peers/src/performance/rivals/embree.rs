//! Embree's subdivision geometry, where its library was found when this program was built.

#![allow(unsafe_code)]

use super::patches::Frames;
use crate::opensubdiv::CShape;
use crate::shape::Shape;

/// Faces and parameters, all faces quads.
#[derive(Clone, Debug, Default)]
pub struct QuadPlaces {
    pub faces: Vec<u32>,
    pub u: Vec<f32>,
    pub v: Vec<f32>,
}

#[cfg(embree)]
mod linked {
    use super::*;
    use crate::opensubdiv::PeerShape;
    use std::ffi::{c_int, c_uint};

    #[repr(C)]
    struct PeerEmbree {
        _opaque: [u8; 0],
    }

    unsafe extern "C" {
        safe fn peer_embree_version() -> c_int;
        fn peer_embree(shape: *const PeerShape, points: *const [f32; 3]) -> *mut PeerEmbree;
        fn peer_embree_free(scene: *mut PeerEmbree);
        fn peer_embree_eval(
            scene: *const PeerEmbree,
            faces: *const c_uint,
            u: *const f32,
            v: *const f32,
            count: c_int,
            position: *mut [f32; 3],
            du: *mut [f32; 3],
            dv: *mut [f32; 3],
        );
        fn peer_embree_eval_many(
            scene: *const PeerEmbree,
            faces: *const c_uint,
            u: *const f32,
            v: *const f32,
            count: c_int,
            results: *mut f32,
        );
    }

    /// "3.13.5", say.
    pub fn version() -> Option<String> {
        let v = peer_embree_version();
        Some(format!("{}.{}.{}", v / 10000, v / 100 % 100, v % 100))
    }

    /// A committed scene of one mesh, on one thread. It reads the mesh's lists while it lives.
    pub struct Embree<'a> {
        scene: *mut PeerEmbree,
        faces: usize,
        _mesh: std::marker::PhantomData<&'a ()>,
    }

    impl Drop for Embree<'_> {
        fn drop(&mut self) {
            // SAFETY: made by peer_embree, freed once.
            unsafe { peer_embree_free(self.scene) }
        }
    }

    impl<'a> Embree<'a> {
        /// # Errors
        /// If Embree fails.
        pub fn new(mesh: &'a CShape<'_>, shape: &Shape, control: &[[f32; 3]]) -> Result<Self, String> {
            assert_eq!(control.len(), shape.positions.len(), "one point per control point");
            // SAFETY: the lists of `mesh` have the lengths it says and outlive the scene; points are copied.
            let scene = unsafe { peer_embree(&mesh.peer, control.as_ptr()) };
            if scene.is_null() {
                return Err("Embree fails".to_string());
            }
            Ok(Self { scene, faces: shape.counts.len(), _mesh: std::marker::PhantomData })
        }

        /// `rtcInterpolate1` of position and first derivatives.
        pub fn eval(&self, places: &QuadPlaces, out: &mut Frames) {
            let count = self.check(places);
            let [position, du, dv] = out.pointers(places.faces.len());
            let (faces, u, v) = (places.faces.as_ptr(), places.u.as_ptr(), places.v.as_ptr());
            // SAFETY: faces exist, the arrays have one row per place.
            unsafe { peer_embree_eval(self.scene, faces, u, v, count, position, du, dv) };
        }

        /// `rtcInterpolateN` of the same, a thousand places a call; nine numbers a place.
        pub fn eval_many(&self, places: &QuadPlaces, results: &mut [f32]) {
            let count = self.check(places);
            assert!(results.len() >= 9 * places.faces.len() + 16, "room for nine numbers a place, and wide writes");
            let (faces, u, v) = (places.faces.as_ptr(), places.u.as_ptr(), places.v.as_ptr());
            // SAFETY: faces exist, and there is room.
            unsafe { peer_embree_eval_many(self.scene, faces, u, v, count, results.as_mut_ptr()) };
        }

        fn check(&self, places: &QuadPlaces) -> c_int {
            let n = places.faces.len();
            assert!(places.u.len() == n && places.v.len() == n, "as many parameters as faces");
            assert!(places.faces.iter().all(|&f| (f as usize) < self.faces), "faces exist");
            n as c_int
        }
    }
}

#[cfg(embree)]
pub use linked::{Embree, version};

#[cfg(not(embree))]
mod missing {
    use super::*;

    /// None: the library was not found.
    pub fn version() -> Option<String> {
        None
    }

    /// There is none.
    pub enum Embree {}

    impl Embree {
        /// # Errors
        /// Always.
        pub fn new(_: &CShape<'_>, _: &Shape, _: &[[f32; 3]]) -> Result<Self, String> {
            Err("absent".to_string())
        }

        pub fn eval(&self, _: &QuadPlaces, _: &mut Frames) {
            match *self {}
        }

        pub fn eval_many(&self, _: &QuadPlaces, _: &mut [f32]) {
            match *self {}
        }
    }
}

#[cfg(not(embree))]
pub use missing::{Embree, version};
