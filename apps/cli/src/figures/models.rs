//! The control meshes that figures show: some of `assets/`, and small ones made here, all as OBJ text, so that every
//! picture can be made by `subsurf render` too.

use crate::failure::Failure;
use crate::input::Input;
use std::borrow::Cow;
use std::f64::consts::PI;
use subsurf::{Rules, Scheme};
use subsurf_io::{ReadOptions, Scene, read_obj};

/// A control mesh in a file.
pub struct Model {
    /// Without `.obj`.
    pub name: &'static str,
    pub obj: Cow<'static, str>,
}

impl Model {
    fn asset(name: &'static str, obj: &'static str) -> Self {
        Self { name, obj: Cow::Borrowed(obj) }
    }

    fn made(name: &'static str, positions: &[[f64; 3]], faces: &[Vec<u32>]) -> Self {
        let vertices = positions.iter().map(|[x, y, z]| format!("v {x:.6} {y:.6} {z:.6}\n"));
        let corners = |face: &Vec<u32>| face.iter().map(|v| format!(" {}", v + 1)).collect::<String>();
        let faces = faces.iter().map(|face| format!("f{}\n", corners(face)));
        Self { name, obj: Cow::Owned(vertices.chain(faces).collect()) }
    }

    /// True where the mesh is made here rather than in `assets/`.
    pub fn is_made(&self) -> bool {
        matches!(self.obj, Cow::Owned(_))
    }

    /// The mesh.
    pub fn scene(&self) -> Result<Scene, Failure> {
        Ok(read_obj(self.obj.as_bytes(), self.name, &ReadOptions { rules: Rules::usd() })?)
    }

    /// The mesh as a verb takes it.
    pub fn input(&self, scheme: Option<Scheme>) -> Result<Input, Failure> {
        let scene = self.scene()?;
        let scheme = scheme.or(scene.scheme).unwrap_or_default();
        Ok(Input { name: self.name.to_owned(), scene, scheme })
    }
}

pub fn car() -> Model {
    Model::asset("catmark_car", include_str!("../../../../assets/catmark_car.obj"))
}

pub fn spot() -> Model {
    Model::asset("spot_control_mesh", include_str!("../../../../assets/spot_control_mesh.obj"))
}

pub fn shoes() -> Model {
    Model::asset("mh_shoes03_semisharp", include_str!("../../../../assets/mh_shoes03_semisharp.obj"))
}

/// Height of the made meshes over (x, z): a ridge, which bends one way only and so has both a round and a saddle part
/// round the vertex in its middle.
fn height(x: f64, z: f64) -> f64 {
    let across = 0.95 * x + 0.3 * z;
    1.5 * (-across * across / 3.0).exp() - 0.03 * (x * x + z * z)
}

/// `rings` rings of quads in `n` sectors round vertex 0, a sector being a skewed grid of `rings × rings`; y is up.
pub fn quads_round_a_vertex(name: &'static str, n: u32, rings: u32) -> Model {
    let (spoke, inner) = (rings, rings * rings);
    let at = |s: u32, x: u32, y: u32| match (x, y) {
        (0, 0) => 0,
        (x, 0) => 1 + (s % n) * spoke + x - 1,
        (0, y) => 1 + ((s + 1) % n) * spoke + y - 1,
        (x, y) => 1 + n * spoke + (s % n) * inner + (y - 1) * rings + x - 1,
    };
    let mut positions = vec![[0.0; 3]; (1 + n * spoke + n * inner) as usize];
    let mut faces = Vec::new();
    for s in 0..n {
        for y in 0..=rings {
            for x in 0..=rings {
                // Rings of squares become circles.
                let ring = f64::from(x.max(y));
                let along = if x >= y { f64::from(y) / ring.max(1.0) / 2.0 } else { 1.0 - f64::from(x) / ring / 2.0 };
                let phi = 2.0 * PI * (f64::from(s) + along) / f64::from(n);
                let (px, pz) = (ring * phi.cos(), -ring * phi.sin());
                positions[at(s, x, y) as usize] = [px, height(px, pz), pz];
                if x < rings && y < rings {
                    faces.push(vec![at(s, x, y), at(s, x + 1, y), at(s, x + 1, y + 1), at(s, x, y + 1)]);
                }
            }
        }
    }
    Model::made(name, &positions, &faces)
}

