//! One frame of a uniform tessellation: patterns of weights times control points, sums in the caller's precision relative to
//! one control point of the face. Every sample is evaluated by its owner alone, and written once.

use super::grid::{self, GridSamples, Parts, turned_sides};
use super::normals::Sides;
use super::pattern::{CornerRow, Pattern, Patterns, corner_of};
use super::sample::Sampler;
use crate::index::{Face, HalfEdge};
use crate::kernel::{self, LANES, unit_normals_of};
use crate::limit::Location;
use crate::real::{Real, round};
use rayon::prelude::*;
use std::ops::Range;

/// Vertices that a thread takes at a time.
const VERTICES: usize = 512;

/// Evaluates a layout with uniform rates.
pub(super) struct Evaluator<'a, T, const N: usize> {
    pub patterns: &'a Patterns<T>,
    /// Evaluates what sums in `T` do not tell.
    pub sampler: Sampler<'a, T, N>,
}

/// What a thread keeps from face to face.
struct Scratch<T, const N: usize> {
    ring: Vec<[T; N]>,
    points: Vec<[T; N]>,
    normals: Vec<[T; 3]>,
    /// By block, the samples whose normals are to be had otherwise.
    unsure: Vec<u32>,
}

/// A chunk of faces and the parts of the result that it fills: points and normals inside its edges, inside its faces.
struct Task<'o, T, const N: usize> {
    faces: Range<u32>,
    edges: Output<'o, T, N>,
    inside: Output<'o, T, N>,
}

/// Points and, where they are wanted, their normals.
pub(super) struct Output<'o, T, const N: usize> {
    pub points: &'o mut [[T; N]],
    pub normals: &'o mut [[T; 3]],
}

impl<'o, T, const N: usize> Output<'o, T, N> {
    /// The first `count` points, and the rest.
    pub fn split(self, count: usize) -> (Self, Self) {
        let (points, more_points) = self.points.split_at_mut(count);
        let (normals, more_normals) = self.normals.split_at_mut(count.min(self.normals.len()));
        (Self { points, normals }, Self { points: more_points, normals: more_normals })
    }
}

