//! Channels: values that go over a mesh's faces but not by its vertices' rules. A face-varying channel (texture
//! coordinates, say) may have different values on the two sides of a seam; a varying one goes by vertices, linearly.
//!
//! A channel has half-edge tables of its own over the mesh's faces, so everything that takes a [`Topology`] refines and
//! evaluates it: [`Level`] level by level, [`PatchTable`] exactly at any [`Location`](crate::Location), by the same plans.
//! Faces, corners, sub-faces and parameters are those of the mesh.

use crate::limit::{Method, PatchTable};
use crate::mesh::{MAX_COUNT, MeshError};
use crate::real::Real;
use crate::refine::Level;
use crate::scheme::Scheme;
use crate::tags::FaceVarying;
use crate::topology::{ChannelTopology, Topology};
use std::borrow::Cow;
use thiserror::Error;

/// Why a channel does not fit its mesh.
#[derive(Clone, PartialEq, Eq, Debug, Error)]
#[non_exhaustive]
pub enum ChannelError {
    /// Not one value index per face corner.
    #[error("the channel has {given} corners, but the mesh has {expected}; give one value index per face corner")]
    CornerCount {
        /// Number of indices given.
        given: usize,
        /// Number of face corners of the mesh.
        expected: usize,
    },
    /// A corner names a value that does not exist.
    #[error("corner {corner} of face {face} uses value {value} of {values} (values count from 0)")]
    ValueOutOfRange {
        /// The face.
        face: usize,
        /// The corner in that face.
        corner: usize,
        /// The value it names.
        value: u32,
        /// How many there are.
        values: usize,
    },
    /// More values than 32-bit indices can name.
    #[error("the channel has {values} values; at most {limit} are supported")]
    TooLarge {
        /// How many there are.
        values: usize,
        /// How many there may be.
        limit: usize,
    },
}

/// The connectivity of a channel over the faces of a mesh. Values are plain arrays, handed to what evaluates them.
///
/// ```
/// use subsurf::{Channel, ControlMesh, Location, Scheme, Tags, Topology};
///
/// // Two quads; their texture coordinates part along the common edge.
/// let mesh = ControlMesh::new(&[[0, 1, 4, 3], [1, 2, 5, 4]], Tags::default())?;
/// let topology = Topology::new(&mesh)?;
/// let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [5.0, 0.0], [6.0, 0.0], [6.0, 1.0], [5.0, 1.0]];
/// let rule = mesh.tags().rules.face_varying;
/// let channel = Channel::face_varying(&topology, Scheme::CatmullClark, uv.len(), &[0, 1, 2, 3, 4, 5, 6, 7], rule)?;
///
/// let values = channel.rows(&uv); // once per change of values
/// let patches = channel.patch_table()?; // once per connectivity
/// let jet = patches.surface(&values).eval(Location::new(1, 0.0, 0.5)).expect("face 1 is no hole");
/// assert!((jet.position[0] - 5.0).abs() < 1e-15 && (jet.position[1] - 0.5).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Channel {
    topology: Topology,
    scheme: Scheme,
    values: usize,
    copies: Vec<u32>,
}

impl Channel {
    /// A face-varying channel of `values` values: `corners` has one value index per face corner of the mesh, face after
    /// face. Edges where the faces disagree about an index are seams. `rule` says which values are sharp; that of the mesh
    /// is `topology.rules().face_varying`.
    ///
    /// # Errors
    /// [`ChannelError`] names what does not fit.
    pub fn face_varying(
        topology: &Topology,
        scheme: Scheme,
        values: usize,
        corners: &[u32],
        rule: FaceVarying,
    ) -> Result<Self, ChannelError> {
        let expected = topology.half_edge_count();
        if corners.len() != expected {
            return Err(ChannelError::CornerCount { given: corners.len(), expected });
        }
        // At worst every corner has a vertex of its own beside the values.
        if values + expected > MAX_COUNT {
            return Err(ChannelError::TooLarge { values, limit: MAX_COUNT - expected });
        }
        if let Some(h) = corners.iter().position(|&value| value as usize >= values) {
            let face = topology.face.get(h as u32) as usize;
            let corner = h - topology.face_offset[face] as usize;
            return Err(ChannelError::ValueOutOfRange { face, corner, value: corners[h], values });
        }
        let ChannelTopology { topology, copies } = topology.channel(values, corners, rule);
        Ok(Self { topology, scheme, values, copies })
    }

    /// A varying channel: one value per vertex of the mesh, interpolated linearly.
    pub fn varying(topology: &Topology, scheme: Scheme) -> Self {
        let topology = topology.with_linear_values();
        Self { values: topology.vertex_count(), topology, scheme, copies: Vec::new() }
    }

    /// Number of values that the channel takes.
    pub fn value_count(&self) -> usize {
        self.values
    }

    /// The channel's half-edge tables: the mesh's faces, with values in the place of vertices.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The scheme of the mesh.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// Number of edges at which faces disagree, each counted once per face.
    pub fn seam_count(&self, mesh: &Topology) -> usize {
        let open = |t: &Topology| t.edge_flags.iter().filter(|f| f.boundary).count();
        open(&self.topology) - open(mesh)
    }

    /// The values in the order of the channel's topology: the values themselves, then once more those that several
    /// vertices of the mesh share, because refinement parts them.
    ///
    /// # Panics
    /// If `values` has not [`value_count`](Self::value_count) rows.
    pub fn rows<'a, T: Real, const N: usize>(&self, values: &'a [[T; N]]) -> Cow<'a, [[T; N]]> {
        assert_eq!(values.len(), self.values, "one row per value of the channel");
        if self.copies.is_empty() {
            return Cow::Borrowed(values);
        }
        let copies = self.copies.iter().map(|&value| values[value as usize]);
        Cow::Owned(values.iter().copied().chain(copies).collect())
    }

    /// Level 0 of the channel's refinement. Levels of the channel have the faces of the mesh's levels, corner by corner.
    pub fn level(&self) -> Level {
        Level::from_topology(self.topology.clone(), self.scheme)
    }

    /// The channel's patch table, which takes the mesh's locations.
    ///
    /// # Errors
    /// As [`PatchTable::new`].
    pub fn patch_table(&self) -> Result<PatchTable, MeshError> {
        self.patch_table_with(Method::default())
    }

    /// The same with a choice of closed form at special vertices.
    ///
    /// # Errors
    /// As [`PatchTable::new`].
    pub fn patch_table_with(&self, method: Method) -> Result<PatchTable, MeshError> {
        PatchTable::from_topology(self.topology.clone(), self.scheme, method)
    }
}
