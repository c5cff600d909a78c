//! Rates for edges and patches. A rate along an edge depends on the edge alone, so that both its faces agree.
//!
//! Adaptive rates are found by measuring: from the coarsest on, until facets keep the goal at points between their
//! corners. Distances are to the facets themselves, not to the points of equal parameter, which drift apart next to
//! extraordinary vertices.

use super::layout::PatchRates;
use super::patch_grid::on_side;
use super::{FINEST, Rates, TessellateError, facets};
use crate::index::{Face, HalfEdge};
use crate::limit::{LastPole, LimitSurface, Location, PatchTable};
use crate::real::Real;
use crate::scheme::SplitKind;
use crate::topology::NONE;
use rayon::prelude::*;

pub(super) fn choose<T: Real>(
    surface: &LimitSurface<'_, T, 3>,
    rates: Rates,
    most_points: u64,
) -> Result<PatchRates, TessellateError> {
    let positive = |what, value: f64| {
        if value > 0.0 && value.is_finite() { Ok(()) } else { Err(TessellateError::NotPositive { what, value }) }
    };
    match rates {
        Rates::Uniform(0) => Err(TessellateError::ZeroRate),
        Rates::Uniform(rate) => Ok(uniform(surface.table(), rate)),
        Rates::Tolerance(value) => {
            positive("tolerance", value)?;
            adaptive(surface, Goal::Deviation(value), most_points)?
                .ok_or(TessellateError::TooFine { what: "tolerance", value })
        }
        Rates::EdgeLength(value) => {
            positive("edge length", value)?;
            adaptive(surface, Goal::Length(value), most_points)?
                .ok_or(TessellateError::TooFine { what: "edge length", value })
        }
    }
}

fn uniform(table: &PatchTable, rate: u32) -> PatchRates {
    let t = table.topology();
    let no_subfaces = table.patch_count() == t.face_count();
    let even = |rate: u32| rate.checked_add(rate % 2).unwrap_or(rate - 1);
    PatchRates::Uniform { rate: if no_subfaces { rate } else { even(rate) }, edges: t.edge_count() }
}

#[derive(Clone, Copy)]
enum Goal {
    /// Distance between facets and surface.
    Deviation(f64),
    /// Length of facet sides.
    Length(f64),
}

/// Shares of a tolerance: the rest is for what lies between the points measured, and along edges for the triangles that
/// lead from them to an inner grid of another rate.
const EDGE_SHARE: f64 = 0.6;
const FACET_SHARE: f64 = 0.8;

impl Goal {
    /// The same goal with a share of the tolerance.
    fn share(self, share: f64) -> Self {
        match self {
            Goal::Deviation(tolerance) => Goal::Deviation(share * tolerance),
            Goal::Length(_) => self,
        }
    }

    /// Whether a facet side from `a` to `b` will do, `between` being points of the surface along it.
    fn side_is_met(self, a: Point, b: Point, between: &[Point]) -> bool {
        match self {
            Goal::Deviation(tolerance) => between.iter().all(|&p| to_segment(p, a, b) <= tolerance),
            Goal::Length(side) => length(minus(b, a)) <= side,
        }
    }

    /// Whether the triangles `a b c` and, of a quad, `a c d` will do for points of the surface over them.
    fn inside_is_met(self, triangles: &[[Point; 3]], over: &[Point]) -> bool {
        let Goal::Deviation(tolerance) = self else { return true };
        over.iter().all(|&p| triangles.iter().any(|&t| to_triangle(p, t) <= tolerance))
    }

    /// Pieces in which a facet's side is measured: more on coarse grids, where a single point may lie on it by chance.
    fn pieces(self, n: u32) -> u32 {
        match self {
            Goal::Length(_) => 1,
            Goal::Deviation(_) if n < 4 => 4,
            Goal::Deviation(_) => 3,
        }
    }

    /// A rate below which a side from `a` to `b` cannot do.
    fn least(self, a: Point, b: Point) -> u32 {
        match self {
            Goal::Length(side) => (length(minus(b, a)) / side).ceil().clamp(1.0, f64::from(FINEST)) as u32,
            Goal::Deviation(_) => 1,
        }
    }

    /// The first of some growing rates, from `least` on, that meets the goal; none up to [`FINEST`].
    fn first(least: u32, meets: impl Fn(u32) -> bool) -> Option<u32> {
        let mut n = least;
        while !meets(n) {
            if n == FINEST {
                return None;
            }
            n = grown(n);
        }
        Some(n)
    }
}

/// The next rate to try.
fn grown(n: u32) -> u32 {
    (n + n.div_ceil(4)).min(FINEST)
}

