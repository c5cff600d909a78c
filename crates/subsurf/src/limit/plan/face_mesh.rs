//! The surroundings of a quad without their sharpness, its [shape](crate::limit::plan_key::names): many faces of a mesh differ
//! in that alone. Such a shape is cut out once, and takes the sharpness of one face after the other; refined points next to
//! nothing sharp are the same for all of them.
//!
//! That holds where the quad's children are known by their [fans](super::fan).

use super::fan::{CornerFan, has_fans};
use super::points::{Rings, Step};
use super::refined_points::RefinedPoints;
use crate::index::{Face, HalfEdge};
use crate::limit::plan_key::names;
use crate::limit::rows::Rows;
use crate::scheme::Scheme;
use crate::tags::INFINITE_SHARPNESS;
use crate::topology::{NONE, SharpnessColumn, Topology};
use std::sync::{Arc, Mutex, PoisonError};

/// Terms of a row from which on it is looked for among those without sharpness. Smaller: time for meshes of few faces to a vertex.
const LONG: usize = 64;

/// What may be sharp.
#[derive(Clone, Copy)]
enum Element {
    Vertex(u32),
    Edge(u32),
}

/// A shape that was cut out.
#[derive(Clone)]
pub(super) struct FaceMesh {
    pub topology: Topology,
    pub own: [HalfEdge; 4],
    /// The elements of the slots, corner by corner.
    slots: [Vec<Element>; 4],
    /// Edges and vertices with nothing sharp but boundaries.
    smooth_edges: SharpnessColumn,
    smooth_vertices: SharpnessColumn,
    /// The refined points of all children then, by the numbers of the next level.
    smooth: Arc<Smooth>,
    /// Refined points that sharpness changes.
    changed: Vec<u32>,
}

struct Smooth {
    rows: Arc<Rows>,
    /// Which refined vertices the rows are.
    vertices: Vec<u32>,
    rings: Arc<Rings>,
}

impl FaceMesh {
    /// That of a cut-out, if the children of its face are known by fans.
    pub fn new(mut t: Topology, scheme: Scheme, points: &mut RefinedPoints) -> Option<Self> {
        let own: Vec<HalfEdge> = (0..t.sides(Face(0))).map(|c| t.half_edge(Face(0), c)).collect();
        if !has_fans(&t, &own, scheme) {
            return None;
        }
        let own = <[HalfEdge; 4]>::try_from(own).ok()?;
        let slots = own.map(|h| elements(&t, h));
        for e in slots.iter().flatten() {
            match *e {
                Element::Vertex(v) => t.vertex_sharpness.set(v as usize, 0.0),
                Element::Edge(e) => {
                    let is_boundary = t.twin[t.edge_half_edge[e as usize] as usize] == NONE;
                    t.edge_sharpness.set(e as usize, if is_boundary { INFINITE_SHARPNESS } else { 0.0 });
                }
            }
        }
        t.index_sharp_edges();
        points.clear(&t, t.vertex_count() + t.face_count() + t.edge_count());
        let (mut rings, mut vertices, mut list) = (Rings::default(), Vec::new(), Vec::new());
        for h in own {
            list.clear();
            CornerFan::default().below(&t, h, Some(&mut list));
            let row = |&v: &u32| {
                let row = points.row(&t, scheme, v);
                if row as usize == vertices.len() {
                    vertices.push(v);
                }
                row
            };
            rings.push(list.iter().map(row));
        }
        let smooth = Smooth {
            rows: Arc::new(points.rows().clone().with_shared_weights()),
            vertices,
            rings: Arc::new(rings.shrunk()),
        };
        let (smooth_edges, smooth_vertices) = (t.edge_sharpness.clone(), t.vertex_sharpness.clone());
        let (smooth, changed) = (Arc::new(smooth), Vec::new());
        Some(Self { topology: t, own, slots, smooth_edges, smooth_vertices, smooth, changed })
    }

