//! All levels of sixteen squares at once, one in each lane: their surroundings at the first level are read, refined
//! in nearby memory down to the last level, and only that is written. What a square's surroundings do not tell about its
//! corners, fans do.

use super::super::parts::{Task, Writer};
use super::Deeper;
use super::fans::{FanCorner, FanValues, Fans};
use super::layout::{Layout, Run, Side};
use super::rules::rounded;
use crate::index::{Edge, Face, HalfEdge};
use crate::kernel::{
    LANES, SideRules, Sixteen, lattice_point, lattice_points, refine_lattice, turn, turn_back, vectorized,
};
use crate::real::Real;
use crate::topology::{NONE, Topology};
use rayon::prelude::*;

/// Points read of a control quad, of one at level 1, and of a corner.
const CONTROL_QUAD: usize = lattice_points(1);
const QUAD: usize = lattice_points(2);
const CORNER: usize = lattice_points(1);

/// What the half-edge at a corner of a control face says of the square there, in bits: it is the first of its edge; and runs
/// against it; its vertex is written here; its vertex has a fan; its edge is sharp.
const OWNS_EDGE: u8 = 1;
const BACKWARD: u8 = 2;
const OWNS_VERTEX: u8 = 4;
const HAS_FAN: u8 = 8;
const IS_SHARP: u8 = 16;

/// By half-edge, what its square is.
pub(super) fn flags(t: &Topology, fans: &Fans, is_linear: bool) -> Vec<u8> {
    let bit = |is: bool, bit: u8| u8::from(is) * bit;
    let of = |h: u32| {
        let (e, v) = (Edge(t.edge[h as usize]), t.origin[h as usize]);
        let has_fan = fans.of_vertex(v).is_some();
        let is_sharp = !is_linear && t.edge_sharpness.code(e.index()) != 0;
        let owns_vertex = !has_fan & (t.vertex_half_edge[v as usize] == h);
        let mut flags = bit(owns_vertex, OWNS_VERTEX) | bit(has_fan, HAS_FAN) | bit(is_sharp, IS_SHARP);
        if t.edge_half_edge[e.index()] == h {
            flags |= OWNS_EDGE | bit(t.edge_vertices[e.index()][0] != v, BACKWARD);
        }
        flags
    };
    let mut out = subsurf_memory::with_capacity(t.half_edge_count());
    (0..t.half_edge_count() as u32).into_par_iter().with_min_len(SHARE).map(of).collect_into_vec(&mut out);
    out
}

/// Half-edges that a thread takes at least.
const SHARE: usize = 1 << 13;

/// One thread's memory.
pub(super) struct Squares<'a, T, const N: usize> {
    deeper: &'a Deeper,
    t: &'a Topology,
    /// Values of the level where squares start.
    level: &'a [[T; N]],
    fans: Option<&'a FanValues<T, N>>,
    memory: Memory<T, N>,
}

struct Memory<T, const N: usize> {
    /// Of the level and the one above, in turn.
    lattices: [Vec<Sixteen<T, N>>; 2],
    /// Points square by square: those read, and those of the last level.
    turned: Vec<[T; N]>,
    /// By point and component, for quads and corners.
    rows: [Vec<u32>; 2],
    /// Lanes and corners of squares that have fans.
    corners: Vec<(usize, usize, FanCorner)>,
    /// Edges that squares own.
    owned: Vec<Place>,
}

/// Points of a square that belong to an element: where they start among those of all squares, and the element among those of the
/// task.
#[derive(Clone, Copy, Default)]
struct Place {
    points: usize,
    element: usize,
}

/// Up to sixteen squares of one kind.
#[derive(Default)]
struct Batch {
    count: usize,
    half_edges: [u32; LANES],
    /// How many edges the task's faces before own; of a corner also without those from the half-edge before on.
    edges: [[u32; 2]; LANES],
}

impl Batch {
    /// True where the batch is full.
    #[inline(always)]
    fn push(&mut self, h: u32, edges: [u32; 2]) -> bool {
        (self.half_edges[self.count], self.edges[self.count]) = (h, edges);
        self.count += 1;
        self.count == LANES
    }
}

/// Where results go.
struct Output<'a, T, const N: usize> {
    parts: Vec<&'a mut [[T; N]]>,
    /// Of edges that are not numbered in the order of their owners, with all of an edge's together.
    edges: &'a mut [[T; N]],
    per_edge: usize,
    first_face: usize,
    first_half_edge: u32,
    corners: Vec<(u32, [T; N])>,
}

