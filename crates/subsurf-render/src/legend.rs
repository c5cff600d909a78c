//! A key to the colours: swatches and labels on a light plate in the lower left corner.

use font8x8::legacy::BASIC_LEGACY;
use glam::{Vec3, Vec4};

/// Side of a glyph's cell, and the distance of rows, in units of `scale` pixels.
const CELL: usize = 8;
const ROW: usize = 12;
const PADDING: usize = 6;
const PLATE_OPACITY: f32 = 0.82;

/// Colours and what they mean.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Legend {
    /// Linear RGB and a short text each; characters beyond ASCII become `?`.
    pub entries: Vec<([f32; 3], String)>,
}

impl Legend {
    /// Draws over linear, premultiplied `colors`. Twice the font's size at 720 rows; what does not fit is cut off.
    pub(crate) fn draw(&self, colors: &mut [Vec4], size: [u32; 2]) {
        let [width, height] = size.map(|x| x as usize);
        let scale = (height.div_ceil(360)).max(1);
        let longest = self.entries.iter().map(|(_, text)| text.chars().count()).max().unwrap_or(0);
        if longest == 0 {
            return;
        }
        let plate =
            [(CELL + 5 + longest * CELL + 2 * PADDING) * scale, (self.entries.len() * ROW + PADDING * 2 - 4) * scale];
        let left = 8 * scale;
        let top = height.saturating_sub(plate[1] + 8 * scale);
        let mut blend = |x: usize, y: usize, color: Vec3, alpha: f32| {
            if x < width && y < height {
                let pixel = &mut colors[y * width + x];
                *pixel = color.extend(1.0) * alpha + *pixel * (1.0 - alpha);
            }
        };
        for y in 0..plate[1] {
            for x in 0..plate[0] {
                blend(left + x, top + y, Vec3::ONE, PLATE_OPACITY);
            }
        }
        for (row, (color, text)) in self.entries.iter().enumerate() {
            let (x0, y0) = (left + PADDING * scale, top + (PADDING + row * ROW) * scale);
            for y in 0..CELL * scale {
                for x in 0..CELL * scale {
                    blend(x0 + x, y0 + y, (*color).into(), 1.0);
                }
            }
            for (i, character) in text.chars().enumerate() {
                let glyph = BASIC_LEGACY.get(character as usize).unwrap_or(&BASIC_LEGACY['?' as usize]);
                let x0 = x0 + (CELL + 5 + i * CELL) * scale;
                for y in 0..CELL * scale {
                    for x in 0..CELL * scale {
                        if glyph[y / scale] >> (x / scale) & 1 != 0 {
                            blend(x0 + x, y0 + y, Vec3::splat(0.02), 1.0);
                        }
                    }
                }
            }
        }
    }
}
