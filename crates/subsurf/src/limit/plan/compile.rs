//! Compiles plans: refines the surroundings of faces until a known patch covers each part, generation by generation, so
//! that surroundings that were met before are not compiled again.

mod alike;
mod numbers;

use super::super::linear_boundary::{LinearEnds, has_side};
use super::super::plan_key::names::{Apart, open_plan_key};
use super::super::plan_key::{Keys, canonical_corner};
use super::face_mesh::{FaceMesh, FaceMeshes};
use super::fan::{CornerFan, has_fans};
use super::fan_mesh::FanMeshes;
use super::points::{Points, Rings, Step};
use super::refined_points::RefinedPoints;
use super::sub_patches::SubPatches;
use super::template::Part;
use super::{Leaf, Link, Plans, SpecialVertices};
use crate::index::{Face, HalfEdge};
use crate::limit::patch_table::Start;
use crate::refine::{NextHalfEdges, NextLevel};
use crate::scheme::Scheme;
use crate::topology::{Around, Cutter, Lowest, Surroundings, Tables, Topology, Walk};
pub(in crate::limit) use numbers::Numbers;
use numbers::{Known, NODES, Open};
use std::sync::Arc;

/// More generations than any surroundings need: each drops one of at most ten different whole parts of sharpness or tells
/// faces apart that were met first; reaching it is a defect of the classification.
const DEEPEST: u32 = 48;

impl Plans {
    /// No plans yet.
    pub(in crate::limit) fn empty(scheme: Scheme) -> Self {
        Self { split: scheme.split(), nodes: Vec::new(), plans: Vec::new(), parts: SubPatches::new() }
    }

    /// Adds plans by their keys, each with a face of `mesh` and the corner that the walk round it starts at. `numbers` are those of
    /// the nodes that are there already.
    pub(in crate::limit) fn add<'a>(
        &mut self,
        mesh: &Topology,
        plans: impl ExactSizeIterator<Item = (&'a [u32], Start)>,
        scheme: Scheme,
        specials: &SpecialVertices,
        numbers: &mut Numbers,
    ) {
        let is_first = self.plans.is_empty();
        if is_first {
            numbers.reserve(plans.len());
            self.nodes.reserve(NODES * plans.len());
        }
        for (key, (face, start)) in plans {
            let (key, raise) = open_plan_key(key);
            let place = Place { face: Face(face), start, raise: raise as i8 };
            self.plans.push(Link { node: numbers.face(key, place), raise });
        }
        for _ in 0..DEEPEST {
            let open = numbers.take_open();
            if open.is_empty() {
                if is_first {
                    self.nodes.shrink_to_fit();
                }
                self.parts.grow(self.plans.len());
                return;
            }
            numbers.generation(mesh, scheme, specials, open, &mut self.nodes);
        }
        unreachable!("a patch tree does not end")
    }
}

/// Surroundings, by the face and the corner that the walk starts at, lowered.
#[derive(Clone, Copy)]
struct Place {
    face: Face,
    start: u32,
    raise: i8,
}

/// Where the children of a node are cut out.
enum Parent {
    /// From a cut-out, with the half-edges of the level below.
    Kept(Box<(Topology, NextHalfEdges)>),
    /// From one that is large, and made again when a child needs it: its own parent and its place there.
    Again(Option<Arc<Parent>>, Place),
}

/// Most vertices of a cut-out that is kept until the next generation. Larger: memory, since `n` faces at a vertex have `n` cut-outs
/// of `n` faces each; smaller: time to make them again.
const MOST_KEPT: usize = 256;

/// Where a child leads to.
struct MadeLink {
    /// Where the node's surroundings are, if they do not follow from its key.
    place: Option<Place>,
    /// What remains of the raise at the node.
    raise: u8,
    node: MadeNode,
}

enum MadeNode {
    Known(u32),
    /// Not known at the time that its key was made; of a walk with the places where sharpness stands in it.
    New(Box<[u32]>, Box<[u32]>),
}

/// A node whose children have no numbers yet.
struct Made {
    ring: usize,
    body: MadeBody,
}

