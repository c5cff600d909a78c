//! Lines of a text file of any size, through one buffer that is used again. Lines end at `\n`; a `\r` before it and a
//! byte-order mark are dropped; a line that ends in `\` goes on in the next one, except comments and statements that
//! end in a name, where a backslash is likely part of a Windows path.

use crate::number::{is_blank, word_length};
use memchr::memchr;
use std::io::{self, ErrorKind, Read};
use std::ops::Range;

/// Bytes asked of the source at once.
const BLOCK: usize = 1 << 18;

/// Reads lines from a source.
pub struct LineReader<R> {
    source: R,
    /// What was read and not yet returned is `buffer[start..end]`.
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    ended: bool,
    /// How many lines of the file were consumed.
    line: u32,
    /// A line that was put together from several.
    joined: Vec<u8>,
}

impl<R: Read> LineReader<R> {
    pub fn new(source: R) -> Self {
        Self { source, buffer: vec![0; BLOCK], start: 0, end: 0, ended: false, line: 0, joined: Vec::new() }
    }

    /// The next line without its end, and its number counted from 1 (that of its first part where it was continued).
    pub fn next_line(&mut self) -> io::Result<Option<(&[u8], u32)>> {
        let Some(mut range) = self.next_part()? else { return Ok(None) };
        let number = self.line;
        if number == 1 && self.buffer[range.clone()].starts_with(b"\xef\xbb\xbf") {
            range.start += 3;
        }
        if !continues(&self.buffer[range.clone()]) {
            return Ok(Some((&self.buffer[range], number)));
        }
        self.joined.clear();
        loop {
            let part = &self.buffer[range];
            let goes_on = part.last() == Some(&b'\\');
            self.joined.extend_from_slice(if goes_on { &part[..part.len() - 1] } else { part });
            if !goes_on {
                break;
            }
            self.joined.push(b' ');
            match self.next_part()? {
                Some(next) => range = next,
                None => break,
            }
        }
        Ok(Some((&self.joined, number)))
    }

    /// Where in the buffer the next line of the file lies.
    fn next_part(&mut self) -> io::Result<Option<Range<usize>>> {
        let mut searched = 0;
        let length = loop {
            let text = &self.buffer[self.start..self.end];
            match memchr(b'\n', &text[searched..]) {
                Some(found) => break searched + found,
                None if !self.ended => {
                    searched = text.len();
                    self.fill()?;
                }
                None if text.is_empty() => return Ok(None),
                None => break text.len(),
            }
        };
        let range = self.start..self.start + length;
        self.start = (range.end + 1).min(self.end);
        self.line = self.line.saturating_add(1);
        let carriage_return = self.buffer[range.clone()].last() == Some(&b'\r');
        Ok(Some(range.start..range.end - usize::from(carriage_return)))
    }

    /// Reads more, after moving what is left to the front; the buffer grows only when one line fills it.
    fn fill(&mut self) -> io::Result<()> {
        if self.start > 0 {
            self.buffer.copy_within(self.start..self.end, 0);
            (self.start, self.end) = (0, self.end - self.start);
        }
        if self.end == self.buffer.len() {
            self.buffer.resize(2 * self.end, 0);
        }
        loop {
            match self.source.read(&mut self.buffer[self.end..]) {
                Ok(count) => {
                    self.end += count;
                    self.ended = count == 0;
                    return Ok(());
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }
}

/// Whether the statement that starts on this line goes on in the next.
fn continues(line: &[u8]) -> bool {
    if line.last() != Some(&b'\\') {
        return false;
    }
    let text = &line[line.iter().position(|&b| !is_blank(b)).unwrap_or(0)..];
    let takes_a_name = matches!(&text[..word_length(text)], b"g" | b"o" | b"mtllib" | b"usemtl");
    !takes_a_name && memchr(b'#', text).is_none()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hands out one byte at a time.
    struct Slow<'a>(&'a [u8]);

    impl Read for Slow<'_> {
        fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
            let Some((first, rest)) = self.0.split_first() else { return Ok(0) };
            into[0] = *first;
            self.0 = rest;
            Ok(1)
        }
    }

    fn lines(source: impl Read) -> Vec<(String, u32)> {
        let mut reader = LineReader::new(source);
        let mut all = Vec::new();
        while let Some((text, number)) = reader.next_line().unwrap() {
            all.push((String::from_utf8_lossy(text).into_owned(), number));
        }
        all
    }

    fn expect(expected: &[(&str, u32)], text: &str) {
        let expected: Vec<_> = expected.iter().map(|&(text, number)| (text.to_owned(), number)).collect();
        assert_eq!(lines(text.as_bytes()), expected);
        assert_eq!(lines(Slow(text.as_bytes())), expected);
    }

    #[test]
    fn line_ends_of_all_systems_and_a_byte_order_mark_are_dropped() {
        expect(&[("v 1", 1), ("", 2), ("v 2", 3)], "\u{feff}v 1\r\n\nv 2");
        expect(&[("a", 1)], "a\n");
        expect(&[], "");
    }

    #[test]
    fn a_backslash_joins_lines_and_the_first_part_names_them() {
        expect(&[("f 1  2  3", 1), ("v", 4)], "f 1 \\\r\n2 \\\n3\nv");
        expect(&[("f 1 ", 1)], "f 1\\");
        expect(&[("f 1 ", 1)], "f 1\\\n");
    }

    #[test]
    fn a_backslash_in_a_comment_or_name_is_text() {
        expect(&[("# C:\\", 1), ("v", 2)], "# C:\\\nv");
        expect(&[(" mtllib C:\\a\\", 1), ("v", 2)], " mtllib C:\\a\\\nv");
    }

    #[test]
    fn a_line_longer_than_the_buffer_is_kept_whole() {
        let long = "x".repeat(3 * BLOCK + 5);
        expect(&[("a", 1), (&long, 2), ("b", 3)], &format!("a\n{long}\nb"));
    }
}
