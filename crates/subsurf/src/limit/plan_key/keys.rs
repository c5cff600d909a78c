//! Lists of numbers, each known by the place at which it was first met. They lie one after the other in one array, with a table of
//! places beside it, so that a new key costs no allocation.

use super::KeyHasher;
use crate::topology::NONE;
use std::hash::Hasher;

/// Keys, numbered from 0 in the order in which they came.
#[derive(Default)]
pub(in crate::limit) struct Keys {
    words: Vec<u32>,
    /// Where keys end in `words`.
    ends: Vec<usize>,
    /// Hashes and numbers; [`NONE`] where nothing is. A power of two, at most half of them in use.
    slots: Vec<(u32, u32)>,
}

/// Slots to begin with.
const LEAST_SLOTS: usize = 16;

impl Keys {
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Makes room for so many keys more of so many numbers each.
    pub fn reserve(&mut self, more: usize, numbers: usize) {
        self.ends.reserve(more);
        self.words.reserve(more * numbers);
        let slots = (2 * (self.len() + more)).next_power_of_two().max(LEAST_SLOTS);
        if slots > self.slots.len() {
            self.grow(slots);
        }
    }

    /// The key of a number.
    #[inline]
    pub fn key(&self, number: u32) -> &[u32] {
        let number = number as usize;
        let start = if number == 0 { 0 } else { self.ends[number - 1] };
        &self.words[start..self.ends[number]]
    }

    /// The keys from a number on.
    pub fn since(&self, first: usize) -> impl ExactSizeIterator<Item = &[u32]> {
        (first as u32..self.len() as u32).map(|number| self.key(number))
    }

    /// The number of a key, if it is known.
    pub fn get(&self, key: &[u32]) -> Option<u32> {
        if self.slots.is_empty() {
            return None;
        }
        let number = self.slots[self.place(hash(key), key)].1;
        (number != NONE).then_some(number)
    }

    /// The number of a key, and whether it is a new one.
    pub fn insert(&mut self, key: &[u32]) -> (u32, bool) {
        if 2 * (self.len() + 1) > self.slots.len() {
            self.grow((2 * self.slots.len()).max(LEAST_SLOTS));
        }
        let hash = hash(key);
        let place = self.place(hash, key);
        let number = self.slots[place].1;
        if number != NONE {
            return (number, false);
        }
        let number = self.len() as u32;
        self.words.extend_from_slice(key);
        self.ends.push(self.words.len());
        self.slots[place] = (hash, number);
        (number, true)
    }

    /// Where a key is, or would be.
    #[inline]
    fn place(&self, hash: u32, key: &[u32]) -> usize {
        let mask = self.slots.len() - 1;
        let mut at = hash as usize & mask;
        loop {
            let (known, number) = self.slots[at];
            if number == NONE || known == hash && self.key(number) == key {
                return at;
            }
            at = (at + 1) & mask;
        }
    }

    fn grow(&mut self, slots: usize) {
        let old = std::mem::replace(&mut self.slots, vec![(0, NONE); slots]);
        for (hash, number) in old.into_iter().filter(|slot| slot.1 != NONE) {
            let mut at = hash as usize & (slots - 1);
            while self.slots[at].1 != NONE {
                at = (at + 1) & (slots - 1);
            }
            self.slots[at] = (hash, number);
        }
    }
}

fn hash(key: &[u32]) -> u32 {
    let mut hasher = KeyHasher::default();
    let (pairs, rest) = key.as_chunks();
    for &[a, b] in pairs {
        hasher.write_u64(u64::from(a) << 32 | u64::from(b));
    }
    rest.iter().for_each(|&word| hasher.write_u32(word));
    let hash = hasher.finish();
    (hash ^ hash >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn keys_are_numbered_as_they_come_and_found_again() {
        let (mut keys, mut expected) = (Keys::default(), HashMap::new());
        assert_eq!(keys.get(&[]), None);
        // Lists of up to three numbers, most of them several times.
        for i in 0..4000u32 {
            let list = [i % 7, (i % 5) << 20, i % 11];
            let key = &list[..(i % 4) as usize];
            let next = expected.len() as u32;
            let number = *expected.entry(key.to_vec()).or_insert(next);
            assert_eq!(keys.get(key), (number != next).then_some(number));
            assert_eq!(keys.insert(key), (number, number == next));
            assert_eq!(keys.key(number), key);
        }
        assert!(keys.len() == expected.len() && keys.len() > 100);
        assert!(keys.since(0).zip(0..).all(|(key, number)| expected[key] == number));
    }
}
