use crate::program::{Folder, data, distance, mesh, worse};
use subsurf_io::Scene;

#[test]
fn a_cube_refines_to_its_published_points_in_order() {
    let folder = Folder::new();
    let json = folder.run(&format!("refine {} -l 1 -o out.obj --precision f64 --json", data("cube.obj"))).done().json();
    assert_eq!((&json["vertices"], &json["edges"], &json["faces"]), (&26.into(), &48.into(), &24.into()));
    let scene = mesh(&folder.text("out.obj"));
    let size = |p: &[f64; 3]| p.iter().map(|x| x.abs()).fold(0.0, worse);
    assert!(scene.positions[..8].iter().all(|p| (size(p) - 5.0 / 9.0).abs() < 1e-15));
    assert!(scene.positions[8..14].iter().all(|p| size(p) == 1.0));
    assert!(scene.positions[14..].iter().all(|p| size(p) == 0.75));
}

#[test]
fn refining_the_output_goes_on_with_the_same_surface() {
    for rules in ["", "--boundary none", "--boundary edge-only", "--creasing chaikin", "--triangles smooth"] {
        for name in ["cube.obj", "tagged_sheet.obj", "mixed_faces.obj"] {
            let folder = Folder::new();
            let refine = |from: &str, level: u32, to: &str| {
                folder.run(&format!("refine {from} -l {level} -o {to} --precision f64 {rules}")).done();
                mesh(&folder.text(to))
            };
            let two = refine(&data(name), 2, "two.obj");
            refine(&data(name), 1, "one.obj");
            let again = refine("one.obj", 1, "again.obj");
            assert_eq!(again.mesh.tags().rules, two.mesh.tags().rules, "{name} {rules}");
            assert_eq!(again.mesh.tags().holes, two.mesh.tags().holes, "{name} {rules}");
            // Edges of the first level are numbered anew when it is read, and with them the vertices on them.
            let mut same = vec![0; two.positions.len()];
            again.mesh.corners().iter().zip(two.mesh.corners()).for_each(|(&a, &b)| same[a as usize] = b);
            let moved: Vec<[f64; 3]> = same.iter().map(|&v| two.positions[v as usize]).collect();
            assert!(distance(&again.positions, &moved) < 1e-12, "{name} {rules}");
            assert_eq!(tags(&again, |v| same[v as usize]), tags(&two, |v| v), "{name} {rules}");
        }
    }
}

/// Ends and sharpness of creases, vertex and sharpness of corners.
type SortedTags = (Vec<([u32; 2], f64)>, Vec<(u32, f64)>);

/// Creases and corners in a fixed order, vertices renumbered.
fn tags(scene: &Scene, number: impl Fn(u32) -> u32) -> SortedTags {
    let tags = scene.mesh.tags();
    let mut creases: Vec<_> = tags.creases.iter().map(|c| (c.vertices.map(&number), c.sharpness)).collect();
    creases.iter_mut().for_each(|c| c.0.sort());
    creases.sort_by(|a, b| a.partial_cmp(b).unwrap());
    let mut corners: Vec<_> = tags.corners.iter().map(|c| (number(c.vertex), c.sharpness)).collect();
    corners.sort_by(|a, b| a.partial_cmp(b).unwrap());
    (creases, corners)
}

#[test]
fn level_nought_says_again_what_was_read() {
    let folder = Folder::new();
    folder.run(&format!("refine {} -l 0 -o out.obj --precision f64", data("tagged_sheet.obj"))).done();
    let (a, b) = (mesh(&folder.text("out.obj")), mesh(&std::fs::read_to_string(data("tagged_sheet.obj")).unwrap()));
    assert_eq!(a.mesh.corners(), b.mesh.corners());
    assert_eq!(a.positions, b.positions);
    assert_eq!(tags(&a, |v| v), tags(&b, |v| v));
}

#[test]
fn limit_moves_vertices_to_where_every_level_ends() {
    let folder = Folder::new();
    let limit = |name: &str, level: u32| {
        folder.run(&format!("refine {} -l {level} --limit -o out.obj --precision f64", data(name))).done();
        mesh(&folder.text("out.obj")).positions
    };
    for name in ["cube.obj", "mixed_faces.obj", "tagged_sheet.obj"] {
        let (one, three) = (limit(name, 1), limit(name, 3));
        // Vertices keep their places at the front of finer levels. The sheet's hole has no surface, where what is
        // left is the refined point.
        let first = if name == "tagged_sheet.obj" { 3 } else { one.len() };
        assert!(distance(&one[..first], &three[..first]) < 1e-12, "{name}");
    }
}

#[test]
fn every_format_and_pipes_are_written() {
    let folder = Folder::new();
    for name in ["out.obj", "out.ply", "out.glb"] {
        folder.run(&format!("refine {} -l 2 -o {name}", data("mixed_faces.obj"))).done();
    }
    assert!(folder.read("out.ply").starts_with(b"ply\nformat binary_little_endian"));
    assert!(folder.read("out.glb").starts_with(b"glTF"));
    let cube = std::fs::read_to_string(data("cube.obj")).unwrap();
    let piped = folder.run_with(&["refine", "-", "-l", "1", "-o", "-"], &cube).done();
    assert_eq!(mesh(&piped.stdout).mesh.face_count(), 24);
}

#[test]
fn texture_coordinates_are_refined_and_go_on_with_the_same_channel() {
    let flat = |scene: &Scene| -> Vec<[f64; 2]> {
        let texture = scene.texture.as_ref().unwrap();
        texture.indices.iter().map(|&i| texture.values[i as usize]).collect()
    };
    for rule in ["none", "corners-only", "corners-plus1", "corners-plus2", "boundaries", "all"] {
        let folder = Folder::new();
        let refine = |from: &str, level: u32, to: &str| {
            folder.run(&format!("refine {from} -l {level} -o {to} --precision f64 --face-varying {rule}")).done();
            mesh(&folder.text(to))
        };
        let two = refine(&data("mixed_faces.obj"), 2, "two.obj");
        refine(&data("mixed_faces.obj"), 1, "one.obj");
        let again = refine("one.obj", 1, "again.obj");
        let (a, b) = (flat(&again), flat(&two));
        assert_eq!(a.len(), b.len(), "{rule}");
        let apart = a.iter().zip(&b).map(|(a, b)| (a[0] - b[0]).abs() + (a[1] - b[1]).abs()).fold(0.0, worse);
        assert!(apart < 1e-14, "{rule}: {apart:e}");
    }
}

#[test]
fn bilinear_leaves_vertices_where_they_are() {
    let folder = Folder::new();
    folder.run(&format!("refine {} -l 2 --scheme bilinear -o out.obj", data("cube.obj"))).done();
    let (out, cube) = (folder.text("out.obj"), std::fs::read_to_string(data("cube.obj")).unwrap());
    assert_eq!(mesh(&out).positions[..8], mesh(&cube).positions[..]);
}

#[test]
fn threads_change_no_bit() {
    let folder = Folder::new();
    for (threads, name) in [(1, "one.obj"), (2, "two.obj")] {
        folder.run(&format!("refine {} -l 4 -o {name} --threads {threads}", data("tagged_sheet.obj"))).done();
    }
    assert!(folder.read("one.obj") == folder.read("two.obj"));
}
