//! The next level's tables with little of them made: origins and twins of half-edges are listed, in memory that is used
//! again, and all else follows from the parent by index arithmetic when it is asked for. Walks round a few faces of the
//! next level need no more. Numbers are those of [`quad_split`](super::quad_split) and [`tri_split`](super::tri_split),
//! whose drawings name the half-edges.

use super::split::{half, runs_forward};
use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::scheme::SplitKind;
use crate::sharpness::{decay, edge_half, foreign_half, seam_half};
use crate::tags::Rules;
use crate::topology::{EdgeFlags, Interpolation, NONE, Tables, Topology};
use std::borrow::Cow;

/// What [`refined`](super::refined) would return.
pub(crate) struct NextLevel<'a> {
    parent: &'a Topology,
    split: SplitKind,
    half_edges: &'a [(u32, u32)],
}

/// Origin and twin of every half-edge of a next level, or memory for them.
#[derive(Default)]
pub(crate) struct NextHalfEdges(Vec<(u32, u32)>);

impl NextHalfEdges {
    /// Those of the level below `parent`; under Loop all its faces are triangles.
    pub fn list(&mut self, parent: &Topology, split: SplitKind) {
        let next = NextLevel { parent, split, half_edges: &[] };
        self.0.clear();
        self.0.resize(4 * parent.half_edge_count(), (0, NONE));
        let mut put = |run: Run, twin: Option<Run>| {
            let twin = twin.map_or(NONE, |run| next.child(run).0);
            self.0[next.child(run).index()] = (next.run_origin(run).0, twin);
        };
        for h in (0..parent.half_edge_count() as u32).map(HalfEdge) {
            let twin = parent.twin(h);
            put(Run::Out(h), twin.map(|g| Run::In(parent.next(g))));
            put(Run::Across(h), Some(Run::Back(h)));
            put(Run::Back(h), Some(Run::Across(h)));
            put(Run::In(parent.next(h)), twin.map(Run::Out));
        }
    }
}

/// Where a child half-edge runs, `h` being a parent half-edge.
#[derive(Clone, Copy)]
enum Run {
    /// From the origin of `h` along it.
    Out(HalfEdge),
    /// From the new vertex on `h` into the face.
    Across(HalfEdge),
    /// From the face point to the new vertex on `h`; under Loop from the new vertex before `h` to that on `h`, in the
    /// middle triangle.
    Back(HalfEdge),
    /// From the new vertex on `prev h` to the origin of `h`.
    In(HalfEdge),
}

/// What a child edge comes from.
enum Origin {
    /// A half-edge: the edge lies inside a face.
    Inside(HalfEdge),
    /// An edge, and the end at which this is its half.
    Half(Edge, usize),
}

impl<'a> NextLevel<'a> {
    /// The level below `parent`, whose half-edges are listed.
    pub fn new(parent: &'a Topology, split: SplitKind, half_edges: &'a NextHalfEdges) -> Self {
        Self { parent, split, half_edges: &half_edges.0 }
    }

    fn face_points(&self) -> usize {
        match self.split {
            SplitKind::Quads => self.parent.face_count(),
            SplitKind::Triangles => 0,
        }
    }

    #[inline]
    fn edge_point(&self, e: Edge) -> Vertex {
        Vertex((self.parent.vertex_count() + self.face_points()) as u32 + e.0)
    }

    #[inline]
    fn face_point(&self, f: Face) -> Vertex {
        Vertex(self.parent.vertex_count() as u32 + f.0)
    }

    #[inline]
    fn run(&self, child: HalfEdge) -> Run {
        let t = self.parent;
        match self.split {
            SplitKind::Quads => {
                let h = HalfEdge(child.0 / 4);
                match (child.0 + 4 - quad_turn(t, h)) % 4 {
                    0 => Run::Out(h),
                    1 => Run::Across(h),
                    2 => Run::Back(t.prev(h)),
                    _ => Run::In(h),
                }
            }
            SplitKind::Triangles => {
                let (face, place) = (child.0 / 12, child.0 % 12);
                let (c, j) = (place / 3, place % 3);
                let h = |c: u32| HalfEdge(3 * face + c % 3);
                match (c, (j + 3 - c) % 3) {
                    (3, _) => Run::Back(h(j + 2)),
                    (_, 0) => Run::Out(h(c)),
                    (_, 1) => Run::Across(h(c)),
                    _ => Run::In(h(c)),
                }
            }
        }
    }

    #[inline]
    fn run_origin(&self, run: Run) -> Vertex {
        let t = self.parent;
        match (run, self.split) {
            (Run::Out(h), _) => t.origin(h),
            (Run::Across(h), _) => self.edge_point(t.edge(h)),
            (Run::Back(h), SplitKind::Quads) => self.face_point(t.face(h)),
            (Run::Back(h), SplitKind::Triangles) | (Run::In(h), _) => self.edge_point(t.edge(t.prev(h))),
        }
    }

