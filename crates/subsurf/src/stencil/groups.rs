//! Control faces in groups of equal surroundings: the rows of one face of a group, over its ring, are those of all.
//!
//! Unlike the patches of a [`PatchTable`](crate::PatchTable), faces are taken whole, whatever their number of corners,
//! and holes are faces like others: refinement goes on inside them.

use crate::index::Face;
use crate::limit::KeyHasher;
use crate::mesh::{MAX_COUNT, MeshError};
use crate::topology::{Surroundings, Topology, Walk};
use rayon::prelude::*;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::hash::BuildHasherDefault;

/// Faces a thread takes at a time. Fixed, so that groups get the same numbers for any number of threads.
const CHUNK: usize = 2048;

/// Control points that all rings together may have beyond 64 per face: a gigabyte. A pole of valence n has n rings of
/// 2 n points; 2^28 allows one of 11,000.
const MOST_RING_POINTS: usize = 1 << 28;

type Keys = HashMap<Box<[u32]>, u32, BuildHasherDefault<KeyHasher>>;

/// Every face's group and ring.
pub(super) struct FaceGroups {
    group: Vec<u32>,
    offset: Vec<u32>,
    ring: Vec<u32>,
    /// The first face of every group.
    pub representatives: Vec<Face>,
}

impl FaceGroups {
    /// Groups the faces, in parallel.
    pub fn new(t: &Topology) -> Result<Self, MeshError> {
        check_rings(t)?;
        let chunks: Vec<Gathered> =
            (0..t.face_count().div_ceil(CHUNK)).into_par_iter().map(|chunk| Gathered::of_chunk(t, chunk)).collect();
        refuse_beyond(MAX_COUNT, chunks.iter().map(|c| c.ring.len()).sum())?;
        let mut out = Self { group: Vec::new(), offset: vec![0], ring: Vec::new(), representatives: Vec::new() };
        let mut known = Keys::default();
        for chunk in chunks {
            let mut renumber = Vec::with_capacity(chunk.keys.len());
            for (key, face) in chunk.keys {
                let next = known.len() as u32;
                renumber.push(match known.entry(key) {
                    Entry::Occupied(group) => *group.get(),
                    Entry::Vacant(empty) => {
                        out.representatives.push(face);
                        *empty.insert(next)
                    }
                });
            }
            out.group.extend(chunk.group.iter().map(|&g| renumber[g as usize]));
            let start = out.ring.len() as u32;
            out.offset.extend(chunk.end.iter().map(|end| start + end));
            out.ring.extend_from_slice(&chunk.ring);
        }
        Ok(out)
    }

    pub fn group(&self, face: Face) -> usize {
        self.group[face.index()] as usize
    }

    /// The control points that the face's rows are over: those of all faces that touch it.
    pub fn ring(&self, face: Face) -> &[u32] {
        &self.ring[self.offset[face.index()] as usize..self.offset[face.index() + 1] as usize]
    }

    /// For every entry of [`ring`](Self::ring), all faces one after another: control points in ascending order, and the
    /// position that each has in the ring.
    pub fn ascending(&self) -> Ascending<'_> {
        let mut entry = vec![(0u32, 0u32); self.ring.len()];
        let mut rest = &mut entry[..];
        let mut parts = Vec::with_capacity(self.group.len());
        for face in self.offset.windows(2) {
            let (part, tail) = rest.split_at_mut((face[1] - face[0]) as usize);
            parts.push((part, &self.ring[face[0] as usize..face[1] as usize]));
            rest = tail;
        }
        parts.into_par_iter().for_each(|(part, ring)| {
            part.iter_mut().zip(ring).enumerate().for_each(|(slot, (entry, &v))| *entry = (v, slot as u32));
            part.sort_unstable();
        });
        Ascending { groups: self, entry }
    }
}

/// Rings in ascending order.
pub(super) struct Ascending<'a> {
    pub groups: &'a FaceGroups,
    entry: Vec<(u32, u32)>,
}

impl Ascending<'_> {
    /// Control points of the ring of `face` in ascending order, each with its position in the ring.
    pub fn ring(&self, face: Face) -> &[(u32, u32)] {
        let offset = &self.groups.offset;
        &self.entry[offset[face.index()] as usize..offset[face.index() + 1] as usize]
    }
}

/// Refuses meshes whose rings would not fit into memory, before any is made.
fn check_rings(t: &Topology) -> Result<(), MeshError> {
    // Round an interior vertex a face adds its corners but two; a ring may have a few points more at boundaries.
    let mut around = vec![1usize; t.vertex_count()];
    for f in (0..t.face_count() as u32).map(Face) {
        t.face_vertices(f).iter().for_each(|&v| around[v as usize] += t.sides(f) - 2);
    }
    let count: usize = t.corners().iter().map(|&v| around[v as usize]).sum();
    refuse_beyond(MOST_RING_POINTS + 64 * t.face_count(), count)
}

fn refuse_beyond(limit: usize, count: usize) -> Result<(), MeshError> {
    if count > limit {
        let what = "control points round its faces (a vertex of n faces needs n² of them)";
        return Err(MeshError::TooLarge { what, count, limit });
    }
    Ok(())
}

/// One chunk of faces, groups numbered within the chunk.
#[derive(Default)]
struct Gathered {
    group: Vec<u32>,
    end: Vec<u32>,
    ring: Vec<u32>,
    /// Distinct keys in order of appearance, each with its first face.
    keys: Vec<(Box<[u32]>, Face)>,
}

impl Gathered {
    fn of_chunk(t: &Topology, chunk: usize) -> Self {
        let mut out = Self::default();
        let mut known = Keys::default();
        let (mut walk, mut around) = (Walk::default(), Surroundings::default());
        for face in (chunk * CHUNK..((chunk + 1) * CHUNK).min(t.face_count())).map(Face::new) {
            t.surroundings(face, 0, &mut walk, &mut around);
            let group = match known.get(&around.key[..]) {
                Some(&group) => group,
                None => {
                    let group = out.keys.len() as u32;
                    let key: Box<[u32]> = around.key.clone().into();
                    known.insert(key.clone(), group);
                    out.keys.push((key, face));
                    group
                }
            };
            out.group.push(group);
            out.ring.extend_from_slice(&around.ring);
            out.end.push(out.ring.len() as u32);
        }
        out
    }
}
