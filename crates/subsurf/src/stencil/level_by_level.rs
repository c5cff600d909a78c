//! Rows made level by level, from those of the level before: for meshes with faces whose surroundings are so many that a
//! pattern of weights would not pay.

use super::StencilError;
use super::StencilOptions;
use super::csr::{self, Csr};
use crate::mask::Mask;
use crate::real::Real;
use crate::refine::{Level, Parent, refined_point};
use rayon::prelude::*;

/// Rows that a thread takes at a time.
const CHUNK: usize = 1024;

/// Rows of one level: ends, control points in ascending order, weights.
#[derive(Default)]
struct Sparse {
    ends: Vec<usize>,
    terms: Vec<(u32, f64)>,
}

impl Sparse {
    fn row(&self, row: usize) -> &[(u32, f64)] {
        &self.terms[if row == 0 { 0 } else { self.ends[row - 1] }..self.ends[row]]
    }
}

/// Rows and weights of the levels that the options ask for, of level `depth` and the vertices of `control`.
pub(super) fn rows<W: Real>(
    control: &Level,
    depth: u32,
    options: &StencilOptions,
) -> Result<(Csr, Vec<W>), StencilError> {
    let control_points = control.topology().vertex_count();
    let mut level = control.clone();
    let mut rows =
        Sparse { ends: (1..=control_points).collect(), terms: (0..control_points as u32).map(|v| (v, 1.0)).collect() };
    let (mut offsets, mut indices, mut weights) = (vec![0], Vec::new(), Vec::new());
    for k in 1..=depth {
        rows = refined(&level, &rows, control_points, options.most_weights)?;
        if k == depth || options.all_levels {
            let start = indices.len();
            csr::check_count(start + rows.terms.len(), options.most_weights)?;
            offsets.extend(rows.ends.iter().map(|end| (start + end) as u32));
            indices.extend(rows.terms.iter().map(|term| term.0));
            weights.extend(rows.terms.iter().map(|term| W::from_f64(term.1)));
        }
        if k < depth {
            level = level.refine()?;
        }
    }
    Ok((Csr { offsets, indices, control_points }, weights))
}

/// Rows of the next level.
fn refined(level: &Level, before: &Sparse, control_points: usize, most: usize) -> Result<Sparse, StencilError> {
    let (t, scheme) = (level.topology(), level.scheme());
    let count = Parent::count(t, scheme);
    let chunks: Vec<Sparse> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map_init(
            || (Mask::default(), vec![0.0; control_points]),
            |(mask, sum), chunk| {
                let mut out = Sparse::default();
                let (mut terms, mut met) = (Vec::new(), Vec::new());
                for v in chunk * CHUNK..((chunk + 1) * CHUNK).min(count) {
                    terms.clear();
                    refined_point(t, scheme, Parent::of(t, scheme, v as u32), mask, &mut terms);
                    for &(u, weight) in &terms {
                        for &(point, x) in before.row(u as usize) {
                            // No mask has negative weights, so that a sum is zero only before its first term.
                            if sum[point as usize] == 0.0 {
                                met.push(point);
                            }
                            sum[point as usize] += weight * x;
                        }
                    }
                    met.sort_unstable();
                    out.terms.extend(met.drain(..).map(|point| (point, std::mem::take(&mut sum[point as usize]))));
                    out.ends.push(out.terms.len());
                }
                out
            },
        )
        .collect();
    csr::check_count(chunks.iter().map(|chunk| chunk.terms.len()).sum(), most)?;
    let mut out = Sparse::default();
    for chunk in chunks {
        let start = out.terms.len();
        out.ends.extend(chunk.ends.iter().map(|end| start + end));
        out.terms.extend_from_slice(&chunk.terms);
    }
    Ok(out)
}
