//! Where on the surface, and what is known there.

use crate::index::Face;

/// A place on the limit surface.
///
/// Under Catmull-Clark and bilinear subdivision a quad is `[0,1]²` with (0,0) at its first corner, u along its first edge, v along its last. An n-gon is n sub-faces in
/// the order of its corners, each `[0,1]²` with (0,0) at the corner, u along the edge to the next corner, v along the
/// edge to the previous one, and (1,1) at the centre. Under Loop a triangle is `u, v ≥ 0, u + v ≤ 1` with (0,0), (1,0),
/// (0,1) at its corners.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Location {
    /// A face of the control mesh.
    pub face: Face,
    /// 0 for quads (triangles under Loop), the corner for other faces.
    pub subface: u32,
    /// First parameter, in `[0, 1]`.
    pub u: f64,
    /// Second parameter, in `[0, 1]`.
    pub v: f64,
}

impl Location {
    /// A place on a face that is one patch: a quad, or a triangle under Loop.
    pub fn new(face: u32, u: f64, v: f64) -> Self {
        Self { face: Face(face), subface: 0, u, v }
    }
}

/// What the derivatives of a jet are.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Derivatives {
    /// The derivatives with respect to u and v.
    #[default]
    Finite,
    /// At an extraordinary vertex where they are zero (valence 3, say): `du`, `dv` hold the limits of their directions.
    Vanishes,
    /// At an extraordinary vertex where they grow without bound: `du`, `dv` hold the limits of their directions. On a
    /// face-varying boundary that is kept linear, where the derivative across grows slowly: `du`, `dv` hold differences
    /// over 2⁻⁵⁰ of a face.
    Diverges,
}

/// Position and derivatives at one location, in `f64` whatever the precision of the control points.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Jet<const N: usize> {
    /// The point of the limit surface.
    pub position: [f64; N],
    /// First derivative in u; a direction where [`derivatives`](Self::derivatives) is not finite.
    pub du: [f64; N],
    /// First derivative in v; a direction where [`derivatives`](Self::derivatives) is not finite.
    pub dv: [f64; N],
    /// Second derivatives in uu, uv, vv; none at special vertices, where they are unbounded or depend on the direction.
    pub second: Option<[[f64; N]; 3]>,
    /// What `du` and `dv` are.
    pub derivatives: Derivatives,
    /// Two vectors that span the tangent plane; none where the surface has none (cone points, interior valence 2).
    pub plane: Option<[[f64; N]; 2]>,
    /// False at creased and pinned vertices whose normal depends on the direction of approach (more than four faces in a
    /// crease's sector, more than two in a corner's); the plane is then spanned by the sharp edges, or by the crease and
    /// the direction across.
    pub unique_plane: bool,
}

/// Principal, Gaussian and mean curvature, in one over the unit of length.
///
/// Signs: positive where the surface bends towards the normal, as a sphere's inside would. Seen with outward normals, a
/// sphere of radius r has both curvatures `-1/r`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Curvature {
    /// The principal curvature of larger value.
    pub k1: f64,
    /// The principal curvature of smaller value.
    pub k2: f64,
    /// `k1 · k2`.
    pub gaussian: f64,
    /// `(k1 + k2) / 2`.
    pub mean: f64,
}

impl<const N: usize> Jet<N> {
    /// Where the surface is regular: the derivatives are what they are and span the tangent plane.
    pub(super) fn regular([position, du, dv]: [[f64; N]; 3], second: Option<[[f64; N]; 3]>) -> Self {
        let derivatives = Derivatives::Finite;
        Self { position, du, dv, second, derivatives, plane: Some([du, dv]), unique_plane: true }
    }

    /// The same with something else in the place of every vector.
    pub(super) fn map<const M: usize>(self, f: impl Fn([f64; N]) -> [f64; M]) -> Jet<M> {
        let Self { position, du, dv, second, derivatives, plane, unique_plane } = self;
        Jet {
            position: f(position),
            du: f(du),
            dv: f(dv),
            second: second.map(|all| all.map(&f)),
            derivatives,
            plane: plane.map(|both| both.map(&f)),
            unique_plane,
        }
    }
}

