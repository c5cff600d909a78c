//! Facets of one patch from the rates of its sides and of its inside.
//!
//! Where all rates fit, a plain grid. Elsewhere an inner grid, and between it and each side a strip of triangles that
//! depends on that side's rate alone, so that the neighbour sees the same points.

use super::layout::Layout;
use super::normals::Sides;
use super::patch_grid::{PatchGrid, on_side};
use super::{Facets, Places, TessellateError, TessellateOptions, grid_facets};
use crate::index::Face;
use crate::mesh::MAX_COUNT;
use rayon::prelude::*;
use std::ops::Range;

/// Facets of a mesh.
#[derive(Default)]
pub(super) struct FacetArrays {
    /// Start of every facet in `corners`, and the end of the last one.
    pub face_offsets: Vec<u32>,
    pub corners: Vec<u32>,
    /// Normal of every corner; empty where normals go by the same indices as points.
    pub normal_corners: Vec<u32>,
    /// Empty if they were not asked for.
    pub places: Places,
}

/// Facets of a run of faces.
#[derive(Default)]
struct FacetList {
    corners: Vec<u32>,
    /// End of every facet in `corners`.
    ends: Vec<u32>,
    normal_corners: Vec<u32>,
    places: Places,
}

/// A facet corner: its point, its normal, its place in the patch.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub point: u32,
    pub normal: u32,
    pub uv: [f64; 2],
}

/// Facets of a layout.
pub(super) fn of_layout(
    layout: &Layout<'_>,
    sides: &Sides,
    options: &TessellateOptions,
) -> Result<FacetArrays, TessellateError> {
    let check = |count: u64| {
        let limit = MAX_COUNT as u64;
        if count > limit { Err(TessellateError::TooLarge { what: "facet corners", count, limit }) } else { Ok(()) }
    };
    if layout.is_uniform() {
        let cells = |f: u32| -> u64 {
            let subfaces = layout.table.subfaces(Face(f));
            u64::from(subfaces) * u64::from(layout.cells[usize::from(subfaces > 1)]).pow(2)
        };
        let kept = |f: &u32| !layout.table.topology().is_hole(Face(*f));
        let faces = layout.table.topology().face_count() as u32;
        let facets: u64 = match layout.is_plain() {
            true => u64::from(faces).saturating_mul(u64::from(layout.cells[0]).pow(2)),
            false => (0..faces).filter(kept).map(cells).sum(),
        };
        let corners = match (layout.is_triangle(), options.facets) {
            (true, _) => 3,
            (false, Facets::Quads) => 4,
            (false, Facets::Triangles) => 6,
        };
        check(facets.saturating_mul(corners))?;
        return Ok(grid_facets::of_layout(layout, sides, options));
    }
    let chunks: Vec<FacetList> =
        layout.face_chunks().into_par_iter().map(|faces| of_faces(layout, sides, faces, options)).collect();
    let corners = chunks.iter().map(|c| c.corners.len() as u64).sum();
    check(corners)?;
    let mut out =
        FacetArrays { face_offsets: vec![0], corners: Vec::with_capacity(corners as usize), ..FacetArrays::default() };
    for chunk in chunks {
        let base = out.corners.len() as u32;
        out.face_offsets.extend(chunk.ends.iter().map(|end| base + end));
        out.corners.extend_from_slice(&chunk.corners);
        out.normal_corners.extend_from_slice(&chunk.normal_corners);
        out.places.facet.extend_from_slice(&chunk.places.facet);
        out.places.corner_uv.extend_from_slice(&chunk.places.corner_uv);
    }
    Ok(out)
}

