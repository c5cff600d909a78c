//! All levels of sixteen squares at once, one in each lane: their surroundings at the first level are read, refined
//! in nearby memory down to the last level, and only that is written. What a square's surroundings do not tell about its
//! corners, fans do.

mod flags;
mod read;
mod rings;
mod write;

pub(super) use flags::flags;
pub(super) use read::in_quad;
pub(super) use rings::Rings;

use super::super::parts::{Task, Writer};
use super::Deeper;
use super::fans::{FanCorner, FanValues};
use super::layout::Layout;
use super::rules::rounded;
use crate::index::{Edge, Face, HalfEdge};
use crate::kernel::{LANES, SideRules, Sixteen, lattice_point, lattice_points, refine_lattice, turn, vectorized};
use crate::real::Real;
use crate::topology::{FaceOf, NONE, Topology};
use flags::{HAS_FAN, IS_EARLY, IS_SHARP, OWNS_EDGE, all_flags, with_flag};
use read::{ControlQuad, Corner, QUAD, Quad, read};
use rings::Ring;
use write::{Output, Place, write};

/// One thread's memory.
pub(super) struct Squares<'a, T, const N: usize> {
    deeper: &'a Deeper,
    t: &'a Topology,
    /// Values of the levels where squares start, 0 and 1.
    levels: [&'a [[T; N]]; 2],
    fans: Option<&'a FanValues<T, N>>,
    rings: Option<&'a [Ring]>,
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

/// True where the quad with this first half-edge starts at its control points.
pub(super) fn is_early(flags: &[u8], first: u32) -> bool {
    with_flag(all_flags(flags, first), IS_EARLY) == 15
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
    /// Of quads, those of all half-edges.
    flags: [u32; LANES],
}

impl Batch {
    /// True where the batch is full.
    #[inline(always)]
    fn push(&mut self, h: u32, flags: u32, edges: [u32; 2]) -> bool {
        let lane = self.count;
        (self.half_edges[lane], self.flags[lane], self.edges[lane]) = (h, flags, edges);
        self.count += 1;
        self.count == LANES
    }

    /// The half-edges of the first `count` quads that have a flag, a bit for each.
    #[inline(always)]
    fn with(&self, flag: u8, count: usize) -> HalfEdges {
        let mut bits = 0;
        for (lane, &flags) in self.flags[..count].iter().enumerate() {
            bits |= u64::from(with_flag(flags, flag)) << (4 * lane);
        }
        HalfEdges(bits)
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
        fans: Option<&'a FanValues<T, N>>,
        rings: Option<&'a [Ring]>,
    ) -> Self {
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
            // What is read may spill over by one.
            turned: vec![[T::default(); N]; LANES * points.next_multiple_of(LANES) + 1],
            rows,
            corners: Vec::new(),
            owned: Vec::new(),
        };
        Self { deeper, t, levels, fans, rings, memory }
    }

    /// Refines the squares of a batch, and empties it.
    fn run<const KIND: usize>(&mut self, batch: &mut Batch, out: &mut Output<'_, T, N>) {
        let count = std::mem::take(&mut batch.count);
        if count == 0 {
            return;
        }
        let Self { deeper, t, levels, fans, rings, memory } = self;
        let (deeper, t, fans, rings, half_edges) = (*deeper, *t, *fans, *rings, &batch.half_edges[..count]);
        let layout =
            if KIND != CORNERS { &deeper.quad } else { deeper.corner.as_ref().expect("a face that is no quad") };
        let Memory { lattices: [from, to], turned, rows, corners, owned } = memory;
        // The last level comes to lie in the larger one.
        let (mut from, mut to) = (from, to);
        let start = usize::from(KIND != EARLY_QUADS);
        let level = levels[start];
        if (deeper.depth as usize - start).is_multiple_of(2) {
            std::mem::swap(&mut from, &mut to);
        }
        let mut size = match (KIND, rings) {
            (EARLY_QUADS, Some(rings)) => read(t, level, half_edges, turned, from, &rings),
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
        let mut corner = |lane: usize, corner: usize, h: u32, fan: u32| {
            corners.push((lane, corner, deeper.fans.corner(fan, h)));
        };
        if KIND != CORNERS {
            let owned = batch.with(OWNS_EDGE, count);
            for (lane, k) in batch.with(IS_SHARP, count) {
                side(lane, k, half_edges[lane] + k as u32, owned.has(lane, k));
            }
            for (lane, k) in batch.with(HAS_FAN, count) {
                let h = half_edges[lane] + k as u32;
                corner(lane, k, h, fan_of(h));
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
                    corner(lane, 0, h, fan_of(h));
                }
                if let Some(fan) = fans.and_then(|_| deeper.fans.of_centre(t.face.get(h))) {
                    corner(lane, 2, h, fan);
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
        let rows = &rows[usize::from(KIND == CORNERS)];
        let turned = &mut turned[..LANES * layout.points.len()];
        turn(from.as_flattened(), rows, turned.as_flattened_mut());
        vectorized(
            #[inline(always)]
            || match KIND {
                CORNERS => write::<T, N, false>(deeper, t, layout, batch, count, turned, from, owned, out),
                _ => write::<T, N, true>(deeper, t, layout, batch, count, turned, from, owned, out),
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
