//! A plan's corner 0 may be any corner of a face, and a special vertex may sit at any corner of a plan: parameters are
//! turned on the way down, derivatives on the way up.

use super::special::PointWeights;
use crate::scheme::SplitKind;

/// Parameters after turning the face so that corner `turn` comes first.
#[inline(always)]
pub(super) fn turned(split: SplitKind, u: f64, v: f64, turn: u8) -> (f64, f64) {
    match split {
        SplitKind::Quads => turned_quad(u, v, turn),
        SplitKind::Triangles => turned_triangle(u, v, turn),
    }
}

/// The control points of a bicubic patch in the order of the face's own parameters, from those in the order of parameters
/// that are [`turned`].
#[inline(always)]
pub(super) fn turned_points(points: &[u8; 16], turn: u8) -> [u8; 16] {
    let mut out = *points;
    for k in 0..16 {
        let (i, j) = (k % 4, k / 4);
        let (a, b) = match turn {
            0 => (i, j),
            1 => (j, 3 - i),
            2 => (3 - i, 3 - j),
            _ => (3 - j, i),
        };
        out[k] = points[4 * b + a];
    }
    out
}

/// The one near zero at that corner is exact.
#[inline(always)]
fn turned_quad(u: f64, v: f64, turn: u8) -> (f64, f64) {
    // (u, v), (v, 1 - u), (1 - u, 1 - v), (1 - v, u), as choices rather than branches.
    let (a, b) = if turn & 1 == 0 { (u, v) } else { (v, u) };
    (if turn >= 2 { 1.0 - a } else { a }, if turn == 1 || turn == 2 { 1.0 - b } else { b })
}

/// Derivatives in turned parameters to derivatives in the face's own.
pub(super) fn turn_back_quad(mut w: PointWeights, turn: u8) -> PointWeights {
    let negate = |row: &mut Vec<f64>| row.iter_mut().for_each(|x| *x = -*x);
    if turn == 0 || w.rows[1].is_empty() {
        return w;
    }
    match turn {
        1 => {
            // (a, b) = (v, 1 - u): du = -db, dv = da.
            w.rows.swap(1, 2);
            negate(&mut w.rows[1]);
        }
        2 => {
            negate(&mut w.rows[1]);
            negate(&mut w.rows[2]);
        }
        _ => {
            // (a, b) = (1 - v, u): du = db, dv = -da.
            w.rows.swap(1, 2);
            negate(&mut w.rows[2]);
        }
    }
    if turn != 2 {
        w.rows.swap(3, 5);
        negate(&mut w.rows[4]);
    }
    w
}

/// The same for barycentric parameters `u`, `v`. The order of the subtractions keeps what is small next to the corner.
#[inline(always)]
fn turned_triangle(u: f64, v: f64, turn: u8) -> (f64, f64) {
    match turn {
        0 => (u, v),
        1 => (v, (1.0 - u) - v),
        _ => ((1.0 - v) - u, u),
    }
}

/// The same for triangles.
pub(super) fn turn_back_triangle(mut w: PointWeights, turn: u8) -> PointWeights {
    if turn == 0 || w.rows[1].is_empty() {
        return w;
    }
    let combine = |terms: &[(f64, &[f64])]| -> Vec<f64> {
        (0..terms[0].1.len()).map(|k| terms.iter().map(|(f, row)| f * row[k]).sum()).collect()
    };
    let [_, a, b, aa, ab, bb] = &w.rows;
    let bend = || combine(&[(1.0, aa), (-2.0, ab), (1.0, bb)]);
    let second = !aa.is_empty();
    let rows = if turn == 1 {
        // (a, b) = (v, 1 - u - v): du = -db, dv = da - db.
        let second = second.then(|| [bb.clone(), combine(&[(1.0, bb), (-1.0, ab)]), bend()]);
        (combine(&[(-1.0, b)]), combine(&[(1.0, a), (-1.0, b)]), second)
    } else {
        // (a, b) = (1 - u - v, u): du = db - da, dv = -da.
        let second = second.then(|| [bend(), combine(&[(1.0, aa), (-1.0, ab)]), aa.clone()]);
        (combine(&[(1.0, b), (-1.0, a)]), combine(&[(-1.0, a)]), second)
    };
    (w.rows[1], w.rows[2]) = (rows.0, rows.1);
    if let Some([uu, uv, vv]) = rows.2 {
        (w.rows[3], w.rows[4], w.rows[5]) = (uu, uv, vv);
    }
    w
}
