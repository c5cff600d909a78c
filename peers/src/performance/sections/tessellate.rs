//! The limit surface as a mesh with normals: cold, from face lists; and warm, new positions on the same mesh. Of others,
//! what gives as many points with normals: OpenSubdiv's uniform refinement moved to the limit (the same points), its
//! patches evaluated at as many places, Bfr face by face, and Embree.

use super::super::contest::Contest;
use super::super::places::Places;
use super::super::rivals::embree::Embree;
use super::super::rivals::faces::FaceSurfaces;
use super::super::rivals::name::*;
use super::super::rivals::patches::{Frames, Patches};
use super::super::rivals::uniform::{Precision, Uniform};
use super::super::{floor, ours};
use super::{Context, Emit, agreement};
use std::cell::RefCell;

const LEVEL: u32 = 3;

pub fn run(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let (case, mesh) = (context.case, &context.mesh);
    // About a million points at most.
    let level = if case.faces() > 10_000 { LEVEL - 1 } else { LEVEL };
    let rate = 1 << level;
    let grid = Places::grid(case, rate).by_face();
    let ptex = grid.ptex();
    let control = context.control();
    let table = ours::build(case);
    for normals in [true, false] {
        let with = if normals { "with normals" } else { "positions" };
        let sample = ours::tessellate(&table, control, rate, normals);
        let (points, facets) = (sample.positions.len(), sample.face_offsets.len() - 1);
        let refined_to_limit = || -> Result<_, String> {
            let refined = Uniform::full(mesh, &case.shape, level)?;
            let mut all = refined.points(control);
            let mut out = Frames::new(refined.vertex_count());
            limit(&refined, control, &mut all, &mut out.0, normals);
            Ok((refined, out))
        };
        let far_agrees = refined_to_limit().map(|(_, out)| sorted_agreement(context, &sample.positions, &out.0[0]));
        drop(sample);

        let mut contest = Contest::new(format!("rate {rate}, {with}, cold"), "output vertex", points);
        contest.enter_cold(OURS, || {
            let table = ours::build(case);
            let made = ours::tessellate(&table, control, rate, normals);
            Ok((table, made))
        });
        contest.enter_cold(FAR, refined_to_limit);
        contest.noting(far_agrees.unwrap_or_default());
        match context.at_most(30_000) {
            Ok(()) => contest.enter_cold(OSD, || {
                let mut patches = Patches::new(mesh, &case.shape, 4)?;
                let mut all = patches.points();
                patches.interpolate(control, &mut all);
                patches.locate(&ptex)?;
                let mut out = Frames::new(ptex.len());
                patches.eval_located(&all, &mut out, normals);
                Ok((patches, out))
            }),
            Err(why) => contest.absent(OSD, why),
        };
        if normals {
            contest.enter_cold(BFR_CACHED, || {
                let mut surfaces = FaceSurfaces::new(mesh, &case.shape)?;
                surfaces.init(true);
                surfaces.prepare(control);
                let places = surfaces.places(grid.at.iter().copied());
                let mut out = Frames::new(grid.len());
                surfaces.eval(&places, &mut out);
                Ok((surfaces, out))
            });
        }
        contest.enter_cold(FLOOR, || {
            let normals = normals.then(|| floor::fresh(points, 0));
            Ok((floor::fresh(points, facets), normals))
        });
        contest.enter_cold(FLOOR_ORDINARY, || {
            let normals = normals.then(|| floor::fresh_in_ordinary_pages(points, 0));
            Ok((floor::fresh_in_ordinary_pages(points, facets), normals))
        });
        context.run(contest, emit);
        warm(context, &table, level, normals, points, &grid, emit)?;
    }
    Ok(())
}

