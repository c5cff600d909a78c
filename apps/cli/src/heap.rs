//! The program's allocator: the system's, and how much heap a piece of work needs at most.
//!
//! Counting is off but while [`heap_of`] runs, so that other work pays one load of a flag per allocation. It is our own
//! rather than a crate's for that reason, and this is the one module of the program with `unsafe`: the trait of allocators
//! demands it, and every call goes to the system's allocator as it came.

#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicBool, AtomicIsize, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

/// The system's allocator with a tally.
struct Tally;

#[global_allocator]
static HEAP: Tally = Tally;

static COUNTS: AtomicBool = AtomicBool::new(false);
/// Bytes allocated less bytes freed since counting began; below zero where older memory is freed.
static LIVE: AtomicIsize = AtomicIsize::new(0);
static PEAK: AtomicIsize = AtomicIsize::new(0);

/// Notes that memory of `old` bytes has now `new`.
fn note(old: usize, new: usize) {
    if COUNTS.load(Relaxed) {
        let change = new as isize - old as isize;
        let live = LIVE.fetch_add(change, Relaxed) + change;
        if change > 0 {
            PEAK.fetch_max(live, Relaxed);
        }
    }
}

// SAFETY: every call is handed to the system's allocator with the arguments that it came with.
unsafe impl GlobalAlloc for Tally {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(0, layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        note(0, layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        note(layout.size(), 0);
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note(layout.size(), size);
        unsafe { System.realloc(memory, layout, size) }
    }
}

/// Heap in bytes beyond what was in use before some work.
#[derive(Clone, Copy, Debug)]
pub struct Heap {
    /// The most at once.
    pub peak: u64,
    /// What the result keeps.
    pub kept: u64,
}

/// What `work` gives, and what heap it needs. Counts what all threads do; a second call waits for the first.
pub fn heap_of<R>(work: impl FnOnce() -> R) -> (R, Heap) {
    static ONE: Mutex<()> = Mutex::new(());
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    LIVE.store(0, Relaxed);
    PEAK.store(0, Relaxed);
    COUNTS.store(true, Relaxed);
    let result = work();
    COUNTS.store(false, Relaxed);
    let [peak, kept] = [&PEAK, &LIVE].map(|bytes| bytes.load(Relaxed).max(0) as u64);
    (result, Heap { peak, kept })
}
