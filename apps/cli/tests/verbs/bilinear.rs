//! `--scheme bilinear` in every verb.

use crate::program::{Folder, data, mesh};

#[test]
fn info_counts_patches_and_calls_nothing_extraordinary() {
    let text = Folder::new().run(&format!("info {} --scheme bilinear", data("mixed_faces.obj"))).done().stdout;
    assert!(text.contains("bilinear") && !text.contains("extraordinary") && !text.contains("bicubic"), "{text}");
}

#[test]
fn refine_leaves_vertices_where_they_are_and_limit_changes_nothing() {
    let folder = Folder::new();
    let refine = |flags: &str| {
        let file = data("mixed_faces.obj");
        folder.run(&format!("refine {file} -l 2 -o out.obj --scheme bilinear --precision f64 -q {flags}")).done();
        mesh(&folder.text("out.obj")).positions
    };
    let (plain, limit) = (refine(""), refine("--limit"));
    let control = mesh(&std::fs::read_to_string(data("mixed_faces.obj")).unwrap()).positions;
    assert_eq!(plain[..control.len()], control);
    // Means of means, in another order.
    assert!(crate::program::distance(&plain, &limit) < 1e-14);
}

#[test]
fn the_faces_of_a_tessellated_box_have_their_own_normals() {
    let folder = Folder::new();
    folder.run(&format!("tessellate {} --scheme bilinear -r 2 -o out.obj -q", data("cube.obj"))).done();
    let scene = mesh(&folder.text("out.obj"));
    let normals = scene.normals.expect("normals");
    assert_eq!((scene.positions.len(), scene.mesh.face_count()), (26, 24));
    for (facet, ends) in scene.mesh.face_offsets().windows(2).enumerate() {
        let of = |i: u32| normals.values[normals.indices[i as usize] as usize];
        assert!((ends[0]..ends[1]).all(|i| of(i) == of(ends[0])), "facet {facet}");
    }
}

#[test]
fn eval_and_render_take_bilinear_surfaces() {
    let folder = Folder::new();
    folder.write("at.csv", "face,subface,u,v\n0,0,0,0\n0,0,0.25,1\n");
    let cube = data("cube.obj");
    folder.run(&format!("eval {cube} --scheme bilinear --at at.csv -o out.csv --second --curvature")).done();
    assert!(folder.text("out.csv").lines().skip(1).all(|row| row.contains("finite")));
    for show in ["shaded", "wireframe", "cage", "patches", "levels"] {
        let size = "--size 96x64 --samples 2";
        folder.run(&format!("render {cube} --scheme bilinear -o {show}.png --show {show} {size}")).done();
    }
}
