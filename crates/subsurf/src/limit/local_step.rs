//! The local subdivision step at a special vertex: the matrix `A` from the control points of one face there to those of
//! its child at the vertex, and the control points `X_c` of the three regular children, as combinations of the same
//! points. Both are read off the refinement masks, run once on a mesh that has nothing but the vertex's neighbourhood.
//! The four children have most of their points in common: every point is one row, which the children share.

use super::corner::{Corner, Kind, grid_points, special_points};
use super::rows::{Accumulator, Combination, Rows};
use super::triangle_points;
use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::mask::{Mask, edge_mask, vertex_mask};
use crate::mesh::ControlMesh;
use crate::refine::{Level, NextHalfEdges, NextLevel};
use crate::scheme::{Scheme, SplitKind};
use crate::tags::{Boundary, Corner as CornerTag, Crease, INFINITE_SHARPNESS, Rules, Tags};
use crate::topology::{NONE, Tables, Topology};
use std::sync::Arc;

/// How many faces on either side of a face its points beyond the ring depend on, sharp spokes included.
const REACH: u32 = 2;

/// `A` and `X_1 X_2 X_3` over the points of [`special_points`].
#[derive(Clone, Debug)]
pub(crate) struct LocalStep {
    /// Number of points `K`.
    pub points: usize,
    /// How many of them belong to the ring of the vertex.
    pub ring: usize,
    /// The first rows of `A`, those of the ring: where these count from a sharp edge, all faces have the same.
    inner: Arc<Rows>,
    /// The other rows of `A`, and behind them what else the regular children need.
    outer: Rows,
    /// Which rows `X_1 X_2 X_3` are, one matrix after the other: 16 each, child `c` being the quadrant at the face's corner `c`;
    /// 12 each under Loop, where child 3 is the middle.
    x: Box<[u32]>,
}

impl LocalStep {
    pub fn new(special: Corner) -> Self {
        let (neighbourhood, face) = Neighbourhood::of(special);
        neighbourhood.step(face, None)
    }

    /// Those of all faces at a dart of valence `n`, which have most of their neighbourhoods in common.
    pub fn all_at_dart(split: SplitKind, n: u32) -> Vec<Self> {
        let round_all = (split == SplitKind::Quads).then(|| {
            let (mesh, ring) = dart_neighbourhood(n);
            Neighbourhood::new(&mesh, Scheme::CatmullClark, ring)
        });
        let mut all = Vec::<Self>::with_capacity(n as usize);
        for i in 0..n {
            let inner = all.first().map(|first| &first.inner);
            let step = match &round_all {
                Some(neighbourhood) => neighbourhood.step(i, inner),
                None => {
                    let (neighbourhood, face) = Neighbourhood::of(Corner { split, kind: Kind::Dart, n, i });
                    neighbourhood.step(face, inner)
                }
            };
            all.push(step);
        }
        all
    }

    /// That of another face at the vertex of this one, where faces count from a sharp edge.
    pub fn of_other_face(&self, special: Corner) -> Self {
        let Corner { n, i, .. } = special;
        if i < REACH || i + REACH >= n || n < Self::MODEL.0 {
            let (neighbourhood, face) = Neighbourhood::of(special);
            return neighbourhood.step(face, Some(&self.inner));
        }
        self.moved(special)
    }

    /// Valence and face of a step from which those of other faces far from sharp edges are taken.
    const MODEL: (u32, u32) = (2 * REACH + 5, REACH + 2);

    /// That of a face without a sharp edge nearby: what lies beyond the ring does not depend on the valence, and is the same as
    /// seen from all such faces.
    fn moved(&self, special: Corner) -> Self {
        let (n, i) = Self::MODEL;
        let model = Self::new(Corner { n, i, ..special });
        let per_face = if special.split == SplitKind::Quads { 2 } else { 1 };
        let (back, forth) = (i * per_face, special.i * per_face);
        let (ring, small) = (self.ring as u32, model.ring as u32);
        let point = |p: u32| match p {
            0 => 0,
            p if p < small => p + forth - back,
            p => p - small + ring,
        };
        let points = model.points - model.ring + self.ring;
        let outer = model.outer.renumbered(points, point);
        let x = model.x.iter().map(|&p| point(p)).collect();
        Self { points, ring: self.ring, inner: self.inner.clone(), outer, x }
    }

