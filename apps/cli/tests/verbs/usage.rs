use crate::program::{Folder, data};

#[test]
fn wrong_usage_has_status_2_and_leaves_standard_output_alone() {
    let folder = Folder::new();
    let cube = data("cube.obj");
    for args in [
        String::new(),
        "nothing".into(),
        "info".into(),
        format!("info {cube} --boundary round"),
        format!("info {cube} --scheme doo-sabin"),
        format!("info {cube} --preset maya"),
        format!("info {cube} --triangles"),
        format!("info {cube} --threads 0"),
        format!("info {cube} -q -v"),
        format!("refine {cube} -o out.obj"),
        format!("refine {cube} -l -1 -o out.obj"),
        format!("refine {cube} -l 99999999999 -o out.obj"),
        format!("refine {cube} -l 1"),
        format!("refine {cube} -l 1 -o - --json"),
        format!("tessellate {cube} -o out.obj"),
        format!("tessellate {cube} -r 2 --tolerance 1 -o out.obj"),
        format!("tessellate {cube} -r x -o out.obj"),
        format!("tessellate {cube} -r 0 -o out.obj"),
        format!("tessellate {cube} -r -1 -o out.obj"),
        format!("tessellate {cube} --tolerance 0 -o out.obj"),
        format!("tessellate {cube} --tolerance -1 -o out.obj"),
        format!("tessellate {cube} --tolerance nan -o out.obj"),
        format!("tessellate {cube} --edge-length inf -o out.obj"),
        format!("tessellate {cube} --edge-length 1e999 -o out.obj"),
        format!("info {cube} --split-polygons"),
        format!("info {cube} --scheme bilinear --split-polygons"),
        format!("eval {cube} -o out.csv"),
        "eval - --at - -o out.csv".into(),
        format!("render {cube}"),
        format!("render {cube} -o out.png --size 0x5"),
        format!("render {cube} -o out.png --size 10"),
        format!("render {cube} -o out.png --samples 0"),
        format!("render {cube} -o out.png --camera 1,2"),
        format!("render {cube} -o out.png --show nothing"),
        format!("render {cube} -o out.png --background red"),
        format!("render {cube} -o out.png --baseline feature-adaptive"),
        format!("render {cube} -o out.png --show levels --baseline octree"),
        format!("info {cube} --isolation 4"),
        format!("info {cube} --baseline feature-adaptive --isolation 11"),
    ] {
        let run = folder.run(&args);
        assert_eq!(run.status, 2, "{args}: {}{}", run.stdout, run.stderr);
        assert_eq!(run.stdout, "", "{args}");
        assert!(!run.stderr.is_empty(), "{args}");
    }
    assert!(folder.names().is_empty());
}

#[test]
fn what_cannot_be_shown_is_answered_with_what_can() {
    let run = Folder::new().run(&format!("render {} -o out.png --show curvature", data("cube.obj")));
    assert_eq!(run.status, 2);
    for name in ["shaded", "normals", "wireframe", "cage", "patches", "levels"] {
        assert!(run.stderr.contains(name), "{}", run.stderr);
    }
}

#[test]
fn what_is_not_there_yet_says_so() {
    let folder = Folder::new();
    let cube = data("cube.obj");
    folder.run(&format!("info {cube} --device gpu")).failed(&["no GPU support yet"]);
    for name in ["a.usda", "a.ply", "a.glb", "a.gltf"] {
        folder.write(name, "");
        folder.run(&format!("info {name}")).failed(&[name, "not supported yet"]);
    }
}

#[test]
fn help_teaches_with_examples() {
    let folder = Folder::new();
    for verb in ["", "info", "refine", "tessellate", "eval", "render", "bench", "completions", "man"] {
        let run = folder.run(&format!("{verb} --help")).done();
        assert!(run.stdout.contains("Examples:\n  "), "{verb}: {}", run.stdout);
    }
    assert!(folder.run("--version").done().stdout.starts_with("subsurf 0."));
}

#[test]
fn completions_and_manual_pages_are_printed() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish"] {
        assert!(folder.run(&format!("completions {shell}")).done().stdout.contains("tessellate"), "{shell}");
    }
    assert!(folder.run("man").done().stdout.contains(".TH subsurf 1"));
    let page = folder.run("man tessellate").done().stdout;
    assert!(page.contains("subsurf\\-tessellate") && page.contains("tolerance"), "{page}");
}
