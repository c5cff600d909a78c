//! The table of places, read block by block: CSV whose header names the columns face, subface, u and v in any order.

use super::table_error::{RowError, TableError, quoted};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use subsurf::{Face, Location, PatchTable, Scheme};

/// Bytes read at a time, and the longest line. Larger costs memory (the result of a block takes about ten times as
/// much), smaller keeps threads waiting for each other.
pub const BLOCK: usize = 1 << 20;

/// The columns that are needed.
const NAMES: [&str; 4] = ["face", "subface", "u", "v"];

/// A stream of places.
pub struct Places {
    name: String,
    input: Box<dyn Read>,
    length: u64,
    /// Number of the next line.
    line: u64,
    /// Start of the line that the last block cut.
    rest: Vec<u8>,
}

/// What the header says.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Header {
    /// Where the columns of [`NAMES`] lie.
    columns: [usize; 4],
    width: usize,
}

/// Whole lines of the table.
#[derive(Default)]
pub struct Block {
    text: Vec<u8>,
    lines: Vec<Line>,
}

/// One line of a block.
pub struct Line {
    pub number: u64,
    start: usize,
    end: usize,
}

/// The fields of a row as they stand.
pub struct Words<'a> {
    /// Face, sub-face, u and v.
    pub fields: [&'a [u8]; 4],
    /// How many fields there are in all.
    found: usize,
}

impl Places {
    /// Opens a table, or standard input for `-`, and reads its header.
    pub fn open(path: &Path) -> Result<(Self, Header), TableError> {
        if path.as_os_str() == "-" {
            return Self::new("standard input".to_owned(), Box::new(io::stdin()), 0);
        }
        let name = path.display().to_string();
        let opened = fs::metadata(path).and_then(|metadata| match metadata.is_dir() {
            true => Err(io::ErrorKind::IsADirectory.into()),
            false => Ok((File::open(path)?, metadata.len())),
        });
        match opened {
            Ok((file, length)) => Self::new(name, Box::new(file), length),
            Err(error) => Err(TableError::from_io(&name, error)),
        }
    }

    fn new(name: String, input: Box<dyn Read>, length: u64) -> Result<(Self, Header), TableError> {
        let mut places = Self { name, input, length, line: 1, rest: Vec::new() };
        let header = places.read_header()?;
        Ok((places, header))
    }

    /// Bytes of the table, if it is a file.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// An error on a line of this table.
    pub fn error(&self, line: u64, source: RowError) -> TableError {
        TableError::Row { name: self.name.clone(), line, source }
    }

    /// Reads the first line that is not blank; what follows it waits for the first block.
    fn read_header(&mut self) -> Result<Header, TableError> {
        let mut block = Block::default();
        if !self.read(&mut block)? {
            return Err(self.error(1, RowError::NoHeader));
        }
        let line = &block.lines[0];
        let header =
            Header::parse(&block.text[line.start..line.end]).map_err(|source| self.error(line.number, source))?;
        self.line = line.number + 1;
        let after = (line.end + 1).min(block.text.len());
        block.text.drain(..after);
        block.text.append(&mut self.rest);
        self.rest = block.text;
        Ok(header)
    }

    /// Reads the next whole lines; false at the end.
    pub fn read(&mut self, block: &mut Block) -> Result<bool, TableError> {
        loop {
            block.text.clear();
            block.text.append(&mut self.rest);
            let wanted = BLOCK.saturating_sub(block.text.len());
            let read = (&mut self.input).take(wanted as u64).read_to_end(&mut block.text);
            let ended = read.map_err(|error| TableError::from_io(&self.name, error))? < wanted;
            if block.text.is_empty() {
                return Ok(false);
            }
            if !ended {
                let end = memchr::memrchr(b'\n', &block.text);
                let end = end.ok_or_else(|| self.error(self.line, RowError::TooLong))?;
                self.rest.extend_from_slice(&block.text[end + 1..]);
                block.text.truncate(end + 1);
            }
            self.line = block.find_lines(self.line);
            if !block.lines.is_empty() {
                return Ok(true);
            }
        }
    }
}

impl Header {
    fn parse(line: &[u8]) -> Result<Self, RowError> {
        let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
        let words: Vec<&[u8]> = line.split(|&b| b == b',').map(bare).collect();
        let mut columns = [0; 4];
        for (name, column) in NAMES.into_iter().zip(&mut columns) {
            let mut found = (0..words.len()).filter(|&i| words[i].eq_ignore_ascii_case(name.as_bytes()));
            *column = found.next().ok_or(RowError::NoColumn(name))?;
            if found.next().is_some() {
                return Err(RowError::TwoColumns(name));
            }
        }
        Ok(Self { columns, width: words.len() })
    }

