//! What an animation frame allocates: next to nothing, whatever the size of the mesh.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use subsurf::{PatchTable, Rates, Scheme, TessellateOptions, shapes};

/// The system's allocator, counting bytes asked for.
struct Counting;

static BYTES: AtomicUsize = AtomicUsize::new(0);

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        BYTES.fetch_add(layout.size(), Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_frame_allocates_a_fiftieth_of_what_it_writes_at_most() {
    for n in [16, 48] {
        let grid = shapes::grid(n, n);
        let control: Vec<[f32; 3]> = grid.positions.iter().map(|p| p.map(|x| x as f32)).collect();
        let table = PatchTable::new(&grid.mesh, Scheme::CatmullClark).unwrap();
        let options = TessellateOptions { rates: Rates::Uniform(8), ..TessellateOptions::default() };
        let tessellator = table.tessellator(&control, &options).unwrap();
        let mut points = vec![[0.0; 3]; tessellator.point_count()];
        let mut normals = vec![[0.0; 3]; tessellator.normal_count()];
        // The thread pool starts with the first frame.
        tessellator.evaluate_into(&control, &mut points, &mut normals);
        let before = BYTES.load(Relaxed);
        tessellator.evaluate_into(&control, &mut points, &mut normals);
        let (asked, written) = (BYTES.load(Relaxed) - before, 12 * (points.len() + normals.len()));
        // A chunk of 128 faces is a task, which has 3 KiB for its blocks and writes 200 KiB.
        assert!(asked <= written / 50 + (16 << 10), "{asked} bytes for {written}");
    }
}
