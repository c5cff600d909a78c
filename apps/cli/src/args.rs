//! The command line's words, and what they mean to the library.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::ffi::OsString;
use std::path::PathBuf;
use subsurf::{Boundary, Creasing, FaceVarying, Method, Rules, Scheme, Triangles};

const EXAMPLES: &str = "\
Examples:
  subsurf info spot.obj                          what is in the file
  subsurf render spot.obj -o spot.png            a picture of the limit surface
  subsurf tessellate spot.obj -r 8 -o spot.glb   the limit surface as a mesh
  subsurf refine spot.obj -l 2 -o spot2.obj      two classical subdivision steps
  subsurf eval spot.obj --at at.csv -o out.csv   position and derivatives at given places

Control meshes are read from OBJ files with OpenSubdiv's tag lines; `-` reads OBJ from standard input.
`subsurf help VERB` shows a verb's options with examples. Exit status: 0 done, 1 the input is wrong or the work
could not be done, 2 wrong usage.";

/// Exact limit surfaces of Catmull-Clark, Loop and bilinear subdivision: as numbers, as meshes, as pictures.
#[derive(Parser, Debug)]
#[command(name = "subsurf", version, after_help = EXAMPLES, arg_required_else_help = true, max_term_width = 110)]
pub struct Cli {
    #[command(flatten)]
    pub common: Common,
    #[command(subcommand)]
    pub verb: Verb,
}

/// What to do.
#[derive(Subcommand, Debug)]
pub enum Verb {
    Info(crate::info::InfoArgs),
    Refine(crate::refine::RefineArgs),
    Tessellate(crate::tessellate::TessellateArgs),
    Eval(crate::eval::EvalArgs),
    Render(crate::render::RenderArgs),
    Bench(crate::bench::BenchArgs),
    Figures(crate::figures::FiguresArgs),
    Completions(crate::manual::CompletionsArgs),
    Man(crate::manual::ManArgs),
}

/// Options of every verb.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Common options")]
pub struct Common {
    /// Threads to use [default: one per core]; results are the same to the bit for any number
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Precision of positions [default: f32 for meshes, f64 for eval]; weights are always f64
    #[arg(long, global = true, value_name = "P")]
    pub precision: Option<Precision>,
    /// Where to compute
    #[arg(long, global = true, value_name = "DEVICE", default_value = "cpu")]
    pub device: Device,
    /// Print a machine-readable result on standard output
    #[arg(long, global = true)]
    pub json: bool,
    /// No warnings, no progress
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Say more about what is done
    #[arg(short, long, global = true, conflicts_with = "quiet")]
    pub verbose: bool,
}

/// How positions are stored.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub enum Precision {
    F32,
    F64,
}

/// What computes.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub enum Device {
    Cpu,
    Gpu,
}

/// The control mesh and how to understand it.
#[derive(Args, Clone, Debug)]
pub struct MeshArgs {
    /// Control mesh: an .obj file, or - for OBJ on standard input
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Subdivision scheme: catmull-clark, loop (triangles, see --split-polygons) or bilinear [default: what the file says, else catmull-clark]
    #[arg(long, value_parser = one_of(SCHEMES), hide_possible_values = true, help_heading = "Interpretation")]
    pub scheme: Option<Scheme>,
    /// With --scheme loop: cut faces that are no triangles along their shortest diagonals; faces are then counted in triangles
    #[arg(long, help_heading = "Interpretation")]
    pub split_polygons: bool,
    /// Rules for what the file leaves open: usd, opensubdiv or blender [default: usd]
    #[arg(long, value_parser = one_of(PRESETS), hide_possible_values = true, help_heading = "Interpretation")]
    pub preset: Option<Preset>,
    /// Boundary rule, over the file's: none, edge-only or edge-and-corner
    #[arg(long, value_name = "RULE", value_parser = one_of(BOUNDARIES), hide_possible_values = true, help_heading = "Interpretation")]
    pub boundary: Option<Boundary>,
    /// How sharpness decays, over the file's: uniform or chaikin
    #[arg(long, value_name = "RULE", value_parser = one_of(CREASINGS), hide_possible_values = true, help_heading = "Interpretation")]
    pub creasing: Option<Creasing>,
    /// Texture coordinates at seams, over the file's: all, none, boundaries, corners-only, corners-plus1 or corners-plus2
    #[arg(long, value_name = "RULE", value_parser = one_of(FACE_VARYINGS), hide_possible_values = true, help_heading = "Interpretation")]
    pub face_varying: Option<FaceVarying>,
}

