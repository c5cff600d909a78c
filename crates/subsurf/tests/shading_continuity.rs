//! Which shading normals are continuously differentiable, measured: at extraordinary vertices, where limit normals turn
//! without bound, and at the rim of what is blended.

mod rings;

use rings::Centre;
use subsurf::{
    Blend, HalfEdge, Level, Location, NormalField, PatchTable, Power, Scheme, ShadingNormals, ShadingOptions,
};
use subsurf::{ControlMesh, Face, Spectrum, Tags};

const SCHEMES: [Scheme; 2] = [Scheme::CatmullClark, Scheme::Loop];

fn options(field: NormalField, p: f64) -> ShadingOptions {
    ShadingOptions { field, power: Power::Uniform(p), ..ShadingOptions::default() }
}

#[test]
fn gradients_of_a3_a4_and_subdivided_normals_have_one_limit_at_extraordinary_vertices() {
    for scheme in SCHEMES {
        for n in [3, 5, 7, 12] {
            let centre = Centre::new(scheme, n);
            let spectrum = Spectrum::of_interior(scheme, n).unwrap();
            let smooth = [NormalField::Subdivided, NormalField::Blended(Blend::A3), NormalField::Blended(Blend::A4)];
            for field in smooth {
                for p in [0.5, 1.0, 2.0] {
                    let shading = centre.shading(&options(field, p));
                    let (start, end) = (centre.spread(&shading, 6), centre.spread(&shading, 36));
                    // Subdivided normals depart from linear ones by (μ/λ)^m, the blend by (μ/λ)^2m; beside that, rounding
                    // of normals over differences of size λ^m.
                    let rate = (spectrum.mu / spectrum.lambda).max(0.125 / spectrum.lambda);
                    let rounding = 1e-13 / spectrum.lambda.powi(36);
                    let bound = 10.0 * start * rate.powi(30) + rounding;
                    assert!(end < bound, "{scheme:?} valence {n} {field:?} p {p}: {start:e} to {end:e}, {bound:e}");
                }
            }
        }
    }
}

#[test]
fn gradients_of_limit_normals_and_a2_have_none() {
    for scheme in SCHEMES {
        for n in [5, 7, 12] {
            let centre = Centre::new(scheme, n);
            for field in [NormalField::Limit, NormalField::Blended(Blend::A2)] {
                let shading = centre.shading(&options(field, 1.0));
                let (start, end) = (centre.spread(&shading, 20), centre.spread(&shading, 30));
                // They grow by μ/λ² per level: 1.12 at valence 5; under Loop 1 there, once a faster mode is gone.
                assert!(end > 0.9 * start && start > 1e-3, "{scheme:?} valence {n} {field:?}: {start:e} to {end:e}");
            }
        }
    }
}

#[test]
fn one_minus_the_blend_weight_falls_at_the_same_rate_whatever_the_power() {
    // So the bound of the published theorem, which lets it fall as the p-th power, is not sharp: valence 12 and p = 1/2
    // violate it, yet gradients have a limit.
    let centre = Centre::new(Scheme::CatmullClark, 12);
    let spectrum = Spectrum::of_interior(Scheme::CatmullClark, 12).unwrap();
    assert!(spectrum.theorem_ratio(0.5) > 1.0 && spectrum.gradient_ratio() < 1.0);
    let shading = centre.shading(&options(NormalField::Blended(Blend::A3), 1.0));
    for p in [0.25, 0.5, 1.0, 2.0] {
        let gap = |depth: i32| {
            let r = 0.5f64.powi(depth);
            1.0 - shading.blend_weight(Location::new(0, 0.7 * r, 0.2 * r)).powf(p)
        };
        let rate = (gap(20) / gap(10)).powf(0.1);
        // The next round mode is a fifth of the first.
        assert!((rate - spectrum.mu_round).abs() < 1e-3, "p {p}: {rate}");
    }
}

/// Blend weights at distances 2^-1, 2^-2 … (of a face) from the rim of what A4 blends round a vertex of valence 5, on the
/// way to the middle of a side of that region.
fn towards_the_rim(scheme: Scheme) -> Vec<f64> {
    let distances = (1..20).map(|m| 0.5f64.powi(m));
    if scheme == Scheme::CatmullClark {
        let centre = Centre::new(scheme, 5);
        let shading = centre.shading(&ShadingOptions::default());
        // Face 2 of a sector reaches from two edges off the vertex to three.
        return distances.map(|d| shading.blend_weight(Location::new(2, 1.0 - d, 0.4))).collect();
    }
    let mesh = fine_icosahedron();
    let patches = PatchTable::new(&mesh, scheme).unwrap();
    let shading =
        ShadingNormals::new(&patches, &vec![[0.0; 3]; mesh.vertex_count()], &ShadingOptions::default()).unwrap();
    // From a face at vertex 0 across the opposite side, then straight on through the vertex behind it: the rim is the far
    // side of that triangle.
    let t = patches.topology();
    let start = (0..t.half_edge_count() as u32).map(HalfEdge).find(|&h| t.origin(h).0 == 0).unwrap();
    let mut h = t.prev(t.twin(t.next(start)).unwrap());
    for _ in 0..3 {
        h = t.turn_left(h).unwrap();
    }
    let (face, corner) = (t.face(h), h.index() % 3);
    let weight = |d: f64| {
        let mut barycentric = [0.0; 3];
        barycentric[corner] = d;
        barycentric[(corner + 1) % 3] = 0.6 * (1.0 - d);
        barycentric[(corner + 2) % 3] = 0.4 * (1.0 - d);
        shading.blend_weight(Location { face, subface: 0, u: barycentric[1], v: barycentric[2] })
    };
    distances.map(weight).collect()
}

/// Triangles whose twelve vertices of valence 5 lie eight edges apart; all others have valence 6.
fn fine_icosahedron() -> ControlMesh {
    let around =
        |pole: u32, ring: u32, turn: u32| (0..5).map(move |i| [pole, ring + (i + turn) % 5, ring + (i + 1 - turn) % 5]);
    let between = (0..5).flat_map(|i| [[1 + i, 6 + i, 1 + (i + 1) % 5], [1 + (i + 1) % 5, 6 + i, 6 + (i + 1) % 5]]);
    let faces: Vec<[u32; 3]> = around(0, 1, 0).chain(between).chain(around(11, 6, 1)).collect();
    let mut level = Level::new(&ControlMesh::new(&faces, Tags::default()).unwrap(), Scheme::Loop).unwrap();
    for _ in 0..3 {
        level = level.refine().unwrap();
    }
    let t = level.topology();
    let faces: Vec<&[u32]> = (0..t.face_count()).map(|f| t.face_vertices(Face::new(f))).collect();
    ControlMesh::new(&faces, Tags::default()).unwrap()
}

#[test]
fn at_the_rim_the_blend_is_differentiable_for_powers_above_a_third_only() {
    for scheme in SCHEMES {
        let b = towards_the_rim(scheme);
        let slope = |p: f64, m: usize| b[m - 1].powf(p) * 2f64.powi(m as i32);
        // b falls as the cube of the distance, so that b^p over it goes as its power 3p - 1.
        for (p, factor) in [(0.25, 2f64.powf(0.25)), (0.3, 2f64.powf(0.1)), (0.4, 2f64.powf(-0.2)), (1.0, 0.25)] {
            let rate = slope(p, 14) / slope(p, 13);
            assert!((rate - factor).abs() < 1e-3, "{scheme:?} p {p}: {rate} {factor}");
        }
    }
}
