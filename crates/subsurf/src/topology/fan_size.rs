//! How many faces lie round a vertex, found once for all who ask: in the build of the tables, where it tells which vertices are
//! manifold, and in that of a patch table.

use super::{FaceOf, Topology};
use crate::index::Vertex;
use rayon::prelude::*;

/// The fan that starts at a vertex' leading half-edge, in two bytes: faces (63 stands for more), whether the fan is closed,
/// whether all faces are quads, and the number of points of the faces beside the vertex and one more per face (255 for more).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FanSize(u16);

const MANY_FACES: u16 = 63;
const CLOSED: u16 = 1 << 6;
const QUADS: u16 = 1 << 7;
const MANY_POINTS: u16 = 255;

/// Vertices that a thread takes at a time.
const SHARE: usize = 1 << 13;

impl FanSize {
    /// Those of all vertices, and the number of faces in all fans together.
    pub fn all(t: &Topology) -> (Vec<Self>, usize) {
        let mut all = subsurf_memory::with_capacity(t.vertex_count);
        all.resize(t.vertex_count, Self::default());
        let share = |(share, sizes): (usize, &mut [Self])| {
            let mut sum = 0;
            for (size, v) in sizes.iter_mut().zip((share * SHARE) as u32..) {
                let faces;
                (*size, faces) = Self::with_faces(t, Vertex(v));
                sum += faces;
            }
            sum
        };
        let sum = all.par_chunks_mut(SHARE).enumerate().map(share).sum();
        (all, sum)
    }

    /// That of one vertex.
    #[cfg(test)]
    pub fn of(t: &Topology, v: Vertex) -> Self {
        Self::with_faces(t, v).0
    }

    #[inline]
    fn with_faces(t: &Topology, v: Vertex) -> (Self, usize) {
        let (faces, points, quads, closed) = walk(t, v);
        let few_faces = faces.min(usize::from(MANY_FACES)) as u16;
        let points = points.min(usize::from(MANY_POINTS)) as u16;
        let flags = if closed { CLOSED } else { 0 } | if quads { QUADS } else { 0 };
        (Self(few_faces | flags | (points << 8)), faces)
    }

    /// True at a vertex of no face.
    #[inline]
    pub fn is_empty(self) -> bool {
        self.0 & MANY_FACES == 0
    }

    /// Number of faces.
    pub fn faces(self, t: &Topology, v: Vertex) -> usize {
        match self.few_faces() {
            Some(few) => few,
            None => walk(t, v).0,
        }
    }

    /// The same where the vertex is not asked: none for very many.
    #[inline]
    pub fn few_faces(self) -> Option<usize> {
        let faces = self.0 & MANY_FACES;
        (faces < MANY_FACES).then_some(usize::from(faces))
    }

    /// Number of faces where the fan is closed and of quads, but for very many.
    #[inline]
    pub fn closed_quads(self) -> Option<usize> {
        if self.0 & (CLOSED | QUADS) == CLOSED | QUADS { self.few_faces() } else { None }
    }

    /// Vertices of the faces beside the vertex, where all are different.
    pub fn points(self, t: &Topology, v: Vertex) -> usize {
        let points = match self.0 >> 8 {
            MANY_POINTS => walk(t, v).1,
            few => usize::from(few),
        };
        points + usize::from(self.0 & CLOSED == 0)
    }
}

/// Faces, their corners but two each, whether all are quads, and whether the fan is closed.
#[inline]
fn walk(t: &Topology, v: Vertex) -> (usize, usize, bool, bool) {
    if matches!(t.face, FaceOf::Quads) {
        let mut faces = 0;
        let closed = t.walk_fan(v, |_| faces += 1);
        return (faces, 2 * faces, true, closed);
    }
    let (mut faces, mut points, mut quads) = (0, 0, true);
    let closed = t.walk_fan(v, |h| {
        let sides = t.sides_at(h);
        faces += 1;
        points += sides - 2;
        quads &= sides == 4;
    });
    (faces, points, quads, closed)
}
