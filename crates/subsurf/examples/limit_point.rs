//! A point of the limit surface: position, normal, curvatures; and what holds at an extraordinary vertex.
//!
//!     cargo run --example limit_point

use subsurf::{ControlMesh, Crease, Location, PatchTable, Scheme, Tags};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A cube with one semi-sharp edge. Faces are counter-clockwise seen from outside.
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let points: Vec<[f64; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    let tags = Tags { creases: vec![Crease::new(5, 7, 2.5)], ..Tags::default() };

    let mesh = ControlMesh::new(&faces, tags)?;
    let patches = PatchTable::new(&mesh, Scheme::CatmullClark)?; // once per connectivity
    let surface = patches.surface(&points); // once per frame
    let jet = surface.eval_second(Location::new(1, 0.75, 0.5)).expect("face 1 is no hole");
    println!("at (3/4, 1/2) of face 1");
    println!("  position    {:?}", jet.position);
    println!("  normal      {:?}", jet.normal().expect("the surface is smooth here"));
    println!("  curvatures  {:?}", jet.principal_curvatures().expect("curvature is bounded here"));

    // Corner 1 of face 1 is vertex 5: one sharp edge ends there, and three faces meet.
    let jet = surface.eval_second(Location::new(1, 1.0, 0.0)).expect("face 1 is no hole");
    println!("at vertex 5, where parametric derivatives are {:?}", jet.derivatives);
    println!("  position    {:?}", jet.position);
    println!("  normal      {:?}", jet.normal().expect("a tangent plane exists all the same"));
    println!("  curvatures  {:?}", jet.principal_curvatures());
    Ok(())
}
