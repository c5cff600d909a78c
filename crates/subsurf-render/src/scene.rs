//! From a mesh to a picture.

use crate::bvh::{Bvh, Stack};
use crate::camera::{Camera, Lens};
use crate::error::{MAX_PIXELS, MAX_SAMPLES, MAX_SIDE};
use crate::light::{Studio, interreflected, tone};
use crate::trace::{Floor, Pixel, Scratch, Tracer};
use crate::{
    Faceted, Image, Overlay, RenderError, RenderMesh, SceneError, Show, SurfaceAt, SurfaceShader, palette, smooth,
};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Told how much of the picture is done, from 0 to 1, by any thread.
pub type Progress<'a> = &'a (dyn Fn(f32) + Sync);

/// How to make a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples per pixel. Powers of two are spread best; 16 suffices for the web, 64 for print.
    pub samples: u32,
    /// Where the picture is taken from.
    pub camera: Camera,
    /// What colours the surface.
    pub show: Show,
    /// What is behind it.
    pub background: Background,
    /// Whether a floor just under the mesh receives its shadow.
    pub floor: bool,
}

impl Default for Options {
    /// 1280 × 720 pixels, 16 samples, automatic camera, shaded, before a light gradient, on a floor.
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            samples: 16,
            camera: Camera::Auto,
            show: Show::Shaded,
            background: Background::Gradient,
            floor: true,
        }
    }
}

/// What is behind the mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Background {
    /// Nearly white in the middle, light grey towards the corners.
    #[default]
    Gradient,
    /// One sRGB colour.
    Plain([u8; 3]),
    /// Nothing: alpha is 0 there, and the floor's shadow is see-through black.
    Transparent,
}

impl Background {
    /// Linear colour and opacity at a point of the picture, from (0, 0) to (1, 1).
    fn color(self, x: f32, y: f32) -> Vec4 {
        match self {
            Self::Transparent => Vec4::ZERO,
            Self::Plain(srgb) => Vec3::from(palette::linear(srgb)).extend(1.0),
            Self::Gradient => {
                let (dx, dy) = (x - 0.5, y - 0.42);
                let t = ((dx * dx + dy * dy) * 1.7).min(1.0);
                let (inner, outer) = (palette::linear([248, 248, 249]), palette::linear([205, 209, 215]));
                Vec3::from(inner).lerp(outer.into(), t).extend(1.0)
            }
        }
    }
}

/// Renders one picture. For several of the same mesh, keep a [`Scene`].
///
/// # Errors
/// If the mesh is empty or not finite, or an option is out of range.
pub fn render(
    mesh: &RenderMesh,
    shader: &dyn SurfaceShader,
    overlay: &Overlay,
    options: &Options,
    progress: Option<Progress<'_>>,
) -> Result<Image, RenderError> {
    options.check()?;
    Scene::new(mesh)?.render(shader, overlay, options, progress)
}

impl Options {
    fn check(&self) -> Result<(), RenderError> {
        let &Self { width, height, samples, .. } = self;
        let sides = (1..=MAX_SIDE).contains(&width) && (1..=MAX_SIDE).contains(&height);
        if !sides || u64::from(width) * u64::from(height) > MAX_PIXELS {
            return Err(RenderError::Size { width, height });
        }
        if !(1..=MAX_SAMPLES).contains(&samples) {
            return Err(RenderError::Samples { samples });
        }
        Ok(())
    }
}

/// A mesh prepared for rendering from any side.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    mesh: &'a RenderMesh,
    bvh: Bvh,
    center: Vec3,
    radius: f32,
    lowest: f32,
    epsilon: f32,
}

