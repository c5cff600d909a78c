//! Where every sample goes: rates per edge, and the index of every point.

mod walk;

use super::TessellateError;
use super::grid::Parts;
use super::patch_grid::{PatchGrid, on_side};
use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::limit::{Location, PatchTable};
use crate::mesh::MAX_COUNT;
use crate::scheme::SplitKind;
use crate::topology::NONE;
use std::borrow::Cow;
use std::ops::Range;
use walk::{AnyOrder, InOrder, Walked, walk};

/// Facets along edges and inside patches.
#[derive(Clone, Debug, PartialEq)]
pub enum PatchRates {
    /// The same along all edges, of which there are so many, and half of it across sub-faces.
    Uniform { rate: u32, edges: usize },
    Each {
        /// Per edge; even where a face beside it is no quad.
        edge: Vec<u32>,
        /// Per patch: across u and across v. All sub-faces of a face have the same, both equal.
        patch: Vec<[u32; 2]>,
    },
}

impl PatchRates {
    /// Facets along an edge.
    #[inline]
    pub fn edge(&self, e: Edge) -> u32 {
        match self {
            Self::Uniform { rate, .. } => *rate,
            Self::Each { edge, .. } => edge[e.index()],
        }
    }

    /// Number of edges.
    pub fn edges(&self) -> usize {
        match self {
            Self::Uniform { edges, .. } => *edges,
            Self::Each { edge, .. } => edge.len(),
        }
    }

    /// Facets across a patch of a face that has so many.
    #[inline]
    fn patch(&self, patch: usize, subfaces: u32) -> [u32; 2] {
        match self {
            Self::Uniform { rate, .. } => [if subfaces > 1 { rate / 2 } else { *rate }; 2],
            Self::Each { patch: cells, .. } => cells[patch],
        }
    }
}

pub struct Layout<'a> {
    pub table: &'a PatchTable,
    pub rates: PatchRates,
    /// Cells of whole faces and of sub-faces where all have the same, else zeros.
    pub cells: [u32; 2],
    /// Point of every vertex; nothing where that is the vertex's own number.
    vertex_point: Vec<u32>,
    /// By point, the face corner that evaluates a vertex: the lowest one outside holes.
    pub vertex_owner: Vec<u32>,
    /// By point, the number of a vertex in the order of owners; nothing where that is the order of points.
    pub vertex_slot: Vec<u32>,
    /// First point inside every edge, counted from the first of all; nothing where all edges have equally many and come in
    /// the order of their numbers. Edges come in the order of their owners.
    edge_first: Vec<u32>,
    /// The half-edge that evaluates an edge: the lowest one outside holes.
    edge_owner: Cow<'a, [u32]>,
    /// First point inside every face, counted from the first of all.
    face_first: Vec<u32>,
    /// By patch, what its face evaluates: the edges that sides lie on, and the vertices at corners; of sub-faces sides 0
    /// and 3 lie on edges, and corner 0 is a vertex.
    owned: Vec<Parts>,
    /// Vertices, and points inside the edges, that earlier chunks of faces own.
    chunk_starts: Vec<[u32; 2]>,
    /// Numbers of points at vertices, inside edges, inside faces.
    counts: [u64; 3],
}

/// Faces that a thread takes at a time, whatever the number of threads.
const CHUNK: u32 = 128;

