//! Pictures of whole models: of the car in the colours of levels (figure 3 of Nießner, Loop and Greiner 2012), and those
//! of the front page.

use super::sheet::Sheet;
use super::studio::{Panel, picture, sheet};
use super::table::{Cell, Table};
use super::{Drawing, Picture, Settings, models};
use crate::failure::Failure;
use subsurf::{AdaptiveOptions, AdaptiveRefinement, PatchKind, PatchTable, Scheme};

const CAR_NEAR: &str = "--up z --camera 4.1,-5.5,2.05:0.45,-1.93,-0.2:33";
const LEVELS: &str = "--show levels --up z --camera 3.4,-4.6,2.6:0.62,-2.0,0.3:20";

/// The car's levels by two baselines and by patch trees.
pub fn crease_levels(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    let panels = [
        Panel::new("feature-adaptive", format!("{LEVELS} --baseline feature-adaptive")),
        Panel::new(
            "with single-crease patches",
            format!("{LEVELS} --no-legend --baseline feature-adaptive-single-crease"),
        ),
        Panel::new("patch trees", format!("{LEVELS} --no-legend")),
    ];
    let png = sheet(settings, &models::car(), 3, [384, 300], &panels)?;
    let car = models::car().scene()?;
    let table = PatchTable::new(&car.mesh, Scheme::CatmullClark)
        .map_err(|source| Failure::Mesh { name: "the car".to_owned(), source })?;
    let mut numbers = Table::new(["method", "level", "regular", "boundary", "single_crease", "end_cap_or_special"]);
    for (method, single_crease) in [("feature-adaptive", false), ("feature-adaptive-single-crease", true)] {
        let options = AdaptiveOptions::for_sharpness_of(table.topology(), single_crease);
        let refined = AdaptiveRefinement::from_topology(table.topology(), Scheme::CatmullClark, options)
            .map_err(|source| Failure::Baseline { name: "the car".to_owned(), source })?;
        for (level, counts) in refined.counts().into_iter().enumerate() {
            let mut row: Vec<Cell> = vec![method.into(), level.into()];
            row.extend(counts.map(Cell::from));
            numbers.push(row);
        }
    }
    for (level, [regular, crease, special]) in leaves(&table).into_iter().enumerate() {
        numbers.push(vec!["plans".into(), level.into(), regular.into(), 0.into(), crease.into(), special.into()]);
    }
    Ok(Drawing { picture: Picture::Png(png), numbers: vec![("csv", numbers.csv())] })
}

/// Leaves of the patch trees of all faces, by level and kind: the tree is walked at the centres of ever smaller squares,
/// until a leaf is as large as its square.
fn leaves(table: &PatchTable) -> Vec<[usize; 3]> {
    let mut counts = Vec::new();
    for patch in (0..table.patch_count()).filter(|&patch| table.patch_plan(patch).is_some()) {
        let mut squares = vec![(0u32, 0.0, 0.0)];
        while let Some((level, u, v)) = squares.pop() {
            let half = 0.5 * (-f64::from(level)).exp2();
            let Some((kind, depth)) = table.patch_kind(patch, u + half, v + half) else { continue };
            if depth > level {
                squares.extend(
                    [(u, v), (u + half, v), (u, v + half), (u + half, v + half)].map(|(u, v)| (level + 1, u, v)),
                );
                continue;
            }
            let column = match kind {
                PatchKind::Regular => 0,
                PatchKind::SingleCrease => 1,
                _ => 2,
            };
            counts.resize(counts.len().max(level as usize + 1), [0; 3]);
            counts[level as usize][column] += 1;
        }
    }
    counts
}

fn single(settings: &Settings<'_>, model: &models::Model, size: [u32; 2], flags: &str) -> Result<Drawing, Failure> {
    let image = picture(settings, model, flags, size)?;
    let sheet = Sheet { columns: 1, panels: vec![image], labels: Vec::new() };
    Ok(Drawing { picture: Picture::Png(sheet.png().map_err(Failure::StandardOutput)?), numbers: Vec::new() })
}

pub fn car(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    single(settings, &models::car(), [1040, 585], "--up z --camera 4.1,-5.5,2.05:0.64,-1.93,0.24:24")
}

pub fn spot_cage(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    single(settings, &models::spot(), [640, 480], "--show cage --camera 2.1,1.1,-2.8:0,0.08,0.22:31")
}

pub fn car_levels(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    single(settings, &models::car(), [640, 480], &format!("--show levels {CAR_NEAR}"))
}

pub fn car_baseline(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    let flags = format!("--show levels --baseline feature-adaptive {CAR_NEAR}");
    single(settings, &models::car(), [640, 480], &flags)
}

pub fn shoes_patches(settings: &Settings<'_>) -> Result<Drawing, Failure> {
    single(settings, &models::shoes(), [640, 480], "--show patches")
}
