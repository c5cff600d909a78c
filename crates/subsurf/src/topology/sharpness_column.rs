//! Sharpness of all edges or all vertices in a byte each: meshes name few distinct values, most of them zero. Every value is
//! kept as it is, to the last bit.

use crate::tags::INFINITE_SHARPNESS;
use std::collections::BTreeMap;

/// One value in `[0, 10]` per element.
#[derive(Clone, Debug)]
pub(crate) struct SharpnessColumn {
    /// Which of `values`, or [`RARE`].
    code: Vec<u8>,
    /// Smooth first, then infinite, then others as they came.
    values: Vec<f64>,
    /// Values that came when all codes were taken, by element.
    rare: BTreeMap<u32, f64>,
}

const RARE: u8 = u8::MAX;

impl SharpnessColumn {
    /// `len` smooth elements.
    pub fn smooth(len: usize) -> Self {
        Self { code: subsurf_memory::zeroed(len), values: vec![0.0, INFINITE_SHARPNESS], rare: BTreeMap::new() }
    }

    pub fn len(&self) -> usize {
        self.code.len()
    }

    /// A number that elements of equal sharpness share; `u8::MAX` for those whose sharpness is one of very many.
    #[inline]
    pub fn code(&self, i: usize) -> u8 {
        self.code[i]
    }

    /// True where one of these elements is not smooth.
    pub fn is_any_sharp(&self, elements: std::ops::Range<usize>) -> bool {
        self.code[elements].iter().fold(0, |all, code| all | code) != 0
    }

    #[inline]
    pub fn get(&self, i: usize) -> f64 {
        match self.code[i] {
            0 => 0.0,
            RARE => self.rare.get(&(i as u32)).copied().unwrap_or(0.0),
            code => self.values[usize::from(code)],
        }
    }

    /// Adds an element.
    pub fn push(&mut self, sharpness: f64) {
        self.code.push(0);
        if sharpness != 0.0 {
            self.set(self.code.len() - 1, sharpness);
        }
    }

    /// Takes all elements out.
    pub fn clear(&mut self) {
        self.code.clear();
        self.values.truncate(2);
        self.rare.clear();
    }

    /// Becomes equal to another column, in the memory that is there.
    pub fn assign(&mut self, other: &Self) {
        self.code.clone_from(&other.code);
        self.values.clone_from(&other.values);
        self.rare.clone_from(&other.rare);
    }

    pub fn set(&mut self, i: usize, sharpness: f64) {
        if self.code[i] == RARE {
            self.rare.remove(&(i as u32));
        }
        let known = self.values.iter().position(|&s| s == sharpness);
        self.code[i] = match known {
            Some(code) => code as u8,
            None if self.values.len() < usize::from(RARE) => {
                self.values.push(sharpness);
                (self.values.len() - 1) as u8
            }
            None => {
                self.rare.insert(i as u32, sharpness);
                RARE
            }
        };
    }

    /// Values in order.
    pub fn iter(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.len()).map(|i| self.get(i))
    }

    /// Every value other than 0 and 10 that an element has, and perhaps some that one had.
    pub fn distinct(&self) -> impl Iterator<Item = f64> + '_ {
        self.values[2..].iter().chain(self.rare.values()).copied()
    }

    /// Changes all values other than 0 and 10.
    pub fn change_values(&mut self, change: impl Fn(f64) -> f64) {
        self.values[2..].iter_mut().chain(self.rare.values_mut()).for_each(|s| *s = change(*s));
    }

    /// Elements that are not smooth, in order.
    pub fn sharp(&self) -> impl Iterator<Item = usize> + '_ {
        // Most blocks are smooth as a whole.
        let blocks = self.code.chunks(64).enumerate().filter(|(_, block)| block.iter().fold(0, |all, c| all | c) != 0);
        blocks.flat_map(|(b, block)| (64 * b..).zip(block).filter(|(_, code)| **code != 0).map(|(i, _)| i))
    }

    /// Heap memory in bytes; entries of the map as if they were in full nodes.
    pub fn bytes(&self) -> usize {
        self.code.capacity() + size_of::<f64>() * self.values.capacity() + self.rare.len() * size_of::<(u32, f64)>()
    }
}

impl FromIterator<f64> for SharpnessColumn {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut out = Self::smooth(0);
        values.into_iter().for_each(|s| out.push(s));
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_comes_back_to_the_bit_however_many_there_are() {
        let values: Vec<f64> = (0..1000).map(|i| if i % 3 == 0 { 0.0 } else { f64::from(i) * 0.01 }).collect();
        let mut column: SharpnessColumn = values.iter().copied().collect();
        let same = |column: &SharpnessColumn, values: &[f64]| {
            assert!(column.iter().zip(values).all(|(a, b)| a.to_bits() == b.to_bits()));
            let sharp: Vec<usize> = (0..values.len()).filter(|&i| values[i] > 0.0).collect();
            assert_eq!(column.sharp().collect::<Vec<_>>(), sharp);
        };
        same(&column, &values);
        // Rare values give way to common ones and come back.
        let turned: Vec<f64> = values.iter().rev().copied().collect();
        turned.iter().enumerate().for_each(|(i, &s)| column.set(i, s));
        same(&column, &turned);
        (0..1000).for_each(|i| column.set(i, 0.0));
        assert!(column.rare.is_empty());
    }
}