impl<'a, T: Real, const N: usize> Output<'a, T, N> {
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

impl<T: Real, const N: usize> Writer<T, N> for Squares<'_, T, N> {
    fn write(&mut self, task: Task<'_, T, N>) -> Vec<(u32, [T; N])> {
        let Task { faces, parts, edges, .. } = task;
        let t = self.t;
        let mut out = Output {
            parts,
            edges,
            per_edge: (1 << self.deeper.depth) - 1,
            first_face: faces.start,
            first_half_edge: t.face_offset[faces.start],
            corners: Vec::with_capacity(faces.len() + faces.len() / 8),
        };
        let (mut quads, mut corners, mut edge) = (Batch::default(), Batch::default(), 0);
        for f in faces.map(Face::new) {
            let (first, sides) = (t.first(f), t.sides(f));
            let owns = |h: u32| u32::from(self.deeper.flags[h as usize] & OWNS_EDGE);
            if sides == 4 {
                let owned = all_flags(&self.deeper.flags, first) & u32::from_le_bytes([OWNS_EDGE; 4]);
                let is_full = quads.push(first, [edge; 2]);
                edge += owned.count_ones();
                if is_full {
                    self.run::<true>(&mut quads, &mut out);
                }
                continue;
            }
            let centre = self.fans.and_then(|fans| self.deeper.fans.centre(fans, f.0));
            out.parts[0][f.index() - out.first_face] = centre.unwrap_or(self.level[t.vertex_count() + f.index()]);
            let end = first + sides as u32;
            let mut before = edge + (first..end - 1).map(owns).sum::<u32>();
            for h in first..end {
                let (own, owned) = (edge, owns(h));
                edge += owned;
                if corners.push(h, [own, before]) {
                    self.run::<false>(&mut corners, &mut out);
                }
                before = own;
            }
        }
        self.run::<true>(&mut quads, &mut out);
        self.run::<false>(&mut corners, &mut out);
        out.corners
    }
}

impl<'a, T: Real, const N: usize> Squares<'a, T, N> {
    pub fn new(deeper: &'a Deeper, t: &'a Topology, level: &'a [[T; N]], fans: Option<&'a FanValues<T, N>>) -> Self {
        let rows = |layout: &Layout| -> Vec<u32> {
            layout.points.iter().flat_map(|&point| (0..N as u32).map(move |c| N as u32 * point + c)).collect()
        };
        let rows = [rows(&deeper.quad), deeper.corner.as_ref().map_or(Vec::new(), rows)];
        let size = 1usize << deeper.depth;
        let layouts = [Some(&deeper.quad), deeper.corner.as_ref()];
        let points = layouts.into_iter().flatten().map(|layout| layout.points.len()).fold(QUAD, usize::max);
        // What is read is turned in whole sixteens.
        let lattice = |size: usize| vec![[[T::default(); LANES]; N]; lattice_points(size).max(QUAD) + LANES];
        let memory = Memory {
            lattices: [size / 2, size].map(lattice),
            turned: vec![[T::default(); N]; LANES * points.next_multiple_of(LANES)],
            rows,
            corners: Vec::new(),
            owned: Vec::new(),
        };
        Self { deeper, t, level, fans, memory }
    }

