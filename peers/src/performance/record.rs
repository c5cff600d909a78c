//! Results as JSON lines, one line per contest, so that a run can be taken up again and the document be written at any
//! time. The first keys of a line are its section and mesh.

use serde_json::{Value, json};
use std::path::Path;

/// Who took how long for one piece of work.
#[derive(Clone, PartialEq, Debug)]
pub struct Record {
    pub section: String,
    pub mesh: String,
    pub what: String,
    /// What `count` counts.
    pub unit: String,
    pub count: f64,
    /// Ours first.
    pub entries: Vec<Entry>,
}

/// One of those who did it.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Entry {
    pub name: String,
    /// Nanoseconds a unit: by the processor, and on the wall.
    pub processor: Option<Spread>,
    pub wall: Option<Spread>,
    /// Processor time as a multiple of ours in the same round.
    pub ratio: Option<Spread>,
    /// Where not time but something else is told: bytes, say.
    pub value: Option<f64>,
    /// Why there is nothing.
    pub failed: Option<String>,
    pub note: String,
}

/// Order statistics of what was measured.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Spread {
    pub least: f64,
    pub lower: f64,
    pub median: f64,
    pub upper: f64,
    pub most: f64,
    pub rounds: usize,
}

impl Spread {
    /// None of nothing.
    pub fn of(mut values: Vec<f64>) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let n = values.len();
        // Between neighbours where a quantile falls between them.
        let at = |q: f64| {
            let place = q * (n - 1) as f64;
            let low = place.floor() as usize;
            values[low] + (values[(low + 1).min(n - 1)] - values[low]) * (place - low as f64)
        };
        (n > 0).then(|| Self {
            least: at(0.0),
            lower: at(0.25),
            median: at(0.5),
            upper: at(0.75),
            most: at(1.0),
            rounds: n,
        })
    }

    fn to_json(self) -> Value {
        json!([self.least, self.lower, self.median, self.upper, self.most, self.rounds])
    }

    fn from_json(value: &Value) -> Option<Self> {
        let at = |i: usize| value.get(i)?.as_f64();
        Some(Self {
            least: at(0)?,
            lower: at(1)?,
            median: at(2)?,
            upper: at(3)?,
            most: at(4)?,
            rounds: value.get(5)?.as_u64()? as usize,
        })
    }
}

impl Entry {
    /// Something told, not timed.
    pub fn value(name: &str, value: f64) -> Self {
        Self { name: name.to_string(), value: Some(value), ..Self::default() }
    }

    /// Someone who is not there, and why.
    pub fn absent(name: &str, why: &str) -> Self {
        Self { name: name.to_string(), failed: Some(why.to_string()), ..Self::default() }
    }

    fn to_json(&self) -> Value {
        json!({
            "name": self.name,
            "processor": self.processor.map(Spread::to_json),
            "wall": self.wall.map(Spread::to_json),
            "ratio": self.ratio.map(Spread::to_json),
            "value": self.value,
            "failed": self.failed,
            "note": self.note,
        })
    }

    fn from_json(v: &Value) -> Option<Self> {
        Some(Self {
            name: v["name"].as_str()?.to_string(),
            processor: Spread::from_json(&v["processor"]),
            wall: Spread::from_json(&v["wall"]),
            ratio: Spread::from_json(&v["ratio"]),
            value: v["value"].as_f64(),
            failed: v["failed"].as_str().map(str::to_string),
            note: v["note"].as_str()?.to_string(),
        })
    }
}

impl Record {
    /// One line of text.
    pub fn to_line(&self) -> String {
        let entries: Vec<Value> = self.entries.iter().map(Entry::to_json).collect();
        json!({
            "section": self.section,
            "mesh": self.mesh,
            "what": self.what,
            "unit": self.unit,
            "count": self.count,
            "entries": entries,
        })
        .to_string()
    }

    /// None of a line that says something else.
    pub fn from_line(line: &str) -> Option<Self> {
        let v: Value = serde_json::from_str(line).ok()?;
        let text = |key: &str| Some(v[key].as_str()?.to_string());
        Some(Self {
            section: text("section")?,
            mesh: text("mesh")?,
            what: text("what")?,
            unit: text("unit")?,
            count: v["count"].as_f64()?,
            entries: v["entries"].as_array()?.iter().map(Entry::from_json).collect::<Option<_>>()?,
        })
    }

    /// The entry of this name.
    pub fn entry(&self, name: &str) -> Option<&Entry> {
        self.entries.iter().find(|e| e.name == name)
    }
}

/// The records of a file; none where there is no file.
pub fn read(path: &Path) -> Vec<Record> {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.lines().filter_map(Record::from_line).collect()
}

/// Writes all, replacing what was there at once.
pub fn write(path: &Path, records: &[Record]) -> Result<(), String> {
    let text: String = records.iter().map(|r| r.to_line() + "\n").collect();
    let fail = |e: std::io::Error| format!("{}: {e}", path.display());
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(fail)?;
    }
    let beside = path.with_extension("part");
    std::fs::write(&beside, text).map_err(fail)?;
    std::fs::rename(&beside, path).map_err(fail)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_survives_its_line() {
        let spread = Spread::of(vec![3.0, 1.0, 2.0, 5.0]);
        let timed = Entry { name: "ours".to_string(), processor: spread, wall: spread, ..Entry::default() };
        let record = Record {
            section: "refine".to_string(),
            mesh: "cube".to_string(),
            what: "level 2".to_string(),
            unit: "vertex".to_string(),
            count: 7.0,
            entries: vec![timed, Entry::absent("rival", "absent"), Entry::value("bytes", 12.5)],
        };
        assert_eq!(Record::from_line(&record.to_line()), Some(record));
    }

    #[test]
    fn quartiles_lie_between_neighbours() {
        let spread = Spread::of(vec![4.0, 1.0, 2.0, 3.0]).unwrap();
        assert_eq!([spread.least, spread.lower, spread.median, spread.upper], [1.0, 1.75, 2.5, 3.25]);
        assert_eq!(Spread::of(vec![]), None);
    }
}
