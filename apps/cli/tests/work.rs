//! What patch tables cost, in counts and bytes that are the same on every machine: a regression shows without a clock.

use std::path::Path;
use subsurf::{ControlMesh, PatchTable, Scheme, Tags};

fn asset(name: &str) -> ControlMesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets").join(name);
    subsurf_io::read(&path, &subsurf_io::ReadOptions::default()).unwrap().mesh
}

/// A torus of `n` by `n` quads.
fn torus(n: u32) -> ControlMesh {
    let at = |i: u32, j: u32| i % n * n + j % n;
    let faces = (0..n * n).map(|f| (f / n, f % n));
    let corners = faces.flat_map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect();
    ControlMesh::from_counts((n * n) as usize, &vec![4; (n * n) as usize], corners, Tags::default()).unwrap()
}

fn table(mesh: &ControlMesh) -> PatchTable {
    PatchTable::new(mesh, Scheme::CatmullClark).unwrap()
}

/// Counts of one mesh.
struct Work {
    plans: usize,
    nodes: usize,
    special_vertices: usize,
    patch_bytes: usize,
    plan_bytes: usize,
    topology_bytes: usize,
}

#[test]
fn the_meshes_at_hand_need_no_more_than_they_did() {
    // What was counted when this was written; more is a regression, less a reason to write the new count down.
    let counted = [
        (
            "catmark_car.obj",
            Work { plans: 0, nodes: 0, special_vertices: 0, patch_bytes: 0, plan_bytes: 0, topology_bytes: 0 },
        ),
        (
            "fancy_teapot.obj",
            Work { plans: 0, nodes: 0, special_vertices: 0, patch_bytes: 0, plan_bytes: 0, topology_bytes: 0 },
        ),
        (
            "mh_shoes03_semisharp.obj",
            Work { plans: 0, nodes: 0, special_vertices: 0, patch_bytes: 0, plan_bytes: 0, topology_bytes: 0 },
        ),
        (
            "spot_control_mesh.obj",
            Work { plans: 0, nodes: 0, special_vertices: 0, patch_bytes: 0, plan_bytes: 0, topology_bytes: 0 },
        ),
    ];
    for (name, most) in counted {
        let size = table(&asset(name)).size();
        for (what, count, most) in [
            ("plans", size.plans, most.plans),
            ("nodes", size.nodes, most.nodes),
            ("special vertices", size.special_vertices, most.special_vertices),
            ("bytes per patch", size.patch_bytes, most.patch_bytes),
            ("bytes of plans", size.plan_bytes, most.plan_bytes),
            ("bytes of topology", size.topology_bytes, most.topology_bytes),
        ] {
            assert!(count <= most, "{name}: {count} {what}, {most} before");
        }
    }
}

#[test]
fn plans_do_not_multiply_with_the_mesh() {
    let [small, large] = [20, 160].map(|n| table(&torus(n)).size());
    assert_eq!((small.plans, small.nodes), (1, 1));
    assert_eq!((large.plans, large.nodes), (1, 1));
    assert_eq!(small.plan_bytes, large.plan_bytes);
}
