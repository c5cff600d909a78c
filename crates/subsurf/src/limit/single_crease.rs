//! The patch along one semi-sharp crease in closed form (Nießner, Loop, Greiner 2012), integer and fractional
//! sharpness, at a cost that does not depend on the sharpness.
//!
//! Across the crease the surface is a curve with control points `P0 P1 P2 P3`, parameter `t` in `[0, 1]`, and the
//! crease at `t = 1`, at `P2`:
//!
//! ```text
//!   P0 ──── P1 ════════ P2 ──── P3
//!          t = 0       t = 1 (crease)
//! ```
//!
//! The paper's `M_s = R^-s R_p^s` has entries of size `4^s` that cancel. Here the same curve is written in powers of the
//! sharp step `R_p` alone, relative to the crease point, with the parameter of the level `k` at which it is smooth:
//! with `q = 2^-k` and `D_j = P_j - P2`,
//!
//! ```text
//!   R_p^k P - P2 = (2 q D1 + q³ (D0 - 2 D1),  q D1,  0,  q D3),    t' = 1 - 2^k d
//! ```
//!
//! which is accurate to rounding for every sharpness. The paper prints `floor` twice in its `P̂_s`; the second is `ceil`.

use super::bspline::cubic;

/// Weights of position, first and second derivative (with respect to `t`) over `P0..P3`, at distance `d = 1 - t` from
/// the crease, for sharpness `s` in `(0, 10)`. Taking the distance keeps its precision next to the crease.
///
/// Three segments: infinitely sharp up to `1 - 2^-floor(s)`, a transition up to `1 - 2^-ceil(s)`, smooth beyond.
pub(crate) fn curve(d: f64, s: f64) -> [[f64; 4]; 3] {
    let (k, points) = piece(s, piece_at(d, s));
    let mut weights = segment(d, k, &points);
    weights[0][2] += 1.0;
    weights
}

/// Number of the segment at distance `d`: 0, 1, 2 towards the crease.
pub(crate) fn piece_at(d: f64, s: f64) -> usize {
    joints(s).iter().take_while(|&&joint| d < joint).count()
}

/// Distances at which segments meet.
pub(crate) fn joints(s: f64) -> [f64; 2] {
    [(-s.floor()).exp2(), (-s.ceil()).exp2()]
}

/// The level `k` of a segment, and its control points there less `P2`, in which the parameter is `1 - 2^k d`.
pub(crate) fn piece(s: f64, number: usize) -> (i32, Points) {
    let (low, high) = (s.floor(), s.ceil());
    let w = s - low;
    let at_low = sharp_steps(low as i32);
    match number {
        0 => (0, compose(&infinite(), &sharp_steps(0))),
        1 => (low as i32, blend(1.0 - w, &at_low, w, &compose(&infinite(), &at_low))),
        _ if low == high => (high as i32, at_low),
        _ => {
            let smooth = compose(&smooth_step(), &at_low);
            (high as i32, blend(1.0 - w, &smooth, w, &sharp_steps(high as i32)))
        }
    }
}

/// Four control points less `P2` as combinations of the original four. What holds for points holds for these: rows of all
/// steps sum to one.
pub(crate) type Points = [[f64; 4]; 4];

/// Evaluates the curve with control points `points`, which are those of level `k` next to the crease.
fn segment(d: f64, k: i32, points: &Points) -> [[f64; 4]; 3] {
    let scale = 2f64.powi(k);
    let basis = cubic(1.0 - scale * d);
    let mut weights = [[0.0; 4]; 3];
    for (order, row) in weights.iter_mut().enumerate() {
        let factor = scale.powi(order as i32);
        for c in 0..4 {
            row[c] = factor * (0..4).map(|j| basis[order][j] * points[j][c]).sum::<f64>();
        }
    }
    weights
}

/// `R_p^k P - P2`: after `k` sharp steps towards the crease.
fn sharp_steps(k: i32) -> Points {
    let q = 2f64.powi(-k);
    let q3 = q * q * q;
    [[q3, 2.0 * q - 2.0 * q3, q3 - 2.0 * q, 0.0], [0.0, q, -q, 0.0], [0.0; 4], [0.0, 0.0, -q, q]]
}

