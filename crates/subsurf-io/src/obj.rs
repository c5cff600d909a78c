//! Wavefront OBJ, read in one pass: `v vt vn f` and the subdivision tags `t`. Faces may have any size and may stand
//! before their vertices. Lines, points, groups, names and smoothing groups are passed over, other statements too, with
//! a warning. Bytes that are no UTF-8 are fine, they only occur in names and comments.
//!
//! Source: Wavefront, "Object Files (.obj)", Advanced Visualizer manual, appendix B1.

use crate::line::LineReader;
use crate::number::integer;
use crate::obj_tag::TagLines;
use crate::read_error::{LineError, ReadError, quoted};
use crate::scene::{Channel, ReadOptions, Scene, Warning, WarningKind};
use crate::source_lines::SourceLines;
use crate::words::Words;
use std::io::Read;
use subsurf::{ControlMesh, Tags};

/// Reads an OBJ file from `source` to its end, a block at a time. Messages call it `name`.
///
/// # Errors
/// [`ReadError`] names the first line that is wrong, or what keeps the whole from being a mesh. That each crease lies on
/// an edge is only found when the mesh's topology is built; [`SourceLines::of_error`] then names the line.
pub fn read_obj(source: impl Read, name: &str, options: &ReadOptions) -> Result<Scene, ReadError> {
    let mut lines = LineReader::new(source);
    let mut file = Statements::default();
    while let Some((text, line)) = lines.next_line().map_err(|error| ReadError::from_io(name, error))? {
        if line == 1 && (text.starts_with(b"\xff\xfe") || text.starts_with(b"\xfe\xff")) {
            return Err(ReadError::Utf16 { name: name.to_owned() });
        }
        file.last_line = line;
        file.read(text, line).map_err(|source| ReadError::Line { name: name.to_owned(), line, source })?;
    }
    file.finish(name, options)
}

/// What the lines said so far.
#[derive(Default)]
struct Statements {
    positions: Vec<[f64; 3]>,
    sides: Vec<u32>,
    corners: Vec<u32>,
    texture: CornerValues<2>,
    normals: CornerValues<3>,
    tags: TagLines,
    lines: SourceLines,
    warnings: Vec<Warning>,
    /// Number of the last line that is not part of another.
    last_line: u32,
}

/// In the indices of a channel: this corner's face has none. Replaced before the file is handed on.
const NONE: u32 = u32::MAX;

/// The largest index, counted from 1, that a file may name.
const MAX_INDEX: i64 = u32::MAX as i64 - 1;

/// Texture coordinates or normals: values, and an index for each corner once any face has named one.
#[derive(Default)]
struct CornerValues<const N: usize> {
    values: Vec<[f64; N]>,
    indices: Vec<u32>,
}

impl Statements {
    fn read(&mut self, text: &[u8], line: u32) -> Result<(), LineError> {
        let mut words = Words::new(text);
        match words.next() {
            None => Ok(()),
            Some(b"v") => self.position(words),
            Some(b"f" | b"fo") => self.face(words, line),
            Some(b"vt") => {
                let mut value = [0.0; 2];
                let found = read_numbers(&mut words, "vt", &mut value)?;
                require("vt", 1, found)?;
                self.texture.push(value, line, WarningKind::NonFiniteTexture, &mut self.warnings);
                Ok(())
            }
            Some(b"vn") => {
                let mut value = [0.0; 3];
                let found = read_numbers(&mut words, "vn", &mut value)?;
                require("vn", 3, found)?;
                self.normals.push(value, line, WarningKind::NonFiniteNormal, &mut self.warnings);
                Ok(())
            }
            Some(b"t") => self.tags.read(words, line, &mut self.lines, &mut self.warnings),
            Some(b"g" | b"o" | b"s" | b"l" | b"p" | b"usemtl" | b"mtllib") => Ok(()),
            Some(_) => {
                Warning::count(&mut self.warnings, WarningKind::UnknownStatement, line);
                Ok(())
            }
        }
    }

