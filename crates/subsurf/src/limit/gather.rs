//! What a patch table holds per patch: which plan, turned how, over which ring. Gathered chunk by chunk, in parallel.
//!
//! Most patches are quads with [smooth corners](super::smooth_ring). Their rings are read off the half-edges, straight into
//! the first part of the list of all rings. Of others, the first with certain [fans](super::fan_class) at its corners is walked
//! round, which tells its plan; further ones take the plan, and their rings are read off the half-edges too.

use super::fan_class::{self, ByFace, FaceKey, FanClasses};
use super::fans::Fans;
use super::plan_key::{Key, KeyHasher, Keys, canonical_corner};
use super::smooth_ring::{self, Valences, is_distinct};
use crate::index::Face;
use crate::mesh::{MAX_COUNT, MeshError};
use crate::topology::{NONE, Surroundings, Topology, Walk};
use rayon::prelude::*;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::hash::BuildHasherDefault;
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
        let fans = Fans::new(t);
        let patches = face_patch[t.face_count()] as usize;
        let sizes: Vec<Size> = (0..t.face_count().div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| faces_of(t, chunk).map(|f| Size::of(t, whole, &fans, Face::new(f))).sum())
            .collect();
        let size: Size = sizes.iter().copied().sum();
        size.check(patches)?;

        let (mut patch_plan, mut patch_turn) =
            (subsurf_memory::with_capacity(patches), subsurf_memory::zeroed(patches));
        patch_plan.resize(patches, NONE);
        // Memory that comes zeroed costs nothing until threads write to it.
        let (mut ring_start, mut ring) =
            (subsurf_memory::zeroed(patches), subsurf_memory::zeroed(size.direct + size.others));
        let classes = FanClasses::new(t, &fans);
        let lists = Lists {
            plan: &mut patch_plan,
            turn: &mut patch_turn,
            start: &mut ring_start,
            direct: &mut ring[..size.direct],
        };
        let mut chunks = lists.chunks(t, face_patch, &sizes);
        let mut met: Vec<Met> =
            chunks.par_iter_mut().map_init(Scratch::default, |own, c| c.gather(t, whole, &classes, own)).collect();

        let (mut representatives, mut known) = (Vec::new(), Keys::default());
        let mut end = size.direct;
        let chunks: Vec<_> = chunks.into_iter().map(|chunk| (chunk.plan, chunk.start)).collect();
        ring.resize(size.direct + met.iter().map(|chunk| chunk.ring.len()).sum::<usize>(), 0);
        let mut others = &mut ring[size.direct..];
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
        chunks.into_par_iter().zip(met).zip(rest).for_each(|(((plan, start), met), (base, plans, others))| {
            plan.iter_mut().filter(|plan| **plan != NONE).for_each(|plan| *plan = plans[*plan as usize]);
            met.walked.iter().for_each(|&patch| start[patch as usize] += base as u32);
            others.copy_from_slice(&met.ring);
        });
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

/// How much memory rings take.
#[derive(Clone, Copy, Default)]
struct Size {
    /// Control points in rings that are read directly.
    direct: usize,
    /// Control points in the rings of other patches, at most.
    others: usize,
}

/// Control points that all rings together may have beyond 64 per patch: a gigabyte. A pole of valence n has n rings of
/// 2 n points; 2^28 allows one of 11,000.
const MOST_RING_POINTS: usize = 1 << 28;

impl Size {
    fn of(t: &Topology, whole: usize, fans: &Fans, face: Face) -> Self {
        let corners = t.face_vertices(face);
        if t.is_hole(face) {
            return Self::default();
        }
        if let Some(valences) = valences(whole, &fans.valence, corners) {
            return Self { direct: smooth_ring::points(valences), others: 0 };
        }
        // The face itself is there once; what it adds at each of its corners is not. n-gons have n patches.
        let own = corners.len();
        let beyond = |&v: &u32| (fans.all[v as usize].points() + 2).saturating_sub(own);
        let ring = own + corners.iter().map(beyond).sum::<usize>();
        Self { direct: 0, others: if own == whole { ring } else { own * ring } }
    }

    /// Refuses meshes whose rings would not fit into memory, before any is made.
    fn check(self, patches: usize) -> Result<(), MeshError> {
        let (count, limit) = (self.direct + self.others, MOST_RING_POINTS + 64 * patches);
        if count > limit {
            let what = "control points round its faces (a vertex of n faces needs n² of them)";
            return Err(MeshError::TooLarge { what, count, limit });
        }
        Ok(())
    }
}

