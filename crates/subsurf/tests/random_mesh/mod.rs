//! Random meshes as recipes: a base, operations that make polygons, triangles and valences of all kinds, and tags. A recipe
//! shrinks to its shortest failing form, and the generator's seed is fixed, so every run tests the same meshes.
#![allow(dead_code)]

use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestError, TestRunner};
use std::cell::Cell;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::panic::AssertUnwindSafe;
use std::sync::Once;
use subsurf::{Boundary, ControlMesh, Corner, Crease, Creasing, Face, Location, Rules, Tags, Triangles};

/// What a mesh starts from.
#[derive(Clone, Copy, Debug)]
pub enum Base {
    /// `w × h` quads with a boundary.
    Grid(u32, u32),
    /// `w × h` quads, closed in the first direction.
    Tube(u32, u32),
    /// `w × h` quads, closed in both directions.
    Torus(u32, u32),
    /// Quads round one interior vertex, so many rings.
    Fan(u32, u32),
    /// Quads round one boundary vertex, so many rings.
    Sector(u32, u32),
    /// Triangles round one vertex.
    Umbrella(u32),
    /// Triangles over an n-gon.
    Cone(u32),
    /// Two n-gons back to back.
    Pillow(u32),
    /// The cube, every face `n × n`.
    Cube(u32),
    /// Four triangles.
    Tetrahedron,
    /// So many grids of `w × h` quads with one column of vertices in common.
    Book(u32, u32, u32),
}

/// A change of the mesh; one that would make it no manifold is left out.
#[derive(Clone, Copy, Debug)]
pub enum Change {
    /// Takes an edge out between two faces.
    Merge(u16),
    /// Cuts a face in two.
    Cut(u16, u8),
    /// Draws an edge together.
    Collapse(u16),
    /// Takes a face out.
    Delete(u16),
    /// Puts a vertex into a face.
    Poke(u16),
    /// Puts a vertex into an edge, so that its faces gain a corner.
    Bisect(u16),
    /// A second sheet along an edge: the edge then has three faces.
    Sheet(u16),
}

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

impl Base {
    pub fn faces(self) -> Vec<Vec<u32>> {
        match self {
            Self::Grid(w, h) => grid(w, h, w + 1, h + 1),
            Self::Tube(w, h) => grid(w, h, w, h + 1),
            Self::Torus(w, h) => grid(w, h, w, h),
            Self::Fan(n, rings) => fan(n, n, rings),
            Self::Sector(n, rings) => fan(n, n + 1, rings),
            Self::Umbrella(n) => (0..n).map(|i| vec![0, 1 + i, 1 + (i + 1) % n]).collect(),
            Self::Cone(n) => {
                let mut faces = Self::Umbrella(n).faces();
                faces.push((0..n).rev().map(|i| 1 + i).collect());
                faces
            }
            Self::Pillow(n) => vec![(0..n).collect(), (0..n).rev().collect()],
            Self::Cube(n) => cube(n),
            Self::Book(pages, w, h) => book(pages, w, h),
            Self::Tetrahedron => vec![vec![0, 1, 2], vec![0, 3, 1], vec![1, 3, 2], vec![2, 3, 0]],
        }
    }
}

fn grid(w: u32, h: u32, columns: u32, rows: u32) -> Vec<Vec<u32>> {
    let at = |x: u32, y: u32| y % rows * columns + x % columns;
    let quad = |i: u32| {
        let (x, y) = (i % w, i / w);
        vec![at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]
    };
    (0..w * h).map(quad).collect()
}

fn fan(sectors: u32, spokes: u32, rings: u32) -> Vec<Vec<u32>> {
    let at = |s: u32, x: u32, y: u32| match (x, y) {
        (0, 0) => 0,
        (x, 0) => 1 + s % spokes * rings + x - 1,
        (0, y) => 1 + (s + 1) % spokes * rings + y - 1,
        (x, y) => 1 + spokes * rings + s * rings * rings + (y - 1) * rings + x - 1,
    };
    let mut faces = Vec::new();
    for s in 0..sectors {
        for i in 0..rings * rings {
            let (x, y) = (i % rings, i / rings);
            faces.push(vec![at(s, x, y), at(s, x + 1, y), at(s, x + 1, y + 1), at(s, x, y + 1)]);
        }
    }
    faces
}