    #[inline]
    fn child(&self, run: Run) -> HalfEdge {
        let t = self.parent;
        HalfEdge(match self.split {
            SplitKind::Quads => {
                let at = |h: HalfEdge, k: u32| 4 * h.0 + (quad_turn(t, h) + k) % 4;
                match run {
                    Run::Out(h) => at(h, 0),
                    Run::Across(h) => at(h, 1),
                    Run::Back(h) => at(t.next(h), 2),
                    Run::In(h) => at(h, 3),
                }
            }
            SplitKind::Triangles => {
                let at = |h: HalfEdge, k: u32| 12 * (h.0 / 3) + 3 * (h.0 % 3) + (h.0 % 3 + k) % 3;
                match run {
                    Run::Out(h) => at(h, 0),
                    Run::Across(h) => at(h, 1),
                    Run::Back(h) => 12 * (h.0 / 3) + 9 + (h.0 % 3 + 1) % 3,
                    Run::In(h) => at(h, 2),
                }
            }
        })
    }

    fn edge_origin(&self, e: Edge) -> Origin {
        let inside = self.parent.half_edge_count();
        match e.index().checked_sub(inside) {
            None => Origin::Inside(HalfEdge(e.0)),
            Some(k) => Origin::Half(Edge((k / 2) as u32), k % 2),
        }
    }

    /// The edge of whose new vertex `v` is, if it is one.
    fn edge_of_point(&self, v: Vertex) -> Option<Edge> {
        let first = self.edge_point(Edge(0)).0;
        v.0.checked_sub(first).map(Edge)
    }

    fn half_sharpness(&self, e: Edge, end: usize) -> f64 {
        edge_half(self.parent, e, self.parent.edge_vertices(e)[end])
    }
}

/// Corner of the child at the origin of `h` that holds the old vertex.
#[inline]
fn quad_turn(t: &Topology, h: HalfEdge) -> u32 {
    let face = t.face(h);
    if t.sides(face) == 4 { h.0 - t.first(face) } else { 0 }
}

