//! Refusing work that would not fit into memory, before it is begun.

use crate::failure::{Bytes, Failure};
use std::fs;

/// Refuses what needs more bytes than the machine has left. Where that is not known, anything goes.
pub fn check(name: &str, what: impl Into<String>, needed: u64) -> Result<(), Failure> {
    match available() {
        Some(available) if needed > available => Err(Failure::Memory {
            name: name.to_owned(),
            what: what.into(),
            needed: Bytes(needed),
            available: Bytes(available),
        }),
        _ => Ok(()),
    }
}

/// What Linux says can be had without swapping.
fn available() -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes.saturating_mul(1024))
}
