//! Weights of the samples of uniform tessellations, made once for all faces of a plan: everything about a frame that
//! positions have no say in. Faces whose plan has too few of them, or whose weights would be too large, are evaluated by
//! their values, at high rates sub-patch by sub-patch.

use super::corner_rows::CornerRows;
use super::grid::{ALL, GridSamples, Parts};
use super::layout::Layout;
use super::normals::Sides;
use super::selection::{Selection, Selections};
use crate::index::{Face, HalfEdge};
use crate::kernel::{LANES, SurfaceMatrix};
use crate::limit::PatchTable;
use crate::limit::plan::{GridMaker, GridScratch, MOST_RING};
use crate::real::Real;
use crate::topology::NONE;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Largest memory for the weights of one pattern, and of all; beyond it faces are evaluated without. Larger: memory;
/// smaller: time at high rates.
const PATTERN_BYTES: usize = 32 << 20;
const ALL_PATTERN_BYTES: usize = 512 << 20;

/// Largest memory for a pattern by the faces that share its plan. Larger: at high rates, weights that take longer to make,
/// and to read, than the face takes without; smaller: more faces that are evaluated that way.
const MOST_BYTES_PER_FACE: usize = 256 << 10;

/// Largest memory for a pattern at vertices of many faces, where rings have more than [`MOST_RING`] points, if many faces share its
/// plan. Larger: weights that leave the cache from face to face; smaller: faces of smooth poles that take up to ten times as long
/// at low rates, each by values.
const WIDE_BYTES: usize = 6 << 20;

/// The same by the faces that share the plan, if these are few. Larger: memory, since in a sector every face has its own plan;
/// smaller: frames of sectors of a hundred faces at low rates that take two to three times as long.
const WIDE_BYTES_PER_FACE: usize = 64 << 10;

/// Faces that are many there.
const WIDE_FACES: u32 = 64;

/// How often patterns are used.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Frames {
    One,
    Many,
}

impl Frames {
    /// Faces of a plan from which on it has patterns. Larger: faces that go down the patch tree each by itself; smaller: weights that
    /// are made for few uses. 8 and 4 take the same time on `catmark_car`, 2 and 40 a tenth more.
    fn some_faces(self) -> u32 {
        match self {
            Self::One => 8,
            Self::Many => 1,
        }
    }

    /// The same at vertices of many faces.
    fn some_wide_faces(self) -> u32 {
        match self {
            Self::One => WIDE_FACES,
            Self::Many => 1,
        }
    }

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
    pub selection: Arc<Selection>,
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

/// What a tessellation's faces are evaluated with.
pub(super) struct Patterns<'a, T> {
    patterns: Vec<Pattern<T>>,
    /// Pattern of every patch.
    of_patch: Vec<u32>,
    /// What makes patterns and evaluates faces without, by kind of patch (whole face, sub-face).
    makers: [Option<GridMaker<'a>>; 2],
    corners: CornerRows<T>,
    seen: Vec<HalfEdge>,
    /// Samples of patches without a pattern.
    selections: Selections,
    /// Samples inside turned faces: by kind of patch (whole face, sub-face) and turn.
    turned: [Vec<Vec<u32>>; 2],
}

impl<'a, T: Real> Patterns<'a, T> {
    /// For a layout whose rates are uniform. With normals, where `sides` says which there are beyond one per point.
    pub fn new(layout: &Layout<'a>, sides: Option<&Sides>, frames: Frames) -> Self {
        Self::within(layout, sides, frames, [PATTERN_BYTES, ALL_PATTERN_BYTES])
    }

