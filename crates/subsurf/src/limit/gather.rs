//! What a patch table holds per patch: which plan, turned how, over which ring. Gathered chunk by chunk, in parallel.
//!
//! Most patches are quads among quads with nothing sharp nearby. Their rings are read off the half-edges, straight into the
//! first part of the list of all rings; the rings of others come from walks round the face, and follow.

use super::plan_key::{Key, Keys, canonical_corner};
use super::regular_ring::{is_distinct, regular_ring};
use crate::index::{Face, Vertex};
use crate::mesh::{MAX_COUNT, MeshError};
use crate::topology::{NONE, Surroundings, Topology, Walk};
use rayon::prelude::*;
use std::collections::hash_map::Entry;
use std::ops::Range;

/// Faces a thread takes at a time. Fixed, so that plans get the same numbers for any number of threads.
const CHUNK: usize = 2048;

/// A face, and the corner that its walk starts at.
pub(super) type Start = (u32, u32);

/// Everything per patch, plans numbered by first appearance in the mesh.
pub(super) struct Gathered {
    pub patch_plan: Vec<u32>,
    pub patch_turn: Vec<u8>,
    pub ring_start: Vec<u32>,
    pub ring: Vec<u32>,
    /// Per plan a face, and the corner that its walk starts at.
    pub representatives: Vec<Start>,
    /// Plan of every key.
    pub known: Keys,
}

impl Gathered {
    /// `whole` is the number of corners of a face that is one patch; `face_patch` the first patch of every face.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`] where rings would not fit into memory or into 32-bit indices.
    pub fn new(t: &Topology, whole: usize, face_patch: &[u32]) -> Result<Self, MeshError> {
        let fans = Fan::all(t);
        let patches = face_patch[t.face_count()] as usize;
        let sizes: Vec<Size> = (0..t.face_count().div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| faces_of(t, chunk).map(|f| Size::of(t, whole, &fans, Face::new(f))).sum())
            .collect();
        let size: Size = sizes.iter().copied().sum();
        size.check(patches)?;

        let (mut patch_plan, mut patch_turn) = (vec![NONE; patches], vec![0; patches]);
        let (mut ring_start, mut ring) = (vec![0; patches], vec![0; 16 * size.regular + size.others]);
        let (regular, mut others) = ring.split_at_mut(16 * size.regular);
        let lists = Lists { plan: &mut patch_plan, turn: &mut patch_turn, start: &mut ring_start, regular };
        let mut chunks = lists.chunks(t, face_patch, &sizes);
        let mut met: Vec<Met> =
            chunks.par_iter_mut().map_init(Scratch::default, |own, c| c.gather(t, whole, &fans, own)).collect();

        let (mut representatives, mut known) = (Vec::new(), Keys::default());
        let mut end = 16 * size.regular;
        let mut rest = Vec::with_capacity(met.len());
        for chunk in &mut met {
            let plans: Vec<u32> =
                chunk.keys.drain(..).map(|(key, place)| number(key, place, &mut known, &mut representatives)).collect();
            let (own, more) = others.split_at_mut(chunk.ring.len());
            rest.push((end, plans, own));
            others = more;
            end += chunk.ring.len();
        }
        if end > MAX_COUNT {
            return Err(MeshError::TooLarge { what: "control points in rings", count: end, limit: MAX_COUNT });
        }
        chunks.into_par_iter().zip(met).zip(rest).for_each(|((chunk, met), (base, plans, others))| {
            chunk.plan.iter_mut().filter(|plan| **plan != NONE).for_each(|plan| *plan = plans[*plan as usize]);
            met.walked.iter().for_each(|&patch| chunk.start[patch as usize] += base as u32);
            others.copy_from_slice(&met.ring);
        });
        ring.truncate(end);
        ring.shrink_to_fit();
        Ok(Self { patch_plan, patch_turn, ring_start, ring, representatives, known })
    }
}

fn number(key: Key, place: Start, known: &mut Keys, representatives: &mut Vec<Start>) -> u32 {
    let next = known.len() as u32;
    match known.entry(key) {
        Entry::Occupied(plan) => *plan.get(),
        Entry::Vacant(empty) => {
            representatives.push(place);
            *empty.insert(next)
        }
    }
}

