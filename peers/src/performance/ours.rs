//! Everything of ours that is measured, one function for each; nothing else here calls the library to be timed.

use super::case::Case;
use super::rivals::patches::Frames;
use rayon::prelude::*;
use subsurf::{
    Crease, Level, LimitStencilTable, LimitSurface, Location, PatchTable, Rates, StencilTable, Tags, TessellateOptions,
    Tessellation,
};

const FITS: &str = "meshes that are measured are valid";

/// Face lists to a patch table that is ready to evaluate.
pub fn build(case: &Case) -> PatchTable {
    PatchTable::new(&case.shape.mesh().expect(FITS), case.shape.our_scheme()).expect(FITS)
}

/// Bytes that the table keeps.
pub fn table_bytes(table: &PatchTable) -> usize {
    let size = table.size();
    size.patch_bytes + size.plan_bytes + size.topology_bytes
}

/// A refined mesh: positions, and corners of its faces.
pub struct Refined {
    pub positions: Vec<[f32; 3]>,
    pub corners: Vec<u32>,
}

/// Face lists and positions to the positions and faces of a level.
pub fn refine(case: &Case, depth: u32) -> Refined {
    let refinement = Refinement::new(case, depth);
    let positions = refinement.update(&case.control);
    let corners = refinement.levels.last().expect("level 0 at least").topology().corners().to_vec();
    Refined { positions, corners }
}

/// What stays when positions change.
pub struct Refinement {
    levels: Vec<Level>,
}

impl Refinement {
    pub fn new(case: &Case, depth: u32) -> Self {
        let mut levels = vec![control_level(case)];
        for _ in 0..depth {
            levels.push(levels.last().expect("level 0 at least").refine().expect(FITS));
        }
        Self { levels }
    }

    /// The positions of the level from new control points.
    pub fn update(&self, control: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let (parents, first) = (&self.levels[..self.levels.len() - 1], control.to_vec());
        parents.iter().fold(first, |values, level| level.refine_values(&values))
    }
}

fn control_level(case: &Case) -> Level {
    Level::new(&case.shape.mesh().expect(FITS), case.shape.our_scheme()).expect(FITS)
}

/// The stencils of a level, from face lists.
pub fn stencils(case: &Case, depth: u32) -> StencilTable<f32> {
    StencilTable::new(&control_level(case), depth).expect(FITS)
}

pub fn apply_stencils(table: &StencilTable<f32>, control: &[[f32; 3]], out: &mut [[f32; 3]]) {
    table.apply_into(control, out);
}

/// A tessellation from a table and positions.
pub fn tessellate(table: &PatchTable, control: &[[f32; 3]], rate: u32, normals: bool) -> Tessellation<f32> {
    let options = TessellateOptions { rates: Rates::Uniform(rate), normals, ..TessellateOptions::default() };
    table.surface(control).tessellate(&options).expect(FITS)
}

/// What stays when positions change.
pub struct Tessellator<'a> {
    table: &'a PatchTable,
    rate: u32,
    normals: bool,
}

impl<'a> Tessellator<'a> {
    pub fn new(table: &'a PatchTable, rate: u32, normals: bool) -> Self {
        Self { table, rate, normals }
    }

    pub fn update(&self, control: &[[f32; 3]]) -> Tessellation<f32> {
        tessellate(self.table, control, self.rate, self.normals)
    }
}

/// Position and first derivatives at places, in the order given.
pub fn eval(surface: &LimitSurface<'_, f32, 3>, places: &[Location], out: &mut Frames) {
    let [position, du, dv] = &mut out.0;
    let rows = position.par_iter_mut().zip(du.par_iter_mut()).zip(dv.par_iter_mut());
    places.par_iter().zip(rows).with_min_len(256).for_each(|(&at, ((position, du), dv))| {
        let jet = surface.eval(at).expect("no mesh that is measured has holes");
        *position = jet.position.map(|x| x as f32);
        *du = jet.du.map(|x| x as f32);
        *dv = jet.dv.map(|x| x as f32);
    });
}

/// Limit stencils of position and first derivatives.
pub fn limit_stencils(table: &PatchTable, places: &[Location]) -> LimitStencilTable<f32> {
    LimitStencilTable::new(table, places).expect("few enough weights")
}

pub fn apply_limit_stencils(table: &LimitStencilTable<f32>, control: &[[f32; 3]], out: &mut [[[f32; 3]; 3]]) {
    table.frames_into(control, out);
}

/// The table after the sharpness of one crease has changed.
pub fn edit_crease(case: &Case, tags: &Tags) -> PatchTable {
    let mut shape = case.shape.clone();
    shape.tags = tags.clone();
    PatchTable::new(&shape.mesh().expect(FITS), shape.our_scheme()).expect(FITS)
}

/// The tags of a mesh with one more crease, along the first edge of a face in the middle.
pub fn one_more_crease(case: &Case, sharpness: f64) -> Tags {
    let face = case.faces() / 2;
    let first: u32 = case.shape.counts[..face].iter().sum();
    let [a, b] = [0, 1].map(|i| case.shape.indices[first as usize + i]);
    let mut tags = case.shape.tags.clone();
    tags.creases.push(Crease::new(a, b, sharpness));
    tags
}
