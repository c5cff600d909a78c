//! The rules of one step by kinds: all vertices that a control edge carries follow one rule, which depends on the edge's
//! sharpness alone. Its weights are read off the masks of a small grid with a crease through the middle.

use crate::index::{Edge, Face, Vertex};
use crate::kernel::RowRule;
use crate::mask::{Mask, edge_mask, is_linear, vertex_mask};
use crate::mesh::ControlMesh;
use crate::real::Real;
use crate::scheme::Scheme;
use crate::sharpness::decay;
use crate::tags::Tags;
use crate::topology::{Interpolation, NONE, Topology};
use std::collections::BTreeMap;
use std::ops::Range;

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

/// The rules of rows by kind, which is given by their sharpness on the control mesh; kind 0 is smooth.
pub(super) struct Creases {
    /// By whether an edge is a boundary that is kept linear, and its sharpness.
    kinds: BTreeMap<(bool, u64), u32>,
    /// By code of sharpness, where that says it all.
    by_code: Vec<u32>,
    /// By level from `start` on, then by kind: the rule and whether it is the smooth one.
    rules: Vec<Vec<(RowRule<f64>, bool)>>,
    start: usize,
}

impl Creases {
    /// Of the edges of `t` at some levels; `grids` are those inside and at a boundary.
    pub fn new(t: &Topology, scheme: Scheme, levels: Range<usize>, grids: &mut [RowGrid; 2]) -> Self {
        let smooth = (grids[0].rule(0.0), true);
        let mut out = Self { kinds: BTreeMap::new(), by_code: vec![NONE; 256], rules: Vec::new(), start: levels.start };
        out.by_code[0] = 0;
        let mut sharpness = vec![(false, 0.0)];
        if !is_linear(t, scheme) {
            for e in t.edge_sharpness.sharp() {
                let (key, code) = (key(t, e), t.edge_sharpness.code(e));
                if !key.0 && out.by_code[usize::from(code)] != NONE {
                    continue;
                }
                let kind = *out.kinds.entry(key).or_insert_with(|| {
                    sharpness.push((key.0, t.edge_sharpness.get(e)));
                    sharpness.len() as u32 - 1
                });
                if t.interpolation != Interpolation::LinearBoundaries && code != u8::MAX {
                    out.by_code[usize::from(code)] = kind;
                }
            }
        }
        let mut known = BTreeMap::new();
        for level in 0..levels.end {
            let rule = |(is_boundary, s): &mut (bool, f64)| {
                // One step sees of a sharpness only what is at most 1.
                let seen = s.min(1.0);
                let rule = known.entry((*is_boundary, seen.to_bits()));
                *s = decay(*s);
                (*rule.or_insert_with(|| grids[usize::from(*is_boundary)].rule(seen)), seen == 0.0)
            };
            let rules: Vec<_> = [smooth].into_iter().chain(sharpness[1..].iter_mut().map(rule)).collect();
            if level >= levels.start {
                out.rules.push(rules);
            }
        }
        out
    }

    #[inline(always)]
    pub fn kind(&self, t: &Topology, e: Edge) -> u32 {
        match self.by_code[usize::from(t.edge_sharpness.code(e.index()))] {
            NONE => self.kinds[&key(t, e.index())],
            kind => kind,
        }
    }

    /// The rule from level `level` to the next.
    #[inline(always)]
    pub fn rule(&self, level: usize, kind: u32) -> &RowRule<f64> {
        &self.rules[level - self.start][kind as usize].0
    }

    #[inline(always)]
    pub fn is_smooth(&self, level: usize, kind: u32) -> bool {
        self.rules[level - self.start][kind as usize].1
    }

    pub fn bytes(&self) -> usize {
        let kinds = self.kinds.len() * (size_of::<(bool, u64)>() + size_of::<u32>());
        kinds + 4 * self.by_code.len() + self.rules.iter().map(|level| size_of_val(&level[..])).sum::<usize>()
    }
}

/// Boundaries differ from other sharp edges only where they are kept linear.
fn key(t: &Topology, e: usize) -> (bool, u64) {
    let is_linear = t.interpolation == Interpolation::LinearBoundaries && t.edge_flags[e].boundary;
    (is_linear, t.edge_sharpness.get(e).to_bits())
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

    /// The same with a first term, whatever its weight.
    pub fn push_from(&mut self, first: (u32, f64), owner: u32, terms: impl Iterator<Item = (u32, f64)>) {
        self.terms.push(first);
        self.push(owner, terms);
    }

    /// Positions of the owners in a range.
    pub fn among(&self, owners: Range<u32>) -> Range<usize> {
        let at = |owner: u32| self.owners.partition_point(|&o| o < owner);
        at(owners.start)..at(owners.end)
    }

    /// Numbers and their weights.
    #[inline(always)]
    pub fn terms(&self, row: usize) -> &[(u32, f64)] {
        let start = if row == 0 { 0 } else { self.ends[row - 1] };
        &self.terms[start as usize..self.ends[row] as usize]
    }

    /// The sum of a row, relative to the value of its first term.
    #[inline(always)]
    pub fn apply<T: Real, const N: usize>(&self, row: usize, value: impl Fn(u32) -> [T; N]) -> [T; N] {
        let terms = self.terms(row);
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
