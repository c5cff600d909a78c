//! The leading eigenvalues of subdivision at a smooth interior vertex: how fast the surface, and fields over it, approach
//! their limits there.

use super::corner::{Corner, Kind};
use super::local_step::LocalStep;
use super::tangent::wave_eigenvalue;
use crate::scheme::{Scheme, SplitKind};
use std::f64::consts::PI;

/// Eigenvalues of the local step on the ring of a smooth interior vertex, below the 1 of constants. From level to level
/// distances shrink by λ; what the surface departs from its tangent plane shrinks by μ.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Spectrum {
    /// The subdominant eigenvalue, of the two waves of frequency 1.
    pub lambda: f64,
    /// The largest one below.
    pub mu: f64,
    /// The largest one of the modes that are the same in all directions.
    pub mu_round: f64,
}

impl Spectrum {
    /// At a vertex of `valence` faces; none below 3, and under bilinear subdivision, which has no smooth vertices.
    pub fn of_interior(scheme: Scheme, valence: u32) -> Option<Self> {
        if valence < 3 || scheme == Scheme::Bilinear {
            return None;
        }
        let split = scheme.split();
        // The smaller eigenvalue of a Catmull-Clark wave; the two multiply to 1/16.
        let smaller = |wave: f64| if split == SplitKind::Quads { 1.0 / 16.0 / wave } else { 0.0 };
        let theta = 2.0 * PI / f64::from(valence);
        let lambda = wave_eigenvalue(split, theta);
        let second = if valence > 3 { wave_eigenvalue(split, 2.0 * theta) } else { 0.0 };
        let mu_round = round_mode(split, valence);
        Some(Self { lambda, mu: second.max(mu_round).max(smaller(lambda)), mu_round })
    }

    /// `μ^(p+1) / λ²`: the bound on how fast the gradient of a blended normal grows in theorem 1 of Bakker, Barendrecht,
    /// Kosinka 2018, for the power p. The true factor is [`gradient_ratio`](Self::gradient_ratio), whatever p is.
    pub fn theorem_ratio(self, p: f64) -> f64 {
        self.mu.powf(p + 1.0) / (self.lambda * self.lambda)
    }

    /// `(μ/λ)²`: by what the part of a blended normal's gradient that is due to the limit normal shrinks per level, where
    /// `1 - b` shrinks by μ. As `1 - b^p = p (1 - b) + …`, this holds for every p; and it is below 1 at every valence.
    /// Beyond the ring there are modes of 1/8, which take the place of μ at valence 3 of Loop, where it is less.
    pub fn gradient_ratio(self) -> f64 {
        (self.mu.max(0.125) / self.lambda).powi(2)
    }
}

/// The largest eigenvalue below 1 of the modes with one value at the vertex, one at all edge neighbours and one at all
/// diagonals: from the local step itself, taken on such rings.
fn round_mode(split: SplitKind, n: u32) -> f64 {
    let step = LocalStep::new(Corner { split, kind: Kind::Smooth, n, i: 0 });
    let kinds = if split == SplitKind::Quads { 3 } else { 2 };
    // Canonical points: the vertex, then edge neighbours and diagonals in turn.
    let kind = |point: usize| if point == 0 { 0 } else { 1 + (point - 1) % (kinds - 1) };
    let mut m = [[0.0; 3]; 3];
    for row in 0..kinds {
        step.row(row).for_each(|(c, w)| m[row][kind(c as usize)] += w);
    }
    // Without the eigenvalue 1: sum and product of the other two (of the other one, the product being 0).
    let sum = m[0][0] + m[1][1] + m[2][2] - 1.0;
    let minor = |i: usize, j: usize| m[1][i] * m[2][j] - m[1][j] * m[2][i];
    let product = m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1);
    0.5 * (sum + (sum * sum - 4.0 * product).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_modes_have_their_published_eigenvalues() {
        for n in 3..=50 {
            let x = f64::from(n);
            // Stam 1998 for Catmull-Clark; Loop 1987.
            let quads = (3.0 * x - 7.0 + (5.0 * x * x - 30.0 * x + 49.0).sqrt()) / (8.0 * x);
            let triangles = (0.375 + 0.25 * (2.0 * PI / x).cos()).powi(2);
            assert!((round_mode(SplitKind::Quads, n) - quads).abs() < 1e-14, "valence {n}");
            assert!((round_mode(SplitKind::Triangles, n) - triangles).abs() < 1e-14, "valence {n}");
        }
    }

    #[test]
    fn every_gradient_ratio_is_below_one() {
        for scheme in [Scheme::CatmullClark, Scheme::Loop] {
            for n in 3..=200 {
                assert!(Spectrum::of_interior(scheme, n).unwrap().gradient_ratio() < 1.0, "{scheme:?} valence {n}");
            }
        }
        assert_eq!(Spectrum::of_interior(Scheme::Bilinear, 5), None);
    }

    #[test]
    #[cfg_attr(not(shared_data), ignore = "needs the shared golden data")]
    fn ratios_are_those_of_the_reference_table() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/golden/eigen_ratio_table.json");
        let table: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let rows = table.as_array().unwrap();
        assert!(rows.len() >= 48);
        for row in rows {
            let n = row["n"].as_u64().unwrap() as u32;
            for (scheme, key) in [(Scheme::CatmullClark, "cc"), (Scheme::Loop, "loop")] {
                let ours = Spectrum::of_interior(scheme, n).unwrap();
                let theirs = |name: &str| row[key][name].as_f64().unwrap();
                let pairs = [
                    (ours.lambda, theirs("lam")),
                    (ours.mu, theirs("mu")),
                    (ours.mu_round, theirs("mu0")),
                    (ours.theorem_ratio(0.5), theirs("p0.5")),
                    (ours.theorem_ratio(1.0), theirs("p1.0")),
                    (ours.theorem_ratio(2.0), theirs("p2.0")),
                ];
                // The table's eigenvalues are rounded to f64.
                pairs.iter().for_each(|(a, b)| assert!((a - b).abs() < 1e-13, "{key} valence {n}: {a} {b}"));
            }
        }
    }
}
