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
use subsurf_memory::advise;

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
        let mut values = vec![[T::default(); N]; layout.points()];
        advise(&mut values);
        if const { N > 3 } {
            fill(&layout, surface, &mut values);
        } else if const { N == 3 } {
            T::channel(&layout, surface.of_threes(), as_rows_mut(&mut values));
        } else {
            // Filled up to three numbers, which takes as long as two.
            let filled = |row: &[T; N]| std::array::from_fn(|k| row.get(k).copied().unwrap_or_default());
            let control: Vec<[T; 3]> = surface.points().iter().map(filled).collect();
            let mut points = vec![[T::default(); 3]; values.len()];
            advise(&mut points);
            T::channel(&layout, surface.table().surface(&control), &mut points);
            values.iter_mut().zip(&points).for_each(|(value, point)| value.copy_from_slice(&point[..N]));
        }
        let options = TessellateOptions { facets: self.facets, normals: false, ..TessellateOptions::default() };
        let corners = facets::of_layout(&layout, &Sides::default(), &options)?.corners;
        debug_assert_eq!(corners.len(), self.corners.len());
        Ok(TessellatedChannel { values, corners })
    }
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
