//! From the points of sixteen squares to where they are numbered.

use super::super::super::parts::Task;
use super::super::Deeper;
use super::super::layout::{Layout, Run, Side};
use super::Batch;
use super::flags::{BACKWARD, OWNS_EDGE, OWNS_VERTEX};
use crate::index::HalfEdge;
use crate::kernel::{LANES, Sixteen};
use crate::real::Real;
use crate::topology::Topology;

/// Points of a square that belong to an element: where they start among those of all squares, and the element among those of the
/// task.
#[derive(Clone, Copy, Default)]
pub(super) struct Place {
    points: usize,
    element: usize,
}

/// Where results go.
pub(super) struct Output<'a, T, const N: usize> {
    pub parts: Vec<&'a mut [[T; N]]>,
    /// Of edges that are not numbered in the order of their owners, with all of an edge's together.
    edges: &'a mut [[T; N]],
    per_edge: usize,
    pub first_face: usize,
    first_half_edge: u32,
    /// Values of control vertices.
    pub corners: Vec<(u32, [T; N])>,
}

impl<'a, T: Real, const N: usize> Output<'a, T, N> {
    pub fn new(t: &Topology, task: Task<'a, T, N>, depth: u32) -> Self {
        let Task { faces, parts, edges, .. } = task;
        Self {
            parts,
            edges,
            per_edge: (1 << depth) - 1,
            first_face: faces.start,
            first_half_edge: t.face_offset[faces.start],
            corners: Vec::with_capacity(faces.len() + faces.len() / 8),
        }
    }

    /// What holds the points of a run of edges, from one edge to the next, and where they start.
    #[inline(always)]
    fn of_edges(&mut self, run: &Run) -> (&mut [[T; N]], usize, usize) {
        match self.edges.is_empty() {
            true => (&mut *self.parts[run.part], run.each, run.skip),
            // Regions of 1, 2, 4, … follow each other.
            false => (&mut *self.edges, self.per_edge, run.each - 1 + run.skip),
        }
    }
}

/// Writes what some squares own: `turned` has their points square by square in the order of the layout, `lattice` point by point.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
pub(super) fn write<T: Real, const N: usize, const QUADS: bool>(
    deeper: &Deeper,
    t: &Topology,
    layout: &Layout,
    batch: &Batch,
    count: usize,
    turned: &[[T; N]],
    lattice: &[Sixteen<T, N>],
    owned: &mut Vec<Place>,
    out: &mut Output<'_, T, N>,
) {
    let stride = layout.points.len();
    let mut squares = [[Place::default(); LANES]; 2];
    for lane in 0..count {
        let (points, h) = (lane * stride, batch.half_edges[lane]);
        squares[0][lane] = Place { points, element: t.face.get(h) as usize - out.first_face };
        squares[1][lane] = Place { points, element: (h - out.first_half_edge) as usize };
    }
    let mut first = 0;
    for run in &layout.inside {
        // The first part is that of centres of faces.
        let places = &squares[usize::from(run.part > 0)][..count];
        spread(places, first, run, (run.each, 0), turned, &mut *out.parts[run.part]);
        first += run.count;
    }
    owned.clear();
    let mut own = |out: &mut Output<'_, T, N>, lane: usize, side: usize, number: u32, is_backward: bool| {
        let (side, element) = (&layout.sides[side], number as usize);
        if is_backward {
            write_backward(side, element, lane, lattice, out);
        } else {
            owned.push(Place { points: lane * stride + side.start, element });
        }
    };
    if QUADS {
        let (edges, backward) = (batch.with(OWNS_EDGE, count), batch.with(BACKWARD, count));
        for (lane, k) in edges {
            own(out, lane, k, batch.edges[lane][0] + edges.before(lane, k), backward.has(lane, k));
        }
        for (lane, k) in batch.with(OWNS_VERTEX, count) {
            let v = t.origin[batch.half_edges[lane] as usize + k];
            out.corners.push((v, turned[lane * stride + layout.corners + k]));
        }
    } else {
        for (lane, &h) in batch.half_edges[..count].iter().enumerate() {
            let flags = deeper.flags[h as usize];
            if flags & OWNS_EDGE != 0 {
                own(out, lane, 0, batch.edges[lane][0], flags & BACKWARD != 0);
            }
            if flags & OWNS_VERTEX != 0 {
                out.corners.push((t.origin[h as usize], turned[lane * stride + layout.corners]));
            }
        }
    }
    // All sides of a quad have the same runs; of corners the other sides are the second ones.
    spread_edges(owned, &layout.sides[0].runs[0], turned, out);
    if !QUADS {
        owned.clear();
        for lane in 0..count {
            let h = t.prev(HalfEdge(batch.half_edges[lane])).0;
            let flags = deeper.flags[h as usize];
            let (side, edge) = (&layout.sides[1], batch.edges[lane][1] as usize);
            if flags & OWNS_EDGE == 0 {
                continue;
            }
            if flags & BACKWARD == 0 {
                owned.push(Place { points: lane * stride + side.start, element: edge });
            } else {
                write_backward(side, edge, lane, lattice, out);
            }
        }
        spread_edges(owned, &layout.sides[1].runs[0], turned, out);
    }
}

