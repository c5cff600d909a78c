//! `subsurf tessellate`: the limit surface as a mesh.

use crate::args::{Common, Evaluator, MeshArgs, Precision, TRIANGLES};
use crate::console::{Console, print_json};
use crate::failure::Failure;
use crate::input::Input;
use crate::memory;
use crate::normals::NormalArgs;
use crate::output::Output;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{ArgAction, ArgGroup, Args};
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;
use subsurf::{Face, Facets, PatchTable, Rates, Scheme, TessellateOptions, Triangles};
use subsurf_io::{Attribute, FaceSizes, OutputMesh};

const EXAMPLES: &str = "\
Examples:
  subsurf tessellate spot.obj -r 8 -o spot8.glb                 8 x 8 facets for every quad
  subsurf tessellate spot.obj --tolerance 0.001 -o spot.obj     within 0.001 model units of the surface
  subsurf tessellate spot.obj -r 4 --triangles -o - | less      triangles, as OBJ on standard output
  subsurf tessellate box.obj -r 4 --triangles smooth -o b.ply   quads, with smoother weights at triangles
  subsurf tessellate car.obj -r 8 --normals a4 -o car.glb       normals without kinks at extraordinary vertices

Vertices are shared, so that the mesh is watertight. Along infinitely sharp creases every side has normals of its own;
OBJ files keep positions shared there, PLY and GLB files repeat them. --tolerance and --edge-length that need more than
512 facets along a side of a face are refused. Under Loop all facets are triangles.";

/// What bare `--triangles` stands for among the words of the rule.
const FACETS: &str = "facets";

/// Write the limit surface as a mesh with normals and texture coordinates
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES, group = ArgGroup::new("rates").required(true))]
pub struct TessellateArgs {
    #[command(flatten)]
    mesh: MeshArgs,
    /// Facets along each side of a quad face (of a triangle under Loop)
    #[arg(short, long, value_name = "N", group = "rates", value_parser = clap::value_parser!(u32).range(1..))]
    rate: Option<u32>,
    /// Largest distance of facets from the surface, in model units
    #[arg(long, value_name = "T", group = "rates", allow_negative_numbers = true, value_parser = parse_length)]
    tolerance: Option<f64>,
    /// Largest length of facet sides, in model units
    #[arg(long, value_name = "L", group = "rates", allow_negative_numbers = true, value_parser = parse_length)]
    edge_length: Option<f64>,
    /// Where to write: .obj, .ply or .glb, or - for OBJ on standard output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Facets with four corners (the default; triangles only where rates meet, and under Loop)
    #[arg(long)]
    quads: bool,
    /// Alone: facets with three corners. With catmull-clark or smooth: weights at triangles, over the file's
    #[arg(
        long,
        value_name = "RULE",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = FACETS,
        action = ArgAction::Append,
        value_parser = triangles_parser(),
        hide_possible_values = true,
    )]
    triangles: Vec<TrianglesWord>,
    #[command(flatten)]
    normals: NormalArgs,
    #[command(flatten)]
    evaluator: Evaluator,
}

/// The two meanings of `--triangles`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum TrianglesWord {
    Facets,
    Rule(Triangles),
}

fn triangles_parser() -> impl TypedValueParser<Value = TrianglesWord> {
    PossibleValuesParser::new(TRIANGLES.iter().map(|choice| choice.0).chain([FACETS])).map(|word| {
        let rule = TRIANGLES.iter().find(|choice| choice.0 == word);
        rule.map_or(TrianglesWord::Facets, |choice| TrianglesWord::Rule(choice.1))
    })
}

fn parse_length(text: &str) -> Result<f64, &'static str> {
    let length = text.parse().ok().filter(|length: &f64| *length > 0.0 && length.is_finite());
    length.ok_or("use a positive number")
}

impl TessellateArgs {
    fn facets(&self) -> Result<Facets, Failure> {
        let triangles = self.triangles.contains(&TrianglesWord::Facets);
        match (self.quads, triangles) {
            (true, true) => Err(Failure::Usage("--quads and --triangles exclude each other; give one of them")),
            (_, true) => Ok(Facets::Triangles),
            _ => Ok(Facets::Quads),
        }
    }

    fn rule(&self) -> Option<Triangles> {
        let mut rules = self.triangles.iter().filter_map(|word| match word {
            TrianglesWord::Rule(rule) => Some(*rule),
            TrianglesWord::Facets => None,
        });
        rules.next_back()
    }

    fn rates(&self) -> Rates {
        match (self.rate, self.tolerance, self.edge_length) {
            (Some(rate), ..) => Rates::Uniform(rate),
            (_, Some(tolerance), _) => Rates::Tolerance(tolerance),
            (.., length) => Rates::EdgeLength(length.unwrap_or(f64::NAN)),
        }
    }
}

