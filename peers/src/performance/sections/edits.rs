//! One crease changes its sharpness, or one face is cut into two: what it takes until the surface is ready again. Others
//! have no other way than to build anew.

use super::super::contest::Contest;
use super::super::ours;
use super::super::rivals::name::*;
use super::super::rivals::patches::Patches;
use super::{Context, Emit};
use crate::opensubdiv::CShape;

pub fn run(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let case = context.case;
    let creased = ours::one_more_crease(case, 2.0);
    let mesh = CShape::new(&creased);
    let mut editing = ours::Editing::new(case);
    let mut sharpness = 2.0;
    let mut contest = Contest::new("sharpness of one crease", "edit", 1);
    contest.enter(OURS, || {
        sharpness = 5.0 - sharpness;
        editing.crease(sharpness);
        Ok(())
    });
    others(context, &mut contest, &mesh, &creased);
    context.run(contest, emit);

    let mut editing = ours::Editing::new(case);
    let mut contest = Contest::new("one face cut, or joined again", "edit", 1);
    contest.enter(OURS, || {
        editing.cut_or_join();
        Ok(())
    });
    others(context, &mut contest, &context.mesh, &case.shape);
    context.run(contest, emit);
    Ok(())
}

/// Building anew; ours too, for comparison.
fn others<'a>(context: &Context<'a>, contest: &mut Contest<'a>, mesh: &'a CShape<'a>, shape: &'a crate::shape::Shape) {
    let case = context.case;
    contest.enter(OURS_ANEW, || Ok(ours::build(case)));
    match context.at_most(130_000) {
        Ok(()) => contest.enter(FAR_4, || Patches::new(mesh, shape, 4)),
        Err(why) => contest.absent(FAR_4, why),
    };
}
