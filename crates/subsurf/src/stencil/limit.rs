//! Limit stencils: points and derivatives of the limit surface, at given places, as weighted sums of control points.

use super::csr::Csr;
use super::{Dependents, StencilError, StencilOptions, StencilTable};
use crate::limit::{Derivatives, Location, PatchTable};
use crate::mesh::MAX_COUNT;
use crate::real::Real;
use crate::refine::Level;

/// How far derivatives go.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub enum Orders {
    /// Positions alone.
    Position,
    /// Positions and first derivatives.
    #[default]
    First,
    /// Positions, first and second derivatives.
    Second,
}

/// One of the arrays of weights.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[allow(missing_docs)]
pub enum Part {
    Position,
    Du,
    Dv,
    Duu,
    Duv,
    Dvv,
}

/// What to tabulate at every place, and how much at most.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LimitStencilOptions {
    /// Which derivatives.
    pub orders: Orders,
    /// Most entries to make; more are an error before any is made. They are counted generously, as if no weight over a
    /// face's ring were zero. An entry takes four bytes and those of its weights, of which there are 1, 3 or 6.
    pub most_weights: usize,
}

impl Default for LimitStencilOptions {
    fn default() -> Self {
        Self { orders: Orders::First, most_weights: MAX_COUNT }
    }
}

/// Points of the limit surface as weighted sums of control points: row `i` is the `i`-th place. Positions and derivatives
/// share their lists of control points. Weights are computed in `f64`, as those of a
/// [`LimitSurface`](crate::LimitSurface) are, and rounded once to `W`.
///
/// Derivatives are with respect to the (u, v) of the place's face, as in a [`Jet`](crate::Jet). At a special vertex where
/// first derivatives vanish or diverge, the rows of `Du` and `Dv` are instead two directions that span the tangent plane
/// where there is one (`Jet::plane`), so that `du × dv` points along the normal there too; second derivatives do not
/// exist at special vertices, and their rows are zero. [`derivatives`](Self::derivatives) and
/// [`has_second`](Self::has_second) tell.
///
/// A place in a hole has no surface: its row is empty and everything applied to it is zero.
///
/// ```
/// use subsurf::{LimitStencilTable, Location, PatchTable, Scheme, shapes};
///
/// let cube = shapes::cube();
/// let patches = PatchTable::new(&cube.mesh, Scheme::CatmullClark).expect("a mesh");
/// let table = LimitStencilTable::<f64>::new(&patches, &[Location::new(0, 0.5, 0.5), Location::new(3, 0.1, 0.9)])?;
/// let points = table.positions(&cube.positions);
/// let [du, dv] = table.first_derivatives(&cube.positions)[1];
/// # let jet = patches.surface(&cube.positions).eval(Location::new(3, 0.1, 0.9)).unwrap();
/// # assert!((points[1][0] - jet.position[0]).abs() < 1e-15 && (du[1] - jet.du[1]).abs() + (dv[2] - jet.dv[2]).abs() < 1e-14);
/// # Ok::<(), subsurf::StencilError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LimitStencilTable<W> {
    pub(super) rows: Csr,
    /// Parallel to the indices; empty where the orders do not reach.
    pub(super) weights: [Vec<W>; 6],
    pub(super) states: Vec<State>,
}

/// What holds at a place.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum State {
    Hole,
    Smooth,
    SpecialVertex(Derivatives),
    /// A point of a refinement that no surface covers.
    Refined,
}

impl<W: Real> LimitStencilTable<W> {
    /// The table of positions and first derivatives at some places, in parallel.
    ///
    /// # Errors
    /// [`StencilError::TooLarge`] where the weights overflow 32-bit counts.
    ///
    /// # Panics
    /// If a location names no sub-face of the mesh, or its parameters lie outside the face.
    pub fn new(patches: &PatchTable, places: &[Location]) -> Result<Self, StencilError> {
        Self::with_options(patches, places, &LimitStencilOptions::default())
    }

    /// The same with a choice of derivatives and a bound on memory.
    ///
    /// # Errors
    /// As [`LimitStencilTable::new`].
    ///
    /// # Panics
    /// As [`LimitStencilTable::new`].
    pub fn with_options(
        patches: &PatchTable,
        places: &[Location],
        options: &LimitStencilOptions,
    ) -> Result<Self, StencilError> {
        W::compiled_limit_stencils(patches, places.len(), &|i| Some(places[i]), None, options)
    }

    /// The limit of every vertex of `level`, a refinement of the table's mesh, in the order of refinement. A vertex
    /// that only holes use, or no face, keeps its refined point, as [`limit_of_level`] keeps it; it has no derivatives.
    ///
    /// [`limit_of_level`]: crate::LimitSurface::limit_of_level
    ///
    /// # Errors
    /// As [`LimitStencilTable::new`], and those of [`StencilTable::new`].
    ///
    /// # Panics
    /// If the level stems from another mesh.
    pub fn of_level(patches: &PatchTable, level: &Level, options: &LimitStencilOptions) -> Result<Self, StencilError> {
        let places = patches.places_of_level(level);
        let refined = match places.iter().any(Option::is_none) {
            true => {
                let control = Level::from_topology(patches.topology().clone(), patches.scheme());
                let bounded = StencilOptions { most_weights: options.most_weights, ..StencilOptions::default() };
                Some(StencilTable::<f64>::with_options(&control, level.depth(), &bounded)?)
            }
            false => None,
        };
        W::compiled_limit_stencils(patches, places.len(), &|i| places[i], refined.as_ref(), options)
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

    /// The weights of all rows for one part; empty for derivatives that were not asked for.
    pub fn weights(&self, part: Part) -> &[W] {
        &self.weights[part as usize]
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        let weights: usize = self.weights.iter().map(|w| size_of_val(&w[..])).sum();
        self.rows.bytes() + weights + size_of_val(&self.states[..])
    }

    /// Whether first derivatives are finite at a row's place; none where no surface is. Where they vanish or diverge, the
    /// rows of `Du` and `Dv` are directions.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn derivatives(&self, row: usize) -> Option<Derivatives> {
        match self.states[row] {
            State::Hole | State::Refined => None,
            State::Smooth => Some(Derivatives::Finite),
            State::SpecialVertex(derivatives) => Some(derivatives),
        }
    }

