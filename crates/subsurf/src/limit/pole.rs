//! Values at a special vertex of many faces, from the values at its points. Weights would be rows of all these points, and every
//! location would take such rows through a step of refinement for each of its levels; here one step brings the values at all
//! points from one level to the next, for all locations in the face.
//!
//! With `A`, `X_c`, `l` and `λ` as in [`deflated`](super::deflated) and the values `X` as columns,
//!
//! ```text
//!   D_0 = X - 1 lᵀX,     D_{m+1} = (A - 1 lᵀ) D_m / λ,     points of child c at depth m:  lᵀX + λ^m X_c D_m
//! ```

use super::box_spline;
use super::bspline::{cubic, tensor};
use super::deflated::DENSE_LIMIT;
use super::local_step::LocalStep;
use super::special::{RegularChild, SpecialVertex};
use crate::kernel::vectorized;
use crate::scheme::SplitKind;

/// Levels that are kept. Larger: memory, all points of the vertex for each; smaller: time, where locations deeper than that
/// come one after the other.
const LEVELS: u32 = 16;

/// Regular children whose points are kept. Larger: memory, and time to find one; smaller: points made anew.
const CHILDREN: usize = 3 * LEVELS as usize;

/// The vertex in a face, its values in rows of vectors of `W` numbers.
pub(crate) struct PoleValues<const W: usize> {
    /// Vectors to a row.
    chunks: usize,
    /// `lᵀX`.
    limit: Vec<[f64; W]>,
    /// `D_0` and the following, as far as they were needed.
    levels: Vec<Vec<[f64; W]>>,
    /// One beyond these, and its depth.
    deepest: (u32, Vec<[f64; W]>),
    /// Depth, number and points of regular children.
    children: Vec<(u32, usize, Vec<[f64; W]>)>,
}

/// Position and derivatives in the order of [`ORDERS`](super::bspline::ORDERS), one row each.
pub(crate) type JetRows<const W: usize> = [Vec<[f64; W]>; 6];

/// True where a vertex is evaluated so: where powers of its step are not stored.
pub(crate) fn is_pole(vertex: &SpecialVertex) -> bool {
    vertex.points() > DENSE_LIMIT
}

impl<const W: usize> PoleValues<W> {
    /// From rows of `chunks` vectors, one for each of the vertex's points.
    pub fn new(vertex: &SpecialVertex, points: &[[f64; W]], chunks: usize) -> Self {
        let mut limit = vec![[0.0; W]; chunks];
        add_rows(vertex.limit().iter().copied().zip(0..), points, chunks, &mut limit);
        let mut first = points[..vertex.points() * chunks].to_vec();
        subtract(&mut first, &limit);
        Self { chunks, limit, levels: vec![first], deepest: (0, Vec::new()), children: Vec::new() }
    }

    /// `D_m`.
    fn level(&mut self, vertex: &SpecialVertex, m: u32) -> &[[f64; W]] {
        while self.levels.len() <= m.min(LEVELS) as usize {
            let next = self.after(vertex, &self.levels[self.levels.len() - 1]);
            self.levels.push(next);
        }
        if m <= LEVELS {
            return &self.levels[m as usize];
        }
        let (mut at, mut values) = std::mem::take(&mut self.deepest);
        if values.is_empty() || at > m {
            (at, values) = (LEVELS, self.levels[LEVELS as usize].clone());
        }
        while at < m {
            values = self.after(vertex, &values);
            at += 1;
        }
        self.deepest = (at, values);
        &self.deepest.1
    }

    /// `D_{m+1}` from `D_m`.
    fn after(&self, vertex: &SpecialVertex, values: &[[f64; W]]) -> Vec<[f64; W]> {
        let (chunks, step, scale) = (self.chunks, vertex.step(), 1.0 / vertex.scale());
        // What rounding left of the constant, which would grow beside the rest.
        let mut constant = vec![[0.0; W]; chunks];
        add_rows(vertex.limit().iter().copied().zip(0..), values, chunks, &mut constant);
        let mut next = vec![[0.0; W]; values.len()];
        vectorized(
            #[inline(always)]
            || {
                for k in 0..values.len() / chunks {
                    let (columns, weights) = step.terms(k);
                    for chunk in 0..chunks {
                        let mut sum = constant[chunk].map(|x| -x);
                        for (&c, &w) in columns.iter().zip(weights) {
                            let from = &values[c as usize * chunks + chunk];
                            for l in 0..W {
                                sum[l] += w * from[l];
                            }
                        }
                        for l in 0..W {
                            next[k * chunks + chunk][l] = scale * sum[l];
                        }
                    }
                }
            },
        );
        next
    }

