//! Double precision: the work of other sections beside our own in single precision, and beside OpenSubdiv where that has
//! double precision too.

use super::super::contest::Contest;
use super::super::places::Places;
use super::super::rivals::name::*;
use super::super::rivals::uniform::Uniform;
use super::super::{floor, ours};
use super::refine::counter;
use super::tessellate::limit;
use super::{Context, Emit, worse};
use std::cell::RefCell;

const FRAMES: usize = 4;

pub fn run(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let level = if context.case.faces() > 10_000 { 2 } else { 3 };
    refine(context, level, emit)?;
    tessellate(context, level, emit)?;
    evaluate(context, emit);
    Ok(())
}

/// The same numbers in double precision.
fn double(points: &[[f32; 3]]) -> Vec<[f64; 3]> {
    points.iter().map(|p| p.map(f64::from)).collect()
}

fn refine(context: &Context<'_>, level: u32, emit: Emit<'_>) -> Result<(), String> {
    let case = context.case;
    let single: Vec<_> = (0..FRAMES).map(|i| case.frame(i)).collect();
    let frames: Vec<_> = single.iter().map(|frame| double(frame)).collect();
    let [vertices, _] = case.refined_counts(level);
    let refinement = ours::Refinement::new(case, level);
    let far = Uniform::new(&context.mesh, &case.shape, level)?;
    let mut all = far.points(&frames[0]);
    let out = RefCell::new(vec![[0f64; 3]; vertices]);
    let mut out_single = vec![[0f32; 3]; vertices];
    refinement.update(&frames[0], &mut out.borrow_mut());
    far.interpolate(&frames[0], &mut all);
    let apart = apart(&out.borrow(), far.last(&all)) / case.shape.diagonal();
    let [next, next_single, next_far] = [(); 3].map(|()| counter());

    let mut contest = Contest::new(format!("level {level}, warm"), "output vertex", vertices);
    contest.enter(OURS, || {
        refinement.update(&frames[next()], &mut out.borrow_mut());
        Ok(())
    });
    contest.enter(OURS_SINGLE, || {
        refinement.update(&single[next_single()], &mut out_single);
        Ok(())
    });
    contest.enter(FAR, || {
        far.interpolate(&frames[next_far()], &mut all);
        Ok(())
    });
    contest.noting(if apart < 1e-13 { String::new() } else { format!("differs by {apart:.1e} of the size") });
    contest.enter(FLOOR, || {
        floor::renew(&mut out.borrow_mut(), 1.0);
        Ok(())
    });
    context.run(contest, emit);
    Ok(())
}

/// The largest difference of a coordinate; infinite where the numbers of points differ.
fn apart(ours: &[[f64; 3]], theirs: &[[f64; 3]]) -> f64 {
    if ours.len() != theirs.len() {
        return f64::INFINITY;
    }
    let both = ours.as_flattened().iter().zip(theirs.as_flattened());
    both.map(|(a, b)| (a - b).abs()).fold(0.0, worse)
}

fn tessellate(context: &Context<'_>, level: u32, emit: Emit<'_>) -> Result<(), String> {
    let case = context.case;
    let single = case.frame(1);
    let frame = double(&single);
    let table = ours::build(case);
    let rate = 1 << level;
    let tessellator = ours::Tessellator::new(&table, &frame, rate, true);
    let tessellator_single = ours::Tessellator::new(&table, &single, rate, true);
    let out = RefCell::new(tessellator.samples());
    let mut out_single = tessellator_single.samples();
    let refined = Uniform::full(&context.mesh, &case.shape, level)?;
    let mut all = refined.points(&frame);
    let mut limits = [0; 3].map(|_| vec![[0f64; 3]; refined.vertex_count()]);
    let points = out.borrow().points.len();

    let mut contest = Contest::new(format!("rate {rate}, with normals, warm"), "output vertex", points);
    contest.enter(OURS, || {
        tessellator.update(&frame, &mut out.borrow_mut());
        Ok(())
    });
    contest.enter(OURS_SINGLE, || {
        tessellator_single.update(&single, &mut out_single);
        Ok(())
    });
    contest.enter(FAR, || {
        limit(&refined, &frame, &mut all, &mut limits, true);
        Ok(())
    });
    contest.enter(FLOOR, || {
        let out = &mut *out.borrow_mut();
        floor::renew(&mut out.points, 1.0);
        floor::renew(&mut out.normals, 2.0);
        Ok(())
    });
    context.run(contest, emit);
    Ok(())
}

fn evaluate(context: &Context<'_>, emit: Emit<'_>) {
    let case = context.case;
    let table = ours::build(case);
    let control = double(context.control());
    let (surface, surface_single) = (table.surface(&control), table.surface(context.control()));
    let random = Places::random(case, (16 * case.faces()).clamp(30_000, 1_600_000));
    for (order, places) in [("by face", random.by_face()), ("random order", random)] {
        let at = places.ours();
        let rows = RefCell::new(vec![[[0f64; 3]; 3]; at.len()]);
        let mut rows_single = vec![[[0f32; 3]; 3]; at.len()];
        let mut contest = Contest::new(order, "place", at.len());
        contest.enter(OURS, || {
            ours::eval(&surface, &at, &mut rows.borrow_mut());
            Ok(())
        });
        contest.enter(OURS_SINGLE, || {
            ours::eval(&surface_single, &at, &mut rows_single);
            Ok(())
        });
        contest.enter(FLOOR, || {
            floor::renew(rows.borrow_mut().as_flattened_mut(), 0.0);
            Ok(())
        });
        context.run(contest, emit);
    }
}
