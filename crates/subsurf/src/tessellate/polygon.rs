//! Samples of a face that is no quad, sub-face by sub-face: what sub-faces share lies between those inside them, and every edge
//! is made of the sides of two.

use super::evaluate::{Evaluator, Scratch};
use super::grid;
use super::tasks::Task;
use crate::index::{Face, HalfEdge};
use crate::real::Real;

impl<T: Real, const N: usize> Evaluator<'_, T, N> {
    /// The sub-faces of a face, which gives further normals along the half-edges `seen`.
    pub(super) fn polygon(
        &self,
        face: Face,
        seen: &[HalfEdge],
        first_edge: usize,
        task: &mut Task<'_, T, N>,
        scratch: &mut Scratch<T, N>,
    ) {
        let layout = self.sampler.layout();
        let t = layout.table.topology();
        let subfaces = layout.table.subfaces(face);
        let cells = layout.cells[1] as usize;
        // The centre, the points inside spokes, then those inside sub-faces.
        let (mut spokes, mut inside) = task.inside.borrow().split(1 + subfaces as usize * (cells - 1));
        let (mut counted, mut edge_points) = (spokes.points.len(), 0);
        let before = first_edge + layout.edge_range(&task.faces).len() - task.edges.points.len();
        // Where the further normals along a half-edge start, if the face sees them.
        let further = |h: HalfEdge| seen.binary_search(&h).ok().map(|k| k * (2 * cells - 1));
        for subface in 0..subfaces {
            let h = t.half_edge(face, subface as usize);
            let owned = layout.owned(layout.table.patch(face, subface));
            let (out, back) = (owned & grid::side(0) != 0, owned & grid::side(3) != 0);
            let (further_out, further_back) = (further(h), further(t.prev(h)));
            let mut parts = owned | grid::side(1);
            parts |= if subface == 0 { grid::corner(2) } else { 0 };
            parts |= if out || further_out.is_some() { grid::side(0) | grid::corner(1) } else { 0 };
            parts |= if further_back.is_some() { grid::side(3) } else { 0 };
            let samples = self.patch(face, subface, parts, scratch);
            let corner = |c: usize| samples.corner(c)..samples.corner(c) + 1;
            if subface == 0 {
                scratch.put(corner(2), &mut spokes);
            }
            scratch.put(samples.side(1), &mut spokes);
            scratch.put_inside(samples, None, &mut inside);
            counted += samples.inside();
            let edge = |h: HalfEdge| layout.edge_first(t.edge(h)) - before;
            if out {
                scratch.put(samples.side(0), &mut task.edges.borrow().split(edge(h)).1);
                scratch.put(corner(1), &mut task.edges.borrow().split(edge(h) + cells - 1).1);
                edge_points += 2 * cells - 1;
            }
            if back {
                scratch.put(samples.side(3), &mut task.edges.borrow().split(edge(t.prev(h)) + cells).1);
            }
            if owned & grid::corner(0) != 0 {
                scratch.put(corner(0), &mut task.vertices);
            }
            if let Some(first) = further_out {
                task.further[first..][..cells - 1].copy_from_slice(&scratch.normals[samples.side(0)]);
                task.further[first + cells - 1] = scratch.normals[samples.corner(1)];
            }
            if let Some(first) = further_back {
                task.further[first + cells..][..cells - 1].copy_from_slice(&scratch.normals[samples.side(3)]);
            }
        }
        task.inside.skip(counted);
        task.edges.skip(edge_points);
        task.skip_further(seen.len() * (2 * cells - 1));
    }
}
