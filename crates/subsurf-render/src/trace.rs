//! Samples of a pixel: where rays meet the mesh or the floor, and how much light they see there.

use crate::bvh::{Bvh, Hit, Ray, Stack};
use crate::camera::Lens;
use crate::light::{KEY_TANGENT, Response, Studio};
use crate::sampler::{Sampler, cone, cosine, tent};
use crate::shader::{SurfaceAt, SurfacePoint, SurfaceShader};
use crate::{Phase, RenderMesh, Show};
use glam::{DVec3, Vec2, Vec3, Vec4};

/// Radius of the reconstruction filter in pixels: larger blurs, smaller shows steps.
const FILTER_RADIUS: f32 = 1.0;
/// Things farther than this do not darken the sky; in radii of the mesh.
const SKY_REACH: f32 = 1.2;
/// The floor's shadow fades between these distances from the middle; in radii of the mesh.
const FLOOR_FADE: [f32; 2] = [1.0, 2.2];
/// How dark the floor's shadow may become.
const FLOOR_STRENGTH: f32 = 0.62;

/// Rays below this sine over their triangle may be cut off by it or its neighbours: smaller shows the triangles in the
/// shading's terminator, larger asks for more normals.
const GRAZING: f32 = 0.25;

/// Visibilities of a pixel: of the sky and of the key light from the mesh, and of both from the floor.
pub const SKY: usize = 0;
pub const KEY: usize = 1;
pub const FLOOR: usize = 2;
pub const CHANNELS: usize = 3;

/// All samples of one pixel, averaged. Colours are linear and premultiplied by coverage.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pixel {
    /// Light that no shadow touches, and coverage by the mesh.
    pub fixed: Vec4,
    /// To be added: `sky` × open sky and `key` × visible key light.
    pub sky: Vec3,
    pub key: Vec3,
    /// Opacity of the floor's shadow where it is fully dark.
    pub veil: f32,
    /// Sums over rays of what they found open, and of the rays' weights, for each visibility.
    pub open: [f32; CHANNELS],
    pub rays: [f32; CHANNELS],
    /// Mean reflectance of the mesh, for [`interreflected`](crate::light::interreflected) light.
    pub albedo: f32,
    /// Mean normal and position of the samples on the mesh.
    pub normal: Vec3,
    pub position: Vec3,
}

/// What a thread needs for tracing and reuses from pixel to pixel.
#[derive(Default)]
pub struct Scratch {
    stack: Stack,
    /// The samples of a pixel that hit something, with their numbers.
    places: Vec<(u32, Lit)>,
}

/// A horizontal plane under the mesh that only receives shadow.
#[derive(Clone, Copy, Debug)]
pub struct Floor {
    pub height: f32,
    pub center: Vec3,
}

/// All that is needed to sample a pixel.
pub struct Tracer<'a> {
    pub mesh: &'a RenderMesh,
    pub bvh: &'a Bvh,
    pub shader: &'a dyn SurfaceShader,
    pub show: Show,
    pub lens: Lens,
    pub studio: Studio,
    pub floor: Option<Floor>,
    /// Radius of the mesh, and a length that is just noticeable to single precision around it.
    pub radius: f32,
    pub epsilon: f32,
    pub size: [u32; 2],
    pub samples: u32,
}

/// A place from which light is looked for.
struct Lit {
    position: Vec3,
    /// Normal of the surface, and of the triangle, on the side that is seen.
    normal: Vec3,
    flat: Vec3,
    /// Where on which triangle; `None` on the floor.
    on: Option<(u32, [f32; 3])>,
    /// Colour that is known only once all samples of the pixel are.
    striped: Option<Striped>,
}

/// A sample among stripes.
struct Striped {
    phase: Phase,
    /// Where in the picture, in pixels.
    offset: Vec2,
    view: Vec3,
    front: bool,
}