impl<'a> Scene<'a> {
    /// Checks and arranges the mesh.
    ///
    /// # Errors
    /// If the mesh is empty, not finite, or a triangle names a vertex that does not exist.
    pub fn new(mesh: &'a RenderMesh) -> Result<Self, SceneError> {
        mesh.check()?;
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.corners).collect();
        let bvh = Bvh::new(&mesh.positions, &triangles);
        let (mut lower, mut upper) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for i in triangles.as_flattened() {
            let p = Vec3::from(mesh.positions[*i as usize]);
            (lower, upper) = (lower.min(p), upper.max(p));
        }
        let radius = ((upper - lower).length() / 2.0).max(f32::MIN_POSITIVE);
        let largest = lower.abs().max(upper.abs()).max_element();
        Ok(Self {
            mesh,
            bvh,
            center: (lower + upper) / 2.0,
            radius,
            lowest: lower.y,
            // Some ulps of the coordinates, and of the extent.
            epsilon: 1e-6 * largest + 1e-5 * radius,
        })
    }

    /// Renders a picture.
    ///
    /// # Errors
    /// If an option is out of range or the overlay is not finite.
    pub fn render(
        &self,
        shader: &dyn SurfaceShader,
        overlay: &Overlay,
        options: &Options,
        progress: Option<Progress<'_>>,
    ) -> Result<Image, RenderError> {
        overlay.check()?;
        let tracer = self.tracer(shader, overlay, options)?;
        let lens = tracer.lens;
        let pixels = traced(&tracer, progress);
        let mut colors = self.developed(&pixels, &lens, options);
        let covered: Vec<f32> = pixels.iter().map(|pixel| pixel.fixed.w).collect();
        drop(pixels);
        overlay.draw(&mut colors, &covered, &lens, [options.width, options.height], &self.bvh, self.radius);
        let dither = options.background == Background::Gradient;
        Ok(Image::from_linear(options.width, options.height, &colors, dither))
    }

    /// The places that the same picture shows in the middle of every `step`-th pixel of every `step`-th row; for
    /// statistics over what is seen.
    ///
    /// # Errors
    /// As for [`render`](Self::render).
    ///
    /// # Panics
    /// If `step` is 0.
    pub fn seen(&self, overlay: &Overlay, options: &Options, step: u32) -> Result<Vec<SurfaceAt>, RenderError> {
        overlay.check()?;
        let tracer = self.tracer(&Faceted, overlay, options)?;
        let rows: Vec<u32> = (0..options.height).step_by(step as usize).collect();
        let row = |stack: &mut Stack, y: u32| -> Vec<SurfaceAt> {
            (0..options.width).step_by(step as usize).filter_map(|x| tracer.middle(x, y, stack)).collect()
        };
        Ok(rows.into_par_iter().map_init(Stack::new, row).flatten_iter().collect())
    }

    fn tracer<'s>(
        &'s self,
        shader: &'s dyn SurfaceShader,
        overlay: &Overlay,
        options: &Options,
    ) -> Result<Tracer<'s>, RenderError> {
        options.check()?;
        let lens = self.lens(overlay, options)?;
        Ok(Tracer {
            mesh: self.mesh,
            bvh: &self.bvh,
            shader,
            show: options.show,
            lens,
            studio: Studio::new(&lens),
            floor: (options.floor && options.show != Show::Normals)
                .then_some(Floor { height: self.lowest - self.epsilon, center: self.center }),
            radius: self.radius,
            epsilon: self.epsilon,
            size: [options.width, options.height],
            samples: options.samples,
        })
    }

    fn lens(&self, overlay: &Overlay, options: &Options) -> Result<Lens, RenderError> {
        let aspect = f64::from(options.width) / f64::from(options.height);
        let view = match options.camera {
            Camera::At(view) => view,
            Camera::Auto => {
                // Only what is drawn counts: meshes may hold unused positions.
                let mut points: Vec<[f32; 3]> = self
                    .mesh
                    .triangles
                    .iter()
                    .flat_map(|t| t.corners.map(|i| self.mesh.positions[i as usize]))
                    .collect();
                points.extend(overlay.lines.iter().flat_map(|line| &line.points));
                points.extend(overlay.dots.iter().map(|dot| dot.point));
                Camera::Auto.view(&points, aspect)
            }
        };
        view.lens(aspect).ok_or(RenderError::Camera { eye: view.eye, target: view.target, fov_deg: view.fov_deg })
    }

    /// From samples to colours: filtered visibility, light, tone, background.
    fn developed(&self, pixels: &[Pixel], lens: &Lens, options: &Options) -> Vec<Vec4> {
        let (width, height) = (options.width as usize, options.height as usize);
        let footprint = lens.height_at_unit_depth() / options.height as f32;
        let open = smooth::visibilities(pixels, width, |pixel| lens.depth(pixel.position) * footprint);
        let develop = |(i, pixel): (usize, &Pixel)| {
            let [sky, key, floor] = open[i];
            let alpha = pixel.fixed.w;
            let light = pixel.fixed.truncate() + pixel.sky * interreflected(sky, pixel.albedo) + pixel.key * key;
            // Tone the light of what covers the pixel, not the share of it that the pixel holds.
            let toned = match options.show {
                Show::Normals => light,
                _ if alpha > 0.0 => tone(light / alpha) * alpha,
                _ => Vec3::ZERO,
            };
            let (x, y) = ((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
            let background = options.background.color(x / width as f32, y / height as f32);
            // The veil covers a part of what the mesh leaves free.
            let veil = pixel.veil * (1.0 - floor);
            toned.extend(alpha + veil) + background * (1.0 - alpha - veil)
        };
        pixels.par_iter().enumerate().map(develop).collect()
    }
}

/// All pixels, traced in square tiles, bands of tiles in parallel.
fn traced(tracer: &Tracer<'_>, progress: Option<Progress<'_>>) -> Vec<Pixel> {
    const TILE: usize = 16;
    let [width, height] = tracer.size.map(|x| x as usize);
    let mut pixels = vec![Pixel::default(); width * height];
    let bands = height.div_ceil(TILE);
    let done = AtomicUsize::new(0);
    pixels.par_chunks_mut(width * TILE).enumerate().for_each_init(Scratch::default, |scratch, (band, rows)| {
        for left in (0..width).step_by(TILE) {
            for (dy, row) in rows.chunks_mut(width).enumerate() {
                for x in left..(left + TILE).min(width) {
                    row[x] = tracer.pixel(x as u32, (band * TILE + dy) as u32, scratch);
                }
            }
        }
        if let Some(progress) = progress {
            progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f32 / bands as f32);
        }
    });
    pixels
}
