//! What semi-sharp creases cost under Loop subdivision: plans, memory and time to build the patch table of a model, with
//! all its creases at one sharpness after the other.
//!
//! ```text
//! cargo run --release -p subsurf-io --example crease_cost -- assets/catmark_car.obj
//! ```

use std::error::Error;
use std::time::Instant;
use subsurf::{ControlMesh, PatchTable, Scheme};
use subsurf_io::{ReadOptions, read};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("name an OBJ file with creases")?;
    let scene = read(std::path::Path::new(&path), &ReadOptions::default())?;
    let mesh = scene.mesh.triangulated(&scene.positions)?.mesh;
    let sizes = vec![3; mesh.face_count()];
    println!("{} triangles, {} creases", mesh.face_count(), mesh.tags().creases.len());
    println!("sharpness  plans    bytes   ms");
    for s in [0.0, 1.0, 1.7, 2.0, 3.0, 4.0, 6.0, 8.0, 9.0, 9.5, 10.0] {
        let mut tags = mesh.tags().clone();
        tags.creases.iter_mut().for_each(|crease| crease.sharpness = s);
        let mesh = ControlMesh::from_counts(mesh.vertex_count(), &sizes, mesh.corners().to_vec(), tags)?;
        let mut times = Vec::new();
        let mut size = None;
        for _ in 0..5 {
            let start = Instant::now();
            let table = PatchTable::new(&mesh, Scheme::Loop)?;
            times.push(start.elapsed().as_secs_f64() * 1e3);
            size = Some(table.size());
        }
        times.sort_by(f64::total_cmp);
        let size = size.ok_or("no table")?;
        println!("{s:9} {:6} {:8} {:5.0}", size.plans, size.plan_bytes, times[times.len() / 2]);
    }
    Ok(())
}
