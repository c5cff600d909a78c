//! How the vertices of a level deep below the control mesh are numbered, in closed form.
//!
//! Every refinement appends one vertex per face (not under Loop) and one per edge, and every edge of a level is either one
//! that appeared inside a face some levels up or a piece of a control edge. So the vertices of level L are a list of
//! *regions*, each of equally many vertices per control vertex, face, half-edge or edge:
//!
//! ```text
//!   control vertices                                                     1 per vertex
//!   then for m = 1 … L, the vertices that level m adds:
//!     face points          m = 1                                         1 per face
//!                          m > 1                                         4^(m-2) per half-edge
//!     on edges that appeared inside faces at level j = m-1, …, 1         4^(j-1) 2^(m-1-j) per half-edge
//!     on control edges                                                   2^(m-1) per edge
//! ```
//!
//! Inside a control face the order is the same for all faces with as many corners; a [`Tile`] holds it.

use super::split::runs_forward;
use super::tile::{Cell, Tile, halves, middle};
use crate::index::{Face, HalfEdge};
use crate::kernel::vectorized;
use crate::mesh::{MAX_COUNT, MeshError};
use crate::scheme::SplitKind;
use crate::topology::{NONE, Topology};
use rayon::prelude::*;
use std::borrow::Cow;

/// Numbers of elements of a level.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Counts {
    pub vertices: usize,
    pub faces: usize,
    pub edges: usize,
    pub half_edges: usize,
}

impl Counts {
    pub fn of(t: &Topology) -> Self {
        Self {
            vertices: t.vertex_count(),
            faces: t.face_count(),
            edges: t.edge_count(),
            half_edges: t.half_edge_count(),
        }
    }

    /// One level down; refused where it overflows 32-bit indices.
    pub fn refined(self, split: SplitKind) -> Result<Self, MeshError> {
        let (face_points, faces) = match split {
            SplitKind::Quads => (self.faces, self.half_edges),
            SplitKind::Triangles => (0, 4 * self.faces),
        };
        let next = Self {
            vertices: self.vertices + face_points + self.edges,
            faces,
            edges: 2 * self.edges + self.half_edges,
            half_edges: 4 * self.half_edges,
        };
        for (what, count) in [("vertices", next.vertices), ("corners", next.half_edges), ("edges", next.edges)] {
            if count > MAX_COUNT {
                return Err(MeshError::TooLarge { what, count, limit: MAX_COUNT });
            }
        }
        Ok(next)
    }
}

/// What the vertices of a region belong to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Owner {
    Vertices,
    Faces,
    HalfEdges,
    Edges,
}

/// Consecutive vertices, `each` for every element of the control mesh.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Region {
    pub owner: Owner,
    pub each: usize,
    /// First vertex.
    pub start: usize,
}

/// The regions of level `depth`, in order.
pub(crate) fn regions(control: Counts, split: SplitKind, depth: u32) -> Vec<Region> {
    let mut out = Vec::new();
    let mut start = 0;
    let mut add = |owner, each: usize| {
        out.push(Region { owner, each, start });
        start += each
            * match owner {
                Owner::Vertices => control.vertices,
                Owner::Faces => control.faces,
                Owner::HalfEdges => control.half_edges,
                Owner::Edges => control.edges,
            };
    };
    add(Owner::Vertices, 1);
    for m in 1..=depth {
        match (split, m) {
            (SplitKind::Triangles, _) => {}
            (SplitKind::Quads, 1) => add(Owner::Faces, 1),
            (SplitKind::Quads, _) => add(Owner::HalfEdges, 1 << (2 * (m - 2))),
        }
        (1..m).rev().for_each(|j| add(Owner::HalfEdges, 1 << (2 * (j - 1) + m - 1 - j)));
        add(Owner::Edges, 1 << (m - 1));
    }
    out
}

/// For every region of edges, the places `i / 2^depth` along an edge, from its first end, that its vertices have, in order.
pub(super) fn along_edge(depth: u32) -> Vec<Vec<u32>> {
    let mut pieces: Vec<[Cell; 2]> = vec![[[0, 0], [1 << depth, 0]]];
    (0..depth)
        .map(|_| {
            let points = pieces.iter().map(|&[a, b]| middle(a, b)[0]).collect();
            pieces = pieces.iter().flat_map(|&ends| halves(ends)).collect();
            points
        })
        .collect()
}

