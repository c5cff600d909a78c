//! From a surface to a picture, for any verb.

use super::marks;
use super::paint::Painter;
use super::{lines, patch_lines, rate};
use rayon::prelude::*;
use subsurf::{
    AdaptiveRefinement, Facets, PatchTable, Rates, ShadingNormals, TessellateError, TessellateOptions, Tessellation,
};
use subsurf_render::{
    Background, Camera, Image, Options, Overlay, Progress, RenderError, RenderMesh, RenderTriangle, Scene, Show,
    Stripes,
};
use thiserror::Error;

/// What is in the picture.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    pub table: &'a PatchTable,
    /// Control points; +y is up.
    pub points: &'a [[f32; 3]],
    /// Normals, where they are not the surface's own.
    pub shading: Option<&'a ShadingNormals<'a>>,
    /// Whose patches are shown instead of ours.
    pub baseline: Option<&'a AdaptiveRefinement>,
}

/// How it is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Width and height in pixels.
    pub size: [u32; 2],
    pub samples: u32,
    pub camera: Camera,
    pub show: Show,
    pub background: Background,
    /// Stripes of isophotes and reflection lines.
    pub stripes: Stripes,
    /// Largest curvature that colours tell apart; `None`: what the picture needs.
    pub range: Option<f64>,
    /// Whether the control mesh's edges are drawn on the surface, where what is shown does not draw them anyway.
    pub edges: bool,
    /// Whether colours are explained, where they have a meaning.
    pub legend: bool,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            size: [1280, 720],
            samples: 16,
            camera: Camera::Auto,
            show: Show::Shaded,
            background: Background::Gradient,
            stripes: Stripes { axis: [0.0, 1.0, 0.0], count: STRIPES },
            range: None,
            edges: false,
            legend: true,
        }
    }
}

/// Dark stripes unless told otherwise: enough that a face of an ordinary control mesh has some, few enough that each is
/// some pixels wide.
pub const STRIPES: u32 = 16;

/// The picture, and facts about it.
pub struct Picture {
    pub image: Image,
    /// Facets along a side of a face.
    pub rate: u32,
    pub triangles: usize,
    /// Largest curvature that its colours tell apart.
    pub range: Option<f64>,
}

/// Why there is none.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PictureError {
    #[error(transparent)]
    Tessellate(#[from] TessellateError),
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// Makes a picture.
///
/// # Errors
/// If the surface is too large or too small for it.
pub fn draw(subject: &Subject<'_>, look: &Look, progress: Option<Progress<'_>>) -> Result<Picture, PictureError> {
    let surface = subject.table.surface(subject.points);
    let rate = rate::for_picture(subject.table, subject.points, look.camera, look.size);
    let options = TessellateOptions {
        rates: Rates::Uniform(rate),
        facets: Facets::Triangles,
        normals: false,
        places: true,
        ..TessellateOptions::default()
    };
    let mesh = render_mesh(surface.tessellate(&options)?);
    let scene = Scene::new(&mesh).map_err(RenderError::from)?;
    let options = Options {
        width: look.size[0],
        height: look.size[1],
        samples: look.samples,
        camera: look.camera,
        show: look.show,
        background: look.background,
        ..Options::default()
    };
    let mut overlay = overlay(subject, look, rate);
    let mut painter = Painter::new(subject, look, &mesh);
    let mut marks = 0;
    if matches!(look.show, Show::Gaussian | Show::Mean) {
        painter.set_range(look.range, subject.points, &scene.seen(&overlay, &options, SEEN_STEP)?);
        overlay.dots = marks::without_curvature(&surface, look.size[1]);
        marks = overlay.dots.len();
    }
    overlay.legend = painter.legend(marks).filter(|_| look.legend);
    let image = scene.render(&painter, &overlay, &options, progress)?;
    Ok(Picture { image, rate, triangles: mesh.triangles.len(), range: painter.range() })
}

/// Every so many pixels are asked for their curvature to find the colours' range: fewer make no visible difference.
const SEEN_STEP: u32 = 4;

/// Lines and dots that belong to what is shown.
fn overlay(subject: &Subject<'_>, look: &Look, rate: u32) -> Overlay {
    let surface = subject.table.surface(subject.points);
    let wireframe = || Overlay::wireframe(lines::edge_curves(&surface, rate));
    let mut overlay = match look.show {
        Show::Wireframe | Show::Patches | Show::Levels => wireframe(),
        Show::Cage => {
            let edges = lines::cage_edges(subject.table.topology());
            let mean = rate::mean_px(&edges, subject.points, look.camera, look.size);
            Overlay::cage(subject.points, &edges).thinned(mean as f32)
        }
        _ if look.edges => wireframe(),
        _ => Overlay::default(),
    };
    if let Some(baseline) = subject.baseline {
        overlay.lines.extend(patch_lines::patch_lines(&surface, baseline, rate, look.camera, look.size));
    }
    overlay
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
