//! Bad meshes and places: exit status 1, one message, no file.

use crate::program::{Folder, data};
use std::io::Write;

const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

#[test]
fn bad_meshes_are_refused_by_name_and_line_and_leave_nothing() {
    let cases = [
        ("empty", String::new(), "bad.obj: ", "the file is empty"),
        ("blank", "# a comment\n\n".into(), "bad.obj: ", "no vertices (v) and no faces"),
        ("vertices only", "v 0 0 0\nv 1 0 0\n".into(), "bad.obj: ", "2 vertices but no faces"),
        ("another format", "solid box\nfacet normal 0 0 1\n".into(), "bad.obj: ", "no vertices (v) and no faces"),
        ("truncated number", QUAD.replace("v 0 1 0\nf 1 2 3 4\n", "v 0 1"), "bad.obj:4: ", "cut off"),
        ("truncated face", QUAD.replace(" 3 4\n", ""), "bad.obj:5: ", "at least 3"),
        ("face of two", QUAD.to_owned() + "f 1 2\n", "bad.obj:6: ", "at least 3"),
        ("index too large", QUAD.to_owned() + "f 1 2 9\n", "bad.obj:6: ", "9"),
        ("index 0", QUAD.to_owned() + "f 0 1 2\n", "bad.obj:6: ", "0"),
        ("index too negative", QUAD.to_owned() + "f -1 -2 -9\n", "bad.obj:6: ", "9"),
        ("index 2^31", QUAD.to_owned() + "f 1 2 2147483648\n", "bad.obj:6: ", "2147483648"),
        ("index 2^64", QUAD.to_owned() + "f 1 2 18446744073709551616\n", "bad.obj:6: ", "but there are 4"),
        ("NaN position", QUAD.replace("v 1 1 0", "v 1 nan 0"), "bad.obj:3: ", "nan"),
        ("infinite position", QUAD.replace("v 1 1 0", "v 1 inf 0"), "bad.obj:3: ", "inf"),
        ("overflowing position", QUAD.replace("v 1 1 0", "v 1 1e999 0"), "bad.obj:3: ", "1e999"),
        ("NaN sharpness", QUAD.to_owned() + "t crease 2/1/0 0 1 nan\n", "bad.obj:6: ", "nan"),
        ("infinite sharpness", QUAD.to_owned() + "t corner 1/1/0 0 inf\n", "bad.obj:6: ", "inf"),
        ("crease on no edge", QUAD.to_owned() + "\nt crease 2/1/0 0 2 1\n", "bad.obj:7: ", "no edge joins"),
        ("crease off the mesh", QUAD.to_owned() + "t crease 2/1/0 0 9 1\n", "bad.obj:6: ", "9"),
        ("corner off the mesh", QUAD.to_owned() + "t corner 1/1/0 4 1\n", "bad.obj:6: ", "4"),
        ("hole off the mesh", QUAD.to_owned() + "t hole 1/0/0 1\n", "bad.obj:6: ", "1"),
        ("2^31 tag values", QUAD.to_owned() + "t hole 2147483648/0/0 0\n", "bad.obj:6: ", "2147483648"),
        ("words for numbers", "v a b c\n".into(), "bad.obj:1: ", "`a`"),
        ("no text", "\u{0}\u{1}\u{2}".into(), "bad.obj: ", "no vertices (v) and no faces"),
    ];
    let folder = Folder::new();
    folder.write("at.csv", "face,subface,u,v\n0,0,0,0\n");
    for (what, text, place, words) in cases {
        folder.write("bad.obj", text);
        for verb in [
            "info",
            "refine -l 1 -o out.obj",
            "tessellate -r 2 -o out.ply",
            "eval --at at.csv -o out.csv",
            "bench",
            "render -o out.png",
        ] {
            let run = folder.run(&format!("{verb} bad.obj -q"));
            run.failed(&[place, words]);
            assert_eq!(folder.names(), ["at.csv", "bad.obj"], "{what}");
        }
    }
}

#[test]
fn a_position_too_large_for_single_precision_asks_for_double() {
    let folder = Folder::new();
    folder.write("far.obj", QUAD.replace("v 1 1 0", "v 1 1e300 0"));
    folder.run("refine far.obj -l 1 -o out.obj").failed(&["far.obj", "vertex 2", "--precision f64"]);
    folder.run("refine far.obj -l 1 -o out.obj --precision f64").done();
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let folder = Folder::new();
    folder.write("a.stl", "");
    std::fs::create_dir(folder.path("folder.obj")).unwrap();
    folder.run("info none.obj").failed(&["none.obj", "no such file"]);
    folder.run("info folder.obj").failed(&["folder.obj", "is a folder"]);
    folder.run("info a.stl").failed(&["a.stl", ".obj"]);
    folder.run_with(&["info", "-"], "v x\n").failed(&["standard input:1: "]);
}