impl Tables for NextLevel<'_> {
    fn vertex_count(&self) -> usize {
        self.edge_point(Edge(self.parent.edge_count() as u32)).index()
    }
    fn rules(&self) -> &Rules {
        self.parent.rules()
    }
    fn interpolation(&self) -> Interpolation {
        self.parent.interpolation
    }
    fn sides(&self, _: Face) -> usize {
        match self.split {
            SplitKind::Quads => 4,
            SplitKind::Triangles => 3,
        }
    }
    fn half_edge(&self, face: Face, corner: usize) -> HalfEdge {
        HalfEdge((face.index() * self.sides(face) + corner) as u32)
    }
    fn face(&self, h: HalfEdge) -> Face {
        match self.split {
            SplitKind::Quads => Face(h.0 / 4),
            SplitKind::Triangles => Face(h.0 / 3),
        }
    }
    #[inline]
    fn origin(&self, h: HalfEdge) -> Vertex {
        Vertex(self.half_edges[h.index()].0)
    }
    fn edge(&self, h: HalfEdge) -> Edge {
        let t = self.parent;
        let inside = t.half_edge_count();
        Edge(match self.run(h) {
            Run::Out(h) => half(inside, t.edge(h), !runs_forward(t, h)),
            Run::Across(h) | Run::Back(h) => h.0,
            Run::In(h) => {
                let prev = t.prev(h);
                half(inside, t.edge(prev), runs_forward(t, prev))
            }
        })
    }
    #[inline]
    fn twin(&self, h: HalfEdge) -> Option<HalfEdge> {
        let twin = self.half_edges[h.index()].1;
        (twin != NONE).then_some(HalfEdge(twin))
    }
    #[inline]
    fn next(&self, h: HalfEdge) -> HalfEdge {
        match self.split {
            SplitKind::Quads => HalfEdge(h.0 & !3 | (h.0 + 1) & 3),
            SplitKind::Triangles => HalfEdge(if h.0 % 3 == 2 { h.0 - 2 } else { h.0 + 1 }),
        }
    }
    #[inline]
    fn prev(&self, h: HalfEdge) -> HalfEdge {
        match self.split {
            SplitKind::Quads => HalfEdge(h.0 & !3 | (h.0 + 3) & 3),
            SplitKind::Triangles => HalfEdge(if h.0.is_multiple_of(3) { h.0 + 2 } else { h.0 - 1 }),
        }
    }
    fn edge_vertices(&self, e: Edge) -> [Vertex; 2] {
        let t = self.parent;
        match (self.edge_origin(e), self.split) {
            (Origin::Half(e, end), _) => [self.edge_point(e), t.edge_vertices(e)[end]],
            (Origin::Inside(h), SplitKind::Quads) => [self.face_point(t.face(h)), self.edge_point(t.edge(h))],
            (Origin::Inside(h), SplitKind::Triangles) => [h, t.prev(h)].map(|h| self.edge_point(t.edge(h))),
        }
    }
    fn edge_flags(&self, e: Edge) -> EdgeFlags {
        match self.edge_origin(e) {
            Origin::Inside(_) => EdgeFlags::default(),
            Origin::Half(e, _) => self.parent.edge_flags[e.index()],
        }
    }
    fn edge_sharpness(&self, e: Edge) -> f64 {
        match self.edge_origin(e) {
            Origin::Inside(_) => 0.0,
            Origin::Half(e, end) => self.half_sharpness(e, end),
        }
    }
    fn vertex_sharpness(&self, v: Vertex) -> f64 {
        if v.index() < self.parent.vertex_count() { decay(self.parent.vertex_sharpness(v)) } else { 0.0 }
    }
    fn is_non_manifold_vertex(&self, v: Vertex) -> bool {
        let t = self.parent;
        match self.edge_of_point(v) {
            Some(e) => t.is_non_manifold_edge(e),
            None => v.index() < t.vertex_count() && t.is_non_manifold_vertex(v),
        }
    }
    fn sharp_edges(&self, v: Vertex) -> impl Iterator<Item = Edge> {
        let t = self.parent;
        let is_old = v.index() < t.vertex_count();
        let old = if is_old { t.sharp_edges(v) } else { &[] };
        let at_old = old.iter().flat_map(move |&e| [(Edge(e), 0), (Edge(e), 1)]);
        let at_old = at_old.filter(move |&(e, end)| t.edge_vertices(e)[end] == v);
        let new = self.edge_of_point(v).into_iter().flat_map(|e| [(e, 0), (e, 1)]);
        let sharp = at_old.chain(new).filter(|&(e, end)| self.half_sharpness(e, end) > 0.0);
        sharp.map(|(e, end)| Edge(half(t.half_edge_count(), e, end == 1)))
    }
    fn foreign_sharpness(&self, v: Vertex) -> Cow<'_, [f64]> {
        let known = self.parent.foreign_sharpness.contains_key(&v.0);
        Cow::Owned(if known { foreign_half(self.parent, v) } else { Vec::new() })
    }
    fn across_seam(&self, v: Vertex) -> Cow<'_, [f64]> {
        let known = self.parent.across_seam.contains_key(&v.0);
        Cow::Owned(if known { seam_half(self.parent, v) } else { Vec::new() })
    }
    fn far_half(&self, _: Edge, _: Vertex) -> Option<f64> {
        // A new vertex on an edge has no sharp edges but the edge's halves, and this level holds both.
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refine::refined;
    use crate::scheme::Scheme;
    use crate::shapes;

    #[test]
    fn the_tables_are_those_that_refinement_makes() {
        let mut half_edges = NextHalfEdges::default();
        for shape in shapes::all().into_iter().chain(shapes::all_triangles()).chain([shapes::pillow()]) {
            for scheme in [Scheme::CatmullClark, Scheme::Loop] {
                if scheme == Scheme::Loop && shape.mesh.faces().any(|f| f.len() != 3) {
                    continue;
                }
                let mut parent = Topology::new(&shape.mesh).unwrap();
                for _ in 0..2 {
                    let made = refined(&parent, scheme);
                    half_edges.list(&parent, scheme.split());
                    check(&NextLevel::new(&parent, scheme.split(), &half_edges), &made, &shape.name);
                    parent = made;
                }
            }
        }
    }

    fn check(next: &NextLevel<'_>, made: &Topology, name: &str) {
        assert_eq!(next.vertex_count(), made.vertex_count(), "{name}");
        for h in (0..made.half_edge_count() as u32).map(HalfEdge) {
            assert_eq!(next.face(h), made.face(h), "{name} {h}");
            assert_eq!(next.origin(h), made.origin(h), "{name} {h}");
            assert_eq!(next.edge(h), made.edge(h), "{name} {h}");
            assert_eq!(next.twin(h), made.twin(h), "{name} {h}");
            assert_eq!((next.next(h), next.prev(h)), (made.next(h), made.prev(h)), "{name} {h}");
        }
        for e in (0..made.edge_count() as u32).map(Edge) {
            assert_eq!(next.edge_vertices(e), made.edge_vertices(e), "{name} {e}");
            assert_eq!(next.edge_flags(e), made.edge_flags[e.index()], "{name} {e}");
            assert_eq!(next.edge_sharpness(e), made.edge_sharpness(e), "{name} {e}");
        }
        for v in (0..made.vertex_count() as u32).map(Vertex) {
            assert_eq!(next.vertex_sharpness(v), made.vertex_sharpness(v), "{name} {v}");
            assert_eq!(next.is_non_manifold_vertex(v), made.is_non_manifold_vertex(v), "{name} {v}");
            let sharp: Vec<u32> = next.sharp_edges(v).map(|e| e.0).collect();
            assert_eq!(sharp, made.sharp_edges(v), "{name} {v}");
        }
        (0..made.face_count() as u32).for_each(|f| assert_eq!(next.sides(Face(f)), made.sides(Face(f)), "{name}"));
    }
}
