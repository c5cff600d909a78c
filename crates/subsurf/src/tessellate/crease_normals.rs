//! Normals of the further sides of creases, where one point has several: at corners from two rows of weights each, along edges
//! as any other samples of the face that sees them.

use super::corner_rows::{CornerRow, corner_of};
use super::evaluate::{Evaluator, Scratch};
use super::grid::{self, turned_parts};
use super::normals::Sides;
use crate::index::HalfEdge;
use crate::kernel::{LANES, unit_normals_of};
use crate::real::{Real, round};
use rayon::prelude::*;

impl<T: Real, const N: usize> Evaluator<'_, T, N> {
    /// Fills them, in the order of [`Sides`].
    pub fn extra_normals(&self, sides: &Sides, normals: &mut [[T; 3]]) {
        let layout = self.sampler.layout();
        let corners: Vec<u32> = sides.corners().map(|h| h.0).collect();
        let (at_corners, along_edges) = normals.split_at_mut(corners.len());
        at_corners
            .par_chunks_mut(LANES)
            .zip(corners.par_chunks(LANES))
            .for_each(|(normals, corners)| self.corners(corners, normals));
        let Some(rate) = sides.edges().next().map(|h| layout.rates.edge(layout.table.topology().edge(h))) else {
            return;
        };
        let edges: Vec<HalfEdge> = sides.edges().collect();
        along_edges
            .par_chunks_mut(rate as usize - 1)
            .zip(edges)
            .for_each_init(Scratch::default, |scratch, (normals, h)| self.along(h, normals, scratch));
    }

    /// Normals of the points inside an edge as the face of `h` sees it.
    fn along(&self, h: HalfEdge, normals: &mut [[T; 3]], scratch: &mut Scratch<T, N>) {
        let layout = self.sampler.layout();
        let t = layout.table.topology();
        let face = t.face(h);
        let corner = h.0 - t.first(face);
        let subfaces = layout.table.subfaces(face);
        if subfaces == 1 {
            let turn = layout.table.turn(layout.table.patch(face, 0));
            let own = turned_parts(layout.is_triangle(), grid::side(corner as u8), turn);
            let samples = self.some_of(face, 0, own, false, scratch);
            normals.copy_from_slice(&scratch.normals[samples.side(own.trailing_zeros() as usize)]);
            return;
        }
        let (out, back) = normals.split_at_mut(layout.cells[1] as usize);
        let samples = self.some_of(face, corner, grid::side(0) | grid::corner(1), false, scratch);
        out[..back.len()].copy_from_slice(&scratch.normals[samples.side(0)]);
        out[back.len()] = scratch.normals[samples.corner(1)];
        let samples = self.some_of(face, (corner + 1) % subfaces, grid::side(3), false, scratch);
        back.copy_from_slice(&scratch.normals[samples.side(3)]);
    }

    /// Normals of up to a block of face corners.
    fn corners(&self, corners: &[u32], normals: &mut [[T; 3]]) {
        let [mut du, mut dv] = [[[T::default(); LANES]; 3]; 2];
        let mut extent = [T::default(); LANES];
        for (k, &h) in corners.iter().enumerate() {
            let ([u, v], size) = self.corner(HalfEdge(h));
            extent[k] = size;
            (0..3).for_each(|c| (du[c][k], dv[c][k]) = (u[c % N], v[c % N]));
        }
        let mut unit = [[T::default(); 3]; LANES];
        let unsure = unit_normals_of(&du, &dv, &extent, &mut unit);
        normals.copy_from_slice(&unit[..corners.len()]);
        for (k, &h) in corners.iter().enumerate().filter(|(k, _)| unsure >> k & 1 != 0) {
            normals[k] = round(self.sampler.single(self.sampler.layout().corner_location(HalfEdge(h))).1);
        }
    }

    /// Derivatives at the start of a half-edge; and how far from each other its control points are.
    fn corner(&self, h: HalfEdge) -> ([[T; N]; 2], T) {
        let layout = self.sampler.layout();
        let (patch, corner) = corner_of(layout.table, layout.is_triangle(), h);
        let plan = layout.table.patch_plan(patch).expect("its face is no hole");
        let row: &CornerRow<T> = self.patterns.corner(plan, corner);
        let (ring, control) = (layout.table.ring(patch), self.sampler.surface().points());
        let base = control[ring[0] as usize];
        let mut sums = [[T::default(); N]; 2];
        let mut extent = T::default();
        for &(p, weights) in row {
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
