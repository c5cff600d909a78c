//! Pictures of models, described by the words of `subsurf render`.

use super::models::Model;
use super::{Settings, sheet::Sheet};
use crate::args::{Cli, Verb};
use crate::failure::Failure;
use clap::Parser;
use subsurf_render::Image;

/// A model, and what to show of it.
pub struct Panel {
    /// Flags of `subsurf render`, but for size and samples.
    pub flags: String,
    /// Under its column.
    pub label: &'static str,
}

impl Panel {
    pub fn new(label: &'static str, flags: impl Into<String>) -> Self {
        Self { flags: flags.into(), label }
    }
}

/// One picture, `size` before the settings' scale.
pub fn picture(settings: &Settings<'_>, model: &Model, flags: &str, size: [u32; 2]) -> Result<Image, Failure> {
    let [width, height] = settings.scaled(size);
    let file = format!("{}.obj", model.name);
    let size = format!("{width}x{height}");
    let samples = settings.samples.to_string();
    let words = ["subsurf", "render", &file, "-o", "-", "--size", &size, "--samples", &samples];
    let words = words.into_iter().chain(flags.split_whitespace());
    let Ok(Cli { verb: Verb::Render(args), .. }) = Cli::try_parse_from(words) else {
        return Err(Failure::Usage("a figure's flags are not those of `subsurf render`"));
    };
    let input = model.input(args.scheme())?;
    args.draw(&input, settings.console).map(|picture| picture.image)
}

/// A sheet of pictures of one model, row by row, labelled by its last row.
pub fn sheet(
    settings: &Settings<'_>,
    model: &Model,
    columns: usize,
    size: [u32; 2],
    panels: &[Panel],
) -> Result<Vec<u8>, Failure> {
    let images = panels.iter().map(|panel| picture(settings, model, &panel.flags, size)).collect::<Result<_, _>>()?;
    let last = &panels[panels.len() - columns..];
    let labels = if last.iter().all(|panel| panel.label.is_empty()) {
        Vec::new()
    } else {
        last.iter().map(|panel| panel.label.to_owned()).collect()
    };
    Sheet { columns, panels: images, labels }.png().map_err(Failure::StandardOutput)
}
