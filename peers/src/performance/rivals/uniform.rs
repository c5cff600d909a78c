//! OpenSubdiv's uniform refinement: `Far::TopologyRefiner`, `PrimvarRefiner` and `StencilTable`, applied by
//! `Osd::CpuEvaluator`. Stencils are in single precision, all else in either.

#![allow(unsafe_code)]

use crate::opensubdiv::{CShape, PeerRefiner, PeerShape, Refiner, or_error};
use crate::shape::Shape;
use std::ffi::{c_char, c_int};
use std::ops::Range;

#[repr(C)]
struct PeerStencils {
    _opaque: [u8; 0],
}

unsafe extern "C" {
    fn peer_uniform(
        shape: *const PeerShape,
        levels: c_int,
        full: c_int,
        error: *mut c_char,
        size: c_int,
    ) -> *mut PeerRefiner;
    fn peer_uniform_counts(refiner: *const PeerRefiner, counts: *mut c_int);
    fn peer_uniform_points(refiner: *const PeerRefiner, points: *mut [f32; 3]);
    fn peer_uniform_limit(
        refiner: *const PeerRefiner,
        points: *const [f32; 3],
        position: *mut [f32; 3],
        du: *mut [f32; 3],
        dv: *mut [f32; 3],
    );
    fn peer_uniform_points_double(refiner: *const PeerRefiner, points: *mut [f64; 3]);
    fn peer_uniform_limit_double(
        refiner: *const PeerRefiner,
        points: *const [f64; 3],
        position: *mut [f64; 3],
        du: *mut [f64; 3],
        dv: *mut [f64; 3],
    );
    fn peer_stencils(refiner: *const PeerRefiner) -> *mut PeerStencils;
    fn peer_stencils_free(stencils: *mut PeerStencils);
    fn peer_stencils_count(stencils: *const PeerStencils) -> c_int;
    fn peer_stencils_apply(
        stencils: *const PeerStencils,
        width: c_int,
        control: *const f32,
        out: *mut f32,
        start: c_int,
        end: c_int,
    );
}

type Points<T> = unsafe extern "C" fn(*const PeerRefiner, *mut [T; 3]);
type Limit<T> = unsafe extern "C" fn(*const PeerRefiner, *const [T; 3], *mut [T; 3], *mut [T; 3], *mut [T; 3]);

/// Single or double precision.
pub trait Precision: subsurf::Real + std::ops::Div<Output = Self> {
    #[doc(hidden)]
    const POINTS: Points<Self>;
    #[doc(hidden)]
    const LIMIT: Limit<Self>;

    /// Its square root.
    fn root(self) -> Self;
}

impl Precision for f32 {
    const POINTS: Points<f32> = peer_uniform_points;
    const LIMIT: Limit<f32> = peer_uniform_limit;

    fn root(self) -> Self {
        self.sqrt()
    }
}

impl Precision for f64 {
    const POINTS: Points<f64> = peer_uniform_points_double;
    const LIMIT: Limit<f64> = peer_uniform_limit_double;

    fn root(self) -> Self {
        self.sqrt()
    }
}

/// A mesh refined some times.
pub struct Uniform {
    refiner: Refiner,
    /// Of all levels, of the last.
    vertices: [usize; 2],
    control: usize,
    full: bool,
}

impl Uniform {
    /// `TopologyRefinerFactory::Create` and `RefineUniform`.
    ///
    /// # Errors
    /// What OpenSubdiv says when it refuses the mesh.
    pub fn new(mesh: &CShape<'_>, shape: &Shape, levels: u32) -> Result<Self, String> {
        Self::with_topology(mesh, shape, levels, false)
    }

    /// The same with full topology of the last level, which [`limit`](Self::limit) needs.
    ///
    /// # Errors
    /// As [`Uniform::new`].
    pub fn full(mesh: &CShape<'_>, shape: &Shape, levels: u32) -> Result<Self, String> {
        Self::with_topology(mesh, shape, levels, true)
    }

    fn with_topology(mesh: &CShape<'_>, shape: &Shape, levels: u32, full: bool) -> Result<Self, String> {
        assert!((1..16).contains(&levels), "OpenSubdiv stores the level in four bits");
        let refiner = or_error(shape, |error, size| {
            // SAFETY: the lists of `mesh` have the lengths it says; OpenSubdiv copies them.
            let refiner = unsafe { peer_uniform(&mesh.peer, levels as c_int, c_int::from(full), error, size) };
            (!refiner.is_null()).then_some(Refiner(refiner))
        })?;
        let mut counts = [0; 3];
        // SAFETY: three counts are written.
        unsafe { peer_uniform_counts(refiner.0, counts.as_mut_ptr()) };
        let vertices = [counts[0] as usize, counts[1] as usize];
        Ok(Self { refiner, vertices, control: shape.positions.len(), full })
    }

