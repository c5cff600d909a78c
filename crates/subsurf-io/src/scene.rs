//! What a file holds: a control mesh with positions, texture coordinates and normals, and what the file said about
//! how to subdivide it.

use crate::output::{Attribute, FaceSizes, OutputMesh};
use crate::source_lines::SourceLines;
use std::fmt;
use subsurf::{Boundary, ControlMesh, Creasing, FaceVarying, Rules, Scheme, Triangles};

/// One mesh of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Faces and tags. Its rules are the file's, completed from [`ReadOptions::rules`].
    pub mesh: ControlMesh,
    /// One position for each vertex, isolated vertices included.
    pub positions: Vec<[f64; 3]>,
    /// Texture coordinates, if any face has some.
    pub texture: Option<Channel<2>>,
    /// Normals as the file gives them, of any length, if any face has some.
    pub normals: Option<Channel<3>>,
    /// The scheme the file names; OBJ has no word for it.
    pub scheme: Option<Scheme>,
    /// The rules that the file set itself.
    pub file_rules: FileRules,
    /// Which line each face and tag came from.
    pub lines: SourceLines,
    /// What was left out or repaired.
    pub warnings: Vec<Warning>,
}

impl Scene {
    /// The control mesh as something to write, tags included.
    pub fn output(&self) -> OutputMesh<'_, f64> {
        OutputMesh {
            positions: &self.positions,
            sizes: FaceSizes::Offsets(self.mesh.face_offsets()),
            corners: self.mesh.corners(),
            normals: self.normals.as_ref().map(Channel::attribute),
            texture: self.texture.as_ref().map(Channel::attribute),
            tags: Some(self.mesh.tags()),
        }
    }
}

/// Values with an index for each face corner: corners that share an index are joined, others meet in a seam.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel<const N: usize> {
    /// The distinct values in file order.
    pub values: Vec<[f64; N]>,
    /// One index into `values` for each entry of [`ControlMesh::corners`].
    pub indices: Vec<u32>,
}

impl<const N: usize> Channel<N> {
    fn attribute(&self) -> Attribute<'_, f64, N> {
        Attribute { values: &self.values, indices: Some(&self.indices) }
    }
}

/// How to read.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ReadOptions {
    /// The rules for what the file does not say.
    pub rules: Rules,
}

/// The rules that a file set itself; `None` where it was silent.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct FileRules {
    /// `interpolateboundary`
    pub boundary: Option<Boundary>,
    /// `creasemethod`
    pub creasing: Option<Creasing>,
    /// `smoothtriangles`
    pub triangles: Option<Triangles>,
    /// `facevaryinginterpolateboundary`
    pub face_varying: Option<FaceVarying>,
}

impl FileRules {
    /// These rules, and those of `preset` where the file was silent.
    pub fn over(self, preset: Rules) -> Rules {
        Rules {
            boundary: self.boundary.unwrap_or(preset.boundary),
            creasing: self.creasing.unwrap_or(preset.creasing),
            triangles: self.triangles.unwrap_or(preset.triangles),
            face_varying: self.face_varying.unwrap_or(preset.face_varying),
        }
    }
}

/// Something a reader left out or repaired, counted.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Warning {
    /// What.
    pub kind: WarningKind,
    /// How many times.
    pub count: usize,
    /// The first few lines where it happened, counted from 1.
    pub first_lines: Vec<u32>,
}

impl Warning {
    /// How many lines are remembered.
    const NAMED: usize = 3;

    /// Counts one more `kind`, on `line`.
    pub(crate) fn count(warnings: &mut Vec<Self>, kind: WarningKind, line: u32) {
        let known = warnings.iter().position(|warning| warning.kind == kind);
        let at = known.unwrap_or_else(|| {
            warnings.push(Self { kind, count: 0, first_lines: Vec::new() });
            warnings.len() - 1
        });
        let warning = &mut warnings[at];
        warning.count += 1;
        if warning.first_lines.len() < Self::NAMED {
            warning.first_lines.push(line);
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, done) = match self.kind {
            WarningKind::UnknownStatement => ("unknown statement", "ignored"),
            WarningKind::UnknownTag => ("unknown tag", "ignored"),
            WarningKind::HierarchicalEdit => ("hierarchical edit (obsolete)", "ignored"),
            WarningKind::UntexturedFace => ("face without texture coordinates", "given (0, 0)"),
            WarningKind::FaceWithoutNormals => ("face without normals", "given (0, 0, 0)"),
            WarningKind::NonFiniteTexture => ("texture coordinate that is no finite number", "set to zero"),
            WarningKind::NonFiniteNormal => ("normal that is no finite number", "set to zero"),
        };
        write!(f, "{what}, {done}: {}", self.count)?;
        for (i, line) in self.first_lines.iter().enumerate() {
            f.write_str(match i {
                0 if self.count == 1 => " (line ",
                0 => " (lines ",
                _ => ", ",
            })?;
            write!(f, "{line}")?;
        }
        f.write_str(if self.count > self.first_lines.len() { ", …)" } else { ")" })
    }
}

/// Kinds of [`Warning`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[non_exhaustive]
pub enum WarningKind {
    /// A statement outside the part of the format that is read; ignored.
    UnknownStatement,
    /// A tag of unknown name; ignored.
    UnknownTag,
    /// `vertexedit`, `edgeedit`, `faceedit`, which OpenSubdiv 3 gave up; ignored.
    HierarchicalEdit,
    /// A face without texture coordinates in a file that has some; all such faces share a (0, 0) at the end.
    UntexturedFace,
    /// A face without normals in a file that has some; all such faces share a zero normal at the end.
    FaceWithoutNormals,
    /// A texture coordinate that is not a number or infinite; set to zero.
    NonFiniteTexture,
    /// A normal that is not a number or infinite; set to zero.
    NonFiniteNormal,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_wins_over_the_preset_where_it_speaks() {
        let file = FileRules { boundary: Some(Boundary::EdgeOnly), ..FileRules::default() };
        let rules = file.over(Rules::opensubdiv());
        assert_eq!(rules, Rules { boundary: Boundary::EdgeOnly, ..Rules::opensubdiv() });
    }

    #[test]
    fn warnings_are_counted_and_the_first_lines_named() {
        let mut warnings = Vec::new();
        for line in [2, 4, 8, 16] {
            Warning::count(&mut warnings, WarningKind::UnknownTag, line);
        }
        assert_eq!(warnings.len(), 1);
        assert_eq!(warnings[0].to_string(), "unknown tag, ignored: 4 (lines 2, 4, 8, …)");
    }
}
