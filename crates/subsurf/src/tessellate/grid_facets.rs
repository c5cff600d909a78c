//! Facets of tessellations with uniform rates: their number is known face by face, so that all threads write the result
//! where it belongs. A patch's points are laid out as a grid first; facets are its cells.

use super::facets::{Corner, FacetArrays, Patch};
use super::layout::Layout;
use super::normals::Sides;
use super::{Facets, Places, TessellateOptions};
use crate::index::{Face, HalfEdge};
use rayon::prelude::*;
use std::ops::Range;
use subsurf_memory::{advise, with_capacity, zeroed};

/// Facets of a layout with uniform rates.
pub(super) fn of_layout(layout: &Layout<'_>, sides: &Sides, options: &TessellateOptions) -> FacetArrays {
    let kind = Kind::new(layout, options);
    let chunks = layout.face_chunks();
    let is_plain = layout.is_plain();
    let patches = |faces: &Range<u32>| match is_plain {
        true => faces.len() * kind.facets_of(layout, Face(faces.start)),
        false => faces.clone().map(|f| kind.facets_of(layout, Face(f))).sum::<usize>(),
    };
    let counts: Vec<usize> = chunks.par_iter().map(patches).collect();
    let facets = counts.iter().sum::<usize>();
    let own_normals = options.normals && sides.extra() > 0;
    let mut out = FacetArrays {
        face_offsets: with_capacity(facets + 1),
        corners: zeroed(facets * kind.corners),
        normal_corners: zeroed(if own_normals { facets * kind.corners } else { 0 }),
        places: Places::default(),
    };
    let offsets = (0..facets as u32 + 1).into_par_iter().map(|k| k * kind.corners as u32);
    offsets.collect_into_vec(&mut out.face_offsets);
    if options.places {
        out.places.facet = vec![(0, 0); facets];
        out.places.corner_uv = vec![[0.0; 2]; facets * kind.corners];
        advise(&mut out.places.facet);
        advise(&mut out.places.corner_uv);
    }
    let mut rest = Slices {
        corners: &mut out.corners,
        normals: &mut out.normal_corners,
        facets: &mut out.places.facet,
        uv: &mut out.places.corner_uv,
    };
    let mut tasks = Vec::with_capacity(chunks.len());
    for (faces, count) in chunks.into_iter().zip(counts) {
        let (own, other) = rest.split(count, kind.corners);
        rest = other;
        tasks.push((faces, own));
    }
    tasks.into_par_iter().for_each_init(Vec::new, |grid, (faces, own)| {
        kind.write(layout, own_normals.then_some(sides), faces, own, grid);
    });
    out
}

/// How all patches are cut.
struct Kind {
    is_triangle: bool,
    /// Every cell of a quad is two triangles.
    halves: bool,
    /// Corners of a facet.
    corners: usize,
}

/// The parts of the result that a chunk of faces fills; some are empty.
struct Slices<'o> {
    corners: &'o mut [u32],
    normals: &'o mut [u32],
    facets: &'o mut [(u32, u32)],
    uv: &'o mut [[f64; 2]],
}

impl<'o> Slices<'o> {
    /// The first `facets` facets, and the rest.
    fn split(self, facets: usize, corners: usize) -> (Self, Self) {
        fn at<T>(slice: &mut [T], count: usize) -> (&mut [T], &mut [T]) {
            slice.split_at_mut(count.min(slice.len()))
        }
        let (a, b) = (at(self.corners, facets * corners), at(self.normals, facets * corners));
        let (c, d) = (at(self.facets, facets), at(self.uv, facets * corners));
        (
            Self { corners: a.0, normals: b.0, facets: c.0, uv: d.0 },
            Self { corners: a.1, normals: b.1, facets: c.1, uv: d.1 },
        )
    }
}

impl Kind {
    fn new(layout: &Layout<'_>, options: &TessellateOptions) -> Self {
        let is_triangle = layout.is_triangle();
        let halves = !is_triangle && options.facets == Facets::Triangles;
        Self { is_triangle, halves, corners: if is_triangle || halves { 3 } else { 4 } }
    }

    fn facets_of(&self, layout: &Layout<'_>, face: Face) -> usize {
        if layout.table.topology().is_hole(face) {
            return 0;
        }
        let subfaces = layout.table.subfaces(face) as usize;
        let cells = layout.cells[usize::from(subfaces > 1)] as usize;
        subfaces * cells * cells * if self.halves { 2 } else { 1 }
    }

