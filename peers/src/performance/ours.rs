//! Everything of ours that is measured, one function for each; nothing else here calls the library to be timed.

use super::case::Case;
use crate::shape::Shape;
use subsurf::{
    Crease, Level, LimitStencilTable, LimitSurface, Location, PatchTable, Rates, Real, StencilTable, TableEditor,
    TessellateOptions, Tessellation, UniformRefinement,
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
    let refinement = Refinement::new(case, depth).0;
    Refined { positions: refinement.refine(&case.control), corners: refinement.corners() }
}

/// What stays when positions change.
pub struct Refinement(UniformRefinement);

impl Refinement {
    pub fn new(case: &Case, depth: u32) -> Self {
        let mesh = case.shape.mesh().expect(FITS);
        Self(UniformRefinement::new(&mesh, case.shape.our_scheme(), depth).expect(FITS))
    }

    /// The positions of the level from new control points, over what was there.
    pub fn update<T: Real>(&self, control: &[[T; 3]], out: &mut [[T; 3]]) {
        self.0.refine_into(control, out);
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
    table.surface(control).tessellate(&options(rate, normals)).expect(FITS)
}

fn options(rate: u32, normals: bool) -> TessellateOptions {
    TessellateOptions { rates: Rates::Uniform(rate), normals, ..TessellateOptions::default() }
}

/// Points and normals of a tessellation.
#[derive(Clone, PartialEq, Debug)]
pub struct Samples<T> {
    pub points: Vec<[T; 3]>,
    pub normals: Vec<[T; 3]>,
}

/// What stays when positions change.
pub struct Tessellator<'a, T>(subsurf::Tessellator<'a, T>);

impl<'a, T: Real> Tessellator<'a, T> {
    pub fn new(table: &'a PatchTable, control: &[[T; 3]], rate: u32, normals: bool) -> Self {
        Self(table.tessellator(control, &options(rate, normals)).expect(FITS))
    }

    /// Room for what is evaluated.
    pub fn samples(&self) -> Samples<T> {
        let [points, normals] = [self.0.point_count(), self.0.normal_count()].map(|n| vec![[T::default(); 3]; n]);
        Samples { points, normals }
    }

    /// Points and normals from new control points, over what was there.
    pub fn update(&self, control: &[[T; 3]], out: &mut Samples<T>) {
        self.0.evaluate_into(control, &mut out.points, &mut out.normals);
    }
}

/// Position and first derivatives at places, in the order given.
pub fn eval<T: Real>(surface: &LimitSurface<'_, T, 3>, places: &[Location], rows: &mut [[[T; 3]; 3]]) {
    assert!(surface.eval_into(places, rows).is_empty(), "no place is a vertex or a hole");
}

/// Limit stencils of position and first derivatives.
pub fn limit_stencils(table: &PatchTable, places: &[Location]) -> LimitStencilTable<f32> {
    LimitStencilTable::new(table, places).expect("few enough weights")
}

pub fn apply_limit_stencils(table: &LimitStencilTable<f32>, control: &[[f32; 3]], out: &mut [[[f32; 3]; 3]]) {
    table.frames_into(control, out);
}

/// A table that follows edits, and what is edited: an edge in the middle of the mesh, and the face beside it.
pub struct Editing {
    editor: TableEditor,
    edge: (u32, u32),
    face: Vec<u32>,
    /// The numbers that the face has now, as one or as two.
    now: Vec<u32>,
}

impl Editing {
    pub fn new(case: &Case) -> Self {
        let editor = TableEditor::new(&case.shape.mesh().expect(FITS), case.shape.our_scheme()).expect(FITS);
        let (face, corners) = middle_face(case);
        Self { editor, edge: (corners[0], corners[1]), face: corners, now: vec![face] }
    }

    /// Gives the edge a sharpness.
    pub fn crease(&mut self, sharpness: f64) {
        self.editor.set_creases(&[self.edge], sharpness).expect("the edge is there");
    }

    /// Cuts the face into two along a diagonal, or makes the two one again.
    pub fn cut_or_join(&mut self) {
        let all = self.face.as_slice();
        let parts = [[all[0], all[1], all[2]], [all[0], all[2], all[3]]];
        let new: &[&[u32]] = if self.now.len() == 1 { &[&parts[0], &parts[1]] } else { &[all] };
        let edited = self.editor.replace_faces(&self.now, new).expect("the face is there");
        self.now = edited.added.iter().map(|face| face.0).collect();
    }
}

/// A quad in the middle of a mesh, and its corners.
fn middle_face(case: &Case) -> (u32, Vec<u32>) {
    let half = case.faces() / 2;
    let face = (half..case.faces()).find(|&f| case.shape.counts[f] == 4).expect("meshes that are measured have quads");
    let first = case.shape.counts[..face].iter().sum::<u32>() as usize;
    (face as u32, case.shape.indices[first..first + 4].to_vec())
}

/// A mesh with one more crease, along the edge that [`Editing`] edits.
pub fn one_more_crease(case: &Case, sharpness: f64) -> Shape {
    let (_, corners) = middle_face(case);
    let mut shape = case.shape.clone();
    shape.tags.creases.push(Crease::new(corners[0], corners[1], sharpness));
    shape
}
