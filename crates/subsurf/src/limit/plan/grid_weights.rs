//! Points of a grid over a plan, by weights or by values: what tessellations with one rate are made of.
//!
//! The way goes down the patch tree once for all points. Every node's control points are held as dense rows; a step of
//! refinement makes the rows of its children from them, and points go to the child that holds them. At a leaf, rows are
//! summed with the leaf's basis: where that is a product of two curves, one direction after the other.
//!
//! What a row holds is the caller's choice. Rows that start as the identity over the plan's ring, eight numbers to a vector, end as
//! weights, for all faces of the plan. Rows that start as the values at the control points of one face end as values on the
//! surface ([`values`]): a few numbers where weights are dozens, and nothing is left to be multiplied.
//!
//! Derivatives stay in the parameters of the leaf where they were made; how these lie in the face comes down with the
//! points. Weights over rings of more than [`MOST_RING`] points, linear leaves, semi-sharp creases under Loop and ends on
//! boundaries that are kept linear go through [`Plan::weights`], point by point.

mod dense;
mod region;
mod values;

use super::grid::Grid;
use super::leaf_basis::{Basis, LeafBases, MOST_KEPT};
use super::sub_patches::Pose;
use super::{Body, Leaf, LeafShape, Link, Plan, Plans, Split};
use crate::kernel::{SurfaceMatrix, vectorized};
use crate::limit::bspline::cubic;
use crate::limit::pole::{JetRows, PoleValues, is_pole};
use crate::limit::single_crease;
use crate::limit::special::{PointWeights, SpecialVertex};
use crate::real::Real;
use crate::scheme::SplitKind;
use dense::{Control, Target, WIDTH, Weights, add, combine, product, refine, run_of};

pub(crate) use region::GridPoints;
use region::{Crossings, Region, Sample};
pub(crate) use values::GridValues;

/// Largest ring whose rows of weights are dense, of 128 KiB. Larger: memory, and time for rows of zeros; smaller: more plans point
/// by point.
pub(crate) const MOST_RING: usize = 128;

/// Goes down plans with the points of a grid: for position, and for `∂u`, `∂v` where three are wanted. At special vertices
/// derivatives are vectors that span the tangent plane, zeros where there is none.
pub(crate) struct GridMaker<'a> {
    plans: &'a Plans,
    grid: Grid,
    count: usize,
    /// Curve weights at all lines of the grid.
    cubic: Vec<[[f64; 4]; 3]>,
    bases: LeafBases,
}

/// Memory that is used again, for rows of vectors of `W` numbers.
#[derive(Default)]
pub(crate) struct GridScratch<const W: usize = WIDTH> {
    matrices: Vec<Vec<[f64; W]>>,
    lists: Vec<Vec<Sample>>,
    needed: Vec<u32>,
    is_made: Vec<bool>,
}

impl<'a> GridMaker<'a> {
    /// For a grid of `cells` facets a side, and `count` weights, 1 or 3.
    pub fn new(plans: &'a Plans, cells: u32, count: usize) -> Self {
        let at = |i: u32| cubic(f64::from(i) / f64::from(cells));
        let grid = Grid { cells, split: plans.split };
        Self { plans, grid, count, cubic: (0..=cells).map(at).collect(), bases: LeafBases::new(grid, count) }
    }

    /// True where what leaves have in common is made once. Where it is not, to go by values takes longer than sub-patch by sub-patch.
    pub fn keeps_bases(&self) -> bool {
        self.grid.cells <= MOST_KEPT
    }

