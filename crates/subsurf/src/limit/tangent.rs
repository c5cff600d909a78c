//! Limit position and tangent masks at special vertices, over the canonical points: left eigenvectors of the local step.
//! Closed forms where they exist (the waves `cos jθ`, `sin jθ` round the vertex), iteration for darts.
//!
//! Notation: `d = cos(θ/2)`, `α = √(4+d²) - d`; a wave has eigenvalue `λ = ((√(4+d²) + d)/4)²` and left vector
//! `4 cos(iθ)` on `e_i`, `α cos((i+½)θ)` on `f_i` (or sines). `θ = 2π/n` round an interior vertex, `π/k` in a sector.
//! Under Loop there are no `f_i`, and `λ = 3/8 + cos(θ)/4`.

use super::corner::{Corner, Kind};
use super::jet::Derivatives;
use super::local_step::LocalStep;
use crate::scheme::{SplitKind, loop_subdivision};
use std::f64::consts::PI;

/// The angle from spoke to spoke of the slowest wave; none at pinned interior vertices, whose ring shrinks evenly.
pub(crate) fn angle(corner: Corner) -> f64 {
    match corner.kind {
        Kind::Smooth | Kind::Dart => 2.0 * PI / f64::from(corner.n),
        Kind::Crease | Kind::Corner => PI / f64::from(corner.n),
        Kind::Pinned => 0.0,
    }
}

/// The dominant eigenvalue of the wave with angle `theta` from spoke to spoke.
pub(crate) fn wave_eigenvalue(split: SplitKind, theta: f64) -> f64 {
    if split == SplitKind::Triangles {
        return 0.375 + 0.25 * theta.cos();
    }
    let d = (0.5 * theta).cos();
    let root = 0.25 * ((4.0 + d * d).sqrt() + d);
    root * root
}

fn alpha(theta: f64) -> f64 {
    let d = (0.5 * theta).cos();
    (4.0 + d * d).sqrt() - d
}

impl Corner {
    /// Canonical index of spoke end `e_j`.
    fn e(self, j: u32) -> usize {
        match self.split {
            SplitKind::Quads => 1 + 2 * j as usize,
            SplitKind::Triangles => 1 + j as usize,
        }
    }

    /// Canonical index of diagonal `f_j`; none under Loop.
    fn f(self, j: u32) -> Option<usize> {
        (self.split == SplitKind::Quads).then_some(2 + 2 * j as usize)
    }
}

/// The limit position mask: `l A = l`, summing to one.
pub(crate) fn limit_mask(corner: Corner, step: &LocalStep) -> Vec<f64> {
    let mut l = vec![0.0; step.points];
    let n = f64::from(corner.n);
    match corner.kind {
        Kind::Corner | Kind::Pinned => l[0] = 1.0,
        Kind::Crease => {
            l[0] = 2.0 / 3.0;
            l[corner.e(0)] = 1.0 / 6.0;
            l[corner.e(corner.n)] += 1.0 / 6.0;
        }
        Kind::Smooth if corner.split == SplitKind::Triangles => {
            let w = 1.0 / (n + 3.0 / (8.0 * loop_subdivision::beta(corner.n)));
            l[0] = 1.0 - n * w;
            (0..corner.n).for_each(|j| l[corner.e(j)] = w);
        }
        Kind::Smooth => {
            l[0] = n / (n + 5.0);
            for j in 0..corner.n {
                l[corner.e(j)] = 4.0 / (n * (n + 5.0));
                corner.f(j).into_iter().for_each(|f| l[f] = 1.0 / (n * (n + 5.0)));
            }
        }
        Kind::Dart => {
            // Not the smooth mask: the dart edge breaks the symmetry. The other modes shrink by 0.66 or more a step.
            l[0] = 1.0;
            for _ in 0..200 / STEPS {
                let mut next = times_power(l.clone(), step, STEPS);
                let sum: f64 = next.iter().sum();
                next.iter_mut().for_each(|w| *w /= sum);
                let is_still = next == l;
                l = next;
                if is_still {
                    break;
                }
            }
        }
    }
    l
}

/// Steps of an iteration from one test of its end to the next. More: steps that change nothing; fewer: tests, each of which takes
/// as long as a step.
const STEPS: usize = 8;

/// `row · A`.
fn times(row: &[f64], step: &LocalStep) -> Vec<f64> {
    times_power(row.to_vec(), step, 1)
}

