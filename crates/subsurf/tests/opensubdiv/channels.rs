//! Face-varying values against OpenSubdiv's, at face corners, under all six rules.

use crate::opensubdiv_shapes::{indices, number, rows};
use crate::reference::{has_fractions, shapes_with};
use serde_json::Value;
use subsurf::{Channel, FaceVarying, Level};

fn rule(name: &Value) -> FaceVarying {
    match name.as_str().unwrap() {
        "none" => FaceVarying::None,
        "corners-only" => FaceVarying::CornersOnly,
        "corners-plus-1" => FaceVarying::CornersPlus1,
        "corners-plus-2" => FaceVarying::CornersPlus2,
        "boundaries" => FaceVarying::Boundaries,
        "all" => FaceVarying::All,
        other => panic!("rule {other}"),
    }
}

fn pair(v: &Value) -> [f64; 2] {
    [0, 1].map(|k| number(&v[k]))
}

#[test]
fn values_at_face_corners_are_opensubdivs_under_every_rule() {
    let (mut worst, mut count) = (0.0f64, 0);
    for (shape, file) in shapes_with("channels") {
        let control = Level::new(&shape.mesh, shape.scheme).unwrap();
        let values: Vec<[f64; 2]> = rows(&file["values"]).iter().map(pair).collect();
        let corners = indices(&file["corners"]);
        let extent = |k: usize| {
            let of = |f: fn(f64, f64) -> f64| values.iter().map(|v| v[k]).reduce(f).unwrap();
            of(f64::max) - of(f64::min)
        };
        let size = extent(0).hypot(extent(1));
        // As with positions: fractional sharpness has weights in single precision there.
        let bound = if has_fractions(control.topology()) { 2e-8 } else { 1e-13 };
        for record in rows(&file["records"]) {
            let (depth, stride) = (record["level"].as_u64().unwrap(), record["stride"].as_u64().unwrap() as usize);
            for name in rows(&record["rules"]) {
                let channel =
                    Channel::face_varying(control.topology(), shape.scheme, values.len(), &corners, rule(name))
                        .unwrap();
                let mut level = channel.level();
                let mut refined = channel.rows(&values).into_owned();
                for _ in 0..depth {
                    refined = level.refine_values(&refined);
                    level = level.refine().unwrap();
                }
                let ours = level.topology().corners();
                assert_eq!(ours.len() as u64, record["count"].as_u64().unwrap(), "{}: face corners", shape.name);
                let expected = rows(&record["values"]);
                assert_eq!(expected.len(), ours.len().div_ceil(stride));
                for (corner, theirs) in (0..).step_by(stride).zip(expected) {
                    let (a, b) = (refined[ours[corner] as usize], pair(theirs));
                    let error = (a[0] - b[0]).hypot(a[1] - b[1]) / size;
                    let what = format!("{}, rule {name}, level {depth}, face corner {corner}", shape.name);
                    assert!(error <= bound, "{what}: {a:?} and {b:?}");
                    (worst, count) = (worst.max(error), count + 1);
                }
            }
        }
    }
    assert!(count > 20_000, "only {count} values");
    println!("{count} values, worst {worst:.1e} of their box");
}
