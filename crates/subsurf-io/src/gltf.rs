//! glTF 2.0 in its one-file form, GLB, written: one mesh of triangles in single precision. A GLB file is a header and
//! two chunks, each padded to four bytes:
//!
//! ```text
//! "glTF" 2 length | length "JSON" text…spaces | length "BIN\0" positions normals texture-coordinates indices
//! ```
//!
//! Source: Khronos, "glTF 2.0 specification", sections 3.7 (geometry) and 4.4 (binary layout).

use crate::output::{OutputError, OutputMesh, Real};
use crate::weld::{Welded, weld};
use crate::write_error::EncodeError;
use serde_json::{Value, json};
use std::io::{self, BufWriter, Write};

/// Bytes written at once.
const BLOCK: usize = 1 << 18;

/// Component types, buffer targets and chunk names of the specification.
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const JSON_CHUNK: &[u8; 4] = b"JSON";
const BIN_CHUNK: &[u8; 4] = b"BIN\0";

/// Writes a GLB file. Faces become fans of triangles around their first corner, so quads are split from corner 0 to 2.
/// Normals are made unit vectors; those of no length point along z. Vertices are split at seams as in
/// [`write_ply`](crate::write_ply). Tags are left out.
///
/// # Errors
/// If the mesh is none ([`OutputMesh::check`]) or too large: a coordinate for `f32`, or the file for 4 GiB; or if `out`
/// takes no more.
pub fn write_glb<T: Real>(out: impl Write, mesh: &OutputMesh<'_, T>) -> Result<(), EncodeError> {
    mesh.check()?;
    let too_large = OutputError::TooLarge { format: "glTF" };
    let welded = weld(mesh).ok_or(too_large.clone())?;
    let bounds = bounds(mesh, &welded)?;
    let index_count = mesh.faces().map(|face| 3 * (face.len() - 2)).sum::<usize>();
    let (text, binary_length) = describe(mesh, welded.vertex_count(), index_count, bounds);
    let mut text = text.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = u32::try_from(12 + 8 + text.len() + 8 + binary_length).map_err(|_| too_large)?;

    let mut out = BufWriter::with_capacity(BLOCK, out);
    out.write_all(b"glTF")?;
    write_u32(&mut out, 2)?;
    write_u32(&mut out, length)?;
    write_u32(&mut out, text.len() as u32)?;
    out.write_all(JSON_CHUNK)?;
    out.write_all(&text)?;
    write_u32(&mut out, binary_length as u32)?;
    out.write_all(BIN_CHUNK)?;
    write_binary(&mut out, mesh, &welded)?;
    Ok(out.flush()?)
}

/// The box around the positions, which the accessor must state. Refuses values that single precision does not hold.
fn bounds<T: Real>(mesh: &OutputMesh<'_, T>, welded: &Welded<'_>) -> Result<[[f32; 3]; 2], OutputError> {
    let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for [position, _, texture] in welded.vertices() {
        for (i, x) in mesh.positions[position].map(T::to_f32).into_iter().enumerate() {
            if !x.is_finite() {
                return Err(OutputError::NotFinite { what: "position", index: position });
            }
            min[i] = min[i].min(x);
            max[i] = max[i].max(x);
        }
        let coordinates = mesh.texture.iter().flat_map(|coordinates| coordinates.values[texture]);
        if coordinates.map(T::to_f32).any(|x| !x.is_finite()) {
            return Err(OutputError::NotFinite { what: "texture coordinate", index: texture });
        }
    }
    Ok([min, max])
}

