//! Patches made anew after an edit, the rest of the table left as it is.

use super::super::plan_key::walk_plan;
use super::{Known, PatchTable};
use crate::index::Face;
use crate::mesh::{MAX_COUNT, MeshError};
use crate::topology::{NONE, Surroundings, Topology, Walk};

impl PatchTable {
    /// The topology, for edits; the patches round what changes there are to be made anew.
    pub(crate) fn topology_mut(&mut self) -> &mut Topology {
        &mut self.topology
    }

    /// Leaves a face's patches empty, as those of holes are.
    pub(crate) fn forget(&mut self, face: Face) {
        for patch in self.face_patch[face.index()]..self.face_patch[face.index() + 1] {
            self.patch_plan[patch as usize] = NONE;
            self.edited_rings.insert(patch, Vec::new());
        }
    }

    /// Empty patches for a face that is the last one, or in the place of one of as many corners.
    pub(crate) fn make_room(&mut self, face: Face) {
        if face.index() + 1 < self.face_patch.len() {
            return self.forget(face);
        }
        let sides = self.topology.sides(face);
        let patches = self.patch_plan.len() + if sides == self.scheme.patch_sides() { 1 } else { sides };
        self.face_patch.push(patches as u32);
        self.patch_plan.resize(patches, NONE);
        self.patch_turn.resize(patches, 0);
        self.ring_start.resize(patches, 0);
    }

    /// Finds or makes the plans of faces that are no holes, and their rings. Returns how many nodes were made.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`] where there are more patches than 32-bit indices can name.
    pub(crate) fn rebuild(&mut self, faces: &[Face], known: &mut Known, walk: &mut Walk) -> Result<usize, MeshError> {
        if self.patch_plan.len() > MAX_COUNT {
            let (what, count) = ("patches", self.patch_plan.len());
            return Err(MeshError::TooLarge { what, count, limit: MAX_COUNT });
        }
        let t = &self.topology;
        let mut around = Surroundings::default();
        let (before, mut starts) = (self.plans.len(), Vec::new());
        for &face in faces {
            let first = self.face_patch[face.index()];
            let patches = self.face_patch[face.index() + 1] - first;
            let is_whole = t.sides(face) == self.scheme.patch_sides();
            for subface in 0..patches {
                let start = walk_plan(t, face, (!is_whole).then_some(subface as usize), walk, &mut around);
                let (plan, is_new) = known.plans.insert(known.nodes.names().plan_key(&around.key));
                starts.extend(is_new.then_some((face.0, start as u32)));
                let patch = first + subface;
                self.patch_plan[patch as usize] = plan;
                self.patch_turn[patch as usize] = if is_whole { start as u8 } else { 0 };
                self.edited_rings.insert(patch, around.ring.clone());
            }
        }
        let nodes = self.plans.node_count();
        let new = known.plans.since(before).zip(starts);
        self.plans.add(&self.topology, new, self.scheme, &self.specials, &mut known.nodes);
        Ok(self.plans.node_count() - nodes)
    }
}
