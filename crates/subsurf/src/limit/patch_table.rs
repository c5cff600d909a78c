//! One plan and one ring per patch: built once per connectivity, shared by all positions and all frames.
//!
//! A patch is a quad (a triangle under Loop), or one sub-face of another face; patches are numbered face by face (the order of Ptex).

use super::plan::{PatchKind, Plan, Plans, SpecialVertices};
use super::plan_key::{Key, Keys, canonical_corner};
use super::special::Method;
use crate::index::{Face, HalfEdge, Vertex};
use crate::limit::{LimitSurface, Location};
use crate::mesh::{ControlMesh, MAX_COUNT, MeshError};
use crate::real::Real;
use crate::refine::scheme_topology;
use crate::scheme::{Scheme, SplitKind};
use crate::topology::{NONE, Surroundings, Topology, Walk};
use rayon::prelude::*;
use std::collections::hash_map::Entry;

/// Patches a thread takes at a time. Fixed, so that plans get the same numbers for any number of threads.
const CHUNK: usize = 2048;

/// For every face of a mesh, where its limit comes from: a plan, shared by all faces with equal surroundings, and the
/// ring of control points that the plan's weights are for.
pub struct PatchTable {
    topology: Topology,
    scheme: Scheme,
    /// First patch of every face, and their number at the end.
    face_patch: Vec<u32>,
    patch_plan: Vec<u32>,
    /// Which corner of its face is the plan's corner 0.
    patch_turn: Vec<u8>,
    ring_offset: Vec<u32>,
    ring: Vec<u32>,
    plans: Plans,
    specials: SpecialVertices,
}

/// Figures about a table.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub struct TableSize {
    /// Patches: quads, and sub-faces of other faces; holes have none.
    pub patches: usize,
    /// Distinct plans.
    pub plans: usize,
    /// Nodes of the patch trees of all plans, shared ones counted once.
    pub nodes: usize,
    /// Plans that are one bicubic patch.
    pub regular_plans: usize,
    /// Patches whose plan is one bicubic patch.
    pub regular_patches: usize,
    /// Distinct special vertices, one for each kind, size and face number.
    pub special_vertices: usize,
    /// Bytes of what grows with the mesh: plan numbers and rings.
    pub patch_bytes: usize,
    /// Bytes of plans and special vertices; these grow a little when locations deep at them are first evaluated.
    pub plan_bytes: usize,
    /// Bytes of the topology that the table keeps.
    pub topology_bytes: usize,
}

impl PatchTable {
    /// Builds the table of a mesh, in parallel.
    ///
    /// # Errors
    /// Those of [`Topology::new`], and [`MeshError::TooLarge`] where rings overflow 32-bit indices.
    pub fn new(mesh: &ControlMesh, scheme: Scheme) -> Result<Self, MeshError> {
        Self::with_method(mesh, scheme, Method::default())
    }

    /// Builds the table with a choice of closed form at special vertices.
    ///
    /// # Errors
    /// As [`PatchTable::new`].
    pub fn with_method(mesh: &ControlMesh, scheme: Scheme, method: Method) -> Result<Self, MeshError> {
        Self::from_topology(scheme_topology(mesh, scheme)?, scheme, method)
    }

    /// Builds the table from a topology that is at hand.
    ///
    /// # Errors
    /// As [`PatchTable::new`].
    pub fn from_topology(topology: Topology, scheme: Scheme, method: Method) -> Result<Self, MeshError> {
        let faces = topology.face_count();
        let whole = scheme.patch_sides();
        if scheme.split() == SplitKind::Triangles
            && let Some(face) = (0..faces).find(|&f| topology.sides(Face(f as u32)) != whole)
        {
            return Err(MeshError::NotATriangle { face, sides: topology.sides(Face(face as u32)) });
        }
        let mut face_patch = Vec::with_capacity(faces + 1);
        face_patch.push(0u32);
        for f in 0..faces as u32 {
            let sides = topology.sides(Face(f));
            // At most one patch per corner, and corners fit into 32 bits.
            face_patch.push(face_patch[f as usize] + if sides == whole { 1 } else { sides as u32 });
        }
        check_rings(&topology, face_patch[faces] as usize)?;
        let specials = SpecialVertices::new(method);
        let plain: Vec<bool> =
            (0..topology.vertex_count() as u32).into_par_iter().map(|v| is_plain(&topology, Vertex(v))).collect();
        let gathered: Vec<Gathered> = (0..faces.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| Gathered::of_chunk(&topology, whole, &plain, chunk))
            .collect();
        let merged = Merged::new(gathered)?;
        let plans = Plans::compile(&topology, &merged.representatives, scheme, &specials);
        Ok(Self {
            topology,
            scheme,
            face_patch,
            patch_plan: merged.patch_plan,
            patch_turn: merged.patch_turn,
            ring_offset: merged.ring_offset,
            ring: merged.ring,
            plans,
            specials,
        })
    }

