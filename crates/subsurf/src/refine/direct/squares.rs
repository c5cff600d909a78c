//! All levels of sixteen squares at once, one in each lane: their surroundings at the first level are read, refined
//! in nearby memory down to the last level, and only that is written. What a square's surroundings do not tell about its
//! corners, fans do.

mod flags;
mod frames;
mod read;
mod write;

pub(super) use flags::flags;
pub(super) use frames::{Frames, Tables, rings};
pub(super) use read::in_quad;

use super::super::parts::{Task, Writer};
use super::Deeper;
use super::fans::{FanCorner, FanValues};
use super::layout::Layout;
use super::rules::rounded;
use crate::index::{Edge, Face, HalfEdge};
use crate::kernel::{LANES, Lined, SideRules, lattice_point, lattice_points, refine_lattice, turn, vectorized};
use crate::real::Real;
use crate::topology::{FaceOf, NONE, Topology};
use flags::{HAS_FAN, IS_EARLY, IS_SHARP, OWNS_EDGE, all_flags, with_flag};
use read::{ControlQuad, Corner, QUAD, Quad, read};
use std::ops::Range;
use write::{Output, Place, write};

/// One thread's memory.
pub(super) struct Squares<'a, T, const N: usize> {
    deeper: &'a Deeper,
    t: &'a Topology,
    /// Values of the levels where squares start, 0 and 1.
    levels: [&'a [[T; N]]; 2],
    fans: Option<&'a FanValues<'a, T, N>>,
    tables: Option<&'a Tables>,
    memory: Memory<T>,
}

struct Memory<T> {
    /// Of the level and the one above, in turn.
    lattices: [Lined<T>; 2],
    /// Points square by square: those read, and those of the last level.
    turned: Lined<T>,
    /// By point and component, for quads and corners.
    rows: [Vec<u32>; 2],
    /// Lanes and corners of squares that have fans.
    corners: Vec<(usize, usize, FanCorner)>,
    /// By kind of quads: those before are listed in the tables of fans before this place.
    listed: [usize; 2],
    /// Edges that squares own.
    owned: Vec<Place>,
}

/// True where the quad with this first half-edge starts at its control points.
pub(super) fn is_early(flags: &[u8], first: u32) -> bool {
    with_flag(all_flags(flags, first), IS_EARLY) == 15
}

/// True where the quad with this half-edge looks for a fan at its origin.
pub(super) fn has_fan(flags: &[u8], h: u32) -> bool {
    flags[h as usize] & HAS_FAN != 0
}

/// Kinds of squares: quads that start at their control points, others, and corners of faces that are no quads.
const EARLY_QUADS: usize = 0;
const QUADS: usize = 1;
const CORNERS: usize = 2;

/// Up to sixteen squares of one kind.
#[derive(Default)]
struct Batch {
    count: usize,
    half_edges: [u32; LANES],
    /// How many edges the task's faces before own; of a corner also without those from the half-edge before on.
    edges: [[u32; 2]; LANES],
    /// Of quads, those of all half-edges, four to each.
    flags: Flags,
}

#[derive(Clone, Copy)]
struct Flags([u8; 4 * LANES]);

impl Default for Flags {
    fn default() -> Self {
        Self([0; 4 * LANES])
    }
}

impl Batch {
    /// True where the batch is full.
    #[inline(always)]
    fn push(&mut self, h: u32, flags: u32, edges: [u32; 2]) -> bool {
        let lane = self.count;
        (self.half_edges[lane], self.edges[lane]) = (h, edges);
        self.flags.0.as_chunks_mut().0[lane] = flags.to_le_bytes();
        self.count += 1;
        self.count == LANES
    }

