//! A face with a side on a boundary that stays piecewise linear (face-varying rule "boundaries"): values along it move on
//! straight lines while the inside is smooth, so no finite set of spline patches covers the face.
//!
//! Its children are again such faces along the boundary, and ordinary faces inside. Up to equal surroundings there are
//! only a few different ones, so they form a finite automaton whose steps are small matrices: a location is followed from
//! state to state until it leaves the boundary, which takes as many steps as its distance has binary digits.
//!
//! Steps stop at [`DEEPEST`], where the face is as good as bilinear. On the boundary itself positions are exact and the
//! derivative across diverges, slowly. Second derivatives lose digits towards it, as `4^depth` times rounding.

use super::corner::{Kind, corner, ring_points};
use super::jet::Derivatives;
use super::local_step::child_vertex;
use super::plan::{Plan, SpecialVertices, descend, linear};
use super::rows::{Accumulator, Combination, Rows};
use super::special::{AtVertex, PointWeights, SpecialVertex};
use crate::index::Face;
use crate::refine::Level;
use crate::scheme::{Scheme, SplitKind};
use crate::topology::{Interpolation, Surroundings, Topology, Walk};
use std::collections::HashMap;
use std::sync::Arc;

/// Steps towards the boundary. Larger: time; smaller: positions are off by `2^-DEEPEST` of the face's size squared.
const DEEPEST: u32 = 50;

/// True where a side of the face is a boundary that stays linear.
pub(super) fn has_side(t: &Topology, face: Face) -> bool {
    t.interpolation == Interpolation::LinearBoundaries
        && (0..t.sides(face)).any(|c| t.is_boundary(t.edge(t.half_edge(face, c))))
}

/// What the limit of such a face depends on.
pub(crate) struct LinearBoundary {
    split: SplitKind,
    /// State 0 is the face itself.
    states: Vec<State>,
    /// Vertices with a closed form at the face's own corners, and their points.
    at_corner: Vec<Option<(Arc<SpecialVertex>, Rows)>>,
}

/// A face with a linear side, up to equal surroundings.
struct State {
    /// Positions of the face's corners among its points.
    corners: Vec<u32>,
    points: usize,
    children: Vec<Child>,
}

struct Child {
    /// The child's points over those of its parent.
    points: Rows,
    goes_to: Next,
}

enum Next {
    State(usize),
    Inside(Box<Plan>),
}

impl LinearBoundary {
    /// The automaton of face 0 of `t`, a cut-out whose faces have all the scheme's number of sides and no finite
    /// sharpness at the face's corners.
    pub fn new(t: &Topology, scheme: Scheme, specials: &SpecialVertices) -> Self {
        let mut builder =
            Builder { scheme, specials, walk: Walk::default(), known: HashMap::new(), states: Vec::new() };
        let mut around = Surroundings::default();
        t.surroundings(Face(0), 0, &mut builder.walk, &mut around);
        builder.state(t, &around);
        let mut done = 0;
        while done < builder.states.len() {
            builder.expand(done);
            done += 1;
        }
        let at_corner = (0..t.sides(Face(0))).map(|c| at_corner(t, c, scheme, specials)).collect();
        let states = builder.states.into_iter().map(|open| open.state).collect();
        Self { split: scheme.split(), states, at_corner }
    }

    /// Weights over the points of the face's surroundings for position and derivatives at `(u, v)`.
    pub fn weights(&self, u: f64, v: f64, count: usize) -> PointWeights {
        let places: &[[f64; 2]] = match self.split {
            SplitKind::Quads => &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            SplitKind::Triangles => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        };
        let corner = places.iter().position(|place| *place == [u, v]);
        if let Some((vertex, points)) = corner.and_then(|c| self.at_corner[c].as_ref()) {
            let width = self.states[0].points;
            let local = vertex.weights(0.0, 0.0, count);
            return pull_back(local, points, width, 1.0, count);
        }
        self.follow(0, u, v, 0, count)
    }