fn faces_of(t: &Topology, chunk: usize) -> Range<usize> {
    chunk * CHUNK..((chunk + 1) * CHUNK).min(t.face_count())
}

/// The faces at a vertex: how many, and whether it is *plain*, an interior vertex of four quads with nothing sharp.
#[derive(Clone, Copy)]
pub(super) struct Fan(u32);

impl Fan {
    const PLAIN: u32 = 1 << 31;

    /// Those of all vertices.
    fn all(t: &Topology) -> Vec<Self> {
        let vertices = (0..t.vertex_count() as u32).into_par_iter().with_min_len(CHUNK).map(Vertex);
        let mut fans: Vec<Self> = vertices.map(|v| Self::of(t, v)).collect();
        if t.vertex_non_manifold.contains(&true) {
            // There are faces beyond the fan.
            t.vertex_non_manifold
                .iter()
                .zip(&mut fans)
                .filter(|(non_manifold, _)| **non_manifold)
                .for_each(|f| *f.1 = Self(0));
            for &v in t.corners() {
                if t.vertex_non_manifold[v as usize] {
                    fans[v as usize].0 += 1;
                }
            }
        }
        fans
    }

    /// The fan that starts at the vertex' leading half-edge.
    pub fn of(t: &Topology, v: Vertex) -> Self {
        let Some(start) = t.outgoing(v) else { return Self(0) };
        let (mut at, mut faces, mut quads) = (start, 1, t.sides(t.face(start)) == 4);
        let closed = loop {
            match t.turn_left(at) {
                None => break false,
                Some(h) if h == start => break true,
                Some(h) => at = h,
            }
            faces += 1;
            quads &= t.sides(t.face(at)) == 4;
        };
        let smooth = t.vertex_sharpness(v) == 0.0 && t.sharp_edges(v).is_empty() && t.foreign_sharpness(v).is_empty();
        let plain = closed && faces == 4 && quads && smooth && !t.vertex_non_manifold[v.index()];
        Self(faces | if plain { Self::PLAIN } else { 0 })
    }

    pub fn is_plain(self) -> bool {
        self.0 & Self::PLAIN != 0
    }

    fn faces(self) -> usize {
        (self.0 & !Self::PLAIN) as usize
    }
}

/// How much memory rings take.
#[derive(Clone, Copy, Default)]
struct Size {
    /// Quads whose corners are plain.
    regular: usize,
    /// Control points in the rings of other patches, at most.
    others: usize,
}

/// Control points that all rings together may have beyond 64 per patch: a gigabyte. A pole of valence n has n rings of
/// 2 n points; 2^28 allows one of 11,000.
const MOST_RING_POINTS: usize = 1 << 28;

impl Size {
    fn of(t: &Topology, whole: usize, fans: &[Fan], face: Face) -> Self {
        let corners = t.face_vertices(face);
        if t.is_hole(face) {
            return Self::default();
        }
        if is_regular(whole, fans, corners) {
            return Self { regular: 1, others: 0 };
        }
        // A face at a vertex adds at most its corners but two to the ring; n-gons have n patches.
        let ring = corners.iter().map(|&v| 2 * fans[v as usize].faces()).sum::<usize>();
        Self { regular: 0, others: if corners.len() == whole { ring } else { corners.len() * ring } }
    }

    /// Refuses meshes whose rings would not fit into memory, before any is made.
    fn check(self, patches: usize) -> Result<(), MeshError> {
        let (count, limit) = (16 * self.regular + self.others, MOST_RING_POINTS + 64 * patches);
        if count > limit {
            let what = "control points round its faces (a vertex of n faces needs n² of them)";
            return Err(MeshError::TooLarge { what, count, limit });
        }
        Ok(())
    }
}

impl std::iter::Sum for Size {
    fn sum<I: Iterator<Item = Self>>(sizes: I) -> Self {
        sizes.fold(Self::default(), |a, b| Self { regular: a.regular + b.regular, others: a.others + b.others })
    }
}

fn is_regular(whole: usize, fans: &[Fan], corners: &[u32]) -> bool {
    whole == 4 && corners.len() == 4 && corners.iter().all(|&v| fans[v as usize].is_plain())
}

