use crate::program::{Folder, data};

#[test]
fn every_figure_is_there_and_above_zero() {
    let folder = Folder::new();
    for (mesh, args) in [
        ("cube.obj", "--precision f64"),
        ("mixed_faces.obj", "--threads 1"),
        ("octahedron.obj", "--scheme loop"),
        ("tagged_sheet.obj", "--boundary edge-only"),
    ] {
        let run = folder.run(&format!("bench {} --level 2 --rate 3 --samples 100 {args} --json", data(mesh))).done();
        let json = run.json();
        for path in [
            "/threads",
            "/faces",
            "/build_s",
            "/build_peak_bytes",
            "/table_bytes",
            "/plans",
            "/refine/cold_s",
            "/refine/warm_s",
            "/refine/vertices",
            "/refine/peak_bytes",
            "/tessellate/cold_s",
            "/tessellate/warm_s",
            "/tessellate/vertices",
            "/tessellate/peak_bytes",
            "/eval/by_face_ns",
            "/eval/random_ns",
            "/write_floor_s",
        ] {
            let figure = json.pointer(path).and_then(serde_json::Value::as_f64);
            assert!(figure.is_some_and(|x| x > 0.0), "{mesh} {path}: {json}");
        }
        let expected = if args.contains("f64") { "f64" } else { "f32" };
        assert_eq!(json["precision"], expected);
    }
}

#[test]
fn counts_are_those_of_the_other_verbs() {
    let folder = Folder::new();
    let mesh = data("mixed_faces.obj");
    let bench = folder.run(&format!("bench {mesh} -l 2 -r 4 -n 10 --json")).done().json();
    let refined = folder.run(&format!("refine {mesh} -l 2 -o refined.ply --json")).done().json();
    let tessellated = folder.run(&format!("tessellate {mesh} -r 4 -o tessellated.ply --json")).done().json();
    let info = folder.run(&format!("info {mesh} --json")).done().json();
    assert_eq!(bench["refine"]["vertices"], refined["vertices"]);
    assert_eq!(bench["tessellate"]["vertices"], tessellated["vertices"]);
    assert_eq!(bench["faces"], info["faces"]);
}

#[test]
fn a_peak_is_at_least_the_output() {
    let folder = Folder::new();
    let json = folder.run(&format!("bench {} -l 4 -r 16 -n 10 --json", data("cube.obj"))).done().json();
    for verb in ["refine", "tessellate"] {
        let figure = |name: &str| json[verb][name].as_u64().unwrap();
        // Three numbers of four bytes a vertex, and as many quads with four indices.
        assert!(figure("output_bytes") > 28 * (figure("vertices") - 2), "{json}");
        assert!(figure("peak_bytes") >= figure("output_bytes"), "{json}");
    }
}

#[test]
fn without_json_there_is_a_table_to_read() {
    let run = Folder::new().run(&format!("bench {} -l 1 -r 2 -n 10 --threads 1", data("cube.obj"))).done();
    for word in ["cube.obj", "1 thread, f32", "build", "plans", "a sample by face", "write floor", "level 1", "rate 2"]
    {
        assert!(run.stdout.contains(word), "{word}: {}", run.stdout);
    }
}

#[test]
fn what_cannot_be_measured_is_refused_before_work() {
    let folder = Folder::new();
    let cube = data("cube.obj");
    folder.run(&format!("bench {cube} --level 40")).failed(&["cube.obj", "level 14 is too large", "corners"]);
    folder.run(&format!("bench {cube} --rate 4000000000")).failed(&["cube.obj", "rate 4000000000"]);
    folder.write("hole.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nt hole 1/0/0 0\n");
    folder.run("bench hole.obj").failed(&["hole.obj", "every face is a hole"]);
    for wrong in ["--rate 0", "--samples 0", "--level x"] {
        assert_eq!(folder.run(&format!("bench {cube} {wrong}")).status, 2, "{wrong}");
    }
}
