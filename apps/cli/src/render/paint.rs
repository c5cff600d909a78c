//! Normals and colours of the limit surface, exact at every sample.

use rayon::prelude::*;
use subsurf::{Face, LimitSurface, Location, PatchKind, Scheme};
use subsurf_render::{Legend, RenderMesh, Show, SurfaceAt, SurfacePoint, SurfaceShader, palette};

/// What the renderer asks.
pub struct Painter<'a> {
    surface: LimitSurface<'a, f32, 3>,
    show: Show,
    /// How many explicit levels the patch trees have, the face itself included.
    levels: usize,
}

/// Kinds of patches in the order of their colours.
const KINDS: [(PatchKind, &str); 3] = [
    (PatchKind::Regular, "regular"),
    (PatchKind::SingleCrease, "single crease"),
    (PatchKind::Special, "special vertex"),
];

impl<'a> Painter<'a> {
    pub fn new(surface: LimitSurface<'a, f32, 3>, show: Show, mesh: &RenderMesh) -> Self {
        let mut painter = Self { surface, show, levels: 1 };
        if show == Show::Levels {
            let level = |t: &subsurf_render::RenderTriangle| {
                let [u, v] = [0, 1].map(|i| t.uv.iter().map(|uv| f64::from(uv[i])).sum::<f64>() / 3.0);
                painter.patch(t.face, t.subface, u, v).map_or(0, |(_, level)| level as usize)
            };
            painter.levels = mesh.triangles.par_iter().map(level).max().unwrap_or(0) + 1;
        }
        painter
    }

    /// What the colours mean.
    pub fn legend(&self) -> Option<Legend> {
        let entries = match self.show {
            Show::Patches => (0..KINDS.len()).map(|i| (palette::category(i), KINDS[i].1.to_owned())).collect(),
            Show::Levels => (0..self.levels).map(|i| (palette::level(i, self.levels), format!("level {i}"))).collect(),
            _ => return None,
        };
        Some(Legend { entries })
    }

    /// Parameters within the face, which interpolation between corners may leave by a rounding.
    fn inside(&self, u: f64, v: f64) -> [f64; 2] {
        let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
        let beyond = if self.surface.table().scheme() == Scheme::Loop { (u + v).max(1.0) } else { 1.0 };
        [u / beyond, v / beyond]
    }

    fn patch(&self, face: u32, subface: u32, u: f64, v: f64) -> Option<(PatchKind, u32)> {
        let table = self.surface.table();
        table.patch_kind(table.patch(Face(face), subface), u, v)
    }
}

impl SurfaceShader for Painter<'_> {
    fn normal(&self, at: &SurfaceAt) -> Option<[f64; 3]> {
        let [u, v] = self.inside(at.u, at.v);
        self.surface.eval(Location { face: Face(at.face), subface: at.subface, u, v })?.normal()
    }

    fn color(&self, point: &SurfacePoint) -> [f32; 3] {
        if !matches!(self.show, Show::Patches | Show::Levels) {
            return palette::clay();
        }
        let SurfaceAt { face, subface, u, v, .. } = point.at;
        let [u, v] = self.inside(u, v);
        let Some((kind, level)) = self.patch(face, subface, u, v) else {
            return palette::clay();
        };
        if self.show == Show::Levels {
            return palette::level(level as usize, self.levels);
        }
        let index = KINDS.iter().position(|known| known.0 == kind).unwrap_or(KINDS.len());
        palette::category(index)
    }
}
