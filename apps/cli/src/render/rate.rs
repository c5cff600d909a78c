//! How finely to tessellate for a picture.

use subsurf::{Edge, PatchTable, Scheme};
use subsurf_render::{Camera, View};

/// Longest side of a facet in the picture. Larger shows corners in outlines, smaller only costs time (normals are exact
/// at any size). Chosen on a cube that fills 720 rows.
const FACET_PX: f64 = 3.0;
/// This share of edges gets facets that small; a few very long edges shall not make all others too fine.
const SHARE: f64 = 0.98;
/// Most triangles. More take longer to arrange than to look at.
const MOST_TRIANGLES: f64 = 2e6;

/// Facets along each side of a face for a picture of `size` pixels.
pub fn for_picture(table: &PatchTable, points: &[[f32; 3]], camera: Camera, size: [u32; 2]) -> u32 {
    let t = table.topology();
    let [width, height] = size.map(f64::from);
    let used: Vec<[f32; 3]> = t.corners().iter().map(|&v| points[v as usize]).collect();
    let view = camera.view(&used, width / height);
    let mut lengths: Vec<f64> = (0..t.edge_count())
        .map(|e| length_px(&view, height, t.edge_vertices(Edge::new(e)).map(|v| points[v.index()])))
        .collect();
    let at = ((lengths.len() as f64 * SHARE) as usize).min(lengths.len().saturating_sub(1));
    let length = *lengths.select_nth_unstable_by(at, f64::total_cmp).1;
    // A face of n sides has the facets of n/4 quads, two triangles each; under Loop those of one triangle.
    let share = if table.scheme() == Scheme::Loop { 3.0 } else { 2.0 };
    let most = (MOST_TRIANGLES * share / t.half_edge_count() as f64).sqrt();
    (length / FACET_PX).min(most).ceil().max(2.0) as u32
}

/// Mean length of edges in a picture of `size` pixels if they lay across the view.
pub fn mean_px(edges: &[[u32; 2]], points: &[[f32; 3]], camera: Camera, size: [u32; 2]) -> f64 {
    let [width, height] = size.map(f64::from);
    let used: Vec<[f32; 3]> = edges.as_flattened().iter().map(|&v| points[v as usize]).collect();
    let view = camera.view(&used, width / height);
    let sum: f64 = edges.iter().map(|edge| length_px(&view, height, edge.map(|v| points[v as usize]))).sum();
    sum / edges.len().max(1) as f64
}

/// Length of a segment in the picture if it lay across the view.
pub fn length_px(view: &View, height: f64, ends: [[f32; 3]; 2]) -> f64 {
    let [a, b] = ends.map(|p| p.map(f64::from));
    let subtract = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let forward = subtract(view.target, view.eye);
    let distance = dot(forward, forward).sqrt();
    let middle = [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]));
    // What is close to the eye or behind it counts as if it were some way off.
    let depth = (dot(subtract(middle, view.eye), forward) / distance).max(0.05 * distance);
    let along = subtract(b, a);
    dot(along, along).sqrt() / depth * height / (2.0 * (view.fov_deg.to_radians() / 2.0).tan())
}