    /// With other bounds for the memory of one pattern and of all.
    pub fn within(
        layout: &Layout<'a>,
        sides: Option<&Sides>,
        frames: Frames,
        [most_each, most_in_all]: [usize; 2],
    ) -> Self {
        let table = layout.table;
        let is_triangle = layout.is_triangle();
        let count = if sides.is_some() { 3 } else { 1 };
        let mut users = vec![0u32; table.plan_count()];
        (0..table.patch_count()).filter_map(|p| table.patch_plan(p)).for_each(|plan| users[plan] += 1);
        let (list, mut of_patch) = wanted(layout, sides, &users, frames);
        let fits = fits(table, &list, &users, [most_each, most_in_all], count * size_of::<T>());
        let corners = CornerRows::new(layout, sides);
        let seen = sides.iter().flat_map(|sides| sides.edges()).collect();
        let maker = |cells: u32| (cells > 0).then(|| GridMaker::new(table.plans(), cells, count));
        let makers = layout.cells.map(maker);
        let selections = Selections::new(layout.cells, is_triangle);
        let make = |scratch: &mut GridScratch, (wanted, fits): (&Wanted, &bool)| {
            let kind = (0..2).find(|&kind| layout.cells[kind] == wanted.cells)?;
            let maker = makers[kind].as_ref()?;
            fits.then(|| wanted.pattern(&selections, maker, kind > 0, scratch))
        };
        let made: Vec<Option<Pattern<T>>> = list.par_iter().zip(&fits).map_init(GridScratch::default, make).collect();
        let mut number = Vec::with_capacity(made.len());
        let mut patterns = Vec::with_capacity(made.len());
        for pattern in made {
            number.push(pattern.as_ref().map_or(NONE, |_| patterns.len() as u32));
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
        Self { patterns, of_patch, makers, corners, seen, selections, turned }
    }

    /// The pattern of a patch; none where it would be too large, or few faces share the plan.
    pub fn of_patch(&self, patch: usize) -> Option<&Pattern<T>> {
        self.patterns.get(self.of_patch[patch] as usize)
    }

    /// What evaluates a patch without a pattern.
    pub fn maker(&self, is_subface: bool) -> &GridMaker<'a> {
        self.makers[usize::from(is_subface)].as_ref().expect("there are patches of this kind")
    }

    /// True where patches without a pattern go by values; others go sub-patch by sub-patch.
    pub fn goes_by_values(&self, is_subface: bool) -> bool {
        self.maker(is_subface).keeps_bases()
    }

    /// What a whole face that goes by values evaluates, whose corner `turn` is its plan's corner 0.
    pub fn own_selection(&self, parts: Parts, turn: u8) -> Option<&Selection> {
        self.goes_by_values(false).then(|| &**self.selections.get(false, parts, turn))
    }

    /// Some parts, at least, of a patch without a pattern, in the plan's orientation. At high rates all ways to lie have one list in
    /// common, since it takes thirteen bytes a point.
    pub fn selection(&self, is_subface: bool, parts: Parts) -> &Selection {
        self.selections.get(is_subface, if self.goes_by_values(is_subface) { parts } else { ALL }, 0)
    }

    /// The face corners that further normals are evaluated at, in order, and their weights.
    pub fn corners(&self) -> &CornerRows<T> {
        &self.corners
    }

