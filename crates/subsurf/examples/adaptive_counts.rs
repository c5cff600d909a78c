//! What a crease's sharpness costs: feature-adaptive patches without and with single-crease patches, beside our plans.
//!
//!     cargo run --release -p subsurf --example adaptive_counts
//!
//! The model is the car of `assets/`, all its creases set to one sharpness from 0 to 10. The isolation level is 10, as
//! sharpness up to 9.99 needs.

use std::time::Instant;
use subsurf::{
    AdaptiveOptions, AdaptiveRefinement, AdaptiveSize, ControlMesh, Crease, MAX_ISOLATION, PatchTable, Scheme, Tags,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (faces, creases) = car()?;
    println!("The car: {} faces, {} creases; isolation level {MAX_ISOLATION}.\n", faces.len(), creases.len());
    println!("          feature-adaptive                      with single-crease patches          plans");
    println!(
        "sharpness   patches    points    memory  time   patches    points   memory  time   patches   memory  time"
    );
    for sharpness in [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 9.99, 10.0] {
        let creases = creases.iter().map(|&[a, b]| Crease::new(a, b, sharpness)).collect();
        let mesh = ControlMesh::new(&faces, Tags { creases, ..Tags::default() })?;
        print!("{sharpness:9}");
        for single_crease in [false, true] {
            let start = Instant::now();
            let options = AdaptiveOptions { isolation: MAX_ISOLATION, single_crease };
            let size = AdaptiveRefinement::new(&mesh, Scheme::CatmullClark, options)?.size();
            let ms = start.elapsed().as_millis();
            print!(" {:9} {:9} {:9} {ms:5}", size.patches, points(&size), memory(&size));
        }
        let start = Instant::now();
        let size = PatchTable::new(&mesh, Scheme::CatmullClark)?.size();
        let ms = start.elapsed().as_millis();
        println!(" {:9} {:8} {ms:5}", size.patches, kib(size.patch_bytes + size.plan_bytes));
    }
    println!(
        "\npoints: computed every frame before a patch can be evaluated. Memory in KiB: patches, masks and points"
    );
    println!("of the baseline (without the weights of its end caps); patches and plans of ours. Time in ms.");
    Ok(())
}

fn points(size: &AdaptiveSize) -> usize {
    size.refined_points + size.end_cap_points
}

fn memory(size: &AdaptiveSize) -> String {
    kib(size.patch_bytes + size.mask_bytes + size.point_bytes)
}

fn kib(bytes: usize) -> String {
    (bytes.div_ceil(1024)).to_string()
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
