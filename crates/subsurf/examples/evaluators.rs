//! Deflated powers against the eigenbasis (Jordan form at boundaries): time, building and storage, as a markdown table.
//!
//!     cargo run --release -p subsurf --example evaluators

use std::hint::black_box;
use std::time::Instant;
use subsurf::{Location, Method, PatchTable, Scheme, shapes};

/// Rounds; in each, both methods take their turn, so that what else the machine does hits both.
const ROUNDS: usize = 31;
const METHODS: [Method; 2] = [Method::Deflated, Method::Eigenbasis];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("Position and first derivatives at one place of a face at the vertex: nanoseconds, spread over the face");
    println!("and at depth 20. The patch table of three rings round the vertex, on one thread: microseconds to build,");
    println!("bytes of plans. Medians of {ROUNDS} rounds (quartiles); D deflated powers, E eigenbasis.\n");
    println!("| vertex | spread, D | E | depth 20, D | E | build, D | E | bytes, D | E |");
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|");
    let interior = [3, 5, 8, 16, 50].map(|n| (format!("interior, valence {n}"), shapes::interior_vertex(n), 0));
    let boundary = [3, 5, 8, 50].map(|k| (format!("boundary, {k} faces"), shapes::boundary_vertex(k), k / 2));
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    for (name, shape, sector) in interior.into_iter().chain(boundary) {
        let build = |method| one_thread.install(|| PatchTable::with_method(&shape.mesh, Scheme::CatmullClark, method));
        let tables = [build(METHODS[0])?, build(METHODS[1])?];
        // Each sector has nine faces, the first of them at the vertex, which is its corner (0, 0).
        let at = |u: f64, v: f64| Location::new(9 * sector, u, v);
        let spread: Vec<Location> =
            (0..400).map(|i| at((0.618_034 * f64::from(i)).fract(), f64::from(i) / 400.0)).collect();
        let deep: Vec<Location> =
            spread.iter().map(|l| at(l.u.max(0.5) * 0.5f64.powi(20), l.v * 0.5f64.powi(20))).collect();
        let mut times = [(); 6].map(|()| Vec::with_capacity(ROUNDS));
        for _ in 0..ROUNDS {
            for (m, table) in tables.iter().enumerate() {
                let surface = table.surface(&shape.positions);
                for (k, locations) in [&spread, &deep].into_iter().enumerate() {
                    let start = Instant::now();
                    for &location in locations {
                        black_box(surface.eval(location));
                    }
                    times[2 * k + m].push(start.elapsed().as_secs_f64() * 1e9 / locations.len() as f64);
                }
                let start = Instant::now();
                black_box(build(METHODS[m])?);
                times[4 + m].push(start.elapsed().as_secs_f64() * 1e6);
            }
        }
        let cells: Vec<String> = times.iter_mut().map(|t| quartiles(t)).collect();
        let bytes = tables.each_ref().map(|t| t.size().plan_bytes);
        println!("| {name} | {} | {} | {} |", cells.join(" | "), bytes[0], bytes[1]);
    }
    Ok(())
}

fn quartiles(times: &mut [f64]) -> String {
    times.sort_by(f64::total_cmp);
    let [low, middle, high] = [1, 2, 3].map(|q| times[q * (times.len() - 1) / 4]);
    format!("{middle:.0} ({low:.0}–{high:.0})")
}
