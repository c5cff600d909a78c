//! The ring of a quad whose corners are all *smooth*: interior, manifold, among quads, with nothing sharp. It is read off the
//! half-edges in the order in which [`Topology::surroundings`] meets it, and depends on the valences of the corners alone.
//!
//! ```text
//!    15 ── 14 ── 13 ── 12          d: from 7 to 0, in the face at corner 0
//!     |     |     |     |          t: from 1 to 0, the twin of the face's first half-edge
//!     4 ─── 3 ─── 2 ── 11
//!     |     |face |     |          and likewise, turned, at the other corners
//!     5 ─── 0 ─── 1 ── 10
//!     |     |     |     |
//!     6 ─── 7 ─── 8 ─── 9
//! ```
//!
//! At a corner of valence n there are n - 2 outer vertices at the ends of edges and n - 3 across faces, so the ring has
//! 4 + (2 n₀ - 5) + … + (2 n₃ - 5) points. Where the mesh is so small that some of them are the same vertex, the ring is
//! another one, and takes a walk.

use crate::index::Face;
use crate::topology::{FaceOf, Topology};

/// Valences of a quad's corners, in order.
pub(super) type Valences = [u8; 4];

/// Least and largest valence that is read this way: below, faces at a corner are neighbours on both sides; above, there is no
/// end to the memory.
pub(super) const VALENCES: std::ops::RangeInclusive<u32> = 3..=12;

/// Most points of a ring.
pub(super) const MOST: usize = points([12; 4]);

/// Number of points of the ring.
#[inline]
pub(super) const fn points(valences: Valences) -> usize {
    let [a, b, c, d] = valences;
    2 * (a as usize + b as usize + c as usize + d as usize) - 16
}

/// Reads the ring of a quad into `out`, beginning at corner `start`; `valences` are those of the corners from there on.
#[inline]
pub(super) fn read(t: &Topology, face: Face, start: usize, valences: Valences, out: &mut [u32]) {
    match t.face {
        FaceOf::Quads => {
            let (next, prev) = (|h: u32| h & !3 | (h + 1) & 3, |h: u32| h & !3 | h.wrapping_sub(1) & 3);
            Reader { t, next, prev }.read(face, start, valences, out);
        }
        _ => {
            // All faces there are quads.
            let turn = |h: u32, by: u32| {
                let first = t.face.first_of_few(h);
                first + ((h - first + by) & 3)
            };
            let (next, prev) = (|h| turn(h, 1), |h| turn(h, 3));
            Reader { t, next, prev }.read(face, start, valences, out);
        }
    }
}

struct Reader<'a, N, P> {
    t: &'a Topology,
    next: N,
    prev: P,
}

impl<N: Fn(u32) -> u32, P: Fn(u32) -> u32> Reader<'_, N, P> {
    #[inline]
    fn twin(&self, h: u32) -> u32 {
        self.t.twin[h as usize]
    }

    #[inline]
    fn origin(&self, h: u32) -> u32 {
        self.t.origin[h as usize]
    }

    #[inline]
    fn read(&self, face: Face, start: usize, valences: Valences, out: &mut [u32]) {
        match <&mut [u32; 16]>::try_from(&mut *out) {
            Ok(out) if valences == [4; 4] => self.regular(face, out),
            _ => self.any(face, start, valences, out),
        }
    }

    #[inline]
    fn regular(&self, face: Face, ring: &mut [u32; 16]) {
        let first = self.t.first(face);
        let across: [u32; 4] = std::array::from_fn(|c| self.twin(first + c as u32));
        ring[..4].copy_from_slice(self.t.face_vertices(face));
        let before = (self.prev)(across[3]);
        (ring[4], ring[5]) = (self.origin((self.prev)(before)), self.origin(before));
        for (c, &t) in across.iter().enumerate() {
            let d = self.twin((self.next)(t));
            ring[6 + 3 * c] = self.origin((self.prev)(d));
            // The last corner's neighbours were met at the others.
            if c < 3 {
                ring[7 + 3 * c] = self.origin(d);
                ring[8 + 3 * c] = self.origin((self.prev)(t));
            }
        }
    }

    fn any(&self, face: Face, start: usize, valences: Valences, out: &mut [u32]) {
        let corners: [u32; 4] = std::array::from_fn(|c| self.t.half_edge(face, (start + c) % 4).0);
        let mut at = 0;
        let mut push = |v| {
            out[at] = v;
            at += 1;
        };
        corners.iter().for_each(|&h| push(self.origin(h)));
        for (c, (&own, &valence)) in corners.iter().zip(&valences).enumerate() {
            let mut h = own;
            for k in 1..valence {
                h = self.twin((self.prev)(h));
                // Faces across the sides of the quad are met at two corners.
                let last = k + 1 == valence;
                if (c > 0 && k == 1) || (c == 3 && last) {
                    continue;
                }
                // At the last corner the first face comes round again, and what was met with it.
                if !(c == 2 && last && valences[3] == 3) {
                    push(self.origin((self.next)((self.next)(h))));
                }
                if !(last || (c == 3 && k + 2 == valence)) {
                    push(self.origin((self.prev)(h)));
                }
            }
        }
        debug_assert_eq!(at, out.len());
    }
}

