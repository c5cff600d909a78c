//! The masks of vertices and edges, written from the literature: Catmull, Clark 1978 and Loop 1987, sharpness by DeRose,
//! Kass, Truong 1998 with OpenSubdiv's treatment of fractions.

use super::point::{Point, mix, over, plus, sum, times};
use super::{Double, INFINITE, Rings, Soup};
use std::collections::HashSet;

pub(super) fn decay(s: f64) -> f64 {
    if s >= INFINITE { INFINITE } else { (s - 1.0).max(0.0) }
}

#[derive(Clone, Copy, PartialEq, Debug)]
enum Rule {
    Smooth,
    Crease,
    Corner,
}

impl Soup {
    pub(super) fn sharpness(&self, e: (u32, u32)) -> f64 {
        self.edge_sharpness.get(&e).copied().unwrap_or(0.0)
    }

    /// Sharpness of the half of `e` at its end `v`.
    pub(super) fn half(&self, e: (u32, u32), v: u32, rings: &Rings) -> f64 {
        let s = self.sharpness(e);
        let semi = |s: f64| s > 0.0 && s < INFINITE;
        if !self.chaikin || !semi(s) {
            return decay(s);
        }
        let others: Vec<f64> = rings.vertex_edges[&v]
            .iter()
            .filter(|&&other| other != e)
            .map(|&other| self.sharpness(other))
            .filter(|&s| semi(s))
            .collect();
        if others.is_empty() {
            return decay(s);
        }
        (0.75 * s + 0.25 * others.iter().sum::<f64>() / others.len() as f64 - 1.0).max(0.0)
    }

    fn rule(vertex: f64, sharp_edges: usize) -> Rule {
        match sharp_edges {
            _ if vertex > 0.0 => Rule::Corner,
            0 | 1 => Rule::Smooth,
            2 => Rule::Crease,
            _ => Rule::Corner,
        }
    }

    pub(super) fn vertex_point(&self, v: u32, rings: &Rings, face_points: &[Point]) -> Point {
        let edges = &rings.vertex_edges[&v];
        let own = self.points[v as usize];
        let s = self.vertex_sharpness[v as usize];
        let other = |e: &(u32, u32)| self.points[if e.0 == v { e.1 } else { e.0 } as usize];
        let now: Vec<(u32, u32)> = edges.iter().copied().filter(|&e| self.sharpness(e) > 0.0).collect();
        let later: Vec<(u32, u32)> = now.iter().copied().filter(|&e| self.half(e, v, rings) > 0.0).collect();
        let apply = |rule: Rule, sharp: &[(u32, u32)]| match rule {
            Rule::Corner => own,
            Rule::Crease => {
                let ends = plus(other(&sharp[0]), other(&sharp[1]));
                plus(times(own, Double::from(0.75)), times(ends, Double::from(0.125)))
            }
            Rule::Smooth => {
                let faces = &rings.vertex_faces[&v];
                let n = faces.len();
                assert_eq!(edges.len(), n, "a smooth vertex lies inside");
                if self.triangles {
                    let beta = beta(n);
                    let rest = Double::from(1.0) - Double::from(n as f64) * beta;
                    return plus(times(own, rest), times(sum(edges.iter().map(other)), beta));
                }
                let ring = plus(sum(edges.iter().map(other)), sum(faces.iter().map(|&f| face_points[f])));
                let n = Double::from(n as f64);
                plus(times(own, (n - Double::from(2.0)) / n), times(ring, Double::from(1.0) / (n * n)))
            }
        };
        let parent = Self::rule(s, now.len());
        if parent == Rule::Smooth {
            return apply(Rule::Smooth, &[]);
        }
        let child = Self::rule(decay(s), later.len());
        if child == parent && (child != Rule::Crease || now == later) {
            return apply(parent, &now);
        }
        let mut fading: Vec<f64> = now
            .iter()
            .filter(|&&e| if self.chaikin { self.half(e, v, rings) <= 0.0 } else { self.sharpness(e) <= 1.0 })
            .map(|&e| self.sharpness(e))
            .collect();
        if s > 0.0 && decay(s) == 0.0 {
            fading.push(s);
        }
        let weight = if fading.is_empty() { 0.0 } else { (fading.iter().sum::<f64>() / fading.len() as f64).min(1.0) };
        mix(apply(parent, &now), weight, apply(child, &later))
    }

