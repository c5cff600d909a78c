//! Where the vertices of level m lie, for m ≥ 1, when half-edges are known: the numbering of
//! [`Numbering`](super::super::numbering::Numbering) read from the place to the number.
//!
//! Seen from half-edge h, which starts at V, a *quadrant* of its face has the cells (a, b), in steps of which an edge has
//! `size = 2^m`:
//!
//! ```text
//!   E(prev h) = (0, half) ──────── F = (half, half)
//!       │                          │  spoke of h
//!       │                          │
//!       V = (0, 0) ─────────── E(h) = (half, 0)
//! ```

use super::super::numbering::{Counts, Owner, along_edge, regions};
use super::super::tile::Tile;
use super::sides::{Beside, Sides, Walk};
use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::scheme::SplitKind;
use crate::topology::Topology;

/// A vertex `start + each · i` that belongs to element i.
pub(super) type Affine = (u32, u32);

/// The vertices of one level.
pub(super) struct Places {
    /// Pieces of an edge.
    pub size: usize,
    /// By steps along an edge, from its first end and from its second; the ends are not to be asked for.
    on_edge: [Vec<Affine>; 2],
    /// By corner of a quad, or corner 0 for any other face: cells (a, b) inside the quadrant.
    quadrant: [Vec<Affine>; 4],
    /// By steps from E(h) along the spoke of h.
    spoke: Vec<Affine>,
    /// By corner of a quad, at last for any other face: the row of vertices next to the side, from place 1 to the middle by
    /// the half-edge, and beyond by the next one. Nothing at level 1, where the face's centre is the only one.
    beside: [[Vec<Affine>; 2]; 5],
    /// By cell of a quad: the vertex there by the first half-edge. On the sides and in the centre it means nothing.
    pub inside: Vec<Affine>,
    /// The cells along the sides of a quad, corner 0 first.
    pub rim: Vec<u32>,
    centres: u32,
}

impl Places {
    pub fn new(control: Counts, level: u32) -> Self {
        let regions = regions(control, SplitKind::Quads, level);
        let tile = Tile::whole(SplitKind::Quads, level);
        let (size, half) = (tile.size, tile.size / 2);
        let mut inside = vec![(0, 0); tile.cells()];
        // By cell: its vertex by half-edge, that of the corner in whose quadrant it lies.
        let mut affine = vec![(0, 0); tile.cells()];
        for (region, range) in regions.iter().zip(&tile.ranges).filter(|(_, range)| !range.is_empty()) {
            let cells = &tile.order[range.clone()];
            for (i, &cell) in cells.iter().enumerate() {
                affine[cell as usize] = ((region.start + i % region.each) as u32, region.each as u32);
                inside[cell as usize] = ((region.start + i) as u32, region.each as u32);
            }
        }
        let edge_regions = regions.iter().filter(|region| region.owner == Owner::Edges);
        let mut forward = vec![(0, 0); size + 1];
        for (region, along) in edge_regions.zip(along_edge(level)) {
            for (i, &place) in along.iter().enumerate() {
                forward[place as usize] = ((region.start + i) as u32, region.each as u32);
            }
        }
        let cell = |corner: usize, a: usize, b: usize| {
            let (i, j) = [(a, b), (size - b, a), (size - a, size - b), (b, size - a)][corner];
            affine[j * (size + 1) + i]
        };
        let quadrant = std::array::from_fn(|corner| {
            let rows = (1..half).flat_map(|b| (1..half).map(move |a| (a, b)));
            rows.map(|(a, b)| cell(corner, a, b)).collect()
        });
        let beside = std::array::from_fn(|side| {
            let (own, next) = if side == 4 { (0, 0) } else { (side, (side + 1) % 4) };
            if half == 1 {
                return [Vec::new(), Vec::new()];
            }
            let first = (1..=half).map(|i| cell(own, i, 1)).collect();
            [first, (half + 1..size).map(|i| cell(next, 1, size - i)).collect()]
        });
        let backward = forward.iter().rev().copied().collect();
        let rim = (0..4).flat_map(|side| (0..size).map(move |i| (side, i)));
        Self {
            size,
            on_edge: [forward, backward],
            quadrant,
            spoke: (0..half).map(|b| cell(0, half, b)).collect(),
            beside,
            inside,
            rim: rim.map(|(side, i)| tile.on_side(4, side, i) as u32).collect(),
            centres: control.vertices as u32,
        }
    }

