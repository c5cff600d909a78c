//! Clocks: processor time of the whole process beside wall-clock time, because machines are shared; and peak memory.

#![allow(unsafe_code)]

use std::fs;
use std::time::Instant;

unsafe extern "C" {
    safe fn peer_processor_ns() -> u64;
    safe fn peer_release_free_memory();
    safe fn peer_allocated_bytes() -> u64;
}

/// What some work took, in nanoseconds.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Spent {
    /// By all threads of the process, the kernel's work for it included.
    pub processor: f64,
    pub wall: f64,
}

impl std::ops::AddAssign for Spent {
    fn add_assign(&mut self, other: Self) {
        self.processor += other.processor;
        self.wall += other.wall;
    }
}

/// Runs `work` under both clocks. What it returns is dropped by the caller, off the clock.
pub fn spent<R>(work: impl FnOnce() -> R) -> (Spent, R) {
    let (start, processor) = (Instant::now(), peer_processor_ns());
    let result = work();
    let processor = (peer_processor_ns() - processor) as f64;
    (Spent { processor, wall: start.elapsed().as_nanos() as f64 }, result)
}

/// Hands free memory back to the system, so that whoever allocates next pays for fresh pages.
pub fn release_free_memory() {
    peer_release_free_memory();
}

/// Runs `work`; by how many bytes resident memory rose at most meanwhile, and how many more were allocated at the end.
/// None where the system does not say.
pub fn memory_of<R>(work: impl FnOnce() -> R) -> (Option<Memory>, R) {
    release_free_memory();
    let before = peer_allocated_bytes();
    let resident = status("VmRSS:");
    // Sets the mark of highest resident memory back to what is resident now.
    let reset = fs::write("/proc/self/clear_refs", "5").is_ok();
    let result = work();
    let kept = peer_allocated_bytes().saturating_sub(before);
    let peak = status("VmHWM:").zip(resident).filter(|_| reset).map(|(peak, before)| peak.saturating_sub(before));
    (peak.map(|peak| Memory { peak, kept }), result)
}

/// Bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Memory {
    pub peak: u64,
    pub kept: u64,
}

fn status(key: &str) -> Option<u64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(1024 * line.split_whitespace().next()?.parse::<u64>().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_clock_runs_while_asleep_the_other_while_at_work() {
        // Tests beside this one are at work too: processor time has no upper bound.
        let (asleep, ()) = spent(|| std::thread::sleep(std::time::Duration::from_millis(30)));
        assert!(asleep.wall >= 30e6, "{asleep:?}");
        let (at_work, sum) = spent(|| (0..20_000_000u64).fold(0, |sum, i| std::hint::black_box(sum ^ i)));
        assert!(at_work.processor >= 1e6, "{at_work:?} {sum}");
    }

    #[test]
    fn memory_that_is_touched_and_freed_counts_in_the_peak_alone() {
        let (memory, sum) = memory_of(|| vec![1u8; 64 << 20].iter().map(|&x| u64::from(x)).sum::<u64>());
        let memory = memory.expect("Linux says");
        assert_eq!(sum, 64 << 20);
        // Other tests allocate meanwhile.
        assert!(memory.peak >= 60 << 20 && memory.kept < 32 << 20, "{memory:?}");
    }
}
