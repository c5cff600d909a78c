//! Weights of points of a grid over a plan: what tessellations with one rate are made of.
//!
//! The way goes down the patch tree once for all points. Every node's control points are held as dense rows over the plan's
//! ring, eight numbers to a vector; a step of refinement makes the rows of its children from them, and points go to the child
//! that holds them. At a leaf, rows are summed with the leaf's basis: where that is a product of two curves, one
//! direction after the other.
//!
//! Derivatives stay in the parameters of the leaf where they were made; how these lie in the face comes down with the
//! points. Rings of more than [`MOST_RING`] points, linear leaves, semi-sharp creases under Loop and ends on boundaries
//! that are kept linear go through [`Plan::weights`], point by point.

use super::grid::Grid;
use super::leaf_basis::{Basis, LeafBases};
use super::sub_patches::Pose;
use super::{Body, Leaf, LeafShape, Link, Plan, Plans, Points, Split};
use crate::kernel::{LANES, SurfaceMatrix, vectorized};
use crate::limit::bspline::cubic;
use crate::limit::rows::Rows;
use crate::limit::single_crease;
use crate::limit::special::PointWeights;
use crate::real::Real;
use crate::scheme::SplitKind;

/// Numbers of a vector of `f64`; rows are filled up to a multiple.
const WIDTH: usize = 8;

/// Largest ring whose rows are dense, of 128 KiB. Larger: memory, and time for rows of zeros; smaller: more plans point by point.
const MOST_RING: usize = 128;

/// Makes the weights of plans on a grid: of position, and of `∂u`, `∂v` where three are wanted. At special vertices
/// derivatives are vectors that span the tangent plane, zeros where there is none.
pub(crate) struct GridMaker<'a> {
    plans: &'a Plans,
    grid: Grid,
    count: usize,
    /// Curve weights at all lines of the grid.
    cubic: Vec<[[f64; 4]; 3]>,
    bases: LeafBases,
}

/// Memory that is used again.
#[derive(Default)]
pub(crate) struct GridScratch {
    matrices: Vec<Vec<[f64; WIDTH]>>,
    lists: Vec<Vec<Sample>>,
    needed: Vec<u32>,
    is_made: Vec<bool>,
}

/// A grid point in the parameters of a node, and its number among those that are wanted.
#[derive(Clone, Copy)]
struct Sample {
    number: u32,
    at: [u32; 2],
}

/// Control points of a node or leaf over the plan's ring: some rows of a matrix.
#[derive(Clone, Copy)]
struct Control<'m> {
    matrix: &'m [[f64; WIDTH]],
    /// Which rows; all where there is no list.
    some: Option<&'m [u32]>,
    /// How the parameters lie in the face.
    jacobian: Jacobian,
    /// How many times the face has been halved.
    depth: u32,
}

impl Control<'_> {
    #[inline(always)]
    fn row(&self, i: u32) -> usize {
        match self.some {
            Some(rows) => rows[i as usize] as usize,
            None => i as usize,
        }
    }
}

/// `∂s/∂u ∂t/∂u`, `∂s/∂v ∂t/∂v`.
type Jacobian = [[f64; 2]; 2];

/// Where the weights of a plan go.
struct Target<'o, T> {
    out: &'o mut SurfaceMatrix<T>,
    ring: usize,
    /// Vectors to a row.
    chunks: usize,
}

impl<'a> GridMaker<'a> {
    /// For a grid of `cells` facets a side, and `count` weights, 1 or 3.
    pub fn new(plans: &'a Plans, cells: u32, count: usize) -> Self {
        let at = |i: u32| cubic(f64::from(i) / f64::from(cells));
        let grid = Grid { cells, split: plans.split };
        Self { plans, grid, count, cubic: (0..=cells).map(at).collect(), bases: LeafBases::new(grid, count) }
    }

    /// Facets a side.
    pub fn cells(&self) -> u32 {
        self.grid.cells
    }

