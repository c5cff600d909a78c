//! Face-varying values under all six rules: level by level at every face corner, so that no numbering matters, and in
//! the limit.

use super::place::places;
use super::variants::{Variant, scheme_name};
use super::vector::worse;
use crate::opensubdiv::{self, limit_channel, refine_channel, takes_one_value_for_two};
use crate::shape::Shape;
use std::collections::BTreeMap;
use subsurf::{Channel, Face, FaceVarying, Level, Location, Topology};

pub const RULES: [FaceVarying; 6] = [
    FaceVarying::None,
    FaceVarying::CornersOnly,
    FaceVarying::CornersPlus1,
    FaceVarying::CornersPlus2,
    FaceVarying::Boundaries,
    FaceVarying::All,
];

/// Levels compared, the level whose limits are, and the one that judges them.
const LEVELS: u32 = 4;
const LIMIT_LEVEL: u32 = 2;
const JUDGE_LEVEL: u32 = 7;
/// Face corners of the finest level.
const MOST_CORNERS: usize = 100_000;
/// Refined values of equal rules differ by rounding only; fractional sharpness has weights in single precision.
const BOUND: f64 = 1e-12;
const FRACTION_BOUND: f64 = 1e-7;
/// Above this two limits differ.
const LIMIT_BOUND: f64 = 1e-7;

#[derive(Clone, Debug, Default)]
pub struct Group {
    pub meshes: usize,
    pub corners: usize,
    /// As a share of the diagonal of the values' box.
    pub worst: f64,
    pub worst_fraction: f64,
    pub limits: usize,
    pub limits_agreeing: f64,
    pub limits_differing: usize,
    pub limits_apart: f64,
    pub limits_judged: usize,
    pub ours_off: f64,
    pub theirs_off: f64,
}

#[derive(Clone, Debug, Default)]
pub struct Channels {
    pub groups: BTreeMap<(String, usize), Group>,
    pub faults: Vec<String>,
    /// Shapes with a value that OpenSubdiv takes for two, once for every variant that shows it.
    pub one_for_two: Vec<String>,
}

pub fn rule_name(rule: FaceVarying) -> &'static str {
    match rule {
        FaceVarying::None => "none",
        FaceVarying::CornersOnly => "corners-only",
        FaceVarying::CornersPlus1 => "corners-plus-1",
        FaceVarying::CornersPlus2 => "corners-plus-2",
        FaceVarying::Boundaries => "boundaries",
        FaceVarying::All => "all",
    }
}

/// Compares all rules on one variant; shapes without texture coordinates are left out.
///
/// # Errors
/// What either side says when it refuses the mesh or the channel.
pub fn run(variant: &Variant, out: &mut Channels) -> Result<(), String> {
    if variant.shape.channel.is_none() {
        return Ok(());
    }
    for (number, rule) in RULES.into_iter().enumerate() {
        let mut shape = variant.shape.clone();
        shape.tags.rules.face_varying = rule;
        let key = (scheme_name(shape.scheme).to_string(), number);
        let name = format!("{}, face-varying {}", variant.name(), rule_name(rule));
        let (mut group, mut faults) = (Group::default(), vec![]);
        compare(&shape, &name, &mut group, &mut faults)?;
        if !faults.is_empty() && takes_one_value_for_two(&shape)? {
            out.one_for_two.push(shape.name);
            continue;
        }
        out.groups.entry(key).or_default().merge(group);
        out.faults.extend(faults);
    }
    Ok(())
}

fn compare(shape: &Shape, name: &str, group: &mut Group, faults: &mut Vec<String>) -> Result<(), String> {
    let given = shape.channel.as_ref().expect("a channel");
    let corners_at = |level: u32| (4 * shape.indices.len()) << (2 * (level - 1));
    let most = |from: u32| (1..=from).rev().find(|&level| corners_at(level) <= MOST_CORNERS).unwrap_or(1);
    let theirs = refine_channel(shape, most(JUDGE_LEVEL))?;
    let topology = mesh_topology(shape)?;
    let rule = shape.tags.rules.face_varying;
    let channel = Channel::face_varying(&topology, shape.our_scheme(), given.values.len(), &given.indices, rule)
        .map_err(|e| e.to_string())?;
    let diagonal = diagonal(&given.values);
    group.meshes += 1;

    let fractions = super::limits::has_fractions(shape);
    let mut values = channel.rows(&given.values).into_owned();
    let mut level = channel.level();
    for theirs in &theirs[1..=most(LEVELS) as usize] {
        values = level.refine_values(&values);
        level = level.refine().map_err(|e| e.to_string())?;
        let ours = at_corners(&level, &values);
        let theirs = theirs.at_corners();
        let far = ours.iter().zip(&theirs).map(|(a, b)| apart(a, b) / diagonal);
        let farthest = far.enumerate().fold((0, 0.0), |a, b| if b.1 > a.1 || b.1.is_nan() { b } else { a });
        let (corner, worst) = farthest;
        let (slot, bound) =
            if fractions { (&mut group.worst_fraction, FRACTION_BOUND) } else { (&mut group.worst, BOUND) };
        *slot = worse(*slot, worst);
        group.corners += ours.len();
        if worst.is_nan() || worst > bound || ours.len() != theirs.len() {
            let (a, b) = (ours.get(corner), theirs.get(corner));
            faults.push(format!("{name}, level {} corner {corner}: ours {a:?}, theirs {b:?}", level.depth()));
            return Ok(());
        }
    }
    limits(shape, name, &channel, &theirs, diagonal, group, faults)
}

