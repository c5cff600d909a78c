//! Places on a surface in everyone's numbering: the same points for all.

use super::case::Case;
use super::rivals::embree::QuadPlaces;
use super::rivals::patches::Place;
use subsurf::{Face, Location};

/// Faces, sub-faces and parameters.
#[derive(Clone, Debug)]
pub struct Places {
    pub at: Vec<(u32, u32, [f32; 2])>,
    /// First Ptex face of every face.
    ptex: Vec<u32>,
}

impl Places {
    /// Places drawn at random: every sub-face is as likely as any other.
    pub fn random(case: &Case, count: usize) -> Self {
        let patches: Vec<(u32, u32)> = patches(case).collect();
        let mut state = 0x9E37_79B9_7F4A_7C15u64;
        let mut random = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state
        };
        let at = (0..count)
            .map(|_| {
                let (face, subface) = patches[(random() % patches.len() as u64) as usize];
                // 24 bits, as many as a float keeps; never 0 or 1.
                let mut parameter = || ((random() >> 40) as f32 + 0.5) / 16_777_216.0;
                (face, subface, [parameter(), parameter()])
            })
            .collect();
        Self { at, ptex: ptex_faces(case) }
    }

    /// `rate`² places in every quad, half the rate in every sub-face of other faces: about as many as a tessellation at
    /// this rate has vertices.
    pub fn grid(case: &Case, rate: u32) -> Self {
        let mut at = Vec::new();
        for (face, subface) in patches(case) {
            let n = if case.shape.counts[face as usize] == 4 { rate } else { rate / 2 };
            let along = |i: u32| (i as f32 + 0.5) / n as f32;
            at.extend((0..n * n).map(|i| (face, subface, [along(i % n), along(i / n)])));
        }
        Self { at, ptex: ptex_faces(case) }
    }

    pub fn len(&self) -> usize {
        self.at.len()
    }

    /// The same places, face after face.
    pub fn by_face(&self) -> Self {
        let mut sorted = self.clone();
        sorted.at.sort_by_key(|&(face, subface, _)| (face, subface));
        sorted
    }

    /// In our terms.
    pub fn ours(&self) -> Vec<Location> {
        let location = |&(face, subface, [u, v]): &(u32, u32, [f32; 2])| Location {
            face: Face(face),
            subface,
            u: f64::from(u),
            v: f64::from(v),
        };
        self.at.iter().map(location).collect()
    }

    /// In Far's terms.
    pub fn ptex(&self) -> Vec<Place> {
        let place = |&(face, subface, [u, v]): &(u32, u32, [f32; 2])| Place {
            ptex_face: (self.ptex[face as usize] + subface) as i32,
            u,
            v,
        };
        self.at.iter().map(place).collect()
    }

    /// In Embree's terms, where all faces are quads.
    pub fn quads(&self) -> QuadPlaces {
        QuadPlaces {
            faces: self.at.iter().map(|p| p.0).collect(),
            u: self.at.iter().map(|p| p.2[0]).collect(),
            v: self.at.iter().map(|p| p.2[1]).collect(),
        }
    }
}

/// Faces with their sub-faces.
fn patches(case: &Case) -> impl Iterator<Item = (u32, u32)> {
    let subfaces = |&n: &u32| if n == 4 { 1 } else { n };
    case.shape.counts.iter().map(subfaces).enumerate().flat_map(|(f, n)| (0..n).map(move |s| (f as u32, s)))
}

fn ptex_faces(case: &Case) -> Vec<u32> {
    let mut next = 0;
    let first = |&n: &u32| {
        let first = next;
        next += if n == 4 { 1 } else { n };
        first
    };
    case.shape.counts.iter().map(first).collect()
}
