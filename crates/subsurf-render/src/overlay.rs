//! Lines, dots and a legend over the picture.
//!
//! Lines and dots lie in space. Whether the mesh hides them is found by a ray from the eye for about every pixel of
//! their length; their edges are smoothed by how much of a pixel they cover.

use crate::bvh::{Bvh, Ray, Stack};
use crate::camera::Lens;
use crate::legend::Legend;
use crate::{RenderError, palette};
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

/// A line or dot is drawn as visible up to this far behind the surface, in radii of the mesh: larger shows lines
/// through thin parts, smaller breaks lines on the surface where triangles bulge over them.
const BIAS: f32 = 2.5e-3;

/// What is drawn over the surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlay {
    /// Drawn in order; neighbours of the same look do not darken each other where they meet.
    pub lines: Vec<Polyline>,
    /// Drawn over the lines.
    pub dots: Vec<Dot>,
    /// Drawn last, into the corner where it hides least of the mesh; the lower left one if there are several.
    pub legend: Option<Legend>,
}

/// How a line or dot looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Linear RGB.
    pub color: [f32; 3],
    /// Opacity where the mesh does not hide it, 0 to 1.
    pub opacity: f32,
    /// Opacity where the mesh hides it.
    pub hidden: f32,
    /// Width of a line, diameter of a dot, in pixels.
    pub width_px: f32,
}

/// A line through points in space.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// In model units.
    pub points: Vec<[f32; 3]>,
    /// Its look.
    pub stroke: Stroke,
}

/// A round dot that faces the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// In model units.
    pub point: [f32; 3],
    /// Its look.
    pub stroke: Stroke,
}

impl Stroke {
    /// Thin and dark, for lines on the surface.
    pub fn wire() -> Self {
        Self { color: palette::linear([38, 50, 66]), opacity: 0.75, hidden: 0.0, width_px: 1.1 }
    }

    /// For the edges of a control mesh; faint behind the surface.
    pub fn cage_edge() -> Self {
        Self { color: palette::linear([28, 78, 138]), opacity: 0.95, hidden: 0.22, width_px: 1.6 }
    }

    /// For the vertices of a control mesh.
    pub fn cage_vertex() -> Self {
        Self { color: palette::linear([196, 62, 40]), opacity: 1.0, hidden: 0.25, width_px: 5.5 }
    }
}

impl Overlay {
    /// The edges and vertices of a control mesh.
    ///
    /// # Panics
    /// If an edge names a position that does not exist.
    pub fn cage(positions: &[[f32; 3]], edges: &[[u32; 2]]) -> Self {
        let lines = edges
            .iter()
            .map(|edge| Polyline { points: edge.map(|i| positions[i as usize]).to_vec(), stroke: Stroke::cage_edge() })
            .collect();
        let mut used = vec![false; positions.len()];
        for i in edges.as_flattened() {
            used[*i as usize] = true;
        }
        let dots = positions
            .iter()
            .zip(used)
            .filter(|(_, used)| *used)
            .map(|(&point, _)| Dot { point, stroke: Stroke::cage_vertex() })
            .collect();
        Self { lines, dots, legend: None }
    }

    /// Thinner lines and smaller dots for edges that are `mean_px` pixels long on average, so that the picture of a dense
    /// control mesh stays readable: without dots where they would touch.
    #[must_use]
    pub fn thinned(mut self, mean_px: f32) -> Self {
        // Lines keep their full width from 16 pixels on; dots come at 12 and are full at 24.
        let line = (mean_px / 16.0).clamp(0.25, 1.0);
        let dot = (mean_px / 24.0).min(1.0);
        for stroke in self.lines.iter_mut().map(|line| &mut line.stroke) {
            stroke.width_px *= line;
            stroke.hidden *= line * line;
        }
        if mean_px < 12.0 {
            self.dots.clear();
        }
        for stroke in self.dots.iter_mut().map(|dot| &mut dot.stroke) {
            stroke.width_px *= dot;
        }
        self
    }