impl std::iter::Sum for Size {
    fn sum<I: Iterator<Item = Self>>(sizes: I) -> Self {
        sizes.fold(Self::default(), |a, b| Self { direct: a.direct + b.direct, others: a.others + b.others })
    }
}

/// Valences of a quad whose ring is read directly.
#[inline]
fn valences(whole: usize, valence: &[u8], corners: &[u32]) -> Option<Valences> {
    let &[a, b, c, d] = corners else { return None };
    let all = [a, b, c, d].map(|v| valence[v as usize]);
    (whole == 4 && all.iter().all(|&valence| valence != 0)).then_some(all)
}

/// Tables per patch, and the rings that are read directly.
struct Lists<'a, 'r> {
    plan: &'a mut [u32],
    turn: &'a mut [u8],
    start: &'a mut [u32],
    direct: &'r mut [u32],
}

/// Some faces, and their part of the tables.
struct Chunk<'a, 'r> {
    faces: Range<usize>,
    /// Where its rings start that are read directly.
    base: usize,
    plan: &'a mut [u32],
    turn: &'a mut [u8],
    start: &'a mut [u32],
    direct: &'r mut [u32],
}

impl<'a, 'r> Lists<'a, 'r> {
    fn chunks(self, t: &Topology, face_patch: &[u32], sizes: &[Size]) -> Vec<Chunk<'a, 'r>> {
        let Self { mut plan, mut turn, mut start, mut direct } = self;
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
                direct: direct.split_off_mut(..size.direct).unwrap_or_default(),
            };
            base += size.direct;
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
    ring: Vec<u32>,
}

/// What a chunk needs beyond its part of the tables, plans numbered within the chunk.
#[derive(Default)]
struct Met {
    /// Distinct keys in order of appearance, each with the face that it was first met at, and their numbers.
    keys: Vec<(Key, Start)>,
    known: Keys,
    alike: ByFace<Alike>,
    /// Patches whose rings come from walks, and these rings.
    walked: Vec<u32>,
    ring: Vec<u32>,
}

/// What the valences of a quad with smooth corners say: where its walk starts and, once it is met, the plan.
#[derive(Clone, Copy)]
struct Smooth {
    start: u8,
    plan: u32,
}

type SmoothPlans = HashMap<Valences, Smooth, BuildHasherDefault<KeyHasher>>;

impl Chunk<'_, '_> {
    fn gather(&mut self, t: &Topology, whole: usize, classes: &FanClasses<'_>, scratch: &mut Scratch) -> Met {
        let valence = classes.valence;
        let mut met = Met::default();
        let mut smooth = SmoothPlans::default();
        smooth.insert([4; 4], Smooth { start: 0, plan: NONE });
        self.read_rings(t, whole, valence, &mut smooth);
        let mut regular = NONE;
        let (mut patch, mut rings) = (0, 0);
        for face in self.faces.clone().map(Face::new) {
            let sides = t.sides(face);
            let starts = if sides == whole { 0..1 } else { 0..sides };
            if t.is_hole(face) {
                patch += starts.len();
                continue;
            }
            if let Some(valences) = valences(whole, valence, t.face_vertices(face)) {
                let own = rings..rings + smooth_ring::points(valences);
                rings = own.end;
                // In small meshes, where the ring is another one, the place stays unused.
                if is_distinct(&self.direct[own.clone()]) {
                    self.start[patch] = (self.base + own.start) as u32;
                    if valences == [4; 4] && regular != NONE {
                        self.plan[patch] = regular;
                        patch += 1;
                        continue;
                    }
                    let shared = smooth.get_mut(&valences).expect("its ring was read");
                    if shared.plan == NONE {
                        shared.plan = met.walk(t, face, usize::from(shared.start), scratch);
                        debug_assert_eq!(scratch.around.ring, self.direct[own]);
                    }
                    (self.plan[patch], self.turn[patch]) = (shared.plan, shared.start);
                    if valences == [4; 4] {
                        regular = shared.plan;
                    }
                    patch += 1;
                    continue;
                }
            }
            let fans = classes.of_face(t, face);
            for subface in starts {
                let (plan, start) = match sides == whole {
                    true => met.whole(t, face, fans, scratch),
                    false => met.subface(t, face, subface, fans, scratch),
                };
                met.walked.push(patch as u32);
                self.plan[patch] = plan;
                self.turn[patch] = if sides == whole { start as u8 } else { 0 };
                self.start[patch] = met.ring.len() as u32;
                met.ring.extend_from_slice(&scratch.ring);
                patch += 1;
            }
        }
        met
    }

