//! Blended normals in pictures and numbers: figures 1 and 4 to 7 of Bakker, Barendrecht and Kosinka 2018.

use super::chart::{Axis, COLORS, Chart, Corner, Curve, GREY, Look, svg};
use super::models::{self, Model};
use super::studio::{Panel, sheet};
use super::table::{Cell, Table};
use super::turning::{self, DEPTHS};
use super::{Drawing, Picture, Settings};
use crate::failure::Failure;
use subsurf::{
    Blend, Face, Location, Method, NormalField, PatchTable, Power, Scheme, ShadingNormals, ShadingOptions, Spectrum,
};

/// The fields by the words of `--normals`, under their picture, and in the library.
const FIELDS: [(&str, &str, NormalField); 6] = [
    ("limit", "n_L", NormalField::Limit),
    ("subdivided", "n_S", NormalField::Subdivided),
    ("a1", "A_1", NormalField::Blended(Blend::A1)),
    ("a2", "A_2", NormalField::Blended(Blend::A2)),
    ("a3", "A_3", NormalField::Blended(Blend::A3)),
    ("a4", "A_4", NormalField::Blended(Blend::A4)),
];
const LIMIT: usize = 0;
const SUBDIVIDED: usize = 1;
const A3: usize = 4;
const A4: usize = 5;

/// A vertex of valence 9 in a Catmull-Clark mesh.
pub fn nine() -> Model {
    models::quads_round_a_vertex("valence-9-quads", 9, 4)
}

/// A pole of valence 12.
pub fn twelve() -> Model {
    models::pole("pole-12", 12, 2)
}

/// A vertex of valence 9 in a mesh of triangles.
pub fn loop_nine() -> Model {
    models::triangles_round_a_vertex("valence-9-triangles", 9, 4)
}

/// Along the ridge, with the vertex in the middle.
const CLOSE: &str = "--camera 1.2,6.5,-7.5:0.02,1.1,-0.1:15";
const REFLECTIONS: &str = "--show reflection-lines --stripes 18 --axis 0.3,0,-1";
const ISOPHOTES: &str = "--show isophotes --stripes 20 --axis 1,0.3,0";
const ABOVE: &str = "--show blend-weight --weight-level 1 --edges --no-legend --camera 0,9,-5:0,0.2,0.25:32";
const SPOT: &str = "--show isophotes --stripes 16 --camera -2.6,1.4,-1.6:0.05,0.45,-0.2:17";

/// Figure 1.
pub fn fields(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    let row = |show: &str| FIELDS.map(|(word, label, _)| Panel::new(label, format!("{show} --normals {word} {CLOSE}")));
    let panels: Vec<Panel> = row("").into_iter().chain(row(REFLECTIONS)).collect();
    let png = sheet(settings, &nine(), 6, [210, 210], &panels)?;
    let table = turning_table(&nine(), Scheme::CatmullClark)?;
    Ok(Drawing { picture: Picture::Png(png), numbers: vec![("csv", table.csv())] })
}

/// Figure 4.
pub fn powers(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    let columns = [("n_L", ""), ("p = 1/2", "0.5"), ("p = 1", "1"), ("p = 2", "2")];
    let row = |show: &str| {
        columns.map(|(label, p)| {
            let normals = if p.is_empty() { String::new() } else { format!("--normals a3 --blend-power {p}") };
            Panel::new(label, format!("{show} {normals} {CLOSE}"))
        })
    };
    let panels: Vec<Panel> = row("").into_iter().chain(row(ISOPHOTES)).collect();
    let png = sheet(settings, &nine(), 4, [260, 260], &panels)?;

    // Beside the valence of the picture one where the theorem's bound for p = 1/2 is above 1.
    let mut table = Table::new(["valence", "p", "bound", "depth", "rad_per_unit"]);
    for (model, valence) in [(nine(), 9), (models::quads_round_a_vertex("valence-14", 14, 4), 14)] {
        for p in [0.5, 1.0, 2.0] {
            let options = ShadingOptions {
                field: NormalField::Blended(Blend::A3),
                power: Power::Uniform(p),
                ..ShadingOptions::default()
            };
            let rates = turning::rates(&model, Scheme::CatmullClark, &options)?;
            let bound = Spectrum::of_interior(Scheme::CatmullClark, valence).map_or(f64::NAN, |s| s.theorem_ratio(p));
            for (depth, rate) in (1usize..).zip(rates) {
                table.push(vec![(valence as usize).into(), p.into(), bound.into(), depth.into(), rate.into()]);
            }
        }
    }
    Ok(Drawing { picture: Picture::Png(png), numbers: vec![("csv", table.csv())] })
}

/// Figure 5.
pub fn weights(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    let blends: [_; 4] = std::array::from_fn(|i| FIELDS[2 + i]);
    let panels = blends.map(|(word, label, _)| Panel::new(label, format!("--normals {word} {ABOVE}")));
    let png = sheet(settings, &twelve(), 4, [316, 300], &panels)?;

    // Along an edge from the pole outwards, and on.
    let model = twelve().input(Some(Scheme::CatmullClark))?;
    let fail = |source| Failure::Mesh { name: model.name.clone(), source };
    let patches = PatchTable::new(&model.scene.mesh, Scheme::CatmullClark).map_err(fail)?;
    let mut table = Table::new(["blend", "weights_level", "u", "b"]);
    for (word, _, field) in blends {
        let options = ShadingOptions { field, weights_level: 1, ..ShadingOptions::default() };
        let shading = ShadingNormals::new(&patches, &model.scene.positions, &options)
            .map_err(|source| Failure::Shading { name: model.name.clone(), source })?;
        for i in 0..=32 {
            let u = f64::from(i) / 32.0;
            let b = shading.blend_weight(Location::new(0, u, 0.0));
            table.push(vec![word.into(), (shading.weights_level() as usize).into(), u.into(), b.into()]);
        }
    }
    Ok(Drawing { picture: Picture::Png(png), numbers: vec![("csv", table.csv())] })
}

