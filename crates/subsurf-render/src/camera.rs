//! Where the picture is taken from.
//!
//! Perspective, +y of the model up in the picture. Angles are in degrees in the public types; the field of view is the
//! vertical one.

use glam::{DVec3, Vec3};
use std::str::FromStr;
use thiserror::Error;

/// Share of the picture's width and height that an automatic camera leaves free on each side.
const MARGIN: f64 = 0.06;
/// Vertical field of view of the automatic camera: about that of a 70 mm lens, which flatters most objects.
const FOV_DEG: f64 = 28.0;
/// The automatic camera stands this far to the right of the model's front (+z), and this far above.
const AZIMUTH_DEG: f64 = 32.0;
const ELEVATION_DEG: f64 = 16.0;

/// Which camera to use. Parses from `auto` or `ex,ey,ez:tx,ty,tz:fov`.
///
/// ```
/// use subsurf_render::{Camera, View};
/// let camera: Camera = "0,1,5:0,0,0:30".parse().unwrap();
/// assert_eq!(camera, Camera::At(View { eye: [0.0, 1.0, 5.0], target: [0.0; 3], fov_deg: 30.0 }));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Camera {
    /// A three-quarter view from the front right (+z, +x) and above that frames the whole mesh.
    #[default]
    Auto,
    /// A given one.
    At(View),
}

/// An eye, what it looks at, and how wide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Position of the eye in model units.
    pub eye: [f64; 3],
    /// Point in the middle of the picture.
    pub target: [f64; 3],
    /// Vertical field of view in degrees.
    pub fov_deg: f64,
}

/// Why a camera's text was not understood.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("camera '{text}': {reason}; write auto or ex,ey,ez:tx,ty,tz:fov, for example 0,1,5:0,0,0:30")]
pub struct CameraParseError {
    text: String,
    reason: String,
}

impl FromStr for Camera {
    type Err = CameraParseError;

    fn from_str(text: &str) -> Result<Self, CameraParseError> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let fail = |reason: String| CameraParseError { text: text.to_owned(), reason };
        let number = |part: &str| match part.trim().parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => Err(fail(format!("'{part}' is no finite number"))),
        };
        let point = |part: &str, what: &str| -> Result<[f64; 3], CameraParseError> {
            let numbers = part.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
            let count = numbers.len();
            numbers.try_into().map_err(|_| fail(format!("the {what} has {count} coordinates, not 3")))
        };
        let parts: Vec<&str> = text.split(':').collect();
        let [eye, target, fov] = parts[..] else {
            return Err(fail(format!("{} parts between colons, not 3", parts.len())));
        };
        let view = View { eye: point(eye, "eye")?, target: point(target, "target")?, fov_deg: number(fov)? };
        match view.lens(1.0) {
            Some(_) => Ok(Self::At(view)),
            None if view.eye == view.target => Err(fail("the eye is at the target".to_owned())),
            None => Err(fail(format!("a field of view of {} degrees is not between 0 and 180", view.fov_deg))),
        }
    }
}

impl Camera {
    /// The view on `points` for a picture of `aspect` = width / height.
    pub fn view(&self, points: &[[f32; 3]], aspect: f64) -> View {
        match *self {
            Self::At(view) => view,
            Self::Auto => {
                let (azimuth, elevation) = (AZIMUTH_DEG.to_radians(), ELEVATION_DEG.to_radians());
                let towards_eye =
                    DVec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos());
                View::framing(points, towards_eye.to_array(), FOV_DEG, aspect)
            }
        }
    }
}

