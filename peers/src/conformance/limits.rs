//! The limit: OpenSubdiv's three ways to it against ours, and refinement as the judge where they differ.

use super::cause::{Cause, causes};
use super::place::{Place, places};
use super::tally::{Case, Key, Method, Quantity, Tallies, Value, normal};
use super::variants::Variant;
use super::witness::{Start, Witness, face_starts};
use crate::opensubdiv::{self, Approximation, EndCap, Sample, VertexOrder};
use crate::shape::{Scheme, Shape};
use std::collections::HashMap;
use subsurf::{Derivatives, Face, LimitSurface, Location, PatchTable};

/// Most vertices of a level whose limits are compared, and most patches that are sampled, evenly chosen beyond.
const MOST_VERTICES: usize = 6000;
const MOST_PATCHES: usize = 300;
/// Places judged per cause, method and quantity of a mesh: the farthest apart, and as many spread over the rest.
const JUDGED: usize = 3;
/// Levels that a witness is followed at most.
const DEEPEST: usize = 90;

/// All limits of one mesh.
#[derive(Default)]
pub struct Limits {
    pub tallies: Tallies,
    /// Samples where one side has a surface and the other none, or ours has a value that is no number.
    pub one_sided: Vec<String>,
    /// Shapes for whose `Limit` OpenSubdiv must not be asked.
    pub not_run: Vec<String>,
}

/// # Errors
/// What either side says when it refuses the mesh.
pub fn compare(variant: &Variant) -> Result<Limits, String> {
    let shape = &variant.shape;
    let table = PatchTable::new(&shape.mesh()?, shape.our_scheme()).map_err(|e| e.to_string())?;
    let surface = table.surface(&shape.positions);
    let mut run = Run {
        variant,
        shape,
        surface,
        diagonal: shape.diagonal(),
        fractions: has_fractions(shape),
        start: Start::new(shape, 1)?,
        witnesses: HashMap::new(),
        out: Limits::default(),
    };
    for level in 1..=3 {
        run.vertex_limits(level)?;
    }
    run.surfaces()?;
    Ok(run.out)
}

/// True where OpenSubdiv rounds a weight to single precision: fractional sharpness, and Chaikin's averages.
pub fn has_fractions(shape: &Shape) -> bool {
    let creases = shape.tags.creases.iter().map(|c| c.sharpness);
    let chaikin = shape.tags.rules.creasing == subsurf::Creasing::Chaikin;
    chaikin || creases.chain(shape.tags.corners.iter().map(|c| c.sharpness)).any(|s| s.fract() != 0.0)
}

struct Run<'a> {
    variant: &'a Variant,
    shape: &'a Shape,
    surface: LimitSurface<'a, f64, 3>,
    diagonal: f64,
    fractions: bool,
    start: Start,
    witnesses: HashMap<(u32, u32, [u64; 2]), Option<Witness>>,
    out: Limits,
}

/// A place with what both sides say.
struct Pair {
    at: Location,
    cause: Cause,
    ours: Value,
    theirs: Value,
    what: String,
}

