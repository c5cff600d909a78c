//! Nodes by their keys, and the nodes of a generation. Nodes lie in the order in which their keys got their numbers.
//!
//! A generation is made in two passes. The first is parallel: templates, what is made without one, and the weights that nodes
//! have of their own. The second puts the nodes together one after the other, and numbers their children.

use super::super::face_mesh::{FaceMesh, FaceMeshes};
use super::super::fan::CornerFan;
use super::super::points::{OwnWeights, Points};
use super::super::template::{self, Filled};
use super::super::{Body, Child, Link, Node, SpecialVertices, Split};
use super::alike::Templates;
use super::{Compiler, FanMeshes, Made, MadeBody, MadeChild, MadeLink, MadeNode, Parent, Place, Scratch};
use crate::limit::plan_key::Keys;
use crate::limit::plan_key::names::{self, Apart, Names};
use crate::scheme::Scheme;
use crate::topology::{Lowest, Surroundings, Topology};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Numbers of nodes by their keys.
#[derive(Default)]
pub(in crate::limit) struct Numbers {
    known: Known,
    templates: Templates,
    fan_meshes: FanMeshes,
    face_meshes: FaceMeshes,
}

/// A node that is to be made; its key is that of its number.
pub(super) struct Open {
    pub number: u32,
    /// Where its surroundings are, in the mesh or the level below a cut-out; none of a fan, which its key tells.
    pub face: Option<(Option<Arc<Parent>>, Place)>,
    /// Where there is finite sharpness: the number of the key without its values, and these among all values.
    pub outline: Option<(u32, Range<usize>)>,
}

/// Keys, and what is numbered but not made yet.
#[derive(Default)]
pub(super) struct Known {
    pub nodes: Keys,
    pub names: Names,
    /// Keys without the values of finite sharpness.
    pub outlines: Keys,
    open: Vec<Open>,
    pub values: Vec<f64>,
    outline: Vec<u32>,
}

impl Known {
    /// The number of the node round which a walk went, if it is known.
    pub fn walked(&self, walk: &Surroundings, apart: &mut Apart, key: &mut Vec<u32>) -> Option<u32> {
        let has_key = self.names.find(&walk.key, walk.sharpness(), apart, key);
        if has_key { self.nodes.get(key) } else { None }
    }

    /// The number of a fan.
    fn fan(&mut self, key: &[u32]) -> u32 {
        let (number, is_new) = self.nodes.insert(key);
        if is_new {
            self.open(number, None, key, CornerFan::places_in(key));
        }
        number
    }

    /// The number of a face's surroundings.
    fn face(&mut self, key: &[u32], face: (Option<Arc<Parent>>, Place)) -> u32 {
        let (number, is_new) = self.nodes.insert(key);
        if is_new && names::shape(key).is_some() {
            self.open(number, Some(face), key, names::places(key));
        } else if is_new {
            self.open.push(Open { number, face: Some(face), outline: None });
        }
        number
    }

    /// Notes a new node, in whose key sharpness stands at these places.
    fn open(
        &mut self,
        number: u32,
        face: Option<(Option<Arc<Parent>>, Place)>,
        key: &[u32],
        places: impl Iterator<Item = usize>,
    ) {
        let first = self.values.len();
        template::outline(key, places, &mut self.outline, &mut self.values);
        let is_finite = self.values.len() > first;
        let outline = is_finite.then(|| (self.outlines.insert(&self.outline).0, first..self.values.len()));
        self.open.push(Open { number, face, outline });
    }

    fn link(&mut self, MadeLink { place, raise, node }: MadeLink, parent: Option<&Arc<Parent>>) -> Link {
        let node = match (node, place) {
            (MadeNode::Known(node), _) => node,
            (MadeNode::New(walk, sharpness), Some(place)) => {
                let key = self.names.key(&walk, &sharpness).to_vec();
                self.face(&key, (parent.cloned(), place))
            }
            (MadeNode::New(key, _), None) => self.fan(&key),
        };
        Link { node, raise }
    }
}

/// Cuts out the shapes of several nodes.
fn cut_shapes(open: &[Open], known: &Known, meshes: &mut FaceMeshes, compiler: &Compiler<'_>) {
    meshes.grow(known.names.shapes());
    // How many nodes have a shape, and the first of them.
    let mut alike = vec![(0, 0); known.names.shapes()];
    for (i, open) in open.iter().enumerate().filter(|(_, open)| open.face.is_some()) {
        if let Some(shape) = names::shape(known.nodes.key(open.number)) {
            let (count, first) = &mut alike[shape as usize];
            *first = if *count == 0 { i } else { *first };
            *count += 1;
        }
    }
    let is_wanted = |&shape: &u32| alike[shape as usize].0 >= LEAST_ALIKE && meshes.is_open(shape);
    let shapes: Vec<u32> = (0..alike.len() as u32).filter(is_wanted).collect();
    let cut = |scratch: &mut Scratch, &shape: &u32| {
        let (parent, place) = open[alike[shape as usize].1].face.as_ref()?;
        compiler.cut_out(parent.as_ref(), *place, scratch);
        FaceMesh::new(scratch.cutter.take(), compiler.scheme, &mut scratch.points)
    };
    let made: Vec<Option<FaceMesh>> = shapes.par_iter().map_init(Scratch::default, cut).collect();
    shapes.into_iter().zip(made).for_each(|(shape, mesh)| meshes.put(shape, mesh));
}

/// How a node of a generation is made: by itself, or from a template with weights from a place on.
enum Way {
    Direct,
    Filled { outline: u32, weights: usize },
}

/// Nodes that room is made for, per plan: as many as there are where nearly every face has a sharpness of its own.
pub(super) const NODES: usize = 5;

