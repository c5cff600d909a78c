//! Control points as dense rows, and sums of such rows: `W` numbers to a vector. Rows are either weights over a plan's ring or the
//! components of values at the control points of one face.

use super::super::points::Points;
use super::region::Row;
use crate::kernel::{LANES, SurfaceMatrix, vectorized};
use crate::limit::rows::Rows;
use crate::real::Real;

/// Numbers of a vector of weights; rows are filled up to a multiple.
pub(super) const WIDTH: usize = 8;

/// Control points of a node or leaf: some rows of a matrix.
#[derive(Clone, Copy)]
pub(super) struct Control<'m, const W: usize> {
    pub matrix: &'m [[f64; W]],
    /// Which rows; all where there is no list.
    pub some: Option<&'m [u32]>,
    /// How the parameters lie in the face.
    pub jacobian: Jacobian,
    /// How many times the face has been halved.
    pub depth: u32,
}

impl<const W: usize> Control<'_, W> {
    #[inline(always)]
    pub fn row(&self, i: u32) -> usize {
        match self.some {
            Some(rows) => rows[i as usize] as usize,
            None => i as usize,
        }
    }
}

/// `∂s/∂u ∂t/∂u`, `∂s/∂v ∂t/∂v`.
pub(super) type Jacobian = [[f64; 2]; 2];

/// Where the rows of samples go.
pub(super) trait Target<const W: usize> {
    /// Vectors to a row.
    fn chunks(&self) -> usize;

    /// Takes some vectors of the rows of a sample, from vector `chunk` on: of position and, with a `count` of 3, of two derivatives
    /// in parameters that lie in the face as `jacobian` says.
    fn put<const K: usize>(
        &mut self,
        rows: &[[[f64; W]; K]; 3],
        chunk: usize,
        number: u32,
        jacobian: Jacobian,
        count: usize,
    );
}

/// Where the weights of a plan go.
pub(super) struct Weights<'o, T> {
    pub out: &'o mut SurfaceMatrix<T>,
    pub ring: usize,
}

pub(super) fn product(a: Jacobian, b: Jacobian) -> Jacobian {
    let entry = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j];
    [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
}

#[inline(always)]
pub(super) fn add<const W: usize>(sum: &mut [f64; W], w: f64, row: &[f64; W]) {
    for l in 0..W {
        sum[l] += w * row[l];
    }
}

/// Some refined points; all, where none is listed.
pub(super) fn refine<const W: usize>(
    control: Control<'_, W>,
    points: &Points,
    some: &[u32],
    chunks: usize,
    out: &mut [[f64; W]],
) {
    vectorized(
        #[inline(always)]
        || {
            if some.is_empty() {
                for (point, out) in out.chunks_exact_mut(chunks).take(points.len()).enumerate() {
                    sum_terms(control, points.terms(point), chunks, out);
                }
            }
            for &point in some {
                let terms = points.terms(point as usize);
                sum_terms(control, terms, chunks, &mut out[point as usize * chunks..]);
            }
        },
    );
}

/// All points of some rows.
pub(super) fn combine<const W: usize>(control: Control<'_, W>, rows: &Rows, chunks: usize, out: &mut [[f64; W]]) {
    vectorized(
        #[inline(always)]
        || match rows.selected() {
            // Most leaves take their points as they are.
            Some(columns) => {
                for (out, &c) in out.chunks_exact_mut(chunks).zip(columns) {
                    let from = &control.matrix[control.row(c) * chunks..][..chunks];
                    for (out, from) in out.iter_mut().zip(from) {
                        *out = *from;
                    }
                }
            }
            None => {
                for i in 0..rows.len() {
                    sum_terms(control, rows.terms(i), chunks, &mut out[i * chunks..]);
                }
            }
        },
    );
}

#[inline(always)]
fn sum_terms<const W: usize>(
    control: Control<'_, W>,
    (columns, weights): (&[u32], &[f64]),
    chunks: usize,
    out: &mut [[f64; W]],
) {
    let mut chunk = 0;
    while chunk < chunks {
        // Some vectors at once, so that terms are read less often.
        if chunk + 3 <= chunks {
            let sums = terms_of::<W, 3>(control, columns, weights, chunks, chunk);
            out[chunk..chunk + 3].copy_from_slice(&sums);
            chunk += 3;
        } else {
            out[chunk] = terms_of::<W, 1>(control, columns, weights, chunks, chunk)[0];
            chunk += 1;
        }
    }
}

