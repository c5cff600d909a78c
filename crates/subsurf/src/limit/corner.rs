//! What a corner of a face is: regular, or one of the special kinds that have a closed form of their own; and the
//! control points that the patches round it need, in canonical order.

use super::rows::{Combination, extrapolate};
use crate::index::{Edge, HalfEdge};
use crate::scheme::SplitKind;
use crate::tags::INFINITE_SHARPNESS;
use crate::topology::{Tables, Topology};

/// How a vertex behaves for ever, once finite sharpness has decayed.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) enum Kind {
    /// Interior, nothing sharp; `n` is its valence.
    Smooth,
    /// Interior, one sharp edge `e_0`; `n` is its valence.
    Dart,
    /// On a crease or boundary; `n` is the number of faces of the sector.
    Crease,
    /// Stays where it is; `n` is the number of faces of the sector between two sharp edges.
    Corner,
    /// Stays where it is, and no edge is sharp; `n` is its valence.
    Pinned,
}

impl Kind {
    /// True where the faces go all the way round.
    pub fn is_closed(self) -> bool {
        matches!(self, Kind::Smooth | Kind::Dart | Kind::Pinned)
    }
}

/// A face's corner: kind of vertex, its size `n`, and the number `i` of the face counted from `e_0`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) struct Corner {
    pub split: SplitKind,
    pub kind: Kind,
    pub n: u32,
    pub i: u32,
}

impl Corner {
    /// True where a spline patch, extrapolated across sharp sides, covers the corner.
    pub fn is_regular(self) -> bool {
        let regular = match self.split {
            SplitKind::Quads => [4, 2, 1],
            SplitKind::Triangles => [6, 3, 1],
        };
        match self.kind {
            Kind::Smooth => self.n == regular[0],
            Kind::Crease => self.n == regular[1],
            Kind::Corner => self.n == regular[2],
            Kind::Dart | Kind::Pinned => false,
        }
    }
}

pub(crate) fn is_finite_sharpness(s: f64) -> bool {
    s > 0.0 && s < INFINITE_SHARPNESS
}

/// True where sharpness at the origin of `h` will change.
pub(crate) fn has_finite_sharpness(t: &Topology, h: HalfEdge) -> bool {
    let v = t.origin(h);
    is_finite_sharpness(t.vertex_sharpness(v))
        || t.foreign_sharpness(v).iter().any(|&s| is_finite_sharpness(s))
        || t.sharp_edges(v).iter().any(|&e| is_finite_sharpness(t.edge_sharpness(Edge(e))))
}

/// The corner at the origin of `h`, together with the half-edge along `e_0`. Finite sharpness counts as infinite.
pub(crate) fn corner(t: &impl Tables, h: HalfEdge, split: SplitKind) -> (Corner, HalfEdge) {
    let v = t.origin(h);
    let sharp = |e: Edge| t.edge_sharpness(e) > 0.0;
    let sharp_count = t.sharp_edges(v).count() + t.foreign_sharpness(v).len();
    let pinned = t.vertex_sharpness(v) >= INFINITE_SHARPNESS || sharp_count > 2 || t.is_on_linear_boundary(v);
    // Clockwise to the sector's first spoke, or once round.
    let (mut start, mut i) = (h, 0);
    while !sharp(t.edge(start)) {
        let back = t.turn_right(start).expect("an edge without twin is sharp");
        if back == h {
            let n = i + 1;
            let kind = if pinned { Kind::Pinned } else { Kind::Smooth };
            return (Corner { split, kind, n, i: 0 }, h);
        }
        (start, i) = (back, i + 1);
    }
    let mut n = 1;
    let mut at = start;
    while !sharp(t.edge(t.prev(at))) {
        at = t.turn_left(at).expect("an edge without twin is sharp");
        n += 1;
    }
    let kind = match (pinned, sharp_count) {
        (true, _) => Kind::Corner,
        (false, 1) => Kind::Dart,
        _ => Kind::Crease,
    };
    (Corner { split, kind, n, i }, start)
}

/// A vertex itself.
fn at(t: &impl Tables, h: HalfEdge) -> Combination {
    Combination::point(t.origin(h).0)
}