    /// Row `i`: of `A` where that has so many.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let (columns, weights) = self.terms(i);
        columns.iter().copied().zip(weights.iter().copied())
    }

    /// The same as columns and weights.
    #[inline(always)]
    pub fn terms(&self, i: usize) -> (&[u32], &[f64]) {
        if i < self.ring { self.inner.terms(i) } else { self.outer.terms(i - self.ring) }
    }

    /// `out += left · A`.
    pub fn left_multiply(&self, left: &[f64], out: &mut [f64]) {
        let (on_ring, beyond) = left.split_at(self.ring);
        self.inner.left_multiply(on_ring, out);
        self.outer.left_multiply(beyond, out);
    }

    /// The rows of the control points of child `index + 1`.
    pub fn child(&self, index: usize) -> &[u32] {
        let points = self.x.len() / 3;
        &self.x[index * points..(index + 1) * points]
    }

    /// `out += left · X_c` for child `c = index + 1`.
    pub fn left_multiply_child(&self, index: usize, left: &[f64], out: &mut [f64]) {
        for (&i, &w) in self.child(index).iter().zip(left) {
            if w != 0.0 {
                self.row(i as usize).for_each(|(c, x)| out[c as usize] += w * x);
            }
        }
    }

    /// All of `A`, row-major.
    pub fn dense(&self) -> Vec<f64> {
        let mut a = vec![0.0; self.points * self.points];
        for (i, out) in a.chunks_exact_mut(self.points).enumerate() {
            self.row(i).for_each(|(c, w)| out[c as usize] = w);
        }
        a
    }

    /// Heap memory in bytes, the ring's rows left out.
    pub fn bytes(&self) -> usize {
        self.outer.bytes() + size_of_val(&self.x[..])
    }

    /// That of the ring's rows.
    pub fn ring_bytes(&self) -> usize {
        self.inner.bytes()
    }
}

/// The mesh of a special vertex, and what the level below is read off.
struct Neighbourhood {
    level: Level,
    half_edges: NextHalfEdges,
    /// Number of points of the ring.
    ring: usize,
}

impl Neighbourhood {
    /// That of one face at a special vertex, and the face's number.
    fn of(special: Corner) -> (Self, u32) {
        match special {
            Corner { split: SplitKind::Triangles, n: 2, kind, i } if kind.is_closed() => {
                let (level, face, ring) = two_triangles(kind, i);
                (Self::at(level, ring), face)
            }
            Corner { split: SplitKind::Quads, i, .. } => {
                let (mesh, ring) = quad_neighbourhood(special);
                (Self::new(&mesh, Scheme::CatmullClark, ring), i)
            }
            Corner { split: SplitKind::Triangles, i, .. } => {
                let (mesh, ring) = triangle_neighbourhood(special);
                (Self::new(&mesh, Scheme::Loop, ring), i)
            }
        }
    }

    fn new(mesh: &ControlMesh, scheme: Scheme, ring: usize) -> Self {
        Self::at(Level::new(mesh, scheme).expect("the neighbourhood is a mesh"), ring)
    }

    fn at(level: Level, ring: usize) -> Self {
        let mut half_edges = NextHalfEdges::default();
        half_edges.list(level.topology(), level.scheme().split());
        Self { level, half_edges, ring }
    }

