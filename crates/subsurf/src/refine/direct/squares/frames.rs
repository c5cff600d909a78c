//! What is kept from the second set of values on: numbers of the points round quads that start at their control points, which to
//! find by half-edges takes a sixth of a frame, and tables of fans. To keep them pays where frames come.

use super::super::fans::FanTables;
use super::read::{CONTROL_QUAD, ControlQuad, Surroundings};
use crate::index::Face;
use crate::topology::{FaceOf, Topology};
use rayon::prelude::*;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// By control face the points round it, row by row; its own are in the topology. Of others than these quads, nothing of use.
pub(in super::super) type Ring = [u32; CONTROL_QUAD - 4];

/// All that is kept.
pub(in super::super) struct Tables {
    pub rings: Vec<Ring>,
    /// Where there are fans.
    pub fans: Option<FanTables>,
}

/// Nothing before the second use.
#[derive(Default)]
pub(in super::super) struct Frames {
    was_used: AtomicBool,
    tables: OnceLock<Tables>,
}

impl Frames {
    /// True from the second time on.
    pub fn had_one(&self) -> bool {
        self.was_used.load(Ordering::Relaxed)
    }

    /// None the first time.
    pub fn tables(&self, make: impl FnOnce() -> Tables) -> Option<&Tables> {
        if !self.was_used.swap(true, Ordering::Relaxed) {
            return None;
        }
        // Not made while others wait: threads that wait for each other may do each other's work.
        if self.tables.get().is_none() {
            let _ = self.tables.set(make());
        }
        self.tables.get()
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        self.tables
            .get()
            .map_or(0, |Tables { rings, fans }| size_of_val(&rings[..]) + fans.as_ref().map_or(0, FanTables::bytes))
    }
}

impl Surroundings<CONTROL_QUAD> for &[Ring] {
    const SIZE: usize = 1;

    #[inline(always)]
    fn of(&self, t: &Topology, first: u32) -> [u32; CONTROL_QUAD] {
        let [a, b, c, d, e, f, g, h, i, j, k, l] = self[t.face.get(first) as usize];
        let own: &[u32; 4] = t.origin[first as usize..].first_chunk().expect("four corners");
        [a, b, c, d, e, own[0], own[1], f, g, own[3], own[2], h, i, j, k, l]
    }
}

/// The rings of all faces.
pub(in super::super) fn rings(t: &Topology, is_early: impl Fn(u32) -> bool + Sync) -> Vec<Ring> {
    let is_quads = matches!(t.face, FaceOf::Quads);
    let ring = |f: usize| match t.first(Face::new(f)) {
        first if is_quads => ControlQuad::<true>.of(t, first),
        first if t.sides(Face::new(f)) == 4 && is_early(first) => ControlQuad::<false>.of(t, first),
        _ => [0; CONTROL_QUAD],
    };
    let round = |f: usize| {
        let [a, b, c, d, e, _, _, f, g, _, _, h, i, j, k, l] = ring(f);
        [a, b, c, d, e, f, g, h, i, j, k, l]
    };
    let mut out = subsurf_memory::with_capacity(t.face_count());
    (0..t.face_count()).into_par_iter().with_min_len(SHARE).map(round).collect_into_vec(&mut out);
    out
}

/// Faces that a thread takes at least.
const SHARE: usize = 1 << 10;
