//! Sparse rows: points as combinations of other points.

use std::collections::HashMap;

/// One point: `(index, weight)` pairs, no index twice where the order matters. Most are a point itself, which takes no memory of
/// its own.
#[derive(Clone, Debug)]
pub(crate) enum Combination {
    Point([(u32, f64); 1]),
    Sum(Vec<(u32, f64)>),
}

impl Combination {
    /// Point `i`.
    pub fn point(i: u32) -> Self {
        Self::Point([(i, 1.0)])
    }
}

impl Default for Combination {
    /// No terms.
    fn default() -> Self {
        Self::Sum(Vec::new())
    }
}

impl std::ops::Deref for Combination {
    type Target = [(u32, f64)];

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Point(term) => term,
            Self::Sum(terms) => terms,
        }
    }
}

impl FromIterator<(u32, f64)> for Combination {
    fn from_iter<I: IntoIterator<Item = (u32, f64)>>(terms: I) -> Self {
        Self::Sum(terms.into_iter().collect())
    }
}

/// A compressed sparse row matrix: row `i` is a point as a combination of `columns` points.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    /// None, and no weights either, where every row is just one of the points.
    offset: Vec<u32>,
    column: Vec<u32>,
    weight: Vec<f64>,
    /// Where the weights of every row start, where rows of equal weights share them; none where they follow one another.
    shared: Vec<u32>,
    columns: usize,
}

/// Least number of rows that share their weights. Larger: memory of wide plans; smaller: time and a list more for plans of few rows.
const LEAST_SHARED: usize = 128;

/// Most terms of rows that share their weights: longer ones are few.
const MOST_SHARED: usize = 16;

impl Rows {
    /// No rows over `columns` points.
    pub fn empty(columns: usize) -> Self {
        Self { offset: vec![0], columns, ..Self::default() }
    }

    /// Forgets all rows; further ones are over `columns` points.
    pub fn clear(&mut self, columns: usize) {
        self.offset.clear();
        self.offset.push(0);
        self.column.clear();
        self.weight.clear();
        self.shared.clear();
        self.columns = columns;
    }

    /// Makes room for so many rows, and so many terms, beyond those that are there.
    pub fn reserve(&mut self, rows: usize, terms: usize) {
        self.offset.reserve_exact(rows);
        self.column.reserve_exact(terms);
        self.weight.reserve_exact(terms);
    }

    /// Adds a row: the terms added to `sum` since it was last taken from.
    pub fn push(&mut self, sum: &mut Accumulator) {
        sum.drain(|c, w| {
            self.column.push(c);
            self.weight.push(w);
        });
        self.offset.push(self.column.len() as u32);
    }

    /// Rows over `columns` points; terms with the same column are added.
    pub fn new(columns: usize, rows: &[Combination]) -> Self {
        let point = |row: &Combination| if let Combination::Point([(c, _)]) = row { Some(*c) } else { None };
        if let Some(column) = rows.iter().map(point).collect::<Option<Vec<u32>>>() {
            return Self { column, columns, ..Self::default() };
        }
        let most = rows.iter().map(|row| row.len()).sum();
        let mut out = Self::empty(columns);
        out.reserve(rows.len(), most);
        let mut sum = Accumulator::default();
        for row in rows {
            if let Combination::Point([(c, w)]) = row {
                out.column.push(*c);
                out.weight.push(*w);
                out.offset.push(out.column.len() as u32);
                continue;
            }
            sum.widen(columns);
            row.iter().for_each(|&(c, w)| sum.add(c, w));
            out.push(&mut sum);
        }
        out.shrunk()
    }

    /// The same without room for more.
    pub fn shrunk(mut self) -> Self {
        self.offset.shrink_to_fit();
        self.column.shrink_to_fit();
        self.weight.shrink_to_fit();
        self.shared.shrink_to_fit();
        self
    }

    /// The same with the weights of equal rows stored once, where there are many: the rows of a fan have few different ones.
    pub fn with_shared_weights(self) -> Self {
        if self.offset.is_empty() || self.len() < LEAST_SHARED || !self.shared.is_empty() {
            return self;
        }
        let Self { offset, column, weight, columns, .. } = self;
        // Long rows have their own.
        let rows = || offset.windows(2).map(|ends| ends[0] as usize..ends[1] as usize);
        let short: usize = rows().map(|row| row.len()).filter(|&terms| terms <= MOST_SHARED).sum();
        if 2 * short < weight.len() {
            return Self { offset, column, weight, shared: Vec::new(), columns };
        }
        let mut known = HashMap::<&[u64], u32>::new();
        let bits: Vec<u64> = weight.iter().map(|w| w.to_bits()).collect();
        let (mut few, mut shared) = (Vec::new(), Vec::with_capacity(offset.len() - 1));
        for own in rows() {
            let mut add = || {
                few.extend_from_slice(&weight[own.clone()]);
                (few.len() - own.len()) as u32
            };
            shared.push(if own.len() <= MOST_SHARED {
                *known.entry(&bits[own.clone()]).or_insert_with(add)
            } else {
                add()
            });
        }
        if few.len() + shared.len() / 2 >= weight.len() {
            return Self { offset, column, weight, shared: Vec::new(), columns };
        }
        Self { offset, column, weight: few, shared, columns }.shrunk()
    }

    pub fn len(&self) -> usize {
        if self.offset.is_empty() { self.column.len() } else { self.offset.len() - 1 }
    }

    /// The same rows over other points, `point` being the new number of each.
    pub fn renumbered(&self, columns: usize, point: impl Fn(u32) -> u32) -> Self {
        Self { column: self.column.iter().map(|&c| point(c)).collect(), columns, ..self.clone() }
    }

