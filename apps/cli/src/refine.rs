//! `subsurf refine`: classical subdivision, level by level.

mod carried_tags;

use crate::args::{Common, MeshArgs, Precision, TriangleRule};
use crate::console::{Console, print_json};
use crate::failure::Failure;
use crate::input::{Input, Texture};
use crate::memory;
use crate::output::Output;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;
use subsurf::{Level, MAX_COUNT, MeshError, Method, Scheme, Tags, Topology, UniformRefinement};
use subsurf_io::{Attribute, FaceSizes, OutputMesh};

const EXAMPLES: &str = "\
Examples:
  subsurf refine cube.obj -l 3 -o cube3.obj            three steps, tags carried along
  subsurf refine cube.obj -l 3 --limit -o cube3.ply    the same vertices on the limit surface
  cat cube.obj | subsurf refine - -l 1 -o - | less     through pipes

Vertices come in OpenSubdiv's default order: those of the parent's vertices, then of its faces (not under Loop),
then of its edges.
Texture coordinates are refined by the face-varying rule; with --limit they move to their limit too.
Refining the output of `refine` again continues the same surface, its vertices in another order; a warning says where
edges cannot be told apart. Only OBJ files keep tags.";

/// Subdivide level by level, keeping creases, corners and holes
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct RefineArgs {
    #[command(flatten)]
    mesh: MeshArgs,
    #[command(flatten)]
    rule: TriangleRule,
    /// How many subdivision steps
    #[arg(short, long, value_name = "N")]
    level: u32,
    /// Where to write: .obj, .ply or .glb, or - for OBJ on standard output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Move every vertex to its limit on the surface
    #[arg(long)]
    limit: bool,
}

/// Runs the verb.
pub fn run(args: &RefineArgs, common: &Common, console: &Console) -> Result<(), Failure> {
    let output = Output::new(&args.output, common)?;
    output.check_mesh()?;
    let input = Input::load(&args.mesh, args.rule.triangles, console)?;
    match common.precision {
        Some(Precision::F64) => refine::<f64>(args, common, &input, &output, console),
        Some(Precision::F32) | None => refine::<f32>(args, common, &input, &output, console),
    }
}

fn refine<T: subsurf::Real + subsurf_io::Real>(
    args: &RefineArgs,
    common: &Common,
    input: &Input,
    output: &Output,
    console: &Console,
) -> Result<(), Failure> {
    let start = Instant::now();
    let points = input.positions::<T>()?;
    let control = Level::new(&input.scene.mesh, input.scheme).map_err(|e| input.mesh_error(e))?;
    input.warn_about(control.topology(), console);
    let counts = Counts::of(control.topology()).refined(args.level, input.scheme);
    let counts = counts.map_err(|(level, source)| Failure::Level { name: input.name.clone(), level, source })?;
    let texture = input.texture::<T>(control.topology())?;
    let mut bytes = counts.bytes(3 * size_of::<T>());
    if let Some(texture) = &texture {
        let own = Counts::of(texture.channel.topology()).refined(args.level, input.scheme);
        let own = own.map_err(|(level, source)| Failure::Level { name: input.name.clone(), level, source })?;
        bytes = bytes.saturating_add(own.bytes(2 * size_of::<T>()));
    }
    memory::check(&input.name, format!("level {}", args.level), bytes)?;

    let bar = console.progress("refining", u64::from(args.level) + 1);
    let refined = if needs_level(args, common, &control, output) {
        by_levels(args, input, output, control, &points, console, || bar.inc(1))?
    } else {
        at_once(args, input, control, &points)?
    };
    let texture = texture.map(|texture| refine_texture(texture, args, input)).transpose()?;
    output.write_mesh(&OutputMesh {
        positions: &refined.points,
        sizes: FaceSizes::Offsets(&refined.face_offsets),
        corners: &refined.corners,
        normals: None,
        texture: texture.as_ref().map(|(corners, values)| Attribute { values, indices: Some(corners) }),
        tags: Some(&refined.tags),
    })?;
    bar.finish_and_clear();
    if common.json {
        print_json(&json!({
            "output": output.name(),
            "level": args.level,
            "vertices": refined.points.len(),
            "edges": refined.edges,
            "faces": refined.face_offsets.len() - 1,
            "creases": refined.tags.creases.len(),
            "corners": refined.tags.corners.len(),
            "holes": refined.tags.holes.len(),
            "texture_coordinates": texture.as_ref().map(|(_, values)| values.len()),
            "seconds": start.elapsed().as_secs_f64(),
        }))?;
    }
    Ok(())
}

/// What is written of a level.
struct Refined<T> {
    points: Vec<[T; 3]>,
    face_offsets: Vec<u32>,
    corners: Vec<u32>,
    edges: usize,
    tags: Tags,
}

/// True where the edges of the level, or its sharpness, have a say in what is written.
fn needs_level(args: &RefineArgs, common: &Common, control: &Level, output: &Output) -> bool {
    let t = control.topology();
    // Without sharpness and holes there is none on any level; where edges share their ends, tags cannot say all of it.
    let tags = carried_tags::of(t);
    let is_tagged = !(tags.creases.is_empty() && tags.corners.is_empty() && tags.holes.is_empty());
    let shows_tags = output.keeps_tags() || common.json;
    args.limit || (shows_tags && (is_tagged || carried_tags::is_odd(t)))
}

