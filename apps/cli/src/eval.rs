//! `subsurf eval`: position, derivatives, normal and curvature at the places of a table.

mod places;
mod rows;
mod table_error;

use crate::args::{Common, Evaluator, MeshArgs, Precision, TriangleRule};
use crate::console::{Console, print_json};
use crate::failure::Failure;
use crate::input::Input;
use crate::normals::NormalArgs;
use crate::output::{FillError, Output};
use clap::Args;
use indicatif::ProgressBar;
use places::{Block, Header, Line, Places};
use rayon::prelude::*;
use rows::{Columns, Number, Rows};
use serde_json::json;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;
use subsurf::{Derivatives, PatchTable};
use table_error::RowError;
pub use table_error::TableError;

const EXAMPLES: &str = "\
Examples:
  printf 'face,subface,u,v\\n0,0,0.25,0.5\\n' > at.csv
  subsurf eval spot.obj --at at.csv -o out.csv                          position, derivatives, normal
  subsurf eval spot.obj --at at.csv --second --curvature -o out.csv     and second derivatives, curvature
  subsurf eval spot.obj --at at.csv --texture -o out.csv                and texture coordinates
  subsurf eval spot.obj --at at.csv --normals a4 --blend-weight -o out.csv    normals to shade with, and the column b
  subsurf eval spot.obj --at - -o - < at.csv                            through pipes

A place is a face (from 0), a sub-face (0 for quads, the corner for other faces) and u, v from 0 to 1. In a quad, u runs
along the first edge from the first corner and v along the last; in a sub-face, (0,0) is the corner and (1,1) the centre. Under Loop every face is
a triangle with u + v up to 1: (0,0), (1,0) and (0,1) are its corners.
At extraordinary vertices derivatives may vanish or diverge, as the column `derivatives` says; du and dv are then
directions. The normal is empty where the surface has none, curvature where it is unbounded.";

/// Evaluate the limit surface at given places, exactly
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct EvalArgs {
    #[command(flatten)]
    mesh: MeshArgs,
    #[command(flatten)]
    rule: TriangleRule,
    /// Table of places with the columns face,subface,u,v: a .csv file, or - for standard input
    #[arg(long, value_name = "IN")]
    at: PathBuf,
    /// Where to write: a .csv file, or - for standard output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Add second derivatives
    #[arg(long)]
    second: bool,
    /// Add principal, Gaussian and mean curvature
    #[arg(long)]
    curvature: bool,
    /// Add the blend weight b of --normals a1 to a4, from 0 to 1, before it is raised to --blend-power
    #[arg(long)]
    blend_weight: bool,
    /// Add texture coordinates and their derivatives: s,t,du_s,du_t,dv_s,dv_t,texture_derivatives
    #[arg(long)]
    texture: bool,
    #[command(flatten)]
    normals: NormalArgs,
    #[command(flatten)]
    evaluator: Evaluator,
}

/// Rows that a thread evaluates at a time.
const CHUNK: usize = 256;

/// Runs the verb.
pub fn run(args: &EvalArgs, common: &Common, console: &Console) -> Result<(), Failure> {
    if args.at.as_os_str() == "-" && args.mesh.file.as_os_str() == "-" {
        return Err(Failure::Usage("the mesh and the table cannot both come from standard input; give one as a file"));
    }
    args.normals.check()?;
    if args.blend_weight && !args.normals.is_blend() {
        return Err(Failure::Usage("--blend-weight is for blended normals: add --normals a4"));
    }
    let output = Output::new(&args.output, common)?;
    output.check_extension("csv", |name| Failure::TableName { name })?;
    let input = Input::load(&args.mesh, args.rule.triangles, console)?;
    let start = Instant::now();
    let surface = input.patch_table(args.evaluator.evaluator, console)?;
    let (places, header) = Places::open(&args.at)?;
    let columns = Columns { second: args.second, curvature: args.curvature, blend_weight: args.blend_weight };
    let bar = console.progress("evaluating", places.length());
    let mut table = Table { surface: &surface, places, header, summary: Summary::default(), bar };
    match common.precision {
        Some(Precision::F32) => table.run::<f32>(args, columns, &input, &output)?,
        Some(Precision::F64) | None => table.run::<f64>(args, columns, &input, &output)?,
    }
    table.bar.finish_and_clear();
    let summary = table.summary;
    if common.json {
        print_json(&json!({
            "output": output.name(),
            "rows": summary.rows,
            "finite": summary.rows - summary.vanishes - summary.diverges,
            "vanishes": summary.vanishes,
            "diverges": summary.diverges,
            "seconds": start.elapsed().as_secs_f64(),
        }))?;
    }
    Ok(())
}