/// `LimitFaceVarying` at level 2 against ours; where they differ, the finest level says whom it goes to.
fn limits(
    shape: &Shape,
    name: &str,
    channel: &Channel,
    levels: &[opensubdiv::ChannelLevel],
    diagonal: f64,
    group: &mut Group,
    faults: &mut Vec<String>,
) -> Result<(), String> {
    if levels.len() <= LIMIT_LEVEL as usize {
        return Ok(());
    }
    let given = shape.channel.as_ref().expect("a channel");
    let table = channel.patch_table().map_err(|e| e.to_string())?;
    let rows = channel.rows(&given.values);
    let surface = table.surface(&rows);
    let limit = limit_channel(shape, LIMIT_LEVEL)?;
    let at = &levels[LIMIT_LEVEL as usize];
    let sides = if shape.scheme == crate::shape::Scheme::Loop { 3 } else { 4 };
    let faces = places(shape, LIMIT_LEVEL).pop().expect("a level");
    let finest = levels.len() as u32 - 1;
    let last = levels[finest as usize].at_corners();
    // Until sharpness is gone, refinement does not head for the limit.
    let tags = &shape.tags;
    let sharpness = tags.creases.iter().map(|c| c.sharpness).chain(tags.corners.iter().map(|c| c.sharpness));
    let decayed = sharpness.filter(|&s| s < 10.0).fold(0.0, f64::max) + 1.0 <= f64::from(finest);
    for (f, place) in faces.iter().enumerate() {
        for corner in 0..sides {
            let [u, v] = place.corners[corner];
            let location = Location { face: Face(place.face), subface: place.subface, u, v };
            let Some(ours) = surface.position(location) else { continue };
            let theirs = limit[at.indices[sides * f + corner] as usize];
            let far = apart(&ours, &theirs) / diagonal;
            group.limits += 1;
            if far <= LIMIT_BOUND {
                group.limits_agreeing = group.limits_agreeing.max(far);
                continue;
            }
            group.limits_differing += 1;
            group.limits_apart = worse(group.limits_apart, far);
            if !decayed && !far.is_nan() {
                continue;
            }
            group.limits_judged += 1;
            // The child at the same corner, level after level.
            let child = (LIMIT_LEVEL..finest).fold(f, |f, _| 4 * f + corner);
            let deep = last[sides * child + corner];
            let (ours_off, theirs_off) = (apart(&ours, &deep) / diagonal, apart(&theirs, &deep) / diagonal);
            group.ours_off = worse(group.ours_off, ours_off);
            group.theirs_off = worse(group.theirs_off, theirs_off);
            if ours_off.is_nan() || ours_off > theirs_off {
                faults.push(format!(
                    "{name}, limit at face {f} corner {corner}: off by {ours_off:.1e}, {theirs_off:.1e}"
                ));
            }
        }
    }
    Ok(())
}

/// The mesh as the refiner sees it.
fn mesh_topology(shape: &Shape) -> Result<Topology, String> {
    Ok(Level::new(&shape.mesh()?, shape.our_scheme()).map_err(|e| e.to_string())?.topology().clone())
}

fn at_corners(level: &Level, values: &[[f64; 2]]) -> Vec<[f64; 2]> {
    level.topology().corners().iter().map(|&v| values[v as usize]).collect()
}

fn apart(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn diagonal(values: &[[f64; 2]]) -> f64 {
    let side = |k: usize| {
        let axis = || values.iter().map(|v| v[k]);
        axis().fold(f64::MIN, f64::max) - axis().fold(f64::MAX, f64::min)
    };
    side(0).hypot(side(1)).max(f64::MIN_POSITIVE)
}

impl Group {
    fn merge(&mut self, from: Self) {
        self.meshes += from.meshes;
        self.corners += from.corners;
        self.limits += from.limits;
        self.limits_differing += from.limits_differing;
        self.limits_judged += from.limits_judged;
        for (to, from) in [
            (&mut self.worst, from.worst),
            (&mut self.worst_fraction, from.worst_fraction),
            (&mut self.limits_agreeing, from.limits_agreeing),
            (&mut self.limits_apart, from.limits_apart),
            (&mut self.ours_off, from.ours_off),
            (&mut self.theirs_off, from.theirs_off),
        ] {
            *to = worse(*to, from);
        }
    }
}

impl Channels {
    pub fn merge(&mut self, other: Self) {
        for (key, from) in other.groups {
            self.groups.entry(key).or_default().merge(from);
        }
        self.one_for_two.extend(other.one_for_two);
        self.faults.extend(other.faults);
    }
}
