//! The control mesh: faces and tags, no positions. Checked once, in the constructor.

use crate::tags::{INFINITE_SHARPNESS, Rules, Tags};
use thiserror::Error;

/// Why a control mesh could not be made. Faces, vertices and creases are counted from 0.
#[derive(Clone, PartialEq, Debug, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// There is nothing to subdivide.
    #[error("the mesh has no faces; at least one is needed")]
    NoFaces,
    /// A face of fewer than three corners.
    #[error("face {face} has {sides} corners; a face needs at least 3")]
    FaceTooSmall {
        /// The face.
        face: usize,
        /// Its number of corners.
        sides: usize,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} uses vertex {vertex} of {vertices} (vertices count from 0)")]
    VertexOutOfRange {
        /// The face.
        face: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// The counts of corners do not add up to the number of indices.
    #[error("the face sizes add up to {counted} corners, but there are {given} indices")]
    CornerCount {
        /// Sum of the face sizes.
        counted: usize,
        /// Number of indices given.
        given: usize,
    },
    /// More elements than 32-bit indices can name.
    #[error("the mesh has {count} {what}; at most {limit} are supported")]
    TooLarge {
        /// "corners", "vertices", "faces" or "edges".
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// Faces round a vertex, or corners of a face, whose patches would take too much memory: see
    /// [`MOST_POLE_BYTES`](crate::MOST_POLE_BYTES).
    #[error(
        "{pole}: a patch table would take about {:.1} GB for its rings and plans, more than the {:.1} GB that are allowed; {}",
        *bytes as f64 / 1e9, *limit as f64 / 1e9, pole.advice()
    )]
    PoleTooLarge {
        /// Where.
        pole: Pole,
        /// Bytes that it would take, estimated.
        bytes: u64,
        /// Bytes that it may take.
        limit: u64,
    },
    /// A crease names a vertex that does not exist, or two vertices that no edge joins.
    #[error("crease {crease} names vertices {a} and {b}, but no edge joins them")]
    CreaseNotOnEdge {
        /// Position in [`Tags::creases`].
        crease: usize,
        /// First vertex.
        a: u32,
        /// Second vertex.
        b: u32,
    },
    /// A corner names a vertex that does not exist.
    #[error("corner {corner} names vertex {vertex} of {vertices} (vertices count from 0)")]
    CornerOutOfRange {
        /// Position in [`Tags::corners`].
        corner: usize,
        /// The vertex.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// A hole names a face that does not exist.
    #[error("hole {hole} names face {face} of {faces} (faces count from 0)")]
    HoleOutOfRange {
        /// Position in [`Tags::holes`].
        hole: usize,
        /// The face.
        face: u32,
        /// How many there are.
        faces: usize,
    },
    /// Loop subdivision is defined for triangles; [`ControlMesh::triangulated`] makes them.
    #[error(
        "face {face} has {sides} corners; Loop subdivision needs triangles: split polygons (--split-polygons on the \
         command line), or use Catmull-Clark"
    )]
    NotATriangle {
        /// The face.
        face: usize,
        /// Its number of corners.
        sides: usize,
    },
    /// A sharpness that is no finite number.
    #[error("{what} {index} has sharpness {sharpness}; use a finite number, 10 for infinitely sharp")]
    BadSharpness {
        /// "crease" or "corner".
        what: &'static str,
        /// Position in its list.
        index: usize,
        /// The offending value.
        sharpness: f64,
    },
}

/// A place where very many faces or sub-faces meet.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Pole {
    /// A vertex of many faces.
    Vertex {
        /// The vertex.
        vertex: u32,
        /// Its number of faces.
        faces: usize,
    },
    /// A face of many corners.
    Face {
        /// The face.
        face: u32,
        /// Its number of corners.
        corners: usize,
    },
}

impl Pole {
    /// What to do about it.
    fn advice(self) -> &'static str {
        match self {
            Self::Vertex { .. } => "let fewer faces meet there, or refine level by level, which needs no patch table",
            Self::Face { .. } => "cut it into smaller ones, or refine level by level, which needs no patch table",
        }
    }
}