    /// The step in a face; `inner` are the ring's rows, if they are known.
    fn step(&self, own: u32, inner: Option<&Arc<Rows>>) -> LocalStep {
        let (t, scheme) = (self.level.topology(), self.level.scheme());
        let split = scheme.split();
        let order = canonical(t, t.half_edge(Face(own), 0), split);
        let points = order.len();
        // Canonical position of every vertex of the mesh.
        let mut position = vec![NONE; t.vertex_count()];
        for (k, point) in order.iter().enumerate() {
            let [(v, _)] = point[..] else { unreachable!("the neighbourhood has no extrapolated points") };
            position[v as usize] = k as u32;
        }
        let child = NextLevel::new(t, split, &self.half_edges);
        // Children are numbered four to a face; corner c of child c < 4 (3 under Loop) is the old vertex.
        let first = |c: u32| child.half_edge(Face(4 * own + c), 0);
        let below: Vec<u32> = canonical(&child, first(0), split)
            .iter()
            .map(|point| if let [(v, _)] = point[..] { v } else { unreachable!("nor has the one below") })
            .collect();
        let (on_ring, beyond) = below.split_at(self.ring);
        let mut rows = ChildRows::new(t, scheme, &position, points, child.vertex_count());
        rows.inner = match inner {
            Some(inner) => {
                on_ring.iter().zip(0..).for_each(|(&v, k)| rows.known[v as usize] = k);
                inner.clone()
            }
            None => {
                on_ring.iter().for_each(|&v| rows.push(v));
                Arc::new(std::mem::replace(&mut rows.outer, Rows::empty(points)).shrunk())
            }
        };
        beyond.iter().for_each(|&v| rows.push(v));
        let mut x = Vec::with_capacity(48);
        for c in 1..4 {
            if split == SplitKind::Quads {
                let grid = grid_points(&child, first(c), false);
                x.extend(grid.iter().map(|p| rows.row(p.as_ref().expect("a full grid"))));
            } else {
                x.extend(triangle_points::patch_points(&child, first(c)).iter().map(|p| rows.row(p)));
            }
        }
        let ChildRows { inner, outer, .. } = rows;
        LocalStep { points, ring: self.ring, inner, outer: outer.shrunk(), x: x.into() }
    }
}

/// Points of the level below over the canonical points, one row each.
struct ChildRows<'a> {
    parent: &'a Topology,
    scheme: Scheme,
    /// Canonical position of every vertex of the parent.
    position: &'a [u32],
    /// Those of the ring, once they are known, and all others.
    inner: Arc<Rows>,
    outer: Rows,
    /// Row of every vertex of the level below, or [`NONE`].
    known: Vec<u32>,
    sum: Accumulator,
    mask: Mask,
}

impl<'a> ChildRows<'a> {
    fn new(parent: &'a Topology, scheme: Scheme, position: &'a [u32], points: usize, vertices: usize) -> Self {
        let (known, sum) = (vec![NONE; vertices], Accumulator::new(points));
        let (inner, outer) = (Arc::new(Rows::empty(points)), Rows::empty(points));
        Self { parent, scheme, position, inner, outer, known, sum, mask: Mask::default() }
    }

    /// Number of rows.
    fn len(&self) -> usize {
        self.inner.len() + self.outer.len()
    }

    /// Adds the row of a vertex.
    fn push(&mut self, v: u32) {
        self.known[v as usize] = self.len() as u32;
        let Self { parent, scheme, position, outer, sum, mask, .. } = self;
        child_vertex_by(parent, *scheme, v, mask, &mut |parent, w| {
            let p = position[parent as usize];
            assert!(p != NONE, "vertex {parent} lies outside the neighbourhood");
            sum.add(p, w);
        });
        outer.push(sum);
    }

    /// The row of a point, which is made where it is not known.
    fn row(&mut self, point: &Combination) -> u32 {
        for &(v, _) in &point[..] {
            if self.known[v as usize] == NONE {
                self.push(v);
            }
        }
        if let [(v, _)] = point[..] {
            return self.known[v as usize];
        }
        let number = self.len() as u32;
        let Self { inner, outer, known, sum, .. } = self;
        for &(v, w) in &point[..] {
            let row = known[v as usize] as usize;
            let terms = if row < inner.len() { inner.row(row) } else { outer.row(row - inner.len()) };
            terms.for_each(|(p, x)| sum.add(p, w * x));
        }
        outer.push(sum);
        number
    }
}

