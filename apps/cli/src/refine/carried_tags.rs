//! The tags of a refined level: its sharpness, less what every reader infers from the faces and the rules.

use subsurf::{Boundary, ControlMesh, Corner, Crease, Edge, Face, INFINITE_SHARPNESS, Tags, Topology, Vertex};

/// Tags with which the faces of `t` have the sharpness and holes of `t` again.
///
/// Boundary edges are sharp by themselves, and so are vertices of one face under the rule edge-and-corner. Under the rule
/// none, open boundaries would make further holes: there the holes stand as they are and the boundary is tagged sharp.
pub fn of(t: &Topology) -> Tags {
    let rules = *t.rules();
    let is_written = |e: &Edge| {
        t.edge_sharpness(*e) > 0.0 && (!t.is_boundary(*e) || rules.boundary == Boundary::None) && {
            let [a, b] = t.edge_vertices(*e);
            a != b
        }
    };
    let creases = (0..t.edge_count()).map(Edge::new).filter(is_written).map(|e| {
        let [a, b] = t.edge_vertices(e);
        Crease::new(a.0, b.0, t.edge_sharpness(e))
    });

    let mut faces_at = vec![0u32; t.vertex_count()];
    t.corners().iter().for_each(|&v| faces_at[v as usize] += 1);
    let is_implied = |v: Vertex| {
        let one_face = rules.boundary == Boundary::EdgeAndCorner && faces_at[v.index()] == 1;
        t.vertex_sharpness(v) >= INFINITE_SHARPNESS && (one_face || t.is_non_manifold_vertex(v))
    };
    let corners = (0..t.vertex_count())
        .map(Vertex::new)
        .filter(|&v| t.vertex_sharpness(v) > 0.0 && !is_implied(v))
        .map(|v| Corner::new(v.0, t.vertex_sharpness(v)));
    let holes = (0..t.face_count()).map(Face::new).filter(|&f| t.is_hole(f)).map(|f| f.0);
    Tags { creases: creases.collect(), corners: corners.collect(), holes: holes.collect(), rules }
}

/// Number of edges that are sharper or smoother when the faces of `t` are read again with `tags`: edges between the same
/// two vertices become one there, and so do the halves of winding conflicts.
pub fn unsayable(t: &Topology, tags: &Tags) -> usize {
    if !is_odd(t) {
        return 0;
    }
    let sizes: Vec<u32> = t.face_offsets().windows(2).map(|w| w[1] - w[0]).collect();
    let again = ControlMesh::from_counts(t.vertex_count(), &sizes, t.corners().to_vec(), tags.clone());
    let Ok(again) = again.and_then(|mesh| Topology::new(&mesh)) else { return t.edge_count() };
    let half_edges = (0..t.face_count()).map(Face::new).flat_map(|f| (0..t.sides(f)).map(move |c| t.half_edge(f, c)));
    let mut differs = vec![false; t.edge_count()];
    for h in half_edges {
        let same = again.edge_sharpness(again.edge(h)) == t.edge_sharpness(t.edge(h))
            && again.vertex_sharpness(again.origin(h)) == t.vertex_sharpness(t.origin(h));
        differs[t.edge(h).index()] |= !same;
    }
    differs.into_iter().filter(|&d| d).count()
}

/// True where some edges of this level, or of those below it, may share both their ends: only non-manifold edges and, under
/// Loop, interior vertices of two faces make such edges.
pub fn is_odd(t: &Topology) -> bool {
    let (mut faces_at, mut open) = (vec![0u32; t.vertex_count()], vec![false; t.vertex_count()]);
    t.corners().iter().for_each(|&v| faces_at[v as usize] += 1);
    let edges = || (0..t.edge_count()).map(Edge::new);
    for e in edges().filter(|&e| t.is_boundary(e)) {
        t.edge_vertices(e).iter().for_each(|v| open[v.index()] = true);
    }
    faces_at.iter().zip(&open).any(|(&faces, &open)| faces == 2 && !open) || edges().any(|e| t.is_non_manifold_edge(e))
}

#[cfg(test)]
mod tests {
    use super::*;
    use subsurf::{Level, Rules, Scheme, shapes};

    /// Sharpness at every edge (by its ends) and vertex, and the holes.
    type Effective = (Vec<(Vec<Vertex>, f64)>, Vec<f64>, Vec<bool>);

    fn effective(t: &Topology) -> Effective {
        let edge = |e: Edge| {
            let mut ends = t.edge_vertices(e).to_vec();
            ends.sort();
            (ends, t.edge_sharpness(e))
        };
        let mut edges: Vec<_> = (0..t.edge_count()).map(|e| edge(Edge::new(e))).collect();
        edges.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let vertices = (0..t.vertex_count()).map(|v| t.vertex_sharpness(Vertex::new(v))).collect();
        (edges, vertices, (0..t.face_count()).map(|f| t.is_hole(Face::new(f))).collect())
    }

    #[test]
    fn faces_with_carried_tags_have_the_level_s_sharpness_and_holes() {
        // Left out: edge points of winding conflicts lie on a crease of one sheet, and edges with equal ends become two
        // edges with equal ends each, neither of which tags can say.
        let is_sayable =
            |shape: &shapes::Shape| !["winding", "degenerate"].iter().any(|odd| shape.name.starts_with(odd));
        let quads = shapes::all().into_iter().chain(shapes::tagged()).map(|shape| (shape, Scheme::CatmullClark));
        let triangles = shapes::all_triangles().into_iter().map(|shape| (shape, Scheme::Loop));
        for (shape, scheme) in quads.chain(triangles).filter(|(shape, _)| is_sayable(shape)) {
            for boundary in [Boundary::None, Boundary::EdgeOnly, Boundary::EdgeAndCorner] {
                let rules = Rules { boundary, ..shape.mesh.tags().rules };
                let mut level = Level::new(&shape.mesh.clone().with_rules(rules), scheme).unwrap();
                for depth in 0..3 {
                    let t = level.topology();
                    let sizes: Vec<u32> = t.face_offsets().windows(2).map(|w| w[1] - w[0]).collect();
                    let mesh = ControlMesh::from_counts(t.vertex_count(), &sizes, t.corners().to_vec(), of(t)).unwrap();
                    let again = Topology::new(&mesh).unwrap();
                    assert_eq!(effective(&again), effective(t), "{} {boundary:?} level {depth}", shape.name);
                    assert_eq!(unsayable(t, &of(t)), 0, "{} {boundary:?} level {depth}", shape.name);
                    level = level.refine().unwrap();
                }
            }
        }
    }

    #[test]
    fn what_tags_cannot_say_is_counted() {
        let odd = shapes::all().into_iter().filter(|shape| shape.name.starts_with("winding"));
        let mut found = 0;
        for shape in odd {
            let level = Level::new(&shape.mesh, Scheme::CatmullClark).unwrap().refine().unwrap();
            let t = level.topology();
            assert!(unsayable(t, &of(t)) > 0, "{}", shape.name);
            found += 1;
        }
        assert!(found > 0);
    }
}
