//! The same work on one thread, two, four, … up to all processors, by the clock on the wall; and whether the results are
//! the same bits.

use super::super::case::Case;
use super::super::contest::Contest;
use super::super::goals::ARITHMETIC;
use super::super::ours;
use super::super::places::Places;
use super::super::rivals::uniform::{Stencils, Uniform};
use super::{Context, Emit};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::{Mutex, MutexGuard};

pub fn run(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let (case, control) = (context.case, context.control());
    let most = std::thread::available_parallelism().map_or(1, usize::from);
    let pools = (0..)
        .map(|i| 1 << i)
        .take_while(|&n| n < most)
        .chain([most])
        .map(|n| ThreadPoolBuilder::new().num_threads(n).build().map_err(|e| e.to_string()))
        .collect::<Result<Vec<ThreadPool>, String>>()?;
    let level = if case.faces() > 500_000 { 1 } else { 2 };
    let [vertices, _] = case.refined_counts(level);
    let refinement = ours::Refinement::new(case, level);
    let table = ours::build(case);
    let tessellator = ours::Tessellator::new(&table, control, 4, true);
    let places = Places::random(case, if context.quick { 50_000 } else { 500_000 }).by_face().ours();
    let surface = table.surface(control);
    let rows = Mutex::new(vec![[[0f32; 3]; 3]; places.len()]);
    let out = Mutex::new(vec![[0f32; 3]; vertices]);
    let samples = Mutex::new(tessellator.samples());
    let points = lock(&samples).points.len();

    let mut contest = |what: &str, unit, count, work: &(dyn Fn() + Sync)| {
        let mut contest = Contest::new(what, unit, count);
        for pool in &pools {
            contest.enter(&name(pool), || {
                pool.install(work);
                Ok(())
            });
        }
        context.run(contest, emit);
    };
    // What two threads are worth at this time on this machine: others may be using it.
    contest(ARITHMETIC, "step", ARITHMETIC_STEPS, &|| arithmetic());
    contest("patch table", "face", case.faces(), &|| drop(ours::build(case)));
    contest(&format!("level {level}, cold"), "output vertex", vertices, &|| drop(ours::refine(case, level)));
    contest(&format!("level {level}, warm"), "output vertex", vertices, &|| {
        refinement.update(control, &mut lock(&out))
    });
    contest("rate 4, with normals, warm", "output vertex", points, &|| {
        tessellator.update(control, &mut lock(&samples));
    });
    contest("evaluation, by face", "place", places.len(), &|| {
        ours::eval(&surface, &places, &mut lock(&rows));
    });
    // Of OpenSubdiv's work that of applying stencils is split most easily: by rows.
    if vertices <= 500_000 {
        let stencils = Stencils::new(&Uniform::new(&context.mesh, &case.shape, level)?);
        contest(&format!("level {level}, Osd stencils"), "output vertex", vertices, &|| {
            split(&stencils, control, &mut lock(&out));
        });
    }
    same_bits(case, &pools, level, &tessellator, &refinement)
}

const ARITHMETIC_STEPS: usize = 1 << 22;

/// Steps that need no memory, in sixty-four equal parts.
fn arithmetic() {
    (0..64u64).into_par_iter().for_each(|part| {
        let steps = 0..ARITHMETIC_STEPS as u64 / 64;
        std::hint::black_box(steps.fold(part, |x, i| std::hint::black_box(x.wrapping_mul(0x9e37_79b9) ^ i)));
    });
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().expect("nothing panics meanwhile")
}

fn name(pool: &ThreadPool) -> String {
    match pool.current_num_threads() {
        1 => "1 thread".to_string(),
        n => format!("{n} threads"),
    }
}

fn split(stencils: &Stencils, control: &[[f32; 3]], out: &mut [[f32; 3]]) {
    let rows = out.len().div_ceil(rayon::current_num_threads());
    out.par_chunks_mut(rows).enumerate().for_each(|(i, part)| {
        stencils.apply_rows(i * rows..i * rows + part.len(), control, part);
    });
}

fn same_bits(
    case: &Case,
    pools: &[ThreadPool],
    level: u32,
    tessellator: &ours::Tessellator<'_, f32>,
    refinement: &ours::Refinement,
) -> Result<(), String> {
    let results = |pool: &ThreadPool| {
        pool.install(|| {
            let cold = ours::refine(case, level);
            let mut warm = vec![[0.0; 3]; cold.positions.len()];
            let mut samples = tessellator.samples();
            refinement.update(&case.control, &mut warm);
            tessellator.update(&case.control, &mut samples);
            (cold.positions, cold.corners, warm, samples)
        })
    };
    let first = results(&pools[0]);
    match pools[1..].iter().all(|pool| results(pool) == first) {
        true => Ok(()),
        false => Err("results depend on the number of threads".to_string()),
    }
}