/// Tables per patch, and the rings of regular patches, or the part of them that belongs to some faces.
struct Lists<'a> {
    plan: &'a mut [u32],
    turn: &'a mut [u8],
    start: &'a mut [u32],
    regular: &'a mut [u32],
}

/// Some faces, and their part of the tables.
struct Chunk<'a> {
    faces: Range<usize>,
    /// Where the rings of its regular patches start.
    base: usize,
    plan: &'a mut [u32],
    turn: &'a mut [u8],
    start: &'a mut [u32],
    regular: &'a mut [u32],
}

impl<'a> Lists<'a> {
    fn chunks(self, t: &Topology, face_patch: &[u32], sizes: &[Size]) -> Vec<Chunk<'a>> {
        let Self { mut plan, mut turn, mut start, mut regular } = self;
        let mut base = 0;
        let cut = |(chunk, size): (usize, &Size)| {
            let faces = faces_of(t, chunk);
            let patches = (face_patch[faces.end] - face_patch[faces.start]) as usize;
            let chunk = Chunk {
                faces,
                base,
                plan: plan.split_off_mut(..patches).unwrap_or_default(),
                turn: turn.split_off_mut(..patches).unwrap_or_default(),
                start: start.split_off_mut(..patches).unwrap_or_default(),
                regular: regular.split_off_mut(..16 * size.regular).unwrap_or_default(),
            };
            base += 16 * size.regular;
            chunk
        };
        sizes.iter().enumerate().map(cut).collect()
    }
}

/// Memory for one walk after the other.
#[derive(Default)]
struct Scratch {
    walk: Walk,
    around: Surroundings,
}

/// What a chunk needs beyond its part of the tables, plans numbered within the chunk.
#[derive(Default)]
struct Met {
    /// Distinct keys in order of appearance, each with the face that it was first met at.
    keys: Vec<(Key, Start)>,
    /// Patches whose rings come from walks, and these rings.
    walked: Vec<u32>,
    ring: Vec<u32>,
}

impl Chunk<'_> {
    fn gather(&mut self, t: &Topology, whole: usize, fans: &[Fan], scratch: &mut Scratch) -> Met {
        let mut met = Met::default();
        let mut known = Keys::default();
        let mut regular_plan = None;
        let (mut patch, mut rings) = (0, 0);
        for face in self.faces.clone().map(Face::new) {
            let sides = t.sides(face);
            let starts = if sides == whole { 0..1 } else { 0..sides };
            if t.is_hole(face) {
                patch += starts.len();
                continue;
            }
            if is_regular(whole, fans, t.face_vertices(face)) {
                let ring = regular_ring(t, face);
                let own = rings..rings + 16;
                rings += 16;
                // Where a mesh is so small that faces round this one are the same, the place stays empty.
                if is_distinct(&ring) {
                    let plan = *regular_plan.get_or_insert_with(|| {
                        let plan = met.walk(t, face, canonical_corner(t, face), &mut known, scratch);
                        debug_assert_eq!(scratch.around.ring, ring);
                        plan
                    });
                    self.plan[patch] = plan;
                    self.start[patch] = (self.base + own.start) as u32;
                    self.regular[own].copy_from_slice(&ring);
                    patch += 1;
                    continue;
                }
            }
            for subface in starts {
                let start = if sides == whole { canonical_corner(t, face) } else { subface };
                let plan = met.walk(t, face, start, &mut known, scratch);
                met.walked.push(patch as u32);
                self.plan[patch] = plan;
                self.turn[patch] = if sides == whole { start as u8 } else { 0 };
                self.start[patch] = met.ring.len() as u32;
                met.ring.extend_from_slice(&scratch.around.ring);
                patch += 1;
            }
        }
        met
    }
}

impl Met {
    /// Walks round a face from corner `start`, and finds or makes the plan's number.
    fn walk(&mut self, t: &Topology, face: Face, start: usize, known: &mut Keys, scratch: &mut Scratch) -> u32 {
        let around = &mut scratch.around;
        t.surroundings(face, start, &mut scratch.walk, around);
        known.get(&around.key[..]).copied().unwrap_or_else(|| {
            let plan = self.keys.len() as u32;
            self.keys.push((around.key.clone().into(), (face.0, start as u32)));
            known.insert(around.key.clone().into(), plan);
            plan
        })
    }
}
