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
    for show in ["shaded", "normals", "wireframe", "cage", "patches", "levels"] {
        folder.run(&format!("render {} -o out.png --show {show} {SMALL}", data("tagged_sheet.obj"))).done();
        assert_eq!(picture(&folder.read("out.png")), (96, 64, 2));
        pictures.push(folder.read("out.png"));
    }
    pictures.sort();
    pictures.dedup();
    assert_eq!(pictures.len(), 6);
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
