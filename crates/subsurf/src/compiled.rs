//! Work that is compiled with this crate, once per precision, and not again with every crate that calls it. What is called from
//! here is generic, so that by itself it would be compiled wherever it is called: half a minute for a program of ten lines,
//! each time one of them changes. Rows of three numbers go through here, and pairs where they are refined; other widths are compiled
//! by the caller.

use crate::limit::{Exceptional, Jet, LimitSurface, Location, PatchTable, Places, Sampler};
use crate::refine::{Level, UniformRefinement};
use crate::shading::ShadingNormals;
use crate::stencil::{
    Csr, LimitStencilOptions, LimitStencilTable, PlaceOf, StencilError, StencilOptions, StencilTable, limit_rows,
    refined,
};
use crate::tessellate::{Frames, Layout, TessellateError, TessellateOptions, Tessellator, channel, tessellator};

/// Rows of `N` numbers as the rows of `M` that they are.
pub(crate) fn as_rows<T, const N: usize, const M: usize>(rows: &[[T; N]]) -> &[[T; M]] {
    assert_eq!(N, M, "rows keep their width");
    rows.as_flattened().as_chunks().0
}

/// The same to write to.
pub(crate) fn as_rows_mut<T, const N: usize, const M: usize>(rows: &mut [[T; N]]) -> &mut [[T; M]] {
    assert_eq!(N, M, "rows keep their width");
    rows.as_flattened_mut().as_chunks_mut().0
}

/// A row of three numbers as the row of `N` that it is.
pub(crate) fn row_of_three<const N: usize>(row: [f64; 3]) -> [f64; N] {
    assert_eq!(N, 3, "rows keep their width");
    std::array::from_fn(|k| row[k])
}

