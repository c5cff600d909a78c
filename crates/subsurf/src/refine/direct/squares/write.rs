//! From the points of sixteen squares to where they are numbered.

use super::super::super::parts::Task;
use super::super::Deeper;
use super::super::layout::{Layout, Run};
use super::Batch;
use super::flags::{BACKWARD, OWNS_EDGE, OWNS_VERTEX};
use crate::index::HalfEdge;
use crate::kernel::LANES;
use crate::real::Real;
use crate::topology::Topology;

/// Points of a square that belong to an element: where they start among those of all squares, and the element among those of the
/// task.
#[derive(Clone, Copy, Default)]
pub(super) struct Place {
    points: usize,
    element: usize,
    /// Of an edge: its half-edge runs against it.
    is_backward: bool,
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

    /// What holds the points of a run of edges, from one edge to the next, and where they start for each direction.
    #[inline(always)]
    fn of_edges(&mut self, run: &Run) -> (&mut [[T; N]], usize, [usize; 2]) {
        match self.edges.is_empty() {
            true => (&mut *self.parts[run.part], run.each, run.skip),
            // Regions of 1, 2, 4, … follow each other.
            false => (&mut *self.edges, self.per_edge, run.skip.map(|skip| run.each - 1 + skip)),
        }
    }
}

/// Writes what some squares own: `turned` has their points square by square in the order of the layout.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
pub(super) fn write<T: Real, const N: usize, const QUADS: bool>(
    deeper: &Deeper,
    t: &Topology,
    layout: &Layout,
    batch: &Batch,
    count: usize,
    turned: &[[T; N]],
    owned: &mut Vec<Place>,
    out: &mut Output<'_, T, N>,
) {
    let stride = layout.stride;
    let (first, last) = (batch.half_edges[0], batch.half_edges[count - 1]);
    let is_run = QUADS && last - first == 4 * (count as u32 - 1);
    if is_run {
        // Of faces that follow each other, so do the points.
        let elements = [t.face.get(first) as usize - out.first_face, (first - out.first_half_edge) as usize];
        let mut at = 0;
        for run in &layout.inside {
            let to = &mut out.parts[run.part][run.each * elements[usize::from(run.part > 0)]..][..run.count * count];
            append(turned.chunks_exact(stride), at, run.count, to);
            at += run.count;
        }
    } else {
        let mut squares = [[Place::default(); LANES]; 2];
        for lane in 0..count {
            let (points, h) = (lane * stride, batch.half_edges[lane]);
            let place = |element: usize| Place { points, element, is_backward: false };
            squares[0][lane] = place(t.face.get(h) as usize - out.first_face);
            squares[1][lane] = place((h - out.first_half_edge) as usize);
        }
        let mut at = 0;
        for run in &layout.inside {
            // The first part is that of centres of faces.
            let places = &squares[usize::from(run.part > 0)][..count];
            spread(places, run.count, run.each, run.skip, &turned[at..], &mut *out.parts[run.part]);
            at += run.count;
        }
    }
    owned.clear();
    if QUADS {
        let (edges, backward) = (batch.with(OWNS_EDGE, count), batch.with(BACKWARD, count));
        // All sides have the same runs.
        for (next, (lane, k)) in (batch.edges[0][0]..).zip(edges) {
            let element = if is_run { next } else { batch.edges[lane][0] + edges.before(lane, k) } as usize;
            let points = lane * stride + layout.sides[k].start;
            owned.push(Place { points, element, is_backward: backward.has(lane, k) });
        }
        if is_run && out.edges.is_empty() {
            append_edges(owned, &layout.sides[0].runs, turned, &mut out.parts);
        } else {
            spread_edges(owned, &layout.sides[0].runs, turned, out);
        }
        for (lane, k) in batch.with(OWNS_VERTEX, count) {
            let v = t.origin[batch.half_edges[lane] as usize + k];
            out.corners.push((v, turned[lane * stride + layout.corners + k]));
        }
        return;
    }
    for (side, of) in layout.sides.iter().enumerate() {
        owned.clear();
        for (lane, &h) in batch.half_edges[..count].iter().enumerate() {
            let h = if side == 0 { h } else { t.prev(HalfEdge(h)).0 };
            let flags = deeper.flags[h as usize];
            if flags & OWNS_EDGE != 0 {
                let (points, element) = (lane * stride + of.start, batch.edges[lane][side] as usize);
                owned.push(Place { points, element, is_backward: flags & BACKWARD != 0 });
            }
            if side == 0 && flags & OWNS_VERTEX != 0 {
                out.corners.push((t.origin[h as usize], turned[lane * stride + layout.corners]));
            }
        }
        spread_edges(owned, &of.runs, turned, out);
    }
}

