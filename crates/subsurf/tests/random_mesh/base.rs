//! What a random mesh starts from.

use proptest::prelude::*;
use std::collections::HashMap;

/// What a mesh starts from.
#[derive(Clone, Copy, Debug)]
pub enum Base {
    /// `w × h` quads with a boundary.
    Grid(u32, u32),
    /// `w × h` quads, closed in the first direction.
    Tube(u32, u32),
    /// `w × h` quads, closed in both directions.
    Torus(u32, u32),
    /// Quads round one interior vertex, so many rings.
    Fan(u32, u32),
    /// Quads round one boundary vertex, so many rings.
    Sector(u32, u32),
    /// Triangles round one vertex.
    Umbrella(u32),
    /// Triangles over an n-gon.
    Cone(u32),
    /// Two n-gons back to back.
    Pillow(u32),
    /// The cube, every face `n × n`.
    Cube(u32),
    /// Four triangles.
    Tetrahedron,
    /// So many grids of `w × h` quads with one column of vertices in common.
    Book(u32, u32, u32),
}

impl Base {
    pub fn faces(self) -> Vec<Vec<u32>> {
        match self {
            Self::Grid(w, h) => grid(w, h, w + 1, h + 1),
            Self::Tube(w, h) => grid(w, h, w, h + 1),
            Self::Torus(w, h) => grid(w, h, w, h),
            Self::Fan(n, rings) => fan(n, n, rings),
            Self::Sector(n, rings) => fan(n, n + 1, rings),
            Self::Umbrella(n) => (0..n).map(|i| vec![0, 1 + i, 1 + (i + 1) % n]).collect(),
            Self::Cone(n) => {
                let mut faces = Self::Umbrella(n).faces();
                faces.push((0..n).rev().map(|i| 1 + i).collect());
                faces
            }
            Self::Pillow(n) => vec![(0..n).collect(), (0..n).rev().collect()],
            Self::Cube(n) => cube(n),
            Self::Book(pages, w, h) => book(pages, w, h),
            Self::Tetrahedron => vec![vec![0, 1, 2], vec![0, 3, 1], vec![1, 3, 2], vec![2, 3, 0]],
        }
    }
}

fn grid(w: u32, h: u32, columns: u32, rows: u32) -> Vec<Vec<u32>> {
    let at = |x: u32, y: u32| y % rows * columns + x % columns;
    let quad = |i: u32| {
        let (x, y) = (i % w, i / w);
        vec![at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]
    };
    (0..w * h).map(quad).collect()
}

fn fan(sectors: u32, spokes: u32, rings: u32) -> Vec<Vec<u32>> {
    let at = |s: u32, x: u32, y: u32| match (x, y) {
        (0, 0) => 0,
        (x, 0) => 1 + s % spokes * rings + x - 1,
        (0, y) => 1 + (s + 1) % spokes * rings + y - 1,
        (x, y) => 1 + spokes * rings + s * rings * rings + (y - 1) * rings + x - 1,
    };
    let mut faces = Vec::new();
    for s in 0..sectors {
        for i in 0..rings * rings {
            let (x, y) = (i % rings, i / rings);
            faces.push(vec![at(s, x, y), at(s, x + 1, y), at(s, x + 1, y + 1), at(s, x, y + 1)]);
        }
    }
    faces
}

/// Every other page is turned round, so that neighbouring pages run on into each other.
fn book(pages: u32, w: u32, h: u32) -> Vec<Vec<u32>> {
    let at = |page: u32, x: u32, y: u32| if x == 0 { y } else { (h + 1) * (1 + page * w + x - 1) + y };
    let mut faces = Vec::new();
    for page in 0..pages {
        for i in 0..w * h {
            let (x, y) = (i % w, i / w);
            let mut quad = vec![at(page, x, y), at(page, x + 1, y), at(page, x + 1, y + 1), at(page, x, y + 1)];
            if page % 2 == 1 {
                quad.reverse();
            }
            faces.push(quad);
        }
    }
    faces
}

fn cube(n: u32) -> Vec<Vec<u32>> {
    let mut number: HashMap<[u32; 3], u32> = HashMap::new();
    let mut faces = Vec::new();
    for axis in 0..3 {
        for end in [0, n] {
            for i in 0..n * n {
                let (x, y) = (i % n, i / n);
                let mut corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
                if end == 0 {
                    corners.reverse();
                }
                let point = |[p, q]: [u32; 2]| {
                    let mut c = [0; 3];
                    (c[axis], c[(axis + 1) % 3], c[(axis + 2) % 3]) = (end, p, q);
                    c
                };
                let next = |c| {
                    let free = number.len() as u32;
                    *number.entry(point(c)).or_insert(free)
                };
                faces.push(corners.map(next).to_vec());
            }
        }
    }
    faces
}

pub fn base() -> impl Strategy<Value = Base> {
    prop_oneof![
        3 => (1..6u32, 1..6u32).prop_map(|(w, h)| Base::Grid(w, h)),
        1 => (3..6u32, 1..4u32).prop_map(|(w, h)| Base::Tube(w, h)),
        1 => (3..6u32, 3..6u32).prop_map(|(w, h)| Base::Torus(w, h)),
        3 => (2..9u32, 1..3u32).prop_map(|(n, r)| Base::Fan(n, r)),
        1 => (9..51u32).prop_map(|n| Base::Fan(n, 1)),
        2 => (1..9u32, 1..3u32).prop_map(|(n, r)| Base::Sector(n, r)),
        1 => (9..51u32).prop_map(|n| Base::Sector(n, 1)),
        1 => (3..51u32).prop_map(Base::Umbrella),
        1 => (3..13u32).prop_map(Base::Cone),
        1 => (3..8u32).prop_map(Base::Pillow),
        2 => (1..4u32).prop_map(Base::Cube),
        1 => Just(Base::Tetrahedron),
        1 => (2..5u32, 1..4u32, 1..5u32).prop_map(|(p, w, h)| Base::Book(p, w, h)),
    ]
}
