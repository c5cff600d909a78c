//! Limit position and tangent masks at special vertices, over the canonical points: left eigenvectors of the local step.
//! Closed forms where they exist (the waves `cos jθ`, `sin jθ` round the vertex), iteration for darts.
//!
//! Notation: `d = cos(θ/2)`, `α = √(4+d²) - d`; a wave has eigenvalue `λ = ((√(4+d²) + d)/4)²` and left vector
//! `4 cos(iθ)` on `e_i`, `α cos((i+½)θ)` on `f_i` (or sines). `θ = 2π/n` round an interior vertex, `π/k` in a sector.

use super::corner::{Corner, Kind};
use super::jet::Derivatives;
use super::local_step::LocalStep;
use std::f64::consts::PI;

/// The dominant eigenvalue of the wave with angle `theta` from spoke to spoke.
pub(crate) fn wave_eigenvalue(theta: f64) -> f64 {
    let d = (0.5 * theta).cos();
    let root = 0.25 * ((4.0 + d * d).sqrt() + d);
    root * root
}

fn alpha(theta: f64) -> f64 {
    let d = (0.5 * theta).cos();
    (4.0 + d * d).sqrt() - d
}

/// Canonical index of spoke end `e_j`.
fn e(j: u32) -> usize {
    1 + 2 * j as usize
}

/// Canonical index of diagonal `f_j`.
fn f(j: u32) -> usize {
    2 + 2 * j as usize
}

/// The limit position mask: `l A = l`, summing to one.
pub(crate) fn limit_mask(corner: Corner, step: &LocalStep) -> Vec<f64> {
    let mut l = vec![0.0; step.points];
    let n = f64::from(corner.n);
    match corner.kind {
        Kind::Corner | Kind::Pinned => l[0] = 1.0,
        Kind::Crease => {
            l[0] = 2.0 / 3.0;
            l[e(0)] = 1.0 / 6.0;
            l[e(corner.n)] += 1.0 / 6.0;
        }
        Kind::Smooth => {
            l[0] = n / (n + 5.0);
            for j in 0..corner.n {
                l[e(j)] = 4.0 / (n * (n + 5.0));
                l[f(j)] = 1.0 / (n * (n + 5.0));
            }
        }
        Kind::Dart => {
            // Not the smooth mask: the dart edge breaks the symmetry. The other modes shrink by 0.66 or more a step.
            l[0] = 1.0;
            for _ in 0..200 {
                l = times(&l, step);
                let sum: f64 = l.iter().sum();
                l.iter_mut().for_each(|w| *w /= sum);
            }
        }
    }
    l
}

