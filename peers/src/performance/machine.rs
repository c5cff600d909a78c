//! What the figures were taken on: processor, memory, compilers, versions and options. No dates.

use super::rivals;
use crate::opensubdiv;
use std::fs;
use std::path::Path;

/// Names and what they are.
pub fn description() -> Vec<(&'static str, String)> {
    let cpu = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let of_cpu = |key: &str| {
        let line = cpu.lines().find(|line| line.starts_with(key))?;
        Some(line.split_once(':')?.1.trim().to_string())
    };
    let flags = of_cpu("flags").unwrap_or_default();
    let widths = ["sse4_2", "avx2", "avx512f"].into_iter().filter(|f| flags.split(' ').any(|g| g == *f));
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let memory = memory_bytes().map_or_else(String::new, |b| format!("{} GiB", b >> 30));
    let cache = fs::read_to_string("/sys/devices/system/cpu/cpu0/cache/index3/size").unwrap_or_default();
    let pages = fs::read_to_string("/sys/kernel/mm/transparent_hugepage/enabled").unwrap_or_default();
    let chosen = pages.split_once('[').and_then(|(_, rest)| rest.split_once(']')).map_or("not known", |(c, _)| c);
    let absent = || "absent".to_string();
    vec![
        ("processor", of_cpu("model name").unwrap_or_else(|| "not known".to_string())),
        ("instructions", widths.collect::<Vec<_>>().join(", ")),
        ("threads", cores.to_string()),
        ("memory", memory),
        ("last-level cache", cache.trim().to_string()),
        ("huge pages", chosen.to_string()),
        ("Rust", env!("PEERS_RUSTC").to_string()),
        ("C++", env!("PEERS_CXX").to_string()),
        ("C++ options", env!("PEERS_CXX_FLAGS").to_string()),
        ("OpenSubdiv", opensubdiv::version()),
        ("Embree", rivals::embree::version().unwrap_or_else(absent)),
        ("subdiv-kernels", locked("subdiv-kernels").unwrap_or_else(absent)),
        ("half-edge", std::env::var(rivals::HALF_EDGE_PROGRAM).map_or_else(|_| absent(), |_| "a program".to_string())),
    ]
}

/// Bytes of memory of this machine.
pub fn memory_bytes() -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    Some(1024 * line.split_whitespace().next()?.parse::<u64>().ok()?)
}

/// The version of a package in the lock file.
fn locked(name: &str) -> Option<String> {
    let lock = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.lock")).ok()?;
    let start = lock.find(&format!("name = \"{name}\"\n"))?;
    let line = lock[start..].lines().nth(1)?;
    Some(line.split('"').nth(1)?.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_of_what_is_linked_are_known() {
        let description = description();
        let of = |name: &str| description.iter().find(|(n, _)| *n == name).unwrap().1.clone();
        assert!(of("OpenSubdiv").starts_with("3."));
        assert!(of("subdiv-kernels").starts_with("0.1"));
        assert!(of("Rust").contains("rustc") && of("C++ options").contains("-O3"));
    }
}
