//! The mesh of one [fan](super::fan): its faces and the outer layer round one of them. Built once for all fans of a shape; of its
//! refined points only those next to the spokes depend on sharpness, the rows of the others are shared.

use super::super::corner::{Corner, Kind};
use super::super::local_step::quad_neighbourhood;
use super::super::rows::Rows;
use super::fan::{CornerFan, FanShape};
use super::points::{Rings, Step};
use super::refined_points::RefinedPoints;
use crate::index::{Face, HalfEdge};
use crate::scheme::{Scheme, SplitKind};
use crate::topology::{SharpnessColumn, Topology};
use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex, PoisonError};

/// The mesh of a fan, which takes the sharpness of one fan after the other.
#[derive(Clone)]
pub(super) struct FanMesh {
    /// The quad comes first of the half-edges `own`; vertex `k` is the `k`-th of the ring.
    pub topology: Topology,
    pub own: [HalfEdge; 4],
    /// Edges of the spokes, and those that go on beyond the quad's two.
    spokes: Vec<u32>,
    beyond: Vec<(u32, u32)>,
    smooth_edges: SharpnessColumn,
    smooth_vertices: SharpnessColumn,
    /// Refined points that depend on sharpness, and rows of the others.
    varying: Vec<u32>,
    fixed: Arc<Rows>,
    /// The children's rings: fixed points first.
    rings: Arc<Rings>,
    /// At a vertex of many faces, whose mask is as long as the ring: the rings where it is the mask of a smooth vertex, which is
    /// the last of the fixed rows then.
    smooth_rings: Option<Arc<Rings>>,
}

/// Terms of a vertex's row from which on it is shared by all fans of a shape where it can be.
const LONG: usize = 64;

impl FanMesh {
    pub fn new(shape: FanShape) -> Self {
        let kind = if shape.is_closed { Kind::Smooth } else { Kind::Crease };
        let (mesh, _) = quad_neighbourhood(Corner { split: SplitKind::Quads, kind, n: shape.faces, i: shape.own });
        let t = Topology::new(&mesh).expect("the neighbourhood is a mesh");
        let own = [0, 1, 2, 3].map(|c| t.half_edge(Face(shape.own), c));
        let spoke = |j: u32| t.half_edge(Face(j), 0);
        let mut spokes: Vec<u32> = (0..shape.faces).map(|j| t.edge(spoke(j)).0).collect();
        if !shape.is_closed {
            spokes.push(t.edge(t.half_edge(Face(shape.faces - 1), 3)).0);
        }
        // Round an edge point that lies inside, the spoke goes on two edges further.
        let on = |h: HalfEdge| t.turn_left(h).and_then(|h| t.turn_left(h)).map(|h| t.edge(h).0);
        let after = (shape.own + 1) % spokes.len() as u32;
        let beyond = [(shape.own, t.twin(own[0]).and_then(on)), (after, t.twin(own[3]).map(|_| own[3]).and_then(on))];
        let beyond: Vec<(u32, u32)> = beyond.into_iter().filter_map(|(spoke, e)| Some((spoke, e?))).collect();

        let edge_points = (t.vertex_count() + t.face_count()) as u32;
        let mut varying = vec![0, t.origin(own[1]).0, t.origin(own[3]).0];
        varying.extend(spokes.iter().chain(beyond.iter().map(|(_, e)| e)).map(|e| edge_points + e));
        let mut fan = CornerFan::default();
        let below = own.map(|h| {
            let mut ring = Vec::new();
            fan.below(&t, h, Some(&mut ring));
            ring
        });
        let mut fixed: Vec<u32> = below.concat();
        fixed.sort_unstable();
        fixed.dedup();
        let depend: HashSet<u32> = varying.iter().copied().collect();
        fixed.retain(|v| !depend.contains(v));
        let mut points = RefinedPoints::default();
        points.clear(&t, edge_points as usize + t.edge_count());
        fixed.iter().for_each(|&v| _ = points.row(&t, Scheme::CatmullClark, v));
        let is_long = 2 * shape.faces as usize > LONG && shape.is_closed;
        if is_long {
            points.row(&t, Scheme::CatmullClark, varying[0]);
        }
        let (first, fixed_rows) = (fixed.len() as u32, points.rows().len() as u32);
        let row: HashMap<u32, u32> =
            fixed.iter().copied().zip(0..).chain(varying.iter().copied().zip(fixed_rows..)).collect();
        let mut rings = Rings::default();
        below.iter().for_each(|ring| rings.push(ring.iter().map(|v| row[v])));
        // The vertex comes first of what varies.
        let without = |p: u32| {
            if p == fixed_rows {
                first
            } else if p > fixed_rows {
                p - 1
            } else {
                p
            }
        };
        let smooth_rings = is_long.then(|| Arc::new(rings.renumbered(without)));
        let (smooth_edges, smooth_vertices) = (t.edge_sharpness.clone(), SharpnessColumn::smooth(t.vertex_count()));
        let (fixed, rings) = (Arc::new(points.rows().clone().with_shared_weights()), Arc::new(rings.shrunk()));
        Self { topology: t, own, spokes, beyond, smooth_edges, smooth_vertices, varying, fixed, rings, smooth_rings }
    }

    /// Takes the sharpness of a fan of its shape.
    pub fn set(&mut self, fan: &CornerFan) {
        let t = &mut self.topology;
        t.edge_sharpness.assign(&self.smooth_edges);
        for &(spoke, s) in &fan.spokes {
            t.edge_sharpness.set(self.spokes[spoke as usize] as usize, s);
            let on = self.beyond.iter().filter(|on| on.0 == spoke);
            on.for_each(|&(_, e)| t.edge_sharpness.set(e as usize, s));
        }
        t.index_sharp_edges();
        t.vertex_sharpness.assign(&self.smooth_vertices);
        t.vertex_sharpness.set(0, fan.vertex);
    }

