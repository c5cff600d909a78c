//! As much of an OBJ file as the numbers need: vertices, faces, and the tag lines of creases and corners.

use std::error::Error;
use std::path::Path;
use subsurf::{ControlMesh, Corner, Crease, Tags};

pub struct Model {
    pub name: String,
    pub mesh: ControlMesh,
    pub positions: Vec<[f64; 3]>,
}

impl Model {
    pub fn read(path: &str) -> Result<Self, Box<dyn Error>> {
        let text = std::fs::read_to_string(path).map_err(|e| format!("{path}: {e}"))?;
        let (mut positions, mut counts, mut corners, mut tags) = (Vec::new(), Vec::new(), Vec::new(), Tags::default());
        for (number, line) in text.lines().enumerate() {
            let words: Vec<&str> = line.split_whitespace().collect();
            let bad = || format!("{path}, line {}: {line}", number + 1);
            match words[..] {
                ["v", x, y, z, ..] => positions.push([x.parse()?, y.parse()?, z.parse()?]),
                ["f", ref list @ ..] => {
                    counts.push(list.len() as u32);
                    for word in list {
                        let vertex: u32 = word.split('/').next().ok_or_else(bad)?.parse()?;
                        corners.push(vertex.checked_sub(1).ok_or_else(bad)?);
                    }
                }
                ["t", "crease", _, a, b, s] => tags.creases.push(Crease::new(a.parse()?, b.parse()?, s.parse()?)),
                ["t", "corner", _, v, s] => tags.corners.push(Corner::new(v.parse()?, s.parse()?)),
                _ => {}
            }
        }
        let mesh = ControlMesh::from_counts(positions.len(), &counts, corners, tags)?;
        let name = Path::new(path).file_stem().map_or(path.into(), |s| s.to_string_lossy().into_owned());
        Ok(Self { name, mesh, positions })
    }
}
