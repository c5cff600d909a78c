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

use super::fan::CornerFan;
use super::points::{OwnWeights, Points, Step};
use super::{Leaf, LeafShape};
use crate::sharpness::{decay, is_semi_sharp};
use crate::topology::{Lowest, lowered};
use std::sync::Arc;

/// What becomes of a face in one step.
pub(super) enum Part<C> {
    Leaf(Leaf),
    /// The step, and the children corner by corner.
    Split(Step, Vec<C>),
}

/// A node with places for values.
pub(super) struct Template {
    pub ring: usize,
    body: Body,
}

enum Body {
    /// A patch along one crease: the leaf, and which value is the crease's.
    Crease(Leaf, usize),
    Split {
        step: Arc<Step>,
        slopes: Vec<Slope>,
        children: Vec<Child>,
    },
}

/// How the weights that differ from node to node depend on a value below 1.
struct Slope {
    value: usize,
    marker: f64,
    weights: Vec<f64>,
}

/// A child: the key of its fan, whose sharpness is that of the node less one, and where in it which values stand.
struct Child {
    key: Vec<u32>,
    values: Vec<(usize, usize)>,
}

/// Of a node made from a template, what does not need other nodes' numbers.
pub(super) enum Filled<'a> {
    Leaf(Leaf),
    /// The step, and how many weights the node has of its own.
    Split(&'a Arc<Step>, usize),
}

/// Most values of a template. Larger: markers would come too close.
const MOST_VALUES: usize = 48;

/// The outline of a key in which sharpness stands at these places: the key without the values of finite sharpness, which are added
/// to `values`.
pub(super) fn outline(key: &[u32], places: impl Iterator<Item = usize>, outline: &mut Vec<u32>, values: &mut Vec<f64>) {
    let first = values.len();
    outline.clear();
    outline.extend_from_slice(key);
    for at in places {
        let s = f64::from_bits(u64::from(key[at]) << 32 | u64::from(key[at + 1]));
        outline[at..at + 2].copy_from_slice(&[place(s, values, first), 0]);
    }
}

