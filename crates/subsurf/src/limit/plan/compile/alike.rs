//! Nodes of one generation: those that many others are like, but for the values of finite sharpness, are made from
//! [templates](super::super::template).

use super::super::fan::{CornerFan, has_fans};
use super::super::template::{self, Below, Outline, Part, Template};
use super::{Compiler, Made, Open, Scratch, fan_child, made};
use crate::index::{Face, HalfEdge};
use crate::limit::plan_key::{KeyHasher, Keys};
use crate::topology::Lowest;
use rayon::prelude::*;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

impl Compiler<'_> {
    /// Nodes in order; many that differ in the values of finite sharpness alone are made from a template.
    pub(super) fn nodes(&self, open: &[Open], known: &Keys) -> Vec<Made> {
        // Which are alike follows from the list, whatever thread makes them.
        let mut alike: HashMap<&[u32], (usize, usize), BuildHasherDefault<KeyHasher>> = HashMap::default();
        for (i, outline) in open.iter().enumerate().filter_map(|(i, open)| Some((i, open.outline()?))) {
            alike.entry(&outline.key).or_insert((i, 0)).1 += 1;
        }
        let pays = |(first, count): &(usize, usize)| {
            *count >= open[*first].outline().map_or(usize::MAX, |outline| template::least(&outline.values))
        };
        let first: Vec<usize> = alike.values().filter(|of| pays(of)).map(|of| of.0).collect();
        let templates: Vec<Option<Template>> =
            first.par_iter().map_init(Scratch::default, |scratch, &i| self.template(&open[i], scratch)).collect();
        let template: HashMap<usize, Template> =
            first.into_iter().zip(templates).filter_map(|(first, template)| Some((first, template?))).collect();
        let node = |scratch: &mut Scratch, open: &Open| {
            let outline = open.outline();
            let template = outline.and_then(|outline| template.get(&alike.get(&outline.key[..])?.0));
            let (Some(Outline { values, .. }), Some(template)) = (outline, template) else {
                return self.node(open, known, scratch);
            };
            let lowest = Lowest::among(values.iter().copied());
            let Scratch { fan, key, .. } = scratch;
            let child = |below: &CornerFan, c, ring| fan_child(below, lowest, c, ring, known, key);
            made((template.ring, template.fill(values, fan, child)))
        };
        open.par_iter().map_init(Scratch::default, node).collect()
    }

    /// The template of a node with finite sharpness.
    fn template(&self, open: &Open, scratch: &mut Scratch) -> Option<Template> {
        let Outline { values: from, .. } = open.outline()?;
        let Scratch { around, cutter, points, fan: below, list, .. } = scratch;
        let child = |below: &CornerFan, _, ring| -> Below { (below.clone(), ring) };
        let place = match open {
            Open::Fan(fan, _) => {
                return Template::new(from, |to| Some(self.fan_mesh(&fan.with_values(from, to), points, below, child)));
            }
            Open::Face { place, .. } => *place,
        };
        around.cut_out(self.mesh, place, cutter);
        let whole = cutter.take();
        let own: Vec<HalfEdge> = (0..whole.sides(Face(0))).map(|c| whole.half_edge(Face(0), c)).collect();
        if !has_fans(&whole, &own, self.scheme) {
            return None;
        }
        Template::new(from, |to| {
            let mut t = whole.clone();
            let change = |s: f64| from.iter().position(|&value| value == s).map_or(s, |at| to[at]);
            t.edge_sharpness.change_values(change);
            t.vertex_sharpness.change_values(change);
            let part = match self.leaf(&t, &own) {
                Some(leaf) => Part::Leaf(leaf),
                None => {
                    let (points, children) = self.split_into_fans(&t, &own, points, below, list, child);
                    Part::Split(points, children)
                }
            };
            Some((t.vertex_count(), part))
        })
    }
}
