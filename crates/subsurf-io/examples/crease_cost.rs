//! What semi-sharp creases cost under Loop subdivision: plans, memory, time to build the patch table and time to evaluate a
//! place (position and first derivatives, on faces at creases), with all creases at one sharpness after the other. Of a
//! model, or without one of a regular grid of triangles with straight creases.
//!
//! ```text
//! cargo run --release -p subsurf-io --example crease_cost -- [assets/catmark_car.obj]
//! ```

use std::error::Error;
use std::path::Path;
use std::time::Instant;
use subsurf::{ControlMesh, Crease, Face, Location, MeshError, PatchTable, Scheme, Tags, shapes};
use subsurf_io::{ReadOptions, read};

/// Places on each face at a crease, within 1/4, 1/16, … of a side.
const PLACES: [(f64, f64); 6] = [(0.3, 0.2), (0.55, 0.06), (0.06, 0.41), (0.38, 0.6), (0.71, 0.004), (0.0009, 0.23)];

fn main() -> Result<(), Box<dyn Error>> {
    let (mesh, positions) = match std::env::args().nth(1) {
        Some(path) => {
            let scene = read(Path::new(&path), &ReadOptions::default())?;
            (scene.mesh.triangulated(&scene.positions)?.mesh, scene.positions)
        }
        None => regular()?,
    };
    let sizes = vec![3; mesh.face_count()];
    println!("{} triangles, {} creases", mesh.face_count(), mesh.tags().creases.len());
    println!("sharpness  plans    bytes  build ms  eval ns");
    for s in [0.0, 1.0, 1.7, 2.0, 3.0, 4.0, 6.0, 8.0, 9.0, 9.5, 10.0] {
        let mut tags = mesh.tags().clone();
        tags.creases.iter_mut().for_each(|crease| crease.sharpness = s);
        let mesh = ControlMesh::from_counts(mesh.vertex_count(), &sizes, mesh.corners().to_vec(), tags)?;
        let table = PatchTable::new(&mesh, Scheme::Loop)?;
        let surface = table.surface(&positions);
        let at = places(&mesh);
        let build = median(|| _ = PatchTable::new(&mesh, Scheme::Loop)) * 1e3;
        let eval = median(|| at.iter().for_each(|&at| _ = std::hint::black_box(surface.eval(at))));
        let (size, each) = (table.size(), eval * 1e9 / at.len() as f64);
        println!("{s:9} {:6} {:8} {build:9.1} {each:8.0}", size.plans, size.plan_bytes);
    }
    Ok(())
}

/// Median of seven, in seconds.
fn median(mut work: impl FnMut()) -> f64 {
    let mut times = [0.0; 7].map(|_: f64| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    });
    times.sort_by(f64::total_cmp);
    times[3]
}

fn places(mesh: &ControlMesh) -> Vec<Location> {
    let mut at_crease = vec![false; mesh.vertex_count()];
    mesh.tags().creases.iter().flat_map(|c| c.vertices).for_each(|v| at_crease[v as usize] = true);
    let faces = (0..mesh.face_count()).filter(|&f| {
        let is_hole = mesh.tags().holes.contains(&(f as u32));
        !is_hole && mesh.face_vertices(f).iter().any(|&v| at_crease[v as usize])
    });
    faces.flat_map(|f| PLACES.map(|(u, v)| Location { face: Face::new(f), subface: 0, u, v })).collect()
}

/// 64 × 64 squares of two triangles, with a crease along every fourth row.
fn regular() -> Result<(ControlMesh, Vec<[f64; 3]>), MeshError> {
    const SIDE: u32 = 64;
    let grid = shapes::grid(SIDE, SIDE).triangulated();
    let row = |y: u32| (0..SIDE).map(move |x| Crease::new(y * (SIDE + 1) + x, y * (SIDE + 1) + x + 1, 1.0));
    let creases = (4..SIDE).step_by(4).flat_map(row).collect();
    let sizes = vec![3; grid.mesh.face_count()];
    let tags = Tags { creases, ..Tags::default() };
    let mesh = ControlMesh::from_counts(grid.positions.len(), &sizes, grid.mesh.corners().to_vec(), tags)?;
    Ok((mesh, grid.positions))
}