/// Positions and derivatives of a batch of places, by how many vectors each has.
pub enum JetRows<'a, T> {
    Positions(&'a mut [[[T; 3]; 1]]),
    First(&'a mut [[[T; 3]; 3]]),
    Second(&'a mut [[[T; 3]; 6]]),
}

impl<'a, T> JetRows<'a, T> {
    pub(crate) fn new<const N: usize, const R: usize>(rows: &'a mut [[[T; N]; R]]) -> Self {
        let vectors = as_rows_mut(rows.as_flattened_mut());
        match R {
            1 => Self::Positions(vectors.as_chunks_mut().0),
            3 => Self::First(vectors.as_chunks_mut().0),
            6 => Self::Second(vectors.as_chunks_mut().0),
            _ => unreachable!("rows have 1, 3 or 6 vectors"),
        }
    }
}

/// What stencils give: positions, first derivatives, both, or second derivatives.
pub enum SumRows<'a, T> {
    Positions(&'a mut [[[T; 3]; 1]]),
    First(&'a mut [[[T; 3]; 2]]),
    Frames(&'a mut [[[T; 3]; 3]]),
    Second(&'a mut [[[T; 3]; 3]]),
}

impl<'a, T> SumRows<'a, T> {
    pub(crate) fn new<const N: usize, const K: usize, const FIRST_IS_POSITION: bool>(
        rows: &'a mut [[[T; N]; K]],
    ) -> Self {
        let vectors = as_rows_mut(rows.as_flattened_mut());
        match (K, FIRST_IS_POSITION) {
            (1, true) => Self::Positions(vectors.as_chunks_mut().0),
            (2, false) => Self::First(vectors.as_chunks_mut().0),
            (3, true) => Self::Frames(vectors.as_chunks_mut().0),
            (3, false) => Self::Second(vectors.as_chunks_mut().0),
            _ => unreachable!("there are no such stencils"),
        }
    }
}

/// A list in one of the two precisions, by which a function that is generic in two sees that they are one.
#[derive(Clone, Copy)]
pub enum Numbers<'a> {
    Single(&'a [f32]),
    Double(&'a [f64]),
}

/// Lists that are all of one precision.
fn list_of<'a, T: CompiledHere>(lists: &[Numbers<'a>]) -> Option<Vec<&'a [T]>> {
    lists.iter().map(|&list| T::compiled_of_numbers(list)).collect()
}

macro_rules! compiled {
    ($($(#[$attribute:meta])* fn $name:ident $(<$life:lifetime>)? ($($argument:ident: $of:ty),* $(,)?) $(-> $result:ty)? { $body:expr })*) => {
        /// What [`Real`](crate::Real) numbers bring with them, for points of these numbers; no part of the public interface.
        #[doc(hidden)]
        pub trait CompiledHere: Sized {
            fn compiled_numbers(list: &[Self]) -> Numbers<'_>;
            fn compiled_of_numbers(numbers: Numbers<'_>) -> Option<&[Self]>;
            $($(#[$attribute])* fn $name $(<$life>)? ($($argument: $of),*) $(-> $result)?;)*
        }

        compiled!(@of [f32] Single { $(fn $name $(<$life>)? ($($argument: $of),*) $(-> $result)? { $body })* });
        compiled!(@of [f64] Double { $(fn $name $(<$life>)? ($($argument: $of),*) $(-> $result)? { $body })* });
    };
    (@of [$number:ty] $variant:ident { $($function:item)* }) => {
        impl CompiledHere for $number {
            fn compiled_numbers(list: &[Self]) -> Numbers<'_> {
                Numbers::$variant(list)
            }
            fn compiled_of_numbers(numbers: Numbers<'_>) -> Option<&[Self]> {
                if let Numbers::$variant(list) = numbers { Some(list) } else { None }
            }
            $($function)*
        }
    };
}

compiled! {
    fn compiled_tessellator<'a>(
        table: &'a PatchTable,
        points: &[[Self; 3]],
        options: &TessellateOptions,
        frames: Frames,
    ) -> Result<(Tessellator<'a, Self>, Vec<u8>), TessellateError> {
        tessellator::prepare(table, points, options, frames)
    }

    fn compiled_tessellate(
        tessellator: &Tessellator<'_, Self>,
        surface: LimitSurface<'_, Self, 3>,
        shading: Option<&ShadingNormals<'_>>,
        points: &mut [[Self; 3]],
        normals: &mut [[Self; 3]],
    ) {
        tessellator.fill(surface, shading, points, normals)
    }

    fn compiled_channel(layout: &Layout<'_>, surface: LimitSurface<'_, Self, 3>, out: &mut [[Self; 3]]) {
        channel::fill(layout, surface, out)
    }

    /// The first `count` vectors of the jet: 3 or 6.
    fn compiled_jet(surface: &LimitSurface<'_, Self, 3>, at: Location, count: usize) -> Option<Jet<3>> {
        surface.jet_here(at, count)
    }

    fn compiled_position(surface: &LimitSurface<'_, Self, 3>, at: Location) -> Option<[f64; 3]> {
        surface.position_here(at)
    }

    fn compiled_batch(surface: &LimitSurface<'_, Self, 3>, at: &[Location], rows: JetRows<'_, Self>) -> Vec<Exceptional> {
        match rows {
            JetRows::Positions(rows) => surface.rows_into(at, rows),
            JetRows::First(rows) => surface.rows_into(at, rows),
            JetRows::Second(rows) => surface.rows_into(at, rows),
        }
    }

    /// Second derivatives too, with sums in `f64`.
    fn compiled_batch_in_f64(surface: &LimitSurface<'_, Self, 3>, at: &[Location], rows: &mut [[[f64; 3]; 6]]) -> Vec<Exceptional> {
        surface.rows_into(at, rows)
    }

    /// Places of one patch.
    fn compiled_patch_batch(
        sampler: &mut Sampler<Self>,
        surface: &LimitSurface<'_, Self, 3>,
        places: &Places<Self>,
        rows: JetRows<'_, Self>,
    ) {
        match rows {
            JetRows::Positions(rows) => sampler.run(surface, places, rows),
            JetRows::First(rows) => sampler.run(surface, places, rows),
            JetRows::Second(rows) => sampler.run(surface, places, rows),
        }
    }

    fn compiled_refine(refinement: &UniformRefinement, values: &[[Self; 3]], out: &mut [[Self; 3]]) {
        refinement.fill(values, out)
    }

    /// Texture coordinates.
    fn compiled_refine_pairs(refinement: &UniformRefinement, values: &[[Self; 2]], out: &mut [[Self; 2]]) {
        refinement.fill(values, out)
    }

    fn compiled_stencils(control: &Level, depth: u32, options: &StencilOptions) -> Result<(Csr, Vec<Self>), StencilError> {
        refined::rows(control, depth, options)
    }

    fn compiled_limit_stencils(
        patches: &PatchTable,
        count: usize,
        place: PlaceOf<'_>,
        refined: Option<&StencilTable<f64>>,
        options: &LimitStencilOptions,
    ) -> Result<LimitStencilTable<Self>, StencilError> {
        limit_rows::build(patches, count, place, refined, options)
    }

    /// Sums of all rows, or of some alone, with weights in the precision of the points or in `f64`.
    fn compiled_sums(
        rows: &Csr,
        weights: &[Numbers<'_>],
        control: &[[Self; 3]],
        some: Option<&[u32]>,
        out: SumRows<'_, Self>,
    ) {
        match list_of::<Self>(weights) {
            Some(weights) => rows.sums(&weights, control, some, out),
            None => rows.sums(&list_of::<f64>(weights).expect("weights are no narrower than points"), control, some, out),
        }
    }
}
