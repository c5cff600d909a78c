//! Damaged files end in a mesh or an error, never in a panic.

use proptest::test_runner::{RngAlgorithm, TestRng};
use subsurf_io::{ReadError, ReadOptions, Scene, read_obj};

/// One of everything the reader knows.
const EVERYTHING: &str = "\u{feff}# everything\r
mtllib a.mtl\r
o shape\r
v 0 0 0 1\r
v 1.5 0 -0.25 0.5 0.5 0.5\r
v 1e0\t1 .5\r
v 0 1 0.1234567890123456789\r
v 2 2 2e-300\r
vt 0 0\nvt 1 0 0\nvt 1 1\nvt nan 0\n\
vn 0 0 1\nvn 0 0 -1\n\
g a b\ns off\nusemtl m\n\
f 1/1/1 2/2/1 3/3/1 4/4/1\n\
f -1/-1/-2 -2/-2/-2 -3/-3/-2\n\
f 1//2 2//2 \\\n3//2 5//2 4//2 # long\n\
f 1 2 5\n\
l 1 2 3\np 1\nvp 0.1 0.2\n\
t crease 2/1/0 0 1 2.5\nt crease 4/2/0 1 2 2 3 1 10\n\
t corner 1/1/0 2 3.5\nt hole 1/0/0 1\n\
t interpolateboundary 1/0/0 1\nt facevaryinginterpolateboundary 1/0/0 3\n\
t creasemethod 0/0/1 chaikin\nt smoothtriangles 0/0/1 smooth\n\
t vertexedit 4/3/3 3 4 1 0 0 0 1 add P value\nt unknown 0/0/0\n";

fn read(bytes: &[u8]) -> Result<Scene, ReadError> {
    read_obj(bytes, "damaged", &ReadOptions::default())
}

/// Reads, looks at all that the scene or the message says.
fn exercise(bytes: &[u8]) {
    match read(bytes) {
        Ok(scene) => {
            let _ = scene.warnings.iter().map(ToString::to_string).collect::<String>();
            scene.output().check().unwrap();
            assert!((0..scene.mesh.face_count()).all(|face| scene.lines.face(face).is_some()));
        }
        Err(error) => assert!(error.to_string().starts_with("damaged:")),
    }
}

#[test]
fn the_undamaged_file_reads_in_full() {
    let scene = read(EVERYTHING.as_bytes()).unwrap();
    assert_eq!((scene.mesh.vertex_count(), scene.mesh.face_count()), (5, 4));
    assert_eq!(scene.warnings.len(), 6, "{:?}", scene.warnings);
    assert_eq!(scene.mesh.tags().creases.len(), 3);
}

#[test]
fn a_file_cut_anywhere_is_a_mesh_or_an_error() {
    (0..EVERYTHING.len()).for_each(|end| exercise(&EVERYTHING.as_bytes()[..end]));
}

#[test]
fn a_file_with_changed_bytes_is_a_mesh_or_an_error() {
    use proptest::prelude::Rng;
    let mut random = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
    // Bytes that mean something to the reader are as likely as all others together.
    let meaningful = b" \n\r\t\\/#-+.0123456789eEnNvft";
    for _ in 0..20_000 {
        let mut bytes = EVERYTHING.as_bytes().to_vec();
        for _ in 0..1 + random.next_u32() % 4 {
            let at = random.next_u32() as usize % bytes.len();
            let byte = match random.next_u32() {
                word if word % 2 == 0 => meaningful[word as usize / 2 % meaningful.len()],
                word => (word >> 8) as u8,
            };
            match random.next_u32() % 3 {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                _ => drop(bytes.remove(at)),
            }
        }
        exercise(&bytes);
    }
}
