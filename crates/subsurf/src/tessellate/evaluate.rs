//! One frame of a uniform tessellation: patterns of weights times control points, sums in the caller's precision relative to
//! one control point of the face; where there is no pattern, by values in `f64`. Every sample is evaluated by its owner alone. Faces of a chunk come in order, and so do
//! the points inside them and the vertices and edges that they own: each kind is one run of the result.

use super::by_values::ValueMemory;
use super::grid::{self, ALL, GridSamples, Parts, turned_parts};
use super::output::{Output, Vertices, of};
use super::pattern::{Pattern, Patterns};
use super::sample::Sampler;
use super::tasks::{Task, tasks};
use crate::index::{Face, HalfEdge};
use crate::kernel::{LANES, Ring, Samples, level};
use crate::limit::{LastPole, Location};
use crate::real::{Real, round};
use fearless_simd::{Simd, dispatch};
use rayon::prelude::*;
use std::ops::Range;
#[cfg(test)]
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Vertices that a thread takes at a time.
const VERTICES: usize = 4096;

/// Evaluates a layout with uniform rates.
pub(super) struct Evaluator<'a, T, const N: usize> {
    pub patterns: &'a Patterns<'a, T>,
    /// Evaluates what sums in `T` do not tell.
    pub sampler: Sampler<'a, T, N>,
    /// How many patches were evaluated so far.
    #[cfg(test)]
    pub evaluated: AtomicUsize,
}

/// What a thread keeps from face to face.
pub(super) struct Scratch<T, const N: usize> {
    ring: Vec<[T; N]>,
    points: Vec<[T; N]>,
    pub normals: Vec<[T; 3]>,
    /// By block, the samples whose normals are to be had otherwise.
    unsure: Vec<u32>,
    /// Of faces without a pattern.
    values: ValueMemory,
}

impl<'a, T: Real, const N: usize> Evaluator<'a, T, N> {
    pub fn new(patterns: &'a Patterns<'a, T>, sampler: Sampler<'a, T, N>) -> Self {
        Self {
            patterns,
            sampler,
            #[cfg(test)]
            evaluated: AtomicUsize::new(0),
        }
    }

    /// Fills points and normals of a layout, further ones included.
    pub fn evaluate(&self, out: Output<'_, T, N>, memory: &mut Vertices<T, N>) {
        let layout = self.sampler.layout();
        let (mut vertices, rest) = out.split(layout.vertices());
        let in_order = layout.vertex_slot.is_empty();
        if !in_order {
            memory.points.resize(vertices.points.len(), [T::default(); N]);
            memory.normals.resize(vertices.normals.len(), [T::default(); 3]);
        }
        let by_owner = Output { points: &mut memory.points, normals: &mut memory.normals };
        self.chunks(if in_order { vertices.borrow() } else { by_owner }, rest);
        if in_order {
            return;
        }
        fn pick<P: Copy + Send + Sync>(out: &mut [P], from: &[P], slots: &[u32]) {
            let each = out.par_chunks_mut(VERTICES).zip(slots.par_chunks(VERTICES));
            each.for_each(|(out, slots)| out.iter_mut().zip(slots).for_each(|(out, &slot)| *out = from[slot as usize]));
        }
        pick(vertices.points, &memory.points, &layout.vertex_slot);
        pick(vertices.normals, &memory.normals, &layout.vertex_slot);
    }

    fn chunks(&self, vertices: Output<'_, T, N>, rest: Output<'_, T, N>) {
        let layout = self.sampler.layout();
        let (rest, further) = rest.split(layout.edge_points() + layout.face_points());
        let (at_corners, along_edges) = further.normals.split_at_mut(self.patterns.corners().corners.len());
        self.normals_at_corners(at_corners);
        let tasks = tasks(layout, vertices, rest, (self.patterns.seen(), along_edges));
        tasks.into_par_iter().for_each_init(Scratch::default, |scratch, task| self.chunk(task, scratch));
    }

