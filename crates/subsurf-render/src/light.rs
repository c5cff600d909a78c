//! The studio: a large sky, a soft key light, a fill and a rim, which turn with the camera.
//!
//! The answer to light is split into a part that no shadow touches and parts to be scaled by how much of the sky and of
//! the key light is seen. Those two visibilities are noisy, smooth over the surface and cheap to filter; the rest is exact.

use crate::camera::Lens;
use glam::Vec3;

/// Radius of the key light's disc at distance 1: wide enough for soft shadows, small enough for shape.
pub const KEY_TANGENT: f32 = 0.12;

/// Irradiance, divided by π, from straight above and straight below. The floor returns warm light.
const SKY: Vec3 = Vec3::new(0.34, 0.365, 0.41);
const FLOOR: Vec3 = Vec3::new(0.20, 0.18, 0.16);
const KEY: Vec3 = Vec3::new(0.90, 0.84, 0.755);
const FILL: Vec3 = Vec3::new(0.10, 0.115, 0.14);
const RIM: Vec3 = Vec3::new(0.42, 0.44, 0.47);
/// Reflectance of the surface's coat straight on, and its gloss as a Blinn–Phong exponent.
const COAT: f32 = 0.04;
const GLOSS: f32 = 28.0;
/// Back sides are darker and cooler.
const BACK: Vec3 = Vec3::new(0.50, 0.56, 0.68);

/// Light that a point of the surface sends to the eye: `fixed + sky · (open sky) + key · (visible key light)`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Response {
    pub fixed: Vec3,
    pub sky: Vec3,
    pub key: Vec3,
}

#[derive(Clone, Copy, Debug)]
pub struct Studio {
    /// Direction towards the middle of the key light.
    pub key: Vec3,
    fill: Vec3,
    rim: Vec3,
}

impl Studio {
    pub fn new(lens: &Lens) -> Self {
        // The viewing direction on the floor; looking straight down, the picture's up.
        let flat = Vec3::new(lens.forward.x, 0.0, lens.forward.z);
        let ahead = if flat.length() > 1e-3 {
            flat.normalize()
        } else {
            Vec3::new(lens.up.x, 0.0, lens.up.z).normalize_or(Vec3::NEG_Z)
        };
        let right = ahead.cross(Vec3::Y);
        Self {
            key: (-0.62 * ahead - 0.62 * right + 0.95 * Vec3::Y).normalize(),
            fill: (-0.55 * ahead + 0.85 * right + 0.10 * Vec3::Y).normalize(),
            rim: (0.85 * ahead + 0.45 * right + 0.45 * Vec3::Y).normalize(),
        }
    }

    /// The light from a point of base colour `albedo`; `lit` from 0 (the flat colour) to 1 (full light and shade).
    pub fn respond(&self, albedo: Vec3, normal: Vec3, view: Vec3, front: bool, lit: f32) -> Response {
        let albedo = if front { albedo } else { albedo * BACK };
        let facing = normal.dot(view).clamp(0.0, 1.0);
        let grazing = (1.0 - facing).powi(5);

        let sky = FLOOR.lerp(SKY, 0.5 + 0.5 * normal.y);
        let fill = FILL * normal.dot(self.fill).max(0.0);
        let rim = RIM * normal.dot(self.rim).max(0.0) * (1.0 - facing).powi(2);
        let reflected = (2.0 * facing * normal - view).y;
        let coat = FLOOR.lerp(SKY, 0.5 + 0.5 * reflected) * (COAT + 0.30 * grazing);

        let towards_key = normal.dot(self.key).max(0.0);
        let half = (self.key + view).normalize_or(normal);
        let gloss = COAT * (GLOSS + 8.0) / 8.0 * normal.dot(half).max(0.0).powf(GLOSS);

        Response {
            fixed: albedo * (1.0 - lit),
            sky: (albedo * (sky + fill + rim) + coat) * lit,
            key: KEY * (albedo + Vec3::splat(gloss)) * (towards_key * lit),
        }
    }

    /// Shares of the sky and of the key light in the light on the floor, which add up to one.
    pub fn floor_shares(&self) -> [f32; 2] {
        let (sky, key) = (SKY.element_sum(), KEY.element_sum() * self.key.y);
        [sky / (sky + key), key / (sky + key)]
    }
}

/// How much light reaches a hollow that sees `open` of the sky, if its walls of reflectance `albedo` see light as it
/// does: the series open (1 + ρ (1 − open) + …), so that light hollows are not drawn sooty.
pub fn interreflected(open: f32, albedo: f32) -> f32 {
    open / (1.0 - albedo * (1.0 - open))
}

/// Compresses what is brighter than the shoulder towards 1, each channel by itself.
pub fn tone(color: Vec3) -> Vec3 {
    const SHOULDER: f32 = 0.70;
    Vec3::from(color.to_array().map(|x| {
        if x <= SHOULDER {
            x
        } else {
            let room = 1.0 - SHOULDER;
            SHOULDER + room * ((x - SHOULDER) / room).tanh()
        }
    }))
}