/// `rings` rings of triangles round vertex 0 of valence `n`; ring r has r · n vertices, all of valence 6; y is up.
pub fn triangles_round_a_vertex(name: &'static str, n: u32, rings: u32) -> Model {
    let at = |r: u32, i: u32| if r == 0 { 0 } else { 1 + n * r * (r - 1) / 2 + i % (n * r) };
    let mut positions = vec![[0.0, height(0.0, 0.0), 0.0]];
    let mut faces = Vec::new();
    for r in 1..=rings {
        for i in 0..n * r {
            let phi = 2.0 * PI * f64::from(i) / f64::from(n * r);
            let (x, z) = (f64::from(r) * phi.cos(), -f64::from(r) * phi.sin());
            positions.push([x, height(x, z), z]);
        }
        for s in 0..n {
            for j in 0..r {
                let (outer, inner) = (s * r + j, s * (r - 1) + j);
                faces.push(vec![at(r - 1, inner), at(r, outer), at(r, outer + 1)]);
                if j + 1 < r {
                    faces.push(vec![at(r - 1, inner), at(r, outer + 1), at(r - 1, inner + 1)]);
                }
            }
        }
    }
    Model::made(name, &positions, &faces)
}

/// A pole of valence `n`: triangles, then `rings` rings of quads; y is up.
pub fn pole(name: &'static str, n: u32, rings: u32) -> Model {
    let mut positions = vec![[0.0, height(0.0, 0.0), 0.0]];
    let mut faces = Vec::new();
    let at = |r: u32, i: u32| 1 + (r - 1) * n + i % n;
    for r in 1..=rings + 1 {
        for i in 0..n {
            let phi = 2.0 * PI * f64::from(i) / f64::from(n);
            let (x, z) = (f64::from(r) * phi.cos(), -f64::from(r) * phi.sin());
            positions.push([x, height(x, z), z]);
            faces.push(match r {
                1 => vec![0, at(1, i), at(1, i + 1)],
                _ => vec![at(r - 1, i), at(r, i), at(r, i + 1), at(r - 1, i + 1)],
            });
        }
    }
    Model::made(name, &positions, &faces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use subsurf::{Edge, Location, PatchTable, Vertex};

    #[test]
    fn made_meshes_have_one_extraordinary_vertex_inside_and_face_up() {
        let models = [
            (quads_round_a_vertex("a", 7, 3), Scheme::CatmullClark, 4),
            (triangles_round_a_vertex("b", 7, 3), Scheme::Loop, 6),
        ];
        for (model, scheme, regular) in models {
            let scene = model.scene().unwrap();
            let table = PatchTable::new(&scene.mesh, scheme).unwrap();
            let t = table.topology();
            let (mut valence, mut inside) = (vec![0; t.vertex_count()], vec![true; t.vertex_count()]);
            for e in (0..t.edge_count()).map(Edge::new) {
                for v in t.edge_vertices(e).map(Vertex::index) {
                    valence[v] += 1;
                    inside[v] &= !t.is_boundary(e);
                }
            }
            let odd: Vec<usize> = (0..t.vertex_count()).filter(|&v| inside[v] && valence[v] != regular).collect();
            assert_eq!(odd, [0], "{}", model.name);
            let surface = table.surface(&scene.positions);
            for face in 0..t.face_count() as u32 {
                let jet = surface.eval(Location::new(face, 0.3, 0.3)).unwrap();
                assert!(jet.normal().unwrap()[1] > 0.1, "{} face {face}", model.name);
            }
        }
    }
}