/// `row · A^m`.
fn times_power(mut row: Vec<f64>, step: &LocalStep, m: usize) -> Vec<f64> {
    let mut next = vec![0.0; row.len()];
    for _ in 0..m {
        next.fill(0.0);
        step.left_multiply(&row, &mut next);
        std::mem::swap(&mut row, &mut next);
    }
    row
}

/// What is known of the surface's directions at a special vertex.
#[derive(Clone, Debug)]
pub(crate) struct Tangents {
    /// Towards `e_i` and towards `e_{i+1}`: the limits of the directions of `∂u` and `∂v`, in the scale of
    /// characteristic-map coordinates with spokes of unit length.
    pub directions: [Vec<f64>; 2],
    /// What becomes of `∂u` and `∂v` themselves.
    pub derivatives: Derivatives,
    /// Two vectors that span the tangent plane, in the surface's orientation.
    pub plane: Option<[Vec<f64>; 2]>,
    /// False where the normal depends on the direction of approach; the plane is then a convention.
    pub unique_normal: bool,
}

impl Tangents {
    /// `even` is that of a dart.
    pub fn new(corner: Corner, step: &LocalStep, even: Option<&EvenMode>) -> Self {
        match corner.kind {
            Kind::Smooth => smooth(corner, step),
            Kind::Crease => crease(corner, step),
            Kind::Corner => pinned_sector(corner, step),
            Kind::Pinned => pinned(corner, step),
            Kind::Dart => dart(corner, step, even.expect("a dart has an even mode")),
        }
    }
}

fn state(eigenvalue: f64) -> Derivatives {
    const EXACT: f64 = 1e-12;
    if eigenvalue > 0.5 + EXACT {
        Derivatives::Diverges
    } else if eigenvalue < 0.5 - EXACT {
        Derivatives::Vanishes
    } else {
        Derivatives::Finite
    }
}

/// The tangent at angle `φθ` from `e_0`: `2/(n (4+α²)) Σ 4 cos((j-φ)θ) e_j + α cos((j+½-φ)θ) f_j`, under Loop
/// `2/n Σ cos((j-φ)θ) e_j`.
fn smooth_direction(corner: Corner, phi: f64, points: usize) -> Vec<f64> {
    let n = f64::from(corner.n);
    let theta = 2.0 * PI / n;
    let a = alpha(theta);
    let quads = corner.split == SplitKind::Quads;
    let (on_e, on_f) = if quads { (8.0 / (n * (4.0 + a * a)), 2.0 * a / (n * (4.0 + a * a))) } else { (2.0 / n, 0.0) };
    let mut mask = vec![0.0; points];
    for j in 0..corner.n {
        mask[corner.e(j)] = on_e * ((f64::from(j) - phi) * theta).cos();
        corner.f(j).into_iter().for_each(|f| mask[f] = on_f * ((f64::from(j) + 0.5 - phi) * theta).cos());
    }
    mask
}

fn smooth(corner: Corner, step: &LocalStep) -> Tangents {
    let n = corner.n;
    let towards = |phi: u32| smooth_direction(corner, f64::from(phi), step.points);
    let directions = [towards(corner.i), towards(corner.i + 1)];
    // Valence 2: the eigenvalues ±1/4 tie, there is no tangent plane.
    let flat = n >= 3;
    let quarter = f64::from(n) / 4.0;
    let i = f64::from(corner.i);
    let plane = flat.then(|| [i, i + quarter].map(|phi| smooth_direction(corner, phi, step.points)));
    Tangents {
        directions,
        derivatives: state(wave_eigenvalue(corner.split, angle(corner))),
        plane,
        unique_normal: flat,
    }
}

