//! The levels on which fields start: the mesh refined, cut into sectors once, at level 0.
//!
//! Old vertices keep their numbers from level to level, so that what is known of a sector at level 0 holds at all levels;
//! new vertices are regular but for the centres of faces that are no quads.

use super::ShadingError;
use super::field::{FieldTable, Table};
use super::sectors::Sectors;
use crate::channel::Channel;
use crate::index::{Edge, Face};
use crate::limit::{Method, PatchTable};
use crate::refine::Level;
use crate::scheme::{Scheme, SplitKind};
use crate::tags::{FaceVarying, INFINITE_SHARPNESS};
use crate::topology::Topology;
use std::sync::Arc;

/// Most face corners of a level that a field starts at; a table of so many takes gigabytes.
const MOST_CORNERS: usize = 1 << 25;

pub(super) struct Levels<'a> {
    patches: &'a PatchTable,
    pub sectors: Sectors,
    /// The mesh as it is; only where the other differs.
    whole: Vec<Arc<Level>>,
    /// The mesh cut into sectors: a vertex for every value.
    cut: Vec<Arc<Level>>,
}

/// An extraordinary value of a level.
#[derive(Clone, Copy)]
pub(super) struct Centre {
    pub value: u32,
    pub is_interior: bool,
}

impl<'a> Levels<'a> {
    pub fn new(patches: &'a PatchTable, cut: f64) -> Result<Self, ShadingError> {
        let (t, scheme) = (patches.topology(), patches.scheme());
        let sectors = Sectors::new(t, scheme, cut);
        let level = if sectors.is_parted(t) {
            // Sectors decide what is sharp; seams are smooth curves, but where the limit normal must stay.
            let channel = Channel::face_varying(t, scheme, sectors.len(), &sectors.corner, FaceVarying::None)?;
            let mut topology = channel.topology().clone();
            for (v, _) in sectors.locked.iter().enumerate().filter(|(_, locked)| **locked) {
                topology.vertex_sharpness.set(v, INFINITE_SHARPNESS);
            }
            Level::from_topology(topology, scheme)
        } else {
            Level::from_topology(t.clone(), scheme)
        };
        Ok(Self { patches, sectors, whole: Vec::new(), cut: vec![Arc::new(level)] })
    }

    pub fn scheme(&self) -> Scheme {
        self.patches.scheme()
    }

    /// The level `depth` cut into sectors.
    pub fn cut(&mut self, depth: u32, what: &'static str) -> Result<&Level, ShadingError> {
        refine_to(&mut self.cut, depth, what)
    }

    /// The level `depth` of the mesh itself: the faces of [`cut`](Self::cut), corner by corner.
    pub fn whole(&mut self, depth: u32, what: &'static str) -> Result<&Level, ShadingError> {
        let t = self.patches.topology();
        if !self.sectors.is_parted(t) {
            return self.cut(depth, what);
        }
        if self.whole.is_empty() {
            self.whole.push(Arc::new(Level::from_topology(t.clone(), self.scheme())));
        }
        refine_to(&mut self.whole, depth, what)
    }

    /// A level made before.
    pub fn made(&self, depth: u32) -> &Topology {
        self.cut[depth as usize].topology()
    }

    /// The levels of the mesh itself up to `depth`, made before.
    pub fn whole_up_to(&self, depth: u32) -> Vec<Arc<Level>> {
        let levels = if self.whole.is_empty() { &self.cut } else { &self.whole };
        levels[..=depth as usize].to_vec()
    }

    /// The levels cut into sectors from `from` to `to`, made before.
    pub fn cut_between(&self, from: u32, to: u32) -> Vec<Arc<Level>> {
        self.cut[from as usize..=to as usize].to_vec()
    }

    /// The patch table of fields that start at `depth`, with the surface's masks or linear ones.
    pub fn table(&self, depth: u32, is_linear: bool) -> Result<FieldTable<'a>, ShadingError> {
        let t = self.made(depth);
        if depth == 0 && !is_linear && !self.sectors.is_parted(self.patches.topology()) {
            return Ok(FieldTable { table: Table::Mesh(self.patches), depth });
        }
        let topology = if is_linear { t.with_linear_values() } else { t.clone() };
        let table = PatchTable::from_topology(topology, self.scheme(), Method::default())?;
        Ok(FieldTable { table: Table::Own(Box::new(table)), depth })
    }

    /// The extraordinary values of level `depth`, ascending.
    pub fn centres(&self, depth: u32) -> Vec<Centre> {
        let s = &self.sectors;
        let vertices = (0..s.len()).filter(|&value| s.extraordinary[value]);
        let mut centres: Vec<Centre> =
            vertices.map(|value| Centre { value: value as u32, is_interior: s.interior[value] }).collect();
        if depth > 0 && self.scheme().split() == SplitKind::Quads {
            let t = self.made(0);
            let polygons = (0..t.face_count()).filter(|&f| t.sides(Face::new(f)) != 4);
            centres.extend(polygons.map(|f| Centre { value: (s.len() + f) as u32, is_interior: true }));
        }
        centres
    }

    /// Which values of level `depth` must leave the limit normal alone.
    pub fn locked(&self, depth: u32) -> Vec<bool> {
        let mut locked = self.sectors.locked.clone();
        for step in 0..depth {
            // The middle of a cut edge is as its ends are.
            let t = self.made(step);
            let mut next = locked.clone();
            next.resize(self.made(step + 1).vertex_count() - t.edge_count(), false);
            next.extend(
                (0..t.edge_count() as u32)
                    .map(Edge)
                    .map(|e| t.is_infinitely_sharp(e) && t.edge_vertices(e).iter().all(|v| locked[v.index()])),
            );
            locked = next;
        }
        locked
    }

    /// Values of level `depth` from values of the sectors.
    pub fn refine_values<const N: usize>(&self, values: Vec<[f64; N]>, depth: u32) -> Vec<[f64; N]> {
        self.cut[..depth as usize].iter().fold(values, |values, level| level.refine_values(&values))
    }
}

/// Refuses a level that is too deep before any is made; every step makes four corners of one.
fn refine_to<'l>(levels: &'l mut Vec<Arc<Level>>, depth: u32, what: &'static str) -> Result<&'l Level, ShadingError> {
    let made = levels.len() as u32 - 1;
    let corners = levels[made as usize].topology().half_edge_count();
    let corners = 4usize.saturating_pow(depth.saturating_sub(made)).saturating_mul(corners);
    if depth > made && corners > MOST_CORNERS {
        return Err(ShadingError::TooDeep { what, level: depth, corners, limit: MOST_CORNERS });
    }
    for level in made..depth {
        let next = levels[level as usize].refine()?;
        levels.push(Arc::new(next));
    }
    Ok(&levels[depth as usize])
}
