//! From face lists to a surface that is ready to evaluate, once per connectivity; and how that grows with the mesh.

use super::super::case::{CAGES, Case};
use super::super::clock::Spent;
use super::super::contest::Contest;
use super::super::record::Record;
use super::super::rivals::embree::Embree;
use super::super::rivals::faces::FaceSurfaces;
use super::super::rivals::name::*;
use super::super::rivals::patches::Patches;
use super::super::rivals::uniform::Uniform;
use super::super::{floor, machine, ours};
use super::{Context, Emit};
use crate::opensubdiv::CShape;

/// Of more faces there is a table alone, where there is so much memory: a refinement would take more than a workstation has.
const MOST_REFINED: usize = 2_000_000;
const BYTES_BEYOND: u64 = 20 << 30;
/// At least, on used memory.
const FACES_A_MEASUREMENT: usize = 1_000_000;

pub fn run(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let (case, mesh) = (context.case, &context.mesh);
    let mut contest = Contest::new("patch table", "face", case.faces());
    contest.enter_cold(OURS, || Ok(ours::build(case)));
    for (name, isolation, most) in [(FAR_4, 4, 130_000), (FAR_6, 6, 30_000)] {
        match context.at_most(most) {
            Ok(()) => contest.enter_cold(name, move || Patches::new(mesh, &case.shape, isolation)),
            Err(why) => contest.absent(name, why),
        };
    }
    for (name, cached, most) in [(BFR, false, 30_000), (BFR_CACHED, true, 130_000)] {
        match context.at_most(most) {
            Ok(()) => contest.enter_cold(name, move || {
                let mut faces = FaceSurfaces::new(mesh, &case.shape)?;
                faces.init(cached);
                Ok(faces)
            }),
            Err(why) => contest.absent(name, why),
        };
    }
    contest.enter_timed(EMBREE, || {
        super::super::clock::release_free_memory();
        let (spent, scene) = super::super::clock::spent(|| Embree::new(mesh, &case.shape, context.control()));
        scene.map(|_| spent)
    });
    contest.noting("with its tree of boxes");
    context.run(contest, emit);
    Ok(())
}

/// The same on cages that grow; and one refinement, with the floor. All sizes take turns, round after round, because it is
/// their times that are compared. A quick run ends with the cage given.
pub fn scaling(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let Cages { names, cases, others } = Cages::load(context)?;
    let meshes: Vec<CShape<'_>> = cases.iter().map(|case| CShape::new(&case.shape)).collect();
    // The cages are in the order of the contests, the smallest first.
    let mut run = |contests: Vec<Contest<'_>>| {
        for (&name, record) in names.iter().zip(context.run_together(contests)) {
            emit(Record { mesh: name.to_string(), ..record });
        }
    };

    let tables = cases.iter().zip(&meshes).map(|(case, mesh)| {
        let mut contest = Contest::new("patch table", "face", case.faces());
        contest.enter_cold(OURS, || Ok(ours::build(case)));
        match context.at_most_of(case, 130_000) {
            Ok(()) => contest.enter_cold(FAR_4, || Patches::new(mesh, &case.shape, 4)),
            Err(why) => contest.absent(FAR_4, why),
        };
        contest
    });
    run(tables.collect());

    let refined = cases.iter().zip(&meshes).filter(|(case, _)| case.faces() <= MOST_REFINED).map(|(case, mesh)| {
        let [vertices, faces] = case.refined_counts(1);
        let mut contest = Contest::new("level 1, cold", "output vertex", vertices);
        contest.enter_cold(OURS, || Ok(ours::refine(case, 1)));
        contest.enter_cold(FAR, || {
            let refined = Uniform::new(mesh, &case.shape, 1)?;
            let mut points = refined.points(&case.control);
            refined.interpolate(&case.control, &mut points);
            Ok((refined, points))
        });
        contest.enter_cold(FLOOR, move || Ok(floor::fresh(vertices, faces)));
        contest.enter_cold(FLOOR_ORDINARY, move || Ok(floor::fresh_in_ordinary_pages(vertices, faces)));
        contest
    });
    run(refined.collect());

    for (name, faces) in others {
        let mut contest = Contest::new("patch table", "face", faces);
        contest.absent(OURS, format!("needs {} GB of memory", BYTES_BEYOND >> 30));
        emit(Record { mesh: name.to_string(), ..contest.run(context.effort, &[]) });
    }
    Ok(())
}

/// Our tables of cages that grow, on memory that was used before: without what the system takes for fresh pages.
pub fn scaling_in_used_memory(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let Cages { names, cases, .. } = Cages::load(context)?;
    let tables = cases.iter().map(|case| {
        let mut contest = Contest::new("patch table", "face", case.faces());
        // As many faces a measurement, so that what others left in the caches matters to none.
        let times = (FACES_A_MEASUREMENT / case.faces()).max(1);
        contest.enter_timed(OURS, move || {
            let (spent, ()) = super::super::clock::spent(|| (0..times).for_each(|_| drop(ours::build(case))));
            Ok(Spent { processor: spent.processor / times as f64, wall: spent.wall / times as f64 })
        });
        contest
    });
    for (&name, record) in names.iter().zip(context.run_together(tables.collect())) {
        emit(Record { mesh: name.to_string(), ..record });
    }
    Ok(())
}

/// Cages that grow, the smallest first.
struct Cages {
    names: Vec<&'static str>,
    cases: Vec<Case>,
    /// Those that this machine has too little memory for, and their faces.
    others: Vec<(&'static str, usize)>,
}

impl Cages {
    /// All, but of a quick run.
    fn load(context: &Context<'_>) -> Result<Self, String> {
        let much = machine::memory_bytes().is_some_and(|bytes| bytes >= BYTES_BEYOND);
        let all = CAGES.iter().copied().filter(|(_, faces)| !context.quick || *faces < 2 * context.case.faces());
        let (fit, others): (Vec<_>, Vec<_>) = all.partition(|(_, faces)| much || *faces <= MOST_REFINED);
        let names: Vec<&str> = fit.iter().map(|(name, _)| *name).collect();
        let cases = names.iter().map(|name| Case::load(name, &[])).collect::<Result<_, _>>()?;
        Ok(Self { names, cases, others })
    }
}
