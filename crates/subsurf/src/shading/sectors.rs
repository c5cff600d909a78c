//! Where fields of normals and weights part: at every vertex, the faces between two consecutive cut edges are a sector,
//! and a sector has values of its own. Edges are cut from a chosen sharpness on; boundaries and non-manifold edges always.
//!
//! Values are numbered so that the first sector of vertex v is value v and further sectors follow after all vertices; a
//! mesh without cuts has the numbers of its vertices.

use crate::index::{Edge, HalfEdge, Vertex};
use crate::scheme::{Scheme, SplitKind};
use crate::tags::INFINITE_SHARPNESS;
use crate::topology::{NONE, Topology};

/// The sectors of a control mesh.
pub(super) struct Sectors {
    /// Value at every face corner.
    pub corner: Vec<u32>,
    /// Vertex of every value.
    pub vertex: Vec<u32>,
    /// Per value: extraordinary, that is, of another number of faces than splines have there.
    pub extraordinary: Vec<bool>,
    /// Per value: the faces go all the way round, and no edge between them is cut.
    pub interior: Vec<bool>,
    /// Per value: the limit normal must stay (semi-sharp features from the cut on, cone points, creases of one edge).
    pub locked: Vec<bool>,
}

/// One sector: its half-edges counter-clockwise, and whether it is closed without a cut.
struct Sector {
    faces: Vec<HalfEdge>,
    shape: Shape,
}

#[derive(Clone, Copy, PartialEq)]
enum Shape {
    /// All round the vertex.
    Closed,
    /// All round, from a cut edge to itself.
    Dart,
    /// From a cut edge to another.
    Open,
}

impl Sectors {
    /// The sectors of `t`, whose edges are cut where their sharpness is at least `cut`.
    pub fn new(t: &Topology, scheme: Scheme, cut: f64) -> Self {
        // Infinitely sharp edges cut in any case.
        let cut = cut.min(INFINITE_SHARPNESS);
        let mut out = Self {
            corner: vec![NONE; t.half_edge_count()],
            vertex: (0..t.vertex_count() as u32).collect(),
            extraordinary: vec![false; t.vertex_count()],
            interior: vec![false; t.vertex_count()],
            locked: vec![false; t.vertex_count()],
        };
        let mut has_sector = vec![false; t.vertex_count()];
        for h in (0..t.half_edge_count() as u32).map(HalfEdge) {
            if out.corner[h.index()] != NONE {
                continue;
            }
            let v = t.origin(h);
            let sector = Sector::of(t, h, cut);
            let mut value = v.0;
            if std::mem::replace(&mut has_sector[v.index()], true) {
                value = out.vertex.len() as u32;
                out.vertex.push(v.0);
                for list in [&mut out.extraordinary, &mut out.interior, &mut out.locked] {
                    list.push(false);
                }
            }
            sector.faces.iter().for_each(|h| out.corner[h.index()] = value);
            let value = value as usize;
            let rule = Rule::of(t, v, cut);
            out.locked[value] = rule.is_locked || (rule.is_pinned && sector.shape != Shape::Open);
            out.interior[value] = sector.shape == Shape::Closed;
            out.extraordinary[value] = !out.locked[value] && sector.faces.len() != regular(scheme, sector.shape, rule);
        }
        out.lock_whole_creases(t, cut);
        out
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        self.vertex.len()
    }

    /// True where some vertex has several values.
    pub fn is_parted(&self, t: &Topology) -> bool {
        self.len() > t.vertex_count()
    }

    /// A cut edge that parts no values (a crease of a single edge: each end is one sector) has one normal for both sides;
    /// blending must leave it alone.
    fn lock_whole_creases(&mut self, t: &Topology, cut: f64) {
        for h in (0..t.half_edge_count() as u32).map(HalfEdge) {
            let Some(twin) = t.twin(h).filter(|_| t.edge_sharpness(t.edge(h)) >= cut) else { continue };
            let ends = [h, t.next(h)].map(|h| self.corner[h.index()]);
            if ends == [t.next(twin), twin].map(|h| self.corner[h.index()]) {
                for value in ends {
                    self.locked[value as usize] = true;
                    self.extraordinary[value as usize] = false;
                }
            }
        }
    }
}