impl<'a> Layout<'a> {
    pub fn new(table: &'a PatchTable, rates: PatchRates) -> Self {
        let cells = uniform_cells(table, &rates);
        let rates = match cells {
            [0, 0] => rates,
            [whole, of_sub] => PatchRates::Uniform { rate: whole.max(2 * of_sub), edges: rates.edges() },
        };
        let in_order = match rates {
            PatchRates::Uniform { .. } => walk(table, &rates, &mut InOrder::new(table)),
            PatchRates::Each { .. } => None,
        };
        let (walked, edge_first, edge_owner) = match in_order {
            Some(walked) => (walked, Vec::new(), Cow::Borrowed(&table.topology().edge_half_edge[..])),
            None => {
                let mut edges = AnyOrder::new(table.topology().edge_count());
                let walked = walk(table, &rates, &mut edges).expect("every order can be listed");
                (walked, edges.first, Cow::Owned(edges.owner))
            }
        };
        let Walked { mut vertex_owner, mut vertex_slot, owned, face_first, chunk_starts, counts } = walked;
        // Owners and slots by vertex become those by point.
        let mut vertex_point = Vec::new();
        if vertex_slot.contains(&NONE) {
            let mut points = 0;
            let number = |&slot: &u32| {
                let is_used = slot != NONE;
                points += u32::from(is_used);
                if is_used { points - 1 } else { NONE }
            };
            vertex_point = vertex_slot.iter().map(number).collect();
            vertex_owner.retain(|&owner| owner != NONE);
            vertex_slot.retain(|&slot| slot != NONE);
        }
        if vertex_slot.iter().enumerate().all(|(point, &slot)| point as u32 == slot) {
            vertex_slot = Vec::new();
        }
        Self {
            table,
            rates,
            cells,
            vertex_point,
            vertex_owner,
            vertex_slot,
            edge_first,
            edge_owner,
            face_first,
            owned,
            chunk_starts,
            counts,
        }
    }

    /// True where no face is a hole, or has sub-faces.
    pub fn is_plain(&self) -> bool {
        let t = self.table.topology();
        self.table.patch_count() == t.face_count() && !t.hole.contains(&true)
    }

    /// True where all faces have the same rate.
    pub fn is_uniform(&self) -> bool {
        self.cells != [0, 0]
    }

    pub fn into_rates(self) -> PatchRates {
        self.rates
    }

    pub fn check(&self, most_points: u64) -> Result<(), TessellateError> {
        let count = self.counts.iter().fold(0, |sum: u64, &count| sum.saturating_add(count));
        let limit = most_points.min(MAX_COUNT as u64);
        if count > limit {
            return Err(TessellateError::TooLarge { what: "points", count, limit });
        }
        Ok(())
    }

    pub fn points(&self) -> usize {
        self.vertices() + self.edge_points() + self.face_points()
    }

    pub fn vertices(&self) -> usize {
        self.counts[0] as usize
    }

    pub fn edge_points(&self) -> usize {
        self.counts[1] as usize
    }

    pub fn face_points(&self) -> usize {
        self.counts[2] as usize
    }

    /// Runs of faces of a size that does not depend on the number of threads.
    pub fn face_chunks(&self) -> Vec<Range<u32>> {
        let faces = self.table.topology().face_count() as u32;
        (0..faces.div_ceil(CHUNK)).map(|c| c * CHUNK..((c + 1) * CHUNK).min(faces)).collect()
    }

    /// The points inside the faces of a chunk, counted from the first face's first.
    pub fn face_range(&self, faces: &Range<u32>) -> Range<usize> {
        self.face_first[faces.start as usize] as usize..self.face_first[faces.end as usize] as usize
    }

    /// The points inside the edges that the faces of a chunk own, counted from the first edge's first.
    pub fn edge_range(&self, faces: &Range<u32>) -> Range<usize> {
        self.chunk_range(faces, 1)
    }

    /// The vertices that the faces of a chunk own, in the order of owners.
    pub fn vertex_range(&self, faces: &Range<u32>) -> Range<usize> {
        self.chunk_range(faces, 0)
    }

    fn chunk_range(&self, faces: &Range<u32>, kind: usize) -> Range<usize> {
        let chunk = (faces.start / CHUNK) as usize;
        self.chunk_starts[chunk][kind] as usize..self.chunk_starts[chunk + 1][kind] as usize
    }

    /// The first point inside an edge, counted from the first of all edges.
    #[inline]
    pub fn edge_first(&self, e: Edge) -> usize {
        match self.rates {
            PatchRates::Uniform { rate, .. } if self.edge_first.is_empty() => e.index() * (rate as usize - 1),
            _ => self.edge_first[e.index()] as usize,
        }
    }

    /// What the face of a patch evaluates: edges by the sides that lie on them, vertices by the corners.
    #[inline(always)]
    pub fn owned(&self, patch: usize) -> Parts {
        self.owned[patch]
    }