    /// The half-edges along which faces give normals beyond those of the points that they own, in order.
    pub fn seen(&self) -> &[HalfEdge] {
        &self.seen
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

impl Wanted {
    fn pattern<T: Real>(
        &self,
        selections: &Selections,
        maker: &GridMaker<'_>,
        is_subface: bool,
        scratch: &mut GridScratch,
    ) -> Pattern<T> {
        let selection = selections.get(is_subface, self.parts, self.own.unwrap_or(0)).clone();
        let mut matrix = SurfaceMatrix::default();
        maker.fill(self.plan, &selection.points, selection.samples.len(), scratch, &mut matrix);
        Pattern { selection, is_own: self.own.is_some(), matrix }
    }
}

/// Which of a list there is memory for.
fn fits(table: &PatchTable, list: &[Wanted], users: &[u32], most: [usize; 2], bytes_each: usize) -> Vec<bool> {
    let [most_each, most_in_all] = most;
    let mut cells = vec![0; users.len()];
    list.iter().for_each(|wanted| cells[wanted.plan] = wanted.cells);
    let mut total = 0;
    let plan_fits = |plan: usize| {
        let samples = (cells[plan] as usize + 1).pow(2).next_multiple_of(LANES);
        let bytes = samples * table.plan(plan).ring() * bytes_each;
        // As many as there can be ways to lie that many faces have.
        let ways = 1 + (users[plan] / Frames::Many.many_faces()).min(15) as usize;
        let (most_each, most_by_face) = match (table.plan(plan).ring() > MOST_RING, users[plan] >= WIDE_FACES) {
            (false, _) => (most_each, MOST_BYTES_PER_FACE),
            (true, true) => (most_each.min(WIDE_BYTES), MOST_BYTES_PER_FACE),
            (true, false) => (most_each, WIDE_BYTES_PER_FACE),
        };
        let is_small = bytes <= most_each.min(most_by_face.saturating_mul(users[plan] as usize));
        let fits = is_small && total + ways * bytes <= most_in_all;
        total += if fits { ways * bytes } else { 0 };
        fits
    };
    let plans: Vec<bool> = (0..users.len()).map(plan_fits).collect();
    list.iter().map(|wanted| plans[wanted.plan]).collect()
}

/// Ways that a whole face may lie in its plan and what it may evaluate.
const WAYS: usize = 4 * 256;

/// How many faces lie in which way, plan by plan; in memory of some bytes a face, of some kilobytes a plan at most.
struct Ways {
    /// By plan, the first of its slots; nothing for plans with few faces.
    start: Vec<u32>,
    /// By plan, how many slots there are, a power of two.
    len: Vec<u32>,
    slots: Vec<Slot>,
}

/// One way, if there are faces.
#[derive(Clone, Copy)]
struct Slot {
    way: u32,
    faces: u32,
    /// Its pattern, once it has one.
    pattern: u32,
}

impl Ways {
    /// For plans with at least `least` faces.
    fn new(users: &[u32], least: u32) -> Self {
        let mut ways = Self { start: vec![NONE; users.len()], len: vec![0; users.len()], slots: Vec::new() };
        for (plan, &users) in users.iter().enumerate().filter(|(_, users)| **users >= least) {
            let len = (2 * users as usize).next_power_of_two().min(WAYS);
            (ways.start[plan], ways.len[plan]) = (ways.slots.len() as u32, len as u32);
            ways.slots.resize(ways.slots.len() + len, Slot { way: NONE, faces: 0, pattern: NONE });
        }
        ways
    }

    /// The slot of a way; none in plans with few faces.
    #[inline]
    fn slot(&mut self, plan: usize, way: u32) -> Option<&mut Slot> {
        let (start, mask) = (self.start[plan], self.len[plan].wrapping_sub(1));
        if start == NONE {
            return None;
        }
        // With as many slots as ways, each has its own; else there are twice as many as faces.
        let mut at = way & mask;
        loop {
            let slot = (start + at) as usize;
            if self.slots[slot].way == NONE {
                self.slots[slot].way = way;
            }
            if self.slots[slot].way == way {
                return Some(&mut self.slots[slot]);
            }
            at = (at + 1) & mask;
        }
    }
}

/// The patterns that a layout calls for, and which of them every patch has.
fn wanted(layout: &Layout<'_>, sides: Option<&Sides>, users: &[u32], frames: Frames) -> (Vec<Wanted>, Vec<u32>) {
    let (table, t) = (layout.table, layout.table.topology());
    let least = frames.many_faces();
    let mut ways = Ways::new(users, least);
    // Faces that are asked for more sides than those they own.
    let seen_again: BTreeSet<u32> = sides.iter().flat_map(|s| s.edges()).map(|h| t.face(h).0).collect();
    let way = |face: Face, patch: usize| {
        let plan = table.patch_plan(patch)?;
        let is_plain = table.subfaces(face) == 1 && !seen_again.contains(&face.0);
        is_plain.then(|| (plan, u32::from(table.turn(patch)) << 8 | u32::from(layout.owned(patch))))
    };
    let faces = || (0..t.face_count() as u32).map(Face);
    for face in faces() {
        if let Some((plan, way)) = way(face, table.patch(face, 0))
            && let Some(slot) = ways.slot(plan, way)
        {
            slot.faces += 1;
        }
    }
    let mut list: Vec<Wanted> = Vec::new();
    let mut shared = vec![NONE; users.len()];
    let mut of_patch = vec![NONE; table.patch_count()];
    for face in faces() {
        let subfaces = table.subfaces(face);
        let cells = layout.cells[usize::from(subfaces > 1)];
        for patch in table.patch(face, 0)..table.patch(face, 0) + subfaces as usize {
            let Some(plan) = table.patch_plan(patch) else { continue };
            let is_wide = table.plan(plan).ring() > MOST_RING;
            if users[plan] < if is_wide { frames.some_wide_faces() } else { frames.some_faces() } {
                continue;
            }
            let own = way(face, patch).and_then(|(plan, way)| ways.slot(plan, way)).filter(|slot| slot.faces >= least);
            let is_own = own.is_some();
            let known = own.map_or(&mut shared[plan], |slot| &mut slot.pattern);
            if *known == NONE {
                *known = list.len() as u32;
                let (parts, own) = match is_own {
                    true => (layout.owned(patch), Some(table.turn(patch))),
                    false => (ALL, None),
                };
                list.push(Wanted { plan, cells, parts, own });
            }
            of_patch[patch] = *known;
        }
    }
    (list, of_patch)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::Scheme;
    use crate::shapes;
    use crate::tessellate::grid::EVERY_SIDE;
    use crate::tessellate::layout::PatchRates;

    fn layout(table: &PatchTable, rate: u32) -> Layout<'_> {
        Layout::new(table, PatchRates::Uniform { rate, edges: table.topology().edge_count() })
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
