//! How many faces lie round every vertex, and whether they are quads with nothing sharp between them.

use super::smooth_ring::VALENCES;
use crate::index::{Face, Vertex};
use crate::topology::Topology;
use rayon::prelude::*;

/// The faces at a vertex: at a *smooth* one, an interior manifold vertex of quads with nothing sharp, how many; at others how
/// many vertices they have beside it, at most.
#[derive(Clone, Copy)]
pub(super) struct Fan(u32);

/// Those of all vertices.
pub(super) struct Fans {
    pub all: Vec<Fan>,
    /// See [`Fan::smooth_valence`]; 0 where there is none. Small, since every face asks for it several times.
    pub valence: Vec<u8>,
}

impl Fans {
    pub fn new(t: &Topology) -> Self {
        let vertices = (0..t.vertex_count() as u32).into_par_iter().with_min_len(2048).map(Vertex);
        let mut all = subsurf_memory::with_capacity(t.vertex_count());
        vertices.map(|v| Fan::of(t, v)).collect_into_vec(&mut all);
        if t.vertex_non_manifold.contains(&true) {
            // There are faces beyond the fan.
            let pairs = t.vertex_non_manifold.iter().zip(&mut all);
            pairs.filter(|(non_manifold, _)| **non_manifold).for_each(|fan| *fan.1 = Fan(0));
            for f in (0..t.face_count()).map(Face::new) {
                for &v in t.face_vertices(f) {
                    if t.vertex_non_manifold[v as usize] {
                        all[v as usize].0 += t.sides(f) as u32 - 1;
                    }
                }
            }
        }
        let mut valence = subsurf_memory::with_capacity(all.len());
        valence.extend(all.iter().map(|fan| fan.smooth_valence().unwrap_or(0)));
        Self { all, valence }
    }
}

impl Fan {
    const SMOOTH: u32 = 1 << 31;

    /// The fan that starts at the vertex' leading half-edge.
    #[inline]
    pub fn of(t: &Topology, v: Vertex) -> Self {
        let (mut faces, mut points, mut quads) = (0, 0, true);
        let closed = t.walk_fan(v, |h| {
            let sides = t.sides_at(h) as u32;
            faces += 1;
            points += sides - 2;
            quads &= sides == 4;
        });
        let smooth = t.vertex_sharpness(v) == 0.0 && t.sharp_edges(v).is_empty() && t.foreign_sharpness(v).is_empty();
        let smooth = closed && quads && smooth && !t.vertex_non_manifold[v.index()];
        Self(if smooth { faces | Self::SMOOTH } else { points + u32::from(!closed) })
    }

    /// Valence of a smooth vertex, where it is neither too small nor too large for rings to be read directly.
    #[inline]
    pub fn smooth_valence(self) -> Option<u8> {
        let valence = self.0 & !Self::SMOOTH;
        (self.0 & Self::SMOOTH != 0 && VALENCES.contains(&valence)).then_some(valence as u8)
    }

    /// Vertices of the faces but the one in the middle, at most.
    pub fn points(self) -> usize {
        let count = (self.0 & !Self::SMOOTH) as usize;
        if self.0 & Self::SMOOTH != 0 { 2 * count } else { count }
    }
}
