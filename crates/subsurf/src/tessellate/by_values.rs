//! Samples of a face without a pattern: down its patch tree with the values at its control points, in `f64`. A pattern
//! would have to be made first, with dozens of weights where a sample has a few components.

use super::evaluate::Evaluator;
use super::selection::Selection;
use crate::kernel::{LANES, Samples, unit_normals_of};
use crate::limit::plan::{GridMaker, GridScratch, GridValues};
use crate::real::{Real, round};

/// What part of the extent of a face's control points counts beside its derivatives where many faces meet: there faces are thin, and
/// by itself a sample would be evaluated the same way. Larger: all control points refined again for thin faces, at poles of 300 faces
/// and more; smaller: at 1e-9, normals from derivatives that are rounding.
const AT_POLES: f64 = 1e-3;

/// Memory that is used again.
#[derive(Default)]
pub(super) struct ValueMemory {
    /// For up to four components, and for more.
    narrow: Rows<4>,
    wide: Rows<8>,
    derivatives: Vec<[[[f64; LANES]; 3]; 2]>,
}

#[derive(Default)]
struct Rows<const W: usize> {
    control: Vec<[f64; W]>,
    grid: GridScratch<W>,
}

impl<T: Real, const N: usize> Evaluator<'_, T, N> {
    /// Evaluates samples of a patch; true where some normals are to be had otherwise.
    pub(super) fn by_values(
        &self,
        maker: &GridMaker<'_>,
        patch: usize,
        selection: &Selection,
        memory: &mut ValueMemory,
        out: Samples<'_, T, N>,
    ) -> bool {
        let ValueMemory { narrow, wide, derivatives } = memory;
        if self.sampler.with_normals() {
            derivatives.resize(selection.samples.blocks(), [[[0.0; LANES]; 3]; 2]);
        }
        let Samples { points, normals, unsure } = out;
        let extent = match N {
            0..=4 => self.in_rows(maker, patch, selection, narrow, points, derivatives),
            _ => self.in_rows(maker, patch, selection, wide, points, derivatives),
        };
        if !self.sampler.with_normals() {
            return false;
        }
        let table = self.sampler.layout().table;
        let is_wide = table.patch_plan(patch).is_some_and(|plan| table.plan(plan).is_wide());
        let extent = if is_wide { AT_POLES * extent } else { extent };
        let mut any = 0;
        for (b, ([du, dv], normals)) in derivatives.iter().zip(normals.chunks_mut(LANES)).enumerate() {
            let mut unit = [[0.0; 3]; LANES];
            let bits = unit_normals_of(du, dv, &[extent; LANES], &mut unit);
            normals.iter_mut().zip(unit).for_each(|(out, n)| *out = round(n));
            // The last block may be filled up.
            unsure[b] = bits & u32::MAX >> (32 - (selection.samples.len() - b * LANES).min(LANES) as u32);
            any |= unsure[b];
        }
        any != 0
    }

    /// Points and derivatives, in vectors of `W` numbers; the largest component of a control point relative to the first.
    fn in_rows<const W: usize>(
        &self,
        maker: &GridMaker<'_>,
        patch: usize,
        selection: &Selection,
        rows: &mut Rows<W>,
        points: &mut [[T; N]],
        derivatives: &mut [[[[f64; LANES]; 3]; 2]],
    ) -> f64 {
        let table = self.sampler.layout().table;
        let plan = table.patch_plan(patch).expect("holes have no samples");
        let numbers = table.ring_of(patch, table.plan(plan).ring());
        let control = self.sampler.surface().points();
        let base = control[numbers[0] as usize].map(T::to_f64);
        let vectors = N.div_ceil(W);
        rows.control.resize(numbers.len() * vectors, [0.0; W]);
        let mut extent = 0.0f64;
        for (row, &number) in rows.control.chunks_exact_mut(vectors).zip(numbers) {
            let point = &control[number as usize];
            for c in 0..N {
                let x = point[c].to_f64() - base[c];
                row[c / W][c % W] = x;
                extent = extent.max(x.abs());
            }
        }
        let mut out = GridValues { base, points, derivatives };
        maker.evaluate(plan, &rows.control, &selection.points, &mut rows.grid, &mut out);
        extent
    }
}
