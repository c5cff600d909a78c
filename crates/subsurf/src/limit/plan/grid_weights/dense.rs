//! Control points as dense rows of numbers over a plan's ring, and sums of such rows, eight numbers to a vector.

use super::super::points::Points;
use crate::kernel::{LANES, SurfaceMatrix, vectorized};
use crate::limit::rows::Rows;
use crate::real::Real;

/// Numbers of a vector of `f64`; rows are filled up to a multiple.
pub(super) const WIDTH: usize = 8;

/// A grid point in the parameters of a node, and its number among those that are wanted.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub number: u32,
    pub at: [u32; 2],
}

/// Control points of a node or leaf over the plan's ring: some rows of a matrix.
#[derive(Clone, Copy)]
pub(super) struct Control<'m> {
    pub matrix: &'m [[f64; WIDTH]],
    /// Which rows; all where there is no list.
    pub some: Option<&'m [u32]>,
    /// How the parameters lie in the face.
    pub jacobian: Jacobian,
    /// How many times the face has been halved.
    pub depth: u32,
}

impl Control<'_> {
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

/// Where the weights of a plan go.
pub(super) struct Target<'o, T> {
    pub out: &'o mut SurfaceMatrix<T>,
    pub ring: usize,
    /// Vectors to a row.
    pub chunks: usize,
}

pub(super) fn product(a: Jacobian, b: Jacobian) -> Jacobian {
    let entry = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j];
    [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
}

#[inline(always)]
pub(super) fn add(sum: &mut [f64; WIDTH], w: f64, row: &[f64; WIDTH]) {
    for l in 0..WIDTH {
        sum[l] += w * row[l];
    }
}

/// Some refined points over the ring.
pub(super) fn refine(control: Control<'_>, points: &Points, some: &[u32], chunks: usize, out: &mut [[f64; WIDTH]]) {
    vectorized(
        #[inline(always)]
        || {
            for &point in some {
                let terms = points.terms(point as usize);
                sum_terms(control, terms, chunks, &mut out[point as usize * chunks..]);
            }
        },
    );
}

/// All points of some rows over the ring.
pub(super) fn combine(control: Control<'_>, rows: &Rows, chunks: usize, out: &mut [[f64; WIDTH]]) {
    vectorized(
        #[inline(always)]
        || {
            for i in 0..rows.len() {
                sum_terms(control, rows.terms(i), chunks, &mut out[i * chunks..]);
            }
        },
    );
}

#[inline(always)]
fn sum_terms(control: Control<'_>, (columns, weights): (&[u32], &[f64]), chunks: usize, out: &mut [[f64; WIDTH]]) {
    let mut chunk = 0;
    while chunk < chunks {
        // Some vectors at once, so that terms are read less often.
        if chunk + 3 <= chunks {
            let sums = terms_of::<3>(control, columns, weights, chunks, chunk);
            out[chunk..chunk + 3].copy_from_slice(&sums);
            chunk += 3;
        } else {
            out[chunk] = terms_of::<1>(control, columns, weights, chunks, chunk)[0];
            chunk += 1;
        }
    }
}

#[inline(always)]
fn terms_of<const K: usize>(
    control: Control<'_>,
    columns: &[u32],
    weights: &[f64],
    chunks: usize,
    chunk: usize,
) -> [[f64; WIDTH]; K] {
    let mut sums = [[0.0; WIDTH]; K];
    for (&c, &w) in columns.iter().zip(weights) {
        let at = control.row(c) * chunks + chunk;
        let from = &control.matrix[at..at + K];
        for k in 0..K {
            add(&mut sums[k], w, &from[k]);
        }
    }
    sums
}

/// Samples of equal v, `outer` being the weights there and `inner` those at all lines of equal u: `K` vectors of their rows.
#[inline(always)]
pub(super) fn run_of<T: Real, const K: usize, const COUNT: usize>(
    run: &[Sample],
    outer: &[[f64; 4]; 3],
    inner: &[[[f64; 4]; 3]],
    control: Control<'_>,
    chunk: usize,
    target: &mut Target<'_, T>,
) {
    // Control points of the curve along the run, and of its derivative across.
    let mut line = [[[[0.0; WIDTH]; K]; 4]; 2];
    for x in 0..4 {
        for y in 0..4 {
            let from = &control.matrix[(4 * y + x) * target.chunks + chunk..][..K];
            for k in 0..K {
                add(&mut line[0][x][k], outer[0][y], &from[k]);
                if COUNT == 3 {
                    add(&mut line[1][x][k], outer[1][y], &from[k]);
                }
            }
        }
    }
    for sample in run {
        let inner = &inner[sample.at[0] as usize];
        let mut rows = [[[0.0; WIDTH]; K]; 3];
        for x in 0..4 {
            for k in 0..K {
                add(&mut rows[0][k], inner[0][x], &line[0][x][k]);
                if COUNT == 3 {
                    add(&mut rows[1][k], inner[1][x], &line[0][x][k]);
                    add(&mut rows[2][k], inner[0][x], &line[1][x][k]);
                }
            }
        }
        put_chunks(&rows, chunk, sample.number, control.jacobian, COUNT, target);
    }
}

/// Writes some vectors of the rows of a sample.
#[inline(always)]
pub(super) fn put_chunks<T: Real, const K: usize>(
    rows: &[[[f64; WIDTH]; K]; 3],
    chunk: usize,
    number: u32,
    jacobian: Jacobian,
    count: usize,
    target: &mut Target<'_, T>,
) {
    let first = chunk * WIDTH;
    let len = (target.ring - first).min(K * WIDTH);
    target.put(
        [rows[0].as_flattened(), rows[1].as_flattened(), rows[2].as_flattened()],
        first,
        len,
        number,
        jacobian,
        count,
    );
}

impl<T: Real> Target<'_, T> {
    /// Writes the weights of `len` points of the ring from `first` on.
    #[inline(always)]
    pub fn put(&mut self, rows: [&[f64]; 3], first: usize, len: usize, number: u32, jacobian: Jacobian, count: usize) {
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
