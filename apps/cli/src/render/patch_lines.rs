//! The lines between a baseline's patches on the limit surface.

use super::rate::length_px;
use rayon::prelude::*;
use subsurf::{AdaptivePatch, AdaptiveRefinement, LimitSurface, Location, Scheme};
use subsurf_render::{Camera, Polyline, Stroke};

/// Patches whose diagonal is shorter in the picture have no lines: they would cover the colours.
const SHORTEST_PX: f64 = 7.0;

/// A line on a patch: its ends, in the patch's own parameters.
type Side = [[f64; 2]; 2];

/// Of squares, the sides along v = 0 and u = 0, unless they lie on a side of the face, where the control mesh's edge is
/// drawn: with those of its neighbours they are every line between two patches.
const OF_SQUARE: [Side; 2] = [[[0.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]]];
/// Of triangles, all sides of those that are upside down; the others touch each other in corners only.
const OF_TRIANGLE: [Side; 3] = [[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [0.0, 1.0]], [[0.0, 1.0], [0.0, 0.0]]];

/// The lines, thinner than those of the control mesh. `rate` is the tessellation's.
pub fn patch_lines(
    surface: &LimitSurface<'_, f32, 3>,
    baseline: &AdaptiveRefinement,
    rate: u32,
    camera: Camera,
    size: [u32; 2],
) -> Vec<Polyline> {
    let [width, height] = size.map(f64::from);
    let view = camera.view(surface.points(), width / height);
    let curves = |patch: AdaptivePatch| {
        let point = |[a, b]: [f64; 2]| {
            let (u, v) = (patch.u + patch.size * a, patch.v + patch.size * b);
            let at = Location { face: patch.face, subface: patch.subface, u, v };
            surface.position(at).map(|p| p.map(|x| x as f32))
        };
        let diagonal = [[1.0, 0.0], [0.0, 1.0]].map(point);
        let large = matches!(diagonal, [Some(a), Some(b)] if length_px(&view, height, [a, b]) >= SHORTEST_PX);
        let steps = (f64::from(rate) * patch.size.abs()).ceil().max(1.0) as u32;
        let curve = move |[from, to]: Side| -> Vec<[f32; 3]> {
            let at = |s: f64| [0, 1].map(|k| from[k] + s * (to[k] - from[k]));
            (0..=steps).filter_map(|i| point(at(f64::from(i) / f64::from(steps)))).collect()
        };
        sides(&patch, baseline.scheme()).into_iter().filter(|_| large).map(curve).collect::<Vec<_>>()
    };
    let stroke = Stroke { opacity: 0.45, width_px: 0.7, ..Stroke::wire() };
    let patches: Vec<AdaptivePatch> = baseline.patches().collect();
    let lines = patches.into_par_iter().flat_map_iter(curves).map(|points| Polyline { points, stroke });
    lines.collect()
}

/// The sides of a patch that it draws.
fn sides(patch: &AdaptivePatch, scheme: Scheme) -> Vec<Side> {
    if scheme == Scheme::Loop {
        return if patch.size < 0.0 { OF_TRIANGLE.to_vec() } else { Vec::new() };
    }
    let inside = [patch.v > 0.0, patch.u > 0.0];
    OF_SQUARE.into_iter().zip(inside).filter(|(_, inside)| *inside).map(|(side, _)| side).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;
    use subsurf::{AdaptiveOptions, shapes};

    /// Every stretch between neighbouring patches, in units of the smallest patch, with how often it is a side at all.
    fn covered(table: &AdaptiveRefinement, drawn: bool) -> BTreeMap<(u32, [i64; 4]), usize> {
        let unit = f64::from(1 << table.options().isolation);
        let mut covered = BTreeMap::new();
        for patch in table.patches() {
            let all = match table.scheme() {
                Scheme::Loop => OF_TRIANGLE.to_vec(),
                _ => {
                    let opposite = [[[0.0, 1.0], [1.0, 1.0]], [[1.0, 0.0], [1.0, 1.0]]];
                    OF_SQUARE.into_iter().chain(opposite).collect()
                }
            };
            let list = if drawn { sides(&patch, table.scheme()) } else { all };
            for [from, to] in list {
                let steps = (patch.size.abs() * unit) as i64;
                let place = |[a, b]: [f64; 2]| [patch.u + patch.size * a, patch.v + patch.size * b];
                let ends = [from, to].map(|end| place(end).map(|x| (x * unit).round() as i64));
                for i in 0..steps {
                    let at = |i: i64| [0, 1].map(|k| ends[0][k] + (ends[1][k] - ends[0][k]) / steps * i);
                    let mut stretch = [at(i), at(i + 1)];
                    stretch.sort();
                    let [[a, b], [c, d]] = stretch;
                    *covered.entry((patch.face.0 * 64 + patch.subface, [a, b, c, d])).or_insert(0) += 1;
                }
            }
        }
        covered
    }

    #[test]
    fn every_line_between_two_patches_is_drawn() {
        let quads = [shapes::interior_vertex(5), shapes::cone(5)].map(|shape| (shape, Scheme::CatmullClark));
        let triangles = [(shapes::interior_triangles(5), Scheme::Loop)];
        for (shape, scheme) in quads.into_iter().chain(triangles) {
            let options = AdaptiveOptions { isolation: 4, single_crease: true };
            let table = AdaptiveRefinement::new(&shape.mesh, scheme, options).unwrap();
            let drawn = covered(&table, true);
            let shared = covered(&table, false).into_iter().filter(|(_, times)| *times == 2);
            for (stretch, _) in shared {
                assert!(drawn.contains_key(&stretch), "{}: {stretch:?}", shape.name);
            }
        }
    }
}
