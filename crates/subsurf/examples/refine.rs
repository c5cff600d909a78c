//! Refinement level by level, and how its vertices converge to the limit surface.
//!
//!     cargo run --example refine

use subsurf::{Face, Level, Location, PatchTable, Scheme, shapes};

fn main() -> Result<(), subsurf::MeshError> {
    // Six triangles over a hexagon: after one level everything is quads.
    let cone = shapes::cone(6);
    let patches = PatchTable::new(&cone.mesh, Scheme::CatmullClark)?;
    // The apex is corner 0 of the first triangle, hence (0, 0) of that triangle's sub-face 0.
    let apex = Location { face: Face(0), subface: 0, u: 0.0, v: 0.0 };
    let limit = patches.surface(&cone.positions).position(apex).expect("face 0 is no hole");

    let mut level = Level::new(&cone.mesh, Scheme::CatmullClark)?;
    let mut points = cone.positions;
    println!("{}", cone.name);
    println!("level  vertices   edges   faces   height of the apex   above its limit");
    loop {
        let t = level.topology();
        let above = points[0][2] - limit[2];
        let counts = [t.vertex_count(), t.edge_count(), t.face_count()];
        let [vertices, edges, faces] = counts;
        println!("{:5}  {vertices:8}  {edges:6}  {faces:6}   {:18.15}   {above:15.1e}", level.depth(), points[0][2]);
        if level.depth() == 7 {
            break;
        }
        points = level.refine_values(&points);
        level = level.refine()?;
    }
    println!("limit                            {:18.15}", limit[2]);
    Ok(())
}
