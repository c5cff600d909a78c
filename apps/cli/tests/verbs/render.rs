use crate::program::{Folder, data};

/// Width, height and colour type (2: RGB, 6: RGBA) of a PNG file.
fn picture(bytes: &[u8]) -> (u32, u32, u8) {
    assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.ends_with(b"IEND\xaeB`\x82"));
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    (number(16), number(20), bytes[25])
}

const SMALL: &str = "--size 96x64 --samples 2";

#[test]
fn everything_that_can_be_shown_gives_a_picture_of_its_own() {
    let folder = Folder::new();
    let mut pictures = Vec::new();
    let shows = [
        "shaded",
        "normals",
        "wireframe",
        "cage",
        "patches",
        "levels",
        "isophotes",
        "reflection-lines",
        "gaussian",
        "mean",
        "blend-weight --normals a4",
        "isophotes --edges",
        "isophotes --stripes 7",
        "isophotes --axis 1,0,0",
        "mean --range 0.1",
    ];
    for show in shows {
        folder.run(&format!("render {} -o out.png --show {show} {SMALL}", data("tagged_sheet.obj"))).done();
        assert_eq!(picture(&folder.read("out.png")), (96, 64, 2));
        pictures.push(folder.read("out.png"));
    }
    pictures.sort();
    pictures.dedup();
    assert_eq!(pictures.len(), shows.len());
}

#[test]
fn a_baseline_has_pictures_of_its_own() {
    let folder = Folder::new();
    for (mesh, scheme) in [("tagged_sheet.obj", "catmull-clark"), ("octahedron.obj", "loop")] {
        let mut pictures = Vec::new();
        for show in ["levels", "patches"] {
            for baseline in ["", "--baseline feature-adaptive"] {
                let args = format!("--scheme {scheme} --show {show} {baseline} {SMALL}");
                folder.run(&format!("render {} -o out.png {args}", data(mesh))).done();
                pictures.push(folder.read("out.png"));
            }
        }
        pictures.sort();
        pictures.dedup();
        assert_eq!(pictures.len(), 4, "{mesh}");
    }
}

#[test]
fn cameras_backgrounds_and_json() {
    let folder = Folder::new();
    let mesh = data("mixed_faces.obj");
    let run = folder.run(&format!("render {mesh} -o out.png --background transparent --json -q {SMALL}")).done();
    let json = run.json();
    assert_eq!((&json["width"], &json["height"], &json["samples"]), (&96.into(), &64.into(), &2.into()));
    assert_eq!(picture(&folder.read("out.png")).2, 6);
    folder.run(&format!("render {mesh} -o at.png --background #203040 --camera -3,2,5:0,1,0:30 {SMALL}")).done();
    folder.run(&format!("render {mesh} -o up.png --up z {SMALL}")).done();
    let piped = folder.run(&format!("render {mesh} -o - {SMALL}")).done();
    assert!(piped.stdout.contains("PNG"));
}

#[test]
fn threads_change_no_bit() {
    let folder = Folder::new();
    for (threads, name) in [(1, "one.png"), (2, "two.png")] {
        folder.run(&format!("render {} -o {name} --threads {threads} {SMALL}", data("cube.obj"))).done();
    }
    assert!(folder.read("one.png") == folder.read("two.png"));
}

#[test]
fn a_surface_of_holes_has_no_picture() {
    let folder = Folder::new();
    let mesh = data("tagged_sheet.obj");
    folder.write("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    folder.run(&format!("render {mesh} -o out.txt {SMALL}")).failed(&["out.txt", ".png"]);
    let run = folder.run(&format!("render quad.obj -o out.png --boundary none -q {SMALL}"));
    run.failed(&["quad.obj", "hole"]);
    folder.run("tessellate quad.obj -r 2 -o out.obj --boundary none -q").failed(&["quad.obj", "hole"]);
    assert_eq!(folder.names(), ["quad.obj"]);
}

#[test]
fn every_field_of_normals_has_a_picture_of_its_own() {
    let folder = Folder::new();
    // Refined, so that there is something regular between extraordinary vertices.
    folder.run(&format!("refine {} -l 2 -q -o fine.obj", data("mixed_faces.obj"))).done();
    for show in ["shaded", "normals", "isophotes", "reflection-lines"] {
        let mut pictures = Vec::new();
        let fields = ["limit", "subdivided", "a1", "a2", "a3", "a4", "a4 --blend-power 0.5"];
        for field in fields {
            let args = format!("--show {show} --normals {field} {SMALL} -q");
            folder.run(&format!("render fine.obj -o out.png {args}")).done();
            pictures.push(folder.read("out.png"));
        }
        pictures.sort();
        pictures.dedup();
        assert_eq!(pictures.len(), fields.len(), "{show}");
    }
}

#[test]
fn flat_surfaces_have_no_coloured_rounding() {
    let folder = Folder::new();
    // 3 by 3 quads on a slanted plane, with coordinates that are no binary fractions.
    let points = (0..16).map(|i| (0.1 * f64::from(i % 4), 0.1 * f64::from(i / 4)));
    let points: String = points.map(|(x, y)| format!("v {x} {y} {}\n", 0.3 * x + 0.7 * y)).collect();
    let faces: String =
        [1, 2, 3, 5, 6, 7, 9, 10, 11].map(|i| format!("f {i} {} {} {}\n", i + 1, i + 5, i + 4)).concat();
    folder.write("plane.obj", points + &faces);
    for show in ["gaussian", "mean"] {
        let run = folder.run(&format!("render plane.obj -o out.png --show {show} --json -q {SMALL}")).done();
        // 0.3 units long: its own curvature would end the scale at about 1e-6.
        assert!(run.json()["range"].as_f64().unwrap() >= 3.0, "{show}");
    }
}

#[test]
fn colours_of_curvature_fit_the_size_of_the_model() {
    let folder = Folder::new();
    let cube = std::fs::read_to_string(data("cube.obj")).unwrap();
    let scaled = cube.lines().map(|line| match line.strip_prefix("v ") {
        Some(point) => {
            let point = point.split_whitespace().map(|x| format!(" {}", 10.0 * x.parse::<f64>().unwrap()));
            format!("v{}\n", point.collect::<String>())
        }
        None => format!("{line}\n"),
    });
    folder.write("ten.obj", scaled.collect::<String>());
    for (show, power) in [("gaussian", 100.0), ("mean", 10.0)] {
        let [small, large] = [data("cube.obj"), "ten.obj".to_owned()].map(|mesh| {
            let run = folder.run(&format!("render {mesh} -o out.png --show {show} --json -q {SMALL}")).done();
            run.json()["range"].as_f64().unwrap()
        });
        // The same digits, times a power of ten that is computed.
        assert!((small / large / power - 1.0).abs() < 1e-12, "{show}: {small} {large}");
    }
    let run = folder.run(&format!("render ten.obj -o out.png --show mean --range 0.7 --json -q {SMALL}")).done();
    assert_eq!(run.json()["range"], 0.7);
    let run = folder.run(&format!("render ten.obj -o out.png --json -q {SMALL}")).done();
    assert!(run.json()["range"].is_null());
}