    /// True where second derivatives exist: everywhere but at special vertices and where no surface is.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn has_second(&self, row: usize) -> bool {
        self.states[row] == State::Smooth
    }

    /// The points, one per row, in parallel. Sums are formed in the wider of `T` and `W`, relative to the row's first control
    /// point.
    ///
    /// # Panics
    /// If `control` has not one value per control point.
    pub fn positions<T: Real, const N: usize>(&self, control: &[[T; N]]) -> Vec<[T; N]> {
        let mut out = vec![[T::default(); N]; self.len()];
        subsurf_memory::advise(&mut out);
        self.positions_into(control, &mut out);
        out
    }

    /// [`positions`](Self::positions) into memory that is at hand.
    ///
    /// # Panics
    /// If `control` has not one value per control point, or `out` not one per row.
    pub fn positions_into<T: Real, const N: usize>(&self, control: &[[T; N]], out: &mut [[T; N]]) {
        self.rows.apply_into::<W, T, N, 1, true>(self.parts(0), control, out.as_chunks_mut().0);
    }

    /// `[du, dv]` of every row, in parallel; a constant has derivatives of exactly zero.
    ///
    /// # Panics
    /// If `control` has not one value per control point, or the table was made for positions alone.
    pub fn first_derivatives<T: Real, const N: usize>(&self, control: &[[T; N]]) -> Vec<[[T; N]; 2]> {
        let mut out = vec![[[T::default(); N]; 2]; self.len()];
        subsurf_memory::advise(&mut out);
        self.rows.apply_into::<W, T, N, 2, false>(self.parts(1), control, &mut out);
        out
    }

    /// `[position, du, dv]` of every row, in one pass over the table.
    ///
    /// # Panics
    /// As [`first_derivatives`](Self::first_derivatives).
    pub fn frames<T: Real, const N: usize>(&self, control: &[[T; N]]) -> Vec<[[T; N]; 3]> {
        let mut out = vec![[[T::default(); N]; 3]; self.len()];
        subsurf_memory::advise(&mut out);
        self.frames_into(control, &mut out);
        out
    }

    /// [`frames`](Self::frames) into memory that is at hand.
    ///
    /// # Panics
    /// As [`first_derivatives`](Self::first_derivatives), or if `out` has not one entry per row.
    pub fn frames_into<T: Real, const N: usize>(&self, control: &[[T; N]], out: &mut [[[T; N]; 3]]) {
        self.rows.apply_into::<W, T, N, 3, true>(self.parts(0), control, out);
    }

    /// `[duu, duv, dvv]` of every row, in parallel.
    ///
    /// # Panics
    /// If `control` has not one value per control point, or the table was not made for second derivatives.
    pub fn second_derivatives<T: Real, const N: usize>(&self, control: &[[T; N]]) -> Vec<[[T; N]; 3]> {
        let mut out = vec![[[T::default(); N]; 3]; self.len()];
        subsurf_memory::advise(&mut out);
        self.rows.apply_into::<W, T, N, 3, false>(self.parts(3), control, &mut out);
        out
    }

    /// Which rows depend on which control points, for the updates.
    pub fn dependents(&self) -> Dependents {
        Dependents::new(&self.rows)
    }

    /// Recomputes the positions that depend on the `changed` control points, and returns which rows those are, ascending;
    /// with the same bits as [`positions`](Self::positions).
    ///
    /// # Panics
    /// If `control` has not one value per control point, `out` not one per row, a changed point does not exist, or
    /// `dependents` belongs to another table.
    pub fn update_positions<T: Real, const N: usize>(
        &self,
        dependents: &Dependents,
        control: &[[T; N]],
        changed: &[u32],
        out: &mut [[T; N]],
    ) -> Vec<u32> {
        let moved = dependents.of_all(changed);
        self.rows.update::<W, T, N, 1, true>(self.parts(0), control, &moved, out.as_chunks_mut().0);
        moved
    }

    /// The same for [`frames`](Self::frames).
    ///
    /// # Panics
    /// As [`update_positions`](Self::update_positions) and [`frames`](Self::frames).
    pub fn update_frames<T: Real, const N: usize>(
        &self,
        dependents: &Dependents,
        control: &[[T; N]],
        changed: &[u32],
        out: &mut [[[T; N]; 3]],
    ) -> Vec<u32> {
        let moved = dependents.of_all(changed);
        self.rows.update::<W, T, N, 3, true>(self.parts(0), control, &moved, out);
        moved
    }

    fn parts<const K: usize>(&self, first: usize) -> [&[W]; K] {
        let part = |k: usize| -> &[W] {
            let weights = &self.weights[first + k];
            assert_eq!(weights.len(), self.rows.indices.len(), "the table was made with these derivatives");
            weights
        };
        std::array::from_fn(part)
    }
}
