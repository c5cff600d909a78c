//! The ring of a quad whose corners are all plain (interior, of four quads, nothing sharp), read off the half-edges in the
//! order in which [`Topology::surroundings`] meets it.
//!
//! ```text
//!    15 ── 14 ── 13 ── 12          d: from 7 to 0, in the face at corner 0
//!     |     |     |     |          t: from 1 to 0, the twin of the face's first half-edge
//!     4 ─── 3 ─── 2 ── 11          r: from 0 to 7, after t; the twin of d
//!     |     |face |     |
//!     5 ─── 0 ─── 1 ── 10          and likewise, turned, at the other corners
//!     |     |     |     |
//!     6 ─── 7 ─── 8 ─── 9
//! ```

use crate::index::{Face, HalfEdge};
use crate::topology::{FaceOf, Topology};

/// The ring of a quad with four plain corners. Where the mesh is so small that faces round it are the same, it repeats
/// vertices, and a walk finds another one.
#[inline]
pub(super) fn regular_ring(t: &Topology, face: Face) -> [u32; 16] {
    match t.face {
        FaceOf::Quads => read(t, face, |h| h & !3 | (h + 1) & 3, |h| h & !3 | h.wrapping_sub(1) & 3),
        _ => read(t, face, |h| t.next(HalfEdge(h)).0, |h| t.prev(HalfEdge(h)).0),
    }
}

#[inline]
fn read(t: &Topology, face: Face, next: impl Fn(u32) -> u32, prev: impl Fn(u32) -> u32) -> [u32; 16] {
    let (twin, origin) = (|h: u32| t.twin[h as usize], |h: u32| t.origin[h as usize]);
    let first = t.first(face);
    let across: [u32; 4] = std::array::from_fn(|c| twin(first + c as u32));
    let mut ring = [0; 16];
    ring[..4].copy_from_slice(t.face_vertices(face));
    let before = prev(across[3]);
    (ring[4], ring[5]) = (origin(prev(before)), origin(before));
    for (c, &t) in across.iter().enumerate() {
        let d = twin(next(t));
        ring[6 + 3 * c] = origin(prev(d));
        // The last corner's neighbours were met at the others.
        if c < 3 {
            ring[7 + 3 * c] = origin(d);
            ring[8 + 3 * c] = origin(prev(t));
        }
    }
    ring
}

/// True where no vertex is named twice.
#[inline]
pub(super) fn is_distinct(ring: &[u32; 16]) -> bool {
    // Every vertex against those up to eight places on, round the end.
    let mut twice = [0; 24];
    twice[..16].copy_from_slice(ring);
    twice[16..].copy_from_slice(&ring[..8]);
    let mut same = [0u32; 16];
    for shift in 1..=8 {
        for i in 0..16 {
            same[i] |= u32::from(ring[i] == twice[i + shift]);
        }
    }
    same.iter().fold(0, |all, s| all | s) == 0
}

#[cfg(test)]
mod tests {
    use super::super::gather::Fan;
    use super::*;
    use crate::index::Vertex;
    use crate::shapes;
    use crate::topology::{Surroundings, Walk};

    #[test]
    fn the_ring_of_a_regular_quad_is_the_walk_round_its_corners() {
        let drawing = [15, 14, 13, 12, 4, 3, 2, 11, 5, 0, 1, 10, 6, 7, 8, 9];
        let grid = shapes::grid(3, 3);
        let t = Topology::new(&grid.mesh).unwrap();
        let is_plain = |&v: &u32| Fan::of(&t, Vertex(v)).is_plain();
        let middle = (0..9).map(Face).find(|&f| t.face_vertices(f).iter().all(is_plain)).unwrap();
        let ring = regular_ring(&t, middle);
        let mut around = Surroundings::default();
        t.surroundings(middle, 0, &mut Walk::default(), &mut around);
        assert_eq!(around.ring, ring);
        // Along the rows of the drawing neighbours are a unit apart.
        let at = |k: usize| grid.positions[ring[drawing[k]] as usize];
        let step = |a: [f64; 3], b: [f64; 3]| [0, 1].map(|i| b[i] - a[i]);
        for k in (0..16).filter(|k| k % 4 < 3) {
            assert_eq!(step(at(k), at(k + 1)), step(at(0), at(1)), "{k}");
        }
    }

    #[test]
    fn a_vertex_named_twice_is_found_wherever_it_stands() {
        let ring: [u32; 16] = std::array::from_fn(|i| 3 * i as u32);
        assert!(is_distinct(&ring));
        for (i, j) in (0..16).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let mut twice = ring;
            twice[i] = twice[j];
            assert!(!is_distinct(&twice), "{i} {j}");
        }
    }
}
