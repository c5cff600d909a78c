//! `subsurf figures`: every picture of the documentation that shows a surface or a number, drawn again.
//!
//! Each figure is a picture (PNG, or SVG for charts) and the numbers behind it (CSV). Pictures of surfaces are described
//! by the words of `subsurf render`; the models are part of the program.

mod chart;
mod crease_cost;
mod crease_curves;
mod lettering;
mod models;
mod pictures;
mod profiles;
mod ratio;
mod shading;
mod sheet;
mod studio;
mod table;
mod turning;

use crate::args::{Choices, Common, one_of};
use crate::console::{Console, print_json};
use crate::failure::Failure;
use crate::output::{FillError, Output};
use clap::Args;
use models::Model;
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};
use subsurf_io::WriteError;

const EXAMPLES: &str = "\
Examples:
  subsurf figures docs/figures                                  all of them, as they are in the documentation
  subsurf figures out --only ratio,profiles                     two of them
  subsurf figures out --only fields --size 3600 --samples 64    one for print
  subsurf figures out --size 300 --samples 2                    a quick look at all of them

OUT_DIR gets a picture of each figure, data/NAME.csv with its numbers, the models that are made for it as data/MODEL.obj,
and, when all are drawn, README.md with the captions.";

/// Draw the figures of the documentation
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct FiguresArgs {
    /// Where to write: a folder, made if there is none
    #[arg(value_name = "OUT_DIR")]
    out: PathBuf,
    /// Draw these alone: names separated by commas
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = one_of(NAMES))]
    only: Vec<usize>,
    /// Width of pictures of surfaces in pixels, about; charts have no size of their own
    #[arg(long, value_name = "PX", default_value_t = NATURAL, value_parser = clap::value_parser!(u32).range(60..=8192))]
    size: u32,
    /// Samples per pixel
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=i64::from(subsurf_render::MAX_SAMPLES)))]
    samples: u32,
}

/// The width that figures are laid out for.
const NATURAL: u32 = 1280;

/// How to draw.
pub struct Settings<'a> {
    size: u32,
    pub samples: u32,
    pub console: &'a Console,
}

impl Settings<'_> {
    /// A size that is laid out for the natural width, at the width asked for.
    pub fn scaled(&self, size: [u32; 2]) -> [u32; 2] {
        size.map(|x| (x * self.size / NATURAL).max(8))
    }
}

