//! Weights of the samples of uniform tessellations, made once for all faces of a plan: everything about a frame that
//! positions have no say in.

use super::grid::{ALL, EVERY_SIDE, GridSamples, Parts, turned_sides};
use super::layout::Layout;
use super::normals::Sides;
use crate::index::HalfEdge;
use crate::kernel::{LANES, Matrix};
use crate::limit::PatchTable;
use crate::limit::plan::Plan;
use crate::real::Real;
use crate::topology::NONE;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Largest memory for the weights of one pattern, and of all; beyond it samples are evaluated one by one. Larger: memory;
/// smaller: time at high rates.
const PATTERN_BYTES: usize = 32 << 20;
const ALL_PATTERN_BYTES: usize = 512 << 20;

/// Faces of a plan from which on it gets a pattern for every combination of sides that its faces evaluate, rather than one
/// with all sides of which faces use what they need. Larger: samples that no face uses; smaller: patterns to make.
const MANY_FACES: u32 = 256;

/// The sides of a quad that a pattern without corners may have.
const SIDES: usize = 16;

/// Weights of a plan at the samples of a grid, in the plan's own orientation.
pub(super) struct Pattern<T> {
    pub samples: GridSamples,
    /// Rows of position, and of `∂u`, `∂v` (two vectors that span the tangent plane, where derivatives do not) if normals
    /// are wanted. Zeros for the latter where there is no such plane.
    pub rows: Vec<Matrix<T>>,
}

/// Weights at the corner of a plan: `(point of the ring, weights of position, ∂u, ∂v)`.
pub(super) type CornerRow<T> = Vec<(u32, [T; 3])>;

/// What a tessellation's faces are evaluated with.
pub(super) struct Patterns<T> {
    patterns: Vec<Pattern<T>>,
    /// Pattern of every patch.
    of_patch: Vec<u32>,
    corners: Vec<CornerRow<T>>,
    /// Row of every corner of every plan.
    of_corner: Vec<[u32; 4]>,
    /// Samples of patches without a pattern, by kind of patch (whole face, sub-face).
    all: [Option<GridSamples>; 2],
    /// Samples inside turned faces: by kind of patch (whole face, sub-face) and turn.
    turned: [Vec<Vec<u32>>; 2],
}

impl<T: Real> Patterns<T> {
    /// For a layout whose rates are uniform. With normals, where `sides` says which there are beyond one per point.
    pub fn new(layout: &Layout<'_>, sides: Option<&Sides>) -> Self {
        Self::within(layout, sides, [PATTERN_BYTES, ALL_PATTERN_BYTES])
    }

