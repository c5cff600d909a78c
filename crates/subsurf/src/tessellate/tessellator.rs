//! A tessellation of which everything but positions is at hand: made once per connectivity and options, evaluated once per
//! animation frame.

use super::evaluate::Evaluator;
use super::faceted::PatchNormals;
use super::facets::{self, FacetArrays};
use super::layout::Layout;
use super::normals::Sides;
use super::output::{Output, Vertices};
use super::pattern::{Frames, Patterns};
use super::sample::{NormalOf, Sampler};
use super::{Places, TessellateError, TessellateOptions, Tessellation, rates, shade};
use crate::limit::{LimitSurface, PatchTable};
use crate::real::{Real, round};
use crate::scheme::Scheme;
use crate::shading::ShadingNormals;
use rayon::prelude::*;
use std::sync::Mutex;
use subsurf_memory::{advise, reserve_whole_pages, with_capacity};

/// Tessellates a mesh whose control points move: facets, and the weights of all samples, are made once. A frame agrees with
/// what [`tessellate`](LimitSurface::tessellate) gives to rounding, as that sums in `f64` where few faces are alike.
///
/// ```
/// use subsurf::{PatchTable, Rates, Scheme, TessellateOptions, shapes};
///
/// let cube = shapes::cube();
/// let mut control: Vec<[f32; 3]> = cube.positions.iter().map(|p| p.map(|x| x as f32)).collect();
/// let patches = PatchTable::new(&cube.mesh, Scheme::CatmullClark)?;
/// let options = TessellateOptions { rates: Rates::Uniform(4), ..TessellateOptions::default() };
/// let tessellator = patches.tessellator(&control, &options)?; // once per connectivity
///
/// let mut points = vec![[0.0; 3]; tessellator.point_count()];
/// let mut normals = vec![[0.0; 3]; tessellator.normal_count()];
/// for frame in 0..3 {
///     control[0][2] += 0.1 * frame as f32;
///     tessellator.evaluate_into(&control, &mut points, &mut normals); // once per frame
/// }
/// assert_eq!(tessellator.facet_count(), 6 * 4 * 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Tessellator<'a, T> {
    layout: Layout<'a>,
    sides: Sides,
    /// None where rates differ from face to face.
    patterns: Option<Patterns<'a, T>>,
    facets: FacetArrays,
    /// Where normals are evaluated under bilinear subdivision.
    faceted: Option<PatchNormals>,
    /// Kept from frame to frame.
    vertices: Mutex<Vertices<T, 3>>,
    options: TessellateOptions,
}

impl PatchTable {
    /// Prepares tessellations of this mesh for any control points. Adaptive rates are those that the given ones ask for,
    /// and stay.
    ///
    /// # Errors
    /// [`TessellateError`]: rates that are not positive, or a result too large for 32-bit indices.
    ///
    /// # Panics
    /// If `points` has not one row per vertex of the mesh.
    pub fn tessellator<T: Real>(
        &self,
        points: &[[T; 3]],
        options: &TessellateOptions,
    ) -> Result<Tessellator<'_, T>, TessellateError> {
        Ok(T::compiled_tessellator(self, points, options, Frames::Many)?.0)
    }
}

