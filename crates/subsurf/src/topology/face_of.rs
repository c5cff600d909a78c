//! The face of a half-edge. Where all faces are quads, or all are triangles, it follows from the half-edge's number, and so
//! do the half-edges before and after: no table is stored or read.

/// The face of every half-edge, and its neighbours within the face.
#[derive(Clone, Debug)]
pub(crate) enum FaceOf {
    /// All faces have four corners.
    Quads,
    /// All faces have three corners.
    Triangles,
    /// Faces as they come: one entry per half-edge.
    Listed(Vec<u32>),
}

impl FaceOf {
    /// From the first half-edge of every face, and their number at the end.
    pub fn new(face_offset: &[u32]) -> Self {
        Self::with(face_offset, Vec::new())
    }

    fn with(face_offset: &[u32], mut face: Vec<u32>) -> Self {
        let all = |sides: u32| face_offset.iter().zip(0u32..).all(|(&first, f)| first == sides.wrapping_mul(f));
        if all(4) {
            return Self::Quads;
        }
        if all(3) {
            return Self::Triangles;
        }
        let half_edges = face_offset.last().map_or(0, |&n| n as usize);
        if face.capacity() == 0 {
            face = subsurf_memory::with_capacity(half_edges);
        }
        face.resize(half_edges, 0);
        for (w, f) in face_offset.windows(2).zip(0u32..) {
            face[w[0] as usize..w[1] as usize].fill(f);
        }
        Self::Listed(face)
    }

    /// The same with memory that is at hand.
    pub fn refill(&mut self, face_offset: &[u32]) {
        let listed = match std::mem::replace(self, Self::Quads) {
            Self::Listed(mut face) => {
                face.clear();
                face
            }
            _ => Vec::new(),
        };
        *self = Self::with(face_offset, listed);
    }

    /// Adds a face behind all others, whose first half-edges, and the number of half-edges, are `face_offset`.
    pub fn push(&mut self, sides: usize, face_offset: &[u32]) {
        match (&mut *self, sides) {
            (Self::Quads, 4) | (Self::Triangles, 3) => {}
            (Self::Listed(face), _) => face.resize(face.len() + sides, face_offset.len() as u32 - 1),
            _ => {
                let faces = face_offset.windows(2).zip(0u32..);
                let mut listed: Vec<u32> =
                    faces.flat_map(|(w, f)| std::iter::repeat_n(f, (w[1] - w[0]) as usize)).collect();
                listed.resize(listed.len() + sides, face_offset.len() as u32 - 1);
                *self = Self::Listed(listed);
            }
        }
    }

    /// All faces of a mesh with `sides` corners.
    pub fn uniform(sides: u32, half_edges: usize) -> Self {
        match sides {
            4 => Self::Quads,
            3 => Self::Triangles,
            _ => Self::Listed((0..half_edges as u32).map(|h| h / sides).collect()),
        }
    }

    /// The face of half-edge `h`.
    #[inline]
    pub fn get(&self, h: u32) -> u32 {
        match self {
            Self::Quads => h / 4,
            Self::Triangles => h / 3,
            Self::Listed(face) => face[h as usize],
        }
    }

    /// First half-edge of face `f`.
    #[inline]
    pub fn first(&self, f: u32, face_offset: &[u32]) -> u32 {
        match self {
            Self::Quads => 4 * f,
            Self::Triangles => 3 * f,
            Self::Listed(_) => face_offset[f as usize],
        }
    }

    /// The half-edge after `h` in its face.
    #[inline]
    pub fn next(&self, h: u32, face_offset: &[u32]) -> u32 {
        match self {
            Self::Quads => h & !3 | (h + 1) & 3,
            Self::Triangles => h + 1 - if h % 3 == 2 { 3 } else { 0 },
            Self::Listed(face) => {
                let f = face[h as usize] as usize;
                if h + 1 == face_offset[f + 1] { face_offset[f] } else { h + 1 }
            }
        }
    }

    /// The half-edge before `h` in its face.
    #[inline]
    pub fn prev(&self, h: u32, face_offset: &[u32]) -> u32 {
        match self {
            Self::Quads => h & !3 | h.wrapping_sub(1) & 3,
            Self::Triangles => {
                if h.is_multiple_of(3) {
                    h + 2
                } else {
                    h - 1
                }
            }
            Self::Listed(face) => {
                let f = face[h as usize] as usize;
                if h == face_offset[f] { face_offset[f + 1] - 1 } else { h - 1 }
            }
        }
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Quads | Self::Triangles => 0,
            Self::Listed(face) => size_of::<u32>() * face.capacity(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_faces_are_computed_as_listed_ones_are_read() {
        for sides in [3, 4] {
            let offset: Vec<u32> = (0..=5).map(|f| sides * f).collect();
            let computed = FaceOf::new(&offset);
            assert!(!matches!(computed, FaceOf::Listed(_)));
            let listed = FaceOf::Listed((0..5 * sides).map(|h| h / sides).collect());
            for h in 0..5 * sides {
                assert_eq!(computed.get(h), listed.get(h));
                assert_eq!(computed.next(h, &offset), listed.next(h, &offset));
                assert_eq!(computed.prev(h, &offset), listed.prev(h, &offset));
            }
            for f in 0..5 {
                assert_eq!(computed.first(f, &offset), listed.first(f, &offset));
            }
        }
        assert!(matches!(FaceOf::new(&[0, 4, 7]), FaceOf::Listed(face) if face == [0, 0, 0, 0, 1, 1, 1]));
    }
}
