//! Stencil tables: building them, from face lists, and applying them.

use super::super::contest::Contest;
use super::super::places::Places;
use super::super::rivals::kernels::{self, KernelMesh};
use super::super::rivals::name::*;
use super::super::rivals::patches::{Frames, LimitStencils, Patches};
use super::super::rivals::uniform::{Stencils, Uniform};
use super::super::{floor, ours};
use super::{Context, Emit, agreement};
use std::cell::RefCell;

pub fn refined(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let (case, mesh) = (context.case, &context.mesh);
    let level = if case.faces() > 50_000 { 1 } else { 2 };
    let [vertices, _] = case.refined_counts(level);
    let kernel_mesh = KernelMesh::new(&case.shape);
    let control = context.control();
    let ours_table = ours::stencils(case, level);
    let osd = Stencils::new(&Uniform::new(mesh, &case.shape, level)?);
    let (mut a, mut b) = (vec![[0f32; 3]; vertices], vec![[0f32; 3]; vertices]);
    ours::apply_stencils(&ours_table, control, &mut a);
    osd.apply(control, &mut b);
    let agrees = agreement(case, &a, &b);

    let mut contest = Contest::new(format!("level {level}, build"), "row", vertices);
    contest.enter_cold(OURS, || Ok(ours::stencils(case, level)));
    contest.enter_cold(FAR, || Ok(Stencils::new(&Uniform::new(mesh, &case.shape, level)?)));
    contest.enter_cold(KERNELS, || {
        let refined = kernel_mesh.refine(level)?;
        kernels::compose(&refined, case.control.len())
    });
    context.run(contest, emit);

    let composed = kernel_mesh.refine(level).and_then(|refined| kernels::compose(&refined, case.control.len()));
    let wide: Vec<[f32; 4]> = control.iter().map(|p| [p[0], p[1], p[2], 1.0]).collect();
    let out = RefCell::new(a);
    let out_wide = RefCell::new(vec![[0f32; 4]; vertices]);
    let mut contest = Contest::new(format!("level {level}, apply"), "row", vertices);
    contest.enter(OURS, || {
        ours::apply_stencils(&ours_table, control, &mut out.borrow_mut());
        Ok(())
    });
    contest.enter(OSD_XYZ, || {
        osd.apply(control, &mut out.borrow_mut());
        Ok(())
    });
    contest.noting(agrees);
    contest.enter(OSD_XYZW, || {
        osd.apply(&wide, &mut out_wide.borrow_mut());
        Ok(())
    });
    match &composed {
        Ok(table) => contest.enter(KERNELS, || Ok(table.interpolate(control))),
        Err(why) => contest.absent(KERNELS, why.clone()),
    };
    contest.enter(FLOOR, || {
        floor::renew(&mut out.borrow_mut(), 0.0);
        Ok(())
    });
    context.run(contest, emit);
    Ok(())
}

/// Positions and first derivatives at random places, face after face: rows as a bake or a simulation has them.
pub fn limit(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let (case, mesh) = (context.case, &context.mesh);
    // Far takes some tens of microseconds a place.
    let places = Places::random(case, if context.quick { 2_000 } else { 10_000 }).by_face();
    let (at, ptex) = (places.ours(), places.ptex());
    let table = ours::build(case);
    let patches = Patches::new(mesh, &case.shape, 4)?;

    let mut contest = Contest::new("build", "place", places.len());
    contest.enter_cold(OURS, || Ok(ours::limit_stencils(&table, &at)));
    contest.enter_cold(FAR_4, || Ok(LimitStencils::new(&patches, &ptex)));
    context.run(contest, emit);

    let ours_table = ours::limit_stencils(&table, &at);
    let far = LimitStencils::new(&patches, &ptex);
    let control = context.control();
    let mut out = vec![[[0f32; 3]; 3]; places.len()];
    if far.len() != places.len() {
        return Err(format!("Far makes {} limit stencils of {} places", far.len(), places.len()));
    }
    let mut frames = Frames::new(places.len());
    let floor_out = RefCell::new(vec![[0f32; 9]; places.len()]);
    let mut contest = Contest::new("apply", "place", places.len());
    contest.enter(OURS, || {
        ours::apply_limit_stencils(&ours_table, control, &mut out);
        Ok(())
    });
    contest.enter(FAR_4, || {
        far.apply(control, &mut frames);
        Ok(())
    });
    contest.enter(FLOOR, || {
        floor::renew(&mut floor_out.borrow_mut(), 0.0);
        Ok(())
    });
    context.run(contest, emit);
    Ok(())
}