    /// `v x y z`; a weight or colours behind are passed over.
    fn position(&mut self, mut words: Words<'_>) -> Result<(), LineError> {
        let mut position = [0.0; 3];
        for i in 0..3 {
            match words.finite_number("v", "repair the vertex where the file was made")? {
                Some(value) => position[i] = value,
                None => return require("v", 3, i),
            }
        }
        self.positions.push(position);
        Ok(())
    }

    /// `f a/b/c …`
    fn face(&mut self, words: Words<'_>, line: u32) -> Result<(), LineError> {
        let first = self.corners.len();
        let (mut textured, mut with_normal) = (0, 0);
        for word in words {
            let Some([Some(vertex), texture, normal]) = read_corner(word) else {
                return Err(LineError::BadCorner { word: quoted(word) });
            };
            self.corners.push(resolve(vertex, self.positions.len(), "vertex")?);
            if let Some(index) = texture {
                textured += 1;
                self.texture.name(index, self.corners.len(), "texture coordinate")?;
            }
            if let Some(index) = normal {
                with_normal += 1;
                self.normals.name(index, self.corners.len(), "normal")?;
            }
        }
        let corners = self.corners.len() - first;
        if corners < 3 {
            return Err(LineError::FaceTooSmall { corners });
        }
        if textured != 0 && textured != corners {
            return Err(LineError::MixedCorners { what: "texture coordinate" });
        }
        if with_normal != 0 && with_normal != corners {
            return Err(LineError::MixedCorners { what: "normal" });
        }
        self.sides.push(u32::try_from(corners).unwrap_or(u32::MAX));
        self.lines.push_face(line);
        Ok(())
    }

    /// Makes the mesh and checks what could not be checked before the end of the file.
    fn finish(mut self, name: &str, options: &ReadOptions) -> Result<Scene, ReadError> {
        if self.sides.is_empty() {
            let (name, lines, vertices) = (name.to_owned(), self.last_line, self.positions.len());
            return Err(ReadError::NoFaces { name, lines, vertices });
        }
        let corners = self.corners.len();
        self.check_range(&self.corners, self.positions.len(), "vertex", name)?;
        self.check_range(&self.texture.indices, self.texture.values.len(), "texture coordinate", name)?;
        self.check_range(&self.normals.indices, self.normals.values.len(), "normal", name)?;
        let texture = self.texture.complete(corners);
        let normals = self.normals.complete(corners);
        if let Some((_, at)) = &texture {
            self.warn_of_faces(at, WarningKind::UntexturedFace);
        }
        if let Some((_, at)) = &normals {
            self.warn_of_faces(at, WarningKind::FaceWithoutNormals);
        }

        let TagLines { creases, corners, holes, rules } = self.tags;
        let tags = Tags { creases, corners, holes, rules: rules.over(options.rules) };
        let mesh = ControlMesh::from_counts(self.positions.len(), &self.sides, self.corners, tags)
            .map_err(|source| ReadError::Mesh { name: name.to_owned(), line: self.lines.of_error(&source), source })?;
        Ok(Scene {
            mesh,
            positions: self.positions,
            texture: texture.map(|(channel, _)| channel),
            normals: normals.map(|(channel, _)| channel),
            scheme: None,
            file_rules: rules,
            lines: self.lines,
            warnings: self.warnings,
        })
    }

    /// Refuses the first index that names none of `count` values.
    fn check_range(&self, indices: &[u32], count: usize, what: &'static str, name: &str) -> Result<(), ReadError> {
        let Some(corner) = indices.iter().position(|&i| i as usize >= count && i != NONE) else { return Ok(()) };
        let source = LineError::IndexOutOfRange { what, index: i64::from(indices[corner]) + 1, count };
        let line = self.face_of_corner(corner).and_then(|face| self.lines.face(face)).unwrap_or(0);
        Err(ReadError::Line { name: name.to_owned(), line, source })
    }

