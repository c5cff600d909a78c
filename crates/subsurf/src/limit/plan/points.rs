//! The refined points of a step: rows over the points of the node above. Nodes that differ in the values of finite sharpness alone
//! share all but the weights that depend on these, which lie one after the other in one array per generation.

use super::super::rows::Rows;
use std::sync::Arc;

/// The refined points that the children of a node need, over those of the node.
pub(super) struct Points {
    pub step: Arc<Step>,
    /// In the place of the step's, the weights of rows from [`Step::varying`] on.
    pub weights: Option<OwnWeights>,
}

/// Weights of a node, from `start` on among those of its generation.
pub(super) struct OwnWeights {
    pub all: Arc<Vec<f64>>,
    pub start: usize,
}

/// What nodes share of a step.
pub(super) struct Step {
    /// The first rows, which all steps of a fan's shape share.
    pub shared: Option<Arc<Rows>>,
    /// The rows after these.
    pub own: Rows,
    /// How many of `own` come before the first whose weights differ from node to node.
    pub varying: usize,
    /// The children's control points among the rows.
    pub rings: Arc<Rings>,
}

/// The rings of a node's children, one after the other.
#[derive(Default)]
pub(super) struct Rings {
    points: Vec<u32>,
    ends: Vec<u32>,
}

impl Rings {
    pub fn push(&mut self, ring: impl IntoIterator<Item = u32>) {
        self.points.extend(ring);
        self.ends.push(self.points.len() as u32);
    }

    /// The ring of child `c`.
    pub fn get(&self, c: usize) -> &[u32] {
        let start = if c == 0 { 0 } else { self.ends[c - 1] as usize };
        &self.points[start..self.ends[c] as usize]
    }

    /// The same without room for more.
    pub fn shrunk(mut self) -> Self {
        self.points.shrink_to_fit();
        self.ends.shrink_to_fit();
        self
    }

    /// The same with other numbers of points.
    pub fn renumbered(&self, number: impl Fn(u32) -> u32) -> Self {
        Self { points: self.points.iter().map(|&p| number(p)).collect(), ends: self.ends.clone() }
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        4 * (self.points.capacity() + self.ends.capacity())
    }
}

impl Step {
    /// A step with no weights that differ.
    pub fn new(shared: Option<Arc<Rows>>, own: Rows, rings: Arc<Rings>) -> Self {
        let varying = own.len();
        Self { shared, own, varying, rings }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.shared_len() + self.own.len()
    }

    pub fn shared_len(&self) -> usize {
        self.shared.as_ref().map_or(0, |rows| rows.len())
    }
}

impl Points {
    /// Of a node by itself, whose weights need no places of their own.
    pub fn new(mut step: Step) -> Self {
        step.own = step.own.with_shared_weights();
        Self { step: Arc::new(step), weights: None }
    }

    pub fn len(&self) -> usize {
        self.step.len()
    }

    /// Columns and weights of row `i`.
    #[inline(always)]
    pub fn terms(&self, i: usize) -> (&[u32], &[f64]) {
        let Step { shared, own, varying, .. } = &*self.step;
        let before = match shared {
            Some(shared) if i < shared.len() => return shared.terms(i),
            Some(shared) => shared.len(),
            None => 0,
        };
        let i = i - before;
        let (columns, weights) = own.terms(i);
        match &self.weights {
            Some(OwnWeights { all, start }) if i >= *varying => {
                let from = start + (own.start(i) - own.start(*varying));
                (columns, &all[from..from + columns.len()])
            }
            _ => (columns, weights),
        }
    }

    pub fn row(&self, i: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let (columns, weights) = self.terms(i);
        columns.iter().copied().zip(weights.iter().copied())
    }

    /// `out += left · rows`, a row vector over some of the points from the left.
    pub fn left_multiply_some(&self, left: &[f64], rows: &[u32], out: &mut [f64]) {
        for (&i, &w) in rows.iter().zip(left) {
            if w != 0.0 {
                self.row(i as usize).for_each(|(c, x)| out[c as usize] += w * x);
            }
        }
    }

    /// Heap memory in bytes; `once` takes what may be shared for what it is when it meets it first, and for nothing later.
    pub fn bytes(&self, mut once: impl FnMut(*const u8, usize) -> usize) -> usize {
        // With the two counts of references.
        const COUNTS: usize = 2 * size_of::<usize>();
        let step = &self.step;
        let shared = step
            .shared
            .as_ref()
            .map_or(0, |rows| once(Arc::as_ptr(rows).cast(), COUNTS + size_of::<Rows>() + rows.bytes()));
        let rings = once(Arc::as_ptr(&step.rings).cast(), COUNTS + size_of::<Rings>() + step.rings.bytes());
        let own = once(Arc::as_ptr(step).cast(), COUNTS + size_of::<Step>() + step.own.bytes());
        let weights = self.weights.as_ref().map_or(0, |OwnWeights { all, .. }| {
            once(Arc::as_ptr(all).cast(), COUNTS + size_of::<Vec<f64>>() + 8 * all.capacity())
        });
        shared + rings + own + weights
    }
}