/// Where the vertices of a level go.
pub(crate) struct Numbering {
    pub regions: Vec<Region>,
    /// The region of the centres of faces.
    pub centres: Option<usize>,
    /// The regions of edges, with the number of vertices for each edge.
    pub edge_regions: Vec<(usize, usize)>,
    /// Of a face that is one tile: for each side, run along and against the direction of its edge, the cells of the edge's
    /// vertices, region by region.
    side_cells: [[Vec<u32>; 2]; 4],
    /// Places of an edge's vertices along it, region by region.
    along: Vec<u32>,
    /// By place along an edge: vertex `start + each · e` of edge e.
    on_edge: Vec<(u32, u32)>,
    /// Of faces that are one tile.
    pub whole: Tile,
    /// Of one corner of any other face.
    pub corner: Tile,
    /// Corners of faces that are one tile.
    sides: usize,
    /// Pieces of an edge.
    steps: usize,
}

impl Numbering {
    pub fn new(control: &Topology, split: SplitKind, depth: u32) -> Self {
        let regions = regions(Counts::of(control), split, depth);
        let edge_regions: Vec<(usize, usize)> =
            regions.iter().enumerate().filter(|(_, r)| r.owner == Owner::Edges).map(|(k, r)| (k, r.each)).collect();
        let along = along_edge(depth);
        let mut on_edge = vec![(0, 0); (1 << depth) + 1];
        for (&(k, each), along) in edge_regions.iter().zip(&along) {
            for (i, &place) in along.iter().enumerate() {
                on_edge[place as usize] = ((regions[k].start + i) as u32, each as u32);
            }
        }
        let along = along.concat();
        let sides = match split {
            SplitKind::Quads => 4,
            SplitKind::Triangles => 3,
        };
        let (whole, corner) = (Tile::whole(split, depth), Tile::corner(depth.max(1)));
        let cells = |side: usize, forward: bool| {
            let place = |i: u32| if forward { i as usize } else { whole.size - i as usize };
            along.iter().map(|&i| whole.on_side(sides, side, place(i)) as u32).collect()
        };
        let side_cells = std::array::from_fn(|side| {
            [true, false].map(|forward| if side < sides { cells(side, forward) } else { Vec::new() })
        });
        let centres = regions.iter().position(|r| r.owner == Owner::Faces);
        let steps = whole.size;
        Self { regions, centres, edge_regions, side_cells, along, on_edge, whole, corner, sides, steps }
    }