    /// The face that has corner `corner`.
    fn face_of_corner(&self, corner: usize) -> Option<usize> {
        let mut end = 0;
        self.sides.iter().position(|&sides| {
            end += sides as usize;
            corner < end
        })
    }

    /// Counts the faces whose first corner is among `corners`, which ascend.
    fn warn_of_faces(&mut self, corners: &[usize], kind: WarningKind) {
        let mut corners = corners.iter().peekable();
        let mut start = 0;
        for (face, &sides) in self.sides.iter().enumerate() {
            let end = start + sides as usize;
            if corners.peek().is_some_and(|&&corner| corner == start) {
                Warning::count(&mut self.warnings, kind, self.lines.face(face).unwrap_or(0));
                while corners.next_if(|&&corner| corner < end).is_some() {}
            }
            start = end;
        }
    }
}

impl<const N: usize> CornerValues<N> {
    fn push(&mut self, mut value: [f64; N], line: u32, kind: WarningKind, warnings: &mut Vec<Warning>) {
        if value.iter().any(|x| !x.is_finite()) {
            Warning::count(warnings, kind, line);
            value = [0.0; N];
        }
        self.values.push(value);
    }

    /// Gives the last of `corners` corners the value `index`; earlier corners that have none keep none.
    fn name(&mut self, index: i64, corners: usize, what: &'static str) -> Result<(), LineError> {
        let index = resolve(index, self.values.len(), what)?;
        self.indices.resize(corners - 1, NONE);
        self.indices.push(index);
        Ok(())
    }

    /// The channel, if any corner has a value, and the corners that had none: they share a zero at the end.
    fn complete(&mut self, corners: usize) -> Option<(Channel<N>, Vec<usize>)> {
        if self.indices.is_empty() {
            return None;
        }
        self.indices.resize(corners, NONE);
        let empty: Vec<usize> = (0..corners).filter(|&corner| self.indices[corner] == NONE).collect();
        if !empty.is_empty() {
            let zero = self.values.len() as u32;
            self.values.push([0.0; N]);
            empty.iter().for_each(|&corner| self.indices[corner] = zero);
        }
        let (values, indices) = (std::mem::take(&mut self.values), std::mem::take(&mut self.indices));
        Some((Channel { values, indices }, empty))
    }
}

/// Reads up to `N` numbers and returns how many there were.
fn read_numbers<const N: usize>(
    words: &mut Words<'_>,
    statement: &'static str,
    into: &mut [f64; N],
) -> Result<usize, LineError> {
    for i in 0..N {
        match words.number(statement)? {
            Some(value) => into[i] = value,
            None => return Ok(i),
        }
    }
    Ok(N)
}

/// Refuses a statement with fewer numbers than it needs.
fn require(statement: &'static str, needed: usize, found: usize) -> Result<(), LineError> {
    if found < needed { Err(LineError::TooFewNumbers { statement, needed, found }) } else { Ok(()) }
}

/// The indices of `v`, `v/vt`, `v//vn` or `v/vt/vn`, as they stand in the file. Empty places at the end are allowed.
#[inline]
fn read_corner(word: &[u8]) -> Option<[Option<i64>; 3]> {
    let mut indices = [None; 3];
    let mut rest = word;
    for (place, index) in indices.iter_mut().enumerate() {
        if let Some((value, length)) = integer(rest) {
            *index = Some(value);
            rest = &rest[length..];
        }
        match rest.split_first() {
            None => return Some(indices),
            Some((b'/', behind)) if place < 2 => rest = behind,
            Some(_) => return None,
        }
    }
    Some(indices)
}