    /// The vertices of a quad, cell by cell.
    #[inline(always)]
    pub fn of_quad(&self, t: &Topology, sides: &Sides, f: Face, out: &mut [u32]) {
        let first = t.first(f);
        for (v, &(start, each)) in out.iter_mut().zip(&self.inside) {
            *v = start.wrapping_add(each.wrapping_mul(first));
        }
        out[self.inside.len() / 2] = self.centres + f.0;
        for (rim, h) in self.rim.chunks_exact(self.size).zip((first..).map(HalfEdge)) {
            out[rim[0] as usize] = t.origin(h).0;
            let (e, backward) = sides.get(h);
            for (&cell, &(start, each)) in rim[1..].iter().zip(self.along(backward)) {
                out[cell as usize] = start + each * e.0;
            }
        }
    }

    /// The vertices along an edge but its ends, from its first end or from its second.
    #[inline(always)]
    pub fn along(&self, backward: bool) -> &[Affine] {
        &self.on_edge[usize::from(backward)][1..self.size]
    }

    /// The vertex `steps` along a half-edge, none of its ends.
    #[inline(always)]
    pub fn on_half_edge<const QUADS: bool>(&self, walk: Walk<'_, QUADS>, h: HalfEdge, steps: usize) -> u32 {
        let (e, backward) = walk.sides.get(h);
        let (start, each) = self.on_edge[usize::from(backward)][steps];
        start + each * e.0
    }

    /// The neighbour of an end of an edge along it.
    pub fn near_end(&self, t: &Topology, e: Edge, v: Vertex) -> u32 {
        let (start, each) = self.on_edge[usize::from(t.edge_vertices(e)[0] != v)][1];
        start + each * e.0
    }

    /// The vertex of the quadrant of `h` across the diagonal from where it starts.
    #[inline(always)]
    pub fn diagonal(&self, h: HalfEdge, beside: &Beside) -> u32 {
        if self.size == 2 {
            return self.centres + beside.face;
        }
        let (start, each) = self.quadrant[beside.corner.unwrap_or(0)][0];
        start + each * h.0
    }

    /// The row of vertices next to a half-edge on its left, in the direction of its edge.
    #[inline(always)]
    pub fn beside<const QUADS: bool>(&self, walk: Walk<'_, QUADS>, h: HalfEdge, out: &mut [u32]) {
        let Beside { next, prev, face, corner } = walk.beside(h);
        out[0] = self.on_half_edge(walk, prev, self.size - 1);
        out[self.size] = self.on_half_edge(walk, next, 1);
        if self.size == 2 {
            out[1] = self.centres + face;
        } else {
            let [first, second] = &self.beside[corner.unwrap_or(4)];
            let (to_first, to_second) = out[1..self.size].split_at_mut(first.len());
            to_first.iter_mut().zip(first).for_each(|(v, &(start, each))| *v = start + each * h.0);
            to_second.iter_mut().zip(second).for_each(|(v, &(start, each))| *v = start + each * next.0);
        }
        if walk.sides.get(h).1 {
            out[..=self.size].reverse();
        }
    }

    /// The vertex at cell (a, b) of the quadrant of `h`; its face is no quad.
    pub fn cell(&self, walk: Walk<'_, false>, h: HalfEdge, a: usize, b: usize) -> u32 {
        let t = walk.t;
        let half = self.size / 2;
        let spoke = |h: HalfEdge, steps: usize| self.spoke[steps].0 + self.spoke[steps].1 * h.0;
        match (a, b) {
            (0, 0) => t.origin(h).0,
            (a, 0) => self.on_half_edge(walk, h, a),
            (0, b) => self.on_half_edge(walk, t.prev(h), self.size - b),
            (a, b) if a == half && b == half => self.centres + t.face(h).0,
            (a, b) if a == half => spoke(h, b),
            (a, b) if b == half => spoke(t.prev(h), a),
            (a, b) => {
                let (start, each) = self.quadrant[0][(b - 1) * (half - 1) + a - 1];
                start + each * h.0
            }
        }
    }

    pub fn bytes(&self) -> usize {
        let lists = self
            .quadrant
            .iter()
            .chain(&self.on_edge)
            .chain([&self.spoke, &self.inside])
            .chain(self.beside.as_flattened());
        size_of::<Affine>() * lists.map(Vec::len).sum::<usize>() + 4 * self.rim.len()
    }
}
