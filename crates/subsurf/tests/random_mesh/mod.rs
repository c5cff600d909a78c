//! Random meshes as recipes: a base, operations that make polygons, triangles and valences of all kinds, and tags. A recipe
//! shrinks to its shortest failing form, and the generator's seed is fixed, so every run tests the same meshes.
#![allow(dead_code)]

mod base;
mod change;

pub use base::{Base, base};
pub use change::{Change, edges_of};

use change::{a_change, change};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestError, TestRunner};
use std::cell::Cell;
use std::collections::BTreeSet;
use std::panic::AssertUnwindSafe;
use std::sync::Once;
use subsurf::{Boundary, ControlMesh, Corner, Crease, Creasing, Face, Location, Rules, Tags, Triangles};

/// A parameter: where the difficulties are.
#[derive(Clone, Copy, Debug)]
pub enum Parameter {
    Zero,
    One,
    Half,
    Inside(u16),
    /// Near 0, at so many levels of depth.
    NearZero(u16, u8),
    NearOne(u16, u8),
    /// Just below or above one half.
    NearHalf(bool, u8),
}

impl Parameter {
    pub fn value(self) -> f64 {
        let part = |x: u16| 0.5 + f64::from(x) / 131_072.0;
        match self {
            Self::Zero => 0.0,
            Self::One => 1.0,
            Self::Half => 0.5,
            Self::Inside(x) => f64::from(x) / 65536.0,
            Self::NearZero(x, depth) => part(x) * 2f64.powi(-i32::from(depth)),
            Self::NearOne(x, depth) => 1.0 - part(x) * 2f64.powi(-i32::from(depth)),
            Self::NearHalf(above, depth) => {
                let d = 2f64.powi(-i32::from(depth));
                if above { 0.5 + d } else { 0.5 - d }
            }
        }
    }
}

/// Sharpness values at which the rules change, and some between.
pub const SHARPNESS: [f64; 14] = [10.0, 1.0, 2.0, 0.5, 1.7, 0.25, 2.5, 0.9, 3.0, 1.2, 4.75, 12.0, 9.0, 9.99];

/// A line of sharp edges.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    pub edge: u16,
    pub length: u8,
    pub sharpness: u8,
    /// Sharpness of the line's second half.
    pub then: Option<u8>,
}

#[derive(Clone, Debug)]
pub struct Recipe {
    pub base: Base,
    pub changes: Vec<Change>,
    pub lines: Vec<Line>,
    pub corners: Vec<(u16, u8)>,
    pub holes: Vec<u16>,
    pub boundary: Boundary,
    pub chaikin: bool,
    pub smooth_triangles: bool,
    /// Whether all faces are cut into triangles in the end.
    pub triangles: bool,
    pub seed: u16,
    /// Faces, sub-faces and parameters.
    pub places: Vec<(u16, u8, Parameter, Parameter)>,
}

pub struct Mesh {
    pub mesh: ControlMesh,
    pub positions: Vec<[f64; 3]>,
}

/// A number in `[-1, 1)` from a seed.
fn noise(seed: u64) -> f64 {
    let mut x = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(0x1234_5678_9abc_def1);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    // 24 bits: a number of single precision, so that f32 and f64 start from the same points.
    ((x ^ (x >> 31)) >> 40) as f64 / f64::from(1 << 23) - 1.0
}

pub fn random_points(count: usize, seed: u64) -> Vec<[f64; 3]> {
    (0..count as u64).map(|i| [0, 1, 2].map(|k| noise(seed << 32 | i << 2 | k))).collect()
}

fn pick<T>(list: &[T], i: u16) -> Option<&T> {
    (!list.is_empty()).then(|| &list[usize::from(i) % list.len()])
}

