//! The document's figures as SVG, in the style of the others: thin axes, a faint grid, colours that the colour-blind can
//! tell apart.

use super::record::Record;
use super::rivals::name::*;
use plotters::coord::Shift;
use plotters::prelude::*;

/// Okabe and Ito, "Color universal design", 2008.
const BLUE: RGBColor = RGBColor(0, 114, 178);
const VERMILION: RGBColor = RGBColor(213, 94, 0);
const ORANGE: RGBColor = RGBColor(230, 159, 0);
const GREY: RGBColor = RGBColor(130, 136, 144);
const INK: RGBColor = RGBColor(40, 46, 54);
const FAINT: RGBColor = RGBColor(228, 231, 235);
const FONT: &str = "sans-serif";
/// Drawings are made this many times as large as they are shown, because their coordinates are whole numbers.
const FINE: u32 = 4;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn<'a> = Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>>;

/// What everyone takes: one panel per kind of work, one row for everyone, one dot per mesh and level.
pub fn overview(records: &[Record]) -> String {
    let of = |section: &str, what: &str| -> Vec<&Record> {
        records.iter().filter(|r| r.section == section && r.what.contains(what)).collect()
    };
    let panels = [
        ("Uniform refinement, cold: ns per output vertex", of("refine", "cold")),
        ("Uniform refinement, warm: ns per output vertex", of("animation", "warm")),
        ("Tessellation with normals, cold: ns per output vertex", of("tessellate", "normals, cold")),
        ("Tessellation with normals, warm: ns per output vertex", of("tessellate", "normals, warm")),
        ("Position and first derivatives, by face: ns per place", of("limit", "by face")),
        ("Position and first derivatives, random order: ns per place", of("limit", "random")),
    ];
    drawing([1000, 960], |root| {
        let areas = root.split_evenly((3, 2));
        areas.iter().zip(&panels).try_for_each(|(area, (title, records))| rows(area, title, records))
    })
}

/// What creases cost, against sharpness: Figure 2 of Nießner, Loop and Greiner 2012.
pub fn creases(records: &[Record]) -> String {
    let panels = [("Build", "build", "ms"), ("Memory", "memory", "MB"), ("A frame", "frame", "ms")];
    drawing([1000, 380], |root| {
        let areas = root.split_evenly((1, 3));
        areas.iter().zip(panels).enumerate().try_for_each(|(i, (area, (title, what, unit)))| {
            let end = format!(": {what}");
            let chosen = records.iter().filter(|r| r.section == "creases" && r.what.ends_with(&end));
            against_sharpness(area, title, unit, &chosen.collect::<Vec<_>>(), i == 2)
        })
    })
}

fn drawing([width, height]: [u32; 2], draw: impl for<'a> FnOnce(&Area<'a>) -> Drawn<'a>) -> String {
    let mut text = String::new();
    let drawn = [FINE * width, FINE * height];
    {
        let root = SVGBackend::with_string(&mut text, (drawn[0], drawn[1])).into_drawing_area();
        root.fill(&WHITE).expect("a string takes every drawing");
        draw(&root).expect("a string takes every drawing");
        root.present().expect("a string takes every drawing");
    }
    let size = |[width, height]: [u32; 2]| format!("<svg width=\"{width}\" height=\"{height}\"");
    text.replacen(&size(drawn), &size([width, height]), 1)
}

fn font(size: u32) -> TextStyle<'static> {
    (FONT, size * FINE).into_font().color(&INK)
}

/// Rows sorted by their median.
fn rows<'a>(area: &Area<'a>, title: &str, records: &[&Record]) -> Drawn<'a> {
    let mut rows: Vec<(&str, Vec<f64>)> = Vec::new();
    for entry in records.iter().flat_map(|r| &r.entries) {
        let Some(ns) = entry.processor.map(|p| p.median.max(1e-3)) else { continue };
        match rows.iter_mut().find(|(name, _)| *name == entry.name) {
            Some((_, values)) => values.push(ns),
            None => rows.push((&entry.name, vec![ns])),
        }
    }
    if rows.is_empty() {
        return Ok(());
    }
    rows.iter_mut().for_each(|(_, values)| values.sort_by(f64::total_cmp));
    rows.sort_by(|a, b| b.1[b.1.len() / 2].total_cmp(&a.1[a.1.len() / 2]));
    let all = || rows.iter().flat_map(|r| r.1.iter().map(|x| x.log10()));
    let (from, to) = (all().fold(f64::MAX, f64::min).floor(), all().fold(f64::MIN, f64::max).ceil());
    let count = rows.len() as f64;
    let mut chart = ChartBuilder::on(area)
        .margin(8 * FINE)
        .margin_right(20 * FINE)
        .caption(title, font(14))
        .x_label_area_size(24 * FINE)
        .y_label_area_size(150 * FINE)
        .build_cartesian_2d(from..to, 0.0..count)?;
    chart
        .configure_mesh()
        .disable_y_mesh()
        .y_labels(0)
        .x_labels((to - from) as usize + 1)
        .x_label_formatter(&|place| power(*place))
        .light_line_style(WHITE)
        .bold_line_style(FAINT.stroke_width(FINE))
        .axis_style(GREY.stroke_width(FINE))
        .label_style(font(12))
        .draw()?;
    for (i, (name, values)) in rows.iter().enumerate() {
        let color = match *name {
            OURS | OUR_STENCILS | OURS_ANEW => BLUE,
            FLOOR | FLOOR_ORDINARY => GREY,
            _ => VERMILION,
        };
        let y = i as f64 + 0.5;
        let places: Vec<(f64, f64)> = values.iter().map(|x| (x.log10(), y)).collect();
        let ends = vec![places[0], places[places.len() - 1]];
        chart.draw_series(std::iter::once(PathElement::new(ends, color.mix(0.35).stroke_width(3 * FINE))))?;
        chart.draw_series(places.iter().map(|&p| Circle::new(p, 3 * FINE, color.filled())))?;
        let (x, y) = chart.backend_coord(&(from, y));
        let style = font(12).color(&color).pos(text_position());
        area.draw_text(name, &style, relative(area, (x - 8 * FINE as i32, y)))?;
    }
    Ok(())
}

