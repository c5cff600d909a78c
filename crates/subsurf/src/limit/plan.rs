//! A plan: everything that the limit of one face depends on except positions. Faces with equal surroundings share it.
//!
//! A plan is a tree. A node is either split into four children, the level's explicit refinement, or a leaf:
//! a bicubic patch, a patch along one semi-sharp crease, or a special vertex with its closed form. Every leaf has its
//! control points as sparse rows over the face's ring. The tree is at most `⌈sharpness⌉ + 2` levels deep: each level
//! takes one from every finite sharpness, makes all faces quads, and parts special vertices.

use super::box_spline;
use super::bspline::{cubic, tensor};
use super::corner::{Corner, Kind, corner, grid_points, special_points};
use super::local_step::child_vertex;
use super::rows::{Accumulator, Combination, Rows};
use super::single_crease;
use super::special::{AtVertex, Method, PointWeights, SpecialVertex};
use super::triangle_points;
use crate::index::{Edge, Face, HalfEdge};
use crate::refine::Level;
use crate::scheme::{Scheme, SplitKind};
use crate::tags::INFINITE_SHARPNESS;
use crate::topology::{Surroundings, Topology, Walk};
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// The special vertices that plans refer to, each made once.
#[derive(Default)]
pub(crate) struct SpecialVertices {
    made: Mutex<HashMap<Corner, Arc<SpecialVertex>>>,
    method: Method,
}

impl SpecialVertices {
    pub fn new(method: Method) -> Self {
        Self { made: Mutex::default(), method }
    }

    fn get(&self, corner: Corner) -> Arc<SpecialVertex> {
        // A smooth or pinned vertex looks the same from all its faces: their numbering starts at the face itself.
        if let Some(made) = self.lock().get(&corner) {
            return made.clone();
        }
        let new = Arc::new(SpecialVertex::new(corner, self.method));
        self.lock().entry(corner).or_insert(new).clone()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<Corner, Arc<SpecialVertex>>> {
        self.made.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// Every kind that was made, sorted.
    pub fn all(&self) -> Vec<Arc<SpecialVertex>> {
        let mut all: Vec<_> = self.lock().values().cloned().collect();
        all.sort_by_key(|s| s.corner);
        all
    }
}

/// What kind of patch covers a location.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum PatchKind {
    /// A bicubic B-spline patch, a quartic box-spline patch under Loop, or a bilinear one.
    Regular,
    /// A patch along one semi-sharp crease, in closed form.
    SingleCrease,
    /// A patch at a special vertex, in closed form.
    Special,
}

enum Node {
    Split([u32; 4]),
    Leaf(u32),
}

struct Leaf {
    shape: LeafShape,
    /// The leaf's control points over the ring.
    points: Rows,
}

enum LeafShape {
    /// The quad's four corners, bilinear.
    Bilinear,
    /// Sixteen points in the order of [`bspline`](super::bspline), or twelve in that of
    /// [`box_spline`](super::box_spline).
    Regular,
    /// Sixteen points turned so that the crease runs along v = 1, between corners `turn + 2` and `turn + 3`.
    SingleCrease { turn: u8, sharpness: f64 },
    /// Points of a special vertex at corner `turn`.
    Special { turn: u8, vertex: Arc<SpecialVertex> },
}

/// A compiled plan.
pub(crate) struct Plan {
    split: SplitKind,
    ring: usize,
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    root: u32,
}

/// A leaf, and the place in it.
struct Found<'a> {
    leaf: &'a Leaf,
    depth: u32,
    /// Leaf parameters per face parameter; negative in triangles that are turned upside down.
    speed: f64,
    u: f64,
    v: f64,
}

impl Found<'_> {
    /// Goes on to the child that holds the place: its number, and -1 where it is turned upside down.
    fn descend(&mut self, split: SplitKind) -> (usize, f64) {
        let (u, v) = (self.u, self.v);
        let (child, u, v, flip) = match (split, u >= 0.5, v >= 0.5) {
            (_, true, false) | (SplitKind::Triangles, true, true) => (1, 2.0 * u - 1.0, 2.0 * v, 1.0),
            (SplitKind::Triangles, false, true) => (2, 2.0 * u, 2.0 * v - 1.0, 1.0),
            (SplitKind::Triangles, ..) if u + v > 0.5 => (3, 1.0 - 2.0 * u, 1.0 - 2.0 * v, -1.0),
            (SplitKind::Quads, true, true) => (2, 2.0 * u - 1.0, 2.0 * v - 1.0, 1.0),
            (SplitKind::Quads, false, true) => (3, 2.0 * u, 2.0 * v - 1.0, 1.0),
            _ => (0, 2.0 * u, 2.0 * v, 1.0),
        };
        (self.u, self.v) = (u, v);
        (child, flip)
    }
}

