//! Uniform refinement: cold, from face lists and positions to the positions and faces of a level; and warm, new positions
//! on the same mesh.

use super::super::case::Case;
use super::super::clock::Spent;
use super::super::contest::Contest;
use super::super::rivals::HALF_EDGE_PROGRAM;
use super::super::rivals::kernels::{self, KernelMesh};
use super::super::rivals::name::*;
use super::super::rivals::program::{MeshFile, Program};
use super::super::rivals::uniform::{Stencils, Uniform};
use super::super::{floor, ours};
use super::{Context, Emit, agreement, agreement_in_any_order, moments, moments_apart, remark};
use std::cell::RefCell;

/// More vertices take `subdiv-kernels` seconds, and their tables gigabytes.
const MOST_OF_KERNELS: usize = 700_000;

/// Levels of which the finest has some million vertices at most.
fn levels(context: &Context<'_>) -> Vec<u32> {
    let most = if context.quick { 200_000 } else { 1_800_000 };
    let fit = (1..=4u32).filter(|&level| context.case.faces() << (2 * level) <= most).collect::<Vec<_>>();
    let finest = fit.last().copied().unwrap_or(1);
    let first = if context.quick { finest } else { finest.saturating_sub(1).max(1) };
    (first..=finest).collect()
}

pub fn cold(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let (case, mesh) = (context.case, &context.mesh);
    let control = context.control();
    let kernel_mesh = KernelMesh::new(&case.shape);
    for level in levels(context) {
        let [vertices, faces] = case.refined_counts(level);
        let mut half_edge = HalfEdge::start(case, level);
        let expected = ours::refine(case, level).positions;
        let far = || -> Result<_, String> {
            let refined = Uniform::new(mesh, &case.shape, level)?;
            let mut points = refined.points(control);
            refined.interpolate(control, &mut points);
            Ok((refined, points))
        };
        let far_agrees = far().map(|(refined, points)| agreement(case, &expected, refined.last(&points)));
        let refine_kernels = || -> Result<_, String> {
            if vertices > MOST_OF_KERNELS {
                return Err("not run: takes too long".to_string());
            }
            let refined = kernel_mesh.refine(level)?;
            let points = kernels::interpolate(&refined, control)?;
            Ok((refined, points))
        };
        let kernels_agree = refine_kernels().map(|(_, points)| agreement_in_any_order(case, &expected, &points));
        let half_edge_agrees = half_edge.agreement(case, &expected);

        let mut contest = Contest::new(format!("level {level}, cold"), "output vertex", vertices);
        contest.enter_cold(OURS, || Ok(ours::refine(case, level)));
        contest.enter_cold(FAR, far).noting(far_agrees.unwrap_or_default());
        contest.enter_cold(KERNELS, refine_kernels).noting(kernels_agree.unwrap_or_default());
        contest.enter_timed(HALF_EDGE, || half_edge.order("cold")).noting(half_edge_agrees);
        contest.enter_cold(FLOOR, || Ok(floor::fresh(vertices, faces)));
        contest.enter_cold(FLOOR_ORDINARY, || Ok(floor::fresh_in_ordinary_pages(vertices, faces)));
        context.run(contest, emit);
    }
    Ok(())
}

