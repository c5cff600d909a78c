//! Blended normals in pictures and numbers: figures 1 and 4 to 7 of Bakker, Barendrecht and Kosinka 2018.

use super::models::{self, Model};
use super::studio::{Panel, sheet};
use super::table::{Cell, Table};
use super::turning::{self, DEPTHS};
use super::{Drawing, Picture, Settings};
use crate::failure::Failure;
use subsurf::{Blend, Location, NormalField, PatchTable, Power, Scheme, ShadingNormals, ShadingOptions};

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

const CLOSE: &str = "--camera 0,7.5,4.2:0,0.55,0.1:26";
const ABOVE: &str = "--camera 0,10,0.01:0,0,0:34";

/// Figure 1.
pub fn fields(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    let row = |show: &str| {
        FIELDS.map(|(word, label, _)| Panel::new(label, format!("--show {show} --normals {word} {CLOSE}")))
    };
    let panels: Vec<Panel> = row("shaded").into_iter().chain(row("reflection-lines")).collect();
    let png = sheet(settings, &nine(), 6, [210, 210], &panels)?;
    let table = turning_table(&nine(), Scheme::CatmullClark, &FIELDS)?;
    Ok(Drawing { picture: Picture::Png(png), numbers: vec![("csv", table.csv())] })
}

/// Figure 4.
pub fn powers(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    let columns = [("n_L", "limit", 1.0), ("p = 1/2", "a3", 0.5), ("p = 1", "a3", 1.0), ("p = 2", "a3", 2.0)];
    let row = |show: &str| {
        columns.map(|(label, word, p)| {
            let power = if word == "limit" { String::new() } else { format!("--blend-power {p}") };
            Panel::new(label, format!("--show {show} --normals {word} {power} {CLOSE}"))
        })
    };
    let panels: Vec<Panel> = row("shaded").into_iter().chain(row("isophotes")).collect();
    let png = sheet(settings, &nine(), 4, [260, 260], &panels)?;

    let model = nine().input(Some(Scheme::CatmullClark))?;
    let fail = |source| Failure::Mesh { name: model.name.clone(), source };
    let patches = PatchTable::new(&model.scene.mesh, Scheme::CatmullClark).map_err(fail)?;
    let mut table = Table::new(["p", "depth", "rad_per_unit"]);
    for p in [0.5, 1.0, 2.0] {
        let options = ShadingOptions {
            field: NormalField::Blended(Blend::A3),
            power: Power::Uniform(p),
            ..ShadingOptions::default()
        };
        let rates = turning::rates(&patches, &model.scene.positions, &options)?;
        for (depth, rate) in (1usize..).zip(rates) {
            table.push(vec![p.into(), depth.into(), rate.into()]);
        }
    }
    Ok(Drawing { picture: Picture::Png(png), numbers: vec![("csv", table.csv())] })
}

/// Figure 5.
pub fn weights(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    let blends: [_; 4] = std::array::from_fn(|i| FIELDS[2 + i]);
    let panels = blends.map(|(word, label, _)| {
        Panel::new(label, format!("--show blend-weight --normals {word} --weight-level 1 --edges {ABOVE}"))
    });
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
    let panels = [LIMIT, SUBDIVIDED, A3, A4].map(|i| {
        let (word, label, _) = FIELDS[i];
        Panel::new(label, format!("--show isophotes --normals {word} --camera 2.1,1.1,-2.8:0.1,0.45,-0.35:15"))
    });
    let png = sheet(settings, &models::spot(), 4, [316, 316], &panels)?;
    Ok(Drawing { picture: Picture::Png(png), numbers: Vec::new() })
}

/// Figure 7.
pub fn loop_isophotes(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    let fields = [LIMIT, A3, A4].map(|i| FIELDS[i]);
    let panels = fields
        .map(|(word, label, _)| Panel::new(label, format!("--scheme loop --show isophotes --normals {word} {CLOSE}")));
    let png = sheet(settings, &loop_nine(), 3, [400, 360], &panels)?;
    let table = turning_table(&loop_nine(), Scheme::Loop, &fields)?;
    Ok(Drawing { picture: Picture::Png(png), numbers: vec![("csv", table.csv())] })
}

/// How fast the normals of fields turn near the vertex.
fn turning_table(
    model: &Model,
    scheme: Scheme,
    fields: &[(&'static str, &str, NormalField)],
) -> Result<Table, Failure> {
    let input = model.input(Some(scheme))?;
    let fail = |source| Failure::Mesh { name: input.name.clone(), source };
    let patches = PatchTable::new(&input.scene.mesh, scheme).map_err(fail)?;
    let mut columns = Vec::new();
    for &(_, _, field) in fields {
        let options = ShadingOptions { field, ..ShadingOptions::default() };
        columns.push(turning::rates(&patches, &input.scene.positions, &options)?);
    }
    let mut table = Table::new(std::iter::once("depth").chain(fields.iter().map(|f| f.0)));
    for depth in 0..DEPTHS as usize {
        let mut row: Vec<Cell> = vec![(depth + 1).into()];
        row.extend(columns.iter().map(|rates| Cell::from(rates[depth])));
        table.push(row);
    }
    Ok(table)
}