/// The control points of the face at the special vertex where `h` starts.
fn canonical(t: &impl Tables, h: HalfEdge, split: SplitKind) -> Vec<Combination> {
    match split {
        SplitKind::Quads => special_points(t, h),
        SplitKind::Triangles => triangle_points::special_points(t, h),
    }
}

/// Terms of child vertex `v` over the vertices of its parent level.
pub(crate) fn child_vertex(t: &Topology, scheme: Scheme, v: u32, term: &mut dyn FnMut(u32, f64)) {
    child_vertex_by(t, scheme, v, &mut Mask::default(), term);
}

/// The same with memory for the mask.
pub(crate) fn child_vertex_by(
    t: &Topology,
    scheme: Scheme,
    v: u32,
    mask: &mut Mask,
    term: &mut (impl FnMut(u32, f64) + ?Sized),
) {
    mask.clear();
    let vertices = t.vertex_count() as u32;
    let faces = if scheme.split() == SplitKind::Quads { t.face_count() as u32 } else { 0 };
    if v < vertices {
        vertex_mask(t, scheme, Vertex(v), mask);
    } else if v < vertices + faces {
        mask.face(Face(v - vertices), 1.0);
    } else {
        edge_mask(t, scheme, Edge(v - vertices - faces), mask);
    }
    mask.vertices.iter().for_each(|&(p, w)| term(p, w));
    for &(f, w) in &mask.faces {
        let corners = t.face_vertices(Face(f));
        corners.iter().for_each(|&p| term(p, w / corners.len() as f64));
    }
}

/// The mesh of one special vertex: its faces, and the outer layer round face `i`. Vertices come in canonical order,
/// then those that only close the mesh. Returns the number of ring points too.
pub(super) fn quad_neighbourhood(Corner { kind, n, i, .. }: Corner) -> (ControlMesh, usize) {
    let closed = kind.is_closed();
    let spokes = if closed { n } else { n + 1 };
    let spoke = |j: u32| 1 + 2 * (j % spokes);
    let diagonal = |j: u32| 2 + 2 * (j % n);
    let ring = 1 + spokes + n;
    let mut next = ring;
    let mut new = || {
        next += 1;
        next - 1
    };
    let mut faces: Vec<[u32; 4]> = (0..n).map(|j| [0, spoke(j), diagonal(j), spoke(j + 1)]).collect();
    let [sharp_u, sharp_v] = [i == 0, i + 1 == n].map(|end| end && !matches!(kind, Kind::Smooth | Kind::Pinned));
    let (a, f, b) = (spoke(i), diagonal(i), spoke(i + 1));
    let below = (!sharp_u).then(&mut new);
    let [p20, p21, p22, p12, p02] = std::array::from_fn(|_| new());
    let above = (!sharp_v).then(&mut new);
    faces.extend([[a, p20, p21, f], [f, p21, p22, p12], [f, p12, p02, b]]);
    if let Some(p) = below {
        faces.push([a, diagonal(i + n - 1), p, p20]);
    }
    if let Some(p) = above {
        faces.push([b, p02, p, diagonal(i + 1)]);
    }
    let mut tags = vertex_tags(kind, spoke(0));
    // A dart's crease goes on beyond e_0 where the face touches it, with one more face behind it.
    if kind == Kind::Dart && sharp_u {
        tags.creases.push(Crease::new(a, p20, INFINITE_SHARPNESS));
        faces.push([a, diagonal(n - 1), new(), p20]);
    }
    if kind == Kind::Dart && sharp_v {
        tags.creases.push(Crease::new(b, p02, INFINITE_SHARPNESS));
        faces.push([b, p02, new(), diagonal(0)]);
    }
    let counts = vec![4; faces.len()];
    let mesh = ControlMesh::from_counts(next as usize, &counts, faces.concat(), tags).expect("a valid mesh");
    (mesh, ring as usize)
}

