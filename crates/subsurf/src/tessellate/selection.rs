//! What a face evaluates, in the order of its points, and where that lies in its plan.

use super::grid::{GridSamples, Parts};
use crate::limit::plan::GridPoints;
use crate::scheme::SplitKind;
use std::sync::{Arc, OnceLock};

/// Some samples of a face.
pub(super) struct Selection {
    pub samples: GridSamples,
    /// The same in the plan.
    pub points: GridPoints,
}

/// Every selection that was asked for.
pub(super) struct Selections {
    is_triangle: bool,
    cells: [u32; 2],
    /// By kind of patch (whole face, sub-face), turn, and parts.
    made: [Vec<OnceLock<Arc<Selection>>>; 2],
}

impl Selections {
    /// For whole faces and sub-faces of these cells.
    pub fn new(cells: [u32; 2], is_triangle: bool) -> Self {
        let none = |turns: usize| (0..turns << 8).map(|_| OnceLock::new()).collect();
        // Sub-faces start at their own corner.
        Self { is_triangle, cells, made: [none(4), none(1)] }
    }

    /// The parts of a patch whose corner `turn` is its plan's corner 0.
    pub fn get(&self, is_subface: bool, parts: Parts, turn: u8) -> &Arc<Selection> {
        let kind = usize::from(is_subface);
        let cells = self.cells[kind];
        let new = || {
            let samples = GridSamples::new(cells, self.is_triangle, parts);
            let split = if self.is_triangle { SplitKind::Triangles } else { SplitKind::Quads };
            let points = GridPoints::new(samples.points(), cells, split, turn);
            Arc::new(Selection { samples, points })
        };
        self.made[kind][usize::from(turn) << 8 | usize::from(parts)].get_or_init(new)
    }
}
