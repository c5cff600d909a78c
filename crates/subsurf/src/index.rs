//! Index newtypes: a face is never mistaken for a vertex.

macro_rules! index {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
        #[repr(transparent)]
        pub struct $name(pub u32);

        impl $name {
            /// The index as a `usize`, for slices.
            #[inline]
            pub fn index(self) -> usize {
                self.0 as usize
            }

            /// The `i`-th element.
            ///
            /// # Panics
            /// If `i` does not fit into 32 bits.
            #[inline]
            pub fn new(i: usize) -> Self {
                Self(u32::try_from(i).expect("index fits into 32 bits"))
            }
        }

        impl From<u32> for $name {
            fn from(i: u32) -> Self {
                Self(i)
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                self.0.fmt(f)
            }
        }
    };
}

index!(
    /// A vertex of a control mesh or of one refinement level.
    Vertex
);
index!(
    /// An undirected edge.
    Edge
);
index!(
    /// A face.
    Face
);
index!(
    /// One side of an edge: half-edge `offset(f) + i` of face `f` runs from the face's corner `i` to
    /// corner `i + 1`. Half-edges are therefore also the face's corners.
    HalfEdge
);