    /// Lines on the surface, such as the images of the control mesh's edges.
    pub fn wireframe(lines: impl IntoIterator<Item = Vec<[f32; 3]>>) -> Self {
        let lines = lines.into_iter().map(|points| Polyline { points, stroke: Stroke::wire() }).collect();
        Self { lines, ..Self::default() }
    }

    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let fine = |stroke: &Stroke, points: &[[f32; 3]]| {
            points.as_flattened().iter().all(|x| x.abs() < 1e18) && stroke.width_px.is_finite()
        };
        if let Some(index) = self.lines.iter().position(|line| !fine(&line.stroke, &line.points)) {
            return Err(RenderError::OverlayNotFinite { what: "line", index });
        }
        if let Some(index) = self.dots.iter().position(|dot| !fine(&dot.stroke, &[dot.point])) {
            return Err(RenderError::OverlayNotFinite { what: "dot", index });
        }
        Ok(())
    }

    /// Draws over linear, premultiplied `colors`, of which the mesh covers these shares.
    pub(crate) fn draw(
        &self,
        colors: &mut [Vec4],
        covered: &[f32],
        lens: &Lens,
        size: [u32; 2],
        bvh: &Bvh,
        radius: f32,
    ) {
        let projector = Projector { lens, size, bvh, radius };
        let segments = projector.lines(&self.lines);
        let dots = projector.dots(&self.dots);
        draw_shapes(colors, size, &segments);
        draw_shapes(colors, size, &dots);
        if let Some(legend) = &self.legend {
            legend.draw(colors, covered, size);
        }
    }
}

/// A piece of a line in the picture, or a dot: a segment with round ends, in pixels.
struct Shape {
    from: Vec2,
    to: Vec2,
    stroke: Stroke,
    /// Opacity at equal steps from one end to the other.
    opacity: Vec<f32>,
}

impl Shape {
    /// Half the width, at least half a pixel; thinner lines become fainter instead.
    fn half_width(&self) -> f32 {
        self.stroke.width_px.max(1.0) / 2.0
    }

    /// Rows that it may touch.
    fn rows(&self, height: u32) -> std::ops::Range<usize> {
        let reach = self.half_width() + 0.5;
        let top = (self.from.y.min(self.to.y) - reach).floor().max(0.0);
        let bottom = (self.from.y.max(self.to.y) + reach).ceil().min(height as f32);
        top as usize..bottom.max(top) as usize
    }

    /// How much of the pixel with this centre it covers, times its opacity there.
    fn cover(&self, center: Vec2) -> f32 {
        let along = self.to - self.from;
        let t = ((center - self.from).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
        let distance = (center - (self.from + along * t)).length();
        let coverage = (self.half_width() + 0.5 - distance).clamp(0.0, 1.0) * self.stroke.width_px.clamp(0.0, 1.0);
        if coverage == 0.0 {
            return 0.0;
        }
        let step = t * (self.opacity.len() - 1) as f32;
        let (i, f) = (step as usize, step.fract());
        let next = (i + 1).min(self.opacity.len() - 1);
        coverage * (self.opacity[i] * (1.0 - f) + self.opacity[next] * f)
    }
}

struct Projector<'a> {
    lens: &'a Lens,
    size: [u32; 2],
    bvh: &'a Bvh,
    radius: f32,
}

