//! Normals of the further sides of creases, where one point has several: at corners from two rows of weights each. Those along
//! edges a face gives with its own samples.

use super::corner_rows::FurtherCorner;
use super::evaluate::Evaluator;
use crate::kernel::{LANES, unit_normals_of};
use crate::real::{Real, round};
use rayon::prelude::*;

impl<T: Real, const N: usize> Evaluator<'_, T, N> {
    /// Fills those at corners.
    pub(super) fn normals_at_corners(&self, normals: &mut [[T; 3]]) {
        let blocks = normals.par_chunks_mut(LANES).zip(self.patterns.corners().corners.par_chunks(LANES));
        blocks.for_each(|(normals, corners)| self.corners(corners, normals));
    }

    /// Normals of up to a block of face corners.
    fn corners(&self, corners: &[FurtherCorner], normals: &mut [[T; 3]]) {
        let [mut du, mut dv] = [[[T::default(); LANES]; 3]; 2];
        let mut extent = [T::default(); LANES];
        for (k, corner) in corners.iter().enumerate() {
            let ([u, v], size) = self.corner(corner);
            extent[k] = size;
            (0..3).for_each(|c| (du[c][k], dv[c][k]) = (u[c % N], v[c % N]));
        }
        let mut unit = [[T::default(); 3]; LANES];
        let unsure = unit_normals_of(&du, &dv, &extent, &mut unit);
        normals.copy_from_slice(&unit[..corners.len()]);
        for (k, corner) in corners.iter().enumerate().filter(|(k, _)| unsure >> k & 1 != 0) {
            normals[k] = round(self.sampler.single(self.sampler.layout().corner_location(corner.half_edge)).1);
        }
    }

    /// Derivatives at a corner; and how far from each other its control points are.
    fn corner(&self, corner: &FurtherCorner) -> ([[T; N]; 2], T) {
        let table = self.sampler.layout().table;
        let (ring, control) = (table.ring(corner.patch), self.sampler.surface().points());
        let base = control[ring[0] as usize];
        let mut sums = [[T::default(); N]; 2];
        let mut extent = T::default();
        for &(p, weights) in self.patterns.corners().row(corner) {
            let point = control[ring[p as usize] as usize];
            for c in 0..N {
                let x = point[c] - base[c];
                let size = if x > T::default() { x } else { T::default() - x };
                extent = if size > extent { size } else { extent };
                for k in 0..2 {
                    sums[k][c] = sums[k][c] + weights[k] * x;
                }
            }
        }
        (sums, extent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::index::Face;
    use crate::limit::PatchTable;
    use crate::scheme::Scheme;
    use crate::shapes::{self, Shape};
    use crate::tags::{Crease, Tags};
    use crate::tessellate::layout::{Layout, PatchRates};
    use crate::tessellate::normals::Sides;
    use crate::tessellate::output::{Output, Vertices};
    use crate::tessellate::pattern::{Frames, Patterns};
    use crate::tessellate::sample::{NormalOf, Sampler};
    use std::collections::BTreeSet;
    use std::sync::atomic::Ordering::Relaxed;

    /// The shape with infinitely sharp creases along every `step`-th of its edges.
    fn creased(shape: &Shape, step: usize) -> Shape {
        let mut edges = BTreeSet::new();
        for face in shape.mesh.faces() {
            let sides = face.iter().zip(face.iter().cycle().skip(1)).filter(|(a, b)| a != b);
            edges.extend(sides.map(|(&a, &b)| (a.min(b), a.max(b))));
        }
        let creases = edges.into_iter().step_by(step).map(|(a, b)| Crease::new(a, b, 10.0)).collect();
        let tags = Tags { creases, ..shape.mesh.tags().clone() };
        shape.tagged(format!("{}, every {step} edges sharp", shape.name), tags)
    }

    /// Normals of one frame are those of their places one by one, and every patch is evaluated once.
    fn agrees(shape: &Shape, scheme: Scheme, rate: u32, bytes: [usize; 2]) -> usize {
        let table = PatchTable::new(&shape.mesh, scheme).unwrap();
        let t = table.topology();
        let layout = Layout::new(&table, PatchRates::Uniform { rate, edges: t.edge_count() });
        let sides = Sides::new(&table, &layout);
        let sampler = Sampler::new(table.surface(&shape.positions), &layout, Some(NormalOf::SPACE));
        let patterns = Patterns::within(&layout, Some(&sides), Frames::Many, bytes);
        let evaluator = Evaluator::new(&patterns, sampler);
        let mut points = vec![[0.0; 3]; layout.points()];
        let mut normals = vec![[f64::NAN; 3]; layout.points() + sides.extra()];
        evaluator.evaluate(Output { points: &mut points, normals: &mut normals }, &mut Vertices::default());

        let faces = (0..t.face_count() as u32).map(Face).filter(|&f| !t.is_hole(f));
        let patches: usize = faces.map(|f| table.subfaces(f) as usize).sum();
        assert_eq!(evaluator.evaluated.load(Relaxed), patches, "{} at rate {rate}", shape.name);
        let mut expected = vec![[f64::NAN; 3]; sides.extra()];
        sampler.extra_normals(&sides, &mut expected);
        for (k, (a, b)) in normals[layout.points()..].iter().zip(&expected).enumerate() {
            let is_near = (0..3).all(|c| (a[c] - b[c]).abs() < 1e-11);
            assert!(is_near, "{} at rate {rate}, further normal {k}: {a:?} {b:?}", shape.name);
        }
        sides.edges().count()
    }

    #[test]
    fn further_normals_come_with_the_samples_of_their_faces() {
        let triangles = shapes::all_triangles().into_iter().map(|s| (s, Scheme::Loop));
        let mut seen = 0;
        for (shape, scheme) in shapes::all().into_iter().map(|s| (s, Scheme::CatmullClark)).chain(triangles) {
            let variants = [1, 2, 3].map(|step| creased(&shape, step));
            for shape in std::iter::once(shape).chain(variants) {
                for (rate, bytes) in [(2, usize::MAX), (6, usize::MAX), (6, 0)] {
                    seen += agrees(&shape, scheme, rate, [bytes; 2]);
                }
            }
        }
        assert!(seen > 1000, "{seen} sides of creases");
    }

    #[test]
    fn further_normals_come_with_those_of_large_and_of_fine_faces() {
        // More faces than a chunk has, and a rate at which faces are evaluated sub-patch by sub-patch.
        assert!(agrees(&creased(&shapes::grid(20, 15), 3), Scheme::CatmullClark, 4, [usize::MAX; 2]) > 100);
        for shape in [shapes::cube(), shapes::interior_vertex(5), shapes::cone(5)] {
            agrees(&creased(&shape, 2), Scheme::CatmullClark, 160, [0; 2]);
        }
    }
}
