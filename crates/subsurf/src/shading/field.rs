//! Where the values of a field come from: the patch table of a level of the mesh, cut into sectors, and the way from a
//! place on the control mesh down to its place on that level. Values are sums of the weights that positions have there.

use super::patterns::Patterns;
use crate::index::HalfEdge;
use crate::limit::{Location, PatchTable};
use crate::scheme::SplitKind;
use crate::topology::Topology;
use std::borrow::Cow;
use std::ops::Deref;

/// The patch table of a field.
pub(super) enum Table<'a> {
    /// That of the mesh: the field starts at level 0 and nothing is cut.
    Mesh(&'a PatchTable),
    Own(Box<PatchTable>),
}

impl Deref for Table<'_> {
    type Target = PatchTable;

    fn deref(&self) -> &PatchTable {
        match self {
            Table::Mesh(table) => table,
            Table::Own(table) => table,
        }
    }
}

/// A field's patch table, and the level that it starts at.
pub(super) struct FieldTable<'a> {
    pub table: Table<'a>,
    pub depth: u32,
}

/// The weights of a field's values at one place.
pub(super) struct Weights<'a> {
    pub ring: &'a [u32],
    pub row: Cow<'a, [f64]>,
}

impl FieldTable<'_> {
    /// The place of `at` on the field's level: the patch and its parameters.
    pub fn locate(&self, mesh: &Topology, at: Location) -> (usize, f64, f64) {
        let at = descend(mesh, self.table.scheme().split(), at, self.depth);
        (self.table.patch(at.face, at.subface), at.u, at.v)
    }

    /// The weights at a place found by [`locate`](Self::locate); none in holes.
    pub fn weights<'b>(
        &'b self,
        (patch, u, v): (usize, f64, f64),
        patterns: Option<&'b Patterns>,
    ) -> Option<Weights<'b>> {
        let plan = self.table.patch_plan(patch)?;
        let turn = self.table.turn(patch);
        let shared = patterns.and_then(|p| p.row(&self.table, plan, turn, u, v));
        let row = match shared {
            Some(row) => Cow::Borrowed(row),
            None => {
                let [row, ..] = self.table.plan(plan).weights(u, v, turn, 1).rows;
                Cow::Owned(row)
            }
        };
        Some(Weights { ring: self.table.ring(patch), row })
    }
}

impl Weights<'_> {
    /// The weighted sum, relative to the first value, so that constants come out exactly.
    #[inline]
    pub fn sum<const N: usize>(&self, values: &[[f64; N]]) -> [f64; N] {
        let base = values[self.ring[0] as usize];
        let mut sum = [0.0; N];
        for (&v, &w) in self.ring.iter().zip(self.row.iter()) {
            let x = &values[v as usize];
            for i in 0..N {
                sum[i] += w * (x[i] - base[i]);
            }
        }
        std::array::from_fn(|i| base[i] + sum[i])
    }
}

/// The place of `at` after `depth` refinements of `mesh`.
fn descend(mesh: &Topology, split: SplitKind, at: Location, depth: u32) -> Location {
    let mut at = at;
    for step in 0..depth {
        at = match split {
            SplitKind::Triangles => in_child_triangle(at),
            SplitKind::Quads => {
                let is_quad = step > 0 || mesh.sides(at.face) == 4;
                let first = if step > 0 { 4 * at.face.0 } else { mesh.first(at.face) };
                if is_quad {
                    in_child_quad(at, HalfEdge(first))
                } else {
                    // A sub-face is a quad of the next level, with the same parameters.
                    Location { face: (first + at.subface).into(), subface: 0, ..at }
                }
            }
        };
    }
    at
}

/// Child c of a quad is face `first + c`, at corner c of the quad.
fn in_child_quad(at: Location, first: HalfEdge) -> Location {
    let (right, up) = (at.u >= 0.5, at.v >= 0.5);
    let child = match (right, up) {
        (false, false) => 0,
        (true, false) => 1,
        (true, true) => 2,
        (false, true) => 3,
    };
    let part = |x: f64, upper: bool| 2.0 * x - if upper { 1.0 } else { 0.0 };
    Location { face: (first.0 + child).into(), subface: 0, u: part(at.u, right), v: part(at.v, up) }
}

/// Children 0 to 2 of a triangle lie at its corners; child 3, in the middle, is turned upside down.
fn in_child_triangle(at: Location) -> Location {
    let (u, v) = (at.u, at.v);
    let (child, u, v) = if u >= 0.5 {
        (1, 2.0 * u - 1.0, 2.0 * v)
    } else if v >= 0.5 {
        (2, 2.0 * u, 2.0 * v - 1.0)
    } else if u + v > 0.5 {
        (3, 1.0 - 2.0 * u, 1.0 - 2.0 * v)
    } else {
        (0, 2.0 * u, 2.0 * v)
    };
    // Doubling must not add to what the third side is missed by.
    Location { face: (4 * at.face.0 + child).into(), subface: 0, u, v: v.min(1.0 - u) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::index::Face;
    use crate::refine::Level;
    use crate::scheme::Scheme;
    use crate::shapes;

    #[test]
    fn a_place_on_the_mesh_and_on_its_levels_is_the_same_point() {
        let quads = [shapes::cone(5), shapes::interior_vertex(5), shapes::cube()].map(|s| (s, Scheme::CatmullClark));
        let triangles = [shapes::interior_triangles(5), shapes::cube().triangulated()].map(|s| (s, Scheme::Loop));
        for (shape, scheme) in quads.into_iter().chain(triangles) {
            let mesh = PatchTable::new(&shape.mesh, scheme).unwrap();
            let surface = mesh.surface(&shape.positions);
            let mut level = Level::new(&shape.mesh, scheme).unwrap();
            let mut points = shape.positions.clone();
            for depth in 0..4 {
                let table =
                    Box::new(PatchTable::from_topology(level.topology().clone(), scheme, Default::default()).unwrap());
                let field = FieldTable { table: Table::Own(table), depth };
                for f in 0..shape.mesh.face_count() as u32 {
                    for k in 0..40 {
                        let (mut u, v) = ((0.618 * f64::from(k)).fract(), f64::from(k % 9) / 8.0);
                        if scheme == Scheme::Loop {
                            u *= 1.0 - v;
                        }
                        let at = Location { face: Face(f), subface: k % mesh.subfaces(Face(f)), u, v };
                        let want = surface.position(at).unwrap();
                        let place = field.locate(mesh.topology(), at);
                        let got = field.weights(place, None).unwrap().sum(&points);
                        (0..3).for_each(|i| assert!((got[i] - want[i]).abs() < 1e-13, "{} {at:?}", shape.name));
                    }
                }
                points = level.refine_values(&points);
                level = level.refine().unwrap();
            }
        }
    }
}
