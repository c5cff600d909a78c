//! What is wanted, beside what was measured.

use super::case::{CAR, CHARACTER};
use super::record::{Entry, Record};
use super::rivals::name::*;
use super::sections::IN_TURN;

/// One goal and how far it is reached.
pub struct Outcome {
    pub goal: &'static str,
    pub wanted: String,
    /// Least and most of what was measured, and of how many measurements how many reach the goal.
    pub measured: Option<([f64; 2], [usize; 2])>,
    /// The same of a program that only writes the output, where that was measured: no other can do better.
    pub floor: Option<([f64; 2], [usize; 2])>,
    pub unit: &'static str,
}

/// A measurement in which another was faster.
pub struct Behind {
    pub what: String,
    pub rival: String,
    /// Their time by ours.
    pub ratio: f64,
}

/// Every one, and of how many comparisons. Memory and threads are told apart, and so are what we compare of ours.
pub fn behind(records: &[Record]) -> (Vec<Behind>, usize) {
    const OTHERS: [&str; 5] = [FLOOR, FLOOR_ORDINARY, OURS_SINGLE, OUR_STENCILS, OURS_ANEW];
    let compared = |r: &&Record| !["memory", "threads"].contains(&r.section.as_str()) && !r.what.ends_with(IN_TURN);
    let (mut out, mut count) = (Vec::new(), 0);
    for record in records.iter().filter(compared) {
        for entry in record.entries.iter().filter(|e| !OTHERS.contains(&e.name.as_str())) {
            let Some(ratio) = entry.ratio.map(|ratio| ratio.median) else { continue };
            count += 1;
            if ratio < 1.0 {
                let Record { section, mesh, what, .. } = record;
                out.push(Behind { what: format!("{section}: {mesh}, {what}"), rival: entry.name.clone(), ratio });
            }
        }
    }
    (out, count)
}

/// All goals, in the order of the document.
pub fn outcomes(records: &[Record]) -> Vec<Outcome> {
    let far_of_build = |r: &Record| if r.mesh == CAR { FAR_6 } else { FAR_4 };
    let of = |section: &'static str, what: &'static str| {
        records.iter().filter(move |r| r.section == section && r.what.contains(what))
    };
    let ratios = |section, what, rival: &'static str| -> Vec<Beside> {
        of(section, what).filter_map(|r| Beside::of(r, rival)).collect()
    };
    let tessellated = |normals: &'static str, state: &'static str, rival: &'static str| -> Vec<Beside> {
        of("tessellate", normals).filter(|r| r.what.ends_with(state)).filter_map(|r| Beside::of(r, rival)).collect()
    };
    // How many times as long as writing the output ours takes.
    let inverse = |values: Vec<Beside>| values.into_iter().map(|x| 1.0 / x.ours).collect();
    let above_floor = |section, what| inverse(ratios(section, what, FLOOR));
    let bytes = of("memory", "kept").filter(|r| r.mesh == CHARACTER).filter_map(|r| r.entry(OURS)?.value).collect();
    let peak = of("memory", "peak").filter_map(|r| Some(r.entry(OURS)?.value? / r.entry(FLOOR)?.value?)).collect();
    let creases = |what: &str| variation(times_of_creases(records, what));
    let (ours, others): (Vec<&Record>, Vec<&Record>) =
        of("threads", "").filter(|r| !r.what.contains("Osd")).partition(|r| !r.what.contains(ARITHMETIC));
    let [threads, ceiling] = [ours, others].map(|records| records.into_iter().filter_map(two_threads));
    vec![
        at_least(
            "build, beside OpenSubdiv's adaptive set-up (isolation 6 on the Car, else 4)",
            50.0,
            of("build", "").filter_map(|r| Beside::of(r, far_of_build(r))).collect(),
        ),
        at_least("… beside Bfr's initialisation of all faces, without its cache", 10.0, ratios("build", "", BFR)),
        at_most("bytes a face of the character's table", 200.0, bytes, ""),
        at_most("build: slowest by fastest time a face, 10⁴ to 10⁷ faces", 1.15, scaling(records, "scaling"), ""),
        at_most("… on memory used before", 1.15, scaling(records, "scaling-used"), ""),
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
        at_most("… memory", 1.15, variation(memory_of_creases(records)), ""),
        at_most("… time of a frame", 1.15, creases("frame"), ""),
        at_least("two threads by one", 1.8, threads.map(Beside::alone).collect()),
        at_least("… of arithmetic that shares nothing", 1.8, ceiling.map(Beside::alone).collect()),
    ]
}

/// What the time on two threads of work that shares nothing is called.
pub const ARITHMETIC: &str = "arithmetic alone";

