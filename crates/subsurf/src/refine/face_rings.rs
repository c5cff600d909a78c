//! Control faces in groups of equal surroundings, each with its ring: what refinement does inside a face is one linear
//! map of its ring, the same for all faces of a group.
//!
//! Unlike the patches of a [`PatchTable`](crate::PatchTable), faces are taken whole, whatever their number of corners,
//! and holes are faces like others: refinement goes on inside them.

use super::plain::{is_plain, plain_ring};
use crate::index::{Face, Vertex};
use crate::limit::KeyHasher;
use crate::mesh::{MAX_COUNT, MeshError};
use crate::scheme::{Scheme, SplitKind};
use crate::topology::{Surroundings, Topology, Walk};
use rayon::prelude::*;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::hash::BuildHasherDefault;
use std::sync::{Mutex, PoisonError};

/// Faces a thread takes at a time. Fixed, so that groups get the same numbers for any number of threads.
const CHUNK: usize = 2048;

/// Lists of numbers in the order in which they were first met, each once.
pub(crate) struct Distinct<K>(HashMap<K, u32, BuildHasherDefault<KeyHasher>>);

impl<K> Default for Distinct<K> {
    fn default() -> Self {
        Self(HashMap::default())
    }
}

impl Distinct<Box<[u32]>> {
    /// The number of a key, and whether it is new.
    pub fn number(&mut self, key: &[u32]) -> (u32, bool) {
        if let Some(&number) = self.0.get(key) {
            return (number, false);
        }
        self.number_owned(key.into())
    }

    /// The same for a key to keep.
    pub fn number_owned(&mut self, key: Box<[u32]>) -> (u32, bool) {
        let next = self.0.len() as u32;
        match self.0.entry(key) {
            Entry::Occupied(known) => (*known.get(), false),
            Entry::Vacant(empty) => (*empty.insert(next), true),
        }
    }
}

/// Every face's group and ring.
pub(crate) struct FaceRings {
    /// By face; [`PLAIN`] is the group of plain quads.
    group: Vec<u32>,
    offset: Vec<u32>,
    ring: Vec<u32>,
    /// The first face of every group but that of plain quads.
    pub representatives: Vec<Face>,
}

/// Points of the widest ring that faces are grouped for: what a face at a vertex of some 90 faces has. Larger: matrices that
/// grow with its square; smaller: more meshes that are refined level by level.
const WIDEST_RING: usize = 200;

/// The group of quads with four plain corners, whose rings are in the order of [`plain_ring`].
pub(crate) const PLAIN: u32 = u32::MAX;

impl FaceRings {
    /// Groups the faces, in parallel; none where a ring has more than [`WIDEST_RING`] points. Rings name no point twice,
    /// but those of plain quads may where a mesh is so small that it meets itself, unless `distinct` is asked for; then
    /// such quads are not plain.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`] where the rings together overflow 32-bit indices.
    pub fn new(t: &Topology, scheme: Scheme, distinct: bool) -> Result<Option<Self>, MeshError> {
        if ring_bounds(t).max().unwrap_or(0) > WIDEST_RING {
            return Ok(None);
        }
        let is_plain = |v: u32| scheme.split() == SplitKind::Quads && is_plain(t, Vertex(v));
        let plain: Vec<bool> = (0..t.vertex_count() as u32).into_par_iter().with_min_len(CHUNK).map(is_plain).collect();
        // As many walks as threads: each has an entry for every vertex.
        let walks = Mutex::new(Vec::new());
        let pool = || walks.lock().unwrap_or_else(PoisonError::into_inner);
        let chunks: Vec<Gathered> = (0..t.face_count().div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let mut walk = pool().pop().unwrap_or_default();
                let gathered = Gathered::of_chunk(t, &plain, distinct, chunk, &mut walk);
                pool().push(walk);
                gathered
            })
            .collect();
        let count = chunks.iter().map(|c| c.ring.len()).sum();
        if count > MAX_COUNT {
            return Err(MeshError::TooLarge { what: "control points round its faces", count, limit: MAX_COUNT });
        }
        let mut out = Self {
            group: Vec::with_capacity(t.face_count()),
            offset: Vec::with_capacity(t.face_count() + 1),
            ring: Vec::with_capacity(count),
            representatives: Vec::new(),
        };
        out.offset.push(0);
        let mut known = Distinct::default();
        for chunk in chunks {
            let renumber: Vec<u32> = chunk
                .keys
                .into_iter()
                .map(|(key, face)| {
                    let (group, is_new) = known.number_owned(key);
                    out.representatives.extend(is_new.then_some(face));
                    group
                })
                .collect();
            out.group.extend(chunk.group.iter().map(|&g| if g == PLAIN { PLAIN } else { renumber[g as usize] }));
            let start = out.ring.len() as u32;
            out.offset.extend(chunk.end.iter().map(|end| start + end));
            out.ring.extend_from_slice(&chunk.ring);
        }
        Ok(Some(out))
    }

    /// The group of a face.
    #[inline(always)]
    pub fn group(&self, face: Face) -> u32 {
        self.group[face.index()]
    }

    /// The control points that the face's vertices are made of: those of all faces that touch it.
    #[inline(always)]
    pub fn ring(&self, face: Face) -> &[u32] {
        &self.ring[self.offset[face.index()] as usize..self.offset[face.index() + 1] as usize]
    }

    /// Number of plain quads.
    pub fn plain_faces(&self) -> usize {
        self.group.iter().filter(|&&group| group == PLAIN).count()
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
        parts.into_par_iter().with_min_len(CHUNK / 4).for_each(|(part, ring)| {
            part.iter_mut().zip(ring).zip(0..).for_each(|((entry, &v), slot)| *entry = (v, slot));
            part.sort_unstable();
        });
        Ascending { rings: self, entry }
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        4 * (self.group.len() + self.offset.len() + self.ring.len() + self.representatives.len())
    }
}