    fn write(
        &self,
        layout: &Layout<'_>,
        sides: Option<&Sides>,
        faces: Range<u32>,
        own: Slices<'_>,
        grid: &mut Vec<u32>,
    ) {
        let table = layout.table;
        let (mut corner, mut facet) = (0, 0);
        for face in faces.map(Face).filter(|&f| !table.topology().is_hole(f)) {
            let subfaces = table.subfaces(face);
            let count = self.facets_of(layout, face);
            let range = corner..corner + count * self.corners;
            if subfaces == 1 {
                let cells = layout.cells[0];
                self.fill_grid(layout, face, |_, _, point| point, grid);
                self.cut(cells, grid, &mut own.corners[range.clone()]);
                if sides.is_some_and(|sides| sides.is_plain(face)) {
                    own.normals[range.clone()].copy_from_slice(&own.corners[range.clone()]);
                } else if let Some(sides) = sides {
                    self.fill_grid(layout, face, |h, k, point| sides.at(layout, h, k, point), grid);
                    self.cut(cells, grid, &mut own.normals[range.clone()]);
                }
                if !own.uv.is_empty() {
                    self.cut_parameters(cells, &mut own.uv[range.clone()]);
                    own.facets[facet..facet + count].fill((face.0, 0));
                }
            } else {
                let mut at = corner;
                for subface in 0..subfaces {
                    let patch = Patch::new(layout, sides, face, subface);
                    let mut put = |facet: &[Corner]| {
                        for c in facet {
                            own.corners[at] = c.point;
                            if sides.is_some() {
                                own.normals[at] = c.normal;
                            }
                            if let Some(uv) = own.uv.get_mut(at) {
                                *uv = c.uv;
                            }
                            at += 1;
                        }
                    };
                    patch.facets(&mut |facet| match facet {
                        &[a, b, c, d] if self.halves => {
                            put(&[a, b, c]);
                            put(&[a, c, d]);
                        }
                        _ => put(facet),
                    });
                    if !own.uv.is_empty() {
                        let each = count / subfaces as usize;
                        let first = facet + each * subface as usize;
                        own.facets[first..first + each].fill((face.0, subface));
                    }
                }
            }
            (corner, facet) = (range.end, facet + count);
        }
    }

    /// Start of row `j` of a grid.
    fn row(&self, cells: usize, j: usize) -> usize {
        if self.is_triangle { j * (cells + 1) - j * j.saturating_sub(1) / 2 } else { j * (cells + 1) }
    }

    /// Indices at the grid points of a face that is one patch, row by row. `map` gives those along its half-edges, from
    /// the half-edge, the number along it, and the point.
    fn fill_grid(&self, layout: &Layout<'_>, face: Face, map: impl Fn(HalfEdge, u32, u32) -> u32, grid: &mut Vec<u32>) {
        let n = layout.cells[0] as usize;
        grid.resize(self.row(n, n + 1), 0);
        let mut next = layout.grid(face, 0).first;
        for j in 1..n {
            let start = self.row(n, j);
            let inside = if self.is_triangle { n.saturating_sub(j + 1) } else { n - 1 };
            for (k, point) in grid[start + 1..start + 1 + inside].iter_mut().enumerate() {
                *point = next + k as u32;
            }
            next += inside as u32;
        }
        let t = layout.table.topology();
        for side in 0..if self.is_triangle { 3 } else { 4 } {
            let h = t.half_edge(face, side);
            let place = |k: usize| match (self.is_triangle, side) {
                (_, 0) => k,
                (false, 1) => self.row(n, k) + n,
                (false, 2) => self.row(n, n) + n - k,
                (true, 1) => self.row(n, k) + n - k,
                _ => self.row(n, n - k),
            };
            grid[place(0)] = map(h, 0, layout.along(h, 0));
            layout.inside_edge(h, |k, point| grid[place(k as usize)] = map(h, k, point));
        }
    }

    /// Facets from the indices at the points of a grid.
    fn cut(&self, cells: u32, grid: &[u32], out: &mut [u32]) {
        let n = cells as usize;
        let row = |j: usize| &grid[self.row(n, j)..self.row(n, j + 1)];
        if self.is_triangle {
            let mut out = out.as_chunks_mut::<3>().0.iter_mut();
            let mut put = |facet| *out.next().expect("one place per facet") = facet;
            for j in 0..n {
                let (a, b) = (row(j), row(j + 1));
                for i in 0..n - j {
                    put([a[i], a[i + 1], b[i]]);
                    if i + j + 2 <= n {
                        put([a[i + 1], b[i + 1], b[i]]);
                    }
                }
            }
        } else if self.halves {
            for (j, out) in out.as_chunks_mut::<6>().0.chunks_exact_mut(n).enumerate() {
                let corners = row(j).windows(2).zip(row(j + 1).windows(2));
                for (out, (a, b)) in out.iter_mut().zip(corners) {
                    *out = [a[0], a[1], b[1], a[0], b[1], b[0]];
                }
            }
        } else {
            for (j, out) in out.as_chunks_mut::<4>().0.chunks_exact_mut(n).enumerate() {
                let corners = row(j).windows(2).zip(row(j + 1).windows(2));
                for (out, (a, b)) in out.iter_mut().zip(corners) {
                    *out = [a[0], a[1], b[1], b[0]];
                }
            }
        }
    }

    /// Parameters of facet corners.
    fn cut_parameters(&self, cells: u32, out: &mut [[f64; 2]]) {
        let n = cells as usize;
        let points = self.row(n, n + 1) as u32;
        let grid: Vec<u32> = (0..points).collect();
        let mut uv = Vec::with_capacity(grid.len());
        for j in 0..=n {
            let width = self.row(n, j + 1) - self.row(n, j);
            uv.extend((0..width).map(|i| [i, j].map(|k| k as f64 / n as f64)));
        }
        let mut corners = vec![0; out.len()];
        self.cut(cells, &grid, &mut corners);
        out.iter_mut().zip(corners).for_each(|(out, c)| *out = uv[c as usize]);
    }
}
