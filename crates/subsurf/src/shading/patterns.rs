//! Weights of the samples of a tessellation, shared by all faces of a plan: a grid over the patch, sides and corners
//! included.

use super::field::FieldTable;
use crate::index::Face;
use crate::limit::PatchTable;
use crate::scheme::SplitKind;
use std::sync::OnceLock;

/// Largest memory for the grid of one plan, and of all; other plans compute weights sample by sample with the same
/// result. Larger: memory; smaller: time at high rates.
const PLAN_BYTES: usize = 16 << 20;
const ALL_BYTES: usize = 256 << 20;

/// How far a parameter may be from a grid line and still lie on it: rounding of a quotient, doubled at every level.
const ON_GRID: f64 = 1e-9;

pub(crate) struct Patterns {
    grids: Vec<Grid>,
    is_triangle: bool,
}

/// One plan's grid of `cells × cells`; 0 where there is none.
struct Grid {
    cells: u32,
    weights: OnceLock<Vec<f64>>,
}

impl Patterns {
    /// Grids for samples at multiples of `1 / cells` in the mesh's patches: `cells[0]` in faces that are one patch,
    /// `cells[1]` in sub-faces; 0 where there is no such number.
    pub(super) fn new(field: &FieldTable<'_>, cells: [u32; 2]) -> Self {
        let table: &PatchTable = &field.table;
        let is_triangle = table.scheme().split() == SplitKind::Triangles;
        let mut users = vec![0usize; table.plan_count()];
        let mut grids: Vec<Grid> = (0..users.len()).map(|_| Grid { cells: 0, weights: OnceLock::new() }).collect();
        for f in (0..table.topology().face_count() as u32).map(Face) {
            for subface in 0..table.subfaces(f) {
                let Some(plan) = table.patch_plan(table.patch(f, subface)) else { continue };
                users[plan] += 1;
                grids[plan].cells = match (cells, field.depth) {
                    (_, 0) => cells[usize::from(table.subfaces(f) > 1)],
                    ([0, sub], depth) => below(sub, depth - 1),
                    ([whole, _], depth) => below(whole, depth),
                };
            }
        }
        let mut total = 0;
        for (plan, grid) in grids.iter_mut().enumerate() {
            let points = (grid.cells as usize + 1).pow(2);
            let bytes = 8 * points * table.plan(plan).ring();
            if users[plan] < 2 || bytes > PLAN_BYTES || total + bytes > ALL_BYTES {
                grid.cells = 0;
            } else {
                total += bytes;
            }
        }
        Self { grids, is_triangle }
    }

    /// The weights at `(u, v)` of a face whose corner `turn` is the plan's corner 0; none beside the grid.
    pub(super) fn row(&self, table: &PatchTable, plan: usize, turn: u8, u: f64, v: f64) -> Option<&[f64]> {
        let grid = &self.grids[plan];
        let c = grid.cells;
        if c == 0 {
            return None;
        }
        let line = |x: f64| {
            let x = x * f64::from(c);
            ((x - x.round()).abs() < ON_GRID).then_some(x.round() as u32)
        };
        let (i, j) = (line(u)?, line(v)?);
        // The plan's grid is turned against the face's.
        let (a, b) = match (self.is_triangle, turn) {
            (_, 0) => (i, j),
            (false, 1) => (j, c - i),
            (false, 2) => (c - i, c - j),
            (false, _) => (c - j, i),
            (true, 1) => (j, c - (i + j).min(c)),
            (true, _) => (c - (i + j).min(c), i),
        };
        let weights = grid.weights.get_or_init(|| self.fill(table, plan, c));
        let length = table.plan(plan).ring();
        let at = (b * (c + 1) + a) as usize * length;
        Some(&weights[at..at + length])
    }

    fn fill(&self, table: &PatchTable, plan: usize, cells: u32) -> Vec<f64> {
        let plan = table.plan(plan);
        let mut weights = Vec::with_capacity((cells as usize + 1).pow(2) * plan.ring());
        for b in 0..=cells {
            for a in 0..=cells {
                if self.is_triangle && a + b > cells {
                    weights.resize(weights.len() + plan.ring(), 0.0);
                    continue;
                }
                let [u, v] = [a, b].map(|x| f64::from(x) / f64::from(cells));
                weights.extend_from_slice(&plan.weights(u, v, 0, 1).rows[0]);
            }
        }
        weights
    }
}

/// Cells of a grid that holds all samples of a patch of `cells`, `depth` levels down.
fn below(cells: u32, depth: u32) -> u32 {
    cells >> depth.min(cells.trailing_zeros().min(31))
}