/// The mesh of a dart of `n` faces with the outer layers round all of them: the ring first, then for every face `j` the point
/// straight beyond `e_j` and three round `f_j`. Returns the number of ring points too.
fn dart_neighbourhood(n: u32) -> (ControlMesh, usize) {
    let ring = 1 + 2 * n;
    let spoke = |j: u32| 1 + 2 * (j % n);
    let beyond = |j: u32| ring + 4 * (j % n);
    // The faces at the dart come first.
    let mut faces: Vec<[u32; 4]> = (0..n).map(|j| [0, spoke(j), spoke(j) + 1, spoke(j + 1)]).collect();
    for j in 0..n {
        let (a, f, b) = (spoke(j), spoke(j) + 1, spoke(j + 1));
        let [p20, p21, p22, p12] = [0, 1, 2, 3].map(|k| beyond(j) + k);
        faces.extend([[a, p20, p21, f], [f, p21, p22, p12], [f, p12, beyond(j + 1), b]]);
    }
    let mut tags = vertex_tags(Kind::Dart, spoke(0));
    tags.creases.push(Crease::new(spoke(0), beyond(0), INFINITE_SHARPNESS));
    let counts = vec![4; faces.len()];
    let vertices = (ring + 4 * n) as usize;
    let mesh = ControlMesh::from_counts(vertices, &counts, faces.concat(), tags).expect("a valid mesh");
    (mesh, ring as usize)
}

/// Tags that make vertex 0 what it is; `first` is the end of `e_0`.
fn vertex_tags(kind: Kind, first: u32) -> Tags {
    let mut tags = Tags { rules: Rules { boundary: Boundary::EdgeOnly, ..Rules::default() }, ..Tags::default() };
    match kind {
        Kind::Corner | Kind::Pinned => tags.corners.push(CornerTag::new(0, INFINITE_SHARPNESS)),
        Kind::Dart => tags.creases.push(Crease::new(0, first, INFINITE_SHARPNESS)),
        Kind::Smooth | Kind::Crease => {}
    }
    tags
}

/// Two triangles round one vertex: their ends are joined by two different edges, which no list of faces can say, but
/// the second level of two triangles back to back has. The points beyond are one: `c` and `g` coincide, and the weights
/// are all on the latter.
fn two_triangles(kind: Kind, i: u32) -> (Level, u32, usize) {
    let pillow = ControlMesh::new(&[[0, 1, 2], [0, 2, 1]], vertex_tags(kind, 1)).expect("a valid mesh");
    let mut level = Level::new(&pillow, Scheme::Loop).expect("two triangles");
    for _ in 0..2 {
        level = level.refine().expect("two triangles stay few");
    }
    // The first child of the first child of triangle i.
    (level, 16 * i, 3)
}

