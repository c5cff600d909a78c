//! Animation: connectivity is compiled once, and every frame brings nothing but positions.
//!
//!     cargo run --release --example animate

use std::time::Instant;
use subsurf::{Face, LimitSurface, Location, PatchTable, Scheme, shapes};

fn main() -> Result<(), subsurf::MeshError> {
    // A flag of 40 × 25 quads; control points in single precision, as animation systems deliver them.
    let flag = shapes::grid(40, 25);
    let start = Instant::now();
    let patches = PatchTable::new(&flag.mesh, Scheme::CatmullClark)?;
    let build = start.elapsed();
    let size = patches.size();
    println!("{} faces, {} plans, table built in {build:.1?}\n", size.patches, size.plans);
    println!(" time  height of the middle row, from the pole to the loose end");

    let start = Instant::now();
    let frames = 24;
    for frame in 0..frames {
        let time = f64::from(frame) / 24.0;
        let points: Vec<[f32; 3]> = flag.positions.iter().map(|p| wave(p[0], p[1], time)).collect();
        let surface = patches.surface(&points);
        if frame % 3 == 0 {
            println!("{time:5.3}  |{}|", profile(&surface));
        }
    }
    println!("\n{frames} frames in {:.1?}", start.elapsed());
    Ok(())
}

fn wave(x: f64, y: f64, time: f64) -> [f32; 3] {
    let phase = std::f64::consts::TAU * (time - x / 20.0);
    [x, y, 0.05 * x * (phase + 0.03 * y).sin()].map(|c| c as f32)
}

/// The height at the middle of each quad of row 12 as a letter, low to high.
fn profile(surface: &LimitSurface<'_, f32, 3>) -> String {
    let height = |column: u32| {
        let at = Location { face: Face(12 * 40 + column), subface: 0, u: 0.5, v: 0.5 };
        surface.position(at).expect("no holes")[2]
    };
    let letters = b"_.-=^\"";
    (0..40).map(|c| letters[((height(c) + 2.0) / 4.0 * 5.99).clamp(0.0, 5.0) as usize] as char).collect()
}