    fn chunk(&self, mut task: Task<'_, T, N>, scratch: &mut Scratch<T, N>) {
        let layout = self.sampler.layout();
        let table = layout.table;
        let first_edge = layout.edge_range(&task.faces).start;
        let faces = task.faces.clone();
        let mut next = faces.start;
        while next < faces.end {
            let face = Face(next);
            next += 1;
            if table.topology().is_hole(face) {
                continue;
            }
            let seen = task.seen_by(face, table.topology());
            if table.subfaces(face) > 1 {
                self.polygon(face, seen, first_edge, &mut task, scratch);
                continue;
            }
            let patch = table.patch(face, 0);
            match self.patterns.of_patch(patch) {
                // Faces that see more than they own have no such pattern.
                Some(pattern) if pattern.is_own => {
                    let is_alike = |&f: &u32| {
                        let face = Face(f);
                        let is_one = table.subfaces(face) == 1 && !table.topology().is_hole(face);
                        let other = is_one.then(|| self.patterns.of_patch(table.patch(face, 0))).flatten();
                        other.is_some_and(|other| std::ptr::eq(other, pattern))
                    };
                    next = (next..faces.end).find(|f| !is_alike(f)).unwrap_or(faces.end);
                    self.own(face.0..next, pattern, &mut task, scratch);
                }
                None if seen.is_empty() => self.alone(face, patch, &mut task, scratch),
                _ => self.shared(face, patch, seen, &mut task, scratch),
            }
        }
    }

    /// A face without a pattern.
    fn alone(&self, face: Face, patch: usize, task: &mut Task<'_, T, N>, scratch: &mut Scratch<T, N>) {
        let layout = self.sampler.layout();
        let Some(selection) = self.patterns.own_selection(layout.owned(patch), layout.table.turn(patch)) else {
            return self.shared(face, patch, &[], task, scratch);
        };
        let maker = self.patterns.maker(false);
        self.in_order(face, &selection.samples, 0, task, scratch, |values, _, out| {
            self.by_values(maker, patch, selection, values, out)
        });
    }

    /// Faces that follow each other and share a pattern with their own samples, in the order of the result.
    fn own(&self, faces: Range<u32>, pattern: &Pattern<T>, task: &mut Task<'_, T, N>, scratch: &mut Scratch<T, N>) {
        let points = pattern.matrix.points();
        let (table, control) = (self.sampler.layout().table, self.sampler.surface().points());
        dispatch!(level(), simd => simd.vectorize(
            #[inline(always)]
            || {
                for face in faces.map(Face) {
                    let numbers = table.ring_of(table.patch(face, 0), points);
                    self.in_order(face, &pattern.selection.samples, points, task, scratch, #[inline(always)] |_, ring, out| {
                        pattern.matrix.evaluate_with(simd, Ring { numbers, control }, ring, #[inline(always)] |_| true, out)
                    });
                }
            }
        ));
    }

