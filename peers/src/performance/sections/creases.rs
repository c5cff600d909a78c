//! The Car with all its creases at one sharpness: Figure 2 of Nießner, Loop and Greiner, "Efficient evaluation of
//! semi-smooth creases in Catmull-Clark subdivision surfaces" (Eurographics short papers 2012). Time to build, memory,
//! and time of a frame: all points from new control points, and the same places evaluated.

use super::super::case::Case;
use super::super::clock;
use super::super::contest::{Contest, Effort};
use super::super::ours;
use super::super::places::Places;
use super::super::record::{Entry, Record};
use super::super::rivals::name::*;
use super::super::rivals::patches::{Frames, Patches};
use super::{Context, Emit};
use crate::opensubdiv::CShape;
use std::cell::RefCell;
use std::rc::Rc;
use subsurf::{Crease, PatchTable};

const SHARPNESSES: [f64; 14] = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0];
const RATE: u32 = 8;
/// Levels at extraordinary vertices where nothing is sharp.
const SMOOTH: u32 = 4;
/// Rounds in which our times at all sharpnesses are compared with one another, whatever others' effort; and of a quick run.
const TURNS: [usize; 2] = [101, 5];
/// Where these comparisons begin.
const SHARP: f64 = 1.0;

/// How records of ours alone, all sharpnesses in turn, are named at the end.
pub const IN_TURN: &str = "sharpnesses in turn";

/// All sharpnesses take turns, round after round, because it is their times that are compared.
pub fn run(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let quick = [1.0, 4.0, 10.0];
    let sharpnesses = if context.quick { quick.to_vec() } else { SHARPNESSES.to_vec() };
    let cases: Vec<Case> = sharpnesses.iter().map(|&sharpness| case_of(context.case, sharpness)).collect();
    let cars: Vec<Car<'_>> =
        sharpnesses.iter().zip(&cases).map(|(&sharpness, case)| Car::new(sharpness, case)).collect();

    context.run_together(cars.iter().map(build).collect()).into_iter().for_each(&mut *emit);
    let mut frames = Vec::new();
    for car in &cars {
        let (record, patches) = memory(car)?;
        emit(record);
        frames.push(Frame::new(car, patches)?);
    }
    context.run_together(frames.iter().map(Frame::contest).collect()).into_iter().for_each(&mut *emit);

    let turns = TURNS[usize::from(context.quick)];
    let often = Effort { least_rounds: turns, most_rounds: turns, ..context.effort };
    emit(builds_in_turn(&cars).run(often, &[]));
    emit(frames_in_turn(&frames).run(often, &[]));
    Ok(())
}

fn case_of(case: &Case, sharpness: f64) -> Case {
    let mut shape = case.shape.clone();
    shape.tags.creases = shape.tags.creases.iter().map(|c| Crease { sharpness, ..*c }).collect();
    Case { shape, control: case.control.clone() }
}

/// The Car at one sharpness.
struct Car<'a> {
    sharpness: f64,
    case: &'a Case,
    mesh: CShape<'a>,
    /// At creases, and at extraordinary vertices.
    isolation: [u32; 2],
}

/// Feature-adaptive refinement, and with single-crease patches.
const RIVALS: [(&str, bool); 2] = [(FAR_CREASES, false), (FAR_SINGLE, true)];

impl<'a> Car<'a> {
    fn new(sharpness: f64, case: &'a Case) -> Self {
        // As many levels as the creases need, infinitely sharp ones none.
        let levels = if sharpness < 10.0 { (sharpness.ceil() as u32).max(SMOOTH) } else { SMOOTH };
        Self { sharpness, case, mesh: CShape::new(&case.shape), isolation: [levels, SMOOTH] }
    }

    fn patches(&self, single: bool) -> Result<Patches, String> {
        Patches::with_creases(&self.mesh, &self.case.shape, self.isolation, single)
    }
}

fn build<'a>(car: &'a Car<'a>) -> Contest<'a> {
    let mut contest = Contest::new(format!("{}: build", car.sharpness), "face", car.case.faces());
    contest.enter_cold(OURS, || Ok(ours::build(car.case)));
    for (name, single) in RIVALS {
        contest.enter_cold(name, move || car.patches(single));
    }
    contest
}