/// True where no vertex is named twice: compares every vertex with those on the following half of the way round.
pub(super) fn is_distinct(ring: &[u32]) -> bool {
    let (n, half) = (ring.len(), ring.len() / 2);
    let mut round = [0; MOST + MOST / 2];
    round[..n].copy_from_slice(ring);
    round[n..n + half].copy_from_slice(&ring[..half]);
    let mut same = 0;
    for shift in 1..=half {
        same |= ring.iter().zip(&round[shift..]).fold(0, |same, (a, b)| same | u32::from(a == b));
    }
    same == 0
}

#[cfg(test)]
mod tests {
    use super::super::fans::smooth_valence;
    use super::*;
    use crate::index::Vertex;
    use crate::mesh::ControlMesh;
    use crate::shapes;
    use crate::tags::Tags;
    use crate::topology::{FanSize, Surroundings, Walk};

    #[test]
    fn the_ring_of_a_regular_quad_is_drawn_as_it_lies() {
        let drawing = [15, 14, 13, 12, 4, 3, 2, 11, 5, 0, 1, 10, 6, 7, 8, 9];
        let grid = shapes::grid(3, 3);
        let t = Topology::new(&grid.mesh).unwrap();
        let is_smooth = |&v: &u32| smooth_valence(&t, Vertex(v), FanSize::of(&t, Vertex(v))).is_some();
        let middle = (0..9).map(Face).find(|&f| t.face_vertices(f).iter().all(is_smooth)).unwrap();
        let mut ring = [0; 16];
        read(&t, middle, 0, [4; 4], &mut ring);
        // Along the rows of the drawing neighbours are a unit apart.
        let at = |k: usize| grid.positions[ring[drawing[k]] as usize];
        let step = |a: [f64; 3], b: [f64; 3]| [0, 1].map(|i| b[i] - a[i]);
        for k in (0..16).filter(|k| k % 4 < 3) {
            assert_eq!(step(at(k), at(k + 1)), step(at(0), at(1)), "{k}");
        }
    }

    /// A quad with these valences, among quads: the first of a mesh that is a disc.
    fn quad_with(valences: Valences) -> ControlMesh {
        // The faces at corner c lie between spokes: those along the sides, and others out from the corner.
        let mut faces: Vec<[u32; 4]> = vec![[0, 1, 2, 3]];
        let mut next = 4;
        let spokes: Vec<Vec<u32>> = valences
            .iter()
            .map(|&n| {
                let own: Vec<u32> = (next..).take(usize::from(n) - 2).collect();
                next += u32::from(n) - 2;
                own
            })
            .collect();
        for c in 0..4 {
            // Spokes go round the corner from the face across the side before it to the one across the side after it.
            let (own, after) = (&spokes[c], &spokes[(c + 1) % 4]);
            faces.push([(c as u32 + 1) % 4, c as u32, own[own.len() - 1], after[0]]);
            for pair in own.windows(2) {
                faces.push([c as u32, pair[0], next, pair[1]]);
                next += 1;
            }
        }
        ControlMesh::new(&faces, Tags::default()).unwrap()
    }

    #[test]
    fn a_ring_is_the_walk_round_the_corners_for_all_valences_and_turns() {
        for code in 0..256u32 {
            let valences: Valences = std::array::from_fn(|c| [3, 4, 5, 8][(code >> (2 * c) & 3) as usize]);
            let t = Topology::new(&quad_with(valences)).unwrap();
            let found = [0, 1, 2, 3].map(|v| smooth_valence(&t, Vertex(v), FanSize::of(&t, Vertex(v))).unwrap());
            assert_eq!(found, valences);
            for start in 0..4 {
                let turned: Valences = std::array::from_fn(|c| valences[(start + c) % 4]);
                let mut ring = vec![0; points(turned)];
                if turned == [4; 4] && start > 0 {
                    continue;
                }
                read(&t, Face(0), start, turned, &mut ring);
                assert!(is_distinct(&ring));
                let mut around = Surroundings::default();
                t.surroundings(Face(0), start, &mut Walk::default(), &mut around);
                assert_eq!(around.ring, ring, "{valences:?} from {start}");
            }
        }
    }

    #[test]
    fn a_vertex_named_twice_is_found_wherever_it_stands() {
        for n in [points([3, 3, 3, 3]), 14, 16, 18, MOST] {
            let ring: Vec<u32> = (0..n as u32).map(|i| 3 * i).collect();
            assert!(is_distinct(&ring));
            for (i, j) in (0..n).flat_map(|i| (0..i).map(move |j| (i, j))) {
                let mut twice = ring.clone();
                twice[i] = twice[j];
                assert!(!is_distinct(&twice), "{i} {j} of {n}");
            }
        }
    }
}