impl View {
    /// The view along −`towards_eye` that holds all `points` as large as possible with a small margin.
    ///
    /// With the camera's axes fixed, a point (x, y, z) (z forward) is inside the picture of an eye (X, Y, Z) if
    /// |x − X| ≤ tₓ (z − Z), and likewise for y. With R = max(x − tₓ z) and L = max(−x − tₓ z) the largest possible Z
    /// is −(R + L) / 2tₓ, reached at X = (R − L) / 2.
    pub fn framing(points: &[[f32; 3]], towards_eye: [f64; 3], fov_deg: f64, aspect: f64) -> Self {
        let forward = -DVec3::from(towards_eye).normalize_or(DVec3::Z);
        let (right, up) = axes(forward);
        let tangent = (fov_deg.to_radians() / 2.0).tan() * (1.0 - 2.0 * MARGIN);
        let tangents = [tangent * aspect, tangent];
        let (mut plus, mut minus) = ([f64::NEG_INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let (mut near, mut far) = (f64::INFINITY, f64::NEG_INFINITY);
        for &point in points {
            let point = Vec3::from(point).as_dvec3();
            let z = point.dot(forward);
            (near, far) = (near.min(z), far.max(z));
            for (axis, direction) in [right, up].into_iter().enumerate() {
                let x = point.dot(direction);
                plus[axis] = plus[axis].max(x - tangents[axis] * z);
                minus[axis] = minus[axis].max(-x - tangents[axis] * z);
            }
        }
        if points.is_empty() {
            (near, far, plus, minus) = (0.0, 0.0, [0.0; 2], [0.0; 2]);
        }
        let depth =
            (0..2).map(|axis| -(plus[axis] + minus[axis]) / (2.0 * tangents[axis])).fold(f64::INFINITY, f64::min);
        // A single point, or a line seen end-on, can be framed from anywhere: keep a distance.
        let depth = depth.min(near - 1e-3 * (far - near) - if far > near { 0.0 } else { near.abs().max(1.0) });
        let eye = right * ((plus[0] - minus[0]) / 2.0) + up * ((plus[1] - minus[1]) / 2.0) + forward * depth;
        let target = eye + forward * ((near + far) / 2.0 - depth);
        Self { eye: eye.to_array(), target: target.to_array(), fov_deg }
    }

    /// Ready for projecting, or `None` if nothing can be seen through it.
    pub(crate) fn lens(&self, aspect: f64) -> Option<Lens> {
        let (eye, target) = (DVec3::from(self.eye), DVec3::from(self.target));
        let forward = (target - eye).try_normalize().filter(|f| f.is_finite())?;
        if !(eye.is_finite() && self.fov_deg > 0.0 && self.fov_deg < 180.0) {
            return None;
        }
        let (right, up) = axes(forward);
        let tangent = (self.fov_deg.to_radians() / 2.0).tan();
        Some(Lens {
            eye: eye.as_vec3(),
            forward: forward.as_vec3(),
            right: right.as_vec3(),
            up: up.as_vec3(),
            tangents: [(tangent * aspect) as f32, tangent as f32],
        })
    }
}

/// Right and up of a camera that looks along `forward`.
fn axes(forward: DVec3) -> (DVec3, DVec3) {
    let right = forward.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
    (right, right.cross(forward))
}

/// A view with its axes computed. Picture coordinates run from (0, 0) at the upper left to (1, 1) at the lower right.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    pub eye: Vec3,
    pub forward: Vec3,
    pub right: Vec3,
    pub up: Vec3,
    tangents: [f32; 2],
}

impl Lens {
    /// Direction of length one through a point of the picture.
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        (self.forward
            + self.right * ((2.0 * x - 1.0) * self.tangents[0])
            + self.up * ((1.0 - 2.0 * y) * self.tangents[1]))
            .normalize()
    }

    /// Depth of a point along the viewing direction.
    pub fn depth(&self, point: Vec3) -> f32 {
        (point - self.eye).dot(self.forward)
    }

    /// Where a point in front of the eye appears in the picture.
    pub fn project(&self, point: Vec3) -> [f32; 2] {
        let (d, depth) = (point - self.eye, self.depth(point));
        [
            0.5 + 0.5 * d.dot(self.right) / (depth * self.tangents[0]),
            0.5 - 0.5 * d.dot(self.up) / (depth * self.tangents[1]),
        ]
    }

    /// Height of the picture at depth 1, in model units.
    pub fn height_at_unit_depth(&self) -> f32 {
        2.0 * self.tangents[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::tests::Random;

    #[test]
    fn an_automatic_camera_frames_all_points_and_touches_the_margin() {
        let mut random = Random(3);
        for aspect in [0.5, 1.0, 16.0 / 9.0] {
            for stretch in [Vec3::ONE, Vec3::new(10.0, 1.0, 1.0), Vec3::new(1.0, 20.0, 1.0), Vec3::new(1.0, 0.0, 3.0)] {
                let points: Vec<[f32; 3]> =
                    (0..200).map(|_| (random.point() * stretch * 3.0 + 7.0).to_array()).collect();
                let lens = Camera::Auto.view(&points, aspect).lens(aspect).expect("a valid view");
                let mut extreme = 0.0f32;
                for &p in &points {
                    assert!(lens.depth(p.into()) > 0.0);
                    for x in lens.project(p.into()) {
                        let off = (x - 0.5).abs();
                        extreme = if off > extreme || off.is_nan() { off } else { extreme };
                    }
                }
                // Single-precision projection of coordinates of order 100.
                assert!((extreme - (0.5 - MARGIN as f32)).abs() < 1e-3, "{extreme}");
            }
        }
    }

    #[test]
    fn points_that_coincide_are_seen_from_a_distance() {
        for p in [[0.0, 0.0, 0.0], [5.0, 1e6, 3.0]] {
            let view = Camera::Auto.view(&[p, p], 1.5);
            assert!(view.lens(1.5).is_some_and(|lens| lens.depth(p.into()) > 0.5));
        }
    }

    #[test]
    fn a_camera_is_read_from_text_or_says_why_not() {
        assert_eq!("auto".parse(), Ok(Camera::Auto));
        for (text, reason) in [
            ("1,2:0,0,0:30", "the eye has 2 coordinates, not 3"),
            ("1,2,3:0,0,0", "2 parts between colons, not 3"),
            ("1,2,x:0,0,0:30", "'x' is no finite number"),
            ("1,2,3:1,2,3:30", "the eye is at the target"),
            ("1,2,3:0,0,0:180", "a field of view of 180 degrees is not between 0 and 180"),
        ] {
            let message = text.parse::<Camera>().expect_err("text is wrong").to_string();
            assert!(message.contains(reason), "{message}");
        }
    }

    #[test]
    fn a_projected_point_lies_on_the_ray_through_it() {
        let view = View { eye: [3.0, 2.0, 5.0], target: [0.0, 1.0, 0.0], fov_deg: 40.0 };
        let lens = view.lens(1.7).expect("a valid view");
        let point = Vec3::new(0.3, -0.2, 0.9);
        let [x, y] = lens.project(point);
        assert!(lens.direction(x, y).dot((point - lens.eye).normalize()) > 1.0 - 1e-6);
    }
}
