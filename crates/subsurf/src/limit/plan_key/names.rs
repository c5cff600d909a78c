//! Short keys for long walks. What a walk round a quad lists without sharpness is its *shape*, which has a number; the key is
//! that number, and what is sharp by *slot*: which corner of the quad, and which number there, of the vertex, then of the edges in
//! the order in which the walk round the corner comes to them. Slots that are 0 are left out.

use super::Keys;
use crate::topology::Surroundings;

/// First number of a key with a shape; those of walks begin otherwise.
const FACE: u32 = u32::MAX - 17;

/// The shapes of quads, and memory.
#[derive(Default)]
pub(in crate::limit) struct Names {
    /// True where sharpness next to a quad's corners is all that rules see there beside the shape.
    has_shapes: bool,
    shapes: Keys,
    apart: Apart,
    key: Vec<u32>,
}

/// A walk's key taken apart: memory.
#[derive(Default)]
pub(in crate::limit) struct Apart {
    shape: Vec<u32>,
    slots: Vec<u32>,
}

impl Names {
    pub fn new(has_shapes: bool) -> Self {
        Self { has_shapes, ..Self::default() }
    }

    /// Number of shapes.
    pub fn shapes(&self) -> usize {
        self.shapes.len()
    }

    /// The key of a walk in whose list `walk` sharpness stands at the places `sharpness`.
    pub fn key(&mut self, walk: &[u32], sharpness: &[u32]) -> &[u32] {
        let Self { has_shapes, shapes, apart, key } = self;
        key.clear();
        if *has_shapes && apart.take(walk, sharpness) {
            key.extend([FACE, shapes.insert(&apart.shape).0]);
            key.extend_from_slice(&apart.slots);
        } else {
            key.extend_from_slice(walk);
        }
        key
    }

    /// The same, if the shape is known, into `key`.
    pub fn find(&self, walk: &[u32], sharpness: &[u32], apart: &mut Apart, key: &mut Vec<u32>) -> bool {
        key.clear();
        if self.has_shapes && apart.take(walk, sharpness) {
            let Some(shape) = self.shapes.get(&apart.shape) else { return false };
            key.extend([FACE, shape]);
            key.extend_from_slice(&apart.slots);
        } else {
            key.extend_from_slice(walk);
        }
        true
    }

    /// The key of a plan, from what [`walk_plan`](super::walk_plan) leaves: that of the walk, and the raise.
    pub fn plan_key(&mut self, closed: &[u32]) -> &[u32] {
        let (walk, sharpness, raise) = Surroundings::open_key(closed);
        self.key(walk, sharpness);
        self.key.push(raise.into());
        &self.key
    }

    /// The number of a plan among `plans`, if it is known.
    #[cfg(test)]
    pub fn plan(&self, plans: &Keys, closed: &[u32]) -> Option<u32> {
        let (walk, sharpness, raise) = Surroundings::open_key(closed);
        let mut key = Vec::new();
        if !self.find(walk, sharpness, &mut Apart::default(), &mut key) {
            return None;
        }
        key.push(raise.into());
        plans.get(&key)
    }
}

/// The key of a walk, and the raise, in a plan's key.
pub(in crate::limit) fn open_plan_key(key: &[u32]) -> (&[u32], u8) {
    key.split_last().map_or((key, 0), |(&raise, walk)| (walk, raise as u8))
}

/// The shape in a key, if it has one.
pub(in crate::limit) fn shape(key: &[u32]) -> Option<u32> {
    match key {
        [FACE, shape, ..] => Some(*shape),
        _ => None,
    }
}

/// The slots in a key with a shape: the corner, the number there and the sharpness.
pub(in crate::limit) fn slots(key: &[u32]) -> impl Iterator<Item = (usize, usize, f64)> {
    let slot = |&[slot, high, low]: &[u32; 3]| {
        let s = f64::from_bits(u64::from(high) << 32 | u64::from(low));
        let [corner, number] = open_slot(slot);
        (corner, number, s)
    };
    key[2..].as_chunks().0.iter().map(slot)
}

/// Bits of the number at a corner; the corner has the two above. No vertex has 2³⁰ edges: each brings a face of four half-edges,
/// which have numbers of 32 bits.
const CORNER_SHIFT: u32 = 30;

/// The first slot of a corner.
fn first_slot(corner: u32) -> u32 {
    corner << CORNER_SHIFT
}