/// How many nodes of a shape it takes to cut it out.
const LEAST_ALIKE: usize = 2;

/// Nodes with weights of their own that a thread fills at a time, at least.
const SHARE: usize = 64;

impl Numbers {
    /// None; `has_shapes` is true where quads may be known by shapes.
    pub fn new(has_shapes: bool) -> Self {
        let known = Known { names: Names::new(has_shapes), ..Known::default() };
        Self { known, ..Self::default() }
    }

    /// The names of what walks list.
    pub fn names(&mut self) -> &mut Names {
        &mut self.known.names
    }

    /// Makes room for the nodes of so many plans more.
    pub(super) fn reserve(&mut self, plans: usize) {
        self.known.nodes.reserve(NODES * plans, 16);
    }

    /// The number of the surroundings of a face of the mesh.
    pub(super) fn face(&mut self, key: &[u32], place: Place) -> u32 {
        self.known.face(key, (None, place))
    }

    /// The nodes that are to be made next.
    pub(super) fn take_open(&mut self) -> Vec<Open> {
        std::mem::take(&mut self.known.open)
    }

    /// Makes nodes, which have the numbers that come next.
    pub(super) fn generation(
        &mut self,
        mesh: &Topology,
        scheme: Scheme,
        specials: &SpecialVertices,
        open: Vec<Open>,
        nodes: &mut Vec<Node>,
    ) {
        let Self { known, templates, fan_meshes, face_meshes } = self;
        let without = Compiler { mesh, fan_meshes, face_meshes: &FaceMeshes::default(), scheme, specials };
        cut_shapes(&open, known, face_meshes, &without);
        let compiler = Compiler { face_meshes, ..without };
        templates.make(&open, known, &compiler);

        let (mut direct, mut filled, mut own) = (Vec::new(), Vec::new(), 0);
        let way = |(i, open): (usize, &Open)| {
            let template = open
                .outline
                .as_ref()
                .and_then(|(outline, values)| Some((*outline, values.clone(), templates.get(*outline)?)));
            let Some((outline, values, template)) = template else {
                direct.push(i);
                return Way::Direct;
            };
            let weights = own;
            if let Filled::Split(_, count @ 1..) = template.fill(&known.values[values.clone()]) {
                filled.push((template, values, count));
                own += count;
            }
            Way::Filled { outline, weights }
        };
        let ways: Vec<Way> = open.iter().enumerate().map(way).collect();
        let mut weights: Vec<f64> = subsurf_memory::zeroed(own);
        let mut rest = &mut weights[..];
        let parts = filled.into_iter().map(|(template, values, count)| {
            let (part, more) = std::mem::take(&mut rest).split_at_mut(count);
            rest = more;
            (template, values, part)
        });
        let parts: Vec<_> = parts.collect();
        parts.into_par_iter().with_min_len(SHARE).for_each(|(template, values, part)| {
            template.weights(&known.values[values], part);
        });
        let make = |scratch: &mut Scratch, &i: &usize| {
            compiler.node(known.nodes.key(open[i].number), &open[i], known, scratch)
        };
        let made: Vec<Made> = direct.par_iter().map_init(Scratch::default, make).collect();

        let (weights, mut made) = (Arc::new(weights), made.into_iter());
        nodes.reserve(open.len());
        let mut key = Vec::new();
        for (open, way) in open.into_iter().zip(ways) {
            let node = match (way, open.outline) {
                (Way::Filled { outline, weights: start }, Some((_, values))) => {
                    let (template, fixed) = templates.get_mut(outline);
                    let body = match template.fill(&known.values[values.clone()]) {
                        Filled::Leaf(leaf) => Body::Leaf(leaf),
                        Filled::Split(step, own) => {
                            let lowest = Lowest::among(known.values[values.clone()].iter().copied());
                            let mut children = [Child::NONE; 4];
                            for (c, child) in children.iter_mut().enumerate() {
                                let below = template.lowest(c, &known.values[values.clone()]);
                                let low = match fixed[c] {
                                    Some(node) => Link { node, raise: 0 },
                                    None => {
                                        template.key(c, &known.values[values.clone()], below.raise() as i8, &mut key);
                                        let node = known.fan(&key);
                                        fixed[c] = (below == Lowest::default()).then_some(node);
                                        Link { node, raise: below.raise() }
                                    }
                                };
                                let high = if lowest.excess() > 0 && below.ends() {
                                    template.key(c, &known.values[values.clone()], -1, &mut key);
                                    Link { node: known.fan(&key), raise: 0 }
                                } else {
                                    low.raised()
                                };
                                *child = Child::new([low, high], c as u8, c);
                            }
                            let own = (own > 0).then(|| OwnWeights { all: weights.clone(), start });
                            let points = Points::filled(step, own);
                            Body::Split(Split { points, children, count: 4, ends: None })
                        }
                    };
                    Node { ring: template.ring, body }
                }
                _ => {
                    let Made { ring, body } = made.next().expect("made in the same order");
                    let body = match body {
                        MadeBody::Leaf(leaf) => Body::Leaf(leaf),
                        MadeBody::Split { parent, points, children: below, ends } => {
                            let (count, mut children) = (below.len() as u8, [Child::NONE; 4]);
                            for (number, (child, made)) in children.iter_mut().zip(below).enumerate() {
                                let MadeChild { low, high, turn } = made;
                                let low = known.link(low, parent.as_ref());
                                let high = high.map_or(low.raised(), |high| known.link(high, parent.as_ref()));
                                *child = Child::new([low, high], turn, number);
                            }
                            Body::Split(Split { points, children, count, ends: ends.map(Box::new) })
                        }
                    };
                    Node { ring, body }
                }
            };
            nodes.push(node);
        }
        if known.open.is_empty() {
            known.values.clear();
        }
    }
}