    /// Writes the weights of a plan at some grid points, rounded to `T`.
    pub fn fill<T: Real>(
        &self,
        plan: usize,
        points: impl ExactSizeIterator<Item = [u32; 2]>,
        scratch: &mut GridScratch,
        out: &mut SurfaceMatrix<T>,
    ) {
        let plan = self.plans.get(plan);
        let ring = plan.ring();
        out.resize(points.len(), ring, self.count);
        let mut samples = scratch.lists.pop().unwrap_or_default();
        samples.clear();
        samples.extend((0..).zip(points).map(|(number, at)| Sample { number, at }));
        let mut target = Target { out, ring, chunks: ring.div_ceil(WIDTH) };
        let whole = [[1.0, 0.0], [0.0, 1.0]];
        if ring > MOST_RING {
            for &sample in &samples {
                let rows = self.single(plan.start, sample);
                target.put([0, 1, 2].map(|k| &rows[k][..]), 0, ring, sample.number, whole, self.count);
            }
        } else {
            let mut identity = scratch.matrices.pop().unwrap_or_default();
            identity.clear();
            identity.resize(ring * target.chunks, [0.0; WIDTH]);
            (0..ring).for_each(|p| identity[p * target.chunks + p / WIDTH][p % WIDTH] = 1.0);
            let control = Control { matrix: &identity, some: None, jacobian: whole, depth: 0 };
            self.node(plan.start, control, &samples, scratch, &mut target);
            scratch.matrices.push(identity);
        }
        scratch.lists.push(samples);
    }

    /// The weights of samples in a node.
    fn node<T: Real>(
        &self,
        link: Link,
        control: Control<'_>,
        samples: &[Sample],
        scratch: &mut GridScratch,
        target: &mut Target<'_, T>,
    ) {
        match &self.plans.nodes[link.node as usize].body {
            Body::Leaf(leaf) => self.leaf(leaf, link, control, samples, scratch, target),
            // There the way down does not end. So deep, no two grid points lie in a node.
            Body::Split(split) if split.ends.is_some() && 1u64 << control.depth > u64::from(self.grid.cells) => {
                self.singly(link, control, samples, target);
            }
            Body::Split(split) => self.split(split, link, control, samples, scratch, target),
        }
    }

    fn split<T: Real>(
        &self,
        split: &Split,
        link: Link,
        control: Control<'_>,
        samples: &[Sample],
        scratch: &mut GridScratch,
        target: &mut Target<'_, T>,
    ) {
        let halved = split.children.len() > 1;
        // The samples of every child, in its parameters.
        let mut lists: [Vec<Sample>; 4] = Default::default();
        for list in &mut lists[..split.children.len()] {
            *list = scratch.lists.pop().unwrap_or_default();
            list.clear();
        }
        for &Sample { number, at } in samples {
            let (child, below) = match halved {
                true => {
                    let child = self.grid.child_of(at);
                    (child, self.grid.in_child(child, at))
                }
                false => (0, at),
            };
            lists[child].push(Sample { number, at: self.grid.turned(below, split.children[child].turn) });
        }
        // The refined points that these children need.
        let mut matrix = scratch.matrices.pop().unwrap_or_default();
        let GridScratch { needed, is_made, .. } = scratch;
        needed.clear();
        is_made.clear();
        is_made.resize(split.points.len(), false);
        for (child, _) in split.children.iter().zip(&lists).filter(|(_, list)| !list.is_empty()) {
            for &point in &child.ring[..] {
                if !std::mem::replace(&mut is_made[point as usize], true) {
                    needed.push(point);
                }
            }
        }
        matrix.resize(split.points.len() * target.chunks, [0.0; WIDTH]);
        refine(control, &split.points, needed, target.chunks, &mut matrix);
        for (number, (child, list)) in split.children.iter().zip(&lists).enumerate() {
            if list.is_empty() {
                continue;
            }
            let flip = if number == 3 && self.grid.split == SplitKind::Triangles { -1.0 } else { 1.0 };
            let speed = if halved { 2.0 * flip } else { 1.0 };
            let pose = Pose { turn: child.turn, speed: [speed; 2] };
            let jacobian = product(control.jacobian, pose.jacobian(self.grid.split));
            let control = Control {
                matrix: &matrix,
                some: Some(&child.ring),
                jacobian,
                depth: control.depth + u32::from(halved),
            };
            self.node(child.link(link.raise), control, list, scratch, target);
        }
        scratch.lists.extend(lists);
        scratch.matrices.push(matrix);
    }