/// The points of an edge against which the square's half-edge runs.
fn write_backward<T: Real, const N: usize>(
    side: &Side,
    edge: usize,
    lane: usize,
    lattice: &[Sixteen<T, N>],
    out: &mut Output<'_, T, N>,
) {
    let mut rest = &side.backward[..];
    for run in &side.runs[1] {
        let (some, tail) = rest.split_at(run.count);
        rest = tail;
        let (to, each, skip) = out.of_edges(run);
        let values = some.iter().map(|&point| of_lane(&lattice[point as usize], lane));
        to[each * edge + skip..].iter_mut().zip(values).for_each(|(to, value)| *to = value);
    }
}

/// The points of edges, run by run.
#[inline(always)]
fn spread_edges<T: Real, const N: usize>(owned: &[Place], runs: &[Run], turned: &[[T; N]], out: &mut Output<'_, T, N>) {
    let mut first = 0;
    for run in runs {
        let (to, each, skip) = out.of_edges(run);
        spread(owned, first, run, (each, skip), turned, to);
        first += run.count;
    }
}

/// Copies the points of a run, which are `first` among those of each place, to where elements have room for `each`, `skip` of which come
/// before.
#[inline(always)]
fn spread<T: Real, const N: usize>(
    places: &[Place],
    first: usize,
    run: &Run,
    (each, skip): (usize, usize),
    from: &[[T; N]],
    to: &mut [[T; N]],
) {
    let (from, count) = (&from[first..], run.count);
    let to = if places.is_empty() { to } else { &mut to[skip..] };
    match count {
        1 => {
            for place in places {
                to[each * place.element] = from[place.points];
            }
        }
        2 => copy_all::<T, N, 2>(places, count, each, from, to),
        4 | 8 => copy_all::<T, N, 4>(places, count, each, from, to),
        _ => copy_all::<T, N, 16>(places, count, each, from, to),
    }
}

/// As `copy_from_slice` for each of some places, without a call: `count` is a multiple of `K`.
#[inline(always)]
fn copy_all<T: Real, const N: usize, const K: usize>(
    places: &[Place],
    count: usize,
    each: usize,
    from: &[[T; N]],
    to: &mut [[T; N]],
) {
    for place in places {
        let from = from[place.points..][..count].as_chunks::<K>().0;
        let to = to[each * place.element..][..count].as_chunks_mut::<K>().0;
        for (to, from) in to.iter_mut().zip(from) {
            *to = *from;
        }
    }
}

#[inline(always)]
fn of_lane<T: Real, const N: usize>(point: &Sixteen<T, N>, lane: usize) -> [T; N] {
    let mut out = [T::default(); N];
    for c in 0..N {
        out[c] = point[c][lane];
    }
    out
}