    /// `X_c D_m`: where they are among the children that are kept.
    fn child(&mut self, vertex: &SpecialVertex, depth: u32, index: usize) -> usize {
        if let Some(known) = self.children.iter().position(|c| (c.0, c.1) == (depth, index)) {
            return known;
        }
        let chunks = self.chunks;
        let values = self.level(vertex, depth);
        let rows = vertex.step().child(index);
        let mut points = vec![[0.0; W]; rows.len() * chunks];
        for (&k, out) in rows.iter().zip(points.chunks_exact_mut(chunks)) {
            add_row(vertex.step(), k as usize, values, chunks, out);
        }
        if self.children.len() == CHILDREN {
            self.children.clear();
        }
        self.children.push((depth, index, points));
        self.children.len() - 1
    }

    /// The first `count` rows of the jet at parameters `(a, b)`, the vertex at the origin; false at the vertex itself, and where
    /// derivatives diverge so near to it that they are no numbers.
    pub fn jet(&mut self, vertex: &SpecialVertex, [a, b]: [f64; 2], count: usize, out: &mut JetRows<W>) -> bool {
        let Some(RegularChild { depth, index, u, v, flip }) = vertex.child(a, b) else { return false };
        let basis = match vertex.corner.split {
            SplitKind::Quads => tensor(&cubic(u), &cubic(v), count),
            SplitKind::Triangles => box_spline::basis(u, v, count),
        };
        let child = self.child(vertex, depth, index);
        let points = &self.children[child].2;
        for (order, row) in out.iter_mut().enumerate().take(count) {
            row.clear();
            row.resize(self.chunks, [0.0; W]);
            add_rows(basis[order].iter().copied().zip(0..points.len() / self.chunks), points, self.chunks, row);
            let times = [0, 1, 1, 2, 2, 2][order];
            let factor = (2f64.powi(times) * vertex.scale()).powi(depth as i32) * (2.0 * flip).powi(times);
            row.iter_mut().flatten().for_each(|x| *x *= factor);
            if order == 0 {
                row.iter_mut().flatten().zip(self.limit.as_flattened()).for_each(|(x, l)| *x += l);
            }
        }
        out[..count].iter().flatten().flatten().all(|x| x.is_finite())
    }

    /// `lᵀX`.
    pub fn limit(&self) -> &[[f64; W]] {
        &self.limit
    }

    /// A sum over the vertex's points whose weights add up to zero.
    pub fn difference(&self, weights: &[f64]) -> Vec<[f64; W]> {
        let mut out = vec![[0.0; W]; self.chunks];
        add_rows(weights.iter().copied().zip(0..), &self.levels[0], self.chunks, &mut out);
        out
    }
}

/// Adds row `k` of a step times the values.
fn add_row<const W: usize>(step: &LocalStep, k: usize, values: &[[f64; W]], chunks: usize, out: &mut [[f64; W]]) {
    let (columns, weights) = step.terms(k);
    for (&c, &w) in columns.iter().zip(weights) {
        let from = &values[c as usize * chunks..][..chunks];
        for (out, from) in out.iter_mut().zip(from) {
            for l in 0..W {
                out[l] += w * from[l];
            }
        }
    }
}

/// Adds weighted rows of `values`.
fn add_rows<const W: usize>(
    terms: impl Iterator<Item = (f64, usize)>,
    values: &[[f64; W]],
    chunks: usize,
    out: &mut [[f64; W]],
) {
    for (w, k) in terms.filter(|(w, _)| *w != 0.0) {
        for (out, from) in out.iter_mut().zip(&values[k * chunks..]) {
            for l in 0..W {
                out[l] += w * from[l];
            }
        }
    }
}

/// Subtracts a row from all rows.
fn subtract<const W: usize>(rows: &mut [[f64; W]], row: &[[f64; W]]) {
    for out in rows.chunks_exact_mut(row.len()) {
        for (out, from) in out.iter_mut().zip(row) {
            for l in 0..W {
                out[l] -= from[l];
            }
        }
    }
}