    /// With other bounds for the memory of one pattern and of all.
    pub fn within(layout: &Layout<'_>, sides: Option<&Sides>, [most_each, most_in_all]: [usize; 2]) -> Self {
        let table = layout.table;
        let is_triangle = layout.is_triangle();
        let count = if sides.is_some() { 3 } else { 1 };
        // Faces that are asked for more sides than those they own.
        let t = table.topology();
        let seen_again: BTreeSet<u32> = sides.iter().flat_map(|s| s.edges()).map(|h| t.face(h).0).collect();
        let mut users = vec![0u32; table.plan_count()];
        let planned = || (0..table.patch_count()).filter_map(|p| table.patch_plan(p).map(|plan| (p, plan)));
        planned().for_each(|(_, plan)| users[plan] += 1);

        // Which patterns are wanted: by plan and parts.
        let mut wanted = vec![NONE; table.plan_count() * (SIDES + 1)];
        let mut list: Vec<(usize, Parts, u32)> = Vec::new();
        let mut of_patch = vec![NONE; table.patch_count()];
        for face in (0..t.face_count() as u32).map(crate::index::Face) {
            let subfaces = table.subfaces(face);
            let cells = layout.cells[usize::from(subfaces > 1)];
            for patch in (0..subfaces).map(|s| table.patch(face, s)) {
                let Some(plan) = table.patch_plan(patch) else { continue };
                let owned = turned_sides(is_triangle, layout.owned(patch), table.turn(patch));
                let exact = subfaces == 1 && users[plan] >= MANY_FACES && !seen_again.contains(&face.0);
                let slot = if exact { usize::from(owned) } else { SIDES };
                let known = &mut wanted[plan * (SIDES + 1) + slot];
                if *known == NONE {
                    *known = list.len() as u32;
                    // Vertices are evaluated apart, where they are no middle of an edge or face.
                    let parts = match (exact, subfaces) {
                        (true, _) => owned,
                        (false, 1) => EVERY_SIDE,
                        _ => ALL,
                    };
                    list.push((plan, parts, cells));
                }
                of_patch[patch] = *known;
            }
        }
        let mut total = 0;
        let fits: Vec<bool> = list
            .iter()
            .map(|&(plan, _, cells)| {
                let samples = (cells as usize + 1).pow(2).next_multiple_of(LANES);
                let bytes = samples * table.plan(plan).ring() * count * size_of::<T>();
                let fits = bytes <= most_each && total + bytes <= most_in_all;
                total += if fits { bytes } else { 0 };
                fits
            })
            .collect();
        let made: Vec<Option<Pattern<T>>> = list
            .par_iter()
            .zip(&fits)
            .map(|(&(plan, parts, cells), &fits)| {
                let samples = || GridSamples::new(cells, is_triangle, parts);
                fits.then(|| Pattern::new(table.plan(plan), samples(), count))
            })
            .collect();
        let mut number = Vec::with_capacity(made.len());
        let mut patterns = Vec::with_capacity(made.len());
        for pattern in made {
            number.push(if pattern.is_some() { patterns.len() as u32 } else { NONE });
            patterns.extend(pattern);
        }
        of_patch.iter_mut().filter(|p| **p != NONE).for_each(|p| *p = number[*p as usize]);

        let (corners, of_corner) = corner_rows(layout, sides, count);
        let turned = [0, 1].map(|kind| match layout.cells[kind] {
            0 => Vec::new(),
            // Sub-faces start at their own corner.
            cells => (0..if kind == 0 { 4 } else { 1 })
                .map(|turn| GridSamples::turned_inside(cells, is_triangle, turn))
                .collect(),
        });
        let missing = |kind: usize| number.contains(&NONE) && layout.cells[kind] > 0;
        let all = [0, 1].map(|kind| missing(kind).then(|| GridSamples::new(layout.cells[kind], is_triangle, ALL)));
        Self { patterns, of_patch, corners, of_corner, all, turned }
    }

    /// The pattern of a patch; none where it would be too large.
    pub fn of_patch(&self, patch: usize) -> Option<&Pattern<T>> {
        self.patterns.get(self.of_patch[patch] as usize)
    }

    /// All samples of a patch without a pattern.
    pub fn all(&self, is_subface: bool) -> &GridSamples {
        self.all[usize::from(is_subface)].as_ref().expect("made where patterns are missing")
    }

    /// The weights at a corner of a plan that some vertex is evaluated at.
    pub fn corner(&self, plan: usize, corner: usize) -> &CornerRow<T> {
        &self.corners[self.of_corner[plan][corner] as usize]
    }

    /// Where the samples inside a face lie in its plan's pattern.
    pub fn turned_inside(&self, is_subface: bool, turn: u8) -> &[u32] {
        &self.turned[usize::from(is_subface)][turn as usize]
    }

    /// Number of patterns.
    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.patterns.len()
    }
}

/// The corner that a vertex is evaluated at: its patch, and which corner of that patch's plan it is.
pub(super) fn corner_of(table: &PatchTable, is_triangle: bool, h: HalfEdge) -> (usize, usize) {
    let t = table.topology();
    let face = t.face(h);
    let corner = h.0 - t.first(face);
    if table.subfaces(face) > 1 {
        return (table.patch(face, corner), 0);
    }
    let (patch, sides) = (table.patch(face, 0), if is_triangle { 3 } else { 4 });
    (patch, (corner as usize + sides - usize::from(table.turn(patch))) % sides)
}