    /// Vertices of the last level.
    pub fn vertex_count(&self) -> usize {
        self.vertices[1]
    }

    /// Points of all levels, those of the control mesh in place.
    pub fn points<T: Precision>(&self, control: &[[T; 3]]) -> Vec<[T; 3]> {
        let mut all = Vec::with_capacity(self.vertices[0]);
        all.extend_from_slice(control);
        all.resize(self.vertices[0], [T::default(); 3]);
        all
    }

    /// `PrimvarRefiner::Interpolate`, level by level; the last level's points are the last.
    pub fn interpolate<T: Precision>(&self, control: &[[T; 3]], points: &mut [[T; 3]]) {
        assert!(control.len() == self.control && points.len() == self.vertices[0], "one point per vertex");
        points[..self.control].copy_from_slice(control);
        // SAFETY: there is room for all levels.
        unsafe { T::POINTS(self.refiner.0, points.as_mut_ptr()) };
    }

    /// The last level's points out of those of all levels.
    pub fn last<'a, T>(&self, points: &'a [[T; 3]]) -> &'a [[T; 3]] {
        &points[self.vertices[0] - self.vertices[1]..]
    }

    /// `PrimvarRefiner::Limit` of the last level's vertices: positions, and two tangents where asked for.
    pub fn limit<T: Precision>(
        &self,
        points: &[[T; 3]],
        position: &mut [[T; 3]],
        tangents: Option<[&mut [[T; 3]]; 2]>,
    ) {
        let n = self.vertices[1];
        assert!(self.full, "limits need full topology");
        assert_eq!(position.len(), n, "one point per vertex of the last level");
        let [du, dv] = match tangents {
            Some(tangents) => tangents.map(|t| {
                assert_eq!(t.len(), n, "one tangent per vertex of the last level");
                t.as_mut_ptr()
            }),
            None => [std::ptr::null_mut(); 2],
        };
        // SAFETY: all arrays have one entry per vertex of the last level.
        unsafe { T::LIMIT(self.refiner.0, self.last(points).as_ptr(), position.as_mut_ptr(), du, dv) };
    }
}

/// The last level's vertices as weighted sums of control points.
pub struct Stencils {
    stencils: *mut PeerStencils,
    control: usize,
}

// SAFETY: OpenSubdiv's tables are not written to once they are made.
unsafe impl Send for Stencils {}
// SAFETY: as above.
unsafe impl Sync for Stencils {}

impl Drop for Stencils {
    fn drop(&mut self) {
        // SAFETY: made by peer_stencils, freed once.
        unsafe { peer_stencils_free(self.stencils) }
    }
}

impl Stencils {
    /// `StencilTableFactory::Create`, of the last level alone.
    pub fn new(refined: &Uniform) -> Self {
        // SAFETY: the refiner lives during the call.
        Self { stencils: unsafe { peer_stencils(refined.refiner.0) }, control: refined.control }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        // SAFETY: the table lives.
        unsafe { peer_stencils_count(self.stencils) as usize }
    }

    /// `CpuEvaluator::EvalStencils` of points of 3 or 4 numbers.
    pub fn apply<const N: usize>(&self, control: &[[f32; N]], out: &mut [[f32; N]]) {
        let rows = 0..self.len();
        assert_eq!(out.len(), rows.end, "one point per row");
        self.apply_rows(rows, control, out);
    }

    /// Some of the rows. OpenSubdiv's kernel for 4 numbers takes only all of them.
    pub fn apply_rows<const N: usize>(&self, rows: Range<usize>, control: &[[f32; N]], out: &mut [[f32; N]]) {
        assert!(rows.end <= self.len() && out.len() == rows.len(), "one point per row");
        assert!(control.len() == self.control && N >= 3, "one point per control point");
        assert!(N != 4 || rows.start == 0, "rows of 4 numbers begin at the first");
        // SAFETY: the rows are the table's, and `out` holds their results.
        unsafe {
            let (from, to) = (rows.start as c_int, rows.end as c_int);
            let out = out.as_mut_ptr().cast();
            peer_stencils_apply(self.stencils, N as c_int, control.as_ptr().cast(), out, from, to);
        }
    }
}