/// Figure 6.
pub fn isophotes(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    let chosen = [LIMIT, SUBDIVIDED, A3, A4].map(|i| FIELDS[i]);
    let panels = chosen.map(|(word, label, field)| {
        let level = match field {
            NormalField::Limit => "",
            NormalField::Subdivided => "--normal-level 1",
            NormalField::Blended(_) => "--normal-level 1 --weight-level 1",
        };
        Panel::new(label, format!("{SPOT} --normals {word} {level}"))
    });
    let png = sheet(settings, &models::spot(), 4, [316, 300], &panels)?;

    let input = models::spot().input(None)?;
    let patches = input.patch_table(Method::default(), settings.console)?;
    let surface = patches.surface(&input.scene.positions);
    let mut table = Table::new(["normals", "mean_deg_from_limit", "max_deg_from_limit"]);
    for (word, _, field) in chosen {
        let options = ShadingOptions { field, normals_level: 1, weights_level: 1, ..ShadingOptions::default() };
        let shading = ShadingNormals::new(&patches, &input.scene.positions, &options)
            .map_err(|source| Failure::Shading { name: input.name.clone(), source })?;
        let angle = |at: Location| {
            let jet = surface.eval(at)?;
            let (n, m) = (jet.normal()?, shading.normal(at, &jet)?);
            let chord = n.iter().zip(m).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
            Some((2.0 * (0.5 * chord).min(1.0).asin()).to_degrees())
        };
        let faces = (0..patches.topology().face_count()).map(Face::new);
        let places = faces.flat_map(|face| (0..patches.subfaces(face)).map(move |subface| (face, subface)));
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(GRID);
        let angles: Vec<f64> = places
            .flat_map(|(face, subface)| (0..GRID * GRID).map(move |i| (face, subface, i)))
            .filter_map(|(face, subface, i)| angle(Location { face, subface, u: at(i % GRID), v: at(i / GRID) }))
            .collect();
        let mean = angles.iter().sum::<f64>() / angles.len() as f64;
        table.push(vec![word.into(), mean.into(), angles.into_iter().fold(0.0, f64::max).into()]);
    }
    Ok(Drawing { picture: Picture::Png(png), numbers: vec![("csv", table.csv())] })
}

/// Samples along each side of a face.
const GRID: u32 = 8;

/// Figure 7.
pub fn loop_isophotes(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    let panels = [LIMIT, A3, A4].map(|i| {
        let (word, label, _) = FIELDS[i];
        Panel::new(label, format!("--scheme loop {ISOPHOTES} --normals {word} {CLOSE}"))
    });
    let png = sheet(settings, &loop_nine(), 3, [400, 360], &panels)?;
    let table = turning_table(&loop_nine(), Scheme::Loop)?;
    Ok(Drawing { picture: Picture::Png(png), numbers: vec![("csv", table.csv())] })
}

/// How fast the normals of all fields turn near a vertex: the numbers of figures 1 and 7 as a chart.
pub fn turning(_: &Settings<'_>) -> Result<Drawing, Failure> {
    let mut charts = Vec::new();
    for (model, scheme, title) in
        [(nine(), Scheme::CatmullClark, "Catmull-Clark, valence 9"), (loop_nine(), Scheme::Loop, "Loop, valence 9")]
    {
        let looks = [
            (GREY, Look::Line(2)),
            (COLORS[0], Look::Line(2)),
            (COLORS[3], Look::Marked(1)),
            (COLORS[1], Look::Marked(1)),
            (COLORS[2], Look::Marked(1)),
            (COLORS[4], Look::Marked(1)),
        ];
        let names = ["n_L: limit", "n_S: subdivided", "A₁", "A₂", "A₃", "A₄"];
        let mut curves = Vec::new();
        for ((&(_, _, field), (color, look)), name) in FIELDS.iter().zip(looks).zip(names) {
            let rates = turning::rates(&model, scheme, &ShadingOptions { field, ..ShadingOptions::default() })?;
            let points = (1u32..).zip(rates).map(|(depth, rate)| [f64::from(depth), rate]).collect();
            curves.push(Curve { label: Some(name.replace("n_L", "nₗ").replace("n_S", "nₛ")), color, look, points });
        }
        charts.push(Chart {
            title: title.to_owned(),
            x: Axis::linear("halvings of the distance to the vertex", 1.0, f64::from(DEPTHS), DEPTHS as usize),
            y: Axis::logarithmic("normals turn by, radians per unit", 1e-1, 1e2),
            curves,
            key: Some(Corner::UpperLeft),
            notes: Vec::new(),
        });
    }
    Ok(Drawing { picture: Picture::Svg(svg(&charts, [1000, 400])), numbers: Vec::new() })
}

/// How fast the normals of all fields turn near vertex 0.
fn turning_table(model: &Model, scheme: Scheme) -> Result<Table, Failure> {
    let columns = FIELDS
        .iter()
        .map(|&(_, _, field)| turning::rates(model, scheme, &ShadingOptions { field, ..ShadingOptions::default() }))
        .collect::<Result<Vec<_>, _>>()?;
    let mut table = Table::new(std::iter::once("depth").chain(FIELDS.iter().map(|f| f.0)));
    for depth in 0..DEPTHS as usize {
        let mut row: Vec<Cell> = vec![(depth + 1).into()];
        row.extend(columns.iter().map(|rates| Cell::from(rates[depth])));
        table.push(row);
    }
    Ok(table)
}
