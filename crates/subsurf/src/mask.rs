//! A mask: the weights of one rule. Everything that needs a weight (refinement, stencils, local subdivision matrices)
//! asks these functions; there is no second source.

use crate::index::{Edge, Face, Vertex};
use crate::scheme::Scheme;
use crate::sharpness::{Rule, edge_half, vertex_rules};
use crate::tags::Creasing;
use crate::topology::{Interpolation, NONE, Topology};

/// Weights over vertices of the parent level and over the centroids of its faces; they sum to one.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Mask {
    pub vertices: Vec<(u32, f64)>,
    pub faces: Vec<(u32, f64)>,
    /// For every entry of `vertices` the edge that joins it to the vertex whose mask this is; [`NONE`] elsewhere.
    pub edges: Vec<u32>,
}

impl Mask {
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.faces.clear();
        self.edges.clear();
    }

    pub fn vertex(&mut self, v: Vertex, weight: f64) {
        self.vertices.push((v.0, weight));
        self.edges.push(NONE);
    }

    /// A vertex that lies across edge `e` from the one whose mask this is.
    pub fn along(&mut self, e: Edge, v: Vertex, weight: f64) {
        self.vertices.push((v.0, weight));
        self.edges.push(e.0);
    }

    pub fn face(&mut self, f: Face, weight: f64) {
        self.faces.push((f.0, weight));
    }
}

/// The new vertex on edge `e`.
pub(crate) fn edge_mask(t: &Topology, scheme: Scheme, e: Edge, mask: &mut Mask) {
    mask.clear();
    let s = t.edge_sharpness(e);
    let whole =
        is_linear(t, scheme) || s >= 1.0 || (s > 0.0 && t.rules().creasing == Creasing::Chaikin && stays_sharp(t, e));
    let sharp = if whole { 1.0 } else { s };
    if sharp < 1.0 {
        scheme.smooth_edge_mask(t, e, 1.0 - sharp, mask);
    }
    if sharp > 0.0 {
        let [a, b] = t.edge_vertices(e);
        mask.vertex(a, 0.5 * sharp);
        mask.vertex(b, 0.5 * sharp);
    }
}

/// True where all rules are the linear ones.
pub(crate) fn is_linear(t: &Topology, scheme: Scheme) -> bool {
    scheme == Scheme::Bilinear || t.interpolation == Interpolation::Linear
}

fn stays_sharp(t: &Topology, e: Edge) -> bool {
    t.edge_vertices(e).iter().all(|&v| edge_half(t, e, v) > 0.0)
}

/// The new position of vertex `v`.
pub(crate) fn vertex_mask(t: &Topology, scheme: Scheme, v: Vertex, mask: &mut Mask) {
    mask.clear();
    if is_linear(t, scheme) {
        return mask.vertex(v, 1.0);
    }
    let rules = vertex_rules(t, v);
    let mut add = |rule: Rule, weight: f64| {
        if weight == 0.0 {
            return;
        }
        match rule {
            Rule::Corner => mask.vertex(v, weight),
            Rule::Crease(edges) => {
                mask.vertex(v, 0.75 * weight);
                edges.iter().for_each(|&e| mask.along(e, other_end(t, e, v), 0.125 * weight));
            }
            Rule::Smooth => scheme.smooth_vertex_mask(t, v, weight, mask),
        }
    };
    if rules.parent == rules.child {
        return add(rules.parent, 1.0);
    }
    add(rules.parent, rules.weight);
    add(rules.child, 1.0 - rules.weight);
}

/// The end of `e` that is not `v`.
pub(crate) fn other_end(t: &Topology, e: Edge, v: Vertex) -> Vertex {
    let [a, b] = t.edge_vertices(e);
    if a == v { b } else { a }
}