    /// Writes the weights of a plan at `count` grid points, rounded to `T`.
    pub fn fill<T: Real>(
        &self,
        plan: usize,
        points: &GridPoints,
        count: usize,
        scratch: &mut GridScratch,
        out: &mut SurfaceMatrix<T>,
    ) {
        let plan = self.plans.get(plan);
        let ring = plan.ring();
        out.resize(count, ring, self.count);
        let samples = points.region(self.grid.cells);
        let mut target = Weights { out, ring };
        let whole = [[1.0, 0.0], [0.0, 1.0]];
        if ring > MOST_RING {
            samples.each(|sample| {
                let rows = self.single(plan.start, sample);
                target.write([0, 1, 2].map(|k| &rows[k][..]), 0, ring, sample.number, whole, self.count);
            });
        } else {
            let chunks = target.chunks();
            let mut identity = scratch.matrices.pop().unwrap_or_default();
            identity.clear();
            identity.resize(ring * chunks, [0.0; WIDTH]);
            (0..ring).for_each(|p| identity[p * chunks + p / WIDTH][p % WIDTH] = 1.0);
            let control = Control { matrix: &identity, some: None, jacobian: whole, depth: 0 };
            self.node(plan.start, control, samples, scratch, &mut target);
            scratch.matrices.push(identity);
        }
    }

