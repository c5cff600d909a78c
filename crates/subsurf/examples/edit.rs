//! Editing: a crease is sharpened and a face cut while the table stays in use. The time of an edit does not depend on the
//! size of the mesh.
//!
//!     cargo run --release --example edit

use std::time::{Duration, Instant};
use subsurf::{Location, Scheme, TableEditor, shapes};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("     faces  table built  a crease  a cut   patches made anew");
    for n in [10, 100, 1000] {
        let grid = shapes::grid(n, n);
        let start = Instant::now();
        let mut editor = TableEditor::new(&grid.mesh, Scheme::CatmullClark)?;
        let build = start.elapsed();

        // The first edit of a kind compiles plans that no face had before; later ones find them.
        let (mut crease, mut cut, mut rebuilt) = (Vec::new(), Vec::new(), [0, 0]);
        for column in n / 5..n * 4 / 5 {
            let face = n / 2 * n + column;
            let f = grid.mesh.face_vertices(face as usize);
            let start = Instant::now();
            rebuilt[0] = editor.set_creases(&[(f[0], f[1])], 2.5)?.rebuilt.len();
            crease.push(start.elapsed());
            let start = Instant::now();
            let edited = editor.replace_faces(&[face], &[&[f[0], f[1], f[2]], &[f[0], f[2], f[3]]])?;
            cut.push(start.elapsed());
            rebuilt[1] = edited.rebuilt.len();

            let surface = editor.table().surface(&grid.positions);
            let at = Location { face: edited.added[0], subface: 0, u: 0.5, v: 0.5 };
            assert!(surface.position(at).is_some());
        }
        let [crease, cut] = [median(crease), median(cut)];
        println!("{:10}  {build:9.1?}  {crease:8.1?}  {cut:6.1?}  {} and {}", n * n, rebuilt[0], rebuilt[1]);
    }
    Ok(())
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort();
    times[times.len() / 2]
}
