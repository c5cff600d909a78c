//! One plan and one ring per patch: built once per connectivity, shared by all positions and all frames.
//!
//! A patch is a quad (a triangle under Loop), or one sub-face of another face; patches are numbered face by face (the order of Ptex).

use super::gather::Gathered;
pub(super) use super::gather::Start;
use super::plan::{Numbers, PatchKind, Plan, Plans, SpecialVertices, may_have_fans};
use super::plan_key::Keys;
use super::special::Method;
use crate::index::{Face, HalfEdge};
use crate::limit::{LimitSurface, Location};
use crate::mesh::{ControlMesh, MeshError};
use crate::real::Real;
use crate::refine::scheme_topology;
use crate::scheme::{Scheme, SplitKind};
use crate::topology::{NONE, Topology};
use std::collections::BTreeMap;

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
    /// Where the ring of every patch starts in `ring`; its plan says how long it is.
    ring_start: Vec<u32>,
    ring: Vec<u32>,
    /// Rings of patches that edits made anew.
    edited_rings: BTreeMap<u32, Vec<u32>>,
    plans: Plans,
    specials: SpecialVertices,
}

/// Numbers of plans and nodes by their keys.
pub(crate) struct Known {
    plans: Keys,
    nodes: Numbers,
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
    /// Bytes of plans and special vertices; these grow a little when locations at them are first evaluated. What evaluation
    /// tabulates comes on top: see [`PatchTable::evaluation_size`].
    pub plan_bytes: usize,
    /// Bytes of the topology that the table keeps.
    pub topology_bytes: usize,
}

/// What evaluation has tabulated so far: see [`PatchTable::evaluation_size`].
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub struct EvaluationSize {
    /// Matrices made: one per sub-patch of a plan and precision that a location was met in.
    pub matrices: usize,
    /// Bytes of those that are kept.
    pub bytes: usize,
    /// Bytes of what tells in which sub-patch a location lies, the patch trees and cells of plans that were met, with room for their
    /// matrices; some for every plan from the beginning.
    pub search_bytes: usize,
}

impl PatchTable {
    /// Builds the table of a mesh, in parallel. A call from outside a thread pool hands its work to rayon's global one, which may
    /// take 100 µs: many small meshes are built fastest from within a pool (`meshes.par_iter()`).
    ///
    /// # Errors
    /// Those of [`Topology::new`], [`MeshError::PoleTooLarge`] where so many faces meet at a vertex that their rings and plans would
    /// take more than [`MOST_POLE_BYTES`](crate::MOST_POLE_BYTES), and [`MeshError::TooLarge`] where rings overflow 32-bit indices.
    pub fn new(mesh: &ControlMesh, scheme: Scheme) -> Result<Self, MeshError> {
        Self::with_method(mesh, scheme, Method::default())
    }

    /// Builds the table with a choice of closed form at special vertices.
    ///
    /// # Errors
    /// As [`PatchTable::new`].
    pub fn with_method(mesh: &ControlMesh, scheme: Scheme, method: Method) -> Result<Self, MeshError> {
        // One entry into the thread pool for all that follows.
        rayon::scope(|_| Self::from_topology(scheme_topology(mesh, scheme)?, scheme, method))
    }

    /// Builds the table from a topology that is at hand.
    ///
    /// # Errors
    /// As [`PatchTable::new`].
    pub fn from_topology(topology: Topology, scheme: Scheme, method: Method) -> Result<Self, MeshError> {
        rayon::scope(|_| Self::with_known(topology, scheme, method)).map(|(table, _)| table)
    }