enum MadeBody {
    Leaf(Leaf),
    /// The surroundings, where some child has a new key, and all four children or the first alone.
    Split {
        parent: Option<Arc<Parent>>,
        points: Points,
        children: Vec<MadeChild>,
        ends: Option<LinearEnds>,
    },
}

struct MadeChild {
    /// From the node as it is.
    low: MadeLink,
    /// From the node raised by 1, where that leads to another node.
    high: Option<MadeLink>,
    turn: u8,
}

impl MadeChild {
    fn is_new(&self) -> bool {
        [Some(&self.low), self.high.as_ref()].into_iter().flatten().any(|l| matches!(l.node, MadeNode::New(..)))
    }
}

/// Reusable memory.
#[derive(Default)]
struct Scratch {
    around: Walked,
    cutter: Cutter,
    points: RefinedPoints,
    half_edges: NextHalfEdges,
    fan: CornerFan,
    list: Vec<u32>,
    key: Vec<u32>,
    apart: Apart,
    /// The parent that was cut out again last.
    again: Option<(Arc<Parent>, Topology, NextHalfEdges)>,
}

/// A walk, and the surroundings that it met.
#[derive(Default)]
struct Walked {
    walk: Walk,
    list: Surroundings,
}

impl Walked {
    fn go(&mut self, t: &impl Tables, Place { face, start, raise }: Place) {
        t.lowered_surroundings(face, start as usize, raise, &mut self.walk, &mut self.list);
    }

    fn cut_out(&mut self, t: &impl Tables, place: Place, cutter: &mut Cutter) {
        self.go(t, place);
        cutter.cut_out(t, &self.list, &self.walk);
    }
}

/// What nodes are made from.
pub(super) struct Compiler<'a> {
    pub mesh: &'a Topology,
    pub fan_meshes: &'a FanMeshes,
    pub face_meshes: &'a FaceMeshes,
    pub scheme: Scheme,
    pub specials: &'a SpecialVertices,
}