    /// The surface of this table with these control points, one row per vertex of the mesh.
    ///
    /// # Panics
    /// If `points` has not one row per vertex of the mesh.
    pub fn surface<'a, T: Real, const N: usize>(&'a self, points: &'a [[T; N]]) -> LimitSurface<'a, T, N> {
        LimitSurface::new(self, points)
    }

    /// The control mesh's half-edge tables.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The scheme that the table was built for.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// Number of patches, holes included.
    pub fn patch_count(&self) -> usize {
        self.patch_plan.len()
    }

    /// Number of sub-faces of a face: 1 for quads (triangles under Loop), the number of corners for others.
    pub fn subfaces(&self, face: Face) -> u32 {
        self.face_patch[face.index() + 1] - self.face_patch[face.index()]
    }

    /// The patch of a face's sub-face.
    ///
    /// # Panics
    /// If there is no such sub-face.
    pub fn patch(&self, face: Face, subface: u32) -> usize {
        assert!(subface < self.subfaces(face), "face {face} has no sub-face {subface}");
        (self.face_patch[face.index()] + subface) as usize
    }

    /// The patch of a location.
    ///
    /// # Panics
    /// If the location names no sub-face of the mesh, or its parameters lie outside the face.
    pub(crate) fn checked_patch(&self, at: Location) -> usize {
        let inside = |x: f64| (0.0..=1.0).contains(&x);
        assert!(inside(at.u) && inside(at.v), "parameters ({}, {}) lie outside [0, 1]", at.u, at.v);
        // The sum of two parameters on the third side may round up.
        let beyond = self.scheme.split() == SplitKind::Triangles && at.u + at.v > 1.0 + 4.0 * f64::EPSILON;
        assert!(!beyond, "parameters ({}, {}) lie outside the triangle u + v <= 1", at.u, at.v);
        self.patch(at.face, at.subface)
    }

    /// Where the corner at the start of `h` lies in the face of `h`.
    pub fn corner_location(&self, h: HalfEdge) -> Location {
        let face = self.topology.face(h);
        let corner = h.0 - self.topology.first(face);
        if self.subfaces(face) > 1 {
            return Location { face, subface: corner, u: 0.0, v: 0.0 };
        }
        let (u, v) = match (self.scheme.split(), corner) {
            (_, 0) => (0.0, 0.0),
            (_, 1) => (1.0, 0.0),
            (SplitKind::Quads, 2) => (1.0, 1.0),
            _ => (0.0, 1.0),
        };
        Location { face, subface: 0, u, v }
    }

    /// First patch of every face, and the number of patches at the end.
    pub fn face_patches(&self) -> &[u32] {
        &self.face_patch
    }

    /// The plan number of a patch; none in holes.
    pub fn patch_plan(&self, patch: usize) -> Option<usize> {
        let plan = self.patch_plan[patch];
        (plan != NONE).then_some(plan as usize)
    }

    /// Kind and depth of the patch-tree leaf at a place; none in holes.
    pub fn patch_kind(&self, patch: usize, u: f64, v: f64) -> Option<(PatchKind, u32)> {
        self.patch_plan(patch).map(|plan| self.plan(plan).patch_kind(u, v, self.patch_turn[patch]))
    }

    pub(crate) fn plan(&self, plan: usize) -> Plan<'_> {
        self.plans.get(plan)
    }

    pub(crate) fn plan_count(&self) -> usize {
        self.plans.len()
    }

    pub(crate) fn turn(&self, patch: usize) -> u8 {
        self.patch_turn[patch]
    }

    /// The control points that a patch's weights are for.
    pub(crate) fn ring(&self, patch: usize) -> &[u32] {
        &self.ring[self.ring_offset[patch] as usize..self.ring_offset[patch + 1] as usize]
    }

    /// Counts and memory.
    pub fn size(&self) -> TableSize {
        let t = &self.topology;
        let regular: Vec<bool> = (0..self.plans.len()).map(|plan| self.plan(plan).is_regular()).collect();
        let specials = self.specials.all();
        TableSize {
            patches: self.patch_plan.iter().filter(|&&p| p != NONE).count(),
            plans: self.plans.len(),
            nodes: self.plans.node_count(),
            regular_plans: regular.iter().filter(|&&r| r).count(),
            regular_patches: self.patch_plan.iter().filter(|&&p| p != NONE && regular[p as usize]).count(),
            special_vertices: specials.len(),
            patch_bytes: 4 * (self.face_patch.len() + self.patch_plan.len() + self.ring_offset.len() + self.ring.len())
                + self.patch_turn.len(),
            plan_bytes: self.plans.bytes() + specials.iter().map(|s| s.bytes()).sum::<usize>(),
            topology_bytes: 16 * t.half_edge_count() + 24 * t.edge_count() + 20 * t.vertex_count() + 5 * t.face_count(),
        }
    }
}