    /// Columns and weights of a row.
    #[inline(always)]
    pub fn terms(&self, i: usize) -> (&[u32], &[f64]) {
        if self.offset.is_empty() {
            return (&self.column[i..=i], &[1.0]);
        }
        let range = self.offset[i] as usize..self.offset[i + 1] as usize;
        let columns = &self.column[range.clone()];
        if self.shared.is_empty() {
            return (columns, &self.weight[range]);
        }
        let start = self.shared[i] as usize;
        (columns, &self.weight[start..start + columns.len()])
    }

    /// The column of every row, where each is just one of the points. For rows that sum to one: these have no fewer terms.
    #[inline(always)]
    pub fn selected(&self) -> Option<&[u32]> {
        let selected = (self.column.len() == self.len()).then_some(&self.column[..]);
        debug_assert!(selected.is_none() || (0..self.len()).all(|i| matches!(self.terms(i), (&[_], &[1.0]))));
        selected
    }

    /// The weights of all rows, one after the other; of rows that are just points, and of those that share weights, there is no
    /// such list.
    pub fn weights(&self) -> &[f64] {
        debug_assert!(self.has_own_weights());
        &self.weight
    }

    /// Where the weights of row `i` start among all [`weights`](Self::weights).
    #[inline(always)]
    pub fn start(&self, i: usize) -> usize {
        debug_assert!(self.has_own_weights());
        self.offset[i] as usize
    }

    /// True where every row has a place of its own among the weights.
    fn has_own_weights(&self) -> bool {
        !self.offset.is_empty() && self.shared.is_empty()
    }

    /// The same rows in another order.
    pub fn in_order(&self, order: &[usize]) -> Self {
        let mut out = Self::empty(self.columns);
        for &i in order {
            let (columns, weights) = self.terms(i);
            out.column.extend_from_slice(columns);
            out.weight.extend_from_slice(weights);
            out.offset.push(out.column.len() as u32);
        }
        out
    }

    /// True where every row is just one of the points.
    pub fn is_selection(&self) -> bool {
        self.offset.is_empty()
    }

    /// True where the rows of both are over the same points.
    pub fn is_like(&self, other: &Self) -> bool {
        self.offset == other.offset && self.column == other.column
    }

    pub fn row(&self, i: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let (columns, weights) = self.terms(i);
        columns.iter().copied().zip(weights.iter().copied())
    }

    /// `out += left · self`, a row vector from the left.
    pub fn left_multiply(&self, left: &[f64], out: &mut [f64]) {
        for (i, &w) in left.iter().enumerate() {
            if w != 0.0 {
                self.row(i).for_each(|(c, x)| out[c as usize] += w * x);
            }
        }
    }

    /// All entries, row-major.
    #[cfg(test)]
    pub fn dense(&self) -> Vec<f64> {
        let mut out = vec![0.0; self.len() * self.columns];
        for i in 0..self.len() {
            self.row(i).for_each(|(c, w)| out[i * self.columns + c as usize] += w);
        }
        out
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        4 * (self.offset.len() + self.column.len() + self.shared.len()) + 8 * self.weight.len()
    }
}

/// Adds up sparse terms; gives them back in ascending order.
#[derive(Default)]
pub(crate) struct Accumulator {
    sum: Vec<f64>,
    /// A bit per column that was added to.
    used: Vec<u64>,
}

impl Accumulator {
    pub fn new(columns: usize) -> Self {
        let mut new = Self::default();
        new.widen(columns);
        new
    }

    /// Makes room for `columns` points. Nothing may have been added.
    pub fn widen(&mut self, columns: usize) {
        if columns > self.sum.len() {
            self.sum.resize(columns, 0.0);
            self.used.resize(columns.div_ceil(64), 0);
        }
    }

    #[inline]
    pub fn add(&mut self, column: u32, weight: f64) {
        self.used[column as usize / 64] |= 1 << (column % 64);
        self.sum[column as usize] += weight;
    }

    /// Hands over the terms added since the last call, ascending; zeros are dropped.
    #[inline]
    pub fn drain(&mut self, mut term: impl FnMut(u32, f64)) {
        for (word, bits) in self.used.iter_mut().enumerate() {
            while *bits != 0 {
                let column = 64 * word as u32 + bits.trailing_zeros();
                *bits &= *bits - 1;
                let w = std::mem::take(&mut self.sum[column as usize]);
                if w != 0.0 {
                    term(column, w);
                }
            }
        }
    }
}

/// `a · 2 - b`: the point beyond `a` seen from `b`.
pub(crate) fn extrapolate(a: &Combination, b: &Combination) -> Combination {
    a.iter().map(|&(v, w)| (v, 2.0 * w)).chain(b.iter().map(|&(v, w)| (v, -w))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_share_weights_are_the_rows_that_they_were() {
        let mut sum = Accumulator::new(600);
        let mut rows = Rows::empty(600);
        for i in 0..300 {
            // Two kinds of short rows, and now and then one of many terms.
            let terms = if i % 50 == 7 { 40 } else { 3 + i % 2 };
            (0..terms).for_each(|k| sum.add(i + k, 1.0 / f64::from(terms + k)));
            rows.push(&mut sum);
        }
        let shared = rows.clone().with_shared_weights();
        assert!(shared.bytes() * 3 < rows.bytes() * 2, "{} {}", shared.bytes(), rows.bytes());
        assert_eq!(shared.len(), rows.len());
        assert!((0..rows.len()).all(|i| shared.terms(i) == rows.terms(i)));
        assert!(shared.selected().is_none());
        assert_eq!(shared.in_order(&[299, 7]).dense(), rows.in_order(&[299, 7]).dense());
    }
}
