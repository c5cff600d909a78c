//! Limit points of the vertices of a refinement level: the level's vertices are places on the surface, and the surface
//! is evaluated there. So features that are still semi-sharp at that level are exact too.

use super::{LimitSurface, Location, PatchTable};
use crate::index::{Face, HalfEdge};
use crate::real::{Real, round};
use crate::refine::Level;
use crate::scheme::SplitKind;
use rayon::prelude::*;

impl<T: Real, const N: usize> LimitSurface<'_, T, N> {
    /// The limit point of every vertex of `level`, which must be a refinement of this surface's mesh. Vertices that only
    /// holes use, or no face, keep the value that `values` has for them.
    ///
    /// # Panics
    /// If `values` has not one row per vertex of the level, or the level stems from another mesh.
    pub fn limit_of_level(&self, level: &Level, values: &[[T; N]]) -> Vec<[T; N]> {
        let fine = level.topology();
        assert_eq!(values.len(), fine.vertex_count(), "one value per vertex of the level");
        let places = self.table.places_of_level(level);
        places
            .par_iter()
            .zip(values)
            .map(|(place, &value)| place.and_then(|at| self.position(at)).map_or(value, round))
            .collect()
    }
}

impl PatchTable {
    /// Where every vertex of `level` lies, as the first of its faces outside holes sees it.
    pub(crate) fn places_of_level(&self, level: &Level) -> Vec<Option<Location>> {
        let (coarse, fine) = (self.topology(), level.topology());
        let split = self.scheme().split();
        let faces = match level.depth() {
            depth if split == SplitKind::Triangles => coarse.face_count() << (2 * depth),
            0 => coarse.face_count(),
            depth => coarse.half_edge_count() << (2 * (depth - 1)),
        };
        assert_eq!(fine.face_count(), faces, "the level is a refinement of this mesh");
        let mut places = vec![None; fine.vertex_count()];
        for f in (0..fine.face_count() as u32).rev().map(Face) {
            if fine.is_hole(f) {
                continue;
            }
            for corner in 0..fine.sides(f) {
                let v = fine.origin(fine.half_edge(f, corner));
                places[v.index()] = Some(self.place(f, corner, level.depth()));
            }
        }
        places
    }

    /// Where corner `corner` of face `f` of the level of depth `depth` lies.
    fn place(&self, f: Face, corner: usize, depth: u32) -> Location {
        let t = self.topology();
        if depth == 0 {
            return self.corner_location(t.half_edge(f, corner));
        }
        if self.scheme().split() == SplitKind::Triangles {
            return triangle_place(f, corner, depth);
        }
        // A face's number is, level by level, four times its parent's plus the corner it sits at.
        let base = HalfEdge(f.0 >> (2 * (depth - 1)));
        let face = t.face(base);
        let mut path: Vec<u32> = (0..depth - 1).rev().map(|k| f.0 >> (2 * k) & 3).collect();
        let own_corner = base.0 - t.first(face);
        let is_quad = t.sides(face) == 4;
        if is_quad {
            path.insert(0, own_corner);
        }
        let quadrant = |c: u32| [(0u32, 0u32), (1, 0), (1, 1), (0, 1)][c as usize];
        // Lower corner of the face in cells of its level, then its corner.
        let (mut x, mut y) = (0u64, 0u64);
        for &c in &path {
            let (cx, cy) = quadrant(c);
            (x, y) = (2 * x + u64::from(cx), 2 * y + u64::from(cy));
        }
        let (cx, cy) = quadrant(corner as u32);
        let cells = (1u64 << path.len()) as f64;
        let [u, v] = [x + u64::from(cx), y + u64::from(cy)].map(|k| k as f64 / cells);
        Location { face, subface: if is_quad { 0 } else { own_corner }, u, v }
    }
}

/// The same under Loop: four children to a face, the middle one turned upside down.
pub(super) fn triangle_place(f: Face, corner: usize, depth: u32) -> Location {
    // The place of corner 0, in cells of the level, and the cells' direction.
    let (mut x, mut y, mut sign) = (0i64, 0i64, 1i64);
    for k in (0..depth).rev() {
        (x, y) = (2 * x, 2 * y);
        match f.0 >> (2 * k) & 3 {
            0 => {}
            1 => x += sign,
            2 => y += sign,
            _ => {
                (x, y) = (x + sign, y + sign);
                sign = -sign;
            }
        }
    }
    match corner {
        1 => x += sign,
        2 => y += sign,
        _ => {}
    }
    let cells = (1u64 << depth) as f64;
    Location { face: Face(f.0 >> (2 * depth)), subface: 0, u: x as f64 / cells, v: y as f64 / cells }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::Scheme;
    use crate::shapes;

    #[test]
    fn limit_points_are_where_refinement_goes() {
        // Ten more levels bring a smooth mesh's points within 4^-10 of the limit, more slowly beside many faces.
        for shape in [shapes::cube(), shapes::cone(5), shapes::grid(2, 2), shapes::three_sheets()] {
            let table = PatchTable::new(&shape.mesh, Scheme::CatmullClark).unwrap();
            let surface = table.surface(&shape.positions);
            let mut level = Level::new(&shape.mesh, Scheme::CatmullClark).unwrap();
            let mut values = shape.positions.clone();
            for depth in 0..6 {
                let limit = surface.limit_of_level(&level, &values);
                let mut far = limit.iter().zip(&values).flat_map(|(a, b)| (0..3).map(move |i| (a[i] - b[i]).abs()));
                let bound = 1.5 * 0.4f64.powi(depth);
                assert!(far.all(|x| x < bound), "{} at depth {depth}", shape.name);
                values = level.refine_values(&values);
                level = level.refine().unwrap();
            }
        }
    }

    #[test]
    fn limits_of_two_levels_agree_where_they_share_vertices() {
        let quads = shapes::all().into_iter().map(|s| (s, Scheme::CatmullClark));
        for (shape, scheme) in
            quads.chain(shapes::all_triangles().into_iter().chain([shapes::pillow()]).map(|s| (s, Scheme::Loop)))
        {
            let table = PatchTable::new(&shape.mesh, scheme).unwrap();
            let surface = table.surface(&shape.positions);
            let level = Level::new(&shape.mesh, scheme).unwrap();
            let (one, values1) = (level.refine().unwrap(), level.refine_values(&shape.positions));
            let (two, values2) = (one.refine().unwrap(), one.refine_values(&values1));
            let (a, b) = (surface.limit_of_level(&one, &values1), surface.limit_of_level(&two, &values2));
            for (v, (a, b)) in a.iter().zip(&b).enumerate() {
                let is_near = (0..3).all(|i| (a[i] - b[i]).abs() < 1e-13);
                // Vertices inside holes keep refined values, which move.
                assert!(is_near || in_hole_only(&one, v), "{} vertex {v}: {a:?} {b:?}", shape.name);
            }
        }
    }

    fn in_hole_only(level: &Level, v: usize) -> bool {
        let t = level.topology();
        !(0..t.face_count() as u32).map(Face).any(|f| !t.is_hole(f) && t.face_vertices(f).contains(&(v as u32)))
    }
}
