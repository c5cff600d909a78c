//! Blend weights along a line through an extraordinary vertex, made regular: figure 3 of Bakker, Barendrecht and Kosinka
//! 2018.
//!
//! On a regular grid whose values are constant in one direction the surface is a cubic B-spline curve in the other, so
//! that the curves here come from the plans that everything else does.

use super::chart::{Axis, COLORS, Chart, Corner, Curve, GREY, Look, svg};
use super::table::Table;
use super::{Drawing, Picture, Settings};
use crate::failure::Failure;
use subsurf::{Location, PatchTable, Scheme, shapes};

/// Faces of the grid along the line, and across it. The vertex is in the middle of the first.
const LONG: u32 = 10;
const WIDE: u32 = 5;
const MIDDLE: usize = LONG as usize / 2;
const STEPS: u32 = 32;
const POWERS: [f64; 3] = [0.5, 1.0, 2.0];

/// The curve over a grid whose columns have these values: pairs of distance from the middle, in faces, and limit.
fn curve(values: &[f64]) -> Result<Vec<[f64; 2]>, Failure> {
    let grid = shapes::grid(LONG, WIDE).mesh;
    let fail = |source| Failure::Mesh { name: "grid".to_owned(), source };
    let table = PatchTable::new(&grid, Scheme::CatmullClark).map_err(fail)?;
    let points: Vec<[f64; 1]> = (0..=WIDE).flat_map(|_| values.iter().map(|&x| [x])).collect();
    let surface = table.surface(&points);
    let first = WIDE / 2 * LONG;
    let at = |i: u32| {
        let face = (i / STEPS).min(LONG - 1);
        let u = f64::from(i - face * STEPS) / f64::from(STEPS);
        let value = surface.position(Location::new(first + face, u, 0.5))?[0];
        Some([f64::from(i) / f64::from(STEPS) - MIDDLE as f64, value])
    };
    Ok((0..=LONG * STEPS).filter_map(at).collect())
}

/// Weights of the control points: A3 and A4.
pub fn control_weights() -> Result<[Vec<f64>; 2], Failure> {
    let mut single = vec![0.0; LONG as usize + 1];
    single[MIDDLE] = 1.0;
    // A3: the reciprocal of the vertex's weight in its own limit.
    let own = curve(&single)?[MIDDLE * STEPS as usize][1];
    let third = single.iter().map(|b| b / own).collect();
    let fourth = (0..single.len()).map(|i| if i.abs_diff(MIDDLE) <= 1 { 1.0 } else { 0.0 }).collect();
    Ok([third, fourth])
}

pub fn draw(_: &Settings<'_>) -> Result<Drawing, Failure> {
    let mut table = Table::new(["blend", "distance", "b", "p_half", "p_one", "p_two"]);
    let mut charts = Vec::new();
    for ((word, title), control) in
        [("a3", "A₃: one weight above 1"), ("a4", "A₄: ones on the one-ring")].into_iter().zip(control_weights()?)
    {
        let b = curve(&control)?;
        for &[x, b] in &b {
            // Rounding may leave [0, 1] by an ulp.
            let b = b.clamp(0.0, 1.0);
            let mut row = vec![word.into(), x.into(), b.into()];
            row.extend(POWERS.map(|p| b.powf(p).into()));
            table.push(row);
        }
        let net: Vec<[f64; 2]> = control.iter().enumerate().map(|(i, &w)| [i as f64 - MIDDLE as f64, w]).collect();
        let mut curves =
            vec![Curve { label: Some("control weights".to_owned()), color: GREY, look: Look::Marked(1), points: net }];
        curves.extend(POWERS.into_iter().zip(COLORS).map(|(p, color)| Curve {
            label: Some(format!("bᵖ, p = {p}")),
            color,
            look: Look::Line(3),
            points: b.iter().map(|&[x, b]| [x, b.clamp(0.0, 1.0).powf(p)]).collect(),
        }));
        charts.push(Chart {
            title: title.to_owned(),
            x: Axis::linear("faces from the vertex", -4.0, 4.0, 9),
            y: Axis::linear("weight of the subdivided normal", 0.0, 1.6, 9),
            curves,
            key: Some(Corner::UpperRight),
            notes: Vec::new(),
        });
    }
    Ok(Drawing { picture: Picture::Svg(svg(&charts, [1000, 380])), numbers: vec![("csv", table.csv())] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_blends_are_one_and_flat_in_the_middle_and_end_after_two_and_three_faces() {
        for (control, reach) in control_weights().unwrap().into_iter().zip([2.0, 3.0]) {
            let b = curve(&control).unwrap();
            let middle = MIDDLE * STEPS as usize;
            // Sums of a handful of numbers up to 1.5.
            assert!((b[middle][1] - 1.0).abs() < 1e-15);
            assert!(b.iter().all(|[_, b]| (-1e-15..=1.0 + 1e-15).contains(b)));
            for (left, right) in b[..middle].iter().rev().zip(&b[middle + 1..]) {
                assert!((left[1] - right[1]).abs() < 1e-15, "symmetric");
            }
            assert!(b.iter().all(|[x, b]| (*b > 1e-15) == (x.abs() < reach)), "{reach}");
        }
    }
}