/// The index from 0 for one as it stands in the file, where `count` values precede. One that counts forwards may name
/// a value that follows; the end of the file decides.
#[inline]
fn resolve(index: i64, count: usize, what: &'static str) -> Result<u32, LineError> {
    let resolved = match index {
        0 => return Err(LineError::IndexZero { what }),
        1..=MAX_INDEX => index - 1,
        ..0 => (count as i64).saturating_add(index),
        _ => -1,
    };
    match u32::try_from(resolved) {
        Ok(resolved) if resolved != NONE => Ok(resolved),
        _ => Err(LineError::IndexOutOfRange { what, index, count }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use subsurf::{Boundary, Corner, Crease, MeshError, Rules};

    fn scene(text: &str) -> Scene {
        read_obj(text.as_bytes(), "test.obj", &ReadOptions::default()).unwrap()
    }

    /// The line and trouble that reading ends with.
    fn refusal(text: &str) -> (u32, LineError) {
        match read_obj(text.as_bytes(), "test.obj", &ReadOptions::default()) {
            Err(ReadError::Line { line, source, .. }) => (line, source),
            other => panic!("{other:?}"),
        }
    }

    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    #[test]
    fn faces_of_any_size_are_read_with_forward_and_backward_indices() {
        let read = scene("f 1 2 3\nv 0 0 0 1 .5 .5 .5\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf -4 -3 -1 -2\nv 9 9 9 # alone");
        assert_eq!(read.mesh.faces().collect::<Vec<_>>(), [&[0, 1, 2][..], &[0, 1, 3, 2]]);
        assert_eq!(read.mesh.vertex_count(), 5);
        assert_eq!(read.positions[4], [9.0; 3]);
        assert_eq!((read.lines.face(0), read.lines.face(1)), (Some(1), Some(6)));
        assert!(read.warnings.is_empty());
    }

    #[test]
    fn texture_coordinates_and_normals_keep_their_own_indices() {
        let read = scene("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt .5\nvt 1 0 0\nvn 0 0 1\nf 1/2/1 2/1/1 3/-1/-1\n");
        let texture = read.texture.unwrap();
        assert_eq!((texture.values, texture.indices), (vec![[0.5, 0.0], [1.0, 0.0]], vec![1, 0, 1]));
        let normals = read.normals.unwrap();
        assert_eq!((normals.values, normals.indices), (vec![[0.0, 0.0, 1.0]], vec![0, 0, 0]));
        assert!(scene(&format!("vt 0 0\n{TRIANGLE}")).texture.is_none());
        assert_eq!(scene("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1").normals.unwrap().indices, [0; 3]);
    }

    #[test]
    fn faces_without_texture_share_a_zero_at_the_end_and_are_counted() {
        let read = scene(&format!("{TRIANGLE}vt 1 1\nf 1/1 3/1 2/1\nf 3 2 1\n"));
        let texture = read.texture.unwrap();
        assert_eq!((texture.values, texture.indices), (vec![[1.0, 1.0], [0.0, 0.0]], vec![1, 1, 1, 0, 0, 0, 1, 1, 1]));
        let [warning] = &read.warnings[..] else { panic!("{:?}", read.warnings) };
        assert_eq!(
            (warning.kind, warning.count, &warning.first_lines[..]),
            (WarningKind::UntexturedFace, 2, &[4, 7][..])
        );
    }

    #[test]
    fn tags_win_over_the_preset_and_know_their_lines() {
        let text = format!("{TRIANGLE}t interpolateboundary 1/0/0 2\nt crease 4/1/0 0 1 1 2 3\nt corner 1/1/0 2 10\n");
        let read = read_obj(text.as_bytes(), "", &ReadOptions { rules: Rules::opensubdiv() }).unwrap();
        assert_eq!(read.mesh.tags().creases, [Crease::new(0, 1, 3.0), Crease::new(1, 2, 3.0)]);
        assert_eq!(read.mesh.tags().corners, [Corner::new(2, 10.0)]);
        assert_eq!(read.mesh.tags().rules, Rules { boundary: Boundary::EdgeOnly, ..Rules::opensubdiv() });
        assert_eq!((read.file_rules.boundary, read.file_rules.creasing), (Some(Boundary::EdgeOnly), None));
        assert_eq!((read.lines.crease(1), read.lines.corner(0), read.lines.hole(0)), (Some(6), Some(7), None));
    }

    #[test]
    fn what_is_not_read_is_passed_over_and_the_unknown_is_counted() {
        let bytes =
            [TRIANGLE.as_bytes(), b"# caf\xe9 \\\nusemtl \xff\xfe\ng \xc3\nl 1 2\np 1\ncurv 0 1\nt faceedit x\n"]
                .concat();
        let read = read_obj(&bytes[..], "", &ReadOptions::default()).unwrap();
        let kinds: Vec<_> = read.warnings.iter().map(|warning| warning.kind).collect();
        assert_eq!(kinds, [WarningKind::UnknownStatement, WarningKind::HierarchicalEdit]);
    }

    #[test]
    fn positions_beyond_single_precision_are_kept() {
        assert_eq!(scene(&TRIANGLE.replace("v 1 0 0", "v 1e300 -1e-300 0.1")).positions[1], [1e300, -1e-300, 0.1]);
    }

    #[test]
    fn a_bad_statement_is_refused_with_its_line() {
        use LineError::*;
        let after = |line: &str| refusal(&format!("{TRIANGLE}{line}"));
        assert_eq!(after("v 1 2"), (5, TooFewNumbers { statement: "v", needed: 3, found: 2 }));
        assert_eq!(after("vt"), (5, TooFewNumbers { statement: "vt", needed: 1, found: 0 }));
        assert_eq!(after("v 1 2 3-"), (5, BadNumber { statement: "v", word: "3-".into() }));
        assert!(matches!(after("v 1 nan 3"), (5, NotFinite { statement: "v", .. })));
        assert_eq!(after("f 1 2"), (5, FaceTooSmall { corners: 2 }));
        assert_eq!(after("f 1 2 0"), (5, IndexZero { what: "vertex" }));
        assert_eq!(after("f 1 2 4"), (5, IndexOutOfRange { what: "vertex", index: 4, count: 3 }));
        assert_eq!(after("f 1 2 -4"), (5, IndexOutOfRange { what: "vertex", index: -4, count: 3 }));
        assert!(matches!(after("f 1 2 99999999999999999999"), (5, IndexOutOfRange { .. })));
        assert!(matches!(after("f 1 2 -99999999999999999999"), (5, IndexOutOfRange { .. })));
        assert_eq!(after("f 1/1 2/1 3/1"), (5, IndexOutOfRange { what: "texture coordinate", index: 1, count: 0 }));
        assert_eq!(after("f 1//1 2 3\nvn 0 0 1"), (5, MixedCorners { what: "normal" }));
        for word in ["1.5", "x", "/1", "1/2/3/4", "1-2", "1/2/3/"] {
            assert_eq!(after(&format!("f 1 2 {word}")), (5, BadCorner { word: word.into() }));
        }
        assert!(matches!(after("t hole 1/0/0 x"), (5, BadTagValue { .. })));
    }

    #[test]
    fn a_mesh_that_makes_no_sense_is_refused() {
        let refuse = |text: &str| read_obj(text.as_bytes(), "x", &ReadOptions::default()).unwrap_err();
        assert!(matches!(refuse("v 0 0 0\n"), ReadError::NoFaces { lines: 1, vertices: 1, .. }));
        assert!(matches!(refuse("\u{0}"), ReadError::NoFaces { lines: 1, vertices: 0, .. }));
        let error = refuse(&format!("{TRIANGLE}t hole 1/0/0 0\nt hole 1/0/0 1\n"));
        assert!(matches!(error, ReadError::Mesh { line: Some(6), source: MeshError::HoleOutOfRange { .. }, .. }));
        let utf16 = read_obj(&b"\xff\xfev\0 \0"[..], "x", &ReadOptions::default());
        assert!(matches!(utf16, Err(ReadError::Utf16 { .. })));
    }
}