    /// Refines the squares of a batch, and empties it.
    fn run<const QUADS: bool>(&mut self, batch: &mut Batch, out: &mut Output<'_, T, N>) {
        let count = std::mem::take(&mut batch.count);
        if count == 0 {
            return;
        }
        let Self { deeper, t, level, fans, memory } = self;
        let (deeper, t, fans, half_edges) = (*deeper, *t, *fans, &batch.half_edges[..count]);
        let layout = if QUADS { &deeper.quad } else { deeper.corner.as_ref().expect("a face that is no quad") };
        let Memory { lattices: [from, to], turned, rows, corners, owned } = memory;
        // The last level comes to lie in the larger one.
        let (mut from, mut to) = (from, to);
        if (deeper.depth - deeper.start) % 2 == 0 {
            std::mem::swap(&mut from, &mut to);
        }
        let mut size = match (QUADS, deeper.start) {
            (true, 0) => {
                read::<T, N, CONTROL_QUAD>(
                    t,
                    level,
                    half_edges,
                    turned,
                    from,
                    #[inline(always)]
                    |t, h| round_control_quad(t, h),
                );
                1
            }
            (true, _) => {
                read::<T, N, QUAD>(
                    t,
                    level,
                    half_edges,
                    turned,
                    from,
                    #[inline(always)]
                    |t, h| round_quad(t, h),
                );
                2
            }
            (false, _) => {
                read::<T, N, CORNER>(
                    t,
                    level,
                    half_edges,
                    turned,
                    from,
                    #[inline(always)]
                    |t, h| round_corner(t, h),
                );
                1
            }
        };
        corners.clear();
        let mut kinds = [[0; LANES]; 4];
        let mut has_sharp = [false; 4];
        for (lane, &h) in half_edges.iter().enumerate() {
            let mut side = |side: usize, h: u32| {
                kinds[side][lane] = deeper.creases.kind(t, Edge(t.edge[h as usize]));
                has_sharp[side] = true;
            };
            let mut corner = |corner: usize, h: u32| {
                let fan = deeper.fans.of_vertex(t.origin[h as usize]).unwrap_or(0);
                corners.push((lane, corner, deeper.fans.corner(fan, h)));
            };
            if QUADS {
                let mut sharp = all_flags(&deeper.flags, h) & u32::from_le_bytes([IS_SHARP; 4]);
                while sharp != 0 {
                    let k = sharp.trailing_zeros() / 8;
                    side(k as usize, h + k);
                    sharp &= sharp - 1;
                }
                let mut fans = all_flags(&deeper.flags, h) & u32::from_le_bytes([HAS_FAN; 4]);
                while fans != 0 {
                    let k = fans.trailing_zeros() / 8;
                    corner(k as usize, h + k);
                    fans &= fans - 1;
                }
            } else {
                for (at, h) in [(0, h), (3, t.prev(HalfEdge(h)).0)] {
                    if deeper.flags[h as usize] & IS_SHARP != 0 {
                        side(at, h);
                    }
                }
                if deeper.flags[h as usize] & HAS_FAN != 0 {
                    corner(0, h);
                }
                if let Some(fan) = fans.and_then(|_| deeper.fans.of_centre(t.face.get(h))) {
                    corners.push((lane, 2, deeper.fans.corner(fan, h)));
                }
            }
        }
        let smooth = rounded(&deeper.smooth);
        for at in deeper.start as usize..deeper.depth as usize {
            let is_last = at + 1 == deeper.depth as usize;
            let mut sides: [Option<SideRules<T>>; 4] = [None; 4];
            for side in 0..4 {
                if has_sharp[side] && kinds[side][..count].iter().any(|&kind| !deeper.creases.is_smooth(at, kind)) {
                    sides[side] = Some(deeper.side_rules(at, &kinds[side]));
                }
            }
            let sides = [sides[0].as_ref(), sides[1].as_ref(), sides[2].as_ref(), sides[3].as_ref()];
            refine_lattice(from, size, &smooth, sides, !is_last, to);
            size *= 2;
            if let (false, Some(fans)) = (is_last, fans) {
                for &(lane, corner, FanCorner { fan, beyond }) in &*corners {
                    let values = deeper.fans.kept(fans, fan, at + 1);
                    let mut put = |[i, j]: [isize; 2], value: &[T; N]| {
                        let point = &mut to[lattice_point(size, i, j)];
                        (0..N).for_each(|c| point[c][lane] = value[c]);
                    };
                    let [own, clockwise, counter] = at_corner(size as isize, corner);
                    put(own, &values[0]);
                    for (at, end) in [clockwise, counter].into_iter().zip(beyond) {
                        if end != NONE {
                            put(at, &values[1 + end as usize]);
                        }
                    }
                }
            }
            std::mem::swap(&mut from, &mut to);
        }
        let rows = &rows[usize::from(!QUADS)];
        let turned = &mut turned[..LANES * layout.points.len()];
        turn(from.as_flattened(), rows, turned.as_flattened_mut());
        vectorized(
            #[inline(always)]
            || write::<T, N, QUADS>(deeper, t, layout, batch, count, turned, from, owned, out),
        );
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

/// A corner, and the points beyond the side that starts there and beyond the one that ends there, next to it.
fn at_corner(size: isize, corner: usize) -> [[isize; 2]; 3] {
    match corner {
        0 => [[0, 0], [0, -1], [-1, 0]],
        1 => [[size, 0], [size + 1, 0], [size, -1]],
        2 => [[size, size], [size, size + 1], [size + 1, size]],
        _ => [[0, size], [-1, size], [0, size + 1]],
    }
}

/// Reads the surroundings of squares into lanes.
fn read<T: Real, const N: usize, const POINTS: usize>(
    t: &Topology,
    level: &[[T; N]],
    half_edges: &[u32],
    turned: &mut [[T; N]],
    out: &mut [Sixteen<T, N>],
    round: impl Fn(&Topology, u32) -> [u32; POINTS],
) {
    let stride = POINTS.next_multiple_of(LANES);
    vectorized(
        #[inline(always)]
        || {
            // Numbers first, so that loads do not wait for each other.
            let mut ids = [[0; POINTS]; LANES];
            for (ids, &h) in ids.iter_mut().zip(half_edges) {
                *ids = round(t, h);
            }
            for (ids, row) in ids[..half_edges.len()].iter().zip(turned.chunks_exact_mut(stride)) {
                for (&id, out) in ids.iter().zip(row) {
                    *out = level[id as usize];
                }
            }
        },
    );
    turn_back(turned[..LANES * stride].as_flattened(), out.as_flattened_mut());
}

/// The control vertices in and round a quad with first half-edge `first`, as a lattice of size 1. What lies across a corner
/// where there are not four faces does not matter, nor what lies beyond a boundary.
#[inline(always)]
fn round_control_quad(t: &Topology, first: u32) -> [u32; CONTROL_QUAD] {
    // Corner by corner, counter-clockwise: across the corner, then beyond the side from there on.
    const BEYOND: [[usize; 3]; 4] = [[0, 1, 2], [3, 7, 11], [15, 14, 13], [12, 8, 4]];
    const OWN: [usize; 4] = [5, 6, 10, 9];
    let at = |h: u32, by: u32| (h & !3 | (h + by) & 3) as usize;
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

/// The vertices of level 1 in and round a quad with first half-edge `first`, as a lattice of size 2. What lies across a corner
/// where there are not four faces does not matter, nor what lies beyond a boundary.
#[inline(always)]
fn round_quad(t: &Topology, first: u32) -> [u32; QUAD] {
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

/// The same of the corner at half-edge `h` of another face, as a lattice of size 1.
#[inline(always)]
fn round_corner(t: &Topology, h: u32) -> [u32; CORNER] {
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
        [out[0], out[1], out[2], out[3]] = [centre(across), middle(t.next(twin)), centre(twin), middle(t.prev(twin))];
    }
    if let Some(twin) = t.twin(prev) {
        [out[4], out[8], out[12]] = [middle(t.prev(twin)), centre(twin), middle(t.next(twin))];
    }
    out
}

/// Writes what some squares own: `turned` has their points square by square in the order of the layout, `lattice` point by point.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
fn write<T: Real, const N: usize, const QUADS: bool>(
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
    for lane in 0..count {
        let (h, edges) = (batch.half_edges[lane], batch.edges[lane]);
        let mut own = |side: usize, number: u32, is_backward: bool| {
            let (side, edge) = (&layout.sides[side], number as usize);
            if !is_backward {
                return owned.push(Place { points: lane * stride + side.start, element: edge });
            }
            write_backward(side, edge, lane, lattice, out);
        };
        if QUADS {
            // Most quads own two edges and a vertex, but which ones they are is hard to predict.
            let flags = all_flags(&deeper.flags, h);
            let (mut edges, mut number) = (flags & u32::from_le_bytes([OWNS_EDGE; 4]), edges[0]);
            while edges != 0 {
                let at = edges.trailing_zeros();
                own(at as usize / 8, number, (flags >> at) as u8 & BACKWARD != 0);
                (edges, number) = (edges & (edges - 1), number + 1);
            }
            let mut vertices = flags & u32::from_le_bytes([OWNS_VERTEX; 4]);
            while vertices != 0 {
                let k = vertices.trailing_zeros() as usize / 8;
                out.corners.push((t.origin[h as usize + k], turned[lane * stride + layout.corners + k]));
                vertices &= vertices - 1;
            }
        } else {
            let flags = deeper.flags[h as usize];
            if flags & OWNS_EDGE != 0 {
                own(0, edges[0], flags & BACKWARD != 0);
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
        for i in 0..from.len().min(to.len()) {
            to[i] = from[i];
        }
    }
}

/// Those of a quad's half-edges, the first one's lowest.
#[inline(always)]
fn all_flags(flags: &[u8], first: u32) -> u32 {
    u32::from_le_bytes(*flags[first as usize..].first_chunk().expect("a quad has four sides"))
}