    /// The cells of an edge's vertices, region by region, where the edge is side `side` of a face and runs with it or against
    /// it.
    #[inline(always)]
    pub fn side_cells(&self, sides: usize, side: usize, forward: bool) -> Cow<'_, [u32]> {
        if self.is_whole(sides) {
            return Cow::Borrowed(&self.side_cells[side][usize::from(!forward)]);
        }
        let place = |i: u32| if forward { i as usize } else { self.steps - i as usize };
        Cow::Owned(self.along.iter().map(|&i| self.on_side(sides, side, place(i)) as u32).collect())
    }

    /// True for a face that is one tile.
    #[inline(always)]
    pub fn is_whole(&self, sides: usize) -> bool {
        sides == self.sides
    }

    /// The cell `i` of `2^depth` steps along side `side` of a face; the tiles of faces that are no tile follow each other.
    #[inline(always)]
    pub fn on_side(&self, sides: usize, side: usize, i: usize) -> usize {
        if self.is_whole(sides) {
            return self.whole.on_side(sides, side, i);
        }
        let (size, cells) = (self.corner.size, self.corner.cells());
        if i <= size { side * cells + i } else { (side + 1) % sides * cells + (2 * size - i) * (size + 1) }
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        let tile = |t: &Tile| 4 * (t.order.len() + t.corners.len()) + size_of_val(&t.ranges[..]);
        let along = self.side_cells.as_flattened().iter().chain([&self.along]).map(|cells| 4 * cells.len());
        tile(&self.whole)
            + tile(&self.corner)
            + along.sum::<usize>()
            + size_of_val(&self.on_edge[..])
            + size_of_val(&self.regions[..])
            + size_of_val(&self.edge_regions[..])
    }

    /// The vertices of all faces of the level.
    pub fn write_corners(&self, t: &Topology, out: &mut [u32]) {
        let each = self.steps * self.steps;
        let chunks = (0..t.face_count()).step_by(CORNER_CHUNK).map(|f| f..(f + CORNER_CHUNK).min(t.face_count()));
        let mut rest = out;
        let mut tasks = Vec::new();
        for faces in chunks {
            let half_edges = t.face_offset[faces.end] - t.face_offset[faces.start];
            let (part, tail) = rest.split_at_mut(each * half_edges as usize);
            rest = tail;
            tasks.push((faces, part));
        }
        let whole = WholeCorners::new(self);
        let rim = || vec![0; self.sides * self.steps + 1];
        tasks.into_par_iter().for_each_init(
            || (rim(), Vec::new()),
            |(rim, vertices), (faces, mut out)| {
                vectorized(
                    #[inline(always)]
                    || {
                        for f in faces.map(Face::new) {
                            let (part, tail) = std::mem::take(&mut out).split_at_mut(each * t.sides(f));
                            out = tail;
                            if self.steps == 2 && self.sides == 4 {
                                write_children(t, f, part);
                            } else if self.is_whole(t.sides(f)) {
                                whole.number_rim(t, f, rim);
                                whole.write(t.first(f), rim, part);
                            } else {
                                self.write_corner_tiles(t, f, vertices, part);
                            }
                        }
                    },
                );
            },
        );
    }

    /// The vertices of the faces in a face of several tiles.
    fn write_corner_tiles(&self, t: &Topology, f: Face, vertices: &mut Vec<u32>, out: &mut [u32]) {
        for (corner, part) in out.chunks_exact_mut(self.steps * self.steps).enumerate() {
            self.number_corner(t, f, corner, vertices);
            part.iter_mut().zip(&self.corner.corners).for_each(|(v, &cell)| *v = vertices[cell as usize]);
        }
    }

    /// The vertex at place `i` along half-edge `h`, neither of its ends.
    #[inline(always)]
    fn on_half_edge(&self, t: &Topology, h: HalfEdge, i: usize) -> u32 {
        let e = t.edge(h);
        let place = if runs_forward(t, h) { i } else { self.steps - i };
        let (start, each) = self.on_edge[place];
        start + each * e.0
    }

    /// The vertices of all cells of the tile at a corner of any other face.
    fn number_corner(&self, t: &Topology, f: Face, corner: usize, vertices: &mut Vec<u32>) {
        let tile = &self.corner;
        let (h, size) = (t.half_edge(f, corner), tile.size);
        let prev = t.prev(h);
        vertices.resize(tile.cells(), 0);
        for (region, range) in self.regions.iter().zip(&tile.ranges) {
            let cells = &tile.order[range.clone()];
            let first = region.start as u32 + region.each as u32 * h.0;
            cells.iter().zip(first..).for_each(|(&cell, v)| vertices[cell as usize] = v);
            // The spoke of the previous half-edge runs along v = 1 as this one's runs along u = 1.
            if cells.first().is_some_and(|&cell| cell as usize % (size + 1) == size) {
                let first = region.start as u32 + region.each as u32 * prev.0;
                let along = cells.iter().map(|&cell| size * (size + 1) + cell as usize / (size + 1));
                along.zip(first..).for_each(|(cell, v)| vertices[cell] = v);
            }
        }
        vertices[0] = t.origin(h).0;
        for i in 1..=size {
            vertices[i] = self.on_half_edge(t, h, i);
            vertices[i * (size + 1)] = self.on_half_edge(t, prev, 2 * size - i);
        }
        // The first face points are the centres of control faces.
        vertices[tile.centre] = t.vertex_count() as u32 + f.0;
    }
}

