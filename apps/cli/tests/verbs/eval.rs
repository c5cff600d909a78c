use crate::program::{Folder, data};
use subsurf::{ControlMesh, Face, Location, PatchTable, Scheme, Tags};

const USUAL: &str = "face,subface,u,v,x,y,z,du_x,du_y,du_z,dv_x,dv_y,dv_z,n_x,n_y,n_z,derivatives";

fn eval(folder: &Folder, mesh: &str, table: &str, flags: &str) -> Vec<Vec<String>> {
    folder.write("at.csv", table);
    folder.run(&format!("eval {} --at at.csv -o out.csv {flags}", data(mesh))).done();
    folder.text("out.csv").lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn the_header_is_as_promised() {
    let folder = Folder::new();
    let header = |flags| eval(&folder, "cube.obj", "face,subface,u,v\n", flags)[0].join(",");
    assert_eq!(header(""), USUAL);
    let second = ",duu_x,duu_y,duu_z,duv_x,duv_y,duv_z,dvv_x,dvv_y,dvv_z";
    assert_eq!(header("--second"), format!("{USUAL}{second}"));
    assert_eq!(header("--curvature"), format!("{USUAL},k1,k2,gaussian,mean"));
    assert_eq!(header("--curvature --second"), format!("{USUAL}{second},k1,k2,gaussian,mean"));
}

#[test]
fn numbers_read_back_as_the_library_has_them_to_the_bit() {
    let folder = Folder::new();
    let cube = crate::program::mesh(&std::fs::read_to_string(data("cube.obj")).unwrap());
    let mesh = ControlMesh::from_counts(8, &[4; 6], cube.mesh.corners().to_vec(), Tags::default()).unwrap();
    let table = PatchTable::new(&mesh, Scheme::CatmullClark).unwrap();
    let surface = table.surface(&cube.positions);
    let rows = eval(&folder, "cube.obj", "face,subface,u,v\n3,0,0.3,0.7\n5,0,1e-9,0.125\n", "--second --curvature");
    for (row, (face, u, v)) in rows[1..].iter().zip([(3, 0.3, 0.7), (5, 1e-9, 0.125)]) {
        let jet = surface.eval_second(Location { face: Face(face), subface: 0, u, v }).unwrap();
        let curvature = jet.curvature().unwrap();
        let mut expected = [jet.position, jet.du, jet.dv, jet.normal().unwrap()].concat();
        expected.extend(jet.second.unwrap().concat());
        expected.extend([curvature.k1, curvature.k2, curvature.gaussian, curvature.mean]);
        let fields = row[4..16].iter().chain(&row[17..]);
        let found: Vec<f64> = fields.map(|field| field.parse().unwrap()).collect();
        assert_eq!(found, expected);
        assert_eq!(row[16], "finite");
    }
}

#[test]
fn corners_of_valence_three_vanish_and_have_no_curvature() {
    let folder = Folder::new();
    let rows = eval(&folder, "cube.obj", "face,subface,u,v\n0,0,0,0\n", "--second --curvature");
    assert_eq!(rows[1][16], "vanishes");
    assert!(rows[1][17..].iter().all(String::is_empty));
    assert_eq!(rows[1].len(), rows[0].len());
    let length: f64 = rows[1][13..16].iter().map(|x| x.parse::<f64>().unwrap().powi(2)).sum();
    assert!((length - 1.0).abs() < 1e-14);
}

#[test]
fn columns_come_in_any_order_and_rows_keep_theirs() {
    let folder = Folder::new();
    let table = "\u{feff}name, v ,u,\"face\",subface\r\na,0.5,0.25,10,2\r\n\r\nb,1,0,0,0";
    let rows = eval(&folder, "mixed_faces.obj", table, "-q");
    assert_eq!(rows.len(), 3);
    assert_eq!(rows[1][..4], ["10", "2", "0.25", "0.5"]);
    assert_eq!(rows[2][..4], ["0", "0", "0", "1"]);
}

#[test]
fn a_long_table_keeps_its_order_for_any_number_of_threads() {
    let folder = Folder::new();
    let rows: String = (0..60_000).map(|i| format!("{},0,0.{:05},0.5\n", i % 6, i)).collect();
    folder.write("at.csv", format!("face,subface,u,v\n{rows}"));
    for threads in [1, 2] {
        let cube = data("cube.obj");
        let args = format!("eval {cube} --at at.csv -o {threads}.csv --threads {threads} --json");
        assert_eq!(folder.run(&args).done().json()["rows"], 60_000);
    }
    assert!(folder.read("1.csv") == folder.read("2.csv"));
    let us: Vec<String> =
        folder.text("1.csv").lines().skip(1).map(|line| line.split(',').nth(2).unwrap().to_owned()).collect();
    assert!(us.is_sorted() && us.len() == 60_000);
}

#[test]
fn pipes_and_single_precision_work() {
    let folder = Folder::new();
    let args = ["eval", &data("cube.obj"), "--at", "-", "-o", "-", "--precision", "f32"];
    let run = folder.run_with(&args, "face,subface,u,v\n0,0,0.1,0.1\n").done();
    let row: Vec<&str> = run.stdout.lines().nth(1).unwrap().split(',').collect();
    assert!(row[4..16].iter().all(|x| x.trim_start_matches(['-', '0', '.']).len() <= 13), "{row:?}");
    assert_eq!(run.stderr, "");
}

#[test]
fn wrong_tables_are_refused_with_their_line() {
    let folder = Folder::new();
    let cases = [
        ("", "at.csv:1: ", "face,subface,u,v"),
        ("face,u,v\n0,0,0\n", "at.csv:1: ", "no column subface"),
        ("face,subface,u,v,u\n", "at.csv:1: ", "column u twice"),
        ("face,subface,u,v\n0,0,0.5\n", "at.csv:2: ", "3 fields"),
        ("face,subface,u,v\n0,0,0,0\n\n0,0,x,0.5\n", "at.csv:4: ", "u is `x`"),
        ("face,subface,u,v\n0,0,0.5,NaN\n", "at.csv:2: ", "v is `NaN`"),
        ("face,subface,u,v\n0,0,inf,0\n", "at.csv:2: ", "u is `inf`"),
        ("face,subface,u,v\n0,0,1.0000001,0\n", "at.csv:2: ", "from 0 to 1"),
        ("face,subface,u,v\n0,0,-1e-9,0\n", "at.csv:2: ", "from 0 to 1"),
        ("face,subface,u,v\n12,0,0,0\n", "at.csv:2: ", "no face 12"),
        ("face,subface,u,v\n2147483648,0,0,0\n", "at.csv:2: ", "no face 2147483648"),
        ("face,subface,u,v\n-1,0,0,0\n", "at.csv:2: ", "face is `-1`"),
        ("face,subface,u,v\n0.5,0,0,0\n", "at.csv:2: ", "face is `0.5`"),
        ("face,subface,u,v\n1,1,0,0\n", "at.csv:2: ", "no sub-face 1"),
        ("face,subface,u,v\n0,0,0,0\n3,0,0,0\n", "at.csv:3: ", "face 3 is a hole"),
        ("face,subface,u,v\n\u{0}\u{ff}\n", "at.csv:2: ", "1 fields"),
    ];
    for (table, line, words) in cases {
        folder.write("at.csv", table);
        folder.run(&format!("eval {} --at at.csv -o out.csv", data("tagged_sheet.obj"))).failed(&[line, words]);
        assert_eq!(folder.names(), ["at.csv"], "{table}");
    }
    folder.run(&format!("eval {} --at none.csv -o out.csv", data("cube.obj"))).failed(&["none.csv", "no such file"]);
    folder.run(&format!("eval {} --at . -o out.csv", data("cube.obj"))).failed(&["folder"]);
}

#[test]
fn texture_coordinates_are_extra_columns() {
    let folder = Folder::new();
    folder.write("at.csv", "face,subface,u,v\n1,0,0.5,0.5\n1,0,0,0\n");
    folder.run(&format!("eval {} --at at.csv -o out.csv --texture --face-varying all", data("mixed_faces.obj"))).done();
    let text = folder.text("out.csv");
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].ends_with(",derivatives,s,t,du_s,du_t,dv_s,dv_t,texture_derivatives"), "{}", lines[0]);
    assert!(lines[1].ends_with(",0.5,0.5,1.0,0.0,0.0,1.0,finite"), "{}", lines[1]);
    assert!(lines[2].ends_with(",0.0,0.0,1.0,0.0,0.0,1.0,finite"), "{}", lines[2]);
    folder
        .run(&format!("eval {} --at at.csv -o out.csv --texture", data("cube.obj")))
        .failed(&["has no texture coordinates", "leave out --texture"]);
}
