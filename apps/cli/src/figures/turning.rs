//! How fast normals turn near an extraordinary vertex: what the pictures of shading show, as numbers.

use super::models::Model;
use crate::failure::Failure;
use subsurf::{Face, Location, PatchTable, Scheme, ShadingNormals, ShadingOptions};

/// Halvings of the distance to the vertex.
pub const DEPTHS: u32 = 14;
/// Places on an arc across a face, and the share of the way to the vertex that the next arc is nearer.
const ARC: u32 = 8;
const NEARER: f64 = 0.98;

/// The largest angle in radians between normals near each other, per distance, on arcs round vertex 0 at
/// `2^-1, …, 2^-DEPTHS` of its faces, each of which starts with it.
pub fn rates(model: &Model, scheme: Scheme, options: &ShadingOptions) -> Result<Vec<f64>, Failure> {
    let scene = model.scene()?;
    let positions = &scene.positions;
    let name = || model.name.to_owned();
    let table = PatchTable::new(&scene.mesh, scheme).map_err(|source| Failure::Mesh { name: name(), source })?;
    let shading =
        ShadingNormals::new(&table, positions, options).map_err(|source| Failure::Shading { name: name(), source })?;
    let surface = table.surface(positions);
    let t = table.topology();
    let at = |face: u32, h: f64, i: u32| {
        let s = f64::from(i) / f64::from(ARC);
        let at = Location::new(face, h * (1.0 - s), h * s);
        let jet = surface.eval(at)?;
        Some((jet.position, shading.normal(at, &jet)?))
    };
    let faces: Vec<u32> = (0..t.face_count())
        .filter(|&f| t.face_vertices(Face::new(f)).first().is_some_and(|v| *v == 0))
        .map(|f| f as u32)
        .collect();
    let rate = |depth: u32| {
        let h = (-f64::from(depth)).exp2();
        let mut most: f64 = 0.0;
        for &face in &faces {
            for i in 0..ARC {
                let here = at(face, h, i);
                for there in [at(face, h, i + 1), at(face, h * NEARER, i)] {
                    if let (Some((p, n)), Some((q, m))) = (here, there) {
                        most = most.max(2.0 * (0.5 * distance(n, m)).asin() / distance(p, q));
                    }
                }
            }
        }
        most
    };
    Ok((1..=DEPTHS).map(rate).collect())
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::models;
    use subsurf::{Blend, NormalField, Spectrum};

    #[test]
    fn limit_normals_turn_ever_faster_by_mu_over_lambda_squared_and_smooth_blends_do_not() {
        let quads = (models::quads_round_a_vertex("quads", 9, 4), Scheme::CatmullClark);
        let triangles = (models::triangles_round_a_vertex("triangles", 9, 4), Scheme::Loop);
        for (model, scheme) in [quads, triangles] {
            let last = |field| {
                let rates = rates(&model, scheme, &ShadingOptions { field, ..ShadingOptions::default() }).unwrap();
                rates[rates.len() - 1] / rates[rates.len() - 2]
            };
            let s = Spectrum::of_interior(scheme, 9).unwrap();
            // The next mode is still there at depth 14: about (its eigenvalue / mu)^14.
            assert!((last(NormalField::Limit) - s.mu / (s.lambda * s.lambda)).abs() < 0.05, "{scheme:?}");
            for field in [NormalField::Subdivided, NormalField::Blended(Blend::A3), NormalField::Blended(Blend::A4)] {
                assert!((last(field) - 1.0).abs() < 0.05, "{scheme:?} {field:?}");
            }
        }
    }
}
