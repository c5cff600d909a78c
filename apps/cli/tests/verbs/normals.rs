//! `--normals` and what goes with it, in every verb that has it.

use crate::program::{Folder, data, mesh, worse};
use subsurf::{
    Averaging, Blend, Face, Location, NormalField, PatchTable, Power, Scheme, ShadingNormals, ShadingOptions,
};

const PLACES: [(u32, f64, f64); 4] = [(1, 0.0, 0.0), (1, 0.1, 0.05), (3, 0.3, 0.7), (7, 1.0, 1.0)];

/// The rows of `eval` at [`PLACES`], without the header.
fn eval(folder: &Folder, name: &str, flags: &str) -> Vec<Vec<String>> {
    let rows: String = PLACES.iter().map(|(face, u, v)| format!("{face},0,{u},{v}\n")).collect();
    folder.write("at.csv", format!("face,subface,u,v\n{rows}"));
    folder.run(&format!("eval {name} --at at.csv -o out.csv {flags}")).done();
    folder.text("out.csv").lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

/// A mesh with extraordinary vertices and regular parts between them, where blends differ.
fn fine(folder: &Folder) -> String {
    folder.run(&format!("refine {} -l 2 --precision f64 -q -o fine.obj", data("mixed_faces.obj"))).done();
    folder.path("fine.obj").display().to_string()
}

fn numbers(fields: &[String]) -> Vec<f64> {
    fields.iter().map(|field| field.parse().unwrap()).collect()
}

fn normal(row: &[String]) -> Vec<f64> {
    numbers(&row[13..16])
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, worse)
}

#[test]
fn limit_is_the_default() {
    let folder = Folder::new();
    let mixed = data("mixed_faces.obj");
    assert_eq!(eval(&folder, &mixed, ""), eval(&folder, &mixed, "--normals limit"));
    for verb in ["tessellate -r 2 -o out.obj", "render -o out.png --size 48x32 --samples 1"] {
        folder.run(&format!("{verb} {mixed}")).done();
        let name = folder.names().into_iter().find(|name| name.starts_with("out.") && name != "out.csv").unwrap();
        let default = folder.read(&name);
        folder.run(&format!("{verb} {mixed} --normals limit")).done();
        assert!(default == folder.read(&name), "{verb}");
        std::fs::remove_file(folder.path(&name)).unwrap();
    }
}

#[test]
fn at_an_extraordinary_vertex_the_blend_is_the_subdivided_normal() {
    let folder = Folder::new();
    let mixed = data("mixed_faces.obj");
    let [limit, subdivided, a2, a4] = ["limit", "subdivided", "a2 --blend-weight", "a4 --blend-weight"]
        .map(|field| eval(&folder, &mixed, &format!("--normals {field}")));
    // The first place is a vertex of three faces, one of them a pentagon.
    assert_eq!(numbers(&a4[0][17..]), [1.0]);
    // Two tables, of different levels, give the same normal to rounding.
    assert!(difference(&normal(&a4[0]), &normal(&subdivided[0])) < 1e-13);
    assert!(difference(&normal(&limit[0]), &normal(&subdivided[0])) > 1e-3);
    let [b] = numbers(&a2[0][17..])[..] else { panic!("one column more") };
    assert!(b > 0.2 && b < 0.999, "{b}");
    assert!(difference(&normal(&a2[0]), &normal(&subdivided[0])) > 1e-5);
}

#[test]
fn options_reach_the_library() {
    let folder = Folder::new();
    let name = fine(&folder);
    let scene = mesh(&std::fs::read_to_string(&name).unwrap());
    let table = PatchTable::new(&scene.mesh, Scheme::CatmullClark).unwrap();
    let surface = table.surface(&scene.positions);
    let field = NormalField::Blended(Blend::A4);
    let plain = ShadingOptions { field, ..ShadingOptions::default() };
    let cases = [
        ("", plain.clone()),
        ("--blend-power 2.5", ShadingOptions { power: Power::Uniform(2.5), ..plain.clone() }),
        ("--weight-level 2", ShadingOptions { weights_level: 2, ..plain.clone() }),
        ("--normal-level 2", ShadingOptions { normals_level: 2, ..plain.clone() }),
        ("--averaging spherical:2", ShadingOptions { averaging: Averaging::Spherical(2), ..plain.clone() }),
        ("--averaging linear --crease-sharpness 3", ShadingOptions { crease_sharpness: 3.0, ..plain }),
    ];
    let mut all = Vec::new();
    for (flags, options) in cases {
        let shading = ShadingNormals::new(&table, &scene.positions, &options).unwrap();
        let rows = eval(&folder, &name, &format!("--normals a4 --blend-weight {flags}"));
        for (row, (face, u, v)) in rows.iter().zip(PLACES) {
            let at = Location { face: Face(face), subface: 0, u, v };
            let jet = surface.eval(at).unwrap();
            assert_eq!(normal(row), shading.normal(at, &jet).unwrap(), "{flags}");
            assert_eq!(numbers(&row[17..]), [shading.blend_weight(at)], "{flags}");
        }
        all.push(rows);
    }
    // All but the sharpness, which this mesh has none of, make a difference.
    (1..5).for_each(|i| assert_ne!(all[0], all[i], "case {i}"));
    assert_eq!(all[0], all[5]);
}

#[test]
fn the_blend_weight_comes_before_texture_coordinates() {
    let folder = Folder::new();
    let mixed = data("mixed_faces.obj");
    folder.write("at.csv", "face,subface,u,v\n");
    let flags = "--texture --second --curvature --blend-weight --normals a3";
    folder.run(&format!("eval {mixed} --at at.csv -o out.csv {flags}")).done();
    let header = folder.text("out.csv");
    assert!(header.ends_with(",dvv_z,k1,k2,gaussian,mean,b,s,t,du_s,du_t,dv_s,dv_t,texture_derivatives\n"), "{header}");
}