/// A tessellator for a number of frames; for a single one, also [memory](reserve_whole_pages) to hold back until its arrays are there.
pub(crate) fn prepare<'a, T: Real>(
    table: &'a PatchTable,
    points: &[[T; 3]],
    options: &TessellateOptions,
    frames: Frames,
) -> Result<(Tessellator<'a, T>, Vec<u8>), TessellateError> {
    let rates = rates::choose(&table.surface(points), options.rates, options.most_points)?;
    let layout = Layout::new(table, rates);
    layout.check(options.most_points)?;
    let is_faceted = options.normals && table.scheme() == Scheme::Bilinear;
    let shared = options.normals && !is_faceted;
    let sides = if shared { Sides::new(table, &layout) } else { Sides::default() };
    let mut before = Vec::new();
    if frames == Frames::One {
        // Positions, normals, and about one facet of four corners a point, whose normals may have numbers of their own.
        let normals = if shared { layout.points() + sides.extra() } else { 0 };
        let samples = (layout.points() + normals).saturating_mul(size_of::<[T; 3]>());
        let numbers = if sides.extra() > 0 { 9 } else { 5 };
        before =
            reserve_whole_pages(samples.saturating_add(layout.points().saturating_mul(numbers * size_of::<u32>())));
    }
    let with_places = TessellateOptions { places: options.places || is_faceted, ..*options };
    let mut facets = facets::of_layout(&layout, &sides, &with_places)?;
    let faceted = is_faceted.then(|| PatchNormals::of(&facets));
    if let Some(faceted) = &faceted {
        facets.normal_corners.clone_from(&faceted.corners);
        if !options.places {
            facets.places = Places::default();
        }
    }
    let patterns = layout.is_uniform().then(|| Patterns::new(&layout, shared.then_some(&sides), frames));
    let vertices = Mutex::default();
    Ok((Tessellator { layout, sides, patterns, facets, faceted, vertices, options: *options }, before))
}

impl<'a, T: Real> Tessellator<'a, T> {
    /// Number of points.
    pub fn point_count(&self) -> usize {
        self.layout.points()
    }

    /// Number of normals; 0 if they were not asked for.
    pub fn normal_count(&self) -> usize {
        match &self.faceted {
            Some(faceted) => faceted.sources.len(),
            None if self.options.normals => self.layout.points() + self.sides.extra(),
            None => 0,
        }
    }

    /// Number of facets.
    pub fn facet_count(&self) -> usize {
        self.facets.face_offsets.len() - 1
    }

    /// Start of every facet in [`corners`](Self::corners), and the end of the last one.
    pub fn face_offsets(&self) -> &[u32] {
        &self.facets.face_offsets
    }

    /// Points of all facets, counter-clockwise.
    pub fn corners(&self) -> &[u32] {
        &self.facets.corners
    }

    /// Normal of every facet corner; empty where normals go by the same indices as points.
    pub fn normal_corners(&self) -> &[u32] {
        &self.facets.normal_corners
    }

    /// Where each facet lies, if asked for.
    pub fn places(&self) -> Option<&Places> {
        self.options.places.then_some(&self.facets.places)
    }

    /// Points and normals for these control points, one per vertex of the mesh. Nothing is allocated but a few blocks per
    /// thread and, at rates so high that patterns would be too large, room for the samples of a face and the first time lists of them.
    ///
    /// # Panics
    /// If a slice has not the length that [`point_count`](Self::point_count) and [`normal_count`](Self::normal_count)
    /// say, or `control` not one row per vertex of the mesh.
    pub fn evaluate_into(&self, control: &[[T; 3]], points: &mut [[T; 3]], normals: &mut [[T; 3]]) {
        T::compiled_tessellate(self, self.layout.table.surface(control), None, points, normals);
    }

    /// The same with shading normals in the place of the surface's own, as
    /// [`tessellate_shaded`](LimitSurface::tessellate_shaded) gives them.
    ///
    /// # Panics
    /// As [`evaluate_into`](Self::evaluate_into), and if the normals are those of another mesh.
    pub fn evaluate_shaded_into(
        &self,
        control: &[[T; 3]],
        shading: &ShadingNormals<'_>,
        points: &mut [[T; 3]],
        normals: &mut [[T; 3]],
    ) {
        T::compiled_tessellate(self, self.layout.table.surface(control), Some(shading), points, normals);
    }

    /// The whole mesh for these control points.
    ///
    /// # Panics
    /// If `control` has not one row per vertex of the mesh.
    pub fn evaluate(&self, control: &[[T; 3]]) -> Tessellation<T> {
        let (positions, normals) = self.vertices(self.layout.table.surface(control), None);
        Tessellation {
            positions,
            face_offsets: copy(&self.facets.face_offsets),
            corners: copy(&self.facets.corners),
            normals,
            normal_corners: copy(&self.facets.normal_corners),
            places: self.options.places.then(|| self.facets.places.clone()),
            rates: self.layout.rates.clone(),
            facets: self.options.facets,
        }
    }

