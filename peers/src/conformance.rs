//! `peers conformance`: every shape under every scheme and rule that makes a difference to it, refined and in the limit,
//! OpenSubdiv beside ours, as a document.

pub mod cause;
pub mod channels;
mod limits;
mod refinement;
mod report;
mod tally;
mod variants;
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
