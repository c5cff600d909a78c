//! Control meshes that nobody would model: a regression shape whose vertices are merged, whose faces are flipped,
//! doubled, split or dropped, under random tags and rules. The same seed gives the same mesh.

use crate::shape::{Scheme, Shape};
use subsurf::{Boundary, Corner, Crease, Creasing, Triangles};

/// Splitmix64 (Steele, Lea, Flood 2014).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// Below 1, between 1 and 10, whole, or infinite.
    fn sharpness(&mut self) -> f64 {
        let unit = self.below(1000) as f64 / 1000.0;
        let sharpness = match self.below(4) {
            0 => unit,
            1 => 9.0 * unit + 1.0,
            2 => self.below(6) as f64,
            _ => 10.0 + unit,
        };
        f64::from(sharpness as f32)
    }
}

/// One of `models`, spoilt.
pub fn random_shape(models: &[Shape], seed: u64) -> Shape {
    let mut random = Random::new(seed);
    let r = &mut random;
    let mut shape = models[r.below(models.len())].clone();
    shape.name = format!("{}#{seed}", shape.name);
    shape.channel = None;
    let mut corners = shape.indices.iter().copied();
    let mut faces: Vec<Vec<u32>> = shape.counts.iter().map(|&n| corners.by_ref().take(n as usize).collect()).collect();

    let spoil = r.below(3);
    if spoil > 0 {
        faces.retain(|_| !r.one_in(8));
    }
    if spoil > 1 {
        spoil_faces(&mut faces, shape.positions.len(), shape.scheme == Scheme::Loop, r);
    }
    if faces.is_empty() {
        faces.push(vec![0, 1, 2]);
    }
    shape.counts = faces.iter().map(|f| f.len() as u32).collect();
    shape.indices = faces.concat();

    let tags = &mut shape.tags;
    tags.rules.boundary = [Boundary::None, Boundary::EdgeOnly, Boundary::EdgeAndCorner][r.below(3)];
    tags.rules.creasing = [Creasing::Uniform, Creasing::Chaikin][r.below(2)];
    tags.rules.triangles = [Triangles::CatmullClark, Triangles::Smooth][r.below(2)];
    tags.creases.clear();
    tags.corners.clear();
    tags.holes.clear();
    let every = 1 + r.below(12);
    for face in &faces {
        for (i, &a) in face.iter().enumerate() {
            let b = face[(i + 1) % face.len()];
            if a != b && r.one_in(every) {
                tags.creases.push(Crease::new(a, b, r.sharpness()));
            }
            if r.one_in(4 * every) {
                tags.corners.push(Corner::new(a, r.sharpness()));
            }
        }
    }
    tags.holes = (0..faces.len() as u32).filter(|_| r.one_in(10)).collect();
    shape
}

fn spoil_faces(faces: &mut Vec<Vec<u32>>, vertices: usize, keep_triangles: bool, r: &mut Random) {
    for _ in 0..r.below(4) {
        let (from, to) = (r.below(vertices) as u32, r.below(vertices) as u32);
        faces.iter_mut().flatten().filter(|v| **v == from).for_each(|v| *v = to);
    }
    for f in 0..faces.len() {
        match r.below(24) {
            0 => faces[f].reverse(),
            1 => faces.push(faces[f].clone()),
            2 if faces[f].len() > 3 => {
                let face = faces[f].clone();
                faces[f].truncate(3);
                faces.push([&face[2..], &face[..1]].concat());
            }
            3 if !keep_triangles => {
                let extra = r.below(vertices) as u32;
                faces[f].push(extra);
            }
            _ => {}
        }
    }
}
