//! A cubic curve that ends at a crease of sharpness 0, 1, 1.7 and 2, in its segments: figure 1 of Nießner, Loop and
//! Greiner 2012.
//!
//! The curve is the section of a surface that is constant in the other direction, with the crease along its third row of
//! control points: it comes from the plans, like everything else.

use super::chart::{Axis, COLORS, Chart, Corner, Curve, GREY, Look, Note, svg};
use super::table::Table;
use super::{Drawing, Picture, Settings};
use crate::failure::Failure;
use subsurf::{Crease, Location, PatchTable, Scheme, Tags, shapes};

const SHARPNESSES: [f64; 4] = [0.0, 1.0, 1.7, 2.0];
/// The control polygon; the crease runs through the third point.
const POLYGON: [[f64; 2]; 4] = [[0.0, 0.1], [0.3, 1.2], [1.95, 1.45], [2.3, 0.0]];
/// Rows of faces across the curve: enough that the ends of the crease are out of sight.
const ROWS: u32 = 5;
/// Samples of the segment's parameter; a multiple of 4, so that segments end at samples.
const STEPS: u32 = 128;

/// The points of the curve at t = i / STEPS.
pub fn curve(sharpness: f64) -> Result<Vec<[f64; 2]>, Failure> {
    let at = |column: u32, row: u32| row * 4 + column;
    let creases = (0..ROWS).map(|row| Crease::new(at(2, row), at(2, row + 1), sharpness)).collect();
    let strip = shapes::grid(3, ROWS).tagged("strip with a crease", Tags { creases, ..Tags::default() });
    let fail = |source| Failure::Mesh { name: strip.name.clone(), source };
    let table = PatchTable::new(&strip.mesh, Scheme::CatmullClark).map_err(fail)?;
    let points: Vec<[f64; 2]> = (0..=ROWS).flat_map(|_| POLYGON).collect();
    let surface = table.surface(&points);
    let face = ROWS / 2 * 3 + 1;
    Ok((0..=STEPS)
        .filter_map(|i| surface.position(Location::new(face, f64::from(i) / f64::from(STEPS), 0.5)))
        .collect())
}

/// The parameters at which segments end.
pub fn ends(sharpness: f64) -> Vec<f64> {
    let mut ends: Vec<f64> =
        [sharpness.floor(), sharpness.ceil()].iter().map(|s| 1.0 - (-s).exp2()).filter(|&t| t > 0.0).collect();
    ends.push(1.0);
    ends.dedup();
    ends
}

pub fn draw(_: &Settings<'_>) -> Result<Drawing, Failure> {
    let mut table = Table::new(["sharpness", "t", "segment", "x", "y"]);
    let mut charts = Vec::new();
    for sharpness in SHARPNESSES {
        let points = curve(sharpness)?;
        let ends = ends(sharpness);
        let mut curves = vec![Curve { label: None, color: GREY, look: Look::Marked(1), points: POLYGON.to_vec() }];
        let mut first = 0;
        let mut joints = Vec::new();
        for (segment, &end) in ends.iter().enumerate() {
            let last = (end * f64::from(STEPS)).round() as usize;
            let run = points[first..=last].to_vec();
            joints.push(run[run.len() - 1]);
            curves.push(Curve { label: None, color: COLORS[segment], look: Look::Line(3), points: run });
            first = last;
        }
        joints.insert(0, points[0]);
        curves.push(Curve { label: None, color: GREY, look: Look::Dots(4), points: joints });
        for (i, p) in points.iter().enumerate() {
            let t = i as f64 / f64::from(STEPS);
            let segment = ends.iter().take_while(|&&end| t > end).count();
            table.push(vec![sharpness.into(), t.into(), segment.into(), p[0].into(), p[1].into()]);
        }
        charts.push(Chart {
            title: format!("sharpness {sharpness}"),
            x: Axis::linear("", -0.15, 2.5, 0),
            y: Axis::linear("", -0.15, 1.7, 0),
            curves,
            key: None::<Corner>,
            notes: POLYGON
                .iter()
                .zip(["P₀", "P₁", "P₂", "P₃"])
                .zip([[0.07, 0.02], [-0.08, 0.2], [0.1, 0.14], [-0.26, 0.06]])
                .map(|((p, text), [dx, dy])| Note { at: [p[0] + dx, p[1] + dy], text: text.to_owned(), color: GREY })
                .collect(),
        });
    }
    Ok(Drawing { picture: Picture::Svg(svg(&charts, [1120, 260])), numbers: vec![("csv", table.csv())] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_end_where_the_paper_ends_them() {
        assert_eq!(ends(0.0), [1.0]);
        assert_eq!(ends(1.0), [0.5, 1.0]);
        assert_eq!(ends(1.7), [0.5, 0.75, 1.0]);
        assert_eq!(ends(2.0), [0.75, 1.0]);
    }
}
