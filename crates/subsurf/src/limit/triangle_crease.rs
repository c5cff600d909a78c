//! Semi-sharp creases of Loop subdivision in closed form, at a cost that does not depend on the sharpness.
//!
//! Where the ends of a crease edge are regular (valence 6, the crease straight through), the surface is that of an
//! infinitely sharp crease plus a sum of box splines centred one row beyond the crease. Their coefficients are the bends
//! of the crease edges,
//!
//! ```text
//!        a
//!      /   \          d = a + b - c - c'
//!    c ════ c'
//!      \   /          (how far b is from where the edge's middle reflects a)
//!        b
//! ```
//!
//! which one sharp step halves and refines like a uniform quadratic B-spline (Chaikin 1974): the two new edges on edge i
//! have bends `(3 d_i + d_{i-1}) / 8` and `(3 d_i + d_{i+1}) / 8`. After k steps they are `2^-k` times the blossom of the
//! quadratic at neighbouring multiples of `2^-k`. The proof is in `docs/theory/loop-creases.md`.

use super::box_spline;
use super::bspline::ORDERS;
use super::rows::Combination;
use crate::index::HalfEdge;
use crate::topology::Topology;

/// How a triangle meets a semi-sharp crease.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Contact {
    /// Along the side from its corner `turn` to the next.
    Side,
    /// At corner `turn` alone.
    Corner,
}

/// A semi-sharp crease at a triangle.
#[derive(Clone, Debug)]
pub(crate) struct TriangleCrease {
    contact: Contact,
    /// The corner that comes first after turning.
    pub turn: u8,
    /// In `(0, 10)`, a raise left out.
    sharpness: f64,
}

impl TriangleCrease {
    /// The creases at the triangle with half-edges `own`, and the bends of their edges as combinations of vertices: three
    /// along a side, from before its first corner to beyond its second; two at a corner, clockwise first. None where some
    /// finite sharpness has no closed form.
    pub fn all(t: &Topology, own: &[HalfEdge]) -> Option<Vec<(Self, Vec<Combination>)>> {
        let mut known = [None; 3];
        for (slot, &h) in known.iter_mut().zip(own) {
            if super::corner::has_finite_sharpness(t, h) {
                *slot = Some(regular_crease(t, h)?);
            }
        }
        let is_side = |j: usize| t.edge_sharpness(t.edge(own[j])) > 0.0 && known[j].is_some();
        let mut creases = Vec::new();
        for (j, sharpness) in known.iter().enumerate() {
            let (turn, h) = (j as u8, own[j]);
            let Some(sharpness) = *sharpness else { continue };
            if is_side(j) {
                let twin = t.twin(h)?;
                let bends = [bend(t, opposite(t, h)?)?, bend(t, h)?, bend(t, opposite(t, twin)?)?];
                creases.push((Self { contact: Contact::Side, turn, sharpness }, bends.to_vec()));
            } else if !is_side((j + 2) % 3) {
                let clockwise = t.turn_right(h)?;
                let bends = [bend(t, clockwise)?, bend(t, opposite(t, clockwise)?)?];
                creases.push((Self { contact: Contact::Corner, turn, sharpness }, bends.to_vec()));
            }
        }
        Some(creases)
    }

    /// Number of bends.
    fn bends(&self) -> usize {
        match self.contact {
            Contact::Side => 3,
            Contact::Corner => 2,
        }
    }

    /// Weights of the bends for the first `count` entries of [`ORDERS`] at `(a, b)`, parameters that see the crease along
    /// `b = 0` or at the origin, where the crease is sharper by `raise`. A fraction is one step between two rules, in which the limit is linear.
    pub fn weights(&self, a: f64, b: f64, raise: u8, count: usize) -> [Vec<f64>; 6] {
        let mut rows: [Vec<f64>; 6] = Default::default();
        rows[..count].iter_mut().for_each(|row| row.resize(self.bends(), 0.0));
        let sharpness = self.sharpness + f64::from(raise);
        let (low, high) = (sharpness.floor(), sharpness.ceil());
        let part = sharpness - low;
        self.add(low as i32, 1.0 - part, a, b, &mut rows[..count]);
        if part > 0.0 {
            self.add(high as i32, part, a, b, &mut rows[..count]);
        }
        rows
    }

