//! Nodes that differ in the values of finite sharpness alone are made from one template.
//!
//! The rules of one step tell finite sharpness `s` apart by whether it is below 1, equal to 1, or above. Above 1 no weight depends
//! on the value. Below 1 an edge point is `(1 - s) · smooth + s · midpoint`, and a vertex blends two masks by the mean of what
//! reaches 0: weights are affine in all values together. So a step is worked out once with *markers* in the place of values, and
//! once more for every value below 1, which tells the slope; then a node of other values is
//!
//! ```text
//! weight(s) = weight(m) + Σ_k (s_k - m_k) · slope_k
//! ```
//!
//! and which value a child inherits is read off the markers that its fan has.

use super::fan::{CornerFan, FanShape};
use super::{Leaf, LeafShape, Points};
use crate::limit::plan_key::Key;
use crate::limit::rows::Rows;
use crate::sharpness::{decay, is_semi_sharp};
use std::sync::Arc;

/// A key without the values of finite sharpness, and these values.
pub(super) struct Outline {
    pub key: Key,
    pub values: Box<[f64]>,
}

/// What becomes of a face in one step.
pub(super) enum Part<C> {
    Leaf(Leaf),
    /// The refined points, and the children corner by corner.
    Split(Points, Vec<C>),
}

/// A child: its fan, and its ring among the refined points.
pub(super) type Below = (CornerFan, Arc<[u32]>);

/// A node with places for values.
pub(super) struct Template {
    pub ring: usize,
    body: Body,
}

enum Body {
    /// A patch along one crease: the leaf, and which value is the crease's.
    Crease(Leaf, usize),
    Split {
        shared: Option<Arc<Rows>>,
        own: Arc<Rows>,
        slopes: Vec<Slope>,
        children: Vec<Child>,
    },
}

/// How weights depend on a value below 1.
struct Slope {
    value: usize,
    marker: f64,
    weights: Vec<f64>,
}

/// A child's fan, whose sharpness is that of the node less one.
struct Child {
    shape: FanShape,
    vertex: Source,
    spokes: Vec<(u32, Source)>,
    ring: Arc<[u32]>,
}

#[derive(Clone, Copy)]
enum Source {
    Fixed(f64),
    Value(usize),
}

/// Most values of a template. Larger: markers would come too close.
const MOST_VALUES: usize = 48;

/// Where `s` belongs in an outline: a number that is equal for equal `s`, and tells smooth, infinitely sharp, below 1, 1 and above
/// apart. New values are added to `values`.
pub(super) fn place(s: f64, values: &mut Vec<f64>) -> u32 {
    if !is_semi_sharp(s) {
        return u32::from(s > 0.0);
    }
    let at = values.iter().position(|&value| value == s).unwrap_or_else(|| {
        values.push(s);
        values.len() - 1
    });
    let class = if s < 1.0 {
        0
    } else if s == 1.0 {
        1
    } else {
        2
    };
    2 + 3 * at as u32 + class
}

/// A marker for every value: different ones, on the same side of 1.
fn markers(values: &[f64]) -> Vec<f64> {
    let marker = |(k, &s): (usize, &f64)| {
        let step = (k + 1) as f64 / 128.0;
        if s < 1.0 {
            step
        } else if s == 1.0 {
            1.0
        } else {
            2.0 + step
        }
    };
    values.iter().enumerate().map(marker).collect()
}

/// How many nodes have to be alike for a template to pay.
pub(super) fn least(values: &[f64]) -> usize {
    3 + values.iter().filter(|&&s| s < 1.0).count()
}

impl Template {
    /// `step` works a node out with other values in the place of `values`; none where its children are no fans. None too
    /// where there are too many values, or weights have no common structure.
    pub fn new(values: &[f64], mut step: impl FnMut(&[f64]) -> Option<(usize, Part<Below>)>) -> Option<Self> {
        if values.len() > MOST_VALUES {
            return None;
        }
        let markers = markers(values);
        let (ring, part) = step(&markers)?;
        let (points, below) = match part {
            Part::Split(points, below) => (points, below),
            Part::Leaf(leaf) => {
                let LeafShape::SingleCrease { sharpness, .. } = leaf.shape else { return None };
                let value = markers.iter().position(|&m| m == sharpness)?;
                return Some(Self { ring, body: Body::Crease(leaf, value) });
            }
        };
        let mut slopes = Vec::new();
        for value in (0..values.len()).filter(|&value| values[value] < 1.0) {
            let mut moved = markers.clone();
            moved[value] += 0.5;
            let (_, Part::Split(there, _)) = step(&moved)? else { return None };
            if !there.own.is_like(&points.own) {
                return None;
            }
            let weights = there.own.weights().iter().zip(points.own.weights());
            let weights = weights.map(|(there, here)| (there - here) / 0.5).collect();
            slopes.push(Slope { value, marker: markers[value], weights });
        }
        let source = |s: f64| {
            let inherited = |&m: &f64| m > 1.0 && decay(m) == s;
            markers.iter().position(inherited).map_or(Source::Fixed(s), Source::Value)
        };
        let child = |(fan, ring): Below| Child {
            shape: fan.shape,
            vertex: source(fan.vertex),
            spokes: fan.spokes.iter().map(|&(spoke, s)| (spoke, source(s))).collect(),
            ring,
        };
        let children = below.into_iter().map(child).collect();
        Some(Self { ring, body: Body::Split { shared: points.shared, own: points.own, slopes, children } })
    }