/// Straight to the level.
fn at_once<T: subsurf::Real>(
    args: &RefineArgs,
    input: &Input,
    control: Level,
    points: &[[T; 3]],
) -> Result<Refined<T>, Failure> {
    let (rules, scheme) = (*control.topology().rules(), control.scheme());
    let refinement = UniformRefinement::from_topology(control.into_topology(), scheme, args.level)
        .map_err(|e| input.mesh_error(e))?;
    Ok(Refined {
        points: refinement.refine(points),
        face_offsets: refinement.face_offsets(),
        corners: refinement.corners(),
        edges: refinement.edge_count(),
        tags: Tags { rules, ..Tags::default() },
    })
}

/// Level by level.
fn by_levels<T: subsurf::Real>(
    args: &RefineArgs,
    input: &Input,
    output: &Output,
    control: Level,
    points: &[[T; 3]],
    console: &Console,
    step: impl Fn(),
) -> Result<Refined<T>, Failure> {
    let (mut level, mut values) = (control, points.to_vec());
    for _ in 0..args.level {
        values = level.refine_values(&values);
        level = level.refine().map_err(|e| input.mesh_error(e))?;
        let t = level.topology();
        console.note(&format_args!("level {}: {} vertices, {} faces", level.depth(), t.vertex_count(), t.face_count()));
        step();
    }
    if args.limit {
        let table = subsurf::PatchTable::with_method(&input.scene.mesh, input.scheme, Method::default())
            .map_err(|e| input.mesh_error(e))?;
        values = table.surface(points).limit_of_level(&level, &values);
    }
    let t = level.topology();
    let tags = carried_tags::of(t);
    let merged = if output.keeps_tags() { carried_tags::unsayable(t, &tags) } else { 0 };
    if merged > 0 {
        console.warn(&format_args!(
            "{}: {merged} edges of level {} share their ends with others, which a file cannot say; refining the output \
             again gives another surface there",
            input.name, args.level
        ));
    }
    let (face_offsets, corners) = (t.face_offsets().to_vec(), t.corners().to_vec());
    Ok(Refined { points: values, face_offsets, corners, edges: t.edge_count(), tags })
}

/// Texture coordinates of the level: one index per corner, and the values.
fn refine_texture<T: subsurf::Real>(
    texture: Texture<T>,
    args: &RefineArgs,
    input: &Input,
) -> Result<(Vec<u32>, Vec<[T; 2]>), Failure> {
    let channel = &texture.channel;
    let control = channel.level();
    if !args.limit {
        let refinement = UniformRefinement::from_topology(control.into_topology(), channel.scheme(), args.level)
            .map_err(|e| input.mesh_error(e))?;
        return Ok((refinement.corners(), refinement.refine(&texture.values)));
    }
    let (mut level, mut values) = (control, texture.values.clone());
    for _ in 0..args.level {
        values = level.refine_values(&values);
        level = level.refine().map_err(|e| input.mesh_error(e))?;
    }
    let table = texture.patch_table(Method::default(), input)?;
    let limit = table.surface(&texture.values).limit_of_level(&level, &values);
    Ok((level.topology().corners().to_vec(), limit))
}

/// How large a level is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Counts {
    vertices: u64,
    edges: u64,
    faces: u64,
    corners: u64,
}

impl Counts {
    pub fn of(t: &Topology) -> Self {
        let [vertices, edges, faces, corners] =
            [t.vertex_count(), t.edge_count(), t.face_count(), t.half_edge_count()].map(|count| count as u64);
        Self { vertices, edges, faces, corners }
    }

    /// `levels` steps on; refused at the level where 32-bit indices overflow.
    pub fn refined(mut self, levels: u32, scheme: Scheme) -> Result<Self, (u32, MeshError)> {
        for level in 1..=levels {
            let Self { vertices, edges, faces, corners } = self;
            let (face_points, children) = if scheme == Scheme::Loop { (0, 4 * faces) } else { (faces, corners) };
            self = Self {
                vertices: vertices + face_points + edges,
                edges: 2 * edges + corners,
                faces: children,
                corners: 4 * corners,
            };
            for (what, count) in [("vertices", self.vertices), ("corners", self.corners), ("edges", self.edges)] {
                if count > MAX_COUNT as u64 {
                    return Err((level, MeshError::TooLarge { what, count: count as usize, limit: MAX_COUNT }));
                }
            }
        }
        Ok(self)
    }

    /// Memory of such a level, its parent and the values of both, roughly.
    pub fn bytes(self, size_of_value: usize) -> u64 {
        let tables = 16 * self.corners + 32 * self.edges + 24 * self.vertices + 5 * self.faces;
        let values = size_of_value as u64 * self.vertices;
        (tables + values) / 4 * 5
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use subsurf::shapes;

    #[test]
    fn counts_of_a_level_are_known_before_it_is_made() {
        let quads = shapes::all().into_iter().map(|shape| (shape, Scheme::CatmullClark));
        let triangles = shapes::all_triangles().into_iter().map(|shape| (shape, Scheme::Loop));
        for (shape, scheme) in quads.chain(triangles) {
            let mut level = Level::new(&shape.mesh, scheme).unwrap();
            let control = Counts::of(level.topology());
            for n in 1..4 {
                level = level.refine().unwrap();
                assert_eq!(control.refined(n, scheme).unwrap(), Counts::of(level.topology()), "{}", shape.name);
            }
        }
    }

    #[test]
    fn a_level_beyond_32_bits_is_refused_at_once() {
        let cube = Level::new(&shapes::cube().mesh, Scheme::CatmullClark).unwrap();
        let error = Counts::of(cube.topology()).refined(u32::MAX, Scheme::CatmullClark).unwrap_err();
        assert!(matches!(error, (14, MeshError::TooLarge { what: "corners", .. })), "{error:?}");
    }
}
