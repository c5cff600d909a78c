//! Which vertices have quads alone round them with nothing sharp between, and how many faces lie round all others.

use super::smooth_ring::VALENCES;
use crate::index::{Face, Vertex};
use crate::topology::{FanSize, Topology};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Those of all vertices.
pub(super) struct Fans {
    sizes: Vec<FanSize>,
    /// Valence of *smooth* vertices: interior manifold ones of quads with nothing sharp, where rings can be read directly; 0 of all
    /// others. Small, since every face asks for it several times.
    pub valence: Vec<u8>,
    /// At non-manifold vertices, which have faces beyond the fan, how many vertices these faces have beside it, at most.
    non_manifold: BTreeMap<u32, usize>,
}

/// Vertices that a thread takes at a time.
const SHARE: usize = 1 << 13;

impl Fans {
    /// `sizes` as the topology was built with, or none.
    pub fn new(t: &Topology, mut sizes: Vec<FanSize>) -> Self {
        let vertices = || (0..t.vertex_count() as u32).into_par_iter().with_min_len(SHARE).map(Vertex);
        if sizes.len() != t.vertex_count() {
            sizes = FanSize::all(t).0;
        }
        let mut non_manifold = BTreeMap::new();
        if t.vertex_non_manifold.contains(&true) {
            for f in (0..t.face_count()).map(Face::new) {
                for &v in t.face_vertices(f).iter().filter(|&&v| t.vertex_non_manifold[v as usize]) {
                    *non_manifold.entry(v).or_default() += t.sides(f) - 1;
                }
            }
        }
        let mut valence = subsurf_memory::with_capacity(sizes.len());
        vertices().map(|v| smooth_valence(t, v, sizes[v.index()]).unwrap_or(0)).collect_into_vec(&mut valence);
        Self { sizes, valence, non_manifold }
    }

    /// Vertices of the faces at `v` beside it, at most.
    pub fn points(&self, t: &Topology, v: u32) -> usize {
        match t.vertex_non_manifold[v as usize] {
            true => self.non_manifold.get(&v).copied().unwrap_or(0),
            false => self.sizes[v as usize].points(t, Vertex(v)),
        }
    }
}

/// Valence of a smooth vertex, where it is neither too small nor too large for rings to be read directly.
#[inline]
pub(super) fn smooth_valence(t: &Topology, v: Vertex, size: FanSize) -> Option<u8> {
    let valence = size.closed_quads().filter(|&valence| VALENCES.contains(&(valence as u32)))?;
    let is_sharp = t.vertex_sharpness.code(v.index()) != 0 || !t.sharp_edges(v).is_empty();
    let is_odd = t.vertex_non_manifold[v.index()] || !t.foreign_sharpness(v).is_empty();
    (!is_sharp && !is_odd).then_some(valence as u8)
}
