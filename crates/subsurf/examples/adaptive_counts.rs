//! What a crease's sharpness costs: feature-adaptive patches without and with single-crease patches, beside our plans.
//!
//!     cargo run --release -p subsurf --example adaptive_counts [ISOLATION]
//!
//! The model is the car of `assets/`, all its creases set to one sharpness from 0 to 10. Without an isolation level the
//! baseline has as many levels as the sharpness needs to decay, at least 4.

use std::time::Instant;
use subsurf::{
    AdaptiveOptions, AdaptiveRefinement, AdaptiveSize, ControlMesh, Crease, PatchTable, Scheme, Tags, Topology,
};

const HEAD: &str = concat!(
    "                       feature-adaptive            with single-crease patches             plans\n",
    "sharpness levels  patches   points memory   ms  patches   points memory   ms  patches memory   ms"
);
const FOOT: &str = "
points: refined every frame before a patch can be evaluated; plans need none. Memory in KiB: patches, masks and
points of the baseline (without the weights of its end caps); rings and plans of ours.";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let isolation: Option<u32> = std::env::args().nth(1).map(|level| level.parse()).transpose()?;
    let (faces, creases) = car()?;
    println!("The car: {} faces, {} creases.\n\n{HEAD}", faces.len(), creases.len());
    for sharpness in [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 9.99, 10.0] {
        let creases = creases.iter().map(|&[a, b]| Crease::new(a, b, sharpness)).collect();
        let mesh = ControlMesh::new(&faces, Tags { creases, ..Tags::default() })?;
        let mut options = AdaptiveOptions::for_sharpness_of(&Topology::new(&mesh)?, false);
        options.isolation = isolation.unwrap_or(options.isolation);
        print!("{sharpness:9} {:6}", options.isolation);
        for single_crease in [false, true] {
            let start = Instant::now();
            let options = AdaptiveOptions { single_crease, ..options };
            let size = AdaptiveRefinement::new(&mesh, Scheme::CatmullClark, options)?.size();
            let ms = start.elapsed().as_millis();
            print!(" {:8} {:8} {:6} {ms:4}", size.patches, points(&size), kib(bytes(&size)));
        }
        let start = Instant::now();
        let size = PatchTable::new(&mesh, Scheme::CatmullClark)?.size();
        let ms = start.elapsed().as_millis();
        println!(" {:8} {:6} {ms:4}", size.patches, kib(size.patch_bytes + size.plan_bytes));
    }
    println!("{FOOT}");
    Ok(())
}

fn points(size: &AdaptiveSize) -> usize {
    size.refined_points + size.end_cap_points
}

fn bytes(size: &AdaptiveSize) -> usize {
    size.patch_bytes + size.mask_bytes + size.point_bytes
}

fn kib(bytes: usize) -> usize {
    bytes.div_ceil(1024)
}

type Car = (Vec<Vec<u32>>, Vec<[u32; 2]>);

/// Faces and creased edges.
fn car() -> Result<Car, Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/catmark_car.obj"))?;
    let (mut faces, mut creases) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.first() {
            Some(&"f") => {
                let vertex = |word: &&str| Ok(word.split('/').next().unwrap_or_default().parse::<u32>()? - 1);
                faces.push(words[1..].iter().map(vertex).collect::<Result<Vec<u32>, std::num::ParseIntError>>()?);
            }
            Some(&"t") if words.get(1) == Some(&"crease") => creases.push([words[3].parse()?, words[4].parse()?]),
            _ => {}
        }
    }
    Ok((faces, creases))
}
