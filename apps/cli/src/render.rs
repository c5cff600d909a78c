//! `subsurf render`: a picture of the limit surface.

mod lines;
mod paint;
mod patch_lines;
mod rate;

use crate::args::{Choices, Common, Evaluator, MeshArgs, TriangleRule, one_of};
use crate::baseline::BaselineArgs;
use crate::console::{Console, print_json};
use crate::failure::Failure;
use crate::input::Input;
use crate::output::{FillError, Output};
use clap::Args;
use paint::Painter;
use rayon::prelude::*;
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;
use subsurf::{Facets, Rates, TessellateOptions, Tessellation};
use subsurf_render::{Background, Camera, Image, Options, Overlay, RenderMesh, RenderTriangle, Scene, Show, View};

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
    #[command(flatten)]
    baseline: BaselineArgs,
    /// What is behind: gradient, transparent, or a colour as #rrggbb
    #[arg(long, value_name = "COLOUR", default_value = "gradient", value_parser = parse_background)]
    background: Background,
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

impl RenderArgs {
    /// The scheme, where one is given.
    pub fn scheme(&self) -> Option<subsurf::Scheme> {
        self.mesh.scheme
    }
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

/// Runs the verb.
pub fn run(args: &RenderArgs, common: &Common, console: &Console) -> Result<(), Failure> {
    if args.baseline.is_some() && !matches!(args.show, Show::Patches | Show::Levels) {
        return Err(Failure::Usage("--baseline is for pictures of patches: add --show levels or --show patches"));
    }
    let output = Output::new(&args.output, common)?;
    output.check_extension("png", |name| Failure::PictureName { name })?;
    let input = Input::load(&args.mesh, args.rule.triangles, console)?;
    let picture = picture(args, &input, console)?;
    output.write_with(|out| picture.image.write_png(out).map_err(FillError::from))?;
    if common.json {
        print_json(&json!({
            "output": output.name(),
            "width": args.size[0],
            "height": args.size[1],
            "samples": args.samples,
            "rate": picture.rate,
            "triangles": picture.triangles,
            "tessellate_seconds": picture.tessellated_s,
            "seconds": picture.seconds,
        }))?;
    }
    Ok(())
}

/// A picture, and what it took.
pub struct Picture {
    pub image: Image,
    rate: u32,
    triangles: usize,
    tessellated_s: f64,
    seconds: f64,
}

/// Makes a picture of a mesh; the arguments' file is not looked at.
pub fn picture(args: &RenderArgs, input: &Input, console: &Console) -> Result<Picture, Failure> {
    let start = Instant::now();
    let points: Vec<[f32; 3]> = input.positions()?.into_iter().map(|p| args.up.turned(p)).collect();
    let camera = args.up.turned_camera(args.camera);
    let table = input.patch_table(args.evaluator.evaluator, console)?;
    if table.size().patches == 0 {
        return Err(Failure::OnlyHoles { name: input.name.clone() });
    }
    let baseline = args.baseline.refine(table.topology(), input)?;
    let surface = table.surface(&points);
    let rate = rate::for_picture(&table, &points, camera, args.size);
    let options = TessellateOptions {
        rates: Rates::Uniform(rate),
        facets: Facets::Triangles,
        normals: false,
        places: true,
        ..TessellateOptions::default()
    };
    let tessellated = surface.tessellate(&options);
    let tessellated = tessellated.map_err(|source| Failure::Tessellate { name: input.name.clone(), source })?;
    let mesh = render_mesh(tessellated);
    console.note(&format_args!("rate {rate}: {} triangles", mesh.triangles.len()));
    let tessellated_s = start.elapsed().as_secs_f64();

    let painter = Painter::new(surface, args.show, baseline.as_ref(), &mesh);
    let mut overlay = match args.show {
        Show::Wireframe | Show::Patches | Show::Levels => Overlay::wireframe(lines::edge_curves(&surface, rate)),
        Show::Cage => {
            let edges = lines::cage_edges(table.topology());
            let mean = rate::mean_px(&edges, &points, camera, args.size);
            Overlay::cage(&points, &edges).thinned(mean as f32)
        }
        _ => Overlay::default(),
    };
    if let Some(baseline) = &baseline {
        overlay.lines.extend(patch_lines::patch_lines(&surface, baseline, rate, camera, args.size));
    }
    overlay.legend = painter.legend();
    let options = Options {
        width: args.size[0],
        height: args.size[1],
        samples: args.samples,
        camera,
        show: args.show,
        background: args.background,
        ..Options::default()
    };
    let bar = console.progress("rendering", 1000);
    let tell = |done: f32| bar.set_position((done * 1000.0) as u64);
    let scene = Scene::new(&mesh).map_err(|error| fail(input, error.into()))?;
    let image = scene.render(&painter, &overlay, &options, Some(&tell)).map_err(|error| fail(input, error))?;
    bar.finish_and_clear();
    let (triangles, seconds) = (mesh.triangles.len(), start.elapsed().as_secs_f64());
    Ok(Picture { image, rate, triangles, tessellated_s, seconds })
}

fn fail(input: &Input, source: subsurf_render::RenderError) -> Failure {
    Failure::Render { name: input.name.clone(), source }
}

/// The triangles with their places.
fn render_mesh(tessellated: Tessellation<f32>) -> RenderMesh {
    let places = tessellated.places.unwrap_or_default();
    let triangle = |i: usize| {
        let corner = |k: usize| 3 * i + k;
        let (face, subface) = places.facet[i];
        RenderTriangle {
            corners: [0, 1, 2].map(|k| tessellated.corners[corner(k)]),
            face,
            subface,
            uv: [0, 1, 2].map(|k| places.corner_uv[corner(k)].map(|x| x as f32)),
        }
    };
    let triangles = (0..places.facet.len()).into_par_iter().map(triangle).collect();
    RenderMesh { positions: tessellated.positions, triangles }
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
