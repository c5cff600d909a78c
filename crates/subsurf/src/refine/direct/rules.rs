//! The rules of one step by kinds: all vertices that a control edge carries follow one rule, which depends on the edge's
//! sharpness alone. Its weights are read off the masks of a small grid with a crease through the middle.

use crate::index::{Face, HalfEdge, Vertex};
use crate::kernel::RowRule;
use crate::mask::{Mask, edge_mask, is_linear, vertex_mask};
use crate::mesh::ControlMesh;
use crate::real::Real;
use crate::scheme::Scheme;
use crate::tags::Tags;
use crate::topology::{Interpolation, Topology};
use std::collections::BTreeMap;

/// A small grid with a row of two edges through its middle, or along its side, off which the rule of rows is read.
pub(super) struct RowGrid {
    t: Topology,
    scheme: Scheme,
    /// None along a boundary, which is sharp as it is.
    row: Option<[usize; 2]>,
    mask: Mask,
}

impl RowGrid {
    /// Of quads as `t` has them, or of their boundary.
    pub fn new(t: &Topology, scheme: Scheme, is_boundary: bool) -> Self {
        // Vertices 0 1 2 of the row, then 3 4 5 above, and 6 7 8 below where there are faces.
        let faces = [[0u32, 1, 4, 3], [1, 2, 5, 4], [6, 7, 1, 0], [7, 8, 2, 1]];
        let tags = Tags { rules: *t.rules(), ..Tags::default() };
        let mesh = ControlMesh::new(&faces[..if is_boundary { 2 } else { 4 }], tags).expect("a grid is a mesh");
        let mut grid = Topology::new(&mesh).expect("a grid has no creases");
        grid.interpolation = t.interpolation;
        let row = (!is_boundary).then(|| [0, 1].map(|f| grid.edge(grid.half_edge(Face(f), 0)).index()));
        Self { t: grid, scheme, row, mask: Mask::default() }
    }

    /// The rule of a row of sharpness `s`.
    pub fn rule(&mut self, s: f64) -> RowRule<f64> {
        let Self { t, scheme, row, mask } = self;
        if let Some(row) = row {
            row.iter().for_each(|&e| t.edge_sharpness.set(e, s));
            t.index_sharp_edges();
        }
        let sum = |terms: &[(u32, f64)], of: u32| -> f64 {
            terms.iter().filter(|term| term.0 == of).map(|term| term.1).sum()
        };
        edge_mask(t, *scheme, t.edge(t.half_edge(Face(0), 0)), mask);
        let edge = [sum(&mask.vertices, 0), sum(&mask.faces, 0)];
        vertex_mask(t, *scheme, Vertex(1), mask);
        let [own, beside, beyond] = [1, 0, 4].map(|v| sum(&mask.vertices, v));
        RowRule { edge, vertex: [own, beside, beyond, sum(&mask.faces, 0)] }
    }
}

/// In the precision of the values.
pub(super) fn rounded<T: Real>(rule: &RowRule<f64>) -> RowRule<T> {
    RowRule { edge: rule.edge.map(T::from_f64), vertex: rule.vertex.map(T::from_f64) }
}

/// The rules of all sharp edges.
#[derive(Default)]
pub(super) struct SharpEdges {
    rules: Vec<RowRule<f64>>,
    /// Edges in ascending order, each with its rule.
    edges: Vec<(u32, u32)>,
}

impl SharpEdges {
    /// Of the edges of `t`; `grids` are those inside and at a boundary.
    pub fn new(t: &Topology, scheme: Scheme, grids: &mut [RowGrid; 2]) -> Self {
        let mut out = Self::default();
        if is_linear(t, scheme) {
            return out;
        }
        let mut known: BTreeMap<(bool, u64), u32> = BTreeMap::new();
        for e in t.edge_sharpness.sharp() {
            // One step sees of a sharpness only what is at most 1.
            let s = t.edge_sharpness.get(e).min(1.0);
            // Boundaries differ from other sharp edges only where they are kept linear.
            let is_boundary = t.edge_flags[e].boundary && t.interpolation == Interpolation::LinearBoundaries;
            let rule = *known.entry((is_boundary, s.to_bits())).or_insert_with(|| {
                out.rules.push(grids[usize::from(is_boundary)].rule(s));
                out.rules.len() as u32 - 1
            });
            out.edges.push((e as u32, rule));
        }
        out
    }