    fn leaf<T: Real>(
        &self,
        leaf: &Leaf,
        link: Link,
        control: Control<'_>,
        samples: &[Sample],
        scratch: &mut GridScratch,
        target: &mut Target<'_, T>,
    ) {
        let (turn, sharpness, basis) = match (&leaf.shape, self.grid.split) {
            _ if !leaf.creases.is_empty() => return self.singly(link, control, samples, target),
            (LeafShape::Linear, _) => return self.singly(link, control, samples, target),
            (LeafShape::Regular, SplitKind::Quads) => (0, None, None),
            (LeafShape::Regular, SplitKind::Triangles) => (0, None, Some(self.bases.of(None))),
            (LeafShape::SingleCrease { turn, sharpness }, _) => (*turn, Some(sharpness + f64::from(link.raise)), None),
            (LeafShape::Special { turn, vertex }, _) => (*turn, None, Some(self.bases.of(Some(vertex)))),
        };
        let mut matrix = scratch.matrices.pop().unwrap_or_default();
        let mut turned = scratch.lists.pop().unwrap_or_default();
        matrix.resize(leaf.points.len() * target.chunks, [0.0; WIDTH]);
        combine(control, &leaf.points, target.chunks, &mut matrix);
        turned.clear();
        turned.extend(samples.iter().map(|s| Sample { at: self.grid.turned(s.at, turn), ..*s }));
        let jacobian = product(control.jacobian, Pose { turn, speed: [1.0; 2] }.jacobian(self.grid.split));
        let own = Control { matrix: &matrix, some: None, jacobian, depth: control.depth };
        match basis {
            Some(basis) => self.by_point(&basis, own, &turned, target),
            None => {
                let curve = |j: u32| match sharpness {
                    Some(sharpness) => single_crease::curve(1.0 - f64::from(j) / f64::from(self.grid.cells), sharpness),
                    None => self.cubic[j as usize],
                };
                turned.sort_by_key(|sample| sample.at[1]);
                self.by_curves(curve, own, &turned, target);
            }
        }
        scratch.lists.push(turned);
        scratch.matrices.push(matrix);
    }

    /// Samples of a leaf whose basis is a product of two curves, `across` being that in v; samples of equal v side by side.
    /// What has v in common is summed first, whichever samples are wanted, and the rest sample by sample.
    fn by_curves<T: Real>(
        &self,
        across: impl Fn(u32) -> [[f64; 4]; 3],
        control: Control<'_>,
        samples: &[Sample],
        target: &mut Target<'_, T>,
    ) {
        for run in samples.chunk_by(|a, b| a.at[1] == b.at[1]) {
            let outer = across(run[0].at[1]);
            for chunk in (0..target.chunks).step_by(2) {
                let two = chunk + 1 < target.chunks;
                vectorized(
                    #[inline(always)]
                    || match (two, self.count) {
                        (true, 1) => run_of::<T, 2, 1>(run, &outer, &self.cubic, control, chunk, target),
                        (true, _) => run_of::<T, 2, 3>(run, &outer, &self.cubic, control, chunk, target),
                        (false, 1) => run_of::<T, 1, 1>(run, &outer, &self.cubic, control, chunk, target),
                        (false, _) => run_of::<T, 1, 3>(run, &outer, &self.cubic, control, chunk, target),
                    },
                );
            }
        }
    }

    /// Samples of a leaf with any basis.
    fn by_point<T: Real>(
        &self,
        basis: &Basis<'_>,
        control: Control<'_>,
        samples: &[Sample],
        target: &mut Target<'_, T>,
    ) {
        for sample in samples {
            basis.with(sample.at, |weights| {
                vectorized(
                    #[inline(always)]
                    || {
                        for chunk in 0..target.chunks {
                            let mut rows = [[[0.0; WIDTH]; 1]; 3];
                            for order in 0..self.count {
                                let weights = weights[order].iter().enumerate();
                                for (i, &w) in weights {
                                    add(&mut rows[order][0], w, &control.matrix[i * target.chunks + chunk]);
                                }
                            }
                            put_chunks(&rows, chunk, sample.number, control.jacobian, self.count, target);
                        }
                    },
                );
            });
        }
    }

    /// Samples of a node one by one.
    fn singly<T: Real>(&self, link: Link, control: Control<'_>, samples: &[Sample], target: &mut Target<'_, T>) {
        for &sample in samples {
            let weights = self.single(link, sample);
            for chunk in 0..target.chunks {
                let mut rows = [[[0.0; WIDTH]; 1]; 3];
                for (rows, weights) in rows.iter_mut().zip(&weights).take(self.count) {
                    for (i, &w) in (0..).zip(weights) {
                        add(&mut rows[0], w, &control.matrix[control.row(i) * target.chunks + chunk]);
                    }
                }
                put_chunks(&rows, chunk, sample.number, control.jacobian, self.count, target);
            }
        }
    }

    /// Weights over the points of a node.
    fn single(&self, link: Link, sample: Sample) -> [Vec<f64>; 3] {
        let plan = Plan { plans: self.plans, number: usize::MAX, start: link };
        let [u, v] = self.grid.uv(sample.at);
        spanning(plan.weights(u, v, 0, self.count), plan.ring())
    }
}