/// The text of the file and the length of the binary part. Offsets are multiples of 4 as all components are 4 bytes.
fn describe<T: Real>(
    mesh: &OutputMesh<'_, T>,
    vertex_count: usize,
    index_count: usize,
    [min, max]: [[f32; 3]; 2],
) -> (Value, usize) {
    let mut views = Vec::new();
    let mut accessors = Vec::new();
    let mut length = 0;
    let mut add = |target: u32, component: u32, kind: &str, width: usize, count: usize| {
        let bytes = 4 * width * count;
        let view = views.len();
        views.push(json!({ "buffer": 0, "byteOffset": length, "byteLength": bytes, "target": target }));
        accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        length += bytes;
        view
    };
    let mut attributes = json!({ "POSITION": add(ARRAY_BUFFER, FLOAT, "VEC3", 3, vertex_count) });
    if mesh.normals.is_some() {
        attributes["NORMAL"] = add(ARRAY_BUFFER, FLOAT, "VEC3", 3, vertex_count).into();
    }
    if mesh.texture.is_some() {
        attributes["TEXCOORD_0"] = add(ARRAY_BUFFER, FLOAT, "VEC2", 2, vertex_count).into();
    }
    let indices = add(ELEMENT_ARRAY_BUFFER, UNSIGNED_INT, "SCALAR", 1, index_count);
    // As f64, an f32 is written with digits that name exactly it.
    accessors[0]["min"] = json!(min.map(f64::from));
    accessors[0]["max"] = json!(max.map(f64::from));
    let text = json!({
        "asset": { "version": "2.0", "generator": "subsurf" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": attributes, "indices": indices, "mode": 4 }] }],
        "buffers": [{ "byteLength": length }],
        "bufferViews": views,
        "accessors": accessors,
    });
    (text, length)
}

/// The arrays in the order of their buffer views.
fn write_binary<T: Real>(out: &mut impl Write, mesh: &OutputMesh<'_, T>, welded: &Welded<'_>) -> io::Result<()> {
    for [position, _, _] in welded.vertices() {
        write_floats(out, mesh.positions[position].map(T::to_f32))?;
    }
    if let Some(normals) = &mesh.normals {
        for [_, normal, _] in welded.vertices() {
            write_floats(out, unit(normals.values[normal].map(Into::into)))?;
        }
    }
    if let Some(coordinates) = &mesh.texture {
        for [_, _, texture] in welded.vertices() {
            // glTF counts v from the top.
            let [u, v]: [f64; 2] = coordinates.values[texture].map(Into::into);
            write_floats(out, [u as f32, (1.0 - v) as f32])?;
        }
    }
    for face in mesh.faces() {
        let corners = &welded.corners[face];
        for edge in corners[1..].windows(2) {
            write_u32(out, corners[0])?;
            write_u32(out, edge[0])?;
            write_u32(out, edge[1])?;
        }
    }
    Ok(())
}

/// `normal` with length one; scaled first so that no square overflows or vanishes.
fn unit(normal: [f64; 3]) -> [f32; 3] {
    let largest = normal.iter().fold(0.0, |max: f64, x| max.max(x.abs()));
    if largest == 0.0 {
        return [0.0, 0.0, 1.0];
    }
    let scaled = normal.map(|x| x / largest);
    let length = scaled.iter().map(|x| x * x).sum::<f64>().sqrt();
    scaled.map(|x| (x / length) as f32)
}

fn write_floats<const N: usize>(out: &mut impl Write, values: [f32; N]) -> io::Result<()> {
    values.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
}

fn write_u32(out: &mut impl Write, value: u32) -> io::Result<()> {
    out.write_all(&value.to_le_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{Attribute, FaceSizes};

    fn words(bytes: &[u8]) -> Vec<u32> {
        bytes.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect()
    }

    /// A quad and a pentagon.
    fn mesh() -> OutputMesh<'static, f64> {
        OutputMesh {
            positions: &[
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [0.0, 1.0, 0.0],
                [2.0, -0.5, 0.25],
                [3.0, 0.0, 0.1],
            ],
            sizes: FaceSizes::Offsets(&[0, 4, 9]),
            corners: &[0, 1, 2, 3, 1, 4, 5, 2, 3],
            normals: Some(Attribute { values: &[[0.0, 0.0, 0.0], [3.0, 0.0, 4.0]], indices: Some(&[1; 9]) }),
            texture: Some(Attribute { values: &[[0.25, 0.25]; 6], indices: None }),
            tags: None,
        }
    }

    #[test]
    fn chunks_are_aligned_and_add_up() {
        let mut bytes = Vec::new();
        write_glb(&mut bytes, &mesh()).unwrap();
        let header = words(&bytes[..20]);
        assert_eq!((header[1], header[2] as usize), (2, bytes.len()));
        let text_end = 20 + header[3] as usize;
        let text: Value = serde_json::from_slice(&bytes[20..text_end]).unwrap();
        let binary = &bytes[text_end + 8..];
        assert_eq!(text["buffers"][0]["byteLength"], binary.len());
        assert_eq!(words(&bytes[text_end..])[0] as usize, binary.len());
        assert_eq!(bytes.len() % 4, 0);
        assert_eq!(text["accessors"][0]["min"], json!([0.0, -0.5, 0.0]));
        assert_eq!(text["accessors"][0]["max"], json!([3.0, 1.0, 0.25]));

        let views = text["bufferViews"].as_array().unwrap();
        let view = |i: usize| &binary[views[i]["byteOffset"].as_u64().unwrap() as usize..][..12];
        assert_eq!(words(view(1)), [0.6f32, 0.0, 0.8].map(f32::to_bits));
        assert_eq!(words(&view(2)[..8]), [0.25f32, 0.75].map(f32::to_bits));
        let indices = &binary[views[3]["byteOffset"].as_u64().unwrap() as usize..];
        assert_eq!(words(indices), [0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2, 1, 2, 3]);
    }

    #[test]
    fn normals_have_unit_length_whatever_their_size() {
        assert_eq!(unit([0.0; 3]), [0.0, 0.0, 1.0]);
        assert_eq!(unit([0.0, -1e-200, 0.0]), [0.0, -1.0, 0.0]);
        assert_eq!(unit([1e200, 0.0, 0.0]), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn positions_beyond_single_precision_are_refused() {
        let mut positions = mesh().positions.to_vec();
        positions[4][1] = 1e60;
        let error = write_glb(io::sink(), &OutputMesh { positions: &positions, ..mesh() }).unwrap_err();
        assert!(matches!(error, EncodeError::Mesh(OutputError::NotFinite { what: "position", index: 4 })));
    }
}
