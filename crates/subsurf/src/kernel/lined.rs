//! Memory to work in that begins at a line of the cache: where it does not, every vector of 64 bytes reaches across two.

use super::LANES;
use super::lattice::Sixteen;
use crate::real::Real;

/// Bytes of a line.
const LINE: usize = 64;

/// Numbers, at first zero.
#[derive(Default)]
pub(crate) struct Lined<T> {
    memory: Vec<T>,
    start: usize,
}

impl<T: Real> Lined<T> {
    pub fn new(count: usize) -> Self {
        let slack = LINE / size_of::<T>();
        let memory = vec![T::default(); count + slack];
        // Nothing but speed depends on it.
        let start = memory.as_ptr().align_offset(LINE).min(slack);
        Self { memory, start }
    }

    /// Room for at least so many.
    pub fn reserve(&mut self, count: usize) {
        if self.memory.len() < self.start + count {
            *self = Self::new(count);
        }
    }

    pub fn numbers(&mut self) -> &mut [T] {
        &mut self.memory[self.start..]
    }

    /// The same as points of sixteen lanes.
    pub fn sixteens<const N: usize>(&mut self) -> &mut [Sixteen<T, N>] {
        self.numbers().as_chunks_mut::<LANES>().0.as_chunks_mut::<N>().0
    }

    /// The same as values.
    pub fn values<const N: usize>(&mut self) -> &mut [[T; N]] {
        self.numbers().as_chunks_mut::<N>().0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_begins_at_a_line_and_has_room() {
        fn check<T: Real>() {
            for count in [0, 1, 48, 1000] {
                let mut memory = Lined::<T>::new(count);
                memory.reserve(count + 5);
                assert!(memory.numbers().len() >= count + 5);
                assert_eq!(memory.numbers().as_ptr().addr() % LINE, 0);
            }
        }
        check::<f32>();
        check::<f64>();
    }
}
