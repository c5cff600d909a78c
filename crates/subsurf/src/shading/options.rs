//! What shading normals can be asked for, and what is refused.

use crate::channel::ChannelError;
use crate::mesh::MeshError;
use crate::topology::Topology;
use thiserror::Error;

/// Which normals to shade with.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum NormalField {
    /// Those of the limit surface, `n_L`.
    Limit,
    /// Subdivided ones everywhere, `n_S` (but at what is locked, see [`ShadingOptions::crease_sharpness`]).
    Subdivided,
    /// A blend, `n_B`.
    Blended(Blend),
}

impl Default for NormalField {
    fn default() -> Self {
        Self::Blended(Blend::A4)
    }
}

/// How blend weights are made, by the names of Bakker, Barendrecht and Kosinka 2018.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Blend {
    /// 1 at extraordinary vertices, interpolated bilinearly (linearly in triangles). Not smooth along edges.
    A1,
    /// The same weights, subdivided: less than 1 at extraordinary vertices, and so not smooth there.
    A2,
    /// The reciprocal of its weight in its own limit at every interior extraordinary vertex: b = 1 there. They must not
    /// share a face, so the weights start at a level where they do not. Boundary vertices keep `n_L`.
    A3,
    /// 1 at extraordinary vertices and at all vertices of their faces: b = 1 to third order at extraordinary vertices of
    /// every kind. The blend to use.
    #[default]
    A4,
}

/// The exponent p of the blend: the smaller, the wider `n_S` reaches. The blend is smooth for p > 1/3.
#[derive(Clone, PartialEq, Debug)]
pub enum Power {
    /// One for all.
    Uniform(f64),
    /// One per vertex of the control mesh, subdivided as positions are.
    PerVertex(Vec<f64>),
    /// One per face: the mean of its faces at every vertex, and then as per vertex.
    PerFace(Vec<f64>),
}

impl Default for Power {
    fn default() -> Self {
        Self::Uniform(1.0)
    }
}

/// How normals are averaged when they are subdivided.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Averaging {
    /// As vectors; the limit is brought to unit length.
    #[default]
    Linear,
    /// On the unit sphere (Buss, Fillmore 2001) for this many levels, then as vectors. Memory grows fourfold a level.
    Spherical(u32),
}

/// What normals to make.
#[derive(Clone, PartialEq, Debug)]
pub struct ShadingOptions {
    /// Which normals.
    pub field: NormalField,
    /// Exponent of the blend weight, above 0.
    pub power: Power,
    /// How normals are averaged.
    pub averaging: Averaging,
    /// The level of refinement whose vertex normals are subdivided. The finer, the closer `n_S` comes to `n_L`.
    pub normals_level: u32,
    /// The level at which blend weights start. The finer, the less of the surface is blended. Raised where the blend
    /// needs it: by one level for polygons under Catmull-Clark, whose centres are extraordinary, and for A3 by up to two,
    /// until extraordinary vertices are apart.
    pub weights_level: u32,
    /// Fields part at edges of at least this sharpness on the control mesh, as at infinitely sharp ones. Along those that
    /// are not infinitely sharp, the limit normal stays.
    pub crease_sharpness: f64,
}

impl Default for ShadingOptions {
    fn default() -> Self {
        Self {
            field: NormalField::default(),
            power: Power::default(),
            averaging: Averaging::default(),
            normals_level: 0,
            weights_level: 0,
            crease_sharpness: 1.0,
        }
    }
}

/// Why normals could not be made.
#[derive(Clone, PartialEq, Debug, Error)]
#[non_exhaustive]
pub enum ShadingError {
    /// A power that is no positive number.
    #[error("the power of {what} {index} is {value}; use a number above 0 (above 1/3 for smooth shading)")]
    BadPower {
        /// "vertex", "face" or "all".
        what: &'static str,
        /// Which one.
        index: usize,
        /// What was given.
        value: f64,
    },
    /// Not one power per vertex or face.
    #[error("there are {given} powers for {expected} {what}; give one for each")]
    PowerCount {
        /// "vertices" or "faces".
        what: &'static str,
        /// Number of powers given.
        given: usize,
        /// Number of vertices or faces.
        expected: usize,
    },
    /// A sharpness from which fields part that is no positive number.
    #[error(
        "fields cannot part at edges of sharpness {value}; use a number above 0, 10 for infinitely sharp edges alone"
    )]
    BadCreaseSharpness {
        /// What was given.
        value: f64,
    },
    /// Not one normal index per face corner.
    #[error("there are {given} corners with normals, but the mesh has {expected}; give one normal per face corner")]
    CornerCount {
        /// Number of indices given.
        given: usize,
        /// Number of face corners of the mesh.
        expected: usize,
    },
    /// A corner names a normal that does not exist.
    #[error("corner {corner} of all face corners uses normal {normal} of {normals} (both count from 0)")]
    NormalOutOfRange {
        /// The corner.
        corner: usize,
        /// The normal it names.
        normal: u32,
        /// How many there are.
        normals: usize,
    },
    /// Normals of the mesh with a start level of their own.
    #[error("normals that the mesh brings along belong to level 0; ask for normals_level 0, not {level}")]
    OwnNormalsLevel {
        /// What was asked for.
        level: u32,
    },
    /// A level of more corners than are reasonable.
    #[error(
        "{what} at level {level} need a mesh of {corners} corners; at most {limit} are supported: use a lower level"
    )]
    TooDeep {
        /// "normals" or "blend weights".
        what: &'static str,
        /// The level.
        level: u32,
        /// Its number of face corners.
        corners: usize,
        /// The largest number.
        limit: usize,
    },
    /// A level that does not fit into 32-bit indices.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// More values than 32-bit indices can name.
    #[error(transparent)]
    Channel(#[from] ChannelError),
}

/// Refuses options that do not fit the mesh.
pub(super) fn check(mesh: &Topology, options: &ShadingOptions) -> Result<(), ShadingError> {
    let is_good = |p: f64| p > 0.0 && p.is_finite();
    let (what, names, list, expected): (_, _, &[f64], _) = match &options.power {
        Power::Uniform(p) => ("all", "", std::slice::from_ref(p), 1),
        Power::PerVertex(list) => ("vertex", "vertices", list, mesh.vertex_count()),
        Power::PerFace(list) => ("face", "faces", list, mesh.face_count()),
    };
    if list.len() != expected {
        return Err(ShadingError::PowerCount { what: names, given: list.len(), expected });
    }
    if let Some(index) = list.iter().position(|&p| !is_good(p)) {
        return Err(ShadingError::BadPower { what, index, value: list[index] });
    }
    if !is_good(options.crease_sharpness) {
        return Err(ShadingError::BadCreaseSharpness { value: options.crease_sharpness });
    }
    Ok(())
}
