//! Weighted averages of directions as points of the unit sphere (Buss, Fillmore 2001, algorithm A1): the point q at which
//! the weighted sum of the logarithms vanishes, `Σ w_i log_q(p_i) = 0`, where `log_q(p)` is the tangent vector at q that
//! leads to p along the great circle, as long as the arc.

use super::vertex_normals::unit;
use crate::limit::child_vertex;
use crate::scheme::Scheme;
use crate::topology::Topology;
use rayon::prelude::*;

/// Length of a step at which the iteration ends: rounding of sums of unit vectors.
const CONVERGED: f64 = 1e-15;
/// The iteration converges linearly, at a rate that falls with the spread of the points; within a hemisphere 10 to 20
/// steps reach rounding. Points spread wider end here, with the best found.
const MOST_STEPS: usize = 64;

/// The normals of the next level of `t`, every mask taken as a spherical average.
pub(super) fn refine(t: &Topology, scheme: Scheme, normals: &[[f64; 3]], count: usize) -> Vec<[f64; 3]> {
    (0..count as u32)
        .into_par_iter()
        .map_init(Vec::new, |terms, v| {
            terms.clear();
            child_vertex(t, scheme, v, &mut |parent, w| terms.push((w, normals[parent as usize])));
            average(terms)
        })
        .collect()
}

/// The spherical average of unit vectors with weights that sum to one; vectors of length zero count as absent. Where the
/// linear average vanishes, so does the result.
pub(super) fn average(terms: &[(f64, [f64; 3])]) -> [f64; 3] {
    let combine = |of: &dyn Fn([f64; 3]) -> [f64; 3]| {
        terms.iter().fold([0.0; 3], |s, &(w, p)| {
            let x = of(p);
            std::array::from_fn(|i| s[i] + w * x[i])
        })
    };
    let mut q = unit(combine(&|p| p));
    if q == [0.0; 3] {
        return q;
    }
    for _ in 0..MOST_STEPS {
        let step = combine(&|p| log(q, p));
        let length = dot(step, step).sqrt();
        if length <= CONVERGED {
            break;
        }
        let (s, c) = length.sin_cos();
        q = unit(std::array::from_fn(|i| c * q[i] + s / length * step[i]));
    }
    q
}

/// The tangent vector at `q` towards `p`; zero for the opposite point, which lies in every direction.
fn log(q: [f64; 3], p: [f64; 3]) -> [f64; 3] {
    let cosine = dot(q, p);
    let across: [f64; 3] = std::array::from_fn(|i| p[i] - cosine * q[i]);
    let sine = dot(across, across).sqrt();
    if sine == 0.0 {
        return [0.0; 3];
    }
    let angle = sine.atan2(cosine);
    across.map(|x| angle / sine * x)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_circle(angle: f64) -> [f64; 3] {
        [angle.cos(), angle.sin(), 0.0]
    }

    #[test]
    fn on_a_great_circle_the_average_is_that_of_the_angles() {
        for weights in [[0.5, 0.5, 0.0], [0.2, 0.3, 0.5], [0.75, 0.125, 0.125]] {
            let angles = [0.1, 1.4, -0.9];
            let terms: Vec<_> = weights.iter().zip(angles).map(|(&w, a)| (w, on_circle(a))).collect();
            let mean: f64 = weights.iter().zip(angles).map(|(w, a)| w * a).sum();
            let (got, want) = (average(&terms), on_circle(mean));
            // A few roundings per term and step.
            (0..3).for_each(|i| assert!((got[i] - want[i]).abs() < 1e-14, "{got:?} {want:?}"));
        }
    }

    #[test]
    fn turning_all_points_turns_the_average() {
        let points = [[0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [-0.48, 0.36, 0.8], [0.0, 0.0, 1.0]];
        let weights = [0.1, 0.4, 0.3, 0.2];
        let turn = |p: [f64; 3]| [p[2], p[0], p[1]];
        let plain = average(&std::array::from_fn::<_, 4, _>(|i| (weights[i], points[i])));
        let turned = average(&std::array::from_fn::<_, 4, _>(|i| (weights[i], turn(points[i]))));
        (0..3).for_each(|i| assert!((turn(plain)[i] - turned[i]).abs() < 1e-14));
    }

    #[test]
    fn opposite_points_have_no_average() {
        assert_eq!(average(&[(0.5, [0.0, 0.0, 1.0]), (0.5, [0.0, 0.0, -1.0])]), [0.0; 3]);
    }
}
