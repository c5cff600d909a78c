//! Facets of one patch from the rates of its sides and of its inside.
//!
//! Where all rates fit, a plain grid. Elsewhere an inner grid, and between it and each side a strip of triangles that
//! depends on that side's rate alone, so that the neighbour sees the same points.

use super::layout::{Layout, PatchGrid};
use super::normals::Sides;
use super::{Facets, TessellateOptions};
use crate::index::Face;
use crate::limit::PatchTable;
use std::ops::Range;

/// Facets of a run of faces.
#[derive(Default)]
pub(super) struct FacetList {
    pub corners: Vec<u32>,
    /// End of every facet in `corners`.
    pub ends: Vec<u32>,
    pub normal_corners: Vec<u32>,
    pub places: Vec<(u32, u32)>,
    pub corner_uv: Vec<[f64; 2]>,
}

/// A facet corner: its point, its normal, its place in the patch.
#[derive(Clone, Copy)]
struct Corner {
    point: u32,
    normal: u32,
    uv: [f64; 2],
}

pub(super) fn of_faces(
    table: &PatchTable,
    layout: &Layout<'_>,
    sides: &Sides,
    faces: Range<u32>,
    options: &TessellateOptions,
) -> FacetList {
    let mut out = FacetList::default();
    let own_normals = options.normals && sides.extra() > 0;
    for f in faces.map(Face).filter(|&f| !table.topology().is_hole(f)) {
        for subface in 0..table.subfaces(f) {
            let patch = Patch::new(layout, sides, f, subface, own_normals);
            let mut emit = |facet: &[Corner]| {
                let mut push = |facet: &[Corner]| {
                    out.corners.extend(facet.iter().map(|c| c.point));
                    out.ends.push(out.corners.len() as u32);
                    if own_normals {
                        out.normal_corners.extend(facet.iter().map(|c| c.normal));
                    }
                    if options.places {
                        out.places.push((f.0, subface));
                        out.corner_uv.extend(facet.iter().map(|c| c.uv));
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

struct Patch {
    grid: PatchGrid,
    /// Corners along the four sides, each from its patch corner to the next, both included.
    side: [Vec<Corner>; 4],
}

impl Patch {
    fn new(layout: &Layout<'_>, sides: &Sides, f: Face, subface: u32, own_normals: bool) -> Self {
        let t = layout.table.topology();
        let is_quad = layout.table.subfaces(f) == 1;
        let side = [0, 1, 2, 3].map(|s| {
            let points = layout.side(f, subface, s);
            let n = points.len() as u32 - 1;
            let along = |k: u32| f64::from(k) / f64::from(n);
            let normal = |k: u32, point: u32| {
                // Which half-edge this side lies on, and how far along it the side starts.
                let (h, start) = match (is_quad, s) {
                    _ if !own_normals => return point,
                    (true, s) => (t.half_edge(f, s), 0),
                    (false, 0) => (t.half_edge(f, subface as usize), 0),
                    (false, 3) => (t.prev(t.half_edge(f, subface as usize)), n),
                    _ => {
                        // A spoke: only its outer end lies on an edge.
                        let out = t.half_edge(f, subface as usize);
                        let h = if s == 1 { out } else { t.prev(out) };
                        let outer = if s == 1 { k == 0 } else { k == n };
                        let middle = layout.rates.edge[t.edge(h).index()] / 2;
                        return if outer { sides.along(h, middle, point) } else { point };
                    }
                };
                let (k, rate) = (start + k, layout.rates.edge[t.edge(h).index()]);
                match k {
                    0 => sides.corner(h, point),
                    k if k == rate => sides.corner(t.next(h), point),
                    k => sides.along(h, k, point),
                }
            };
            points
                .iter()
                .enumerate()
                .map(|(k, &point)| {
                    let k = k as u32;
                    let uv = match s {
                        0 => [along(k), 0.0],
                        1 => [1.0, along(k)],
                        2 => [along(n - k), 1.0],
                        _ => [0.0, along(n - k)],
                    };
                    Corner { point, normal: normal(k, point), uv }
                })
                .collect()
        });
        Self { grid: layout.grid(f, subface), side }
    }

    fn inner(&self, i: u32, j: u32) -> Corner {
        let [nu, nv] = self.grid.cells;
        let point = self.grid.inner(i, j);
        Corner { point, normal: point, uv: [f64::from(i) / f64::from(nu), f64::from(j) / f64::from(nv)] }
    }

    /// Grid point `(i, j)` where the sides' rates are those of the inside.
    fn at(&self, i: u32, j: u32) -> Corner {
        let [nu, nv] = self.grid.cells;
        match (i, j) {
            (i, 0) => self.side[0][i as usize],
            (i, j) if i == nu => self.side[1][j as usize],
            (i, j) if j == nv => self.side[2][(nu - i) as usize],
            (0, j) => self.side[3][(nv - j) as usize],
            (i, j) => self.inner(i, j),
        }
    }

    fn facets(&self, emit: &mut dyn FnMut(&[Corner])) {
        let [nu, nv] = self.grid.cells;
        let rates = [0, 1, 2, 3].map(|s| self.side[s].len() as u32 - 1);
        if rates == [nu, nv, nu, nv] {
            for j in 0..nv {
                for i in 0..nu {
                    emit(&[self.at(i, j), self.at(i + 1, j), self.at(i + 1, j + 1), self.at(i, j + 1)]);
                }
            }
            return;
        }
        for j in 1..nv - 1 {
            for i in 1..nu - 1 {
                emit(&[self.inner(i, j), self.inner(i + 1, j), self.inner(i + 1, j + 1), self.inner(i, j + 1)]);
            }
        }
        let rim: [Vec<Corner>; 4] = [
            (1..nu).map(|i| self.inner(i, 1)).collect(),
            (1..nv).map(|j| self.inner(nu - 1, j)).collect(),
            (1..nu).rev().map(|i| self.inner(i, nv - 1)).collect(),
            (1..nv).rev().map(|j| self.inner(1, j)).collect(),
        ];
        for s in 0..4 {
            let axis = s % 2;
            // How far along the side a corner lies.
            let along = |c: &Corner| if s < 2 { c.uv[axis] } else { 1.0 - c.uv[axis] };
            strip(&self.side[s], &rim[s], along, emit);
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