    /// The half-edges of the first `count` quads that have a flag, a bit for each.
    #[inline(always)]
    fn with(&self, flag: u8, count: usize) -> HalfEdges {
        let mut bits = 0;
        for (eight, &flags) in self.flags.0.as_chunks().0.iter().enumerate() {
            // Bits 0, 8, … 56 move to 56, 57, … 63.
            let found = u64::from_le_bytes(flags) >> flag.trailing_zeros() & 0x0101_0101_0101_0101;
            bits |= found.wrapping_mul(0x0102_0408_1020_4080) >> 56 << (8 * eight);
        }
        HalfEdges(bits & u64::MAX >> (64 - 4 * count))
    }
}

/// Half-edges of sixteen quads, a bit for each: one loop over those of all quads ends once, where loops over those of each are hard
/// to predict.
#[derive(Clone, Copy)]
struct HalfEdges(u64);

impl HalfEdges {
    #[inline(always)]
    fn has(self, lane: usize, k: usize) -> bool {
        self.0 >> (4 * lane + k) & 1 == 1
    }

    /// How many of a quad's come before its half-edge number `k`.
    #[inline(always)]
    fn before(self, lane: usize, k: usize) -> u32 {
        (self.0 >> (4 * lane) & ((1 << k) - 1)).count_ones()
    }
}

/// Lanes, and which of the four.
impl Iterator for HalfEdges {
    type Item = (usize, usize);

    #[inline(always)]
    fn next(&mut self) -> Option<(usize, usize)> {
        let at = self.0.trailing_zeros() as usize;
        self.0 &= self.0.wrapping_sub(1);
        (at < 64).then_some((at / 4, at % 4))
    }
}

impl<T: Real, const N: usize> Writer<T, N> for Squares<'_, T, N> {
    fn write(&mut self, task: Task<'_, T, N>) -> Vec<(u32, [T; N])> {
        let (t, faces) = (self.t, task.faces.clone());
        let mut out = Output::new(t, task, self.deeper.depth);
        if let Some(tables) = self.tables.and_then(|tables| tables.fans.as_ref()) {
            self.memory.listed = [tables.first_from(t.face_offset[faces.start]); 2];
        }
        if matches!(t.face, FaceOf::Quads) {
            self.write_quads(faces, &mut out);
            return out.corners;
        }
        let (mut early, mut quads, mut corners, mut edge) = (Batch::default(), Batch::default(), Batch::default(), 0);
        for f in faces.map(Face::new) {
            let (first, sides) = (t.first(f), t.sides(f));
            let owns = |h: u32| u32::from(self.deeper.flags[h as usize] & OWNS_EDGE);
            if sides == 4 {
                let flags = all_flags(&self.deeper.flags, first);
                let before = [edge; 2];
                edge += with_flag(flags, OWNS_EDGE).count_ones();
                if with_flag(flags, IS_EARLY) == 15 {
                    if early.push(first, flags, before) {
                        self.run::<EARLY_QUADS>(&mut early, &mut out);
                    }
                } else if quads.push(first, flags, before) {
                    self.run::<QUADS>(&mut quads, &mut out);
                }
                continue;
            }
            let centre = self.fans.and_then(|fans| self.deeper.fans.centre(fans, f.0));
            out.parts[0][f.index() - out.first_face] = centre.unwrap_or(self.levels[1][t.vertex_count() + f.index()]);
            let end = first + sides as u32;
            let mut before = edge + (first..end - 1).map(owns).sum::<u32>();
            for h in first..end {
                let (own, owned) = (edge, owns(h));
                edge += owned;
                if corners.push(h, 0, [own, before]) {
                    self.run::<CORNERS>(&mut corners, &mut out);
                }
                before = own;
            }
        }
        self.run::<EARLY_QUADS>(&mut early, &mut out);
        self.run::<QUADS>(&mut quads, &mut out);
        self.run::<CORNERS>(&mut corners, &mut out);
        out.corners
    }
}

