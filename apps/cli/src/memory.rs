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

/// What Linux says can be had without swapping, within the limit of the control group that the program runs in.
pub fn available() -> Option<u64> {
    let free = free_in_machine(&fs::read_to_string("/proc/meminfo").ok()?)?;
    Some(free_in_group().map_or(free, |group| free.min(group)))
}

fn free_in_machine(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes.saturating_mul(1024))
}

fn free_in_group() -> Option<u64> {
    let read = |name: &str| fs::read_to_string(format!("/sys/fs/cgroup/{name}")).ok()?.trim().parse::<u64>().ok();
    let current = read("memory.current")?;
    Some(read("memory.max")?.saturating_sub(current))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_memory_is_read_in_bytes() {
        assert_eq!(free_in_machine("MemTotal: 9 kB\nMemAvailable:     2048 kB\n"), Some(2 << 20));
        assert_eq!(free_in_machine("MemTotal: 9 kB\n"), None);
    }

    #[test]
    fn only_the_impossible_is_refused() {
        assert!(check("a.obj", "nothing", 0).is_ok());
        if available().is_some() {
            let error = check("a.obj", "level 20", u64::MAX).unwrap_err().to_string();
            assert!(error.starts_with("a.obj: level 20 needs about 16.0 EiB, but"), "{error}");
        }
    }
}
