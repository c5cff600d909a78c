//! Stencils: connectivity is tabulated once; then any attribute is refined by one pass over a table, and an edit moves
//! only what it must.
//!
//!     cargo run --release --example stencils

use subsurf::{Level, LimitStencilOptions, LimitStencilTable, PatchTable, Scheme, StencilError, StencilTable, shapes};

fn main() -> Result<(), StencilError> {
    let mut flag = shapes::grid(40, 25);
    let control = Level::new(&flag.mesh, Scheme::CatmullClark)?;

    // Refined points: weights in single precision, computed in double.
    let table = StencilTable::<f32>::new(&control, 2)?;
    let (points, weights) = table.row(table.len() / 2);
    println!("{} refined points from {} control points", table.len(), table.control_points());
    println!("one of them: {points:?} times {weights:.4?}\n");

    // Positions and colours take the same table.
    let mut refined = table.apply(&flag.positions);
    let colours: Vec<[f32; 4]> = (0..flag.positions.len()).map(|v| [v as f32 / 1066.0, 0.2, 0.4, 1.0]).collect();
    println!("colour of the first face's middle: {:.4?}", table.apply(&colours)[control.topology().vertex_count()]);

    // Someone pulls at one control point: only what depends on it is computed again.
    let dependents = table.dependents();
    flag.positions[520][2] += 3.0;
    let moved = table.update(&dependents, &flag.positions, &[520], &mut refined);
    println!("control point 520 moves {} points of {}\n", moved.len(), refined.len());

    // The limit of every vertex of level 1, with tangents.
    let patches = PatchTable::new(&flag.mesh, Scheme::CatmullClark)?;
    let limit = LimitStencilTable::<f64>::of_level(&patches, &control.refine()?, &LimitStencilOptions::default())?;
    let highest = limit.frames(&flag.positions).into_iter().max_by(|a, b| a[0][2].total_cmp(&b[0][2]));
    let [position, du, dv] = highest.expect("the flag has vertices");
    println!("highest point {position:.4?}, tangents {du:.4?} and {dv:.4?}");
    Ok(())
}
