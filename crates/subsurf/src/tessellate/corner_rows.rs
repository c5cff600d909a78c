//! Weights of normals at the corners of plans, for the further sides of creases.

use super::layout::Layout;
use super::normals::Sides;
use crate::index::HalfEdge;
use crate::limit::PatchTable;
use crate::real::Real;
use crate::topology::NONE;
use rayon::prelude::*;

/// Weights at the corner of a plan: `(point of the ring, weights of ∂u, ∂v)`.
pub(super) type CornerRow<T> = Vec<(u32, [T; 2])>;

/// The corner that a vertex is evaluated at: its patch, and which corner of that patch's plan it is.
fn corner_of(table: &PatchTable, is_triangle: bool, h: HalfEdge) -> (usize, usize) {
    let t = table.topology();
    let face = t.face(h);
    let corner = h.0 - t.first(face);
    if table.subfaces(face) > 1 {
        return (table.patch(face, corner), 0);
    }
    let (patch, sides) = (table.patch(face, 0), if is_triangle { 3 } else { 4 });
    (patch, (corner as usize + sides - usize::from(table.turn(patch))) % sides)
}

/// A face corner that a further normal is evaluated at.
pub(super) struct FurtherCorner {
    pub half_edge: HalfEdge,
    pub patch: usize,
    row: usize,
}

/// The corners that further normals are evaluated at, and their weights, which corners of the same plan share.
pub(super) struct CornerRows<T> {
    pub corners: Vec<FurtherCorner>,
    rows: Vec<CornerRow<T>>,
}

impl<T: Real> CornerRows<T> {
    /// For all corners that some normal beyond one per point is evaluated at.
    pub fn new(layout: &Layout<'_>, sides: Option<&Sides>) -> Self {
        let (table, is_triangle) = (layout.table, layout.is_triangle());
        let mut of_corner = vec![[NONE; 4]; table.plan_count()];
        let (mut corners, mut list) = (Vec::new(), Vec::new());
        for h in sides.iter().flat_map(|sides| sides.corners()) {
            let (patch, corner) = corner_of(table, is_triangle, h);
            let plan = table.patch_plan(patch).expect("owners are no holes");
            if of_corner[plan][corner] == NONE {
                of_corner[plan][corner] = list.len() as u32;
                list.push((plan, corner));
            }
            corners.push(FurtherCorner { half_edge: h, patch, row: of_corner[plan][corner] as usize });
        }
        let row = |&(plan, corner): &(usize, usize)| {
            let [u, v] = corner_place(is_triangle, corner);
            let plan = table.plan(plan);
            let [_, s, t] = plan.spanning_weights(u, v);
            sparse((0..plan.ring()).map(|p| [s[p], t[p]]))
        };
        Self { corners, rows: list.par_iter().map(row).collect() }
    }

    /// The weights at one of the corners.
    pub fn row(&self, corner: &FurtherCorner) -> &CornerRow<T> {
        &self.rows[corner.row]
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

fn sparse<T: Real>(weights: impl Iterator<Item = [f64; 2]>) -> CornerRow<T> {
    let used = weights.enumerate().filter(|(_, [u, v])| *u != 0.0 || *v != 0.0);
    used.map(|(p, weights)| (p as u32, weights.map(T::from_f64))).collect()
}