/// From each of some squares so many points, of which those before `at` are left out, one after the other.
#[inline(always)]
fn append<'a, T: Real, const N: usize>(
    squares: impl Iterator<Item = &'a [[T; N]]>,
    at: usize,
    count: usize,
    to: &mut [[T; N]],
) {
    match count {
        1 => append_all::<T, N, 1>(squares, at, count, to),
        4 => append_all::<T, N, 4>(squares, at, count, to),
        8 => append_all::<T, N, 8>(squares, at, count, to),
        _ => append_all::<T, N, 16>(squares, at, count, to),
    }
}

/// The same by `K` points at a time.
#[inline(always)]
fn append_all<'a, T: Real, const N: usize, const K: usize>(
    squares: impl Iterator<Item = &'a [[T; N]]>,
    at: usize,
    count: usize,
    to: &mut [[T; N]],
) {
    for (from, to) in squares.zip(to.chunks_exact_mut(count)) {
        copy_by::<T, N, K>(&from[at..][..count], to);
    }
}

/// The points of edges that follow each other: their middles, then for each region both halves of what lies along them.
#[inline(always)]
fn append_edges<T: Real, const N: usize>(
    owned: &[Place],
    runs: &[Run],
    turned: &[[T; N]],
    parts: &mut [&mut [[T; N]]],
) {
    let (Some(first), [middle, halves @ ..]) = (owned.first(), runs) else { return };
    for (to, place) in parts[middle.part][first.element..].iter_mut().zip(owned) {
        *to = turned[place.points];
    }
    let mut at = 1;
    for [half, _] in halves.as_chunks().0 {
        let to = &mut parts[half.part][half.each * first.element..][..half.each * owned.len()];
        let from = &turned[at..];
        match half.count {
            1 => append_halves::<T, N, 1>(owned, half.count, from, to),
            2 => append_halves::<T, N, 2>(owned, half.count, from, to),
            4 => append_halves::<T, N, 4>(owned, half.count, from, to),
            8 => append_halves::<T, N, 8>(owned, half.count, from, to),
            _ => append_halves::<T, N, 16>(owned, half.count, from, to),
        }
        at += 2 * half.count;
    }
}

/// Both halves of so many points for each of some edges, `K` at a time; they change places where half-edges run against their edges.
#[inline(always)]
fn append_halves<T: Real, const N: usize, const K: usize>(
    owned: &[Place],
    half: usize,
    from: &[[T; N]],
    to: &mut [[T; N]],
) {
    // Of known length where it is short.
    let half = if K < 16 { K } else { half };
    for (to, place) in to.chunks_exact_mut(2 * half).zip(owned) {
        let from = &from[place.points..][..2 * half];
        let (low, high) = to.split_at_mut(half);
        let [first, second] = if place.is_backward { [half, 0] } else { [0, half] };
        copy_by::<T, N, K>(&from[first..][..half], low);
        copy_by::<T, N, K>(&from[second..][..half], high);
    }
}

/// As `copy_from_slice` without a call, of some `K` points.
#[inline(always)]
fn copy_by<T: Real, const N: usize, const K: usize>(from: &[[T; N]], to: &mut [[T; N]]) {
    for (from, to) in from.as_chunks::<K>().0.iter().zip(to.as_chunks_mut::<K>().0) {
        *to = *from;
    }
}

/// The points of edges, run by run.
#[inline(always)]
fn spread_edges<T: Real, const N: usize>(owned: &[Place], runs: &[Run], turned: &[[T; N]], out: &mut Output<'_, T, N>) {
    let mut first = 0;
    for run in runs {
        let (to, each, skip) = out.of_edges(run);
        spread(owned, run.count, each, skip, &turned[first..], to);
        first += run.count;
    }
}

/// Copies so many points for each of some places to where elements have room for `each`, `skip` of which come before.
#[inline(always)]
fn spread<T: Real, const N: usize>(
    places: &[Place],
    count: usize,
    each: usize,
    skip: [usize; 2],
    from: &[[T; N]],
    to: &mut [[T; N]],
) {
    match count {
        1 => copy_all::<T, N, 1>(places, each, skip, from, to),
        2 => copy_all::<T, N, 2>(places, each, skip, from, to),
        4 => copy_all::<T, N, 4>(places, each, skip, from, to),
        8 => copy_all::<T, N, 8>(places, each, skip, from, to),
        _ => {
            // Longer ones are sixteens.
            for first in (0..count).step_by(16) {
                copy_all::<T, N, 16>(places, each, skip.map(|skip| skip + first), &from[first..], to);
            }
        }
    }
}

/// As `copy_from_slice` for each of some places, without a call.
#[inline(always)]
fn copy_all<T: Real, const N: usize, const K: usize>(
    places: &[Place],
    each: usize,
    skip: [usize; 2],
    from: &[[T; N]],
    to: &mut [[T; N]],
) {
    for place in places {
        let skip = if place.is_backward { skip[1] } else { skip[0] };
        let from: &[[T; N]; K] = from[place.points..].first_chunk().expect("the points of a run");
        let to: &mut [[T; N]; K] = to[each * place.element + skip..].first_chunk_mut().expect("room for a run");
        *to = *from;
    }
}
