//! Black and white stripes that show how smooth a surface's normals are.
//!
//! *Isophotes* are lines of equal angle between the normal and a direction. *Reflection lines* are the mirror image of
//! parallel straight lights (Klass 1980), here infinitely far away, so that only directions count and stripes look alike
//! on near and far, small and large surfaces: the lights are great circles through ± the axis, at equal angles round it.
//! Where normals are continuous stripes do not break, where normals are differentiable stripes have no corners.

//!
//! A place is a number of stripes, whose colour the renderer averages over what a sample stands for: stripes narrower than
//! that become grey instead of noise.

use glam::Vec3;

/// Most stripes: more are narrower than pixels on any sphere.
pub const MAX_STRIPES: u32 = 1000;

/// Linear grey of the two kinds of stripes: not quite black and white, so that form shows in soft light.
const DARK: f64 = 0.012;
const LIGHT: f64 = 0.86;

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

/// A place among stripes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// Number of stripes up to here: dark in the first half of every unit, light in the second.
    pub stripes: f32,
    /// After so many stripes all begins again; infinite if never.
    pub turn: f32,
}

impl Stripes {
    /// The place of a normal of length one among isophotes.
    pub fn isophotes(&self, normal: [f32; 3]) -> Phase {
        let turn = angle(self.axis(), Vec3::from(normal)) / std::f32::consts::PI;
        // A quarter on, so that walls, floors and ceilings lie in the middle of a stripe and not on its edge.
        Phase { stripes: turn * self.count as f32 + 0.25, turn: f32::INFINITY }
    }

    /// The place among reflection lines where the normal and the direction towards the eye, of length one, are these.
    pub fn reflection_lines(&self, normal: [f32; 3], view: [f32; 3]) -> Phase {
        let (normal, view) = (Vec3::from(normal), Vec3::from(view));
        let reflected = 2.0 * normal.dot(view) * normal - view;
        // Angles are from straight up, or from +z round a vertical axis.
        let axis = self.axis();
        let up = [Vec3::Y, Vec3::Z].map(|up| up - up.dot(axis) * axis);
        let up = if up[0].length() > 0.1 { up[0] } else { up[1] }.normalize();
        let turn = reflected.dot(axis.cross(up)).atan2(reflected.dot(up)) / std::f32::consts::TAU;
        Phase { stripes: turn * self.count as f32, turn: self.count as f32 }
    }

    fn axis(&self) -> Vec3 {
        Vec3::from(self.axis).normalize_or(Vec3::Y)
    }
}

impl Phase {
    /// How many stripes lie between two places, the shorter way.
    pub(crate) fn distance(self, other: Self) -> f32 {
        let d = (self.stripes - other.stripes).abs();
        if self.turn.is_finite() { d.min(self.turn - d) } else { d }
    }

    /// Linear grey, averaged over `width` stripes.
    pub(crate) fn grey(self, width: f32) -> f32 {
        // Below this the average is one of both in nearly all places, and differences would be rounding.
        let width = f64::from(width).max(1e-4);
        let light = |x: f64| 0.5 * x.floor() + (x.rem_euclid(1.0) - 0.5).max(0.0);
        let x = f64::from(self.stripes);
        let share = (light(x + 0.5 * width) - light(x - 0.5 * width)) / width;
        (DARK + (LIGHT - DARK) * share) as f32
    }
}

/// Angle between two directions of length one, also exact where it is small (Kahan 2006).
fn angle(a: Vec3, b: Vec3) -> f32 {
    2.0 * (a - b).length().atan2((a + b).length())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_dark(phase: Phase) -> bool {
        phase.grey(0.0) < 0.4
    }

    /// How often neighbours differ.
    fn changes(stripes: impl Iterator<Item = Phase>) -> usize {
        let all: Vec<_> = stripes.map(is_dark).collect();
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
        // 12 light ones between 11 dark ones and a half at either end, and 24 changes.
        assert_eq!(changes(colors.iter().copied()), 24);
        let dark = colors.iter().filter(|&&c| is_dark(c)).count();
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
    fn the_average_over_whole_stripes_is_the_mean_of_both_greys_and_over_little_one_of_them() {
        let mean = ((DARK + LIGHT) / 2.0) as f32;
        for i in 0..40 {
            let phase = Phase { stripes: 3.0 + i as f32 / 40.0, turn: 10.0 };
            assert!((phase.grey(1.0) - mean).abs() < 1e-6 && (phase.grey(5.0) - mean).abs() < 1e-6);
            let one = if i < 20 { DARK } else { LIGHT } as f32;
            // At the very edge between both the average is in between.
            assert!(i % 20 == 0 || (phase.grey(0.01) - one).abs() < 1e-6, "{i}");
        }
        let edge = Phase { stripes: 2.5, turn: 10.0 };
        assert!((edge.grey(0.2) - mean).abs() < 1e-6);
    }

    #[test]
    fn stripes_are_counted_the_shorter_way_round() {
        let [a, b] = [-4.9, 4.9].map(|stripes| Phase { stripes, turn: 10.0 });
        assert!((a.distance(b) - 0.2).abs() < 1e-6);
        let [a, b] = [a, b].map(|phase| Phase { turn: f32::INFINITY, ..phase });
        assert!((a.distance(b) - 9.8).abs() < 1e-6);
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
