//! What a patch table holds per patch: which plan, turned how, over which ring. Gathered chunk by chunk, in parallel.
//!
//! Most patches are quads with [smooth corners](super::smooth_ring). Their rings are read off the half-edges, straight into
//! the first part of the list of all rings. Of others, the first with certain [fans](super::fan_class) at its corners is walked
//! round, which tells its plan; further ones take the plan, and their rings are read off the half-edges too. Which faces are
//! first is found by a [survey] of the whole mesh, so that no chunk walks round what another has met.

mod survey;

use super::fan_class::FanClasses;
use super::fans::Fans;
use super::plan_key::{Keys, Names, walk_plan};
use super::pole_memory;
use super::smooth_ring::{self, Valences};
use crate::index::Face;
use crate::kernel::are_distinct;
use crate::mesh::{MAX_COUNT, MeshError};
use crate::scheme::Scheme;
use crate::topology::{FanSize, NONE, Surroundings, Topology, Walk};
use rayon::prelude::*;
use std::ops::Range;
use survey::{Found, Shared, Smooth, Survey};

/// Faces a thread takes at a time. Fixed, so that plans get the same numbers for any number of threads. More: threads wait for the
/// last one; fewer: kinds of patches are met anew in more chunks, which at half as many costs the Car 4 %.
const CHUNK: usize = 2048;

/// A face, and the corner that its walk starts at.
pub(super) type Start = (u32, u32);

