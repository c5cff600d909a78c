//! `subsurf render`: a picture of the limit surface.

mod lines;
mod marks;
mod paint;
mod patch_lines;
pub mod picture;
mod rate;

use crate::args::{Choices, Common, Evaluator, MeshArgs, TriangleRule, one_of};
use crate::baseline::BaselineArgs;
use crate::console::{Console, print_json};
use crate::failure::Failure;
use crate::input::Input;
use crate::normals::NormalArgs;
use crate::output::{FillError, Output};
use clap::Args;
use picture::{Look, Picture, STRIPES, Subject};
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;
use subsurf::Scheme;
use subsurf_render::{Background, Camera, MAX_STRIPES, Show, Stripes, View};

const EXAMPLES: &str = "\
Examples:
  subsurf render spot.obj -o spot.png                                    a clean picture
  subsurf render spot.obj -o wire.png --show wireframe                   with the control mesh's edges on the surface
  subsurf render spot.obj -o cage.png --show cage                        inside its control mesh
  subsurf render spot.obj -o big.png --size 3840x2160 --samples 64       for print
  subsurf render spot.obj -o icon.png --size 256x256 --background transparent
  subsurf render spot.obj -o back.png --camera \"0,1,-3:0,0.2,0:35\"       from (0,1,-3), looking at (0,0.2,0)
  subsurf render car.obj -o car.png --up z                               for models whose z axis points up
  subsurf render car.obj -o osd.png --show levels --baseline feature-adaptive    what feature-adaptive refinement needs
  subsurf render car.obj -o lines.png --show reflection-lines --normals a4       smooth where limit normals turn sharply
  subsurf render car.obj -o iso.png --show isophotes --stripes 40 --axis 1,0,0
  subsurf render car.obj -o b.png --show blend-weight --normals a4 --edges
  subsurf render spot.obj -o k.png --show gaussian                        or mean; colours fit the picture, --range fixes them

What --show shows: shaded, normals (x, y, z as red, green, blue), wireframe, cage, patches, levels; isophotes (equal steps of
the angle between normal and --axis), reflection-lines (parallel straight lights in the mirror), gaussian and mean (curvature;
mean is positive in hollows; dots mark vertices where there is none), blend-weight (share of subdivided normals, b^p).

Every sample takes the exact normal of the surface where its ray meets it.";

/// Make a picture of the limit surface
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct RenderArgs {
    #[command(flatten)]
    mesh: MeshArgs,
    #[command(flatten)]
    rule: TriangleRule,
    /// Where to write: a .png file, or - for standard output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    size: [u32; 2],
    /// Samples per pixel; powers of two are spread best
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=i64::from(subsurf_render::MAX_SAMPLES)))]
    samples: u32,
    /// auto, or eye:target:vertical angle in degrees as ex,ey,ez:tx,ty,tz:fov
    #[arg(long, default_value = "auto", allow_hyphen_values = true)]
    camera: Camera,
    /// Which axis points up in the picture; the camera is given in the model's own axes
    #[arg(long, value_name = "AXIS", default_value = "y", value_parser = one_of(UPS))]
    up: Up,
    /// What to show
    #[arg(long, value_name = "WHAT", default_value = "shaded", value_parser = one_of(&Show::ALL))]
    show: Show,
    /// Draw the control mesh's edges on the surface, whatever is shown
    #[arg(long)]
    edges: bool,
    /// Leave the key to the colours out
    #[arg(long)]
    no_legend: bool,
    /// With stripes: how many dark ones in half a turn (isophotes) or a full turn of the mirror image (reflection-lines)
    /// [default: 16]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_STRIPES)))]
    stripes: Option<u32>,
    /// With stripes: isophotes' angles are measured from this direction, reflection lines' lights run along it
    /// [default: upwards for isophotes, x for reflection-lines]
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = parse_axis)]
    axis: Option<[f32; 3]>,
    /// With curvature: colours end at plus and minus this [default: what 95% of the visible surface stay within]
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = parse_range)]
    range: Option<f64>,
    /// What is behind: gradient, transparent, or a colour as #rrggbb
    #[arg(long, value_name = "COLOUR", default_value = "gradient", value_parser = parse_background)]
    background: Background,
    #[command(flatten)]
    normals: NormalArgs,
    #[command(flatten)]
    baseline: BaselineArgs,
    #[command(flatten)]
    evaluator: Evaluator,
}

/// The model's upward axis.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Up {
    Y,
    Z,
}

const UPS: Choices<Up> = &[("y", Up::Y), ("z", Up::Z)];

impl Up {
    /// Turns the model's axes to those of the picture, where y points up.
    fn turned<T: Copy + std::ops::Neg<Output = T>>(self, [x, y, z]: [T; 3]) -> [T; 3] {
        match self {
            Self::Y => [x, y, z],
            Self::Z => [x, z, -y],
        }
    }

    fn turned_camera(self, camera: Camera) -> Camera {
        match camera {
            Camera::Auto => Camera::Auto,
            Camera::At(view) => {
                Camera::At(View { eye: self.turned(view.eye), target: self.turned(view.target), ..view })
            }
        }
    }
}

fn parse_axis(text: &str) -> Result<[f32; 3], &'static str> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let axis = numbers.and_then(|numbers| <[f32; 3]>::try_from(numbers).ok());
    let is_good = |axis: &[f32; 3]| axis.iter().all(|x| x.abs() < 1e18) && axis.iter().any(|x| x.abs() > 1e-18);
    axis.filter(is_good).ok_or("write a direction as x,y,z, for example 0,1,0")
}