impl std::fmt::Display for Pole {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Vertex { vertex, faces } => write!(f, "vertex {vertex} (counted from 0) has {faces} faces"),
            Self::Face { face, corners } => write!(f, "face {face} (counted from 0) has {corners} corners"),
        }
    }
}

/// Largest number of corners, vertices, faces or edges of a mesh or refinement level: the last value of a `u32` is
/// kept free.
pub const MAX_COUNT: usize = u32::MAX as usize - 1;

/// A polygonal control mesh: faces of any size ≥ 3, counter-clockwise, and tags.
///
/// Connectivity only; positions and other attributes are plain arrays that are handed to what evaluates them.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlMesh {
    vertex_count: usize,
    /// Face `f` has corners `face_offset[f]..face_offset[f + 1]` of `corners`.
    face_offset: Vec<u32>,
    corners: Vec<u32>,
    tags: Tags,
}

impl ControlMesh {
    /// A mesh from a list of faces, each a list of vertices in counter-clockwise order. The number of vertices is one
    /// more than the largest index; use [`ControlMesh::from_counts`] where isolated vertices follow.
    ///
    /// # Errors
    /// [`MeshError`] names the first offending face or tag.
    pub fn new<F: AsRef<[u32]>>(faces: &[F], tags: Tags) -> Result<Self, MeshError> {
        let counts: Vec<u32> = faces.iter().map(|f| f.as_ref().len() as u32).collect();
        let mut corners = subsurf_memory::with_capacity(counts.iter().map(|&n| n as usize).sum());
        faces.iter().for_each(|f| corners.extend_from_slice(f.as_ref()));
        let vertex_count = corners.iter().max().map_or(0, |&v| v as usize + 1);
        Self::from_counts(vertex_count, &counts, corners, tags)
    }

    /// A mesh from face sizes and one flat list of vertices, as USD and OpenSubdiv store it.
    ///
    /// # Errors
    /// [`MeshError`] names the first offending face or tag. That a crease lies on an edge is found when the mesh's
    /// [`Topology`](crate::Topology) is built.
    pub fn from_counts(vertex_count: usize, counts: &[u32], corners: Vec<u32>, tags: Tags) -> Result<Self, MeshError> {
        if counts.is_empty() {
            return Err(MeshError::NoFaces);
        }
        for (what, count) in [("vertices", vertex_count), ("corners", corners.len())] {
            if count > MAX_COUNT {
                return Err(MeshError::TooLarge { what, count, limit: MAX_COUNT });
            }
        }
        let mut face_offset = subsurf_memory::with_capacity(counts.len() + 1);
        let mut end = 0usize;
        face_offset.push(0);
        for (face, &sides) in counts.iter().enumerate() {
            if sides < 3 {
                return Err(MeshError::FaceTooSmall { face, sides: sides as usize });
            }
            end += sides as usize;
            if end > corners.len() {
                break;
            }
            face_offset.push(end as u32);
        }
        if end != corners.len() {
            let counted = counts.iter().map(|&n| n as usize).sum();
            return Err(MeshError::CornerCount { counted, given: corners.len() });
        }
        let mesh = Self { vertex_count, face_offset, corners, tags };
        mesh.check_vertices()?;
        mesh.check_tags()?;
        Ok(mesh)
    }

    fn check_vertices(&self) -> Result<(), MeshError> {
        let vertices = self.vertex_count;
        // The largest is found in a fraction of the time that it takes to look for the first that is too large.
        if self.corners.iter().fold(0, |most, &v| v.max(most)) < vertices as u32 {
            return Ok(());
        }
        match self.corners.iter().position(|&v| v as usize >= vertices) {
            None => Ok(()),
            Some(corner) => Err(MeshError::VertexOutOfRange {
                face: self.face_offset.partition_point(|&o| o as usize <= corner) - 1,
                vertex: self.corners[corner],
                vertices,
            }),
        }
    }