impl Plan<'_> {
    /// Weights over the ring of position at `(u, v)` and of two vectors that span the tangent plane there, zeros where there
    /// is none.
    pub fn spanning_weights(self, u: f64, v: f64) -> [Vec<f64>; 3] {
        spanning(self.weights(u, v, 0, 3), self.ring())
    }
}

/// Weights of position and of two vectors that span the tangent plane.
pub(super) fn spanning(weights: PointWeights, points: usize) -> [Vec<f64>; 3] {
    let [position, du, dv, ..] = weights.rows;
    match weights.at_vertex {
        None => [position, du, dv],
        Some(at) => {
            let [a, b] = at.plane.unwrap_or_else(|| [0, 1].map(|_| vec![0.0; points]));
            [position, a, b]
        }
    }
}

fn product(a: Jacobian, b: Jacobian) -> Jacobian {
    let entry = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j];
    [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
}

#[inline(always)]
fn add(sum: &mut [f64; WIDTH], w: f64, row: &[f64; WIDTH]) {
    for l in 0..WIDTH {
        sum[l] += w * row[l];
    }
}

/// Some refined points over the ring.
fn refine(control: Control<'_>, points: &Points, some: &[u32], chunks: usize, out: &mut [[f64; WIDTH]]) {
    vectorized(
        #[inline(always)]
        || {
            for &point in some {
                let (rows, i) = points.of(point as usize);
                sum_terms(control, rows, i, chunks, &mut out[point as usize * chunks..]);
            }
        },
    );
}

/// All points of some rows over the ring.
fn combine(control: Control<'_>, rows: &Rows, chunks: usize, out: &mut [[f64; WIDTH]]) {
    vectorized(
        #[inline(always)]
        || {
            for i in 0..rows.len() {
                sum_terms(control, rows, i, chunks, &mut out[i * chunks..]);
            }
        },
    );
}

#[inline(always)]
fn sum_terms(control: Control<'_>, rows: &Rows, i: usize, chunks: usize, out: &mut [[f64; WIDTH]]) {
    let (columns, weights) = rows.terms(i);
    let mut chunk = 0;
    while chunk < chunks {
        // Some vectors at once, so that terms are read less often.
        if chunk + 3 <= chunks {
            let sums = terms_of::<3>(control, columns, weights, chunks, chunk);
            out[chunk..chunk + 3].copy_from_slice(&sums);
            chunk += 3;
        } else {
            out[chunk] = terms_of::<1>(control, columns, weights, chunks, chunk)[0];
            chunk += 1;
        }
    }
}

#[inline(always)]
fn terms_of<const K: usize>(
    control: Control<'_>,
    columns: &[u32],
    weights: &[f64],
    chunks: usize,
    chunk: usize,
) -> [[f64; WIDTH]; K] {
    let mut sums = [[0.0; WIDTH]; K];
    for (&c, &w) in columns.iter().zip(weights) {
        let at = control.row(c) * chunks + chunk;
        let from = &control.matrix[at..at + K];
        for k in 0..K {
            add(&mut sums[k], w, &from[k]);
        }
    }
    sums
}

/// Samples of equal v, `outer` being the weights there and `inner` those at all lines of equal u: `K` vectors of their rows.
#[inline(always)]
fn run_of<T: Real, const K: usize, const COUNT: usize>(
    run: &[Sample],
    outer: &[[f64; 4]; 3],
    inner: &[[[f64; 4]; 3]],
    control: Control<'_>,
    chunk: usize,
    target: &mut Target<'_, T>,
) {
    // Control points of the curve along the run, and of its derivative across.
    let mut line = [[[[0.0; WIDTH]; K]; 4]; 2];
    for x in 0..4 {
        for y in 0..4 {
            let from = &control.matrix[(4 * y + x) * target.chunks + chunk..][..K];
            for k in 0..K {
                add(&mut line[0][x][k], outer[0][y], &from[k]);
                if COUNT == 3 {
                    add(&mut line[1][x][k], outer[1][y], &from[k]);
                }
            }
        }
    }
    for sample in run {
        let inner = &inner[sample.at[0] as usize];
        let mut rows = [[[0.0; WIDTH]; K]; 3];
        for x in 0..4 {
            for k in 0..K {
                add(&mut rows[0][k], inner[0][x], &line[0][x][k]);
                if COUNT == 3 {
                    add(&mut rows[1][k], inner[1][x], &line[0][x][k]);
                    add(&mut rows[2][k], inner[0][x], &line[1][x][k]);
                }
            }
        }
        put_chunks(&rows, chunk, sample.number, control.jacobian, COUNT, target);
    }
}