/// A finished figure.
pub struct Drawing {
    pub picture: Picture,
    /// Files beside it: how their names end, and what is in them.
    pub numbers: Vec<(&'static str, String)>,
}

/// Its picture.
pub enum Picture {
    Svg(String),
    Png(Vec<u8>),
}

/// A figure to draw.
struct Figure {
    name: &'static str,
    caption: &'static str,
    draw: fn(&Settings<'_>) -> Result<Drawing, Failure>,
    /// Models made for it.
    models: fn() -> Vec<Model>,
}

const FIGURES: [Figure; 16] = [
    Figure {
        name: "fields",
        caption: "Six normal fields round a vertex of valence 9 under Catmull-Clark: shaded, and with reflection lines. \
                  Bakker, Barendrecht, Kosinka 2018, figure 1.",
        draw: shading::fields,
        models: || vec![shading::nine()],
    },
    Figure {
        name: "turning",
        caption: "How fast the normals of the six fields turn on the way to the vertex: those of the limit surface and of A2 \
                  without bound.",
        draw: shading::turning,
        models: Vec::new,
    },
    Figure {
        name: "ratio",
        caption: "The bound μᵖ⁺¹/λ² of their theorem 1 against valence. The factor by which the troublesome term truly changes \
                  from level to level is at most (μ/λ)², whatever p is: their curve for p = 1. Their figure 2.",
        draw: ratio::draw,
        models: Vec::new,
    },
    Figure {
        name: "profiles",
        caption: "The blend weight b^p along a line through the vertex, for both smooth blends. Their figure 3.",
        draw: profiles::draw,
        models: Vec::new,
    },
    Figure {
        name: "powers",
        caption: "The power p of the blend A3: shaded, and isophotes. Their figure 4.",
        draw: shading::powers,
        models: || vec![shading::nine()],
    },
    Figure {
        name: "weights",
        caption: "Blend weights round a pole of valence 12 with triangles, once subdivided. Their figure 5.",
        draw: shading::weights,
        models: || vec![shading::twelve()],
    },
    Figure {
        name: "isophotes",
        caption: "Isophotes of four normal fields on a Catmull-Clark surface. Their figure 6.",
        draw: shading::isophotes,
        models: Vec::new,
    },
    Figure {
        name: "loop-isophotes",
        caption: "Isophotes of three normal fields on a Loop surface. Their figure 7.",
        draw: shading::loop_isophotes,
        models: || vec![shading::loop_nine()],
    },
    Figure {
        name: "crease-curves",
        caption: "One control polygon whose curve ends at a crease of sharpness 0, 1, 1.7 and 2; colours are the segments, \
                  each one polynomial. Nießner, Loop, Greiner 2012, figure 1.",
        draw: crease_curves::draw,
        models: Vec::new,
    },
    Figure {
        name: "crease-cost",
        caption: "What the car needs when all its 314 creases have one sharpness. Their figure 2, in counts.",
        draw: crease_cost::draw,
        models: Vec::new,
    },
    Figure {
        name: "crease-levels",
        caption: "The car with creases of sharpness 6, in the colours of levels: feature-adaptive refinement, the same with \
                  single-crease patches, and patch trees. Their figure 3.",
        draw: pictures::crease_levels,
        models: Vec::new,
    },
    Figure { name: "car", caption: "The car's limit surface.", draw: pictures::car, models: Vec::new },
    Figure { name: "spot-cage", caption: "Spot in its control mesh.", draw: pictures::spot_cage, models: Vec::new },
    Figure {
        name: "car-levels",
        caption: "Depth of the patch trees on the car.",
        draw: pictures::car_levels,
        models: Vec::new,
    },
    Figure {
        name: "car-baseline",
        caption: "Levels of feature-adaptive refinement on the car.",
        draw: pictures::car_baseline,
        models: Vec::new,
    },
    Figure {
        name: "shoes-patches",
        caption: "Kinds of leaves on shoes with fractional sharpness.",
        draw: pictures::shoes_patches,
        models: Vec::new,
    },
];

/// Names of figures, and which they are.
const NAMES: Choices<usize> = &{
    let mut names = [("", 0); FIGURES.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = (FIGURES[i].name, i);
        i += 1;
    }
    names
};

/// Runs the verb.
pub fn run(args: &FiguresArgs, common: &Common, console: &Console) -> Result<(), Failure> {
    let settings = Settings { size: args.size, samples: args.samples, console };
    let chosen: Vec<&Figure> = FIGURES
        .iter()
        .enumerate()
        .filter(|(i, _)| args.only.is_empty() || args.only.contains(i))
        .map(|f| f.1)
        .collect();
    let data = args.out.join("data");
    fs::create_dir_all(&data).map_err(|error| WriteError::from_io(&data, error))?;
    let mut index =
        String::from("# Figures\n\nDrawn by `subsurf figures`; numbers and the models made for them are in `data/`.\n");
    let mut written = Vec::new();
    for figure in &chosen {
        console.note(&format_args!("drawing {}", figure.name));
        let drawing = (figure.draw)(&settings)?;
        let (extension, bytes) = match &drawing.picture {
            Picture::Svg(text) => ("svg", text.as_bytes()),
            Picture::Png(bytes) => ("png", bytes.as_slice()),
        };
        let file = format!("{}.{extension}", figure.name);
        let mut files = vec![(args.out.join(&file), bytes)];
        for (ending, text) in &drawing.numbers {
            files.push((data.join(format!("{}.{ending}", figure.name)), text.as_bytes()));
        }
        let models = (figure.models)();
        for model in models.iter().filter(|model| model.is_made()) {
            files.push((data.join(format!("{}.obj", model.name)), model.obj.as_bytes()));
        }
        for (path, bytes) in files {
            write(&path, bytes, common)?;
            written.push(path.display().to_string());
        }
        index += &format!("\n![{}]({file})\n\n**{}** {}\n", figure.name, figure.name, figure.caption);
    }
    if chosen.len() == FIGURES.len() {
        let path = args.out.join("README.md");
        write(&path, index.as_bytes(), common)?;
        written.push(path.display().to_string());
    }
    if common.json {
        print_json(&json!({ "files": written, "size": args.size, "samples": args.samples }))?;
    }
    Ok(())
}

fn write(path: &Path, bytes: &[u8], common: &Common) -> Result<(), Failure> {
    Output::new(path, common)?.write_with(|out| out.write_all(bytes).map_err(FillError::from))
}