    /// The weights of samples in a node.
    fn node<const W: usize>(
        &self,
        link: Link,
        control: Control<'_, W>,
        samples: Region<'_>,
        scratch: &mut GridScratch<W>,
        target: &mut impl Target<W>,
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

    fn split<const W: usize>(
        &self,
        split: &Split,
        link: Link,
        control: Control<'_, W>,
        samples: Region<'_>,
        scratch: &mut GridScratch<W>,
        target: &mut impl Target<W>,
    ) {
        let (chunks, halved) = (target.chunks(), split.children().len() > 1);
        // The samples of every child, in its parameters.
        let children = split.children();
        let mut lists: [Vec<Sample>; 4] = Default::default();
        let mut regions = [Region::List(&[]); 4];
        match samples {
            Region::Crossings(crossings) => {
                let n = self.grid.cells as i32;
                for (number, child) in children.iter().enumerate() {
                    let part = if halved { crossings.child(n, number) } else { crossings };
                    if !part.is_empty() {
                        regions[number] = Region::Crossings(part.turned(n, child.turn));
                    }
                }
            }
            Region::List(samples) => {
                for list in &mut lists[..children.len()] {
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
                    lists[child].push(Sample { number, at: self.grid.turned(below, children[child].turn) });
                }
                regions.iter_mut().zip(&lists).for_each(|(region, list)| *region = Region::List(list));
            }
        }
        let is_met = |region: &Region<'_>| !matches!(region, Region::List([]));
        // The refined points that these children need: all that there are, if all children are met.
        let mut matrix = scratch.matrices.pop().unwrap_or_default();
        let GridScratch { needed, is_made, .. } = scratch;
        needed.clear();
        if !regions[..children.len()].iter().all(is_met) {
            is_made.clear();
            is_made.resize(split.points.len(), false);
            for (child, _) in children.iter().zip(&regions).filter(|(_, region)| is_met(region)) {
                for &point in split.ring(child) {
                    if !std::mem::replace(&mut is_made[point as usize], true) {
                        needed.push(point);
                    }
                }
            }
        }
        make_room(&mut matrix, split.points.len() * chunks);
        refine(control, &split.points, needed, chunks, &mut matrix);
        for (number, (child, region)) in children.iter().zip(regions).enumerate() {
            if !is_met(&region) {
                continue;
            }
            let flip = if number == 3 && self.grid.split == SplitKind::Triangles { -1.0 } else { 1.0 };
            let speed = if halved { 2.0 * flip } else { 1.0 };
            let pose = Pose { turn: child.turn, speed: [speed; 2] };
            let jacobian = product(control.jacobian, pose.jacobian(self.grid.split));
            let control = Control {
                matrix: &matrix,
                some: Some(split.ring(child)),
                jacobian,
                depth: control.depth + u32::from(halved),
            };
            self.node(child.link(link.raise), control, region, scratch, target);
        }
        if let Region::List(_) = samples {
            scratch.lists.extend(lists);
        }
        scratch.matrices.push(matrix);
    }

    fn leaf<const W: usize>(
        &self,
        leaf: &Leaf,
        link: Link,
        control: Control<'_, W>,
        samples: Region<'_>,
        scratch: &mut GridScratch<W>,
        target: &mut impl Target<W>,
    ) {
        let chunks = target.chunks();
        let (turn, sharpness, basis) = match (&leaf.shape, self.grid.split) {
            _ if !leaf.creases.is_empty() => return self.singly(link, control, samples, target),
            (LeafShape::Linear, _) => return self.singly(link, control, samples, target),
            (LeafShape::Regular, SplitKind::Quads) => (0, None, None),
            (LeafShape::Regular, SplitKind::Triangles) => (0, None, Some(self.bases.of(None))),
            (LeafShape::SingleCrease { turn, sharpness }, _) => (*turn, Some(sharpness + f64::from(link.raise)), None),
            (LeafShape::Special { turn, vertex }, _) if is_pole(vertex) => (*turn, None, None),
            (LeafShape::Special { turn, vertex }, _) => (*turn, None, Some(self.bases.of(Some(vertex)))),
        };
        let pole = match &leaf.shape {
            LeafShape::Special { vertex, .. } if is_pole(vertex) => Some(&**vertex),
            _ => None,
        };
        let mut matrix = scratch.matrices.pop().unwrap_or_default();
        let mut list = scratch.lists.pop().unwrap_or_default();
        make_room(&mut matrix, leaf.points.len() * chunks);
        combine(control, &leaf.points, chunks, &mut matrix);
        let turned = match samples {
            Region::Crossings(crossings) => Region::Crossings(crossings.turned(self.grid.cells as i32, turn)),
            Region::List(samples) => {
                list.clear();
                list.extend(samples.iter().map(|s| Sample { at: self.grid.turned(s.at, turn), ..*s }));
                Region::List(&list)
            }
        };
        let jacobian = product(control.jacobian, Pose { turn, speed: [1.0; 2] }.jacobian(self.grid.split));
        let own = Control { matrix: &matrix, some: None, jacobian, depth: control.depth };
        match (pole, basis, turned) {
            (Some(vertex), ..) => self.at_pole(vertex, own, turned, target),
            (None, None, Region::Crossings(samples)) => {
                let curve = |j: u32| match sharpness {
                    Some(sharpness) => single_crease::curve(1.0 - f64::from(j) / f64::from(self.grid.cells), sharpness),
                    None => self.cubic[j as usize],
                };
                self.by_curves(curve, own, samples, target);
            }
            (None, basis, _) => {
                let basis = basis.expect("patches over triangles are no products");
                self.by_point(&basis, own, turned, target);
            }
        }
        scratch.lists.push(list);
        scratch.matrices.push(matrix);
    }

    /// Samples of a leaf whose basis is a product of two curves, `across` being that in v.
    /// What has v in common is summed first, whichever samples are wanted, and the rest sample by sample.
    fn by_curves<const W: usize>(
        &self,
        across: impl Fn(u32) -> [[f64; 4]; 3],
        control: Control<'_, W>,
        samples: Crossings<'_>,
        target: &mut impl Target<W>,
    ) {
        let (chunks, inner) = (target.chunks(), &self.cubic);
        vectorized(
            #[inline(always)]
            || {
                for row in 0..samples.rows() {
                    let row = samples.row(row);
                    if row.is_empty() {
                        continue;
                    }
                    let outer = across(row.v);
                    for chunk in (0..chunks).step_by(2) {
                        match (chunk + 1 < chunks, self.count) {
                            (true, 1) => run_of::<W, 2, 1>(row, &outer, inner, control, chunk, target),
                            (true, _) => run_of::<W, 2, 3>(row, &outer, inner, control, chunk, target),
                            (false, 1) => run_of::<W, 1, 1>(row, &outer, inner, control, chunk, target),
                            (false, _) => run_of::<W, 1, 3>(row, &outer, inner, control, chunk, target),
                        }
                    }
                }
            },
        );
    }

    /// Samples of a leaf with any basis.
    fn by_point<const W: usize>(
        &self,
        basis: &Basis<'_>,
        control: Control<'_, W>,
        samples: Region<'_>,
        target: &mut impl Target<W>,
    ) {
        let chunks = target.chunks();
        vectorized(
            #[inline(always)]
            || {
                samples.each(
                    #[inline(always)]
                    |sample| {
                        basis.with(
                            sample.at,
                            #[inline(always)]
                            |weights| {
                                for chunk in 0..chunks {
                                    let mut rows = [[[0.0; W]; 1]; 3];
                                    for order in 0..self.count {
                                        for (i, &w) in weights[order].iter().enumerate() {
                                            add(&mut rows[order][0], w, &control.matrix[i * chunks + chunk]);
                                        }
                                    }
                                    target.put(&rows, chunk, sample.number, control.jacobian, self.count);
                                }
                            },
                        );
                    },
                );
            },
        );
    }

    /// Samples at a vertex of many faces.
    fn at_pole<const W: usize>(
        &self,
        vertex: &SpecialVertex,
        control: Control<'_, W>,
        samples: Region<'_>,
        target: &mut impl Target<W>,
    ) {
        let chunks = target.chunks();
        let mut values = PoleValues::new(vertex, control.matrix, chunks);
        let mut jet = JetRows::default();
        let none = vec![[0.0; W]; chunks];
        samples.each(|sample| {
            let at = self.grid.uv(sample.at);
            if !values.jet(vertex, at, self.count, &mut jet) {
                jet[0] = values.limit().to_vec();
                if self.count > 1 {
                    let plane = vertex.weights(0.0, 0.0, self.count).at_vertex.and_then(|at| at.plane);
                    [jet[1], jet[2]] = match plane {
                        Some(plane) => plane.map(|weights| values.difference(&weights)),
                        None => [none.clone(), none.clone()],
                    };
                }
            }
            for chunk in 0..chunks {
                let row = |k: usize| [if k < self.count { jet[k][chunk] } else { [0.0; W] }];
                target.put(&[row(0), row(1), row(2)], chunk, sample.number, control.jacobian, self.count);
            }
        });
    }

    /// Samples of a node one by one.
    fn singly<const W: usize>(
        &self,
        link: Link,
        control: Control<'_, W>,
        samples: Region<'_>,
        target: &mut impl Target<W>,
    ) {
        let chunks = target.chunks();
        samples.each(|sample| {
            let weights = self.single(link, sample);
            for chunk in 0..chunks {
                let mut rows = [[[0.0; W]; 1]; 3];
                for (rows, weights) in rows.iter_mut().zip(&weights).take(self.count) {
                    for (i, &w) in (0..).zip(weights) {
                        add(&mut rows[0], w, &control.matrix[control.row(i) * chunks + chunk]);
                    }
                }
                target.put(&rows, chunk, sample.number, control.jacobian, self.count);
            }
        });
    }

    /// Weights over the points of a node.
    fn single(&self, link: Link, sample: Sample) -> [Vec<f64>; 3] {
        let plan = Plan { plans: self.plans, number: usize::MAX, start: link };
        let [u, v] = self.grid.uv(sample.at);
        spanning(plan.weights(u, v, 0, self.count), plan.ring())
    }
}

/// Makes a matrix at least so long; what it holds is written over.
fn make_room<const W: usize>(matrix: &mut Vec<[f64; W]>, len: usize) {
    if matrix.len() < len {
        matrix.resize(len, [0.0; W]);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::LANES;
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
        let wanted = GridPoints::new(&points, cells, maker.grid.split, 0);
        let mut scratch = GridScratch::default();
        let [mut matrix, mut of_position] = [0; 2].map(|_| SurfaceMatrix::<f64>::default());
        for plan in 0..table.plan_count() {
            maker.fill(plan, &wanted, points.len(), &mut scratch, &mut matrix);
            positions.fill(plan, &wanted, points.len(), &mut scratch, &mut of_position);
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