/// None where some face would need more than [`FINEST`] facets along a side; found without measuring all the others.
fn adaptive<T: Real>(
    surface: &LimitSurface<'_, T, 3>,
    goal: Goal,
    most_points: u64,
) -> Result<Option<PatchRates>, TessellateError> {
    let table = surface.table();
    let t = table.topology();
    let mut owner = vec![NONE; t.edge_count()];
    let mut beside_subfaces = vec![false; t.edge_count()];
    for h in (0..t.half_edge_count() as u32).rev().map(HalfEdge) {
        if !t.is_hole(t.face(h)) {
            owner[t.edge(h).index()] = h.0;
        }
        beside_subfaces[t.edge(h).index()] |= table.subfaces(t.face(h)) > 1;
    }
    let edge: Option<Vec<u32>> = (0..t.edge_count())
        .into_par_iter()
        .map(|e| {
            if owner[e] == NONE {
                return Some(2);
            }
            let h = HalfEdge(owner[e]);
            let [a, b] = [0.0, 1.0].map(|s| surface.position(along_edge(table, h, s)).expect("owners are no holes"));
            let n = Goal::first(goal.least(a, b), |n| edge_meets(surface, goal.share(EDGE_SHARE), h, n))?;
            Some(if beside_subfaces[e] { n + n % 2 } else { n })
        })
        .collect();
    let Some(edge) = edge else { return Ok(None) };
    check_edges(table, &edge, most_points)?;
    let faces: Option<Vec<Vec<[u32; 2]>>> = (0..t.face_count() as u32)
        .into_par_iter()
        .map(|f| {
            let f = Face(f);
            let n = table.subfaces(f) as usize;
            if t.is_hole(f) {
                return Some(vec![[1, 1]; n]);
            }
            let sides: Vec<u32> = (0..t.sides(f)).map(|c| edge[t.edge(t.half_edge(f, c)).index()]).collect();
            face_rates(surface, goal, f, &sides)
        })
        .collect();
    Ok(faces.map(|faces| PatchRates::Each { edge, patch: faces.concat() }))
}

/// Refuses before any face is measured: inside a face there are at least as many points as its sides call for.
fn check_edges(table: &PatchTable, edge: &[u32], most_points: u64) -> Result<(), TessellateError> {
    let t = table.topology();
    let inside = |f: Face| -> u64 {
        let rate = |c: usize| u64::from(edge[t.edge(t.half_edge(f, c)).index()]);
        let least = (0..t.sides(f)).map(rate).min().unwrap_or(0);
        if t.is_hole(f) { 0 } else { least * least / 2 }
    };
    let count: u64 = (0..t.face_count() as u32).map(|f| inside(Face(f))).sum();
    if count > most_points {
        return Err(TessellateError::TooLarge { what: "points", count, limit: most_points });
    }
    Ok(())
}

/// True where an edge in `n` pieces keeps the goal.
fn edge_meets<T: Real>(surface: &LimitSurface<'_, T, 3>, goal: Goal, h: HalfEdge, n: u32) -> bool {
    let p = goal.pieces(n);
    let mut last = LastPole::default();
    let at = |k: u32| {
        let s = f64::from(k) / f64::from(p * n);
        surface.position_after(along_edge(surface.table(), h, s), &mut last).expect("owners are no holes")
    };
    let points: Vec<Point> = (0..=p * n).map(at).collect();
    let p = p as usize;
    (0..n as usize).all(|i| goal.side_is_met(points[p * i], points[p * (i + 1)], &points[p * i + 1..p * (i + 1)]))
}

/// The place at `s` in `[0, 1]` along `h`.
fn along_edge(table: &PatchTable, h: HalfEdge, s: f64) -> Location {
    let t = table.topology();
    let face = t.face(h);
    let corner = h.0 - t.first(face);
    let n = table.subfaces(face);
    if n == 1 {
        let is_triangle = table.scheme().split() == SplitKind::Triangles;
        let [u, v] = on_side(is_triangle, corner as usize, s, 1.0 - s);
        Location { face, subface: 0, u, v }
    } else if s < 0.5 {
        Location { face, subface: corner, u: 2.0 * s, v: 0.0 }
    } else {
        Location { face, subface: (corner + 1) % n, u: 0.0, v: 2.0 - 2.0 * s }
    }
}