/// Every other page is turned round, so that neighbouring pages run on into each other.
fn book(pages: u32, w: u32, h: u32) -> Vec<Vec<u32>> {
    let at = |page: u32, x: u32, y: u32| if x == 0 { y } else { (h + 1) * (1 + page * w + x - 1) + y };
    let mut faces = Vec::new();
    for page in 0..pages {
        for i in 0..w * h {
            let (x, y) = (i % w, i / w);
            let mut quad = vec![at(page, x, y), at(page, x + 1, y), at(page, x + 1, y + 1), at(page, x, y + 1)];
            if page % 2 == 1 {
                quad.reverse();
            }
            faces.push(quad);
        }
    }
    faces
}

fn cube(n: u32) -> Vec<Vec<u32>> {
    let mut number: HashMap<[u32; 3], u32> = HashMap::new();
    let mut faces = Vec::new();
    for axis in 0..3 {
        for end in [0, n] {
            for i in 0..n * n {
                let (x, y) = (i % n, i / n);
                let mut corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
                if end == 0 {
                    corners.reverse();
                }
                let point = |[p, q]: [u32; 2]| {
                    let mut c = [0; 3];
                    (c[axis], c[(axis + 1) % 3], c[(axis + 2) % 3]) = (end, p, q);
                    c
                };
                let next = |c| {
                    let free = number.len() as u32;
                    *number.entry(point(c)).or_insert(free)
                };
                faces.push(corners.map(next).to_vec());
            }
        }
    }
    faces
}

pub type Edges = BTreeMap<(u32, u32), Vec<usize>>;

/// Faces of every edge.
pub fn edges_of(faces: &[Vec<u32>]) -> Edges {
    let mut edges = Edges::new();
    for (f, face) in faces.iter().enumerate() {
        for i in 0..face.len() {
            let (a, b) = (face[i], face[(i + 1) % face.len()]);
            edges.entry((a.min(b), a.max(b))).or_default().push(f);
        }
    }
    edges
}

/// True where faces visit no vertex twice, edges have one face or two in opposite directions, and vertices one fan.
pub fn is_manifold(faces: &[Vec<u32>]) -> bool {
    let mut runs: HashMap<(u32, u32), usize> = HashMap::new();
    for (f, face) in faces.iter().enumerate() {
        if face.len() < 3 || face.iter().collect::<HashSet<_>>().len() < face.len() {
            return false;
        }
        for i in 0..face.len() {
            if runs.insert((face[i], face[(i + 1) % face.len()]), f).is_some() {
                return false;
            }
        }
    }
    let mut at: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    faces.iter().enumerate().for_each(|(f, face)| face.iter().for_each(|&v| at.entry(v).or_default().push(f)));
    at.iter().all(|(&v, list)| {
        let mut known = HashSet::from([list[0]]);
        let mut todo = vec![list[0]];
        while let Some(f) = todo.pop() {
            let face = &faces[f];
            let i = face.iter().position(|&w| w == v).unwrap();
            let (next, before) = (face[(i + 1) % face.len()], face[(i + face.len() - 1) % face.len()]);
            for g in [runs.get(&(next, v)), runs.get(&(v, before))].into_iter().flatten() {
                if known.insert(*g) {
                    todo.push(*g);
                }
            }
        }
        known.len() == list.len()
    })
}

fn pick<T>(list: &[T], i: u16) -> Option<&T> {
    (!list.is_empty()).then(|| &list[usize::from(i) % list.len()])
}