impl<T: Real, const N: usize> Evaluator<'_, T, N> {
    /// Fills points and normals of a layout.
    pub fn evaluate(&self, out: Output<'_, T, N>) {
        let layout = self.sampler.layout();
        let (vertices, rest) = out.split(layout.vertices());
        self.vertices(vertices);
        let (mut edges, mut inside) = rest.split(layout.edge_points());
        let mut tasks = Vec::new();
        for faces in layout.face_chunks() {
            let (own_edges, other_edges) = edges.split(layout.edge_range(&faces).len());
            let (own_inside, other_inside) = inside.split(layout.face_range(&faces).len());
            (edges, inside) = (other_edges, other_inside);
            tasks.push(Task { faces, edges: own_edges, inside: own_inside });
        }
        tasks.into_par_iter().for_each_init(Scratch::default, |scratch, task| self.chunk(task, scratch));
    }

    fn vertices(&self, out: Output<'_, T, N>) {
        let layout = self.sampler.layout();
        let points = out.points.par_chunks_mut(VERTICES).zip(layout.vertex_owner.par_chunks(VERTICES));
        if !self.sampler.with_normals() {
            return points.for_each(|(points, owners)| {
                points.iter_mut().zip(owners).for_each(|(point, &h)| ([*point], _) = self.corner(HalfEdge(h)));
            });
        }
        points.zip(out.normals.par_chunks_mut(VERTICES)).for_each(|((points, owners), normals)| {
            let blocks = points.chunks_mut(LANES).zip(normals.chunks_mut(LANES)).zip(owners.chunks(LANES));
            for ((points, normals), owners) in blocks {
                self.corners(owners, Some(points), normals);
            }
        });
    }

    /// Normals of the further sides of creases.
    pub fn extra_normals(&self, sides: &Sides, normals: &mut [[T; 3]]) {
        let layout = self.sampler.layout();
        let corners: Vec<u32> = sides.corners().map(|h| h.0).collect();
        let (at_corners, along_edges) = normals.split_at_mut(corners.len());
        at_corners
            .par_chunks_mut(LANES)
            .zip(corners.par_chunks(LANES))
            .for_each(|(normals, corners)| self.corners(corners, None, normals));
        let Some(rate) = sides.edges().next().map(|h| layout.rates.edge[layout.table.topology().edge(h).index()])
        else {
            return;
        };
        let edges: Vec<HalfEdge> = sides.edges().collect();
        along_edges
            .par_chunks_mut(rate as usize - 1)
            .zip(edges)
            .for_each_init(Scratch::default, |scratch, (normals, h)| self.along(h, normals, scratch));
    }

    /// Normals of the points inside an edge as the face of `h` sees it.
    fn along(&self, h: HalfEdge, normals: &mut [[T; 3]], scratch: &mut Scratch<T, N>) {
        let layout = self.sampler.layout();
        let t = layout.table.topology();
        let face = t.face(h);
        let corner = h.0 - t.first(face);
        let subfaces = layout.table.subfaces(face);
        if subfaces == 1 {
            let turn = layout.table.turn(layout.table.patch(face, 0));
            let own = turned_sides(layout.is_triangle(), grid::side(corner as u8), turn);
            let samples = self.patch(face, 0, own, scratch);
            normals.copy_from_slice(&scratch.normals[samples.side(own.trailing_zeros() as usize)]);
            return;
        }
        let (out, back) = normals.split_at_mut(layout.cells[1] as usize);
        let samples = self.patch(face, corner, grid::side(0) | grid::corner(1), scratch);
        out[..back.len()].copy_from_slice(&scratch.normals[samples.side(0)]);
        out[back.len()] = scratch.normals[samples.corner(1)];
        let samples = self.patch(face, (corner + 1) % subfaces, grid::side(3), scratch);
        back.copy_from_slice(&scratch.normals[samples.side(3)]);
    }

    /// Up to a block of face corners.
    fn corners(&self, corners: &[u32], mut points: Option<&mut [[T; N]]>, normals: &mut [[T; 3]]) {
        let [mut du, mut dv] = [[[T::default(); LANES]; 3]; 2];
        let mut extent = [T::default(); LANES];
        for (k, &h) in corners.iter().enumerate() {
            let ([position, u, v], size) = self.corner(HalfEdge(h));
            extent[k] = size;
            if let Some(points) = &mut points {
                points[k] = position;
            }
            (0..3).for_each(|c| (du[c][k], dv[c][k]) = (u[c % N], v[c % N]));
        }
        let mut unit = [[T::default(); 3]; LANES];
        let unsure = unit_normals_of(&du, &dv, &extent, &mut unit);
        normals.copy_from_slice(&unit[..corners.len()]);
        for (k, &h) in corners.iter().enumerate().filter(|(k, _)| unsure >> k & 1 != 0) {
            normals[k] = round(self.sampler.single(self.sampler.layout().corner_location(HalfEdge(h))).1);
        }
    }

    /// Position, and derivatives if `K` is 3, at the start of a half-edge; and how far from each other its control points
    /// are.
    #[inline]
    fn corner<const K: usize>(&self, h: HalfEdge) -> ([[T; N]; K], T) {
        let layout = self.sampler.layout();
        let (patch, corner) = corner_of(layout.table, layout.is_triangle(), h);
        let plan = layout.table.patch_plan(patch).expect("owners are no holes");
        let row: &CornerRow<T> = self.patterns.corner(plan, corner);
        let (ring, control) = (layout.table.ring(patch), self.sampler.surface().points());
        let base = control[ring[0] as usize];
        let mut sums = [[T::default(); N]; K];
        let mut extent = T::default();
        for &(p, weights) in row {
            let point = control[ring[p as usize] as usize];
            for c in 0..N {
                let x = point[c] - base[c];
                let size = if x > T::default() { x } else { T::default() - x };
                extent = if size > extent { size } else { extent };
                for k in 0..K {
                    sums[k][c] = sums[k][c] + weights[k] * x;
                }
            }
        }
        for c in 0..N {
            sums[0][c] = base[c] + sums[0][c];
        }
        (sums, extent)
    }

    fn chunk(&self, mut task: Task<'_, T, N>, scratch: &mut Scratch<T, N>) {
        let layout = self.sampler.layout();
        let (table, is_triangle) = (layout.table, layout.is_triangle());
        let before = [layout.edge_range(&task.faces).start, layout.face_range(&task.faces).start];
        for face in task.faces.clone().map(Face).filter(|&f| !table.topology().is_hole(f)) {
            if table.subfaces(face) > 1 {
                self.polygon(face, before, &mut task, scratch);
                continue;
            }
            let patch = table.patch(face, 0);
            let (owned, turn) = (layout.owned(patch), table.turn(patch));
            let samples = self.patch(face, 0, turned_sides(is_triangle, owned, turn), scratch);
            let turned = (turn > 0).then(|| self.patterns.turned_inside(false, turn));
            scratch.copy_inside(samples, turned, &mut task.inside, layout.face_first(face) - before[1]);
            if owned != 0 {
                // Edges come in the order of their owners.
                let first = table.topology().half_edge(face, owned.trailing_zeros() as usize);
                let mut at = layout.edge_first(table.topology().edge(first)) - before[0];
                for s in (0..4u8).filter(|s| owned & grid::side(*s) != 0) {
                    let own = turned_sides(is_triangle, grid::side(s), turn).trailing_zeros();
                    at += scratch.copy(samples.side(own as usize), &mut task.edges, at);
                }
            }
        }
    }

    /// The sub-faces of a face that is no quad.
    fn polygon(&self, face: Face, before: [usize; 2], task: &mut Task<'_, T, N>, scratch: &mut Scratch<T, N>) {
        let layout = self.sampler.layout();
        let t = layout.table.topology();
        let subfaces = layout.table.subfaces(face);
        let cells = layout.cells[1] as usize;
        // The centre, the points inside spokes, then those inside sub-faces.
        let centre = layout.face_first(face) - before[1];
        let mut inside_at = centre + 1 + subfaces as usize * (cells - 1);
        for subface in 0..subfaces {
            let owned = layout.owned(layout.table.patch(face, subface));
            let (out, back) = (owned & grid::side(0) != 0, owned & grid::side(3) != 0);
            let mut parts = owned | grid::side(1);
            parts |= if out { grid::corner(1) } else { 0 } | if subface == 0 { grid::corner(2) } else { 0 };
            let samples = self.patch(face, subface, parts, scratch);
            if subface == 0 {
                scratch.copy(samples.corner(2)..samples.corner(2) + 1, &mut task.inside, centre);
            }
            let spoke = centre + 1 + subface as usize * (cells - 1);
            scratch.copy(samples.side(1), &mut task.inside, spoke);
            inside_at += scratch.copy_inside(samples, None, &mut task.inside, inside_at);
            let h = t.half_edge(face, subface as usize);
            let first = |h: HalfEdge| layout.edge_first(t.edge(h)) - before[0];
            if out {
                let at = first(h);
                scratch.copy(samples.side(0), &mut task.edges, at);
                scratch.copy(samples.corner(1)..samples.corner(1) + 1, &mut task.edges, at + cells - 1);
            }
            if back {
                scratch.copy(samples.side(3), &mut task.edges, first(t.prev(h)) + cells);
            }
        }
    }

    /// Evaluates the wanted parts of a patch into the thread's own memory.
    fn patch(&self, face: Face, subface: u32, parts: Parts, scratch: &mut Scratch<T, N>) -> &GridSamples {
        let table = self.sampler.layout().table;
        let patch = table.patch(face, subface);
        let turn = table.turn(patch);
        let pattern = self.patterns.of_patch(patch);
        let samples = pattern.map_or_else(|| self.patterns.all(table.subfaces(face) > 1), |p| &p.samples);
        scratch.resize(samples.blocks(), self.sampler.with_normals());
        let at = |s: usize| {
            let [u, v] = samples.uv_in_face(s, turn);
            Location { face, subface, u, v }
        };
        let Some(pattern) = pattern else {
            for s in (0..samples.len()).filter(|s| samples.uses(s / LANES, parts)) {
                let (point, normal) = self.sampler.single(at(s));
                scratch.points[s] = round(point);
                if let Some(n) = scratch.normals.get_mut(s) {
                    *n = round(normal);
                }
            }
            return samples;
        };
        let control = self.sampler.surface().points();
        let ring = table.ring(patch);
        let base = control[ring[0] as usize];
        scratch.ring.clear();
        scratch.ring.extend(ring.iter().map(|&v| {
            let p = &control[v as usize];
            std::array::from_fn::<T, N, _>(|c| p[c] - base[c])
        }));
        let unsure = scratch.apply(pattern, parts, base);
        if unsure {
            for s in (0..samples.len()).filter(|&s| samples.uses(s / LANES, parts)) {
                if scratch.unsure[s / LANES] >> (s % LANES) & 1 != 0 {
                    scratch.normals[s] = round(self.sampler.single(at(s)).1);
                }
            }
        }
        samples
    }
}

