//! The document.

use super::Results;
use super::cause::Cause;
use super::tally::{Key, Method, Quantity, Tally};
use crate::opensubdiv;
use std::collections::BTreeMap;
use std::fmt::Write;

pub fn text(results: &Results) -> String {
    let mut t = String::new();
    dump(&mut t, results);
    t
}

fn dump(t: &mut String, results: &Results) {
    let _ = writeln!(t, "OpenSubdiv {} shapes {} variants {}", opensubdiv::version(), results.shapes, results.variants);
    for (key, g) in &results.refinement.groups {
        let _ = writeln!(t, "{key:?} {g:?}");
    }
    for (key, g) in &results.channels.groups {
        let _ = writeln!(t, "{key:?} {g:?}");
    }
    for ((cause, method, quantity), y) in &results.tallies.0 {
        let _ = writeln!(
            t,
            "{:34} {:16} {:18} n {:7} agree {:8.1e} differ {:6} worst {:8.1e} judged {:5} ours {:8.1e} theirs {:8.1e} lost {}  {}",
            cause.name(),
            method.name(),
            quantity.name(),
            y.samples,
            y.agreeing,
            y.differing,
            y.worst,
            y.judged,
            y.ours_off,
            y.theirs_off,
            y.lost.len(),
            y.case.as_ref().map_or("", |c| &c.place),
        );
    }
    let _: (Option<Cause>, Option<Key>, Option<Method>, Option<Quantity>, Option<BTreeMap<u8, Tally>>) =
        (None, None, None, None, None);
}