    /// Adds `factor` times the box splines after `level` sharp steps.
    fn add(&self, level: i32, factor: f64, a: f64, b: f64, rows: &mut [Vec<f64>]) {
        let scale = 2f64.powi(level);
        let (x, y, h) = (a * scale, b * scale, 1.0 / scale);
        // Adds the box splines that `terms` name, at a place of the level's own lattice.
        let mut put = |u: f64, v: f64, sign: f64, terms: &[(usize, [f64; 3])]| {
            let points: [usize; 3] = std::array::from_fn(|k| terms[k.min(terms.len() - 1)].0);
            let basis = box_spline::some_of_basis(&points[..terms.len()], u, v, rows.len());
            for (order, row) in rows.iter_mut().enumerate() {
                let times = (ORDERS[order].0 + ORDERS[order].1) as i32;
                let speed = factor * h * (sign * scale).powi(times);
                for (point, bends) in terms {
                    row.iter_mut().zip(bends).for_each(|(w, bend)| *w += speed * basis[order][*point] * bend);
                }
            }
        };
        match self.contact {
            Contact::Side if y < 1.0 => {
                let j = x.floor().min(scale - 1.0);
                let x = x - j;
                let of = |edge: f64| blossom(edge * h, (edge + 1.0) * h);
                if x + y <= 1.0 {
                    put(x, y, 1.0, &[(0, of(j - 1.0)), (2, of(j)), (5, of(j + 1.0))]);
                } else {
                    // Half a turn makes a triangle that hangs from row 1 one that stands on row 0; the box spline is its
                    // own image.
                    put(1.0 - x, 1.0 - y, -1.0, &[(11, of(j)), (8, of(j + 1.0))]);
                }
            }
            Contact::Corner if x + y < 1.0 => {
                let [near, far] = [0.5 + 0.5 * h, 0.5 - 0.5 * h];
                put(x, y, 1.0, &[(0, [near, far, 0.0]), (1, [far, near, 0.0])]);
            }
            _ => {}
        }
    }
}

/// The blossom at `(x, y)` of the quadratic over `[0, 1]` with coefficients `d_-1, d_0, d_1`, its values at `(-1, 0)`,
/// `(0, 1)` and `(1, 2)` (Ramshaw 1989). At `(-h, 0)` and `(1, 1 + h)` the neighbouring quadratics have the same.
fn blossom(x: f64, y: f64) -> [f64; 3] {
    [0.5 * (1.0 - x) * (1.0 - y), 0.5 * (1.0 + x + y) - x * y, 0.5 * x * y]
}

/// The sharpness of the one crease through the origin of `h`, if nothing else is sharp there, it is inside, of valence 6,
/// and the crease goes straight on with the same sharpness.
fn regular_crease(t: &Topology, h: HalfEdge) -> Option<f64> {
    let v = t.origin(h);
    let [e, f] = t.sharp_edges(v) else { return None };
    if t.vertex_sharpness(v) > 0.0 || !t.foreign_sharpness(v).is_empty() {
        return None;
    }
    let s = t.edge_sharpness(crate::index::Edge(*e));
    let mut spokes = [0; 6];
    let mut at = h;
    for (i, spoke) in spokes.iter_mut().enumerate() {
        // Six steps also lead three times round a vertex of valence 2.
        if i > 0 && at == h {
            return None;
        }
        *spoke = t.edge(at).0;
        at = t.turn_left(at)?;
    }
    let first = spokes.iter().position(|spoke| spoke == e)?;
    (at == h && s == t.edge_sharpness(crate::index::Edge(*f)) && spokes[(first + 3) % 6] == *f).then_some(s)
}

/// The spoke across from `h` at a vertex of valence 6.
fn opposite(t: &Topology, h: HalfEdge) -> Option<HalfEdge> {
    (0..3).try_fold(h, |h, _| t.turn_left(h))
}

