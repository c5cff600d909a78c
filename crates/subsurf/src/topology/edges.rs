//! Edges, numbered in the order in which the faces first name them.

use super::NONE;
use super::build::{SHARE, shared};
use super::matching::FaceList;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Edges by half-edge, their ends in the direction of their leaders, and these.
pub(super) struct Edges {
    pub of_half_edge: Vec<u32>,
    pub vertices: Vec<[u32; 2]>,
    pub half_edge: Vec<u32>,
}

impl Edges {
    /// From twins, and the half-edges that follow another without being its twin.
    pub fn number(list: FaceList<'_>, twin: &[u32], followers: &[(u32, u32)]) -> Self {
        let pieces = twin.len().div_ceil(SHARE);
        let piece = |p: usize| p * SHARE..((p + 1) * SHARE).min(twin.len());
        let followers_in = |p: usize| {
            let at = |h: usize| followers.partition_point(|f| (f.0 as usize) < h);
            &followers[at(piece(p).start)..at(piece(p).end)]
        };
        // An edge begins at its leader: the smaller of two twins, or a half-edge without one that follows no other.
        let leaders = |p: usize| {
            let first = twin[piece(p)].iter().zip(p as u32 * SHARE as u32..).filter(|&(&twin, h)| twin > h).count();
            first - followers_in(p).len()
        };
        let counts: Vec<usize> = (0..pieces).into_par_iter().map(leaders).collect();
        let count = counts.iter().sum();
        let of_half_edge = shared(twin.len(), 0);
        // Memory that comes zeroed is not written twice.
        let (mut vertices, mut half_edge) = (vec![[0; 2]; count], subsurf_memory::zeroed(count));
        subsurf_memory::advise(&mut vertices);
        let mut tasks = Vec::with_capacity(pieces);
        let (mut v, mut h) = (&mut vertices[..], &mut half_edge[..]);
        let mut first = 0u32;
        for (p, &count) in counts.iter().enumerate() {
            let own = (v.split_off_mut(..count).unwrap_or_default(), h.split_off_mut(..count).unwrap_or_default());
            tasks.push((p, first, own));
            first += count as u32;
        }
        tasks.into_par_iter().for_each(|(p, first, (vertices, half_edge))| {
            let mut followers = followers_in(p).iter().peekable();
            let mut k = 0;
            for h in piece(p).map(|h| h as u32) {
                let is_leader = twin[h as usize] > h && followers.next_if(|f| f.0 == h).is_none();
                // Written whether or not it is one: which half-edges are cannot be guessed.
                let Some(row) = half_edge.get_mut(k) else { break };
                *row = h;
                k += usize::from(is_leader);
            }
            for ((&h, ends), edge) in half_edge.iter().zip(vertices).zip(first..) {
                let next = list.face.next(h, list.face_offset);
                *ends = [list.origin[h as usize], list.origin[next as usize]];
                of_half_edge[h as usize].store(edge, Relaxed);
                // None where there is no twin.
                if let Some(of_twin) = of_half_edge.get(twin[h as usize] as usize) {
                    of_twin.store(edge, Relaxed);
                }
            }
        });
        let mut of_half_edge: Vec<u32> = of_half_edge.into_iter().map(AtomicU32::into_inner).collect();
        for &(h, leader) in followers {
            of_half_edge[h as usize] = of_half_edge[leader as usize];
        }
        Self { of_half_edge, vertices, half_edge }
    }
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
