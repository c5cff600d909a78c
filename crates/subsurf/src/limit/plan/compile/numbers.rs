//! Nodes by their keys, and the nodes of a generation. Nodes lie in the order in which their keys got their numbers.
//!
//! A generation is made in two passes. The first is parallel: templates, what is made without one, and the weights that nodes
//! have of their own. The second puts the nodes together one after the other, and numbers their children.

use super::super::fan::CornerFan;
use super::super::points::{OwnWeights, Points};
use super::super::template::Filled;
use super::super::{Body, Child, Link, Node, Split};
use super::alike::Templates;
use super::{Compiler, FanMeshes, Made, MadeBody, MadeChild, MadeLink, MadeNode, Parent, Place, Scratch};
use crate::limit::plan_key::Keys;
use crate::topology::Lowest;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Numbers of nodes by their keys.
#[derive(Default)]
pub(in crate::limit) struct Numbers {
    known: Known,
    templates: Templates,
    fan_meshes: Arc<FanMeshes>,
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
    /// Keys without the values of finite sharpness.
    pub outlines: Keys,
    open: Vec<Open>,
    pub values: Vec<f64>,
    outline: Vec<u32>,
}

impl Known {
    /// The number of a fan.
    fn fan(&mut self, key: &[u32]) -> u32 {
        let (number, is_new) = self.nodes.insert(key);
        if is_new {
            let first = self.values.len();
            CornerFan::outline(key, &mut self.outline, &mut self.values);
            self.open(number, None, first);
        }
        number
    }

    /// The number of a face's surroundings, in whose key sharpness stands at these places.
    fn face(&mut self, key: &[u32], face: (Option<Arc<Parent>>, Place), sharpness: &[u32]) -> u32 {
        let (number, is_new) = self.nodes.insert(key);
        if is_new {
            let first = self.values.len();
            CornerFan::outline_at(key, sharpness.iter().map(|&at| at as usize), &mut self.outline, &mut self.values);
            self.open(number, Some(face), first);
        }
        number
    }

    /// Notes a new node whose outline was made last, its values from `first` on.
    fn open(&mut self, number: u32, face: Option<(Option<Arc<Parent>>, Place)>, first: usize) {
        let is_finite = self.values.len() > first;
        let outline = is_finite.then(|| (self.outlines.insert(&self.outline).0, first..self.values.len()));
        self.open.push(Open { number, face, outline });
    }

    fn link(&mut self, MadeLink { place, raise, node }: MadeLink, parent: Option<&Arc<Parent>>) -> Link {
        let node = match (node, place) {
            (MadeNode::Known(node), _) => node,
            (MadeNode::New(key), Some(place)) => self.face(&key, (parent.cloned(), place), &[]),
            (MadeNode::New(key), None) => self.fan(&key),
        };
        Link { node, raise }
    }
}

/// How a node of a generation is made: by itself, or from a template with weights from a place on.
enum Way {
    Direct,
    Filled { outline: u32, weights: usize },
}

/// Nodes with weights of their own that a thread fills at a time, at least.
const SHARE: usize = 64;

impl Numbers {
    /// The number of the surroundings of a face of the mesh; `sharpness` says where in the key it stands.
    pub(super) fn face(&mut self, key: &[u32], place: Place, sharpness: &[u32]) -> u32 {
        self.known.face(key, (None, place), sharpness)
    }

    pub(super) fn fan_meshes(&self) -> Arc<FanMeshes> {
        self.fan_meshes.clone()
    }

    /// The nodes that are to be made next.
    pub(super) fn take_open(&mut self) -> Vec<Open> {
        std::mem::take(&mut self.known.open)
    }

    /// Makes nodes, which have the numbers that come next.
    pub(super) fn generation(&mut self, compiler: &Compiler<'_>, open: Vec<Open>, nodes: &mut Vec<Node>) {
        let Self { known, templates, .. } = self;
        templates.make(&open, known, compiler);

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
            compiler.node(known.nodes.key(open[i].number), &open[i], &known.nodes, scratch)
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
                                *child = Child { links: [low, high], turn: c as u8, number: c as u8 };
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
                                *child = Child { links: [low, high], turn, number: number as u8 };
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