/// The sine wave's left vector in a sector, from the crease into the surface; on `v`, `e_0`, `e_k` what the boundary
/// curve feeds into it.
fn cross(corner: Corner, points: usize) -> Vec<f64> {
    let k = corner.n;
    let mut y = vec![0.0; points];
    if k == 1 {
        (y[0], y[corner.e(0)], y[corner.e(1)]) = (-2.0, 1.0, 1.0);
        return y;
    }
    let theta = PI / f64::from(k);
    let (a, lambda) = (alpha(theta), wave_eigenvalue(corner.split, theta));
    let quads = corner.split == SplitKind::Quads;
    let on_e = if quads { 4.0 } else { 1.0 };
    for j in 0..k {
        corner.f(j).into_iter().for_each(|f| y[f] = a * ((f64::from(j) + 0.5) * theta).sin());
        if j > 0 {
            y[corner.e(j)] = on_e * (f64::from(j) * theta).sin();
        }
    }
    // What one step feeds from e_0 and from v into the wave.
    let (at_end, at_vertex) = if quads {
        (
            0.25 * theta.sin() + 0.25 * a * (0.5 * theta).sin(),
            1.5 / (0.5 * theta).tan() + a / (4.0 * (0.5 * theta).sin()),
        )
    } else {
        (0.125 * theta.sin(), 0.375 / (0.5 * theta).tan())
    };
    y[0] = (at_vertex * (lambda - 0.5) + at_end) / ((lambda - 1.0) * (lambda - 0.25));
    y[corner.e(0)] = y[0] * (lambda - 0.75) - at_vertex;
    y[corner.e(k)] = y[corner.e(0)];
    let scale = 2.0 / (f64::from(k) * if quads { 4.0 + a * a } else { 1.0 });
    y.iter_mut().for_each(|w| *w *= scale);
    y
}

fn crease(corner: Corner, step: &LocalStep) -> Tangents {
    let k = corner.n;
    let mut along = vec![0.0; step.points];
    (along[corner.e(0)], along[corner.e(k)]) = (0.5, -0.5);
    let cross = cross(corner, step.points);
    let wave = wave_eigenvalue(corner.split, angle(corner));
    // The tangent along the crease has eigenvalue 1/2: below it, derivatives across vanish.
    let derivatives = if k == 1 { Derivatives::Finite } else { state(wave.max(0.5)) };
    let weight = if derivatives == Derivatives::Finite { 0.0 } else { 1.0 };
    let towards = |j: u32| -> Vec<f64> {
        match j {
            0 => along.clone(),
            j if j == k => along.iter().map(|w| -w).collect(),
            j => {
                let (s, c) = (PI * f64::from(j) / f64::from(k)).sin_cos();
                along.iter().zip(&cross).map(|(a, x)| c * a + weight * s * x).collect()
            }
        }
    };
    // From this many faces on a second wave beats the eigenvalue of the tangent along the crease.
    let most = if corner.split == SplitKind::Quads { 4 } else { 6 };
    Tangents {
        directions: [towards(corner.i), towards(corner.i + 1)],
        derivatives,
        plane: Some([along, cross]),
        unique_normal: k <= most,
    }
}

fn pinned_sector(corner: Corner, step: &LocalStep) -> Tangents {
    let k = corner.n;
    let side = |j: u32| {
        let mut t = vec![0.0; step.points];
        (t[0], t[corner.e(j)]) = (-1.0, 1.0);
        t
    };
    let plane = [side(0), side(k)];
    // Two triangles: both modes of eigenvalue 1/2 are linear, and the middle spoke's derivative is the sum of the sides'.
    let linear = corner.split == SplitKind::Triangles && k == 2;
    let towards = |j: u32| {
        if linear && j == 1 { plane[0].iter().zip(&plane[1]).map(|(a, b)| a + b).collect() } else { side(j) }
    };
    Tangents {
        directions: [towards(corner.i), towards(corner.i + 1)],
        derivatives: if linear { Derivatives::Finite } else { Derivatives::Diverges },
        unique_normal: k <= if corner.split == SplitKind::Quads { 2 } else { 3 },
        plane: Some(plane),
    }
}

fn pinned(corner: Corner, step: &LocalStep) -> Tangents {
    let side = |j: u32| {
        let mut t = vec![0.0; step.points];
        t[0] -= 1.0;
        t[corner.e(j % corner.n)] += 1.0;
        t
    };
    // A cone point: no plane.
    Tangents {
        directions: [side(corner.i), side(corner.i + 1)],
        derivatives: Derivatives::Diverges,
        plane: None,
        unique_normal: false,
    }
}

