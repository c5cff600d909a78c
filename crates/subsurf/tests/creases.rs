//! What semi-sharp creases cost: what a table holds does not grow with the sharpness.

mod random_mesh;

use proptest::strategy::Strategy;
use random_mesh::{for_all, recipe, triangle_recipe};
use subsurf::{ControlMesh, Corner, Crease, PatchTable, Scheme, TableSize, Tags, shapes};

/// The mesh with another sharpness wherever it is finite.
fn resharpened(mesh: &ControlMesh, new: impl Fn(f64) -> f64) -> ControlMesh {
    let sharpness = |s: f64| if s > 0.0 && s < 10.0 { new(s) } else { s };
    let old = mesh.tags();
    let tags = Tags {
        creases: old.creases.iter().map(|c| Crease { sharpness: sharpness(c.sharpness), ..*c }).collect(),
        corners: old.corners.iter().map(|c| Corner { sharpness: sharpness(c.sharpness), ..*c }).collect(),
        ..old.clone()
    };
    let counts: Vec<u32> = mesh.faces().map(|f| f.len() as u32).collect();
    ControlMesh::from_counts(mesh.vertex_count(), &counts, mesh.corners().to_vec(), tags).unwrap()
}

fn size(mesh: &ControlMesh, scheme: Scheme) -> TableSize {
    PatchTable::new(mesh, scheme).unwrap().size()
}

#[test]
fn sharpness_that_is_higher_by_a_whole_number_takes_the_same_nodes() {
    for (recipes, scheme) in [(recipe().boxed(), Scheme::CatmullClark), (triangle_recipe().boxed(), Scheme::Loop)] {
        for_all(recipes, 60, 21, |recipe| {
            // Chaikin's averages move fractions at every level: there nodes are not shared.
            let mesh = random_mesh::Recipe { chaikin: false, ..recipe.clone() }.mesh().mesh;
            // Fractions from below a tenth up to 1, whole parts from 1 to 3, and then raised.
            let at =
                |raise: f64| resharpened(&mesh, |s| 1.0 + s.floor().min(2.0) + (s - s.floor()).max(0.0625) + raise);
            let low = size(&at(1.0), scheme);
            for raise in [2.0, 3.0, 5.0] {
                let high = size(&at(raise), scheme);
                if high != low {
                    return Err(format!("raised by {raise}: {high:?}, by 1: {low:?}"));
                }
            }
            Ok(())
        });
    }
}

/// Nodes and bytes stand in for the time to build: one node costs what another does.
#[test]
fn a_table_costs_the_same_at_every_sharpness() {
    for (name, mesh) in [
        ("valence 3", shapes::interior_vertex(3).mesh),
        ("valence 5", shapes::interior_vertex(5).mesh),
        ("valence 4", shapes::grid(6, 6).mesh),
    ] {
        // A crease that ends, one that turns, and a vertex; all special.
        let [a, b, c] = if name == "valence 4" { [17, 24, 25] } else { [1, 0, 7] };
        let at = |s: f64| {
            let creases = vec![Crease::new(a, b, s), Crease::new(b, c, s)];
            let tags = Tags { creases, ..mesh.tags().clone() };
            let counts: Vec<u32> = mesh.faces().map(|f| f.len() as u32).collect();
            ControlMesh::from_counts(mesh.vertex_count(), &counts, mesh.corners().to_vec(), tags).unwrap()
        };
        let reference = size(&at(2.5), Scheme::CatmullClark);
        for s in [1.25, 1.5, 3.0, 4.75, 6.0, 7.1, 8.5, 9.0, 9.9] {
            let other = size(&at(s), Scheme::CatmullClark);
            assert_eq!(other.nodes, reference.nodes, "{name}, sharpness {s}");
            assert_eq!(other.plans, reference.plans, "{name}, sharpness {s}");
            // Weights of one half cancel where those of another fraction do not: in rows next to creases, which are the same
            // few in every mesh, so that the bound does not depend on what the rest takes.
            let [bytes, of] = [other, reference].map(|size| size.plan_bytes);
            assert!(bytes.abs_diff(of) < 4 << 10, "{name}, sharpness {s}: {bytes} for {of}");
        }
    }
}
