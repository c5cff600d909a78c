//! What is wanted, beside what was measured.

use super::case::{CAR, CHARACTER};
use super::record::{Entry, Record};
use super::rivals::name::*;

/// One goal and how far it is reached.
pub struct Outcome {
    pub goal: &'static str,
    pub wanted: String,
    /// Least and most of what was measured, and of how many measurements how many reach the goal.
    pub measured: Option<([f64; 2], [usize; 2])>,
    pub unit: &'static str,
}

/// All goals, in the order of the document.
pub fn outcomes(records: &[Record]) -> Vec<Outcome> {
    let far_of_build = |r: &Record| if r.mesh == CAR { FAR_6 } else { FAR_4 };
    let of = |section: &'static str, what: &'static str| {
        records.iter().filter(move |r| r.section == section && r.what.contains(what))
    };
    let ratios = |section, what, rival: &'static str| -> Vec<f64> {
        of(section, what).filter_map(|r| ratio(r, rival)).collect()
    };
    // How many times as long as writing the output ours takes.
    let above_floor =
        |section, what| -> Vec<f64> { ratios(section, what, FLOOR).into_iter().map(|x| 1.0 / x).collect() };
    let tessellated = |normals: &'static str, state: &'static str, rival: &'static str| -> Vec<f64> {
        of("tessellate", normals).filter(|r| r.what.ends_with(state)).filter_map(|r| ratio(r, rival)).collect()
    };
    let inverse = |values: Vec<f64>| values.into_iter().map(|x: f64| 1.0 / x).collect();
    let bytes = of("memory", "kept").filter(|r| r.mesh == CHARACTER).filter_map(|r| r.entry(OURS)?.value).collect();
    let peak = of("memory", "peak").filter_map(|r| Some(r.entry(OURS)?.value? / r.entry(FLOOR)?.value?)).collect();
    let creases = |what: &str| variation(of_creases(records, what));
    let threads = records.iter().filter(|r| r.section == "threads" && !r.what.contains("Osd")).filter_map(two_threads);
    vec![
        at_least(
            "build, beside OpenSubdiv's adaptive set-up (isolation 6 on the Car, else 4)",
            50.0,
            of("build", "").filter_map(|r| ratio(r, far_of_build(r))).collect(),
        ),
        at_least("… beside Bfr's initialisation of all faces, without its cache", 10.0, ratios("build", "", BFR)),
        at_most("bytes a face of the character's table", 200.0, bytes, ""),
        at_most("build: slowest by fastest time a face, 10⁴ to 10⁷ faces", 1.15, scaling(records), ""),
        at_least("uniform refinement, cold, beside Far", 25.0, ratios("refine", "cold", FAR)),
        at_most("… peak memory by the output's", 1.5, peak, ""),
        at_most("… cold, by the time of writing the output", 2.0, above_floor("refine", "cold"), "×"),
        at_least("uniform refinement, warm, beside PrimvarRefiner", 8.0, ratios("animation", "warm", FAR)),
        at_least("… beside Osd's stencils", 10.0, ratios("animation", "warm", OSD_XYZ)),
        at_most("… warm, by the time of writing the output", 2.0, above_floor("animation", "warm"), "×"),
        at_least("tessellation, cold, beside Far", 25.0, tessellated("positions", "cold", FAR)),
        at_least("tessellation with normals, cold, beside Far", 25.0, tessellated("normals", "cold", FAR)),
        at_least("tessellation, warm, beside Far", 8.0, tessellated("positions", "warm", FAR)),
        at_most(
            "… warm, by the time of writing the output",
            2.0,
            inverse(tessellated("positions", "warm", FLOOR)),
            "×",
        ),
        at_most("… with normals", 2.5, inverse(tessellated("normals", "warm", FLOOR)), "×"),
        at_least("evaluation by face, beside Far", 20.0, best_far(of("limit", "by face"))),
        at_least("… beside Bfr", 10.0, ratios("limit", "by face", BFR)),
        at_least("… beside Embree's batches", 5.0, ratios("limit", "by face", EMBREE_MANY)),
        at_least("evaluation in random order, beside Far", 10.0, best_far(of("limit", "random"))),
        at_least("limit stencils, build, beside Far", 30.0, ratios("limit-stencils", "build", FAR_4)),
        at_least("limit stencils, apply, beside Far", 5.0, ratios("limit-stencils", "apply", FAR_4)),
        at_most("creases of sharpness 1 to 10: most by least time to build", 1.15, creases("build"), ""),
        at_most("… memory", 1.15, creases("memory"), ""),
        at_most("… time of a frame", 1.15, creases("frame"), ""),
        at_least("two threads by one", 1.8, threads.collect()),
    ]
}

