//! A key to the colours: a title, a scale, swatches with labels, on a light plate in the corner that hides least.

use font8x8::legacy::BASIC_LEGACY;
use glam::{Vec3, Vec4};

/// Side of a glyph's cell, and the distance of rows, in units of `scale` pixels.
const CELL: usize = 8;
const ROW: usize = 12;
const PADDING: usize = 6;
const PLATE_OPACITY: f32 = 0.82;
const INK: Vec3 = Vec3::splat(0.02);

/// Colours and what they mean. Characters beyond ASCII become `?`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Legend {
    /// First rows, if not empty.
    pub title: String,
    /// Linear RGB and a label each, from top to bottom, drawn as one bar with the colours between them.
    pub scale: Vec<([f32; 3], String)>,
    /// Linear RGB and a short text each, drawn as swatches.
    pub entries: Vec<([f32; 3], String)>,
}

/// Linear, premultiplied colours to draw over, and how many pixels a unit has.
struct Canvas<'a> {
    colors: &'a mut [Vec4],
    size: [usize; 2],
    unit: usize,
}

impl Canvas<'_> {
    /// Fills a rectangle with corner `at` and this size, in pixels, row by row.
    fn fill(&mut self, at: [usize; 2], size: [usize; 2], alpha: f32, color: impl Fn(usize) -> Vec3) {
        let [width, height] = self.size;
        for y in at[1]..(at[1] + size[1]).min(height) {
            for x in at[0]..(at[0] + size[0]).min(width) {
                let pixel = &mut self.colors[y * width + x];
                *pixel = color(y - at[1]).extend(1.0) * alpha + *pixel * (1.0 - alpha);
            }
        }
    }

    fn text(&mut self, at: [usize; 2], text: &str) {
        for (i, character) in text.chars().enumerate() {
            let glyph = BASIC_LEGACY.get(character as usize).unwrap_or(&BASIC_LEGACY['?' as usize]);
            for (row, bits) in glyph.iter().enumerate() {
                for column in (0..CELL).filter(|column| bits >> column & 1 != 0) {
                    let at = [at[0] + (i * CELL + column) * self.unit, at[1] + row * self.unit];
                    self.fill(at, [self.unit; 2], 1.0, |_| INK);
                }
            }
        }
    }
}

impl Legend {
    /// Draws over linear, premultiplied `colors`, of which the mesh covers these shares, into the corner where it covers
    /// least; the lower left one if several are alike. Twice the font's size at 720 rows; what does not fit is cut off.
    pub(crate) fn draw(&self, colors: &mut [Vec4], covered: &[f32], size: [u32; 2]) {
        let unit = (size[1] as usize).div_ceil(360).max(1);
        let mut canvas = Canvas { colors, size: size.map(|x| x as usize), unit };
        let labels = self.scale.iter().chain(&self.entries);
        let columns = labels.map(|(_, text)| CELL + 5 + text.chars().count() * CELL).max().unwrap_or(0);
        let title = self.title.lines().map(|line| line.chars().count() * CELL).max().unwrap_or(0);
        let columns = columns.max(title);
        let rows = self.title.lines().count() + self.scale.len() + self.entries.len();
        if columns == 0 {
            return;
        }
        let plate = [(columns + 2 * PADDING) * unit, (rows * ROW + PADDING * 2 - 4) * unit];
        let [left, top] = corner(plate, 8 * unit, covered, canvas.size);
        canvas.fill([left, top], plate, PLATE_OPACITY, |_| Vec3::ONE);
        let x = left + PADDING * unit;
        let row = |i: usize| top + (PADDING + i * ROW) * unit;
        let mut next = 0;
        for line in self.title.lines() {
            canvas.text([x, row(next)], line);
            next += 1;
        }
        if let [first, .., last] = &self.scale[..] {
            // The bar reaches from the first label's cell to the last one's; colours are exact in the cells' middles.
            let height = ((self.scale.len() - 1) * ROW + CELL) * unit;
            let color = |y: usize| {
                let t = (y as f32 + 0.5 - (CELL * unit) as f32 / 2.0) / (ROW * unit) as f32;
                match t {
                    t if t <= 0.0 => first.0.into(),
                    t if t >= (self.scale.len() - 1) as f32 => last.0.into(),
                    t => Vec3::from(self.scale[t as usize].0).lerp(self.scale[t as usize + 1].0.into(), t.fract()),
                }
            };
            canvas.fill([x, row(next)], [CELL * unit, height], 1.0, color);
        }
        let text_x = x + (CELL + 5) * unit;
        for (_, text) in &self.scale {
            canvas.text([text_x, row(next)], text);
            next += 1;
        }
        for (color, text) in &self.entries {
            canvas.fill([x, row(next)], [CELL * unit; 2], 1.0, |_| (*color).into());
            canvas.text([text_x, row(next)], text);
            next += 1;
        }
    }
}

/// Where a plate of this size goes, `margin` away from the picture's sides.
fn corner(plate: [usize; 2], margin: usize, covered: &[f32], [width, height]: [usize; 2]) -> [usize; 2] {
    let (right, bottom) = (width.saturating_sub(plate[0] + margin), height.saturating_sub(plate[1] + margin));
    let hidden = |[left, top]: [usize; 2]| -> f32 {
        let rows = top..(top + plate[1]).min(height);
        let columns = left.min(width)..(left + plate[0]).min(width);
        rows.flat_map(|y| &covered[y * width..][columns.clone()]).sum()
    };
    let corners = [[margin, bottom], [margin, margin], [right, bottom], [right, margin]];
    let hidden = corners.map(|corner| (hidden(corner), corner));
    hidden.into_iter().reduce(|best, next| if next.0 < best.0 { next } else { best }).map_or(corners[0], |best| best.1)
}
