//! Values of a refinement: the maps of all trees in the caller's precision, applied to the rings of control points.
//!
//! Sums are formed relative to one point of the ring, so that constants come out exactly and distance from the origin costs
//! no digits. A regular quad is refined along u, then along v; tiles with one or two levels to come are one matrix; all others are
//! one step of refinement and their children.

use super::compose::{Composer, Placed, cells_of, corners};
use super::tile_trees::{ChildKind, Node, TileTrees};
use crate::kernel::{LANES, Matrix, vectorized};
use crate::real::Real;
use crate::scheme::SplitKind;
use rayon::prelude::*;

/// Tiles with so many levels to come are one matrix. Larger: matrices of more rows than the rings of the children have
/// points; smaller: steps for tiles of a few vertices.
const DENSE_LEVELS: [usize; 2] = [2, 3];

/// Values that a grid has beyond its last one, for whole blocks to be written.
pub(super) const PADDING: usize = LANES;

/// A node in the caller's precision.
enum Map<T> {
    /// All vertices of the tile over its ring.
    Dense(Matrix<T>),
    /// The refined points over the ring.
    Step(Matrix<T>),
}

/// Trees in the caller's precision.
pub(super) struct Maps<T> {
    split: SplitKind,
    tiers: Vec<Vec<Map<T>>>,
    /// By levels to come: coefficients of a regular grid along one axis.
    regular: Vec<Regular<T>>,
    /// By levels to come: the cells of a tile that is one matrix.
    cells: Vec<Vec<(usize, usize)>>,
}

/// Coefficients of the points of a regular grid along one axis.
struct Regular<T> {
    rows: Vec<[T; 4]>,
}

impl<T: Real> Maps<T> {
    /// Rounds the weights of all nodes, in parallel.
    pub fn new(trees: &TileTrees, split: SplitKind) -> Self {
        let levels = trees.tiers.len();
        let dense = DENSE_LEVELS[usize::from(split == SplitKind::Triangles)];
        let composer = Composer { trees, split };
        let cells: Vec<Vec<(usize, usize)>> =
            (0..=levels).map(|left| if left <= dense { cells_of(split, 1 << left) } else { Vec::new() }).collect();
        let map = |tier: usize, index: usize, node: &Node| {
            let left = levels - tier;
            if node.cells.is_none() && (left > dense || node.children.len() != 4) {
                return Map::Step(step(node));
            }
            let (rows, cells) = (composer.node(tier, index), &cells[left]);
            let row = |k: usize| rows.row(Placed::alone(1 << left).cell(cells[k].0, cells[k].1));
            Map::Dense(Matrix::new(cells.len(), node.ring, |k, p| row(k)[p]))
        };
        let tiers = trees
            .tiers
            .iter()
            .enumerate()
            .map(|(tier, nodes)| nodes.par_iter().enumerate().map(|(i, node)| map(tier, i, node)).collect())
            .collect();
        let regular = (0..=levels)
            .map(|left| Regular {
                rows: trees.regular.repeated(left as u32).iter().map(|r| r.map(T::from_f64)).collect(),
            })
            .collect();
        Self { split, tiers, regular, cells }
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        let map = |map: &Map<T>| {
            let (Map::Dense(matrix) | Map::Step(matrix)) = map;
            matrix.bytes() + size_of::<Map<T>>()
        };
        self.tiers.iter().flatten().map(map).sum()
    }
}

fn step<T: Real>(node: &Node) -> Matrix<T> {
    let points = node.points.len();
    let mut dense = vec![0.0; points * node.ring];
    for point in 0..points {
        node.points.terms(point).iter().for_each(|&(p, w)| dense[point * node.ring + p as usize] += w);
    }
    Matrix::new(points, node.ring, |i, p| dense[i * node.ring + p])
}

/// Fills grids of cells with values; keeps its memory.
pub(super) struct Filler<'a, T, const N: usize> {
    trees: &'a TileTrees,
    maps: &'a Maps<T>,
    /// Refined points, by tier.
    points: Vec<Vec<[T; N]>>,
    ring: Vec<[T; N]>,
    tile: Vec<[T; N]>,
    curves: Vec<[T; LANES]>,
}

impl<'a, T: Real, const N: usize> Filler<'a, T, N> {
    pub fn new(trees: &'a TileTrees, maps: &'a Maps<T>) -> Self {
        let points = maps.tiers.iter().map(|_| Vec::new()).collect();
        Self { trees, maps, points, ring: Vec::new(), tile: Vec::new(), curves: Vec::new() }
    }

    /// All vertices of root `root`, whose ring is given relative to `base`; tiles one after another where the face is no
    /// quad.
    pub fn root(&mut self, root: usize, ring: &[[T; N]], base: [T; N], size: usize, out: &mut [[T; N]]) {
        self.node(0, root, ring, base, Placed::alone(size), size, out);
    }

    /// All vertices of a quad with four plain corners, and [`PADDING`] more.
    #[inline(always)]
    pub fn plain(&mut self, ring: &[[T; N]; 16], base: [T; N], size: usize, out: &mut [[T; N]]) {
        self.maps.regular[size.ilog2() as usize].fill(ring, base, &mut self.curves, out);
    }

