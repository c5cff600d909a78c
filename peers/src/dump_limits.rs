//! The limits that OpenSubdiv gets right, for the core's tests: one file a shape in `limits`.
//!
//! Which ones these are is told by its own tags, not by comparison with ours: `PrimvarRefiner::Limit` at vertices of level
//! 1 that are regular, extraordinary and smooth, or on regular creases and corners, with nothing semi-sharp; and jets by
//! Bfr on faces of the control mesh all corners of which are of the regular kinds and have quads (triangles under Loop)
//! all around.

use crate::conformance::cause::{Cause, causes};
use crate::conformance::place::{Place, places};
use crate::conformance::witness::face_starts;
use crate::dump_reference::{line, list, quoted};
use crate::opensubdiv::{self, Approximation, OsdLevel, Sample, VertexOrder};
use crate::shape::{Scheme, Shape};

/// Most vertices and patches of a shape, evenly chosen.
const VERTICES: usize = 12;
const PATCHES: usize = 3;
/// Where patches are sampled; dyadic so that text and number are the same.
const SAMPLES: [[f64; 2]; 2] = [[0.25, 0.125], [0.375, 0.5]];

/// None where OpenSubdiv is right nowhere, or the scheme is bilinear.
///
/// # Errors
/// What OpenSubdiv says when it refuses the mesh.
pub fn reference(shape: &Shape) -> Result<Option<String>, String> {
    if shape.scheme == Scheme::Bilinear {
        return Ok(None);
    }
    let (vertices, jets) = (vertices(shape)?, jets(shape)?);
    if vertices.is_empty() && jets.is_empty() {
        return Ok(None);
    }
    let mut text = String::new();
    line(&mut text, "{\"shape\": ", &quoted(&shape.name));
    let provenance = format!(
        "OpenSubdiv {} in double precision, written by `peers dump-reference`; the mesh is in ../{}.json.",
        opensubdiv::version(),
        shape.name
    );
    line(&mut text, ",\"provenance\": ", &quoted(&provenance));
    line(&mut text, ",\"vertices\": ", &rows(vertices));
    line(&mut text, ",\"jets\": ", &rows(jets));
    text.push_str("}\n");
    Ok(Some(text))
}

fn rows(rows: Vec<String>) -> String {
    if rows.is_empty() { "[]".into() } else { format!("[\n {}]", rows.join(",\n ")) }
}

fn right(cause: Cause) -> bool {
    matches!(cause, Cause::Regular | Cause::Crease | Cause::Corner | Cause::Extraordinary)
}

/// `[face, sub-face, u, v, [position]]` of vertices of level 1; none where OpenSubdiv cannot be asked.
fn vertices(shape: &Shape) -> Result<Vec<String>, String> {
    let level = opensubdiv::refine(shape, 1, VertexOrder::VerticesFirst)?.pop().expect("level 1");
    let Ok(limits) = opensubdiv::limit(shape, 1, VertexOrder::VerticesFirst) else { return Ok(vec![]) };
    let causes = causes(&level, shape.scheme);
    let (starts, places) = (face_starts(&level), places(shape, 1).pop().expect("level 1"));
    let mut chosen = vec![];
    for v in 0..level.positions.len() {
        if right(causes[v])
            && let Some((place, corner)) = seen_from(&level, &starts, &places, v as u32)
        {
            let [x, y] = place.corners[corner];
            let at = [place.face.to_string(), place.subface.to_string(), x.to_string(), y.to_string()].join(",");
            chosen.push(format!("[{at},{}]", point(limits[v].position)));
        }
    }
    Ok(thin(chosen, VERTICES))
}

/// The first face outside holes that has the vertex, and at which corner.
fn seen_from<'a>(level: &OsdLevel, starts: &[usize], places: &'a [Place], v: u32) -> Option<(&'a Place, usize)> {
    (0..level.face_counts.len()).filter(|&f| !level.holes[f]).find_map(|f| {
        let corner = level.face_vertices[starts[f]..starts[f + 1]].iter().position(|&w| w == v)?;
        Some((&places[f], corner))
    })
}

/// `[face, u, v, [position], [du], [dv], [duu], [duv], [dvv]]` on regular faces.
fn jets(shape: &Shape) -> Result<Vec<String>, String> {
    let level = opensubdiv::refine(shape, 0, VertexOrder::VerticesFirst)?.pop().expect("level 0");
    let causes = causes(&level, shape.scheme);
    let starts = face_starts(&level);
    let sides = if shape.scheme == Scheme::Loop { 3 } else { 4 };
    let corners = |f: usize| &level.face_vertices[starts[f]..starts[f + 1]];
    let mut around = vec![true; level.positions.len()];
    for f in 0..level.face_counts.len() {
        corners(f).iter().for_each(|&v| around[v as usize] &= corners(f).len() == sides);
    }
    let regular =
        |v: u32| around[v as usize] && matches!(causes[v as usize], Cause::Regular | Cause::Crease | Cause::Corner);
    let mut patch = 0;
    let mut samples = vec![];
    for f in 0..level.face_counts.len() {
        let n = corners(f).len();
        if n == sides && !level.holes[f] && corners(f).iter().all(|&v| regular(v)) {
            samples.push((f, patch));
        }
        patch += if n == sides { 1 } else { n as u32 };
    }
    let samples: Vec<(usize, Sample)> = thin(samples, PATCHES)
        .into_iter()
        .flat_map(|(f, ptex_face)| SAMPLES.map(|uv| (f, Sample { ptex_face, uv })))
        .collect();
    let places: Vec<Sample> = samples.iter().map(|s| s.1).collect();
    let jets = opensubdiv::eval(shape, &places, Approximation::default())?;
    let row = |(&(f, sample), jet): (&(usize, Sample), &opensubdiv::Jet)| {
        let [uu, uv, vv] = jet.second;
        let rows = [jet.position, jet.du, jet.dv, uu, uv, vv].map(point).join(",");
        format!("[{f},{},{},{rows}]", sample.uv[0], sample.uv[1])
    };
    Ok(samples.iter().zip(&jets).map(row).collect())
}

fn point(p: [f64; 3]) -> String {
    list(p.iter().map(|x| x.to_string()))
}

/// At most `most` entries, evenly chosen.
pub fn thin<T>(entries: Vec<T>, most: usize) -> Vec<T> {
    let stride = entries.len().div_ceil(most).max(1);
    entries.into_iter().step_by(stride).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_has_limits_at_its_vertices_and_no_regular_face() {
        let text = "v -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 -1\nv 1 -1 -1\n\
            f 1 2 4 3\nf 3 4 6 5\nf 5 6 8 7\nf 7 8 2 1\nf 2 8 6 4\nf 7 1 3 5";
        let shape = Shape::parse("catmark_cube", text).unwrap();
        let json: serde_json::Value = serde_json::from_str(&reference(&shape).unwrap().unwrap()).unwrap();
        assert_eq!(json["jets"].as_array().unwrap().len(), 0);
        // Vertex 0 of level 1 is corner 0 of face 0; a cube's corner goes to 5/12 of itself: 5/9 · 3/8 of it and so on.
        let first = &json["vertices"][0];
        assert_eq!((&first[0], &first[2], &first[3]), (&0.into(), &0.into(), &0.into()));
        let [x, y, z] = [0, 1, 2].map(|k| first[4][k].as_f64().unwrap());
        assert!(x < 0.0 && x == y && (x + z).abs() < 1e-15);
    }
}
