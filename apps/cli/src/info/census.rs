//! Counting what a control mesh is made of.

use super::Histogram;
use crate::oddities::{EdgeFault, edge_faults};
use subsurf::{Edge, Face, HalfEdge, INFINITE_SHARPNESS, Scheme, Topology, Vertex};
use subsurf_io::{Channel, Scene};

/// Counts.
pub struct Census {
    pub faces: usize,
    pub vertices: usize,
    pub edges: usize,
    pub sides: Histogram,
    /// Edges at interior vertices off non-manifold edges.
    pub interior: Histogram,
    /// Edges at boundary vertices off non-manifold edges.
    pub boundary: Histogram,
    pub extraordinary: usize,
    pub boundary_edges: usize,
    pub boundary_loops: usize,
    pub components: usize,
    pub isolated: usize,
    pub euler: i64,
    pub creases: Sharpness,
    pub corners: Sharpness,
    pub tagged_holes: usize,
    /// Holes by tags or by the boundary rule.
    pub holes: usize,
    pub texture: Option<TextureCensus>,
    /// Number of normals.
    pub normals: Option<usize>,
    pub non_manifold_edges: usize,
    /// Vertices where faces do not form one fan; isolated ones left out.
    pub non_manifold_vertices: usize,
    pub winding_conflicts: usize,
    pub degenerate_edges: usize,
    pub bounds: [[f64; 3]; 2],
}

/// Tags of one kind.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sharpness {
    pub count: usize,
    /// How many are infinitely sharp.
    pub infinite: usize,
    /// Smallest and largest.
    pub range: Option<[f64; 2]>,
}

impl Sharpness {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        values.fold(Self::default(), |all, s| Self {
            count: all.count + 1,
            infinite: all.infinite + usize::from(s >= INFINITE_SHARPNESS),
            range: Some(all.range.map_or([s, s], |[low, high]| [low.min(s), high.max(s)])),
        })
    }

    /// The range in words.
    pub fn describe(&self) -> String {
        match self.range {
            None => String::new(),
            Some([low, high]) if low == high => format!("sharpness {low}"),
            Some([low, high]) => format!("sharpness {low} to {high}, {} infinite", self.infinite),
        }
    }
}

/// Texture coordinates.
#[derive(Clone, Copy, Debug)]
pub struct TextureCensus {
    pub values: usize,
    /// Edges whose two faces use different values.
    pub seam_edges: usize,
}

impl Census {
    pub fn new(scene: &Scene, t: &Topology, scheme: Scheme) -> Self {
        let faults = edge_faults(t);
        let fault_count = |kind| faults.iter().filter(|fault| fault.1 == kind).count();
        let used = used_vertices(t);
        let isolated = used.iter().filter(|&&used| !used).count();
        let mut census = Self {
            faces: t.face_count(),
            vertices: t.vertex_count(),
            edges: t.edge_count(),
            sides: Histogram::new(),
            interior: Histogram::new(),
            boundary: Histogram::new(),
            extraordinary: 0,
            boundary_edges: edges(t).filter(|&e| t.is_boundary(e)).count(),
            boundary_loops: boundary_loops(t),
            components: components(t),
            isolated,
            euler: (t.vertex_count() - isolated + t.face_count()) as i64 - t.edge_count() as i64,
            creases: Sharpness::of(scene.mesh.tags().creases.iter().map(|c| c.sharpness)),
            corners: Sharpness::of(scene.mesh.tags().corners.iter().map(|c| c.sharpness)),
            tagged_holes: scene.mesh.tags().holes.iter().collect::<std::collections::BTreeSet<_>>().len(),
            holes: faces(t).filter(|&f| t.is_hole(f)).count(),
            texture: scene
                .texture
                .as_ref()
                .map(|channel| TextureCensus { values: channel.values.len(), seam_edges: seam_edges(t, channel) }),
            normals: scene.normals.as_ref().map(|channel| channel.values.len()),
            non_manifold_edges: fault_count(EdgeFault::Crowded),
            non_manifold_vertices: vertices(t).filter(|&v| t.is_non_manifold_vertex(v) && used[v.index()]).count(),
            winding_conflicts: fault_count(EdgeFault::Winding),
            degenerate_edges: fault_count(EdgeFault::Degenerate),
            bounds: bounds(&scene.positions),
        };
        faces(t).for_each(|f| *census.sides.entry(t.sides(f)).or_default() += 1);
        census.count_valences(t, scheme, &used);
        census
    }

