//! The meshes that all are measured on: files, and generated cages.

use super::cage::cage;
use crate::shape::Shape;
use std::path::{Path, PathBuf};

/// A mesh with its points in single precision, as everyone gets it.
pub struct Case {
    pub shape: Shape,
    pub control: Vec<[f32; 3]>,
}

pub const CAR: &str = "catmark_car";
pub const CHARACTER: &str = "makehuman_base";
pub const HEAD: &str = "ict_face_neutral";
pub const SHOES: &str = "mh_shoes03_semisharp";
/// Names and about how many faces.
pub const CAGES: [(&str, usize); 4] =
    [("cage_10k", 10_000), ("cage_100k", 100_000), ("cage_1m", 1_000_000), ("cage_10m", 10_000_000)];

/// Where models are looked for, one folder after the other.
pub fn folders(named: Option<&str>) -> Vec<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let models = named.map_or_else(|| beside.join("../shared/models"), PathBuf::from);
    vec![models.join("opensubdiv_shapes"), models, beside.join("assets")]
}

impl Case {
    /// A generated cage, or the first file of this name.
    ///
    /// # Errors
    /// If there is no such file, or it cannot be read.
    pub fn load(name: &str, folders: &[PathBuf]) -> Result<Self, String> {
        let shape = match CAGES.iter().find(|(cage, _)| *cage == name) {
            Some(&(name, faces)) => cage(name, faces),
            None => {
                let files: Vec<PathBuf> = folders.iter().map(|f| f.join(format!("{name}.obj"))).collect();
                let file = files.iter().find(|f| f.exists());
                Shape::read(file.ok_or_else(|| format!("there is no {name}.obj in any of {folders:?}"))?)?
            }
        };
        let control = shape.positions.iter().map(|p| p.map(|x| x as f32)).collect();
        Ok(Self { shape, control })
    }

    pub fn faces(&self) -> usize {
        self.shape.counts.len()
    }

    pub fn all_quads(&self) -> bool {
        self.shape.counts.iter().all(|&n| n == 4)
    }

    /// The control points of another frame: each moved by up to a thousandth of the mesh's size.
    pub fn frame(&self, number: usize) -> Vec<[f32; 3]> {
        let step = 1e-3 * self.shape.diagonal() as f32;
        let moved = |i: usize, k: usize, x: f32| x + step * ((i + 7 * number) as f32 * 0.7 + k as f32).sin();
        self.control.iter().enumerate().map(|(i, p)| std::array::from_fn(|k| moved(i, k, p[k]))).collect()
    }

    /// Vertices, faces of the `level`-th refinement, from a mesh without other than manifold edges.
    pub fn refined_counts(&self, level: u32) -> [usize; 2] {
        let mut edges: Vec<u64> = Vec::with_capacity(self.shape.indices.len());
        let mut start = 0;
        for &sides in &self.shape.counts {
            let face = &self.shape.indices[start..start + sides as usize];
            start += sides as usize;
            for (i, &a) in face.iter().enumerate() {
                let b = face[(i + 1) % face.len()];
                edges.push(u64::from(a.min(b)) << 32 | u64::from(a.max(b)));
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let (mut v, mut e, mut f) = (self.shape.positions.len(), edges.len(), self.faces());
        let mut corners = self.shape.indices.len();
        for _ in 0..level {
            (v, e, f) = (v + e + f, 2 * e + corners, corners);
            corners = 4 * f;
        }
        [v, f]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refined_counts_are_those_of_refinement() {
        let case = Case::load("spot_control_mesh", &folders(None)).unwrap();
        let mesh = case.shape.mesh().unwrap();
        let mut level = subsurf::Level::new(&mesh, case.shape.our_scheme()).unwrap();
        for depth in 1..3 {
            level = level.refine().unwrap();
            let t = level.topology();
            assert_eq!(case.refined_counts(depth), [t.vertex_count(), t.face_count()]);
        }
    }
}