impl Run<'_> {
    fn vertex_limits(&mut self, depth: u32) -> Result<(), String> {
        let level = opensubdiv::refine(self.shape, depth, VertexOrder::VerticesFirst)?.pop().expect("a level");
        if level.positions.len() > MOST_VERTICES && depth > 1 {
            return Ok(());
        }
        let limits = match opensubdiv::limit(self.shape, depth, VertexOrder::VerticesFirst) {
            Ok(limits) => limits,
            Err(message) => {
                self.out.not_run.push(self.shape.name.clone());
                eprintln!("{message}");
                return Ok(());
            }
        };
        let causes = causes(&level, self.shape.scheme);
        let faces = places(self.shape, depth).pop().expect("a level");
        let starts = face_starts(&level);
        // On either side of a sharp edge the surface has another normal.
        let mut at: Vec<Vec<Location>> = vec![vec![]; level.positions.len()];
        // OpenSubdiv takes one side's, be it a hole's.
        let mut in_hole = vec![false; level.positions.len()];
        for (f, place) in faces.iter().enumerate() {
            for corner in 0..starts[f + 1] - starts[f] {
                let v = level.face_vertices[starts[f] + corner] as usize;
                in_hole[v] |= level.holes[f];
                if !level.holes[f] && (at[v].is_empty() || level.vertex_rules[v] > 2) {
                    at[v].push(location(place, place.corners[corner]));
                }
            }
        }
        let mut pairs = vec![];
        for (v, at) in at.into_iter().enumerate() {
            let limit = limits[v];
            let comparable = self.shape.scheme != Scheme::Bilinear && (level.vertex_rules[v] <= 2 || !in_hole[v]);
            let normal = if comparable { normal(limit.tangents) } else { None };
            let theirs = Value { position: limit.position, normal, first: None, second: None };
            let angle = |value: &Value| value.apart(&theirs, Quantity::Normal, 1.0).unwrap_or(180.0);
            let sides = at.iter().filter_map(|&at| Some((at, self.ours(at)?)));
            let nearest = sides.min_by(|(_, a), (_, b)| angle(a).total_cmp(&angle(b)));
            let Some((at, mut ours)) = nearest else { continue };
            // Tangents of the limit have no parametrisation of their own.
            (ours.first, ours.second) = (None, None);
            let what = format!("vertex {v} of level {depth}");
            pairs.push(Pair { at, cause: causes[v], ours, theirs, what });
        }
        self.enter(Method::Limit, &pairs)
    }

    fn surfaces(&mut self) -> Result<(), String> {
        let level = opensubdiv::refine(self.shape, 0, VertexOrder::VerticesFirst)?.pop().expect("level 0");
        let causes = causes(&level, self.shape.scheme);
        let table = self.surface.table();
        let patches = table.face_patches();
        let mut all = vec![];
        for face in 0..self.shape.counts.len() {
            all.extend((patches[face]..patches[face + 1]).map(|p| (face as u32, p - patches[face], p)));
        }
        let stride = all.len().div_ceil(MOST_PATCHES);
        let (mut samples, mut places) = (vec![], vec![]);
        for &(face, subface, patch) in all.iter().step_by(stride) {
            for uv in sample_places(self.shape.scheme) {
                samples.push(Sample { ptex_face: patch, uv });
                places.push(Location { face: Face(face), subface, u: uv[0], v: uv[1] });
            }
        }
        let starts = face_starts(&level);
        let corners = |f: u32| &level.face_vertices[starts[f as usize]..starts[f as usize + 1]];
        let ours: Vec<Option<Value>> = places.iter().map(|&at| self.ours(at)).collect();
        for method in Method::ALL.into_iter().filter(|&m| m != Method::Limit) {
            let jets = match method {
                Method::Far(level) => opensubdiv::eval_patches(self.shape, &samples, level, EndCap::GregoryBasis)?,
                Method::FarBSpline(level) => opensubdiv::eval_patches(self.shape, &samples, level, EndCap::BSpline)?,
                Method::Bfr(smooth, sharp) => opensubdiv::eval(self.shape, &samples, Approximation { smooth, sharp })?,
                Method::Limit => unreachable!("limits have no samples"),
            };
            let mut pairs = vec![];
            let mut one_sided = 0;
            for ((jet, &at), ours) in jets.iter().zip(&places).zip(&ours) {
                let theirs = Value {
                    position: jet.position,
                    normal: normal([jet.du, jet.dv]),
                    first: Some([jet.du, jet.dv]),
                    second: Some(jet.second),
                };
                let (Some(ours), false) = (*ours, jet.position[0].is_nan()) else {
                    one_sided += usize::from(ours.is_some() == jet.position[0].is_nan());
                    continue;
                };
                let cause = nearest(self.shape.scheme, corners(at.face.0), &causes, at);
                pairs.push(Pair { at, cause, ours, theirs, what: String::new() });
            }
            if one_sided > 0 {
                let text =
                    format!("{}: {one_sided} of {} samples by {}", self.variant.name(), samples.len(), method.name());
                self.out.one_sided.push(text);
            }
            self.enter(method, &pairs)?;
        }
        Ok(())
    }

    fn ours(&self, at: Location) -> Option<Value> {
        let jet = self.surface.eval_second(at)?;
        let finite = jet.derivatives == Derivatives::Finite;
        Some(Value {
            position: jet.position,
            normal: jet.plane.filter(|_| jet.unique_plane).and_then(normal),
            first: finite.then_some([jet.du, jet.dv]),
            second: if finite { jet.second } else { None },
        })
    }

    /// Counts the pairs' differences, and has some of them judged.
    fn enter(&mut self, method: Method, pairs: &[Pair]) -> Result<(), String> {
        let mut differing: Vec<(Key, f64, usize)> = vec![];
        for (i, pair) in pairs.iter().enumerate() {
            for quantity in Quantity::ALL {
                // Any number is at no distance from itself.
                if pair.ours.apart(&pair.ours, quantity, self.diagonal).is_some_and(f64::is_nan) {
                    let (name, quantity) = (self.variant.name(), quantity.name());
                    self.out.one_sided.push(format!("{name}, {quantity} by {}: ours is no number", method.name()));
                }
                let Some(apart) = pair.ours.apart(&pair.theirs, quantity, self.diagonal) else { continue };
                let threshold = quantity.threshold(self.fractions);
                let differs = apart.is_nan() || apart > threshold;
                let upside_down = differs
                    && quantity == Quantity::Second
                    && self.shape.scheme == Scheme::Loop
                    && pair.ours.apart(&pair.theirs.negated(), quantity, self.diagonal).is_some_and(|d| d <= threshold);
                let cause = if upside_down { Cause::UpsideDown } else { pair.cause };
                let key = (cause, method, quantity);
                self.out.tallies.add(key, apart, differs, self.fractions);
                if differs {
                    differing.push((key, apart, i));
                }
            }
        }
        differing.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        for group in differing.chunk_by(|a, b| a.0 == b.0) {
            let spread = (group.len() / JUDGED).max(1);
            let rest = group.iter().enumerate().filter(|(i, _)| *i >= JUDGED && i % spread == 0).map(|(_, g)| g);
            for &(key, difference, i) in group.iter().take(JUDGED).chain(rest) {
                let pair = &pairs[i];
                let Some(witness) = self.witness(pair.at)? else { continue };
                let at = pair.at;
                let place = format!(
                    "{}, {}face {}.{} ({}, {})",
                    self.variant.name(),
                    if pair.what.is_empty() { String::new() } else { format!("{}, ", pair.what) },
                    at.face.0,
                    at.subface,
                    at.u,
                    at.v
                );
                let case = Case {
                    place,
                    own: self.variant.own,
                    diagonal: self.diagonal,
                    fractions: self.fractions,
                    difference,
                    ours: pair.ours,
                    theirs: pair.theirs,
                    witness,
                };
                self.out.tallies.judge(key, case);
            }
        }
        Ok(())
    }

    fn witness(&mut self, at: Location) -> Result<Option<Witness>, String> {
        let key = (at.face.0, at.subface, [at.u.to_bits(), at.v.to_bits()]);
        if let Some(known) = self.witnesses.get(&key) {
            return Ok(known.clone());
        }
        let found = self.start.follow(self.shape, at.face.0, at.subface, [at.u, at.v], DEEPEST)?;
        self.witnesses.insert(key, found.clone());
        Ok(found)
    }
}

