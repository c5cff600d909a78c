//! Where every sample goes: rates per edge, and the index of every point.

use super::TessellateError;
use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::limit::{Location, PatchTable};
use crate::mesh::MAX_COUNT;
use crate::scheme::SplitKind;
use crate::topology::NONE;
use std::ops::Range;

/// Facets along edges and inside patches.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct PatchRates {
    /// Per edge; even where a face beside it is no quad.
    pub edge: Vec<u32>,
    /// Per patch: across u and across v. All sub-faces of a face have the same, both equal.
    pub patch: Vec<[u32; 2]>,
}

/// A grid of facets over one patch.
#[derive(Clone, Copy)]
pub(super) struct PatchGrid {
    /// Facets across u and v; both the same for triangles.
    pub cells: [u32; 2],
    /// First interior point.
    pub first: u32,
    pub is_triangle: bool,
}

impl PatchGrid {
    /// Interior point `(i, j)`, both from 1.
    pub fn inner(&self, i: u32, j: u32) -> u32 {
        let n = self.cells[0];
        if self.is_triangle {
            // Row j has n - 1 - j points.
            return self.first + (j - 1) * (n - 1) - (j - 1) * j / 2 + i - 1;
        }
        self.first + (j - 1) * (n - 1) + i - 1
    }

    /// Number of interior points.
    pub fn points(&self) -> u32 {
        inner_points(self.is_triangle, self.cells.map(u64::from)) as u32
    }

    /// All interior points `(i, j)` in order.
    pub fn interior(self) -> impl Iterator<Item = (u32, u32)> {
        let [nu, nv] = self.cells;
        let row = move |j: u32| if self.is_triangle { 1..nu.saturating_sub(j) } else { 1..nu };
        (1..nv).flat_map(move |j| row(j).map(move |i| (i, j)))
    }

    /// Parameters of grid point `(i, j)`.
    pub fn uv(&self, i: u32, j: u32) -> [f64; 2] {
        [f64::from(i) / f64::from(self.cells[0]), f64::from(j) / f64::from(self.cells[1])]
    }
}

fn inner_points(is_triangle: bool, [nu, nv]: [u64; 2]) -> u64 {
    if is_triangle { (nu - 1) * nu.saturating_sub(2) / 2 } else { (nu - 1) * (nv - 1) }
}

pub(super) struct Layout<'a> {
    pub table: &'a PatchTable,
    pub rates: PatchRates,
    /// Point of every vertex.
    vertex_point: Vec<u32>,
    /// The face corner that evaluates a vertex: the lowest one outside holes.
    pub vertex_owner: Vec<u32>,
    /// First point inside every edge.
    edge_first: Vec<u64>,
    /// The half-edge that evaluates an edge: the lowest one outside holes.
    pub edge_owner: Vec<u32>,
    /// First point inside every face.
    face_first: Vec<u64>,
    vertices: usize,
}

impl<'a> Layout<'a> {
    pub fn new(table: &'a PatchTable, rates: PatchRates) -> Self {
        let t = table.topology();
        let is_triangle = table.scheme().split() == SplitKind::Triangles;
        let mut vertex_owner = vec![NONE; t.vertex_count()];
        let mut edge_owner = vec![NONE; t.edge_count()];
        for h in (0..t.half_edge_count() as u32).rev().map(HalfEdge) {
            if !t.is_hole(t.face(h)) {
                vertex_owner[t.origin(h).index()] = h.0;
                edge_owner[t.edge(h).index()] = h.0;
            }
        }
        let mut vertices = 0;
        let vertex_point = vertex_owner
            .iter()
            .map(|&owner| {
                let point = vertices as u32;
                vertices += usize::from(owner != NONE);
                if owner == NONE { NONE } else { point }
            })
            .collect();
        let mut next = vertices as u64;
        let mut edge_first = Vec::with_capacity(t.edge_count() + 1);
        for (e, &owner) in edge_owner.iter().enumerate() {
            edge_first.push(next);
            next += if owner == NONE { 0 } else { u64::from(rates.edge[e]) - 1 };
        }
        edge_first.push(next);
        let mut face_first = Vec::with_capacity(t.face_count() + 1);
        for f in (0..t.face_count() as u32).map(Face) {
            face_first.push(next);
            if t.is_hole(f) {
                continue;
            }
            let cells = rates.patch[table.patch(f, 0)].map(u64::from);
            let (nu, inner) = (cells[0], inner_points(is_triangle, cells));
            let n = u64::from(table.subfaces(f));
            // Sub-faces share the centre and the points inside their spokes.
            next += if n == 1 { inner } else { 1 + n * (nu - 1) + n * inner };
        }
        face_first.push(next);
        Self { table, rates, vertex_point, vertex_owner, edge_first, edge_owner, face_first, vertices }
    }

    pub fn into_rates(self) -> PatchRates {
        self.rates
    }