    /// The table, and what to know of it to add to it.
    pub(crate) fn with_known(
        mut topology: Topology,
        scheme: Scheme,
        method: Method,
    ) -> Result<(Self, Known), MeshError> {
        let faces = topology.face_count();
        let whole = scheme.patch_sides();
        if scheme.split() == SplitKind::Triangles
            && let Some(face) = (0..faces).find(|&f| topology.sides(Face(f as u32)) != whole)
        {
            return Err(MeshError::NotATriangle { face, sides: topology.sides(Face(face as u32)) });
        }
        // At most one patch per corner, and corners fit into 32 bits.
        let sides = |f: usize| topology.sides(Face(f as u32));
        let mut face_patch: Vec<u32> = subsurf_memory::with_capacity(faces + 1);
        face_patch.extend(0..=faces as u32);
        if (0..faces).any(|f| sides(f) != whole) {
            for f in 0..faces {
                face_patch[f + 1] = face_patch[f] + if sides(f) == whole { 1 } else { sides(f) as u32 };
            }
        }
        let specials = SpecialVertices::new(method);
        let fan_sizes = std::mem::take(&mut topology.fan_sizes);
        let mut nodes = Numbers::new(may_have_fans(&topology, scheme));
        let gathered = Gathered::new(&topology, fan_sizes, scheme, &face_patch, nodes.names())?;
        let mut plans = Plans::empty(scheme);
        let (known, starts) = (gathered.known, gathered.representatives);
        plans.add(&topology, known.since(0).zip(starts), scheme, &specials, &mut nodes);
        let table = Self {
            topology,
            scheme,
            face_patch,
            patch_plan: gathered.patch_plan,
            patch_turn: gathered.patch_turn,
            ring_start: gathered.ring_start,
            ring: gathered.ring,
            edited_rings: BTreeMap::new(),
            plans,
            specials,
        };
        Ok((table, Known { plans: known, nodes }))
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
        self.check_parameters(at.u, at.v);
        self.patch(at.face, at.subface)
    }

    /// Panics where parameters lie outside a face.
    #[inline]
    pub(crate) fn check_parameters(&self, u: f64, v: f64) {
        let inside = |x: f64| (0.0..=1.0).contains(&x);
        assert!(inside(u) && inside(v), "parameters ({}, {}) lie outside [0, 1]", u, v);
        // The sum of two parameters on the third side may round up.
        let beyond = self.scheme.split() == SplitKind::Triangles && u + v > 1.0 + 4.0 * f64::EPSILON;
        assert!(!beyond, "parameters ({}, {}) lie outside the triangle u + v <= 1", u, v);
    }

    /// The same for many at once.
    #[inline(always)]
    pub(crate) fn check_all(&self, u: &[f64], v: &[f64]) {
        // Bits of numbers in [0, 1] are in order, those of all others but -0 are larger.
        let mut most = 0;
        for x in [u, v] {
            for k in 0..x.len() {
                let bits = x[k].to_bits();
                most = if bits > most { bits } else { most };
            }
        }
        if most > 1f64.to_bits() || self.scheme.split() == SplitKind::Triangles {
            u.iter().zip(v).for_each(|(&u, &v)| self.check_parameters(u, v));
        }
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

    pub(crate) fn plans(&self) -> &Plans {
        &self.plans
    }

    pub(crate) fn plan_count(&self) -> usize {
        self.plans.len()
    }

    pub(crate) fn turn(&self, patch: usize) -> u8 {
        self.patch_turn[patch]
    }

    /// The control points that a patch's weights are for.
    pub(crate) fn ring(&self, patch: usize) -> &[u32] {
        if !self.edited_rings.is_empty()
            && let Some(ring) = self.edited_rings.get(&(patch as u32))
        {
            return ring;
        }
        let Some(plan) = self.patch_plan(patch) else { return &[] };
        let start = self.ring_start[patch] as usize;
        &self.ring[start..start + self.plan(plan).ring()]
    }

    /// The same where the plan is known to be for so many points.
    #[inline(always)]
    pub(crate) fn ring_of(&self, patch: usize, points: usize) -> &[u32] {
        if !self.edited_rings.is_empty() {
            return self.ring(patch);
        }
        let start = self.ring_start[patch] as usize;
        &self.ring[start..start + points]
    }

    /// Matrices that evaluation made when it first met the sub-patches of a plan, all faces and threads together; at most
    /// 128 MiB are kept.
    pub fn evaluation_size(&self) -> EvaluationSize {
        let parts = self.plans.sub_patches();
        EvaluationSize { matrices: parts.made(), bytes: parts.bytes(), search_bytes: parts.search_bytes() }
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
            patch_bytes: [&self.face_patch, &self.patch_plan, &self.ring_start, &self.ring]
                .into_iter()
                .map(|list| size_of::<u32>() * list.capacity())
                .sum::<usize>()
                + self.patch_turn.capacity()
                + self.edited_rings.values().map(|ring| 32 + 4 * ring.len()).sum::<usize>(),
            plan_bytes: self.plans.bytes() + specials.iter().map(|s| s.bytes()).sum::<usize>(),
            topology_bytes: t.bytes(),
        }
    }
}

mod rebuild;
