//! Black and white stripes that show how smooth a surface's normals are.
//!
//! *Isophotes* are lines of equal angle between the normal and a direction. *Reflection lines* are the mirror image of
//! parallel straight lights (Klass 1980), here infinitely far away, so that only directions count and stripes look alike
//! on near and far, small and large surfaces: the lights are great circles through ± the axis, at equal angles round it.
//! Where normals are continuous stripes do not break, where normals are differentiable stripes have no corners.

use glam::Vec3;

/// Most stripes: more are narrower than pixels on any sphere.
pub const MAX_STRIPES: u32 = 1000;

/// Linear grey of the two kinds of stripes: not quite black and white, so that form shows in soft light.
const DARK: f32 = 0.012;
const LIGHT: f32 = 0.86;

/// A family of stripes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stripes {
    /// Of isophotes, the direction that angles are measured from; of reflection lines, the direction of the lights. Any
    /// length but 0.
    pub axis: [f32; 3],
    /// Dark stripes in the half turn of isophotes, or in the full turn of reflection lines: a normal that turns meets
    /// about as many of either.
    pub count: u32,
}

impl Stripes {
    /// Colour of the isophotes at a normal of length one, linear RGB.
    pub fn isophotes(&self, normal: [f32; 3]) -> [f32; 3] {
        self.color(angle(self.axis(), Vec3::from(normal)) / std::f32::consts::PI)
    }

    /// Colour of the reflection lines where the normal and the direction towards the eye, of length one, are these.
    pub fn reflection_lines(&self, normal: [f32; 3], view: [f32; 3]) -> [f32; 3] {
        let (normal, view) = (Vec3::from(normal), Vec3::from(view));
        let reflected = 2.0 * normal.dot(view) * normal - view;
        // Angles are from straight up, or from +z round a vertical axis.
        let axis = self.axis();
        let up = [Vec3::Y, Vec3::Z].map(|up| up - up.dot(axis) * axis);
        let up = if up[0].length() > 0.1 { up[0] } else { up[1] }.normalize();
        let turn = reflected.dot(axis.cross(up)).atan2(reflected.dot(up));
        self.color(turn / std::f32::consts::TAU)
    }

    fn axis(&self) -> Vec3 {
        Vec3::from(self.axis).normalize_or(Vec3::Y)
    }

    /// Dark in the first half of each of `count` parts of the unit interval, light in the second.
    fn color(&self, t: f32) -> [f32; 3] {
        [if (t * self.count as f32).rem_euclid(1.0) < 0.5 { DARK } else { LIGHT }; 3]
    }
}

/// Angle between two directions of length one, also exact where it is small (Kahan 2006).
fn angle(a: Vec3, b: Vec3) -> f32 {
    2.0 * (a - b).length().atan2((a + b).length())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How often neighbours differ.
    fn changes(colors: impl Iterator<Item = [f32; 3]>) -> usize {
        let all: Vec<_> = colors.collect();
        all.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }

    /// Directions of half a turn from the axis to its opposite, between the ends.
    fn half_turn(axis: Vec3, across: Vec3) -> impl Iterator<Item = Vec3> {
        (0..2000).map(move |i| {
            let (sin, cos) = ((i as f32 + 0.5) / 2000.0 * std::f32::consts::PI).sin_cos();
            axis * cos + across * sin
        })
    }

    #[test]
    fn half_a_turn_crosses_every_isophote_at_equal_angles() {
        let stripes = Stripes { axis: [0.0, 3.0, 0.0], count: 12 };
        let colors: Vec<_> = half_turn(Vec3::Y, Vec3::X).map(|n| stripes.isophotes(n.into())).collect();
        // 12 dark and 12 light ones, and 23 changes.
        assert_eq!(changes(colors.iter().copied()), 23);
        let dark = colors.iter().filter(|c| c[0] == DARK).count();
        assert!(dark.abs_diff(1000) <= 12, "{dark}");
    }

    #[test]
    fn isophotes_do_not_change_round_their_direction() {
        let stripes = Stripes { axis: [0.0, 0.0, 1.0], count: 9 };
        let ring = (0..50).map(|i| {
            let (sin, cos) = (i as f32).sin_cos();
            stripes.isophotes(Vec3::new(0.6 * cos, 0.6 * sin, 0.8).into())
        });
        assert_eq!(changes(ring), 0);
    }

    #[test]
    fn reflections_along_a_light_have_one_colour_and_across_the_lights_all() {
        for axis in [Vec3::X, Vec3::Y, Vec3::new(0.6, 0.0, 0.8)] {
            let stripes = Stripes { axis: axis.into(), count: 10 };
            let color = |reflected: Vec3, view: Vec3| {
                stripes.reflection_lines((reflected + view).normalize().into(), view.into())
            };
            let across = axis.any_orthonormal_vector();
            let view = (across + 0.3 * axis.cross(across) + 0.2 * axis).normalize();
            // In the middle of a stripe, so that rounding does not matter.
            let up = if axis == Vec3::Y { Vec3::Z } else { Vec3::Y };
            let (sin, cos) = (0.25f32 / 10.0 * std::f32::consts::TAU).sin_cos();
            let light = up * cos + axis.cross(up) * sin;
            assert_eq!(changes(half_turn(axis, light).map(|r| color(r, view))), 0, "{axis}");
            let round = half_turn(light, axis.cross(light)).map(|r| color(r, view));
            assert_eq!(changes(round), 10, "{axis}");
        }
    }
}
