//! Normals and colours of the limit surface, exact at every sample.

use super::marks;
use super::picture::{Look, Subject};
use crate::baseline;
use rayon::prelude::*;
use subsurf::{AdaptiveRefinement, Curvature, Face, LimitSurface, Location, PatchKind, Scheme, ShadingNormals};
use subsurf_render::{
    Legend, Phase, RenderMesh, RenderTriangle, Show, Stripes, SurfaceAt, SurfacePoint, SurfaceShader, palette,
};

/// What the renderer asks.
pub struct Painter<'a> {
    surface: LimitSurface<'a, f32, 3>,
    shading: Option<&'a ShadingNormals<'a>>,
    show: Show,
    stripes: Stripes,
    /// Whose patches are shown instead of ours.
    baseline: Option<&'a AdaptiveRefinement>,
    /// How many levels there are: of the baseline, or of the patch trees, the face itself included.
    levels: usize,
    /// Curvatures from -range to range have colours of their own.
    range: f64,
}

/// Kinds of our patches in the order of their colours.
const KINDS: [(PatchKind, &str); 3] = [
    (PatchKind::Regular, "regular"),
    (PatchKind::SingleCrease, "single crease"),
    (PatchKind::Special, "special vertex"),
];

/// Colours of the baseline's kinds: those of ours, and one more for boundaries.
const BASELINE_COLORS: [usize; 4] = [0, 4, 1, 2];

/// The share of what is seen whose curvature has colours of its own. Larger lets the neighbourhoods of extraordinary
/// vertices, where curvature grows without bound, bleach everything else; smaller hides differences.
const SHARE: f64 = 0.95;

/// Curvature below this, in one over the size of the model, comes from the rounding of control points, and gets no
/// colours.
const ROUNDING: f64 = 1e-5;

impl<'a> Painter<'a> {
    pub fn new(subject: &Subject<'a>, look: &Look, mesh: &RenderMesh) -> Self {
        let &Subject { table, points, shading, baseline } = subject;
        let (show, stripes) = (look.show, look.stripes);
        let surface = table.surface(points);
        let mut painter = Self { surface, shading, show, stripes, baseline, levels: 1, range: 1.0 };
        if let Some(baseline) = baseline {
            painter.levels = baseline.counts().len();
        } else if show == Show::Levels {
            let level = |t: &RenderTriangle| {
                let [u, v] = [0, 1].map(|i| t.uv.iter().map(|uv| f64::from(uv[i])).sum::<f64>() / 3.0);
                painter.patch(t.face, t.subface, u, v).map_or(0, |(_, level)| level as usize)
            };
            painter.levels = mesh.triangles.par_iter().map(level).max().unwrap_or(0) + 1;
        }
        painter
    }

    /// Fits the colours to `range`, or else to the curvature at the places `seen`.
    pub fn set_range(&mut self, range: Option<f64>, points: &[[f32; 3]], seen: &[SurfaceAt]) {
        let size = |at: &SurfaceAt| self.curvature(at).map(f64::abs);
        let power = if self.show == Show::Gaussian { 2 } else { 1 };
        let flat = extent(points).recip();
        self.range = range.unwrap_or_else(|| match percentile(seen.par_iter().filter_map(size).collect()) {
            size if size > (ROUNDING * flat).powi(power) => rounded_up(size),
            _ => rounded_up(flat.powi(power)),
        });
    }

    /// The end of the colours' scale, if they show curvature.
    pub fn range(&self) -> Option<f64> {
        matches!(self.show, Show::Gaussian | Show::Mean).then_some(self.range)
    }

    /// What the colours mean; `marks` is the number of dots where there is no curvature.
    pub fn legend(&self, marks: usize) -> Option<Legend> {
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
            (Show::Gaussian | Show::Mean, _) if marks > 0 => vec![(marks::COLOR, "no value".to_owned())],
            _ => Vec::new(),
        };
        let mut legend = Legend { entries, ..Legend::default() };
        match self.show {
            Show::Gaussian | Show::Mean => {
                // Beyond the ends colours stay the same.
                let label = |i: i32| {
                    let ends = ["<= ", "", ">= "][(1 + i / 3) as usize];
                    format!("{ends}{}", short(self.range * f64::from(i) / 3.0))
                };
                legend.title = match self.show {
                    Show::Gaussian => "Gaussian\n1/unit^2".to_owned(),
                    _ => "mean\n1/unit".to_owned(),
                };
                legend.scale = (-3..=3).rev().map(|i| (palette::diverging(i as f32 / 3.0), label(i))).collect();
            }
            Show::BlendWeight => {
                legend.title = "weight".to_owned();
                let label = |i: i32| format!("{:.1}", f64::from(i) / 5.0);
                legend.scale = (0..=5).rev().map(|i| (palette::sequential(i as f32 / 5.0), label(i))).collect();
            }
            _ => {}
        }
        (legend != Legend::default()).then_some(legend)
    }

    /// The place in the surface's parameters, which interpolation between corners may leave by a rounding.
    fn location(&self, at: &SurfaceAt) -> Location {
        let (u, v) = (at.u.clamp(0.0, 1.0), at.v.clamp(0.0, 1.0));
        let beyond = if self.surface.table().scheme() == Scheme::Loop { (u + v).max(1.0) } else { 1.0 };
        Location { face: Face(at.face), subface: at.subface, u: u / beyond, v: v / beyond }
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

    /// The curvature that is shown.
    fn curvature(&self, at: &SurfaceAt) -> Option<f64> {
        let Curvature { gaussian, mean, .. } = self.surface.eval_second(self.location(at))?.curvature()?;
        Some(if self.show == Show::Gaussian { gaussian } else { mean })
    }

    /// The weight of subdivided normals, b^p.
    fn share(&self, at: Location) -> f64 {
        self.shading.map_or(0.0, |shading| shading.blend_weight(at).powf(shading.power(at)))
    }
}

