//! The limit surface by brute force, independent of the crate: a polygon soup with hash maps is refined round a location
//! until a bicubic patch covers it. Arithmetic in double-double, relative to a point of the neighbourhood, so that
//! derivatives are right at any depth. Slow and simple; the crate's closed forms are checked against it.
#![allow(dead_code)]

mod double;

pub use double::Double;
use std::collections::{BTreeMap, HashMap, HashSet};
use subsurf::{Boundary, ControlMesh, Creasing, Face, Location, Triangles};

type Point = [Double; 3];

const INFINITE: f64 = 10.0;

/// What brute force finds at a location.
#[derive(Clone, Debug)]
pub struct Truth {
    pub position: [f64; 3],
    /// First derivatives in u, v and second in uu, uv, vv; none where no level has a bicubic patch: at special vertices.
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
    chaikin: bool,
    smooth_triangles: bool,
    /// Where the points' zero lies.
    zero: Point,
}

fn key(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

fn sides(face: &[u32]) -> impl Iterator<Item = (u32, u32)> {
    (0..face.len()).map(move |i| (face[i], face[(i + 1) % face.len()]))
}

fn decay(s: f64) -> f64 {
    if s >= INFINITE { INFINITE } else { (s - 1.0).max(0.0) }
}

fn sum(terms: impl Iterator<Item = Point>) -> Point {
    terms.fold([Double::ZERO; 3], plus)
}

fn plus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] + b[k])
}

fn times(a: Point, w: Double) -> Point {
    a.map(|x| x * w)
}

fn over(a: Point, n: usize) -> Point {
    a.map(|x| x / Double::from(n as f64))
}

fn mix(a: Point, w: f64, b: Point) -> Point {
    let w = Double::from(w);
    plus(times(a, w), times(b, Double::from(1.0) - w))
}

/// What refinement asks of a vertex's and an edge's surroundings.
struct Rings {
    /// Faces of every edge.
    edge_faces: HashMap<(u32, u32), Vec<usize>>,
    /// Edges and faces of every vertex.
    vertex_edges: HashMap<u32, Vec<(u32, u32)>>,
    vertex_faces: HashMap<u32, Vec<usize>>,
}

#[derive(Clone, Copy, PartialEq, Debug)]
enum Rule {
    Smooth,
    Crease,
    Corner,
}

impl Soup {
    /// The control mesh with its rules applied. No face may visit a vertex twice.
    pub fn new(mesh: &ControlMesh, positions: &[[f64; 3]]) -> Self {
        let tags = mesh.tags();
        let mut soup = Self {
            faces: mesh.faces().map(<[u32]>::to_vec).collect(),
            points: positions.iter().map(|p| p.map(Double::from)).collect(),
            vertex_sharpness: vec![0.0; positions.len()],
            edge_sharpness: HashMap::new(),
            holes: tags.holes.iter().map(|&f| f as usize).collect(),
            chaikin: tags.rules.creasing == Creasing::Chaikin,
            smooth_triangles: tags.rules.triangles == Triangles::Smooth,
            zero: [Double::ZERO; 3],
        };
        for f in &soup.faces {
            let distinct: HashSet<u32> = f.iter().copied().collect();
            assert_eq!(distinct.len(), f.len(), "a face visits a vertex twice");
        }
        for c in &tags.creases {
            soup.edge_sharpness.insert(key(c.vertices[0], c.vertices[1]), c.sharpness.clamp(0.0, INFINITE));
        }
        for c in &tags.corners {
            soup.vertex_sharpness[c.vertex as usize] = c.sharpness.clamp(0.0, INFINITE);
        }
        let rings = soup.rings();
        let is_boundary = |e: &(u32, u32)| rings.edge_faces[e].len() < 2;
        let odd: HashSet<(u32, u32)> = rings
            .edge_faces
            .keys()
            .copied()
            .filter(|e| rings.edge_faces[e].len() > 2 || soup.conflict(*e, &rings))
            .collect();
        let is_odd = |e: &(u32, u32)| odd.contains(e);
        if tags.rules.boundary == Boundary::None {
            let open: HashSet<u32> = rings
                .edge_faces
                .keys()
                .filter(|e| is_boundary(e) && soup.edge_sharpness.get(e).is_none_or(|&s| s < INFINITE))
                .flat_map(|e| [e.0, e.1])
                .collect();
            let holes: Vec<usize> =
                (0..soup.faces.len()).filter(|&f| soup.faces[f].iter().any(|v| open.contains(v))).collect();
            soup.holes.extend(holes);
        }
        let mut pinned = Vec::new();
        for (&v, edges) in &rings.vertex_edges {
            let sheets = soup.sheets(v, &rings);
            let odd: Vec<(u32, u32)> = edges.iter().copied().filter(is_odd).collect();
            let lone = rings.vertex_faces[&v].len() == 1 && tags.rules.boundary == Boundary::EdgeAndCorner;
            // A crease along which several sheets meet stays a crease.
            let along = odd.len() == 2
                && rings.vertex_faces[&v].len() > edges.len()
                && rings.edge_faces[&odd[0]].len() == rings.edge_faces[&odd[1]].len()
                && sheets.iter().all(|ends| ends.len() == 2 && odd.iter().all(|e| ends.contains(e)));
            if lone || (!odd.is_empty() && !along) || (odd.is_empty() && sheets.len() > 1) {
                pinned.push(v);
            }
        }
        let sharp: Vec<(u32, u32)> = rings.edge_faces.keys().copied().filter(|e| is_boundary(e) || is_odd(e)).collect();
        sharp.into_iter().for_each(|e| _ = soup.edge_sharpness.insert(e, INFINITE));
        pinned.into_iter().for_each(|v| soup.vertex_sharpness[v as usize] = INFINITE);
        soup.edge_sharpness.retain(|_, s| *s > 0.0);
        soup
    }

