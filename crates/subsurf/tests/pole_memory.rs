//! What vertices of many faces ask for in memory: no worse than the square of their valence, as their rings do.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use subsurf::{ControlMesh, Crease, Face, Location, PatchTable, Rates, Scheme, Tags, TessellateOptions};

/// The system's allocator, counting bytes in use.
struct Counting;

static BYTES: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let bytes = BYTES.fetch_add(layout.size(), Relaxed) + layout.size();
        MOST.fetch_max(bytes, Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        BYTES.fetch_sub(layout.size(), Relaxed);
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Held by the test that counts.
static COUNTS: Mutex<()> = Mutex::new(());

/// Quads round vertex 0, in two rings, from one boundary edge to the other or all the way round.
fn fan(n: u32, is_closed: bool, creases: Vec<Crease>) -> ControlMesh {
    let columns = if is_closed { 2 * n } else { 2 * n + 1 };
    let at = |ring: u32, i: u32| 1 + ring * columns + i % columns;
    let mut faces: Vec<[u32; 4]> = (0..n).map(|i| [0, at(0, 2 * i), at(0, 2 * i + 1), at(0, 2 * i + 2)]).collect();
    faces.extend((0..2 * n).map(|i| [at(0, i), at(1, i), at(1, i + 1), at(0, i + 1)]));
    ControlMesh::new(&faces, Tags { creases, ..Tags::default() }).unwrap()
}

/// The most bytes in use beyond those before, while `f` runs.
fn most_bytes<R>(f: impl FnOnce() -> R) -> (R, f64) {
    let before = BYTES.load(Relaxed);
    MOST.store(before, Relaxed);
    let result = f();
    (result, (MOST.load(Relaxed) - before) as f64)
}

/// Bytes for a table, and for a tessellation of it with normals.
fn bytes(mesh: &ControlMesh) -> [f64; 2] {
    let points: Vec<[f32; 3]> = (0..mesh.vertex_count()).map(|i| [i % 7, i % 11, i % 13].map(|x| x as f32)).collect();
    let (table, built) = most_bytes(|| PatchTable::new(mesh, Scheme::CatmullClark).unwrap());
    let options = TessellateOptions { rates: Rates::Uniform(8), ..TessellateOptions::default() };
    let (_, tessellated) = most_bytes(|| table.surface(&points).tessellate(&options).unwrap());
    [built, tessellated]
}

#[test]
fn poles_of_all_kinds_ask_for_no_more_than_the_square_of_their_valence() {
    let _counts = COUNTS.lock();
    // Every thread has a face at work, whatever the machine.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    pool.install(every_kind);
}

fn every_kind() {
    type Kind = (&'static str, fn(u32) -> ControlMesh, f64);
    let kinds: [Kind; 4] = [
        ("smooth", |n| fan(n, true, Vec::new()), SMOOTH),
        ("boundary", |n| fan(n, false, Vec::new()), SECTOR),
        ("dart", |n| fan(n, true, vec![Crease::new(0, 1, 10.0)]), SECTOR),
        ("crease", |n| fan(n, true, vec![Crease::new(0, 1, 10.0), Crease::new(0, 1 + n, 10.0)]), SECTOR),
    ];
    for (what, mesh, most) in kinds {
        // The first time threads start.
        bytes(&mesh(8));
        for n in [150, 300] {
            let found = bytes(&mesh(n));
            println!("{what} {n}: {:?} bytes per square of the valence", found.map(|b| b / f64::from(n * n)));
            for (found, most) in found.iter().zip([most, TESSELLATED]) {
                assert!(*found < most * f64::from(n * n), "{what} {n}: {found} bytes");
            }
        }
    }
}

#[test]
fn a_location_at_a_pole_leaves_nothing_behind() {
    let _counts = COUNTS.lock();
    let mesh = fan(300, true, Vec::new());
    let points: Vec<[f64; 3]> = (0..mesh.vertex_count()).map(|i| [i % 7, i % 11, i % 13].map(|x| x as f64)).collect();
    let table = PatchTable::new(&mesh, Scheme::CatmullClark).unwrap();
    let at = |face: u32| Location { face: Face(face), subface: 0, u: 1e-3, v: 2e-4 };
    let before = table.surface(&points).eval(at(0)).map(|_| BYTES.load(Relaxed));
    let after = table.surface(&points).eval(at(7)).map(|_| BYTES.load(Relaxed));
    assert_eq!(before, after);
}

/// Bytes per square of the valence that a table may ask for, where all faces share a plan and where each has its own; and a
/// tessellation.
const SMOOTH: f64 = 60.0;
const SECTOR: f64 = 400.0;
const TESSELLATED: f64 = 200.0;
