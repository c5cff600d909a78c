//! Which line of the file each face and tag came from, so that a message about face 12 can name the line.

use subsurf::{MeshError, Pole};

/// Line numbers, counted from 1, of faces and tags in file order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SourceLines {
    /// Runs of faces on consecutive lines.
    face_runs: Vec<FaceRun>,
    face_count: usize,
    pub(crate) creases: Vec<u32>,
    pub(crate) corners: Vec<u32>,
    pub(crate) holes: Vec<u32>,
}

/// Faces from `face` on lie on the lines from `line` on, one each.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FaceRun {
    face: usize,
    line: u32,
}

impl SourceLines {
    /// Adds the next face.
    pub(crate) fn push_face(&mut self, line: u32) {
        let face = self.face_count;
        if self.face(face.wrapping_sub(1)).is_none_or(|last| last.saturating_add(1) != line) {
            self.face_runs.push(FaceRun { face, line });
        }
        self.face_count += 1;
    }

    /// The line of face `face`.
    pub fn face(&self, face: usize) -> Option<u32> {
        if face >= self.face_count {
            return None;
        }
        let last = self.face_runs.last().filter(|run| run.face <= face);
        let run = last.or_else(|| self.face_runs[..self.face_runs.partition_point(|run| run.face <= face)].last())?;
        Some(run.line.saturating_add((face - run.face) as u32))
    }

    /// The line of the crease at position `crease` of [`Tags::creases`](subsurf::Tags::creases).
    pub fn crease(&self, crease: usize) -> Option<u32> {
        self.creases.get(crease).copied()
    }

    /// The line of the corner at position `corner` of [`Tags::corners`](subsurf::Tags::corners).
    pub fn corner(&self, corner: usize) -> Option<u32> {
        self.corners.get(corner).copied()
    }

    /// The line of the hole at position `hole` of [`Tags::holes`](subsurf::Tags::holes).
    pub fn hole(&self, hole: usize) -> Option<u32> {
        self.holes.get(hole).copied()
    }

    /// The line that holds the face or tag an error names.
    pub fn of_error(&self, error: &MeshError) -> Option<u32> {
        match *error {
            MeshError::FaceTooSmall { face, .. }
            | MeshError::VertexOutOfRange { face, .. }
            | MeshError::NotATriangle { face, .. } => self.face(face),
            MeshError::PoleTooLarge { pole: Pole::Face { face, .. }, .. } => self.face(face as usize),
            MeshError::CreaseNotOnEdge { crease, .. } => self.crease(crease),
            MeshError::CornerOutOfRange { corner, .. } => self.corner(corner),
            MeshError::HoleOutOfRange { hole, .. } => self.hole(hole),
            MeshError::BadSharpness { what: "crease", index, .. } => self.crease(index),
            MeshError::BadSharpness { what: "corner", index, .. } => self.corner(index),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_face_finds_its_line_and_runs_are_stored_once() {
        let given = [5, 6, 7, 10, 11, 20];
        let mut lines = SourceLines::default();
        given.iter().for_each(|&line| lines.push_face(line));
        let found: Vec<_> = (0..given.len()).filter_map(|face| lines.face(face)).collect();
        assert_eq!(found, given);
        assert_eq!(lines.face_runs.len(), 3);
        assert_eq!(lines.face(6), None);
    }

    #[test]
    fn a_face_that_loop_cannot_take_finds_its_line() {
        let mut lines = SourceLines::default();
        [5, 9].iter().for_each(|&line| lines.push_face(line));
        assert_eq!(lines.of_error(&MeshError::NotATriangle { face: 1, sides: 4 }), Some(9));
    }

    #[test]
    fn an_error_about_a_tag_finds_the_line_of_the_tag() {
        let lines = SourceLines { creases: vec![3, 4], ..SourceLines::default() };
        assert_eq!(lines.of_error(&MeshError::CreaseNotOnEdge { crease: 1, a: 0, b: 2 }), Some(4));
        assert_eq!(lines.of_error(&MeshError::NoFaces), None);
    }
}
