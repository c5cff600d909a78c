//! Which known patch covers a face whose surroundings were cut out, and its control points.

use super::super::corner::{
    Corner, Kind, corner, grid_points, has_finite_sharpness, is_finite_sharpness, special_points,
};
use super::super::linear_boundary::has_side;
use super::super::rows::{Combination, Rows};
use super::super::triangle_crease::TriangleCrease;
use super::super::triangle_points;
use super::compile::Compiler;
use super::{Leaf, LeafShape};
use crate::index::{Edge, Face, HalfEdge};
use crate::scheme::{Scheme, SplitKind};
use crate::topology::{Interpolation, Topology};

impl Compiler<'_> {
    /// The leaf that covers the face of `t` with these half-edges, if one does.
    pub fn leaf(&self, t: &Topology, own: &[HalfEdge]) -> Option<Leaf> {
        let split = self.scheme.split();
        if self.scheme == Scheme::Bilinear || t.interpolation == Interpolation::Linear {
            let corners: Vec<Combination> = own.iter().map(|&h| Combination::point(t.origin(h).0)).collect();
            return Some(make(t, LeafShape::Linear, corners, Vec::new()));
        }
        if has_side(t, t.face(own[0]))
            || (0..t.face_count() as u32).any(|f| t.sides(Face(f)) != self.scheme.patch_sides())
        {
            return None;
        }
        let mut creases = Vec::new();
        if own.iter().any(|&h| has_finite_sharpness(t, h)) {
            if t.interpolation == Interpolation::LinearBoundaries {
                return None;
            }
            if split == SplitKind::Quads {
                return single_crease(t, own);
            }
            creases = TriangleCrease::all(t, own)?;
        }
        let special: Vec<(usize, Corner)> = own
            .iter()
            .enumerate()
            .map(|(j, &h)| (j, corner(t, h, split).0))
            .filter(|(_, corner)| !corner.is_regular())
            .collect();
        match special[..] {
            [] => {
                let points = match split {
                    SplitKind::Quads => grid_points(t, own[0], false).map(|p| p.expect("a full grid")).to_vec(),
                    SplitKind::Triangles => triangle_points::patch_points(t, own[0]).to_vec(),
                };
                Some(make(t, LeafShape::Regular, points, creases))
            }
            [(j, corner)] => {
                let vertex = self.specials.get(corner);
                let points = match split {
                    SplitKind::Quads => special_points(t, own[j]),
                    SplitKind::Triangles => triangle_points::special_points(t, own[j]),
                };
                debug_assert_eq!(points.len(), vertex.points(), "{corner:?}");
                let mut leaf = make(t, LeafShape::Special { turn: j as u8, vertex }, points, creases);
                leaf.points = self.specials.share_points(corner, leaf.points);
                Some(leaf)
            }
            _ => None,
        }
    }
}

/// The leaf along one semi-sharp side of a quad, if it has that form.
fn single_crease(t: &Topology, own: &[HalfEdge]) -> Option<Leaf> {
    let (side, sharpness) = single_crease_side(t, own)?;
    // The crease along v = 1 runs between corners 2 and 3 of the turned quad.
    let turn = (side + 2) % 4;
    let grid = grid_points(t, own[turn], false).map(|p| p.expect("a full grid")).to_vec();
    Some(make(t, LeafShape::SingleCrease { turn: turn as u8, sharpness }, grid, Vec::new()))
}

/// A leaf whose control points are combinations of the vertices of `t`, the creases' bends last.
fn make(
    t: &Topology,
    shape: LeafShape,
    mut points: Vec<Combination>,
    creases: Vec<(TriangleCrease, Vec<Combination>)>,
) -> Leaf {
    let patch_points = points.len();
    let creases = creases.into_iter().map(|(crease, bends)| {
        points.extend(bends);
        crease
    });
    let creases = creases.collect();
    Leaf { shape, points: Rows::new(t.vertex_count(), &points).into(), patch_points, creases }
}

/// The only sharp side of a quad and its sharpness, where the closed form of one semi-sharp crease holds: both ends are
/// interior, of valence 4, and continued straight with the same sharpness; the opposite side is smooth or infinitely
/// sharp, with regular corners.
fn single_crease_side(t: &Topology, own: &[HalfEdge]) -> Option<(usize, f64)> {
    let sharpness = |h: HalfEdge| t.edge_sharpness(t.edge(h));
    let mut sides = (0..4).filter(|&j| is_finite_sharpness(sharpness(own[j])));
    let side = sides.next().filter(|_| sides.next().is_none())?;
    let s = sharpness(own[side]);
    let [next, opposite, before] = [1, 2, 3].map(|k| own[(side + k) % 4]);
    if sharpness(next) > 0.0 || sharpness(before) > 0.0 {
        return None;
    }
    for end in [own[side], next] {
        let v = t.origin(end);
        let goes_on = t.sharp_edges(v).len() == 2
            && t.vertex_sharpness(v) == 0.0
            && t.foreign_sharpness(v).is_empty()
            && spokes(t, end).is_some_and(|spokes| {
                // Of four spokes the sharp ones must face each other.
                let sharp: Vec<bool> = spokes.iter().map(|&e| t.edge_sharpness(e) == s).collect();
                sharp == [true, false, true, false] || sharp == [false, true, false, true]
            });
        if !goes_on {
            return None;
        }
    }
    for far in [opposite, before] {
        if has_finite_sharpness(t, far) {
            return None;
        }
        let c = corner(t, far, SplitKind::Quads).0;
        let plain = c.kind == Kind::Smooth && c.n == 4;
        let along = c.kind == Kind::Crease && c.n == 2 && t.is_infinitely_sharp(t.edge(opposite));
        if !plain && !along {
            return None;
        }
    }
    Some((side, s))
}

/// The four edges round the origin of `h`, if it is an interior vertex of valence 4.
fn spokes(t: &Topology, h: HalfEdge) -> Option<[Edge; 4]> {
    let a = t.turn_left(h)?;
    let b = t.turn_left(a)?;
    let c = t.turn_left(b)?;
    (t.turn_left(c)? == h && b != h).then(|| [h, a, b, c].map(|h| t.edge(h)))
}