    pub fn check(&self, most_points: u64) -> Result<(), TessellateError> {
        let count = *self.face_first.last().expect("one more than faces");
        let limit = most_points.min(MAX_COUNT as u64);
        if count > limit {
            return Err(TessellateError::TooLarge { what: "points", count, limit });
        }
        Ok(())
    }

    pub fn points(&self) -> usize {
        self.face_first[self.face_first.len() - 1] as usize
    }

    pub fn vertices(&self) -> usize {
        self.vertices
    }

    pub fn edge_points(&self) -> usize {
        self.face_first[0] as usize - self.vertices
    }

    pub fn face_points(&self) -> usize {
        self.points() - self.face_first[0] as usize
    }

    /// Runs of faces of a size that does not depend on the number of threads.
    pub fn face_chunks(&self) -> Vec<Range<u32>> {
        let faces = self.table.topology().face_count() as u32;
        (0..faces.div_ceil(512)).map(|c| c * 512..((c + 1) * 512).min(faces)).collect()
    }

    /// The points inside the faces of a run, counted from the first face's first.
    pub fn face_range(&self, faces: &Range<u32>) -> Range<usize> {
        let base = self.face_first[0];
        let at = |f: u32| (self.face_first[f as usize] - base) as usize;
        at(faces.start)..at(faces.end)
    }

    pub fn edge_range(&self, e: usize) -> Range<usize> {
        let at = |e: usize| self.edge_first[e] as usize - self.vertices;
        at(e)..at(e + 1)
    }

    pub fn vertex(&self, v: Vertex) -> u32 {
        self.vertex_point[v.index()]
    }

    /// Point `k` of `rate` along half-edge `h`, ends included.
    pub fn along(&self, h: HalfEdge, k: u32) -> u32 {
        let t = self.table.topology();
        let e = t.edge(h);
        let rate = self.rates.edge[e.index()];
        if k == 0 {
            return self.vertex(t.origin(h));
        }
        if k == rate {
            return self.vertex(t.origin(t.next(h)));
        }
        let k = if self.runs_with_owner(h) { k } else { rate - k };
        self.edge_first[e.index()] as u32 + k - 1
    }

    /// True where `h` runs in the direction in which its edge's points are numbered.
    fn runs_with_owner(&self, h: HalfEdge) -> bool {
        let t = self.table.topology();
        let owner = self.edge_owner[t.edge(h).index()];
        owner == h.0 || t.origin(HalfEdge(owner)) == t.origin(h)
    }

    /// The centre of a face that is no quad.
    fn centre(&self, f: Face) -> u32 {
        self.face_first[f.index()] as u32
    }

    /// Point `k` along spoke `j` of a face that is no quad, from the middle of edge `j` to the centre.
    fn spoke(&self, f: Face, j: u32, k: u32) -> u32 {
        let n = self.rates.patch[self.table.patch(f, 0)][0];
        let sides = self.table.subfaces(f);
        if k == n {
            return self.centre(f);
        }
        if k == 0 {
            let h = self.table.topology().half_edge(f, (j % sides) as usize);
            let rate = self.rates.edge[self.table.topology().edge(h).index()];
            return self.along(h, rate / 2);
        }
        self.centre(f) + 1 + (j % sides) * (n - 1) + k - 1
    }

    /// True under Loop, where every patch is a triangle.
    pub fn is_triangle(&self) -> bool {
        self.table.scheme().split() == SplitKind::Triangles
    }

    pub fn grid(&self, f: Face, subface: u32) -> PatchGrid {
        let cells = self.rates.patch[self.table.patch(f, subface)];
        let first = self.face_first[f.index()] as u32;
        let mut grid = PatchGrid { cells, first, is_triangle: self.is_triangle() };
        let n = self.table.subfaces(f);
        if n > 1 {
            grid.first += 1 + n * (cells[0] - 1) + subface * grid.points();
        }
        grid
    }

    /// The points along side `side` of a patch, from its corner `side` to the next.
    pub fn side(&self, f: Face, subface: u32, side: usize) -> Vec<u32> {
        let t = self.table.topology();
        let rate = |h: HalfEdge| self.rates.edge[t.edge(h).index()];
        let n = self.table.subfaces(f);
        if n == 1 {
            let h = t.half_edge(f, side);
            return (0..=rate(h)).map(|k| self.along(h, k)).collect();
        }
        let cells = self.rates.patch[self.table.patch(f, subface)][0];
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
        let rate = self.rates.edge[t.edge(h).index()];
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

    pub fn edges(&self) -> impl Iterator<Item = (Edge, u32)> + '_ {
        self.edge_owner.iter().enumerate().filter(|(_, o)| **o != NONE).map(|(e, &o)| (Edge(e as u32), o))
    }
}

/// Parameters at `there` of the way along side `side` of a patch, `back` being the rest of the way.
pub(super) fn on_side(is_triangle: bool, side: usize, there: f64, back: f64) -> [f64; 2] {
    match (is_triangle, side) {
        (_, 0) => [there, 0.0],
        (false, 1) => [1.0, there],
        (false, 2) => [back, 1.0],
        (true, 1) => [back, there],
        _ => [0.0, back],
    }
}
