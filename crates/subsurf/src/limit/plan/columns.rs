//! Weights in columns: for every control point a run of numbers, one per place and order of differentiation.

use super::lattice::{Grid, Lattice};
use crate::limit::special::PointWeights;

/// Runs of numbers are filled up to a multiple of this: one 512-bit vector of `f64`.
pub(super) const WIDTH: usize = 8;

/// Weights of some points over the points of a node.
#[derive(Default)]
pub(super) struct Columns {
    /// By control point, `width` numbers.
    pub weights: Vec<f64>,
    pub width: usize,
    /// By grid point, where its numbers lie in a run, and how the parameters of its derivatives lie in those of the node.
    pub places: Vec<Place>,
}

#[derive(Clone, Copy)]
pub(super) struct Place {
    pub at: u32,
    /// `∂s/∂u ∂t/∂u`, `∂s/∂v ∂t/∂v`.
    pub jacobian: [[f64; 2]; 2],
}

/// Weights made one point after the other.
pub(super) fn point_by_point(
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

pub(super) fn product(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let entry = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j];
    [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
}
