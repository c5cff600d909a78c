//! Trees multiplied out: rows of weights over a ring in the place of values, in `f64`. The only place where weights of several
//! levels are put together.

use super::tile_trees::{ChildKind, RegularStep, TileTrees};
use crate::kernel::vectorized;
use crate::scheme::SplitKind;

/// Where a tile lies in a grid of cells: its corner 0, and whether its axes run backwards (the middle child of a triangle).
#[derive(Clone, Copy)]
pub(crate) struct Placed {
    pub origin: usize,
    pub backwards: bool,
    /// Cells from row to row.
    pub stride: usize,
}

impl Placed {
    /// A grid by itself.
    pub fn alone(size: usize) -> Self {
        Self { origin: 0, backwards: false, stride: size + 1 }
    }

    #[inline(always)]
    pub fn cell(self, i: usize, j: usize) -> usize {
        let step = j * self.stride + i;
        if self.backwards { self.origin - step } else { self.origin + step }
    }

    /// Child `c` of a tile of `size` cells along a side.
    pub fn child(self, split: SplitKind, size: usize, c: usize) -> Self {
        let half = size / 2;
        let (i, j, backwards) = match (split, c) {
            (_, 0) => (0, 0, false),
            (_, 1) => (half, 0, false),
            (SplitKind::Quads, 2) => (half, half, false),
            (SplitKind::Quads, _) | (_, 2) => (0, half, false),
            (SplitKind::Triangles, _) => (half, half, true),
        };
        Self { origin: self.cell(i, j), backwards: self.backwards != backwards, ..self }
    }
}

/// Rows of weights, all of one width.
pub(crate) struct WeightRows {
    pub width: usize,
    pub weights: Vec<f64>,
}

impl WeightRows {
    pub fn zeros(rows: usize, width: usize) -> Self {
        Self { width, weights: vec![0.0; rows * width] }
    }

    #[inline(always)]
    pub fn row(&self, row: usize) -> &[f64] {
        &self.weights[row * self.width..(row + 1) * self.width]
    }

    #[inline(always)]
    fn row_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.weights[row * self.width..(row + 1) * self.width]
    }

    /// Rows of the identity.
    pub fn identity(width: usize) -> Self {
        let mut out = Self::zeros(width, width);
        (0..width).for_each(|i| out.weights[i * width + i] = 1.0);
        out
    }

    /// `self[row] += weight · from[other]`.
    #[inline(always)]
    fn add(&mut self, row: usize, weight: f64, from: &Self, other: usize) {
        self.row_mut(row).iter_mut().zip(from.row(other)).for_each(|(sum, x)| *sum += weight * x);
    }
}

/// Writes the weights of all vertices of a tile, made of `points`, into a grid of cells.
pub(crate) struct Composer<'a> {
    pub trees: &'a TileTrees,
    pub split: SplitKind,
}

impl Composer<'_> {
    /// All vertices of node `node` of tier `tier`, over its own ring; cells of several tiles one after another where the
    /// node is a face that is no quad.
    pub fn node(&self, tier: usize, node: usize) -> WeightRows {
        let of_node = &self.trees.tiers[tier][node];
        let left = self.trees.tiers.len() - tier;
        let is_single = of_node.is_tile();
        let size = 1usize << if is_single { left } else { left - 1 };
        let tiles = if is_single { 1 } else { of_node.children.len() };
        let ring = WeightRows::identity(of_node.ring);
        let mut out = WeightRows::zeros(tiles * (size + 1) * (size + 1), of_node.ring);
        self.fill_node(tier, node, &ring, Placed::alone(size), size, &mut out);
        out
    }

    fn fill_node(&self, tier: usize, node: usize, ring: &WeightRows, at: Placed, size: usize, out: &mut WeightRows) {
        let node = &self.trees.tiers[tier][node];
        let mut points = WeightRows::zeros(node.points.len(), ring.width);
        vectorized(
            #[inline(always)]
            || {
                for point in 0..node.points.len() {
                    node.points.terms(point).iter().for_each(|&(p, w)| points.add(point, w, ring, p as usize));
                }
            },
        );
        if let Some(cells) = &node.cells {
            for (&(i, j), k) in cells_of(self.split, size).iter().zip(0..) {
                let cell = at.cell(i, j);
                out.row_mut(cell).fill(0.0);
                cells.terms(k).iter().for_each(|&(p, w)| out.add(cell, w, &points, p as usize));
            }
        }
        let is_single = node.is_tile();
        for (c, child) in node.children.iter().enumerate() {
            let (at, size) = if is_single {
                (at.child(self.split, size, c), size / 2)
            } else {
                (Placed { origin: at.origin + c * (size + 1) * (size + 1), ..at }, size)
            };
            let mut ring = WeightRows { width: ring.width, weights: Vec::with_capacity(child.ring.len() * ring.width) };
            child.ring.iter().for_each(|&p| ring.weights.extend_from_slice(points.row(p as usize)));
            match child.kind {
                ChildKind::Node(node) => self.fill_node(tier + 1, node as usize, &ring, at, size, out),
                ChildKind::Regular => fill_regular(&self.trees.regular, &ring, at, size, out),
                ChildKind::Corners => self.fill_corners(&ring, at, out),
            }
        }
    }

    fn fill_corners(&self, ring: &WeightRows, at: Placed, out: &mut WeightRows) {
        for (corner, (i, j)) in corners(self.split).iter().enumerate() {
            out.row_mut(at.cell(*i, *j)).copy_from_slice(ring.row(corner));
        }
    }
}

/// All vertices of a tile, row by row.
pub(crate) fn cells_of(split: SplitKind, size: usize) -> Vec<(usize, usize)> {
    let length = |j: usize| if split == SplitKind::Quads { size } else { size - j };
    (0..=size).flat_map(|j| (0..=length(j)).map(move |i| (i, j))).collect()
}

/// Cells of the corners of a tile of one cell.
pub(crate) fn corners(split: SplitKind) -> &'static [(usize, usize)] {
    match split {
        SplitKind::Quads => &[(0, 0), (1, 0), (1, 1), (0, 1)],
        SplitKind::Triangles => &[(0, 0), (1, 0), (0, 1)],
    }
}

/// All vertices of a regular quad, over any rows of its sixteen points: along u, then along v.
pub(crate) fn fill_regular(step: &RegularStep, ring: &WeightRows, at: Placed, size: usize, out: &mut WeightRows) {
    vectorized(
        #[inline(always)]
        || refine_regular(step, ring, at, size, out),
    );
}

#[inline(always)]
fn refine_regular(step: &RegularStep, ring: &WeightRows, at: Placed, size: usize, out: &mut WeightRows) {
    let along = step.repeated(size.ilog2());
    let mut curves = WeightRows::zeros(4 * (size + 1), ring.width);
    for y in 0..4 {
        for (i, row) in along.iter().enumerate() {
            (0..4).filter(|&x| row[x] != 0.0).for_each(|x| curves.add(y * (size + 1) + i, row[x], ring, 4 * y + x));
        }
    }
    for (j, row) in along.iter().enumerate() {
        for i in 0..=size {
            let cell = at.cell(i, j);
            // Neighbouring tiles have written the same along the sides that they share.
            out.row_mut(cell).fill(0.0);
            (0..4).filter(|&y| row[y] != 0.0).for_each(|y| out.add(cell, row[y], &curves, y * (size + 1) + i));
        }
    }
}