impl<T: Real, const N: usize> Default for Scratch<T, N> {
    fn default() -> Self {
        Self { ring: Vec::new(), points: Vec::new(), normals: Vec::new(), unsure: Vec::new() }
    }
}

impl<T: Real, const N: usize> Scratch<T, N> {
    /// Makes room for this many blocks.
    fn resize(&mut self, blocks: usize, normals: bool) {
        if self.points.len() < blocks * LANES {
            self.points.resize(blocks * LANES, [T::default(); N]);
            self.normals.resize(if normals { blocks * LANES } else { 0 }, [T::default(); 3]);
            self.unsure.resize(blocks, 0);
        }
    }

    /// Weights times the ring at hand; true where some normal is to be had otherwise.
    fn apply(&mut self, pattern: &Pattern<T>, parts: Parts, base: [T; N]) -> bool {
        let wanted = |b: usize| pattern.samples.uses(b, parts);
        pattern.rows[0].apply_some(&self.ring, base, wanted, &mut self.points);
        let [_, u, v] = &pattern.rows[..] else { return false };
        kernel::normals([u, v], &self.ring, wanted, &mut self.normals, &mut self.unsure)
    }

    /// Copies a run of samples to `at`; gives back their number.
    fn copy(&self, run: Range<usize>, out: &mut Output<'_, T, N>, at: usize) -> usize {
        let count = run.len();
        out.points[at..at + count].copy_from_slice(&self.points[run.clone()]);
        if !out.normals.is_empty() {
            out.normals[at..at + count].copy_from_slice(&self.normals[run]);
        }
        count
    }

