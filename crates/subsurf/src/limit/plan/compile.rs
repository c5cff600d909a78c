//! Compiles plans: refines the surroundings of faces until a known patch covers each part, generation by generation, so
//! that surroundings that were met before are not compiled again.

mod alike;

use super::super::linear_boundary::{LinearEnds, has_side};
use super::super::plan_key::{Key, Keys, canonical_corner_lowered};
use super::fan::{CornerFan, has_fans, may_have_fans};
use super::fan_mesh::FanMeshes;
use super::refined_points::RefinedPoints;
use super::sub_patches::SubPatches;
use super::template::{self, Outline, Part};
use super::{Body, Child, Leaf, Link, Node, Plans, Points, SpecialVertices, Split};
use crate::index::{Face, HalfEdge};
use crate::limit::patch_table::Start;
use crate::refine::{NextHalfEdges, NextLevel};
use crate::scheme::Scheme;
use crate::topology::{Around, Cutter, Lowest, Surroundings, Tables, Topology, Walk};
use rayon::prelude::*;
use std::collections::hash_map::Entry;
use std::sync::Arc;

/// More generations than any surroundings need: each drops one of at most ten different whole parts of sharpness or tells
/// faces apart that were met first; reaching it is a defect of the classification.
const DEEPEST: u32 = 48;

impl Plans {
    /// No plans yet.
    pub(in crate::limit) fn empty(scheme: Scheme) -> Self {
        Self { split: scheme.split(), nodes: Vec::new(), plans: Vec::new(), parts: SubPatches::new() }
    }