/// The corner, and the number there.
fn open_slot(slot: u32) -> [usize; 2] {
    [slot >> CORNER_SHIFT, slot & (first_slot(1) - 1)].map(|x| x as usize)
}

/// Where sharpness stands in a key with a shape.
pub(in crate::limit) fn places(key: &[u32]) -> impl Iterator<Item = usize> {
    (3..key.len()).step_by(3)
}

impl Apart {
    /// Takes the key of a walk round a quad apart; false where edges that are not spokes have a say.
    fn take(&mut self, walk: &[u32], sharpness: &[u32]) -> bool {
        let Self { shape, slots } = self;
        shape.clear();
        slots.clear();
        // A face of four sides.
        if walk.get(1) != Some(&4) {
            return false;
        }
        let (mut from, mut corners) = (0, 0);
        let mut notes = sharpness.iter().map(|&at| at as usize).peekable();
        while let Some(&first) = notes.peek() {
            let between = &walk[from..first];
            // Every corner begins with this number, and nothing else is as large.
            corners += between.iter().map(|&word| u32::from(word == u32::MAX)).sum::<u32>();
            shape.extend_from_slice(between);
            from = first;
            let mut slot = first_slot(corners - 1);
            while notes.next_if_eq(&from).is_some() {
                if walk[from..from + 2] != [0; 2] {
                    slots.extend([slot, walk[from], walk[from + 1]]);
                }
                (slot, from) = (slot + 1, from + 2);
            }
            // How many other edges follow, of either kind.
            if walk[from..from + 2] != [0; 2] {
                return false;
            }
            from += 2;
        }
        shape.extend_from_slice(&walk[from..]);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::walk_plan;
    use super::*;
    use crate::index::Face;
    use crate::limit::plan::may_have_fans;
    use crate::scheme::Scheme;
    use crate::shapes;
    use crate::topology::{Topology, Walk};
    use std::collections::BTreeMap;

    /// The walk round a quad at whose corners `spokes` edges meet, all smooth but one, `slot` of a corner, and where sharpness stands.
    fn walk_with(spokes: usize, sharp: [usize; 2]) -> (Vec<u32>, Vec<u32>) {
        let (mut walk, mut places) = (vec![0, 4], Vec::new());
        for corner in 0..4 {
            walk.push(u32::MAX);
            for slot in 0..=spokes {
                places.push(walk.len() as u32);
                walk.extend([u32::from(sharp == [corner, slot]), 0]);
            }
            walk.extend([0, 0]);
        }
        (walk, places)
    }

    #[test]
    fn slots_of_large_poles_are_not_those_of_the_next_corner() {
        let mut names = Names::new(true);
        let mut keys = Vec::new();
        for sharp in [[0, 65_536], [1, 0], [3, 65_540], [3, 4]] {
            let (walk, places) = walk_with(70_000, sharp);
            let key = names.key(&walk, &places).to_vec();
            let found: Vec<[usize; 2]> = slots(&key).map(|(corner, number, _)| [corner, number]).collect();
            assert_eq!(found, [sharp]);
            assert!(!keys.contains(&key));
            keys.push(key);
        }
        assert_eq!(names.shapes(), 1);
    }

    #[test]
    fn keys_with_shapes_tell_apart_what_walks_tell_apart() {
        let (mut short, mut full) = (Names::new(true), Names::new(false));
        let (mut walk, mut around) = (Walk::default(), Surroundings::default());
        let (mut by_short, mut by_full) = (BTreeMap::new(), BTreeMap::new());
        let mut with_shapes = 0;
        for shape in shapes::all() {
            let t = Topology::new(&shape.mesh).unwrap();
            if !may_have_fans(&t, Scheme::CatmullClark) {
                continue;
            }
            for face in (0..t.face_count()).map(Face::new) {
                let start = (t.sides(face) != 4).then_some(0);
                walk_plan(&t, face, start, &mut walk, &mut around);
                let [a, b] = [&mut short, &mut full].map(|names| names.plan_key(&around.key).to_vec());
                with_shapes += usize::from(super::shape(&a).is_some() && slots(&a[..a.len() - 1]).count() > 0);
                assert_eq!(*by_short.entry(a.clone()).or_insert(b.clone()), b, "{} {face}", shape.name);
                assert_eq!(*by_full.entry(b).or_insert(a.clone()), a, "{} {face}", shape.name);
            }
        }
        assert!(with_shapes > 50, "{with_shapes}");
    }
}
