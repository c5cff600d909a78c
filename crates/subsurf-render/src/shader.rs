//! What the renderer asks about the surface: its normal, and its colour.
//!
//! The renderer finds where a ray meets a triangle, and asks for everything else there: a shader over an exact surface
//! gives exact normals in every sample, however coarse the triangles are.

use crate::{Phase, RenderMesh, palette};
use glam::Vec3;

/// A place on the surface: on a triangle, and in the surface's own parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceAt {
    /// Index of the triangle in [`RenderMesh::triangles`].
    pub triangle: u32,
    /// Weights of its corners; they add up to one.
    pub barycentric: [f32; 3],
    /// Face of the control mesh.
    pub face: u32,
    /// Sub-face of the face.
    pub subface: u32,
    /// First surface parameter, interpolated over the triangle.
    pub u: f64,
    /// Second surface parameter.
    pub v: f64,
}

/// A place on the surface, seen from somewhere: all that a colour may depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Where on the surface.
    pub at: SurfaceAt,
    /// Where in space: on the triangle.
    pub position: [f32; 3],
    /// Normal of length one, on the side that is seen.
    pub normal: [f32; 3],
    /// Direction of length one towards the eye.
    pub view: [f32; 3],
    /// Whether the front (counter-clockwise) side is seen.
    pub front: bool,
}

/// Normals and colours of a surface.
pub trait SurfaceShader: Sync {
    /// A normal of any length and either side, or `None` where there is none: the triangle's own is taken there.
    fn normal(&self, at: &SurfaceAt) -> Option<[f64; 3]>;

    /// The base colour (diffuse reflectance), linear RGB, 0 to 1.
    fn color(&self, point: &SurfacePoint) -> [f32; 3] {
        let _ = point;
        palette::clay()
    }

    /// The place among stripes, asked where [`Show::Isophotes`](crate::Show) or [`Show::ReflectionLines`](crate::Show)
    /// is shown; without one, the colour is taken.
    fn phase(&self, point: &SurfacePoint) -> Option<Phase> {
        let _ = point;
        None
    }
}

/// The triangles as they are: every one flat.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faceted;

impl SurfaceShader for Faceted {
    fn normal(&self, _: &SurfaceAt) -> Option<[f64; 3]> {
        None
    }
}

/// Interpolated vertex normals, for meshes without a surface to ask.
#[derive(Clone, Debug)]
pub struct VertexNormals {
    /// One per corner of each triangle.
    corners: Vec<[Vec3; 3]>,
}

impl VertexNormals {
    /// Interpolates `normals`, one for each position of `mesh`.
    ///
    /// # Panics
    /// If a triangle names a normal that does not exist.
    pub fn new(mesh: &RenderMesh, normals: &[[f32; 3]]) -> Self {
        Self { corners: mesh.triangles.iter().map(|t| t.corners.map(|i| normals[i as usize].into())).collect() }
    }

    /// Averages the normals of the triangles around each vertex, weighted by area.
    ///
    /// # Panics
    /// If a triangle names a position that does not exist.
    pub fn averaged(mesh: &RenderMesh) -> Self {
        let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
        for t in &mesh.triangles {
            let [a, b, c] = t.corners.map(|i| Vec3::from(mesh.positions[i as usize]));
            let normal = (b - a).cross(c - a);
            for i in t.corners {
                sums[i as usize] += normal;
            }
        }
        let normals: Vec<[f32; 3]> = sums.iter().map(|n| n.normalize_or_zero().to_array()).collect();
        Self::new(mesh, &normals)
    }
}

impl SurfaceShader for VertexNormals {
    fn normal(&self, at: &SurfaceAt) -> Option<[f64; 3]> {
        let [a, b, c] = self.corners[at.triangle as usize];
        let [wa, wb, wc] = at.barycentric;
        let normal = a * wa + b * wb + c * wc;
        (normal != Vec3::ZERO).then(|| normal.as_dvec3().to_array())
    }
}