    /// A face whose samples are in the order of the result; `evaluate` fills them, with memory for `ring` points, and says whether
    /// some normals are to be had otherwise.
    #[inline(always)]
    fn in_order(
        &self,
        face: Face,
        samples: &GridSamples,
        ring: usize,
        task: &mut Task<'_, T, N>,
        scratch: &mut Scratch<T, N>,
        evaluate: impl FnOnce(&mut ValueMemory, &mut [[T; N]], Samples<'_, T, N>) -> bool,
    ) {
        #[cfg(test)]
        self.evaluated.fetch_add(1, Relaxed);
        let length = samples.blocks() * LANES;
        let with_normals = self.sampler.with_normals();
        scratch.resize(samples.blocks(), ring, with_normals);
        let Scratch { ring, points: kept_points, normals: kept_normals, unsure, values } = scratch;
        // Blocks may end beyond the samples inside: later faces write over what they leave there.
        let has_room = task.inside.points.len() >= length;
        let points = if has_room { &mut task.inside.points[..length] } else { &mut kept_points[..length] };
        let normals = match (with_normals, has_room) {
            (false, _) => &mut [],
            (true, true) => &mut task.inside.normals[..length],
            (true, false) => &mut kept_normals[..length],
        };
        if evaluate(values, ring, Samples { points: &mut *points, normals: &mut *normals, unsure }) {
            self.sure_normals(face, 0, samples, (0, ALL), normals, unsure);
        }
        let (inside, along) = (samples.inside(), samples.inside() + samples.along_sides());

        task.edges.put_few(inside..along, points, normals);
        task.vertices.put_few(along..samples.len(), points, normals);
        if has_room {
            task.inside.skip(inside);
        } else {
            task.inside.put(&kept_points[..inside], of(kept_normals, 0..inside));
        }
    }

    /// A face that shares its samples with others that lie otherwise, or that sees more than it owns.
    fn shared(
        &self,
        face: Face,
        patch: usize,
        seen: &[HalfEdge],
        task: &mut Task<'_, T, N>,
        scratch: &mut Scratch<T, N>,
    ) {
        let layout = self.sampler.layout();
        let is_triangle = layout.is_triangle();
        let (owned, turn) = (layout.owned(patch), layout.table.turn(patch));
        let first = layout.table.topology().first(face);
        let seen = seen.iter().fold(0, |parts: Parts, h| parts | grid::side((h.0 - first) as u8));
        let samples = self.patch(face, 0, turned_parts(is_triangle, owned | seen, turn), scratch);
        let turned = (turn > 0).then(|| self.patterns.turned_inside(false, turn));
        scratch.put_inside(samples, turned, &mut task.inside);
        let place = |part: Parts| turned_parts(is_triangle, part, turn).trailing_zeros() as usize;
        for s in (0..4u8).filter(|s| owned & grid::side(*s) != 0) {
            scratch.put(samples.side(place(grid::side(s))), &mut task.edges);
        }
        for c in (0..4u8).filter(|c| owned & grid::corner(*c) != 0) {
            let at = samples.corner(place(grid::corner(c)) - 4);
            scratch.put(at..at + 1, &mut task.vertices);
        }
        for s in (0..4u8).filter(|s| seen & grid::side(*s) != 0) {
            task.put_further(&scratch.normals[samples.side(place(grid::side(s)))]);
        }
    }

    /// Evaluates the inside of a patch and the wanted parts into the thread's own memory.
    pub(super) fn patch(&self, face: Face, subface: u32, parts: Parts, scratch: &mut Scratch<T, N>) -> &GridSamples {
        #[cfg(test)]
        self.evaluated.fetch_add(1, Relaxed);
        let table = self.sampler.layout().table;
        let patch = table.patch(face, subface);
        let turn = table.turn(patch);
        let with_normals = self.sampler.with_normals();
        let Some(pattern) = self.patterns.of_patch(patch) else {
            let is_subface = table.subfaces(face) > 1;
            let selection = self.patterns.selection(is_subface, parts);
            let samples = &selection.samples;
            scratch.resize(samples.blocks(), 0, with_normals);
            let Scratch { points, normals, unsure, values, .. } = scratch;
            if !self.patterns.goes_by_values(is_subface) {
                self.piecewise((face, subface), samples, parts, points, normals);
                return samples;
            }
            let out = Samples { points, normals, unsure };
            if self.by_values(self.patterns.maker(is_subface), patch, selection, values, out) {
                self.sure_normals(face, subface, samples, (turn, parts), normals, unsure);
            }
            return samples;
        };
        let samples = &pattern.selection.samples;
        scratch.resize(samples.blocks(), pattern.matrix.points(), with_normals);
        let Scratch { ring, points, normals, unsure, .. } = scratch;
        let control = self.sampler.surface().points();
        let numbers = table.ring_of(patch, pattern.matrix.points());
        let wanted = |b: usize| samples.uses(b, parts);
        let out = Samples { points, normals, unsure };
        if pattern.matrix.evaluate(Ring { numbers, control }, ring, wanted, out) {
            self.sure_normals(face, subface, samples, (turn, parts), normals, unsure);
        }
        samples
    }

    /// Evaluates those normals by themselves that are not to be had from sums in `T`.
    #[cold]
    fn sure_normals(
        &self,
        face: Face,
        subface: u32,
        samples: &GridSamples,
        (turn, parts): (u8, Parts),
        normals: &mut [[T; 3]],
        unsure: &[u32],
    ) {
        let mut last = LastPole::default();
        for s in (0..samples.len()).filter(|&s| samples.uses(s / LANES, parts)) {
            if unsure[s / LANES] >> (s % LANES) & 1 != 0 {
                let [u, v] = samples.uv_in_face(s, turn);
                normals[s] = round(self.sampler.single_after(Location { face, subface, u, v }, &mut last).1);
            }
        }
    }
}

impl<T: Real, const N: usize> Default for Scratch<T, N> {
    fn default() -> Self {
        Self {
            ring: Vec::new(),
            points: Vec::new(),
            normals: Vec::new(),
            unsure: Vec::new(),
            values: ValueMemory::default(),
        }
    }
}

impl<T: Real, const N: usize> Scratch<T, N> {
    /// Makes room for this many blocks, and control points.
    fn resize(&mut self, blocks: usize, ring: usize, normals: bool) {
        if self.points.len() < blocks * LANES {
            self.points.resize(blocks * LANES, [T::default(); N]);
            self.normals.resize(if normals { blocks * LANES } else { 0 }, [T::default(); 3]);
            self.unsure.resize(blocks, 0);
        }
        if self.ring.len() < ring {
            self.ring.resize(ring, [T::default(); N]);
        }
    }

