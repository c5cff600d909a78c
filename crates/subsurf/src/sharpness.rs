//! How sharpness decays, and which rule a vertex follows because of it (DeRose, Kass, Truong 1998, with OpenSubdiv's
//! treatment of fractions: `sdc/crease.cpp`, `sdc/scheme.h`).

use crate::index::{Edge, Vertex};
use crate::tags::{Creasing, INFINITE_SHARPNESS};
use crate::topology::{Tables, Topology};

/// Sharpness one level further down under uniform decay.
#[inline]
pub(crate) fn decay(s: f64) -> f64 {
    if s >= INFINITE_SHARPNESS { INFINITE_SHARPNESS } else { (s - 1.0).max(0.0) }
}

/// True for what decays in the end.
pub(crate) fn is_semi_sharp(s: f64) -> bool {
    s > 0.0 && s < INFINITE_SHARPNESS
}

/// Sharpness of the half of edge `e` at its end `v`.
///
/// Uniform: that of the edge less one. Chaikin: with at least two semi-sharp edges at `v`,
/// `max(0, 3/4 s + 1/4 mean(the others) - 1)`.
pub(crate) fn edge_half(t: &impl Tables, e: Edge, v: Vertex) -> f64 {
    t.far_half(e, v).unwrap_or_else(|| chaikin_or_uniform(t, v, t.edge_sharpness(e)))
}

fn chaikin_or_uniform(t: &impl Tables, v: Vertex, s: f64) -> f64 {
    if t.rules().creasing == Creasing::Uniform || !is_semi_sharp(s) {
        return decay(s);
    }
    let (mut count, mut sum) = (0, 0.0);
    let (own, foreign, across) = (sharpness_at(t, v), t.foreign_sharpness(v), t.across_seam(v));
    for other in own.chain(foreign.iter().copied()).chain(across.iter().copied()).filter(|&s| is_semi_sharp(s)) {
        count += 1;
        sum += other;
    }
    half_among(Creasing::Chaikin, s, count, sum)
}

/// Sharpness of an edge's half at an end where `count` edges are semi-sharp and `sum` is their total, the edge's own `s`
/// included.
pub(crate) fn half_among(creasing: Creasing, s: f64, count: u32, sum: f64) -> f64 {
    if creasing == Creasing::Uniform || !is_semi_sharp(s) || count < 2 {
        return decay(s);
    }
    (0.75 * s + 0.25 * (sum - s) / f64::from(count - 1) - 1.0).max(0.0)
}

/// Positive sharpness values of the edges at `v` that the table holds.
fn sharpness_at(t: &impl Tables, v: Vertex) -> impl Iterator<Item = f64> {
    t.sharp_edges(v).map(|e| t.edge_sharpness(e))
}

/// Sharpness one level down of the edges at `v` that a cut-out topology does not hold.
pub(crate) fn foreign_half(t: &Topology, v: Vertex) -> Vec<f64> {
    t.foreign_sharpness(v).iter().map(|&s| chaikin_or_uniform(t, v, s)).filter(|&s| s > 0.0).collect()
}

/// Sharpness one level down of the edges at `v` that lie beyond a seam.
pub(crate) fn seam_half(t: &Topology, v: Vertex) -> Vec<f64> {
    t.across_seam(v).iter().map(|&s| chaikin_or_uniform(t, v, s)).filter(|&s| s > 0.0).collect()
}

/// Which mask a vertex takes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Rule {
    /// No or one sharp edge (the latter is a dart).
    Smooth,
    /// Two sharp edges.
    Crease([Edge; 2]),
    /// A sharp vertex, or more than two sharp edges.
    Corner,
}

/// A vertex's rule before and after the sharpness decays: the vertex point is
/// `weight · parent + (1 - weight) · child`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct VertexRules {
    pub parent: Rule,
    pub child: Rule,
    pub weight: f64,
}

/// The rules of vertex `v` from this level to the next.
pub(crate) fn vertex_rules(t: &Topology, v: Vertex) -> VertexRules {
    let edges = t.sharp_edges(v);
    let s = t.vertex_sharpness(v);
    let same = |rule| VertexRules { parent: rule, child: rule, weight: 1.0 };
    if s == 0.0 && edges.len() < 2 {
        return same(Rule::Smooth);
    }
    if s >= INFINITE_SHARPNESS || t.is_on_linear_boundary(v) {
        return same(Rule::Corner);
    }
    let foreign = t.foreign_sharpness(v);
    let rule = |s: f64, sharp: &mut dyn Iterator<Item = Option<Edge>>| {
        if s > 0.0 {
            return Rule::Corner;
        }
        match (sharp.next(), sharp.next(), sharp.next()) {
            (None | Some(_), None, _) => Rule::Smooth,
            (Some(Some(a)), Some(Some(b)), None) => Rule::Crease([a, b]),
            _ => Rule::Corner,
        }
    };
    let parent = rule(s, &mut edges.iter().map(|&e| Some(Edge(e))).chain(foreign.iter().map(|_| None)));
    if parent == Rule::Smooth {
        return same(Rule::Smooth);
    }
    let sharp_halves = edges.iter().map(|&e| Edge(e)).filter(|&e| edge_half(t, e, v) > 0.0);
    let foreign_halves = foreign.iter().filter(|&&f| chaikin_or_uniform(t, v, f) > 0.0);
    let child = rule(decay(s), &mut sharp_halves.map(Some).chain(foreign_halves.map(|_| None)));
    if child == parent {
        return same(parent);
    }
    VertexRules { parent, child, weight: transition_weight(t, v) }
}

/// Mean of the sharpness values at `v` that reach zero now, at most 1; 0 where none does.
fn transition_weight(t: &Topology, v: Vertex) -> f64 {
    let (mut count, mut sum) = (0, 0.0);
    let mut add = |s| {
        count += 1;
        sum += s;
    };
    let s = t.vertex_sharpness(v);
    if s > 0.0 && decay(s) == 0.0 {
        add(s);
    }
    sharpness_at(t, v)
        .chain(t.foreign_sharpness(v).iter().copied())
        .filter(|&s| chaikin_or_uniform(t, v, s) == 0.0)
        .for_each(add);
    if count == 0 { 0.0 } else { (sum / f64::from(count)).min(1.0) }
}