impl Tracer<'_> {
    pub fn pixel(&self, x: u32, y: u32, scratch: &mut Scratch) -> Pixel {
        let Scratch { stack, places } = scratch;
        let sampler = Sampler::new(x, y);
        let mut pixel = Pixel::default();
        places.clear();
        for sample in 0..self.samples {
            let offset = tent(sampler.point(0, sample), FILTER_RADIUS);
            let direction = self.lens.direction(
                (x as f32 + 0.5 + offset.x) / self.size[0] as f32,
                (y as f32 + 0.5 + offset.y) / self.size[1] as f32,
            );
            let ray = Ray { origin: self.lens.eye, direction, reach: f32::INFINITY };
            let lit = match self.bvh.nearest(&ray, stack) {
                Some(hit) => Some(self.surface(&hit, direction, offset, &mut pixel)),
                None => self.floor_shadow(direction, &mut pixel),
            };
            places.extend(lit.map(|lit| (sample, lit)));
        }

        if self.show.is_striped() {
            self.color_stripes(places, &mut pixel);
        }

        // What lies on one smooth piece is smoothed later and needs few rays. Edges must do with their own.
        let turns = if self.straddles(places) { 1 } else { 2 };
        let mut hits = 0.0;
        for (sample, lit) in places {
            if lit.on.is_some() {
                hits += 1.0;
                pixel.normal += lit.normal;
                pixel.position += lit.position;
            }
            self.look_for_light(lit, &sampler, *sample, turns, &mut pixel, stack);
        }
        let share = 1.0 / self.samples as f32;
        pixel.fixed *= share;
        pixel.sky *= share;
        pixel.key *= share;
        pixel.veil *= share;
        if hits > 0.0 {
            pixel.normal = pixel.normal.normalize_or_zero();
            pixel.position /= hits;
            pixel.albedo /= hits;
        }
        pixel
    }

    /// Whether samples on the mesh lie on different pieces of surface.
    fn straddles(&self, places: &[(u32, Lit)]) -> bool {
        let mut on_mesh = places.iter().map(|(_, lit)| lit).filter(|lit| lit.on.is_some());
        let Some(first) = on_mesh.next() else { return false };
        let pixel_size = self.lens.depth(first.position) * self.lens.height_at_unit_depth() / self.size[1] as f32;
        on_mesh.any(|lit| {
            lit.normal.dot(first.normal) < 0.9
                || (lit.position - first.position).dot(first.normal).abs() > 2.0 * pixel_size
        })
    }

    /// Adds the light of a place on the mesh.
    fn surface(&self, hit: &Hit, direction: Vec3, offset: Vec2, pixel: &mut Pixel) -> Lit {
        let triangle = &self.mesh.triangles[hit.triangle as usize];
        let [a, b, c] = triangle.corners.map(|i| Vec3::from(self.mesh.positions[i as usize]));
        let weights = hit.barycentric;
        let position = a * weights[0] + b * weights[1] + c * weights[2];
        let flat = (b - a).cross(c - a).normalize_or(-direction);
        let front = flat.dot(direction) <= 0.0;
        let flat = if front { flat } else { -flat };

        let at = self.at(hit.triangle, weights);
        let normal = self.normal(&at, flat);
        // A smooth normal may turn away from the eye where the triangle does not: turn it back to the silhouette.
        let view = -direction;
        let facing = normal.dot(view);
        let normal = if facing < 1e-3 { (normal + view * (1e-3 - facing)).normalize_or(flat) } else { normal };

        let point = SurfacePoint { at, position: position.into(), normal: normal.into(), view: view.into(), front };
        let mut lit = Lit { position, normal, flat, on: Some((hit.triangle, weights)), striped: None };
        let phase = if self.show.is_striped() { self.shader.phase(&point) } else { None };
        if let Some(phase) = phase {
            lit.striped = Some(Striped { phase, offset, view, front });
            return lit;
        }
        let albedo = match self.show {
            Show::Shaded | Show::Wireframe | Show::Cage => crate::palette::clay(),
            Show::Normals => (normal * 0.5 + 0.5).to_array().map(encoded_to_linear),
            _ => self.shader.color(&point),
        };
        self.respond(albedo.into(), &lit, view, front, pixel);
        lit
    }

    /// Adds the light of a sample whose base colour is `albedo`.
    fn respond(&self, albedo: Vec3, lit: &Lit, view: Vec3, front: bool, pixel: &mut Pixel) {
        let Response { fixed, sky, key } = self.studio.respond(albedo, lit.normal, view, front, self.show.lit());
        pixel.fixed += fixed.extend(1.0);
        pixel.sky += sky;
        pixel.key += key;
        pixel.albedo += albedo.element_sum() / 3.0;
    }

    /// Adds the light of samples on stripes. Every sample stands for a square of the pixel; how many stripes that has is
    /// found from how they change from sample to sample on the same piece of surface.
    fn color_stripes(&self, places: &[(u32, Lit)], pixel: &mut Pixel) {
        let striped = || places.iter().filter_map(|(_, lit)| Some((lit, lit.striped.as_ref()?)));
        let (mut slopes, mut pairs) = (0.0, 0.0);
        for ((lit, at), (next_lit, next)) in striped().zip(striped().skip(1)) {
            if lit.normal.dot(next_lit.normal) > 0.7 {
                slopes += at.phase.distance(next.phase) / (at.offset - next.offset).length().max(0.05);
                pairs += 1.0;
            }
        }
        // The mean of |cos| over all directions is 2/π.
        let slope = if pairs > 0.0 { slopes / pairs * std::f32::consts::FRAC_PI_2 } else { 0.0 };
        let width = slope / (self.samples as f32).sqrt();
        for (lit, at) in striped() {
            self.respond(Vec3::splat(at.phase.grey(width)), lit, at.view, at.front, pixel);
        }
    }

    /// What the middle of a pixel sees of the mesh.
    pub fn middle(&self, x: u32, y: u32, stack: &mut Stack) -> Option<SurfaceAt> {
        let [width, height] = self.size.map(|side| side as f32);
        let direction = self.lens.direction((x as f32 + 0.5) / width, (y as f32 + 0.5) / height);
        let ray = Ray { origin: self.lens.eye, direction, reach: f32::INFINITY };
        self.bvh.nearest(&ray, stack).map(|hit| self.at(hit.triangle, hit.barycentric))
    }

    fn at(&self, index: u32, weights: [f32; 3]) -> SurfaceAt {
        let triangle = &self.mesh.triangles[index as usize];
        let parameter =
            |k: usize| (0..3).map(|corner| f64::from(triangle.uv[corner][k]) * f64::from(weights[corner])).sum::<f64>();
        SurfaceAt {
            triangle: index,
            barycentric: weights,
            face: triangle.face,
            subface: triangle.subface,
            u: parameter(0),
            v: parameter(1),
        }
    }

    /// The shader's normal, of length one and on the side of `flat`.
    fn normal(&self, at: &SurfaceAt, flat: Vec3) -> Vec3 {
        let normal = self.shader.normal(at).and_then(|n| DVec3::from(n).try_normalize()).map_or(flat, DVec3::as_vec3);
        if normal.dot(flat) < 0.0 { -normal } else { normal }
    }

    /// Where the surface would be above a flat triangle: Hanika, "Hacking the shadow terminator", Ray Tracing Gems II,
    /// 2021. The position is projected onto the tangent planes of the corners and the projections are interpolated,
    /// which only ever lifts. Without it, triangles cut light off along their edges where it grazes the surface.
    fn lifted(&self, lit: &Lit) -> Vec3 {
        let Some((index, weights)) = lit.on else { return lit.position };
        let corners = self.mesh.triangles[index as usize].corners;
        let mut lifted = lit.position;
        for corner in 0..3 {
            let mut weight = [0.0; 3];
            weight[corner] = 1.0;
            let normal = self.normal(&self.at(index, weight), lit.flat);
            let below = (lit.position - Vec3::from(self.mesh.positions[corners[corner] as usize])).dot(normal).min(0.0);
            lifted -= normal * (below * weights[corner]);
        }
        lifted
    }

    /// Adds the shadow on the floor, if the ray meets it.
    fn floor_shadow(&self, direction: Vec3, pixel: &mut Pixel) -> Option<Lit> {
        let floor = self.floor?;
        if direction.y >= 0.0 || self.lens.eye.y <= floor.height {
            return None;
        }
        let position = self.lens.eye + direction * ((floor.height - self.lens.eye.y) / direction.y);
        let away = position - floor.center;
        let distance = Vec3::new(away.x, 0.0, away.z).length() / self.radius;
        let t = ((FLOOR_FADE[1] - distance) / (FLOOR_FADE[1] - FLOOR_FADE[0])).clamp(0.0, 1.0);
        if t == 0.0 {
            return None;
        }
        // A black veil: as opaque as the light that is missing.
        pixel.veil += FLOOR_STRENGTH * t * t * (3.0 - 2.0 * t);
        Some(Lit { position, normal: Vec3::Y, flat: Vec3::Y, on: None, striped: None })
    }

    /// Casts rays from one sample: with `turns` 2, samples look at the sky and the key light by turns.
    fn look_for_light(
        &self,
        lit: &Lit,
        sampler: &Sampler,
        sample: u32,
        turns: u32,
        pixel: &mut Pixel,
        stack: &mut Stack,
    ) {
        if self.show == Show::Normals {
            return;
        }
        let mut lifted = None;
        let mut open = |direction: Vec3, reach: f32| {
            // Rays that graze the triangle start above it; all others start on it: most do, and contacts stay tight.
            let grazes = direction.dot(lit.flat) < GRAZING;
            let origin = if grazes { *lifted.get_or_insert_with(|| self.lifted(lit)) } else { lit.position };
            let origin = origin + lit.flat * self.epsilon;
            f32::from(u8::from(!self.bvh.blocked(&Ray { origin, direction, reach }, stack)))
        };
        let [sky, key] = match lit.on {
            Some(_) => [SKY, KEY].map(|channel| (channel, 1.0)),
            None => self.studio.floor_shares().map(|share| (FLOOR, share)),
        };
        let shines = lit.normal.dot(self.studio.key) > 0.0;
        if turns == 1 || sample.is_multiple_of(2) || !shines {
            let direction = cosine(sampler.point(1, sample / turns), lit.normal);
            pixel.open[sky.0] += sky.1 * open(direction, SKY_REACH * self.radius);
            pixel.rays[sky.0] += sky.1;
        }
        if shines && (turns == 1 || !sample.is_multiple_of(2)) {
            let direction = cone(sampler.point(2, sample / turns), self.studio.key, KEY_TANGENT);
            pixel.open[key.0] += key.1 * open(direction, f32::INFINITY);
            pixel.rays[key.0] += key.1;
        }
    }
}

/// So that a number is seen as it is in the file, not brighter.
fn encoded_to_linear(x: f32) -> f32 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}
