//! Catmull-Clark and bilinear refinement without topology below the control mesh: where the vertices of a level lie follows
//! from half-edges of the control mesh (their children by arithmetic, after Dupuy, Vanhoey 2021), and so do their
//! neighbours. Level follows level, each written once in its final order, the last one where it is wanted.
//!
//! What lies inside a control face is a regular grid; what lies on a control edge is one with at most one sharp row; only
//! control vertices have rules that depend on their surroundings. Threads share faces, not parts of one: a few faces at great
//! depth occupy as few threads.

mod first_step;
mod grid;
mod places;
mod rules;
mod sides;
mod step;

use super::numbering::Counts;
use super::uniform::zeroed;
use crate::index::Vertex;
use crate::mask::is_linear;
use crate::mesh::MeshError;
use crate::real::Real;
use crate::scheme::{Scheme, SplitKind};
use crate::sharpness::decay;
use crate::tags::Creasing;
use crate::topology::{SharpnessColumn, Topology};
use first_step::FirstStep;
use rules::RowGrid;
use sides::Sides;
use step::Step;

/// All steps to a level below a control mesh.
pub(super) struct Direct {
    first: FirstStep,
    /// For the steps below the first.
    sides: Option<Sides>,
    deeper: Vec<Step>,
    /// Vertices of level 1 and those below it.
    counts: Vec<usize>,
}

impl Direct {
    /// `depth` steps; none where sharpness may differ along a control edge or come from beyond the mesh. `t` is as it was
    /// afterwards.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`] where the level would overflow 32-bit indices.
    pub fn new(t: &mut Topology, scheme: Scheme, depth: u32) -> Result<Option<Self>, MeshError> {
        if depth == 0 || scheme.split() != SplitKind::Quads || !is_plain(t, scheme) {
            return Ok(None);
        }
        let mut counts = Counts::of(t);
        let mut vertices = Vec::with_capacity(depth as usize);
        for _ in 0..depth {
            counts = counts.refined(SplitKind::Quads)?;
            vertices.push(counts.vertices);
        }
        let special = special_vertices(t);
        let mut grids = [false, true].map(|is_boundary| RowGrid::new(t, scheme, is_boundary));
        let first = FirstStep::new(t, scheme, &special, &mut grids[0]);
        let sides = (depth > 1).then(|| Sides::new(t));
        let mut deeper = Vec::with_capacity(depth as usize - 1);
        let fades = [&t.edge_sharpness, &t.vertex_sharpness].iter().any(|column| column.distinct().next().is_some());
        if let Some(sides) = sides.as_ref().filter(|_| !fades) {
            deeper.extend((1..depth).map(|level| Step::new(t, sides, scheme, level, &special, &mut grids)));
        } else if let Some(sides) = &sides {
            let columns = [t.edge_sharpness.clone(), t.vertex_sharpness.clone()];
            for level in 1..depth {
                [t.edge_sharpness, t.vertex_sharpness] = [&t.edge_sharpness, &t.vertex_sharpness].map(decayed);
                t.index_sharp_edges();
                deeper.push(Step::new(t, sides, scheme, level, &special, &mut grids));
            }
            [t.edge_sharpness, t.vertex_sharpness] = columns;
            t.index_sharp_edges();
        }
        Ok(Some(Self { first, sides, deeper, counts: vertices }))
    }

    /// The level's values from those of the control mesh.
    pub fn refine<T: Real, const N: usize>(&self, t: &Topology, values: &[[T; N]], out: &mut [[T; N]]) {
        // One entry into the thread pool for all steps.
        rayon::scope(|_| self.run(t, values, out));
    }

    fn run<T: Real, const N: usize>(&self, t: &Topology, values: &[[T; N]], out: &mut [[T; N]]) {
        let steps = self.deeper.len();
        let between = if steps == 0 { 0 } else { self.counts[steps - 1] };
        // Every other level before the last lies in the output meanwhile.
        let mut between = zeroed(between);
        let (mut from, mut to) = (&mut between[..], out);
        if steps.is_multiple_of(2) {
            std::mem::swap(&mut from, &mut to);
        }
        self.first.refine(t, values, &mut from[..self.counts[0]]);
        let Some(sides) = &self.sides else { return };
        for (step, counts) in self.deeper.iter().zip(self.counts.windows(2)) {
            step.refine(t, sides, &from[..counts[0]], &mut to[..counts[1]]);
            std::mem::swap(&mut from, &mut to);
        }
    }

    /// Vertices and edges with rules of their own, in all steps together.
    pub fn special(&self) -> usize {
        self.first.special() + self.deeper.iter().map(Step::special).sum::<usize>()
    }

    /// Heap memory in bytes of what grows with the control mesh.
    pub fn mesh_bytes(&self) -> usize {
        self.first.bytes()
            + self.sides.as_ref().map_or(0, Sides::bytes)
            + self.deeper.iter().map(Step::mesh_bytes).sum::<usize>()
    }

    /// And of what grows with the depth.
    pub fn step_bytes(&self) -> usize {
        self.deeper.iter().map(Step::bytes).sum()
    }
}

/// True where edits left no gaps, and either all rules are linear, or all of an edge keeps the same sharpness, none runs from a
/// vertex to itself, and no rule takes in what the table does not hold.
fn is_plain(t: &Topology, scheme: Scheme) -> bool {
    let mut values = t.edge_sharpness.distinct();
    let is_uniform = t.rules().creasing == Creasing::Uniform || values.next().is_none();
    let holds_all = t.foreign_sharpness.is_empty() && t.across_seam.is_empty() && t.far_half.is_empty();
    let has_loops = t.edge_vertices.iter().any(|[a, b]| a == b);
    t.edits.leave_no_gaps() && (is_linear(t, scheme) || is_uniform && holds_all && !has_loops)
}

/// Vertices that do not follow the smooth rule at level 0, and so perhaps not below.
fn special_vertices(t: &Topology) -> Vec<u32> {
    let is_special = |v: &u32| t.vertex_sharpness(Vertex(*v)) > 0.0 || t.sharp_edges(Vertex(*v)).len() > 1;
    (0..t.vertex_count() as u32).filter(is_special).collect()
}

/// Sharpness one level down.
fn decayed(column: &SharpnessColumn) -> SharpnessColumn {
    let mut out = SharpnessColumn::smooth(column.len());
    column.sharp().for_each(|i| out.set(i, decay(column.get(i))));
    out
}