fn of_faces(layout: &Layout<'_>, sides: &Sides, faces: Range<u32>, options: &TessellateOptions) -> FacetList {
    let mut out = FacetList::default();
    let table = layout.table;
    let own_normals = options.normals && sides.extra() > 0;
    for f in faces.map(Face).filter(|&f| !table.topology().is_hole(f)) {
        for subface in 0..table.subfaces(f) {
            let patch = Patch::new(layout, own_normals.then_some(sides), f, subface);
            let mut emit = |facet: &[Corner]| {
                let mut push = |facet: &[Corner]| {
                    out.corners.extend(facet.iter().map(|c| c.point));
                    out.ends.push(out.corners.len() as u32);
                    if own_normals {
                        out.normal_corners.extend(facet.iter().map(|c| c.normal));
                    }
                    if options.places {
                        out.places.facet.push((f.0, subface));
                        out.places.corner_uv.extend(facet.iter().map(|c| c.uv));
                    }
                };
                match (facet, options.facets) {
                    (&[a, b, c, d], Facets::Triangles) => {
                        push(&[a, b, c]);
                        push(&[a, c, d]);
                    }
                    _ => push(facet),
                }
            };
            patch.facets(&mut emit);
        }
    }
    out
}

/// The facets of a patch in its parameters, for given facets across and along its sides.
pub(super) fn in_parameters(is_triangle: bool, cells: [u32; 2], sides: &[u32]) -> Vec<Vec<[f64; 2]>> {
    let side = |(s, &n): (usize, &u32)| -> Vec<Corner> {
        let part = |k: u32| f64::from(k) / f64::from(n);
        (0..=n).map(|k| Corner { point: 0, normal: 0, uv: on_side(is_triangle, s, part(k), part(n - k)) }).collect()
    };
    let grid = PatchGrid { cells, first: 0, is_triangle };
    let mut facets = Vec::new();
    Patch { grid, side: sides.iter().enumerate().map(side).collect() }
        .facets(&mut |facet| facets.push(facet.iter().map(|c| c.uv).collect()));
    facets
}

pub(super) struct Patch {
    grid: PatchGrid,
    /// Corners along the sides, each from its patch corner to the next, both included.
    side: Vec<Vec<Corner>>,
}

impl Patch {
    /// `sides` says which normals are not those of the points; none where all are.
    pub fn new(layout: &Layout<'_>, sides: Option<&Sides>, f: Face, subface: u32) -> Self {
        let t = layout.table.topology();
        let is_quad = layout.table.subfaces(f) == 1;
        let is_triangle = layout.is_triangle();
        let side = |s: usize| -> Vec<Corner> {
            let points = layout.side(f, subface, s);
            let n = points.len() as u32 - 1;
            let along = |k: u32| f64::from(k) / f64::from(n);
            let normal = |k: u32, point: u32| {
                let Some(sides) = sides else { return point };
                // Which half-edge this side lies on, and how far along it the side starts.
                let (h, start) = match (is_quad, s) {
                    (true, s) => (t.half_edge(f, s), 0),
                    (false, 0) => (t.half_edge(f, subface as usize), 0),
                    (false, 3) => (t.prev(t.half_edge(f, subface as usize)), n),
                    _ => {
                        // A spoke: only its outer end lies on an edge.
                        let out = t.half_edge(f, subface as usize);
                        let h = if s == 1 { out } else { t.prev(out) };
                        let outer = if s == 1 { k == 0 } else { k == n };
                        let middle = layout.rates.edge(t.edge(h)) / 2;
                        return if outer { sides.along(h, middle, point) } else { point };
                    }
                };
                sides.at(layout, h, start + k, point)
            };
            points
                .iter()
                .enumerate()
                .map(|(k, &point)| {
                    let k = k as u32;
                    let uv = on_side(is_triangle, s, along(k), along(n - k));
                    Corner { point, normal: normal(k, point), uv }
                })
                .collect()
        };
        let count = if is_triangle { 3 } else { 4 };
        Self { grid: layout.grid(f, subface), side: (0..count).map(side).collect() }
    }

    fn inner(&self, i: u32, j: u32) -> Corner {
        let point = self.grid.inner(i, j);
        Corner { point, normal: point, uv: self.grid.uv(i, j) }
    }

