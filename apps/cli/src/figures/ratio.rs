//! The bound of theorem 1 of Bakker, Barendrecht and Kosinka 2018 against valence: their figure 2.

use super::chart::{Axis, COLORS, Chart, Corner, Curve, GREY, Look, svg};
use super::table::Table;
use super::{Drawing, Picture, Settings};
use crate::failure::Failure;
use subsurf::{Scheme, Spectrum};

const VALENCES: std::ops::RangeInclusive<u32> = 3..=50;
const POWERS: [(f64, &str); 3] = [(0.5, "p = 1/2"), (1.0, "p = 1; also (μ/λ)²"), (2.0, "p = 2")];
const SCHEMES: [(Scheme, &str, &str); 2] =
    [(Scheme::CatmullClark, "catmull-clark", "Catmull-Clark"), (Scheme::Loop, "loop", "Loop")];

pub fn draw(_: &Settings<'_>) -> Result<Drawing, Failure> {
    let mut table = Table::new(["scheme", "valence", "lambda", "mu", "p_half", "p_one", "p_two", "gradient"]);
    let mut charts = Vec::new();
    for (scheme, word, title) in SCHEMES {
        let spectra: Vec<(u32, Spectrum)> =
            VALENCES.filter_map(|n| Some((n, Spectrum::of_interior(scheme, n)?))).collect();
        for (n, s) in &spectra {
            let [half, one, two] = POWERS.map(|(p, _)| s.theorem_ratio(p));
            table.push(vec![
                word.into(),
                (*n as usize).into(),
                s.lambda.into(),
                s.mu.into(),
                half.into(),
                one.into(),
                two.into(),
                s.gradient_ratio().into(),
            ]);
        }
        let curve = |f: &dyn Fn(&Spectrum) -> f64| spectra.iter().map(|(n, s)| [f64::from(*n), f(s)]).collect();
        let mut curves = vec![Curve {
            label: None,
            color: GREY,
            look: Look::Line(1),
            points: vec![[f64::from(*VALENCES.start()), 1.0], [f64::from(*VALENCES.end()), 1.0]],
        }];
        curves.extend(POWERS.into_iter().zip(COLORS).map(|((p, label), color)| Curve {
            label: Some(label.to_owned()),
            color,
            look: Look::Marked(2),
            points: curve(&|s| s.theorem_ratio(p)),
        }));
        charts.push(Chart {
            title: title.to_owned(),
            x: Axis::linear("valence n", f64::from(*VALENCES.start()), f64::from(*VALENCES.end()), 11),
            y: Axis::linear("μᵖ⁺¹ / λ²", 0.0, 1.7, 9),
            curves,
            key: Some(Corner::LowerRight),
            notes: Vec::new(),
        });
    }
    Ok(Drawing { picture: Picture::Svg(svg(&charts, [1000, 420])), numbers: vec![("csv", table.csv())] })
}