    /// Takes the sharpness of a node's key, each changed by `change`.
    pub fn set(&mut self, key: &[u32], change: impl Fn(f64) -> f64) {
        let Self { topology: t, slots, smooth_edges, smooth_vertices, changed, .. } = self;
        t.edge_sharpness.assign(smooth_edges);
        t.vertex_sharpness.assign(smooth_vertices);
        changed.clear();
        let edge_points = (t.vertex_count() + t.face_count()) as u32;
        for (corner, number, s) in names::slots(key) {
            let (vertex, s) = (slots[corner][0], change(s));
            let point = match slots[corner][number] {
                Element::Vertex(v) => {
                    t.vertex_sharpness.set(v as usize, s);
                    v
                }
                Element::Edge(e) if smooth_edges.get(e as usize) == s => continue,
                Element::Edge(e) => {
                    t.edge_sharpness.set(e as usize, s);
                    edge_points + e
                }
            };
            let Element::Vertex(v) = vertex else { unreachable!("the vertex comes first") };
            changed.extend([v, point]);
        }
        changed.sort_unstable();
        changed.dedup();
        t.index_sharp_edges();
    }

    /// The refined points that the children need, with the sharpness that was set.
    pub fn step(&self, points: &mut RefinedPoints) -> Step {
        let (t, smooth, changed) = (&self.topology, &self.smooth, &self.changed);
        points.clear(t, t.vertex_count() + t.face_count() + t.edge_count());
        changed.iter().for_each(|&v| _ = points.row(t, Scheme::CatmullClark, v));
        if changed.is_empty() {
            return Step::new(Some(smooth.rows.clone()), points.rows().clone(), smooth.rings.clone());
        }
        // A vertex of many faces may keep its mask, as at a dart: that is as long as the ring.
        let rows = points.rows();
        let keeps = |i: usize| {
            let is_row = |v: &u32| *v == changed[i];
            rows.terms(i).0.len() > LONG
                && smooth.vertices.iter().position(is_row).is_some_and(|k| smooth.rows.terms(k) == rows.terms(i))
        };
        let (mut own, mut number) = (Vec::with_capacity(rows.len()), Vec::with_capacity(rows.len()));
        for i in 0..rows.len() {
            let is_kept = keeps(i);
            number.push((!is_kept).then_some((smooth.vertices.len() + own.len()) as u32));
            own.extend((!is_kept).then_some(i));
        }
        let row = |row: u32| {
            let at = changed.binary_search(&smooth.vertices[row as usize]).ok();
            at.and_then(|i| number[i]).unwrap_or(row)
        };
        let rings = Arc::new(smooth.rings.renumbered(row));
        let own = if own.len() == rows.len() { rows.clone() } else { rows.in_order(&own) };
        Step::new(Some(smooth.rows.clone()), own, rings)
    }
}

/// The elements of a corner's slots.
fn elements(t: &Topology, own: HalfEdge) -> Vec<Element> {
    let edge = |h: HalfEdge| Element::Edge(t.edge(h).0);
    let mut out = vec![Element::Vertex(t.origin(own).0), edge(own)];
    let mut at = own;
    let is_closed = loop {
        out.push(edge(t.prev(at)));
        match t.turn_left(at) {
            Some(h) if h == own => break true,
            Some(h) => at = h,
            None => break false,
        }
    };
    let mut at = own;
    while let Some(h) = t.turn_right(at).filter(|_| !is_closed) {
        out.push(edge(h));
        at = h;
    }
    out
}

/// Shapes that were cut out, by their numbers.
#[derive(Default)]
pub(super) struct FaceMeshes(Vec<Tried>);

// Boxed, so that lending a mesh moves a pointer.
#[allow(clippy::vec_box)]
#[derive(Default)]
enum Tried {
    #[default]
    Not,
    /// Children are not known by fans.
    InVain,
    /// The mesh, of which every thread that is at work with one has a copy.
    Made(Mutex<Vec<Box<FaceMesh>>>, Box<FaceMesh>),
}

impl FaceMeshes {
    /// Makes room for so many shapes.
    pub fn grow(&mut self, shapes: usize) {
        self.0.resize_with(shapes, Tried::default);
    }

    /// True where a mesh has not been asked for.
    pub fn is_open(&self, shape: u32) -> bool {
        matches!(self.0[shape as usize], Tried::Not)
    }

    pub fn put(&mut self, shape: u32, mesh: Option<FaceMesh>) {
        self.0[shape as usize] = mesh.map_or(Tried::InVain, |mesh| Tried::Made(Mutex::default(), Box::new(mesh)));
    }

