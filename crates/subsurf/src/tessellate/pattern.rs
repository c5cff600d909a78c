//! Weights of the samples of uniform tessellations, made once for all faces of a plan: everything about a frame that
//! positions have no say in.

use super::grid::{ALL, GridSamples, Parts};
use super::layout::Layout;
use super::normals::Sides;
use crate::index::{Face, HalfEdge};
use crate::kernel::{LANES, SurfaceMatrix};
use crate::limit::PatchTable;
use crate::limit::plan::{GridWeights, Plan};
use crate::real::Real;
use crate::topology::NONE;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Largest memory for the weights of one pattern, and of all; beyond it samples are evaluated one by one. Larger: memory;
/// smaller: time at high rates.
const PATTERN_BYTES: usize = 32 << 20;
const ALL_PATTERN_BYTES: usize = 512 << 20;

/// How often patterns are used.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Frames {
    One,
    Many,
}

impl Frames {
    /// Faces that lie in one way and evaluate the same sides and corners, from which on they get a pattern of just these
    /// samples, in their own order. Larger: more samples that no face uses, and copying; smaller: patterns to make, and
    /// weights that leave the cache.
    fn many_faces(self) -> u32 {
        match self {
            Self::One => 64,
            Self::Many => 12,
        }
    }
}

/// Weights of a plan at the samples of a grid.
pub(super) struct Pattern<T> {
    /// In the plan's own orientation, or in that of the faces that the pattern is for.
    pub samples: GridSamples,
    /// True where samples are those that the face evaluates and no others, in its own order.
    pub is_own: bool,
    /// Of position, and of `∂u`, `∂v` (two vectors that span the tangent plane, where derivatives do not) if normals
    /// are wanted. Zeros for the latter where there is no such plane.
    pub matrix: SurfaceMatrix<T>,
}

/// A pattern that is to be made.
struct Wanted {
    plan: usize,
    cells: u32,
    parts: Parts,
    /// How the faces lie that it is for alone.
    own: Option<u8>,
}

/// Weights at the corner of a plan: `(point of the ring, weights of ∂u, ∂v)`.
pub(super) type CornerRow<T> = Vec<(u32, [T; 2])>;

/// What a tessellation's faces are evaluated with.
pub(super) struct Patterns<T> {
    patterns: Vec<Pattern<T>>,
    /// Pattern of every patch.
    of_patch: Vec<u32>,
    corners: CornerRows<T>,
    /// Samples of patches without a pattern, by kind of patch (whole face, sub-face).
    all: [Option<GridSamples>; 2],
    /// Samples inside turned faces: by kind of patch (whole face, sub-face) and turn.
    turned: [Vec<Vec<u32>>; 2],
}

impl<T: Real> Patterns<T> {
    /// For a layout whose rates are uniform. With normals, where `sides` says which there are beyond one per point.
    pub fn new(layout: &Layout<'_>, sides: Option<&Sides>, frames: Frames) -> Self {
        Self::within(layout, sides, frames, [PATTERN_BYTES, ALL_PATTERN_BYTES])
    }

