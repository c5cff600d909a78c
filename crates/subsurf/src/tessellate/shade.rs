//! Turns the limit normals of a tessellation into shading normals, sample by sample in the order of the layout.

use super::layout::Layout;
use super::normals::{Sides, Source};
use crate::index::{Face, HalfEdge};
use crate::limit::Location;
use crate::real::{Real, round};
use crate::shading::ShadingNormals;
use rayon::prelude::*;

/// Replaces the normals at vertices, inside edges, inside faces and at further sides, in this order.
pub(super) fn shade<T: Real>(layout: &Layout<'_>, sides: &Sides, shading: &ShadingNormals<'_>, normals: &mut [[T; 3]]) {
    if shading.is_limit() {
        return;
    }
    let patterns = shading.patterns(layout.cells);
    let blend = |n: &mut [T; 3], at: Location| {
        if let Some(blended) = shading.blend(at, Some(n.map(T::to_f64)), Some(&patterns)) {
            *n = round(blended);
        }
    };
    let (vertices, rest) = normals.split_at_mut(layout.vertices());
    let (edges, rest) = rest.split_at_mut(layout.edge_points());
    let (mut faces, extra) = rest.split_at_mut(layout.face_points());

    vertices.par_iter_mut().zip(&layout.vertex_owner).for_each(|(n, &h)| blend(n, layout.corner_location(HalfEdge(h))));
    let samples = layout.edge_samples();
    edges.par_iter_mut().zip(samples).for_each(|(n, (h, k))| blend(n, layout.edge_location(h, k)));

    let mut tasks = Vec::new();
    for run in layout.face_chunks() {
        let (part, rest) = faces.split_at_mut(layout.face_range(&run).len());
        faces = rest;
        tasks.push((run, part));
    }
    tasks.into_par_iter().for_each(|(run, part)| {
        let mut part = part.iter_mut();
        for f in run.map(Face).filter(|&f| !layout.table.topology().is_hole(f)) {
            layout.inner_locations(f, |at| blend(part.next().expect("a normal per sample"), at));
        }
    });

    extra.par_iter_mut().zip(&sides.sources).for_each(|(n, source)| {
        blend(
            n,
            match *source {
                Source::Corner(h) => layout.corner_location(h),
                Source::Edge(h, k) => layout.edge_location(h, k),
            },
        );
    });
}