    /// Calls `f` with the mesh of a node's shape, if there is one.
    pub fn with<R>(&self, key: &[u32], f: impl FnOnce(&mut FaceMesh) -> R) -> Option<R> {
        let Tried::Made(free, original) = &self.0[names::shape(key)? as usize] else { return None };
        let copies = || free.lock().unwrap_or_else(PoisonError::into_inner);
        let known = copies().pop();
        let mut mesh = known.unwrap_or_else(|| original.clone());
        let result = f(&mut mesh);
        copies().push(mesh);
        Some(result)
    }
}

#[cfg(test)]
mod tests {
    use super::super::points::Points;
    use super::*;
    use crate::limit::plan::may_have_fans;
    use crate::limit::plan_key::{Names, walk_plan};
    use crate::mesh::ControlMesh;
    use crate::shapes;
    use crate::tags::{Corner, Crease, Tags};
    use crate::topology::{Around, Cutter, Lowest, Surroundings, Walk};
    use std::collections::BTreeMap;

    /// A grid with creases across each other, of many sharpnesses, and some sharp vertices.
    fn creased_grid(side: u32) -> ControlMesh {
        let at = |i: u32, j: u32| i * (side + 1) + j;
        let faces: Vec<[u32; 4]> = (0..side * side)
            .map(|f| (f / side, f % side))
            .map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)])
            .collect();
        let along = (0..side).map(|i| Crease::new(at(i, 2), at(i + 1, 2), 0.25 * f64::from(i)));
        let across = (0..side).map(|j| Crease::new(at(3, j), at(3, j + 1), 10.0 - f64::from(j)));
        let corners = (1..side).map(|i| Corner::new(at(i, i), 0.5 * f64::from(i))).collect();
        ControlMesh::new(&faces, Tags { creases: along.chain(across).collect(), corners, ..Tags::default() }).unwrap()
    }

    #[test]
    fn a_shape_with_a_face_s_sharpness_gives_the_points_that_masks_give() {
        let scheme = Scheme::CatmullClark;
        let (mut walk, mut around, mut cutter) = (Walk::default(), Surroundings::default(), Cutter::default());
        let (mut points, mut direct) = (RefinedPoints::default(), RefinedPoints::default());
        let mut met_again = 0;
        for mesh in shapes::all().into_iter().map(|shape| shape.mesh).chain([creased_grid(12)]) {
            let t = Topology::new(&mesh).unwrap();
            if !may_have_fans(&t, scheme) {
                continue;
            }
            let (mut names, mut meshes) = (Names::new(true), BTreeMap::new());
            for face in (0..t.face_count()).map(Face::new).filter(|&face| t.sides(face) == 4) {
                let start = walk_plan(&t, face, None, &mut walk, &mut around);
                let key = names.plan_key(&around.key).split_last().unwrap().1.to_vec();
                let Some(shape) = names::shape(&key) else { continue };
                t.lowered_surroundings(face, start, Lowest::of(&t, face).raise() as i8, &mut walk, &mut around);
                cutter.cut_out(&t, &around, &walk);
                met_again += usize::from(meshes.contains_key(&shape) && names::slots(&key).count() > 0);
                let mesh = meshes
                    .entry(shape)
                    .or_insert_with(|| FaceMesh::new(cutter.cut().clone(), scheme, &mut RefinedPoints::default()));
                let Some(mesh) = mesh else { continue };
                mesh.set(&key, |s| s);
                let (step, cut) = (Points::new(mesh.step(&mut points)), cutter.cut());
                direct.clear(cut, cut.vertex_count() + cut.face_count() + cut.edge_count());
                for c in 0..4 {
                    let (mut ring, mut fan, mut below) = (Vec::new(), CornerFan::default(), CornerFan::default());
                    fan.below(cut, cut.half_edge(Face(0), c), Some(&mut ring));
                    below.below(&mesh.topology, mesh.own[c], None);
                    assert_eq!(fan, below, "{face} child {c}");
                    let rows = step.step.rings.get(c);
                    assert_eq!(rows.len(), ring.len());
                    for (&row, &v) in rows.iter().zip(&ring) {
                        let i = direct.row(cut, scheme, v) as usize;
                        let expected: Vec<_> = direct.rows().row(i).collect();
                        assert_eq!(step.row(row as usize).collect::<Vec<_>>(), expected, "{face} child {c}");
                    }
                }
            }
        }
        assert!(met_again > 50, "{met_again}");
    }
}
