//! `--scheme loop` in every verb.

use crate::program::{Folder, data, distance, mesh};
use subsurf::{Face, Location, PatchTable, Scheme};

/// Vertices, edges and faces of the octahedron.
const OCTAHEDRON: [usize; 3] = [6, 12, 8];
const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 3 4\n\nf 1 2 3 4\n";

#[test]
fn info_names_the_scheme_and_counts_what_is_extraordinary_in_it() {
    let folder = Folder::new();
    let json = folder.run(&format!("info {} --scheme loop --json", data("octahedron.obj"))).done().json();
    assert_eq!(json["scheme"], "loop");
    // One patch per triangle; every vertex has four edges, where six are ordinary.
    assert_eq!((&json["patches"], &json["extraordinary_vertices"]), (&8.into(), &6.into()));
    assert_eq!(json["creases"]["count"], 4);
    let text = folder.run(&format!("info {} --scheme loop", data("octahedron.obj"))).done().stdout;
    assert!(text.contains("not 6 inside"), "{text}");
}

#[test]
fn refine_quarters_triangles_and_continues_from_its_own_output() {
    let folder = Folder::new();
    let refine = |from: &str, level: u32, to: &str, flags: &str| {
        let run = folder.run(&format!("refine {from} -l {level} -o {to} --scheme loop --precision f64 --json {flags}"));
        (run.done().json(), mesh(&folder.text(to)))
    };
    let octahedron = data("octahedron.obj");
    let (json, two) = refine(&octahedron, 2, "two.obj", "");
    let mut counts = OCTAHEDRON;
    for _ in 0..2 {
        let [vertices, edges, faces] = counts;
        counts = [vertices + edges, 2 * edges + 3 * faces, 4 * faces];
    }
    for (what, count) in ["vertices", "edges", "faces"].into_iter().zip(counts) {
        assert_eq!(json[what], count, "{what}");
    }
    assert!(two.mesh.faces().all(|f| f.len() == 3));
    // Sharpness 1.5 is 0.5 after one step and gone after two.
    let (_, one) = refine(&octahedron, 1, "one.obj", "");
    assert!(one.mesh.tags().creases.len() == 8 && one.mesh.tags().creases.iter().all(|c| c.sharpness == 0.5));
    assert!(two.mesh.tags().creases.is_empty());
    let (_, again) = refine("one.obj", 1, "again.obj", "");
    // Edges of the first level are numbered anew when it is read, and with them the vertices on them.
    let mut same = vec![0; two.positions.len()];
    again.mesh.corners().iter().zip(two.mesh.corners()).for_each(|(&a, &b)| same[a as usize] = b);
    let moved: Vec<[f64; 3]> = same.iter().map(|&v| two.positions[v as usize]).collect();
    assert!(distance(&again.positions, &moved) < 1e-15);
    let limits = [1, 3].map(|level| refine(&octahedron, level, "limit.obj", "--limit").1.positions);
    assert!(distance(&limits[0], &limits[1][..limits[0].len()]) < 1e-14);
}

#[test]
fn tessellate_makes_triangles_whatever_the_rates_and_facets() {
    let folder = Folder::new();
    for rates in ["-r 3", "-r 4 --quads", "-r 3 --triangles", "--tolerance 0.01", "--edge-length 0.3"] {
        let octahedron = data("octahedron.obj");
        let run = folder.run(&format!("tessellate {octahedron} --scheme loop {rates} -o out.obj -v")).done();
        assert!(!run.stderr.contains("rounded up"), "{}", run.stderr);
        let scene = mesh(&folder.text("out.obj"));
        assert!(scene.mesh.faces().all(|f| f.len() == 3), "{rates}");
        // Closed, and of a sphere's kind: V - F/2 = 2.
        assert_eq!(2 * scene.positions.len(), 4 + scene.mesh.face_count(), "{rates}");
        assert!(rates != "-r 3" || scene.mesh.face_count() == 8 * 9);
    }
}

