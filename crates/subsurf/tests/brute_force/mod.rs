//! The limit surface by brute force, independent of the crate: a polygon soup with hash maps is refined round a location
//! until one polynomial patch covers it. Arithmetic in double-double, relative to a point of the neighbourhood, so that
//! derivatives are right at any depth. Slow and simple; the crate's closed forms are checked against it.
//!
//! `control` applies tags and rules, `masks` has the weights, `refine` the two splits, `bicubic` and `quartic` the
//! polynomials of regular faces; `compare` puts the crate beside it.
#![allow(dead_code)]

mod bicubic;
pub mod compare;
mod control;
mod double;
mod masks;
mod point;
mod quartic;
mod refine;

pub use double::Double;
pub use point::{apart, diagonal, size, worse};

use point::{Point, plus};
use std::collections::{HashMap, HashSet};
use subsurf::{Face, Location};

const INFINITE: f64 = 10.0;

/// What brute force finds at a location.
#[derive(Clone, Debug)]
pub struct Truth {
    pub position: [f64; 3],
    /// First derivatives in u, v and second in uu, uv, vv; none where no level has a polynomial patch: at special vertices.
    pub derivatives: Option<[[f64; 3]; 5]>,
    /// The largest first derivative that points so far apart as the patch's can have.
    pub spread: f64,
    /// How many refinements it took.
    pub depth: u32,
}

/// The effective tags of a mesh and its faces; refined round one face at a time.
#[derive(Clone)]
pub struct Soup {
    /// Face 0 is the one looked at.
    faces: Vec<Vec<u32>>,
    points: Vec<Point>,
    vertex_sharpness: Vec<f64>,
    /// Positive values only, by vertex pair, smaller first.
    edge_sharpness: HashMap<(u32, u32), f64>,
    holes: HashSet<usize>,
    /// Loop's split and masks; else Catmull and Clark's.
    triangles: bool,
    chaikin: bool,
    smooth_triangles: bool,
    /// Where the points' zero lies.
    zero: Point,
}

/// Faces, edges and vertices round each other.
struct Rings {
    /// Faces of every edge.
    edge_faces: HashMap<(u32, u32), Vec<usize>>,
    /// Edges and faces of every vertex.
    vertex_edges: HashMap<u32, Vec<(u32, u32)>>,
    vertex_faces: HashMap<u32, Vec<usize>>,
}

