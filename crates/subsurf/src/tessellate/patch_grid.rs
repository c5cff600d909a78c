//! The grid of facets over one patch: its points, their numbers and parameters.

/// A grid of facets over one patch.
#[derive(Clone, Copy)]
pub struct PatchGrid {
    /// Facets across u and v; both the same for triangles.
    pub cells: [u32; 2],
    /// First interior point.
    pub first: u32,
    pub is_triangle: bool,
}

impl PatchGrid {
    /// Interior point `(i, j)`, both from 1.
    pub fn inner(&self, i: u32, j: u32) -> u32 {
        let n = self.cells[0];
        if self.is_triangle {
            // Row j has n - 1 - j points.
            return self.first + (j - 1) * (n - 1) - (j - 1) * j / 2 + i - 1;
        }
        self.first + (j - 1) * (n - 1) + i - 1
    }

    /// Number of interior points.
    pub fn points(&self) -> u32 {
        inner_points(self.is_triangle, self.cells.map(u64::from)) as u32
    }

    /// All interior points `(i, j)` in order.
    pub fn interior(self) -> impl Iterator<Item = (u32, u32)> {
        let [nu, nv] = self.cells;
        let row = move |j: u32| if self.is_triangle { 1..nu.saturating_sub(j) } else { 1..nu };
        (1..nv).flat_map(move |j| row(j).map(move |i| (i, j)))
    }

    /// Parameters of grid point `(i, j)`.
    pub fn uv(&self, i: u32, j: u32) -> [f64; 2] {
        [f64::from(i) / f64::from(self.cells[0]), f64::from(j) / f64::from(self.cells[1])]
    }
}

/// Number of interior points of a grid of these cells.
pub(super) fn inner_points(is_triangle: bool, [nu, nv]: [u64; 2]) -> u64 {
    if is_triangle { (nu - 1) * nu.saturating_sub(2) / 2 } else { (nu - 1) * (nv - 1) }
}

/// Parameters at `there` of the way along side `side` of a patch, `back` being the rest of the way.
pub(super) fn on_side(is_triangle: bool, side: usize, there: f64, back: f64) -> [f64; 2] {
    match (is_triangle, side) {
        (_, 0) => [there, 0.0],
        (false, 1) => [1.0, there],
        (false, 2) => [back, 1.0],
        (true, 1) => [back, there],
        _ => [0.0, back],
    }
}