    /// Copies the samples inside a patch, whose face may be turned against its plan.
    fn copy_inside(
        &self,
        samples: &GridSamples,
        turned: Option<&[u32]>,
        out: &mut Output<'_, T, N>,
        at: usize,
    ) -> usize {
        let count = samples.inside();
        let Some(turned) = turned else { return self.copy(0..count, out, at) };
        for (out, &s) in out.points[at..at + count].iter_mut().zip(turned) {
            *out = self.points[s as usize];
        }
        if !out.normals.is_empty() {
            for (out, &s) in out.normals[at..at + count].iter_mut().zip(turned) {
                *out = self.normals[s as usize];
            }
        }
        count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limit::PatchTable;
    use crate::scheme::Scheme;
    use crate::shapes;
    use crate::tessellate::layout::{Layout, PatchRates};
    use crate::tessellate::sample::NormalOf;

    #[test]
    fn without_memory_for_patterns_the_samples_are_the_same() {
        let triangles = shapes::all_triangles().into_iter().map(|s| (s, Scheme::Loop));
        for (shape, scheme) in shapes::all().into_iter().map(|s| (s, Scheme::CatmullClark)).chain(triangles) {
            let table = PatchTable::new(&shape.mesh, scheme).unwrap();
            let subfaces = |p: usize| {
                (0..shape.mesh.face_count() as u32).any(|f| {
                    let f = Face(f);
                    table.subfaces(f) > 1
                        && (table.patch(f, 0)..table.patch(f, 0) + table.subfaces(f) as usize).contains(&p)
                })
            };
            let patch = (0..table.patch_count()).map(|p| if subfaces(p) { [3; 2] } else { [6; 2] }).collect();
            let layout = Layout::new(&table, PatchRates { edge: vec![6; table.topology().edge_count()], patch });
            let sampler = Sampler::new(table.surface(&shape.positions), &layout, Some(NormalOf::SPACE));
            let evaluate = |bytes: [usize; 2]| {
                let patterns = Patterns::within(&layout, Some(&Sides::default()), bytes);
                let (mut points, mut normals) = (vec![[0.0; 3]; layout.points()], vec![[0.0; 3]; layout.points()]);
                let out = Output { points: &mut points, normals: &mut normals };
                Evaluator { patterns: &patterns, sampler }.evaluate(out);
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