/// Where `s` belongs in an outline: a number that is equal for equal `s`, and tells smooth, infinitely sharp, below 1, 1 and above
/// apart. Values are those from `first` on; new ones are added.
fn place(s: f64, values: &mut Vec<f64>, first: usize) -> u32 {
    if !is_semi_sharp(s) {
        return u32::from(s > 0.0);
    }
    let at = values[first..].iter().position(|&value| value == s).unwrap_or_else(|| {
        values.push(s);
        values.len() - 1 - first
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
    pub fn new(values: &[f64], mut step: impl FnMut(&[f64]) -> Option<(usize, Part<CornerFan>)>) -> Option<Self> {
        if values.len() > MOST_VALUES {
            return None;
        }
        let markers = markers(values);
        let (ring, part) = step(&markers)?;
        let (here, below) = match part {
            Part::Split(here, below) => (here, below),
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
            if !there.own.is_like(&here.own) {
                return None;
            }
            let weights = there.own.weights().iter().zip(here.own.weights());
            let weights = weights.map(|(there, here)| (there - here) / 0.5).collect();
            slopes.push(Slope { value, marker: markers[value], weights });
        }
        let step = Arc::new(varying_last(here, &mut slopes));
        let children = below.into_iter().map(|fan| Child::new(&fan, &markers)).collect();
        Some(Self { ring, body: Body::Split { step, slopes, children } })
    }

    /// The node with these values, but for its weights and links.
    pub fn fill(&self, values: &[f64]) -> Filled<'_> {
        match &self.body {
            Body::Crease(leaf, value) => Filled::Leaf(leaf.with_sharpness(values[*value])),
            Body::Split { step, slopes, .. } => {
                Filled::Split(step, slopes.first().map_or(0, |slope| slope.weights.len()))
            }
        }
    }

    /// The weights that the node with these values has of its own.
    pub fn weights(&self, values: &[f64], out: &mut [f64]) {
        let Body::Split { step, slopes, .. } = &self.body else { return };
        out.copy_from_slice(&step.own.weights()[step.own.start(step.varying)..]);
        for Slope { value, marker, weights: slope } in slopes {
            let by = values[*value] - marker;
            out.iter_mut().zip(slope).for_each(|(weight, slope)| *weight += by * slope);
        }
    }

    /// The lowest sharpness in the fan of child `c`; none where no value is left there.
    pub fn lowest(&self, c: usize, values: &[f64]) -> Lowest {
        let Body::Split { children, .. } = &self.body else { return Lowest::default() };
        Lowest::among(children[c].values.iter().map(|&(_, value)| decay(values[value])))
    }

    /// The key of child `c`, lowered by `raise`.
    pub fn key(&self, c: usize, values: &[f64], raise: i8, key: &mut Vec<u32>) {
        let Body::Split { children, .. } = &self.body else { return };
        key.clear();
        key.extend_from_slice(&children[c].key);
        for &(at, value) in &children[c].values {
            let bits = lowered(decay(values[value]), raise).to_bits();
            key[at..at + 2].copy_from_slice(&[(bits >> 32) as u32, bits as u32]);
        }
    }
}

impl Child {
    /// Of a fan with markers.
    fn new(fan: &CornerFan, markers: &[f64]) -> Self {
        let mut key = Vec::new();
        fan.key(0, &mut key);
        let all = std::iter::once(fan.vertex).chain(fan.spokes.iter().map(|spoke| spoke.1));
        let inherited = |s: f64| markers.iter().position(|&m| m > 1.0 && decay(m) == s);
        let places = CornerFan::places(fan.spokes.len()).zip(all);
        let values = places.filter_map(|(at, s)| Some((at, inherited(s)?))).collect();
        Self { key, values }
    }
}

/// A step whose rows that depend on values come last; slopes are those of these rows' weights.
fn varying_last(step: Step, slopes: &mut [Slope]) -> Step {
    let Step { shared, own, rings, .. } = step;
    let weights = |i: usize| own.start(i)..own.start(i + 1);
    let varies = |i: usize| slopes.iter().any(|slope| slope.weights[weights(i)].iter().any(|&w| w != 0.0));
    let (fixed, differing): (Vec<usize>, Vec<usize>) = (0..own.len()).partition(|&i| !varies(i));
    for slope in slopes.iter_mut() {
        slope.weights = differing.iter().flat_map(|&i| slope.weights[weights(i)].iter().copied()).collect();
    }
    let varying = fixed.len();
    let order = [fixed, differing].concat();
    let mut place = vec![0; order.len()];
    order.iter().zip(0..).for_each(|(&i, to)| place[i] = to);
    let first = shared.as_ref().map_or(0, |rows| rows.len()) as u32;
    let rings = rings.renumbered(|p| if p < first { p } else { first + place[(p - first) as usize] });
    Step { shared, own: own.in_order(&order), varying, rings: Arc::new(rings) }
}

impl Points {
    /// Of a template's step.
    pub fn filled(step: &Arc<Step>, weights: Option<OwnWeights>) -> Self {
        Self { step: step.clone(), weights }
    }
}

#[cfg(test)]
mod tests {
    use super::super::compile::Compiler;
    use super::super::face_mesh::FaceMeshes;
    use super::super::fan::FanShape;
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
        let (face_meshes, scheme) = (&FaceMeshes::default(), Scheme::CatmullClark);
        let compiler = Compiler { mesh: &mesh, fan_meshes: &fan_meshes, face_meshes, scheme, specials: &specials };
        let mut scratch = RefinedPoints::default();
        let mut node = |fan: &CornerFan| {
            compiler.fan_mesh(fan, &mut scratch, &mut CornerFan::default(), |below: &CornerFan, _| below.clone())
        };
        let shape = |is_closed, faces, own| FanShape { is_closed, faces, own };
        let (mut splits, mut creases) = (0, 0);
        let (mut key, mut own_key) = (Vec::new(), Vec::new());
        for shape in [shape(true, 3, 0), shape(true, 4, 0), shape(false, 2, 1), shape(false, 3, 1)] {
            for code in 0..5u32.pow(if shape.is_closed { 5 } else { 3 }) {
                let [here, there] = [[0.25, 1.5, 0.625], [0.875, 3.25, 0.5]].map(|values| fan(shape, values, code));
                let [(outline, from), (same, to)] = [&here, &there].map(|fan| {
                    let (mut outline, mut values) = (Vec::new(), Vec::new());
                    fan.key(0, &mut key);
                    super::outline(&key, CornerFan::places_in(&key), &mut outline, &mut values);
                    (outline, values)
                });
                assert_eq!(outline, same);
                if from.is_empty() {
                    continue;
                }
                let template = Template::new(&from, |to| Some(node(&here.with_values(&from, to))));
                let (ring, direct) = node(&there);
                let Some(template) = template else { panic!("{here:?}") };
                assert_eq!(template.ring, ring);
                match (template.fill(&to), direct) {
                    (Filled::Leaf(filled), Part::Leaf(direct)) => {
                        let crease = |leaf: &Leaf| match leaf.shape {
                            LeafShape::SingleCrease { turn, sharpness } => (turn, sharpness),
                            _ => panic!("{there:?}"),
                        };
                        assert_eq!(crease(&filled), crease(&direct));
                        assert_eq!(filled.points.dense(), direct.points.dense());
                        creases += 1;
                    }
                    (Filled::Split(step, own), Part::Split(direct, children)) => {
                        assert_eq!(children.len(), 4);
                        for (c, child) in children.iter().enumerate() {
                            child.key(0, &mut own_key);
                            template.key(c, &to, 0, &mut key);
                            assert_eq!(key, own_key, "{there:?}");
                            assert_eq!(template.lowest(c, &to), child.lowest(), "{there:?}");
                        }
                        let mut all = vec![0.0; own];
                        template.weights(&to, &mut all);
                        let weights = (own > 0).then(|| OwnWeights { all: Arc::new(all), start: 0 });
                        let (filled, direct) = (Points::filled(step, weights), Points::new(direct));
                        for c in 0..children.len() {
                            let rings = [&filled, &direct].map(|points| points.step.rings.get(c));
                            assert_eq!(rings[0].len(), rings[1].len());
                            for (&i, &j) in rings[0].iter().zip(rings[1]) {
                                let ours: Vec<_> = filled.row(i as usize).collect();
                                let theirs: Vec<_> = direct.row(j as usize).collect();
                                assert_eq!(ours.len(), theirs.len());
                                // Weights are at most 1; a slope is the difference of two by a half.
                                let near = |(a, b): (&(u32, f64), &(u32, f64))| {
                                    a.0 == b.0 && (a.1 - b.1).abs() < 8.0 * f64::EPSILON
                                };
                                assert!(ours.iter().zip(&theirs).all(near), "{there:?} child {c} row {i}");
                            }
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
