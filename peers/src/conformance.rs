//! `peers conformance`: every shape under every scheme and rule that makes a difference to it, refined and in the limit,
//! OpenSubdiv beside ours, as a document.

pub mod cause;
pub mod channels;
mod limits;
pub mod place;
mod refinement;
mod report;
mod tally;
mod variants;
mod vector;
pub mod witness;

use crate::compare_refine::{SCHEMES, round_sharpness};
use crate::shape::{Shape, shapes};
use channels::Channels;
use rayon::prelude::*;
use refinement::Refinement;
use std::path::Path;
use tally::Tallies;

/// Everything that the document tells.
#[derive(Default)]
struct Results {
    shapes: usize,
    variants: usize,
    refinement: Refinement,
    tallies: Tallies,
    one_sided: Vec<String>,
    not_run: Vec<String>,
    channels: Channels,
    failures: Vec<String>,
}

impl Results {
    fn of_shape(shape: &Shape) -> Self {
        let mut out = Self { shapes: 1, ..Self::default() };
        match variants::variants(shape) {
            Err(message) => out.failures.push(message),
            Ok(variants) => {
                for variant in variants {
                    out.variants += 1;
                    if let Err(message) = out.add(&variant) {
                        out.failures.push(format!("{}: {message}", variant.name()));
                    }
                }
            }
        }
        out
    }

    fn add(&mut self, variant: &variants::Variant) -> Result<(), String> {
        if refinement::run(variant, &mut self.refinement)? {
            let limits = limits::compare(variant)?;
            self.tallies.merge(limits.tallies);
            self.one_sided.extend(limits.one_sided);
            self.not_run.extend(limits.not_run);
            channels::run(variant, &mut self.channels)?;
        }
        Ok(())
    }

    fn merge(mut self, other: Self) -> Self {
        self.shapes += other.shapes;
        self.variants += other.variants;
        self.refinement.merge(other.refinement);
        self.tallies.merge(other.tallies);
        self.one_sided.extend(other.one_sided);
        self.not_run.extend(other.not_run);
        self.channels.merge(other.channels);
        self.failures.extend(other.failures);
        self
    }

    /// What must not be: a mesh that differs, or a place where refinement speaks for OpenSubdiv.
    fn faults(&self) -> Vec<String> {
        let lost = self.tallies.0.iter().flat_map(|((cause, method, quantity), tally)| {
            let what = format!("{}, {}, {}", cause.name(), method.name(), quantity.name());
            tally.lost.iter().map(move |place| format!("{what}: {place}"))
        });
        let mismatches =
            self.refinement.mismatches.iter().chain(&self.failures).chain(&self.one_sided).chain(&self.channels.faults);
        mismatches.cloned().chain(lost).collect()
    }
}

/// Writes the document; `folder` holds the shapes.
///
/// # Errors
/// Files that cannot be read or written, and what the document counts as faults.
pub fn run(folder: &Path, out: &Path) -> Result<(), String> {
    let all: Vec<Shape> = shapes(folder, &SCHEMES)?.into_iter().map(round_sharpness).collect();
    let each: Vec<Results> = all
        .par_iter()
        .with_max_len(1)
        .map(|shape| {
            let results = Results::of_shape(shape);
            eprintln!("{:32} {} variants, {} faults", shape.name, results.variants, results.faults().len());
            results
        })
        .collect();
    let results = each.into_iter().fold(Results::default(), Results::merge);
    std::fs::write(out, report::text(&results)).map_err(|e| format!("{}: {e}", out.display()))?;
    let faults = results.faults();
    faults.iter().for_each(|fault| println!("{fault}"));
    if faults.is_empty() { Ok(()) } else { Err(format!("{} faults", faults.len())) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tally::{Method, Quantity};

    #[test]
    fn wherever_limits_differ_refinement_goes_to_ours() {
        // A cube with a dart at either end of an edge and a semi-sharp corner; under Loop its faces halved; a seam.
        let cube = "v -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 -1\nv 1 -1 -1\n\
            vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n";
        let quads = "f 1/1 2/2 4/4 3/3\nf 3/3 4/4 6/2 5/1\nf 5/1 6/2 8/4 7/3\nf 7/3 8/4 2/2 1/1\nf 2/2 8/4 6/2 4/4\n\
            f 7/3 1/1 3/3 5/1\n";
        let tags = "t crease 2/1/0 0 1 10\nt corner 1/1/0 5 2.5\n";
        let triangles = "f 1/1 2/2 4/4\nf 1/1 4/4 3/3\nf 3 4 6\nf 3 6 5\nf 5 6 8\nf 5 8 7\nf 7 8 2\nf 7 2 1\nf 2 8 6\n\
            f 2 6 4\nf 7 1 3\nf 7 3 5\n";
        for (name, faces) in [("catmark_cube", quads), ("loop_cube", triangles)] {
            let shape = Shape::parse(name, &format!("{cube}{faces}{tags}")).unwrap();
            let results = Results::of_shape(&shape);
            assert_eq!(results.faults(), Vec::<String>::new(), "{name}");
            let judged = |cause| {
                let tally = &results.tallies.0[&(cause, Method::Limit, Quantity::Position)];
                assert!(tally.differing > 0 && tally.judged > 0 && tally.theirs_off > 1e-3, "{name} {cause:?}");
                assert!(tally.ours_off < 1e-8, "{name} {cause:?}: {:e}", tally.ours_off);
            };
            judged(cause::Cause::Dart);
            judged(cause::Cause::SemiSharp);
            let report = report::text(&results);
            assert!(report.ends_with("none.\n"), "{report}");
        }
    }
}
