//! Normals and colours of the limit surface, exact at every sample.

use crate::baseline;
use rayon::prelude::*;
use subsurf::{AdaptiveRefinement, Face, LimitSurface, Location, PatchKind, Scheme};
use subsurf_render::{Legend, RenderMesh, Show, SurfaceAt, SurfacePoint, SurfaceShader, palette};

/// What the renderer asks.
pub struct Painter<'a> {
    surface: LimitSurface<'a, f32, 3>,
    show: Show,
    /// Whose patches are shown instead of ours.
    baseline: Option<&'a AdaptiveRefinement>,
    /// How many levels there are: of the baseline, or of the patch trees, the face itself included.
    levels: usize,
}

/// Kinds of our patches in the order of their colours.
const KINDS: [(PatchKind, &str); 3] = [
    (PatchKind::Regular, "regular"),
    (PatchKind::SingleCrease, "single crease"),
    (PatchKind::Special, "special vertex"),
];

/// Colours of the baseline's kinds: those of ours, and one more for boundaries.
const BASELINE_COLORS: [usize; 4] = [0, 4, 1, 2];

impl<'a> Painter<'a> {
    pub fn new(
        surface: LimitSurface<'a, f32, 3>,
        show: Show,
        baseline: Option<&'a AdaptiveRefinement>,
        mesh: &RenderMesh,
    ) -> Self {
        let mut painter = Self { surface, show, baseline, levels: 1 };
        if let Some(baseline) = baseline {
            painter.levels = baseline.counts().len();
        } else if show == Show::Levels {
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
        let entries = match (self.show, self.baseline) {
            (Show::Patches, Some(baseline)) => {
                let counts = baseline.counts();
                let occurs = |kind: &usize| counts.iter().any(|level| level[*kind] > 0);
                let entry = |kind: usize| (palette::category(BASELINE_COLORS[kind]), baseline::KINDS[kind].to_owned());
                (0..BASELINE_COLORS.len()).filter(occurs).map(entry).collect()
            }
            (Show::Patches, None) => (0..KINDS.len()).map(|i| (palette::category(i), KINDS[i].1.to_owned())).collect(),
            (Show::Levels, _) => {
                (0..self.levels).map(|i| (palette::level(i, self.levels), format!("level {i}"))).collect()
            }
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

    /// Number of the colour of the patch's kind, and its level.
    fn patch(&self, face: u32, subface: u32, u: f64, v: f64) -> Option<(usize, u32)> {
        if let Some(baseline) = self.baseline {
            let patch = baseline.patch_at(Location { face: Face(face), subface, u, v })?;
            return Some((BASELINE_COLORS[patch.kind as usize], patch.level));
        }
        let table = self.surface.table();
        let (kind, level) = table.patch_kind(table.patch(Face(face), subface), u, v)?;
        Some((KINDS.iter().position(|known| known.0 == kind).unwrap_or(KINDS.len()), level))
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
        let Some((color, level)) = self.patch(face, subface, u, v) else {
            return palette::clay();
        };
        if self.show == Show::Levels {
            return palette::level(level as usize, self.levels);
        }
        palette::category(color)
    }
}
