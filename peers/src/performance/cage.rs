//! Cages of any size: a torus of quads, in every twelfth row and column of which a quad holds a smaller one. Its corners
//! then have valence 5, the small one's 3. Every fourth time the quad diagonally beyond has one too, and the corner
//! between them valence 6. About 6 % of the vertices are extraordinary, as in a character.
//!
//! Everything follows from the size: no random numbers.

use crate::shape::{Scheme, Shape};
use subsurf::{Boundary, Rules, Tags};

/// Rows and columns from one quad that holds another to the next.
const APART: usize = 12;

/// A cage of about this many faces, all quads.
pub fn cage(name: &str, faces: usize) -> Shape {
    // Twice as many columns as rows, both multiples of APART; a block has 6 faces more on average than it has cells.
    let per_block = (APART * APART) as f64 + 5.0;
    let blocks = ((faces as f64 / per_block / 2.0).sqrt().round() as usize).max(1);
    let (rows, columns) = (APART * blocks, 2 * APART * blocks);
    let grid = |row: usize, column: usize| ((row % rows) * columns + column % columns) as u32;
    let mut positions = Vec::with_capacity(rows * columns * 21 / 20);
    for row in 0..rows {
        for column in 0..columns {
            positions.push(on_torus(row as f64 / rows as f64, column as f64 / columns as f64));
        }
    }
    let mut indices = Vec::with_capacity(4 * faces);
    for row in 0..rows {
        for column in 0..columns {
            let outer = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(i, j)| grid(row + i, column + j));
            if !holds_another(row, column) {
                indices.extend(outer);
                continue;
            }
            let center: [f64; 3] =
                std::array::from_fn(|k| outer.iter().map(|&v| positions[v as usize][k]).sum::<f64>() / 4.0);
            let first = positions.len() as u32;
            for v in outer {
                let p = positions[v as usize];
                positions.push(std::array::from_fn(|k| (p[k] + center[k]) / 2.0));
            }
            let inner = [0, 1, 2, 3].map(|i| first + i);
            indices.extend(inner);
            for i in 0..4 {
                let j = (i + 1) % 4;
                indices.extend([outer[i], outer[j], inner[j], inner[i]]);
            }
        }
    }
    Shape {
        name: name.to_string(),
        scheme: Scheme::CatmullClark,
        positions,
        counts: vec![4; indices.len() / 4],
        indices,
        tags: Tags { rules: Rules { boundary: Boundary::EdgeOnly, ..Rules::default() }, ..Tags::default() },
        channel: None,
    }
}

fn holds_another(row: usize, column: usize) -> bool {
    let at = |row: usize, column: usize| row % APART == 5 && column % APART == 5;
    let twice = |row: usize, column: usize| (row / APART + column / APART).is_multiple_of(4);
    at(row, column) || row > 0 && column > 0 && at(row - 1, column - 1) && twice(row - 1, column - 1)
}

/// A torus with low bumps.
fn on_torus(row: f64, column: f64) -> [f64; 3] {
    let (a, b) = (std::f64::consts::TAU * column, std::f64::consts::TAU * row);
    let tube = 0.4 + 0.03 * (5.0 * a).sin() * (3.0 * b).cos();
    let ring = 1.0 + tube * b.cos();
    [ring * a.cos(), ring * a.sin(), tube * b.sin()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cage_is_closed_has_valences_3_to_6_and_about_the_size_asked_for() {
        for faces in [10_000, 100_000] {
            let shape = cage("cage", faces);
            let near = |count: usize| (count as f64 / faces as f64 - 1.0).abs() < 0.25;
            assert!(near(shape.counts.len()), "{}", shape.counts.len());
            let mut corners = vec![0; shape.positions.len()];
            shape.indices.iter().for_each(|&v| corners[v as usize] += 1);
            let count = |valence: usize| corners.iter().filter(|&&n| n == valence).count();
            assert!([3, 5, 6].iter().all(|&n| count(n) > 0));
            assert_eq!([3, 4, 5, 6].map(count).iter().sum::<usize>(), corners.len());
            // Euler's number of a torus: V - E + F = 0, where every edge has two faces.
            assert_eq!(shape.positions.len() + shape.counts.len(), shape.indices.len() / 2);
            assert!(shape.mesh().is_ok());
            let extraordinary = 1.0 - count(4) as f64 / corners.len() as f64;
            assert!((0.04..0.09).contains(&extraordinary), "{extraordinary}");
        }
    }
}
