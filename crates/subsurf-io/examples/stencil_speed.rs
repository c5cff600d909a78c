//! Stencil tables: nanoseconds per vertex to build and to apply, beside refinement level by level, as a markdown table.
//!
//! `cargo run --release -p subsurf-io --example stencil_speed -- [FILE]...`

use std::hint::black_box;
use std::time::Instant;
use subsurf::{Level, LimitStencilOptions, LimitStencilTable, PatchTable, Scheme, StencilOptions, StencilTable};
use subsurf_io::{ReadOptions, read};

/// Rounds; in each, everything takes its turn, so that what else the machine does hits all alike.
const ROUNDS: usize = 15;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut files: Vec<String> = std::env::args().skip(1).collect();
    if files.is_empty() {
        files = ["catmark_car", "spot_control_mesh"].map(|name| format!("assets/{name}.obj")).to_vec();
    }
    println!(
        "Nanoseconds per vertex of the level, medians of {ROUNDS} rounds. Refinement is of values alone, all levels"
    );
    println!(
        "from the control mesh, whose topology all take as it is; limit tables hold positions and first derivatives.\n"
    );
    println!(
        "| model | level | vertices | threads | weights per vertex | build f64 | f32 | apply f64 | f32 | refine f64 | f32 | refine / apply f64 | limit build f64 | frames f64 |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    for file in &files {
        let scene = read(file, &ReadOptions::default())?;
        let double = &scene.positions[..];
        let single: Vec<[f32; 3]> = double.iter().map(|p| p.map(|x| x as f32)).collect();
        let mut levels = vec![Level::new(&scene.mesh, Scheme::CatmullClark)?];
        let patches = PatchTable::new(&scene.mesh, Scheme::CatmullClark)?;
        for depth in 1..5 {
            levels.push(levels[depth - 1].refine()?);
            let vertices = levels[depth].topology().vertex_count();
            for threads in [1, 2] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
                let mut times = [const { Vec::new() }; 8];
                let mut weights = 0;
                for _ in 0..ROUNDS {
                    let mut k = 0;
                    let mut timed = |work: &mut (dyn FnMut() + Send)| {
                        let start = Instant::now();
                        pool.install(work);
                        times[k].push(start.elapsed().as_secs_f64() * 1e9 / vertices as f64);
                        k += 1;
                    };
                    let (mut a, mut b, mut limit) = (None, None, None);
                    let options = LimitStencilOptions::default();
                    timed(&mut || a = Some(StencilTable::<f64>::of_levels(&levels, &StencilOptions::default())));
                    timed(&mut || b = Some(StencilTable::<f32>::of_levels(&levels, &StencilOptions::default())));
                    let (a, b) = (a.expect("made")?, b.expect("made")?);
                    weights = a.weights().len();
                    timed(&mut || drop(black_box(a.apply(double))));
                    timed(&mut || drop(black_box(b.apply(&single))));
                    timed(&mut || drop(black_box(refine(&levels[..depth], double.to_vec()))));
                    timed(&mut || drop(black_box(refine(&levels[..depth], single.clone()))));
                    timed(&mut || limit = Some(LimitStencilTable::<f64>::of_level(&patches, &levels[depth], &options)));
                    let limit = limit.expect("made")?;
                    timed(&mut || drop(black_box(limit.frames(double))));
                }
                let [a, b, c, d, e, f, g, h] = times.map(median);
                let name = file.rsplit('/').next().unwrap_or(file);
                let per_vertex = weights as f64 / vertices as f64;
                println!(
                    "| {name} | {depth} | {vertices} | {threads} | {per_vertex:.1} | {a:.0} | {b:.0} | {c:.1} | {d:.1} | {e:.0} | {f:.0} | {:.1} | {g:.0} | {h:.0} |",
                    e / c
                );
            }
        }
    }
    Ok(())
}

fn refine<T: subsurf::Real>(levels: &[Level], control: Vec<[T; 3]>) -> Vec<[T; 3]> {
    levels.iter().fold(control, |values, level| level.refine_values(&values))
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
