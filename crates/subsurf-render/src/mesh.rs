//! The triangles to draw, and where each lies on the surface.

use crate::SceneError;

/// A tessellated limit surface, or any other triangle mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderMesh {
    /// Positions in model units, +y up.
    pub positions: Vec<[f32; 3]>,
    /// Triangles over them, counter-clockwise seen from the front.
    pub triangles: Vec<RenderTriangle>,
}

/// A triangle and its place in the parameter domain of the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderTriangle {
    /// Indices into [`RenderMesh::positions`].
    pub corners: [u32; 3],
    /// Face of the control mesh.
    pub face: u32,
    /// Sub-face of that face; 0 where faces are whole.
    pub subface: u32,
    /// Surface parameters (u, v) of the corners.
    pub uv: [[f32; 2]; 3],
}

impl RenderMesh {
    /// A mesh from triangles that lie on no surface: triangle `i` is face `i`, its corners are (0,0), (1,0), (0,1).
    pub fn from_triangles(positions: Vec<[f32; 3]>, corners: &[[u32; 3]]) -> Self {
        let triangles = (0..)
            .zip(corners)
            .map(|(face, &corners)| RenderTriangle {
                corners,
                face,
                subface: 0,
                uv: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            })
            .collect();
        Self { positions, triangles }
    }

    /// Something to draw, all of it finite and in range.
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        if self.triangles.is_empty() {
            return Err(SceneError::NoTriangles);
        }
        if self.triangles.len() > 1 << 30 {
            return Err(SceneError::TooManyTriangles { count: self.triangles.len() });
        }
        // Squares of coordinates must not overflow.
        if let Some(vertex) = self.positions.iter().position(|p| !p.iter().all(|x| x.abs() < 1e18)) {
            return Err(SceneError::PositionNotFinite { vertex, position: self.positions[vertex] });
        }
        for (triangle, t) in self.triangles.iter().enumerate() {
            for vertex in t.corners {
                if vertex as usize >= self.positions.len() {
                    return Err(SceneError::VertexOutOfRange { triangle, vertex, vertices: self.positions.len() });
                }
            }
        }
        Ok(())
    }
}
