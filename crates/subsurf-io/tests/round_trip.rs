//! What is written as OBJ reads back equal.

use proptest::prelude::*;
use subsurf::{Boundary, Corner, Crease, Creasing, FaceVarying, Rules, Tags, Triangles};
use subsurf_io::{Attribute, FaceSizes, OutputMesh, ReadOptions, read_obj, write_obj};

/// A mesh with everything, owned.
#[derive(Clone, Debug)]
struct Mesh {
    positions: Vec<[f64; 3]>,
    offsets: Vec<u32>,
    corners: Vec<u32>,
    texture: Option<(Vec<[f64; 2]>, Vec<u32>)>,
    normals: Option<(Vec<[f64; 3]>, Vec<u32>)>,
    tags: Tags,
}

impl Mesh {
    fn output(&self) -> OutputMesh<'_, f64> {
        OutputMesh {
            positions: &self.positions,
            sizes: FaceSizes::Offsets(&self.offsets),
            corners: &self.corners,
            normals: self.normals.as_ref().map(|(values, indices)| Attribute { values, indices: Some(indices) }),
            texture: self.texture.as_ref().map(|(values, indices)| Attribute { values, indices: Some(indices) }),
            tags: Some(&self.tags),
        }
    }
}

/// Any finite number, with all its bits.
fn number() -> impl Strategy<Value = f64> {
    any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |x| x.is_finite())
}

fn channel<const N: usize>(corners: usize) -> impl Strategy<Value = Option<(Vec<[f64; N]>, Vec<u32>)>> {
    let values = prop::collection::vec(prop::array::uniform(number()), 1..9);
    let some = values.prop_flat_map(move |values: Vec<[f64; N]>| {
        let count = values.len() as u32;
        (Just(values), prop::collection::vec(0..count, corners))
    });
    prop::option::of(some)
}

fn rules() -> impl Strategy<Value = Rules> {
    use FaceVarying::{All, Boundaries, CornersOnly, CornersPlus1, CornersPlus2, None};
    (
        prop::sample::select(vec![Boundary::None, Boundary::EdgeOnly, Boundary::EdgeAndCorner]),
        prop::sample::select(vec![Creasing::Uniform, Creasing::Chaikin]),
        prop::sample::select(vec![Triangles::CatmullClark, Triangles::Smooth]),
        prop::sample::select(vec![None, CornersOnly, CornersPlus1, CornersPlus2, Boundaries, All]),
    )
        .prop_map(|(boundary, creasing, triangles, face_varying)| Rules {
            boundary,
            creasing,
            triangles,
            face_varying,
        })
}

fn tags(vertices: u32, faces: u32) -> impl Strategy<Value = Tags> {
    let crease = (0..vertices, 1..vertices, number())
        .prop_map(move |(a, step, sharpness)| Crease::new(a, (a + step) % vertices, sharpness));
    let corner = (0..vertices, number()).prop_map(|(vertex, sharpness)| Corner::new(vertex, sharpness));
    (
        prop::collection::vec(crease, 0..5),
        prop::collection::vec(corner, 0..5),
        prop::collection::vec(0..faces, 0..3),
        rules(),
    )
        .prop_map(|(creases, corners, holes, rules)| Tags { creases, corners, holes, rules })
}

fn mesh() -> impl Strategy<Value = Mesh> {
    let faces = prop::collection::vec(prop::collection::vec(0..20u32, 3..7), 1..12);
    let positions = prop::collection::vec(prop::array::uniform3(number()), 20..30);
    (positions, faces).prop_flat_map(|(positions, faces)| {
        let corners: Vec<u32> = faces.concat();
        let ends = faces.iter().scan(0, |end, face| {
            *end += face.len() as u32;
            Some(*end)
        });
        let offsets: Vec<u32> = std::iter::once(0).chain(ends).collect();
        let channels = (channel(corners.len()), channel(corners.len()));
        let tags = tags(positions.len() as u32, faces.len() as u32);
        (Just(positions), Just(offsets), Just(corners), channels, tags).prop_map(
            |(positions, offsets, corners, (texture, normals), tags)| Mesh {
                positions,
                offsets,
                corners,
                texture,
                normals,
                tags,
            },
        )
    })
}

/// Bits, so that zeros of either sign differ.
fn bits<const N: usize>(values: &[[f64; N]]) -> Vec<[u64; N]> {
    values.iter().map(|value| value.map(f64::to_bits)).collect()
}

proptest! {
    #[test]
    fn a_mesh_reads_back_equal_to_the_last_bit(mesh in mesh()) {
        let mut text = Vec::new();
        write_obj(&mut text, &mesh.output()).unwrap();
        let read = read_obj(&text[..], "written", &ReadOptions { rules: Rules::blender() }).unwrap();
        prop_assert_eq!(bits(&read.positions), bits(&mesh.positions));
        prop_assert_eq!(read.mesh.face_offsets(), mesh.offsets);
        prop_assert_eq!(read.mesh.corners(), &mesh.corners);
        prop_assert_eq!(read.mesh.tags(), &mesh.tags);
        let texture = read.texture.as_ref().map(|channel| (bits(&channel.values), &channel.indices));
        prop_assert_eq!(texture, mesh.texture.as_ref().map(|(values, indices)| (bits(values), indices)));
        let normals = read.normals.as_ref().map(|channel| (bits(&channel.values), &channel.indices));
        prop_assert_eq!(normals, mesh.normals.as_ref().map(|(values, indices)| (bits(values), indices)));
        prop_assert!(read.warnings.is_empty());

        let mut again = Vec::new();
        write_obj(&mut again, &read.output()).unwrap();
        prop_assert_eq!(text, again);
    }

    #[test]
    fn single_precision_reads_back_equal(positions in prop::collection::vec(prop::array::uniform3(any::<f32>()), 3..20)) {
        prop_assume!(positions.iter().flatten().all(|x| x.is_finite()));
        let mesh = OutputMesh {
            positions: &positions, sizes: FaceSizes::Uniform(3), corners: &[0, 1, 2], normals: None, texture: None, tags: None,
        };
        let mut text = Vec::new();
        write_obj(&mut text, &mesh).unwrap();
        let read = read_obj(&text[..], "written", &ReadOptions::default()).unwrap();
        let single: Vec<_> = read.positions.iter().map(|p| p.map(|x| (x as f32).to_bits())).collect();
        let expected: Vec<_> = positions.iter().map(|p| p.map(f32::to_bits)).collect();
        prop_assert_eq!(single, expected);
    }
}
