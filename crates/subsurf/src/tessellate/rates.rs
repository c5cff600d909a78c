//! Rates for edges and patches. A rate along an edge depends on the edge alone, so that both its faces agree.

use super::layout::PatchRates;
use super::{FINEST, Rates, TessellateError};
use crate::index::{Face, HalfEdge};
use crate::limit::{Jet, LimitSurface, Location, PatchTable};
use crate::real::Real;
use crate::topology::NONE;
use rayon::prelude::*;

pub(super) fn choose<T: Real>(surface: &LimitSurface<'_, T, 3>, rates: Rates) -> Result<PatchRates, TessellateError> {
    let positive = |what, value: f64| {
        if value > 0.0 && value.is_finite() { Ok(()) } else { Err(TessellateError::NotPositive { what, value }) }
    };
    match rates {
        Rates::Uniform(0) => Err(TessellateError::ZeroRate),
        Rates::Uniform(rate) => Ok(uniform(surface.table(), rate)),
        Rates::Tolerance(value) => {
            positive("tolerance", value)?;
            Ok(adaptive(surface, &Goal::Deviation(value)))
        }
        Rates::EdgeLength(value) => {
            positive("edge length", value)?;
            Ok(adaptive(surface, &Goal::Length(value)))
        }
    }
}

fn uniform(table: &PatchTable, rate: u32) -> PatchRates {
    let t = table.topology();
    let all_quads = (0..t.face_count() as u32).all(|f| table.subfaces(Face(f)) == 1);
    let rate = if all_quads { rate } else { rate + rate % 2 };
    let mut patch = Vec::with_capacity(table.patch_count());
    for f in (0..t.face_count() as u32).map(Face) {
        let n = table.subfaces(f);
        let cells = if n == 1 { rate } else { rate / 2 };
        patch.extend(std::iter::repeat_n([cells, cells], n as usize));
    }
    PatchRates { edge: vec![rate; t.edge_count()], patch }
}

enum Goal {
    /// Distance between facets and surface.
    Deviation(f64),
    /// Length of facet sides.
    Length(f64),
}

impl Goal {
    /// Facets that a curve of these jets needs; its parameter runs from 0 to 1 with derivative `first`.
    fn along(&self, curve: &[([f64; 3], [f64; 3])]) -> f64 {
        match self {
            // A chord of parameter length h deviates by |f''| h² / 8.
            Goal::Deviation(tolerance) => {
                let bend = curve.iter().map(|c| length(c.1)).fold(0.0, f64::max);
                (bend / (8.0 * tolerance)).sqrt()
            }
            Goal::Length(side) => curve.iter().map(|c| length(c.0)).fold(0.0, f64::max) / side,
        }
    }
}

impl Goal {
    /// Whether a facet side from `a` to `b` will do, `middle` being the surface between them.
    fn side_is_met(&self, a: [f64; 3], middle: [f64; 3], b: [f64; 3]) -> bool {
        match self {
            Goal::Deviation(_) => self.diagonal_is_met(a, middle, b),
            Goal::Length(side) => length([0, 1, 2].map(|i| b[i] - a[i])) <= *side,
        }
    }