fn text_position() -> plotters::style::text_anchor::Pos {
    use plotters::style::text_anchor::{HPos, Pos, VPos};
    Pos::new(HPos::Right, VPos::Center)
}

/// From the drawing's coordinates to those of a part of it.
fn relative(area: &Area<'_>, (x, y): (i32, i32)) -> (i32, i32) {
    let (left, top) = area.get_base_pixel();
    (x - left, y - top)
}

fn power(place: f64) -> String {
    let exponent = place.round() as i32;
    match exponent {
        0.. => format!("{:.0}", 10f64.powi(exponent)),
        _ => format!("{}", 10f64.powi(exponent)),
    }
}

fn against_sharpness<'a>(area: &Area<'a>, title: &str, unit: &str, records: &[&Record], key: bool) -> Drawn<'a> {
    // Times are per face or place, and bytes: all of them in millions.
    let value = |record: &Record, name: &str| -> Option<f64> {
        let entry = record.entry(name)?;
        let ns_or_bytes = entry.processor.map(|p| p.median * record.count).or(entry.value)?;
        Some(ns_or_bytes / 1e6)
    };
    let sharpness = |record: &Record| record.what.split(':').next().and_then(|s| s.parse::<f64>().ok());
    let lines = [
        (FAR_CREASES, VERMILION, "feature-adaptive"),
        (FAR_SINGLE, ORANGE, "with single-crease patches"),
        (OURS, BLUE, "ours"),
    ];
    let points = |name: &str| -> Vec<(f64, f64)> {
        let mut points: Vec<(f64, f64)> =
            records.iter().filter_map(|r| Some((sharpness(r)?, value(r, name)?.log10()))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let all: Vec<f64> = lines.iter().flat_map(|l| points(l.0)).map(|p| p.1).collect();
    let (from, to) =
        (all.iter().copied().fold(f64::MAX, f64::min).floor(), all.iter().copied().fold(f64::MIN, f64::max).ceil());
    if all.is_empty() {
        return Ok(());
    }
    let mut chart = ChartBuilder::on(area)
        .margin(8 * FINE)
        .margin_right(14 * FINE)
        .caption(title, font(16))
        .x_label_area_size(42 * FINE)
        .y_label_area_size(56 * FINE)
        .build_cartesian_2d(0.0..10.0, from..to)?;
    chart
        .configure_mesh()
        .x_desc("sharpness")
        .y_desc(unit)
        .x_labels(11)
        .y_labels((to - from) as usize + 1)
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|place| power(*place))
        .light_line_style(WHITE)
        .bold_line_style(FAINT.stroke_width(FINE))
        .axis_style(GREY.stroke_width(FINE))
        .label_style(font(12))
        .axis_desc_style(font(13))
        .draw()?;
    for (name, color, label) in lines {
        let all = points(name);
        // An infinitely sharp crease is another thing: no line leads there.
        let (finite, infinite): (Vec<_>, Vec<_>) = all.into_iter().partition(|p| p.0 < 10.0);
        chart.draw_series(finite.iter().chain(&infinite).map(|&p| Circle::new(p, 3 * FINE, color.filled())))?;
        let series = chart.draw_series(LineSeries::new(finite, color.stroke_width(2 * FINE)))?;
        let style = color.stroke_width(2 * FINE);
        series.label(label).legend(move |(x, y)| PathElement::new([(x, y), (x + 20 * FINE as i32, y)], style));
    }
    if key {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .margin(10 * FINE)
            .legend_area_size(28 * FINE)
            .background_style(WHITE.mix(0.85))
            .border_style(FAINT.stroke_width(FINE))
            .label_font(font(12))
            .draw()?;
    }
    Ok(())
}
