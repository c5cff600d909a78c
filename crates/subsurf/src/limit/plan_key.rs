//! Keys of plans: surroundings as lists of numbers, compared in full. Equal keys mean equal limit masks.

mod keys;
pub(super) mod names;

use crate::index::{Face, HalfEdge};
use crate::topology::{Around, Lowest, Surroundings, Tables, Topology, Walk, lowered};
pub(super) use keys::Keys;
pub(super) use names::Names;
use std::hash::Hasher;

/// Walks round a face that is one patch from its canonical corner, round a sub-face from the corner `start`, and leaves the plan's
/// key and ring in `around`. Returns the corner.
pub(super) fn walk_plan(
    t: &Topology,
    face: Face,
    start: Option<usize>,
    walk: &mut Walk,
    around: &mut Surroundings,
) -> usize {
    let lowest = Lowest::of(t, face);
    let start = start.unwrap_or_else(|| canonical_corner(t, face, lowest.excess()));
    t.lowered_surroundings(face, start, lowest.raise() as i8, walk, around);
    around.close_key();
    start
}

/// The corner of a quad or triangle at which its walk starts, chosen by what lies round the corners, so that faces that
/// differ by a turn alone share a plan. Ties go to the first. Raising all finite sharpness by a whole number changes nothing;
/// `excess` is the face's [excess](Lowest::excess).
pub(super) fn canonical_corner(t: &impl Tables, face: Face, excess: u8) -> usize {
    let sides = t.sides(face);
    let mut sign = [0; 4];
    for (c, s) in sign.iter_mut().enumerate().take(sides) {
        *s = corner_signature(t, t.half_edge(face, c), excess as i8);
    }
    if sign[1..sides].iter().all(|&s| s == sign[0]) {
        return 0;
    }
    let turned = |c: usize| {
        let mut signs = [0; 4];
        (0..sides).for_each(|k| signs[k] = sign[(c + k) % sides]);
        signs
    };
    (0..sides).min_by_key(|&c| turned(c)).unwrap_or(0)
}

/// A number that is equal for corners with equal fans (and seldom equal for others), finite sharpness lowered by `excess`.
pub(super) fn corner_signature(t: &impl Tables, own: HalfEdge, excess: i8) -> u64 {
    let v = t.origin(own);
    let sharp = t.vertex_sharpness(v) > 0.0 || t.sharp_edges(v).next().is_some();
    let mut hash = KeyHasher::default();
    let mut note = |h: HalfEdge| {
        hash.write_u32(t.sides(t.face(h)) as u32);
        if sharp {
            hash.write_u64(lowered(t.edge_sharpness(t.edge(h)), excess).to_bits());
        }
    };
    let (mut left, mut right) = (0u64, 0u64);
    let mut at = own;
    let closed = loop {
        note(at);
        match t.turn_left(at) {
            None => break false,
            Some(h) if h == own => break true,
            Some(h) => at = h,
        }
        left += 1;
    };
    if !closed {
        at = own;
        while let Some(h) = t.turn_right(at) {
            note(h);
            at = h;
            right += 1;
        }
    }
    if sharp {
        hash.write_u64(lowered(t.vertex_sharpness(v), excess).to_bits());
    }
    // Valence first, so that canonical turns put the smallest valence at the front.
    (left + right).min(0xffff) << 48 | right.min(0xff) << 40 | (hash.finish() & 0xff_ffff_ffff)
}

/// A fast hash of short lists of small numbers; keys are compared in full.
#[derive(Default)]
pub(crate) struct KeyHasher(u64);

impl Hasher for KeyHasher {
    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 29
    }
    fn write(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks();
        words.iter().for_each(|&word| self.write_u64(u64::from_le_bytes(word)));
        if !rest.is_empty() {
            self.write_u64(rest.iter().fold(0, |word, &byte| word << 8 | u64::from(byte)));
        }
    }
    fn write_u32(&mut self, x: u32) {
        self.write_u64(u64::from(x));
    }
    fn write_u64(&mut self, x: u64) {
        self.0 = (self.0.rotate_left(23) ^ x).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}