#[test]
fn tessellations_carry_the_normals() {
    let folder = Folder::new();
    let name = fine(&folder);
    let written = |field: &str| {
        let run = folder.run(&format!("tessellate {name} -r 4 --precision f64 --normals {field} -o -"));
        mesh(&run.done().stdout)
    };
    let [limit, subdivided, a4] = ["limit", "subdivided", "a4"].map(written);
    assert_eq!(limit.positions, a4.positions);
    let scene = mesh(&std::fs::read_to_string(&name).unwrap());
    let table = PatchTable::new(&scene.mesh, Scheme::CatmullClark).unwrap();
    let shading = ShadingNormals::new(&table, &scene.positions, &ShadingOptions::default()).unwrap();
    let options = subsurf::TessellateOptions { rates: subsurf::Rates::Uniform(4), ..Default::default() };
    let expected = table.surface(&scene.positions).tessellate_shaded(&options, &shading).unwrap();
    let [limit, subdivided, a4] = [limit, subdivided, a4].map(|scene| scene.normals.unwrap().values);
    assert_eq!(a4, expected.normals);
    assert!(limit != a4 && subdivided != a4 && limit != subdivided);
}

#[test]
fn normals_of_the_file_are_subdivided_when_asked_for() {
    let folder = Folder::new();
    let cube = std::fs::read_to_string(data("cube.obj")).unwrap();
    // The same normal at every corner, which subdivision keeps.
    let faces = cube.lines().map(|line| match line.strip_prefix("f ") {
        Some(corners) => {
            let corners = corners.split_whitespace().map(|c| format!(" {}//1", c.split('/').next().unwrap()));
            format!("f{}\n", corners.collect::<String>())
        }
        None => format!("{line}\n"),
    });
    folder.write("own.obj", format!("vn 0 0.6 0.8\n{}", faces.collect::<String>()));
    let rows: Vec<_> = PLACES[..3].iter().map(|(face, u, v)| format!("{face},0,{u},{v}\n")).collect();
    folder.write("at.csv", format!("face,subface,u,v\n{}", rows.concat()));
    folder.run("eval own.obj --at at.csv -o out.csv --normals subdivided --file-normals").done();
    for line in folder.text("out.csv").lines().skip(1) {
        let row: Vec<String> = line.split(',').map(str::to_owned).collect();
        assert!(difference(&normal(&row), &[0.0, 0.6, 0.8]) < 1e-15, "{line}");
    }
    let cube = data("cube.obj");
    for verb in ["eval --at at.csv -o out.csv", "tessellate -r 2 -o out.ply", "render -o out.png"] {
        let run = folder.run(&format!("{verb} {cube} --normals a4 --file-normals"));
        run.failed(&["cube.obj", "no vertex normals", "leave out --file-normals"]);
    }
}

#[test]
fn options_without_effect_are_wrong_usage() {
    let folder = Folder::new();
    let cube = data("cube.obj");
    folder.write("at.csv", "face,subface,u,v\n0,0,0,0\n");
    for verb in ["eval --at at.csv -o out.csv", "tessellate -r 2 -o out.obj", "render -o out.png"] {
        for (flags, words) in [
            ("--normals a5", "a5"),
            ("--normals a4 --blend-power 0", "above 0"),
            ("--normals a4 --blend-power -1", "above 0"),
            ("--normals a4 --blend-power nan", "above 0"),
            ("--normals a4 --crease-sharpness 0", "above 0"),
            ("--normals a4 --averaging round", "spherical:K"),
            ("--normals a4 --weight-level -1", "-1"),
            ("--normals a4 --normal-level 99", "99"),
            ("--blend-power 2", "add --normals a4"),
            ("--normals subdivided --weight-level 1", "add --normals a4"),
            ("--normal-level 1", "add --normals subdivided"),
            ("--averaging linear", "add --normals subdivided"),
            ("--file-normals", "add --normals subdivided"),
            ("--normals a4 --file-normals --normal-level 1", "leave out --normal-level"),
        ] {
            let run = folder.run(&format!("{verb} {cube} {flags}"));
            assert_eq!(run.status, 2, "{}: {}", run.args, run.stderr);
            assert!(run.stderr.contains(words), "{}: {}", run.args, run.stderr);
        }
    }
    for (args, words) in [
        ("eval --at at.csv -o out.csv --blend-weight", "add --normals a4"),
        ("eval --at at.csv -o out.csv --blend-weight --normals subdivided", "add --normals a4"),
        ("render -o out.png --show blend-weight", "add --normals a4"),
        ("render -o out.png --show blend-weight --normals subdivided", "add --normals a4"),
        ("render -o out.png --show mean --normals a4", "leave out --normals"),
        ("render -o out.png --stripes 9", "--show isophotes"),
        ("render -o out.png --show mean --axis 1,0,0", "--show isophotes"),
        ("render -o out.png --show isophotes --axis 0,0,0", "x,y,z"),
        ("render -o out.png --show isophotes --stripes 0", "0"),
        ("render -o out.png --show isophotes --range 2", "--show gaussian"),
        ("render -o out.png --show mean --range -2", "above 0"),
    ] {
        let run = folder.run(&format!("{args} {cube}"));
        assert_eq!(run.status, 2, "{args}: {}", run.stderr);
        assert!(run.stderr.contains(words), "{args}: {}", run.stderr);
    }
    assert_eq!(folder.names(), ["at.csv"]);
}
