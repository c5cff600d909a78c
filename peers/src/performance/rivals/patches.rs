//! OpenSubdiv's feature-adaptive patches: `Far::PatchTable` with its map, `Osd::CpuEvaluator::EvalPatches`, and limit
//! stencils. Single precision, Gregory end caps, infinitely sharp patches.

#![allow(unsafe_code)]

use crate::opensubdiv::{CShape, PeerShape, or_error};
use crate::shape::Shape;
use std::ffi::{c_char, c_int};

/// A place as Far numbers it.
#[derive(Clone, Copy, PartialEq, Debug)]
#[repr(C)]
pub struct Place {
    pub ptex_face: c_int,
    pub u: f32,
    pub v: f32,
}

#[repr(C)]
struct PeerPatches {
    _opaque: [u8; 0],
}

#[repr(C)]
struct PeerLimitStencils {
    _opaque: [u8; 0],
}

unsafe extern "C" {
    fn peer_patches(
        shape: *const PeerShape,
        isolation: c_int,
        smooth_isolation: c_int,
        single_crease: c_int,
        error: *mut c_char,
        size: c_int,
    ) -> *mut PeerPatches;
    fn peer_patches_free(patches: *mut PeerPatches);
    fn peer_patches_counts(patches: *const PeerPatches, counts: *mut c_int);
    fn peer_patches_points(patches: *const PeerPatches, points: *mut [f32; 3]);
    fn peer_patches_eval(
        patches: *const PeerPatches,
        points: *const [f32; 3],
        places: *const Place,
        count: c_int,
        position: *mut [f32; 3],
        du: *mut [f32; 3],
        dv: *mut [f32; 3],
    );
    fn peer_patches_locate(patches: *mut PeerPatches, places: *const Place, count: c_int) -> c_int;
    fn peer_patches_eval_batch(
        patches: *const PeerPatches,
        points: *const [f32; 3],
        position: *mut [f32; 3],
        du: *mut [f32; 3],
        dv: *mut [f32; 3],
    );
    fn peer_limit_stencils(patches: *const PeerPatches, places: *const Place, count: c_int) -> *mut PeerLimitStencils;
    fn peer_limit_stencils_free(stencils: *mut PeerLimitStencils);
    fn peer_limit_stencils_count(stencils: *const PeerLimitStencils) -> c_int;
    fn peer_limit_stencils_apply(
        stencils: *const PeerLimitStencils,
        control: *const [f32; 3],
        position: *mut [f32; 3],
        du: *mut [f32; 3],
        dv: *mut [f32; 3],
    );
}

/// Positions and first derivatives, one row per place.
#[derive(Clone, Debug, Default)]
pub struct Frames(pub [Vec<[f32; 3]>; 3]);

impl Frames {
    pub fn new(count: usize) -> Self {
        Self([0; 3].map(|_| vec![[0.0; 3]; count]))
    }

    /// Where the three arrays begin, after a look at their length.
    pub(super) fn pointers(&mut self, count: usize) -> [*mut [f32; 3]; 3] {
        assert!(self.0.iter().all(|rows| rows.len() == count), "one row per place");
        self.0.each_mut().map(|rows| rows.as_mut_ptr())
    }
}

/// Refiner, patch table and map.
pub struct Patches {
    patches: *mut PeerPatches,
    control: usize,
    located: usize,
}

impl Drop for Patches {
    fn drop(&mut self) {
        // SAFETY: made by peer_patches, freed once.
        unsafe { peer_patches_free(self.patches) }
    }
}

impl Patches {
    /// `Create`, `RefineAdaptive`, `PatchTableFactory::Create` and `PatchMap`.
    ///
    /// # Errors
    /// What OpenSubdiv says when it refuses the mesh.
    pub fn new(mesh: &CShape<'_>, shape: &Shape, isolation: u32) -> Result<Self, String> {
        Self::with_creases(mesh, shape, [isolation; 2], false)
    }

    /// The same with levels at sharp and at smooth features, and a choice of single-crease patches.
    ///
    /// # Errors
    /// As [`Patches::new`].
    pub fn with_creases(
        mesh: &CShape<'_>,
        shape: &Shape,
        isolation: [u32; 2],
        single_crease: bool,
    ) -> Result<Self, String> {
        assert!(isolation.iter().all(|level| (1..=10).contains(level)), "isolation is between 1 and 10");
        let [sharp, smooth] = isolation.map(|level| level as c_int);
        or_error(shape, |error, size| {
            // SAFETY: the lists of `mesh` have the lengths it says; OpenSubdiv copies them.
            let patches = unsafe { peer_patches(&mesh.peer, sharp, smooth, c_int::from(single_crease), error, size) };
            let control = shape.positions.len();
            (!patches.is_null()).then_some(Self { patches, control, located: 0 })
        })
    }

