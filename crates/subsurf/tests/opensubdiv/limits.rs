//! The limit surface against OpenSubdiv's where that one is exact. Which places these are is told by OpenSubdiv's tags; see
//! `docs/conformance.md` for the others.

use crate::opensubdiv_shapes::{index, number, point, rows};
use crate::reference::{apart, diagonal, has_fractions, shapes_with, worse};
use serde_json::Value;
use subsurf::{Face, Jet, Location, PatchTable};

/// The largest distance between two lists of vectors, relative to the longest of them.
fn apart_relative(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let longest = b.iter().map(|&x| apart(x, [0.0; 3])).fold(f64::MIN_POSITIVE, f64::max);
    a.iter().zip(b).map(|(&a, &b)| apart(a, b)).fold(0.0, worse) / longest
}

fn derivatives(jet: &Jet<3>) -> ([[f64; 3]; 2], [[f64; 3]; 3]) {
    ([jet.du, jet.dv], jet.second.expect("regular faces have second derivatives"))
}

#[test]
fn vertices_go_where_opensubdivs_limit_masks_put_them() {
    let (mut worst, mut count) = (0.0f64, 0);
    for (shape, file) in shapes_with("limits") {
        let table = PatchTable::new(&shape.mesh, shape.scheme).unwrap();
        let surface = table.surface(&shape.positions);
        let size = diagonal(&shape.positions);
        // A level of fractional sharpness has weights in single precision there, 6e-8 at most.
        let bound = if has_fractions(table.topology()) { 2e-8 } else { 1e-13 };
        for row in rows(&file["vertices"]) {
            let at = Location {
                face: Face(index(&row[0])),
                subface: index(&row[1]),
                u: number(&row[2]),
                v: number(&row[3]),
            };
            let ours = surface.position(at).expect("no hole");
            let error = apart(ours, point(&row[4])) / size;
            assert!(error <= bound, "{} {at:?}: {error:e}", shape.name);
            (worst, count) = (worst.max(error), count + 1);
        }
    }
    assert!(count > 500, "only {count} vertices");
    println!("{count} vertices, worst {worst:.1e} of the box");
}

#[test]
fn jets_on_regular_faces_are_opensubdivs() {
    let (mut worst, mut count) = ([0.0f64; 3], 0);
    for (shape, file) in shapes_with("limits") {
        let table = PatchTable::new(&shape.mesh, shape.scheme).unwrap();
        let surface = table.surface(&shape.positions);
        let size = diagonal(&shape.positions);
        for row in rows(&file["jets"]) {
            let at = Location::new(index(&row[0]), number(&row[1]), number(&row[2]));
            let jet = surface.eval_second(at).expect("no hole");
            let theirs = |k: usize| -> Value { row[k].clone() };
            let (first, second) = derivatives(&jet);
            let errors = [
                apart(jet.position, point(&theirs(3))) / size,
                apart_relative(&first, &[4, 5].map(|k| point(&theirs(k)))),
                // Second derivatives of flat parts are rounding: compared with first ones there.
                second.iter().zip([6, 7, 8]).map(|(&a, k)| apart(a, point(&theirs(k)))).fold(0.0, worse)
                    / second.iter().chain(&first).map(|&x| apart(x, [0.0; 3])).fold(0.0, f64::max),
            ];
            // Sixteen products of weights up to 1, 3 and 18 and points of a box's size.
            for (k, bound) in [1e-14, 1e-13, 1e-12].into_iter().enumerate() {
                assert!(errors[k] <= bound, "{} {at:?}, derivatives of order {k}: {:e}", shape.name, errors[k]);
                worst[k] = worst[k].max(errors[k]);
            }
            count += 1;
        }
    }
    assert!(count > 80, "only {count} jets");
    println!("{count} jets, worst {:.1e}, {:.1e}, {:.1e}", worst[0], worst[1], worst[2]);
}
