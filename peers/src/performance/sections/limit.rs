//! Position and first derivatives at random places, grouped by face and in random order; all set-up done before.

use super::super::contest::Contest;
use super::super::places::Places;
use super::super::rivals::embree::Embree;
use super::super::rivals::faces::FaceSurfaces;
use super::super::rivals::kernels::{self, KernelMesh};
use super::super::rivals::name::*;
use super::super::rivals::patches::{Frames, Patches};
use super::super::{floor, ours};
use super::{Context, Emit};
use std::cell::RefCell;

/// Places on a face, on average: as many as a small tessellation has, or a texture bake at low resolution.
const PER_FACE: usize = 16;

pub fn run(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let (case, mesh) = (context.case, &context.mesh);
    let count = (PER_FACE * case.faces()).clamp(30_000, if context.quick { 200_000 } else { 1_600_000 });
    let random = Places::random(case, count);
    let table = ours::build(case);
    let control = context.control();
    let surface = table.surface(control);
    // Isolation 6 of a hundred thousand faces takes gigabytes.
    let isolation = if case.faces() > 50_000 { 4 } else { 6 };
    let far_name = if isolation == 6 { FAR_6 } else { FAR_4 };
    let mut patches = Patches::new(mesh, &case.shape, isolation)?;
    let mut points = patches.points();
    patches.interpolate(control, &mut points);
    let mut surfaces = FaceSurfaces::new(mesh, &case.shape)?;
    surfaces.init(true);
    surfaces.prepare(control);
    let embree =
        if case.all_quads() { Embree::new(mesh, &case.shape, control) } else { Err("not run: quads only".to_string()) };
    // It evaluates on a refined level: as many places on the quads of level 1.
    let kernels = KernelMesh::new(&case.shape).refine(1);
    let kernel_points = kernels.as_ref().map_err(Clone::clone).and_then(|r| kernels::interpolate(r, control));
    let evaluator = match (&kernels, &kernel_points) {
        (Ok(refined), Ok(points)) => refined.limit_evaluator(points).map_err(|e| e.to_string()),
        (Err(why), _) | (_, Err(why)) => Err(why.clone()),
    };

    for (order, places) in [("by face", random.by_face()), ("random order", random)] {
        let (at, ptex, quads) = (places.ours(), places.ptex(), places.quads());
        let face_places = surfaces.places(places.at.iter().copied());
        let on_level: Vec<(u32, [f32; 2])> = at_level_1(&places, case.shape.counts.as_slice());
        patches.locate(&ptex)?;
        let out = RefCell::new(Frames::new(count));
        let rows = RefCell::new(vec![[[0f32; 3]; 3]; count]);
        let flat = RefCell::new(vec![0f32; 9 * count + 16]);
        let apart = {
            ours::eval(&surface, &at, &mut rows.borrow_mut());
            patches.eval(&points, &ptex, &mut out.borrow_mut());
            mean_apart(&rows.borrow(), &out.borrow().0[0]) / case.shape.diagonal()
        };

        let mut contest = Contest::new(order, "place", count);
        contest.enter(OURS, || {
            ours::eval(&surface, &at, &mut rows.borrow_mut());
            Ok(())
        });
        contest.enter(far_name, || {
            patches.eval(&points, &ptex, &mut out.borrow_mut());
            Ok(())
        });
        // End caps are off by some thousandths of a face near extraordinary vertices.
        contest.noting(if apart < 1e-4 { String::new() } else { format!("differs by {apart:.1e} of the size") });
        contest.enter(OSD, || {
            patches.eval_located(&points, &mut out.borrow_mut(), true);
            Ok(())
        });
        contest.noting("places looked up before");
        contest.enter(BFR, || {
            surfaces.eval(&face_places, &mut out.borrow_mut());
            Ok(())
        });
        match &embree {
            Ok(scene) => {
                contest.enter(EMBREE, || {
                    scene.eval(&quads, &mut out.borrow_mut());
                    Ok(())
                });
                contest.enter(EMBREE_MANY, || {
                    scene.eval_many(&quads, &mut flat.borrow_mut());
                    Ok(())
                });
            }
            Err(why) => {
                contest.absent(EMBREE, why.clone()).absent(EMBREE_MANY, why.clone());
            }
        }
        match &evaluator {
            Ok(evaluator) => contest.enter(KERNELS, || kernels::eval(evaluator, &on_level, &mut rows.borrow_mut())),
            Err(why) => contest.absent(KERNELS, why.clone()),
        };
        contest.enter(FLOOR, || {
            let out = &mut out.borrow_mut().0;
            out.iter_mut().for_each(|rows| floor::renew(rows, 0.0));
            Ok(())
        });
        context.run(contest, emit);
    }
    Ok(())
}

/// The places' faces of level 1: of a quad the child that the place lies in, of other faces that of the sub-face.
fn at_level_1(places: &Places, counts: &[u32]) -> Vec<(u32, [f32; 2])> {
    let first: Vec<u32> = counts
        .iter()
        .scan(0, |next, &n| {
            *next += n;
            Some(*next - n)
        })
        .collect();
    let child = |&(face, subface, [u, v]): &(u32, u32, [f32; 2])| {
        let corner = match (counts[face as usize] == 4, u < 0.5, v < 0.5) {
            (false, ..) => subface,
            (_, true, true) => 0,
            (_, false, true) => 1,
            (_, false, false) => 2,
            (_, true, false) => 3,
        };
        (first[face as usize] + corner, [u, v])
    };
    places.at.iter().map(child).collect()
}

fn mean_apart(ours: &[[[f32; 3]; 3]], theirs: &[[f32; 3]]) -> f64 {
    let apart =
        |(a, b): (&[[f32; 3]; 3], &[f32; 3])| (0..3).map(|k| f64::from(a[0][k] - b[k]).powi(2)).sum::<f64>().sqrt();
    ours.iter().zip(theirs).map(apart).sum::<f64>() / ours.len() as f64
}
