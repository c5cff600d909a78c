//! The document.

use super::record::Record;
use std::path::Path;

/// One contest in a few lines.
pub fn brief(record: &Record) -> String {
    let mut text =
        format!("{} · {} · {} ({} × {})\n", record.section, record.mesh, record.what, record.count, record.unit);
    for e in &record.entries {
        let told = match (&e.failed, &e.processor, e.value) {
            (Some(why), ..) => why.clone(),
            (_, Some(p), _) => format!("{:10.2} ns [{:.2} … {:.2}]", p.median, p.lower, p.upper),
            (_, _, Some(value)) => format!("{value:10.1}"),
            _ => String::new(),
        };
        let ratio = e.ratio.map_or_else(String::new, |r| format!("{:8.2} × ours", r.median));
        text += &format!("  {:26} {told:40} {ratio} {}\n", e.name, e.note);
    }
    text
}

pub fn write(_: &Path, _: &[Record], _: &[String]) -> Result<(), String> {
    Ok(())
}