impl Sector {
    /// The sector of the face corner `h`.
    fn of(t: &Topology, h: HalfEdge, cut: f64) -> Self {
        let is_cut = |h: HalfEdge| t.edge_sharpness(t.edge(h)) >= cut;
        let mut first = h;
        let mut shape = Shape::Open;
        while !is_cut(first) {
            match t.turn_right(first) {
                Some(next) if next != h => first = next,
                Some(_) => {
                    shape = Shape::Closed;
                    break;
                }
                None => break,
            }
        }
        let mut faces = vec![first];
        let mut last = first;
        while !is_cut(t.prev(last)) {
            match t.turn_left(last) {
                Some(next) if next != first => last = next,
                _ => break,
            }
            faces.push(last);
        }
        if shape == Shape::Open && t.edge(t.prev(last)) == t.edge(first) && t.twin(first).is_some() {
            shape = Shape::Dart;
        }
        Self { faces, shape }
    }
}

/// What a vertex is told by tags.
#[derive(Clone, Copy)]
struct Rule {
    is_pinned: bool,
    /// Sharp from the cut on, but not for ever.
    is_locked: bool,
}

impl Rule {
    fn of(t: &Topology, v: Vertex, cut: f64) -> Self {
        let is_semi_sharp = |s: f64| s >= cut && s < INFINITE_SHARPNESS;
        let edges = || t.sharp_edges(v).iter().map(|&e| t.edge_sharpness(Edge(e)));
        let s = t.vertex_sharpness(v);
        Self {
            is_pinned: s >= INFINITE_SHARPNESS || edges().filter(|&s| s >= INFINITE_SHARPNESS).count() > 2,
            is_locked: is_semi_sharp(s) || edges().any(is_semi_sharp),
        }
    }
}

/// Number of faces of a sector that is covered by spline patches.
fn regular(scheme: Scheme, shape: Shape, rule: Rule) -> usize {
    let [around, beside] = match scheme.split() {
        SplitKind::Quads => [4, 2],
        SplitKind::Triangles => [6, 3],
    };
    match shape {
        Shape::Closed | Shape::Dart => around,
        Shape::Open if rule.is_pinned => 1,
        Shape::Open => beside,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::ControlMesh;
    use crate::shapes;
    use crate::tags::{Corner, Crease, Tags};

    fn sectors(mesh: &ControlMesh, cut: f64) -> (Topology, Sectors) {
        let t = Topology::new(mesh).unwrap();
        let sectors = Sectors::new(&t, Scheme::CatmullClark, cut);
        (t, sectors)
    }

    #[test]
    fn sectors_belong_to_one_vertex_and_end_at_cut_edges() {
        for shape in shapes::all() {
            for cut in [0.5, 1.0, INFINITE_SHARPNESS] {
                let (t, s) = sectors(&shape.mesh, cut);
                for h in (0..t.half_edge_count() as u32).map(HalfEdge) {
                    assert_eq!(t.origin(h).0, s.vertex[s.corner[h.index()] as usize], "{}", shape.name);
                    let across = t.turn_right(h).filter(|_| t.edge_sharpness(t.edge(h)) < cut);
                    let same = |g: HalfEdge| s.corner[g.index()] == s.corner[h.index()];
                    assert!(across.is_none_or(same), "{}", shape.name);
                }
            }
        }
    }

    #[test]
    fn a_crease_parts_its_inner_vertices_only() {
        let mut grid = shapes::grid(4, 4);
        // Two edges in a row inside the grid: darts at both ends, one vertex between.
        let creases = vec![Crease::new(11, 12, 10.0), Crease::new(12, 13, 10.0)];
        grid = grid.tagged("crease of two edges", Tags { creases, ..Tags::default() });
        let (t, s) = sectors(&grid.mesh, INFINITE_SHARPNESS);
        assert_eq!(s.len(), t.vertex_count() + 1);
        assert_eq!(s.vertex[t.vertex_count()], 12);
        assert!(!s.locked.iter().any(|&l| l) && !s.extraordinary.iter().any(|&e| e));
    }

    #[test]
    fn semi_sharp_creases_cone_points_and_creases_of_one_edge_keep_the_limit_normal() {
        let grid = shapes::grid(4, 4);
        let locked = |tags: Tags, cut: f64| {
            let (_, s) = sectors(&grid.tagged("tagged", tags).mesh, cut);
            (0..s.len()).filter(|&i| s.locked[i]).map(|i| s.vertex[i]).collect::<Vec<_>>()
        };
        let crease = |s: f64| Tags { creases: vec![Crease::new(11, 12, s)], ..Tags::default() };
        assert_eq!(locked(crease(2.0), 1.0), [11, 12]);
        assert_eq!(locked(crease(2.0), 3.0), [0u32; 0]);
        assert_eq!(locked(crease(10.0), 10.0), [11, 12]);
        assert_eq!(locked(Tags { corners: vec![Corner::new(12, 10.0)], ..Tags::default() }, 1.0), [12]);
    }
}