    /// Points (control, refined, of end caps) and patches.
    pub fn counts(&self) -> [usize; 2] {
        let mut counts = [0; 2];
        // SAFETY: two counts are written.
        unsafe { peer_patches_counts(self.patches, counts.as_mut_ptr()) };
        counts.map(|n| n as usize)
    }

    /// Room for all points.
    pub fn points(&self) -> Vec<[f32; 3]> {
        vec![[0.0; 3]; self.counts()[0]]
    }

    /// Computes all points from the control points: once per frame.
    pub fn interpolate(&self, control: &[[f32; 3]], points: &mut [[f32; 3]]) {
        assert!(control.len() == self.control && points.len() == self.counts()[0], "one point each");
        points[..self.control].copy_from_slice(control);
        // SAFETY: there is room for all.
        unsafe { peer_patches_points(self.patches, points.as_mut_ptr()) };
    }

    /// Position and first derivatives at places, each looked up in the map: `FindPatch`, `EvaluateBasis` and the sums.
    pub fn eval(&self, points: &[[f32; 3]], places: &[Place], out: &mut Frames) {
        assert_eq!(points.len(), self.counts()[0], "all points");
        let [position, du, dv] = out.pointers(places.len());
        // SAFETY: places on no face are left zero; the arrays have one row per place.
        unsafe {
            let count = places.len() as c_int;
            peer_patches_eval(self.patches, points.as_ptr(), places.as_ptr(), count, position, du, dv);
        }
    }

    /// Looks places up once, for [`eval_located`](Self::eval_located).
    ///
    /// # Errors
    /// If some place lies on no patch.
    pub fn locate(&mut self, places: &[Place]) -> Result<(), String> {
        // SAFETY: the array has that many places.
        let found = unsafe { peer_patches_locate(self.patches, places.as_ptr(), places.len() as c_int) };
        self.located = found as usize;
        let missing = places.len() - self.located;
        if missing == 0 { Ok(()) } else { Err(format!("{missing} places lie on no patch")) }
    }

    /// `CpuEvaluator::EvalPatches` at the places looked up, with first derivatives or without.
    pub fn eval_located(&self, points: &[[f32; 3]], out: &mut Frames, derivatives: bool) {
        assert_eq!(points.len(), self.counts()[0], "all points");
        let [position, du, dv] = out.pointers(self.located);
        let [du, dv] = if derivatives { [du, dv] } else { [std::ptr::null_mut(); 2] };
        // SAFETY: the arrays have one row per place that was found.
        unsafe { peer_patches_eval_batch(self.patches, points.as_ptr(), position, du, dv) };
    }
}

/// Positions and first derivatives as weighted sums of control points.
pub struct LimitStencils {
    stencils: *mut PeerLimitStencils,
    control: usize,
}

impl Drop for LimitStencils {
    fn drop(&mut self) {
        // SAFETY: made by peer_limit_stencils, freed once.
        unsafe { peer_limit_stencils_free(self.stencils) }
    }
}

impl LimitStencils {
    /// `LimitStencilTableFactory::Create` with the refiner and patch table at hand.
    pub fn new(patches: &Patches, places: &[Place]) -> Self {
        // SAFETY: the array has that many places.
        let stencils = unsafe { peer_limit_stencils(patches.patches, places.as_ptr(), places.len() as c_int) };
        Self { stencils, control: patches.control }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        // SAFETY: the table lives.
        unsafe { peer_limit_stencils_count(self.stencils) as usize }
    }

    /// `CpuEvaluator::EvalStencils` of positions and first derivatives.
    pub fn apply(&self, control: &[[f32; 3]], out: &mut Frames) {
        assert_eq!(control.len(), self.control, "one point per control point");
        let [position, du, dv] = out.pointers(self.len());
        // SAFETY: the arrays have one row per stencil.
        unsafe { peer_limit_stencils_apply(self.stencils, control.as_ptr(), position, du, dv) };
    }
}
