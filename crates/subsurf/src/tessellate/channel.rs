//! A channel's values on the facets of a tessellation: the same rates over the channel's own topology, so that a value is
//! evaluated once wherever faces share it, and seams fall where the channel has them.

use super::layout::{Layout, PatchRates};
use super::normals::Sides;
use super::output::{Output, Vertices};
use super::pattern::{Frames, Patterns};
use super::{TessellateError, TessellateOptions, Tessellation, facets, tessellator};
use crate::compiled::as_rows_mut;
use crate::index::HalfEdge;
use crate::limit::{LimitSurface, PatchTable};
use crate::mesh::MAX_COUNT;
use crate::real::Real;
use rayon::prelude::*;
use subsurf_memory::{advise, with_capacity};

/// Values of a channel on the facets of a [`Tessellation`].
#[derive(Clone, Debug, PartialEq)]
pub struct TessellatedChannel<T, const N: usize> {
    /// The values.
    pub values: Vec<[T; N]>,
    /// Value of every facet corner, in the order of [`Tessellation::corners`].
    pub corners: Vec<u32>,
}

impl<P: Real> Tessellation<P> {
    /// The limit values of a channel at the corners of this tessellation's facets. `mesh` is the table that was
    /// tessellated, `surface` that of a [`Channel`](crate::Channel) over the same mesh.
    ///
    /// Values of more than three numbers are compiled where this is called, which takes long.
    ///
    /// # Errors
    /// [`TessellateError::TooLarge`] where the values do not fit 32-bit indices.
    ///
    /// # Panics
    /// If the two tables have not the same faces, or another mesh was tessellated.
    pub fn channel<T: Real, const N: usize>(
        &self,
        mesh: &PatchTable,
        surface: LimitSurface<'_, T, N>,
    ) -> Result<TessellatedChannel<T, N>, TessellateError> {
        let (own, t) = (mesh.topology(), surface.table().topology());
        assert_eq!(own.face_offsets(), t.face_offsets(), "a channel has the faces of its mesh");
        assert_eq!(self.rates.edges(), own.edge_count(), "the tessellation is one of this mesh");
        let rates = match &self.rates {
            PatchRates::Uniform { rate, .. } => PatchRates::Uniform { rate: *rate, edges: t.edge_count() },
            PatchRates::Each { patch, .. } => {
                let mut edge = vec![0; t.edge_count()];
                for h in (0..t.half_edge_count() as u32).map(HalfEdge) {
                    edge[t.edge(h).index()] = self.rates.edge(own.edge(h));
                }
                PatchRates::Each { edge, patch: patch.clone() }
            }
        };
        let layout = Layout::new(surface.table(), rates);
        layout.check(MAX_COUNT as u64)?;
        let values = values(&layout, surface);
        let options = TessellateOptions { facets: self.facets, normals: false, ..TessellateOptions::default() };
        let corners = facets::of_layout(&layout, &Sides::default(), &options)?.corners;
        debug_assert_eq!(corners.len(), self.corners.len());
        Ok(TessellatedChannel { values, corners })
    }
}

/// The values of a layout. One number and two are filled up to three, which are evaluated in the same time.
fn values<T: Real, const N: usize>(layout: &Layout<'_>, surface: LimitSurface<'_, T, N>) -> Vec<[T; N]> {
    fn room<T: Real, const N: usize>(len: usize) -> Vec<[T; N]> {
        let mut values = vec![[T::default(); N]; len];
        advise(&mut values);
        values
    }
    if const { N >= 3 } {
        let mut values = room(layout.points());
        if const { N == 3 } {
            T::compiled_channel(layout, surface.of_threes(), as_rows_mut(&mut values));
        } else {
            fill(layout, surface, &mut values);
        }
        return values;
    }
    let filled = |row: &[T; N]| std::array::from_fn(|k| row.get(k).copied().unwrap_or_default());
    let control: Vec<[T; 3]> = surface.points().par_iter().map(filled).collect();
    let mut points = room(layout.points());
    T::compiled_channel(layout, surface.table().surface(&control), &mut points);
    let mut values = with_capacity(points.len());
    points.par_iter().map(|point| std::array::from_fn(|k| point[k])).collect_into_vec(&mut values);
    values
}

/// The points of a layout.
pub(crate) fn fill<T: Real, const N: usize>(
    layout: &Layout<'_>,
    surface: LimitSurface<'_, T, N>,
    points: &mut [[T; N]],
) {
    let patterns = layout.is_uniform().then(|| Patterns::new(layout, None, Frames::One));
    let out = Output { points, normals: &mut [] };
    tessellator::fill(layout, patterns.as_ref(), surface, None, out, &mut Vertices::default());
}