/// Weights over a face's ring at one location.
pub(crate) type RingWeights = PointWeights;

/// One level of explicit refinement round one face on the way down the tree.
struct Site {
    topology: Topology,
    /// The topology's vertices over the ring.
    points: Vec<Combination>,
}

impl Plan {
    /// The plan of the face whose `around`ings were taken from `t`. Of a face that is no quad, the plan covers the
    /// sub-face at the walk's first corner.
    pub fn new(t: &Topology, around: &Surroundings, scheme: Scheme, specials: &SpecialVertices) -> Self {
        let points = (0..around.ring.len() as u32).map(|i| vec![(i, 1.0)]).collect();
        let site = Site { topology: t.cut_out(around), points };
        let mut compiler = Compiler {
            ring: around.ring.len(),
            scheme,
            specials,
            nodes: Vec::new(),
            leaves: Vec::new(),
            walk: Walk::default(),
        };
        let root = if site.topology.sides(Face(0)) == scheme.patch_sides() {
            compiler.compile(&site, 0)
        } else {
            let children = compiler.children(&site, &[0]);
            compiler.compile(&children[0], 1)
        };
        Self { split: scheme.split(), ring: around.ring.len(), nodes: compiler.nodes, leaves: compiler.leaves, root }
    }

    /// Number of control points of the ring.
    pub fn ring(&self) -> usize {
        self.ring
    }

    /// Finds the leaf at `(u, v)`, parameters of a face whose corner `turn` is the plan's corner 0.
    fn leaf(&self, u: f64, v: f64, turn: u8) -> Found<'_> {
        let mut found = Found { leaf: &self.leaves[0], depth: 0, speed: 1.0, u, v };
        let mut node = self.root;
        while let Node::Split(children) = self.nodes[node as usize] {
            let (child, flip) = found.descend(self.split);
            let turn = usize::from(turn);
            let own = match self.split {
                SplitKind::Quads => (child + 4 - turn) % 4,
                SplitKind::Triangles if child == 3 => 3,
                SplitKind::Triangles => (child + 3 - turn) % 3,
            };
            node = children[own];
            found.depth += 1;
            found.speed *= 2.0 * flip;
        }
        if let Node::Leaf(leaf) = self.nodes[node as usize] {
            found.leaf = &self.leaves[leaf as usize];
        }
        found
    }

    /// Which kind of leaf covers `(u, v)`, and at which depth.
    pub fn patch_kind(&self, u: f64, v: f64, turn: u8) -> (PatchKind, u32) {
        let found = self.leaf(u, v, turn);
        let kind = match found.leaf.shape {
            LeafShape::Bilinear | LeafShape::Regular => PatchKind::Regular,
            LeafShape::SingleCrease { .. } => PatchKind::SingleCrease,
            LeafShape::Special { .. } => PatchKind::Special,
        };
        (kind, found.depth)
    }

    /// Weights over the ring for the first `count` entries of [`ORDERS`](super::bspline::ORDERS) (1, 3 or 6) at `(u, v)`,
    /// parameters of a face whose corner `turn` is the plan's corner 0.
    pub fn weights(&self, u: f64, v: f64, turn: u8, count: usize) -> RingWeights {
        let Found { leaf, speed, u, v, .. } = self.leaf(u, v, turn);
        let corners = match self.split {
            SplitKind::Quads => 4,
            SplitKind::Triangles => 3,
        };
        let total = |leaf_turn: u8| (turn + leaf_turn) % corners;
        let turned = |turn: u8| match self.split {
            SplitKind::Quads => turned_quad(u, v, turn),
            SplitKind::Triangles => turned_triangle(u, v, turn),
        };
        let (local, turn) = match &leaf.shape {
            LeafShape::Bilinear => {
                let (a, b) = turned(turn);
                (bilinear(a, b), turn)
            }
            LeafShape::Regular => {
                let (a, b) = turned(turn);
                let weights = match self.split {
                    SplitKind::Quads => tensor(&cubic(a), &cubic(b), count),
                    SplitKind::Triangles => box_spline::basis(a, b, count),
                };
                (dense(weights, count, leaf.points.len()), turn)
            }
            LeafShape::SingleCrease { turn, sharpness } => {
                let turn = total(*turn);
                let (a, _) = turned(turn);
                // The distance from the crease, exact next to it.
                let (_, distance) = turned((turn + 2) % 4);
                let across = single_crease::curve(distance, *sharpness);
                (dense(tensor(&cubic(a), &across, count), count, 16), turn)
            }
            LeafShape::Special { turn, vertex } => {
                let turn = total(*turn);
                let (a, b) = turned(turn);
                (vertex.weights(a, b, count), turn)
            }
        };
        let local = match self.split {
            SplitKind::Quads => turn_back_quad(local, turn),
            SplitKind::Triangles => turn_back_triangle(local, turn),
        };
        self.on_ring(leaf, local, speed, count)
    }

    /// Leaf weights to ring weights, with the factor `speed` per differentiation.
    fn on_ring(&self, leaf: &Leaf, local: PointWeights, speed: f64, count: usize) -> RingWeights {
        let through = |row: &[f64], factor: f64| {
            let mut out = vec![0.0; self.ring];
            leaf.points.left_multiply(row, &mut out);
            if factor != 1.0 {
                out.iter_mut().for_each(|w| *w *= factor);
            }
            out
        };
        let mut out = RingWeights::default();
        for order in 0..count {
            let times = [0, 1, 1, 2, 2, 2][order];
            out.rows[order] = through(&local.rows[order], speed.powi(times));
        }
        out.at_vertex = local
            .at_vertex
            .map(|at| AtVertex { plane: at.plane.map(|plane| plane.map(|row| through(&row, 1.0))), ..at });
        out
    }

    /// True where one spline patch covers the face.
    pub fn is_regular(&self) -> bool {
        self.leaves.len() == 1 && matches!(self.leaves[0].shape, LeafShape::Regular)
    }

    /// The sixteen control points over the ring, where one bicubic patch covers the face.
    pub fn regular_points(&self) -> Option<&Rows> {
        (self.is_regular() && self.split == SplitKind::Quads).then(|| &self.leaves[0].points)
    }

    /// Heap memory in bytes, shared special vertices left out.
    pub fn bytes(&self) -> usize {
        self.leaves.iter().map(|leaf| leaf.points.bytes() + size_of::<Leaf>()).sum::<usize>()
            + self.nodes.len() * size_of::<Node>()
    }
}