/// Rates of a face's patches: those of the sides where they agree and suffice, else an inner grid with a point inside.
fn face_rates<T: Real>(surface: &LimitSurface<'_, T, 3>, goal: Goal, f: Face, sides: &[u32]) -> Option<Vec<[u32; 2]>> {
    let subfaces = surface.table().subfaces(f);
    let goal = goal.share(FACET_SHARE);
    let patch = |subface: u32| Location { face: f, subface, u: 0.0, v: 0.0 };
    if surface.table().scheme().split() == SplitKind::Triangles {
        let agree = sides.iter().all(|&s| s == sides[0]);
        let meets = |n: u32| triangle_meets(surface, goal, f, n);
        let uneven = |n: u32| uneven_meets(surface, goal, patch(0), [n, n], sides);
        let n = if agree && meets(sides[0]) { sides[0] } else { Goal::first(3, |n| meets(n) && uneven(n))? };
        return Some(vec![[n, n]]);
    }
    let meets = |cells: [u32; 2]| (0..subfaces).all(|s| quad_meets(surface, goal, patch(s), cells));
    if subfaces > 1 {
        // Sub-faces share their spokes: one rate for all, in both directions.
        let half = sides[0] / 2;
        let agree = sides.iter().all(|&s| s / 2 == half);
        let uneven = |n: u32| {
            (0..subfaces as usize).all(|s| {
                let (out, back) = (sides[s] / 2, sides[(s + sides.len() - 1) % sides.len()] / 2);
                uneven_meets(surface, goal, patch(s as u32), [n, n], &[out, n, n, back])
            })
        };
        let n = if agree && meets([half, half]) { half } else { Goal::first(2, |n| meets([n, n]) && uneven(n))? };
        return Some(vec![[n, n]; subfaces as usize]);
    }
    let agree = sides[0] == sides[2] && sides[1] == sides[3];
    if agree && meets([sides[0], sides[1]]) {
        return Some(vec![[sides[0], sides[1]]]);
    }
    // Grow evenly from what the sides ask for.
    let mut cells = [sides[0].max(sides[2]), sides[1].max(sides[3])].map(|n| n.max(2));
    while !(meets(cells) && uneven_meets(surface, goal, patch(0), cells, sides)) {
        if cells == [FINEST, FINEST] {
            return None;
        }
        cells = cells.map(grown);
    }
    Some(vec![cells])
}

/// True where the triangles that lead from a patch's sides, of given rates, to its inner grid keep the goal.
fn uneven_meets<T: Real>(
    surface: &LimitSurface<'_, T, 3>,
    goal: Goal,
    patch: Location,
    cells: [u32; 2],
    sides: &[u32],
) -> bool {
    if matches!(goal, Goal::Length(_)) {
        return true;
    }
    let is_triangle = surface.table().scheme().split() == SplitKind::Triangles;
    let at = |[u, v]: [f64; 2]| surface.position(Location { u, v, ..patch }).expect("holes have no rates");
    // Quads of the inner grid are measured elsewhere.
    let strips = facets::in_parameters(is_triangle, cells, sides).into_iter().filter(|f| f.len() == 3);
    let strips: Vec<([[f64; 2]; 3], [Point; 3])> =
        strips.map(|f| ([f[0], f[1], f[2]], [at(f[0]), at(f[1]), at(f[2])])).collect();
    strips.iter().all(|&(uv, facet)| {
        let mean = |w: [f64; 3]| [0, 1].map(|i| w[0] * uv[0][i] + w[1] * uv[1][i] + w[2] * uv[2][i]);
        const OVER: [[f64; 3]; 4] =
            [[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], [0.5, 0.25, 0.25], [0.25, 0.5, 0.25], [0.25, 0.25, 0.5]];
        OVER.iter().all(|&w| {
            let over = [at(mean(w))];
            // Next to an extraordinary vertex parameters drift: another facet may lie below the point.
            goal.inside_is_met(&[facet], &over) || strips.iter().any(|s| goal.inside_is_met(&[s.1], &over))
        })
    })
}

