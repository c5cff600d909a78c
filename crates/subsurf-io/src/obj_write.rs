//! Wavefront OBJ, written. Numbers have the fewest digits from which the same number is read, so what was written
//! reads back equal; creases, corners, holes and rules become tag lines.

use crate::output::{OutputMesh, Real};
use crate::write_error::EncodeError;
use std::io::{self, BufWriter, Write};
use subsurf::{Boundary, Creasing, FaceVarying, Tags, Triangles};

/// Bytes written at once.
const BLOCK: usize = 1 << 18;

/// Writes an OBJ file.
///
/// # Errors
/// If the mesh is none ([`OutputMesh::check`]) or `out` takes no more.
pub fn write_obj<T: Real>(out: impl Write, mesh: &OutputMesh<'_, T>) -> Result<(), EncodeError> {
    mesh.check()?;
    let mut out = BufWriter::with_capacity(BLOCK, out);
    write_values(&mut out, "v", mesh.positions)?;
    if let Some(texture) = &mesh.texture {
        write_values(&mut out, "vt", texture.values)?;
    }
    if let Some(normals) = &mesh.normals {
        write_values(&mut out, "vn", normals.values)?;
    }
    write_faces(&mut out, mesh)?;
    if let Some(tags) = mesh.tags {
        write_tags(&mut out, tags)?;
    }
    Ok(out.flush()?)
}

fn write_values<T: Real, const N: usize>(out: &mut impl Write, keyword: &str, values: &[[T; N]]) -> io::Result<()> {
    for value in values {
        out.write_all(keyword.as_bytes())?;
        for &x in value {
            out.write_all(b" ")?;
            x.write_shortest(out)?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

fn write_faces<T: Real>(out: &mut impl Write, mesh: &OutputMesh<'_, T>) -> io::Result<()> {
    let texture = mesh.texture.map(|texture| texture.indices.unwrap_or(mesh.corners));
    let normals = mesh.normals.map(|normals| normals.indices.unwrap_or(mesh.corners));
    let mut digits = itoa::Buffer::new();
    let mut write_index =
        |out: &mut _, index: u32| Write::write_all(out, digits.format(u64::from(index) + 1).as_bytes());
    for face in mesh.faces() {
        out.write_all(b"f")?;
        for corner in face {
            out.write_all(b" ")?;
            write_index(out, mesh.corners[corner])?;
            if let Some(texture) = texture {
                out.write_all(b"/")?;
                write_index(out, texture[corner])?;
            }
            if let Some(normals) = normals {
                out.write_all(if texture.is_some() { b"/" } else { b"//" })?;
                write_index(out, normals[corner])?;
            }
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// The tags in the words of the reader.
fn write_tags(out: &mut impl Write, tags: &Tags) -> io::Result<()> {
    let boundary = match tags.rules.boundary {
        Boundary::None => 0,
        Boundary::EdgeAndCorner => 1,
        Boundary::EdgeOnly => 2,
    };
    let face_varying = match tags.rules.face_varying {
        FaceVarying::None => 0,
        FaceVarying::CornersOnly => 1,
        FaceVarying::CornersPlus1 => 2,
        FaceVarying::CornersPlus2 => 3,
        FaceVarying::Boundaries => 4,
        FaceVarying::All => 5,
    };
    let creasing = match tags.rules.creasing {
        Creasing::Uniform => "normal",
        Creasing::Chaikin => "chaikin",
    };
    let triangles = match tags.rules.triangles {
        Triangles::CatmullClark => "catmark",
        Triangles::Smooth => "smooth",
    };
    writeln!(out, "t interpolateboundary 1/0/0 {boundary}")?;
    writeln!(out, "t facevaryinginterpolateboundary 1/0/0 {face_varying}")?;
    writeln!(out, "t creasemethod 0/0/1 {creasing}")?;
    writeln!(out, "t smoothtriangles 0/0/1 {triangles}")?;
    for crease in &tags.creases {
        let [a, b] = crease.vertices;
        write!(out, "t crease 2/1/0 {a} {b} ")?;
        crease.sharpness.write_shortest(out)?;
        out.write_all(b"\n")?;
    }
    for corner in &tags.corners {
        write!(out, "t corner 1/1/0 {} ", corner.vertex)?;
        corner.sharpness.write_shortest(out)?;
        out.write_all(b"\n")?;
    }
    for hole in &tags.holes {
        writeln!(out, "t hole 1/0/0 {hole}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{Attribute, FaceSizes};
    use subsurf::{Corner, Crease};

    #[test]
    fn the_text_is_what_one_would_write_by_hand() {
        let tags = Tags {
            creases: vec![Crease::new(0, 1, 2.5)],
            corners: vec![Corner::new(2, 10.0)],
            holes: vec![0],
            ..Tags::default()
        };
        let mesh = OutputMesh {
            positions: &[[0.0f32, 0.1, -1.0], [1.0, 0.0, 1e-7], [0.0, 1.0, 1e30]],
            sizes: FaceSizes::Uniform(3),
            corners: &[0, 1, 2],
            normals: Some(Attribute { values: &[[0.0, 0.0, 1.0]], indices: Some(&[0, 0, 0]) }),
            texture: None,
            tags: Some(&tags),
        };
        let mut text = Vec::new();
        write_obj(&mut text, &mesh).unwrap();
        let expected = "v 0 0.1 -1\nv 1 0 1e-7\nv 0 1 1e30\nvn 0 0 1\nf 1//1 2//1 3//1\n\
            t interpolateboundary 1/0/0 1\nt facevaryinginterpolateboundary 1/0/0 2\nt creasemethod 0/0/1 normal\n\
            t smoothtriangles 0/0/1 catmark\nt crease 2/1/0 0 1 2.5\nt corner 1/1/0 2 10\nt hole 1/0/0 0\n";
        assert_eq!(String::from_utf8(text).unwrap().replace("e+", "e"), expected);
    }
}