    /// The fields of a line of `block`.
    pub fn words<'a>(&self, block: &'a Block, line: &Line) -> Words<'a> {
        let mut words = Words { fields: [b""; 4], found: 0 };
        for (i, word) in block.text[line.start..line.end].split(|&b| b == b',').enumerate() {
            words.found += 1;
            if let Some(at) = self.columns.iter().position(|&column| column == i) {
                words.fields[at] = bare(word);
            }
        }
        words
    }

    /// The place that the fields of a row name.
    pub fn location(&self, words: &Words<'_>, table: &PatchTable) -> Result<Location, RowError> {
        if words.found != self.width {
            return Err(RowError::FieldCount { found: words.found, needed: self.width });
        }
        let [face, subface, u, v] = words.fields;
        let (face, subface) = (index("face", face)?, index("subface", subface)?);
        let (u, v) = (parameter("u", u)?, parameter("v", v)?);
        let faces = table.topology().face_count();
        if face as usize >= faces {
            return Err(RowError::NoFace { face, faces });
        }
        let subfaces = table.subfaces(Face(face));
        if subface >= subfaces {
            return Err(RowError::NoSubface { face, subface, subfaces });
        }
        // As far beyond the third side as two rounded numbers may lie, and the surface takes.
        if table.scheme() == Scheme::Loop && u + v > 1.0 + 4.0 * f64::EPSILON {
            return Err(RowError::BeyondTriangle { sum: u + v });
        }
        Ok(Location { face: Face(face), subface, u, v })
    }
}

impl Block {
    /// Lines that are not blank.
    pub fn lines(&self) -> &[Line] {
        &self.lines
    }

    /// Length of its text.
    pub fn bytes(&self) -> u64 {
        self.text.len() as u64
    }

    /// Splits the text, whose first line has number `number`; returns the number of the line after it.
    fn find_lines(&mut self, mut number: u64) -> u64 {
        self.lines.clear();
        let mut start = 0;
        while start < self.text.len() {
            let end = memchr::memchr(b'\n', &self.text[start..]).map_or(self.text.len(), |length| start + length);
            if !self.text[start..end].trim_ascii().is_empty() {
                self.lines.push(Line { number, start, end });
            }
            number += 1;
            start = end + 1;
        }
        number
    }
}

/// A field without blanks and quotes round it.
fn bare(word: &[u8]) -> &[u8] {
    let word = word.trim_ascii();
    word.strip_prefix(b"\"").and_then(|word| word.strip_suffix(b"\"")).unwrap_or(word).trim_ascii()
}

fn index(name: &'static str, word: &[u8]) -> Result<u32, RowError> {
    let value = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
    value.ok_or_else(|| RowError::BadIndex { name, word: quoted(word) })
}

fn parameter(name: &'static str, word: &[u8]) -> Result<f64, RowError> {
    let value = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
    value.filter(|x| (0.0..=1.0).contains(x)).ok_or_else(|| RowError::BadParameter { name, word: quoted(word) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_all(text: String) -> Vec<(u64, String)> {
        let (mut places, header) = Places::new("t".into(), Box::new(io::Cursor::new(text)), 0).unwrap();
        let (mut block, mut rows) = (Block::default(), Vec::new());
        while places.read(&mut block).unwrap() {
            for line in block.lines() {
                let fields = header.words(&block, line).fields;
                rows.push((line.number, String::from_utf8(fields.join(&b' ')).unwrap()));
            }
        }
        rows
    }

    #[test]
    fn columns_come_in_any_order_among_others_with_blanks_quotes_and_any_line_ends() {
        let text = "\u{feff}v, note ,\"u\",subface,FACE\r\n0.5,x, 0.25 ,1,\"7\"\r\n\n1,,0,0,0";
        assert_eq!(read_all(text.into()), [(2, "7 1 0.25 0.5".into()), (4, "0 0 0 1".into())]);
    }

    #[test]
    fn a_long_table_is_read_whole_with_its_line_numbers() {
        let rows = 3 * BLOCK / 12;
        let text: String =
            std::iter::once("face,subface,u,v\n".into()).chain((0..rows).map(|i| format!("{i},0,0,1\n"))).collect();
        let read = read_all(text);
        assert_eq!(read.len(), rows);
        assert!(read.iter().enumerate().all(|(i, row)| *row == (i as u64 + 2, format!("{i} 0 0 1"))));
    }

    #[test]
    fn a_line_without_end_is_refused() {
        let text = "face,subface,u,v\n".to_owned() + &"0".repeat(2 * BLOCK);
        let (mut places, _) = Places::new("t".into(), Box::new(io::Cursor::new(text)), 0).unwrap();
        let error = places.read(&mut Block::default()).unwrap_err();
        assert!(error.to_string().starts_with("t:2: the line is longer than"), "{error}");
    }
}