impl Jet<3> {
    /// The unit normal, `∂u × ∂v` on faces that are seen counter-clockwise; none where the surface has no tangent plane.
    pub fn normal(&self) -> Option<[f64; 3]> {
        let [a, b] = self.plane?;
        unit_normal(a, b)
    }

    /// Curvature from the fundamental forms; none where second derivatives are unbounded or the plane degenerates.
    pub fn curvature(&self) -> Option<Curvature> {
        if self.derivatives != Derivatives::Finite {
            return None;
        }
        let [duu, duv, dvv] = self.second?;
        let n = self.normal()?;
        let (e, f, g) = (dot(self.du, self.du), dot(self.du, self.dv), dot(self.dv, self.dv));
        let (l, m, n) = (dot(duu, n), dot(duv, n), dot(dvv, n));
        let area_sq = e * g - f * f;
        if area_sq <= 0.0 {
            return None;
        }
        // The second fundamental form in the orthonormal basis du/|du| and what of dv is perpendicular to it: there the
        // half difference of the curvatures is a plain length, without cancellation.
        let skew = f / e;
        let (xx, xy) = (l / e, (m - skew * l) / area_sq.sqrt());
        let yy = (n - 2.0 * skew * m + skew * skew * l) * e / area_sq;
        let (mean, half) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        let all = Curvature { k1: mean + half, k2: mean - half, gaussian: xx * yy - xy * xy, mean };
        [all.k1, all.k2, all.gaussian, mean].iter().all(|k| k.is_finite()).then_some(all)
    }

    /// The principal curvatures, larger value first.
    pub fn principal_curvatures(&self) -> Option<(f64, f64)> {
        self.curvature().map(|c| (c.k1, c.k2))
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a × b` at unit length; none where they are parallel to rounding.
pub(crate) fn unit_normal(a: [f64; 3], b: [f64; 3]) -> Option<[f64; 3]> {
    let scaled = |v: [f64; 3]| {
        let size = v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        (size > 0.0 && size.is_finite()).then(|| v.map(|x| x / size))
    };
    let (a, b) = (scaled(a)?, scaled(b)?);
    let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let length = dot(n, n).sqrt();
    // Below this the cross product of two vectors of size one is all rounding.
    (length > 1e-14).then(|| n.map(|x| x / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jet(du: [f64; 3], dv: [f64; 3], second: [[f64; 3]; 3]) -> Jet<3> {
        Jet {
            position: [0.0; 3],
            du,
            dv,
            second: Some(second),
            derivatives: Derivatives::Finite,
            plane: Some([du, dv]),
            unique_plane: true,
        }
    }

    #[test]
    fn a_skewed_cylinder_has_curvatures_zero_and_one_over_its_radius() {
        // (cos u, sin u, v + u) / 1 at u = 0, radius 1.
        let j = jet([0.0, 1.0, 1.0], [0.0, 0.0, 1.0], [[-1.0, 0.0, 0.0], [0.0; 3], [0.0; 3]]);
        let (k1, k2) = j.principal_curvatures().unwrap();
        assert!((k1 - 0.0).abs() < 1e-15 && (k2 + 1.0).abs() < 1e-15, "{k1} {k2}");
    }

    #[test]
    fn a_saddle_has_opposite_curvatures() {
        let j = jet([2.0, 0.0, 0.0], [1.0, 1.0, 0.0], [[0.0, 0.0, 4.0], [0.0, 0.0, 2.0], [0.0, 0.0, 0.0]]);
        // z = (x² - y²)/2 at the origin with x = 2u + v, y = v.
        let c = j.curvature().unwrap();
        assert!((c.k1 - 1.0).abs() < 1e-14 && (c.k2 + 1.0).abs() < 1e-14 && c.mean.abs() < 1e-14);
        assert!((c.gaussian + 1.0).abs() < 1e-14);
    }

    #[test]
    fn parallel_vectors_have_no_normal() {
        assert_eq!(unit_normal([1.0, 2.0, 3.0], [-2.0, -4.0, -6.0]), None);
        assert_eq!(unit_normal([0.0; 3], [1.0, 0.0, 0.0]), None);
        assert_eq!(unit_normal([1e-200, 0.0, 0.0], [0.0, 1e200, 0.0]), Some([0.0, 0.0, 1.0]));
    }
}
