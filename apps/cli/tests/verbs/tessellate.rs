use crate::program::{Folder, data, mesh};
use std::collections::HashMap;

#[test]
fn a_cube_at_rate_four_is_closed_with_unit_normals() {
    let folder = Folder::new();
    let json = folder.run(&format!("tessellate {} -r 4 -o out.obj --json", data("cube.obj"))).done().json();
    assert_eq!((&json["vertices"], &json["faces"]), (&98.into(), &96.into()));
    let scene = mesh(&folder.text("out.obj"));
    let normals = scene.normals.unwrap();
    assert!(normals.values.iter().all(|n| (n.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-6));
    let mut sides: HashMap<(u32, u32), i32> = HashMap::new();
    for face in scene.mesh.faces() {
        assert_eq!(face.len(), 4);
        for i in 0..4 {
            let (a, b) = (face[i], face[(i + 1) % 4]);
            *sides.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    assert!(sides.values().all(|&sum| sum == 0), "every edge is used once in each direction");
    assert_eq!(98 + 96 - sides.len() as i64, 2);
}

#[test]
fn triangles_are_facets_alone_and_a_rule_with_a_word() {
    let folder = Folder::new();
    let mixed = data("mixed_faces.obj");
    let run = |args: &[&str]| {
        let run = folder.run_with(&[&["tessellate", "-o", "-", "-q", "-r", "2"], args].concat(), "").done();
        let scene = mesh(&run.stdout);
        let all_triangles = scene.mesh.faces().all(|f| f.len() == 3);
        (all_triangles, scene.positions)
    };
    let (triangles, plain) = run(&["--triangles", &mixed]);
    assert!(triangles);
    let (triangles, smooth) = run(&["--triangles", "smooth", &mixed]);
    assert!(!triangles);
    assert_ne!(plain, smooth);
    let (triangles, both) = run(&["--triangles", "--triangles", "smooth", &mixed]);
    assert!(triangles);
    assert_eq!(both, smooth);
    assert!(run(&[&mixed, "--triangles"]).0);
    assert!(run(&["--triangles", "--threads", "1", &mixed]).0);
    let (triangles, catmark) = run(&["--triangles", "catmull-clark", &mixed, "--quads"]);
    assert!(!triangles);
    assert_eq!(catmark, plain);
    let both = folder.run(&format!("tessellate {mixed} -r 2 --quads --triangles -o -"));
    assert_eq!(both.status, 2, "{}", both.stderr);
}

#[test]
fn tolerance_and_edge_length_are_finer_when_smaller() {
    let folder = Folder::new();
    for flag in ["--tolerance", "--edge-length"] {
        let faces = |value: f64| {
            let run = folder.run(&format!("tessellate {} {flag} {value} -o out.ply --json", data("cube.obj")));
            run.done().json()["faces"].as_u64().unwrap()
        };
        assert!(faces(0.01) > 3 * faces(0.2), "{flag}");
    }
}

#[test]
fn every_format_is_written_with_split_normals_at_infinite_creases() {
    let folder = Folder::new();
    for name in ["out.obj", "out.ply", "out.glb"] {
        let run = folder.run(&format!("tessellate {} -r 3 -o {name} --json", data("tagged_sheet.obj"))).done();
        let json = run.json();
        assert!(json["normals"].as_u64() > json["vertices"].as_u64(), "{json}");
    }
    assert!(folder.read("out.glb").starts_with(b"glTF"));
}

#[test]
fn an_odd_rate_is_rounded_up_where_faces_are_no_quads_and_v_says_so() {
    let folder = Folder::new();
    let run = folder.run(&format!("tessellate {} -r 3 -o out.obj -v", data("mixed_faces.obj"))).done();
    assert!(run.stderr.contains("rounded up to 4"), "{}", run.stderr);
    let quads = folder.run(&format!("tessellate {} -r 3 -o out.obj -v", data("cube.obj"))).done();
    assert!(!quads.stderr.contains("rounded"), "{}", quads.stderr);
}

#[test]
fn both_evaluators_give_the_same_surface() {
    let folder = Folder::new();
    for name in ["deflated", "eigenbasis"] {
        let mesh = data("mixed_faces.obj");
        folder.run(&format!("tessellate {mesh} -r 4 -o {name}.obj --evaluator {name} --precision f64")).done();
    }
    let [a, b] = ["deflated.obj", "eigenbasis.obj"].map(|name| mesh(&folder.text(name)).positions);
    assert!(crate::program::distance(&a, &b) < 1e-12);
}

#[test]
fn threads_change_no_bit() {
    let folder = Folder::new();
    for (threads, name) in [(1, "one.glb"), (2, "two.glb")] {
        folder.run(&format!("tessellate {} -r 12 -o {name} --threads {threads}", data("mixed_faces.obj"))).done();
    }
    assert!(folder.read("one.glb") == folder.read("two.glb"));
}

#[test]
fn texture_coordinates_come_along_with_their_seams() {
    let folder = Folder::new();
    folder.run(&format!("tessellate {} -r 4 -o out.obj", data("mixed_faces.obj"))).done();
    let out = mesh(&folder.text("out.obj"));
    let texture = out.texture.unwrap();
    assert_eq!(texture.indices.len(), out.mesh.corners().len());
    // Control values are the corners of the unit square, and no rule leads outside.
    assert!(texture.values.iter().flatten().all(|&x| (-1e-6..=1.0 + 1e-6).contains(&x)));
    // At seams one vertex has several values.
    let mut values_of = std::collections::BTreeMap::<u32, std::collections::BTreeSet<u32>>::new();
    out.mesh.corners().iter().zip(&texture.indices).for_each(|(&v, &t)| {
        values_of.entry(v).or_default().insert(t);
    });
    assert!(values_of.values().any(|values| values.len() > 1));
    assert!(values_of.values().filter(|values| values.len() == 1).count() > values_of.len() / 2);
}
