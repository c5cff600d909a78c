//! Several pictures in one, in rows and columns, with words under the columns.

use super::lettering::Lettering;
use png::{BitDepth, ColorType, Compression, Encoder, SrgbRenderingIntent};
use std::io;
use subsurf_render::Image;

/// Between panels, and the strip for words, in thousandths of the sheet's width.
const GAP: u32 = 6;
const STRIP: u32 = 26;
const INK: f32 = 45.0;

/// Pictures of one size.
pub struct Sheet {
    pub columns: usize,
    /// Row by row, all of one size.
    pub panels: Vec<Image>,
    /// One per column; none at all for a sheet without words.
    pub labels: Vec<String>,
}

impl Sheet {
    /// As a PNG file.
    pub fn png(&self) -> io::Result<Vec<u8>> {
        let [w, h] = self.panels.first().map_or([0; 2], |panel| [panel.width(), panel.height()]);
        let columns = self.columns as u32;
        let rows = self.panels.len().div_ceil(self.columns) as u32;
        let gap = (columns * w * GAP).div_ceil(1000);
        let strip = if self.labels.is_empty() { 0 } else { (columns * w * STRIP / 1000).clamp(18, w.max(18)) };
        let [width, height] = [columns * w + (columns - 1) * gap, rows * h + (rows - 1) * gap + strip];
        let mut pixels = vec![[255u8; 3]; (width * height) as usize];
        for (i, panel) in self.panels.iter().enumerate() {
            let [x0, y0] = [(i % self.columns) as u32 * (w + gap), (i / self.columns) as u32 * (h + gap)];
            for (y, row) in panel.pixels().chunks(w as usize).enumerate() {
                let at = ((y0 + y as u32) * width + x0) as usize;
                let opaque = |p: &[u8; 4]| [p[0], p[1], p[2]].map(|c| over_white(c, p[3]));
                pixels[at..at + row.len()].iter_mut().zip(row).for_each(|(to, from)| *to = opaque(from));
            }
        }
        let lettering = Lettering::new();
        for (column, label) in self.labels.iter().enumerate() {
            let center = column as f32 * (w + gap) as f32 + w as f32 / 2.0;
            let baseline = height as f32 - strip as f32 * 0.3;
            lettering.draw(label, strip as f32 * 0.78, center, baseline, |x, y, cover| {
                if (0..width as i32).contains(&x) && (0..height as i32).contains(&y) {
                    let pixel = &mut pixels[y as usize * width as usize + x as usize];
                    *pixel = pixel.map(|c| (f32::from(c) + (INK - f32::from(c)) * cover.min(1.0)).round() as u8);
                }
            });
        }
        encode(width, height, &pixels)
    }
}

fn over_white(color: u8, alpha: u8) -> u8 {
    let (c, a) = (u32::from(color), u32::from(alpha));
    ((c * a + 255 * (255 - a)) / 255) as u8
}

fn encode(width: u32, height: u32, pixels: &[[u8; 3]]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::High);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels.as_flattened())?;
    writer.finish()?;
    Ok(bytes)
}
