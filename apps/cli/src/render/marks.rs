//! Dots where the surface has no curvature: at vertices where it grows without bound or differs by direction.

use super::lines::along;
use rayon::prelude::*;
use subsurf::{HalfEdge, Jet, LimitSurface, Location};
use subsurf_render::{Dot, Stroke};

/// Linear colour of the dots.
pub const COLOR: [f32; 3] = [0.02; 3];

/// A dot at every such vertex, and at such centres of faces that are no quads, for a picture of so many rows.
pub fn without_curvature(surface: &LimitSurface<'_, f32, 3>, height: u32) -> Vec<Dot> {
    let width_px = (height as f32 / 200.0).max(2.0);
    let stroke = Stroke { color: COLOR, opacity: 1.0, hidden: 0.0, width_px };
    let jets: Vec<Jet<3>> = places(surface).par_iter().filter_map(|&at| surface.eval_second(at)).collect();
    jets.iter()
        .filter(|jet| jet.curvature().is_none())
        .map(|jet| Dot { point: jet.position.map(|x| x as f32), stroke })
        .collect()
}

/// One place of every vertex that is not in holes alone, and the centres of faces in sub-faces.
fn places(surface: &LimitSurface<'_, f32, 3>) -> Vec<Location> {
    let table = surface.table();
    let t = table.topology();
    let mut corner: Vec<Option<HalfEdge>> = vec![None; t.vertex_count()];
    let mut out = Vec::new();
    for h in (0..t.half_edge_count()).map(HalfEdge::new).filter(|&h| !t.is_hole(t.face(h))) {
        corner[t.origin(h).index()].get_or_insert(h);
        let face = t.face(h);
        if t.half_edge(face, 0) == h && table.subfaces(face) > 1 {
            out.push(Location { face, subface: 0, u: 1.0, v: 1.0 });
        }
    }
    out.extend(corner.into_iter().flatten().map(|h| along(table, h, 0.0)));
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use subsurf::{PatchTable, Scheme, shapes};

    #[test]
    fn extraordinary_vertices_and_centres_of_polygons_are_marked_once_and_regular_vertices_are_not() {
        // A cube has eight vertices of valence 3; in a grid all is regular but nothing is at its four pinned corners.
        for (shape, expected) in [(shapes::cube(), 8), (shapes::grid(3, 3), 0)] {
            let points: Vec<[f32; 3]> = shape.positions.iter().map(|p| p.map(|x| x as f32)).collect();
            let table = PatchTable::new(&shape.mesh, Scheme::CatmullClark).unwrap();
            assert_eq!(without_curvature(&table.surface(&points), 720).len(), expected, "{}", shape.name);
        }
    }
}
