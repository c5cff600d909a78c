//! What plans share of special vertices.

use super::super::corner::{Corner, Kind};
use super::super::rows::Rows;
use super::super::special::{Method, SpecialVertex};
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// The special vertices that plans refer to, each made once.
#[derive(Default)]
pub(crate) struct SpecialVertices {
    made: Mutex<HashMap<Corner, Arc<SpecialVertex>>>,
    /// Control points of leaves at vertices of many faces, by what the vertex is and how many points there are: the faces of a fan
    /// from one boundary to the other have the same.
    points: Mutex<HashMap<(Corner, usize), Arc<Rows>>>,
    method: Method,
}

impl SpecialVertices {
    pub fn new(method: Method) -> Self {
        Self { method, ..Self::default() }
    }

    pub fn get(&self, corner: Corner) -> Arc<SpecialVertex> {
        // A smooth or pinned vertex looks the same from all its faces: their numbering starts at the face itself.
        if let Some(made) = self.lock().get(&corner) {
            return made.clone();
        }
        if SpecialVertex::is_of_many(corner) {
            // What does not depend on the face is that of face 0, whichever comes first.
            let own = |i: u32| Corner { i, ..corner };
            let first = self.known_or(own(0), || SpecialVertex::new(own(0), self.method));
            return self.known_or(corner, || first.for_other_face(corner, self.method));
        }
        if corner.kind == Kind::Dart {
            // All its faces at once: most of what they need they have in common, and other faces of the mesh need it.
            let all = SpecialVertex::all_at_dart(corner.split, corner.n, self.method);
            let mut made = self.lock();
            for new in all {
                made.entry(new.corner).or_insert_with(|| new.into());
            }
            return made[&corner].clone();
        }
        self.known_or(corner, || SpecialVertex::new(corner, self.method))
    }

    /// The same control points of a leaf at such a corner, as others have them already.
    pub(super) fn share_points(&self, corner: Corner, points: Arc<Rows>) -> Arc<Rows> {
        if !SpecialVertex::is_of_many(corner) || !points.is_selection() {
            return points;
        }
        let mut all = self.points.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let first = all.entry((Corner { i: 0, ..corner }, points.len())).or_insert_with(|| points.clone());
        if first.is_like(&points) { first.clone() } else { points }
    }

    fn known_or(&self, corner: Corner, new: impl FnOnce() -> SpecialVertex) -> Arc<SpecialVertex> {
        if let Some(made) = self.lock().get(&corner) {
            return made.clone();
        }
        let new = Arc::new(new());
        self.lock().entry(corner).or_insert(new).clone()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<Corner, Arc<SpecialVertex>>> {
        self.made.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// Every kind that was made, sorted.
    pub fn all(&self) -> Vec<Arc<SpecialVertex>> {
        let mut all: Vec<_> = self.lock().values().cloned().collect();
        all.sort_by_key(|s| s.corner);
        all
    }
}