    /// The node with these values; `child` is called with every child's fan, number and ring.
    pub fn fill<C>(
        &self,
        values: &[f64],
        fan: &mut CornerFan,
        mut child: impl FnMut(&CornerFan, usize, Arc<[u32]>) -> C,
    ) -> Part<C> {
        let (shared, own, slopes, children) = match &self.body {
            Body::Crease(leaf, value) => return Part::Leaf(leaf.with_sharpness(values[*value])),
            Body::Split { shared, own, slopes, children } => (shared, own, slopes, children),
        };
        let own = if slopes.is_empty() {
            own.clone()
        } else {
            let mut weights = own.weights().to_vec();
            for Slope { value, marker, weights: slope } in slopes {
                let by = values[*value] - marker;
                weights.iter_mut().zip(slope).for_each(|(weight, slope)| *weight += by * slope);
            }
            Arc::new(own.with_weights(weights))
        };
        let of = |source: Source| match source {
            Source::Fixed(s) => s,
            Source::Value(value) => decay(values[value]),
        };
        let children = children.iter().enumerate().map(|(c, below)| {
            fan.shape = below.shape;
            fan.vertex = of(below.vertex);
            fan.spokes.clear();
            fan.spokes.extend(below.spokes.iter().map(|&(spoke, s)| (spoke, of(s))));
            child(fan, c, below.ring.clone())
        });
        let children = children.collect();
        Part::Split(Points { shared: shared.clone(), own }, children)
    }
}

#[cfg(test)]
mod tests {
    use super::super::compile::Compiler;
    use super::super::fan_mesh::FanMeshes;
    use super::super::refined_points::RefinedPoints;
    use super::*;
    use crate::limit::plan::SpecialVertices;
    use crate::scheme::Scheme;
    use crate::shapes;
    use crate::topology::Topology;

    /// A fan whose vertex and spokes are smooth, infinitely sharp, or have one of three values, by the digits of `code`.
    fn fan(shape: FanShape, values: [f64; 3], mut code: u32) -> CornerFan {
        let spokes = shape.faces + u32::from(!shape.is_closed);
        let mut next = || {
            let s = [0.0, values[0], values[1], values[2], 10.0][code as usize % 5];
            code /= 5;
            s
        };
        let vertex = next();
        let is_end = |j: u32| !shape.is_closed && (j == 0 || j + 1 == spokes);
        let spokes = (0..spokes).map(|j| (j, if is_end(j) { 10.0 } else { next() }));
        CornerFan { shape, vertex, spokes: spokes.filter(|spoke| spoke.1 > 0.0).collect() }
    }

    #[test]
    fn a_template_gives_the_nodes_that_the_rules_give() {
        let mesh = Topology::new(&shapes::cube().mesh).unwrap();
        let (fan_meshes, specials) = (FanMeshes::default(), SpecialVertices::default());
        let compiler =
            Compiler { mesh: &mesh, fan_meshes: &fan_meshes, scheme: Scheme::CatmullClark, specials: &specials };
        let mut scratch = RefinedPoints::default();
        let mut node = |fan: &CornerFan| {
            let child = |below: &CornerFan, _, ring| -> Below { (below.clone(), ring) };
            compiler.fan_mesh(fan, &mut scratch, &mut CornerFan::default(), child)
        };
        let shape = |is_closed, faces, own| FanShape { is_closed, faces, own };
        let (mut splits, mut creases) = (0, 0);
        for shape in [shape(true, 3, 0), shape(true, 4, 0), shape(false, 2, 1), shape(false, 3, 1)] {
            for code in 0..5u32.pow(if shape.is_closed { 5 } else { 3 }) {
                let [here, there] = [[0.25, 1.5, 0.625], [0.875, 3.25, 0.5]].map(|values| fan(shape, values, code));
                let [from, to] = [here.outline(), there.outline()];
                assert_eq!(from.key, to.key);
                if from.values.is_empty() {
                    continue;
                }
                let template = Template::new(&from.values, |to| Some(node(&here.with_values(&from.values, to))));
                let (ring, direct) = node(&there);
                let Some(template) = template else { panic!("{here:?}") };
                assert_eq!(template.ring, ring);
                let child = |below: &CornerFan, _, ring| -> Below { (below.clone(), ring) };
                match (template.fill(&to.values, &mut CornerFan::default(), child), direct) {
                    (Part::Leaf(filled), Part::Leaf(direct)) => {
                        let crease = |leaf: &Leaf| match leaf.shape {
                            LeafShape::SingleCrease { turn, sharpness } => (turn, sharpness),
                            _ => panic!("{there:?}"),
                        };
                        assert_eq!(crease(&filled), crease(&direct));
                        assert_eq!(filled.points.dense(), direct.points.dense());
                        creases += 1;
                    }
                    (Part::Split(filled, below), Part::Split(direct, children)) => {
                        assert!(below == children, "{there:?}");
                        let rows = direct.own.len() + direct.shared.as_ref().map_or(0, |rows| rows.len());
                        for i in 0..rows {
                            let (ours, theirs): (Vec<_>, Vec<_>) = (filled.row(i).collect(), direct.row(i).collect());
                            assert_eq!(ours.len(), theirs.len());
                            // Weights are at most 1; a slope is the difference of two by a half.
                            let near = |(a, b): (&(u32, f64), &(u32, f64))| {
                                a.0 == b.0 && (a.1 - b.1).abs() < 8.0 * f64::EPSILON
                            };
                            assert!(ours.iter().zip(&theirs).all(near), "{there:?} row {i}");
                        }
                        splits += 1;
                    }
                    _ => panic!("{there:?}"),
                }
            }
        }
        assert!(splits > 1000 && creases > 0, "{splits} {creases}");
    }
}
