//! A finished picture.

use crate::palette::encoded;
use glam::Vec4;
use std::io::{self, Write};

/// 8-bit sRGB with straight (not premultiplied) alpha, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 4]>,
}

impl Image {
    /// From linear RGBA with premultiplied alpha. `dither` adds half a step of ordered noise against banding.
    pub(crate) fn from_linear(width: u32, height: u32, linear: &[Vec4], dither: bool) -> Self {
        use rayon::prelude::*;
        let encode = |(i, color): (usize, &Vec4)| {
            let alpha = color.w.clamp(0.0, 1.0);
            if alpha <= 0.0 {
                return [0; 4];
            }
            let noise = if dither { ordered(i as u32 % width, i as u32 / width) } else { 0.0 };
            let quantised = |x: f32| (x * 255.0 + 0.5 + noise).clamp(0.0, 255.0) as u8;
            let [r, g, b] = (color.truncate() / alpha).to_array().map(|x| quantised(encoded(x)));
            [r, g, b, (alpha * 255.0 + 0.5) as u8]
        };
        Self { width, height, pixels: linear.par_iter().enumerate().map(encode).collect() }
    }

    /// Pixels across.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels down.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The pixels, row by row from the top: red, green, blue in sRGB, then straight alpha.
    pub fn pixels(&self) -> &[[u8; 4]] {
        &self.pixels
    }

    /// One pixel.
    ///
    /// # Panics
    /// If it lies outside.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        assert!(x < self.width && y < self.height, "pixel ({x}, {y}) of {} x {}", self.width, self.height);
        self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// Writes a PNG file, with alpha only if some pixel is not opaque.
    ///
    /// # Errors
    /// If writing fails.
    pub fn write_png(&self, out: impl Write) -> io::Result<()> {
        let opaque = self.pixels.iter().all(|p| p[3] == 255);
        let mut encoder = png::Encoder::new(out, self.width, self.height);
        encoder.set_color(if opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        if opaque {
            let rgb: Vec<u8> = self.pixels.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
            writer.write_image_data(&rgb)?;
        } else {
            writer.write_image_data(self.pixels.as_flattened())?;
        }
        writer.finish()?;
        Ok(())
    }
}

/// Noise in [-½, ½) by a 4 × 4 Bayer matrix.
fn ordered(x: u32, y: u32) -> f32 {
    const BAYER: [[u8; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];
    (f32::from(BAYER[(y % 4) as usize][(x % 4) as usize]) + 0.5) / 16.0 - 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(bytes: &[u8]) -> (png::ColorType, bool, Vec<u8>) {
        let mut reader = png::Decoder::new(io::Cursor::new(bytes)).read_info().expect("a PNG file");
        let mut data = vec![0; reader.output_buffer_size().expect("a small picture")];
        let info = reader.next_frame(&mut data).expect("a PNG file");
        (info.color_type, reader.info().srgb.is_some(), data)
    }

    #[test]
    fn a_png_file_reads_back_as_written() {
        let linear: Vec<Vec4> =
            (0..12).map(|i| Vec4::new(0.05, 0.02 * i as f32, 0.3, 1.0) * (i as f32 / 11.0)).collect();
        let image = Image::from_linear(4, 3, &linear, false);
        assert_eq!(image.pixel(0, 0), [0; 4]);
        assert_eq!(image.pixel(3, 2)[3], 255);
        let mut bytes = Vec::new();
        image.write_png(&mut bytes).expect("memory takes it");
        assert_eq!(decode(&bytes), (png::ColorType::Rgba, true, image.pixels().as_flattened().to_vec()));
    }

    #[test]
    fn an_opaque_png_file_has_no_alpha() {
        let image = Image::from_linear(2, 1, &[Vec4::ONE, Vec4::new(0.0, 0.0, 1.0, 1.0)], false);
        let mut bytes = Vec::new();
        image.write_png(&mut bytes).expect("memory takes it");
        assert_eq!(decode(&bytes), (png::ColorType::Rgb, true, vec![255, 255, 255, 0, 0, 255]));
    }

    #[test]
    fn colours_of_see_through_pixels_are_not_darkened() {
        let image = Image::from_linear(1, 1, &[Vec4::new(0.5, 0.5, 0.5, 0.5)], false);
        assert_eq!(image.pixel(0, 0), [255, 255, 255, 128]);
    }
}
