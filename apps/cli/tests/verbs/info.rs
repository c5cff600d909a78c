use crate::program::{Folder, data};

#[test]
fn a_cube_is_described_for_machines() {
    let json = Folder::new().run(&format!("info {} --json", data("cube.obj"))).done().json();
    assert_eq!((&json["faces"], &json["vertices"], &json["edges"]), (&6.into(), &8.into(), &12.into()));
    assert_eq!(json["sides"]["4"], 6);
    assert_eq!(json["valences"]["interior"]["3"], 8);
    assert_eq!(json["euler_characteristic"], 2);
    assert_eq!(json["boundary_loops"], 0);
    assert_eq!(json["components"], 1);
    assert_eq!((&json["patches"], &json["plans"]), (&6.into(), &1.into()));
    assert!(json["table_bytes"].as_u64().unwrap() > 0);
    assert_eq!(json["rules"]["boundary"], "edge-and-corner");
    assert_eq!(json["scheme"], "catmull-clark");
    assert_eq!(json["bounding_box"]["max"], serde_json::json!([1.0, 1.0, 1.0]));
}

#[test]
fn tags_boundaries_and_channels_are_counted() {
    let folder = Folder::new();
    let json = folder.run(&format!("info {} --json", data("tagged_sheet.obj"))).done().json();
    assert_eq!(json["creases"]["count"], 4);
    assert_eq!(json["creases"]["infinite"], 1);
    assert_eq!((&json["creases"]["min"], &json["creases"]["max"]), (&1.5.into(), &10.0.into()));
    assert_eq!(json["corners"]["count"], 2);
    assert_eq!(json["holes"]["in_force"], 1);
    assert_eq!((&json["boundary_edges"], &json["boundary_loops"]), (&14.into(), &1.into()));
    let json = folder.run(&format!("info {} --json", data("mixed_faces.obj"))).done().json();
    assert_eq!(json["sides"], serde_json::json!({ "3": 5, "4": 5, "5": 1 }));
    assert_eq!(json["channels"]["texture_coordinates"]["values"], 4);
    assert!(json["channels"]["texture_coordinates"]["seam_edges"].as_u64().unwrap() > 0);
}

#[test]
fn what_is_no_manifold_is_reported_and_warned_of_by_refine() {
    let folder = Folder::new();
    let json = folder.run(&format!("info {} --json", data("three_sheets.obj"))).done().json();
    assert_eq!((&json["non_manifold_edges"], &json["winding_conflicts"]), (&1.into(), &1.into()));
    assert_eq!(json["isolated_vertices"], 1);
    let run = folder.run(&format!("refine {} -l 1 -o out.obj", data("three_sheets.obj"))).done();
    assert!(run.stderr.contains("1 non-manifold edge made infinitely sharp (vertices 0 and 1)"), "{}", run.stderr);
    assert!(run.stderr.contains("1 edge between faces of opposite winding"), "{}", run.stderr);
    assert!(run.stderr.contains("1 vertex without faces left alone (vertex 10)"), "{}", run.stderr);
    let quiet = folder.run(&format!("refine {} -l 1 -o out.obj -q", data("three_sheets.obj"))).done();
    assert_eq!(quiet.stderr, "");
}

#[test]
fn text_is_aligned_and_without_colours_in_a_pipe() {
    let text = Folder::new().run(&format!("info {}", data("tagged_sheet.obj"))).done().stdout;
    assert!(text.contains("  faces                 12  12 quads\n"), "{text}");
    assert!(text.contains("sharpness 1.5 to 10, 1 infinite"), "{text}");
    assert!(!text.contains('\x1b'));
}

#[test]
fn flags_win_over_the_file_and_the_file_over_the_preset() {
    let folder = Folder::new();
    let sheet = std::fs::read_to_string(data("tagged_sheet.obj")).unwrap();
    folder.write("file.obj", sheet + "t interpolateboundary 1/0/0 2\nt creasemethod 0/0/1 chaikin\n");
    let boundary = |flags: &str| {
        let json = folder.run(&format!("info file.obj --json {flags}")).done().json();
        ["boundary", "creasing", "face_varying"].map(|rule| json["rules"][rule].as_str().unwrap().to_owned())
    };
    assert_eq!(boundary(""), ["edge-only", "chaikin", "corners-plus1"]);
    assert_eq!(boundary("--preset opensubdiv"), ["edge-only", "chaikin", "all"]);
    assert_eq!(boundary("--preset opensubdiv --boundary none --creasing uniform"), ["none", "uniform", "all"]);
    assert_eq!(boundary("--face-varying corners-only"), ["edge-only", "chaikin", "corners-only"]);
}

#[test]
fn a_pole_too_large_for_a_patch_table_is_still_described() {
    let folder = Folder::new();
    let mut text = String::from("v 0 0 1\n");
    let n = 20_000;
    for i in 0..n {
        let a = f64::from(i) / f64::from(n) * std::f64::consts::TAU;
        text += &format!("v {} {} 0\n", a.cos(), a.sin());
    }
    for i in 0..n {
        text += &format!("f 1 {} {}\n", i + 2, (i + 1) % n + 2);
    }
    folder.write("pole.obj", &text);
    let run = folder.run("info pole.obj --json");
    assert_eq!(run.status, 0, "{}", run.stderr);
    assert!(run.stderr.contains("no patch table"), "{}", run.stderr);
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!((&json["faces"], &json["plans"]), (&20_000.into(), &serde_json::Value::Null));
}

#[test]
fn the_baseline_is_counted_on_request_and_costs_less_with_single_crease_patches() {
    let folder = Folder::new();
    let info = |args: &str| folder.run(&format!("info {} --json {args}", data("tagged_sheet.obj"))).done().json();
    assert!(info("")["baseline"].is_null());
    let patches = |which: &str, isolation: u32| {
        let baseline = &info(&format!("--baseline {which} --isolation {isolation}"))["baseline"];
        assert_eq!((&baseline["baseline"], &baseline["isolation"]), (&which.into(), &isolation.into()));
        let kinds = baseline["kinds"].as_object().unwrap().values().map(|n| n.as_u64().unwrap());
        let levels = baseline["levels"].as_array().unwrap();
        let by_level =
            levels.iter().flat_map(|l| l["patches"].as_object().unwrap().values().map(|n| n.as_u64().unwrap()));
        let total = baseline["patches"].as_u64().unwrap();
        assert_eq!([kinds.sum::<u64>(), by_level.sum()], [total; 2]);
        total
    };
    assert!(patches("feature-adaptive-single-crease", 3) <= patches("feature-adaptive", 3));
    assert!(patches("feature-adaptive", 3) < patches("feature-adaptive", 6));
    let text = folder.run(&format!("info {} --baseline feature-adaptive", data("cube.obj"))).done().stdout;
    assert!(text.contains("feature-adaptive, isolation level 4"), "{text}");
    // Four corners of each of six faces, all of valence 3.
    assert!(text.contains("24 end cap"), "{text}");
}
