//! PLY, written in its binary little-endian form: vertices with `x y z`, `nx ny nz`, `s t`, and faces of any size.
//! A vertex has one index there: see [`weld`].
//!
//! Source: Greg Turk, "The PLY polygon file format", 1994.

use crate::output::{OutputError, OutputMesh, Real};
use crate::weld::weld;
use crate::write_error::EncodeError;
use std::io::{BufWriter, Write};

/// Bytes written at once.
const BLOCK: usize = 1 << 18;

/// Writes a PLY file. Tags are left out. Where normals or texture coordinates have seams, vertices are split and come
/// in the order of their first use, without isolated ones; else they keep their order.
///
/// # Errors
/// If the mesh is none ([`OutputMesh::check`]) or `out` takes no more.
pub fn write_ply<T: Real>(out: impl Write, mesh: &OutputMesh<'_, T>) -> Result<(), EncodeError> {
    mesh.check()?;
    let welded = weld(mesh).ok_or(OutputError::TooLarge { format: "PLY" })?;
    let short = mesh.faces().all(|face| face.len() <= usize::from(u8::MAX));
    let mut out = BufWriter::with_capacity(BLOCK, out);

    writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment subsurf")?;
    writeln!(out, "element vertex {}", welded.vertex_count())?;
    let normal_names = mesh.normals.map_or(&[][..], |_| &["nx", "ny", "nz"]);
    let texture_names = mesh.texture.map_or(&[][..], |_| &["s", "t"]);
    for name in ["x", "y", "z"].iter().chain(normal_names).chain(texture_names) {
        writeln!(out, "property {} {name}", T::PLY_NAME)?;
    }
    writeln!(out, "element face {}", mesh.face_count())?;
    writeln!(out, "property list {} uint vertex_indices", if short { "uchar" } else { "uint" })?;
    writeln!(out, "end_header")?;

    for [position, normal, texture] in welded.vertices() {
        for x in mesh.positions[position] {
            x.write_bytes(&mut out)?;
        }
        for x in mesh.normals.iter().flat_map(|normals| normals.values[normal]) {
            x.write_bytes(&mut out)?;
        }
        for x in mesh.texture.iter().flat_map(|coordinates| coordinates.values[texture]) {
            x.write_bytes(&mut out)?;
        }
    }
    for face in mesh.faces() {
        let sides = (face.len() as u32).to_le_bytes();
        out.write_all(if short { &sides[..1] } else { &sides })?;
        for vertex in &welded.corners[face] {
            out.write_all(&vertex.to_le_bytes())?;
        }
    }
    Ok(out.flush()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{Attribute, FaceSizes};

    /// Header lines, vertices as lists of numbers, faces.
    type Parsed = (Vec<String>, Vec<Vec<f64>>, Vec<Vec<u32>>);

    /// Reads what [`write_ply`] writes.
    fn parse(bytes: &[u8]) -> Parsed {
        let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let header: Vec<_> = String::from_utf8(bytes[..end].to_vec()).unwrap().lines().map(str::to_owned).collect();
        let count = |what: &str| header.iter().find_map(|line| line.strip_prefix(what)?.parse::<usize>().ok()).unwrap();
        let long_count = header.iter().any(|line| line.starts_with("property list uint"));
        let mut rest = &bytes[end..];
        let mut take = |n: usize| {
            let (head, tail) = rest.split_at(n);
            rest = tail;
            head
        };
        let mut vertices = Vec::new();
        for _ in 0..count("element vertex ") {
            let mut vertex = Vec::new();
            for line in header.iter() {
                if line.starts_with("property float") {
                    vertex.push(f64::from(f32::from_le_bytes(take(4).try_into().unwrap())));
                } else if line.starts_with("property double") {
                    vertex.push(f64::from_le_bytes(take(8).try_into().unwrap()));
                }
            }
            vertices.push(vertex);
        }
        let mut faces = Vec::new();
        for _ in 0..count("element face ") {
            let sides =
                if long_count { u32::from_le_bytes(take(4).try_into().unwrap()) } else { u32::from(take(1)[0]) };
            faces.push((0..sides).map(|_| u32::from_le_bytes(take(4).try_into().unwrap())).collect());
        }
        assert!(rest.is_empty());
        (header, vertices, faces)
    }

    fn written<T: Real>(mesh: &OutputMesh<'_, T>) -> Parsed {
        let mut bytes = Vec::new();
        write_ply(&mut bytes, mesh).unwrap();
        parse(&bytes)
    }

    #[test]
    fn a_mesh_reads_back_with_split_seams() {
        let positions = [[0.0, 0.5, 1.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 1e300]];
        let mesh = OutputMesh {
            positions: &positions,
            sizes: FaceSizes::Offsets(&[0, 4, 7]),
            corners: &[0, 1, 2, 3, 3, 2, 1],
            normals: None,
            texture: Some(Attribute { values: &[[0.0, 0.25], [1.0, 0.5]], indices: Some(&[0, 0, 0, 0, 0, 0, 1]) }),
            tags: None,
        };
        let (header, vertices, faces) = written(&mesh);
        assert!(header.contains(&"property double s".to_owned()));
        assert_eq!(faces, [vec![0, 1, 2, 3], vec![3, 2, 4]]);
        assert_eq!(vertices.len(), 5);
        assert_eq!(vertices[3], [0.0, 1.0, 1e300, 0.0, 0.25]);
        assert_eq!(vertices[4], [1.0, 0.0, 0.0, 1.0, 0.5]);
    }

    #[test]
    fn faces_beyond_255_corners_get_a_longer_count() {
        let positions: Vec<[f32; 3]> = (0..300).map(|i| [i as f32, 0.0, 0.0]).collect();
        let corners: Vec<u32> = (0..300).collect();
        let mesh = OutputMesh {
            positions: &positions,
            sizes: FaceSizes::Uniform(300),
            corners: &corners,
            normals: Some(Attribute { values: &positions, indices: None }),
            texture: None,
            tags: None,
        };
        let (_, vertices, faces) = written(&mesh);
        assert_eq!(faces, [corners]);
        assert_eq!(vertices[7], [7.0, 0.0, 0.0, 7.0, 0.0, 0.0]);
    }
}
