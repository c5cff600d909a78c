//! Bases of leaves that are no products of two curves, at grid points: closed forms at special vertices, and quartic patches
//! under Loop. Each is made when it is first needed, and shared by all plans that have such a leaf.

use super::grid::Grid;
use super::grid_weights::spanning;
use crate::limit::box_spline;
use crate::limit::corner::Corner;
use crate::limit::special::SpecialVertex;
use std::collections::HashMap;
use std::sync::{Arc, OnceLock, PoisonError, RwLock};

/// Largest grid whose bases are kept. Larger: memory, half a kilobyte for each point of a grid and kind of special
/// vertex; smaller: points at special vertices are made anew for every plan, or for every face that goes by values, a microsecond
/// or two each.
pub(super) const MOST_KEPT: u32 = 64;

/// Weights of position and two derivatives over the points of a leaf.
type Weights = [Vec<f64>; 3];

/// The bases of a grid.
pub(super) struct LeafBases {
    grid: Grid,
    count: usize,
    quartic: OnceLock<Arc<[OnceLock<Weights>]>>,
    special: RwLock<HashMap<Corner, Arc<[OnceLock<Weights>]>>>,
}

/// The basis of a leaf.
pub(super) struct Basis<'v> {
    grid: Grid,
    count: usize,
    /// A quartic patch where there is none.
    vertex: Option<&'v SpecialVertex>,
    /// By grid point; none where they are not kept.
    kept: Arc<[OnceLock<Weights>]>,
}

impl LeafBases {
    /// None yet, of `count` weights, 1 or 3.
    pub fn new(grid: Grid, count: usize) -> Self {
        Self { grid, count, quartic: OnceLock::new(), special: RwLock::default() }
    }

    /// That of a special vertex, or of a quartic patch.
    pub fn of<'v>(&self, vertex: Option<&'v SpecialVertex>) -> Basis<'v> {
        let lines = if self.grid.cells <= MOST_KEPT { self.grid.cells as usize + 1 } else { 0 };
        let new = || -> Arc<[OnceLock<Weights>]> { (0..lines * lines).map(|_| OnceLock::new()).collect() };
        let kept = match vertex {
            None => self.quartic.get_or_init(new).clone(),
            Some(vertex) => self.known(vertex.corner).unwrap_or_else(|| {
                let mut all = self.special.write().unwrap_or_else(PoisonError::into_inner);
                all.entry(vertex.corner).or_insert_with(new).clone()
            }),
        };
        Basis { grid: self.grid, count: self.count, vertex, kept }
    }

    fn known(&self, corner: Corner) -> Option<Arc<[OnceLock<Weights>]>> {
        self.special.read().unwrap_or_else(PoisonError::into_inner).get(&corner).cloned()
    }
}

impl Basis<'_> {
    /// Calls `f` with the weights at a grid point.
    #[inline(always)]
    pub fn with<R>(&self, point: [u32; 2], f: impl FnOnce(&Weights) -> R) -> R {
        let [i, j] = point.map(|x| x as usize);
        match self.kept.get(j * (self.grid.cells as usize + 1) + i) {
            Some(slot) => f(slot.get_or_init(|| self.weights(point))),
            None => f(&self.weights(point)),
        }
    }

    fn weights(&self, point: [u32; 2]) -> Weights {
        let [u, v] = self.grid.uv(point);
        match self.vertex {
            Some(vertex) => spanning(vertex.weights(u, v, self.count), vertex.points()),
            None => {
                let [position, du, dv, ..] = box_spline::basis(u, v, self.count);
                [position, du, dv].map(|row| row[..12].to_vec())
            }
        }
    }
}
