//! Weights of all points of a grid over many plans at once.
//!
//! A node's weights are those of its children times the refined points: `W_node = Σ W_child · S_child`. They are formed from
//! the leaves up, so that what plans have in common is multiplied once, and in columns: to runs of numbers, which fill
//! vectors, sparse rows add multiples of other runs.
//!
//! Derivatives stay in the parameters of the leaf where they were made; how these lie in the face goes with every point.

use super::Plans;
use super::columns::{Columns, Place};
use super::grid_jobs::{GridScratch, Jobs};
use super::lattice::Grid;
use crate::kernel::{LANES, SurfaceMatrix, vectorized};
use crate::real::Real;
use rayon::prelude::*;
use std::collections::HashMap;

/// Weights of position, and of two derivatives if they are wanted, at the points of a grid over one plan.
pub(crate) struct GridWeights {
    grid: Grid,
    count: usize,
    columns: Columns,
}

/// Makes the weights of plans on a grid.
pub(crate) struct GridMaker<'a> {
    jobs: Jobs<'a>,
    /// Job of every plan.
    of_plan: HashMap<usize, usize>,
    /// The weights of parts that several others are made of.
    done: Vec<Option<Columns>>,
    count: usize,
}

/// Memory for weights that several others are made of; what comes after is made anew for each. Larger: memory; smaller: time
/// where very many plans meet at high rates.
const MOST_BYTES: usize = 256 << 20;

impl<'a> GridMaker<'a> {
    /// For some plans and all points of a grid of `cells` facets a side, in parallel; of position, and of `∂u`, `∂v` if
    /// `count` is 3. At special vertices derivatives are vectors that span the tangent plane, zeros where there is none.
    pub fn new(plans: &'a Plans, wanted: &[usize], cells: u32, count: usize) -> Self {
        let grid = Grid { cells, split: plans.split };
        let mut jobs = Jobs::new(plans, grid);
        let root = |&plan: &usize| (plan, jobs.add_plan(plan));
        let of_plan = wanted.iter().map(root).collect();
        // What is part of one other alone is made with it, and forgotten.
        let mut users = vec![0u32; jobs.list.len()];
        jobs.list.iter().flat_map(|job| &job.sources).for_each(|source| users[source.job] += 1);
        let mut rounds: Vec<Vec<usize>> = Vec::new();
        let mut bytes = 0;
        for (number, &height) in jobs.height.iter().enumerate().filter(|(number, _)| users[*number] > 1) {
            bytes += jobs.bytes(number, count);
            if bytes > MOST_BYTES {
                break;
            }
            rounds.resize((height as usize + 1).max(rounds.len()), Vec::new());
            rounds[height as usize].push(number);
        }
        let mut done: Vec<Option<Columns>> = jobs.list.iter().map(|_| None).collect();
        for round in rounds {
            let make = |scratch: &mut GridScratch, &number: &usize| {
                let columns = jobs.columns(number, count, &done, scratch);
                let exact =
                    Columns { weights: columns.weights[..].to_vec(), places: columns.places[..].to_vec(), ..columns };
                scratch.pool.push(columns);
                exact
            };
            let made: Vec<Columns> = round.par_iter().map_init(GridScratch::default, make).collect();
            round.iter().zip(made).for_each(|(&number, columns)| done[number] = Some(columns));
        }
        Self { jobs, of_plan, done, count }
    }

    /// Calls `with` with the weights of a plan.
    ///
    /// # Panics
    /// If the plan is none of those that were asked for.
    pub fn with_weights<R>(&self, plan: usize, scratch: &mut GridScratch, with: impl FnOnce(&GridWeights) -> R) -> R {
        let columns = self.jobs.columns(self.of_plan[&plan], self.count, &self.done, scratch);
        let weights = GridWeights { grid: self.jobs.grid, count: self.count, columns };
        let result = with(&weights);
        scratch.pool.push(weights.columns);
        result
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

    /// Writes the weights of some grid points, rounded to `T`.
    pub fn fill<T: Real>(&self, points: impl ExactSizeIterator<Item = [u32; 2]>, out: &mut SurfaceMatrix<T>) {
        let Columns { weights, width, places } = &self.columns;
        out.resize(points.len(), weights.len() / width, self.count);
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

#[cfg(test)]
mod tests {
    use super::super::lattice::Lattice;
    use super::*;
    use crate::limit::PatchTable;
    use crate::scheme::Scheme;
    use crate::shapes::{self, Shape};

    fn agrees(shape: &Shape, scheme: Scheme, cells: u32) {
        let table = PatchTable::new(&shape.mesh, scheme).unwrap();
        let all: Vec<usize> = (0..table.plan_count()).collect();
        let maker = GridMaker::new(table.plans(), &all, cells, 3);
        let mut scratch = GridScratch::default();
        let mut check = |plan: usize| {
            maker.with_weights(plan, &mut scratch, |weights| {
                let plan = table.plan(plan);
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
                            assert!(
                                off <= rounding * size,
                                "{} {cells} at {point:?}, order {order}: {off:e}",
                                shape.name
                            );
                        }
                    }
                }
            })
        };
        all.iter().for_each(|&plan| check(plan));
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