    fn count_valences(&mut self, t: &Topology, scheme: Scheme, used: &[bool]) {
        let ordinary = if scheme == Scheme::Loop { [[6, 6], [4, 2]] } else { [[4, 4], [3, 2]] };
        let mut valence = vec![0usize; t.vertex_count()];
        let mut on_boundary = vec![false; t.vertex_count()];
        let mut left_out = vec![false; t.vertex_count()];
        for e in edges(t) {
            for v in t.edge_vertices(e).map(Vertex::index) {
                valence[v] += 1;
                on_boundary[v] |= t.is_boundary(e);
                left_out[v] |= t.is_non_manifold_edge(e);
            }
        }
        for v in (0..t.vertex_count()).filter(|&v| used[v] && !left_out[v]) {
            let histogram = if on_boundary[v] { &mut self.boundary } else { &mut self.interior };
            *histogram.entry(valence[v]).or_default() += 1;
            self.extraordinary += usize::from(!ordinary[usize::from(on_boundary[v])].contains(&valence[v]));
        }
    }
}

fn vertices(t: &Topology) -> impl Iterator<Item = Vertex> {
    (0..t.vertex_count()).map(Vertex::new)
}

fn edges(t: &Topology) -> impl Iterator<Item = Edge> {
    (0..t.edge_count()).map(Edge::new)
}

fn faces(t: &Topology) -> impl Iterator<Item = Face> {
    (0..t.face_count()).map(Face::new)
}

fn half_edges(t: &Topology) -> impl Iterator<Item = HalfEdge> {
    (0..t.half_edge_count()).map(HalfEdge::new)
}

fn used_vertices(t: &Topology) -> Vec<bool> {
    let mut used = vec![false; t.vertex_count()];
    t.corners().iter().for_each(|&v| used[v as usize] = true);
    used
}

/// Closed walks along the boundary. Where a walk meets a non-manifold edge it goes on along it, as each of its faces
/// sees a boundary there.
fn boundary_loops(t: &Topology) -> usize {
    let mut seen = vec![false; t.half_edge_count()];
    let mut loops = 0;
    for start in half_edges(t).filter(|&h| t.is_boundary(t.edge(h))) {
        if seen[start.index()] {
            continue;
        }
        loops += 1;
        let mut h = start;
        while !seen[h.index()] {
            seen[h.index()] = true;
            h = t.next(h);
            while let Some(twin) = t.twin(h) {
                h = t.next(twin);
            }
        }
    }
    loops
}

/// Sets of faces that share vertices, by union of vertices with path halving.
fn components(t: &Topology) -> usize {
    let mut parent: Vec<u32> = (0..t.vertex_count() as u32).collect();
    fn root(parent: &mut [u32], mut v: u32) -> u32 {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    }
    for f in faces(t) {
        let corners = t.face_vertices(f);
        for &v in &corners[1..] {
            let (a, b) = (root(&mut parent, corners[0]), root(&mut parent, v));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let used = used_vertices(t);
    (0..t.vertex_count() as u32).filter(|&v| used[v as usize] && parent[v as usize] == v).count()
}

/// Edges at whose ends some two of their faces have different values.
fn seam_edges<const N: usize>(t: &Topology, channel: &Channel<N>) -> usize {
    let value = |h: HalfEdge| channel.indices[h.index()];
    let mut first: Vec<Option<[u32; 2]>> = vec![None; t.edge_count()];
    let mut is_seam = vec![false; t.edge_count()];
    for h in half_edges(t) {
        let e = t.edge(h);
        let ends = [value(h), value(t.next(h))];
        let forward = t.origin(h) == t.edge_vertices(e)[0];
        let ends = if forward { ends } else { [ends[1], ends[0]] };
        is_seam[e.index()] |= *first[e.index()].get_or_insert(ends) != ends;
    }
    is_seam.iter().filter(|&&is_seam| is_seam).count()
}

fn bounds(positions: &[[f64; 3]]) -> [[f64; 3]; 2] {
    let first = positions.first().copied().unwrap_or_default();
    positions.iter().fold([first; 2], |[low, high], p| {
        [std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i]))]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use subsurf::shapes;

    #[test]
    fn loops_and_components_are_counted_on_shapes_known_by_heart() {
        let count = |shape: shapes::Shape| {
            let t = Topology::new(&shape.mesh).unwrap();
            (boundary_loops(&t), components(&t))
        };
        assert_eq!(count(shapes::cube()), (0, 1));
        assert_eq!(count(shapes::grid(3, 2)), (1, 1));
        // Two fans that touch in a vertex: each has a boundary of its own.
        assert_eq!(count(shapes::bow_tie()), (2, 1));
    }
}
