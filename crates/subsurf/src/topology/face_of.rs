//! The face of a half-edge. Where all faces are quads, or all are triangles, it follows from the half-edge's number, and so
//! do the half-edges before and after: no table is stored or read.

/// The face of every half-edge, and its neighbours within the face.
#[derive(Clone, Debug)]
pub(crate) enum FaceOf {
    /// All faces have four corners.
    Quads,
    /// All faces have three corners.
    Triangles,
    /// Faces as they come.
    Listed(Listed),
}

/// One entry per half-edge.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Listed {
    face: Vec<u32>,
    /// How many half-edges of the face come before, and in the upper four bits how many behind; [`MANY`] for that and more. So
    /// neighbours within a face are a load of one byte away.
    place: Vec<u8>,
}

const MANY: u8 = 15;

impl Listed {
    /// As many half-edges as the last of `face_offset`.
    fn fill(&mut self, face_offset: &[u32]) {
        let half_edges = face_offset.last().map_or(0, |&n| n as usize);
        self.face.clear();
        self.place.clear();
        if self.face.capacity() == 0 {
            self.face = subsurf_memory::with_capacity(half_edges);
            self.place = subsurf_memory::with_capacity(half_edges);
        }
        face_offset.windows(2).zip(0u32..).for_each(|(w, f)| self.push((w[1] - w[0]) as usize, f));
    }

    fn push(&mut self, sides: usize, f: u32) {
        self.face.resize(self.face.len() + sides, f);
        match sides {
            3 => self.place.extend([0x20, 0x11, 0x02]),
            4 => self.place.extend([0x30, 0x21, 0x12, 0x03]),
            _ => {
                let few = |n: usize| n.min(usize::from(MANY)) as u8;
                self.place.extend((0..sides).map(|i| few(i) | few(sides - 1 - i) << 4));
            }
        }
    }

    /// Half-edges of the face before `h` and behind it, at most [`MANY`].
    #[inline]
    fn beside(&self, h: u32) -> (u8, u8) {
        let place = self.place[h as usize];
        (place & 15, place >> 4)
    }

    pub fn len(&self) -> usize {
        self.face.len()
    }
}

impl FaceOf {
    /// From the first half-edge of every face, and their number at the end.
    pub fn new(face_offset: &[u32]) -> Self {
        Self::with(face_offset, Listed::default())
    }

    fn with(face_offset: &[u32], mut listed: Listed) -> Self {
        let all = |sides: u32| face_offset.iter().zip(0u32..).all(|(&first, f)| first == sides.wrapping_mul(f));
        if all(4) {
            return Self::Quads;
        }
        if all(3) {
            return Self::Triangles;
        }
        listed.fill(face_offset);
        Self::Listed(listed)
    }

    /// The same with memory that is at hand.
    pub fn refill(&mut self, face_offset: &[u32]) {
        let listed = match std::mem::replace(self, Self::Quads) {
            Self::Listed(listed) => listed,
            _ => Listed::default(),
        };
        *self = Self::with(face_offset, listed);
    }

    /// Adds a face behind all others, whose first half-edges, and the number of half-edges, are `face_offset`.
    pub fn push(&mut self, sides: usize, face_offset: &[u32]) {
        let next = face_offset.len() as u32 - 1;
        match (&mut *self, sides) {
            (Self::Quads, 4) | (Self::Triangles, 3) => {}
            (Self::Listed(listed), _) => listed.push(sides, next),
            _ => {
                let mut listed = Listed::default();
                listed.fill(face_offset);
                listed.push(sides, next);
                *self = Self::Listed(listed);
            }
        }
    }

    /// All faces of a mesh with `sides` corners.
    pub fn uniform(sides: u32, half_edges: usize) -> Self {
        match sides {
            4 => Self::Quads,
            3 => Self::Triangles,
            _ => {
                let mut listed = Listed::default();
                (0..half_edges as u32 / sides).for_each(|f| listed.push(sides as usize, f));
                Self::Listed(listed)
            }
        }
    }