/// Everything per patch. Plans are numbered in the order in which kinds of patches come first in the mesh, then those that only walks
/// tell apart.
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
    /// `sizes` are those of the fans, if they are known; `face_patch` is the first patch of every face; `names` shorten keys.
    ///
    /// # Errors
    /// [`MeshError::PoleTooLarge`] where rings and plans at one place would not fit into memory, and [`MeshError::TooLarge`] where all
    /// rings would not, or not into 32-bit indices.
    pub fn new(
        t: &Topology,
        sizes: Vec<FanSize>,
        scheme: Scheme,
        face_patch: &[u32],
        names: &mut Names,
    ) -> Result<Self, MeshError> {
        let fans = Fans::new(t, sizes);
        pole_memory::check(t, scheme, &fans)?;
        let whole = scheme.patch_sides();
        let patches = face_patch[t.face_count()] as usize;
        let classes = FanClasses::new(t, &fans);
        let chunks = t.face_count().div_ceil(CHUNK);
        let mut surveys = Vec::with_capacity(chunks);
        let survey = |ring: &mut Vec<u32>, chunk| Survey::of(t, whole, &fans, &classes, faces_of(t, chunk), ring);
        (0..chunks).into_par_iter().map_init(Vec::new, survey).collect_into_vec(&mut surveys);
        let sizes: Vec<Size> = surveys.iter().map(|survey| survey.size).collect();
        let size: Size = sizes.iter().copied().sum();
        size.check(patches)?;
        let shared = Shared::new(t, whole, surveys, names);

        // Memory that comes zeroed costs nothing until threads write to it.
        let (mut patch_plan, mut patch_turn) = (subsurf_memory::zeroed(patches), subsurf_memory::zeroed(patches));
        let (mut ring_start, mut ring) =
            (subsurf_memory::zeroed(patches), subsurf_memory::zeroed(size.direct + size.others));
        let lists = Lists {
            plan: &mut patch_plan,
            turn: &mut patch_turn,
            start: &mut ring_start,
            direct: &mut ring[..size.direct],
        };
        let mut chunks = lists.chunks(t, face_patch, &sizes);
        let gather = |scratch: &mut Scratch, (i, chunk): (usize, &mut Chunk<'_, '_>)| {
            chunk.gather(t, whole, &fans.valence, &shared, shared.found(i), scratch)
        };
        let mut met: Vec<Met> = chunks.par_iter_mut().enumerate().map_init(Scratch::default, gather).collect();

        let (mut representatives, mut known) = (shared.starts, shared.plans);
        let common = known.len() as u32;
        let mut end = size.direct;
        let chunks: Vec<_> = chunks.into_iter().map(|chunk| (chunk.plan, chunk.start)).collect();
        ring.resize(size.direct + met.iter().map(|chunk| chunk.ring.len()).sum::<usize>(), 0);
        let mut others = &mut ring[size.direct..];
        let mut rest = Vec::with_capacity(met.len());
        for chunk in &mut met {
            let number = |(key, &start)| {
                let (plan, is_new) = known.insert(names.plan_key(key));
                representatives.extend(is_new.then_some(start));
                plan
            };
            let plans: Vec<u32> = chunk.known.since(0).zip(&chunk.starts).map(number).collect();
            let (own, more) = others.split_at_mut(chunk.ring.len());
            rest.push((end, plans, own));
            others = more;
            end += chunk.ring.len();
        }
        if end > MAX_COUNT {
            return Err(MeshError::TooLarge { what: "control points in rings", count: end, limit: MAX_COUNT });
        }
        chunks.into_par_iter().zip(met).zip(rest).for_each(|(((plan, start), met), (base, plans, others))| {
            if !plans.is_empty() {
                let is_own = |plan: &&mut u32| **plan != NONE && **plan >= common;
                plan.iter_mut().filter(is_own).for_each(|plan| *plan = plans[(*plan - common) as usize]);
            }
            met.walked.iter().for_each(|&patch| start[patch as usize] += base as u32);
            others.copy_from_slice(&met.ring);
        });
        ring.shrink_to_fit();
        Ok(Self { patch_plan, patch_turn, ring_start, ring, representatives, known })
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

/// Control points that all rings together may have beyond 64 per patch: a gigabyte.
const MOST_RING_POINTS: usize = 1 << 28;

impl Size {
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

/// Control points in the rings of a face that are not read directly, at most.
pub(super) fn others(t: &Topology, whole: usize, fans: &Fans, face: Face) -> usize {
    let corners = t.face_vertices(face);
    // The face itself is there once; what it adds at each of its corners is not. n-gons have n patches.
    let own = corners.len();
    let beyond = |&v: &u32| (fans.points(t, v) + 2).saturating_sub(own);
    let ring = own + corners.iter().map(beyond).sum::<usize>();
    if own == whole { ring } else { own * ring }
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
    smooth: SmoothQuads,
}

/// The quads of a chunk with smooth corners.
#[derive(Default)]
struct SmoothQuads {
    /// By face of the chunk; zeros for others.
    valences: Vec<Valences>,
    /// Of those with rings of sixteen points, where the rings start, and whether they name no vertex twice.
    sixteens: Vec<u32>,
    are_distinct: Vec<bool>,
}

/// What a chunk needs beyond its part of the tables, plans numbered within the chunk behind those that are shared.
struct Met {
    /// Distinct keys in order of appearance, and the places that they were first met at.
    known: Keys,
    starts: Vec<Start>,
    first: u32,
    /// Patches whose rings are not read directly, and these rings.
    walked: Vec<u32>,
    ring: Vec<u32>,
}

impl Chunk<'_, '_> {
    fn gather(
        &mut self,
        t: &Topology,
        whole: usize,
        valence: &[u8],
        shared: &Shared,
        mut found: impl Iterator<Item = Found>,
        scratch: &mut Scratch,
    ) -> Met {
        let first = shared.plans.len() as u32;
        let mut met = Met { known: Keys::default(), starts: Vec::new(), first, walked: Vec::new(), ring: Vec::new() };
        self.read_rings(t, whole, valence, shared, &mut scratch.smooth);
        let regular = shared.smooth.get(&[4; 4]).map_or(NONE, |smooth| smooth.plan);
        let (mut patch, mut rings) = (0, 0);
        let mut sixteen = 0;
        for (i, face) in self.faces.clone().map(Face::new).enumerate() {
            let valences = scratch.smooth.valences[i];
            let sides = t.sides(face);
            let starts = if sides == whole { 0..1 } else { 0..sides };
            if t.is_hole(face) {
                let end = patch + starts.len();
                self.plan[patch..end].fill(NONE);
                patch = end;
                continue;
            }
            let is_smooth = valences != [0; 4];
            if is_smooth {
                let own = rings..rings + smooth_ring::points(valences);
                rings = own.end;
                let is_distinct = if own.len() == 16 {
                    sixteen += 1;
                    scratch.smooth.are_distinct[sixteen - 1]
                } else {
                    smooth_ring::is_distinct(&self.direct[own.clone()])
                };
                // In small meshes, where the ring is another one, the place stays unused.
                if is_distinct {
                    self.start[patch] = (self.base + own.start) as u32;
                    let Smooth { start, plan } = match valences {
                        [4, 4, 4, 4] => Smooth { start: 0, plan: regular },
                        _ => shared.smooth[&valences],
                    };
                    (self.plan[patch], self.turn[patch]) = (plan, start);
                    patch += 1;
                    continue;
                }
            }
            for subface in starts {
                let found = if is_smooth { None } else { found.next() };
                let read = found.and_then(|found| shared.read(t, face, found, &mut scratch.ring));
                let (plan, start) = match read {
                    Some(read) => read,
                    None => met.walk(t, face, (sides != whole).then_some(subface), scratch),
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
    /// load in vectors.
    fn read_rings(&mut self, t: &Topology, whole: usize, valence: &[u8], shared: &Shared, smooth: &mut SmoothQuads) {
        let mut rings = 0;
        smooth.valences.clear();
        smooth.sixteens.clear();
        for face in self.faces.clone().map(Face::new) {
            let valences = if t.is_hole(face) { None } else { valences(whole, valence, t.face_vertices(face)) };
            smooth.valences.push(valences.unwrap_or_default());
            let Some(valences) = valences else { continue };
            let own = rings..rings + smooth_ring::points(valences);
            rings = own.end;
            if own.len() == 16 {
                smooth.sixteens.push(own.start as u32);
            }
            if valences == [4; 4] {
                smooth_ring::read(t, face, 0, valences, &mut self.direct[own]);
                continue;
            }
            let start = usize::from(shared.smooth[&valences].start);
            let turned = std::array::from_fn(|c| valences[(start + c) % 4]);
            smooth_ring::read(t, face, start, turned, &mut self.direct[own]);
        }
        are_distinct(self.direct, &smooth.sixteens, &mut smooth.are_distinct);
    }
}

impl Met {
    /// Walks round a face, a sub-face from corner `start`, and finds or makes the plan's number; the ring is left in `scratch`. The
    /// corner comes back too.
    fn walk(&mut self, t: &Topology, face: Face, start: Option<usize>, scratch: &mut Scratch) -> (u32, usize) {
        let Scratch { walk, around, ring, .. } = scratch;
        let start = walk_plan(t, face, start, walk, around);
        ring.clone_from(&around.ring);
        let (plan, is_new) = self.known.insert(&around.key);
        self.starts.extend(is_new.then_some((face.0, start as u32)));
        (self.first + plan, start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limit::plan::may_have_fans;
    use crate::mesh::ControlMesh;
    use crate::shapes;
    use crate::tags::{Crease, Tags};

    /// A grid of several chunks, some of its quads cut into triangles, some of its edges sharp.
    fn mixed_grid(side: u32) -> ControlMesh {
        let at = |i: u32, j: u32| i * (side + 1) + j;
        let mut faces: Vec<Vec<u32>> = Vec::new();
        for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
            let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if (7 * i + 3 * j + i * j) % 11 == 0 {
                faces.extend([vec![quad[0], quad[1], quad[2]], vec![quad[0], quad[2], quad[3]]]);
            } else {
                faces.push(quad.to_vec());
            }
        }
        let creases = (0..side).map(|i| Crease::new(at(i, i % 5 + 20), at(i + 1, i % 5 + 20), f64::from(i % 3)));
        ControlMesh::new(&faces, Tags { creases: creases.collect(), ..Tags::default() }).unwrap()
    }

    #[test]
    fn every_patch_has_the_plan_and_the_ring_of_its_own_walk() {
        let meshes = shapes::all().into_iter().map(|shape| shape.mesh).chain([mixed_grid(70)]);
        let (mut walk, mut around) = (Walk::default(), Surroundings::default());
        for mesh in meshes {
            let t = Topology::new(&mesh).unwrap();
            let patches = |f: usize| if t.sides(Face::new(f)) == 4 { 1 } else { t.sides(Face::new(f)) as u32 };
            let mut face_patch = vec![0];
            (0..t.face_count()).for_each(|f| face_patch.push(face_patch[f] + patches(f)));
            let mut names = Names::new(may_have_fans(&t, Scheme::CatmullClark));
            let gathered = Gathered::new(&t, Vec::new(), Scheme::CatmullClark, &face_patch, &mut names).unwrap();
            for face in (0..t.face_count()).map(Face::new).filter(|&face| !t.is_hole(face)) {
                let first = face_patch[face.index()] as usize;
                for subface in 0..patches(face.index()) as usize {
                    let patch = first + subface;
                    let turn = usize::from(gathered.patch_turn[patch]);
                    let start = if t.sides(face) == 4 { turn } else { subface };
                    walk_plan(&t, face, Some(start), &mut walk, &mut around);
                    let plan = names.plan(&gathered.known, &around.key);
                    assert_eq!(Some(gathered.patch_plan[patch]), plan, "{face} {subface}");
                    let ring = gathered.ring_start[patch] as usize;
                    assert_eq!(gathered.ring[ring..ring + around.ring.len()], around.ring, "{face} {subface}");
                }
            }
        }
    }
}