/// The rule for triangles, where the word means nothing else.
#[derive(Args, Clone, Copy, Debug)]
pub struct TriangleRule {
    /// Weights at triangles, over the file's: catmull-clark or smooth
    #[arg(long, value_name = "RULE", value_parser = one_of(TRIANGLES), hide_possible_values = true, help_heading = "Interpretation")]
    pub triangles: Option<Triangles>,
}

/// The closed form behind evaluation at special vertices.
#[derive(Args, Clone, Copy, Debug)]
pub struct Evaluator {
    /// Closed form at special vertices: deflated (powers) or eigenbasis (Stam 1998; Lacewell, Burley 2007)
    #[arg(long, value_name = "FORM", value_parser = one_of(METHODS), hide_possible_values = true, default_value = "deflated", help_heading = "Interpretation")]
    pub evaluator: Method,
}

/// A set of rules by name.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Preset {
    Usd,
    OpenSubdiv,
    Blender,
}

impl Preset {
    pub fn rules(self) -> Rules {
        match self {
            Self::Usd => Rules::usd(),
            Self::OpenSubdiv => Rules::opensubdiv(),
            Self::Blender => Rules::blender(),
        }
    }
}

/// Words and what they stand for.
pub type Choices<T> = &'static [(&'static str, T)];

pub const SCHEMES: Choices<Scheme> =
    &[("catmull-clark", Scheme::CatmullClark), ("loop", Scheme::Loop), ("bilinear", Scheme::Bilinear)];
const PRESETS: Choices<Preset> =
    &[("usd", Preset::Usd), ("opensubdiv", Preset::OpenSubdiv), ("blender", Preset::Blender)];
pub const BOUNDARIES: Choices<Boundary> =
    &[("none", Boundary::None), ("edge-only", Boundary::EdgeOnly), ("edge-and-corner", Boundary::EdgeAndCorner)];
pub const CREASINGS: Choices<Creasing> = &[("uniform", Creasing::Uniform), ("chaikin", Creasing::Chaikin)];
pub const FACE_VARYINGS: Choices<FaceVarying> = &[
    ("all", FaceVarying::All),
    ("none", FaceVarying::None),
    ("boundaries", FaceVarying::Boundaries),
    ("corners-only", FaceVarying::CornersOnly),
    ("corners-plus1", FaceVarying::CornersPlus1),
    ("corners-plus2", FaceVarying::CornersPlus2),
];
pub const TRIANGLES: Choices<Triangles> = &[("catmull-clark", Triangles::CatmullClark), ("smooth", Triangles::Smooth)];
const METHODS: Choices<Method> = &[("deflated", Method::Deflated), ("eigenbasis", Method::Eigenbasis)];

/// Takes one of a list of words.
pub fn one_of<T: Copy + Send + Sync + 'static>(choices: Choices<T>) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(choices.iter().map(|choice| choice.0))
        .map(move |word| choices.iter().find(|choice| choice.0 == word).expect("the parser admits listed words only").1)
}

/// The word for a value.
pub fn word<T: PartialEq>(choices: Choices<T>, value: T) -> &'static str {
    choices.iter().find(|choice| choice.1 == value).map_or("", |choice| choice.0)
}

/// Joins `--triangles smooth` to `--triangles=smooth`: `tessellate` also has `--triangles` alone, for the shape of
/// facets, and what follows that must not be taken for its value unless it is one of the rule's words.
pub fn joined(args: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let mut out: Vec<OsString> = Vec::new();
    let mut verbatim = false;
    for arg in args {
        let is_rule = TRIANGLES.iter().any(|choice| arg == choice.0);
        match out.last_mut() {
            Some(last) if !verbatim && is_rule && last == "--triangles" => {
                last.push("=");
                last.push(&arg);
            }
            _ => {
                verbatim |= arg == "--";
                out.push(arg);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_holds_together() {
        Cli::command().debug_assert();
    }

    #[test]
    fn only_the_words_of_the_rule_are_joined() {
        let check = |text: &str, expected: &str| {
            let args = joined(text.split(' ').map(OsString::from));
            let words: Vec<String> = args.into_iter().map(|arg| arg.into_string().unwrap()).collect();
            assert_eq!(words.join(" "), expected);
        };
        check("--triangles smooth a.obj", "--triangles=smooth a.obj");
        check("--triangles a.obj", "--triangles a.obj");
        check("--triangles --triangles catmull-clark", "--triangles --triangles=catmull-clark");
        check("a.obj -- --triangles smooth", "a.obj -- --triangles smooth");
    }
}