    /// Those of a range of edges.
    pub fn among(&self, edges: std::ops::Range<u32>) -> &[(u32, u32)] {
        let at = |e: u32| self.edges.partition_point(|sharp| sharp.0 < e);
        &self.edges[at(edges.start)..at(edges.end)]
    }

    pub fn rule<T: Real>(&self, rule: u32) -> RowRule<T> {
        rounded(&self.rules[rule as usize])
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.rules[..]) + size_of_val(&self.edges[..])
    }
}

/// Sparse rows of weights, each for one vertex or edge with rules of its own, in ascending order.
#[derive(Default)]
pub(super) struct Special {
    pub owners: Vec<u32>,
    ends: Vec<u32>,
    terms: Vec<(u32, f64)>,
}

impl Special {
    /// Adds the row of an owner beyond all before; it has a term at least.
    pub fn push(&mut self, owner: u32, terms: impl Iterator<Item = (u32, f64)>) {
        self.owners.push(owner);
        self.terms.extend(terms.filter(|term| term.1 != 0.0));
        self.ends.push(self.terms.len() as u32);
    }

    /// Positions of the owners in a range.
    pub fn among(&self, owners: std::ops::Range<u32>) -> std::ops::Range<usize> {
        let at = |owner: u32| self.owners.partition_point(|&o| o < owner);
        at(owners.start)..at(owners.end)
    }

    /// The sum of a row, relative to the value of its first term.
    #[inline(always)]
    pub fn apply<T: Real, const N: usize>(&self, row: usize, value: impl Fn(u32) -> [T; N]) -> [T; N] {
        let start = if row == 0 { 0 } else { self.ends[row - 1] };
        let terms = &self.terms[start as usize..self.ends[row] as usize];
        let base = value(terms[0].0);
        let mut sum = [T::default(); N];
        for &(id, weight) in &terms[1..] {
            let (value, weight) = (value(id), T::from_f64(weight));
            for c in 0..N {
                sum[c] = sum[c] + weight * (value[c] - base[c]);
            }
        }
        for c in 0..N {
            sum[c] = base[c] + sum[c];
        }
        sum
    }

    pub fn bytes(&self) -> usize {
        4 * (self.owners.len() + self.ends.len()) + size_of_val(&self.terms[..])
    }
}

/// The half-edges that leave a smooth vertex, or one with faces all round, in the order in which masks list its faces.
pub(super) fn fan(t: &Topology, v: Vertex) -> Vec<HalfEdge> {
    let mut fan = Vec::new();
    t.walk_fan(v, |h| fan.push(h));
    fan
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    #[test]
    fn rules_of_smooth_sharp_and_fading_rows_are_the_published_ones() {
        let t = Topology::new(&shapes::grid(3, 3).mesh).unwrap();
        let of = |s: f64| RowGrid::new(&t, Scheme::CatmullClark, false).rule(s);
        let smooth = RowRule { edge: [0.25, 0.25], vertex: [0.5, 1.0 / 16.0, 1.0 / 16.0, 1.0 / 16.0] };
        let sharp = RowRule { edge: [0.5, 0.0], vertex: [0.75, 0.125, 0.0, 0.0] };
        assert_eq!(of(0.0), smooth);
        assert_eq!(of(10.0), sharp);
        assert_eq!((of(1.0), of(2.7)), (sharp, sharp));
        let between = of(0.5);
        assert_eq!(between.edge, [0.375, 0.125]);
        for k in 0..4 {
            assert_eq!(between.vertex[k], 0.5 * (smooth.vertex[k] + sharp.vertex[k]));
        }
        assert_eq!(RowGrid::new(&t, Scheme::CatmullClark, true).rule(10.0), sharp);
    }
}