    /// The half-edge that evaluates a vertex; none where only holes use it.
    pub fn owner_of_vertex(&self, v: Vertex) -> Option<HalfEdge> {
        let point = self.vertex(v);
        (point != NONE).then(|| HalfEdge(self.vertex_owner[point as usize]))
    }

    #[inline]
    pub fn vertex(&self, v: Vertex) -> u32 {
        if self.vertex_point.is_empty() { v.0 } else { self.vertex_point[v.index()] }
    }

    /// Point `k` of `rate` along half-edge `h`, ends included.
    pub fn along(&self, h: HalfEdge, k: u32) -> u32 {
        let t = self.table.topology();
        let e = t.edge(h);
        let rate = self.rates.edge(e);
        if k == 0 {
            return self.vertex(t.origin(h));
        }
        if k == rate {
            return self.vertex(t.origin(t.next(h)));
        }
        let k = if self.runs_with_owner(h) { k } else { rate - k };
        self.vertices() as u32 + self.edge_first(e) as u32 + k - 1
    }

    /// Visits the points inside the edge of half-edge `h`, numbered along it from 1.
    #[inline]
    pub fn inside_edge(&self, h: HalfEdge, mut visit: impl FnMut(u32, u32)) {
        let e = self.table.topology().edge(h);
        let rate = self.rates.edge(e);
        let first = (self.vertices() + self.edge_first(e)) as u32;
        if self.runs_with_owner(h) {
            (1..rate).for_each(|k| visit(k, first + k - 1));
        } else {
            (1..rate).for_each(|k| visit(k, first + rate - 1 - k));
        }
    }

    /// True where `h` runs in the direction in which its edge's points are numbered.
    fn runs_with_owner(&self, h: HalfEdge) -> bool {
        let t = self.table.topology();
        // Both sides of a manifold edge run against each other.
        let owner = self.edge_owner[t.edge(h).index()];
        owner == h.0 || t.twin[h.index()] != owner && t.origin(HalfEdge(owner)) == t.origin(h)
    }

    /// The centre of a face that is no quad.
    fn centre(&self, f: Face) -> u32 {
        self.first_inside(f)
    }

    fn first_inside(&self, f: Face) -> u32 {
        (self.vertices() + self.edge_points()) as u32 + self.face_first[f.index()]
    }

    /// Point `k` along spoke `j` of a face that is no quad, from the middle of edge `j` to the centre.
    fn spoke(&self, f: Face, j: u32, k: u32) -> u32 {
        let sides = self.table.subfaces(f);
        let n = self.rates.patch(self.table.patch(f, 0), sides)[0];
        if k == n {
            return self.centre(f);
        }
        if k == 0 {
            let h = self.table.topology().half_edge(f, (j % sides) as usize);
            let rate = self.rates.edge(self.table.topology().edge(h));
            return self.along(h, rate / 2);
        }
        self.centre(f) + 1 + (j % sides) * (n - 1) + k - 1
    }

    /// True under Loop, where every patch is a triangle.
    pub fn is_triangle(&self) -> bool {
        self.table.scheme().split() == SplitKind::Triangles
    }

    pub fn grid(&self, f: Face, subface: u32) -> PatchGrid {
        let n = self.table.subfaces(f);
        let cells = self.rates.patch(self.table.patch(f, subface), n);
        let first = self.first_inside(f);
        let mut grid = PatchGrid { cells, first, is_triangle: self.is_triangle() };
        if n > 1 {
            grid.first += 1 + n * (cells[0] - 1) + subface * grid.points();
        }
        grid
    }

    /// The points along side `side` of a patch, from its corner `side` to the next.
    pub fn side(&self, f: Face, subface: u32, side: usize) -> Vec<u32> {
        let t = self.table.topology();
        let rate = |h: HalfEdge| self.rates.edge(t.edge(h));
        let n = self.table.subfaces(f);
        if n == 1 {
            let h = t.half_edge(f, side);
            return (0..=rate(h)).map(|k| self.along(h, k)).collect();
        }
        let cells = self.rates.patch(self.table.patch(f, subface), n)[0];
        let out = t.half_edge(f, subface as usize);
        let back = t.prev(out);
        let before = (subface + n - 1) % n;
        match side {
            0 => (0..=rate(out) / 2).map(|k| self.along(out, k)).collect(),
            1 => (0..=cells).map(|k| self.spoke(f, subface, k)).collect(),
            2 => (0..=cells).rev().map(|k| self.spoke(f, before, k)).collect(),
            _ => (rate(back) / 2..=rate(back)).map(|k| self.along(back, k)).collect(),
        }
    }