#[inline(always)]
fn terms_of<const W: usize, const K: usize>(
    control: Control<'_, W>,
    columns: &[u32],
    weights: &[f64],
    chunks: usize,
    chunk: usize,
) -> [[f64; W]; K] {
    let mut sums = [[0.0; W]; K];
    for (&c, &w) in columns.iter().zip(weights) {
        let at = control.row(c) * chunks + chunk;
        if K == 1 {
            add(&mut sums[0], w, &control.matrix[at]);
            continue;
        }
        let from = &control.matrix[at..at + K];
        for k in 0..K {
            add(&mut sums[k], w, &from[k]);
        }
    }
    sums
}

/// Samples of a row, `outer` being the weights there and `inner` those at all lines of equal u: `K` vectors of their rows.
#[inline(always)]
pub(super) fn run_of<const W: usize, const K: usize, const COUNT: usize>(
    run: Row<'_>,
    outer: &[[f64; 4]; 3],
    inner: &[[[f64; 4]; 3]],
    control: Control<'_, W>,
    chunk: usize,
    target: &mut impl Target<W>,
) {
    let chunks = target.chunks();
    // Control points of the curve along the run, and of its derivative across.
    let mut line = [[[[0.0; W]; K]; 4]; 2];
    for x in 0..4 {
        for y in 0..4 {
            let from = &control.matrix[(4 * y + x) * chunks + chunk..][..K];
            for k in 0..K {
                add(&mut line[0][x][k], outer[0][y], &from[k]);
                if COUNT == 3 {
                    add(&mut line[1][x][k], outer[1][y], &from[k]);
                }
            }
        }
    }
    run.each(
        #[inline(always)]
        |number, u| {
            let inner = &inner[u as usize];
            let mut rows = [[[0.0; W]; K]; 3];
            for x in 0..4 {
                for k in 0..K {
                    add(&mut rows[0][k], inner[0][x], &line[0][x][k]);
                    if COUNT == 3 {
                        add(&mut rows[1][k], inner[1][x], &line[0][x][k]);
                        add(&mut rows[2][k], inner[0][x], &line[1][x][k]);
                    }
                }
            }
            target.put(&rows, chunk, number, control.jacobian, COUNT);
        },
    );
}

impl<T: Real> Target<WIDTH> for Weights<'_, T> {
    fn chunks(&self) -> usize {
        self.ring.div_ceil(WIDTH)
    }

    #[inline(always)]
    fn put<const K: usize>(
        &mut self,
        rows: &[[[f64; WIDTH]; K]; 3],
        chunk: usize,
        number: u32,
        jacobian: Jacobian,
        count: usize,
    ) {
        let first = chunk * WIDTH;
        let len = (self.ring - first).min(K * WIDTH);
        let rows = [rows[0].as_flattened(), rows[1].as_flattened(), rows[2].as_flattened()];
        self.write(rows, first, len, number, jacobian, count);
    }
}

impl<T: Real> Weights<'_, T> {
    /// Writes the weights of `len` points of the ring from `first` on.
    #[inline(always)]
    pub fn write(
        &mut self,
        rows: [&[f64]; 3],
        first: usize,
        len: usize,
        number: u32,
        jacobian: Jacobian,
        count: usize,
    ) {
        let (block, lane) = (number as usize / LANES, number as usize % LANES);
        let out = &mut self.out.block_mut(block)[first * count..(first + len) * count];
        if count == 1 {
            for (out, &w) in out.iter_mut().zip(rows[0]) {
                out[lane] = T::from_f64(w);
            }
            return;
        }
        let [u, v] = jacobian;
        let (position, s, t) = (&rows[0][..len], &rows[1][..len], &rows[2][..len]);
        for (p, out) in out.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            out[0][lane] = T::from_f64(position[p]);
            out[1][lane] = T::from_f64(u[0] * s[p] + u[1] * t[p]);
            out[2][lane] = T::from_f64(v[0] * s[p] + v[1] * t[p]);
        }
    }
}
