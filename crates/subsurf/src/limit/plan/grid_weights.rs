//! Weights of all points of a grid over many plans at once.
//!
//! A node's weights are those of its children times the refined points: `W_node = Σ W_child · S_child`. They are formed from
//! the leaves up, so that what plans have in common is multiplied once, and in columns: for every control point a run of
//! numbers, one per grid point and order of differentiation, to which sparse rows add multiples of other runs. At the leaves stand
//! the spline bases, curves along creases and closed forms at special vertices, once for all leaves that look alike.
//!
//! Derivatives stay in the parameters of the leaf where they were made; how these lie in the face goes with every point.

use super::lattice::{Grid, Lattice};
use super::sub_patches::Pose;
use super::{Body, LeafShape, Link, Plan, Plans, Points};
use crate::kernel::{LANES, SurfaceMatrix, vectorized};
use crate::limit::box_spline;
use crate::limit::bspline::{cubic, tensor};
use crate::limit::corner::Corner;
use crate::limit::plan_key::KeyHasher;
use crate::limit::rows;
use crate::limit::single_crease;
use crate::limit::special::{PointWeights, SpecialVertex};
use crate::real::Real;
use crate::scheme::SplitKind;
use rayon::prelude::*;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

/// Runs of numbers are filled up to a multiple of this: one 512-bit vector of `f64`.
const WIDTH: usize = 8;

/// Weights of position, and of two derivatives if they are wanted, at the points of a grid over one plan.
pub(crate) struct GridWeights {
    grid: Grid,
    count: usize,
    columns: Columns,
}

/// Weights of some points over the points of a node.
struct Columns {
    /// By control point, `width` numbers.
    weights: Vec<f64>,
    width: usize,
    /// By grid point, where its numbers lie in a run, and how the parameters of its derivatives lie in those of the node.
    places: Vec<Place>,
}

#[derive(Clone, Copy)]
struct Place {
    at: u32,
    /// `∂s/∂u ∂t/∂u`, `∂s/∂v ∂t/∂v`.
    jacobian: [[f64; 2]; 2],
}

/// What weights are of.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Part {
    Node(Link),
    /// A spline patch, over its own control points.
    Regular,
    /// A patch along a crease of this sharpness, as bits.
    SingleCrease(u64),
    Special(Corner),
}

/// A part at some points of the grid.
struct Job<'a> {
    part: Part,
    lattice: Lattice,
    vertex: Option<&'a SpecialVertex>,
    /// What it is made of; nothing where its weights are made point by point.
    sources: Vec<Source<'a>>,
}

/// Another part that some points of a job lie in.
struct Source<'a> {
    job: usize,
    lattice: Lattice,
    /// Number of the child, if halving leads to it.
    child: Option<usize>,
    turn: u8,
    points: Rows<'a>,
}

/// Control points of a part as rows over those of the job.
enum Rows<'a> {
    OfLeaf(&'a rows::Rows),
    /// Some of the refined points.
    OfChild(&'a Points, &'a [u32]),
}

impl Source<'_> {
    /// Its control point `i` over the control points of the job.
    #[inline(always)]
    fn row(&self, i: usize) -> impl Iterator<Item = (u32, f64)> {
        let (rows, i) = match self.points {
            Rows::OfLeaf(rows) => (rows, i),
            Rows::OfChild(points, some) => points.of(some[i] as usize),
        };
        rows.row(i)
    }
}

/// Memory that is used again.
#[derive(Default)]
struct Scratch {
    run: Vec<f64>,
    /// By source, where the numbers of its points are.
    taken: [Vec<u32>; 4],
    /// Source of every point.
    chosen: Vec<u8>,
}

type Numbers = HashMap<(Part, Lattice), Option<usize>, BuildHasherDefault<KeyHasher>>;

/// All jobs, those of which others are made before these; `height` says how many rounds come before.
struct Jobs<'a> {
    plans: &'a Plans,
    grid: Grid,
    list: Vec<Job<'a>>,
    height: Vec<u32>,
    numbers: Numbers,
}