    /// True where two faces run through an edge in the same direction.
    fn conflict(&self, e: (u32, u32), rings: &Rings) -> bool {
        let forward = |f: usize| sides(&self.faces[f]).any(|s| s == e);
        let faces = &rings.edge_faces[&e];
        faces.len() == 2 && forward(faces[0]) == forward(faces[1])
    }

    /// The fans at a vertex, of faces joined through edges of two faces: for each fan the edges where it ends.
    fn sheets(&self, v: u32, rings: &Rings) -> Vec<Vec<(u32, u32)>> {
        let mut left: HashSet<usize> = rings.vertex_faces[&v].iter().copied().collect();
        let mut sheets = Vec::new();
        while let Some(&start) = left.iter().min() {
            let (mut ends, mut todo) = (Vec::new(), vec![start]);
            left.remove(&start);
            while let Some(f) = todo.pop() {
                for (a, b) in sides(&self.faces[f]).filter(|&(a, b)| a == v || b == v) {
                    let e = key(a, b);
                    if rings.edge_faces[&e].len() != 2 || self.conflict(e, rings) {
                        ends.push(e);
                        continue;
                    }
                    for &g in &rings.edge_faces[&e] {
                        if left.remove(&g) {
                            todo.push(g);
                        }
                    }
                }
            }
            sheets.push(ends);
        }
        sheets
    }

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

    fn sharpness(&self, e: (u32, u32)) -> f64 {
        self.edge_sharpness.get(&e).copied().unwrap_or(0.0)
    }

    /// Sharpness of the half of `e` at its end `v`.
    fn half(&self, e: (u32, u32), v: u32, rings: &Rings) -> f64 {
        let s = self.sharpness(e);
        let semi = |s: f64| s > 0.0 && s < INFINITE;
        if !self.chaikin || !semi(s) {
            return decay(s);
        }
        let others: Vec<f64> = rings.vertex_edges[&v]
            .iter()
            .filter(|&&other| other != e)
            .map(|&other| self.sharpness(other))
            .filter(|&s| semi(s))
            .collect();
        if others.is_empty() {
            return decay(s);
        }
        (0.75 * s + 0.25 * others.iter().sum::<f64>() / others.len() as f64 - 1.0).max(0.0)
    }

    fn rule(vertex: f64, sharp_edges: usize) -> Rule {
        match sharp_edges {
            _ if vertex > 0.0 => Rule::Corner,
            0 | 1 => Rule::Smooth,
            2 => Rule::Crease,
            _ => Rule::Corner,
        }
    }

