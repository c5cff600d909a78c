//! Words of one line: separated by blanks, ended by the line or by a word that starts with `#`.

use crate::number::{float, is_blank, word_length};
use crate::read_error::{LineError, quoted};

/// A cursor over the words of a line.
#[derive(Clone)]
pub struct Words<'a> {
    rest: &'a [u8],
}

impl<'a> Words<'a> {
    pub fn new(line: &'a [u8]) -> Self {
        Self { rest: line }
    }

    /// Moves to the start of the next word; false if there is none.
    #[inline]
    fn seek(&mut self) -> bool {
        while let [first, rest @ ..] = self.rest
            && is_blank(*first)
        {
            self.rest = rest;
        }
        self.rest.first().is_some_and(|&b| b != b'#')
    }

    /// The next number; `statement` is what messages call the line.
    #[inline]
    pub fn number(&mut self, statement: &'static str) -> Result<Option<f64>, LineError> {
        if !self.seek() {
            return Ok(None);
        }
        match float(self.rest) {
            Some((value, length)) => {
                self.rest = &self.rest[length..];
                Ok(Some(value))
            }
            None => Err(LineError::BadNumber { statement, word: quoted(&self.rest[..word_length(self.rest)]) }),
        }
    }

    /// As [`number`](Self::number), for a number that has to be finite; `advice` says what to write instead.
    #[inline]
    pub fn finite_number(&mut self, statement: &'static str, advice: &'static str) -> Result<Option<f64>, LineError> {
        let before = self.rest;
        match self.number(statement)? {
            Some(value) if !value.is_finite() => {
                let word = Words::new(before).next().unwrap_or_default();
                Err(LineError::NotFinite { statement, word: quoted(word), advice })
            }
            number => Ok(number),
        }
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    #[inline]
    fn next(&mut self) -> Option<&'a [u8]> {
        if !self.seek() {
            return None;
        }
        let (word, rest) = self.rest.split_at(word_length(self.rest));
        self.rest = rest;
        Some(word)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_end_at_blanks_and_at_a_comment() {
        let words: Vec<_> = Words::new(b"  f\t1/2  g#h #x y\r").collect();
        assert_eq!(words, [&b"f"[..], b"1/2", b"g#h"]);
    }

    #[test]
    fn numbers_stop_at_the_end_and_name_what_is_none() {
        let mut words = Words::new(b"1 2.5 x");
        assert_eq!(words.number("v"), Ok(Some(1.0)));
        assert_eq!(words.number("v"), Ok(Some(2.5)));
        assert_eq!(words.number("v"), Err(LineError::BadNumber { statement: "v", word: "x".into() }));
        assert_eq!(Words::new(b" ").number("v"), Ok(None));
        assert!(matches!(Words::new(b"inf").finite_number("v", "fix"), Err(LineError::NotFinite { .. })));
    }
}