/// The bend of an edge.
fn bend(t: &Topology, h: HalfEdge) -> Option<Combination> {
    let twin = t.twin(h)?;
    let ends = [h, twin].map(|h| (t.origin(h).0, -1.0));
    let wings = [h, twin].map(|h| (t.origin(t.prev(h)).0, 1.0));
    Some(wings.into_iter().chain(ends).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::index::{Face, Vertex};
    use crate::limit::level::triangle_place;
    use crate::limit::{LimitSurface, Location, Method, PatchTable};
    use crate::refine::Level;
    use crate::scheme::Scheme;
    use crate::shapes::{self, Shape};
    use crate::tags::{Crease, Tags};

    const COLUMNS: u32 = 6;

    /// A grid of triangles, every inner vertex of valence 6, with a crease along its middle row.
    fn creased(s: f64) -> Shape {
        let crease = |x: u32| Crease::new(2 * (COLUMNS + 1) + x, 2 * (COLUMNS + 1) + x + 1, s);
        let tags = Tags { creases: (0..COLUMNS).map(crease).collect(), ..Tags::default() };
        shapes::grid(COLUMNS, 4).triangulated().tagged(format!("crease of {s}"), tags)
    }

    fn between(t: &Topology, a: u32, b: u32) -> HalfEdge {
        let joins = |h: &HalfEdge| t.origin(*h) == Vertex(a) && t.origin(t.next(*h)) == Vertex(b);
        (0..t.half_edge_count() as u32).map(HalfEdge).find(joins).expect("an edge")
    }

    fn bend_at(t: &Topology, points: &[[f64; 3]], a: u32, b: u32) -> [f64; 3] {
        let terms = bend(t, between(t, a, b)).unwrap();
        [0, 1, 2].map(|k| terms.iter().map(|&(v, w)| w * points[v as usize][k]).sum())
    }

    #[test]
    fn one_sharp_step_halves_bends_and_refines_them_like_a_quadratic_b_spline() {
        let shape = creased(10.0);
        let coarse = Level::new(&shape.mesh, Scheme::Loop).unwrap();
        let (fine, points) = (coarse.refine().unwrap(), coarse.refine_values(&shape.positions));
        let t = coarse.topology();
        let row = 2 * (COLUMNS + 1);
        let old = |i: u32| bend_at(t, &shape.positions, row + i, row + i + 1);
        for i in 1..COLUMNS - 1 {
            let (v, w) = (row + i, row + i + 1);
            let middle = t.vertex_count() as u32 + t.edge(between(t, v, w)).0;
            for (end, beside) in [(v, i - 1), (w, i + 1)] {
                let new = bend_at(fine.topology(), &points, end, middle);
                for k in 0..3 {
                    let expected = (3.0 * old(i)[k] + old(beside)[k]) / 8.0;
                    // Sums of ten terms of size 6.
                    assert!((new[k] - expected).abs() < 1e-14, "edge {i}: {new:?}");
                }
            }
        }
    }

    #[test]
    fn blossoms_at_neighbouring_knots_are_what_chaikin_s_rule_gives() {
        let given: Vec<f64> = (0..7).map(|i| f64::from(i * i % 5) - 0.3 * f64::from(i)).collect();
        let (mut refined, middle) = (given.clone(), 3);
        for level in 1..6 {
            let pairs = refined.windows(3).flat_map(|d| [0.75 * d[1] + 0.25 * d[0], 0.75 * d[1] + 0.25 * d[2]]);
            refined = pairs.collect();
            // Edge 0 of the level lies at the start of the middle edge; each step lost one at the front.
            let first = (0..level).fold(middle as i32, |at, _| 2 * (at - 1)) as usize;
            let h = 2f64.powi(-level);
            for i in -1..=(1 << level) {
                let weights = blossom(f64::from(i) * h, f64::from(i + 1) * h);
                let ours: f64 = (0..3).map(|k| weights[k] * given[middle + k - 1]).sum();
                assert!((ours - refined[(first as i32 + i) as usize]).abs() < 1e-14, "level {level} edge {i}");
            }
        }
    }

    /// Position and derivatives in the parameters of the coarse face.
    fn jet(surface: &LimitSurface<'_, f64, 3>, at: Location, speed: f64) -> [[f64; 3]; 6] {
        let jet = surface.eval_second(at).unwrap();
        let [uu, uv, vv] = jet.second.unwrap().map(|d| d.map(|x| x * speed * speed));
        [jet.position, jet.du.map(|x| x * speed), jet.dv.map(|x| x * speed), uu, uv, vv]
    }

    #[test]
    fn the_closed_form_is_the_limit_of_explicit_levels() {
        for s in [0.4, 1.0, 1.6, 2.0, 2.5, 3.0] {
            let shape = creased(s);
            let table = PatchTable::new(&shape.mesh, Scheme::Loop).unwrap();
            let surface = table.surface(&shape.positions);
            let (mut level, mut points) = (Level::new(&shape.mesh, Scheme::Loop).unwrap(), shape.positions.clone());
            let depth = s.ceil() as u32;
            for _ in 0..depth {
                points = level.refine_values(&points);
                level = level.refine().unwrap();
            }
            let smooth = PatchTable::from_topology(level.topology().clone(), Scheme::Loop, Method::Deflated).unwrap();
            let smooth = smooth.surface(&points);
            for f in (0..level.topology().face_count() as u32).map(Face) {
                let corner = [0, 1, 2].map(|c| triangle_place(f, c, depth));
                let mix = |u: f64, v: f64, of: fn(&Location) -> f64| {
                    (1.0 - u - v) * of(&corner[0]) + u * of(&corner[1]) + v * of(&corner[2])
                };
                let (u, v) = (0.25, 0.375);
                let coarse = Location { u: mix(u, v, |at| at.u), v: mix(u, v, |at| at.v), ..corner[0] };
                let speed = 1.0 / (corner[1].u - corner[0].u);
                let (ours, theirs) =
                    (jet(&surface, coarse, 1.0), jet(&smooth, Location { face: f, subface: 0, u, v }, speed));
                for (order, (a, b)) in ours.iter().zip(&theirs).enumerate() {
                    // Rounding of points of size 6, times the speed of each differentiation.
                    let slack = 1e-14 * speed.abs().powi([0, 1, 1, 2, 2, 2][order]).max(1.0);
                    let is_near = (0..3).all(|k| (a[k] - b[k]).abs() < slack);
                    assert!(is_near, "{} {coarse:?} order {order}: {a:?} {b:?}", shape.name);
                }
            }
        }
    }
}