    #[allow(clippy::too_many_arguments)]
    fn node(
        &mut self,
        tier: usize,
        node: usize,
        ring: &[[T; N]],
        base: [T; N],
        at: Placed,
        size: usize,
        out: &mut [[T; N]],
    ) {
        let matrix = match &self.maps.tiers[tier][node] {
            Map::Dense(matrix) => return self.dense(matrix, ring, base, at, size, out),
            Map::Step(matrix) => matrix,
        };
        let mut points = std::mem::take(&mut self.points[tier]);
        points.resize(matrix.samples(), [T::default(); N]);
        let to = &mut points[..];
        vectorized(
            #[inline(always)]
            || matrix.apply(ring, [T::default(); N], to),
        );
        let children = &self.trees.tiers[tier][node].children;
        let split = self.maps.split;
        for (c, child) in children.iter().enumerate() {
            let (at, size) = if children.len() == 4 {
                (at.child(split, size, c), size / 2)
            } else {
                (Placed { origin: at.origin + c * (size + 1) * (size + 1), ..at }, size)
            };
            match child.kind {
                ChildKind::Node(node) => {
                    let mut ring = std::mem::take(&mut self.ring);
                    ring.clear();
                    ring.extend(child.ring.iter().map(|&p| points[p as usize]));
                    self.node(tier + 1, node as usize, &ring, base, at, size, out);
                    self.ring = ring;
                }
                ChildKind::Regular => {
                    let ring = std::array::from_fn(|k| points[child.ring[k] as usize]);
                    let mut tile = std::mem::take(&mut self.tile);
                    tile.resize((size + 1) * (size + 1) + PADDING, [T::default(); N]);
                    vectorized(
                        #[inline(always)]
                        || self.plain(&ring, base, size, &mut tile),
                    );
                    copy_rows(&tile, at, size, out);
                    self.tile = tile;
                }
                ChildKind::Corners => {
                    for (&(i, j), &p) in corners(split).iter().zip(&child.ring) {
                        let point = points[p as usize];
                        out[at.cell(i, j)] = std::array::from_fn(|c| base[c] + point[c]);
                    }
                }
            }
        }
        self.points[tier] = points;
    }

    fn dense(
        &mut self,
        matrix: &Matrix<T>,
        ring: &[[T; N]],
        base: [T; N],
        at: Placed,
        size: usize,
        out: &mut [[T; N]],
    ) {
        self.tile.resize(matrix.samples(), [T::default(); N]);
        let tile = &mut self.tile[..];
        vectorized(
            #[inline(always)]
            || matrix.apply(ring, base, tile),
        );
        if self.maps.split == SplitKind::Quads {
            return copy_rows(tile, at, size, out);
        }
        let cells = &self.maps.cells[size.ilog2() as usize];
        cells.iter().zip(tile).for_each(|(&(i, j), value)| out[at.cell(i, j)] = *value);
    }
}

/// Rows of a tile by itself into the grid that it is part of.
fn copy_rows<V: Copy>(tile: &[V], at: Placed, size: usize, out: &mut [V]) {
    for (j, row) in tile.chunks_exact(size + 1).take(size + 1).enumerate() {
        let start = at.cell(0, j);
        out[start..start + size + 1].iter_mut().zip(row).for_each(|(to, from)| *to = *from);
    }
}

impl<T: Real> Regular<T> {
    /// Along u for all four rows of points at once, then along v for whole rows of values at once. Rows are written in whole
    /// blocks, and what one writes beyond its end the next one overwrites: `out` has [`PADDING`] values more.
    #[inline(always)]
    fn fill<const N: usize>(
        &self,
        ring: &[[T; N]; 16],
        base: [T; N],
        curves: &mut Vec<[T; LANES]>,
        out: &mut [[T; N]],
    ) {
        let length = self.rows.len() * N;
        let blocks = length.div_ceil(LANES);
        curves.resize(5 * blocks, [T::default(); LANES]);
        let flat = curves.as_flattened_mut();
        let width = blocks * LANES;
        if 4 * N <= LANES {
            // Columns of the ring, one component of one row to a lane.
            let mut columns = [[T::default(); LANES]; 4];
            for (x, column) in columns.iter_mut().enumerate() {
                for y in 0..4 {
                    column[y * N..][..N].copy_from_slice(&ring[4 * y + x]);
                }
            }
            for (i, a) in self.rows.iter().enumerate() {
                let mut sum = [T::default(); LANES];
                for lane in 0..LANES {
                    let p = |x: usize| columns[x][lane];
                    sum[lane] = a[0] * p(0) + a[1] * p(1) + a[2] * p(2) + a[3] * p(3);
                }
                for y in 0..4 {
                    flat[y * width + i * N..][..N].copy_from_slice(&sum[y * N..][..N]);
                }
            }
        } else {
            for (i, a) in self.rows.iter().enumerate() {
                for y in 0..4 {
                    for c in 0..N {
                        let p = |x: usize| ring[4 * y + x][c];
                        flat[y * width + i * N + c] = a[0] * p(0) + a[1] * p(1) + a[2] * p(2) + a[3] * p(3);
                    }
                }
            }
        }
        (0..self.rows.len()).for_each(|i| flat[4 * width + i * N..][..N].copy_from_slice(&base));
        let flat = out.as_flattened_mut();
        // From the last block to the first: what one writes beyond its row belongs to the first block of the next row.
        for k in (0..blocks).rev() {
            let [p, q, r, s, base] = [0, 1, 2, 3, 4].map(|y| curves[y * blocks + k]);
            for (j, b) in self.rows.iter().enumerate() {
                let part = &mut flat[j * length + k * LANES..][..LANES];
                for lane in 0..LANES {
                    let sum = b[0] * p[lane] + b[1] * q[lane] + b[2] * r[lane] + b[3] * s[lane];
                    part[lane] = base[lane] + sum;
                }
            }
        }
    }
}
