//! The crate `subdiv-kernels`: uniform refinement, stencils, and evaluation of the limit on a refined level. Panics of its
//! own become errors.

use crate::shape::{Scheme, Shape};
use std::collections::HashMap;
use std::num::NonZeroU8;
use std::panic::{AssertUnwindSafe, catch_unwind};
use subdiv_kernels::topology::Mesh;
use subdiv_kernels::{
    BoundaryInterpolation, LimitEvaluator, RefinementResult, Refiner, SchemeOptions, StencilTable, UniformRefine,
};
use subsurf::Boundary;

/// What it takes: a mesh with a list of edges. Making that list is not on the clock.
pub struct KernelMesh {
    mesh: Mesh,
    scheme: subdiv_kernels::Scheme,
    options: SchemeOptions,
}

impl KernelMesh {
    pub fn new(shape: &Shape) -> Self {
        let pair = |a: u32, b: u32| (a.min(b), a.max(b));
        let sharp: HashMap<(u32, u32), f32> =
            shape.tags.creases.iter().map(|c| (pair(c.vertices[0], c.vertices[1]), c.sharpness as f32)).collect();
        let mut edges = Vec::new();
        let mut seen = std::collections::HashSet::new();
        let mut start = 0;
        for &sides in &shape.counts {
            let face = &shape.indices[start..start + sides as usize];
            start += sides as usize;
            for (i, &a) in face.iter().enumerate() {
                let edge = pair(a, face[(i + 1) % face.len()]);
                if seen.insert(edge) {
                    edges.push(edge);
                }
            }
        }
        let mut corners = vec![0.0; shape.positions.len()];
        shape.tags.corners.iter().for_each(|c| corners[c.vertex as usize] = c.sharpness as f32);
        let mesh = Mesh {
            vertex_count: shape.positions.len() as u32,
            face_vertex_counts: shape.counts.clone(),
            face_vertex_indices: shape.indices.clone(),
            edge_creases: edges.iter().map(|e| sharp.get(e).copied().unwrap_or(0.0)).collect(),
            edge_vertices: edges.into_iter().map(|(a, b)| [a, b]).collect(),
            vertex_corners: corners,
        };
        let boundary_interpolation = match shape.tags.rules.boundary {
            Boundary::EdgeAndCorner => BoundaryInterpolation::EdgesAndCorners,
            Boundary::EdgeOnly => BoundaryInterpolation::EdgesOnly,
            Boundary::None => BoundaryInterpolation::Natural,
        };
        let scheme = match shape.scheme {
            Scheme::Loop => subdiv_kernels::Scheme::Loop,
            _ => subdiv_kernels::Scheme::CatmullClark,
        };
        Self { mesh, scheme, options: SchemeOptions { boundary_interpolation, ..SchemeOptions::default() } }
    }

    /// `Refiner::new` and `refine_uniform`.
    ///
    /// # Errors
    /// What the crate says, or that it panics.
    pub fn refine(&self, level: u32) -> Result<RefinementResult, String> {
        let levels = NonZeroU8::new(level as u8).expect("one level at least");
        guarded(|| {
            let refiner = Refiner::new(self.mesh.clone(), self.scheme, self.options)?;
            refiner.refine_uniform(&UniformRefine::from(levels))
        })
    }
}

/// The last level's vertices as weighted sums of control points.
///
/// # Errors
/// If the crate panics.
pub fn compose(refined: &RefinementResult, control: usize) -> Result<StencilTable, String> {
    catch_unwind(AssertUnwindSafe(|| refined.compose_stencils(control))).map_err(|_| "panics".to_string())
}

/// Positions of the last level.
///
/// # Errors
/// If the crate panics.
pub fn interpolate(refined: &RefinementResult, control: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, String> {
    catch_unwind(AssertUnwindSafe(|| refined.interpolate(control))).map_err(|_| "panics".to_string())
}

/// Position and first derivatives at places of the refined level: faces and parameters.
///
/// # Errors
/// What the crate says of the first place that it cannot evaluate, or that it panics.
pub fn eval(
    evaluator: &LimitEvaluator<'_>,
    places: &[(u32, [f32; 2])],
    out: &mut [[[f32; 3]; 3]],
) -> Result<(), String> {
    guarded(|| {
        for (&(face, uv), row) in places.iter().zip(out) {
            let (position, du, dv) = evaluator.eval_with_derivatives(face, uv)?;
            *row = [position, du, dv];
        }
        Ok::<_, subdiv_kernels::KernelError>(())
    })
}

fn guarded<R, E: std::fmt::Display>(work: impl FnOnce() -> Result<R, E>) -> Result<R, String> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(result) => result.map_err(|e| e.to_string()),
        Err(_) => Err("panics".to_string()),
    }
}
