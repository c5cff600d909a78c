//! Smoothing of the visibilities over the surface.
//!
//! An à-trous filter (Dammertz, Sewtz, Hanika and Lensch, "Edge-avoiding à-trous wavelet transform", 2010) that
//! averages neighbours on the same smooth piece of surface. It touches only how much light is seen, never normals,
//! colours or silhouettes, and less of it the more rays were cast.

use crate::trace::{CHANNELS, FLOOR, Pixel};
use rayon::prelude::*;

/// Passes; pass k reaches 2 · 2ᵏ pixels. More smear contact shadows, fewer leave grain.
const PASSES: u32 = 3;
/// Neighbours count less as the cosine between normals falls; this is its exponent.
const NORMAL_POWER: i32 = 24;
const KERNEL: [f32; 3] = [3.0 / 8.0, 1.0 / 4.0, 1.0 / 16.0];

/// What every pixel sees of each light, 0 to 1, smoothed. `footprint` is the size of a pixel on the
/// surface at unit depth, `depth` gives the depth of a position.
pub fn visibilities(pixels: &[Pixel], width: usize, footprint: impl Fn(&Pixel) -> f32 + Sync) -> Vec<[f32; CHANNELS]> {
    let mut values: Vec<[f32; CHANNELS]> = pixels
        .par_iter()
        .map(|p| [0, 1, 2].map(|i| if p.rays[i] > 0.0 { p.open[i] / p.rays[i] } else { 1.0 }))
        .collect();
    for pass in 0..PASSES {
        let step = 1isize << pass;
        let source = &values;
        values = (0..pixels.len())
            .into_par_iter()
            .with_min_len(width)
            .map(|center| filtered(pixels, source, width, center, step, &footprint))
            .collect();
    }
    values
}

fn filtered(
    pixels: &[Pixel],
    values: &[[f32; CHANNELS]],
    width: usize,
    center: usize,
    step: isize,
    footprint: &(impl Fn(&Pixel) -> f32 + Sync),
) -> [f32; CHANNELS] {
    let here = &pixels[center];
    if here.rays == [0.0; CHANNELS] {
        return values[center];
    }
    let (x, y) = ((center % width) as isize, (center / width) as isize);
    let height = (pixels.len() / width) as isize;
    // Three standard deviations of a half-open sky, shrinking from pass to pass.
    let spread = here.rays.map(|rays| 1.5 / rays.max(1.0).sqrt() / (step as f32).sqrt());
    let plane = 1.0 / (footprint(here) * step as f32).max(f32::MIN_POSITIVE);
    let (mut sums, mut weights) = ([0.0f32; CHANNELS], [0.0f32; CHANNELS]);
    for dy in -2..=2isize {
        for dx in -2..=2isize {
            let (nx, ny) = (x + dx * step, y + dy * step);
            if nx < 0 || ny < 0 || nx >= width as isize || ny >= height {
                continue;
            }
            let neighbour = ny as usize * width + nx as usize;
            let there = &pixels[neighbour];
            if there.rays == [0.0; CHANNELS] {
                continue;
            }
            let kernel = KERNEL[dx.unsigned_abs()] * KERNEL[dy.unsigned_abs()];
            let aligned = here.normal.dot(there.normal).max(0.0).powi(NORMAL_POWER);
            let away = there.position - here.position;
            let off_plane = (away.dot(here.normal).abs()).max(away.dot(there.normal).abs()) * plane;
            let geometry = kernel * aligned / (1.0 + off_plane * off_plane).powi(2);
            for i in 0..CHANNELS {
                // The floor is flat and has its own rays: no edges to avoid.
                let geometry = if i == FLOOR { kernel } else { geometry };
                let difference = (values[neighbour][i] - values[center][i]) / spread[i];
                let weight = geometry * there.rays[i] / (1.0 + difference * difference).powi(2);
                sums[i] += weight * values[neighbour][i];
                weights[i] += weight;
            }
        }
    }
    [0, 1, 2].map(|i| if weights[i] > 0.0 { sums[i] / weights[i] } else { values[center][i] })
}