fn location(place: &Place, [u, v]: [f64; 2]) -> Location {
    Location { face: Face(place.face), subface: place.subface, u, v }
}

/// A grid, and points that close in on each corner.
fn sample_places(scheme: Scheme) -> Vec<[f64; 2]> {
    let triangle = scheme == Scheme::Loop;
    let mut out = vec![];
    for i in 0..=4 {
        for j in 0..=4 {
            if !triangle || i + j <= 4 {
                out.push([f64::from(i) / 4.0, f64::from(j) / 4.0]);
            }
        }
    }
    for depth in [3, 5, 7, 9] {
        for [a, b] in [[0.75, 0.5], [0.25, 0.625]].map(|p| p.map(|x| x * 0.5f64.powi(depth))) {
            if triangle {
                out.extend([[a, b], [1.0 - a - b, a], [b, 1.0 - a - b]]);
            } else {
                out.extend([[a, b], [1.0 - b, a], [1.0 - a, 1.0 - b], [b, 1.0 - a]]);
            }
        }
    }
    out
}

/// The kind of the patch's nearest corner; semi-sharp where any corner of the face is.
fn nearest(scheme: Scheme, vertices: &[u32], causes: &[Cause], at: Location) -> Cause {
    let of = |v: u32| causes[v as usize];
    if let Some(whole) = vertices.iter().map(|&v| of(v)).filter(|&c| c == Cause::SemiSharp).max() {
        return whole;
    }
    let corner_places: Vec<([f64; 2], Cause)> = match (scheme, vertices.len()) {
        (Scheme::Loop, _) => {
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].into_iter().zip(vertices.iter().map(|&v| of(v))).collect()
        }
        (_, 4) => {
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].into_iter().zip(vertices.iter().map(|&v| of(v))).collect()
        }
        (Scheme::Bilinear, _) => vec![([0.0, 0.0], Cause::Regular)],
        _ => vec![([0.0, 0.0], of(vertices[at.subface as usize])), ([1.0, 1.0], Cause::Extraordinary)],
    };
    let distance = |p: [f64; 2]| {
        let (du, dv) = (at.u - p[0], at.v - p[1]);
        let skew = if scheme == Scheme::Loop { du + dv } else { 0.0 };
        du.abs().max(dv.abs()).max(skew.abs())
    };
    let least = corner_places.iter().map(|(p, _)| distance(*p)).fold(f64::MAX, f64::min);
    corner_places.iter().filter(|(p, _)| distance(*p) == least).map(|&(_, c)| c).max().expect("a corner")
}
