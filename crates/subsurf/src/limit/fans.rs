//! Which vertices have quads alone round them with nothing sharp between, and how many vertices the faces round any vertex have
//! beside it.

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
    /// What [`points`](Self::points) says at vertices where sizes do not tell: non-manifold ones, which have faces beyond the fan,
    /// and poles, whose fans are too large to be walked round once per face.
    points: BTreeMap<u32, usize>,
}

/// Vertices that a thread takes at a time.
const SHARE: usize = 1 << 13;

/// Vertices that are looked at together: in most meshes most of them have nothing that is sharp.
const BLOCK: usize = 128;

impl Fans {
    /// `sizes` as the topology was built with, or none.
    pub fn new(t: &Topology, mut sizes: Vec<FanSize>) -> Self {
        let vertices = || (0..t.vertex_count() as u32).into_par_iter().with_min_len(SHARE).map(Vertex);
        if sizes.len() != t.vertex_count() {
            sizes = FanSize::all(t).0;
        }
        let is_pole = |v: &Vertex| sizes[v.index()].few_points().is_none() && !t.is_non_manifold_vertex(*v);
        let poles: Vec<_> = vertices().filter(is_pole).map(|v| (v.0, FanSize::count_points(t, v))).collect();
        let mut points: BTreeMap<u32, usize> = poles.into_iter().collect();
        if t.vertex_non_manifold.contains(&true) {
            for f in (0..t.face_count()).map(Face::new) {
                for &v in t.face_vertices(f).iter().filter(|&&v| t.vertex_non_manifold[v as usize]) {
                    *points.entry(v).or_default() += t.sides(f) - 1;
                }
            }
        }
        let mut valence = subsurf_memory::zeroed(sizes.len());
        let blocks = valence.par_chunks_mut(BLOCK).zip(sizes.par_chunks(BLOCK)).enumerate().with_min_len(SHARE / BLOCK);
        blocks.for_each(|(block, (valence, sizes))| {
            let first = block * BLOCK;
            let entries = valence.iter_mut().zip(sizes);
            if t.nothing_is_sharp(first..first + sizes.len()) {
                entries.for_each(|(valence, &size)| *valence = readable_valence(size).unwrap_or(0));
            } else {
                let vertices = (first as u32..).map(Vertex);
                entries
                    .zip(vertices)
                    .for_each(|((valence, &size), v)| *valence = smooth_valence(t, v, size).unwrap_or(0));
            }
        });
        Self { sizes, valence, points }
    }

    /// Vertices whose faces have at least `least` points beside them, and how many points.
    pub fn many_points<'a>(&'a self, t: &'a Topology, least: usize) -> impl Iterator<Item = (u32, usize)> + 'a {
        // Hardly a block has one.
        let may_have = move |sizes: &[FanSize]| sizes.iter().fold(false, |any, size| any | size.may_have_points(least));
        let blocks = self.sizes.chunks(BLOCK).zip((0u32..).step_by(BLOCK)).filter(move |(sizes, _)| may_have(sizes));
        let of_blocks = blocks.flat_map(|(sizes, first)| first..first + sizes.len() as u32);
        let few = of_blocks.filter(|v| !self.points.contains_key(v)).map(|v| (v, self.points(t, v)));
        few.chain(self.points.iter().map(|(&v, &points)| (v, points))).filter(move |&(_, points)| points >= least)
    }

    /// Vertices of the faces at `v` beside it, at most.
    pub fn points(&self, t: &Topology, v: u32) -> usize {
        let few = if t.vertex_non_manifold[v as usize] { None } else { self.sizes[v as usize].few_points() };
        few.unwrap_or_else(|| self.points.get(&v).copied().unwrap_or(0))
    }
}

/// Valence of a smooth vertex, where it is neither too small nor too large for rings to be read directly.
#[inline]
pub(super) fn smooth_valence(t: &Topology, v: Vertex, size: FanSize) -> Option<u8> {
    let valence = readable_valence(size)?;
    let is_sharp = t.vertex_sharpness.code(v.index()) != 0 || !t.sharp_edges(v).is_empty();
    let is_odd = t.vertex_non_manifold[v.index()] || !t.foreign_sharpness(v).is_empty();
    (!is_sharp && !is_odd).then_some(valence)
}

/// The same where there is nothing sharp.
#[inline]
fn readable_valence(size: FanSize) -> Option<u8> {
    size.closed_quads().filter(|&valence| VALENCES.contains(&(valence as u32))).map(|valence| valence as u8)
}