    /// With other bounds for the memory of one pattern and of all.
    pub fn within(
        layout: &Layout<'_>,
        sides: Option<&Sides>,
        frames: Frames,
        [most_each, most_in_all]: [usize; 2],
    ) -> Self {
        let table = layout.table;
        let is_triangle = layout.is_triangle();
        let count = if sides.is_some() { 3 } else { 1 };
        let (list, mut of_patch) = wanted(layout, sides, frames);
        let mut total = 0;
        let fits: Vec<bool> = list
            .iter()
            .map(|wanted| {
                let samples = (wanted.cells as usize + 1).pow(2).next_multiple_of(LANES);
                let bytes = samples * table.plan(wanted.plan).ring() * count * size_of::<T>();
                let fits = bytes <= most_each && total + bytes <= most_in_all;
                total += if fits { bytes } else { 0 };
                fits
            })
            .collect();
        let mut corners = CornerRows::new(layout, sides);
        // Which of the list each plan has.
        let mut of_plan: Vec<Vec<u32>> = vec![Vec::new(); table.plan_count()];
        for (i, _) in list.iter().enumerate().filter(|(i, _)| fits[*i]) {
            of_plan[list[i].plan].push(i as u32);
        }
        let mut made: Vec<Option<Pattern<T>>> = list.iter().map(|_| None).collect();
        for cells in layout.cells.into_iter().filter(|&cells| cells > 0) {
            let own = |plan: &usize| of_plan[*plan].first().is_some_and(|&i| list[i as usize].cells == cells);
            let plans: Vec<usize> = (0..table.plan_count()).filter(own).collect();
            let rows = &corners;
            let results = table.plans().grid_weights(&plans, cells, count, |i, weights| {
                let pattern = |&i: &u32| {
                    let Wanted { parts, own, .. } = list[i as usize];
                    let samples = GridSamples::new(cells, is_triangle, parts);
                    let turn = own.unwrap_or(0);
                    let in_plan = |&point: &[u32; 2]| GridSamples::in_plan(is_triangle, cells, point, turn);
                    let matrix = weights.matrix(samples.points().iter().map(in_plan));
                    (i, Pattern { samples, is_own: own.is_some(), matrix })
                };
                let patterns: Vec<(u32, Pattern<T>)> = of_plan[plans[i]].iter().map(pattern).collect();
                (patterns, rows.of_grid(plans[i], cells, weights))
            });
            for (patterns, rows) in results {
                patterns.into_iter().for_each(|(i, pattern)| made[i as usize] = Some(pattern));
                rows.into_iter().for_each(|(row, weights)| corners.rows[row] = weights);
            }
        }
        corners.fill(table, count);
        let mut number = Vec::with_capacity(made.len());
        let mut patterns = Vec::with_capacity(made.len());
        for pattern in made {
            number.push(if pattern.is_some() { patterns.len() as u32 } else { NONE });
            patterns.extend(pattern);
        }
        of_patch.iter_mut().filter(|p| **p != NONE).for_each(|p| *p = number[*p as usize]);

        let turned = [0, 1].map(|kind| match layout.cells[kind] {
            0 => Vec::new(),
            // Sub-faces start at their own corner.
            cells => (0..if kind == 0 { 4 } else { 1 })
                .map(|turn| GridSamples::turned_inside(cells, is_triangle, turn))
                .collect(),
        });
        let missing = |kind: usize| number.contains(&NONE) && layout.cells[kind] > 0;
        let all = [0, 1].map(|kind| missing(kind).then(|| GridSamples::new(layout.cells[kind], is_triangle, ALL)));
        Self { patterns, of_patch, corners, all, turned }
    }

    /// The pattern of a patch; none where it would be too large.
    pub fn of_patch(&self, patch: usize) -> Option<&Pattern<T>> {
        self.patterns.get(self.of_patch[patch] as usize)
    }

    /// All samples of a patch without a pattern.
    pub fn all(&self, is_subface: bool) -> &GridSamples {
        self.all[usize::from(is_subface)].as_ref().expect("made where patterns are missing")
    }