impl SurfaceShader for Painter<'_> {
    fn normal(&self, at: &SurfaceAt) -> Option<[f64; 3]> {
        let at = self.location(at);
        let jet = self.surface.eval(at)?;
        self.shading.map_or_else(|| jet.normal(), |shading| shading.normal(at, &jet))
    }

    fn color(&self, point: &SurfacePoint) -> [f32; 3] {
        let at = self.location(&point.at);
        let patch = || self.patch(at.face.0, at.subface, at.u, at.v);
        match self.show {
            Show::Patches => patch().map_or(palette::clay(), |(kind, _)| palette::category(kind)),
            Show::Levels => patch().map_or(palette::clay(), |(_, level)| palette::level(level as usize, self.levels)),
            Show::Gaussian | Show::Mean => {
                self.curvature(&point.at).map_or(marks::COLOR, |k| palette::diverging((k / self.range) as f32))
            }
            Show::BlendWeight => palette::sequential(self.share(at) as f32),
            _ => palette::clay(),
        }
    }

    fn phase(&self, point: &SurfacePoint) -> Option<Phase> {
        match self.show {
            Show::Isophotes => Some(self.stripes.isophotes(point.normal)),
            Show::ReflectionLines => Some(self.stripes.reflection_lines(point.normal, point.view)),
            _ => None,
        }
    }
}

/// Longest side of the box round the points.
fn extent(points: &[[f32; 3]]) -> f64 {
    let side = |i: usize| {
        let ends = points
            .iter()
            .map(|p| f64::from(p[i]))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
        ends[1] - ends[0]
    };
    (0..3).map(side).fold(f64::MIN_POSITIVE, f64::max)
}

/// The value that a share [`SHARE`] of all does not exceed; 0 of none.
fn percentile(mut sizes: Vec<f64>) -> f64 {
    let at = (sizes.len() as f64 * SHARE) as usize;
    if sizes.is_empty() {
        return 0.0;
    }
    let at = at.min(sizes.len() - 1);
    *sizes.select_nth_unstable_by(at, f64::total_cmp).1
}

/// The next larger of 1.5, 3, 6, 9 and their decimal multiples, whose thirds are short; 1.5 for 0.
fn rounded_up(x: f64) -> f64 {
    if x <= f64::MIN_POSITIVE || !x.is_finite() {
        return 1.5;
    }
    let power = 10f64.powf(x.log10().floor());
    let steps = [1.5, 3.0, 6.0, 9.0, 15.0];
    // Rounding of the power must not double the scale.
    steps.iter().map(|step| step * power).find(|&step| step >= x * (1.0 - 1e-12)).unwrap_or(15.0 * power)
}

/// With as few digits as numbers of the scale have, and a sign.
fn short(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let power = x.abs().log10().floor();
    if (-4.0..6.0).contains(&power) {
        let digits = (1.0 - power).max(0.0) as usize;
        let text = format!("{x:+.digits$}");
        return if digits > 0 { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text };
    }
    format!("{x:+.1e}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_a_little_above_what_they_show() {
        for (x, end) in [(1.0, 1.5), (1.6, 3.0), (0.03, 0.03), (7.0, 9.0), (95.0, 150.0), (2e-7, 3e-7), (0.0, 1.5)] {
            assert!((rounded_up(x) - end).abs() <= 1e-12 * end, "{x}: {}", rounded_up(x));
        }
    }

    #[test]
    fn a_twentieth_of_the_values_may_exceed_the_scale() {
        assert_eq!(percentile((0..100).rev().map(f64::from).collect()), 95.0);
        assert_eq!(percentile(vec![7.0]), 7.0);
        assert_eq!(percentile(Vec::new()), 0.0);
    }

    #[test]
    fn labels_are_short_and_signed() {
        let texts = [150.0, -0.5, 0.0, 20.0, 1e-7, 1e-3].map(short);
        assert_eq!(texts, ["+150", "-0.5", "0", "+20", "+1.0e-7", "+0.001"]);
    }
}