    /// The refined points that the children need, with the sharpness that was set.
    pub fn step(&self, scratch: &mut RefinedPoints) -> Step {
        let t = &self.topology;
        scratch.clear(t, t.vertex_count() + t.face_count() + t.edge_count());
        self.varying.iter().for_each(|&v| _ = scratch.row(t, Scheme::CatmullClark, v));
        let rows = scratch.rows();
        let smooth = self.smooth_rings.as_ref().filter(|_| self.fixed.terms(self.fixed.len() - 1) == rows.terms(0));
        let (own, rings) = match smooth {
            Some(rings) => (rows.in_order(&(1..rows.len()).collect::<Vec<_>>()), rings),
            None => (rows.clone(), &self.rings),
        };
        Step::new(Some(self.fixed.clone()), own, rings.clone())
    }
}

/// The meshes of fans, by shape.
#[derive(Default)]
pub(super) struct FanMeshes(Mutex<HashMap<FanShape, Copies>>);

/// The mesh of a shape, of which every thread that is at work with one has a copy.
struct Copies {
    original: FanMesh,
    /// Boxed, so that lending one moves a pointer.
    #[allow(clippy::vec_box)]
    free: Vec<Box<FanMesh>>,
}

/// Most faces of an open fan whose mesh is kept. Larger: memory, since `n` faces at a vertex see `n` shapes of `n` faces each;
/// smaller: meshes made anew for every pattern of sharpness.
const MOST_OPEN: u32 = 32;

impl FanMeshes {
    /// Calls `f` with the mesh of a fan.
    pub fn with<R>(&self, fan: &CornerFan, f: impl FnOnce(&FanMesh) -> R) -> R {
        if !fan.shape.is_closed && fan.shape.faces > MOST_OPEN {
            let mut mesh = FanMesh::new(fan.shape);
            mesh.set(fan);
            return f(&mesh);
        }
        let all = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let copy = |copies: &mut Copies| copies.free.pop().unwrap_or_else(|| Box::new(copies.original.clone()));
        let known = all().get_mut(&fan.shape).map(copy);
        let mut mesh = known.unwrap_or_else(|| {
            // Made while the list is free, since that may run other tasks; where two were made, one is kept.
            let original = FanMesh::new(fan.shape);
            copy(all().entry(fan.shape).or_insert(Copies { original, free: Vec::new() }))
        });
        mesh.set(fan);
        let result = f(&mesh);
        if let Some(copies) = all().get_mut(&fan.shape) {
            copies.free.push(mesh);
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use super::super::points::Points;
    use super::*;

    /// Every spoke smooth but those of a pattern, semi-sharp.
    fn fan(shape: FanShape, pattern: u32) -> CornerFan {
        let spokes = shape.faces + u32::from(!shape.is_closed);
        let is_end = |j: u32| !shape.is_closed && (j == 0 || j + 1 == spokes);
        let sharpness = |j: u32| match (is_end(j), pattern >> j & 1) {
            (true, _) => 10.0,
            (false, 1) => 1.25 + f64::from(j),
            _ => 0.0,
        };
        let spokes = (0..spokes).map(|j| (j, sharpness(j))).filter(|spoke| spoke.1 > 0.0).collect();
        CornerFan { shape, vertex: f64::from(pattern & 2), spokes }
    }

    fn all_shapes() -> impl Iterator<Item = FanShape> {
        let closed = (2..8).map(|faces| FanShape { is_closed: true, faces, own: 0 });
        let open = (1..6).flat_map(|n| (0..n).map(move |own| FanShape { is_closed: false, faces: n, own }));
        closed.chain(open)
    }

    #[test]
    fn the_child_at_the_vertex_is_the_fan_with_less_sharpness() {
        let meshes = FanMeshes::default();
        for shape in all_shapes() {
            for pattern in 0..16 {
                let fan = fan(shape, pattern);
                meshes.with(&fan, |mesh| {
                    let mut below = CornerFan::default();
                    let mut ring = Vec::new();
                    below.below(&mesh.topology, mesh.own[0], Some(&mut ring));
                    let less = |s: f64| if s < 10.0 { (s - 1.0).max(0.0) } else { s };
                    let spokes = fan.spokes.iter().map(|&(j, s)| (j, less(s))).filter(|spoke| spoke.1 > 0.0).collect();
                    assert_eq!(below, CornerFan { shape, vertex: less(fan.vertex), spokes });
                    // Its ring is as large as that of the fan.
                    assert_eq!(ring.len(), mesh.topology.vertex_count(), "{fan:?}");
                });
            }
        }
    }

    #[test]
    fn the_points_of_the_children_are_those_that_masks_give() {
        let meshes = FanMeshes::default();
        let (mut scratch, mut direct) = (RefinedPoints::default(), RefinedPoints::default());
        for shape in all_shapes() {
            for pattern in [0, 3, 5, 9, 14] {
                meshes.with(&fan(shape, pattern), |mesh| {
                    let t = &mesh.topology;
                    let points = Points::new(mesh.step(&mut scratch));
                    for c in 0..4 {
                        let mut ring = Vec::new();
                        CornerFan::default().below(t, mesh.own[c], Some(&mut ring));
                        direct.clear(t, t.vertex_count() + t.face_count() + t.edge_count());
                        for (&row, &v) in points.step.rings.get(c).iter().zip(&ring) {
                            let row: Vec<_> = points.row(row as usize).collect();
                            let i = direct.row(t, Scheme::CatmullClark, v) as usize;
                            assert_eq!(row, direct.rows().row(i).collect::<Vec<_>>(), "{shape:?} child {c}");
                        }
                    }
                });
            }
        }
    }
}
