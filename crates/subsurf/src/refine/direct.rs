//! Catmull-Clark and bilinear refinement without topology below the control mesh: where the vertices of a level lie follows
//! from half-edges of the control mesh (their children by arithmetic, after Dupuy, Vanhoey 2021). Where all faces are
//! quads, which they are below the first level, squares of them go down to the last level without any level between in memory.
//!
//! What lies inside a control face is a regular grid; what lies on a control edge is one with at most one sharp row; only
//! control vertices, and centres of faces that are no quads, have rules that depend on their surroundings: these are refined first,
//! each with its fan. Threads share faces, not parts of one: a few faces at great depth occupy as few threads.

mod fans;
mod first_step;
mod layout;
mod rules;
mod squares;
mod starts;

use super::numbering::{Counts, Region, regions};
use super::parts::write_by_faces;
use super::uniform::zeroed;
use crate::index::Vertex;
use crate::kernel::{LANES, RowRule, SideRules};
use crate::mask::is_linear;
use crate::mesh::MeshError;
use crate::real::Real;
use crate::scheme::{Scheme, SplitKind};
use crate::sharpness::decay;
use crate::tags::Creasing;
use crate::threads::is_alone;
use crate::topology::{FaceOf, SharpnessColumn, Topology};
use fans::{FanTables, Fans};
use first_step::FirstStep;
use layout::Layout;
use rayon::prelude::*;
use rules::{Creases, RowGrid, rounded};
use squares::{Frames, Squares, Tables, flags, has_fan, is_early, rings};
use starts::Starts;

/// Sixteen faces at this level take some hundred kilobytes. Deeper, more memory than the level itself has would be needed for fewer
/// than [`FEW`] faces.
const DEEP: u32 = 5;
const FEW: usize = 4 * LANES;

/// All steps to a level below a control mesh.
pub(super) struct Direct {
    first: Option<FirstStep>,
    deeper: Option<Deeper>,
    /// Vertices of level 1.
    count: usize,
}

/// What all steps of squares need beside the topology.
struct Deeper {
    depth: u32,
    flags: Vec<u8>,
    frames: Frames,
    smooth: RowRule<f64>,
    creases: Creases,
    fans: Fans,
    has_fans: bool,
    regions: Vec<Region>,
    quad: Layout,
    /// Where some face is no quad.
    corner: Option<Layout>,
}

impl Direct {
    /// True where few faces go so deep that the memory at work exceeds the level's, and other ways are to be tried first.
    pub fn is_wasteful(t: &Topology, depth: u32) -> bool {
        depth > DEEP && t.face_count() < FEW
    }

    /// `depth` steps; none where sharpness may differ along a control edge or come from beyond the mesh. `t` is as it was afterwards.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`] where the level would overflow 32-bit indices.
    pub fn new(t: &mut Topology, scheme: Scheme, depth: u32) -> Result<Option<Self>, MeshError> {
        if depth == 0 || scheme.split() != SplitKind::Quads || !is_plain(t, scheme) {
            return Ok(None);
        }
        let count = Counts::of(t).refined(SplitKind::Quads)?.vertices;
        let special = special_vertices(t);
        let mut grids = [false, true].map(|is_boundary| RowGrid::new(t, scheme, is_boundary));
        let is_quads = matches!(t.face, FaceOf::Quads);
        let starts = Starts::new(t);
        let first = (depth == 1 || !is_quads).then(|| {
            let needed = (depth > 1 && starts.has_early).then(|| starts.needed(t));
            FirstStep::new(t, scheme, &special, &mut grids[0], needed)
        });
        let deeper = (depth > 1).then(|| Deeper::new(t, scheme, &starts, depth, &special, grids));
        Ok(Some(Self { first, deeper, count }))
    }

    /// The level's values from those of the control mesh.
    pub fn refine<T: Real, const N: usize>(&self, t: &Topology, values: &[[T; N]], out: &mut [[T; N]]) {
        let mut steps = || match (&self.first, &self.deeper) {
            (None, None) => {}
            (Some(first), None) => first.refine(t, values, out),
            (None, Some(deeper)) => deeper.refine(t, [values, &[]], out),
            (Some(first), Some(deeper)) => {
                let mut level = zeroed(self.count);
                first.refine(t, values, &mut level);
                deeper.refine(t, [values, &level], out);
            }
        };
        // The first time, memory that the pool made the tables in serves for level 1 beside the last.
        let is_elsewhere = self.first.is_some() && self.deeper.as_ref().is_some_and(|deeper| !deeper.frames.had_one());
        if is_alone() && !is_elsewhere {
            return steps();
        }
        // One entry into the thread pool for all steps.
        rayon::scope(|_| steps());
    }

    /// Vertices and edges with rules of their own, in all steps together.
    pub fn special(&self) -> usize {
        self.first.as_ref().map_or(0, FirstStep::special)
            + self.deeper.as_ref().map_or(0, |deeper| deeper.fans.special())
    }

    /// Heap memory in bytes of what grows with the control mesh.
    pub fn mesh_bytes(&self) -> usize {
        self.first.as_ref().map_or(0, FirstStep::bytes)
            + self.deeper.as_ref().map_or(0, |deeper| deeper.fans.bytes() + deeper.flags.len() + deeper.frames.bytes())
    }

    /// And of what grows with the depth.
    pub fn step_bytes(&self) -> usize {
        self.deeper.as_ref().map_or(0, |deeper| {
            let layouts = [Some(&deeper.quad), deeper.corner.as_ref()];
            layouts.into_iter().flatten().map(Layout::bytes).sum::<usize>()
                + deeper.creases.bytes()
                + size_of_val(&deeper.regions[..])
        })
    }
}