    fn edge_point(&self, e: (u32, u32), rings: &Rings, face_points: &[Point]) -> Point {
        let ends = plus(self.points[e.0 as usize], self.points[e.1 as usize]);
        let middle = over(ends, 2);
        let s = self.sharpness(e);
        if s >= 1.0 || (self.chaikin && s > 0.0 && [e.0, e.1].iter().all(|&v| self.half(e, v, rings) > 0.0)) {
            return middle;
        }
        let faces = &rings.edge_faces[&e];
        assert_eq!(faces.len(), 2, "a smooth edge has two faces");
        if self.triangles {
            let opposite = |&f: &usize| *self.faces[f].iter().find(|&&v| v != e.0 && v != e.1).expect("a triangle");
            let beyond = sum(faces.iter().map(|f| self.points[opposite(f) as usize]));
            let smooth = plus(times(ends, Double::from(0.375)), times(beyond, Double::from(0.125)));
            return mix(middle, s, smooth);
        }
        let triangle = |f: usize| self.faces[f].len() == 3;
        let share = if self.smooth_triangles && faces.iter().any(|&f| triangle(f)) {
            let t = |f: usize| if triangle(f) { Double::ratio(47.0, 100.0) } else { Double::from(0.25) };
            (t(faces[0]) + t(faces[1])) / Double::from(2.0)
        } else {
            Double::from(0.25)
        };
        let centres = plus(face_points[faces[0]], face_points[faces[1]]);
        let smooth = plus(times(ends, Double::from(0.5) - share), times(centres, share));
        mix(middle, s, smooth)
    }

    /// The edge point; where an end's edges are not all here, Chaikin's rule cannot look, and nobody will.
    pub(super) fn edge_point_or_middle(
        &self,
        e: (u32, u32),
        rings: &Rings,
        face_points: &[Point],
        inner: &HashSet<u32>,
    ) -> Point {
        let complete = |v: u32| inner.contains(&v);
        if complete(e.0) && complete(e.1) || !self.chaikin {
            return self.edge_point(e, rings, face_points);
        }
        over(plus(self.points[e.0 as usize], self.points[e.1 as usize]), 2)
    }
}

/// Loop's weight of each neighbour of a smooth vertex with `n` edges: `(5/8 - (3/8 + cos(2π/n)/4)²) / n`.
fn beta(n: usize) -> Double {
    // π to 32 digits.
    let pi = Double::from(std::f64::consts::PI) + Double::from(1.2246467991473532e-16);
    let n = Double::from(n as f64);
    let inner = Double::from(0.375) + Double::from(0.25) * cosine(Double::from(2.0) * pi / n);
    (Double::from(0.625) - inner * inner) / n
}

/// By its series, for angles up to π.
fn cosine(x: Double) -> Double {
    let (mut term, mut total) = (Double::from(1.0), Double::from(1.0));
    for k in 1..25 {
        let k = f64::from(k);
        term = Double::ZERO - term * x * x / Double::from(2.0 * k * (2.0 * k - 1.0));
        total = total + term;
    }
    total
}

#[test]
fn regular_weights_of_loop_are_sixteenths() {
    // 1e-31 for each of 25 terms of size up to (π/3)²/2.
    assert!((beta(6) - Double::ratio(1.0, 16.0)).to_f64().abs() < 1e-30);
    assert!((beta(3) - Double::ratio(3.0, 16.0)).to_f64().abs() < 1e-30);
}