fn key(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

fn sides(face: &[u32]) -> impl Iterator<Item = (u32, u32)> {
    (0..face.len()).map(move |i| (face[i], face[(i + 1) % face.len()]))
}

/// Position, then derivatives in u, v, uu, uv, vv, in a patch's own parameters.
type Jet = [Point; 6];

/// A polynomial over face 0.
struct Patch {
    /// Its jet at any parameters.
    jet: Box<dyn Fn(f64, f64) -> Jet>,
    /// The largest distance of its control points.
    reach: f64,
}

impl Soup {
    fn rings(&self) -> Rings {
        let mut rings =
            Rings { edge_faces: HashMap::new(), vertex_edges: HashMap::new(), vertex_faces: HashMap::new() };
        for (f, face) in self.faces.iter().enumerate() {
            for (a, b) in sides(face) {
                rings.vertex_faces.entry(a).or_default().push(f);
                let faces = rings.edge_faces.entry(key(a, b)).or_default();
                if faces.is_empty() {
                    rings.vertex_edges.entry(a).or_default().push(key(a, b));
                    rings.vertex_edges.entry(b).or_default().push(key(a, b));
                }
                faces.push(f);
            }
        }
        rings
    }

    /// The polynomial over face 0, if it is regular: no finite sharpness at its corners, which are smooth of the regular
    /// valence, straight on a sharp curve, or sharp with this face alone.
    fn patch(&self) -> Option<Patch> {
        let rings = self.rings();
        let own = &self.faces[0];
        let (whole, [inside, straight]) = if self.triangles { (3, [6, 3]) } else { (4, [4, 2]) };
        if self.grown(&[0], &rings).iter().any(|&f| self.faces[f].len() != whole) {
            return None;
        }
        let finite = |s: f64| s > 0.0 && s < INFINITE;
        for &v in own {
            let sharp: Vec<f64> =
                rings.vertex_edges[&v].iter().map(|&e| self.sharpness(e)).filter(|&s| s > 0.0).collect();
            let s = self.vertex_sharpness[v as usize];
            if finite(s) || sharp.iter().any(|&s| finite(s)) {
                return None;
            }
            let faces = self.sector(v, &rings);
            let regular = match (s > 0.0 || sharp.len() > 2, sharp.len()) {
                (true, 0) => false,
                (true, _) => faces == 1,
                (false, 0) => rings.vertex_faces[&v].len() == inside,
                (false, 2) => faces == straight,
                _ => false,
            };
            if !regular {
                return None;
            }
        }
        Some(if self.triangles { self.quartic(&rings) } else { self.bicubic(&rings) })
    }

    /// Number of faces between the sharp edges at corner `v` of face 0.
    fn sector(&self, v: u32, rings: &Rings) -> usize {
        let (mut known, mut todo) = (HashSet::from([0]), vec![0]);
        while let Some(f) = todo.pop() {
            for (a, b) in sides(&self.faces[f]).filter(|&(a, b)| a == v || b == v) {
                if self.sharpness(key(a, b)) == 0.0 {
                    todo.extend(rings.edge_faces[&key(a, b)].iter().copied().filter(|&g| known.insert(g)));
                }
            }
        }
        known.len()
    }

    /// The surface at a location; none in holes.
    pub fn eval(&self, at: Location) -> Option<Truth> {
        self.eval_after(at, 0)
    }

    /// The same with `more` refinements than are needed, which change nothing if the patches are what the levels
    /// converge to.
    pub fn eval_after(&self, at: Location, mut more: u32) -> Option<Truth> {
        let face = at.face.index();
        if self.holes.contains(&face) {
            return None;
        }
        let rings = self.rings();
        let mut soup = self.cut_out(face, &rings);
        let (mut u, mut v) = (at.u, at.v);
        let split = !self.triangles && soup.faces[0].len() != 4;
        if split {
            soup = soup.child(at.subface as usize);
        }
        // The surface over a face lies within its control points. Those at a vertex draw together by 0.66 a level at worst:
        // to 1e-18 after 100 levels.
        const DEEPEST: u32 = 100;
        let small = 1e-18 * soup.extent();
        // Parameters of the patch per those of the face; negative in triangles that are turned upside down.
        let mut scale = 1.0;
        for level in 0..DEEPEST {
            if let Some(patch) = soup.patch() {
                if more == 0 {
                    return Some(soup.at_patch(&patch, u, v, scale, level + u32::from(split)));
                }
                more -= 1;
            }
            if [u, v].iter().all(|&x| x == 0.0 || x == 1.0) && soup.extent() <= small {
                break;
            }
            let (child, turned) =
                if self.triangles { triangle_child(&mut u, &mut v) } else { quad_child(&mut u, &mut v) };
            scale *= 2.0 * turned;
            soup = soup.child(child);
        }
        // The corner that the location has been drawn to.
        let corner = match (self.triangles, u >= 0.5, v >= 0.5) {
            (_, false, false) => 0,
            (_, true, false) => 1,
            (true, _, true) | (false, true, true) => 2,
            (false, false, true) => 3,
        };
        assert!((u == 0.0 || u == 1.0) && (v == 0.0 || v == 1.0), "no patch at {at:?}");
        let position = plus(soup.points[soup.faces[0][corner] as usize], soup.zero);
        Some(Truth { position: position.map(Double::to_f64), derivatives: None, spread: 0.0, depth: DEEPEST })
    }

    /// The largest coordinate, relative to a point of the soup.
    fn extent(&self) -> f64 {
        self.points.iter().flatten().map(|x| x.to_f64().abs()).fold(0.0, f64::max)
    }

    fn at_patch(&self, patch: &Patch, u: f64, v: f64, scale: f64, depth: u32) -> Truth {
        let jet = (patch.jet)(u, v);
        let derivative = |k: usize| jet[k].map(|x| x.to_f64() * scale.powi(if k < 3 { 1 } else { 2 }));
        Truth {
            spread: patch.reach * scale.abs(),
            position: plus(jet[0], self.zero).map(Double::to_f64),
            derivatives: Some([1, 2, 3, 4, 5].map(derivative)),
            depth,
        }
    }

    /// Faces that are no holes.
    pub fn solid_faces(&self) -> Vec<Face> {
        (0..self.faces.len()).filter(|f| !self.holes.contains(f)).map(Face::new).collect()
    }
}

/// The child that holds a place, whose parameters become those of the child; and the child's direction.
fn quad_child(u: &mut f64, v: &mut f64) -> (usize, f64) {
    let (cu, cv) = (*u >= 0.5, *v >= 0.5);
    (*u, *v) = (2.0 * *u - f64::from(u8::from(cu)), 2.0 * *v - f64::from(u8::from(cv)));
    ([[0, 3], [1, 2]][usize::from(cu)][usize::from(cv)], 1.0)
}

/// The same of a triangle, whose middle child is upside down.
fn triangle_child(u: &mut f64, v: &mut f64) -> (usize, f64) {
    let (child, turned) = match (*u >= 0.5, *v >= 0.5) {
        (true, _) => (1, [2.0 * *u - 1.0, 2.0 * *v]),
        (_, true) => (2, [2.0 * *u, 2.0 * *v - 1.0]),
        _ if *u + *v > 0.5 => (3, [1.0 - 2.0 * *u, 1.0 - 2.0 * *v]),
        _ => (0, [2.0 * *u, 2.0 * *v]),
    };
    [*u, *v] = turned;
    (child, if child == 3 { -1.0 } else { 1.0 })
}

impl Truth {
    /// Largest errors of first and second derivatives, relative to the largest derivative there. Where a surface folds
    /// so that all derivatives nearly vanish, rounding leaves errors relative to the points' distances instead.
    pub fn derivative_errors(&self, du: [f64; 3], dv: [f64; 3], second: [[f64; 3]; 3]) -> [f64; 2] {
        let Some(d) = self.derivatives else { return [0.0; 2] };
        let largest = |from: usize, to: usize| d[from..to].iter().map(|&d| size(d)).fold(0.0, f64::max);
        let first = largest(0, 2).max(1e-4 * self.spread);
        let all = largest(2, 5).max(first);
        let [uu, uv, vv] = second;
        let error = |k: usize| apart([du, dv, uu, uv, vv][k], d[k]);
        let errors = [worse(error(0), error(1)), worse(error(2), worse(error(3), error(4)))];
        if first == 0.0 { errors } else { [errors[0] / first, errors[1] / all] }
    }
}
