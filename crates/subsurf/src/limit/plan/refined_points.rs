//! Points of the next level over a node's points, each made when it is first asked for.

use super::super::local_step::child_vertex_by;
use super::super::rows::{Accumulator, Rows};
use crate::mask::Mask;
use crate::scheme::Scheme;
use crate::topology::{NONE, Topology};

/// Rows of refined points, in the order in which they were asked for; memory that is used again.
#[derive(Default)]
pub(super) struct RefinedPoints {
    rows: Rows,
    /// Row of every refined vertex, or [`NONE`].
    known: Vec<u32>,
    sum: Accumulator,
    mask: Mask,
}

impl RefinedPoints {
    /// Forgets all points, for those of a level of `refined` vertices below `parent`.
    pub fn clear(&mut self, parent: &Topology, refined: usize) {
        self.rows.clear(parent.vertex_count());
        self.known.clear();
        self.known.resize(refined, NONE);
        self.sum.widen(parent.vertex_count());
    }

    /// The row of refined vertex `v`.
    pub fn row(&mut self, parent: &Topology, scheme: Scheme, v: u32) -> u32 {
        let Self { rows, known, sum, mask } = self;
        let row = &mut known[v as usize];
        if *row == NONE {
            child_vertex_by(parent, scheme, v, mask, &mut |p, w| sum.add(p, w));
            rows.push(sum);
            *row = rows.len() as u32 - 1;
        }
        *row
    }

    /// All rows.
    pub fn rows(&self) -> &Rows {
        &self.rows
    }
}