    /// The weights at a corner of a plan that a further normal is evaluated at.
    pub fn corner(&self, plan: usize, corner: usize) -> &CornerRow<T> {
        &self.corners.rows[self.corners.of_corner[plan][corner] as usize]
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

/// Ways that a whole face may lie in its plan and what it may evaluate.
const WAYS: usize = 4 * 256;

/// The patterns that a layout calls for, and which of them every patch has.
fn wanted(layout: &Layout<'_>, sides: Option<&Sides>, frames: Frames) -> (Vec<Wanted>, Vec<u32>) {
    let (table, t) = (layout.table, layout.table.topology());
    let mut users = vec![0u32; table.plan_count()];
    (0..table.patch_count()).filter_map(|p| table.patch_plan(p)).for_each(|plan| users[plan] += 1);
    // Plans with many faces count them by the way they lie.
    let mut start = vec![NONE; users.len()];
    let mut ways: Vec<u32> = Vec::new();
    for (start, _) in start.iter_mut().zip(&users).filter(|(_, users)| **users >= frames.many_faces()) {
        *start = ways.len() as u32;
        ways.resize(ways.len() + WAYS, 0);
    }
    // Faces that are asked for more sides than those they own.
    let seen_again: BTreeSet<u32> = sides.iter().flat_map(|s| s.edges()).map(|h| t.face(h).0).collect();
    let way = |face: Face, patch: usize| {
        let start = start[table.patch_plan(patch)?];
        let is_plain = start != NONE && table.subfaces(face) == 1 && !seen_again.contains(&face.0);
        let number = usize::from(table.turn(patch)) << 8 | usize::from(layout.owned(patch));
        is_plain.then(|| start as usize + number)
    };
    let faces = || (0..t.face_count() as u32).map(Face);
    for face in faces() {
        if let Some(way) = way(face, table.patch(face, 0)) {
            ways[way] += 1;
        }
    }
    // From counts to numbers of patterns.
    let is_many = |count: u32| count >= frames.many_faces() && count < NONE;
    let mut known: Vec<u32> = ways.iter().map(|&count| if is_many(count) { NONE } else { NONE - 1 }).collect();
    let mut list: Vec<Wanted> = Vec::new();
    let mut shared = vec![NONE; users.len()];
    let mut of_patch = vec![NONE; table.patch_count()];
    for face in faces() {
        let subfaces = table.subfaces(face);
        let cells = layout.cells[usize::from(subfaces > 1)];
        for patch in table.patch(face, 0)..table.patch(face, 0) + subfaces as usize {
            let Some(plan) = table.patch_plan(patch) else { continue };
            let own = way(face, patch).filter(|&way| known[way] != NONE - 1);
            let known = own.map_or(&mut shared[plan], |way| &mut known[way]);
            if *known == NONE {
                *known = list.len() as u32;
                let (parts, own) = match own {
                    Some(_) => (layout.owned(patch), Some(table.turn(patch))),
                    None => (ALL, None),
                };
                list.push(Wanted { plan, cells, parts, own });
            }
            of_patch[patch] = *known;
        }
    }
    (list, of_patch)
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

/// Weights at the corners that further normals are evaluated at, and which row is whose.
struct CornerRows<T> {
    is_triangle: bool,
    rows: Vec<CornerRow<T>>,
    /// Plan and corner of every row.
    list: Vec<(usize, usize)>,
    /// Row of every corner of every plan.
    of_corner: Vec<[u32; 4]>,
}

impl<T: Real> CornerRows<T> {
    /// Rows without weights.
    fn new(layout: &Layout<'_>, sides: Option<&Sides>) -> Self {
        let (table, is_triangle) = (layout.table, layout.is_triangle());
        let mut of_corner = vec![[NONE; 4]; table.plan_count()];
        let mut list = Vec::new();
        for h in sides.iter().flat_map(|sides| sides.corners()) {
            let (patch, corner) = corner_of(table, is_triangle, h);
            let plan = table.patch_plan(patch).expect("owners are no holes");
            if of_corner[plan][corner] == NONE {
                of_corner[plan][corner] = list.len() as u32;
                list.push((plan, corner));
            }
        }
        Self { is_triangle, rows: list.iter().map(|_| Vec::new()).collect(), list, of_corner }
    }

    /// The rows of a plan from its weights on a grid.
    fn of_grid(&self, plan: usize, cells: u32, weights: &GridWeights) -> Vec<(usize, CornerRow<T>)> {
        let own = (0..4).filter(|&corner| self.of_corner[plan][corner] != NONE);
        own.map(|corner| {
            let point = corner_place(self.is_triangle, corner).map(|x| x as u32 * cells);
            (self.of_corner[plan][corner] as usize, sparse(weights.rows(point)))
        })
        .collect()
    }

    /// The rows that are still missing.
    fn fill(&mut self, table: &PatchTable, count: usize) {
        let is_triangle = self.is_triangle;
        let missing = self.rows.par_iter_mut().zip(&self.list).filter(|(row, _)| row.is_empty());
        missing.for_each(|(row, &(plan, corner))| {
            let [u, v] = corner_place(is_triangle, corner);
            let plan = table.plan(plan);
            let rows = rows_at(plan, u, v, count);
            *row = sparse((0..plan.ring()).map(|p| std::array::from_fn(|k| rows.get(k).map_or(0.0, |row| row[p]))));
        });
    }
}

/// Where a corner lies in its patch.
fn corner_place(is_triangle: bool, corner: usize) -> [f64; 2] {
    match (is_triangle, corner) {
        (_, 0) => [0.0, 0.0],
        (_, 1) => [1.0, 0.0],
        (false, 2) => [1.0, 1.0],
        _ => [0.0, 1.0],
    }
}

fn sparse<T: Real>(weights: impl Iterator<Item = [f64; 3]>) -> CornerRow<T> {
    let used = weights.enumerate().filter(|(_, [_, u, v])| *u != 0.0 || *v != 0.0);
    used.map(|(p, [_, u, v])| (p as u32, [u, v].map(T::from_f64))).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::Scheme;
    use crate::shapes;
    use crate::tessellate::grid::EVERY_SIDE;
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
            Patterns::<f32>::new(&layout(&table, 4), Some(&Sides::default()), Frames::Many).len()
        };
        assert_eq!(patterns(24), patterns(36));
    }

    #[test]
    fn every_sample_has_one_owner() {
        for shape in shapes::all() {
            let table = PatchTable::new(&shape.mesh, Scheme::CatmullClark).unwrap();
            if (0..shape.mesh.face_count() as u32).any(|f| table.subfaces(Face(f)) > 1) {
                continue;
            }
            let layout = layout(&table, 5);
            let owned: u32 = (0..table.patch_count()).map(|p| (layout.owned(p) & EVERY_SIDE).count_ones()).sum();
            assert_eq!(owned as usize * 4, layout.edge_points(), "{}", shape.name);
            let faces = (0..table.patch_count()).filter(|&p| table.patch_plan(p).is_some()).count();
            assert_eq!(layout.points(), layout.vertices() + layout.edge_points() + 16 * faces, "{}", shape.name);
        }
    }
}