/// Bytes of each, and the rivals' patches.
fn memory(car: &Car<'_>) -> Result<(Record, Vec<Patches>), String> {
    let mut entries = vec![Entry::value(OURS, ours::table_bytes(&ours::build(car.case)) as f64)];
    let mut built = Vec::new();
    for (name, single) in RIVALS {
        let (memory, patches) = clock::memory_of(|| car.patches(single));
        let patches = patches?;
        let points = 12 * patches.counts()[0];
        entries.push(match memory {
            Some(memory) => Entry {
                note: format!("{} patches", patches.counts()[1]),
                ..Entry::value(name, memory.kept as f64 + points as f64)
            },
            None => Entry::absent(name, "not known"),
        });
        built.push(patches);
    }
    let record = Record {
        section: String::new(),
        mesh: String::new(),
        what: format!("{}: memory", car.sharpness),
        unit: "bytes".to_string(),
        count: 1.0,
        entries,
    };
    Ok((record, built))
}

/// What everyone keeps between frames.
struct Frame<'a> {
    car: &'a Car<'a>,
    table: PatchTable,
    places: usize,
    rivals: Vec<Patches>,
}

impl<'a> Frame<'a> {
    fn new(car: &'a Car<'a>, mut rivals: Vec<Patches>) -> Result<Self, String> {
        let grid = Places::grid(car.case, RATE).by_face();
        rivals.iter_mut().try_for_each(|patches| patches.locate(&grid.ptex()))?;
        Ok(Self { car, table: ours::build(car.case), places: grid.len(), rivals })
    }

    fn contest(&self) -> Contest<'_> {
        let control = self.car.case.control.as_slice();
        let mut contest = Contest::new(format!("{}: frame", self.car.sharpness), "place", self.places);
        let tessellator = ours::Tessellator::new(&self.table, control, RATE, true);
        let mut samples = tessellator.samples();
        let [points, normals] = [samples.points.len(), samples.normals.len()];
        contest.enter(OURS, move || {
            tessellator.update(control, &mut samples);
            Ok(())
        });
        if normals > points {
            contest.noting(format!(
                "{:.0} % more normals: sharp edges have two",
                100.0 * (normals - points) as f64 / points as f64
            ));
        }
        let out = Rc::new(RefCell::new(Frames::new(self.places)));
        for ((name, _), patches) in RIVALS.iter().zip(&self.rivals) {
            let (mut points, out) = (patches.points(), Rc::clone(&out));
            contest.enter(name, move || {
                patches.interpolate(control, &mut points);
                patches.eval_located(&points, &mut out.borrow_mut(), true);
                Ok(())
            });
        }
        contest
    }
}

/// Our times to build, by that at sharpness 1 in the same round: what changes from minute to minute changes all of a round, and
/// many rounds are had in the time of one of the rivals'.
fn builds_in_turn<'a>(cars: &'a [Car<'a>]) -> Contest<'a> {
    let mut contest = Contest::new(format!("build, {IN_TURN}"), "face, ours", cars[0].case.faces());
    for car in cars.iter().filter(|car| car.sharpness >= SHARP) {
        contest.enter_cold(&format!("at {}", car.sharpness), || Ok(ours::build(car.case)));
    }
    contest
}

/// The same of frames. Memory to write to is given back and taken again, so that all have the same, mostly: where it lies matters as
/// well.
fn frames_in_turn<'a>(frames: &'a [Frame<'a>]) -> Contest<'a> {
    let mut contest = Contest::new(format!("frame, {IN_TURN}"), "place, ours", frames[0].places);
    for frame in frames.iter().filter(|frame| frame.car.sharpness >= SHARP) {
        let control = frame.car.case.control.as_slice();
        let tessellator = ours::Tessellator::new(&frame.table, control, RATE, true);
        contest.enter_timed(&format!("at {}", frame.car.sharpness), move || {
            let mut samples = tessellator.samples();
            tessellator.update(control, &mut samples);
            Ok(clock::spent(|| tessellator.update(control, &mut samples)).0)
        });
    }
    contest
}