    /// Adds the plans of the faces at `places` of `mesh`, each a face with the corner that its walk starts at; `keys` are what the
    /// walks list. `numbers` are those of the nodes that are there already.
    pub(in crate::limit) fn add(
        &mut self,
        mesh: &Topology,
        places: &[Start],
        keys: &[&[u32]],
        scheme: Scheme,
        specials: &SpecialVertices,
        numbers: &mut Numbers,
    ) {
        let known = &numbers.known;
        let starts: Vec<MadeLink> = places
            .par_iter()
            .zip(keys)
            .map_init(Walked::default, |around, (&(face, corner), key)| {
                let lowest = Lowest::of(mesh, Face(face));
                let place = Place { face: Face(face), start: corner, raise: lowest.raise() as i8 };
                if !lowest.is_finite() {
                    // Nothing to be lowered.
                    return link(key, Some(place), 0, known);
                }
                around.go(mesh, place);
                let link = link(&around.list.key, Some(place), lowest.raise(), known);
                let is_new = matches!(link.node, MadeNode::New(_));
                let outline = (is_new && may_have_fans(mesh, scheme)).then(|| around.outline()).flatten();
                MadeLink { outline, ..link }
            })
            .collect();
        numbers.known.reserve(4 * starts.len());
        self.plans.extend(starts.into_iter().map(|start| numbers.link(start, None)));
        for _ in 0..DEEPEST {
            let open = std::mem::take(&mut numbers.open);
            if open.is_empty() {
                self.parts.grow(self.plans.len());
                return;
            }
            let known = &numbers.known;
            let compiler = Compiler { mesh, fan_meshes: &numbers.fan_meshes, scheme, specials };
            let made = compiler.nodes(&open, known);
            // Nodes lie in the order in which their keys got their numbers.
            for Made { ring, body } in made {
                let body = match body {
                    MadeBody::Leaf(leaf) => Body::Leaf(leaf),
                    MadeBody::Split { parent, points, children, ends } => {
                        let link = |MadeChild { low, high, turn, ring }: MadeChild| {
                            let low = numbers.link(low, parent.as_ref());
                            let raised = Link { raise: low.raise + 1, ..low };
                            let high = high.map_or(raised, |high| numbers.link(high, parent.as_ref()));
                            Child { links: [low, high], turn, ring }
                        };
                        let children = children.into_iter().map(link).collect();
                        Body::Split(Box::new(Split { points, children, ends }))
                    }
                };
                self.nodes.push(Node { ring, body });
            }
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

/// A node that is to be made.
enum Open {
    /// Of a face of the mesh, or of the level below a cut-out.
    Face { parent: Option<Arc<Parent>>, place: Place, outline: Option<Outline> },
    /// Of a fan.
    Fan(CornerFan, Option<Outline>),
}

impl Open {
    fn outline(&self) -> Option<&Outline> {
        match self {
            Self::Face { outline, .. } | Self::Fan(_, outline) => outline.as_ref(),
        }
    }
}

/// A cut-out, and the half-edges of the level below.
struct Parent {
    cut: Topology,
    half_edges: NextHalfEdges,
}

/// Where a child or a plan leads to.
struct MadeLink {
    /// Where the node's surroundings are, if they do not follow from its key.
    place: Option<Place>,
    /// What remains of the raise at the node.
    raise: u8,
    node: MadeNode,
    /// Of a new node of a face of the mesh with finite sharpness.
    outline: Option<Outline>,
}

enum MadeNode {
    Known(u32),
    /// Not known at the time that its key was made.
    New(Key),
}

/// Numbers of nodes by their keys.
#[derive(Default)]
pub(in crate::limit) struct Numbers {
    known: Keys,
    /// Numbered, but not made yet.
    open: Vec<Open>,
    fan_meshes: FanMeshes,
}

impl Numbers {
    fn link(&mut self, MadeLink { place, raise, node, outline }: MadeLink, parent: Option<&Arc<Parent>>) -> Link {
        let next = self.known.len() as u32;
        let node = match node {
            MadeNode::Known(node) => node,
            MadeNode::New(key) => match self.known.entry(key) {
                Entry::Occupied(node) => *node.get(),
                Entry::Vacant(empty) => {
                    self.open.push(match place {
                        Some(place) => Open::Face { parent: parent.cloned(), place, outline },
                        None => {
                            let fan = CornerFan::of_key(empty.key()).expect("a fan's key");
                            let outline = fan.lowest().is_finite().then(|| fan.outline());
                            Open::Fan(fan, outline)
                        }
                    });
                    *empty.insert(next)
                }
            },
        };
        Link { node, raise }
    }
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
    ring: Arc<[u32]>,
}

impl MadeChild {
    fn is_new(&self) -> bool {
        [Some(&self.low), self.high.as_ref()].into_iter().flatten().any(|l| matches!(l.node, MadeNode::New(_)))
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

    /// The outline of the last walk's key, where there is finite sharpness.
    fn outline(&self) -> Option<Outline> {
        let mut values = Vec::new();
        let key = self.list.outline(|s| template::place(s, &mut values));
        (!values.is_empty()).then(|| Outline { key: key.into(), values: values.into() })
    }
}

/// What nodes are made from.
pub(super) struct Compiler<'a> {
    pub mesh: &'a Topology,
    pub fan_meshes: &'a FanMeshes,
    pub scheme: Scheme,
    pub specials: &'a SpecialVertices,
}

impl Compiler<'_> {
    fn node(&self, open: &Open, known: &Keys, scratch: &mut Scratch) -> Made {
        let split = self.scheme.split();
        let (parent, place) = match open {
            Open::Fan(fan, _) => {
                let Scratch { points, fan: below, list, .. } = scratch;
                let child = |below: &CornerFan, c, ring| fan_child(below, fan.lowest(), c, ring, known, list);
                return made(self.fan_mesh(fan, points, below, child));
            }
            Open::Face { parent, place, .. } => (parent, *place),
        };
        let Scratch { around, cutter, .. } = scratch;
        match parent {
            None => around.cut_out(self.mesh, place, cutter),
            Some(parent) => {
                around.cut_out(&NextLevel::new(&parent.cut, split, &parent.half_edges), place, cutter);
            }
        }
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
            let child = |below: &CornerFan, c, ring| fan_child(below, lowest, c, ring, known, key);
            let (points, children) = self.split_into_fans(t, &own, points, fan, list, child);
            return made((ring, Part::Split(points, children)));
        }
        Made { ring, body: self.split(is_patch, known, scratch) }
    }

    /// The step from a face that was cut out to its children, which are met by walks.
    fn split(&self, is_patch: bool, known: &Keys, scratch: &mut Scratch) -> MadeBody {
        let split = self.scheme.split();
        let Scratch { around, cutter, points, half_edges, .. } = scratch;
        let t = cutter.take();
        half_edges.list(&t, split);
        let next = NextLevel::new(&t, split, half_edges);
        points.clear(&t, next.vertex_count());
        let can_rise = Lowest::of(&t, Face(0)).excess() > 0;
        let count = if is_patch { 4 } else { 1 };
        // Face 0's children come first, corner by corner, the middle triangle last.
        let children = (0..count).map(Face).map(|face| {
            let lowest = Lowest::of(&next, face);
            let turn = canonical_corner_lowered(&next, face, lowest.excess());
            let place = Place { face, start: turn as u32, raise: lowest.raise() as i8 };
            around.go(&next, place);
            let low = link(&around.list.key, Some(place), lowest.raise(), known);
            let ring = around.list.ring.iter().map(|&v| points.row(&t, self.scheme, v)).collect();
            // The step takes 1 from everything finite, or nothing where the node is raised by 1. Where the child has what
            // was lowest in the node, that leads to other surroundings; else to the same, raised.
            let has_lowest = can_rise && lowest.ends();
            let high = has_lowest.then(|| {
                around.list.lower(-1);
                link(&around.list.key, Some(Place { raise: -1, ..place }), 0, known)
            });
            MadeChild { low, high, turn: turn as u8, ring }
        });
        let children: Vec<MadeChild> = children.collect();
        let points = Points { shared: None, own: Arc::new(points.rows().clone()) };
        let ends = (is_patch && has_side(&t, Face(0))).then(|| LinearEnds::new(&t, self.scheme, self.specials));
        let parent = if children.iter().any(MadeChild::is_new) {
            Some(Arc::new(Parent { cut: t, half_edges: std::mem::take(half_edges) }))
        } else {
            cutter.give_back(t);
            None
        };
        MadeBody::Split { parent, points, children, ends }
    }

    /// The node of a fan, and its number of points.
    pub fn fan_mesh<C>(
        &self,
        fan: &CornerFan,
        points: &mut RefinedPoints,
        below: &mut CornerFan,
        mut child: impl FnMut(&CornerFan, usize, Arc<[u32]>) -> C,
    ) -> (usize, Part<C>) {
        self.fan_meshes.with(fan, |mesh| {
            let (t, own) = (&mesh.topology, &mesh.own);
            let part = match self.leaf(t, own) {
                Some(leaf) => Part::Leaf(leaf),
                None => {
                    let points = mesh.points(points);
                    let children = (0..4).map(|c| {
                        below.below(t, own[c], None);
                        child(below, c, mesh.ring(c))
                    });
                    Part::Split(points, children.collect())
                }
            };
            (t.vertex_count(), part)
        })
    }

    /// The step from a quad that was cut out to the fans at its corners.
    fn split_into_fans<C>(
        &self,
        t: &Topology,
        own: &[HalfEdge],
        points: &mut RefinedPoints,
        below: &mut CornerFan,
        list: &mut Vec<u32>,
        mut child: impl FnMut(&CornerFan, usize, Arc<[u32]>) -> C,
    ) -> (Points, Vec<C>) {
        points.clear(t, t.vertex_count() + t.face_count() + t.edge_count());
        let children = own.iter().enumerate().map(|(c, &h)| {
            list.clear();
            below.below(t, h, Some(list));
            let ring = list.iter().map(|&v| points.row(t, self.scheme, v)).collect();
            child(below, c, ring)
        });
        let children = children.collect();
        (Points { shared: None, own: Arc::new(points.rows().clone()) }, children)
    }
}

/// A node that is a leaf, or whose children are fans.
fn made((ring, part): (usize, Part<MadeChild>)) -> Made {
    let body = match part {
        Part::Leaf(leaf) => MadeBody::Leaf(leaf),
        Part::Split(points, children) => MadeBody::Split { parent: None, points, children, ends: None },
    };
    Made { ring, body }
}

/// Child `c` of a quad, at whose corner `c` the fan `fan` lies; `lowest` is the lowest finite sharpness round the quad. See
/// [`Compiler::node`] for the two links.
fn fan_child(
    fan: &CornerFan,
    lowest: Lowest,
    c: usize,
    ring: Arc<[u32]>,
    known: &Keys,
    key: &mut Vec<u32>,
) -> MadeChild {
    let below = fan.lowest();
    fan.key(below.raise() as i8, key);
    let low = link(key, None, below.raise(), known);
    let high = (lowest.excess() > 0 && below.ends()).then(|| {
        fan.key(-1, key);
        link(key, None, 0, known)
    });
    MadeChild { low, high, turn: c as u8, ring }
}

/// What leads to the node of a key, raised by `raise`.
fn link(key: &[u32], place: Option<Place>, raise: u8, known: &Keys) -> MadeLink {
    let node = match known.get(key) {
        Some(&node) => MadeNode::Known(node),
        None => MadeNode::New(key.into()),
    };
    MadeLink { place, raise, node, outline: None }
}
