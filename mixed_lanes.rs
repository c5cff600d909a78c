//! Samples of different sub-patches side by side: every lane has control points of its own. Where sub-patches have one or
//! two samples each, filling lanes this way costs less than leaving them idle. The bits are those of
//! [`Piece::block`](super::lanes::Piece::block).

use super::lanes::{Block, Piece, Turn, add, curves};
use crate::kernel::{LANES, vectorized};
use crate::real::Real;

/// Samples side by side.
pub(super) const WIDTH: usize = 8;

/// Up to [`WIDTH`] samples that wait for company.
pub(super) struct Mixed<T, const N: usize> {
    points: [[[T; WIDTH]; LANES]; N],
    s: [T; WIDTH],
    t: [T; WIDTH],
    origins: [[T; N]; WIDTH],
    turns: [Option<Turn<T>>; WIDTH],
    samples: [u32; WIDTH],
    count: usize,
}

impl<T: Real, const N: usize> Default for Mixed<T, N> {
    fn default() -> Self {
        let zero = T::default();
        Self {
            points: [[[zero; WIDTH]; LANES]; N],
            s: [zero; WIDTH],
            t: [zero; WIDTH],
            origins: [[zero; N]; WIDTH],
            turns: [None; WIDTH],
            samples: [0; WIDTH],
            count: 0,
        }
    }
}

impl<T: Real, const N: usize> Mixed<T, N> {
    /// Adds a sample of a piece that [`Piece::can_mix`]; evaluates all when there are enough.
    #[inline]
    pub fn push<const R: usize>(&mut self, piece: &Piece<T, N>, s: T, t: T, sample: u32, rows: &mut [[[T; N]; R]]) {
        let lane = self.count;
        for c in 0..N {
            for k in 0..LANES {
                self.points[c][k][lane] = piece.points[c][k];
            }
        }
        (self.s[lane], self.t[lane], self.samples[lane]) = (s, t, sample);
        (self.origins[lane], self.turns[lane]) = (piece.origin, piece.turn);
        self.count += 1;
        if self.count == WIDTH {
            self.flush(rows);
        }
    }

    /// Evaluates the samples that wait.
    pub fn flush<const R: usize>(&mut self, rows: &mut [[[T; N]; R]]) {
        let count = std::mem::take(&mut self.count);
        if count == 0 {
            return;
        }
        let this = &*self;
        vectorized(
            #[inline(always)]
            || this.write(count, rows),
        );
    }

    #[inline(always)]
    fn write<const R: usize>(&self, count: usize, rows: &mut [[[T; N]; R]]) {
        let block = self.block::<R>();
        for lane in 0..count {
            let row = &mut rows[self.samples[lane] as usize];
            for c in 0..N {
                for r in 0..R {
                    row[r][c] = block[r][c][lane];
                }
                row[0][c] = self.origins[lane][c] + row[0][c];
            }
            if let Some((turn, bend)) = &self.turns[lane] {
                for c in 0..N {
                    if R > 1 {
                        let [s, t] = [row[1][c], row[2][c]];
                        row[1][c] = turn[0][0] * s + turn[0][1] * t;
                        row[2][c] = turn[1][0] * s + turn[1][1] * t;
                    }
                    if R > 3 {
                        let [ss, st, tt] = [row[3][c], row[4][c], row[5][c]];
                        for r in 0..3 {
                            row[3 + r][c] = bend[r][0] * ss + bend[r][1] * st + bend[r][2] * tt;
                        }
                    }
                }
            }
        }
    }

    /// Bicubic patches, each in its own parameters.
    #[inline(always)]
    fn block<const R: usize>(&self) -> Block<T, N, R, WIDTH> {
        let (along, across) = (curves(&self.s), curves(&self.t));
        let mut rows = [[[T::default(); WIDTH]; N]; R];
        for c in 0..N {
            for j in 0..4 {
                let points = &self.points[c];
                let value = line(points, j, &along[0]);
                add(&mut rows[0][c], &across[0][j], &value);
                if R > 1 {
                    let slope = line(points, j, &along[1]);
                    add(&mut rows[1][c], &across[0][j], &slope);
                    add(&mut rows[2][c], &across[1][j], &value);
                    if R > 3 {
                        let bend = line(points, j, &along[2]);
                        add(&mut rows[3][c], &across[0][j], &bend);
                        add(&mut rows[4][c], &across[1][j], &slope);
                        add(&mut rows[5][c], &across[2][j], &value);
                    }
                }
            }
        }
        rows
    }
}

/// Row `j` of the control points of every lane, combined.
#[inline(always)]
fn line<T: Real>(points: &[[T; WIDTH]; LANES], j: usize, basis: &[[T; WIDTH]; 4]) -> [T; WIDTH] {
    let mut sum = [T::default(); WIDTH];
    for k in 0..WIDTH {
        sum[k] = basis[0][k] * points[4 * j][k];
    }
    for i in 1..4 {
        for k in 0..WIDTH {
            sum[k] = sum[k] + basis[i][k] * points[4 * j + i][k];
        }
    }
    sum
}
