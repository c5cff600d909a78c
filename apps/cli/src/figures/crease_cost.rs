//! What a crease's sharpness costs: figure 2 of Nießner, Loop and Greiner 2012, in counts instead of milliseconds.

use super::chart::{Axis, COLORS, Chart, Corner, Curve, GREY, Look, svg};
use super::table::{Cell, Table};
use super::{Drawing, Picture, Settings, models};
use crate::failure::Failure;
use subsurf::{AdaptiveOptions, AdaptiveRefinement, ControlMesh, Crease, PatchTable, Scheme, Tags};

const SHARPNESSES: [f64; 13] = [0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 9.99, 10.0];
const METHODS: [&str; 3] = ["feature-adaptive", "feature-adaptive-single-crease", "plans"];

/// Patches, points to refine every frame, and bytes.
pub type Cost = [usize; 3];

/// What the methods need for a mesh with all its creases set to one sharpness.
pub fn costs(mesh: &ControlMesh, sharpness: f64) -> Result<[Cost; 3], Failure> {
    let name = "the car";
    let creases = mesh.tags().creases.iter().map(|c| Crease { sharpness, ..*c }).collect();
    let faces: Vec<&[u32]> = mesh.faces().collect();
    let fail = |source| Failure::Mesh { name: name.to_owned(), source };
    let mesh = ControlMesh::new(&faces, Tags { creases, ..mesh.tags().clone() }).map_err(fail)?;
    let table = PatchTable::new(&mesh, Scheme::CatmullClark).map_err(fail)?;
    let baseline = |single_crease: bool| {
        let options = AdaptiveOptions::for_sharpness_of(table.topology(), single_crease);
        AdaptiveRefinement::from_topology(table.topology(), Scheme::CatmullClark, options)
            .map(|refined| {
                let s = refined.size();
                [s.patches, s.refined_points + s.end_cap_points, s.patch_bytes + s.mask_bytes + s.point_bytes]
            })
            .map_err(|source| Failure::Baseline { name: name.to_owned(), source })
    };
    let ours = table.size();
    Ok([baseline(false)?, baseline(true)?, [ours.patches, 0, ours.patch_bytes + ours.plan_bytes]])
}

pub fn draw(_: &Settings<'_>) -> Result<Drawing, Failure> {
    let car = models::car().scene()?;
    let mut table = Table::new(["sharpness", "method", "patches", "points", "bytes"]);
    let mut rows = Vec::new();
    for sharpness in SHARPNESSES {
        let costs = costs(&car.mesh, sharpness)?;
        for (method, cost) in METHODS.into_iter().zip(costs) {
            let mut row: Vec<Cell> = vec![sharpness.into(), method.into()];
            row.extend(cost.map(Cell::from));
            table.push(row);
        }
        rows.push((sharpness, costs));
    }
    // The step from 9.99 to 10 is no slope: an infinitely sharp crease is another thing.
    let (finite, infinite) = rows.split_at(rows.len() - 1);
    let labels = ["feature-adaptive", "with single-crease patches", "our plans"];
    let chart = |title: &str, label, column: usize, unit: f64, [from, to]: [f64; 2]| {
        let place = |(s, costs): &(f64, [Cost; 3]), m: usize| [*s, costs[m][column] as f64 / unit];
        let mut curves = Vec::new();
        for m in 0..METHODS.len() {
            let color = COLORS[[1, 4, 0][m]];
            let label = Some(labels[m].to_owned());
            let points = finite.iter().map(|row| place(row, m)).collect();
            curves.push(Curve { label, color, look: Look::Marked(2), points });
        }
        let lone = infinite.iter().flat_map(|row| (0..METHODS.len()).map(|m| place(row, m))).collect();
        curves.push(Curve {
            label: Some("infinitely sharp".to_owned()),
            color: GREY,
            look: Look::Dots(4),
            points: lone,
        });
        Chart {
            title: title.to_owned(),
            x: Axis::linear("sharpness", 0.0, 10.0, 11),
            y: Axis::logarithmic(label, from, to),
            curves,
            key: Some(Corner::UpperLeft),
            notes: Vec::new(),
        }
    };
    let charts =
        [chart("Patches", "patches", 0, 1.0, [1e3, 1e7]), chart("Memory", "MiB", 2, f64::from(1 << 20), [1e-1, 1e3])];
    Ok(Drawing { picture: Picture::Svg(svg(&charts, [1000, 420])), numbers: vec![("csv", table.csv())] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use subsurf::shapes;

    #[test]
    fn without_single_crease_patches_each_step_of_sharpness_more_than_doubles_what_it_adds_and_plans_stay_flat() {
        let sheet = shapes::grid(6, 6);
        let creases = (0..6).map(|y| Crease::new(y * 7 + 3, y * 7 + 10, 1.0)).collect();
        let mesh = sheet.tagged("creased sheet", Tags { creases, ..Tags::default() }).mesh;
        let at: Vec<[Cost; 3]> = [5.0, 6.0, 7.0, 8.0].map(|s| costs(&mesh, s).unwrap()).into();
        let steps: Vec<usize> = at.windows(2).map(|w| w[1][0][0] - w[0][0][0]).collect();
        // Twelve faces at the crease, 2^s children of each along it, and as many again beside them: the share of what
        // does not double falls with s.
        assert!(steps.windows(2).all(|w| (1.8..2.2).contains(&(w[1] as f64 / w[0] as f64))), "{steps:?}");
        assert!(at.iter().all(|costs| costs[2][0] == 36 && costs[2][1] == 0));
        assert!(at.windows(2).all(|w| w[1][1][0] - w[0][1][0] <= 24), "linear");
    }
}