    /// Reads the rings of quads with smooth corners, all before any is looked at: what was just written one by one is slow to
    /// load in fours.
    fn read_rings(&mut self, t: &Topology, whole: usize, valence: &[u8], smooth: &mut SmoothPlans) {
        let mut rings = 0;
        for face in self.faces.clone().map(Face::new).filter(|&face| !t.is_hole(face)) {
            let Some(valences) = valences(whole, valence, t.face_vertices(face)) else { continue };
            let start = if valences == [4; 4] {
                0
            } else {
                // Where the walk starts follows from the valences.
                let new = || Smooth { start: canonical_corner(t, face) as u8, plan: NONE };
                usize::from(smooth.entry(valences).or_insert_with(new).start)
            };
            let own = rings..rings + smooth_ring::points(valences);
            rings = own.end;
            let turned = std::array::from_fn(|c| valences[(start + c) % 4]);
            smooth_ring::read(t, face, start, turned, &mut self.direct[own]);
        }
    }
}

/// What the fans at the corners of a face say, from a certain corner on: at how many corners further walks start, and the plan.
#[derive(Clone, Copy)]
struct Alike {
    start: usize,
    plan: u32,
}

impl Met {
    /// The plan of a face that is one patch, and the corner that its walk starts at; its ring is left in `scratch`.
    fn whole(&mut self, t: &Topology, face: Face, fans: Option<FaceKey>, scratch: &mut Scratch) -> (u32, usize) {
        let sides = t.sides(face);
        let Some((fans, turn, period)) = fans.map(|fans| fan_class::least(&fans)) else {
            return self.walked(t, face, canonical_corner(t, face), scratch);
        };
        if let Some(&Alike { start, plan }) = self.alike.get(&fans) {
            // Of corners that look the same the first one.
            let start = (turn + start) % period;
            if self.is_read(t, face, start, plan, scratch) {
                return (plan, start);
            }
        }
        let (plan, start) = self.walked(t, face, canonical_corner(t, face), scratch);
        self.note(t, face, start, fans, Alike { start: (start + sides - turn) % sides, plan }, scratch);
        (plan, start)
    }

    /// The same of a sub-face, whose walk starts at its own corner.
    fn subface(
        &mut self,
        t: &Topology,
        face: Face,
        subface: usize,
        fans: Option<FaceKey>,
        scratch: &mut Scratch,
    ) -> (u32, usize) {
        let fans = fans.map(|fans| fan_class::turned(&fans, subface));
        if let Some(fans) = fans
            && let Some(&Alike { plan, .. }) = self.alike.get(&fans)
            && self.is_read(t, face, subface, plan, scratch)
        {
            return (plan, subface);
        }
        let (plan, start) = self.walked(t, face, subface, scratch);
        if let Some(fans) = fans {
            self.note(t, face, start, fans, Alike { start: 0, plan }, scratch);
        }
        (plan, start)
    }

    /// Reads the ring of a face like others with this plan; false where it takes a walk.
    fn is_read(&mut self, t: &Topology, face: Face, start: usize, plan: u32, scratch: &mut Scratch) -> bool {
        fan_class::read(t, face, start, &mut scratch.ring);
        let is_read = scratch.ring.len() <= smooth_ring::MOST && is_distinct(&scratch.ring);
        if is_read && cfg!(debug_assertions) {
            debug_assert_eq!(self.walk(t, face, start, scratch), plan);
            debug_assert_eq!(scratch.around.ring, scratch.ring);
        }
        is_read
    }

    /// Remembers what a walk told, if the ring is one that can be read.
    fn note(&mut self, t: &Topology, face: Face, start: usize, fans: FaceKey, alike: Alike, scratch: &mut Scratch) {
        fan_class::read(t, face, start, &mut scratch.ring);
        if scratch.ring == scratch.around.ring {
            self.alike.insert(fans, alike);
        } else {
            scratch.ring.clone_from(&scratch.around.ring);
        }
    }

    /// Walks round a face for its plan and ring.
    fn walked(&mut self, t: &Topology, face: Face, start: usize, scratch: &mut Scratch) -> (u32, usize) {
        let plan = self.walk(t, face, start, scratch);
        scratch.ring.clone_from(&scratch.around.ring);
        (plan, start)
    }

    /// Walks round a face from corner `start`, and finds or makes the plan's number.
    fn walk(&mut self, t: &Topology, face: Face, start: usize, scratch: &mut Scratch) -> u32 {
        let around = &mut scratch.around;
        t.surroundings(face, start, &mut scratch.walk, around);
        self.known.get(&around.key[..]).copied().unwrap_or_else(|| {
            let plan = self.keys.len() as u32;
            self.keys.push((around.key.clone().into(), (face.0, start as u32)));
            self.known.insert(around.key.clone().into(), plan);
            plan
        })
    }
}
