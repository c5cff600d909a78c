//! Stencils: refined and limit points as weighted sums of control points, tabulated once per connectivity and applied
//! to any attribute, whole or only where control points have changed.
//!
//! Masks are composed in dense rows over the ring of a control face, once for all faces with equal surroundings, and
//! then written out as sparse rows, straight into their places.

mod csr;
mod dependents;
mod level_by_level;
mod limit;
pub(crate) mod limit_rows;
pub(crate) mod refined;
mod sums;

pub use dependents::Dependents;
pub use limit::{LimitStencilOptions, LimitStencilTable, Orders, Part};

use crate::mesh::{MAX_COUNT, MeshError};
use crate::real::Real;
use crate::refine::{Level, Parent};
pub(crate) use csr::Csr;
pub(crate) use limit_rows::PlaceOf;
use thiserror::Error;

/// What to tabulate, and how much at most.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct StencilOptions {
    /// Rows for all levels from the first to the last, one after another, rather than for the last alone.
    pub all_levels: bool,
    /// Most weights to make; more are an error before any is made. They are counted generously, as if no weight over a
    /// face's ring were zero. A weight takes 12 bytes in `f64` and 8 in `f32`, its index included.
    pub most_weights: usize,
}

impl Default for StencilOptions {
    fn default() -> Self {
        Self { all_levels: false, most_weights: MAX_COUNT }
    }
}

/// Why a table could not be made.
#[derive(Clone, PartialEq, Debug, Error)]
#[non_exhaustive]
pub enum StencilError {
    /// A level does not fit into 32-bit indices, or a mesh has vertices of more faces than memory is for.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// More weights than allowed, or than 32 bits can count.
    #[error("the stencils would have {count} weights; at most {limit} are possible here: use fewer levels or places")]
    TooLarge {
        /// How many there would be.
        count: u64,
        /// How many there may be.
        limit: u64,
    },
}

/// The vertices of a refinement as weighted sums of control points: row `i` is vertex `i`, in the order of refinement.
///
/// Weights are computed in `f64`, from the same masks as refinement itself, and rounded once to `W`. No weight is left
/// out but zeros; every row sums to one.
///
/// ```
/// use subsurf::{Level, Scheme, StencilTable, shapes};
///
/// let cube = shapes::cube();
/// let control = Level::new(&cube.mesh, Scheme::CatmullClark)?;
/// let table = StencilTable::<f64>::new(&control, 3)?; // once per connectivity
/// let refined = table.apply(&cube.positions); // once per frame, of any attribute
/// assert_eq!(refined.len(), 386);
/// # Ok::<(), subsurf::StencilError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct StencilTable<W> {
    rows: Csr,
    weights: Vec<W>,
}

impl<W: Real> StencilTable<W> {
    /// The table of the level `depth` refinements below `control`, whose vertices are the control points.
    ///
    /// # Errors
    /// [`StencilError::Mesh`] where a level overflows 32-bit indices or a vertex has more than some 10,000 faces,
    /// [`StencilError::TooLarge`] where the weights overflow.
    pub fn new(control: &Level, depth: u32) -> Result<Self, StencilError> {
        Self::with_options(control, depth, &StencilOptions::default())
    }

    /// The same with a choice of levels and a bound on memory. Level 0 is not among [`all_levels`](StencilOptions), so
    /// that a depth of 0 then gives no rows; the level itself has one weight of 1 per vertex.
    ///
    /// # Errors
    /// As [`StencilTable::new`].
    pub fn with_options(control: &Level, depth: u32, options: &StencilOptions) -> Result<Self, StencilError> {
        let (rows, weights) = W::compiled_stencils(control, depth, options)?;
        Ok(Self { rows, weights })
    }

    /// The same where the levels are at hand already: the first is that of the control points, each other one the
    /// [`refinement`](Level::refine) of the one before, and the table is that of the vertices of the last.
    ///
    /// # Errors
    /// As [`StencilTable::new`].
    ///
    /// # Panics
    /// If there are no levels, or one is not a refinement of the one before.
    pub fn of_levels(levels: &[Level], options: &StencilOptions) -> Result<Self, StencilError> {
        for pair in levels.windows(2) {
            let (t, scheme) = (pair[0].topology(), pair[0].scheme());
            let expected = (scheme, pair[0].depth() + 1, Parent::count(t, scheme));
            let same = (pair[1].scheme(), pair[1].depth(), pair[1].topology().vertex_count());
            assert_eq!(same, expected, "a level is the refinement of the one before");
        }
        let control = levels.first().expect("no levels are given");
        let (rows, weights) = W::compiled_stencils(control, levels.len() as u32 - 1, options)?;
        Ok(Self { rows, weights })
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// True where there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of control points.
    pub fn control_points(&self) -> usize {
        self.rows.control_points
    }

    /// Start of every row in [`indices`](Self::indices) and [`weights`](Self::weights), and the end of the last one.
    pub fn offsets(&self) -> &[u32] {
        &self.rows.offsets
    }

    /// The control points of all rows, ascending within a row.
    pub fn indices(&self) -> &[u32] {
        &self.rows.indices
    }

    /// The weights of all rows.
    pub fn weights(&self) -> &[W] {
        &self.weights
    }

    /// Control points and weights of one row.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn row(&self, row: usize) -> (&[u32], &[W]) {
        let range = self.rows.range(row);
        (&self.rows.indices[range.clone()], &self.weights[range])
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        self.rows.bytes() + size_of_val(&self.weights[..])
    }

    /// The refined values, one per row, in parallel. Sums are formed in the wider of `T` and `W`, relative to the row's first
    /// control point, so that constants come out exactly and rounded weights cost nothing far from the origin: in `f32` a row
    /// of n terms is right to n + 4 half units in the last place of how far its control points lie apart, and one of the
    /// result.
    ///
    /// # Panics
    /// If `control` has not one value per control point.
    pub fn apply<T: Real, const N: usize>(&self, control: &[[T; N]]) -> Vec<[T; N]> {
        let mut out = vec![[T::default(); N]; self.len()];
        self.apply_into(control, &mut out);
        out
    }

    /// [`apply`](Self::apply) into memory that is at hand.
    ///
    /// # Panics
    /// If `control` has not one value per control point, or `out` not one per row.
    pub fn apply_into<T: Real, const N: usize>(&self, control: &[[T; N]], out: &mut [[T; N]]) {
        self.rows.apply_into::<W, T, N, 1, true>([&self.weights], control, out.as_chunks_mut().0);
    }

    /// Which rows depend on which control points, for [`update`](Self::update).
    pub fn dependents(&self) -> Dependents {
        Dependents::new(&self.rows)
    }

    /// Recomputes the rows of `out` that depend on the `changed` control points, and returns which those are, ascending.
    /// The result has the same bits as that of [`apply`](Self::apply) if `out` had before the change.
    ///
    /// # Panics
    /// If `control` has not one value per control point, `out` not one per row, a changed point does not exist, or
    /// `dependents` belongs to another table.
    pub fn update<T: Real, const N: usize>(
        &self,
        dependents: &Dependents,
        control: &[[T; N]],
        changed: &[u32],
        out: &mut [[T; N]],
    ) -> Vec<u32> {
        let moved = dependents.of_all(changed);
        self.rows.update::<W, T, N, 1, true>([&self.weights], control, &moved, out.as_chunks_mut().0);
        moved
    }
}