/// Control points that all rings together may have beyond 64 per patch: a gigabyte. A pole of valence n has n rings of
/// 2 n points; 2^28 allows one of 11,000.
const MOST_RING_POINTS: usize = 1 << 28;

/// Refuses meshes whose rings would not fit into memory, before any is made.
fn check_rings(t: &Topology, patches: usize) -> Result<(), MeshError> {
    let mut faces_at = vec![0usize; t.vertex_count()];
    t.corners().iter().for_each(|&v| faces_at[v as usize] += 1);
    // A face at a vertex adds at most its corners but two to the ring; n-gons have n patches.
    let around = |f: Face| -> usize {
        let own = t.sides(f);
        let ring = t.face_vertices(f).iter().map(|&v| 2 * faces_at[v as usize]).sum::<usize>();
        if own <= 4 { ring } else { own * ring }
    };
    let count = (0..t.face_count() as u32).map(|f| around(Face(f))).sum();
    let limit = MOST_RING_POINTS + 64 * patches;
    if count > limit {
        let what = "control points round its faces (a vertex of n faces needs n² of them)";
        return Err(MeshError::TooLarge { what, count, limit });
    }
    Ok(())
}

/// What one chunk of faces needs, plans numbered within the chunk.
#[derive(Default)]
struct Gathered {
    patch_plan: Vec<u32>,
    patch_turn: Vec<u8>,
    ring_length: Vec<u32>,
    ring: Vec<u32>,
    /// Distinct keys in order of appearance, each with the patch that it was first met at.
    keys: Vec<(Key, Start)>,
}

/// A face, and the corner that its walk starts at.
pub(super) type Start = (u32, u32);

impl Gathered {
    fn of_chunk(t: &Topology, whole: usize, plain: &[bool], chunk: usize) -> Self {
        let mut out = Self::default();
        let mut known = Keys::default();
        let (mut walk, mut around) = (Walk::default(), Surroundings::default());
        let mut regular_plan = None;
        for face in (chunk * CHUNK..((chunk + 1) * CHUNK).min(t.face_count())).map(Face::new) {
            let sides = t.sides(face);
            let starts = if sides == whole { 0..1 } else { 0..sides };
            for subface in starts {
                if t.is_hole(face) {
                    out.patch_plan.push(NONE);
                    out.patch_turn.push(0);
                    out.ring_length.push(0);
                    continue;
                }
                let is_regular = whole == 4 && sides == 4 && t.face_vertices(face).iter().all(|&v| plain[v as usize]);
                let regular = if is_regular { regular_ring(t, face) } else { None };
                if let Some((plan, ring)) = regular_plan.zip(regular.as_ref()) {
                    out.patch_plan.push(plan);
                    out.patch_turn.push(0);
                    out.ring_length.push(16);
                    out.ring.extend_from_slice(ring);
                    continue;
                }
                let start = if sides == whole { canonical_corner(t, face) } else { subface };
                t.surroundings(face, start, &mut walk, &mut around);
                let plan = match known.get(&around.key[..]) {
                    Some(&plan) => plan,
                    None => {
                        let plan = out.keys.len() as u32;
                        out.keys.push((around.key.clone().into(), (face.0, start as u32)));
                        known.insert(around.key.clone().into(), plan);
                        plan
                    }
                };
                if let Some(ring) = regular {
                    debug_assert_eq!(around.ring, ring);
                    regular_plan = Some(plan);
                }
                out.patch_plan.push(plan);
                out.patch_turn.push(if sides == whole { start as u8 } else { 0 });
                out.ring_length.push(around.ring.len() as u32);
                out.ring.extend_from_slice(&around.ring);
            }
        }
        out
    }
}

/// True for an interior vertex of four quads with nothing sharp.
fn is_plain(t: &Topology, v: Vertex) -> bool {
    let Some(start) = t.outgoing(v) else { return false };
    if t.vertex_non_manifold[v.index()] || t.vertex_sharpness(v) > 0.0 || !t.sharp_edges(v).is_empty() {
        return false;
    }
    let mut h = start;
    for _ in 0..4 {
        match t.turn_left(h) {
            Some(left) if t.sides(t.face(h)) == 4 => h = left,
            _ => return false,
        }
    }
    h == start && t.turn_left(start) != Some(start) && t.foreign_sharpness(v).is_empty()
}

