//! The mesh to be written, borrowed from whoever computed it, and its check.

use std::io::{self, Write};
use std::ops::Range;
use subsurf::Tags;
use thiserror::Error;

/// A polygon mesh to write. `T` is `f32` or `f64`.
#[derive(Clone, Copy, Debug)]
pub struct OutputMesh<'a, T> {
    /// Vertex positions.
    pub positions: &'a [[T; 3]],
    /// How many corners each face has.
    pub sizes: FaceSizes<'a>,
    /// The vertices of all faces, one flat list, counter-clockwise.
    pub corners: &'a [u32],
    /// Normals.
    pub normals: Option<Attribute<'a, T, 3>>,
    /// Texture coordinates, origin at the bottom left.
    pub texture: Option<Attribute<'a, T, 2>>,
    /// Creases, corners, holes and rules; only OBJ files keep them.
    pub tags: Option<&'a Tags>,
}

/// How many corners the faces of an [`OutputMesh`] have.
#[derive(Clone, Copy, Debug)]
pub enum FaceSizes<'a> {
    /// All the same.
    Uniform(u32),
    /// Face `f` has the corners `offsets[f]..offsets[f + 1]`; the first offset is 0.
    Offsets(&'a [u32]),
}

/// Values at face corners.
#[derive(Clone, Copy, Debug)]
pub struct Attribute<'a, T, const N: usize> {
    /// The values.
    pub values: &'a [[T; N]],
    /// One index into `values` for each corner; without, the corner's vertex is the index and there are as many values
    /// as positions.
    pub indices: Option<&'a [u32]>,
}

/// Why a mesh cannot be written; faces, corners and values are counted from 0.
#[derive(Clone, PartialEq, Eq, Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// There is nothing to write.
    #[error("the mesh has no faces: nothing to write")]
    NoFaces,
    /// The face sizes do not make up the list of corners.
    #[error("the face sizes do not add up to the {corners} corners")]
    CornerCount {
        /// How many corners are given.
        corners: usize,
    },
    /// A face of fewer than three corners.
    #[error("face {face} has fewer than 3 corners")]
    FaceTooSmall {
        /// The face.
        face: usize,
    },
    /// An index of something that does not exist.
    #[error("corner {corner} names {what} {index} of {count}")]
    IndexOutOfRange {
        /// "position", "normal" or "texture coordinate".
        what: &'static str,
        /// Position in the list of corners.
        corner: usize,
        /// The index.
        index: u32,
        /// How many there are.
        count: usize,
    },
    /// The indices of an attribute are not one for each corner, or its values not one for each vertex.
    #[error("{given} {what} entries are given where {needed} are needed")]
    AttributeCount {
        /// "normal" or "texture coordinate".
        what: &'static str,
        /// How many are given.
        given: usize,
        /// How many are needed.
        needed: usize,
    },
    /// A value that is not a number or infinite, or too large for the format.
    #[error("{what} {index} is not a finite number, or too large for the format")]
    NotFinite {
        /// "position", "normal" or "texture coordinate".
        what: &'static str,
        /// Position in its list.
        index: usize,
    },
    /// More than the format can count.
    #[error("the mesh is too large for {format}; write OBJ, or refine less")]
    TooLarge {
        /// The format's name.
        format: &'static str,
    },
}

impl<'a, T: Real> OutputMesh<'a, T> {
    /// Number of faces.
    pub fn face_count(&self) -> usize {
        match self.sizes {
            FaceSizes::Uniform(sides) => self.corners.len() / sides.max(1) as usize,
            FaceSizes::Offsets(offsets) => offsets.len().saturating_sub(1),
        }
    }

    /// Where in the list of corners each face lies.
    pub fn faces(&self) -> impl Iterator<Item = Range<usize>> + use<'a, T> {
        let sizes = self.sizes;
        (0..self.face_count()).map(move |face| match sizes {
            FaceSizes::Uniform(sides) => face * sides as usize..(face + 1) * sides as usize,
            FaceSizes::Offsets(offsets) => offsets[face] as usize..offsets[face + 1] as usize,
        })
    }

    /// Refuses a mesh that cannot be written.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<(), OutputError> {
        let corners = self.corners.len();
        if self.face_count() == 0 {
            return Err(OutputError::NoFaces);
        }
        match self.sizes {
            FaceSizes::Uniform(sides) if sides < 3 => return Err(OutputError::FaceTooSmall { face: 0 }),
            FaceSizes::Uniform(sides) if !corners.is_multiple_of(sides as usize) => {
                return Err(OutputError::CornerCount { corners });
            }
            FaceSizes::Uniform(_) => {}
            FaceSizes::Offsets(offsets) => {
                if let Some(face) = offsets.windows(2).position(|w| w[1] < w[0].saturating_add(3)) {
                    return Err(OutputError::FaceTooSmall { face });
                }
                if offsets[0] != 0 || offsets[offsets.len() - 1] as usize != corners {
                    return Err(OutputError::CornerCount { corners });
                }
            }
        }
        check_indices("position", self.corners, self.positions.len())?;
        check_finite("position", self.positions)?;
        if let Some(normals) = &self.normals {
            normals.check("normal", corners, self.positions.len())?;
        }
        if let Some(texture) = &self.texture {
            texture.check("texture coordinate", corners, self.positions.len())?;
        }
        Ok(())
    }
}

