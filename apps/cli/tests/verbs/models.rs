//! Production models, where they lie beside the repository.

use crate::program::Folder;
use std::path::{Path, PathBuf};

fn models() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/models");
    let files = |folder: PathBuf| std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let all = files(root.clone()).chain(files(root.join("opensubdiv_shapes")));
    let mut found: Vec<_> = all.filter(|path| path.extension().is_some_and(|e| e == "obj")).collect();
    found.sort();
    found
}

#[test]
#[cfg_attr(not(shared_models), ignore = "needs the folder of production models beside the repository")]
fn every_model_is_described_and_refined_and_tessellated_and_rendered() {
    let models = models();
    assert!(models.len() > 60);
    for model in models {
        let folder = Folder::new();
        let name = model.display().to_string();
        let json = folder.run_with(&["info", &name, "--json", "-q"], "").done().json();
        assert!(json["patches"].as_u64().unwrap() > 0, "{name}");
        let faces = json["faces"].as_u64().unwrap();
        folder.run_with(&["refine", &name, "-l", "1", "-o", "out.obj", "-q"], "").done();
        folder.run_with(&["tessellate", &name, "-r", "2", "-o", "out.glb", "-q"], "").done();
        let small = ["--size", "96x64", "--samples", "1"];
        if faces < 3000 {
            folder.run_with(&[&["render", &name, "-o", "out.png", "-q"][..], &small].concat(), "").done();
        }
        if json["sides"]["3"] == faces && faces < 3000 {
            for verb in [&["refine", "-l", "2", "--limit"][..], &["tessellate", "-r", "3"]] {
                folder.run_with(&[verb, &[&name, "-o", "out.obj", "-q", "--scheme", "loop"]].concat(), "").done();
            }
            let render = ["render", &name, "-o", "out.png", "-q", "--show", "levels", "--scheme", "loop"];
            folder.run_with(&[&render[..], &small].concat(), "").done();
        }
    }
}