    fn check_tags(&self) -> Result<(), MeshError> {
        let (vertices, faces) = (self.vertex_count, self.face_count());
        for (crease, c) in self.tags.creases.iter().enumerate() {
            let [a, b] = c.vertices;
            if a == b || a as usize >= vertices || b as usize >= vertices {
                return Err(MeshError::CreaseNotOnEdge { crease, a, b });
            }
            if !c.sharpness.is_finite() {
                return Err(MeshError::BadSharpness { what: "crease", index: crease, sharpness: c.sharpness });
            }
        }
        for (corner, c) in self.tags.corners.iter().enumerate() {
            if c.vertex as usize >= vertices {
                return Err(MeshError::CornerOutOfRange { corner, vertex: c.vertex, vertices });
            }
            if !c.sharpness.is_finite() {
                return Err(MeshError::BadSharpness { what: "corner", index: corner, sharpness: c.sharpness });
            }
        }
        match self.tags.holes.iter().position(|&f| f as usize >= faces) {
            Some(hole) => Err(MeshError::HoleOutOfRange { hole, face: self.tags.holes[hole], faces }),
            None => Ok(()),
        }
    }

    /// Number of vertices, isolated ones included.
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// Number of faces, holes included.
    pub fn face_count(&self) -> usize {
        self.face_offset.len() - 1
    }

    /// The vertices of face `face`, counter-clockwise.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn face_vertices(&self, face: usize) -> &[u32] {
        &self.corners[self.face_offset[face] as usize..self.face_offset[face + 1] as usize]
    }

    /// All faces in order.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        self.face_offset.windows(2).map(|w| &self.corners[w[0] as usize..w[1] as usize])
    }

    /// Start of every face in [`corners`](Self::corners), and the end of the last one.
    pub fn face_offsets(&self) -> &[u32] {
        &self.face_offset
    }

    /// All face corners, one flat list.
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// The same mesh under other rules.
    pub fn with_rules(mut self, rules: Rules) -> Self {
        self.tags.rules = rules;
        self
    }

    /// Creases, corners, holes and rules.
    pub fn tags(&self) -> &Tags {
        &self.tags
    }
}

/// `sharpness` clamped to `[0, 10]`.
pub(crate) fn clamp_sharpness(sharpness: f64) -> f64 {
    sharpness.clamp(0.0, INFINITE_SHARPNESS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tags::{Corner, Crease};

    #[test]
    fn a_face_of_two_vertices_is_refused_by_name() {
        let error = ControlMesh::new(&[vec![0, 1, 2], vec![0, 1]], Tags::default()).unwrap_err();
        assert_eq!(error, MeshError::FaceTooSmall { face: 1, sides: 2 });
    }

    #[test]
    fn a_vertex_out_of_range_is_refused_with_its_face() {
        let error = ControlMesh::from_counts(3, &[3, 3], vec![0, 1, 2, 0, 1, 3], Tags::default()).unwrap_err();
        assert_eq!(error, MeshError::VertexOutOfRange { face: 1, vertex: 3, vertices: 3 });
    }

    #[test]
    fn tags_must_name_elements_that_exist_with_finite_sharpness() {
        let quad = [[0u32, 1, 2, 3]];
        let tags = |creases, corners, holes| Tags { creases, corners, holes, ..Tags::default() };
        let refuse = |tags| ControlMesh::new(&quad, tags).unwrap_err();
        assert!(matches!(
            refuse(tags(vec![Crease::new(0, 9, 1.0)], vec![], vec![])),
            MeshError::CreaseNotOnEdge { crease: 0, a: 0, b: 9 }
        ));
        assert!(matches!(
            refuse(tags(vec![Crease::new(0, 1, f64::NAN)], vec![], vec![])),
            MeshError::BadSharpness { what: "crease", .. }
        ));
        assert!(matches!(
            refuse(tags(vec![], vec![Corner::new(4, 1.0)], vec![])),
            MeshError::CornerOutOfRange { vertex: 4, .. }
        ));
        assert!(matches!(refuse(tags(vec![], vec![], vec![1])), MeshError::HoleOutOfRange { face: 1, .. }));
    }

    #[test]
    fn counts_must_add_up() {
        let error = ControlMesh::from_counts(4, &[4, 4], vec![0, 1, 2, 3], Tags::default()).unwrap_err();
        assert_eq!(error, MeshError::CornerCount { counted: 8, given: 4 });
    }
}
