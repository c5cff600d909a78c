//! Weights of normals at the corners of plans, for the further sides of creases.

use super::layout::Layout;
use super::normals::Sides;
use crate::index::HalfEdge;
use crate::limit::PatchTable;
use crate::limit::plan::{GridWeights, Plan};
use crate::real::Real;
use crate::topology::NONE;
use rayon::prelude::*;

/// Weights at the corner of a plan: `(point of the ring, weights of ∂u, ∂v)`.
pub(super) type CornerRow<T> = Vec<(u32, [T; 2])>;

/// The corner that a vertex is evaluated at: its patch, and which corner of that patch's plan it is.
pub(super) fn corner_of(table: &PatchTable, is_triangle: bool, h: HalfEdge) -> (usize, usize) {
    let t = table.topology();
    let face = t.face(h);
    let corner = h.0 - t.first(face);
    if table.subfaces(face) > 1 {
        return (table.patch(face, corner), 0);
    }
    let (patch, sides) = (table.patch(face, 0), if is_triangle { 3 } else { 4 });
    (patch, (corner as usize + sides - usize::from(table.turn(patch))) % sides)
}

/// Weights at the corners that further normals are evaluated at, and which row is whose.
pub(super) struct CornerRows<T> {
    is_triangle: bool,
    rows: Vec<CornerRow<T>>,
    /// Plan and corner of every row.
    list: Vec<(usize, usize)>,
    /// Row of every corner of every plan.
    of_corner: Vec<[u32; 4]>,
}

impl<T: Real> CornerRows<T> {
    /// Rows without weights.
    pub fn new(layout: &Layout<'_>, sides: Option<&Sides>) -> Self {
        let (table, is_triangle) = (layout.table, layout.is_triangle());
        let mut of_corner = vec![[NONE; 4]; table.plan_count()];
        let mut list = Vec::new();
        for h in sides.iter().flat_map(|sides| sides.corners()) {
            let (patch, corner) = corner_of(table, is_triangle, h);
            let plan = table.patch_plan(patch).expect("owners are no holes");
            if of_corner[plan][corner] == NONE {
                of_corner[plan][corner] = list.len() as u32;
                list.push((plan, corner));
            }
        }
        Self { is_triangle, rows: list.iter().map(|_| Vec::new()).collect(), list, of_corner }
    }

    /// The rows of a plan from its weights on a grid.
    pub fn of_grid(&self, plan: usize, cells: u32, weights: &GridWeights) -> Vec<(usize, CornerRow<T>)> {
        let own = (0..4).filter(|&corner| self.of_corner[plan][corner] != NONE);
        own.map(|corner| {
            let point = corner_place(self.is_triangle, corner).map(|x| x as u32 * cells);
            (self.of_corner[plan][corner] as usize, sparse(weights.rows(point)))
        })
        .collect()
    }

    /// Takes rows by number.
    pub fn set(&mut self, rows: Vec<(usize, CornerRow<T>)>) {
        rows.into_iter().for_each(|(number, row)| self.rows[number] = row);
    }

    /// The row of a corner that was asked for.
    pub fn row(&self, plan: usize, corner: usize) -> &CornerRow<T> {
        &self.rows[self.of_corner[plan][corner] as usize]
    }

    /// Makes the rows that are still missing.
    pub fn fill(&mut self, table: &PatchTable, count: usize) {
        let is_triangle = self.is_triangle;
        let missing = self.rows.par_iter_mut().zip(&self.list).filter(|(row, _)| row.is_empty());
        missing.for_each(|(row, &(plan, corner))| {
            let [u, v] = corner_place(is_triangle, corner);
            let plan = table.plan(plan);
            let rows = rows_at(plan, u, v, count);
            *row = sparse((0..plan.ring()).map(|p| std::array::from_fn(|k| rows.get(k).map_or(0.0, |row| row[p]))));
        });
    }
}

/// Where a corner lies in its patch.
fn corner_place(is_triangle: bool, corner: usize) -> [f64; 2] {
    match (is_triangle, corner) {
        (_, 0) => [0.0, 0.0],
        (_, 1) => [1.0, 0.0],
        (false, 2) => [1.0, 1.0],
        _ => [0.0, 1.0],
    }
}

fn sparse<T: Real>(weights: impl Iterator<Item = [f64; 3]>) -> CornerRow<T> {
    let used = weights.enumerate().filter(|(_, [_, u, v])| *u != 0.0 || *v != 0.0);
    used.map(|(p, [_, u, v])| (p as u32, [u, v].map(T::from_f64))).collect()
}

/// Weights of position and of two vectors that span the tangent plane.
fn rows_at(plan: Plan<'_>, u: f64, v: f64, count: usize) -> Vec<Vec<f64>> {
    let weights = plan.weights(u, v, 0, count);
    let [position, du, dv, ..] = weights.rows;
    if count == 1 {
        return vec![position];
    }
    match weights.at_vertex {
        None => vec![position, du, dv],
        Some(at) => {
            let [a, b] = at.plane.unwrap_or_else(|| [0, 1].map(|_| vec![0.0; plan.ring()]));
            vec![position, a, b]
        }
    }
}
