//! One crease changes its sharpness, or one face its corners: what it takes until the surface is ready again. Others build
//! anew; so do we where we have nothing better.

use super::super::contest::Contest;
use super::super::ours;
use super::super::rivals::name::*;
use super::super::rivals::patches::Patches;
use super::{Context, Emit};
use crate::opensubdiv::CShape;

pub fn run(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let case = context.case;
    let tags = [2.0, 3.0].map(|sharpness| ours::one_more_crease(case, sharpness));
    let mut edited = case.shape.clone();
    edited.tags = tags[0].clone();
    let mesh = CShape::new(&edited);
    let next = std::cell::Cell::new(0);
    let mut contest = Contest::new("sharpness of one crease", "edit", 1);
    contest.enter(OURS, || {
        next.set(1 - next.get());
        Ok(ours::edit_crease(case, &tags[next.get()]))
    });
    match context.at_most(130_000) {
        Ok(()) => contest.enter(FAR_4, || Patches::new(&mesh, &edited, 4, false)),
        Err(why) => contest.absent(FAR_4, why),
    };
    context.run(contest, emit);
    Ok(())
}