/// Every face as triangles round one of its corners. Of triangles with the same vertices the first stays: two would be
/// joined by two edges one level down.
fn in_triangles(faces: &[Vec<u32>], seed: u64) -> Vec<Vec<u32>> {
    let mut known = BTreeSet::new();
    let mut triangles = Vec::new();
    for (f, face) in faces.iter().enumerate() {
        let n = face.len();
        // Half of the meshes are cut from first corners: grids then have valence 6.
        let from =
            if seed.is_multiple_of(2) { 0 } else { ((noise(seed << 32 | f as u64) + 1.0) * 0.5 * n as f64) as usize };
        for i in 1..n - 1 {
            let triangle = [0, i, i + 1].map(|k| face[(from + k) % n]);
            let mut sorted = triangle;
            sorted.sort_unstable();
            if known.insert(sorted) {
                triangles.push(triangle.to_vec());
            }
        }
    }
    triangles
}

impl Recipe {
    pub fn faces(&self) -> Vec<Vec<u32>> {
        let mut faces = self.base.faces();
        // Sheets last: other changes need a manifold.
        let sheet = |c: &&Change| matches!(c, Change::Sheet(_));
        for &what in self.changes.iter().filter(|c| !sheet(c)).chain(self.changes.iter().filter(sheet)) {
            if let Some(changed) = change(&faces, what) {
                faces = changed;
            }
        }
        if self.triangles { in_triangles(&faces, u64::from(self.seed)) } else { faces }
    }

    pub fn tags(&self, faces: &[Vec<u32>], vertices: usize) -> Tags {
        let edges = edges_of(faces);
        let list: Vec<(u32, u32)> = edges.keys().copied().collect();
        let mut creases = Vec::new();
        for line in &self.lines {
            let Some(&start) = pick(&list, line.edge) else { continue };
            let (mut edge, mut tip) = (start, start.1);
            for step in 0..=line.length {
                let late = step > line.length / 2;
                let s = line.then.filter(|_| late).unwrap_or(line.sharpness);
                creases.push(Crease::new(edge.0, edge.1, SHARPNESS[usize::from(s) % SHARPNESS.len()]));
                // Straight on: an edge at the tip that shares no face with this one.
                let apart = |other: &&(u32, u32)| {
                    (other.0 == tip || other.1 == tip) && !edges[other].iter().any(|f| edges[&edge].contains(f))
                };
                let Some(&next) = list.iter().find(apart) else { break };
                tip = if next.0 == tip { next.1 } else { next.0 };
                edge = next;
            }
        }
        let value = |s: u8| SHARPNESS[usize::from(s) % SHARPNESS.len()];
        let corner = |&(v, s): &(u16, u8)| Corner::new(u32::from(v) % vertices as u32, value(s));
        Tags {
            creases,
            corners: self.corners.iter().map(corner).collect(),
            holes: self.holes.iter().map(|&f| u32::from(f) % faces.len() as u32).collect(),
            rules: Rules {
                boundary: self.boundary,
                creasing: if self.chaikin { Creasing::Chaikin } else { Creasing::Uniform },
                triangles: if self.smooth_triangles { Triangles::Smooth } else { Triangles::CatmullClark },
                ..Rules::default()
            },
        }
    }

    pub fn mesh(&self) -> Mesh {
        let faces = self.faces();
        let vertices = faces.iter().flatten().max().map_or(0, |&v| v as usize + 1);
        let mesh = ControlMesh::new(&faces, self.tags(&faces, vertices)).expect("a valid mesh");
        Mesh { mesh, positions: random_points(vertices, u64::from(self.seed)) }
    }

    /// The places as locations.
    pub fn locations(&self, mesh: &ControlMesh) -> Vec<Location> {
        let place = |&(face, sub, u, v): &(u16, u8, Parameter, Parameter)| {
            let face = usize::from(face) % mesh.face_count();
            if self.triangles {
                // The corner of the square beyond the triangle's third side, turned onto the triangle.
                let (u, v) = (u.value(), v.value());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                return Location { face: Face::new(face), subface: 0, u, v };
            }
            let sides = mesh.face_vertices(face).len();
            let subface = if sides == 4 { 0 } else { u32::from(sub) % sides as u32 };
            Location { face: Face::new(face), subface, u: u.value(), v: v.value() }
        };
        self.places.iter().map(place).collect()
    }
}