    fn vertex_point(&self, v: u32, rings: &Rings, face_points: &[Point]) -> Point {
        let edges = &rings.vertex_edges[&v];
        let own = self.points[v as usize];
        let s = self.vertex_sharpness[v as usize];
        let other = |e: &(u32, u32)| self.points[if e.0 == v { e.1 } else { e.0 } as usize];
        let now: Vec<(u32, u32)> = edges.iter().copied().filter(|&e| self.sharpness(e) > 0.0).collect();
        let later: Vec<(u32, u32)> = now.iter().copied().filter(|&e| self.half(e, v, rings) > 0.0).collect();
        let apply = |rule: Rule, sharp: &[(u32, u32)]| match rule {
            Rule::Corner => own,
            Rule::Crease => {
                let ends = plus(other(&sharp[0]), other(&sharp[1]));
                plus(times(own, Double::from(0.75)), times(ends, Double::from(0.125)))
            }
            Rule::Smooth => {
                let faces = &rings.vertex_faces[&v];
                let n = faces.len();
                assert_eq!(edges.len(), n, "a smooth vertex lies inside");
                let ring = plus(sum(edges.iter().map(other)), sum(faces.iter().map(|&f| face_points[f])));
                let n = Double::from(n as f64);
                plus(times(own, (n - Double::from(2.0)) / n), times(ring, Double::from(1.0) / (n * n)))
            }
        };
        let parent = Self::rule(s, now.len());
        if parent == Rule::Smooth {
            return apply(Rule::Smooth, &[]);
        }
        let child = Self::rule(decay(s), later.len());
        if child == parent && (child != Rule::Crease || now == later) {
            return apply(parent, &now);
        }
        let mut fading: Vec<f64> = now
            .iter()
            .filter(|&&e| if self.chaikin { self.half(e, v, rings) <= 0.0 } else { self.sharpness(e) <= 1.0 })
            .map(|&e| self.sharpness(e))
            .collect();
        if s > 0.0 && decay(s) == 0.0 {
            fading.push(s);
        }
        let weight = if fading.is_empty() { 0.0 } else { (fading.iter().sum::<f64>() / fading.len() as f64).min(1.0) };
        mix(apply(parent, &now), weight, apply(child, &later))
    }

    fn edge_point(&self, e: (u32, u32), rings: &Rings, face_points: &[Point]) -> Point {
        let ends = plus(self.points[e.0 as usize], self.points[e.1 as usize]);
        let middle = over(ends, 2);
        let s = self.sharpness(e);
        if s >= 1.0 || (self.chaikin && s > 0.0 && [e.0, e.1].iter().all(|&v| self.half(e, v, rings) > 0.0)) {
            return middle;
        }
        let faces = &rings.edge_faces[&e];
        assert_eq!(faces.len(), 2, "a smooth edge has two faces");
        let triangle = |f: usize| self.faces[f].len() == 3;
        let share = if self.smooth_triangles && faces.iter().any(|&f| triangle(f)) {
            let t = |f: usize| if triangle(f) { Double::ratio(47.0, 100.0) } else { Double::from(0.25) };
            (t(faces[0]) + t(faces[1])) / Double::from(2.0)
        } else {
            Double::from(0.25)
        };
        let centres = plus(face_points[faces[0]], face_points[faces[1]]);
        let smooth = plus(times(ends, Double::from(0.5) - share), times(centres, share));
        mix(middle, s, smooth)
    }

    /// Faces at the corners of the faces in `of`, those first.
    fn grown(&self, of: &[usize], rings: &Rings) -> Vec<usize> {
        let mut list = of.to_vec();
        let mut known: HashSet<usize> = of.iter().copied().collect();
        for &f in of {
            for v in &self.faces[f] {
                for &g in &rings.vertex_faces[v] {
                    if known.insert(g) {
                        list.push(g);
                    }
                }
            }
        }
        list
    }