/// The ring of a quad with four plain corners in the order in which [`Topology::surroundings`] meets it; none where the
/// mesh is so small that faces round it are the same.
///
/// ```text
///    15 ── 14 ── 13 ── 12
///     |     |     |     |
///     4 ─── 3 ─── 2 ── 11
///     |     |face |     |
///     5 ─── 0 ─── 1 ── 10
///     |     |     |     |
///     6 ─── 7 ─── 8 ─── 9
/// ```
fn regular_ring(t: &Topology, face: Face) -> Option<[u32; 16]> {
    let left = |h: HalfEdge| t.turn_left(h).expect("a plain vertex has faces all round");
    // The two vertices before the one that `h` starts at, in its face: beyond the next spoke, and at its end.
    let beyond = |h: HalfEdge| [t.origin(t.prev(t.prev(h))).0, t.origin(t.prev(h)).0];
    let mut ring = [0; 16];
    ring[..4].copy_from_slice(t.face_vertices(face));
    let mut at = 4;
    for corner in 0..4 {
        let first = left(t.half_edge(face, corner));
        let second = left(first);
        let third = left(second);
        // Later corners have seen the first face, the last one the third as well.
        if corner == 0 {
            ring[4..6].copy_from_slice(&beyond(first));
            at = 6;
        }
        let [diagonal, spoke] = beyond(second);
        ring[at] = diagonal;
        if corner < 3 {
            ring[at + 1] = spoke;
            ring[at + 2] = beyond(third)[0];
            at += 3;
        }
    }
    (0..15).all(|i| !ring[i + 1..].contains(&ring[i])).then_some(ring)
}

/// All chunks, plans numbered by first appearance in the mesh.
struct Merged {
    patch_plan: Vec<u32>,
    patch_turn: Vec<u8>,
    ring_offset: Vec<u32>,
    ring: Vec<u32>,
    /// Per plan a face, and the corner that its walk starts at.
    representatives: Vec<Start>,
    /// Plan of every key.
    known: Keys,
}

impl Merged {
    fn new(chunks: Vec<Gathered>) -> Result<Self, MeshError> {
        let total: usize = chunks.iter().map(|c| c.ring.len()).sum();
        if total > MAX_COUNT {
            return Err(MeshError::TooLarge { what: "control points in rings", count: total, limit: MAX_COUNT });
        }
        let mut out = Self {
            patch_plan: Vec::new(),
            patch_turn: Vec::new(),
            ring_offset: vec![0],
            ring: Vec::with_capacity(total),
            representatives: Vec::new(),
            known: Keys::default(),
        };
        for chunk in chunks {
            let mut renumber = Vec::with_capacity(chunk.keys.len());
            for (key, place) in chunk.keys {
                let next = out.known.len() as u32;
                renumber.push(match out.known.entry(key) {
                    Entry::Occupied(plan) => *plan.get(),
                    Entry::Vacant(empty) => {
                        out.representatives.push(place);
                        *empty.insert(next)
                    }
                });
            }
            out.patch_plan
                .extend(chunk.patch_plan.iter().map(|&p| if p == NONE { NONE } else { renumber[p as usize] }));
            out.patch_turn.extend_from_slice(&chunk.patch_turn);
            let mut end = out.ring.len() as u32;
            out.ring_offset.extend(chunk.ring_length.iter().map(|&n| {
                end += n;
                end
            }));
            out.ring.extend_from_slice(&chunk.ring);
        }
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    #[test]
    fn the_ring_of_a_regular_quad_is_the_walk_round_its_corners() {
        let drawing = [15, 14, 13, 12, 4, 3, 2, 11, 5, 0, 1, 10, 6, 7, 8, 9];
        let grid = shapes::grid(3, 3);
        let t = Topology::new(&grid.mesh).unwrap();
        let middle = (0..9).map(Face).find(|&f| t.face_vertices(f).iter().all(|&v| is_plain(&t, Vertex(v)))).unwrap();
        let ring = regular_ring(&t, middle).unwrap();
        let mut around = Surroundings::default();
        t.surroundings(middle, 0, &mut Walk::default(), &mut around);
        assert_eq!(around.ring, ring);
        // Along the rows of the drawing neighbours are a unit apart.
        let at = |k: usize| grid.positions[ring[drawing[k]] as usize];
        let step = |a: [f64; 3], b: [f64; 3]| [0, 1].map(|i| b[i] - a[i]);
        for k in (0..16).filter(|k| k % 4 < 3) {
            assert_eq!(step(at(k), at(k + 1)), step(at(0), at(1)), "{k}");
        }
    }
}