fn parameter() -> impl Strategy<Value = Parameter> {
    let x = any::<u16>;
    prop_oneof![
        1 => Just(Parameter::Zero),
        1 => Just(Parameter::One),
        1 => Just(Parameter::Half),
        4 => x().prop_map(Parameter::Inside),
        2 => (x(), 1..41u8).prop_map(|(x, d)| Parameter::NearZero(x, d)),
        2 => (x(), 1..41u8).prop_map(|(x, d)| Parameter::NearOne(x, d)),
        1 => (any::<bool>(), 2..41u8).prop_map(|(a, d)| Parameter::NearHalf(a, d)),
    ]
}

/// Half of the places have both parameters at the same depth, so that they lie deep at a vertex.
pub fn place() -> impl Strategy<Value = (u16, u8, Parameter, Parameter)> {
    let corner = (any::<(u16, u16)>(), any::<(bool, bool)>(), 1..41u8).prop_map(|((x, y), (p, q), d)| {
        let near = |one: bool, x| if one { Parameter::NearOne(x, d) } else { Parameter::NearZero(x, d) };
        (near(p, x), near(q, y))
    });
    (any::<u16>(), any::<u8>(), prop_oneof![(parameter(), parameter()), corner]).prop_map(|(f, s, (u, v))| (f, s, u, v))
}

fn line() -> impl Strategy<Value = Line> {
    (any::<u16>(), 0..6u8, any::<u8>(), proptest::option::weighted(0.3, any::<u8>()))
        .prop_map(|(edge, length, sharpness, then)| Line { edge, length, sharpness, then })
}

pub fn recipe() -> impl Strategy<Value = Recipe> {
    use proptest::collection::vec;
    let boundary = prop_oneof![
        4 => Just(Boundary::EdgeAndCorner),
        3 => Just(Boundary::EdgeOnly),
        1 => Just(Boundary::None),
    ];
    let shape = (base(), vec(a_change(), 0..7));
    let tags = (vec(line(), 0..5), vec((any::<u16>(), any::<u8>()), 0..3), vec(any::<u16>(), 0..2));
    let rules = (boundary, proptest::bool::weighted(0.3), proptest::bool::weighted(0.2));
    (shape, tags, rules, any::<u16>(), vec(place(), 4)).prop_map(
        |((base, changes), (lines, corners, holes), (boundary, chaikin, smooth_triangles), seed, places)| Recipe {
            base,
            changes,
            lines,
            corners,
            holes,
            boundary,
            chaikin,
            smooth_triangles,
            triangles: false,
            seed,
            places,
        },
    )
}

/// The same in triangles, for Loop subdivision.
pub fn triangle_recipe() -> impl Strategy<Value = Recipe> {
    recipe().prop_map(|recipe| Recipe { triangles: true, ..recipe })
}

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Turns a panic into an error, without its message on the terminal: shrinking a recipe panics many times over.
fn caught(law: impl FnOnce() -> Result<(), String>) -> Result<(), String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            // Threads of the pool, which have no names, hand their panics on.
            if !QUIET.get() && std::thread::current().name().is_some() {
                usual(info);
            }
        }));
    });
    QUIET.set(true);
    let result = std::panic::catch_unwind(AssertUnwindSafe(law));
    QUIET.set(false);
    result.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
        Err(format!("panicked: {}", text.unwrap_or_default()))
    })
}

/// Runs `law` on `cases` values, the same ones in every run; panics with the shortest value that breaks it.
pub fn for_all<S: Strategy>(strategy: S, cases: u32, seed: u64, law: impl Fn(&S::Value) -> Result<(), String>)
where
    S::Value: std::fmt::Debug,
{
    let config = Config { cases, failure_persistence: None, rng_seed: RngSeed::Fixed(seed), ..Config::default() };
    let result = TestRunner::new(config).run(&strategy, |value| caught(|| law(&value)).map_err(TestCaseError::fail));
    match result {
        Ok(()) => {}
        Err(TestError::Fail(reason, value)) => panic!("{reason}\nshortest: {value:?}"),
        Err(other) => panic!("{other}"),
    }
}
