//! From face lists to a surface that is ready to evaluate, once per connectivity; and how that grows with the mesh.

use super::super::contest::Contest;
use super::super::rivals::embree::Embree;
use super::super::rivals::faces::FaceSurfaces;
use super::super::rivals::name::*;
use super::super::rivals::patches::Patches;
use super::super::rivals::uniform::Uniform;
use super::super::{floor, ours};
use super::{Context, Emit};

/// The refinement of more faces would take more memory than a workstation has.
const MOST_REFINED: usize = 2_000_000;

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

/// The same on cages that grow; and one refinement, with the floor.
pub fn scaling(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let (case, mesh) = (context.case, &context.mesh);
    let mut contest = Contest::new("patch table", "face", case.faces());
    contest.enter_cold(OURS, || Ok(ours::build(case)));
    match context.at_most(130_000) {
        Ok(()) => contest.enter_cold(FAR_4, || Patches::new(mesh, &case.shape, 4)),
        Err(why) => contest.absent(FAR_4, why),
    };
    context.run(contest, emit);
    if case.faces() > MOST_REFINED {
        return Ok(());
    }

    let [vertices, faces] = case.refined_counts(1);
    let mut contest = Contest::new("level 1, cold", "output vertex", vertices);
    contest.enter_cold(OURS, || Ok(ours::refine(case, 1)));
    contest.enter_cold(FAR, || {
        let refined = Uniform::new(mesh, &case.shape, 1)?;
        let mut points = refined.points(context.control());
        refined.interpolate(context.control(), &mut points);
        Ok((refined, points))
    });
    contest.enter_cold(FLOOR, || Ok(floor::fresh(vertices, faces)));
    contest.enter_cold(FLOOR_ORDINARY, || Ok(floor::fresh_in_ordinary_pages(vertices, faces)));
    context.run(contest, emit);
    Ok(())
}
