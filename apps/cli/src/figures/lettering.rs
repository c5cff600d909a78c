//! Words in pictures: anti-aliased, with subscripts, in a typeface that comes with the program.

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};

/// Size and drop of what follows a `_`, in units of the text's size.
const SUBSCRIPT: [f32; 2] = [0.68, 0.16];

/// A typeface ready for drawing.
pub struct Lettering {
    font: FontRef<'static>,
}

impl Lettering {
    pub fn new() -> Self {
        let font = FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).expect("the typeface is complete");
        Self { font }
    }

    /// Calls `cover` with column, row and coverage in [0, 1] of every pixel that `text` touches, centred at `center`
    /// with its baseline at `baseline`. The character after a `_` stands lower and smaller; the `_` is not drawn.
    pub fn draw(&self, text: &str, size: f32, center: f32, baseline: f32, mut cover: impl FnMut(i32, i32, f32)) {
        let glyphs = self.layout(text, size);
        let width = glyphs.last().map_or(0.0, |last| last.1);
        for (glyph, _) in glyphs {
            let mut glyph = glyph;
            glyph.position += point(center - width / 2.0, baseline);
            if let Some(outlined) = self.font.outline_glyph(glyph) {
                let bounds = outlined.px_bounds();
                outlined.draw(|x, y, coverage| {
                    cover(bounds.min.x as i32 + x as i32, bounds.min.y as i32 + y as i32, coverage);
                });
            }
        }
    }

    /// Glyphs from x = 0 on, each with the x where it ends.
    fn layout(&self, text: &str, size: f32) -> Vec<(ab_glyph::Glyph, f32)> {
        let mut x = 0.0;
        let mut low = false;
        let mut glyphs = Vec::new();
        for character in text.chars() {
            if character == '_' {
                low = true;
                continue;
            }
            let [scale, drop] = if low { SUBSCRIPT } else { [1.0, 0.0] };
            low = false;
            let scale = PxScale::from(size * scale);
            let id = self.font.glyph_id(character);
            let glyph = id.with_scale_and_position(scale, point(x, drop * size));
            x += self.font.as_scaled(scale).h_advance(id);
            glyphs.push((glyph, x));
        }
        glyphs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_centred_and_subscripts_are_lower() {
        let lettering = Lettering::new();
        let extent = |text: &str| {
            let mut extent = [i32::MAX, i32::MIN, i32::MIN];
            lettering.draw(text, 40.0, 0.0, 0.0, |x, y, c| {
                if c > 0.5 {
                    extent = [extent[0].min(x), extent[1].max(x), extent[2].max(y)];
                }
            });
            extent
        };
        let [left, right, bottom] = extent("nnn");
        // Side bearings of a glyph are a few pixels at this size.
        assert!((left + right).abs() <= 4 && right > left, "{left} {right}");
        assert!(extent("n_L")[2] > bottom + 3);
    }
}