/// Parameters after turning the face so that corner `turn` comes first. The one near zero there is exact.
fn turned_quad(u: f64, v: f64, turn: u8) -> (f64, f64) {
    match turn {
        0 => (u, v),
        1 => (v, 1.0 - u),
        2 => (1.0 - u, 1.0 - v),
        _ => (1.0 - v, u),
    }
}

/// Derivatives in turned parameters to derivatives in the face's own.
fn turn_back_quad(mut w: PointWeights, turn: u8) -> PointWeights {
    let negate = |row: &mut Vec<f64>| row.iter_mut().for_each(|x| *x = -*x);
    if turn == 0 || w.rows[1].is_empty() {
        return w;
    }
    match turn {
        1 => {
            // (a, b) = (v, 1 - u): du = -db, dv = da.
            w.rows.swap(1, 2);
            negate(&mut w.rows[1]);
        }
        2 => {
            negate(&mut w.rows[1]);
            negate(&mut w.rows[2]);
        }
        _ => {
            // (a, b) = (1 - v, u): du = db, dv = -da.
            w.rows.swap(1, 2);
            negate(&mut w.rows[2]);
        }
    }
    if turn != 2 {
        w.rows.swap(3, 5);
        negate(&mut w.rows[4]);
    }
    w
}

/// The same for barycentric parameters `u`, `v`. The order of the subtractions keeps what is small next to the corner.
fn turned_triangle(u: f64, v: f64, turn: u8) -> (f64, f64) {
    match turn {
        0 => (u, v),
        1 => (v, (1.0 - u) - v),
        _ => ((1.0 - v) - u, u),
    }
}

/// The same for triangles.
fn turn_back_triangle(mut w: PointWeights, turn: u8) -> PointWeights {
    if turn == 0 || w.rows[1].is_empty() {
        return w;
    }
    let combine = |terms: &[(f64, &[f64])]| -> Vec<f64> {
        (0..terms[0].1.len()).map(|k| terms.iter().map(|(f, row)| f * row[k]).sum()).collect()
    };
    let [_, a, b, aa, ab, bb] = &w.rows;
    let bend = || combine(&[(1.0, aa), (-2.0, ab), (1.0, bb)]);
    let second = !aa.is_empty();
    let rows = if turn == 1 {
        // (a, b) = (v, 1 - u - v): du = -db, dv = da - db.
        let second = second.then(|| [bb.clone(), combine(&[(1.0, bb), (-1.0, ab)]), bend()]);
        (combine(&[(-1.0, b)]), combine(&[(1.0, a), (-1.0, b)]), second)
    } else {
        // (a, b) = (1 - u - v, u): du = db - da, dv = -da.
        let second = second.then(|| [bend(), combine(&[(1.0, aa), (-1.0, ab)]), aa.clone()]);
        (combine(&[(1.0, b), (-1.0, a)]), combine(&[(-1.0, a)]), second)
    };
    (w.rows[1], w.rows[2]) = (rows.0, rows.1);
    if let Some([uu, uv, vv]) = rows.2 {
        (w.rows[3], w.rows[4], w.rows[5]) = (uu, uv, vv);
    }
    w
}

