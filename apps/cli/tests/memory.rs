//! Heap of patch tables, counted by the program's own allocator. One test alone: what others allocate would be counted too.

#[path = "../src/heap.rs"]
mod heap;
mod tables;

use subsurf::TableSize;
use tables::{asset, table, torus};

fn bytes(size: &TableSize) -> usize {
    size.patch_bytes + size.plan_bytes + size.topology_bytes
}

/// The tally itself: its peak is what was held at once.
fn check_tally() {
    const MEBIBYTE: usize = 1 << 20;
    let (_, heap) = heap::heap_of(|| {
        for _ in 0..4 {
            std::hint::black_box(vec![1u8; 8 * MEBIBYTE]);
        }
        let both = [vec![1u8; 8 * MEBIBYTE], vec![0u8; 16 * MEBIBYTE]];
        std::hint::black_box(both).len()
    });
    let expected = 24 * MEBIBYTE as u64;
    assert!((expected..expected + MEBIBYTE as u64).contains(&heap.peak), "{heap:?}");
    assert!(heap.kept < MEBIBYTE as u64, "{heap:?}");
}

#[test]
fn memory_is_what_is_told_and_no_more_than_twice_that_while_building() {
    check_tally();
    let quads = torus(200);
    let meshes = [("torus", &quads), ("teapot", &asset("fancy_teapot.obj"))];
    for (name, mesh) in meshes {
        // Threads and what they keep are there after the first time.
        drop(table(mesh));
        let (own, heap) = heap::heap_of(|| table(mesh));
        let told = bytes(&own.size()) as u64;
        // Maps in plans are counted by their entries.
        assert!(told.abs_diff(heap.kept) <= told / 50, "{name}: {told} bytes told, {} kept", heap.kept);
        assert!(heap.peak <= 2 * heap.kept, "{name}: {} bytes at the peak, {} kept", heap.peak, heap.kept);
    }
    let size = table(&quads).size();
    assert!(bytes(&size) <= 175 * size.patches, "{size:?}");
}
