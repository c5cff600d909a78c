//! Points in double-double, and distances.

use super::Double;

pub type Point = [Double; 3];

pub fn sum(terms: impl Iterator<Item = Point>) -> Point {
    terms.fold([Double::ZERO; 3], plus)
}

pub fn plus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] + b[k])
}

pub fn times(a: Point, w: Double) -> Point {
    a.map(|x| x * w)
}

pub fn over(a: Point, n: usize) -> Point {
    a.map(|x| x / Double::from(n as f64))
}

pub fn mix(a: Point, w: f64, b: Point) -> Point {
    let w = Double::from(w);
    plus(times(a, w), times(b, Double::from(1.0) - w))
}

pub fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    size([0, 1, 2].map(|k| a[k] - b[k]))
}

pub fn size(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The larger of two errors; none is larger than one that is not a number.
pub fn worse(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// Diagonal of the box round the control points.
pub fn diagonal(points: &[[f64; 3]]) -> f64 {
    let bound = |f: fn(f64, f64) -> f64| [0, 1, 2].map(|k| points.iter().map(|p| p[k]).reduce(f).expect("points"));
    apart(bound(f64::max), bound(f64::min))
}