    /// Copies a run of samples to the next places.
    pub fn put(&self, run: Range<usize>, out: &mut Output<'_, T, N>) {
        out.put(&self.points[run.clone()], of(&self.normals, run));
    }

    /// Copies the samples inside a patch, whose face may be turned against its plan.
    pub fn put_inside(&self, samples: &GridSamples, turned: Option<&[u32]>, out: &mut Output<'_, T, N>) {
        let Some(turned) = turned else { return self.put(0..samples.inside(), out) };
        for (out, &s) in out.points.iter_mut().zip(turned) {
            *out = self.points[s as usize];
        }
        for (out, &s) in out.normals.iter_mut().zip(turned) {
            *out = self.normals[s as usize];
        }
        out.skip(turned.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limit::PatchTable;
    use crate::scheme::Scheme;
    use crate::shapes;
    use crate::tessellate::layout::{Layout, PatchRates};
    use crate::tessellate::normals::Sides;
    use crate::tessellate::pattern::Frames;
    use crate::tessellate::sample::NormalOf;

    #[test]
    fn without_memory_for_patterns_the_samples_are_the_same() {
        let triangles = shapes::all_triangles().into_iter().map(|s| (s, Scheme::Loop));
        for (shape, scheme) in shapes::all().into_iter().map(|s| (s, Scheme::CatmullClark)).chain(triangles) {
            let table = PatchTable::new(&shape.mesh, scheme).unwrap();
            let edges = table.topology().edge_count();
            let layout = Layout::new(&table, PatchRates::Uniform { rate: 6, edges });
            let sampler = Sampler::new(table.surface(&shape.positions), &layout, Some(NormalOf::SPACE));
            let evaluate = |bytes: [usize; 2]| {
                let patterns = Patterns::within(&layout, Some(&Sides::default()), Frames::Many, bytes);
                let (mut points, mut normals) = (vec![[0.0; 3]; layout.points()], vec![[0.0; 3]; layout.points()]);
                let out = Output { points: &mut points, normals: &mut normals };
                Evaluator::new(&patterns, sampler).evaluate(out, &mut Vertices::default());
                (points, normals)
            };
            let (with, without) = (evaluate([usize::MAX; 2]), evaluate([0; 2]));
            for (a, b) in with.0.iter().chain(&with.1).zip(without.0.iter().chain(&without.1)) {
                // Sums of the same terms; normals lose three digits where one derivative is small.
                (0..3).for_each(|c| assert!((a[c] - b[c]).abs() < 1e-12, "{}: {a:?} {b:?}", shape.name));
            }
        }
    }
}
