//! The limit surface as a mesh. Samples on shared vertices and edges are evaluated once, by their owner, and used by
//! index, so that tessellations are watertight by construction and have the same bits on any number of threads.
//!
//! Points come in this order: one per control vertex that a face uses, those inside control edges, those inside faces.

mod by_values;
pub(crate) mod channel;
mod corner_rows;
mod crease_normals;
mod evaluate;
mod faceted;
mod facets;
mod grid;
mod grid_facets;
mod layout;
mod normals;
mod output;
mod patch_grid;
mod pattern;
mod piecewise;
mod polygon;
mod rates;
mod sample;
mod selection;
mod shade;
mod tasks;
pub(crate) mod tessellator;

use crate::limit::LimitSurface;
use crate::mesh::MAX_COUNT;
use crate::real::Real;
use crate::shading::ShadingNormals;
pub use channel::TessellatedChannel;
pub(crate) use layout::Layout;
use layout::PatchRates;
pub(crate) use pattern::Frames;
pub use tessellator::Tessellator;
use thiserror::Error;

/// How finely to tessellate.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Rates {
    /// Every quad becomes `rate × rate` facets. Faces that are no quads are tessellated through their sub-faces, at half
    /// the rate; an odd rate is rounded up to even where the mesh has such faces.
    Uniform(u32),
    /// As coarse as possible with every facet within this distance of the surface, in model units, measured at
    /// points of facets and their sides. More than [`FINEST`] per side is an error.
    Tolerance(f64),
    /// Facet sides of at most this length along the surface, in model units. More than [`FINEST`] per side is an error.
    EdgeLength(f64),
}

/// Largest number of facets along one side of a face under adaptive rates.
pub const FINEST: u32 = 512;

/// Shape of facets.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Facets {
    /// Quads; triangles only where adaptive rates meet.
    #[default]
    Quads,
    /// Triangles only.
    Triangles,
}

/// What to produce.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct TessellateOptions {
    /// How finely.
    pub rates: Rates,
    /// Shape of facets.
    pub facets: Facets,
    /// Whether to evaluate normals.
    pub normals: bool,
    /// Whether to say of every facet which part of which face it is.
    pub places: bool,
    /// Most points to produce; more are an error before any is made.
    pub most_points: u64,
}

impl Default for TessellateOptions {
    fn default() -> Self {
        Self {
            rates: Rates::Uniform(8),
            facets: Facets::Quads,
            normals: true,
            places: false,
            most_points: MAX_COUNT as u64,
        }
    }
}

/// A mesh of the limit surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Tessellation<T> {
    /// One point per shared sample.
    pub positions: Vec<[T; 3]>,
    /// Start of every facet in `corners`, and the end of the last one.
    pub face_offsets: Vec<u32>,
    /// Points of all facets, counter-clockwise.
    pub corners: Vec<u32>,
    /// Unit normals: one per point, then further ones for the other sides of infinitely sharp creases. Under bilinear
    /// subdivision, where all edges are sharp, those of one patch after the other. Empty if they were not asked for.
    pub normals: Vec<[T; 3]>,
    /// Normal of every facet corner; empty where normals go by the same indices as points.
    pub normal_corners: Vec<u32>,
    /// Where each facet lies, if asked for.
    pub places: Option<Places>,
    /// What was chosen, for channels to follow.
    rates: PatchRates,
    facets: Facets,
}

/// Where each facet of a tessellation lies on the control mesh.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Places {
    /// Face and sub-face of every facet.
    pub facet: Vec<(u32, u32)>,
    /// Parameters of every facet corner in that sub-face.
    pub corner_uv: Vec<[f64; 2]>,
}

/// Why a surface could not be tessellated.
#[derive(Clone, PartialEq, Debug, Error)]
#[non_exhaustive]
pub enum TessellateError {
    /// A rate of zero.
    #[error("the tessellation rate is 0; use at least 1")]
    ZeroRate,
    /// A tolerance or length that is no positive number.
    #[error("the {what} is {value}; use a positive number")]
    NotPositive {
        /// "tolerance" or "edge length".
        what: &'static str,
        /// What was given.
        value: f64,
    },
    /// A goal that some face does not reach with [`FINEST`] facets along a side.
    #[error("the {what} of {value} needs more than {FINEST} facets along a side of a face; use a larger one")]
    TooFine {
        /// "tolerance" or "edge length".
        what: &'static str,
        /// What was given.
        value: f64,
    },
    /// More points or facet corners than 32-bit indices can name.
    #[error("the tessellation would have {count} {what}; at most {limit} are possible here: use a coarser rate")]
    TooLarge {
        /// "points" or "facet corners".
        what: &'static str,
        /// How many there would be.
        count: u64,
        /// How many there may be.
        limit: u64,
    },
}

impl<T: Real> LimitSurface<'_, T, 3> {
    /// Tessellates the surface, holes left out.
    ///
    /// # Errors
    /// [`TessellateError`]: rates that are not positive, or a result too large for 32-bit indices.
    pub fn tessellate(&self, options: &TessellateOptions) -> Result<Tessellation<T>, TessellateError> {
        self.tessellate_with(options, None)
    }

    /// Tessellates the surface with shading normals in the place of its own. Further sides of infinitely sharp creases
    /// have normals of their own as ever.
    ///
    /// # Errors
    /// As [`tessellate`](Self::tessellate).
    ///
    /// # Panics
    /// If the normals are those of another mesh.
    pub fn tessellate_shaded(
        &self,
        options: &TessellateOptions,
        shading: &ShadingNormals<'_>,
    ) -> Result<Tessellation<T>, TessellateError> {
        assert!(shading.fits(self.table().topology()), "the normals are those of this mesh");
        self.tessellate_with(options, Some(shading))
    }

    fn tessellate_with(
        &self,
        options: &TessellateOptions,
        shading: Option<&ShadingNormals<'_>>,
    ) -> Result<Tessellation<T>, TessellateError> {
        // What lies before the arrays is held back until they are there.
        let (tessellator, _before) = T::compiled_tessellator(self.table(), self.points(), options, Frames::One)?;
        Ok(tessellator.into_mesh(*self, shading))
    }
}
