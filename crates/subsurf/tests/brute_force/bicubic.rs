//! The bicubic polynomial over a regular quad.

use super::point::{Point, plus, size, times};
use super::{Double, Jet, Patch, Rings, Soup, key};

impl Soup {
    /// The polynomial over face 0, which is regular.
    pub(super) fn bicubic(&self, rings: &Rings) -> Patch {
        let grid = self.grid(rings);
        let distance = |p: &Point| size([0, 1, 2].map(|k| (p[k] - grid[1][1][k]).to_f64()));
        let reach = grid.iter().flatten().map(distance).fold(0.0, f64::max);
        Patch { jet: Box::new(move |u, v| tensor(&grid, u, v)), reach }
    }

    /// Its sixteen control points, `[x][y]`.
    fn grid(&self, rings: &Rings) -> [[Point; 4]; 4] {
        const INNER: [(usize, usize); 4] = [(1, 1), (2, 1), (2, 2), (1, 2)];
        // Beyond side j: the points outward of corners j and j + 1.
        const BEYOND: [[(usize, usize); 2]; 4] =
            [[(1, 0), (2, 0)], [(3, 1), (3, 2)], [(2, 3), (1, 3)], [(0, 2), (0, 1)]];
        const DIAGONAL: [(usize, usize); 4] = [(0, 0), (3, 0), (3, 3), (0, 3)];
        let own = &self.faces[0];
        let at = |v: u32| self.points[v as usize];
        let mirror = |a: Point, b: Point| plus(times(a, Double::from(2.0)), times(b, Double::from(-1.0)));
        let mut grid = [[[Double::ZERO; 3]; 4]; 4];
        (0..4).for_each(|j| grid[INNER[j].0][INNER[j].1] = at(own[j]));
        let side = |j: usize| key(own[j % 4], own[(j + 1) % 4]);
        let sharp = |j: usize| self.sharpness(side(j)) > 0.0;
        let neighbour = |j: usize| *rings.edge_faces[&side(j)].iter().find(|&&f| f != 0).expect("two faces");
        let get = |grid: &[[Point; 4]; 4], (x, y): (usize, usize)| grid[x][y];
        for j in 0..4 {
            let [a, b] = if sharp(j) {
                let inner = |k: usize| get(&grid, INNER[k % 4]);
                [mirror(inner(j), inner(j + 3)), mirror(inner(j + 1), inner(j + 2))]
            } else {
                let face = &self.faces[neighbour(j)];
                let i = face.iter().position(|&v| v == own[j]).expect("a common corner");
                // The neighbour runs from corner j + 1 to corner j.
                assert_eq!(face[(i + 3) % 4], own[(j + 1) % 4]);
                [at(face[(i + 1) % 4]), at(face[(i + 2) % 4])]
            };
            grid[BEYOND[j][0].0][BEYOND[j][0].1] = a;
            grid[BEYOND[j][1].0][BEYOND[j][1].1] = b;
        }
        for j in 0..4 {
            let before = (j + 3) % 4;
            let point = match (sharp(before), sharp(j)) {
                (false, false) => {
                    let beside = [0, neighbour(before), neighbour(j)];
                    let faces = &rings.vertex_faces[&own[j]];
                    let f = *faces.iter().find(|f| !beside.contains(f)).expect("four faces");
                    let i = self.faces[f].iter().position(|&v| v == own[j]).expect("a common corner");
                    at(self.faces[f][(i + 2) % 4])
                }
                (true, false) => mirror(get(&grid, BEYOND[j][0]), get(&grid, BEYOND[j][1])),
                _ => mirror(get(&grid, BEYOND[before][1]), get(&grid, BEYOND[before][0])),
            };
            grid[DIAGONAL[j].0][DIAGONAL[j].1] = point;
        }
        grid
    }
}

fn tensor(grid: &[[Point; 4]; 4], u: f64, v: f64) -> Jet {
    let (bu, bv) = (cubic(u), cubic(v));
    [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)].map(|(i, j)| {
        let mut total = [Double::ZERO; 3];
        for x in 0..4 {
            for y in 0..4 {
                total = plus(total, times(grid[x][y], bu[i][x] * bv[j][y]));
            }
        }
        total
    })
}

/// Uniform cubic B-spline basis: values, first and second derivatives.
fn cubic(t: f64) -> [[Double; 4]; 3] {
    let t = Double::from(t);
    let s = Double::from(1.0) - t;
    let n = |x: f64| Double::from(x);
    let six = |x: Double| x / n(6.0);
    let half = |x: Double| x / n(2.0);
    let inner = |t: Double| six(n(4.0) - n(6.0) * t * t + n(3.0) * t * t * t);
    [
        [six(s * s * s), inner(t), inner(s), six(t * t * t)],
        [half(n(-1.0) * s * s), half(n(3.0) * t * t - n(4.0) * t), half(n(4.0) * s - n(3.0) * s * s), half(t * t)],
        [s, n(3.0) * t - n(2.0), n(3.0) * s - n(2.0), t],
    ]
}
