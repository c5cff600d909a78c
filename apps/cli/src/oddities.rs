//! What is unusual about a mesh and how the surface treats it, counted, the first few named.

use std::fmt;
use subsurf::{Boundary, ControlMesh, Edge, Face, Topology, Vertex};

/// How many elements are named.
const NAMED: usize = 3;

/// A kind of oddity.
pub struct Oddity {
    count: usize,
    /// One and many.
    what: [&'static str; 2],
    done: &'static str,
    /// The first few names, none twice.
    first: Vec<String>,
    /// Whether there are further names.
    more: bool,
}

impl fmt::Display for Oddity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { count, what, done, first, more } = self;
        write!(f, "{count} {} {done} ({}", what[usize::from(*count != 1)], first.join(", "))?;
        f.write_str(if *more { ", …)" } else { ")" })
    }
}

/// How an edge fails to be shared by two faces in opposite directions.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum EdgeFault {
    /// Both ends are one vertex.
    Degenerate,
    /// Two faces run along it in the same direction.
    Winding,
    /// More than two faces, or one face twice.
    Crowded,
}

/// The fault of every non-manifold edge, in ascending order.
pub fn edge_faults(t: &Topology) -> Vec<(Edge, EdgeFault)> {
    let mut faults: Vec<(Edge, [usize; 2])> =
        (0..t.edge_count()).map(Edge::new).filter(|&e| t.is_non_manifold_edge(e)).map(|e| (e, [0; 2])).collect();
    if faults.is_empty() {
        return Vec::new();
    }
    for f in (0..t.face_count()).map(Face::new) {
        for corner in 0..t.sides(f) {
            let h = t.half_edge(f, corner);
            if let Ok(at) = faults.binary_search_by_key(&t.edge(h), |fault| fault.0) {
                let forward = t.origin(h) == t.edge_vertices(t.edge(h))[0];
                faults[at].1[usize::from(forward)] += 1;
            }
        }
    }
    let fault = |(e, faces): (Edge, [usize; 2])| {
        let [a, b] = t.edge_vertices(e);
        let kind = match faces {
            _ if a == b => EdgeFault::Degenerate,
            [0, 2] | [2, 0] => EdgeFault::Winding,
            _ => EdgeFault::Crowded,
        };
        (e, kind)
    };
    faults.into_iter().map(fault).collect()
}

/// Everything unusual about `mesh` with the tables `t`.
pub fn found(mesh: &ControlMesh, t: &Topology) -> Vec<Oddity> {
    let edge_name = |e: Edge| {
        let [a, b] = t.edge_vertices(e);
        if a == b { format!("at vertex {a}") } else { format!("vertices {} and {}", a.min(b), a.max(b)) }
    };
    let faults = edge_faults(t);
    let edges = |kind, what, done| {
        let of_kind: Vec<Edge> = faults.iter().filter(|fault| fault.1 == kind).map(|fault| fault.0).collect();
        oddity(of_kind, edge_name, what, done)
    };
    let mut used = vec![false; t.vertex_count()];
    t.corners().iter().for_each(|&v| used[v as usize] = true);
    let vertices = || (0..t.vertex_count()).map(Vertex::new);
    let vertex_name = |v: Vertex| format!("vertex {v}");
    let mut on_faulty_edge = vec![false; t.vertex_count()];
    for (e, _) in &faults {
        t.edge_vertices(*e).iter().for_each(|v| on_faulty_edge[v.index()] = true);
    }
    let pinned = |v: &Vertex| t.is_non_manifold_vertex(*v) && used[v.index()] && !on_faulty_edge[v.index()];
    let mut tagged = vec![false; t.face_count()];
    mesh.tags().holes.iter().for_each(|&f| tagged[f as usize] = true);
    let holes = || (0..t.face_count()).map(Face::new).filter(|&f| t.is_hole(f) && !tagged[f.index()]);
    let holes = if t.rules().boundary == Boundary::None { holes().collect() } else { Vec::new() };
    [
        edges(EdgeFault::Crowded, ["non-manifold edge", "non-manifold edges"], "made infinitely sharp"),
        edges(
            EdgeFault::Winding,
            ["edge between faces of opposite winding", "edges between faces of opposite winding"],
            "made infinitely sharp",
        ),
        edges(EdgeFault::Degenerate, ["edge with equal ends", "edges with equal ends"], "made infinitely sharp"),
        oddity(
            vertices().filter(pinned).collect(),
            vertex_name,
            ["vertex where several fans of faces meet", "vertices where several fans of faces meet"],
            "pinned",
        ),
        oddity(
            vertices().filter(|v| !used[v.index()]).collect(),
            vertex_name,
            ["vertex without faces", "vertices without faces"],
            "left alone",
        ),
        oddity(
            holes,
            |f: Face| format!("face {f}"),
            ["face at the boundary", "faces at the boundary"],
            "made holes by the boundary rule none",
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn oddity<E>(
    elements: Vec<E>,
    name: impl Fn(E) -> String,
    what: [&'static str; 2],
    done: &'static str,
) -> Option<Oddity> {
    let count = elements.len();
    let (mut first, mut more) = (Vec::new(), false);
    // Several edges may join the same vertices.
    for name in elements.into_iter().map(name) {
        match first.len() {
            _ if first.contains(&name) => {}
            NAMED => {
                more = true;
                break;
            }
            _ => first.push(name),
        }
    }
    (count > 0).then_some(Oddity { count, what, done, first, more })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_between_the_same_vertices_are_named_once() {
        // Two edges from vertex 3 to itself, one from 5 to itself.
        let faces = [vec![0, 1, 2, 3, 3, 3], vec![2, 1, 4, 5, 5]];
        let mesh = ControlMesh::new(&faces, subsurf::Tags::default()).unwrap();
        let found = found(&mesh, &Topology::new(&mesh).unwrap());
        let said: Vec<String> = found.iter().map(Oddity::to_string).collect();
        assert!(
            said.contains(&"3 edges with equal ends made infinitely sharp (at vertex 3, at vertex 5)".to_owned()),
            "{said:?}"
        );
    }
}
