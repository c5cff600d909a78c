//! `peers dump-reference`: OpenSubdiv's refinement of the regression shapes as JSON files that tests of the core read
//! without OpenSubdiv. One file a shape: the control mesh, then levels 0 to 3, under Loop 0 to 2. A list of more than `LONGEST` entries
//! keeps its first `HEAD` ones; its length and the hash of all of it are always given. Beside them limits and
//! face-varying values.

use crate::opensubdiv::{self, OsdLevel, VertexOrder};
use crate::shape::{Scheme, Shape, shapes};
use crate::{dump_channels, dump_limits};
use std::fmt::Write;
use std::path::Path;
use subsurf::{Boundary, Creasing, Triangles};

pub const LEVELS: u32 = 3;
/// Under Loop, where a level more shows nothing new.
const LOOP_LEVELS: u32 = 2;
const LONGEST: usize = 400;
const HEAD: usize = 64;
/// Most positions kept of a level.
const POSITIONS: usize = 300;

pub fn run(models: &Path, out: &Path) -> Result<(), String> {
    std::fs::create_dir_all(out).map_err(|e| format!("{}: {e}", out.display()))?;
    let mut total = 0;
    for shape in shapes(models, &["catmark_", "bilinear_", "loop_"])? {
        let text = reference(&shape)?;
        let path = out.join(format!("{}.json", shape.name));
        std::fs::write(&path, &text).map_err(|e| format!("{}: {e}", path.display()))?;
        println!("{:8} {}", text.len(), path.display());
        total += text.len();
        for (folder, text) in
            [("limits", dump_limits::reference(&shape)?), ("channels", dump_channels::reference(&shape)?)]
        {
            let Some(text) = text else { continue };
            let path = out.join(folder).join(format!("{}.json", shape.name));
            std::fs::create_dir_all(out.join(folder)).map_err(|e| format!("{}: {e}", out.display()))?;
            std::fs::write(&path, &text).map_err(|e| format!("{}: {e}", path.display()))?;
            println!("{:8} {}", text.len(), path.display());
            total += text.len();
        }
    }
    println!("{total:8} bytes in all");
    Ok(())
}

fn reference(shape: &Shape) -> Result<String, String> {
    let last = if shape.scheme == Scheme::Loop { LOOP_LEVELS } else { LEVELS };
    let levels = opensubdiv::refine(shape, last, VertexOrder::VerticesFirst)?;
    let mut text = String::new();
    let scheme = match shape.scheme {
        Scheme::Bilinear => "bilinear",
        Scheme::CatmullClark => "catmull-clark",
        Scheme::Loop => "loop",
    };
    line(&mut text, "{\"shape\": ", &quoted(&shape.name));
    line(&mut text, ",\"scheme\": ", &quoted(scheme));
    let provenance = format!(
        "Control mesh: OpenSubdiv's regression/shapes/{}.h, Modified Apache License 2.0 (see LICENSE and NOTICE). \
         Levels: OpenSubdiv {} in double precision, written by `peers dump-reference`.",
        shape.name,
        opensubdiv::version()
    );
    line(&mut text, ",\"provenance\": ", &quoted(&provenance));
    write_mesh(&mut text, shape);
    for (number, level) in levels.iter().enumerate() {
        text.push_str(if number == 0 { ",\"levels\": [\n" } else { ",\n" });
        write_level(&mut text, number, level);
    }
    text.push_str("]}\n");
    Ok(text)
}

fn write_mesh(text: &mut String, shape: &Shape) {
    let tags = &shape.tags;
    let boundary = match tags.rules.boundary {
        Boundary::None => "none",
        Boundary::EdgeOnly => "edge-only",
        Boundary::EdgeAndCorner => "edge-and-corner",
    };
    let creasing = match tags.rules.creasing {
        Creasing::Uniform => "uniform",
        Creasing::Chaikin => "chaikin",
    };
    let triangles = match tags.rules.triangles {
        Triangles::CatmullClark => "catmull-clark",
        Triangles::Smooth => "smooth",
    };
    let creases = tags.creases.iter().map(|c| format!("[{},{},{}]", c.vertices[0], c.vertices[1], c.sharpness as f32));
    let corners = tags.corners.iter().map(|c| format!("[{},{}]", c.vertex, c.sharpness as f32));
    line(text, ",\"mesh\": {\"boundary\": ", &quoted(boundary));
    line(text, " ,\"creasing\": ", &quoted(creasing));
    line(text, " ,\"triangles\": ", &quoted(triangles));
    line(text, " ,\"positions\": ", &list(shape.positions.iter().map(|p| numbers(p))));
    line(text, " ,\"face_counts\": ", &numbers(&shape.counts));
    line(text, " ,\"corners\": ", &numbers(&shape.indices));
    line(text, " ,\"sharp_edges\": ", &list(creases));
    line(text, " ,\"sharp_vertices\": ", &list(corners));
    line(text, " ,\"holes\": ", &(numbers(&tags.holes) + "}"));
}