/// Weights at the corners that some vertex is evaluated at, and which row is whose.
fn corner_rows<T: Real>(
    layout: &Layout<'_>,
    sides: Option<&Sides>,
    count: usize,
) -> (Vec<CornerRow<T>>, Vec<[u32; 4]>) {
    let table = layout.table;
    let is_triangle = layout.is_triangle();
    let mut of_corner = vec![[NONE; 4]; table.plan_count()];
    let mut list = Vec::new();
    let owners = layout.vertex_owner.iter().map(|&h| HalfEdge(h));
    for h in owners.chain(sides.iter().flat_map(|sides| sides.corners())) {
        let (patch, corner) = corner_of(table, is_triangle, h);
        let plan = table.patch_plan(patch).expect("owners are no holes");
        if of_corner[plan][corner] == NONE {
            of_corner[plan][corner] = list.len() as u32;
            list.push((plan, corner));
        }
    }
    let rows = list
        .par_iter()
        .map(|&(plan, corner)| {
            let [u, v] = match (is_triangle, corner) {
                (_, 0) => [0.0, 0.0],
                (_, 1) => [1.0, 0.0],
                (false, 2) => [1.0, 1.0],
                _ => [0.0, 1.0],
            };
            let plan = table.plan(plan);
            let rows = rows_at(plan, u, v, count);
            let weights = (0..plan.ring()).map(|p| std::array::from_fn(|k| rows.get(k).map_or(0.0, |row| row[p])));
            let used = weights.enumerate().filter(|(_, w): &(usize, [f64; 3])| *w != [0.0; 3]);
            used.map(|(p, w)| (p as u32, w.map(T::from_f64))).collect()
        })
        .collect();
    (rows, of_corner)
}

/// Weights of position and of two vectors that span the tangent plane.
fn rows_at(plan: Plan<'_>, u: f64, v: f64, count: usize) -> Vec<Vec<f64>> {
    let weights = plan.weights(u, v, 0, count);
    let [position, du, dv, ..] = weights.rows;
    if count == 1 {
        return vec![position];
    }
    match weights.at_vertex {
        None => vec![position, du, dv],
        Some(at) => {
            let [a, b] = at.plane.unwrap_or_else(|| [0, 1].map(|_| vec![0.0; plan.ring()]));
            vec![position, a, b]
        }
    }
}

impl<T: Real> Pattern<T> {
    fn new(plan: Plan<'_>, samples: GridSamples, count: usize) -> Self {
        let ring = plan.ring();
        let first_corner = samples.first_corner();
        let places: Vec<[f64; 2]> = (0..first_corner).map(|s| samples.uv(s)).collect();
        let mut weights = plan.weights_at(&places, count);
        for s in first_corner..samples.len() {
            let [u, v] = samples.uv(s);
            rows_at(plan, u, v, count).iter().for_each(|row| weights.extend_from_slice(row));
        }
        let matrix = |k: usize| Matrix::new(samples.len(), ring, |s, p| weights[(s * count + k) * ring + p]);
        Self { rows: (0..count).map(matrix).collect(), samples }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::Scheme;
    use crate::shapes;
    use crate::tessellate::layout::PatchRates;

    fn layout(table: &PatchTable, rate: u32) -> Layout<'_> {
        let edge = vec![rate; table.topology().edge_count()];
        let rates = PatchRates { edge, patch: vec![[rate; 2]; table.patch_count()] };
        Layout::new(table, rates)
    }

    #[test]
    fn the_number_of_patterns_does_not_grow_with_the_mesh() {
        let patterns = |n: u32| {
            let table = PatchTable::new(&shapes::grid(n, n).mesh, Scheme::CatmullClark).unwrap();
            Patterns::<f32>::new(&layout(&table, 4), Some(&Sides::default())).len()
        };
        assert_eq!(patterns(24), patterns(36));
    }

    #[test]
    fn every_sample_has_one_owner() {
        for shape in shapes::all() {
            let table = PatchTable::new(&shape.mesh, Scheme::CatmullClark).unwrap();
            if (0..shape.mesh.face_count() as u32).any(|f| table.subfaces(crate::index::Face(f)) > 1) {
                continue;
            }
            let layout = layout(&table, 5);
            let owned: u32 = (0..table.patch_count()).map(|p| layout.owned(p).count_ones()).sum();
            assert_eq!(owned as usize * 4, layout.edge_points(), "{}", shape.name);
            let faces = (0..table.patch_count()).filter(|&p| table.patch_plan(p).is_some()).count();
            assert_eq!(layout.points(), layout.vertices() + layout.edge_points() + 16 * faces, "{}", shape.name);
        }
    }
}