    fn follow(&self, state: usize, u: f64, v: f64, depth: u32, count: usize) -> PointWeights {
        let State { corners, points, children } = &self.states[state];
        if depth == DEEPEST {
            let mut out = PointWeights::default();
            for (row, local) in out.rows.iter_mut().zip(linear(self.split, u, v).rows).take(count) {
                *row = vec![0.0; *points];
                corners.iter().zip(local).for_each(|(&c, w)| row[c as usize] += w);
            }
            // Every vertex of every level on the boundary is a corner with two faces, whose step has a Jordan block at
            // 1/2: the derivative across grows with the depth.
            out.at_vertex = Some(AtVertex { derivatives: Derivatives::Diverges, plane: None, unique_normal: false });
            return out;
        }
        let (child, u, v, flip) = descend(self.split, u, v);
        let child = &children[child];
        let local = match &child.goes_to {
            Next::State(next) => self.follow(*next, u, v, depth + 1, count),
            Next::Inside(plan) => plan.weights(u, v, 0, count),
        };
        pull_back(local, &child.points, *points, 2.0 * flip, count)
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        let child = |child: &Child| match &child.goes_to {
            Next::State(_) => child.points.bytes(),
            Next::Inside(plan) => child.points.bytes() + plan.bytes(),
        };
        self.states.iter().flat_map(|s| &s.children).map(child).sum()
    }
}

/// Weights over `points` to weights over the `width` points they are made of, `speed` per differentiation.
///
/// Weights of derivatives sum to zero; what rounding adds to the sum would double at every level and is taken away.
fn pull_back(local: PointWeights, points: &Rows, width: usize, speed: f64, count: usize) -> PointWeights {
    let through = |row: &[f64], factor: f64| {
        let mut out = vec![0.0; width];
        points.left_multiply(row, &mut out);
        out.iter_mut().for_each(|w| *w *= factor);
        out
    };
    let mut out = PointWeights::default();
    for order in 0..count {
        let times = [0, 1, 1, 2, 2, 2][order];
        let mut row = through(&local.rows[order], speed.powi(times));
        if order > 0 {
            let excess: f64 = row.iter().sum();
            if let Some(largest) = row.iter_mut().max_by(|a, b| a.abs().total_cmp(&b.abs())) {
                *largest -= excess;
            }
        }
        out.rows[order] = row;
    }
    out.at_vertex =
        local.at_vertex.map(|at| AtVertex { plane: at.plane.map(|plane| plane.map(|row| through(&row, 1.0))), ..at });
    out
}

/// The closed form at a corner on the boundary that is no plain spline corner.
fn at_corner(t: &Topology, c: usize, scheme: Scheme, specials: &SpecialVertices) -> Option<(Arc<SpecialVertex>, Rows)> {
    let h = t.half_edge(Face(0), c);
    let kind = corner(t, h, scheme.split()).0;
    if kind.kind != Kind::Corner || kind.is_regular() {
        return None;
    }
    let vertex = specials.get(kind);
    let mut points = ring_points(t, h, scheme.split());
    // At the vertex itself the points beyond its ring have no weight.
    points.resize(vertex.points(), Combination::new());
    Some((vertex, Rows::new(t.vertex_count(), &points)))
}

struct Builder<'a> {
    scheme: Scheme,
    specials: &'a SpecialVertices,
    walk: Walk,
    known: HashMap<Vec<u32>, usize>,
    states: Vec<Open>,
}

/// A state whose children are still to be made.
struct Open {
    topology: Topology,
    state: State,
}

impl Builder<'_> {
    /// The number of the state of the face round which `around` was walked.
    fn state(&mut self, t: &Topology, around: &Surroundings) -> usize {
        if let Some(&known) = self.known.get(&around.key) {
            return known;
        }
        let topology = t.cut_out(around);
        let corners = topology.face_vertices(Face(0)).to_vec();
        let state = State { corners, points: around.ring.len(), children: Vec::new() };
        self.states.push(Open { topology, state });
        self.known.insert(around.key.clone(), self.states.len() - 1);
        self.states.len() - 1
    }

    fn expand(&mut self, at: usize) {
        let parent = Level::from_topology(self.states[at].topology.clone(), self.scheme);
        let refined = parent.refine().expect("surroundings are small");
        let (t, child) = (parent.topology(), refined.topology());
        let mut around = Surroundings::default();
        let mut sum = Accumulator::new(t.vertex_count());
        // Face 0's children come first.
        for face in (0..4).map(Face) {
            child.surroundings(face, 0, &mut self.walk, &mut around);
            let points: Vec<Combination> = around
                .ring
                .iter()
                .map(|&v| {
                    child_vertex(t, self.scheme, v, &mut |p, w| sum.add(p, w));
                    sum.take()
                })
                .collect();
            let goes_to = if has_side(child, face) {
                Next::State(self.state(child, &around))
            } else {
                Next::Inside(Box::new(Plan::new(child, &around, self.scheme, self.specials)))
            };
            let points = Rows::new(t.vertex_count(), &points);
            self.states[at].state.children.push(Child { points, goes_to });
        }
    }
}
