//! Why a picture could not be made.

use thiserror::Error;

/// Most pixels along one side.
pub const MAX_SIDE: u32 = 16_384;
/// Most pixels of one picture: an 8K frame (7680 × 4320) fits. About 150 bytes of memory go with each while it is made.
pub const MAX_PIXELS: u64 = 1 << 25;
/// Most samples per pixel.
pub const MAX_SAMPLES: u32 = 4096;

/// Why a mesh cannot be drawn. Vertices and triangles count from 0.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Nothing to draw.
    #[error("the mesh has no triangles; at least one is needed for a picture")]
    NoTriangles,
    /// More triangles than the hierarchy can address.
    #[error("the mesh has {count} triangles; at most 2^30 can be drawn")]
    TooManyTriangles {
        /// How many there are.
        count: usize,
    },
    /// A coordinate is NaN, infinite or astronomically large.
    #[error("vertex {vertex} lies at {position:?}; coordinates must be finite and below 1e18")]
    PositionNotFinite {
        /// The vertex.
        vertex: usize,
        /// Where it lies.
        position: [f32; 3],
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} uses vertex {vertex} of {vertices} (vertices count from 0)")]
    VertexOutOfRange {
        /// The triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
}

/// Why a picture could not be rendered.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The mesh cannot be drawn.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The size is zero or too large.
    #[error(
        "the picture is {width}x{height} pixels; each side must be 1 to {MAX_SIDE}, and width times height at most {MAX_PIXELS}"
    )]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// The number of samples is zero or too large.
    #[error("{samples} samples per pixel were asked for; use 1 to {MAX_SAMPLES}")]
    Samples {
        /// Samples per pixel.
        samples: u32,
    },
    /// The camera cannot see.
    #[error(
        "the camera at {eye:?} looking at {target:?} with {fov_deg} degrees sees nothing: eye and target must be finite and apart, the angle between 0 and 180"
    )]
    Camera {
        /// Position of the eye.
        eye: [f64; 3],
        /// Point it looks at.
        target: [f64; 3],
        /// Vertical field of view in degrees.
        fov_deg: f64,
    },
    /// A coordinate of an overlay line or dot is no finite number.
    #[error("{what} {index} of the overlay has a point or width that is not a finite number")]
    OverlayNotFinite {
        /// "line" or "dot".
        what: &'static str,
        /// Its position in the overlay.
        index: usize,
    },
}
