//! Where the faces of refined levels lie on the control mesh's patches, in our parameters.

use crate::shape::{Scheme, Shape};

/// A face of the control mesh with its patch's parameters, and what of it a level's face covers.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Place {
    pub face: u32,
    pub subface: u32,
    /// Parameters of the level face's corners; a triangle's fourth is unused.
    pub corners: [[f64; 2]; 4],
}

const UNIT_SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
const UNIT_TRIANGLE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];

fn middle(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
}

impl Place {
    /// The four children of a quad or, under Loop, of a triangle, in the order of the refined faces.
    pub fn children(&self, scheme: Scheme) -> [Self; 4] {
        let p = self.corners;
        std::array::from_fn(|c| {
            let corners = match (scheme, c) {
                (Scheme::Loop, 3) => [middle(p[1], p[2]), middle(p[2], p[0]), middle(p[0], p[1]), [0.0; 2]],
                _ => std::array::from_fn(|j| middle(p[c], p[j])),
            };
            Self { corners, ..*self }
        })
    }

    /// True where the face covers the parameters.
    pub fn contains(&self, scheme: Scheme, at: [f64; 2]) -> bool {
        let p = self.corners;
        if scheme == Scheme::Loop {
            // The smallest barycentric coordinate, exact for the dyadic numbers at hand.
            let cross = |a: [f64; 2], b: [f64; 2]| (b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0]);
            return cross(p[0], p[1]).min(cross(p[1], p[2])).min(cross(p[2], p[0])) >= 0.0;
        }
        (0..2).all(|k| {
            let (a, b) = (p[0][k].min(p[2][k]), p[0][k].max(p[2][k]));
            (a..=b).contains(&at[k])
        })
    }
}

/// Where every face of levels 1 to `levels` lies.
pub fn places(shape: &Shape, levels: u32) -> Vec<Vec<Place>> {
    let mut first = vec![];
    for (face, &n) in (0..).zip(&shape.counts) {
        let whole = |subface, corners| Place { face, subface, corners };
        match (shape.scheme, n) {
            (Scheme::Loop, _) => first.extend(whole(0, UNIT_TRIANGLE).children(Scheme::Loop)),
            (_, 4) => first.extend(whole(0, UNIT_SQUARE).children(shape.scheme)),
            _ => first.extend((0..n).map(|corner| whole(corner, UNIT_SQUARE))),
        }
    }
    let mut all = vec![first];
    while all.len() < levels as usize {
        let next = all[all.len() - 1].iter().flat_map(|place| place.children(shape.scheme)).collect();
        all.push(next);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_of_a_level_cover_their_patch_once() {
        for (name, face, inside) in [("catmark_x", "f 1 2 3 4", [0.3, 0.7]), ("loop_x", "f 1 2 3", [0.3, 0.41])] {
            let shape = Shape::parse(name, &format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n{face}")).unwrap();
            for level in places(&shape, 3) {
                assert_eq!(level.iter().filter(|p| p.contains(shape.scheme, inside)).count(), 1, "{name}");
            }
        }
    }
}