fn change(faces: &[Vec<u32>], what: Change) -> Option<Vec<Vec<u32>>> {
    let edges: Vec<((u32, u32), Vec<usize>)> = edges_of(faces).into_iter().collect();
    let free = faces.iter().flatten().max().map_or(0, |v| v + 1);
    let mut out = faces.to_vec();
    // A face as a list that starts at vertex `v`.
    let from = |face: &[u32], v: u32| {
        let i = face.iter().position(|&w| w == v).unwrap();
        let mut list = face.to_vec();
        list.rotate_left(i);
        list
    };
    match what {
        Change::Merge(i) => {
            let &((a, b), ref both) = pick(&edges, i)?;
            let &[f, g] = &both[..] else { return None };
            // The face that runs from a to b, seen from b; then the other, seen from a.
            let forward = |f: &usize| from(&faces[*f], a)[1] == b;
            let (f, g) = if forward(&f) { (f, g) } else { (g, f) };
            let mut merged = from(&faces[f], b);
            let other = from(&faces[g], a);
            merged.extend_from_slice(&other[1..other.len() - 1]);
            if merged.len() > 12 {
                return None;
            }
            out[f] = merged;
            out.remove(g);
        }
        Change::Cut(i, corner) => {
            let f = usize::from(i) % faces.len();
            let n = faces[f].len();
            if n < 4 {
                return None;
            }
            let list = from(&faces[f], faces[f][usize::from(corner) % n]);
            let at = 2 + usize::from(corner) / n % (n - 3);
            out[f] = list[..=at].to_vec();
            out.push(list[at..].iter().copied().chain([list[0]]).collect());
        }
        Change::Collapse(i) => {
            let &((a, b), _) = pick(&edges, i)?;
            for face in &mut out {
                face.iter_mut().for_each(|v| *v = if *v == b { a } else { *v });
                face.dedup();
                if face.len() > 1 && face[0] == face[face.len() - 1] {
                    face.pop();
                }
            }
            out.retain(|face| face.len() > 2);
        }
        Change::Delete(i) => {
            if faces.len() < 3 {
                return None;
            }
            out.remove(usize::from(i) % faces.len());
        }
        Change::Poke(i) => {
            let f = usize::from(i) % faces.len();
            let face = out.remove(f);
            out.extend((0..face.len()).map(|k| vec![face[k], face[(k + 1) % face.len()], free]));
        }
        Change::Bisect(i) => {
            let &((a, b), _) = pick(&edges, i)?;
            for face in &mut out {
                let n = face.len();
                let joins = |k: &usize| {
                    let (p, q) = (face[*k], face[(k + 1) % n]);
                    (p.min(q), p.max(q)) == (a, b)
                };
                if let Some(k) = (0..n).find(joins) {
                    face.insert(k + 1, free);
                }
            }
        }
        Change::Sheet(i) => {
            let &((a, b), _) = pick(&edges, i)?;
            out.push(vec![a, b, free, free + 1]);
            return Some(out);
        }
    }
    (!out.is_empty() && out.len() < 700 && is_manifold(&out)).then_some(out)
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
        faces
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
            let sides = mesh.face_vertices(face).len();
            let subface = if sides == 4 { 0 } else { u32::from(sub) % sides as u32 };
            Location { face: Face::new(face), subface, u: u.value(), v: v.value() }
        };
        self.places.iter().map(place).collect()
    }
}

pub fn base() -> impl Strategy<Value = Base> {
    prop_oneof![
        3 => (1..6u32, 1..6u32).prop_map(|(w, h)| Base::Grid(w, h)),
        1 => (3..6u32, 1..4u32).prop_map(|(w, h)| Base::Tube(w, h)),
        1 => (3..6u32, 3..6u32).prop_map(|(w, h)| Base::Torus(w, h)),
        3 => (2..9u32, 1..3u32).prop_map(|(n, r)| Base::Fan(n, r)),
        1 => (9..51u32).prop_map(|n| Base::Fan(n, 1)),
        2 => (1..9u32, 1..3u32).prop_map(|(n, r)| Base::Sector(n, r)),
        1 => (9..51u32).prop_map(|n| Base::Sector(n, 1)),
        1 => (3..51u32).prop_map(Base::Umbrella),
        1 => (3..13u32).prop_map(Base::Cone),
        1 => (3..8u32).prop_map(Base::Pillow),
        2 => (1..4u32).prop_map(Base::Cube),
        1 => Just(Base::Tetrahedron),
        1 => (2..5u32, 1..4u32, 1..5u32).prop_map(|(p, w, h)| Base::Book(p, w, h)),
    ]
}

fn a_change() -> impl Strategy<Value = Change> {
    let i = any::<u16>;
    prop_oneof![
        3 => i().prop_map(Change::Merge),
        2 => (i(), any::<u8>()).prop_map(|(f, c)| Change::Cut(f, c)),
        3 => i().prop_map(Change::Collapse),
        1 => i().prop_map(Change::Delete),
        1 => i().prop_map(Change::Poke),
        1 => i().prop_map(Change::Bisect),
        1 => i().prop_map(Change::Sheet),
    ]
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
            seed,
            places,
        },
    )
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