/// How many rows there were, and of which kind.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Summary {
    rows: u64,
    vanishes: u64,
    diverges: u64,
}

impl Summary {
    fn count(&mut self, derivatives: Derivatives) {
        self.rows += 1;
        match derivatives {
            Derivatives::Finite => {}
            Derivatives::Vanishes => self.vanishes += 1,
            Derivatives::Diverges => self.diverges += 1,
        }
    }

    fn add(&mut self, other: Self) {
        self.rows += other.rows;
        self.vanishes += other.vanishes;
        self.diverges += other.diverges;
    }
}

/// A table on its way from places to rows.
struct Table<'a> {
    surface: &'a PatchTable,
    places: Places,
    header: Header,
    summary: Summary,
    bar: ProgressBar,
}

impl Table<'_> {
    fn run<T: Number>(
        &mut self,
        args: &EvalArgs,
        columns: Columns,
        input: &Input,
        output: &Output,
    ) -> Result<(), Failure> {
        let points = input.positions::<T>()?;
        let texture = if args.texture { input.texture::<T>(self.surface.topology())? } else { None };
        if args.texture && texture.is_none() {
            return Err(Failure::NoTexture { name: input.name.clone() });
        }
        let own = texture.as_ref().map(|t| t.patch_table(args.evaluator.evaluator, input)).transpose()?;
        let texture = own.as_ref().zip(texture.as_ref()).map(|(own, t)| own.surface(&t.values));
        let shading = args.normals.shading(self.surface, &points, input, |n| n)?;
        let rows = Rows::new(self.surface.surface(&points), shading, texture, columns);
        output.write_with(|out| self.evaluate(&rows, out))
    }

    /// Block by block, so that tables of any length need little memory; each block in parallel, rows in order.
    fn evaluate<T: Number>(&mut self, rows: &Rows<'_, T>, out: &mut dyn Write) -> Result<(), FillError> {
        out.write_all(rows.header().as_bytes())?;
        let mut block = Block::default();
        let (header, surface) = (self.header, self.surface);
        while self.places.read(&mut block).map_err(Failure::Table)? {
            let evaluated = |lines: &[Line]| {
                let (mut text, mut counts) = (Vec::new(), Summary::default());
                let (mut all_words, mut places, mut wrong) = (Vec::new(), Vec::new(), None);
                for line in lines {
                    let words = header.words(&block, line);
                    match header.location(&words, surface) {
                        Ok(at) => places.push(at),
                        Err(error) => {
                            wrong = Some((line.number, error));
                            break;
                        }
                    }
                    all_words.push(words);
                }
                let jets = rows.jets(&places);
                for (i, (words, jet)) in all_words.iter().zip(jets).enumerate() {
                    rows.write(words, places[i], jet, &mut text, &mut counts)
                        .map_err(|error| (lines[i].number, error))?;
                }
                if let Some(wrong) = wrong {
                    return Err(wrong);
                }
                Ok((text, counts))
            };
            let chunks: Vec<Result<_, (u64, RowError)>> = block.lines().par_chunks(CHUNK).map(evaluated).collect();
            for chunk in chunks {
                let (text, counts) = chunk.map_err(|(line, error)| Failure::Table(self.places.error(line, error)))?;
                out.write_all(&text)?;
                self.summary.add(counts);
            }
            self.bar.inc(block.bytes());
        }
        Ok(())
    }
}
