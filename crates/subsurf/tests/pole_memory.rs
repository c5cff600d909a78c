//! What vertices of many faces ask for in memory: no worse than the square of their valence, as their rings do.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use subsurf::{
    ControlMesh, Crease, EditError, Face, Location, MeshError, PatchTable, Pole, Rates, Scheme, TableEditor, Tags,
    TessellateOptions,
};

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

/// Triangles round vertex 0, in one ring.
fn umbrella(n: u32, is_closed: bool, creases: Vec<Crease>) -> ControlMesh {
    let columns = if is_closed { n } else { n + 1 };
    let at = |ring: u32, i: u32| 1 + ring * columns + i % columns;
    let mut faces: Vec<[u32; 3]> = (0..n).map(|i| [0, at(0, i), at(0, i + 1)]).collect();
    for i in 0..n {
        faces.extend([[at(0, i), at(1, i), at(1, i + 1)], [at(0, i), at(1, i + 1), at(0, i + 1)]]);
    }
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

/// A name, a scheme, and the mesh with a pole of so many faces.
type SomeKind = (&'static str, Scheme, fn(u32) -> ControlMesh);

/// Poles of every kind.
fn all_kinds() -> Vec<SomeKind> {
    let (quads, triangles) = (Scheme::CatmullClark, Scheme::Loop);
    vec![
        ("smooth", quads, |n| fan(n, true, Vec::new())),
        ("boundary", quads, |n| fan(n, false, Vec::new())),
        ("dart", quads, |n| fan(n, true, vec![Crease::new(0, 1, 10.0)])),
        ("semi-sharp dart", quads, |n| fan(n, true, vec![Crease::new(0, 1, 2.5)])),
        ("all spokes sharp by other values", quads, |n| {
            let value = |j: u32| 0.5 + 3.0 * (f64::from(j) * 0.618).fract();
            fan(n, true, (0..n).map(|j| Crease::new(0, 1 + 2 * j, value(j))).collect())
        }),
        ("boundary of triangles in quads", quads, |n| umbrella(n, false, Vec::new())),
        ("smooth triangles", triangles, |n| umbrella(n, true, Vec::new())),
        ("boundary of triangles", triangles, |n| umbrella(n, false, Vec::new())),
        ("dart of triangles", triangles, |n| umbrella(n, true, vec![Crease::new(0, 1, 10.0)])),
        ("semi-sharp dart of triangles", triangles, |n| umbrella(n, true, vec![Crease::new(0, 1, 2.5)])),
        ("face of corners that look different", quads, |n| {
            // A crease leads away from one corner.
            let mut faces: Vec<Vec<u32>> = (0..n).map(|i| vec![i, n + i, n + (i + 1) % n, (i + 1) % n]).collect();
            faces.push((0..n).collect());
            ControlMesh::new(&faces, Tags { creases: vec![Crease::new(0, n, 10.0)], ..Tags::default() }).unwrap()
        }),
    ]
}

#[test]
fn estimates_are_above_what_tables_take() {
    let _counts = COUNTS.lock();
    for (what, scheme, mesh) in all_kinds() {
        // Faces have plans of n² numbers.
        let power = if what.starts_with("face") { 3 } else { 2 };
        let refused = 60_000 / if power == 3 { 20 } else { 1 };
        let large = mesh(refused);
        // Refused before anything large is made.
        let (error, asked) = most_bytes(|| PatchTable::new(&large, scheme).map(|_| ()).unwrap_err());
        let MeshError::PoleTooLarge { bytes, limit, pole } = error else { panic!("{what}: {error}") };
        assert!(bytes > limit && asked < 1500.0 * f64::from(refused), "{what} {pole}: {asked} bytes asked for");
        let estimated = bytes as f64 / f64::from(refused).powi(power);
        let n = if power == 3 { 120 } else { 300 };
        let small = mesh(n);
        // The first time threads start.
        PatchTable::new(&small, scheme).unwrap();
        let (table, taken) = most_bytes(|| PatchTable::new(&small, scheme).unwrap());
        let size = table.size();
        // What grows with a lower power: the mesh's other faces, and rings and lists beside the points over all corners.
        let rest = if power == 3 { 500.0 * f64::from(n * n) } else { 6500.0 * f64::from(n) };
        let found = (taken - rest) / f64::from(n).powi(power);
        println!(
            "{what}: {found} bytes per power {power} of {n}, {} at the end; estimated {estimated}",
            size.plan_bytes
        );
        assert!(found < estimated, "{what}: {found} {estimated}");
    }
}

#[test]
fn an_edit_that_would_take_too_much_is_refused_and_changes_nothing() {
    let _counts = COUNTS.lock();
    // All faces of a smooth vertex share a plan; with a crease each has its own.
    let n = 4700;
    let mut editor = TableEditor::new(&umbrella(n, true, Vec::new()), Scheme::Loop).unwrap();
    let before = editor.table().size();
    let refused = |result: Result<_, EditError>, faces: usize| {
        let Err(EditError::Mesh(MeshError::PoleTooLarge { pole, .. })) = result else { panic!("not refused") };
        assert_eq!(pole, Pole::Vertex { vertex: 0, faces });
    };
    let (result, asked) = most_bytes(|| editor.set_creases(&[(0, 5), (0, 5)], 10.0).map(|_| ()));
    refused(result, 4700);
    assert!(asked < 3000.0 * f64::from(n), "{asked} bytes");
    refused(editor.replace_faces(&[3], &[]).map(|_| ()), 4699);
    assert_eq!(editor.table().size(), before);
    assert!(editor.mesh().unwrap().tags().creases.is_empty());
    // Elsewhere edits go on.
    editor.set_creases(&[(1 + n, 2 + n)], 10.0).unwrap();
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
const SECTOR: f64 = 200.0;
const TESSELLATED: f64 = 200.0;