impl<'a, T: Real, const N: usize> Squares<'a, T, N> {
    pub fn new(
        deeper: &'a Deeper,
        t: &'a Topology,
        levels: [&'a [[T; N]]; 2],
        fans: Option<&'a FanValues<'a, T, N>>,
        tables: Option<&'a Tables>,
    ) -> Self {
        let rows = |layout: &Layout| -> Vec<u32> {
            let each = |&point: &u32| (0..N as u32).map(move |c| N as u32 * point + c);
            let mut rows: Vec<u32> = layout.points.iter().flat_map(each).collect();
            rows.resize(rows.len().next_multiple_of(LANES), 0);
            rows
        };
        let rows = [rows(&deeper.quad), deeper.corner.as_ref().map_or(Vec::new(), rows)];
        let size = 1usize << deeper.depth;
        let layouts = [Some(&deeper.quad), deeper.corner.as_ref()];
        let points = layouts.into_iter().flatten().map(|layout| layout.stride).fold(QUAD, usize::max);
        // What is read is turned in whole sixteens.
        let lattice = |size: usize| Lined::new(N * LANES * (lattice_points(size).max(QUAD) + LANES));
        let memory = Memory {
            lattices: [size / 2, size].map(lattice),
            turned: Lined::new(N * LANES * points.next_multiple_of(LANES)),
            rows,
            corners: Vec::new(),
            listed: [0; 2],
            owned: Vec::new(),
        };
        Self { deeper, t, levels, fans, tables, memory }
    }

    /// The same where all faces are quads.
    fn write_quads(&mut self, faces: Range<usize>, out: &mut Output<'_, T, N>) {
        let (mut batch, mut edge) = (Batch::default(), 0);
        for start in faces.clone().step_by(LANES) {
            batch.count = LANES.min(faces.end - start);
            let flags = &self.deeper.flags[4 * start..][..4 * batch.count];
            batch.flags.0[..flags.len()].copy_from_slice(flags);
            let owned = batch.with(OWNS_EDGE, batch.count);
            for lane in 0..batch.count {
                batch.half_edges[lane] = 4 * (start + lane) as u32;
                batch.edges[lane] = [edge; 2];
                edge += owned.before(lane, 4);
            }
            self.run::<EARLY_QUADS>(&mut batch, out);
        }
    }

    /// Refines the squares of a batch, and empties it.
    fn run<const KIND: usize>(&mut self, batch: &mut Batch, out: &mut Output<'_, T, N>) {
        let count = std::mem::take(&mut batch.count);
        if count == 0 {
            return;
        }
        let Self { deeper, t, levels, fans, tables, memory } = self;
        let (deeper, t, fans, tables, half_edges) = (*deeper, *t, *fans, *tables, &batch.half_edges[..count]);
        let layout =
            if KIND != CORNERS { &deeper.quad } else { deeper.corner.as_ref().expect("a face that is no quad") };
        let Memory { lattices: [from, to], turned, rows, corners, listed, owned } = memory;
        // The last level comes to lie in the larger one.
        let (mut from, mut to) = (from.sixteens(), to.sixteens());
        let turned = turned.values();
        let start = usize::from(KIND != EARLY_QUADS);
        let level = levels[start];
        if (deeper.depth as usize - start).is_multiple_of(2) {
            std::mem::swap(&mut from, &mut to);
        }
        let mut size = match (KIND, tables) {
            (EARLY_QUADS, Some(tables)) => read(t, level, half_edges, turned, from, &&tables.rings[..]),
            (EARLY_QUADS, None) if matches!(t.face, FaceOf::Quads) => {
                read(t, level, half_edges, turned, from, &ControlQuad::<true>)
            }
            (EARLY_QUADS, None) => read(t, level, half_edges, turned, from, &ControlQuad::<false>),
            (QUADS, _) => read(t, level, half_edges, turned, from, &Quad),
            _ => read(t, level, half_edges, turned, from, &Corner),
        };
        corners.clear();
        let mut kinds = [[0; LANES]; 4];
        // In some lane: at all, and by the owner of the edge.
        let mut has_sharp = [[false; 2]; 4];
        let mut side = |lane: usize, side: usize, h: u32, owns: bool| {
            kinds[side][lane] = deeper.creases.kind(t, Edge(t.edge[h as usize]));
            has_sharp[side][0] = true;
            has_sharp[side][1] |= owns;
        };
        let fan_of = |h: u32| deeper.fans.of_vertex(t.origin[h as usize]).unwrap_or(0);
        let fan_tables = tables.and_then(|tables| tables.fans.as_ref());
        if KIND != CORNERS {
            let owned = batch.with(OWNS_EDGE, count);
            for (lane, k) in batch.with(IS_SHARP, count) {
                side(lane, k, half_edges[lane] + k as u32, owned.has(lane, k));
            }
            for (lane, k) in batch.with(HAS_FAN, count) {
                let h = half_edges[lane] + k as u32;
                let corner = match fan_tables {
                    Some(tables) => tables.corner(h, &mut listed[KIND]),
                    None => deeper.fans.corner(None, fan_of(h), h),
                };
                corners.push((lane, k, corner));
            }
        } else {
            for (lane, &h) in half_edges.iter().enumerate() {
                for (at, h) in [(0, h), (3, t.prev(HalfEdge(h)).0)] {
                    let flags = deeper.flags[h as usize];
                    if flags & IS_SHARP != 0 {
                        side(lane, at, h, flags & OWNS_EDGE != 0);
                    }
                }
                if deeper.flags[h as usize] & HAS_FAN != 0 {
                    corners.push((lane, 0, deeper.fans.corner(fan_tables, fan_of(h), h)));
                }
                if let Some(fan) = fans.and_then(|_| deeper.fans.of_centre(t.face.get(h))) {
                    corners.push((lane, 2, deeper.fans.corner(fan_tables, fan, h)));
                }
            }
        }
        let smooth = rounded(&deeper.smooth);
        for at in start..deeper.depth as usize {
            let is_last = at + 1 == deeper.depth as usize;
            let mut sides: [Option<SideRules<T>>; 4] = [None; 4];
            for side in 0..4 {
                if has_sharp[side][usize::from(is_last)]
                    && kinds[side][..count].iter().any(|&kind| !deeper.creases.is_smooth(at, kind))
                {
                    sides[side] = Some(deeper.side_rules(at, &kinds[side]));
                }
            }
            let sides = [sides[0].as_ref(), sides[1].as_ref(), sides[2].as_ref(), sides[3].as_ref()];
            refine_lattice(from, size, &smooth, sides, !is_last, to);
            size *= 2;
            if let (false, Some(fans)) = (is_last, fans) {
                for &(lane, corner, of_fan) in &*corners {
                    let values = deeper.fans.kept(fans, of_fan, at + 1);
                    let mut put = |[i, j]: [isize; 2], value: &[T; N]| {
                        let point = &mut to[lattice_point(size, i, j)];
                        (0..N).for_each(|c| point[c][lane] = value[c]);
                    };
                    let [own, clockwise, counter] = at_corner(size as isize, corner);
                    put(own, &values[0]);
                    for (at, end) in [clockwise, counter].into_iter().zip(of_fan.beyond) {
                        if end != NONE {
                            put(at, &values[1 + end as usize]);
                        }
                    }
                }
            }
            std::mem::swap(&mut from, &mut to);
        }
        let rows = &rows[usize::from(KIND == CORNERS)];
        let turned = &mut turned[..LANES * layout.stride];
        turn(from.as_flattened(), rows, N * layout.stride, turned.as_flattened_mut());
        vectorized(
            #[inline(always)]
            || match KIND {
                CORNERS => write::<T, N, false>(deeper, t, layout, batch, count, turned, owned, out),
                _ => write::<T, N, true>(deeper, t, layout, batch, count, turned, owned, out),
            },
        );
    }
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