impl Plans {
    /// Calls `with` with the weights of each of some plans at all points of a grid of `cells` facets a side, in parallel; of
    /// position, and of `∂u`, `∂v` if `count` is 3. At special vertices derivatives are vectors that span the tangent plane,
    /// zeros where there is none.
    pub fn grid_weights<R: Send>(
        &self,
        plans: &[usize],
        cells: u32,
        count: usize,
        with: impl Fn(usize, &GridWeights) -> R + Sync,
    ) -> Vec<R> {
        let grid = Grid { cells, split: self.split };
        let mut jobs = Jobs { plans: self, grid, list: Vec::new(), height: Vec::new(), numbers: Numbers::default() };
        let roots: Vec<usize> =
            plans.iter().map(|&plan| jobs.add(Part::Node(self.plans[plan]), Lattice::WHOLE, None)).collect();
        let mut rounds: Vec<Vec<usize>> = Vec::new();
        let mut is_part = vec![false; jobs.list.len()];
        jobs.list.iter().flat_map(|job| &job.sources).for_each(|source| is_part[source.job] = true);
        for (number, &height) in jobs.height.iter().enumerate().filter(|(number, _)| is_part[*number]) {
            rounds.resize((height as usize + 1).max(rounds.len()), Vec::new());
            rounds[height as usize].push(number);
        }
        let mut done: Vec<Option<Columns>> = jobs.list.iter().map(|_| None).collect();
        for round in rounds {
            let made: Vec<Columns> = round
                .par_iter()
                .map_init(Scratch::default, |scratch, &number| jobs.columns(number, count, &done, scratch))
                .collect();
            round.iter().zip(made).for_each(|(&number, columns)| done[number] = Some(columns));
        }
        let each = roots.par_iter().enumerate();
        each.map_init(Scratch::default, |scratch, (i, &number)| {
            let columns = jobs.columns(number, count, &done, scratch);
            with(i, &GridWeights { grid, count, columns })
        })
        .collect()
    }
}

impl GridWeights {
    /// Weights of position, `∂u` and `∂v` at a grid point, control point by control point.
    pub fn rows(&self, point: [u32; 2]) -> impl Iterator<Item = [f64; 3]> {
        let Columns { weights, width, places } = &self.columns;
        let Place { at, jacobian: [u, v] } = places[self.grid.index(point)];
        weights.chunks_exact(*width).map(move |run| match &run[at as usize..at as usize + self.count] {
            &[position, s, t] => [position, u[0] * s + u[1] * t, v[0] * s + v[1] * t],
            of_position => [of_position[0], 0.0, 0.0],
        })
    }

    /// The weights of some grid points, rounded to `T`.
    pub fn matrix<T: Real>(&self, points: impl ExactSizeIterator<Item = [u32; 2]>) -> SurfaceMatrix<T> {
        let Columns { weights, width, places } = &self.columns;
        let mut out = SurfaceMatrix::zeros(points.len(), weights.len() / width, self.count);
        let (mut lanes, mut block) = ([places[0]; LANES], 0);
        let mut points = points.peekable();
        while points.peek().is_some() {
            for (lane, point) in lanes.iter_mut().zip(&mut points) {
                *lane = places[self.grid.index(point)];
            }
            let out = out.block_mut(block);
            vectorized(
                #[inline(always)]
                || match self.count {
                    1 => take(weights, *width, &lanes, out),
                    _ => take_three(weights, *width, &lanes, out),
                },
            );
            block += 1;
        }
        out
    }
}

/// One number of every run per lane.
#[inline(always)]
fn take<T: Real>(weights: &[f64], width: usize, lanes: &[Place; LANES], out: &mut [[T; LANES]]) {
    for (run, out) in weights.chunks_exact(width).zip(out) {
        for k in 0..LANES {
            out[k] = T::from_f64(run[lanes[k].at as usize]);
        }
    }
}