impl Compiler<'_> {
    fn node(&self, key: &[u32], open: &Open, known: &Known, scratch: &mut Scratch) -> Made {
        let Some((parent, place)) = &open.face else {
            let fan = CornerFan::of_key(key).expect("a fan's key");
            let Scratch { points, fan: below, list, .. } = scratch;
            let child = |below: &CornerFan, c| fan_child(below, fan.lowest(), c, &known.nodes, list);
            return made(self.fan_mesh(&fan, points, below, child));
        };
        let Scratch { points, fan: below, list, .. } = scratch;
        let with = |mesh: &mut FaceMesh| {
            mesh.set(key, |s| s);
            let lowest = Lowest::of(&mesh.topology, Face(0));
            let child = |below: &CornerFan, c| fan_child(below, lowest, c, &known.nodes, list);
            made(self.face_mesh(mesh, points, below, child))
        };
        if let Some(made) = self.face_meshes.with(key, with) {
            return made;
        }
        self.cut_out(parent.as_ref(), *place, scratch);
        let Scratch { cutter, .. } = scratch;
        let t = cutter.cut();
        let ring = t.vertex_count();
        let own: Vec<HalfEdge> = (0..t.sides(Face(0))).map(|c| t.half_edge(Face(0), c)).collect();
        let is_patch = own.len() == self.scheme.patch_sides();
        if let Some(leaf) = is_patch.then(|| self.leaf(t, &own)).flatten() {
            return Made { ring, body: MadeBody::Leaf(leaf) };
        }
        if has_fans(t, &own, self.scheme) {
            let Scratch { cutter, points, fan, list, key, .. } = scratch;
            let t = cutter.cut();
            let lowest = Lowest::of(t, t.face(own[0]));
            let child = |below: &CornerFan, c| fan_child(below, lowest, c, &known.nodes, key);
            let (step, children) = self.split_into_fans(t, &own, points, fan, list, child);
            return made((ring, Part::Split(step, children)));
        }
        Made { ring, body: self.split(is_patch, (parent.as_ref(), *place), known, scratch) }
    }

    /// Cuts out the surroundings at a place in the mesh, or in the level below another cut-out.
    fn cut_out(&self, parent: Option<&Arc<Parent>>, place: Place, scratch: &mut Scratch) {
        let Scratch { around, cutter, again, .. } = scratch;
        match parent.map(|parent| (parent, &**parent)) {
            None => around.cut_out(self.mesh, place, cutter),
            Some((_, Parent::Kept(kept))) => {
                let (cut, half_edges) = &**kept;
                around.cut_out(&NextLevel::new(cut, self.scheme.split(), half_edges), place, cutter);
            }
            Some((parent, Parent::Again(above, at))) => {
                // Children of one node follow each other.
                let last = again.take().filter(|last| Arc::ptr_eq(&last.0, parent));
                let last = last.unwrap_or_else(|| {
                    let (mut own, mut half_edges) = (Scratch::default(), NextHalfEdges::default());
                    self.cut_out(above.as_ref(), *at, &mut own);
                    let cut = own.cutter.take();
                    half_edges.list(&cut, self.scheme.split());
                    (parent.clone(), cut, half_edges)
                });
                around.cut_out(&NextLevel::new(&last.1, self.scheme.split(), &last.2), place, cutter);
                *again = Some(last);
            }
        }
    }

    /// The step from a face that was cut out to its children, which are met by walks.
    fn split(
        &self,
        is_patch: bool,
        (above, place): (Option<&Arc<Parent>>, Place),
        known: &Known,
        scratch: &mut Scratch,
    ) -> MadeBody {
        let split = self.scheme.split();
        let Scratch { around, cutter, points, half_edges, apart, key, .. } = scratch;
        let t = cutter.take();
        half_edges.list(&t, split);
        let next = NextLevel::new(&t, split, half_edges);
        points.clear(&t, next.vertex_count());
        let can_rise = Lowest::of(&t, Face(0)).excess() > 0;
        let count = if is_patch { 4 } else { 1 };
        let mut rings = Rings::default();
        // Face 0's children come first, corner by corner, the middle triangle last.
        let children = (0..count).map(Face).map(|face| {
            let lowest = Lowest::of(&next, face);
            let turn = canonical_corner(&next, face, lowest.excess());
            let place = Place { face, start: turn as u32, raise: lowest.raise() as i8 };
            around.go(&next, place);
            let low = walk_link(&around.list, place, lowest.raise(), known, (apart, key));
            rings.push(around.list.ring.iter().map(|&v| points.row(&t, self.scheme, v)));
            // The step takes 1 from everything finite, or nothing where the node is raised by 1. Where the child has what
            // was lowest in the node, that leads to other surroundings; else to the same, raised.
            let has_lowest = can_rise && lowest.ends();
            let high = has_lowest.then(|| {
                around.list.lower(-1);
                walk_link(&around.list, Place { raise: -1, ..place }, 0, known, (apart, key))
            });
            MadeChild { low, high, turn: turn as u8 }
        });
        let children: Vec<MadeChild> = children.collect();
        let points = Points::new(Step::new(None, points.rows().clone(), Arc::new(rings.shrunk())));
        let ends = (is_patch && has_side(&t, Face(0))).then(|| LinearEnds::new(&t, self.scheme, self.specials));
        let has_new = children.iter().any(MadeChild::is_new);
        let parent = if has_new && t.vertex_count() <= MOST_KEPT {
            Some(Arc::new(Parent::Kept(Box::new((t, std::mem::take(half_edges))))))
        } else {
            cutter.give_back(t);
            has_new.then(|| Arc::new(Parent::Again(above.cloned(), place)))
        };
        MadeBody::Split { parent, points, children, ends }
    }

    /// The node of a fan, and its number of points.
    pub fn fan_mesh<C>(
        &self,
        fan: &CornerFan,
        points: &mut RefinedPoints,
        below: &mut CornerFan,
        mut child: impl FnMut(&CornerFan, usize) -> C,
    ) -> (usize, Part<C>) {
        self.fan_meshes
            .with(fan, |mesh| self.quad((&mesh.topology, &mesh.own), || mesh.step(points), below, &mut child))
    }

    /// The node of a shape with the sharpness that was set, and its number of points.
    pub fn face_mesh<C>(
        &self,
        mesh: &FaceMesh,
        points: &mut RefinedPoints,
        below: &mut CornerFan,
        mut child: impl FnMut(&CornerFan, usize) -> C,
    ) -> (usize, Part<C>) {
        self.quad((&mesh.topology, &mesh.own), || mesh.step(points), below, &mut child)
    }

    /// The node of a quad that was cut out, with these half-edges and this step, and its number of points.
    fn quad<C>(
        &self,
        (t, own): (&Topology, &[HalfEdge]),
        step: impl FnOnce() -> Step,
        below: &mut CornerFan,
        child: &mut impl FnMut(&CornerFan, usize) -> C,
    ) -> (usize, Part<C>) {
        let part = match self.leaf(t, own) {
            Some(leaf) => Part::Leaf(leaf),
            None => {
                let children = (0..4).map(|c| {
                    below.below(t, own[c], None);
                    child(below, c)
                });
                Part::Split(step(), children.collect())
            }
        };
        (t.vertex_count(), part)
    }

    /// The step from a quad that was cut out to the fans at its corners.
    fn split_into_fans<C>(
        &self,
        t: &Topology,
        own: &[HalfEdge],
        points: &mut RefinedPoints,
        below: &mut CornerFan,
        list: &mut Vec<u32>,
        mut child: impl FnMut(&CornerFan, usize) -> C,
    ) -> (Step, Vec<C>) {
        points.clear(t, t.vertex_count() + t.face_count() + t.edge_count());
        let mut rings = Rings::default();
        let children = own.iter().enumerate().map(|(c, &h)| {
            list.clear();
            below.below(t, h, Some(list));
            rings.push(list.iter().map(|&v| points.row(t, self.scheme, v)));
            child(below, c)
        });
        let children = children.collect();
        (Step::new(None, points.rows().clone(), Arc::new(rings.shrunk())), children)
    }
}