#[test]
fn files_that_cannot_be_written_are_named_before_any_work() {
    let folder = Folder::new();
    let cube = data("cube.obj");
    std::fs::create_dir(folder.path("folder.obj")).unwrap();
    folder.run(&format!("refine {cube} -l 1 -o folder.obj")).failed(&["folder.obj", "is a folder"]);
    folder.run(&format!("refine {cube} -l 1 -o none/out.obj")).failed(&["none/out.obj", "no such folder"]);
    folder.run(&format!("refine {cube} -l 1 -o out.stl")).failed(&["out.stl", ".obj, .ply, .glb"]);
    folder.run(&format!("tessellate {cube} -r 1 -o out")).failed(&["out", ".obj, .ply, .glb"]);
    folder.run(&format!("render {cube} -o none/out.png")).failed(&["none/out.png", "no such folder"]);
    folder.run(&format!("refine {cube} -l 1 -o {cube}/out.obj")).failed(&["out.obj", "goes through a file"]);
    folder.run(&format!("figures {cube} --only ratio")).failed(&["the path goes through a file"]);
    folder.run(&format!("eval {cube} --at at.csv -o out.txt")).failed(&["out.txt", ".csv"]);
    folder.write("kept.obj", "kept");
    let mut permissions = std::fs::metadata(folder.path("kept.obj")).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(folder.path("kept.obj"), permissions).unwrap();
    folder.run(&format!("refine {cube} -l 1 -o kept.obj")).failed(&["kept.obj", "permission denied"]);
    assert_eq!(folder.text("kept.obj"), "kept");
    assert_eq!(folder.names(), ["folder.obj", "kept.obj"]);
}

#[test]
fn sizes_beyond_all_bounds_are_refused_at_once() {
    let folder = Folder::new();
    let cube = data("cube.obj");
    folder.run(&format!("refine {cube} -l 15 -o out.obj")).failed(&["cube.obj", "level 14", "corners"]);
    folder.run(&format!("refine {cube} -l 4294967295 -o out.obj")).failed(&["level 14"]);
    folder.run(&format!("tessellate {cube} -r 4294967295 -o out.obj")).failed(&["cube.obj"]);
    assert!(folder.names().is_empty());
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_no_file() {
    use std::process::{Command, Stdio};
    let folder = Folder::new();
    let mut child = Command::new(env!("CARGO_BIN_EXE_subsurf"))
        .args(["eval", &data("cube.obj"), "--at", "-", "-o", "out.csv"])
        .current_dir(folder.path(""))
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    // Enough rows to begin with, but the table never ends.
    let table = "face,subface,u,v\n".to_owned() + &"0,0,0.5,0.25\n".repeat(200_000);
    child.stdin.as_mut().unwrap().write_all(table.as_bytes()).unwrap();
    let begun = (0..600).any(|_| {
        std::thread::sleep(std::time::Duration::from_millis(50));
        !folder.names().is_empty()
    });
    assert!(begun && !folder.path("out.csv").exists(), "{:?}", folder.names());
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130));
    assert_eq!(folder.names(), Vec::<String>::new());
}

#[cfg(unix)]
#[test]
fn a_reader_who_stops_reading_is_no_failure() {
    use std::process::{Command, Stdio};
    let mut child = Command::new(env!("CARGO_BIN_EXE_subsurf"))
        .args(["refine", &data("cube.obj"), "-l", "7", "-o", "-"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr), (Some(0), Vec::new()));
}

#[test]
fn a_vertex_of_too_many_faces_is_refused_by_every_verb_that_needs_a_patch_table() {
    let folder = Folder::new();
    let n = 6000;
    let mut text = String::from("v 0 0 1\n");
    for i in 0..=n {
        let a = f64::from(i) / f64::from(n) * std::f64::consts::PI;
        text += &format!("v {} {} 0\n", a.cos(), a.sin());
    }
    (0..n).for_each(|i| text += &format!("f 1 {} {}\n", i + 2, i + 3));
    folder.write("pole.obj", &text);
    folder.write("at.csv", "face,subface,u,v\n0,0,0,0\n");
    let verbs = [
        "tessellate pole.obj -r 2 -o out.obj",
        "tessellate pole.obj --tolerance 0.1 --scheme loop -o out.obj",
        "eval pole.obj --at at.csv -o out.csv",
        "refine pole.obj -l 1 --limit -o out.obj",
        "render pole.obj -o out.png",
        "bench pole.obj -l 1 -r 1 -n 1 --json",
    ];
    for verb in verbs {
        let run = folder.run(verb);
        assert_eq!(run.status, 1, "{verb}: {}", run.stderr);
        assert!(run.stderr.contains("vertex 0 (counted from 0) has 6000 faces"), "{verb}: {}", run.stderr);
        assert!(run.stderr.contains("GB"), "{verb}: {}", run.stderr);
        assert!(!["out.obj", "out.csv", "out.png"].iter().any(|name| folder.path(name).exists()), "{verb}");
    }
    // What needs none is done.
    folder.run("refine pole.obj -l 1 -o out.obj").done();
}