    /// Face `face` and two rings of faces round it, relative to its first corner.
    fn cut_out(&self, face: usize, rings: &Rings) -> Self {
        let one = self.grown(&[face], rings);
        let two = self.grown(&one, rings);
        let mut new_of = HashMap::new();
        let mut old = Vec::new();
        let faces: Vec<Vec<u32>> = two
            .iter()
            .map(|&f| {
                let renumber = |&v: &u32| {
                    *new_of.entry(v).or_insert_with(|| {
                        old.push(v);
                        old.len() as u32 - 1
                    })
                };
                self.faces[f].iter().map(renumber).collect()
            })
            .collect();
        let base = self.points[old[0] as usize];
        let away = times(base, Double::from(-1.0));
        let mut edge_sharpness = HashMap::new();
        for (&(a, b), &s) in &self.edge_sharpness {
            if let (Some(&a), Some(&b)) = (new_of.get(&a), new_of.get(&b)) {
                edge_sharpness.insert(key(a, b), s);
            }
        }
        Self {
            faces,
            points: old.iter().map(|&v| plus(self.points[v as usize], away)).collect(),
            vertex_sharpness: old.iter().map(|&v| self.vertex_sharpness[v as usize]).collect(),
            edge_sharpness,
            holes: HashSet::new(),
            chaikin: self.chaikin,
            smooth_triangles: self.smooth_triangles,
            zero: plus(self.zero, base),
        }
    }

    /// One refinement step; the next face 0 is face 0's child at `corner`.
    fn child(&self, corner: usize) -> Self {
        let rings = self.rings();
        // Vertices whose faces are all here.
        let inner: HashSet<u32> =
            self.grown(&[0], &rings).iter().flat_map(|&f| self.faces[f].iter().copied()).collect();
        let centroid = |f: &Vec<u32>| over(sum(f.iter().map(|&v| self.points[v as usize])), f.len());
        let face_points: Vec<Point> = self.faces.iter().map(centroid).collect();
        let mut points = face_points.clone();
        let mut sharpness = vec![0.0; points.len()];
        let mut edge_sharpness = HashMap::new();
        let mut vertex_of = BTreeMap::new();
        for &v in &inner {
            vertex_of.insert(v, points.len() as u32);
            points.push(self.vertex_point(v, &rings, &face_points));
            sharpness.push(decay(self.vertex_sharpness[v as usize]));
        }
        let mut edge_of = HashMap::new();
        for &e in rings.edge_faces.keys().filter(|e| inner.contains(&e.0) || inner.contains(&e.1)) {
            let new = points.len() as u32;
            edge_of.insert(e, new);
            points.push(self.edge_point_or_middle(e, &rings, &face_points, &inner));
            sharpness.push(0.0);
            for v in [e.0, e.1].into_iter().filter(|v| inner.contains(v)) {
                let half = self.half(e, v, &rings);
                if half > 0.0 {
                    edge_sharpness.insert(key(vertex_of[&v], new), half);
                }
            }
        }
        let mut faces = Vec::new();
        let mut own = 0;
        for (f, face) in self.faces.iter().enumerate() {
            let n = face.len();
            for (i, v) in face.iter().enumerate().filter(|(_, v)| inner.contains(v)) {
                let (after, before) = (face[(i + 1) % n], face[(i + n - 1) % n]);
                let mut quad = [vertex_of[v], edge_of[&key(*v, after)], f as u32, edge_of[&key(before, *v)]];
                if n == 4 {
                    quad.rotate_right(i);
                }
                if f == 0 && i == corner {
                    own = faces.len();
                }
                faces.push(quad.to_vec());
            }
        }
        let refined = Self {
            faces,
            points,
            vertex_sharpness: sharpness,
            edge_sharpness,
            holes: HashSet::new(),
            chaikin: self.chaikin,
            smooth_triangles: self.smooth_triangles,
            zero: self.zero,
        };
        let rings = refined.rings();
        refined.cut_out(own, &rings)
    }

    /// The edge point; where an end's edges are not all here, Chaikin's rule cannot look, and nobody will.
    fn edge_point_or_middle(&self, e: (u32, u32), rings: &Rings, face_points: &[Point], inner: &HashSet<u32>) -> Point {
        let complete = |v: u32| inner.contains(&v);
        if complete(e.0) && complete(e.1) || !self.chaikin {
            return self.edge_point(e, rings, face_points);
        }
        over(plus(self.points[e.0 as usize], self.points[e.1 as usize]), 2)
    }