#[test]
fn eval_takes_places_in_the_triangle_and_names_the_line_of_others() {
    let folder = Folder::new();
    let run = |table: &str| {
        folder.write("at.csv", format!("face,subface,u,v\n{table}"));
        folder.run(&format!("eval {} --scheme loop --at at.csv -o out.csv --second", data("octahedron.obj")))
    };
    // Two numbers that were rounded apart may add up to a little more than 1.
    run("3,0,0.2,0.3\n0,0,0.3,0.7000000000000002\n7,0,0,1\n").done();
    let scene = mesh(&std::fs::read_to_string(data("octahedron.obj")).unwrap());
    let table = PatchTable::new(&scene.mesh, Scheme::Loop).unwrap();
    let jet =
        table.surface(&scene.positions).eval_second(Location { face: Face(3), subface: 0, u: 0.2, v: 0.3 }).unwrap();
    let text = folder.text("out.csv");
    let row: Vec<&str> = text.lines().nth(1).unwrap().split(',').collect();
    let numbers = |fields: &[&str]| -> Vec<f64> { fields.iter().map(|x| x.parse().unwrap()).collect() };
    assert_eq!(numbers(&row[4..16]), [jet.position, jet.du, jet.dv, jet.normal().unwrap()].concat());
    assert_eq!(numbers(&row[17..26]), jet.second.unwrap().concat());
    std::fs::remove_file(folder.path("out.csv")).unwrap();
    for (table, line, words) in [
        ("0,0,0.5,0.5\n0,0,0.7,0.6\n", "at.csv:3: ", "at most 1"),
        ("0,0,0.3,0.700000000000002\n", "at.csv:2: ", "at most 1"),
        ("0,1,0,0\n", "at.csv:2: ", "no sub-face 1"),
    ] {
        run(table).failed(&[line, words]);
        assert_eq!(folder.names(), ["at.csv"], "{table}");
    }
}

#[test]
fn render_shows_everything() {
    let folder = Folder::new();
    for show in ["shaded", "wireframe", "cage", "patches", "levels"] {
        let octahedron = data("octahedron.obj");
        folder
            .run(&format!("render {octahedron} --scheme loop -o {show}.png --show {show} --size 96x64 --samples 2"))
            .done();
    }
    assert!(folder.read("patches.png") != folder.read("levels.png"));
}

#[test]
fn faces_that_are_no_triangles_are_refused_by_face_and_line() {
    let folder = Folder::new();
    folder.write("at.csv", "face,subface,u,v\n0,0,0,0\n");
    folder.write("bad.obj", QUAD);
    for verb in [
        "info",
        "refine -l 1 -o out.obj",
        "tessellate -r 2 -o out.ply",
        "eval --at at.csv -o out.csv",
        "render -o out.png",
    ] {
        let run = folder.run(&format!("{verb} bad.obj --scheme loop -q"));
        run.failed(&["bad.obj:9: ", "face 2 has 4 corners", "--split-polygons"]);
        assert_eq!(folder.names(), ["at.csv", "bad.obj"]);
    }
}

#[test]
fn a_level_beyond_32_bits_is_refused_at_once() {
    let folder = Folder::new();
    folder
        .run(&format!("refine {} -l 40 -o out.obj --scheme loop", data("octahedron.obj")))
        .failed(&["level 14", "corners"]);
}

/// A quad that is shorter from its second corner to its fourth, a triangle beside it and a pentagon hole, with textures.
const POLYGONS: &str = "v 0 0 0\nv 1 0 0\nv 3 2 0\nv 0 1 0\nv 2 -1 0\nv -1 3 0\nv -2 1 0\nv -1 0 0\n\
    vt 0 0\nvt 0.1 0\nvt 0.2 0\nvt 0.3 0\n\
    f 1/1 2/2 3/3 4/4\nf 2/2 5/1 3/3\nf 1/1 4/2 6/3 7/4 8/1\n\
    t crease 2/1/0 1 2 2.5\nt hole 1/0/0 2\n";

#[test]
fn polygons_are_split_with_their_tags_and_texture_coordinates() {
    let folder = Folder::new();
    folder.write("in.obj", POLYGONS);
    folder.run("refine in.obj -l 0 -o out.obj --scheme loop --split-polygons --precision f64 -q").done();
    let scene = mesh(&folder.text("out.obj"));
    let faces: Vec<&[u32]> = scene.mesh.faces().collect();
    assert_eq!(faces[..3], [[1, 2, 3], [0, 1, 3], [1, 4, 2]]);
    assert_eq!((faces.len(), &scene.mesh.tags().holes[..]), (6, &[3, 4, 5][..]));
    assert!(scene.mesh.tags().creases.iter().any(|c| c.vertices == [1, 2] && c.sharpness == 2.5));
    let json = folder.run("info in.obj --scheme loop --split-polygons --json").done().json();
    assert_eq!((&json["faces"], &json["patches"]), (&6.into(), &3.into()));
    folder.write("at.csv", "face,subface,u,v\n1,0,0.25,0.5\n");
    for verb in [
        "tessellate in.obj -r 3 -o out.glb",
        "eval in.obj --at at.csv -o out.csv",
        "render in.obj -o out.png --size 48x32 --samples 1",
    ] {
        folder.run(&format!("{verb} --scheme loop --split-polygons")).done();
    }
}
