//! The [templates](super::super::template) from which nodes are made that many others are like, but for the values of finite
//! sharpness. Which are alike follows from the list of nodes, whatever thread makes them.

use super::super::face_mesh::FaceMesh;
use super::super::fan::{CornerFan, has_fans};
use super::super::template::{self, Part, Template};
use super::numbers::{Known, Open};
use super::{Compiler, Scratch};
use crate::index::{Face, HalfEdge};
use crate::topology::Topology;
use rayon::prelude::*;

/// Templates by the numbers of outlines.
#[derive(Default)]
pub(super) struct Templates(Vec<Tried>);

#[derive(Default)]
enum Tried {
    #[default]
    Not,
    /// There is none.
    InVain,
    /// The template, and the children in whose fans no finite sharpness is left, as far as they have numbers.
    Made(Box<Template>, [Option<u32>; 4]),
}

impl Templates {
    pub fn get(&self, outline: u32) -> Option<&Template> {
        match &self.0[outline as usize] {
            Tried::Made(template, _) => Some(template),
            Tried::Not | Tried::InVain => None,
        }
    }

    /// A template that there is, and its children's numbers.
    pub fn get_mut(&mut self, outline: u32) -> (&Template, &mut [Option<u32>; 4]) {
        match &mut self.0[outline as usize] {
            Tried::Made(template, fixed) => (template, fixed),
            Tried::Not | Tried::InVain => unreachable!("a template that was made"),
        }
    }

    /// Makes the templates that pay for these nodes.
    pub fn make(&mut self, open: &[Open], known: &Known, compiler: &Compiler<'_>) {
        self.0.resize_with(known.outlines.len(), Tried::default);
        // How many nodes are alike, and the first of them.
        let mut alike = vec![(0, 0); self.0.len()];
        for (i, open) in open.iter().enumerate() {
            if let Some((outline, _)) = open.outline {
                let (count, first) = &mut alike[outline as usize];
                *first = if *count == 0 { i } else { *first };
                *count += 1;
            }
        }
        let values = |i: usize| open[i].outline.as_ref().map_or(&[][..], |(_, values)| &known.values[values.clone()]);
        let pays = |&outline: &usize| {
            let (count, first) = alike[outline];
            count > 0 && matches!(self.0[outline], Tried::Not) && count >= template::least(values(first))
        };
        let outlines: Vec<usize> = (0..alike.len()).filter(pays).collect();
        let make = |scratch: &mut Scratch, &outline: &usize| {
            let first = alike[outline].1;
            compiler.template(known.nodes.key(open[first].number), &open[first], values(first), scratch)
        };
        let made: Vec<Option<Template>> = outlines.par_iter().map_init(Scratch::default, make).collect();
        for (outline, template) in outlines.into_iter().zip(made) {
            self.0[outline] = template.map_or(Tried::InVain, |template| Tried::Made(Box::new(template), [None; 4]));
        }
    }
}

impl Compiler<'_> {
    /// The template of a node with finite sharpness `from`.
    fn template(&self, key: &[u32], open: &Open, from: &[f64], scratch: &mut Scratch) -> Option<Template> {
        let child = |below: &CornerFan, _| below.clone();
        let changed = |s: f64, to: &[f64]| from.iter().position(|&value| value == s).map_or(s, |at| to[at]);
        let Some((parent, place)) = &open.face else {
            let fan = CornerFan::of_key(key)?;
            let Scratch { points, fan: below, .. } = scratch;
            return Template::new(from, |to| Some(self.fan_mesh(&fan.with_values(from, to), points, below, child)));
        };
        let Scratch { points, fan: below, .. } = scratch;
        let with = |mesh: &mut FaceMesh| {
            Template::new(from, |to| {
                mesh.set(key, |s| changed(s, to));
                Some(self.face_mesh(mesh, points, below, child))
            })
        };
        if let Some(template) = self.face_meshes.with(key, with) {
            return template;
        }
        self.cut_out(parent.as_ref(), *place, scratch);
        let Scratch { cutter, points, fan: below, list, .. } = scratch;
        let whole = cutter.take();
        let own: Vec<HalfEdge> = (0..whole.sides(Face(0))).map(|c| whole.half_edge(Face(0), c)).collect();
        if !has_fans(&whole, &own, self.scheme) {
            return None;
        }
        Template::new(from, |to| {
            let mut t: Topology = whole.clone();
            t.edge_sharpness.change_values(|s| changed(s, to));
            t.vertex_sharpness.change_values(|s| changed(s, to));
            let part = match self.leaf(&t, &own) {
                Some(leaf) => Part::Leaf(leaf),
                None => {
                    let (step, children) = self.split_into_fans(&t, &own, points, below, list, child);
                    Part::Split(step, children)
                }
            };
            Some((t.vertex_count(), part))
        })
    }
}