fn parse_range(text: &str) -> Result<f64, &'static str> {
    text.parse().ok().filter(|x: &f64| *x > 0.0 && x.is_finite()).ok_or("use a number above 0")
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let size = parsed.ok_or("write it as WIDTHxHEIGHT, for example 1280x720")?;
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    if size.iter().any(|&side| side == 0 || side > subsurf_render::MAX_SIDE) || pixels > subsurf_render::MAX_PIXELS {
        return Err(format!(
            "each side must be 1 to {} pixels, and both together at most {} pixels",
            subsurf_render::MAX_SIDE,
            subsurf_render::MAX_PIXELS
        ));
    }
    Ok(size)
}

fn parse_background(text: &str) -> Result<Background, &'static str> {
    const ADVICE: &str = "write gradient, transparent, or a colour as #rrggbb";
    match text {
        "gradient" => Ok(Background::Gradient),
        "transparent" => Ok(Background::Transparent),
        _ => {
            let digits =
                text.strip_prefix('#').filter(|digits| digits.len() == 6 && !digits.starts_with('+')).ok_or(ADVICE)?;
            let rgb = u32::from_str_radix(digits, 16).map_err(|_| ADVICE)?;
            let [_, r, g, b] = rgb.to_be_bytes();
            Ok(Background::Plain([r, g, b]))
        }
    }
}

impl RenderArgs {
    /// Refuses options that would have no effect.
    fn check(&self) -> Result<(), Failure> {
        self.normals.check()?;
        let is_striped = matches!(self.show, Show::Isophotes | Show::ReflectionLines);
        let is_curvature = matches!(self.show, Show::Gaussian | Show::Mean);
        Err(Failure::Usage(match self.show {
            Show::Gaussian | Show::Mean if !self.normals.is_limit() => {
                "curvature is that of the surface, whatever it is shaded with: leave out --normals, or choose another \
                 --show"
            }
            Show::BlendWeight if !self.normals.is_blend() => {
                "--show blend-weight is for blended normals: add --normals a4"
            }
            _ if !is_striped && (self.stripes.is_some() || self.axis.is_some()) => {
                "--stripes and --axis are for stripes: add --show isophotes or --show reflection-lines"
            }
            _ if !is_curvature && self.range.is_some() => {
                "--range is for curvature: add --show gaussian or --show mean"
            }
            _ => return Ok(()),
        }))
    }

    /// Makes the picture of a mesh, whatever file the arguments name.
    pub fn draw(&self, input: &Input, console: &Console) -> Result<Picture, Failure> {
        self.check()?;
        let points: Vec<[f32; 3]> = input.positions()?.into_iter().map(|p| self.up.turned(p)).collect();
        let table = input.patch_table(self.evaluator.evaluator, console)?;
        if table.size().patches == 0 {
            return Err(Failure::OnlyHoles { name: input.name.clone() });
        }
        let baseline = self.baseline.refine(table.topology(), input)?;
        let shading = self.normals.shading(&table, &points, input, |n| self.up.turned(n))?;
        let subject = Subject { table: &table, points: &points, shading: Some(&shading), baseline: baseline.as_ref() };
        let bar = console.progress("rendering", 1000);
        let tell = |done: f32| bar.set_position((done * 1000.0) as u64);
        let picture = picture::draw(&subject, &self.look(), Some(&tell))
            .map_err(|source| Failure::Picture { name: input.name.clone(), source })?;
        bar.finish_and_clear();
        console.note(&format_args!("rate {}: {} triangles", picture.rate, picture.triangles));
        Ok(picture)
    }

    /// The scheme, where one is given.
    pub fn scheme(&self) -> Option<Scheme> {
        self.mesh.scheme
    }

    fn look(&self) -> Look {
        // Lights that run across the picture look alike from front and back.
        let default = if self.show == Show::ReflectionLines { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let axis = self.axis.map_or(default, |axis| self.up.turned(axis));
        Look {
            size: self.size,
            samples: self.samples,
            camera: self.up.turned_camera(self.camera),
            show: self.show,
            background: self.background,
            stripes: Stripes { axis, count: self.stripes.unwrap_or(STRIPES) },
            range: self.range,
            edges: self.edges,
            legend: !self.no_legend,
        }
    }
}

/// Runs the verb.
pub fn run(args: &RenderArgs, common: &Common, console: &Console) -> Result<(), Failure> {
    args.check()?;
    if args.baseline.is_some() && !matches!(args.show, Show::Patches | Show::Levels) {
        return Err(Failure::Usage("--baseline is for pictures of patches: add --show levels or --show patches"));
    }
    let output = Output::new(&args.output, common)?;
    output.check_extension("png", |name| Failure::PictureName { name })?;
    let input = Input::load(&args.mesh, args.rule.triangles, console)?;
    let start = Instant::now();
    let picture = args.draw(&input, console)?;
    output.write_with(|out| picture.image.write_png(out).map_err(FillError::from))?;
    if common.json {
        print_json(&json!({
            "output": output.name(),
            "width": args.size[0],
            "height": args.size[1],
            "samples": args.samples,
            "rate": picture.rate,
            "triangles": picture.triangles,
            "range": picture.range,
            "seconds": start.elapsed().as_secs_f64(),
        }))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_backgrounds_are_read_or_explained() {
        assert_eq!(parse_size("640x480"), Ok([640, 480]));
        for wrong in ["640", "0x5", "-1x5", "99999x2", "16384x16384", "x"] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
        assert_eq!(parse_background("#102fFf"), Ok(Background::Plain([16, 47, 255])));
        for wrong in ["red", "#12345", "#+12345", "#1234567"] {
            assert!(parse_background(wrong).is_err(), "{wrong}");
        }
    }
}