/// The same for triangles.
fn triangle_neighbourhood(Corner { kind, n, i, .. }: Corner) -> (ControlMesh, usize) {
    let closed = kind.is_closed();
    let spokes = if closed { n } else { n + 1 };
    let spoke = |j: u32| 1 + j % spokes;
    let ring = 1 + spokes;
    let mut next = ring;
    let mut new = || {
        next += 1;
        next - 1
    };
    let mut faces: Vec<[u32; 3]> = (0..n).map(|j| [0, spoke(j), spoke(j + 1)]).collect();
    let [sharp_u, sharp_v] = [i == 0, i + 1 == n].map(|end| end && !matches!(kind, Kind::Smooth | Kind::Pinned));
    let (p, q) = (spoke(i), spoke(i + 1));
    let c = (!sharp_u).then(&mut new);
    let [b, m, d] = std::array::from_fn(|_| new());
    let g = (!sharp_v).then(&mut new);
    faces.extend([[p, b, m], [p, m, q], [q, m, d]]);
    if let Some(c) = c {
        faces.extend([[p, spoke(i + spokes - 1), c], [p, c, b]]);
    }
    if let Some(g) = g {
        faces.extend([[q, d, g], [q, g, spoke(i + 2)]]);
    }
    let mut tags = vertex_tags(kind, spoke(0));
    if kind == Kind::Dart && sharp_u {
        let behind = new();
        tags.creases.push(Crease::new(p, b, INFINITE_SHARPNESS));
        faces.extend([[p, spoke(n - 1), behind], [p, behind, b]]);
    }
    if kind == Kind::Dart && sharp_v {
        let behind = new();
        tags.creases.push(Crease::new(q, d, INFINITE_SHARPNESS));
        faces.extend([[q, d, behind], [q, behind, spoke(1)]]);
    }
    let counts = vec![3; faces.len()];
    let mesh = ControlMesh::from_counts(next as usize, &counts, faces.concat(), tags).expect("a valid mesh");
    (mesh, ring as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_keeps_constants_and_the_ring_to_itself() {
        for split in [SplitKind::Quads, SplitKind::Triangles] {
            for kind in [Kind::Smooth, Kind::Dart, Kind::Crease, Kind::Corner, Kind::Pinned] {
                let least = if kind.is_closed() { 2 } else { 1 };
                for n in least..12 {
                    for i in 0..if matches!(kind, Kind::Smooth | Kind::Pinned) { 1 } else { n } {
                        keeps_constants(LocalStep::new(Corner { split, kind, n, i }));
                    }
                }
            }
        }
    }

    #[test]
    fn all_faces_at_a_dart_have_the_steps_that_they_have_alone() {
        for (split, n) in
            [SplitKind::Quads, SplitKind::Triangles].into_iter().flat_map(|s| (2..12).map(move |n| (s, n)))
        {
            let all = LocalStep::all_at_dart(split, n);
            for (i, step) in (0..).zip(&all) {
                let alone = LocalStep::new(Corner { split, kind: Kind::Dart, n, i });
                assert_eq!((step.points, step.ring, &step.x), (alone.points, alone.ring, &alone.x));
                for (rows, others) in [(&*step.inner, &*alone.inner), (&step.outer, &alone.outer)] {
                    assert!(rows.is_like(others) && rows.weights() == others.weights(), "{n} {i}");
                }
            }
        }
    }

    #[test]
    fn faces_far_from_sharp_edges_have_steps_that_are_moved() {
        for (split, kind) in [SplitKind::Quads, SplitKind::Triangles]
            .into_iter()
            .flat_map(|s| [Kind::Dart, Kind::Crease, Kind::Corner].map(|kind| (s, kind)))
        {
            for n in (LocalStep::MODEL.0..16).chain([40]) {
                let first = LocalStep::new(Corner { split, kind, n, i: 0 });
                for i in 0..n {
                    let special = Corner { split, kind, n, i };
                    let (other, alone) = (first.of_other_face(special), LocalStep::new(special));
                    assert_eq!((other.points, other.ring, &other.x), (alone.points, alone.ring, &alone.x));
                    for (rows, others) in [(&*other.inner, &*alone.inner), (&other.outer, &alone.outer)] {
                        assert!(rows.is_like(others) && rows.weights() == others.weights(), "{special:?}");
                    }
                }
            }
        }
    }

    fn keeps_constants(step: LocalStep) {
        let rounding = step.points as f64 * f64::EPSILON;
        let is_one = |k: usize| (step.row(k).map(|t| t.1).sum::<f64>() - 1.0).abs() < rounding;
        for k in 0..step.ring + step.outer.len() {
            assert!(is_one(k));
            assert!(k >= step.ring || step.row(k).all(|t| (t.0 as usize) < step.ring));
        }
    }
}