/// The corners of the quads that a face becomes at level 1.
#[inline(always)]
fn write_children(t: &Topology, f: Face, out: &mut [u32]) {
    let (first, centre) = (t.first(f) as usize, t.vertex_count() as u32 + f.0);
    let first_edge_point = (t.vertex_count() + t.face_count()) as u32;
    let sides = t.sides(f);
    let mut before = first_edge_point + t.edge[first + sides - 1];
    let corners = t.origin[first..first + sides].iter().zip(&t.edge[first..first + sides]);
    for (corner, ((&v, &e), child)) in corners.zip(out.as_chunks_mut::<4>().0).enumerate() {
        let after = first_edge_point + e;
        let around = [v, after, centre, before];
        // In a quad a child's corner is its parent's; elsewhere the old vertex comes first.
        let turn = if sides == 4 { corner } else { 0 };
        for k in 0..4 {
            child[(turn + k) % 4] = around[k];
        }
        before = after;
    }
}

/// Control faces of a task that writes faces. Fixed; larger: uneven loads; smaller: overhead of tasks.
const CORNER_CHUNK: usize = 256;

/// The corners of all faces in a face that is one tile.
struct WholeCorners {
    /// Vertex `start + each · h` for a face whose first half-edge is h.
    start: Vec<u32>,
    each: Vec<u32>,
    /// Which corners lie on the rim, and where there.
    rim: Vec<(u32, u32)>,
    /// By whether a half-edge runs against its edge: vertices `start + each · e` inside it from its origin on.
    along: [Vec<(u32, u32)>; 2],
}

impl WholeCorners {
    fn new(numbering: &Numbering) -> Self {
        let tile = &numbering.whole;
        let mut affine = vec![(0, 0); tile.cells()];
        for (region, range) in numbering.regions.iter().zip(&tile.ranges) {
            for (i, &cell) in tile.order[range.clone()].iter().enumerate() {
                affine[cell as usize] = ((region.start + i) as u32, region.each as u32);
            }
        }
        let (n, sides) = (tile.size, numbering.sides);
        let mut rim_of = vec![NONE; tile.cells()];
        for side in 0..sides {
            (0..n).for_each(|i| rim_of[tile.on_side(sides, side, i)] = (side * n + i) as u32);
        }
        if numbering.centres.is_some() {
            rim_of[tile.centre] = (sides * n) as u32;
        }
        let inside = &numbering.on_edge[1..n];
        let on_rim = |(&cell, k): (&u32, u32)| Some((k, rim_of[cell as usize])).filter(|rim| rim.1 != NONE);
        Self {
            start: tile.corners.iter().map(|&cell| affine[cell as usize].0).collect(),
            each: tile.corners.iter().map(|&cell| affine[cell as usize].1).collect(),
            rim: tile.corners.iter().zip(0..).filter_map(on_rim).collect(),
            along: [inside.to_vec(), inside.iter().rev().copied().collect()],
        }
    }

    /// The vertices along the sides of a face, from corner 0 on, and its centre.
    #[inline(always)]
    fn number_rim(&self, t: &Topology, f: Face, rim: &mut [u32]) {
        let (first, steps) = (t.first(f) as usize, self.along[0].len() + 1);
        let (centre, sides) = rim.split_last_mut().expect("a centre");
        *centre = t.vertex_count() as u32 + f.0;
        let half_edges = t.origin[first..].iter().zip(&t.edge[first..]);
        for (side, (&v, &e)) in sides.chunks_exact_mut(steps).zip(half_edges) {
            // A table for each direction: which one it is cannot be predicted.
            let along = &self.along[usize::from(t.edge_vertices[e as usize][0] != v)];
            side[0] = v;
            for (out, &(start, each)) in side[1..].iter_mut().zip(along) {
                *out = start + each * e;
            }
        }
    }

    #[inline(always)]
    fn write(&self, first: u32, rim: &[u32], out: &mut [u32]) {
        for ((v, &start), &each) in out.iter_mut().zip(&self.start).zip(&self.each) {
            *v = start.wrapping_add(each.wrapping_mul(first));
        }
        self.rim.iter().for_each(|&(corner, at)| out[corner as usize] = rim[at as usize]);
    }
}
