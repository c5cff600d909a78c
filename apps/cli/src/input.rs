//! The control mesh that a verb works on.

use crate::args::{MeshArgs, Preset};
use crate::console::Console;
use crate::failure::Failure;
use std::io;
use std::path::Path;
use subsurf::{Channel, MeshError, Method, PatchTable, Real, Scheme, Topology, Triangles};
use subsurf_io::{ReadError, ReadOptions, Scene, read, read_obj};

/// A file's mesh under the rules in force.
pub struct Input {
    /// The file as messages call it.
    pub name: String,
    pub scene: Scene,
    pub scheme: Scheme,
}

impl Input {
    /// Reads the mesh; rules that are given as arguments win over the file's.
    pub fn load(args: &MeshArgs, triangles: Option<Triangles>, console: &Console) -> Result<Self, Failure> {
        let options = ReadOptions { rules: args.preset.unwrap_or(Preset::Usd).rules() };
        let (name, mut scene) = if args.file.as_os_str() == "-" {
            let name = "standard input".to_owned();
            let scene = read_obj(io::stdin().lock(), &name, &options)?;
            (name, scene)
        } else {
            check_format(&args.file)?;
            (args.file.display().to_string(), read(&args.file, &options)?)
        };
        let scheme = args.scheme.or(scene.scheme).unwrap_or_default();
        let mut rules = scene.mesh.tags().rules;
        rules.boundary = args.boundary.unwrap_or(rules.boundary);
        rules.creasing = args.creasing.unwrap_or(rules.creasing);
        rules.face_varying = args.face_varying.unwrap_or(rules.face_varying);
        rules.triangles = triangles.unwrap_or(rules.triangles);
        scene.mesh = scene.mesh.with_rules(rules);
        if args.split_polygons {
            if scheme != Scheme::Loop {
                return Err(Failure::Usage("--split-polygons makes triangles for Loop subdivision; add --scheme loop"));
            }
            split_polygons(&mut scene, &name, console)?;
        }
        for warning in &scene.warnings {
            console.warn(&format_args!("{name}: {warning}"));
        }
        Ok(Self { name, scene, scheme })
    }

    /// The positions in the chosen precision.
    pub fn positions<T: Real>(&self) -> Result<Vec<[T; 3]>, Failure> {
        let rounded: Vec<[T; 3]> = self.scene.positions.iter().map(|p| p.map(T::from_f64)).collect();
        match rounded.iter().position(|p| p.iter().any(|x| !x.to_f64().is_finite())) {
            None => Ok(rounded),
            Some(vertex) => {
                let position = self.scene.positions[vertex];
                Err(Failure::Precision { name: self.name.clone(), vertex, position })
            }
        }
    }

    /// The file's texture coordinates, if it has some, over the mesh whose tables are `topology`.
    pub fn texture<T: Real>(&self, topology: &Topology) -> Result<Option<Texture<T>>, Failure> {
        let Some(texture) = &self.scene.texture else { return Ok(None) };
        let rule = topology.rules().face_varying;
        let channel = Channel::face_varying(topology, self.scheme, texture.values.len(), &texture.indices, rule)
            .map_err(|source| Failure::Texture { name: self.name.clone(), source })?;
        let rounded: Vec<[T; 2]> = texture.values.iter().map(|uv| uv.map(T::from_f64)).collect();
        if let Some(index) = rounded.iter().position(|uv| uv.iter().any(|x| !x.to_f64().is_finite())) {
            let value = texture.values[index];
            return Err(Failure::TexturePrecision { name: self.name.clone(), index, value });
        }
        let values = channel.rows(&rounded).into_owned();
        Ok(Some(Texture { channel, values }))
    }

    /// The patch table; says what is unusual about the mesh.
    pub fn patch_table(&self, method: Method, console: &Console) -> Result<PatchTable, Failure> {
        let table = PatchTable::with_method(&self.scene.mesh, self.scheme, method).map_err(|e| self.mesh_error(e))?;
        self.warn_about(table.topology(), console);
        let size = table.size();
        console.note(&format_args!("{} patches with {} distinct plans", size.patches, size.plans));
        Ok(table)
    }

    /// The error for something wrong with the mesh, with the line that it is on.
    pub fn mesh_error(&self, source: MeshError) -> Failure {
        match self.scene.lines.of_error(&source) {
            None => Failure::Mesh { name: self.name.clone(), source },
            line => Failure::Read(ReadError::Mesh { name: self.name.clone(), line, source }),
        }
    }

    /// Warns of what the surface does not follow from the faces alone.
    pub fn warn_about(&self, topology: &Topology, console: &Console) {
        for warning in crate::oddities::found(&self.scene.mesh, topology) {
            console.warn(&format_args!("{}: {warning}", self.name));
        }
    }
}

/// Cuts all faces into triangles; what belongs to face corners follows them.
fn split_polygons(scene: &mut Scene, name: &str, console: &Console) -> Result<(), Failure> {
    let failed = |source| Failure::Mesh { name: name.to_owned(), source };
    let cut = scene.mesh.triangulated(&scene.positions).map_err(failed)?;
    let follow = |indices: &mut Vec<u32>| *indices = cut.corners.iter().map(|&c| indices[c as usize]).collect();
    scene.texture.iter_mut().for_each(|channel| follow(&mut channel.indices));
    scene.normals.iter_mut().for_each(|channel| follow(&mut channel.indices));
    let polygons = scene.mesh.faces().filter(|face| face.len() > 3).count();
    console.note(&format_args!("{name}: {polygons} polygons cut; {} triangles in all", cut.mesh.face_count()));
    scene.mesh = cut.mesh;
    Ok(())
}

/// Texture coordinates as a channel.
pub struct Texture<T> {
    pub channel: Channel,
    /// One row per vertex of the channel's topology.
    pub values: Vec<[T; 2]>,
}

impl<T> Texture<T> {
    /// The channel's patch table.
    pub fn patch_table(&self, method: Method, input: &Input) -> Result<PatchTable, Failure> {
        self.channel.patch_table_with(method).map_err(|e| input.mesh_error(e))
    }
}

/// Refuses formats that exist but cannot be read yet.
fn check_format(path: &Path) -> Result<(), Failure> {
    let extension = path.extension().map(|e| e.to_ascii_lowercase());
    let format = match extension.as_ref().and_then(|e| e.to_str()) {
        Some("usda" | "usdc" | "usdz" | "usd") => "USD",
        Some("ply") => "PLY",
        Some("gltf" | "glb") => "glTF",
        _ => return Ok(()),
    };
    Err(Failure::InputFormat { name: path.display().to_string(), format })
}