    /// Grid point `(i, j)` where the sides' rates are those of the inside.
    fn at(&self, i: u32, j: u32) -> Corner {
        let [nu, nv] = self.grid.cells;
        if self.grid.is_triangle {
            return match (i, j) {
                (i, 0) => self.side[0][i as usize],
                (i, j) if i + j == nu => self.side[1][j as usize],
                (0, j) => self.side[2][(nu - j) as usize],
                (i, j) => self.inner(i, j),
            };
        }
        match (i, j) {
            (i, 0) => self.side[0][i as usize],
            (i, j) if i == nu => self.side[1][j as usize],
            (i, j) if j == nv => self.side[2][(nu - i) as usize],
            (0, j) => self.side[3][(nv - j) as usize],
            (i, j) => self.inner(i, j),
        }
    }

    pub fn facets(&self, emit: &mut dyn FnMut(&[Corner])) {
        let [nu, nv] = self.grid.cells;
        let fits = self.side.iter().enumerate().all(|(s, side)| side.len() as u32 - 1 == [nu, nv][s % 2]);
        let at = |i: u32, j: u32| if fits { self.at(i, j) } else { self.inner(i, j) };
        // Where rates differ, the grid stops one row short of every side.
        let rim = u32::from(!fits);
        if self.grid.is_triangle {
            let last = nu - rim;
            for j in rim..last {
                for i in rim..last.saturating_sub(j) {
                    emit(&[at(i, j), at(i + 1, j), at(i, j + 1)]);
                    if i + j + 2 <= last {
                        emit(&[at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                    }
                }
            }
        } else {
            for j in rim..nv - rim {
                for i in rim..nu - rim {
                    emit(&[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
        if fits {
            return;
        }
        let inner =
            |line: Vec<(u32, u32)>| -> Vec<Corner> { line.into_iter().map(|(i, j)| self.inner(i, j)).collect() };
        let lines: Vec<Vec<Corner>> = if self.grid.is_triangle {
            vec![
                inner((1..nu - 1).map(|i| (i, 1)).collect()),
                inner((1..nu - 1).map(|j| (nu - 1 - j, j)).collect()),
                inner((1..nu - 1).rev().map(|j| (1, j)).collect()),
            ]
        } else {
            vec![
                inner((1..nu).map(|i| (i, 1)).collect()),
                inner((1..nv).map(|j| (nu - 1, j)).collect()),
                inner((1..nu).rev().map(|i| (i, nv - 1)).collect()),
                inner((1..nv).rev().map(|j| (1, j)).collect()),
            ]
        };
        for (s, (outer, inner)) in self.side.iter().zip(&lines).enumerate() {
            // How far along the side a corner lies.
            let along = |c: &Corner| match (self.grid.is_triangle, s) {
                (_, 0) => c.uv[0],
                (_, 1) => c.uv[1],
                (false, 2) => 1.0 - c.uv[0],
                _ => 1.0 - c.uv[1],
            };
            strip(outer, inner, along, emit);
        }
    }
}

/// Triangles between a side and the inner line beside it; both run in the side's direction, the inside on the left.
fn strip(outer: &[Corner], inner: &[Corner], along: impl Fn(&Corner) -> f64, emit: &mut dyn FnMut(&[Corner])) {
    let (mut o, mut i) = (0, 0);
    while o + 1 < outer.len() || i + 1 < inner.len() {
        let outer_next = outer.get(o + 1).map(|c| 0.5 * (along(c) + along(&outer[o])));
        let inner_next = inner.get(i + 1).map(|c| 0.5 * (along(c) + along(&inner[i])));
        // Whichever segment's middle comes first.
        let step_outer = match (outer_next, inner_next) {
            (Some(a), Some(b)) => a <= b,
            (a, _) => a.is_some(),
        };
        if step_outer {
            emit(&[outer[o], outer[o + 1], inner[i]]);
            o += 1;
        } else {
            emit(&[outer[o], inner[i + 1], inner[i]]);
            i += 1;
        }
    }
}