/// The 4×4 points round the quad whose first corner is at the origin of `h`, in the order of
/// [`bspline`](super::bspline). Infinitely sharp sides are extrapolated, which commutes with refinement exactly.
/// With `special`, corner 0 may be anything, and the point diagonal to it is left out.
pub(crate) fn grid_points(t: &impl Tables, h: HalfEdge, special: bool) -> [Option<Combination>; 16] {
    const INNER: [usize; 4] = [5, 6, 10, 9];
    const OUTER: [[usize; 2]; 4] = [[1, 2], [7, 11], [14, 13], [8, 4]];
    const DIAGONAL: [usize; 4] = [0, 3, 15, 12];
    let side = {
        let (h1, h3) = (t.next(h), t.prev(h));
        [h, h1, t.next(h1), h3]
    };
    let across = side.map(|s| t.twin(s).filter(|_| t.edge_sharpness(t.edge(s)) < INFINITE_SHARPNESS));
    let mut grid: [Option<Combination>; 16] = Default::default();
    for j in 0..4 {
        grid[INNER[j]] = Some(at(t, side[j]));
    }
    let point = |grid: &[Option<Combination>; 16], k: usize| grid[k].clone().expect("filled before it is used");
    for j in 0..4 {
        let pair = match across[j] {
            // The twin runs from corner j + 1 to corner j.
            Some(g) => [at(t, t.next(t.next(g))), at(t, t.prev(g))],
            None => {
                let inner = |k: usize| point(&grid, INNER[k % 4]);
                [extrapolate(&inner(j), &inner(j + 3)), extrapolate(&inner(j + 1), &inner(j + 2))]
            }
        };
        let [a, b] = pair;
        (grid[OUTER[j][0]], grid[OUTER[j][1]]) = (Some(a), Some(b));
    }
    for j in usize::from(special)..4 {
        let before = (j + 3) % 4;
        let diagonal = match (across[before], across[j]) {
            (Some(_), Some(_)) => t
                .turn_left(side[j])
                .and_then(|g| t.turn_left(g))
                .map(|g| at(t, t.next(t.next(g))))
                .expect("a smooth corner has a face opposite"),
            (None, Some(_)) => extrapolate(&point(&grid, OUTER[j][0]), &point(&grid, OUTER[j][1])),
            _ => extrapolate(&point(&grid, OUTER[before][1]), &point(&grid, OUTER[before][0])),
        };
        grid[DIAGONAL[j]] = Some(diagonal);
    }
    grid
}

/// The vertex at the start of `h` and its neighbours, counter-clockwise from `e_0`: in quads the far ends of spokes and the
/// corners opposite in turn, in triangles the far ends alone.
pub(crate) fn ring_points(t: &impl Tables, h: HalfEdge, split: SplitKind) -> Vec<Combination> {
    let (corner, start) = corner(t, h, split);
    let mut points = vec![at(t, h)];
    let mut spoke = start;
    for j in 0..corner.n {
        points.push(at(t, t.next(spoke)));
        if split == SplitKind::Quads {
            points.push(at(t, t.next(t.next(spoke))));
        }
        if j + 1 < corner.n {
            spoke = t.turn_left(spoke).expect("the sector goes on");
        } else if !corner.kind.is_closed() {
            points.push(at(t, t.prev(spoke)));
        }
    }
    points
}

/// The points round the quad at `h` whose corner 0, and no other, is special:
///
/// ```text
///      v=2   (-1,2)---(0,2)----(1,2)---(2,2)       ring first:  v e_0 f_0 e_1 f_1 ..
///               |       |        |       |           closed kinds end with f_{n-1}, sectors with e_n
///      v=1   f_{i+1}--e_{i+1}---f_i----(2,1)       then (2,-1) (2,0) (2,1) (2,2) (1,2) (0,2) (-1,2)
///               |       | FACE i |       |           without (2,-1) where v-e_i is sharp,
///      v=0   e_{i+2}----v-------e_i----(2,0)         without (-1,2) where v-e_{i+1} is sharp
///                       |        |       |
///      v=-1          e_{i-1}--f_{i-1}--(2,-1)
/// ```
pub(crate) fn special_points(t: &impl Tables, h: HalfEdge) -> Vec<Combination> {
    let mut points = ring_points(t, h, SplitKind::Quads);
    let mut grid = grid_points(t, h, true);
    let [sharp_u, sharp_v] = [h, t.prev(h)].map(|s| t.edge_sharpness(t.edge(s)) >= INFINITE_SHARPNESS);
    let outer = [(3, !sharp_u), (7, true), (11, true), (15, true), (14, true), (13, true), (12, !sharp_v)];
    points.extend(outer.iter().filter(|o| o.1).map(|o| grid[o.0].take().expect("every outer point exists")));
    points
}