    /// The sixteen points of face 0's patch, `[x][y]`, if one covers it: no finite sharpness at its corners, which are
    /// smooth of valence 4, straight on a sharp curve, or sharp with this face alone.
    fn patch(&self) -> Option<[[Point; 4]; 4]> {
        let rings = self.rings();
        let own = &self.faces[0];
        if self.grown(&[0], &rings).iter().any(|&f| self.faces[f].len() != 4) {
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
                (false, 0) => rings.vertex_faces[&v].len() == 4,
                (false, 2) => faces == 2,
                _ => false,
            };
            if !regular {
                return None;
            }
        }
        Some(self.grid(&rings))
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

    fn grid(&self, rings: &Rings) -> [[Point; 4]; 4] {
        const INNER: [(usize, usize); 4] = [(1, 1), (2, 1), (2, 2), (1, 2)];
        // Beyond side j: the points outward of corners j and j + 1.
        const BEYOND: [[(usize, usize); 2]; 4] =
            [[(1, 0), (2, 0)], [(3, 1), (3, 2)], [(2, 3), (1, 3)], [(0, 2), (0, 1)]];
        const DIAGONAL: [(usize, usize); 4] = [(0, 0), (3, 0), (3, 3), (0, 3)];
        let own = &self.faces[0];
        let at = |v: u32| self.points[v as usize];
        let mirror = |a: Point, b: Point| plus(times(a, Double::from(2.0)), times(b, Double::from(-1.0)));
        let mut grid = [[[Double::ZERO; 3]; 4]; 4];
        (0..4).for_each(|j| grid[INNER[j].0][INNER[j].1] = at(own[j]));
        let side = |j: usize| key(own[j % 4], own[(j + 1) % 4]);
        let sharp = |j: usize| self.sharpness(side(j)) > 0.0;
        let neighbour = |j: usize| *rings.edge_faces[&side(j)].iter().find(|&&f| f != 0).expect("two faces");
        let get = |grid: &[[Point; 4]; 4], (x, y): (usize, usize)| grid[x][y];
        for j in 0..4 {
            let [a, b] = if sharp(j) {
                let inner = |k: usize| get(&grid, INNER[k % 4]);
                [mirror(inner(j), inner(j + 3)), mirror(inner(j + 1), inner(j + 2))]
            } else {
                let face = &self.faces[neighbour(j)];
                let i = face.iter().position(|&v| v == own[j]).expect("a common corner");
                // The neighbour runs from corner j + 1 to corner j.
                assert_eq!(face[(i + 3) % 4], own[(j + 1) % 4]);
                [at(face[(i + 1) % 4]), at(face[(i + 2) % 4])]
            };
            grid[BEYOND[j][0].0][BEYOND[j][0].1] = a;
            grid[BEYOND[j][1].0][BEYOND[j][1].1] = b;
        }
        for j in 0..4 {
            let before = (j + 3) % 4;
            let point = match (sharp(before), sharp(j)) {
                (false, false) => {
                    let beside = [0, neighbour(before), neighbour(j)];
                    let faces = &rings.vertex_faces[&own[j]];
                    let f = *faces.iter().find(|f| !beside.contains(f)).expect("four faces");
                    let i = self.faces[f].iter().position(|&v| v == own[j]).expect("a common corner");
                    at(self.faces[f][(i + 2) % 4])
                }
                (true, false) => mirror(get(&grid, BEYOND[j][0]), get(&grid, BEYOND[j][1])),
                _ => mirror(get(&grid, BEYOND[before][1]), get(&grid, BEYOND[before][0])),
            };
            grid[DIAGONAL[j].0][DIAGONAL[j].1] = point;
        }
        grid
    }

    /// The surface at a location; none in holes.
    pub fn eval(&self, at: Location) -> Option<Truth> {
        let face = at.face.index();
        if self.holes.contains(&face) {
            return None;
        }
        let rings = self.rings();
        let mut soup = self.cut_out(face, &rings);
        let (mut u, mut v) = (at.u, at.v);
        let split = soup.faces[0].len() != 4;
        if split {
            soup = soup.child(at.subface as usize);
        }
        // Positions at a vertex converge with 0.66 a level at worst: 1e-18 after 100 levels.
        const DEEPEST: u32 = 100;
        for scale in 0..DEEPEST {
            if let Some(grid) = soup.patch() {
                return Some(soup.at_patch(&grid, u, v, scale as i32, scale + u32::from(split)));
            }
            let (cu, cv) = (u >= 0.5, v >= 0.5);
            let corner = [[0, 3], [1, 2]][usize::from(cu)][usize::from(cv)];
            (u, v) = (2.0 * u - f64::from(u8::from(cu)), 2.0 * v - f64::from(u8::from(cv)));
            soup = soup.child(corner);
        }
        // The corner that the location has been drawn to.
        let corner = [[0, 3], [1, 2]][usize::from(u >= 0.5)][usize::from(v >= 0.5)];
        assert!((u == 0.0 || u == 1.0) && (v == 0.0 || v == 1.0), "no patch at {at:?}");
        let position = plus(soup.points[soup.faces[0][corner] as usize], soup.zero);
        Some(Truth { position: position.map(Double::to_f64), derivatives: None, spread: 0.0, depth: DEEPEST })
    }