/// Writes some vectors of the rows of a sample.
#[inline(always)]
fn put_chunks<T: Real, const K: usize>(
    rows: &[[[f64; WIDTH]; K]; 3],
    chunk: usize,
    number: u32,
    jacobian: Jacobian,
    count: usize,
    target: &mut Target<'_, T>,
) {
    let first = chunk * WIDTH;
    let len = (target.ring - first).min(K * WIDTH);
    target.put(
        [rows[0].as_flattened(), rows[1].as_flattened(), rows[2].as_flattened()],
        first,
        len,
        number,
        jacobian,
        count,
    );
}

impl<T: Real> Target<'_, T> {
    /// Writes the weights of `len` points of the ring from `first` on.
    #[inline(always)]
    fn put(&mut self, rows: [&[f64]; 3], first: usize, len: usize, number: u32, jacobian: Jacobian, count: usize) {
        let (block, lane) = (number as usize / LANES, number as usize % LANES);
        let out = &mut self.out.block_mut(block)[first * count..(first + len) * count];
        if count == 1 {
            for (out, &w) in out.iter_mut().zip(rows[0]) {
                out[lane] = T::from_f64(w);
            }
            return;
        }
        let [u, v] = jacobian;
        let (position, s, t) = (&rows[0][..len], &rows[1][..len], &rows[2][..len]);
        for (p, out) in out.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            out[0][lane] = T::from_f64(position[p]);
            out[1][lane] = T::from_f64(u[0] * s[p] + u[1] * t[p]);
            out[2][lane] = T::from_f64(v[0] * s[p] + v[1] * t[p]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limit::PatchTable;
    use crate::scheme::Scheme;
    use crate::shapes::{self, Shape};

    fn agrees(shape: &Shape, scheme: Scheme, cells: u32) {
        let table = PatchTable::new(&shape.mesh, scheme).unwrap();
        let maker = GridMaker::new(table.plans(), cells, 3);
        let positions = GridMaker::new(table.plans(), cells, 1);
        let points: Vec<[u32; 2]> = (0..=cells).flat_map(|j| (0..=cells).map(move |i| [i, j])).collect();
        let is_inside = |p: &[u32; 2]| maker.grid.split == SplitKind::Quads || p[0] + p[1] <= cells;
        let points: Vec<[u32; 2]> = points.into_iter().filter(is_inside).collect();
        let mut scratch = GridScratch::default();
        let [mut matrix, mut of_position] = [0; 2].map(|_| SurfaceMatrix::<f64>::default());
        for plan in 0..table.plan_count() {
            maker.fill(plan, points.iter().copied(), &mut scratch, &mut matrix);
            positions.fill(plan, points.iter().copied(), &mut scratch, &mut of_position);
            let plan = table.plan(plan);
            for (k, &point) in points.iter().enumerate() {
                let [u, v] = maker.grid.uv(point);
                let single = plan.weights(u, v, 0, 3);
                let plane = single.at_vertex.as_ref().map(|at| &at.plane);
                for p in 0..plan.ring() {
                    for order in 0..3 {
                        let ours = matrix.block_mut(k / LANES)[3 * p + order][k % LANES];
                        if order == 0 {
                            assert_eq!(ours, of_position.block_mut(k / LANES)[p][k % LANES], "{}", shape.name);
                        }
                        let row = match (&plane, order) {
                            (Some(None), 1..) => &vec![0.0; plan.ring()],
                            // Vectors that span the plane may have any length.
                            (Some(Some(_)), 1..) => continue,
                            _ => &single.rows[order],
                        };
                        let size = row.iter().fold(1.0, |m: f64, w| m.max(w.abs()));
                        // A hundred products; each level of a patch tree, up to twelve with creases, doubles what single
                        // locations lose of a derivative.
                        let rounding = 100.0 * f64::EPSILON * if order > 0 { 4096.0 } else { 1.0 };
                        let off = (ours - row[p]).abs();
                        assert!(off <= rounding * size, "{} {cells} at {point:?}, order {order}: {off:e}", shape.name);
                    }
                }
            }
        }
    }

    #[test]
    fn weights_on_a_grid_are_those_of_single_locations() {
        for cells in [1, 3, 8, 20] {
            for shape in shapes::all() {
                agrees(&shape, Scheme::CatmullClark, cells);
                agrees(&shape, Scheme::Bilinear, cells);
            }
            shapes::all_triangles().iter().for_each(|shape| agrees(shape, Scheme::Loop, cells));
        }
    }
}
