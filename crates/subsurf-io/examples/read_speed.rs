//! Reads an OBJ file, or one of some 250 MB made up in memory, and says how fast.
//!
//! `cargo run --release -p subsurf-io --example read_speed -- [FILE]`

use std::time::Instant;
use subsurf_io::{Attribute, FaceSizes, OutputMesh, ReadOptions, read_obj, write_obj};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = match std::env::args().nth(1) {
        Some(path) => std::fs::read(path)?,
        None => made_up()?,
    };
    let megabytes = text.len() as f64 / 1e6;
    for _ in 0..3 {
        let start = Instant::now();
        let scene = read_obj(&text[..], "text", &ReadOptions::default())?;
        let seconds = start.elapsed().as_secs_f64();
        let (vertices, faces) = (scene.mesh.vertex_count(), scene.mesh.face_count());
        println!("{vertices} vertices, {faces} faces, {megabytes:.0} MB, {:.0} MB/s", megabytes / seconds);
    }
    Ok(())
}

/// A grid of quads with texture coordinates, in single precision.
fn made_up() -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    const SIDE: u32 = 1900;
    let place = |i: u32| [(i % SIDE) as f32 / 7.0, (i / SIDE) as f32 / 7.0];
    let texture: Vec<_> = (0..SIDE * SIDE).map(place).collect();
    let positions: Vec<_> = texture.iter().map(|&[x, y]| [x, y, (x * 0.3).sin() + y.cos()]).collect();
    let inner = (0..SIDE * (SIDE - 1)).filter(|i| i % SIDE != SIDE - 1);
    let corners: Vec<u32> = inner.flat_map(|i| [i, i + 1, i + SIDE + 1, i + SIDE]).collect();
    let mesh = OutputMesh {
        positions: &positions,
        sizes: FaceSizes::Uniform(4),
        corners: &corners,
        normals: None,
        texture: Some(Attribute { values: &texture, indices: None }),
        tags: None,
    };
    let mut text = Vec::new();
    let start = Instant::now();
    write_obj(&mut text, &mesh)?;
    println!("written at {:.0} MB/s", text.len() as f64 / 1e6 / start.elapsed().as_secs_f64());
    Ok(text)
}