    fn at_patch(&self, grid: &[[Point; 4]; 4], u: f64, v: f64, scale: i32, depth: u32) -> Truth {
        let (bu, bv) = (cubic(u), cubic(v));
        let at = |i: usize, j: usize| {
            let mut total = [Double::ZERO; 3];
            for x in 0..4 {
                for y in 0..4 {
                    total = plus(total, times(grid[x][y], bu[i][x] * bv[j][y]));
                }
            }
            total
        };
        let derivative = |i: usize, j: usize| at(i, j).map(|x| x.to_f64() * 2f64.powi(scale * (i + j) as i32));
        let reach = |p: &Point| size([0, 1, 2].map(|k| (p[k] - grid[1][1][k]).to_f64()));
        Truth {
            spread: grid.iter().flatten().map(reach).fold(0.0, f64::max) * 2f64.powi(scale),
            position: plus(at(0, 0), self.zero).map(Double::to_f64),
            derivatives: Some([(1, 0), (0, 1), (2, 0), (1, 1), (0, 2)].map(|(i, j)| derivative(i, j))),
            depth,
        }
    }

    /// Faces that are no holes.
    pub fn solid_faces(&self) -> Vec<Face> {
        (0..self.faces.len()).filter(|f| !self.holes.contains(f)).map(Face::new).collect()
    }
}

/// Uniform cubic B-spline basis: values, first and second derivatives.
fn cubic(t: f64) -> [[Double; 4]; 3] {
    let t = Double::from(t);
    let s = Double::from(1.0) - t;
    let n = |x: f64| Double::from(x);
    let six = |x: Double| x / n(6.0);
    let half = |x: Double| x / n(2.0);
    let inner = |t: Double| six(n(4.0) - n(6.0) * t * t + n(3.0) * t * t * t);
    [
        [six(s * s * s), inner(t), inner(s), six(t * t * t)],
        [half(n(-1.0) * s * s), half(n(3.0) * t * t - n(4.0) * t), half(n(4.0) * s - n(3.0) * s * s), half(t * t)],
        [s, n(3.0) * t - n(2.0), n(3.0) * s - n(2.0), t],
    ]
}

impl Truth {
    /// Largest errors of first and second derivatives, relative to the largest derivative there. Where a surface folds
    /// so that all derivatives nearly vanish, rounding leaves errors relative to the points' distances instead.
    pub fn derivative_errors(&self, du: [f64; 3], dv: [f64; 3], second: [[f64; 3]; 3]) -> [f64; 2] {
        let Some(d) = self.derivatives else { return [0.0; 2] };
        let largest = |from: usize, to: usize| d[from..to].iter().map(|&d| size(d)).fold(0.0, f64::max);
        let first = largest(0, 2).max(1e-4 * self.spread);
        let all = largest(2, 5).max(first);
        if first == 0.0 {
            return [0.0; 2];
        }
        let [uu, uv, vv] = second;
        let error = |k: usize| apart([du, dv, uu, uv, vv][k], d[k]);
        [error(0).max(error(1)) / first, error(2).max(error(3)).max(error(4)) / all]
    }
}

pub fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    size([0, 1, 2].map(|k| a[k] - b[k]))
}

pub fn size(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Diagonal of the box round the control points.
pub fn diagonal(points: &[[f64; 3]]) -> f64 {
    let bound = |f: fn(f64, f64) -> f64| [0, 1, 2].map(|k| points.iter().map(|p| p[k]).reduce(f).expect("points"));
    apart(bound(f64::max), bound(f64::min))
}
