//! How smooth normals are round an extraordinary vertex, measured on rings that shrink to it: divided differences of the
//! field over differences of the surface, projected to the tangent plane at the vertex. In these coordinates the surface
//! is smooth there, and so a field is continuously differentiable if and only if its gradients all have the same limit.

use subsurf::{Level, Location, Method, PatchTable, Scheme, ShadingNormals, ShadingOptions, shapes};

/// A vertex amid rings of faces; its faces have it at their corner 0.
pub struct Centre {
    pub patches: PatchTable,
    pub positions: Vec<[f64; 3]>,
    faces: Vec<u32>,
}

impl Centre {
    /// Of valence `n`, without symmetries: three rings of quads or four of triangles, so that nothing at the boundary
    /// has a say in the blend next to the vertex.
    pub fn new(scheme: Scheme, n: u32) -> Self {
        if scheme != Scheme::Loop {
            let shape = shapes::interior_vertex(n);
            let patches = PatchTable::new(&shape.mesh, scheme).expect("a shape is a mesh");
            return Self { patches, positions: shape.positions, faces: (0..n).map(|s| 9 * s).collect() };
        }
        let shape = shapes::interior_triangles(n);
        let coarse = Level::new(&shape.mesh, scheme).expect("a shape is a mesh");
        let positions = coarse.refine_values(&shape.positions);
        let topology = coarse.refine().expect("a shape is small").topology().clone();
        let patches = PatchTable::from_topology(topology, scheme, Method::default()).expect("a level is a mesh");
        // Of four faces a sector the first is at the vertex, and so is the first of its four children.
        Self { patches, positions, faces: (0..n).map(|s| 16 * s).collect() }
    }

    pub fn shading(&self, options: &ShadingOptions) -> ShadingNormals<'_> {
        ShadingNormals::new(&self.patches, &self.positions, options).expect("options fit")
    }

    /// The largest distance of a gradient on ring `depth` from their mean: gradients are 3 × 2 matrices.
    pub fn spread(&self, shading: &ShadingNormals<'_>, depth: i32) -> f64 {
        let surface = self.patches.surface(&self.positions);
        let origin = surface.eval(Location::new(self.faces[0], 0.0, 0.0)).expect("no hole");
        let up = origin.normal().expect("smooth there");
        let [x, y] = plane(up);
        let r = 0.5f64.powi(depth);
        let sample = |face: u32, u: f64, v: f64| {
            let at = Location::new(face, r * u, r * v);
            let jet = surface.eval(at).expect("no hole");
            let from: [f64; 3] = std::array::from_fn(|i| jet.position[i] - origin.position[i]);
            ([dot(from, x), dot(from, y)], shading.normal(at, &jet).expect("smooth there"))
        };
        let mut gradients = Vec::new();
        for &face in &self.faces {
            for (u, v) in [(0.75, 0.1), (0.45, 0.45), (0.1, 0.75)] {
                let difference = |du: f64, dv: f64| {
                    let (a, b) = (sample(face, u + du, v + dv), sample(face, u - du, v - dv));
                    let n: [f64; 3] = std::array::from_fn(|i| a.1[i] - b.1[i]);
                    ([a.0[0] - b.0[0], a.0[1] - b.0[1]], n)
                };
                let ([a, c], nu) = difference(0.02, 0.0);
                let ([b, d], nv) = difference(0.0, 0.02);
                // Solves G · [a b; c d] = [nu nv].
                let det = a * d - b * c;
                gradients.push(std::array::from_fn::<[f64; 2], 3, _>(|i| {
                    [(nu[i] * d - nv[i] * c) / det, (nv[i] * a - nu[i] * b) / det]
                }));
            }
        }
        let count = gradients.len() as f64;
        let mean = |i: usize, k: usize| gradients.iter().map(|g| g[i][k]).sum::<f64>() / count;
        let far = |g: &[[f64; 2]; 3]| {
            (0..3).flat_map(|i| (0..2).map(move |k| (i, k))).map(|(i, k)| (g[i][k] - mean(i, k)).powi(2)).sum::<f64>()
        };
        gradients.iter().map(far).fold(0.0, |most, x| if x > most || x.is_nan() { x } else { most }).sqrt()
    }
}

fn plane(n: [f64; 3]) -> [[f64; 3]; 2] {
    let axis = if n[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let x = cross(axis, n);
    let length = dot(x, x).sqrt();
    let x = x.map(|c| c / length);
    [x, cross(n, x)]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
