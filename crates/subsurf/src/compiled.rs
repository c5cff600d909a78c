//! Work that is compiled with this crate, once per precision, and not again with every crate that calls it. What is called from
//! here is generic, so that by itself it would be compiled wherever it is called: half a minute for a program of ten lines,
//! each time one of them changes. Points are what nearly all callers have; rows of other numbers of components are compiled by the
//! caller, but for refined pairs.

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
    debug_assert_eq!(N, M);
    rows.as_flattened().as_chunks().0
}

/// The same to write to.
pub(crate) fn as_rows_mut<T, const N: usize, const M: usize>(rows: &mut [[T; N]]) -> &mut [[T; M]] {
    debug_assert_eq!(N, M);
    rows.as_flattened_mut().as_chunks_mut().0
}

/// A row of three numbers as the row of `N` that it is.
pub(crate) fn row_of_three<const N: usize>(row: [f64; 3]) -> [f64; N] {
    debug_assert_eq!(N, 3);
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
            _ => Self::Second(vectors.as_chunks_mut().0),
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
            (1, _) => Self::Positions(vectors.as_chunks_mut().0),
            (2, _) => Self::First(vectors.as_chunks_mut().0),
            (_, true) => Self::Frames(vectors.as_chunks_mut().0),
            (_, false) => Self::Second(vectors.as_chunks_mut().0),
        }
    }
}

/// A list in one of the two precisions.
#[derive(Clone, Copy)]
pub enum Numbers<'a> {
    Single(&'a [f32]),
    Double(&'a [f64]),
}

macro_rules! compiled {
    ($($(#[$attribute:meta])* fn $name:ident $(<$life:lifetime>)? ($($argument:ident: $of:ty),* $(,)?) $(-> $result:ty)? { $body:expr })*) => {
        /// What [`Real`](crate::Real) numbers bring with them, for points of these numbers.
        #[doc(hidden)]
        pub trait CompiledHere: Sized {
            fn numbers(list: &[Self]) -> Numbers<'_>;
            fn of_numbers(numbers: Numbers<'_>) -> Option<&[Self]>;
            $($(#[$attribute])* fn $name $(<$life>)? ($($argument: $of),*) $(-> $result)?;)*
        }

        compiled!(@of [f32] Single { $(fn $name $(<$life>)? ($($argument: $of),*) $(-> $result)? { $body })* });
        compiled!(@of [f64] Double { $(fn $name $(<$life>)? ($($argument: $of),*) $(-> $result)? { $body })* });
    };
    (@of [$number:ty] $variant:ident { $($function:item)* }) => {
        impl CompiledHere for $number {
            fn numbers(list: &[Self]) -> Numbers<'_> {
                Numbers::$variant(list)
            }
            fn of_numbers(numbers: Numbers<'_>) -> Option<&[Self]> {
                if let Numbers::$variant(list) = numbers { Some(list) } else { None }
            }
            $($function)*
        }
    };
}

compiled! {
    fn tessellator<'a>(
        table: &'a PatchTable,
        points: &[[Self; 3]],
        options: &TessellateOptions,
        frames: Frames,
    ) -> Result<(Tessellator<'a, Self>, Vec<u8>), TessellateError> {
        tessellator::prepare(table, points, options, frames)
    }

    fn tessellate(
        tessellator: &Tessellator<'_, Self>,
        surface: LimitSurface<'_, Self, 3>,
        shading: Option<&ShadingNormals<'_>>,
        points: &mut [[Self; 3]],
        normals: &mut [[Self; 3]],
    ) {
        tessellator.fill(surface, shading, points, normals)
    }

    fn channel(layout: &Layout<'_>, surface: LimitSurface<'_, Self, 3>, out: &mut [[Self; 3]]) {
        channel::fill(layout, surface, out)
    }

    /// `rows` vectors of the jet: 3 or 6.
    fn jet(surface: &LimitSurface<'_, Self, 3>, at: Location, rows: usize) -> Option<Jet<3>> {
        surface.jet(at, rows)
    }

    fn position(surface: &LimitSurface<'_, Self, 3>, at: Location) -> Option<[f64; 3]> {
        surface.position_alone(at)
    }

    fn rows(surface: &LimitSurface<'_, Self, 3>, at: &[Location], rows: JetRows<'_, Self>) -> Vec<Exceptional> {
        match rows {
            JetRows::Positions(rows) => surface.rows_into(at, rows),
            JetRows::First(rows) => surface.rows_into(at, rows),
            JetRows::Second(rows) => surface.rows_into(at, rows),
        }
    }

    /// Second derivatives too, with sums in `f64`.
    fn wide_rows(surface: &LimitSurface<'_, Self, 3>, at: &[Location], rows: &mut [[[f64; 3]; 6]]) -> Vec<Exceptional> {
        surface.rows_into(at, rows)
    }

    /// Places of one patch.
    fn run(
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

    fn refine(refinement: &UniformRefinement, values: &[[Self; 3]], out: &mut [[Self; 3]]) {
        refinement.fill(values, out)
    }

    /// Texture coordinates.
    fn refine_pairs(refinement: &UniformRefinement, values: &[[Self; 2]], out: &mut [[Self; 2]]) {
        refinement.fill(values, out)
    }

    fn stencils(control: &Level, depth: u32, options: &StencilOptions) -> Result<(Csr, Vec<Self>), StencilError> {
        refined::rows(control, depth, options)
    }

    fn limit_stencils(
        patches: &PatchTable,
        count: usize,
        place: PlaceOf<'_>,
        refined: Option<&StencilTable<f64>>,
        options: &LimitStencilOptions,
    ) -> Result<LimitStencilTable<Self>, StencilError> {
        limit_rows::build(patches, count, place, refined, options)
    }

    /// Sums of all rows, or of some alone, with weights in the precision of the points.
    fn sums(rows: &Csr, weights: &[&[Self]], control: &[[Self; 3]], some: Option<&[u32]>, out: SumRows<'_, Self>) {
        rows.sums(weights, control, some, out)
    }
}
