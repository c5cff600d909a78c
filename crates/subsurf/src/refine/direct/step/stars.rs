//! The control vertices: each with the ends of its edges, which are their first vertices at this level, and the vertices across
//! the faces round it.

use super::super::places::Places;
use super::super::rules::fan;
use super::super::sides::{Sides, Walk};
use super::{Step, Task};
use crate::index::{Edge, HalfEdge, Vertex};
use crate::mask::{Mask, vertex_mask};
use crate::real::Real;
use crate::scheme::Scheme;
use crate::scheme::catmull_clark::smooth_neighbour;
use crate::topology::{NONE, Topology};

impl Step {
    #[inline(always)]
    pub(super) fn vertices<T: Real, const N: usize, const QUADS: bool>(
        &self,
        walk: Walk<'_, QUADS>,
        values: &[[T; N]],
        task: &mut Task<'_, [T; N]>,
    ) {
        let elements = task.elements.clone();
        let (own, out) = (&values[elements.clone()], &mut *task.parts[0]);
        if self.is_linear {
            return out.copy_from_slice(own);
        }
        for ((out, v), own) in out.iter_mut().zip(elements.start as u32..).zip(own) {
            let (mut ends, mut diagonals, mut valence) = ([T::default(); N], [T::default(); N], 0);
            let first = walk.t.vertex_half_edge[v as usize];
            let mut h = first;
            while h != NONE {
                let end = &values[self.from.on_half_edge(walk, HalfEdge(h), 1) as usize];
                let beside = walk.beside(HalfEdge(h));
                let diagonal = &values[self.from.diagonal(HalfEdge(h), &beside) as usize];
                for c in 0..N {
                    ends[c] = ends[c] + (end[c] - own[c]);
                    diagonals[c] = diagonals[c] + (diagonal[c] - own[c]);
                }
                valence += 1;
                h = walk.t.twin[beside.prev.index()];
                if h == first {
                    break;
                }
            }
            *out = smooth_sum(own, &ends, &diagonals, valence);
        }
        for row in self.special.among(elements.start as u32..elements.end as u32) {
            let value = |id: u32| values[id as usize];
            out[self.special.owners[row] as usize - elements.start] = self.special.apply(row, value);
        }
    }
}

/// A smooth vertex from the ends of its edges and the vertices across its faces, relative to its own value. Each centroid is the
/// mean of the vertex, two ends and the vertex across.
#[inline(always)]
fn smooth_sum<T: Real, const N: usize>(own: &[T; N], ends: &[T; N], diagonals: &[T; N], valence: usize) -> [T; N] {
    let each = smooth_neighbour(valence.max(1), 1.0);
    let (end, diagonal) = (T::from_f64(1.5 * each), T::from_f64(0.25 * each));
    let mut out = *own;
    for c in 0..N {
        out[c] = own[c] + (end * ends[c] + diagonal * diagonals[c]);
    }
    out
}

/// A smooth vertex from what lies round it, pair by pair.
pub(super) fn smooth_vertex<T: Real, const N: usize>(
    own: [T; N],
    around: impl Iterator<Item = ([T; N], [T; N])>,
) -> [T; N] {
    let (mut ends, mut diagonals, mut valence) = ([T::default(); N], [T::default(); N], 0);
    for (end, diagonal) in around {
        for c in 0..N {
            ends[c] = ends[c] + (end[c] - own[c]);
            diagonals[c] = diagonals[c] + (diagonal[c] - own[c]);
        }
        valence += 1;
    }
    smooth_sum(&own, &ends, &diagonals, valence)
}

/// The mask of a control vertex at a level, over the level's vertices.
pub(super) fn star(
    t: &Topology,
    sides: &Sides,
    scheme: Scheme,
    from: &Places,
    v: Vertex,
    mask: &mut Mask,
) -> Vec<(u32, f64)> {
    vertex_mask(t, scheme, v, mask);
    let mut terms = vec![(v.0, 0.0)];
    for (&(_, weight), &e) in mask.vertices.iter().zip(&mask.edges) {
        terms.push((if e == NONE { v.0 } else { from.near_end(t, Edge(e), v) }, weight));
    }
    if !mask.faces.is_empty() {
        for (h, &(_, weight)) in fan(t, v).into_iter().zip(&mask.faces) {
            let beside = Walk::<false> { t, sides }.beside(h);
            let ends = [h, beside.prev].map(|h| from.near_end(t, t.edge(h), v));
            terms.extend([v.0, ends[0], ends[1], from.diagonal(h, &beside)].map(|id| (id, 0.25 * weight)));
        }
    }
    terms.sort_by_key(|term| (term.0 != v.0, term.0));
    terms.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        kept.1 += if same { next.1 } else { 0.0 };
        same
    });
    terms
}
