//! The same bits whatever the machine's vectors: everything that loops over lanes, in processes of their own that limit them.

mod every_scheme;
mod random_mesh;

use every_scheme::everywhere;
use std::process::Command;
use std::sync::Mutex;
use subsurf::{
    ControlMesh, Level, LimitStencilTable, Location, PatchTable, Rates, Real, Scheme, StencilTable, TessellateOptions,
    UniformRefinement, limit_vector_bits,
};

/// Tells a process of this test how wide vectors may be.
const BITS: &str = "SUBSURF_TEST_VECTOR_BITS";

/// How results of one kind begin in what such a process prints.
const RESULT: &str = "digest of ";

#[test]
fn results_are_the_same_bits_at_any_width_of_vectors() {
    let digests = |bits: u32| -> Vec<String> {
        let test = std::env::current_exe().unwrap();
        let arguments = ["--ignored", "--exact", "results_at_the_width_that_is_asked_for", "--nocapture"];
        let out = Command::new(test).args(arguments).env(BITS, bits.to_string()).output().unwrap();
        let text = String::from_utf8(out.stdout).unwrap();
        assert!(out.status.success(), "{bits} bits: {text}");
        text.lines().filter_map(|line| line.split_once(RESULT)).map(|(_, digest)| digest.to_string()).collect()
    };
    let narrow = digests(128);
    assert_eq!(narrow.len(), NAMES.len());
    for bits in [256, 512] {
        assert_eq!(digests(bits), narrow, "{bits} bits, or as many as there are");
    }
}

const NAMES: [&str; 10] = [
    "refinement f32",
    "refinement f64",
    "stencils f32",
    "stencils f64",
    "tessellation f32",
    "tessellation f64",
    "evaluation f32",
    "evaluation f64",
    "limit stencils f32",
    "limit stencils f64",
];

static DIGESTS: Mutex<[u64; NAMES.len()]> = Mutex::new([0xcbf2_9ce4_8422_2325; NAMES.len()]);

/// Prints digests, for the other test to compare.
#[test]
#[ignore = "part of the other test, which starts it in processes of its own"]
fn results_at_the_width_that_is_asked_for() {
    let bits = std::env::var(BITS).map_or(512, |bits| bits.parse().unwrap());
    // No narrower than what the test was compiled for.
    let least = if cfg!(target_feature = "avx512f") {
        512
    } else if cfg!(target_feature = "avx2") {
        256
    } else {
        128
    };
    assert!(limit_vector_bits(bits) <= bits.max(least));
    everywhere(10, 77, |mesh, positions, scheme| {
        add::<f32>(0, mesh, positions, scheme);
        add::<f64>(1, mesh, positions, scheme);
        Ok(())
    });
    for (name, digest) in NAMES.iter().zip(*DIGESTS.lock().unwrap()) {
        println!("\n{RESULT}{name}: {digest:x}");
    }
}

/// Adds everything about a mesh to the digests of one precision.
fn add<T: Real>(precision: usize, mesh: &ControlMesh, positions: &[[f64; 3]], scheme: Scheme) {
    let control: Vec<[T; 3]> = positions.iter().map(|p| p.map(T::from_f64)).collect();
    let mut digests = DIGESTS.lock().unwrap();
    let mut add = |kind: usize, numbers: &[T]| {
        let digest = &mut digests[2 * kind + precision];
        for x in numbers {
            *digest = (*digest ^ x.to_f64().to_bits()).wrapping_mul(0x0100_0000_01b3);
        }
    };
    for depth in 1..=3 {
        let refinement = UniformRefinement::new(mesh, scheme, depth).unwrap();
        // The second time tables are at hand.
        (0..2).for_each(|_| add(0, refinement.refine(&control).as_flattened()));
    }
    let level = Level::new(mesh, scheme).unwrap();
    add(1, StencilTable::<T>::new(&level, 2).unwrap().apply(&control).as_flattened());
    let table = PatchTable::new(mesh, scheme).unwrap();
    let surface = table.surface(&control);
    for rate in [1, 4, 7] {
        let options = TessellateOptions { rates: Rates::Uniform(rate), normals: true, ..TessellateOptions::default() };
        let made = surface.tessellate(&options).unwrap();
        add(2, made.positions.as_flattened());
        add(2, made.normals.as_flattened());
    }
    let places = places(&table, mesh, scheme);
    for count in [3, places.len()] {
        let mut rows = vec![[[T::default(); 3]; 3]; count];
        surface.eval_into(&places[..count], &mut rows);
        add(3, rows.as_flattened().as_flattened());
    }
    let table = LimitStencilTable::<T>::new(&table, &places).unwrap();
    let mut frames = vec![[[T::default(); 3]; 3]; places.len()];
    table.frames_into(&control, &mut frames);
    add(4, frames.as_flattened().as_flattened());
}

/// Places inside every face, without order.
fn places(table: &PatchTable, mesh: &ControlMesh, scheme: Scheme) -> Vec<Location> {
    let mut out = Vec::new();
    for i in 0..20 * mesh.face_count() as u32 {
        let part = |step: f64| (f64::from(i + 1) * step).fract();
        let face = i.wrapping_mul(2_654_435_761) % mesh.face_count() as u32;
        let (mut u, mut v) = (part(0.754_877_666_246_692_8), part(0.569_840_290_998_053_2));
        if scheme == Scheme::Loop && u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        if !mesh.tags().holes.contains(&face) {
            let subface = i % table.subfaces(face.into());
            out.push(Location { face: face.into(), subface, u, v });
        }
    }
    out
}
