//! A face with a side on a boundary that stays piecewise linear (face-varying rule "boundaries"): values along it move on
//! straight lines while the inside is smooth, so no finite set of spline patches covers the face.
//!
//! Its children are again such faces along the boundary, and ordinary faces inside. Up to equal surroundings there are
//! only a few different ones, so plans lead back to themselves here: a location is followed from node to node until it
//! leaves the boundary, which takes as many steps as its distance has binary digits.
//!
//! Steps stop at [`DEEPEST`], where the face is as good as bilinear. On the boundary itself positions are exact and the
//! derivative across diverges, slowly. Second derivatives lose digits towards it, as `4^depth` times rounding.

use super::corner::{Kind, corner, has_finite_sharpness, ring_points};
use super::jet::Derivatives;
use super::plan::{SpecialVertices, linear, through};
use super::rows::{Combination, Rows};
use super::special::{AtVertex, PointWeights, SpecialVertex};
use crate::index::Face;
use crate::scheme::{Scheme, SplitKind};
use crate::topology::{Interpolation, Topology};
use std::sync::Arc;

/// Steps towards the boundary. Larger: time; smaller: positions are off by `2^-DEEPEST` of the face's size squared.
const DEEPEST: u32 = 50;

/// True where a side of the face is a boundary that stays linear.
pub(super) fn has_side(t: &Topology, face: Face) -> bool {
    t.interpolation == Interpolation::LinearBoundaries
        && (0..t.sides(face)).any(|c| t.is_boundary(t.edge(t.half_edge(face, c))))
}

/// Where the way along the boundary ends: at a corner of the face, or at last somewhere between.
pub(crate) struct LinearEnds {
    /// Positions of the face's corners among its points.
    corners: Vec<u32>,
    /// Vertices with a closed form at the face's own corners, and their points.
    at_corner: Vec<Option<(Arc<SpecialVertex>, Rows)>>,
}

impl LinearEnds {
    /// Those of face 0 of `t`, a cut-out.
    pub fn new(t: &Topology, scheme: Scheme, specials: &SpecialVertices) -> Self {
        let at_corner = (0..t.sides(Face(0))).map(|c| at_corner(t, c, scheme, specials)).collect();
        Self { corners: t.face_vertices(Face(0)).to_vec(), at_corner }
    }

    /// Weights over the face's points where the way ends at `(u, v)`.
    pub fn weights(
        &self,
        split: SplitKind,
        u: f64,
        v: f64,
        depth: u32,
        points: usize,
        count: usize,
    ) -> Option<PointWeights> {
        let places: &[[f64; 2]] = match split {
            SplitKind::Quads => &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            SplitKind::Triangles => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        };
        let corner = places.iter().position(|place| *place == [u, v]);
        if let Some((vertex, rows)) = corner.and_then(|c| self.at_corner[c].as_ref()) {
            let local = vertex.weights(0.0, 0.0, count);
            return Some(through(local, points, count, |row, out| rows.left_multiply(row, out)));
        }
        (depth >= DEEPEST).then(|| {
            let mut out = PointWeights::default();
            for (row, local) in out.rows.iter_mut().zip(linear(split, u, v).rows).take(count) {
                *row = vec![0.0; points];
                self.corners.iter().zip(local).for_each(|(&c, w)| row[c as usize] += w);
            }
            // Every vertex of every level on the boundary is a corner with two faces, whose step has a Jordan block at
            // 1/2: the derivative across grows with the depth.
            out.at_vertex = Some(AtVertex { derivatives: Derivatives::Diverges, plane: None, unique_normal: false });
            out
        })
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        4 * self.corners.len() + self.at_corner.iter().flatten().map(|(_, rows)| rows.bytes()).sum::<usize>()
    }
}

/// The closed form at a corner on the boundary that is no plain spline corner.
fn at_corner(t: &Topology, c: usize, scheme: Scheme, specials: &SpecialVertices) -> Option<(Arc<SpecialVertex>, Rows)> {
    let h = t.half_edge(Face(0), c);
    let kind = corner(t, h, scheme.split()).0;
    let all_regular = (0..t.face_count() as u32).all(|f| t.sides(Face(f)) == scheme.patch_sides());
    if kind.kind != Kind::Corner || kind.is_regular() || has_finite_sharpness(t, h) || !all_regular {
        return None;
    }
    let vertex = specials.get(kind);
    let mut points = ring_points(t, h, scheme.split());
    // At the vertex itself the points beyond its ring have no weight.
    points.resize(vertex.points(), Combination::default());
    Some((vertex, Rows::new(t.vertex_count(), &points)))
}
