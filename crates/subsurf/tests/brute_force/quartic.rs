//! The quartic polynomial over a regular triangle, by interpolation: its values at the 15 points of parameters that are
//! multiples of a quarter are limit points of vertices two levels down (1/2 of the vertex and 1/12 of each neighbour,
//! Loop 1987), and Lagrange's polynomials go through them.

use super::point::{Point, over, plus, size, sum, times};
use super::{Double, INFINITE, Jet, Patch, Rings, Soup, key};
use std::collections::BTreeMap;

/// Points by their places in the lattice of which the triangle is `(0,0) (1,0) (0,1)`.
type Lattice = BTreeMap<(i32, i32), Point>;

/// The six directions, counter-clockwise.
const AROUND: [(i32, i32); 6] = [(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)];

fn step(at: (i32, i32), direction: usize) -> (i32, i32) {
    let d = AROUND[direction % 6];
    (at.0 + d.0, at.1 + d.1)
}

impl Soup {
    /// The polynomial over face 0, which is regular.
    pub(super) fn quartic(&self, rings: &Rings) -> Patch {
        let mut lattice = Lattice::new();
        for corner in 0..3 {
            self.add_ring(corner, rings, &mut lattice);
        }
        let origin = lattice[&(0, 0)];
        let reach = lattice.values().map(|p| size([0, 1, 2].map(|k| (p[k] - origin[k]).to_f64()))).fold(0.0, f64::max);
        let fine = refined(&refined(&lattice));
        let values = nodes().map(|(i, j, _)| limit(&fine, (i, j)));
        Patch { jet: Box::new(move |u, v| interpolated(&values, u, v)), reach }
    }

    /// The six points round a corner of face 0. Beyond a sharp edge the surface is that of a mesh where the opposite
    /// vertex is reflected in the edge's middle, which makes the smooth rules those of the crease.
    fn add_ring(&self, corner: usize, rings: &Rings, lattice: &mut Lattice) {
        const PLACES: [(i32, i32); 3] = [(0, 0), (1, 0), (0, 1)];
        let own = &self.faces[0];
        let (v, place) = (own[corner], PLACES[corner]);
        let mut ring: [Option<u32>; 6] = [None; 6];
        (ring[0], ring[1]) = (Some(own[(corner + 1) % 3]), Some(own[(corner + 2) % 3]));
        let (mut last, mut first) = (1, 6);
        // Across the edges from the face to its neighbours, one way and the other, up to sharp edges.
        for forward in [true, false] {
            let mut face = 0;
            while first > last + 1 {
                let from = ring[if forward { last } else { first % 6 }].expect("a vertex");
                let e = key(v, from);
                if self.sharpness(e) >= INFINITE {
                    break;
                }
                face = *rings.edge_faces[&e].iter().find(|&&f| f != face).expect("a smooth edge has two faces");
                let next = *self.faces[face].iter().find(|&&x| x != v && x != from).expect("a triangle");
                if forward {
                    last += 1;
                    ring[last] = Some(next);
                } else {
                    first -= 1;
                    ring[first] = Some(next);
                }
            }
        }
        let at = |v: u32| self.points[v as usize];
        let mut points = ring.map(|v| v.map(at));
        let reflected = |edge: Option<Point>, opposite: Option<Point>| {
            let [a, b] = [edge, opposite].map(|p| p.expect("a known point"));
            plus(plus(at(v), a), times(b, Double::from(-1.0)))
        };
        let mut forward = true;
        while first > last + 1 {
            if forward {
                points[last + 1] = Some(reflected(points[last], points[last - 1]));
                last += 1;
            } else {
                points[first - 1] = Some(reflected(points[first % 6], points[(first + 1) % 6]));
                first -= 1;
            }
            forward = !forward;
        }
        lattice.insert(place, at(v));
        for (k, point) in points.into_iter().enumerate() {
            // Corner 1 looks to corner 2 in direction 2, corner 2 to corner 0 in direction 4.
            lattice.insert(step(place, k + 2 * corner), point.expect("six neighbours"));
        }
    }
}

/// The regular smooth rules, wherever all the points they need are there.
fn refined(lattice: &Lattice) -> Lattice {
    let mut fine = Lattice::new();
    let weigh = |w: f64, p: Point| times(p, Double::from(w));
    for (&at, &p) in lattice {
        let ring: Vec<Option<Point>> = (0..6).map(|k| lattice.get(&step(at, k)).copied()).collect();
        if let Some(ring) = ring.iter().copied().collect::<Option<Vec<Point>>>() {
            let around = over(sum(ring.into_iter()), 16);
            fine.insert((2 * at.0, 2 * at.1), plus(weigh(0.625, p), around));
        }
        for k in 0..3 {
            if let [Some(before), Some(end), Some(after)] = [ring[(k + 5) % 6], ring[k], ring[k + 1]] {
                let middle = plus(weigh(0.375, plus(p, end)), weigh(0.125, plus(before, after)));
                fine.insert(step((2 * at.0, 2 * at.1), k), middle);
            }
        }
    }
    fine
}

fn limit(lattice: &Lattice, at: (i32, i32)) -> Point {
    let around = sum((0..6).map(|k| lattice[&step(at, k)]));
    plus(over(lattice[&at], 2), over(around, 12))
}

/// `(i, j, 4 - i - j)`: four times the parameters of the interpolated points.
fn nodes() -> [(i32, i32, i32); 15] {
    let mut list = [(0, 0, 0); 15];
    let all = (0..5).flat_map(|j| (0..5 - j).map(move |i| (i, j, 4 - i - j)));
    list.iter_mut().zip(all).for_each(|(slot, node)| *slot = node);
    list
}

/// `t (t - 1/4) … (t - (n-1)/4)`, one at `t = n/4`; with two derivatives.
fn factor(n: i32, t: Double) -> [Double; 3] {
    let mut f = [Double::from(1.0), Double::ZERO, Double::ZERO];
    for m in 0..n {
        let part = Double::from(f64::from(m + 1));
        let value = (Double::from(4.0) * t - Double::from(f64::from(m))) / part;
        let slope = Double::from(4.0) / part;
        f = [f[0] * value, f[1] * value + f[0] * slope, f[2] * value + Double::from(2.0) * f[1] * slope];
    }
    f
}

fn interpolated(values: &[Point; 15], u: f64, v: f64) -> Jet {
    let (u, v) = (Double::from(u), Double::from(v));
    let w = Double::from(1.0) - u - v;
    let mut jet = [[Double::ZERO; 3]; 6];
    for (&(i, j, k), &value) in nodes().iter().zip(values) {
        let (a, b, c) = (factor(i, u), factor(j, v), factor(k, w));
        let two = Double::from(2.0);
        let weights = [
            a[0] * b[0] * c[0],
            (a[1] * c[0] - a[0] * c[1]) * b[0],
            (b[1] * c[0] - b[0] * c[1]) * a[0],
            (a[2] * c[0] - two * a[1] * c[1] + a[0] * c[2]) * b[0],
            a[1] * b[1] * c[0] - (a[1] * b[0] + a[0] * b[1]) * c[1] + a[0] * b[0] * c[2],
            (b[2] * c[0] - two * b[1] * c[1] + b[0] * c[2]) * a[0],
        ];
        for (slot, weight) in jet.iter_mut().zip(weights) {
            *slot = plus(*slot, times(value, weight));
        }
    }
    jet
}