/// True where a quad patch in `nu × nv` facets keeps the goal.
fn quad_meets<T: Real>(surface: &LimitSurface<'_, T, 3>, goal: Goal, patch: Location, [nu, nv]: [u32; 2]) -> bool {
    let [pu, pv] = [nu, nv].map(|n| goal.pieces(n));
    let mut last = LastPole::default();
    let mut row = |j: u32| -> Vec<Point> {
        let v = f64::from(j) / f64::from(pv * nv);
        let at = |i: u32| Location { u: f64::from(i) / f64::from(pu * nu), v, ..patch };
        (0..=pu * nu).map(|i| surface.position_after(at(i), &mut last).expect("holes have no rates")).collect()
    };
    let mut first = row(0);
    for j in 0..nv {
        let mut rows = vec![first];
        rows.extend((1..=pv).map(|k| row(pv * j + k)));
        for i in (0..(pu * nu) as usize).step_by(pu as usize) {
            let (bottom, top, right) = (&rows[0], &rows[pv as usize], i + pu as usize);
            let left_side: Vec<Point> = rows[1..pv as usize].iter().map(|r| r[i]).collect();
            let inside: Vec<Point> =
                rows[1..pv as usize].iter().flat_map(|r| r[i + 1..right].iter().copied()).collect();
            let (a, b, c, d) = (bottom[i], bottom[right], top[right], top[i]);
            let met = goal.side_is_met(a, b, &bottom[i + 1..right])
                && goal.side_is_met(a, d, &left_side)
                && goal.inside_is_met(&[[a, b, c], [a, c, d]], &inside);
            if !met {
                return false;
            }
        }
        first = rows.pop().expect("a row above");
    }
    true
}

/// True where a triangle in `n × n` facets keeps the goal.
fn triangle_meets<T: Real>(surface: &LimitSurface<'_, T, 3>, goal: Goal, face: Face, n: u32) -> bool {
    let p = goal.pieces(n);
    let cells = p * n;
    let at = |i: u32, j: u32| {
        let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(cells));
        surface.position(Location { face, subface: 0, u, v }).expect("holes have no rates")
    };
    let grid: Vec<Vec<Point>> = (0..=cells).map(|j| (0..=cells - j).map(|i| at(i, j)).collect()).collect();
    let get = |i: u32, j: u32| grid[j as usize][i as usize];
    let side = |from: (u32, u32), step: (i64, i64)| {
        let along = |k: u32| {
            let go = |x: u32, d: i64| (i64::from(x) + d * i64::from(k)) as u32;
            get(go(from.0, step.0), go(from.1, step.1))
        };
        let between: Vec<Point> = (1..p).map(along).collect();
        goal.side_is_met(along(0), along(p), &between)
    };
    for j in (0..cells).step_by(p as usize) {
        for i in (0..cells - j).step_by(p as usize) {
            let sides = side((i, j), (1, 0)) && side((i, j), (0, 1)) && side((i + p, j), (-1, 1));
            let up = [get(i, j), get(i + p, j), get(i, j + p)];
            let over: Vec<Point> =
                (1..p).flat_map(|y| (1..p - y).map(move |x| (x, y))).map(|(x, y)| get(i + x, j + y)).collect();
            let mut met = sides && goal.inside_is_met(&[up], &over);
            if i + j + 2 * p <= cells {
                let down = [get(i + p, j), get(i + p, j + p), get(i, j + p)];
                let over = (1..p).flat_map(|y| (p - y + 1..p).map(move |x| (x, y)));
                met &= goal.inside_is_met(&[down], &over.map(|(x, y)| get(i + x, j + y)).collect::<Vec<_>>());
            }
            if !met {
                return false;
            }
        }
    }
    true
}

type Point = [f64; 3];

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

/// Distance of `p` from the segment `a b`.
fn to_segment(p: Point, a: Point, b: Point) -> f64 {
    let (ab, ap) = (minus(b, a), minus(p, a));
    let s = if dot(ab, ab) > 0.0 { (dot(ap, ab) / dot(ab, ab)).clamp(0.0, 1.0) } else { 0.0 };
    length([0, 1, 2].map(|i| ap[i] - s * ab[i]))
}

/// Distance of `p` from a triangle.
fn to_triangle(p: Point, [a, b, c]: [Point; 3]) -> f64 {
    let (ab, ac, ap) = (minus(b, a), minus(c, a), minus(p, a));
    let (bb, bc, cc) = (dot(ab, ab), dot(ab, ac), dot(ac, ac));
    let (x, y) = (dot(ap, ab), dot(ap, ac));
    let area_sq = bb * cc - bc * bc;
    let (s, t) = ((cc * x - bc * y) / area_sq, (bb * y - bc * x) / area_sq);
    if area_sq > 0.0 && s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
        return length([0, 1, 2].map(|i| ap[i] - s * ab[i] - t * ac[i]));
    }
    to_segment(p, a, b).min(to_segment(p, b, c)).min(to_segment(p, c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_to_the_nearest_point() {
        let t = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        assert_eq!(to_triangle([0.5, 0.5, 3.0], t), 3.0);
        assert_eq!(to_triangle([-3.0, 1.0, 4.0], t), 5.0);
        assert!((to_triangle([2.0, 2.0, 0.0], t) - 2f64.sqrt()).abs() < 1e-15);
        assert_eq!(to_segment([5.0, 4.0, 0.0], t[0], t[1]), 5.0);
    }
}