fn dart(corner: Corner, step: &LocalStep, even: &EvenMode) -> Tangents {
    let n = corner.n;
    // Odd about the dart edge: the smooth vertex's sine wave.
    let odd = smooth_direction(corner, 0.25 * f64::from(n), step.points);
    let (even, even_eigenvalue) = (even.over(step), even.eigenvalue);
    let theta = 2.0 * PI / f64::from(n);
    let odd_eigenvalue = wave_eigenvalue(corner.split, theta);
    let towards = |j: u32| -> Vec<f64> {
        let (s, c) = (f64::from(j) * theta).sin_cos();
        even.iter().zip(&odd).map(|(x, y)| c * x + s * y).collect()
    };
    Tangents {
        directions: [towards(corner.i), towards(corner.i + 1)],
        derivatives: state(odd_eigenvalue.max(even_eigenvalue)),
        plane: (n >= 3).then(|| [even.clone(), odd.clone()]),
        unique_normal: n >= 3,
    }
}

/// At a dart, the left vector of the largest eigenvalue below 1 among those symmetric about the dart edge. It depends on the valence
/// alone, not on which face looks at it.
#[derive(Debug)]
pub(crate) struct EvenMode {
    /// Weights of the points of the ring; no other has one.
    ring: Vec<f64>,
    eigenvalue: f64,
}

impl EvenMode {
    /// That of a dart; `limit` is the [`limit_mask`].
    pub fn new(corner: Corner, step: &LocalStep, limit: &[f64]) -> Self {
        let (mut ring, eigenvalue) = even_mode(corner, step, limit);
        debug_assert!(ring[step.ring..].iter().all(|&w| w == 0.0));
        ring.truncate(step.ring);
        Self { ring, eigenvalue }
    }

    /// Weights of all points of a step.
    fn over(&self, step: &LocalStep) -> Vec<f64> {
        let mut out = vec![0.0; step.points];
        out[..self.ring.len()].copy_from_slice(&self.ring);
        out
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.ring[..])
    }
}

/// By iteration from near the smooth vertex's cosine wave; and the eigenvalue.
fn even_mode(corner: Corner, step: &LocalStep, limit: &[f64]) -> (Vec<f64>, f64) {
    let n = corner.n;
    let symmetric = |row: &mut Vec<f64>| {
        for j in 0..n {
            let mut pair = |a: usize, b: usize| {
                let mean = 0.5 * (row[a] + row[b]);
                (row[a], row[b]) = (mean, mean);
            };
            pair(corner.e(j), corner.e((n - j) % n));
            if let (Some(a), Some(b)) = (corner.f(j), corner.f(n - 1 - j)) {
                pair(a, b);
            }
        }
        // Take out the constant: left vectors of other eigenvalues sum to zero.
        let sum: f64 = row.iter().sum();
        row.iter_mut().zip(limit).for_each(|(w, l)| *w -= sum * l);
    };
    let mut row = smooth_direction(corner, 0.0, step.points);
    let mut eigenvalue = 0.0;
    for _ in 0..20_000 / STEPS {
        // Each step shrinks the mode by less than 3: seven of them lose nothing to small numbers.
        row = times_power(row, step, STEPS - 1);
        symmetric(&mut row);
        let size = row.iter().fold(0.0, |m: f64, w| m.max(w.abs()));
        row.iter_mut().for_each(|w| *w /= size);
        let mut next = times(&row, step);
        symmetric(&mut next);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        eigenvalue = dot(&next, &row) / dot(&row, &row);
        let residual = next.iter().zip(&row).fold(0.0, |m: f64, (x, y)| m.max((x - eigenvalue * y).abs()));
        row = next;
        if residual < 1e-16 {
            break;
        }
    }
    // Unit response to the smooth vertex's cosine wave; at valence 4 that is the linear function along the dart edge.
    let theta = 2.0 * PI / f64::from(n);
    let wave = |j: u32| {
        let spoke = row[corner.e(j)] * (f64::from(j) * theta).cos();
        spoke + corner.f(j).map_or(0.0, |f| row[f] * alpha(theta) * ((f64::from(j) + 0.5) * theta).cos())
    };
    let unit: f64 = (0..n).map(wave).sum();
    row.iter_mut().for_each(|w| *w /= unit);
    (row, eigenvalue)
}