/// Rings in ascending order.
pub(crate) struct Ascending<'a> {
    pub rings: &'a FaceRings,
    entry: Vec<(u32, u32)>,
}

impl Ascending<'_> {
    /// Control points of the ring of `face` in ascending order, each with its position in the ring.
    #[inline(always)]
    pub fn ring(&self, face: Face) -> &[(u32, u32)] {
        let offset = &self.rings.offset;
        &self.entry[offset[face.index()] as usize..offset[face.index() + 1] as usize]
    }
}

/// Bounds for the numbers of points of all rings: round an interior vertex a face adds its corners but two, at boundaries
/// one more.
pub(crate) fn ring_bounds(t: &Topology) -> impl Iterator<Item = usize> {
    let mut around = vec![1usize; t.vertex_count()];
    for f in (0..t.face_count() as u32).map(Face) {
        let sides = t.sides(f);
        t.face_vertices(f).iter().for_each(|&v| around[v as usize] += sides - 2);
    }
    (0..t.face_count() as u32).map(move |f| t.face_vertices(Face(f)).iter().map(|&v| around[v as usize]).sum())
}

fn names_none_twice(ring: &[u32; 16]) -> bool {
    let mut sorted = *ring;
    sorted.sort_unstable();
    sorted.windows(2).all(|w| w[0] != w[1])
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
    fn of_chunk(t: &Topology, plain: &[bool], distinct: bool, chunk: usize, walk: &mut Walk) -> Self {
        let mut out = Self::default();
        let mut known = Distinct::default();
        let mut around = Surroundings::default();
        for face in (chunk * CHUNK..((chunk + 1) * CHUNK).min(t.face_count())).map(Face::new) {
            let is_plain = t.sides(face) == 4 && t.face_vertices(face).iter().all(|&v| plain[v as usize]);
            let ring = is_plain.then(|| plain_ring(t, face)).filter(|ring| !distinct || names_none_twice(ring));
            if let Some(ring) = ring {
                out.group.push(PLAIN);
                out.ring.extend_from_slice(&ring);
            } else {
                t.surroundings(face, 0, walk, &mut around);
                let (group, is_new) = known.number(&around.key);
                if is_new {
                    out.keys.push((around.key.clone().into(), face));
                }
                out.group.push(group);
                out.ring.extend_from_slice(&around.ring);
            }
            out.end.push(out.ring.len() as u32);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refine::Level;
    use crate::shapes;

    #[test]
    fn plain_rings_are_laid_out_as_drawn() {
        // Vertex (i, j) of a grid at (i, j): rings of inner faces are steps of one along x, then of one along y.
        let grid = shapes::grid(6, 5);
        let level = Level::new(&grid.mesh, Scheme::CatmullClark).unwrap();
        let rings = FaceRings::new(level.topology(), Scheme::CatmullClark, true).unwrap().unwrap();
        let mut plain = 0;
        for f in (0..level.topology().face_count() as u32).map(Face).filter(|&f| rings.group(f) == PLAIN) {
            let at = |k: usize| grid.positions[rings.ring(f)[k] as usize];
            let apart = |a: [f64; 3], b: [f64; 3]| [0, 1].map(|i| (b[i] - a[i]).round());
            let (right, up) = (apart(at(5), at(6)), apart(at(5), at(9)));
            (0..16).filter(|k| k % 4 < 3).for_each(|k| assert_eq!(apart(at(k), at(k + 1)), right, "{k}"));
            (0..12).for_each(|k| assert_eq!(apart(at(k), at(k + 4)), up, "{k}"));
            plain += 1;
        }
        assert!(plain > 0);
    }
}
