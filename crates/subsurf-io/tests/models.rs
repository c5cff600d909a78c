//! Production models and OpenSubdiv's regression shapes, where they lie beside the repository.

use std::fs;
use std::path::{Path, PathBuf};
use subsurf::{Boundary, Creasing, FaceVarying, Triangles};
use subsurf_io::{ReadOptions, Scene, WarningKind, read, read_obj, write_obj};

const MODELS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/models");

fn model(name: &str) -> Scene {
    read(Path::new(MODELS).join(name), &ReadOptions::default()).unwrap()
}

fn shape(name: &str) -> Scene {
    model(&format!("opensubdiv_shapes/{name}.obj"))
}

fn all() -> Vec<PathBuf> {
    let folders = [PathBuf::from(MODELS), Path::new(MODELS).join("opensubdiv_shapes")];
    let files = folders.iter().flat_map(|folder| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()));
    files.filter(|path| path.extension().is_some_and(|extension| extension == "obj")).collect()
}

#[test]
#[cfg_attr(not(shared_models), ignore = "needs the shared models")]
fn every_model_reads_and_reads_back_equal() {
    let files = all();
    assert!(files.len() > 60);
    for path in files {
        let scene = read(&path, &ReadOptions::default()).unwrap();
        let mut text = Vec::new();
        write_obj(&mut text, &scene.output()).unwrap();
        let again = read_obj(&text[..], "again", &ReadOptions::default()).unwrap();
        assert_eq!(again.mesh, scene.mesh, "{}", path.display());
        assert_eq!((again.positions, again.texture), (scene.positions, scene.texture), "{}", path.display());
    }
}

#[test]
#[cfg_attr(not(shared_models), ignore = "needs the shared models")]
fn counts_are_those_the_models_are_known_by() {
    // Faces, vertices, distinct texture coordinates: shared/models/README.md.
    for (name, faces, vertices, texture) in [
        ("cat_head", 248, 131, 0),
        ("chess_bishop_nonmanifold", 37528, 37464, 38669),
        ("fancy_teapot", 6120, 6072, 6660),
        ("ict_face_neutral", 26384, 26719, 28911),
        ("makehuman_base", 18486, 19158, 21334),
        ("moebius", 224, 280, 0),
        ("spot_control_mesh", 180, 188, 267),
        ("opensubdiv_shapes/catmark_car", 1575, 1642, 4),
        ("opensubdiv_shapes/catmark_nonman_bareverts", 8, 25, 31),
        ("opensubdiv_shapes/loop_chaikin0", 44, 24, 24),
    ] {
        let scene = model(&format!("{name}.obj"));
        let texture_count = scene.texture.map_or(0, |channel| channel.values.len());
        let counts = (scene.mesh.face_count(), scene.positions.len(), texture_count);
        assert_eq!(counts, (faces, vertices, texture), "{name}");
    }
}

#[test]
#[cfg_attr(not(shared_models), ignore = "needs the shared models")]
fn tags_of_the_models_are_read_in_full() {
    let shoes = model("mh_shoes03_semisharp.obj");
    assert_eq!((shoes.mesh.tags().creases.len(), shoes.mesh.tags().corners.len()), (676, 62));
    assert_eq!(shoes.file_rules.boundary, Some(Boundary::EdgeAndCorner));
    assert_eq!(shape("catmark_rook").mesh.tags().creases.len(), 280);
    assert_eq!(shape("catmark_hole_test2").mesh.tags().holes.len(), 4);
    assert_eq!(shape("catmark_chaikin1").file_rules.creasing, Some(Creasing::Chaikin));
    assert_eq!(shape("catmark_smoothtris1").file_rules.triangles, Some(Triangles::Smooth));
    assert_eq!(shape("catmark_edgenone").file_rules.boundary, Some(Boundary::None));
    assert_eq!(shape("catmark_cubes_semisharp").file_rules.face_varying, Some(FaceVarying::CornersOnly));
    let edits = shape("catmark_square_hedit2").warnings;
    assert_eq!((edits.len(), edits[0].kind), (1, WarningKind::HierarchicalEdit));
}