/// The same, and derivatives.
#[inline(always)]
fn take_three<T: Real>(weights: &[f64], width: usize, lanes: &[Place; LANES], out: &mut [[T; LANES]]) {
    let mut jacobian = [[0.0; LANES]; 4];
    for k in 0..LANES {
        let [u, v] = lanes[k].jacobian;
        (jacobian[0][k], jacobian[1][k], jacobian[2][k], jacobian[3][k]) = (u[0], u[1], v[0], v[1]);
    }
    for (run, out) in weights.chunks_exact(width).zip(out.as_chunks_mut::<3>().0) {
        let (mut s, mut t) = ([0.0; LANES], [0.0; LANES]);
        for k in 0..LANES {
            let at = lanes[k].at as usize;
            out[0][k] = T::from_f64(run[at]);
            (s[k], t[k]) = (run[at + 1], run[at + 2]);
        }
        for k in 0..LANES {
            out[1][k] = T::from_f64(jacobian[0][k] * s[k] + jacobian[1][k] * t[k]);
            out[2][k] = T::from_f64(jacobian[2][k] * s[k] + jacobian[3][k] * t[k]);
        }
    }
}

impl<'a> Jobs<'a> {
    /// The number of a part at some points, which it and all that it is made of gets here.
    fn add(&mut self, part: Part, lattice: Lattice, vertex: Option<&'a SpecialVertex>) -> usize {
        if let Some(&known) = self.numbers.get(&(part, lattice)) {
            return known.expect("the way down a patch tree does not lead back to the same points");
        }
        self.numbers.insert((part, lattice), None);
        let sources = match part {
            Part::Node(link) => self.sources(link, lattice),
            _ => Vec::new(),
        };
        let height = sources.iter().map(|source| self.height[source.job] + 1).max().unwrap_or(0);
        self.list.push(Job { part, lattice, vertex, sources });
        self.height.push(height);
        let number = self.list.len() - 1;
        self.numbers.insert((part, lattice), Some(number));
        number
    }

