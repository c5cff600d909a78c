//! The other way round: which outputs move when a control point does.

use super::csr::Csr;

/// For every control point of a table the outputs that depend on it, in ascending order.
///
/// Made once per table, by [`StencilTable::dependents`](super::StencilTable::dependents) or
/// [`LimitStencilTable::dependents`](super::LimitStencilTable::dependents); four bytes per weight of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Dependents {
    offsets: Vec<u32>,
    outputs: Vec<u32>,
    rows: usize,
}

impl Dependents {
    pub(super) fn new(rows: &Csr) -> Self {
        let points = rows.control_points;
        let mut offsets = vec![0u32; points + 1];
        rows.indices.iter().for_each(|&p| offsets[p as usize + 1] += 1);
        for p in 0..points {
            offsets[p + 1] += offsets[p];
        }
        let mut fill = offsets.clone();
        let mut outputs = vec![0u32; rows.indices.len()];
        for row in 0..rows.len() {
            for &p in &rows.indices[rows.range(row)] {
                outputs[fill[p as usize] as usize] = row as u32;
                fill[p as usize] += 1;
            }
        }
        Self { offsets, outputs, rows: rows.len() }
    }

    /// The outputs that depend on a control point, ascending.
    ///
    /// # Panics
    /// If there is no such control point.
    pub fn of(&self, control_point: u32) -> &[u32] {
        let p = control_point as usize;
        &self.outputs[self.offsets[p] as usize..self.offsets[p + 1] as usize]
    }

    /// The outputs that depend on any of these control points, ascending, each once.
    ///
    /// # Panics
    /// If there is no such control point.
    pub fn of_all(&self, control_points: &[u32]) -> Vec<u32> {
        if let [one] = control_points {
            return self.of(*one).to_vec();
        }
        let terms: usize = control_points.iter().map(|&p| self.of(p).len()).sum();
        // Few: sort them. Many: mark them, which takes a look at every output.
        if terms < self.rows / 16 {
            let mut moved = Vec::with_capacity(terms);
            control_points.iter().for_each(|&p| moved.extend_from_slice(self.of(p)));
            moved.sort_unstable();
            moved.dedup();
            return moved;
        }
        let mut moves = vec![false; self.rows];
        for &p in control_points {
            self.of(p).iter().for_each(|&output| moves[output as usize] = true);
        }
        (0..self.rows as u32).filter(|&output| moves[output as usize]).collect()
    }
}
