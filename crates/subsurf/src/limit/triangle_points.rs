//! The control points round a triangle under Loop subdivision, in canonical order.

use super::corner::{Kind, corner, ring_points};
use super::rows::Combination;
use crate::index::HalfEdge;
use crate::scheme::SplitKind;
use crate::tags::INFINITE_SHARPNESS;
use crate::topology::Tables;

/// Where the ring of corner `j`, counter-clockwise from the next corner, goes among the 12 points of
/// [`box_spline`](super::box_spline).
const RINGS: [[usize; 6]; 3] = [[6, 7, 4, 1, 0, 2], [7, 3, 2, 5, 9, 10], [3, 6, 10, 11, 8, 4]];
const CORNERS: [usize; 3] = [3, 6, 7];

/// The six neighbours of the regular corner at the start of `h`, counter-clockwise from the end of `h`. Those beyond an
/// infinitely sharp edge are extrapolated, which commutes with refinement exactly.
fn six_ring(t: &impl Tables, h: HalfEdge) -> [Combination; 6] {
    let (at, start) = corner(t, h, SplitKind::Triangles);
    let v = t.origin(h).0;
    let mut spokes = Vec::with_capacity(7);
    let mut spoke = start;
    for j in 0..at.n {
        spokes.push(t.origin(t.next(spoke)).0);
        if j + 1 < at.n {
            spoke = t.turn_left(spoke).expect("the sector goes on");
        } else if !at.kind.is_closed() {
            spokes.push(t.origin(t.prev(spoke)).0);
        }
    }
    let i = at.i as usize;
    let mut ring: [Combination; 6] = Default::default();
    for (x, &e) in spokes.iter().enumerate() {
        ring[(x + 6 - i) % 6] = Combination::point(e);
    }
    let e = |x: usize| spokes[x];
    match at.kind {
        Kind::Crease => {
            ring[(10 - i) % 6] = [(v, 1.0), (e(3), 1.0), (e(2), -1.0)].into_iter().collect();
            ring[(11 - i) % 6] = [(v, 1.0), (e(0), 1.0), (e(1), -1.0)].into_iter().collect();
        }
        Kind::Corner => {
            ring[2] = [(v, 1.0), (e(1), 1.0), (e(0), -1.0)].into_iter().collect();
            ring[3] = [(v, 2.0), (e(0), -1.0)].into_iter().collect();
            ring[4] = [(v, 2.0), (e(1), -1.0)].into_iter().collect();
            ring[5] = [(v, 1.0), (e(0), 1.0), (e(1), -1.0)].into_iter().collect();
        }
        _ => {}
    }
    ring
}

/// The 12 points round the triangle whose first corner is at the origin of `h`; all its corners are regular.
pub(crate) fn patch_points(t: &impl Tables, h: HalfEdge) -> [Combination; 12] {
    let mut points: [Combination; 12] = Default::default();
    let mut own = h;
    for (j, ring) in RINGS.iter().enumerate() {
        points[CORNERS[j]] = Combination::point(t.origin(own).0);
        for (&k, p) in ring.iter().zip(six_ring(t, own)) {
            points[k] = p;
        }
        own = t.next(own);
    }
    points
}

/// The points round the triangle at `h` whose corner 0, and no other, is special:
///
/// ```text
///                 g --- d                     ring first:  v e_0 e_1 .., sectors with e_n
///                / \   / \                    then (c) b m d (g): m across edge e_i e_{i+1}; b, d straight beyond
///         e_{i+2}--e_{i+1}--m                 e_i, e_{i+1}; c between e_{i-1} and b, g between d and e_{i+2}
///              \   / \ F / \                  without c where v-e_i is sharp, without g where v-e_{i+1} is sharp
///               \ /   \ /   \
///                v --- e_i -- b
///                 \   / \   /
///                e_{i-1} - c
/// ```
pub(crate) fn special_points(t: &impl Tables, h: HalfEdge) -> Vec<Combination> {
    let mut points = ring_points(t, h, SplitKind::Triangles);
    // Round e_i from e_{i+1}: e_{i+1} v e_{i-1} c b m; round e_{i+1} from v: v e_i m d g e_{i+2}.
    let (next, last) = (t.next(h), t.prev(h));
    let [_, _, _, c, b, m] = six_ring(t, next);
    let [_, _, _, d, g, _] = six_ring(t, last);
    let [sharp_u, sharp_v] = [h, last].map(|s| t.edge_sharpness(t.edge(s)) >= INFINITE_SHARPNESS);
    points.extend((!sharp_u).then_some(c));
    points.extend([b, m, d]);
    points.extend((!sharp_v).then_some(g));
    points
}