    /// Where point `k` along half-edge `h` lies in the face of `h`.
    pub fn edge_location(&self, h: HalfEdge, k: u32) -> Location {
        let t = self.table.topology();
        let (face, corner) = (t.face(h), h.0 - t.first(t.face(h)));
        let rate = self.rates.edge(t.edge(h));
        let part = |k: u32, of: u32| f64::from(k) / f64::from(of);
        let n = self.table.subfaces(face);
        if n == 1 {
            let [u, v] = on_side(self.is_triangle(), corner as usize, part(k, rate), part(rate - k, rate));
            return Location { face, subface: 0, u, v };
        }
        if 2 * k <= rate {
            Location { face, subface: corner, u: part(2 * k, rate), v: 0.0 }
        } else {
            Location { face, subface: (corner + 1) % n, u: 0.0, v: part(2 * (rate - k), rate) }
        }
    }

    /// Where the samples inside face `f` lie, in the order of their points.
    pub fn inner_locations(&self, f: Face, mut visit: impl FnMut(Location)) {
        let subfaces = self.table.subfaces(f);
        if subfaces > 1 {
            let n = self.grid(f, 0).cells[0];
            visit(Location { face: f, subface: 0, u: 1.0, v: 1.0 });
            for subface in 0..subfaces {
                (1..n).for_each(|k| visit(Location { face: f, subface, u: 1.0, v: f64::from(k) / f64::from(n) }));
            }
        }
        for subface in 0..subfaces {
            let grid = self.grid(f, subface);
            for (i, j) in grid.interior() {
                let [u, v] = grid.uv(i, j);
                visit(Location { face: f, subface, u, v });
            }
        }
    }

    /// Where the corner at the start of `h` lies in the face of `h`.
    pub fn corner_location(&self, h: HalfEdge) -> Location {
        self.table.corner_location(h)
    }

    /// Edges with their owners, in the order of their points.
    pub fn edges(&self) -> impl Iterator<Item = (Edge, HalfEdge)> + '_ {
        let t = self.table.topology();
        let all = (0..t.half_edge_count() as u32).map(HalfEdge);
        all.map(move |h| (t.edge(h), h)).filter(|&(e, h)| self.edge_owner[e.index()] == h.0)
    }

    /// Owner and number of every point inside an edge, in order.
    pub fn edge_samples(&self) -> Vec<(HalfEdge, u32)> {
        self.edges().flat_map(|(e, h)| (1..self.rates.edge(e)).map(move |k| (h, k))).collect()
    }
}

/// Cells of quads and of sub-faces where all have the same, and so have their edges, else zeros.
fn uniform_cells(table: &PatchTable, rates: &PatchRates) -> [u32; 2] {
    let t = table.topology();
    let every_patch_is_a_face = table.patch_count() == t.face_count();
    if let (PatchRates::Uniform { rate, .. }, true) = (rates, every_patch_is_a_face && t.hole.contains(&false)) {
        return [*rate, 0];
    }
    let mut cells = [0, 0];
    for f in (0..t.face_count() as u32).map(Face).filter(|&f| !t.is_hole(f)) {
        let subfaces = table.subfaces(f);
        let kind = usize::from(subfaces > 1);
        let [nu, nv] = rates.patch(table.patch(f, 0), subfaces);
        if nu != nv || (cells[kind] != 0 && cells[kind] != nu) {
            return [0, 0];
        }
        cells[kind] = nu;
    }
    let rate = if cells[0] > 0 { cells[0] } else { 2 * cells[1] };
    let edges_fit = match rates {
        PatchRates::Uniform { rate: along, .. } => *along == rate,
        PatchRates::Each { edge, .. } => edge.iter().all(|&n| n == rate),
    };
    if (cells[1] == 0 || 2 * cells[1] == rate) && edges_fit { cells } else { [0, 0] }
}