/// Runs the verb.
pub fn run(args: &TessellateArgs, common: &Common, console: &Console) -> Result<(), Failure> {
    args.normals.check()?;
    let facets = args.facets()?;
    let output = Output::new(&args.output, common)?;
    output.check_mesh()?;
    let input = Input::load(&args.mesh, args.rule(), console)?;
    let mut options =
        TessellateOptions { rates: args.rates(), facets, normals: true, places: false, ..TessellateOptions::default() };
    // A point with its normal, and four corners with two indices each.
    let size = if common.precision == Some(Precision::F64) { 8 } else { 4 };
    if let Some(available) = memory::available() {
        let point = if input.scene.texture.is_some() { 2 * (6 * size + 32) } else { 6 * size + 32 };
        options.most_points = options.most_points.min(available / point);
    }
    match common.precision {
        Some(Precision::F64) => tessellate::<f64>(args, &options, common, &input, &output, console),
        Some(Precision::F32) | None => tessellate::<f32>(args, &options, common, &input, &output, console),
    }
}

fn tessellate<T: subsurf::Real + subsurf_io::Real>(
    args: &TessellateArgs,
    options: &TessellateOptions,
    common: &Common,
    input: &Input,
    output: &Output,
    console: &Console,
) -> Result<(), Failure> {
    let start = Instant::now();
    let points = input.positions::<T>()?;
    let table = input.patch_table(args.evaluator.evaluator, console)?;
    if table.size().patches == 0 {
        return Err(Failure::OnlyHoles { name: input.name.clone() });
    }
    let shading = args.normals.shading(&table, &points, input, |n| n)?;
    let texture = input.texture::<T>(table.topology())?;
    if let Rates::Uniform(rate) = options.rates {
        let bytes = uniform_bytes(&table, rate, size_of::<T>());
        // Texture coordinates have indices of their own, and PLY and GLB repeat vertices along seams.
        let bytes = if texture.is_some() { bytes.saturating_mul(2) } else { bytes };
        memory::check(&input.name, format!("rate {rate}"), bytes)?;
        if rate % 2 == 1 && has_subfaces(&table) {
            console.note(&format_args!("rate {rate} is rounded up to {}: some faces are no quads", rate + 1));
        }
    }
    let bar = console.progress("tessellating", 2);
    let mesh = table
        .surface(&points)
        .tessellate_shaded(options, &shading)
        .map_err(|source| Failure::Tessellate { name: input.name.clone(), source })?;
    let texture = texture
        .map(|texture| {
            let own = texture.patch_table(args.evaluator.evaluator, input)?;
            mesh.channel(&table, own.surface(&texture.values))
                .map_err(|source| Failure::Tessellate { name: input.name.clone(), source })
        })
        .transpose()?;
    bar.inc(1);
    let normal_indices = (!mesh.normal_corners.is_empty()).then_some(&mesh.normal_corners[..]);
    output.write_mesh(&OutputMesh {
        positions: &mesh.positions,
        sizes: FaceSizes::Offsets(&mesh.face_offsets),
        corners: &mesh.corners,
        normals: Some(Attribute { values: &mesh.normals, indices: normal_indices }),
        texture: texture.as_ref().map(|t| Attribute { values: &t.values, indices: Some(&t.corners) }),
        tags: None,
    })?;
    bar.finish_and_clear();
    if common.json {
        print_json(&json!({
            "output": output.name(),
            "vertices": mesh.positions.len(),
            "normals": mesh.normals.len(),
            "faces": mesh.face_offsets.len() - 1,
            "seconds": start.elapsed().as_secs_f64(),
        }))?;
    }
    Ok(())
}

/// Whether some face is tessellated through sub-faces.
fn has_subfaces(table: &PatchTable) -> bool {
    (0..table.topology().face_count()).any(|f| table.subfaces(Face::new(f)) > 1)
}

/// Memory of a uniform tessellation, roughly: every quad has four corners with two indices, and about one point with
/// a normal. A triangle has three corners and half a point.
pub fn uniform_bytes(table: &PatchTable, rate: u32, size_of_number: usize) -> u64 {
    let half_edges = table.topology().half_edge_count() as u64;
    let (patches, bytes) = match table.scheme() {
        Scheme::Loop => (half_edges / 3, 3 * 8 + 3 * size_of_number as u64),
        _ => (half_edges / 4, 4 * 8 + 6 * size_of_number as u64),
    };
    patches.saturating_mul(u64::from(rate).saturating_mul(u64::from(rate))).saturating_mul(bytes)
}