/// Right and left vectors of the eigenvalue 1/2 whose functions are linear in the parameters: their second derivatives are
/// exactly zero and must not drown those of other modes. On a crease with one face (Loop: one or two) it is the function
/// along the crease; at a pinned corner of two triangles there are two, and so at a dart of regular valence, where all
/// rules keep linear functions. `even` is that of a dart.
pub(crate) fn linear_modes(corner: Corner, step: &LocalStep, even: Option<&EvenMode>) -> Vec<(Vec<f64>, Vec<f64>)> {
    let n = corner.n;
    // The linear function with the values `a`, `b` at the ends of two neighbouring spokes `j`, `j + 1`.
    let linear = |j: u32, a: f64, b: f64| -> Vec<f64> {
        let (p, q) = (spoke_direction(corner, j), spoke_direction(corner, j + 1));
        let area = p[0] * q[1] - p[1] * q[0];
        let (x, y) = ((a * q[1] - b * p[1]) / area, (b * p[0] - a * q[0]) / area);
        grid_coordinates(corner).iter().map(|g| x * g[0] + y * g[1]).collect()
    };
    let difference = |j: u32, k: Option<u32>, scale: f64| {
        let mut l = vec![0.0; step.points];
        l[corner.e(j)] = scale;
        l[k.map_or(0, |k| corner.e(k))] = -scale;
        l
    };
    let paired = |r: Vec<f64>, mut l: Vec<f64>| {
        let unit: f64 = l.iter().zip(&r).map(|(x, y)| x * y).sum();
        l.iter_mut().for_each(|w| *w /= unit);
        (r, l)
    };
    match (corner.kind, corner.split, n) {
        (Kind::Crease, _, 1) => vec![(linear(0, 1.0, -1.0), difference(0, Some(1), 0.5))],
        (Kind::Crease, SplitKind::Triangles, 2) => vec![(linear(0, 1.0, 0.0), difference(0, Some(2), 0.5))],
        (Kind::Corner, SplitKind::Triangles, 2) => {
            vec![(linear(0, 1.0, 1.0), difference(0, None, 1.0)), (linear(0, 0.0, 1.0), difference(2, None, 1.0))]
        }
        (Kind::Dart, SplitKind::Quads, 4) | (Kind::Dart, SplitKind::Triangles, 6) => {
            let (s, c) = angle(corner).sin_cos();
            // Along the dart edge and across it.
            let odd = smooth_direction(corner, 0.25 * f64::from(n), step.points);
            let even = even.expect("a dart has an even mode").over(step);
            vec![paired(linear(0, 1.0, c), even), paired(linear(0, 0.0, s), odd)]
        }
        _ => Vec::new(),
    }
}

/// True where there are [`linear_modes`].
pub(crate) fn has_linear_modes(corner: Corner) -> bool {
    match (corner.kind, corner.split) {
        (Kind::Crease, SplitKind::Quads) => corner.n == 1,
        (Kind::Crease, SplitKind::Triangles) => corner.n <= 2,
        (Kind::Corner, SplitKind::Triangles) => corner.n == 2,
        (Kind::Dart, SplitKind::Quads) => corner.n == 4,
        (Kind::Dart, SplitKind::Triangles) => corner.n == 6,
        _ => false,
    }
}

/// Direction of spoke `j` in the parameters of face `i`, continued as in the regular grid.
fn spoke_direction(corner: Corner, j: u32) -> [f64; 2] {
    const QUADS: [[f64; 2]; 4] = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    const TRIANGLES: [[f64; 2]; 6] = [[1.0, 0.0], [0.0, 1.0], [-1.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, -1.0]];
    match corner.split {
        SplitKind::Quads => QUADS[((j + 4 - corner.i) % 4) as usize],
        SplitKind::Triangles => TRIANGLES[((j + 6 - corner.i) % 6) as usize],
    }
}

