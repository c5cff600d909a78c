//! The numbers behind a figure, as CSV.

use std::fmt::Write;

/// A row of names over rows of values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    header: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

/// One value.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    Word(&'static str),
    Count(usize),
    Number(f64),
}

impl From<&'static str> for Cell {
    fn from(word: &'static str) -> Self {
        Self::Word(word)
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Count(count)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl Table {
    /// An empty table.
    pub fn new<S: Into<String>>(header: impl IntoIterator<Item = S>) -> Self {
        Self { header: header.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// Adds a row.
    ///
    /// # Panics
    /// If it has not one cell per name.
    pub fn push(&mut self, row: Vec<Cell>) {
        assert_eq!(row.len(), self.header.len(), "one cell per column");
        self.rows.push(row);
    }

    /// A header line, then one line per row. Numbers have the fewest digits from which the same number is read.
    pub fn csv(&self) -> String {
        let mut text = self.header.join(",") + "\n";
        for row in &self.rows {
            for (i, cell) in row.iter().enumerate() {
                let comma = if i > 0 { "," } else { "" };
                let written = match cell {
                    Cell::Word(word) => write!(text, "{comma}{word}"),
                    Cell::Count(count) => write!(text, "{comma}{count}"),
                    Cell::Number(number) => write!(text, "{comma}{number}"),
                };
                written.expect("a string takes every number");
            }
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_as_they_were() {
        let mut table = Table::new(["what", "n", "x"]);
        let numbers = [0.1 + 0.2, 1e-300, -0.0, 1e22];
        for x in numbers {
            table.push(vec!["row".into(), 3usize.into(), x.into()]);
        }
        let read: Vec<f64> =
            table.csv().lines().skip(1).map(|line| line.rsplit(',').next().unwrap().parse().unwrap()).collect();
        assert!(read.iter().zip(numbers).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
}
