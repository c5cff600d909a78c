//! Curvature, put to the proof: over a closed surface the Gaussian curvature adds up to 2π times the Euler
//! characteristic, whatever the shape (Gauss and Bonnet).
//!
//!     cargo run --release --example curvature

use std::f64::consts::PI;
use subsurf::{ControlMesh, Face, Location, PatchTable, Scheme, Tags, shapes};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A dented doughnut: 12 × 8 quads, all vertices regular.
    let at = |i: u32, j: u32| i % 12 * 8 + j % 8;
    let quad = |k: u32| [at(k / 8, k), at(k / 8 + 1, k), at(k / 8 + 1, k + 1), at(k / 8, k + 1)];
    let faces: Vec<[u32; 4]> = (0..96).map(quad).collect();
    let points: Vec<[f64; 3]> = (0..96)
        .map(|k| {
            let (a, b) = (f64::from(k / 8) * PI / 6.0, f64::from(k % 8) * PI / 4.0);
            let r = 3.0 + b.cos() * (1.0 + 0.3 * (3.0 * a).sin());
            [r * a.cos(), r * a.sin(), b.sin()]
        })
        .collect();
    let doughnut = ControlMesh::new(&faces, Tags::default())?;
    let (cube, cone) = (shapes::cube(), shapes::cone(7));

    println!("surface                                 area   ∫ K dA   expected");
    for (name, mesh, points, characteristic) in [
        ("doughnut", &doughnut, &points, 0.0),
        (cube.name.as_str(), &cube.mesh, &cube.positions, 2.0),
        (cone.name.as_str(), &cone.mesh, &cone.positions, 2.0),
    ] {
        let patches = PatchTable::new(mesh, Scheme::CatmullClark)?;
        let surface = patches.surface(points);
        let (mut area, mut total) = (0.0, 0.0);
        for face in (0..mesh.face_count()).map(Face::new) {
            for subface in 0..patches.subfaces(face) {
                // The midpoint rule: finer than needed, for K is not bounded at extraordinary vertices.
                const STEPS: u32 = 100;
                for k in 0..STEPS * STEPS {
                    let [u, v] = [k % STEPS, k / STEPS].map(|i| (f64::from(i) + 0.5) / f64::from(STEPS));
                    let jet = surface.eval_second(Location { face, subface, u, v }).expect("no holes");
                    let ([a, b, c], [d, e, f]) = (jet.du, jet.dv);
                    let cell = (b * f - c * e).hypot(c * d - a * f).hypot(a * e - b * d) / f64::from(STEPS * STEPS);
                    area += cell;
                    total += cell * jet.curvature().expect("finite between the vertices").gaussian;
                }
            }
        }
        println!("{name:36}{area:8.3}  {:7.3}  {:9.3}", (total * 1e3).round() / 1e3 + 0.0, 2.0 * PI * characteristic);
    }
    Ok(())
}