/// The canonical points' places in the parameters of face `i`, continued as in the regular grid.
fn grid_coordinates(corner: Corner) -> Vec<[f64; 2]> {
    let mut grid = vec![[0.0, 0.0]];
    for j in 0..corner.n {
        let (p, q) = (spoke_direction(corner, j), spoke_direction(corner, j + 1));
        grid.push(p);
        grid.extend((corner.split == SplitKind::Quads).then_some([p[0] + q[0], p[1] + q[1]]));
    }
    if !corner.kind.is_closed() {
        grid.push(spoke_direction(corner, corner.n));
    }
    let [sharp_u, sharp_v] = [corner.i == 0, corner.i + 1 == corner.n];
    grid.extend((!sharp_u).then_some([2.0, -1.0]));
    match corner.split {
        SplitKind::Quads => grid.extend([[2.0, 0.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0]]),
        SplitKind::Triangles => grid.extend([[2.0, 0.0], [1.0, 1.0], [0.0, 2.0]]),
    }
    grid.extend((!sharp_v).then_some([-1.0, 2.0]));
    grid
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners() -> impl Iterator<Item = Corner> {
        let kinds = [Kind::Smooth, Kind::Dart, Kind::Crease, Kind::Corner, Kind::Pinned];
        let pairs = [SplitKind::Quads, SplitKind::Triangles].into_iter().flat_map(move |s| kinds.map(|kind| (s, kind)));
        pairs.flat_map(|(split, kind)| {
            let least = if kind.is_closed() { 3 } else { 1 };
            (least..=30).map(move |n| Corner { split, kind, n, i: if kind == Kind::Smooth { 0 } else { n / 2 } })
        })
    }

    fn even(corner: Corner, step: &LocalStep) -> Option<EvenMode> {
        (corner.kind == Kind::Dart).then(|| EvenMode::new(corner, step, &limit_mask(corner, step)))
    }

    fn residual(row: &[f64], eigenvalue: f64, step: &LocalStep) -> f64 {
        let errors = times(row, step).into_iter().zip(row).map(|(x, y)| (x - eigenvalue * y).abs());
        errors.fold(0.0, |most, x| if x > most || x.is_nan() { x } else { most })
    }

    #[test]
    fn limit_masks_are_left_eigenvectors() {
        for corner in corners() {
            let step = LocalStep::new(corner);
            let mask = limit_mask(corner, &step);
            // Weights below 1, each a sum of up to K products.
            assert!(residual(&mask, 1.0, &step) < step.points as f64 * f64::EPSILON, "{corner:?}");
            assert!((mask.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn plane_vectors_are_left_eigenvectors() {
        for corner in corners().filter(|c| c.kind != Kind::Pinned) {
            let step = LocalStep::new(corner);
            let even = even(corner, &step);
            let tangents = Tangents::new(corner, &step, even.as_ref());
            for row in tangents.plane.unwrap() {
                let size = row.iter().map(|w| w * w).sum::<f64>();
                let eigenvalue = times(&row, &step).iter().zip(&row).map(|(x, y)| x * y).sum::<f64>() / size;
                let error = residual(&row, eigenvalue, &step) / size.sqrt();
                assert!(error < 1e-13, "{corner:?}: {error:e}");
            }
        }
    }

    #[test]
    fn what_has_linear_modes_is_known_without_making_them() {
        for corner in corners() {
            let step = LocalStep::new(corner);
            let modes = linear_modes(corner, &step, even(corner, &step).as_ref());
            assert_eq!(has_linear_modes(corner), !modes.is_empty(), "{corner:?}");
        }
    }

    #[test]
    fn linear_modes_are_eigenvectors_of_one_half() {
        let (quads, triangles) = (SplitKind::Quads, SplitKind::Triangles);
        let cases = [
            (quads, Kind::Crease, 1, 1),
            (quads, Kind::Dart, 4, 2),
            (triangles, Kind::Crease, 1, 1),
            (triangles, Kind::Crease, 2, 1),
            (triangles, Kind::Corner, 2, 2),
            (triangles, Kind::Dart, 6, 2),
        ];
        for (split, kind, n, count) in cases {
            for i in 0..n {
                let corner = Corner { split, kind, n, i };
                let step = LocalStep::new(corner);
                let even = even(corner, &step);
                let modes = linear_modes(corner, &step, even.as_ref());
                assert_eq!(modes.len(), count);
                for (r, l) in &modes {
                    assert!(residual(l, 0.5, &step) < 1e-15, "{corner:?}");
                    for k in 0..step.points {
                        let image: f64 = step.row(k).map(|(c, w)| w * r[c as usize]).sum();
                        assert!((image - 0.5 * r[k]).abs() < 1e-15, "{corner:?} point {k}");
                    }
                }
                for (a, (r, _)) in modes.iter().enumerate() {
                    for (b, (_, l)) in modes.iter().enumerate() {
                        let dot: f64 = l.iter().zip(r).map(|(x, y)| x * y).sum();
                        assert!((dot - f64::from(u8::from(a == b))).abs() < 1e-14, "{corner:?}");
                    }
                }
            }
        }
    }
}