/// `row · A`.
fn times(row: &[f64], step: &LocalStep) -> Vec<f64> {
    let mut out = vec![0.0; row.len()];
    step.a.left_multiply(row, &mut out);
    out
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
    pub fn new(corner: Corner, step: &LocalStep) -> Self {
        match corner.kind {
            Kind::Smooth => smooth(corner, step),
            Kind::Crease => crease(corner, step),
            Kind::Corner => pinned_sector(corner, step),
            Kind::Pinned => pinned(corner, step),
            Kind::Dart => dart(corner, step),
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

/// `2/(n (4+α²)) Σ 4 cos((j-φ)θ) e_j + α cos((j+½-φ)θ) f_j`: the tangent at angle `φθ` from `e_0`.
fn smooth_direction(n: u32, phi: f64, points: usize) -> Vec<f64> {
    let theta = 2.0 * PI / f64::from(n);
    let a = alpha(theta);
    let scale = 2.0 / (f64::from(n) * (4.0 + a * a));
    let mut mask = vec![0.0; points];
    for j in 0..n {
        mask[e(j)] = scale * 4.0 * ((f64::from(j) - phi) * theta).cos();
        mask[f(j)] = scale * a * ((f64::from(j) + 0.5 - phi) * theta).cos();
    }
    mask
}

fn smooth(corner: Corner, step: &LocalStep) -> Tangents {
    let n = corner.n;
    let towards = |phi: u32| smooth_direction(n, f64::from(phi), step.points);
    let directions = [towards(corner.i), towards(corner.i + 1)];
    // Valence 2: the eigenvalues ±1/4 tie, there is no tangent plane.
    let flat = n >= 3;
    let quarter = f64::from(n) / 4.0;
    let i = f64::from(corner.i);
    let plane = flat.then(|| [i, i + quarter].map(|phi| smooth_direction(n, phi, step.points)));
    Tangents { directions, derivatives: state(wave_eigenvalue(2.0 * PI / f64::from(n))), plane, unique_normal: flat }
}

/// The sine wave's left vector in a sector, from the crease into the surface; on `v`, `e_0`, `e_k` what the boundary
/// curve feeds into it.
fn cross(k: u32, points: usize) -> Vec<f64> {
    let mut y = vec![0.0; points];
    if k == 1 {
        (y[0], y[e(0)], y[e(1)]) = (-2.0, 1.0, 1.0);
        return y;
    }
    let theta = PI / f64::from(k);
    let (a, lambda) = (alpha(theta), wave_eigenvalue(theta));
    for j in 0..k {
        y[f(j)] = a * ((f64::from(j) + 0.5) * theta).sin();
        if j > 0 {
            y[e(j)] = 4.0 * (f64::from(j) * theta).sin();
        }
    }
    let at_end = 0.25 * theta.sin() + 0.25 * a * (0.5 * theta).sin();
    let at_vertex = 1.5 / (0.5 * theta).tan() + a / (4.0 * (0.5 * theta).sin());
    y[0] = (at_vertex * (lambda - 0.5) + at_end) / ((lambda - 1.0) * (lambda - 0.25));
    y[e(0)] = y[0] * (lambda - 0.75) - at_vertex;
    y[e(k)] = y[e(0)];
    let scale = 2.0 / (f64::from(k) * (4.0 + a * a));
    y.iter_mut().for_each(|w| *w *= scale);
    y
}

fn crease(corner: Corner, step: &LocalStep) -> Tangents {
    let k = corner.n;
    let mut along = vec![0.0; step.points];
    (along[e(0)], along[e(k)]) = (0.5, -0.5);
    let cross = cross(k, step.points);
    let towards = |j: u32| -> Vec<f64> {
        match j {
            0 => along.clone(),
            j if j == k => along.iter().map(|w| -w).collect(),
            j => {
                let (s, c) = (PI * f64::from(j) / f64::from(k)).sin_cos();
                along.iter().zip(&cross).map(|(a, x)| c * a + s * x).collect()
            }
        }
    };
    Tangents {
        directions: [towards(corner.i), towards(corner.i + 1)],
        // One face: both sides are tangent to the rounded boundary, and their derivatives are finite.
        derivatives: if k == 1 { Derivatives::Finite } else { Derivatives::Diverges },
        plane: Some([along, cross]),
        // From five faces on a second wave beats the eigenvalue 1/2 of the tangent along the crease.
        unique_normal: k <= 4,
    }
}

fn pinned_sector(corner: Corner, step: &LocalStep) -> Tangents {
    let side = |j: u32| {
        let mut t = vec![0.0; step.points];
        (t[0], t[e(j)]) = (-1.0, 1.0);
        t
    };
    let plane = [side(0), side(corner.n)];
    Tangents {
        directions: [side(corner.i), side(corner.i + 1)],
        derivatives: Derivatives::Diverges,
        plane: Some(plane),
        unique_normal: corner.n <= 2,
    }
}

fn pinned(corner: Corner, step: &LocalStep) -> Tangents {
    let side = |j: u32| {
        let mut t = vec![0.0; step.points];
        t[0] -= 1.0;
        t[e(j % corner.n)] += 1.0;
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

fn dart(corner: Corner, step: &LocalStep) -> Tangents {
    let n = corner.n;
    // Odd about the dart edge: the smooth vertex's sine wave. Even: the leading one, by iteration from e_0 - v.
    let odd = smooth_direction(n, 0.25 * f64::from(n), step.points);
    let (even, even_eigenvalue) = even_mode(corner, step);
    let theta = 2.0 * PI / f64::from(n);
    let odd_eigenvalue = wave_eigenvalue(theta);
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

/// The left vector of the largest eigenvalue below 1 among those symmetric about the dart edge, and the eigenvalue.
fn even_mode(corner: Corner, step: &LocalStep) -> (Vec<f64>, f64) {
    let n = corner.n;
    let limit = limit_mask(corner, step);
    let symmetric = |row: &mut Vec<f64>| {
        for j in 0..n {
            let mean = 0.5 * (row[e(j)] + row[e((n - j) % n)]);
            (row[e(j)], row[e((n - j) % n)]) = (mean, mean);
            let mean = 0.5 * (row[f(j)] + row[f(n - 1 - j)]);
            (row[f(j)], row[f(n - 1 - j)]) = (mean, mean);
        }
        // Take out the constant: left vectors of other eigenvalues sum to zero.
        let sum: f64 = row.iter().sum();
        row.iter_mut().zip(&limit).for_each(|(w, l)| *w -= sum * l);
    };
    // Starts near the smooth vertex's cosine wave.
    let mut row = smooth_direction(n, 0.0, step.points);
    let mut eigenvalue = 0.0;
    for _ in 0..20_000 {
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
        row[e(j)] * (f64::from(j) * theta).cos() + row[f(j)] * alpha(theta) * ((f64::from(j) + 0.5) * theta).cos()
    };
    let unit: f64 = (0..n).map(wave).sum();
    row.iter_mut().for_each(|w| *w /= unit);
    (row, eigenvalue)
}

/// Right and left vectors of the eigenvalue 1/2 whose functions are linear in the parameters: their second derivatives are
/// exactly zero and must not drown those of other modes. On a crease with one face it is the function along the crease;
/// at a dart of valence 4, where all rules keep linear functions, there are two.
pub(crate) fn linear_modes(corner: Corner, step: &LocalStep) -> Vec<(Vec<f64>, Vec<f64>)> {
    let grid = || grid_coordinates(corner);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    match (corner.kind, corner.n) {
        (Kind::Crease, 1) => {
            let mut along = vec![0.0; step.points];
            (along[e(0)], along[e(1)]) = (0.5, -0.5);
            vec![(grid().iter().map(|p| p[0] - p[1]).collect(), along)]
        }
        (Kind::Dart, 4) => {
            // Along the dart edge and perpendicular to it.
            let [x, y] = spoke_direction(corner, 0);
            let along: Vec<f64> = grid().iter().map(|p| x * p[0] + y * p[1]).collect();
            let across: Vec<f64> = grid().iter().map(|p| x * p[1] - y * p[0]).collect();
            let pair = |r: Vec<f64>, mut l: Vec<f64>| {
                let unit = dot(&l, &r);
                l.iter_mut().for_each(|w| *w /= unit);
                (r, l)
            };
            vec![pair(along, even_mode(corner, step).0), pair(across, smooth_direction(4, 1.0, step.points))]
        }
        _ => Vec::new(),
    }
}

/// Direction of spoke `j` where spokes meet at right angles and face `i` is the unit square.
fn spoke_direction(corner: Corner, j: u32) -> [f64; 2] {
    [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][((j + 4 - corner.i) % 4) as usize]
}

/// The canonical points' places in the parameter plane, where spokes meet at right angles.
fn grid_coordinates(corner: Corner) -> Vec<[f64; 2]> {
    let mut grid = vec![[0.0, 0.0]];
    for j in 0..corner.n {
        let (p, q) = (spoke_direction(corner, j), spoke_direction(corner, j + 1));
        grid.extend([p, [p[0] + q[0], p[1] + q[1]]]);
    }
    if !corner.kind.is_closed() {
        grid.push(spoke_direction(corner, corner.n));
    }
    let [sharp_u, sharp_v] = [corner.i == 0, corner.i + 1 == corner.n];
    grid.extend((!sharp_u).then_some([2.0, -1.0]));
    grid.extend([[2.0, 0.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0]]);
    grid.extend((!sharp_v).then_some([-1.0, 2.0]));
    grid
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners() -> impl Iterator<Item = Corner> {
        let kinds = [Kind::Smooth, Kind::Dart, Kind::Crease, Kind::Corner, Kind::Pinned];
        kinds.into_iter().flat_map(|kind| {
            let least = if kind.is_closed() { 3 } else { 1 };
            (least..=30).map(move |n| Corner { kind, n, i: if kind == Kind::Smooth { 0 } else { n / 2 } })
        })
    }

    fn residual(row: &[f64], eigenvalue: f64, step: &LocalStep) -> f64 {
        times(row, step).iter().zip(row).fold(0.0, |m: f64, (x, y)| m.max((x - eigenvalue * y).abs()))
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
            let tangents = Tangents::new(corner, &step);
            for row in tangents.plane.unwrap() {
                let size = row.iter().map(|w| w * w).sum::<f64>();
                let eigenvalue = times(&row, &step).iter().zip(&row).map(|(x, y)| x * y).sum::<f64>() / size;
                let error = residual(&row, eigenvalue, &step) / size.sqrt();
                assert!(error < 1e-13, "{corner:?}: {error:e}");
            }
        }
    }

    #[test]
    fn linear_modes_are_eigenvectors_of_one_half() {
        for (kind, n) in [(Kind::Crease, 1), (Kind::Dart, 4)] {
            for i in 0..n {
                let step = LocalStep::new(Corner { kind, n, i });
                let modes = linear_modes(Corner { kind, n, i }, &step);
                assert_eq!(modes.len(), if kind == Kind::Dart { 2 } else { 1 });
                for (r, l) in modes {
                    assert!(residual(&l, 0.5, &step) < 1e-15);
                    for k in 0..step.points {
                        let image: f64 = step.a.row(k).map(|(c, w)| w * r[c as usize]).sum();
                        assert!((image - 0.5 * r[k]).abs() < 1e-15, "{kind:?} face {i} point {k}");
                    }
                }
            }
        }
    }
}