fn at_least(goal: &'static str, bound: f64, values: Vec<f64>) -> Outcome {
    let reached = values.iter().filter(|&&x| x >= bound).count();
    Outcome {
        goal,
        wanted: format!("≥ {bound}×"),
        measured: range(&values).map(|r| (r, [reached, values.len()])),
        unit: "×",
    }
}

fn at_most(goal: &'static str, bound: f64, values: Vec<f64>, unit: &'static str) -> Outcome {
    let reached = values.iter().filter(|&&x| x <= bound).count();
    Outcome {
        goal,
        wanted: format!("≤ {bound}{unit}"),
        measured: range(&values).map(|r| (r, [reached, values.len()])),
        unit,
    }
}

fn range(values: &[f64]) -> Option<[f64; 2]> {
    let least = values.iter().copied().reduce(f64::min)?;
    Some([least, values.iter().copied().reduce(f64::max)?])
}

fn ratio(record: &Record, rival: &str) -> Option<f64> {
    Some(record.entry(rival)?.ratio?.median)
}

/// Far at either isolation.
fn best_far<'a>(records: impl Iterator<Item = &'a Record>) -> Vec<f64> {
    records.filter_map(|r| ratio(r, FAR_6).or_else(|| ratio(r, FAR_4))).collect()
}

fn median(entry: &Entry) -> Option<f64> {
    entry.processor.map(|p| p.median).or(entry.value)
}

fn scaling(records: &[Record]) -> Vec<f64> {
    let tables = records.iter().filter(|r| r.section == "scaling" && r.what == "patch table");
    variation(tables.filter_map(|r| median(r.entry(OURS)?)).collect())
}

/// Ours on the Car at sharpness 1 and above.
fn of_creases(records: &[Record], what: &str) -> Vec<f64> {
    let sharp = |r: &&Record| r.what.split(':').next().and_then(|s| s.parse::<f64>().ok()).is_some_and(|s| s >= 1.0);
    let chosen = records.iter().filter(|r| r.section == "creases" && r.what.ends_with(what)).filter(sharp);
    chosen.filter_map(|r| median(r.entry(OURS)?)).collect()
}

/// Most by least, where there are several.
fn variation(values: Vec<f64>) -> Vec<f64> {
    range(&values).filter(|_| values.len() > 1).map(|[least, most]| most / least).into_iter().collect()
}

fn two_threads(record: &Record) -> Option<f64> {
    Some(record.entry("1 thread")?.wall?.median / record.entry("2 threads")?.wall?.median)
}

#[cfg(test)]
mod tests {
    use super::super::record::Spread;
    use super::*;

    #[test]
    fn an_outcome_counts_what_reaches_the_goal() {
        let record = |mesh: &str, ratio: f64| Record {
            section: "refine".to_string(),
            mesh: mesh.to_string(),
            what: "level 2, cold".to_string(),
            unit: "vertex".to_string(),
            count: 1.0,
            entries: vec![Entry { name: FAR.to_string(), ratio: Spread::of(vec![ratio]), ..Entry::default() }],
        };
        let outcomes = outcomes(&[record("a", 20.0), record("b", 30.0)]);
        let refined = outcomes.iter().find(|o| o.goal.starts_with("uniform refinement, cold")).unwrap();
        assert_eq!(refined.measured, Some(([20.0, 30.0], [1, 2])));
        assert!(outcomes[0].measured.is_none());
    }
}