    /// What a node's weights are made of; nothing where they are made point by point.
    fn sources(&mut self, link: Link, lattice: Lattice) -> Vec<Source<'a>> {
        let grid = self.grid;
        match &self.plans.nodes[link.node as usize].body {
            Body::Leaf(leaf) => {
                let turned = |turn: u8| grid.lattice_turned(lattice, turn).expect("as many points as before");
                let (part, turn, vertex) = match &leaf.shape {
                    _ if !leaf.creases.is_empty() => return Vec::new(),
                    LeafShape::Linear => return Vec::new(),
                    LeafShape::Regular => (Part::Regular, 0, None),
                    LeafShape::SingleCrease { turn, sharpness } => {
                        (Part::SingleCrease((sharpness + f64::from(link.raise)).to_bits()), *turn, None)
                    }
                    LeafShape::Special { turn, vertex } => (Part::Special(vertex.corner), *turn, Some(&**vertex)),
                };
                let lattice = turned(turn);
                let job = self.add(part, lattice, vertex);
                vec![Source { job, lattice, child: None, turn, points: Rows::OfLeaf(&leaf.points) }]
            }
            // There the way down does not end.
            Body::Split(split) if split.ends.is_some() && grid.is_single(lattice) => Vec::new(),
            Body::Split(split) => {
                let halved = split.children.len() > 1;
                let children = split.children.iter().enumerate().filter_map(|(number, child)| {
                    let below = if halved { grid.lattice_in_child(lattice, number)? } else { lattice };
                    let lattice = grid.lattice_turned(below, child.turn)?;
                    let job = self.add(Part::Node(child.link(link.raise)), lattice, None);
                    let points = Rows::OfChild(&split.points, &child.ring);
                    Some(Source { job, lattice, child: halved.then_some(number), turn: child.turn, points })
                });
                children.collect()
            }
        }
    }

    /// The weights of a job, from those of the jobs that it is made of.
    fn columns(&self, number: usize, count: usize, done: &[Option<Columns>], scratch: &mut Scratch) -> Columns {
        let (grid, job) = (self.grid, &self.list[number]);
        let Part::Node(link) = job.part else { return self.basis(job, count) };
        let ring = self.plans.nodes[link.node as usize].ring;
        if job.sources.is_empty() {
            let plan = Plan { plans: self.plans, number: usize::MAX, start: link };
            return point_by_point(grid, job.lattice, count, ring, |[u, v]| plan.weights(u, v, 0, count));
        }
        // Which source every point comes from, and where its numbers are there.
        let Scratch { run, taken, chosen } = scratch;
        taken.iter_mut().for_each(Vec::clear);
        chosen.clear();
        let mut places = Vec::with_capacity(grid.len(job.lattice));
        for point in grid.points_of(job.lattice) {
            let child = grid.child_of(point);
            let number = job.sources.iter().position(|s| s.child.is_none_or(|own| own == child)).expect("some child");
            let source = &job.sources[number];
            let below = if source.child.is_some() { grid.in_child(child, point) } else { point };
            let at = grid.index_in(source.lattice, grid.turned(below, source.turn));
            let columns = done[source.job].as_ref().expect("made in an earlier round");
            let flip = if source.child == Some(3) && grid.split == SplitKind::Triangles { -1.0 } else { 1.0 };
            let speed = flip * if source.child.is_some() { 2.0 } else { 1.0 };
            let outer = Pose { turn: source.turn, speed: [speed; 2] }.jacobian(grid.split);
            let jacobian = product(outer, columns.places[at].jacobian);
            places.push(Place { at: (taken[number].len() * count) as u32, jacobian });
            taken[number].push(columns.places[at].at);
            chosen.push(number as u8);
        }
        // The points of a source lie side by side.
        let mut starts = [0; 4];
        let mut width = 0;
        for (start, taken) in starts.iter_mut().zip(&*taken) {
            *start = width;
            width += (taken.len() * count).next_multiple_of(WIDTH);
        }
        places.iter_mut().zip(chosen).for_each(|(place, number)| place.at += starts[usize::from(*number)] as u32);
        let mut weights = vec![0.0; ring * width];
        for ((source, taken), start) in job.sources.iter().zip(taken).zip(starts).filter(|(s, _)| !s.1.is_empty()) {
            let columns = done[source.job].as_ref().expect("made in an earlier round");
            vectorized(
                #[inline(always)]
                || match (count, taken.len() * count) {
                    (1, 1..=WIDTH) => add_short::<1>(source, columns, taken, &mut weights, [start, width]),
                    (3, 1..=WIDTH) => add_short::<3>(source, columns, taken, &mut weights, [start, width]),
                    _ => add_long(source, columns, taken, count, &mut weights, [start, width], run),
                },
            );
        }
        Columns { weights, width, places }
    }

    /// The weights of a part over its own control points.
    fn basis(&self, job: &Job<'_>, count: usize) -> Columns {
        let (grid, lattice) = (self.grid, job.lattice);
        let rows = |rows: [[f64; 16]; 6]| PointWeights { rows: rows.map(|row| row.to_vec()), at_vertex: None };
        match (job.part, job.vertex) {
            (Part::SingleCrease(sharpness), _) => {
                let sharpness = f64::from_bits(sharpness);
                point_by_point(grid, lattice, count, 16, |[u, v]| {
                    rows(tensor(&cubic(u), &single_crease::curve(1.0 - v, sharpness), count))
                })
            }
            (Part::Special(_), Some(vertex)) => {
                point_by_point(grid, lattice, count, vertex.points(), |[u, v]| vertex.weights(u, v, count))
            }
            _ if grid.split == SplitKind::Triangles => {
                point_by_point(grid, lattice, count, 12, |[u, v]| rows(box_spline::basis(u, v, count)))
            }
            _ => point_by_point(grid, lattice, count, 16, |[u, v]| rows(tensor(&cubic(u), &cubic(v), count))),
        }
    }
}

