//! Which vertices lie in and round a square, and their values into lanes.

use crate::index::HalfEdge;
use crate::kernel::{self, LANES, PART, Parts, Sixteen, by_component, lattice_points, turn_back};
use crate::real::Real;
use crate::topology::{NONE, Topology};
use fearless_simd::{Simd, dispatch};

/// Points read of a control quad, of one at level 1, and of a corner.
pub(super) const CONTROL_QUAD: usize = lattice_points(1);
pub(super) const QUAD: usize = lattice_points(2);
pub(super) const CORNER: usize = lattice_points(1);

/// Which vertices lie in and round a square: a lattice of `SIZE`, row by row. What lies across a corner where there are not four
/// faces does not matter, nor what lies beyond a boundary.
pub(super) trait Surroundings<const POINTS: usize> {
    const SIZE: usize;

    /// Of the square with this half-edge.
    fn of(&self, t: &Topology, h: u32) -> [u32; POINTS];
}

/// Of a quad that touches quads alone, with its first half-edge: control vertices. `ALL` where all faces are quads.
pub(super) struct ControlQuad<const ALL: bool>;

/// Of any quad, with its first half-edge: vertices of level 1.
pub(super) struct Quad;

/// Of the corner at a half-edge of another face: vertices of level 1.
pub(super) struct Corner;

/// Reads the surroundings of squares into lanes; returns the size of the lattice.
pub(super) fn read<T: Real, const N: usize, const POINTS: usize, S: Surroundings<POINTS>>(
    t: &Topology,
    level: &[[T; N]],
    half_edges: &[u32],
    turned: &mut [[T; N]],
    out: &mut [Sixteen<T, N>],
    surroundings: &S,
) -> usize {
    let stride = POINTS.next_multiple_of(LANES);
    let is_part = N == PART || N + 1 == PART;
    dispatch!(kernel::level(), simd => simd.vectorize(
        #[inline(always)]
        || {
            // Numbers first, so that loads do not wait for each other.
            let mut ids = [[0; POINTS]; LANES];
            for (ids, &h) in ids.iter_mut().zip(half_edges) {
                *ids = surroundings.of(t, h);
            }
            if is_part {
                let parts = Parts::new(level, 0);
                for (k, out) in out[..POINTS].iter_mut().enumerate() {
                    let components = by_component::<T, _>(
                        simd,
                        #[inline(always)]
                        |lane| parts.at(ids[lane][k] as usize),
                    );
                    for c in 0..N {
                        T::store(simd, components[c], &mut out[c]);
                    }
                }
                return;
            }
            for (ids, row) in ids[..half_edges.len()].iter().zip(turned.chunks_exact_mut(stride)) {
                for (&id, out) in ids.iter().zip(row) {
                    *out = level[id as usize];
                }
            }
        },
    ));
    if !is_part {
        turn_back(turned[..LANES * stride].as_flattened(), out.as_flattened_mut());
    }
    S::SIZE
}

impl<const ALL: bool> Surroundings<CONTROL_QUAD> for ControlQuad<ALL> {
    const SIZE: usize = 1;

    #[inline(always)]
    fn of(&self, t: &Topology, first: u32) -> [u32; CONTROL_QUAD] {
        // Corner by corner, counter-clockwise: across the corner, then beyond the side from there on.
        const BEYOND: [[usize; 3]; 4] = [[0, 1, 2], [3, 7, 11], [15, 14, 13], [12, 8, 4]];
        const OWN: [usize; 4] = [5, 6, 10, 9];
        let at = |h: u32, by: u32| if ALL { h & !3 | (h + by) & 3 } else { in_quad(t, h, by) } as usize;
        let own: &[u32; 4] = t.origin[first as usize..].first_chunk().expect("four corners");
        let twins: &[u32; 4] = t.twin[first as usize..].first_chunk().expect("four sides");
        let mut out = [own[0]; CONTROL_QUAD];
        for k in 0..4 {
            out[OWN[k]] = own[k];
            // Beyond a boundary, of the quad itself.
            let twin = if twins[k] == NONE { first + k as u32 } else { twins[k] };
            let across = t.twin[at(twin, 1)];
            let across = if across == NONE { twin } else { across };
            out[BEYOND[k][0]] = t.origin[at(across, 3)];
            out[BEYOND[k][1]] = t.origin[at(twin, 2)];
            out[BEYOND[k][2]] = t.origin[at(twin, 3)];
        }
        out
    }
}

/// The half-edge so many behind `h`, a side of a quad.
#[inline(always)]
pub(in super::super) fn in_quad(t: &Topology, h: u32, by: u32) -> u32 {
    let first = t.face.first_of_few(h);
    first + ((h - first + by) & 3)
}

impl Surroundings<QUAD> for Quad {
    const SIZE: usize = 2;

    #[inline(always)]
    fn of(&self, t: &Topology, first: u32) -> [u32; QUAD] {
        // Corner by corner, counter-clockwise: across the corner, then beyond the side from there on.
        const BEYOND: [[usize; 4]; 4] = [[0, 1, 2, 3], [4, 9, 14, 19], [24, 23, 22, 21], [20, 15, 10, 5]];
        const OWN: [[usize; 2]; 4] = [[6, 7], [8, 13], [18, 17], [16, 11]];
        let centres = t.vertex_count() as u32;
        let middles = centres + t.face_count() as u32;
        let mut out = [0; QUAD];
        out[12] = centres + t.face.get(first);
        for k in 0..4 {
            let h = first as usize + k;
            (out[OWN[k][0]], out[OWN[k][1]]) = (t.origin[h], middles + t.edge[h]);
            let twin = t.twin[h];
            if twin == NONE {
                BEYOND[k].iter().for_each(|&at| out[at] = out[OWN[k][1]]);
                continue;
            }
            let [next, prev] = [t.next(HalfEdge(twin)), t.prev(HalfEdge(twin))].map(HalfEdge::index);
            let across = t.twin[next];
            let across = if across == NONE { twin } else { across };
            out[BEYOND[k][0]] = centres + t.face.get(across);
            out[BEYOND[k][1]] = middles + t.edge[next];
            out[BEYOND[k][2]] = centres + t.face.get(twin);
            out[BEYOND[k][3]] = middles + t.edge[prev];
        }
        out
    }
}

impl Surroundings<CORNER> for Corner {
    const SIZE: usize = 1;

    #[inline(always)]
    fn of(&self, t: &Topology, h: u32) -> [u32; CORNER] {
        let centres = t.vertex_count() as u32;
        let middles = centres + t.face_count() as u32;
        let middle = |h: HalfEdge| middles + t.edge(h).0;
        let centre = |h: HalfEdge| centres + t.face(h).0;
        let h = HalfEdge(h);
        let (next, prev) = (t.next(h), t.prev(h));
        let before = t.prev(prev);
        let own = t.origin(h).0;
        let mut out = [own; CORNER];
        [out[5], out[6], out[7]] = [own, middle(h), t.origin(next).0];
        [out[9], out[10], out[11]] = [middle(prev), centre(h), middle(next)];
        [out[13], out[14], out[15]] = [t.origin(prev).0, middle(before), centre(h)];
        if let Some(twin) = t.twin(h) {
            let across = t.twin(t.next(twin)).unwrap_or(twin);
            [out[0], out[1], out[2], out[3]] =
                [centre(across), middle(t.next(twin)), centre(twin), middle(t.prev(twin))];
        }
        if let Some(twin) = t.twin(prev) {
            [out[4], out[8], out[12]] = [middle(t.prev(twin)), centre(twin), middle(t.next(twin))];
        }
        out
    }
}
