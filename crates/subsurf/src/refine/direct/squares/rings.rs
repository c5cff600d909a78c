//! Numbers of the points round quads that start at their control points, kept from the second set of values on: to find them
//! by half-edges takes a sixth of a frame, to keep them pays where frames come.

use super::read::{CONTROL_QUAD, ControlQuad, Surroundings};
use crate::index::Face;
use crate::topology::{FaceOf, Topology};
use rayon::prelude::*;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// By control face; of others than these quads, nothing of use.
pub(in super::super) type Ring = [u32; CONTROL_QUAD];

/// Nothing before the second use.
#[derive(Default)]
pub(in super::super) struct Rings {
    was_used: AtomicBool,
    rings: OnceLock<Vec<Ring>>,
}

impl Rings {
    /// None the first time.
    pub fn get(&self, t: &Topology, is_early: impl Fn(u32) -> bool + Sync) -> Option<&[Ring]> {
        if !self.was_used.swap(true, Ordering::Relaxed) {
            return None;
        }
        // Not made while others wait: threads that wait for each other may do each other's work.
        if self.rings.get().is_none() {
            let _ = self.rings.set(made(t, is_early));
        }
        self.rings.get().map(Vec::as_slice)
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        self.rings.get().map_or(0, |rings| size_of_val(&rings[..]))
    }
}

impl Surroundings<CONTROL_QUAD> for &[Ring] {
    const SIZE: usize = 1;

    #[inline(always)]
    fn of(&self, t: &Topology, first: u32) -> Ring {
        self[t.face.get(first) as usize]
    }
}

fn made(t: &Topology, is_early: impl Fn(u32) -> bool + Sync) -> Vec<Ring> {
    let is_quads = matches!(t.face, FaceOf::Quads);
    let ring = |f: usize| match t.first(Face::new(f)) {
        first if is_quads => ControlQuad::<true>.of(t, first),
        first if t.sides(Face::new(f)) == 4 && is_early(first) => ControlQuad::<false>.of(t, first),
        _ => [0; CONTROL_QUAD],
    };
    let mut out = subsurf_memory::with_capacity(t.face_count());
    (0..t.face_count()).into_par_iter().with_min_len(SHARE).map(ring).collect_into_vec(&mut out);
    out
}

/// Faces that a thread takes at least.
const SHARE: usize = 1 << 10;