fn dense(weights: [[f64; 16]; 6], count: usize, points: usize) -> PointWeights {
    let mut out = PointWeights::default();
    for (row, weights) in out.rows.iter_mut().zip(&weights).take(count) {
        *row = weights[..points].to_vec();
    }
    out
}

fn bilinear(u: f64, v: f64) -> PointWeights {
    let (s, t) = (1.0 - u, 1.0 - v);
    let rows = [
        vec![s * t, u * t, u * v, s * v],
        vec![-t, t, v, -v],
        vec![-s, -u, u, s],
        vec![0.0; 4],
        vec![1.0, -1.0, 1.0, -1.0],
        vec![0.0; 4],
    ];
    PointWeights { rows, at_vertex: None }
}

struct Compiler<'a> {
    ring: usize,
    scheme: Scheme,
    specials: &'a SpecialVertices,
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    walk: Walk,
}

/// More levels than `⌈sharpness⌉ + 2` ever needs; reaching it is a defect of the classification.
const DEEPEST: u32 = 16;

impl Compiler<'_> {
    /// Adds the tree of face 0 of `site`; returns its root.
    fn compile(&mut self, site: &Site, depth: u32) -> u32 {
        assert!(depth < DEEPEST, "the patch tree does not end");
        if let Some(leaf) = self.leaf(site) {
            self.leaves.push(leaf);
            self.nodes.push(Node::Leaf(self.leaves.len() as u32 - 1));
        } else {
            let children = self.children(site, &[0, 1, 2, 3]);
            let split: Vec<u32> = children.iter().map(|child| self.compile(child, depth + 1)).collect();
            self.nodes.push(Node::Split([split[0], split[1], split[2], split[3]]));
        }
        self.nodes.len() as u32 - 1
    }

    /// The sites of face 0's children at the given corners.
    fn children(&mut self, site: &Site, corners: &[usize]) -> Vec<Site> {
        let parent = Level::from_topology(site.topology.clone(), self.scheme);
        let refined = parent.refine().expect("surroundings are small");
        let (t, child) = (parent.topology(), refined.topology());
        let mut around = Surroundings::default();
        let mut sum = Accumulator::new(self.ring);
        let mut sites = Vec::with_capacity(corners.len());
        for &c in corners {
            // Face 0's children come first, corner by corner, the middle triangle last.
            let face = Face(c as u32);
            child.surroundings(face, 0, &mut self.walk, &mut around);
            let points = around
                .ring
                .iter()
                .map(|&v| {
                    child_vertex(t, self.scheme, v, &mut |p, w| {
                        site.points[p as usize].iter().for_each(|&(c, x)| sum.add(c, w * x));
                    });
                    sum.take()
                })
                .collect();
            sites.push(Site { topology: child.cut_out(&around), points });
        }
        sites
    }

    /// The leaf that covers face 0, if one does.
    fn leaf(&self, site: &Site) -> Option<Leaf> {
        let t = &site.topology;
        let own: Vec<HalfEdge> = (0..t.sides(Face(0))).map(|c| t.half_edge(Face(0), c)).collect();
        if self.scheme == Scheme::Bilinear {
            let corners: Vec<Combination> = own.iter().map(|&h| vec![(t.origin(h).0, 1.0)]).collect();
            return Some(self.make(site, LeafShape::Bilinear, &corners));
        }
        let split = self.scheme.split();
        if (0..t.face_count() as u32).any(|f| t.sides(Face(f)) != self.scheme.patch_sides()) {
            return None;
        }
        if own.iter().any(|&h| has_finite_sharpness(t, h)) {
            if split == SplitKind::Triangles {
                return None;
            }
            let (side, sharpness) = single_crease_side(t, &own)?;
            // The crease along v = 1 runs between corners 2 and 3 of the turned quad.
            let turn = (side + 2) % 4;
            let grid = grid_points(t, own[turn], false).map(|p| p.expect("a full grid"));
            return Some(self.make(site, LeafShape::SingleCrease { turn: turn as u8, sharpness }, &grid));
        }
        let special: Vec<(usize, Corner)> = own
            .iter()
            .enumerate()
            .map(|(j, &h)| (j, corner(t, h, split).0))
            .filter(|(_, corner)| !corner.is_regular())
            .collect();
        match special[..] {
            [] if split == SplitKind::Triangles => {
                Some(self.make(site, LeafShape::Regular, &triangle_points::patch_points(t, own[0])))
            }
            [] => {
                let grid = grid_points(t, own[0], false).map(|p| p.expect("a full grid"));
                Some(self.make(site, LeafShape::Regular, &grid))
            }
            [(j, corner)] => {
                let vertex = self.specials.get(corner);
                let points = match split {
                    SplitKind::Quads => special_points(t, own[j]),
                    SplitKind::Triangles => triangle_points::special_points(t, own[j]),
                };
                debug_assert_eq!(points.len(), vertex.points());
                Some(self.make(site, LeafShape::Special { turn: j as u8, vertex }, &points))
            }
            _ => None,
        }
    }

    /// A leaf whose control points are combinations of the site's vertices.
    fn make(&self, site: &Site, shape: LeafShape, points: &[Combination]) -> Leaf {
        let over_ring: Vec<Combination> = points
            .iter()
            .map(|point| {
                let terms = |&(v, w): &(u32, f64)| {
                    site.points[v as usize].iter().map(move |&(c, x)| (c, w * x)).collect::<Vec<_>>()
                };
                point.iter().flat_map(terms).collect()
            })
            .collect();
        Leaf { shape, points: Rows::new(self.ring, &over_ring) }
    }
}

