//! What the weights of plans on a grid are made of: nodes of their children and leaves, leaves of spline bases, curves along
//! creases and closed forms at special vertices. Whatever is met again, over the same points, is one job.

use super::columns::{Columns, Place, WIDTH, point_by_point, product};
use super::lattice::{Grid, Lattice};
use super::sub_patches::Pose;
use super::{Body, LeafShape, Link, Plan, Plans, Points};
use crate::kernel::vectorized;
use crate::limit::box_spline;
use crate::limit::bspline::{cubic, tensor};
use crate::limit::corner::Corner;
use crate::limit::plan_key::KeyHasher;
use crate::limit::rows;
use crate::limit::single_crease;
use crate::limit::special::{PointWeights, SpecialVertex};
use crate::scheme::SplitKind;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

/// What weights are of.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Part {
    Node(Link),
    /// A spline patch, over its own control points.
    Regular,
    /// A patch along a crease of this sharpness, as bits.
    SingleCrease(u64),
    Special(Corner),
}

/// A part at some points of the grid.
pub(super) struct Job<'a> {
    part: Part,
    lattice: Lattice,
    vertex: Option<&'a SpecialVertex>,
    /// What it is made of; nothing where its weights are made point by point.
    pub sources: Vec<Source<'a>>,
}

/// Another part that some points of a job lie in.
pub(super) struct Source<'a> {
    pub job: usize,
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
    /// How the parameters of the part lie in those of the job.
    fn outer(&self, split: SplitKind) -> [[f64; 2]; 2] {
        let flip = if self.child == Some(3) && split == SplitKind::Triangles { -1.0 } else { 1.0 };
        let speed = flip * if self.child.is_some() { 2.0 } else { 1.0 };
        Pose { turn: self.turn, speed: [speed; 2] }.jacobian(split)
    }

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
pub(crate) struct GridScratch {
    pub(super) pool: Vec<Columns>,
    run: Vec<f64>,
    /// By source, where the numbers of its points are.
    taken: [Vec<u32>; 4],
    /// Source of every point.
    chosen: Vec<u8>,
}

type Numbers = HashMap<(Part, Lattice), Option<usize>, BuildHasherDefault<KeyHasher>>;

/// All jobs, those of which others are made before these; `height` says how many rounds come before.
pub(super) struct Jobs<'a> {
    plans: &'a Plans,
    pub grid: Grid,
    pub list: Vec<Job<'a>>,
    pub height: Vec<u32>,
    numbers: Numbers,
}

impl<'a> Jobs<'a> {
    pub fn new(plans: &'a Plans, grid: Grid) -> Self {
        Self { plans, grid, list: Vec::new(), height: Vec::new(), numbers: Numbers::default() }
    }

    /// The number of a plan at all points of the grid.
    pub fn add_plan(&mut self, plan: usize) -> usize {
        self.add(Part::Node(self.plans.plans[plan]), Lattice::WHOLE, None)
    }

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

    /// Memory that the weights of a job take.
    pub fn bytes(&self, number: usize, count: usize) -> usize {
        let Job { part, lattice, vertex, .. } = &self.list[number];
        let ring = match part {
            Part::Node(link) => self.plans.nodes[link.node as usize].ring,
            _ => vertex.map_or(16, SpecialVertex::points),
        };
        let points = self.grid.points_of(*lattice).count();
        points * (ring * count * size_of::<f64>() + size_of::<Place>())
    }

    /// The weights of a job, from those of the jobs that it is made of.
    pub fn columns(&self, number: usize, count: usize, done: &[Option<Columns>], scratch: &mut GridScratch) -> Columns {
        let (grid, job) = (self.grid, &self.list[number]);
        let Part::Node(link) = job.part else { return self.basis(job, count) };
        let ring = self.plans.nodes[link.node as usize].ring;
        if job.sources.is_empty() {
            let plan = Plan { plans: self.plans, number: usize::MAX, start: link };
            return point_by_point(grid, job.lattice, count, ring, |[u, v]| plan.weights(u, v, 0, count));
        }
        let mut new: [Option<Columns>; 4] = Default::default();
        for (new, source) in new.iter_mut().zip(&job.sources).filter(|(_, source)| done[source.job].is_none()) {
            *new = Some(self.columns(source.job, count, done, scratch));
        }
        let source_columns = |number: usize| {
            let known = done[job.sources[number].job].as_ref();
            known.or(new[number].as_ref()).expect("known or just made")
        };
        // Which source every point comes from, and where its numbers are there.
        let Columns { mut weights, mut places, .. } = scratch.pool.pop().unwrap_or_default();
        let GridScratch { run, taken, chosen, .. } = scratch;
        taken.iter_mut().for_each(Vec::clear);
        chosen.clear();
        places.clear();
        for point in grid.points_of(job.lattice) {
            let child = grid.child_of(point);
            let number = job.sources.iter().position(|s| s.child.is_none_or(|own| own == child)).expect("some child");
            let source = &job.sources[number];
            let below = if source.child.is_some() { grid.in_child(child, point) } else { point };
            let at = grid.index_in(source.lattice, grid.turned(below, source.turn));
            let place = source_columns(number).places[at];
            let jacobian = product(source.outer(grid.split), place.jacobian);
            places.push(Place { at: (taken[number].len() * count) as u32, jacobian });
            taken[number].push(place.at);
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
        weights.clear();
        weights.resize(ring * width, 0.0);
        for (number, source) in job.sources.iter().enumerate().filter(|(number, _)| !taken[*number].is_empty()) {
            let (columns, taken, start) = (source_columns(number), &taken[number], starts[number]);
            vectorized(
                #[inline(always)]
                || match (count, taken.len() * count) {
                    (1, 1..=WIDTH) => add_short::<1>(source, columns, taken, &mut weights, [start, width]),
                    (3, 1..=WIDTH) => add_short::<3>(source, columns, taken, &mut weights, [start, width]),
                    _ => add_long(source, columns, taken, count, &mut weights, [start, width], run),
                },
            );
        }
        scratch.pool.extend(new.into_iter().flatten());
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