fn write_level(text: &mut String, number: usize, level: &OsdLevel) {
    let (vertices, edges, faces) = (level.positions.len(), level.edges.len(), level.holes.len());
    line(text, " {\"level\": ", &number.to_string());
    line(text, " ,\"vertices\": ", &vertices.to_string());

    let mut corner = 0;
    let face_lists: Vec<&[u32]> = level
        .face_counts
        .iter()
        .map(|&n| {
            corner += n as usize;
            &level.face_vertices[corner - n as usize..corner]
        })
        .collect();
    let face_words = face_lists.iter().flat_map(|f| [f.len() as u32].into_iter().chain(f.iter().copied()));
    write_list(text, "faces", faces, face_words, |f| numbers(face_lists[f]));

    let edge_words = level.edges.iter().flatten().copied();
    write_list(text, "edges", edges, edge_words, |e| numbers(&level.edges[e]));
    write_sharpness(text, "sharp_edges", &level.edge_sharpness);
    write_sharpness(text, "sharp_vertices", &level.vertex_sharpness);
    write_flags(text, "holes", &level.holes);
    write_flags(text, "non_manifold_edges", &level.edge_non_manifold);
    write_flags(text, "non_manifold_vertices", &level.vertex_non_manifold);

    let stride = vertices.div_ceil(POSITIONS);
    line(text, " ,\"position_stride\": ", &stride.to_string());
    let positions = level.positions.iter().step_by(stride).filter(|_| number > 0);
    line(text, " ,\"positions\": ", &(list(positions.map(|p| numbers(p))) + "}"));
}

/// `"name": {"count": how many, "hash": of all words, "first": the entries}`.
fn write_list(
    text: &mut String,
    name: &str,
    count: usize,
    words: impl Iterator<Item = u32>,
    entry: impl Fn(usize) -> String,
) {
    let kept = if count <= LONGEST { count } else { HEAD };
    let entries = list((0..kept).map(entry));
    let value = format!("{{\"count\": {count}, \"hash\": \"{:016x}\", \"first\": {entries}}}", fnv1a(words));
    line(text, &format!(" ,\"{name}\": "), &value);
}

/// The entries that are not zero, as pairs of index and sharpness; hashed as index and bits of the `f32`.
fn write_sharpness(text: &mut String, name: &str, sharpness: &[f32]) {
    let sharp: Vec<(usize, f32)> = sharpness.iter().copied().enumerate().filter(|&(_, s)| s > 0.0).collect();
    let words = sharp.iter().flat_map(|&(i, s)| [i as u32, s.to_bits()]);
    write_list(text, name, sharp.len(), words, |i| format!("[{},{}]", sharp[i].0, sharp[i].1));
}

fn write_flags(text: &mut String, name: &str, flags: &[bool]) {
    let set: Vec<u32> = (0..flags.len() as u32).filter(|&i| flags[i as usize]).collect();
    write_list(text, name, set.len(), set.iter().copied(), |i| set[i].to_string());
}

/// 64-bit FNV-1a over the bytes of the words, low byte first.
fn fnv1a(words: impl Iterator<Item = u32>) -> u64 {
    let bytes = words.flat_map(u32::to_le_bytes);
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

pub fn line(text: &mut String, start: &str, value: &str) {
    writeln!(text, "{start}{value}").expect("writing to a string succeeds");
}

pub fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

pub fn list(entries: impl Iterator<Item = String>) -> String {
    format!("[{}]", entries.collect::<Vec<_>>().join(","))
}

/// Shortest form that reads back as the same number.
pub fn numbers<T: std::fmt::Display>(values: &[T]) -> String {
    list(values.iter().map(|x| x.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_is_json_with_the_known_counts() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nt crease 2/1/0 0 1 10";
        let shape = Shape::parse("catmark_quad", text).unwrap();
        let json: serde_json::Value = serde_json::from_str(&reference(&shape).unwrap()).unwrap();
        assert_eq!(json["levels"].as_array().unwrap().len(), 4);
        assert_eq!(json["levels"][3]["faces"]["count"], 64);
        assert_eq!(json["levels"][1]["edges"]["first"][0], serde_json::json!([4, 5]));
        assert_eq!(json["mesh"]["sharp_edges"][0], serde_json::json!([0, 1, 10]));
    }

    #[test]
    fn the_hash_is_fnv1a() {
        // The published value for the bytes "foob" and its prefix law.
        assert_eq!(fnv1a([u32::from_le_bytes(*b"foob")].into_iter()), 0xdd12_0e79_0c25_12af);
    }
}