    /// The face of half-edge `h`.
    #[inline]
    pub fn get(&self, h: u32) -> u32 {
        match self {
            Self::Quads => h / 4,
            Self::Triangles => h / 3,
            Self::Listed(listed) => listed.face[h as usize],
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
            Self::Listed(listed) => match listed.beside(h) {
                (MANY, 0) => face_offset[self.get(h) as usize],
                // Written so that there is no branch to be guessed.
                (before, behind) => h + 1 - if behind == 0 { u32::from(before) + 1 } else { 0 },
            },
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
            Self::Listed(listed) => match listed.beside(h) {
                (0, MANY) => face_offset[self.get(h) as usize + 1] - 1,
                (before, behind) => h.wrapping_sub(1).wrapping_add(if before == 0 { u32::from(behind) + 1 } else { 0 }),
            },
        }
    }

    /// First half-edge of the face of `h`, which has less than 16 corners.
    #[inline]
    pub fn first_of_few(&self, h: u32) -> u32 {
        match self {
            Self::Quads => h & !3,
            Self::Triangles => h - h % 3,
            Self::Listed(listed) => h - u32::from(listed.beside(h).0),
        }
    }

    /// Number of corners of the face of `h`.
    #[inline]
    pub fn sides(&self, h: u32, face_offset: &[u32]) -> usize {
        match self {
            Self::Quads => 4,
            Self::Triangles => 3,
            Self::Listed(listed) => match listed.beside(h) {
                (MANY, _) | (_, MANY) => {
                    let f = self.get(h) as usize;
                    (face_offset[f + 1] - face_offset[f]) as usize
                }
                (before, behind) => usize::from(before + behind + 1),
            },
        }
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Quads | Self::Triangles => 0,
            Self::Listed(listed) => size_of::<u32>() * listed.face.capacity() + listed.place.capacity(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Listed, whatever the faces are.
    fn listed(face_offset: &[u32]) -> FaceOf {
        let mut listed = Listed::default();
        listed.fill(face_offset);
        FaceOf::Listed(listed)
    }

    #[test]
    fn uniform_faces_are_computed_as_listed_ones_are_read() {
        for sides in [3, 4] {
            let offset: Vec<u32> = (0..=5).map(|f| sides * f).collect();
            let computed = FaceOf::new(&offset);
            assert!(!matches!(computed, FaceOf::Listed(_)));
            let listed = listed(&offset);
            for h in 0..5 * sides {
                assert_eq!(computed.get(h), listed.get(h));
                assert_eq!(computed.next(h, &offset), listed.next(h, &offset));
                assert_eq!(computed.prev(h, &offset), listed.prev(h, &offset));
            }
            for f in 0..5 {
                assert_eq!(computed.first(f, &offset), listed.first(f, &offset));
            }
        }
        assert!(matches!(FaceOf::new(&[0, 4, 7]), FaceOf::Listed(_)));
    }

    #[test]
    fn neighbours_in_faces_of_any_size_follow_from_where_faces_start() {
        let mut offset = vec![0];
        let mut pushed = FaceOf::new(&[0]);
        for sides in [4, 3, 5, 15, 16, 17, 31, 32, 40, 3] {
            pushed.push(sides, &offset);
            offset.push(offset[offset.len() - 1] + sides as u32);
        }
        for faces in [FaceOf::new(&offset), pushed] {
            for (f, w) in offset.windows(2).enumerate() {
                for h in w[0]..w[1] {
                    assert_eq!(faces.get(h), f as u32);
                    assert_eq!(faces.next(h, &offset), if h + 1 == w[1] { w[0] } else { h + 1 });
                    assert_eq!(faces.prev(h, &offset), if h == w[0] { w[1] - 1 } else { h - 1 });
                    assert_eq!(faces.sides(h, &offset), (w[1] - w[0]) as usize);
                    assert!(w[1] - w[0] > 15 || faces.first_of_few(h) == w[0]);
                }
            }
        }
    }
}
