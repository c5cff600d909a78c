//! Eigenvectors of S12, the outer points' own block, and the extension of ring modes to the outer points.
//!
//! The outer points are two arms that meet at the corner point (2,2). Each arm subdivides like a cubic B-spline curve
//! across its middle point; where the face's edge is sharp, the far point is absent and the middle one is on the crease.
//!
//! ```text
//!     (-1,2)--(0,2)--(1,2)--(2,2)        1/64 | 4 4 0 |  far          1/64 | 8 0 |  middle
//!      far    middle  near    |               | 1 6 1 |  middle            | 4 4 |  near
//!                           (2,1) near        | 0 4 4 |  near
//!                             |
//!                           (2,0) middle      (2,2) = (middle + 6 near + (2,2) + 6 near + middle) / 64
//!                             |
//!                          (2,-1) far
//! ```

/// An eigenvalue of an arm with its right and left vector, from the far point to the near one.
type ArmMode = (f64, &'static [f64], &'static [f64]);

const INNER_ARM: [ArmMode; 3] = [
    (1.0 / 8.0, &[1.0, 1.0, 1.0], &[1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0]),
    (1.0 / 16.0, &[1.0, 0.0, -1.0], &[1.0 / 2.0, 0.0, -1.0 / 2.0]),
    (1.0 / 32.0, &[2.0, -1.0, 2.0], &[1.0 / 6.0, -2.0 / 6.0, 1.0 / 6.0]),
];
const SHARP_ARM: [ArmMode; 2] = [(1.0 / 8.0, &[1.0, 1.0], &[1.0, 0.0]), (1.0 / 16.0, &[0.0, 1.0], &[-1.0, 1.0])];
const CORNER: f64 = 1.0 / 64.0;

/// The eigenvectors of S12, which is always diagonalizable.
pub(super) struct OuterModes {
    pub(super) eigenvalues: Vec<f64>,
    /// `right[mode][point]`.
    pub(super) right: Vec<Vec<f64>>,
    /// `left[mode][point]`, dual to `right`.
    pub(super) left: Vec<Vec<f64>>,
}

impl OuterModes {
    /// The modes of a face whose edges `v e_i` and `v e_{i+1}` are inside the surface, or else sharp.
    pub(super) fn new(first_inside: bool, second_inside: bool) -> Self {
        let arm = |inside| if inside { &INNER_ARM[..] } else { &SHARP_ARM[..] };
        let (first, second) = (arm(first_inside), arm(second_inside));
        let corner = first.len();
        let len = corner + 1 + second.len();
        let mut modes = Self { eigenvalues: vec![], right: vec![], left: vec![] };
        // The corner's own mode is dual to what the corner point has beyond the arms' modes.
        let mut own_left = vec![0.0; len];
        own_left[corner] = 1.0;
        let far_to_near = [(first, (0..corner).collect::<Vec<_>>()), (second, (corner + 1..len).rev().collect())];
        for (arm, points) in far_to_near {
            for &(eigenvalue, right, left) in arm {
                let [.., middle, near] = *right else { unreachable!("an arm has two points") };
                let mut column = vec![0.0; len];
                let mut row = vec![0.0; len];
                column[corner] = (middle + 6.0 * near) / (eigenvalue / CORNER - 1.0);
                for (at, &p) in points.iter().enumerate() {
                    column[p] = right[at];
                    row[p] = left[at];
                    own_left[p] -= column[corner] * left[at];
                }
                modes.push(eigenvalue, column, row);
            }
        }
        let mut own_right = vec![0.0; len];
        own_right[corner] = 1.0;
        modes.push(CORNER, own_right, own_left);
        modes
    }

    fn push(&mut self, eigenvalue: f64, right: Vec<f64>, left: Vec<f64>) {
        self.eigenvalues.push(eigenvalue);
        self.right.push(right);
        self.left.push(left);
    }

    /// Replaces the first mode, an arm's 1/8, by what `x` has of both arms' modes of that eigenvalue.
    pub(super) fn lead_with(&mut self, x: &[f64]) {
        let other = (1..self.len()).find(|&k| self.eigenvalues[k] == self.eigenvalues[0]).expect("a second arm");
        let coefficients = self.coefficients(x);
        let (own, ratio) = (coefficients[0], coefficients[other] / coefficients[0]);
        for p in 0..self.len() {
            self.right[0][p] = own * (self.right[0][p] + ratio * self.right[other][p]);
            self.left[other][p] -= ratio * self.left[0][p];
            self.left[0][p] /= own;
        }
    }

    /// The number of outer points: 7, less one for each sharp edge of the face.
    pub(super) fn len(&self) -> usize {
        self.eigenvalues.len()
    }

    /// The coefficients of a vector over the outer points.
    pub(super) fn coefficients(&self, x: &[f64]) -> Vec<f64> {
        self.left.iter().map(|row| super::dot(row, x)).collect()
    }

    /// The vector over the outer points that has these coefficients.
    pub(super) fn combine(&self, coefficients: &[f64]) -> Vec<f64> {
        (0..self.len()).map(|p| self.right.iter().zip(coefficients).map(|(mode, y)| mode[p] * y).sum()).collect()
    }

    /// Coefficients of the outer part `x` of a column with eigenvalue `λ`: `(S12 - λ) x = -driven + eigenvector`, with
    /// `driven` = S11 times the column's ring part, and `eigenvector` the outer part of the vector that it is chained to.
    ///
    /// Where λ is an eigenvalue of S12 too, any coefficient will do: 0, as the pseudo-inverse has it. Nothing drives that
    /// mode, or else (valence 2) it is the column's eigenvector in a chain.
    pub(super) fn extend(&self, eigenvalue: f64, driven: &[f64], eigenvector: Option<&[f64]>) -> Vec<f64> {
        let mode = |k: usize| match eigenvalue - self.eigenvalues[k] {
            0.0 => 0.0,
            gap => (driven[k] - eigenvector.map_or(0.0, |y| y[k])) / gap,
        };
        (0..self.len()).map(mode).collect()
    }
}
