//! The part of the document that proves, difference by difference, who is right.

use super::{Table, grouped, short};
use crate::conformance::Results;
use crate::conformance::cause::Cause;
use crate::conformance::tally::{Case, Method, Quantity, Tally};
use crate::conformance::vector::{angle_deg, length, sub};
use std::fmt::Write;

/// How much further a place's vertex is refined in the tables.
const FURTHER: [usize; 9] = [0, 1, 2, 4, 6, 8, 10, 20, 40];

/// OpenSubdiv's ways to the limit, those of one kind together.
fn kinds() -> [(&'static str, Vec<Method>); 3] {
    let of = |keep: fn(&Method) -> bool| Method::ALL.into_iter().filter(keep).collect();
    [
        ("`Limit`", of(|m| *m == Method::Limit)),
        ("Far patches", of(|m| matches!(m, Method::Far(_) | Method::FarBSpline(_)))),
        ("Bfr", of(|m| matches!(m, Method::Bfr(..)))),
    ]
}

pub fn write(t: &mut String, results: &Results) {
    t.push_str(
        "## Where they differ: who is right

A limit is what refinement goes to, so refinement decides; and it is OpenSubdiv's own. The few faces round a place are
given to `Far::PrimvarRefiner` and refined once, what touches the place is kept and refined again, and so on, up to
ninety levels, all in double precision. No point of the limit can lie outside its ring, which shrinks to 1e-13 of the
mesh; normals are those of the ring's faces, derivatives are differences of refined points. Of the places that differ, at
least the three farthest apart of each kind, way and mesh were judged so, and others spread over the rest.

Tables give, for each quantity: places that differ, by how much at most, how many were judged, how far refinement ended
from our value and from OpenSubdiv's (the largest), and at how many places it ended nearer to OpenSubdiv's.

",
    );
    for cause in Cause::ALL {
        let mut table = Table::new(&[
            "OpenSubdiv's",
            "quantity",
            "differ",
            "by",
            "judged",
            "refined − ours",
            "refined − OpenSubdiv",
            "nearer to OpenSubdiv",
        ]);
        let mut any = false;
        for (name, methods) in kinds() {
            for quantity in Quantity::ALL {
                let Some(sum) = total(results, cause, &methods, quantity) else { continue };
                any = true;
                table.row(&[
                    name,
                    quantity.name(),
                    &grouped(sum.differing),
                    &short(sum.worst),
                    &grouped(sum.judged),
                    &if sum.judged > 0 { short(sum.ours_off) } else { "–".into() },
                    &if sum.judged > 0 { short(sum.theirs_off) } else { "–".into() },
                    &grouped(sum.lost.len()),
                ]);
            }
        }
        if !any {
            continue;
        }
        let title = cause.name();
        let _ = write!(t, "### {}{}\n\n{}\n\n{}\n", title[..1].to_uppercase(), &title[1..], cause.reason(), table.0);
        // The first kind that shows it is enough.
        for quantity in [Quantity::Position, Quantity::Normal] {
            let case = |(name, methods): (&'static str, Vec<Method>)| {
                Some((name, total(results, cause, &methods, quantity)?.case?))
            };
            if let Some((name, case)) = kinds().into_iter().find_map(case) {
                convergence(t, name, quantity, &case);
            }
        }
    }
}

/// All of one kind; none where nothing differs.
fn total(results: &Results, cause: Cause, methods: &[Method], quantity: Quantity) -> Option<Tally> {
    let mut sum = Tally::default();
    for tally in methods.iter().filter_map(|&m| results.tallies.0.get(&(cause, m, quantity))) {
        sum.merge(tally.clone());
    }
    (sum.differing > 0).then_some(sum)
}

/// The farthest place, level by level.
fn convergence(t: &mut String, name: &str, quantity: Quantity, case: &Case) {
    let witness = &case.witness;
    let off = |k: usize, value: &crate::conformance::tally::Value| -> Option<f64> {
        match quantity {
            Quantity::Position => Some(length(sub(*witness.points.get(k)?, value.position)) / case.diagonal),
            _ => Some(angle_deg((*witness.normals.get(k)?)?, value.normal?)),
        }
    };
    let shown: Vec<usize> = FURTHER.into_iter().filter(|&k| off(k, &case.ours).is_some()).collect();
    if shown.len() < 3 {
        return;
    }
    let levels: Vec<String> = shown.iter().map(usize::to_string).collect();
    let first = format!("{} after … more levels", quantity.name());
    let mut columns = vec![first.as_str()];
    columns.extend(levels.iter().map(String::as_str));
    let mut table = Table::new(&columns);
    for (title, value) in [("refined − ours", &case.ours), ("refined − OpenSubdiv", &case.theirs)] {
        let mut row = vec![title.to_string()];
        row.extend(shown.iter().map(|&k| off(k, value).map_or("–".into(), short)));
        table.row(&row);
    }
    let _ = write!(t, "{name}, {}:\n\n{}\n", case.place, table.0);
}
