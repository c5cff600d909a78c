//! Renders an OBJ file with averaged normals, or, without one, a bumpy sphere with exact normals, to a PNG file.
//!
//! `cargo run --release -p subsurf-render --example clay -- OUT.png [MODEL.obj] [SHOW] [CAMERA] [transparent]`

use std::time::Instant;
use subsurf_render::{
    Background, Legend, Options, Overlay, RenderMesh, RenderTriangle, Scene, Show, SurfaceAt, SurfacePoint,
    SurfaceShader, VertexNormals, palette,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let out = args.first().ok_or("usage: clay OUT.png [MODEL.obj] [SHOW] [CAMERA] [transparent]")?;
    let mut options = Options::default();
    if let Some(show) = args.get(2) {
        options.show = show.parse()?;
    }
    if let Some(camera) = args.get(3) {
        options.camera = camera.parse()?;
    }
    if args.get(4).is_some_and(|arg| arg == "transparent") {
        options.background = Background::Transparent;
    }

    let model = args.get(1).map(String::as_str).filter(|path| path.ends_with(".obj"));
    let (mesh, edges, shader): (_, _, Box<dyn SurfaceShader>) = match model {
        Some(path) => {
            let Model { mesh, edges } = read_obj(&std::fs::read_to_string(path)?)?;
            let normals = VertexNormals::averaged(&mesh);
            (mesh, edges, Box::new(Painted(normals)))
        }
        None => {
            let mesh = BumpySphere.mesh(1000, 500);
            (mesh, vec![], Box::new(Painted(BumpySphere)))
        }
    };
    let mut overlay = match options.show {
        Show::Wireframe => Overlay::wireframe(edges.iter().map(|e| e.map(|i| mesh.positions[i as usize]).to_vec())),
        Show::Cage => Overlay::cage(&mesh.positions, &edges),
        _ => Overlay::default(),
    };
    if matches!(options.show, Show::Patches | Show::Levels) {
        let names = ["regular", "single crease", "valence 3", "valence 5", "boundary", "corner", "other"];
        let entries = names.iter().enumerate().map(|(i, name)| (palette::category(i), (*name).to_owned())).collect();
        overlay.legend = Some(Legend { entries, ..Legend::default() });
    }

    let start = Instant::now();
    let scene = Scene::new(&mesh)?;
    let built = start.elapsed();
    let image = scene.render(&*shader, &overlay, &options, None)?;
    println!("{} triangles: arranged in {built:.2?}, all done in {:.2?}", mesh.triangles.len(), start.elapsed());
    image.write_png(std::io::BufWriter::new(std::fs::File::create(out)?))?;
    Ok(())
}

/// Any shader, with faces in the colours of the palette.
struct Painted<S>(S);

impl<S: SurfaceShader> SurfaceShader for Painted<S> {
    fn normal(&self, at: &SurfaceAt) -> Option<[f64; 3]> {
        self.0.normal(at)
    }

    fn color(&self, point: &SurfacePoint) -> [f32; 3] {
        palette::category(point.at.face as usize % 7)
    }
}

/// The sphere r(d) = 1 + 0.15 sin 7x sin 9y sin 8z + 0.02 sin 40x sin 40y, by longitude u and latitude v.
struct BumpySphere;

impl BumpySphere {
    fn position(&self, u: f64, v: f64) -> [f64; 3] {
        let (a, b) = (u * std::f64::consts::TAU, v * std::f64::consts::PI);
        let d = [a.sin() * b.sin(), b.cos(), a.cos() * b.sin()];
        let r = 1.0
            + 0.15 * (7.0 * d[0]).sin() * (9.0 * d[1]).sin() * (8.0 * d[2]).sin()
            + 0.02 * (40.0 * d[0]).sin() * (40.0 * d[1]).sin();
        d.map(|x| x * r)
    }

    fn mesh(&self, columns: u32, rows: u32) -> RenderMesh {
        let uv = |i: u32, j: u32| [i as f32 / columns as f32, j as f32 / rows as f32];
        let index = |i: u32, j: u32| j * (columns + 1) + i;
        let mut mesh = RenderMesh::default();
        for j in 0..=rows {
            for i in 0..=columns {
                let [u, v] = uv(i, j).map(f64::from);
                mesh.positions.push(self.position(u, v).map(|x| x as f32));
            }
        }
        for j in 0..rows {
            for i in 0..columns {
                let (a, b, c, d) = ((i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j));
                for corners in [[a, b, c], [a, c, d]] {
                    mesh.triangles.push(RenderTriangle {
                        corners: corners.map(|(i, j)| index(i, j)),
                        face: (8 * i / columns) + 8 * (8 * j / rows),
                        subface: 0,
                        uv: corners.map(|(i, j)| uv(i, j)),
                    });
                }
            }
        }
        mesh
    }
}

impl SurfaceShader for BumpySphere {
    fn normal(&self, at: &SurfaceAt) -> Option<[f64; 3]> {
        let h = 1e-5;
        let difference = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] - b[i]);
        let du = difference(self.position(at.u + h, at.v), self.position(at.u - h, at.v));
        let dv = difference(self.position(at.u, at.v + h), self.position(at.u, at.v - h));
        Some([1, 2, 0].map(|i| {
            let j = (i + 1) % 3;
            dv[i] * du[j] - dv[j] * du[i]
        }))
    }
}

/// A mesh and the edges of its faces.
struct Model {
    mesh: RenderMesh,
    edges: Vec<[u32; 2]>,
}

/// Positions and faces of an OBJ file.
fn read_obj(text: &str) -> Result<Model, Box<dyn std::error::Error>> {
    let mut mesh = RenderMesh::default();
    let mut edges = Vec::new();
    let mut face = 0;
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let p = words.take(3).map(str::parse).collect::<Result<Vec<f32>, _>>()?;
                mesh.positions.push(p.try_into().map_err(|_| "a vertex needs three coordinates")?);
            }
            Some("f") => {
                let corners = words
                    .map(|word| word.split('/').next().unwrap_or(word).parse::<u32>().map(|i| i - 1))
                    .collect::<Result<Vec<u32>, _>>()?;
                for i in 1..corners.len() - 1 {
                    let corners = [corners[0], corners[i], corners[i + 1]];
                    mesh.triangles.push(RenderTriangle { corners, face, ..RenderTriangle::default() });
                }
                edges.extend((0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]]));
                face += 1;
            }
            _ => {}
        }
    }
    edges.iter_mut().for_each(|edge| edge.sort_unstable());
    edges.sort_unstable();
    edges.dedup();
    Ok(Model { mesh, edges })
}
