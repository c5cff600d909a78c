//! Blend weights b: what the values at a level's vertices are so that b is 1, or near 1, at extraordinary vertices and
//! falls to 0 round them (Bakker, Barendrecht, Kosinka 2018, section 3).

use super::Blend;
use super::field::FieldTable;
use super::levels::{Centre, Levels};
use crate::index::{Face, HalfEdge};
use crate::scheme::SplitKind;
use crate::topology::{NONE, Topology};

/// True where level `depth`, made before, is fine enough for the blend: faces that are no quads have become quads round
/// a vertex of their own, whose valence counts, and for A3 no face has two extraordinary vertices.
///
/// Under Catmull-Clark the first takes one level. Every face then has one old vertex, and across from it the centre of
/// an old face: both are extraordinary only beside polygons, and another level parts them. Under Loop a face of the next
/// level has at most one old vertex.
pub(super) fn is_ready(blend: Blend, levels: &Levels<'_>, depth: u32) -> bool {
    let t = levels.made(depth);
    let mut faces = (0..t.face_count() as u32).map(Face);
    if levels.scheme().split() == SplitKind::Quads && faces.clone().any(|f| t.sides(f) != 4) {
        return false;
    }
    if blend != Blend::A3 {
        return true;
    }
    let mut is_centre = vec![false; t.vertex_count()];
    levels.centres(depth).iter().for_each(|c| is_centre[c.value as usize] = c.is_interior);
    faces.all(|f| t.face_vertices(f).iter().filter(|&&v| is_centre[v as usize]).count() < 2)
}

/// The blend weights of all values of the level that `field` starts at.
pub(super) fn weights(blend: Blend, levels: &Levels<'_>, field: &FieldTable<'_>) -> Vec<f64> {
    let t = levels.made(field.depth);
    let centres = levels.centres(field.depth);
    let mut b = vec![0.0; t.vertex_count()];
    match blend {
        Blend::A1 | Blend::A2 => centres.iter().for_each(|c| b[c.value as usize] = 1.0),
        Blend::A3 => reciprocal_weights(t, &centres, field, &mut b),
        Blend::A4 => {
            let mut is_centre = vec![false; t.vertex_count()];
            centres.iter().for_each(|c| is_centre[c.value as usize] = true);
            for f in (0..t.face_count() as u32).map(Face) {
                let corners = t.face_vertices(f);
                if corners.iter().any(|&v| is_centre[v as usize]) {
                    corners.iter().for_each(|&v| b[v as usize] = 1.0);
                }
            }
        }
    }
    for (b, _) in b.iter_mut().zip(levels.locked(field.depth)).filter(|(_, locked)| *locked) {
        *b = 0.0;
    }
    b
}

/// 1/w at interior centres, w being a value's weight in its own limit. Boundary centres stay 0: across the boundary the
/// gradient would not vanish.
fn reciprocal_weights(t: &Topology, centres: &[Centre], field: &FieldTable<'_>, b: &mut [f64]) {
    let mut corner = vec![NONE; t.vertex_count()];
    for (h, &v) in t.corners().iter().enumerate().filter(|(h, _)| !t.is_hole(t.face(HalfEdge(*h as u32)))) {
        corner[v as usize] = h as u32;
    }
    for centre in centres.iter().filter(|c| c.is_interior && corner[c.value as usize] != NONE) {
        let at = field.table.corner_location(HalfEdge(corner[centre.value as usize]));
        let place = (field.table.patch(at.face, at.subface), at.u, at.v);
        let weights = field.weights(place, None).expect("the corner lies in no hole");
        let own = weights.ring.iter().zip(weights.row.iter()).filter(|(v, _)| **v == centre.value);
        b[centre.value as usize] = 1.0 / own.map(|(_, w)| w).sum::<f64>();
    }
}
