//! Line charts as SVG, all in one style: thin axes, a faint grid, colours that the colour-blind can tell apart.

use plotters::coord::Shift;
use plotters::prelude::*;

/// What is drawn in one frame.
#[derive(Clone, Debug)]
pub struct Chart {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub curves: Vec<Curve>,
    /// Where the key to the curves is, if there is one.
    pub key: Option<Corner>,
    /// Values of x at which points are marked by name.
    pub notes: Vec<Note>,
}

/// A direction of the chart.
#[derive(Clone, Debug)]
pub struct Axis {
    pub label: &'static str,
    pub from: f64,
    pub to: f64,
    /// About how many numbers stand along it; 0 for none.
    pub ticks: usize,
    /// Powers of ten are equally far apart; `from` and `to` are positive then.
    pub logarithmic: bool,
}

/// A run of points.
#[derive(Clone, Debug)]
pub struct Curve {
    /// None: not in the key.
    pub label: Option<String>,
    pub color: RGBColor,
    pub look: Look,
    pub points: Vec<[f64; 2]>,
}

/// How points are drawn.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Look {
    /// Joined by a line of this width.
    Line(u32),
    /// Dots of this radius.
    Dots(u32),
    /// A line with dots.
    Marked(u32),
}

/// A word at a place.
#[derive(Clone, Debug)]
pub struct Note {
    pub at: [f64; 2],
    pub text: String,
    pub color: RGBColor,
}

/// A corner of the frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Corner {
    UpperLeft,
    UpperRight,
    LowerRight,
}

/// Okabe and Ito, "Color universal design", 2008: dark enough for lines on white.
pub const COLORS: [RGBColor; 5] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
];
/// For what is only there to compare with.
pub const GREY: RGBColor = RGBColor(130, 136, 144);
const INK: RGBColor = RGBColor(40, 46, 54);
const FAINT: RGBColor = RGBColor(228, 231, 235);
const FONT: &str = "sans-serif";

impl Axis {
    /// Equal steps.
    pub fn linear(label: &'static str, from: f64, to: f64, ticks: usize) -> Self {
        Self { label, from, to, ticks, logarithmic: false }
    }

    /// Equal factors.
    pub fn logarithmic(label: &'static str, from: f64, to: f64) -> Self {
        Self { label, from, to, ticks: (to / from).log10().round() as usize + 1, logarithmic: true }
    }

    fn place(&self, value: f64) -> f64 {
        if self.logarithmic { value.log10() } else { value }
    }

    fn text(&self, place: f64) -> String {
        const LARGE: [&str; 6] = ["10⁴", "10⁵", "10⁶", "10⁷", "10⁸", "10⁹"];
        if self.logarithmic {
            let power = place.round() as i32;
            return LARGE
                .get((power - 4) as usize)
                .map_or_else(|| format!("{}", 10f64.powi(power)), ToString::to_string);
        }
        // Rounded to what a tick can be.
        format!("{}", (place * 1e6).round() / 1e6 + 0.0)
    }
}

/// The drawing is made this many times as large as it is shown, because its coordinates are whole numbers.
const FINE: u32 = 4;

/// Draws charts side by side, `width × height` pixels together. Infallible: a string takes every drawing.
pub fn svg(charts: &[Chart], [width, height]: [u32; 2]) -> String {
    let mut text = String::new();
    let drawn = [width, height].map(|x| FINE * x);
    {
        let root = SVGBackend::with_string(&mut text, (drawn[0], drawn[1])).into_drawing_area();
        root.fill(&WHITE).expect("a string takes every drawing");
        for (area, chart) in root.split_evenly((1, charts.len())).iter().zip(charts) {
            draw(area, chart).expect("a string takes every drawing");
        }
        root.present().expect("a string takes every drawing");
    }
    let size = |[width, height]: [u32; 2]| format!("<svg width=\"{width}\" height=\"{height}\"");
    text.replacen(&size(drawn), &size([width, height]), 1)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn<'a> = Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>>;

fn draw<'a>(area: &Area<'a>, chart: &Chart) -> Drawn<'a> {
    let (x, y) = (&chart.x, &chart.y);
    let label = (FONT, 14 * FINE).into_font().color(&INK);
    let mut context = ChartBuilder::on(area)
        .margin(10 * FINE)
        .margin_right(18 * FINE)
        .caption(&chart.title, (FONT, 17 * FINE).into_font().color(&INK))
        .x_label_area_size(FINE * if x.ticks == 0 { 8 } else { 44 })
        .y_label_area_size(FINE * if y.ticks == 0 { 8 } else { 58 })
        .build_cartesian_2d(x.place(x.from)..x.place(x.to), y.place(y.from)..y.place(y.to))?;
    if x.ticks + y.ticks > 0 {
        context
            .configure_mesh()
            .x_desc(x.label)
            .y_desc(y.label)
            .x_labels(x.ticks)
            .y_labels(y.ticks)
            .x_label_formatter(&|place| x.text(*place))
            .y_label_formatter(&|place| y.text(*place))
            .light_line_style(WHITE)
            .bold_line_style(FAINT.stroke_width(FINE))
            .axis_style(GREY.stroke_width(FINE))
            .label_style((FONT, 13 * FINE).into_font().color(&INK))
            .axis_desc_style(label.clone())
            .set_all_tick_mark_size(5 * FINE)
            .draw()?;
    }
    for curve in &chart.curves {
        let points: Vec<(f64, f64)> = curve.points.iter().map(|p| (x.place(p[0]), y.place(p[1]))).collect();
        let color = curve.color;
        let key = match curve.look {
            Look::Line(width) => context.draw_series(LineSeries::new(points, color.stroke_width(width * FINE)))?,
            Look::Dots(radius) => {
                context.draw_series(points.into_iter().map(|p| Circle::new(p, radius * FINE, color.filled())))?
            }
            Look::Marked(width) => {
                context.draw_series(points.iter().map(|&p| Circle::new(p, (width + 1) * FINE, color.filled())))?;
                context.draw_series(LineSeries::new(points, color.stroke_width(width * FINE)))?
            }
        };
        if let Some(label) = &curve.label {
            let stroke = match curve.look {
                Look::Line(width) | Look::Marked(width) => width,
                Look::Dots(radius) => 2 * radius,
            };
            let style = color.stroke_width(stroke * FINE);
            key.label(label).legend(move |(x, y)| PathElement::new([(x, y), (x + 22 * FINE as i32, y)], style));
        }
    }
    for note in &chart.notes {
        let style = (FONT, 14 * FINE).into_font().color(&note.color);
        let at = (x.place(note.at[0]), y.place(note.at[1]));
        context.draw_series(std::iter::once(Text::new(note.text.clone(), at, style)))?;
    }
    if let Some(corner) = chart.key {
        context
            .configure_series_labels()
            .position(match corner {
                Corner::UpperLeft => SeriesLabelPosition::UpperLeft,
                Corner::UpperRight => SeriesLabelPosition::UpperRight,
                Corner::LowerRight => SeriesLabelPosition::LowerRight,
            })
            .margin(12 * FINE)
            .legend_area_size(30 * FINE)
            .background_style(WHITE.mix(0.85))
            .border_style(FAINT.stroke_width(FINE))
            .label_font(label)
            .draw()?;
    }
    Ok(())
}