fn is_finite_sharpness(s: f64) -> bool {
    s > 0.0 && s < INFINITE_SHARPNESS
}

/// True where sharpness at the origin of `h` will change.
fn has_finite_sharpness(t: &Topology, h: HalfEdge) -> bool {
    let v = t.origin(h);
    is_finite_sharpness(t.vertex_sharpness(v))
        || t.foreign_sharpness(v).iter().any(|&s| is_finite_sharpness(s))
        || t.sharp_edges(v).iter().any(|&e| is_finite_sharpness(t.edge_sharpness(Edge(e))))
}

/// The only sharp side of a quad and its sharpness, where the closed form of one semi-sharp crease holds: both ends are
/// interior, of valence 4, and continued straight with the same sharpness; the opposite side is smooth or infinitely
/// sharp, with regular corners.
fn single_crease_side(t: &Topology, own: &[HalfEdge]) -> Option<(usize, f64)> {
    let sharpness = |h: HalfEdge| t.edge_sharpness(t.edge(h));
    let mut sides = (0..4).filter(|&j| is_finite_sharpness(sharpness(own[j])));
    let side = sides.next().filter(|_| sides.next().is_none())?;
    let s = sharpness(own[side]);
    let [next, opposite, before] = [1, 2, 3].map(|k| own[(side + k) % 4]);
    if sharpness(next) > 0.0 || sharpness(before) > 0.0 {
        return None;
    }
    for end in [own[side], next] {
        let v = t.origin(end);
        let goes_on = t.sharp_edges(v).len() == 2
            && t.vertex_sharpness(v) == 0.0
            && t.foreign_sharpness(v).is_empty()
            && spokes(t, end).is_some_and(|spokes| {
                // Of four spokes the sharp ones must face each other.
                let sharp: Vec<bool> = spokes.iter().map(|&e| t.edge_sharpness(e) == s).collect();
                sharp == [true, false, true, false] || sharp == [false, true, false, true]
            });
        if !goes_on {
            return None;
        }
    }
    for far in [opposite, before] {
        if has_finite_sharpness(t, far) {
            return None;
        }
        let c = corner(t, far, SplitKind::Quads).0;
        let plain = c.kind == Kind::Smooth && c.n == 4;
        let along = c.kind == Kind::Crease && c.n == 2 && t.is_infinitely_sharp(t.edge(opposite));
        if !plain && !along {
            return None;
        }
    }
    Some((side, s))
}

/// The four edges round the origin of `h`, if it is an interior vertex of valence 4.
fn spokes(t: &Topology, h: HalfEdge) -> Option<[Edge; 4]> {
    let a = t.turn_left(h)?;
    let b = t.turn_left(a)?;
    let c = t.turn_left(b)?;
    (t.turn_left(c)? == h && b != h).then(|| [h, a, b, c].map(|h| t.edge(h)))
}