/// `R`: one smooth step, right half.
fn smooth_step() -> Points {
    [[0.125, 0.75, 0.125, 0.0], [0.0, 0.5, 0.5, 0.0], [0.0, 0.125, 0.75, 0.125], [0.0, 0.0, 0.5, 0.5]]
}

/// Infinitely sharp at the third point: the fourth is twice that less the second.
fn infinite() -> Points {
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 2.0, 0.0]]
}

fn compose(a: &Points, b: &Points) -> Points {
    let mut c = [[0.0; 4]; 4];
    for i in 0..4 {
        for j in 0..4 {
            c[i][j] = (0..4).map(|k| a[i][k] * b[k][j]).sum();
        }
    }
    c
}

fn blend(wa: f64, a: &Points, wb: f64, b: &Points) -> Points {
    let mut c = *a;
    for i in 0..4 {
        for j in 0..4 {
            c[i][j] = wa * a[i][j] + wb * b[i][j];
        }
    }
    c
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One sharp step, right half.
    fn sharp_step() -> Points {
        [[0.125, 0.75, 0.125, 0.0], [0.0, 0.5, 0.5, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.5, 0.5]]
    }

    /// Subdivides the curve explicitly: sharp steps, one blended step, then a smooth spline.
    fn refined(t: f64, s: f64) -> [[f64; 4]; 3] {
        let mut points: Points = [[0.0; 4]; 4];
        (0..4).for_each(|i| points[i][i] = 1.0);
        let (mut t, mut s, mut level) = (t, s, 0);
        let left = |p: &Points| {
            compose(
                &[[0.5, 0.5, 0.0, 0.0], [0.125, 0.75, 0.125, 0.0], [0.0, 0.5, 0.5, 0.0], [0.0, 0.125, 0.75, 0.125]],
                p,
            )
        };
        while s > 0.0 {
            let w = s.min(1.0);
            if t < 0.5 {
                // The left half's last control point feels the crease: the step at P2 is w sharp, 1 - w smooth.
                let mut half = left(&points);
                let smooth = half[3];
                (0..4).for_each(|c| half[3][c] = w * points[2][c] + (1.0 - w) * smooth[c]);
                points = half;
                t *= 2.0;
                s = 0.0;
            } else {
                points = blend(1.0 - w, &compose(&smooth_step(), &points), w, &compose(&sharp_step(), &points));
                t = 2.0 * t - 1.0;
                s = (s - 1.0).max(0.0);
            }
            level += 1;
        }
        let basis = cubic(t);
        let mut weights = [[0.0; 4]; 3];
        for order in 0..3 {
            for c in 0..4 {
                weights[order][c] =
                    2f64.powi(level * order as i32) * (0..4).map(|j| basis[order][j] * points[j][c]).sum::<f64>();
            }
        }
        weights
    }

    #[test]
    fn the_closed_form_is_the_limit_of_refinement() {
        for s in [0.25, 0.5, 1.0, 1.7, 2.0, 3.3, 5.0, 7.9, 9.0, 9.5] {
            for i in 0..=200 {
                let t = f64::from(i) / 200.0;
                let (ours, theirs) = (curve(1.0 - t, s), refined(t, s));
                for order in 0..3 {
                    let size = theirs[order].iter().fold(1.0, |m: f64, w| m.max(w.abs()));
                    for c in 0..4 {
                        let error = (ours[order][c] - theirs[order][c]).abs() / size;
                        // The second derivative is continuous, but its roundings differ by 4^level at joints.
                        assert!(error < 1e-10, "s {s} t {t} order {order}: {ours:?} {theirs:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn weights_stay_small_for_every_sharpness() {
        // The paper's M_s has entries beyond 1e5 at s = 9.5.
        for i in 0..=1000 {
            let weights = curve(f64::from(i) / 1024.0, 9.5);
            assert!(weights[0].iter().all(|w| w.abs() <= 1.0 + 1e-15));
            assert!((weights[0].iter().sum::<f64>() - 1.0).abs() < 1e-15);
        }
    }
}
