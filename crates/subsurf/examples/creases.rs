//! What sharpness does: the edges of a cube from smooth to infinitely sharp.
//!
//!     cargo run --example creases

use subsurf::{Crease, Location, PatchTable, Scheme, Tags, shapes};

fn main() -> Result<(), subsurf::MeshError> {
    let cube = shapes::cube();
    let edges = [(0, 1), (1, 3), (3, 2), (2, 0), (4, 5), (5, 7), (7, 6), (6, 4), (0, 4), (1, 5), (2, 6), (3, 7)];
    let size = |p: [f64; 3]| p.iter().map(|x| x * x).sum::<f64>().sqrt();
    println!("All edges of the cube [-1, 1]³ with one sharpness: distances from the centre,");
    println!("as a share of the control mesh's own.\n");
    println!("sharpness   corner    edge    face   leaf at the corner, and its depth");
    for sharpness in [0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 7.5, 9.5, 10.0] {
        let creases = edges.iter().map(|&(a, b)| Crease::new(a, b, sharpness)).collect();
        let shape = cube.tagged("cube", Tags { creases, ..Tags::default() });
        let patches = PatchTable::new(&shape.mesh, Scheme::CatmullClark)?;
        let surface = patches.surface(&shape.positions);
        let share = |u, v, full: f64| {
            let p = surface.position(Location::new(0, u, v)).expect("no holes");
            size(p) / full.sqrt()
        };
        let (corner, edge, face) = (share(0.0, 0.0, 3.0), share(0.5, 0.0, 2.0), share(0.5, 0.5, 1.0));
        let (kind, depth) = patches.patch_kind(0, 0.0, 0.0).expect("no holes");
        let bar = "#".repeat((30.0 * corner) as usize);
        println!("{sharpness:9}   {corner:.4}  {edge:.4}  {face:.4}   {kind:?}, {depth}   {bar}");
    }
    Ok(())
}