pub fn warm(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let (case, mesh) = (context.case, &context.mesh);
    let frames: Vec<Vec<[f32; 3]>> = (0..4).map(|i| case.frame(i)).collect();
    let wide: Vec<Vec<[f32; 4]>> = frames.iter().map(|f| f.iter().map(|p| [p[0], p[1], p[2], 1.0]).collect()).collect();
    for level in levels(context) {
        let [vertices, _] = case.refined_counts(level);
        let mut half_edge = HalfEdge::start(case, level);
        let refinement = ours::Refinement::new(case, level);
        let far = Uniform::new(mesh, &case.shape, level)?;
        let points = RefCell::new(far.points(context.control()));
        let kernel_mesh = KernelMesh::new(&case.shape);
        // Tables take ten times the memory of what they make.
        let tables = vertices <= MOST_OF_KERNELS;
        let kernels_refined =
            if tables { kernel_mesh.refine(level) } else { Err("not run: takes too long".to_string()) };
        let our_table = tables.then(|| ours::stencils(case, level));
        let osd_table = tables.then(|| Stencils::new(&far));
        let composed = match &kernels_refined {
            Ok(refined) => kernels::compose(refined, case.control.len()),
            Err(why) => Err(why.clone()),
        };
        let out = RefCell::new(vec![[0f32; 3]; vertices]);
        let out_wide = RefCell::new(vec![[0f32; 4]; vertices]);
        let next = counter();

        let mut contest = Contest::new(format!("level {level}, warm"), "output vertex", vertices);
        contest.enter(OURS, || {
            refinement.update(&frames[next()], &mut out.borrow_mut());
            Ok(())
        });
        match &our_table {
            Some(table) => contest.enter(OUR_STENCILS, || {
                ours::apply_stencils(table, &frames[next()], &mut out.borrow_mut());
                Ok(())
            }),
            None => contest.absent(OUR_STENCILS, "not run: too large"),
        };
        contest.enter(FAR, || {
            far.interpolate(&frames[next()], &mut points.borrow_mut());
            Ok(())
        });
        match &osd_table {
            Some(table) => {
                contest.enter(OSD_XYZ, || {
                    table.apply(&frames[next()], &mut out.borrow_mut());
                    Ok(())
                });
                contest.enter(OSD_XYZW, || {
                    table.apply(&wide[next()], &mut out_wide.borrow_mut());
                    Ok(())
                });
            }
            None => {
                contest.absent(OSD_XYZ, "not run: too large").absent(OSD_XYZW, "not run: too large");
            }
        }
        match &kernels_refined {
            Ok(refined) => contest.enter(KERNELS, || kernels::interpolate(refined, &frames[next()])),
            Err(why) => contest.absent(KERNELS, why.clone()),
        };
        match &composed {
            Ok(table) => contest.enter(KERNELS_STENCILS, || Ok(table.interpolate(&frames[next()]))),
            Err(why) => contest.absent(KERNELS_STENCILS, why.clone()),
        };
        contest.enter_timed(HALF_EDGE, || half_edge.order("warm"));
        contest.enter(FLOOR, || {
            floor::renew(&mut out.borrow_mut(), next() as f32);
            Ok(())
        });
        context.run(contest, emit);
    }
    Ok(())
}

/// 0, 1, 2, 3, 0, …: which frame is next.
pub fn counter() -> impl Fn() -> usize {
    let count = std::cell::Cell::new(0);
    move || {
        count.set(count.get() + 1);
        count.get() % 4
    }
}

/// The program that refines by half-edges, or why there is none.
struct HalfEdge {
    program: Result<Program, String>,
    _file: Option<MeshFile>,
}

impl HalfEdge {
    fn start(case: &Case, level: u32) -> Self {
        if std::env::var_os(HALF_EDGE_PROGRAM).is_none() {
            return Self { program: Err("absent".to_string()), _file: None };
        }
        match MeshFile::write(&case.shape) {
            Ok(file) => Self { program: Program::start(HALF_EDGE_PROGRAM, file.path(), level), _file: Some(file) },
            Err(why) => Self { program: Err(why), _file: None },
        }
    }

    fn order(&mut self, work: &str) -> Result<Spent, String> {
        self.program.as_mut().map_err(|why| why.clone())?.order(work)
    }

    fn agreement(&mut self, case: &Case, expected: &[[f32; 3]]) -> String {
        let Ok(program) = &mut self.program else { return String::new() };
        match program.order("cold").and_then(|_| program.numbers("moments")) {
            Ok(theirs) if theirs.len() == 6 && program.vertices == expected.len() => {
                remark(moments_apart(&moments(expected), &theirs) / case.shape.diagonal())
            }
            Ok(_) => format!("has {} points, ours {}", program.vertices, expected.len()),
            Err(why) => why,
        }
    }
}