/// A node that is a leaf, or whose children are fans.
fn made((ring, part): (usize, Part<MadeChild>)) -> Made {
    let body = match part {
        Part::Leaf(leaf) => MadeBody::Leaf(leaf),
        Part::Split(step, children) => {
            MadeBody::Split { parent: None, points: Points::new(step), children, ends: None }
        }
    };
    Made { ring, body }
}

/// Child `c` of a quad, at whose corner `c` the fan `fan` lies; `lowest` is the lowest finite sharpness round the quad. See
/// [`Compiler::split`] for the two links.
fn fan_child(fan: &CornerFan, lowest: Lowest, c: usize, known: &Keys, key: &mut Vec<u32>) -> MadeChild {
    let below = fan.lowest();
    fan.key(below.raise() as i8, key);
    let low = link(key, below.raise(), known);
    let high = (lowest.excess() > 0 && below.ends()).then(|| {
        fan.key(-1, key);
        link(key, 0, known)
    });
    MadeChild { low, high, turn: c as u8 }
}

/// What leads to the node of a fan's key, raised by `raise`.
fn link(key: &[u32], raise: u8, known: &Keys) -> MadeLink {
    let node = match known.get(key) {
        Some(node) => MadeNode::Known(node),
        None => MadeNode::New(key.into(), Box::default()),
    };
    MadeLink { place: None, raise, node }
}

/// What leads to the node that a walk went round, raised by `raise`; the last is memory.
fn walk_link(
    around: &Surroundings,
    place: Place,
    raise: u8,
    known: &Known,
    (apart, key): (&mut Apart, &mut Vec<u32>),
) -> MadeLink {
    let node = match known.walked(around, apart, key) {
        Some(node) => MadeNode::Known(node),
        None => MadeNode::New(around.key[..].into(), around.sharpness().into()),
    };
    MadeLink { place: Some(place), raise, node }
}