    fn diagonal_is_met(&self, a: [f64; 3], middle: [f64; 3], b: [f64; 3]) -> bool {
        match self {
            Goal::Deviation(tolerance) => {
                length([0, 1, 2].map(|i| 0.5 * (a[i] + b[i]) - middle[i])) <= SHARE * tolerance
            }
            Goal::Length(_) => true,
        }
    }
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Samples per direction from which rates are chosen.
const PROBES: u32 = 8;

fn adaptive<T: Real>(surface: &LimitSurface<'_, T, 3>, goal: &Goal) -> PatchRates {
    let table = surface.table();
    let t = table.topology();
    let rate = |need: f64| if need.is_finite() { (need.ceil() as u32).clamp(1, FINEST) } else { FINEST };
    let mut owner = vec![NONE; t.edge_count()];
    let mut beside_polygon = vec![false; t.edge_count()];
    for h in (0..t.half_edge_count() as u32).rev().map(HalfEdge) {
        if !t.is_hole(t.face(h)) {
            owner[t.edge(h).index()] = h.0;
        }
        beside_polygon[t.edge(h).index()] |= table.subfaces(t.face(h)) > 1;
    }
    let edge: Vec<u32> = (0..t.edge_count())
        .into_par_iter()
        .map(|e| {
            if owner[e] == NONE {
                return 2;
            }
            let h = HalfEdge(owner[e]);
            let mut n = rate(goal.along(&edge_curve(surface, h)));
            n = finer(n, |n| edge_meets(surface, goal, h, n));
            if beside_polygon[e] { n + n % 2 } else { n }
        })
        .collect();
    let faces: Vec<Vec<[u32; 2]>> = (0..t.face_count() as u32)
        .into_par_iter()
        .map(|f| {
            let f = Face(f);
            let n = table.subfaces(f) as usize;
            if t.is_hole(f) {
                return vec![[1, 1]; n];
            }
            let sides: Vec<u32> = (0..t.sides(f)).map(|c| edge[t.edge(t.half_edge(f, c)).index()]).collect();
            face_rates(surface, goal, f, &sides, &rate)
        })
        .collect();
    PatchRates { edge, patch: faces.concat() }
}

/// The first of `n` and some larger rates that meets the goal.
fn finer(mut n: u32, meets: impl Fn(u32) -> bool) -> u32 {
    while n < FINEST && !meets(n) {
        n = (n + n.div_ceil(4)).min(FINEST);
    }
    n
}

/// Share of a tolerance that sides and facets may use up, so that triangles between unequal rates stay within it.
const SHARE: f64 = 0.8;

/// True where an edge in `n` pieces keeps the goal, measured at the middle of every piece.
fn edge_meets<T: Real>(surface: &LimitSurface<'_, T, 3>, goal: &Goal, h: HalfEdge, n: u32) -> bool {
    let at = |k: u32| {
        let s = f64::from(k) / f64::from(2 * n);
        surface.position(along_edge(surface.table(), h, s).0).expect("owners are no holes")
    };
    let points: Vec<[f64; 3]> = (0..=2 * n).map(at).collect();
    points.windows(3).step_by(2).all(|p| goal.side_is_met(p[0], p[1], p[2]))
}

/// True where a patch in `nu × nv` facets keeps the goal, measured at the middle of every facet and its sides.
fn patch_meets<T: Real>(
    surface: &LimitSurface<'_, T, 3>,
    goal: &Goal,
    f: Face,
    subface: u32,
    [nu, nv]: [u32; 2],
) -> bool {
    let at = |i: u32, j: u32| {
        let (u, v) = (f64::from(i) / f64::from(2 * nu), f64::from(j) / f64::from(2 * nv));
        surface.position(Location { face: f, subface, u, v }).expect("holes have no rates")
    };
    let row = |j: u32| -> Vec<[f64; 3]> { (0..=2 * nu).map(|i| at(i, j)).collect() };
    let mut below = row(0);
    for j in 0..nv {
        let (middle, above) = (row(2 * j + 1), row(2 * j + 2));
        for i in (0..2 * nu as usize).step_by(2) {
            let met = goal.side_is_met(below[i], below[i + 1], below[i + 2])
                && goal.side_is_met(below[i], middle[i], above[i])
                && goal.diagonal_is_met(below[i], middle[i + 1], above[i + 2])
                && goal.diagonal_is_met(below[i + 2], middle[i + 1], above[i]);
            if !met {
                return false;
            }
        }
        below = above;
    }
    true
}

/// First and second derivative along an edge, its parameter running from 0 to 1, at probes off the ends, where they may
/// be unbounded.
fn edge_curve<T: Real>(surface: &LimitSurface<'_, T, 3>, h: HalfEdge) -> Vec<([f64; 3], [f64; 3])> {
    (0..PROBES)
        .map(|k| {
            let (at, along_u, scale) = along_edge(surface.table(), h, (f64::from(k) + 0.5) / f64::from(PROBES));
            let jet = surface.eval_second(at).expect("owners are no holes");
            let second = jet.second.unwrap_or([[0.0; 3]; 3]);
            let (d, dd) = if along_u { (jet.du, second[0]) } else { (jet.dv, second[2]) };
            (d.map(|x| scale * x), dd.map(|x| scale * scale * x))
        })
        .collect()
}

/// The place at `s` in `[0, 1]` along `h`, whether the edge runs along u there, and the speed of its parameter.
fn along_edge(table: &PatchTable, h: HalfEdge, s: f64) -> (Location, bool, f64) {
    let t = table.topology();
    let face = t.face(h);
    let corner = h.0 - t.first(face);
    let n = table.subfaces(face);
    if n == 1 {
        let (u, v) = [(s, 0.0), (1.0, s), (1.0 - s, 1.0), (0.0, 1.0 - s)][corner as usize];
        (Location { face, subface: 0, u, v }, corner.is_multiple_of(2), 1.0)
    } else if s < 0.5 {
        (Location { face, subface: corner, u: 2.0 * s, v: 0.0 }, true, 2.0)
    } else {
        (Location { face, subface: (corner + 1) % n, u: 0.0, v: 2.0 - 2.0 * s }, false, 2.0)
    }
}

/// Rates of a face's patches: those of the sides where they agree and suffice, else an inner grid of at least 2 × 2.
fn face_rates<T: Real>(
    surface: &LimitSurface<'_, T, 3>,
    goal: &Goal,
    f: Face,
    sides: &[u32],
    rate: &dyn Fn(f64) -> u32,
) -> Vec<[u32; 2]> {
    let subfaces = surface.table().subfaces(f);
    let mut need = [0.0f64; 2];
    for subface in 0..subfaces {
        let probe = |k: u32| (f64::from(k) + 0.5) / f64::from(PROBES);
        let grid: Vec<Jet<3>> = (0..PROBES * PROBES)
            .filter_map(|k| {
                surface.eval_second(Location { face: f, subface, u: probe(k % PROBES), v: probe(k / PROBES) })
            })
            .collect();
        let second = |j: &Jet<3>| j.second.unwrap_or([[0.0; 3]; 3]);
        // A bilinear facet errs in both directions and by its twist: a third of the tolerance each.
        let share = if matches!(goal, Goal::Deviation(_)) { 3f64.sqrt() } else { 1.0 };
        let u: Vec<_> = grid.iter().map(|j| (j.du, second(j)[0])).collect();
        let v: Vec<_> = grid.iter().map(|j| (j.dv, second(j)[2])).collect();
        need = [need[0].max(share * goal.along(&u)), need[1].max(share * goal.along(&v))];
        if let Goal::Deviation(tolerance) = goal {
            // The twist of a facet split along a diagonal: |f_uv| h_u h_v / 4.
            let twist = grid.iter().map(|j| length(second(j)[1])).fold(0.0, f64::max);
            let cells = (0.75 * twist / tolerance).sqrt();
            let grow = (cells / (need[0].max(1.0) * need[1].max(1.0)).sqrt()).max(1.0);
            need = need.map(|n| n.max(1.0) * grow);
        }
    }
    if subfaces == 1 {
        let meets = |cells: [u32; 2]| patch_meets(surface, goal, f, 0, cells);
        let [mut nu, mut nv] = need.map(rate);
        let agree = sides[0] == sides[2] && sides[1] == sides[3];
        if agree && sides[0] >= nu && sides[1] >= nv && meets([sides[0], sides[1]]) {
            return vec![[sides[0], sides[1]]];
        }
        (nu, nv) = (nu.max(2), nv.max(2));
        while (nu < FINEST || nv < FINEST) && !meets([nu, nv]) {
            [nu, nv] = [nu, nv].map(|n| (n + n.div_ceil(4)).min(FINEST));
        }
        return vec![[nu, nv]];
    }
    // Sub-faces share their spokes: one rate for all, in both directions.
    let meets = |n: u32| (0..subfaces).all(|s| patch_meets(surface, goal, f, s, [n, n]));
    let n = rate(need[0].max(need[1]));
    let half = sides[0] / 2;
    if sides.iter().all(|&s| s / 2 == half) && half >= n && meets(half) {
        return vec![[half, half]; subfaces as usize];
    }
    let n = finer(n.max(2), meets);
    vec![[n, n]; subfaces as usize]
}