/// A rival's time by ours, and by that of writing the output.
#[derive(Clone, Copy)]
struct Beside {
    ours: f64,
    floor: Option<f64>,
}

impl Beside {
    fn of(record: &Record, rival: &str) -> Option<Self> {
        let ours = ratio(record, rival)?;
        Some(Self { ours, floor: ratio(record, FLOOR).map(|floor| ours / floor) })
    }

    fn alone(ours: f64) -> Self {
        Self { ours, floor: None }
    }
}

fn at_least(goal: &'static str, bound: f64, values: Vec<Beside>) -> Outcome {
    let told = |values: Vec<f64>| {
        let reached = values.iter().filter(|&&x| x >= bound).count();
        range(&values).map(|r| (r, [reached, values.len()]))
    };
    Outcome {
        goal,
        wanted: format!("≥ {bound}×"),
        measured: told(values.iter().map(|beside| beside.ours).collect()),
        floor: told(values.iter().filter_map(|beside| beside.floor).collect()),
        unit: "×",
    }
}

fn at_most(goal: &'static str, bound: f64, values: Vec<f64>, unit: &'static str) -> Outcome {
    let reached = values.iter().filter(|&&x| x <= bound).count();
    Outcome {
        goal,
        wanted: format!("≤ {bound}{unit}"),
        measured: range(&values).map(|r| (r, [reached, values.len()])),
        floor: None,
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
fn best_far<'a>(records: impl Iterator<Item = &'a Record>) -> Vec<Beside> {
    records.filter_map(|r| Beside::of(r, FAR_6).or_else(|| Beside::of(r, FAR_4))).collect()
}

fn median(entry: &Entry) -> Option<f64> {
    entry.processor.map(|p| p.median).or(entry.value)
}

fn scaling(records: &[Record], section: &str) -> Vec<f64> {
    let tables = records.iter().filter(|r| r.section == section && r.what == "patch table");
    variation(tables.filter_map(|r| median(r.entry(OURS)?)).collect())
}

/// Bytes of ours on the Car at sharpness 1 and above.
fn memory_of_creases(records: &[Record]) -> Vec<f64> {
    let sharp = |r: &&Record| r.what.split(':').next().and_then(|s| s.parse::<f64>().ok()).is_some_and(|s| s >= 1.0);
    let chosen = records.iter().filter(|r| r.section == "creases" && r.what.ends_with("memory")).filter(sharp);
    chosen.filter_map(|r| median(r.entry(OURS)?)).collect()
}

/// Times there, each by that at sharpness 1 in the same round.
fn times_of_creases(records: &[Record], what: &str) -> Vec<f64> {
    let what = format!("{what}, {IN_TURN}");
    let all = records.iter().filter(|r| r.section == "creases" && r.what == what).flat_map(|r| &r.entries);
    let mut times: Vec<f64> = all.filter_map(|entry| entry.ratio).map(|ratio| ratio.median).collect();
    if !times.is_empty() {
        times.push(1.0);
    }
    times
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
            entries: [(FAR, ratio), (FLOOR, 0.5)]
                .map(|(name, x)| Entry { name: name.to_string(), ratio: Spread::of(vec![x]), ..Entry::default() })
                .to_vec(),
        };
        let outcomes = outcomes(&[record("a", 20.0), record("b", 30.0)]);
        let refined = outcomes.iter().find(|o| o.goal.starts_with("uniform refinement, cold")).unwrap();
        assert_eq!(refined.measured, Some(([20.0, 30.0], [1, 2])));
        // Who writes only takes half of our time.
        assert_eq!(refined.floor, Some(([40.0, 60.0], [2, 2])));
        assert!(outcomes[0].measured.is_none());
    }

    #[test]
    fn a_rival_is_ahead_where_it_takes_less_time_and_writing_is_no_rival() {
        let entry = |name: &str, x| Entry { name: name.to_string(), ratio: Spread::of(vec![x]), ..Entry::default() };
        let record = |section: &str| Record {
            section: section.to_string(),
            mesh: "a".to_string(),
            what: "b".to_string(),
            unit: "vertex".to_string(),
            count: 1.0,
            entries: vec![entry(FAR, 3.0), entry(KERNELS, 0.5), entry(FLOOR, 0.1)],
        };
        let in_turn = Record { what: format!("build, {IN_TURN}"), ..record("creases") };
        let (behind, count) = behind(&[record("refine"), record("memory"), in_turn]);
        assert_eq!((behind.len(), count), (1, 2));
        assert_eq!((behind[0].rival.as_str(), behind[0].ratio), (KERNELS, 0.5));
    }
}