impl Projector<'_> {
    fn lines(&self, lines: &[Polyline]) -> Vec<Shape> {
        lines
            .par_iter()
            .map_init(Stack::new, |stack, line| {
                line.points
                    .windows(2)
                    .filter_map(|p| self.segment(p[0].into(), p[1].into(), line.stroke, stack))
                    .collect()
            })
            .collect::<Vec<Vec<Shape>>>()
            .into_iter()
            .flatten()
            .collect()
    }

    fn dots(&self, dots: &[Dot]) -> Vec<Shape> {
        dots.par_iter()
            .map_init(Stack::new, |stack, dot| self.segment(dot.point.into(), dot.point.into(), dot.stroke, stack))
            .flatten()
            .collect()
    }

    fn segment(&self, from: Vec3, to: Vec3, stroke: Stroke, stack: &mut Stack) -> Option<Shape> {
        // Cut off what is behind the eye or very close.
        let near = 1e-3 * self.radius;
        let (mut ends, depths) = ([from, to], [self.lens.depth(from), self.lens.depth(to)]);
        if depths.iter().all(|&d| d < near) {
            return None;
        }
        for i in 0..2 {
            if depths[i] < near {
                ends[i] += (ends[1 - i] - ends[i]) * ((near - depths[i]) / (depths[1 - i] - depths[i]));
            }
        }
        let size = Vec2::new(self.size[0] as f32, self.size[1] as f32);
        let [a, b] = ends.map(|p| Vec2::from(self.lens.project(p)) * size);
        let reach = Vec2::splat(stroke.width_px / 2.0 + 1.0);
        if a.max(b).cmplt(-reach).any() || a.min(b).cmpgt(size + reach).any() {
            return None;
        }
        // Equal steps in the picture are unequal ones in space: 1 / depth is linear in the picture.
        let steps = ((b - a).length().ceil().min(4.0 * size.max_element()) as usize).max(1);
        let [da, db] = ends.map(|p| self.lens.depth(p).max(near));
        let opacity = (0..=steps)
            .map(|step| {
                let s = step as f32 / steps as f32;
                let t = s * da / (s * da + (1.0 - s) * db);
                if self.visible(ends[0].lerp(ends[1], t), stack) { stroke.opacity } else { stroke.hidden }
            })
            .collect();
        Some(Shape { from: a, to: b, stroke, opacity })
    }

    fn visible(&self, point: Vec3, stack: &mut Stack) -> bool {
        let direction = point - self.lens.eye;
        let distance = direction.length();
        let reach = 1.0 - BIAS * self.radius / distance.max(f32::MIN_POSITIVE);
        reach <= 0.0 || !self.bvh.blocked(&Ray { origin: self.lens.eye, direction, reach }, stack)
    }
}

/// Draws shapes in order, bands of rows in parallel. A run of shapes of one look is one layer: where several of
/// them touch a pixel the largest coverage counts, so joints are no darker than lines.
fn draw_shapes(colors: &mut [Vec4], size: [u32; 2], shapes: &[Shape]) {
    const BAND: usize = 8;
    let width = size[0] as usize;
    if shapes.is_empty() {
        return;
    }
    let mut bands: Vec<Vec<u32>> = vec![Vec::new(); (size[1] as usize).div_ceil(BAND)];
    for (i, shape) in shapes.iter().enumerate() {
        let rows = shape.rows(size[1]);
        if !rows.is_empty() {
            for band in &mut bands[rows.start / BAND..=(rows.end - 1) / BAND] {
                band.push(i as u32);
            }
        }
    }
    colors.par_chunks_mut(width * BAND).zip(bands).enumerate().for_each(|(band, (colors, touching))| {
        let mut layer = vec![0.0f32; colors.len()];
        for run in touching.chunk_by(|&i, &j| shapes[i as usize].stroke == shapes[j as usize].stroke) {
            layer.fill(0.0);
            for &i in run {
                cover_band(&shapes[i as usize], band * BAND, width, &mut layer);
            }
            let color = Vec3::from(shapes[run[0] as usize].stroke.color).extend(1.0);
            for (pixel, &alpha) in colors.iter_mut().zip(&layer) {
                if alpha > 0.0 {
                    *pixel = color * alpha + *pixel * (1.0 - alpha);
                }
            }
        }
    });
}

fn cover_band(shape: &Shape, first_row: usize, width: usize, layer: &mut [f32]) {
    let reach = shape.half_width() + 0.5;
    for (dy, row) in layer.chunks_mut(width).enumerate() {
        let y = (first_row + dy) as f32 + 0.5;
        // The part of the segment near this row bounds the columns.
        let (top, bottom) = if shape.from.y < shape.to.y { (shape.from, shape.to) } else { (shape.to, shape.from) };
        if y < top.y - reach || y > bottom.y + reach {
            continue;
        }
        let along = bottom - top;
        let at = |y: f32| top.x + along.x * ((y - top.y) / along.y).clamp(0.0, 1.0);
        let (x0, x1) = if along.y > 1e-3 { (at(y - reach), at(y + reach)) } else { (top.x, bottom.x) };
        let left = (x0.min(x1) - reach).floor().max(0.0) as usize;
        let right = ((x0.max(x1) + reach).ceil().max(0.0) as usize).min(width);
        for x in left..right {
            let cover = shape.cover(Vec2::new(x as f32 + 0.5, y));
            row[x] = row[x].max(cover);
        }
    }
}
