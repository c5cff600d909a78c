//! Edges, numbered in the order in which the faces first name them.

use super::NONE;
use super::build::SHARE;
use rayon::prelude::*;

/// Edges by half-edge, their ends in the direction of their leaders, and these.
pub(super) struct Edges {
    pub of_half_edge: Vec<u32>,
    pub vertices: Vec<[u32; 2]>,
    pub half_edge: Vec<u32>,
}

/// Half-edges without twins, ascending.
pub(super) fn twinless(twin: &[u32]) -> Vec<u32> {
    // Most blocks have none.
    let block = |(b, block): (usize, &[u32])| {
        let mut out = Vec::new();
        let has_some = block.iter().fold(0, |most, &t| t.max(most)) == NONE;
        if has_some {
            out.extend((b * BLOCK..).zip(block).filter(|(_, twin)| **twin == NONE).map(|(h, _)| h as u32));
        }
        out
    };
    let blocks = twin.par_chunks(BLOCK).enumerate().with_min_len(SHARE / BLOCK);
    blocks.flat_map_iter(block).collect()
}

/// Half-edges that are looked at together.
const BLOCK: usize = 256;
