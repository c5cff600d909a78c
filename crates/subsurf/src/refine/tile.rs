//! The vertices over one face, or one corner of it, as a grid of cells, in the order in which refinement numbers them: the split
//! carried out on places instead of vertices.

use crate::scheme::SplitKind;
use std::ops::Range;

/// A square or triangular grid of vertices: a quad or triangle of the control mesh, or the quad at one corner of another
/// face. Cell `j · (size + 1) + i` is the vertex at u = i / size, v = j / size.
pub(crate) struct Tile {
    /// Cells along a side.
    pub size: usize,
    /// The cells in the order of vertices, for all regions of half-edges and faces one after another.
    pub order: Vec<u32>,
    /// By region: its part of `order`; empty for other regions, and for a face's centre where several tiles share it.
    pub ranges: Vec<Range<usize>>,
    /// The cell of the centre of the control face, which is a vertex but in triangles.
    pub centre: usize,
    /// The corners of all faces in order.
    pub corners: Vec<u32>,
}

/// A place on the grid.
pub(super) type Cell = [u32; 2];

pub(super) fn middle(a: Cell, b: Cell) -> Cell {
    [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]
}

impl Tile {
    /// A whole quad, or triangle under Loop, refined to level `depth`.
    pub fn whole(split: SplitKind, depth: u32) -> Self {
        Self::refined(split, depth, 0)
    }

    /// The quad that one corner of another face becomes at level 1: corner 0 the old vertex, 2 the face point.
    pub fn corner(depth: u32) -> Self {
        Self::refined(SplitKind::Quads, depth, 1)
    }

    fn refined(split: SplitKind, depth: u32, first: u32) -> Self {
        let size = 1u32 << (depth - first);
        let cell = |[i, j]: Cell| j * (size + 1) + i;
        let mut faces: Vec<Vec<Cell>> = match split {
            SplitKind::Quads => vec![vec![[0, 0], [size, 0], [size, size], [0, size]]],
            SplitKind::Triangles => vec![vec![[0, 0], [size, 0], [0, size]]],
        };
        let (mut order, mut ranges): (Vec<u32>, Vec<Range<usize>>) = (Vec::new(), Vec::new());
        ranges.resize(1, 0..0);
        // Ends of the edges inside, in order, by the level where they appeared, that of the last one first.
        let mut edges: Vec<Vec<[Cell; 2]>> = Vec::new();
        if first == 1 {
            // Level 1 adds the face's centre and control edges' middles; then the spoke is an edge of this tile.
            ranges.resize(3, 0..0);
            edges.push(vec![[[size, size], [size, 0]]]);
        }
        let mut put = |points: &mut dyn Iterator<Item = Cell>| {
            let start = order.len();
            order.extend(points.map(cell));
            ranges.push(start..order.len());
        };
        for _ in first..depth {
            if split == SplitKind::Quads {
                put(&mut faces.iter().map(|f| middle(f[0], f[2])));
            }
            for group in &edges {
                put(&mut group.iter().map(|&[a, b]| middle(a, b)));
            }
            put(&mut std::iter::empty());
            for group in &mut edges {
                *group = group.iter().flat_map(|&ends| halves(ends)).collect();
            }
            let mut inside = Vec::new();
            faces = faces.iter().flat_map(|f| children(f, &mut inside)).collect();
            edges.insert(0, inside);
        }
        let corners = faces.iter().flatten().map(|&c| cell(c)).collect();
        let middle = if first == 1 { [size, size] } else { [size / 2, size / 2] };
        Self { size: size as usize, order, ranges, centre: cell(middle) as usize, corners }
    }

    /// Number of cells of the grid, those beyond the third side of a triangle included.
    pub fn cells(&self) -> usize {
        (self.size + 1) * (self.size + 1)
    }

    /// The cell `i` steps along side `side` from its corner of that number.
    pub fn on_side(&self, sides: usize, side: usize, i: usize) -> usize {
        let n = self.size;
        let (u, v) = match (sides, side) {
            (_, 0) => (i, 0),
            (4, 1) => (n, i),
            (4, 2) => (n - i, n),
            (3, 1) => (n - i, i),
            _ => (0, n - i),
        };
        v * (n + 1) + u
    }
}

/// An edge's halves, each with the new vertex first, as refinement numbers them.
pub(super) fn halves(ends: [Cell; 2]) -> [[Cell; 2]; 2] {
    let m = middle(ends[0], ends[1]);
    [[m, ends[0]], [m, ends[1]]]
}

/// The children of a face in order; adds the edges inside it.
fn children(corners: &[Cell], inside: &mut Vec<[Cell; 2]>) -> Vec<Vec<Cell>> {
    let n = corners.len();
    let on_edge = |c: usize| middle(corners[c % n], corners[(c + 1) % n]);
    if n == 3 {
        inside.extend((0..3).map(|c| [on_edge(c), on_edge(c + 2)]));
        let [a, b, c] = [0, 1, 2].map(on_edge);
        return vec![vec![corners[0], a, c], vec![a, corners[1], b], vec![c, b, corners[2]], vec![b, c, a]];
    }
    let centre = middle(corners[0], corners[2]);
    inside.extend((0..4).map(|c| [centre, on_edge(c)]));
    let child = |c: usize| {
        let mut child = vec![corners[c]; 4];
        (child[(c + 1) % 4], child[(c + 2) % 4], child[(c + 3) % 4]) = (on_edge(c), centre, on_edge(c + 3));
        child
    };
    (0..4).map(child).collect()
}