/// Adds the weights of a source's points, at `start` of every run of `width`.
#[inline(always)]
fn add_long(
    source: &Source<'_>,
    columns: &Columns,
    taken: &[u32],
    count: usize,
    weights: &mut [f64],
    [start, width]: [usize; 2],
    scratch: &mut Vec<f64>,
) {
    let length = (taken.len() * count).next_multiple_of(WIDTH);
    scratch.clear();
    scratch.resize(length, 0.0);
    for (i, run) in columns.weights.chunks_exact(columns.width).enumerate() {
        let mut any = false;
        for (to, &at) in scratch.chunks_exact_mut(count).zip(taken) {
            for k in 0..count {
                to[k] = run[at as usize + k];
                any |= to[k] != 0.0;
            }
        }
        if !any {
            continue;
        }
        for (c, w) in source.row(i) {
            let at = c as usize * width + start;
            let out = weights[at..at + length].as_chunks_mut::<WIDTH>().0;
            let from = scratch.as_chunks::<WIDTH>().0;
            for b in 0..out.len() {
                for k in 0..WIDTH {
                    out[b][k] += w * from[b][k];
                }
            }
        }
    }
}

/// The same for so few points that their numbers fit into one vector.
#[inline(always)]
fn add_short<const COUNT: usize>(
    source: &Source<'_>,
    columns: &Columns,
    taken: &[u32],
    weights: &mut [f64],
    [start, width]: [usize; 2],
) {
    let (runs, step) = (&mut weights.as_chunks_mut::<WIDTH>().0[start / WIDTH..], width / WIDTH);
    for (i, run) in columns.weights.chunks_exact(columns.width).enumerate() {
        let mut from = [0.0; WIDTH];
        let mut any = 0.0f64;
        for (k, &at) in taken.iter().enumerate().take(WIDTH / COUNT) {
            for order in 0..COUNT {
                let x = run[at as usize + order];
                from[k * COUNT + order] = x;
                any += x.abs();
            }
        }
        if any == 0.0 {
            continue;
        }
        for (c, w) in source.row(i) {
            let out = &mut runs[c as usize * step];
            for k in 0..WIDTH {
                out[k] += w * from[k];
            }
        }
    }
}

/// Weights made one point after the other.
fn point_by_point(
    grid: Grid,
    lattice: Lattice,
    count: usize,
    points: usize,
    weights: impl Fn([f64; 2]) -> PointWeights,
) -> Columns {
    let width = (grid.len(lattice) * count).next_multiple_of(WIDTH);
    let mut columns = Columns { weights: vec![0.0; points * width], width, places: Vec::new() };
    for (i, point) in grid.points_of(lattice).enumerate() {
        let PointWeights { rows, at_vertex } = weights(grid.uv(point));
        let none = Vec::new();
        let [position, du, dv, ..] = &rows;
        let [du, dv] = match &at_vertex {
            None => [du, dv],
            Some(at) => at.plane.as_ref().map_or([&none; 2], |[a, b]| [a, b]),
        };
        for (order, row) in [position, du, dv].into_iter().take(count).enumerate() {
            row.iter().take(points).enumerate().for_each(|(p, &w)| columns.weights[p * width + i * count + order] = w);
        }
        columns.places.push(Place { at: (i * count) as u32, jacobian: [[1.0, 0.0], [0.0, 1.0]] });
    }
    columns
}

fn product(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let entry = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j];
    [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limit::PatchTable;
    use crate::scheme::Scheme;
    use crate::shapes::{self, Shape};

    fn agrees(shape: &Shape, scheme: Scheme, cells: u32) {
        let table = PatchTable::new(&shape.mesh, scheme).unwrap();
        let all: Vec<usize> = (0..table.plan_count()).collect();
        table.plans().grid_weights(&all, cells, 3, |i, weights| {
            let plan = table.plan(all[i]);
            for point in weights.grid.points_of(Lattice::WHOLE) {
                let [u, v] = weights.grid.uv(point);
                let single = plan.weights(u, v, 0, 3);
                let plane = single.at_vertex.as_ref().map(|at| &at.plane);
                for (p, ours) in weights.rows(point).enumerate() {
                    for order in 0..3 {
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
                        let off = (ours[order] - row[p]).abs();
                        assert!(off <= rounding * size, "{} {cells} at {point:?}, order {order}: {off:e}", shape.name);
                    }
                }
            }
        });
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