    /// The whole mesh once, and no further.
    pub(super) fn into_mesh(
        self,
        surface: LimitSurface<'_, T, 3>,
        shading: Option<&ShadingNormals<'_>>,
    ) -> Tessellation<T> {
        let (positions, normals) = self.vertices(surface, shading);
        Tessellation {
            positions,
            face_offsets: self.facets.face_offsets,
            corners: self.facets.corners,
            normals,
            normal_corners: self.facets.normal_corners,
            places: self.options.places.then_some(self.facets.places),
            rates: self.layout.into_rates(),
            facets: self.options.facets,
        }
    }

    fn vertices(
        &self,
        surface: LimitSurface<'_, T, 3>,
        shading: Option<&ShadingNormals<'_>>,
    ) -> (Vec<[T; 3]>, Vec<[T; 3]>) {
        let mut points = vec![[T::default(); 3]; self.point_count()];
        let mut normals = vec![[T::default(); 3]; self.normal_count()];
        advise(&mut points);
        advise(&mut normals);
        T::compiled_tessellate(self, surface, shading, &mut points, &mut normals);
        (points, normals)
    }

    /// Points and normals of a surface of this mesh.
    pub(crate) fn fill(
        &self,
        surface: LimitSurface<'_, T, 3>,
        shading: Option<&ShadingNormals<'_>>,
        points: &mut [[T; 3]],
        normals: &mut [[T; 3]],
    ) {
        assert_eq!(points.len(), self.point_count(), "one point per sample");
        assert_eq!(normals.len(), self.normal_count(), "the normals that were asked for");
        if let Some(shading) = shading {
            assert!(shading.fits(self.layout.table.topology()), "the normals are those of this mesh");
        }
        // Whoever evaluates another frame at the same time has memory of his own.
        let (mut kept, mut other) = (self.vertices.try_lock(), Vertices::default());
        let memory = kept.as_deref_mut().unwrap_or(&mut other);
        if let Some(faceted) = &self.faceted {
            fill(&self.layout, self.patterns.as_ref(), surface, None, Output { points, normals: &mut [] }, memory);
            let sampler = Sampler::new(surface, &self.layout, Some(NormalOf::SPACE));
            normals.par_iter_mut().zip(&faceted.sources).for_each(|(n, &at)| *n = round(sampler.normal(at)));
            return;
        }
        let normals_of = self.options.normals.then_some((NormalOf::SPACE, &self.sides));
        let out = Output { points, normals: &mut *normals };
        fill(&self.layout, self.patterns.as_ref(), surface, normals_of, out, memory);
        if let Some(shading) = shading.filter(|_| self.options.normals) {
            shade::shade(&self.layout, &self.sides, shading, normals);
        }
    }
}

fn copy(list: &[u32]) -> Vec<u32> {
    let mut out = with_capacity(list.len());
    out.extend_from_slice(list);
    out
}

/// Evaluates all points of a layout, and their normals with those of further sides.
pub(super) fn fill<T: Real, const N: usize>(
    layout: &Layout<'_>,
    patterns: Option<&Patterns<'_, T>>,
    surface: LimitSurface<'_, T, N>,
    normals: Option<(NormalOf<N>, &Sides)>,
    out: Output<'_, T, N>,
    memory: &mut Vertices<T, N>,
) {
    let sampler = Sampler::new(surface, layout, normals.map(|(of, _)| of));
    if let Some(patterns) = patterns {
        return Evaluator::new(patterns, sampler).evaluate(out, memory);
    }
    let (vertices, rest) = out.split(layout.vertices());
    let (edges, rest) = rest.split(layout.edge_points());
    let (inside, further) = rest.split(layout.face_points());
    sampler.vertices(vertices.points, vertices.normals);
    sampler.edges(edges.points, edges.normals);
    sampler.faces(inside.points, inside.normals);
    if let Some((_, sides)) = normals {
        sampler.extra_normals(sides, further.normals);
    }
}
