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

    /// Number of faces, of very many by a walk round the vertex.
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

    /// Vertices of the faces beside the vertex, where all are different; none for very many.
    #[inline]
    pub fn few_points(self) -> Option<usize> {
        let points = self.0 >> 8;
        (points < MANY_POINTS).then_some(usize::from(points) + usize::from(self.0 & CLOSED == 0))
    }

    /// False where there are fewer than `least` for sure.
    #[inline]
    pub fn may_have_points(self, least: usize) -> bool {
        usize::from(self.0 >> 8) + 1 >= least.min(usize::from(MANY_POINTS))
    }

    /// The same for any number, by a walk round the vertex.
    pub fn count_points(t: &Topology, v: Vertex) -> usize {
        let (_, points, _, closed) = walk(t, v);
        points + usize::from(!closed)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    /// The half-edges of the fan one by one, and whether it is closed.
    fn fan(t: &Topology, v: Vertex) -> (Vec<crate::index::HalfEdge>, bool) {
        let mut fan: Vec<_> = t.outgoing(v).into_iter().collect();
        while let Some(&last) = fan.last() {
            match t.turn_left(last) {
                Some(h) if h == fan[0] => return (fan, true),
                Some(h) => fan.push(h),
                None => break,
            }
        }
        (fan, false)
    }

    #[test]
    fn sizes_of_fans_are_what_counting_their_faces_gives() {
        let mut meshes = shapes::all();
        meshes.extend(shapes::all_triangles());
        // Round the numbers from which on sizes are not kept, in faces and in points.
        meshes.extend([62, 63, 64, 127, 128].map(shapes::interior_vertex));
        meshes.extend([62, 63, 64, 127, 128].map(shapes::boundary_vertex));
        meshes.extend([254, 255, 256].map(shapes::interior_triangles));
        meshes.extend([254, 255, 256].map(shapes::cone));
        for shape in meshes {
            let t = Topology::new(&shape.mesh).unwrap();
            let (sizes, sum) = FanSize::all(&t);
            let mut counted = 0;
            for (v, size) in sizes.into_iter().enumerate() {
                let (v, what) = (Vertex::new(v), format!("{}, vertex {v}", shape.name));
                let (fan, closed) = fan(&t, v);
                let sides: Vec<usize> = fan.iter().map(|&h| t.face_vertices(t.face(h)).len()).collect();
                // All corners but the vertex; neighbours in the fan share the end of a spoke.
                let spokes_shared = if closed { fan.len() } else { fan.len().saturating_sub(1) };
                let mut points = sides.iter().map(|n| n - 1).sum::<usize>() - spokes_shared;
                // Counted where there is no face, too, which nobody asks.
                points += usize::from(fan.is_empty());
                let few = (fan.len() < 63).then_some(fan.len());
                assert_eq!(size.is_empty(), fan.is_empty(), "{what}");
                assert_eq!(size.faces(&t, v), fan.len(), "{what}");
                assert_eq!(size.few_faces(), few, "{what}");
                let is_closed_of_quads = closed && sides.iter().all(|&n| n == 4);
                assert_eq!(size.closed_quads(), few.filter(|_| is_closed_of_quads), "{what}");
                assert_eq!(FanSize::count_points(&t, v), points, "{what}");
                let is_kept = points - usize::from(!closed) < 255;
                assert_eq!(size.few_points(), is_kept.then_some(points), "{what}");
                counted += fan.len();
            }
            assert_eq!(sum, counted, "{}", shape.name);
        }
    }
}