fn warm(
    context: &Context<'_>,
    table: &subsurf::PatchTable,
    level: u32,
    normals: bool,
    points: usize,
    grid: &Places,
    emit: Emit<'_>,
) -> Result<(), String> {
    let (case, mesh) = (context.case, &context.mesh);
    let rate = 1 << level;
    let with = if normals { "with normals" } else { "positions" };
    let frame = case.frame(1);
    let tessellator = ours::Tessellator::new(table, context.control(), rate, normals);
    let refined = Uniform::full(mesh, &case.shape, level)?;
    let refined_points = RefCell::new(refined.points(context.control()));
    let refined_out = RefCell::new(Frames::new(refined.vertex_count()));
    let mut surfaces = FaceSurfaces::new(mesh, &case.shape)?;
    surfaces.init(true);
    let face_places = surfaces.places(grid.at.iter().copied());
    let grid_out = RefCell::new(Frames::new(grid.len()));
    let quads = grid.quads();
    let embree =
        if case.all_quads() { Embree::new(mesh, &case.shape, &frame) } else { Err("not run: quads only".to_string()) };
    let mut ours_out = tessellator.samples();
    let floor_out = RefCell::new([0; 2].map(|_| vec![[0f32; 3]; points]));

    let mut patches = match context.at_most(30_000) {
        Ok(()) => Patches::new(mesh, &case.shape, 4),
        Err(why) => Err(why),
    };
    if let Ok(patches) = &mut patches {
        patches.locate(&grid.ptex())?;
    }
    let patch_points = RefCell::new(patches.as_ref().map_or_else(|_| Vec::new(), Patches::points));

    let mut contest = Contest::new(format!("rate {rate}, {with}, warm"), "output vertex", points);
    contest.enter(OURS, || {
        tessellator.update(&frame, &mut ours_out);
        Ok(())
    });
    contest.enter(FAR, || {
        limit(&refined, &frame, &mut refined_points.borrow_mut(), &mut refined_out.borrow_mut().0, normals);
        Ok(())
    });
    match &patches {
        Ok(patches) => contest.enter(OSD, || {
            let all = &mut *patch_points.borrow_mut();
            patches.interpolate(&frame, all);
            patches.eval_located(all, &mut grid_out.borrow_mut(), normals);
            Ok(())
        }),
        Err(why) => contest.absent(OSD, why.clone()),
    };
    if normals {
        contest.enter(BFR_CACHED, || {
            surfaces.prepare(&frame);
            surfaces.eval(&face_places, &mut grid_out.borrow_mut());
            Ok(())
        });
        match &embree {
            Ok(scene) => contest.enter(EMBREE, || {
                scene.eval(&quads, &mut grid_out.borrow_mut());
                Ok(())
            }),
            Err(why) => contest.absent(EMBREE, why.clone()),
        };
        contest.noting("without its commit of new positions");
    }
    contest.enter(FLOOR, || {
        let [positions, others] = &mut *floor_out.borrow_mut();
        floor::renew(positions, 1.0);
        if normals {
            floor::renew(others, 2.0);
        }
        Ok(())
    });
    context.run(contest, emit);
    Ok(())
}

/// `Interpolate` and `Limit`; with normals, tangents and their products, as ours gives unit normals.
pub fn limit<T: Precision>(
    refined: &Uniform,
    control: &[[T; 3]],
    all: &mut [[T; 3]],
    [position, du, dv]: &mut [Vec<[T; 3]>; 3],
    normals: bool,
) {
    refined.interpolate(control, all);
    refined.limit(all, position, normals.then_some([&mut du[..], &mut dv[..]]));
    if normals {
        for (a, b) in du.iter_mut().zip(dv) {
            let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            let length = T::root(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
            *a = n.map(|x| x / length);
        }
    }
}

/// The same points in another order.
fn sorted_agreement(context: &Context<'_>, ours: &[[f32; 3]], theirs: &[[f32; 3]]) -> String {
    let [ours, theirs] = [ours, theirs].map(|points| {
        let mut points = points.to_vec();
        points.sort_by(|a, b| a.partial_cmp(b).expect("points are finite"));
        points
    });
    // Points that differ by rounding may change places; their first coordinates are then still as near.
    let first = |points: &[[f32; 3]]| -> Vec<[f32; 3]> { points.iter().map(|p| [p[0], 0.0, 0.0]).collect() };
    agreement(context.case, &first(&ours), &first(&theirs))
}
