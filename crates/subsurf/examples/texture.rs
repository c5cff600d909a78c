//! Texture coordinates with a seam: refined, and evaluated exactly on both sides.
//!
//!     cargo run --example texture

use subsurf::{Channel, Face, FaceVarying, Location, PatchTable, Scheme, shapes};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A cube whose faces are squares of their own in texture space.
    let cube = shapes::cube();
    let patches = PatchTable::new(&cube.mesh, Scheme::CatmullClark)?;
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let uv: Vec<[f64; 2]> = (0..6).flat_map(|f| square.map(|[s, t]| [s + 2.0 * f64::from(f), t])).collect();
    let corners: Vec<u32> = (0..24).collect();

    println!("rule            seams   limit of the first corner   values at level 2");
    for rule in [FaceVarying::None, FaceVarying::CornersOnly, FaceVarying::Boundaries, FaceVarying::All] {
        let channel = Channel::face_varying(patches.topology(), Scheme::CatmullClark, uv.len(), &corners, rule)?;
        let values = channel.rows(&uv);
        let table = channel.patch_table()?;
        let at = Location { face: Face(0), subface: 0, u: 0.0, v: 0.0 };
        let [s, t] = table.surface(&values).position(at).expect("face 0 is no hole");

        let mut level = channel.level();
        let mut refined = values.to_vec();
        for _ in 0..2 {
            refined = level.refine_values(&refined);
            level = level.refine()?;
        }
        let seams = channel.seam_count(patches.topology());
        let name = format!("{rule:?}");
        println!("{name:14} {seams:6}   ({s:.6}, {t:.6})          {:15}", refined.len());
    }
    Ok(())
}