impl<T: Real, const N: usize> Attribute<'_, T, N> {
    fn check(&self, what: &'static str, corners: usize, vertices: usize) -> Result<(), OutputError> {
        let (given, needed) = match self.indices {
            Some(indices) => (indices.len(), corners),
            None => (self.values.len(), vertices),
        };
        if given != needed {
            return Err(OutputError::AttributeCount { what, given, needed });
        }
        if let Some(indices) = self.indices {
            check_indices(what, indices, self.values.len())?;
        }
        check_finite(what, self.values)
    }

    /// Whether each vertex has one value, at its own index.
    pub(crate) fn is_shared(&self, corners: &[u32], vertices: usize) -> bool {
        self.indices.is_none_or(|indices| self.values.len() >= vertices && indices == corners)
    }
}

fn check_indices(what: &'static str, indices: &[u32], count: usize) -> Result<(), OutputError> {
    match indices.iter().position(|&index| index as usize >= count) {
        Some(corner) => Err(OutputError::IndexOutOfRange { what, corner, index: indices[corner], count }),
        None => Ok(()),
    }
}

fn check_finite<T: Real, const N: usize>(what: &'static str, values: &[[T; N]]) -> Result<(), OutputError> {
    match values.iter().position(|value| value.iter().any(|&x| !x.into().is_finite())) {
        Some(index) => Err(OutputError::NotFinite { what, index }),
        None => Ok(()),
    }
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// The numbers of an [`OutputMesh`]: `f32` or `f64`.
pub trait Real: Copy + Into<f64> + sealed::Sealed {
    /// What PLY calls it.
    #[doc(hidden)]
    const PLY_NAME: &'static str;

    /// Writes the fewest digits from which the same number is read.
    #[doc(hidden)]
    fn write_shortest(self, out: &mut impl Write) -> io::Result<()>;

    /// Writes the bytes, least significant first.
    #[doc(hidden)]
    fn write_bytes(self, out: &mut impl Write) -> io::Result<()>;

    /// The nearest `f32`.
    #[doc(hidden)]
    fn to_f32(self) -> f32;
}

macro_rules! real {
    ($number:ty, $ply_name:literal) => {
        impl Real for $number {
            const PLY_NAME: &'static str = $ply_name;

            #[inline]
            fn write_shortest(self, out: &mut impl Write) -> io::Result<()> {
                let mut digits = zmij::Buffer::new();
                let text = digits.format_finite(self);
                out.write_all(text.strip_suffix(".0").unwrap_or(text).as_bytes())
            }

            #[inline]
            fn write_bytes(self, out: &mut impl Write) -> io::Result<()> {
                out.write_all(&self.to_le_bytes())
            }

            #[inline]
            fn to_f32(self) -> f32 {
                self as f32
            }
        }
    };
}

real!(f32, "float");
real!(f64, "double");

#[cfg(test)]
mod tests {
    use super::*;

    const POSITIONS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    fn quad() -> OutputMesh<'static, f32> {
        OutputMesh {
            positions: &POSITIONS,
            sizes: FaceSizes::Uniform(4),
            corners: &[0, 1, 2, 3],
            normals: None,
            texture: None,
            tags: None,
        }
    }

    #[test]
    fn sizes_must_make_up_the_corners() {
        assert_eq!(quad().check(), Ok(()));
        let with = |sizes| OutputMesh { sizes, ..quad() }.check();
        assert_eq!(with(FaceSizes::Offsets(&[0, 4])), Ok(()));
        assert_eq!(with(FaceSizes::Offsets(&[0, 3])), Err(OutputError::CornerCount { corners: 4 }));
        assert_eq!(with(FaceSizes::Offsets(&[0, 4, 2])), Err(OutputError::FaceTooSmall { face: 1 }));
        assert_eq!(with(FaceSizes::Uniform(3)), Err(OutputError::CornerCount { corners: 4 }));
        assert_eq!(with(FaceSizes::Uniform(2)), Err(OutputError::FaceTooSmall { face: 0 }));
        assert_eq!(with(FaceSizes::Offsets(&[])), Err(OutputError::NoFaces));
        assert!(with(FaceSizes::Uniform(0)).is_err());
    }

    #[test]
    fn indices_and_values_are_checked_by_name() {
        let error = OutputMesh { corners: &[0, 1, 2, 4], ..quad() }.check();
        assert_eq!(error, Err(OutputError::IndexOutOfRange { what: "position", corner: 3, index: 4, count: 4 }));
        let error = OutputMesh { positions: &[[f32::NAN; 3]; 4], ..quad() }.check();
        assert_eq!(error, Err(OutputError::NotFinite { what: "position", index: 0 }));
        let texture = Some(Attribute { values: &[[0.0, 0.0]], indices: None });
        let error = OutputMesh { texture, ..quad() }.check();
        assert_eq!(error, Err(OutputError::AttributeCount { what: "texture coordinate", given: 1, needed: 4 }));
        let normals = Some(Attribute { values: &[[0.0; 3]], indices: Some(&[0, 0, 0, 1]) });
        let error = OutputMesh { normals, ..quad() }.check();
        assert_eq!(error, Err(OutputError::IndexOutOfRange { what: "normal", corner: 3, index: 1, count: 1 }));
    }
}
