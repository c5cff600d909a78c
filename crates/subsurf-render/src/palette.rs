//! Colours for marking parts of a surface. All are linear RGB, as a shader's base colours are.

/// From the usual 8-bit sRGB to linear RGB (IEC 61966-2-1).
pub fn linear(srgb: [u8; 3]) -> [f32; 3] {
    srgb.map(|x| {
        let x = f32::from(x) / 255.0;
        if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    })
}

/// From linear RGB to 0…1 sRGB, clamped.
pub(crate) fn encoded(linear: f32) -> f32 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// The unpainted material.
pub fn clay() -> [f32; 3] {
    linear([214, 205, 194])
}

/// Okabe and Ito, "Color universal design", 2008: told apart with all common kinds of colour vision. Without their
/// black, lightened for shading, then a second round in lighter tints.
const CATEGORIES: [[u8; 3]; 14] = [
    [86, 180, 233],
    [230, 159, 0],
    [0, 158, 115],
    [213, 94, 0],
    [204, 121, 167],
    [240, 228, 66],
    [0, 114, 178],
    [176, 218, 243],
    [245, 211, 140],
    [134, 208, 186],
    [236, 173, 129],
    [231, 190, 212],
    [247, 242, 165],
    [130, 184, 217],
];

/// The `index`-th of a list of colours that are easily told apart, also by the colour-blind; repeats after 14.
pub fn category(index: usize) -> [f32; 3] {
    linear(CATEGORIES[index % CATEGORIES.len()])
}

/// Stops of a scale from dark blue-violet over green to yellow with evenly rising lightness, after viridis (van der
/// Walt and Smith 2015), without its darkest end, which hides shading.
const SCALE: [[u8; 3]; 6] =
    [[71, 74, 142], [52, 105, 146], [33, 138, 141], [58, 174, 118], [137, 208, 73], [249, 226, 60]];

/// Stops of a scale from blue over nearly white to red, as dark at one end as at the other; told apart also by those
/// who see no red or no green.
const BALANCE: [[u8; 3]; 7] =
    [[32, 76, 158], [88, 140, 205], [172, 202, 232], [244, 243, 239], [246, 198, 164], [226, 121, 82], [170, 34, 38]];

/// A colour of a scale, for `t` from 0 (dark) to 1 (light).
pub fn sequential(t: f32) -> [f32; 3] {
    between(&SCALE, t)
}

/// A colour of a scale with two sides, for `t` from −1 (blue) over 0 (nearly white) to 1 (red).
pub fn diverging(t: f32) -> [f32; 3] {
    between(&BALANCE, 0.5 + 0.5 * t)
}

/// Linear between equidistant stops, for `t` from 0 to 1.
fn between(stops: &[[u8; 3]], t: f32) -> [f32; 3] {
    let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) } * (stops.len() - 1) as f32;
    let stop = (t as usize).min(stops.len() - 2);
    let (a, b, f) = (linear(stops[stop]), linear(stops[stop + 1]), t - stop as f32);
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * f)
}

/// The colour of `level` of a scale that ends at `levels - 1`.
pub fn level(level: usize, levels: usize) -> [f32; 3] {
    sequential(level as f32 / levels.saturating_sub(1).max(1) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoding_undoes_decoding() {
        for x in 0..=255u8 {
            assert_eq!((encoded(linear([x; 3])[0]) * 255.0).round() as u8, x);
        }
    }

    fn luminance(c: [f32; 3]) -> f32 {
        0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]
    }

    #[test]
    fn the_scale_with_two_sides_darkens_evenly_from_its_middle() {
        let side = |sign: f32| (0..=12).map(move |i| luminance(diverging(sign * i as f32 / 12.0)));
        for (a, b) in side(-1.0).zip(side(1.0)) {
            // Chosen by eye: neither side looks larger than the other.
            assert!((a - b).abs() < 0.08, "{a} {b}");
        }
        assert!(side(-1.0).is_sorted_by(|a, b| a > b) && side(1.0).is_sorted_by(|a, b| a > b));
    }

    #[test]
    fn the_scale_rises_in_luminance() {
        let scale: Vec<f32> = (0..=20).map(|i| luminance(sequential(i as f32 / 20.0))).collect();
        assert!(scale.is_sorted_by(|a, b| a < b), "{scale:?}");
    }
}
