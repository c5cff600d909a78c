//! The Car with all its creases at one sharpness: Figure 2 of Nießner, Loop and Greiner, "Efficient evaluation of
//! semi-smooth creases in Catmull-Clark subdivision surfaces" (Eurographics short papers 2012). Time to build, memory,
//! and time of a frame: all points from new control points, and the same places evaluated.

use super::super::case::Case;
use super::super::clock;
use super::super::contest::Contest;
use super::super::ours;
use super::super::places::Places;
use super::super::record::{Entry, Record};
use super::super::rivals::name::*;
use super::super::rivals::patches::{Frames, Patches};
use super::{Context, Emit};
use crate::opensubdiv::CShape;
use std::cell::RefCell;
use subsurf::Crease;

const SHARPNESSES: [f64; 14] = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0];
const RATE: u32 = 8;
/// Levels at extraordinary vertices where nothing is sharp.
const SMOOTH: u32 = 4;

pub fn run(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let quick = [1.0, 4.0, 10.0];
    for sharpness in if context.quick { quick.to_vec() } else { SHARPNESSES.to_vec() } {
        let mut shape = context.case.shape.clone();
        shape.tags.creases = shape.tags.creases.iter().map(|c| Crease { sharpness, ..*c }).collect();
        let case = Case { shape, control: context.case.control.clone() };
        at(context, &case, sharpness, emit)?;
    }
    Ok(())
}

fn at(context: &Context<'_>, case: &Case, sharpness: f64, emit: Emit<'_>) -> Result<(), String> {
    let mesh = CShape::new(&case.shape);
    // As many levels as the creases need, infinitely sharp ones none; 4 at extraordinary vertices.
    let isolation = if sharpness < 10.0 { (sharpness.ceil() as u32).max(SMOOTH) } else { SMOOTH };
    let rivals = [(FAR_CREASES, false), (FAR_SINGLE, true)];

    let mut contest = Contest::new(format!("{sharpness}: build"), "face", case.faces());
    contest.enter_cold(OURS, || Ok(ours::build(case)));
    for (name, single) in rivals {
        let mesh = &mesh;
        contest.enter_cold(name, move || Patches::with_creases(mesh, &case.shape, [isolation, SMOOTH], single));
    }
    context.run(contest, emit);

    let table = ours::build(case);
    let control = case.control.as_slice();
    let mut entries = vec![Entry::value(OURS, ours::table_bytes(&table) as f64)];
    let mut built = Vec::new();
    for (name, single) in rivals {
        let (memory, patches) =
            clock::memory_of(|| Patches::with_creases(&mesh, &case.shape, [isolation, SMOOTH], single));
        let patches = patches?;
        let points = 12 * patches.counts()[0];
        match memory {
            Some(memory) => entries.push(Entry {
                note: format!("{} patches", patches.counts()[1]),
                ..Entry::value(name, memory.kept as f64 + points as f64)
            }),
            None => entries.push(Entry::absent(name, "not known")),
        }
        built.push((name, patches));
    }
    emit(Record {
        section: String::new(),
        mesh: String::new(),
        what: format!("{sharpness}: memory"),
        unit: "bytes".to_string(),
        count: 1.0,
        entries,
    });

    let grid = Places::grid(case, RATE).by_face();
    let out = RefCell::new(Frames::new(grid.len()));
    let tessellator = ours::Tessellator::new(&table, control, RATE, true);
    let mut ours_out = tessellator.samples();
    let mut contest = Contest::new(format!("{sharpness}: frame"), "place", grid.len());
    contest.enter(OURS, || {
        tessellator.update(control, &mut ours_out);
        Ok(())
    });
    for (name, patches) in &mut built {
        patches.locate(&grid.ptex())?;
        let patches = &*patches;
        let points = RefCell::new(patches.points());
        let out = &out;
        contest.enter(name, move || {
            let points = &mut *points.borrow_mut();
            patches.interpolate(control, points);
            patches.eval_located(points, &mut out.borrow_mut(), true);
            Ok(())
        });
    }
    context.run(contest, emit);
    Ok(())
}