impl Deeper {
    fn new(
        t: &mut Topology,
        scheme: Scheme,
        starts: &Starts,
        depth: u32,
        special: &[u32],
        mut grids: [RowGrid; 2],
    ) -> Self {
        let start = u32::from(!starts.has_early);
        let levels = start as usize..depth as usize;
        let smooth = grids[0].rule(0.0);
        let creases = Creases::new(t, scheme, levels.clone(), &mut grids);
        let has_fans = !is_linear(t, scheme);
        let mut fans = Fans::default();
        if has_fans {
            fans = Fans::new(t, &creases, starts, levels);
            let fades =
                [&t.edge_sharpness, &t.vertex_sharpness].iter().any(|column| column.distinct().next().is_some());
            let columns = fades.then(|| [t.edge_sharpness.clone(), t.vertex_sharpness.clone()]);
            for level in 0..depth {
                if fades && level > 0 {
                    [t.edge_sharpness, t.vertex_sharpness] = [&t.edge_sharpness, &t.vertex_sharpness].map(decayed);
                    t.index_sharp_edges();
                }
                if level >= start {
                    fans.add_rows(t, scheme, special);
                }
            }
            if let Some(columns) = columns {
                [t.edge_sharpness, t.vertex_sharpness] = columns;
                t.index_sharp_edges();
            }
        }
        let flags = flags(t, starts, &fans, !has_fans);
        let regions = regions(Counts::of(t), SplitKind::Quads, depth);
        let has_others = !matches!(t.face, FaceOf::Quads);
        let (quad, corner) = (Layout::quad(&regions, depth), has_others.then(|| Layout::corner(&regions, depth)));
        let frames = Frames::default();
        Self { depth, flags, frames, smooth, creases, fans, has_fans, regions, quad, corner }
    }

    /// The last level from values of the control mesh, and of level 1 where some squares start there.
    fn refine<T: Real, const N: usize>(&self, t: &Topology, levels: [&[[T; N]]; 2], out: &mut [[T; N]]) {
        let tables = self.frames.tables(|| Tables {
            rings: rings(t, |first| is_early(&self.flags, first)),
            fans: self.has_fans.then(|| FanTables::new(t, &self.fans, |h| has_fan(&self.flags, h))),
        });
        let fan_tables = tables.and_then(|tables| tables.fans.as_ref());
        let fans = self.has_fans.then(|| self.fans.refine(t, &self.creases, levels, fan_tables));
        write_by_faces(t, &self.regions, levels[0], out, || Squares::new(self, t, levels, fans.as_ref(), tables));
        if let Some(fans) = &fans {
            self.fans.write(fans, out);
        }
    }

    /// The rules along one side of sixteen squares, of these kinds.
    #[inline(always)]
    fn side_rules<T: Real>(&self, level: usize, kinds: &[u32; LANES]) -> SideRules<T> {
        let RowRule { edge, vertex } = rounded::<T>(&self.smooth);
        let mut out = SideRules {
            edge: [[edge[0]; LANES], [edge[1]; LANES]],
            vertex: [[vertex[0]; LANES], [vertex[1]; LANES], [vertex[2]; LANES], [vertex[3]; LANES]],
        };
        for (lane, &kind) in kinds.iter().enumerate().filter(|(_, kind)| **kind != 0) {
            let RowRule { edge, vertex } = rounded::<T>(self.creases.rule(level, kind));
            (0..2).for_each(|i| out.edge[i][lane] = edge[i]);
            (0..4).for_each(|i| out.vertex[i][lane] = vertex[i]);
        }
        out
    }
}

/// True where edits left no gaps, and either all rules are linear, or all of an edge keeps the same sharpness, none runs from a
/// vertex to itself, and no rule takes in what the table does not hold.
fn is_plain(t: &Topology, scheme: Scheme) -> bool {
    let mut values = t.edge_sharpness.distinct();
    let is_uniform = t.rules().creasing == Creasing::Uniform || values.next().is_none();
    let holds_all = t.foreign_sharpness.is_empty() && t.across_seam.is_empty() && t.far_half.is_empty();
    // Blocks as a whole: hardly a mesh has any.
    let is_loop = |edges: &[[u32; 2]]| edges.iter().fold(false, |found, [a, b]| found | (a == b));
    let has_loops = t.edge_vertices.par_chunks(EDGES).any(is_loop);
    t.edits.leave_no_gaps() && (is_linear(t, scheme) || is_uniform && holds_all && !has_loops)
}

/// Vertices that do not follow the smooth rule at level 0, and so perhaps not below.
fn special_vertices(t: &Topology) -> Vec<u32> {
    let is_special = |v: &u32| t.vertex_sharpness(Vertex(*v)) > 0.0 || t.sharp_edges(Vertex(*v)).len() > 1;
    let block = |first: usize| first..(first + VERTICES).min(t.vertex_count());
    let blocks = (0..t.vertex_count()).step_by(VERTICES).map(block).filter(|block| !t.nothing_is_sharp(block.clone()));
    blocks.flatten().map(|v| v as u32).filter(is_special).collect()
}

/// Edges that a thread looks at together, and vertices.
const EDGES: usize = 1 << 14;
const VERTICES: usize = 128;

/// Sharpness one level down.
fn decayed(column: &SharpnessColumn) -> SharpnessColumn {
    let mut out = SharpnessColumn::smooth(column.len());
    column.sharp().for_each(|i| out.set(i, decay(column.get(i))));
    out
}
