//! The control mesh's edges, and their images on the limit surface.

use rayon::prelude::*;
use subsurf::{Edge, Face, HalfEdge, LimitSurface, Location, PatchTable, Topology};

/// The ends of all edges.
pub fn cage_edges(t: &Topology) -> Vec<[u32; 2]> {
    (0..t.edge_count()).map(|e| t.edge_vertices(Edge::new(e)).map(|v| v.0)).collect()
}

/// The curve on the limit surface of every edge, in `rate` steps, as the tessellation at this rate has it. Edges
/// between holes have none.
pub fn edge_curves(surface: &LimitSurface<'_, f32, 3>, rate: u32) -> Vec<Vec<[f32; 3]>> {
    let table = surface.table();
    let t = table.topology();
    let mut owner: Vec<Option<HalfEdge>> = vec![None; t.edge_count()];
    for h in (0..t.half_edge_count()).map(HalfEdge::new).filter(|&h| !t.is_hole(t.face(h))) {
        owner[t.edge(h).index()].get_or_insert(h);
    }
    let curve = |&h: &HalfEdge| {
        let points = (0..=rate).filter_map(|i| surface.position(along(table, h, f64::from(i) / f64::from(rate))));
        points.map(|p| p.map(|x| x as f32)).collect()
    };
    owner.par_iter().flatten().map(curve).collect()
}

/// The place a share `s` along half-edge `h`.
pub fn along(table: &PatchTable, h: HalfEdge, s: f64) -> Location {
    let t = table.topology();
    let face = t.face(h);
    let corner = h.0 - t.half_edge(face, 0).0;
    let sides = t.sides(face) as u32;
    let at = |subface, u, v| Location { face: Face(face.0), subface, u, v };
    if sides == 3 && table.subfaces(face) == 1 {
        let [u, v] = [[s, 0.0], [1.0 - s, s], [0.0, 1.0 - s]][corner as usize];
        return at(0, u, v);
    }
    match (sides, corner) {
        (4, 0) => at(0, s, 0.0),
        (4, 1) => at(0, 1.0, s),
        (4, 2) => at(0, 1.0 - s, 1.0),
        (4, _) => at(0, 0.0, 1.0 - s),
        _ if s <= 0.5 => at(corner, 2.0 * s, 0.0),
        _ => at((corner + 1) % sides, 0.0, 2.0 * (1.0 - s)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use subsurf::{PatchTable, Scheme, shapes};

    #[test]
    fn curves_run_from_the_limit_of_one_end_to_that_of_the_other_in_quads_triangles_and_other_faces() {
        let quads = [shapes::cube(), shapes::interior_vertex(5), shapes::cone(5)].map(|s| (s, Scheme::CatmullClark));
        let triangles = shapes::all_triangles().into_iter().map(|shape| (shape, Scheme::Loop));
        for (shape, scheme) in quads.into_iter().chain(triangles) {
            let table = PatchTable::new(&shape.mesh, scheme).unwrap();
            let t = table.topology();
            let points: Vec<[f64; 3]> = shape.positions.clone();
            let surface = table.surface(&points);
            for h in (0..t.half_edge_count()).map(HalfEdge::new).filter(|&h| !t.is_hole(t.face(h))) {
                let next = along(&table, t.next(h), 0.0);
                let end = [along(&table, h, 1.0), next].map(|at| surface.position(at).unwrap());
                let middle = [0.5, 0.5 + 1e-15].map(|s| surface.position(along(&table, h, s)).unwrap());
                for [a, b] in [end, middle] {
                    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{} {h}", shape.name);
                }
            }
        }
    }
}
