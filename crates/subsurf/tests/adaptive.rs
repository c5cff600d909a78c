//! The feature-adaptive baseline and Ptex neighbours against OpenSubdiv's: `tests/golden/adaptive/opensubdiv.json` holds its
//! counts for the shapes of `tests/golden/opensubdiv`, and says how they were made.

mod opensubdiv_shapes;

use opensubdiv_shapes::{index, rows, shapes};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use subsurf::{AdaptiveOptions, AdaptiveRefinement, PtexFaces, Topology};

/// OpenSubdiv's numbers by shape.
fn reference() -> BTreeMap<String, Value> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/adaptive/opensubdiv.json");
    let json: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    rows(&json["shapes"]).iter().map(|s| (s["shape"].as_str().unwrap().to_owned(), s.clone())).collect()
}

#[test]
fn patches_by_level_and_kind_and_vertices_by_level_are_as_many_as_opensubdivs() {
    let reference = reference();
    let mut compared = 0;
    for shape in shapes() {
        for table in rows(&reference[&shape.name]["tables"]) {
            let options = AdaptiveOptions { isolation: index(&table[0]), single_crease: table[1].as_bool().unwrap() };
            let ours = AdaptiveRefinement::new(&shape.mesh, shape.scheme, options).unwrap();
            let what = format!("{} {options:?}", shape.name);
            let vertices: Vec<usize> = rows(&table[2]).iter().map(|n| index(n) as usize).collect();
            assert_eq!(ours.vertices(), vertices, "{what}");
            let count = |row: &Value| [0, 1, 2, 3].map(|k| index(&row[k]) as usize);
            let counts: Vec<[usize; 4]> = rows(&table[3]).iter().map(count).collect();
            assert_eq!(ours.counts(), counts, "{what}");
            compared += 1;
        }
    }
    assert!(compared >= 240, "only {compared} tables");
}

#[test]
fn ptex_neighbours_are_those_of_opensubdiv() {
    let reference = reference();
    let mut compared = 0;
    for shape in shapes() {
        let Some(theirs) = reference[&shape.name].get("ptex") else { continue };
        let topology = Topology::new(&shape.mesh).unwrap();
        let ptex = PtexFaces::new(&topology, shape.scheme);
        assert_eq!(ptex.count(), rows(theirs).len(), "{}", shape.name);
        for (id, theirs) in rows(theirs).iter().enumerate() {
            let ours = ptex.neighbours(&topology, id as u32).map(|e| e.map(|e| (e.ptex_face, u32::from(e.edge))));
            let edge = |e: &Value| (!e.is_null()).then(|| (index(&e[0]), index(&e[1])));
            assert_eq!(ours, [0, 1, 2, 3].map(|i| edge(&theirs[i])), "{} Ptex face {id}", shape.name);
            compared += 1;
        }
    }
    assert!(compared >= 200, "only {compared} Ptex faces");
}
