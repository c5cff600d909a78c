//! Levels 0 to 5 of every variant, element by element.

use super::variants::{Variant, scheme_name};
use crate::compare_refine::{self, compare, first_extrapolation, view};
use crate::opensubdiv::{self, OsdLevel, VertexOrder};
use std::collections::BTreeMap;

const LEVELS: u32 = 5;
/// Faces of the finest level compared, for shapes under their own rules and under others.
const MOST_FACES: [usize; 2] = [2_000_000, 60_000];

/// What was compared under one scheme and set of rules, and how far apart it was.
#[derive(Clone, Debug, Default)]
pub struct Group {
    pub meshes: usize,
    pub levels: usize,
    pub vertices: usize,
    pub faces: usize,
    /// Meshes compared to level 5.
    pub deepest: usize,
    pub sharpness: f64,
    pub f64: f64,
    pub f64_at: String,
    pub f32: f64,
    pub f32_at: String,
}

#[derive(Clone, Debug, Default)]
pub struct Refinement {
    /// By scheme and rules; own rules first.
    pub groups: BTreeMap<(bool, String, String), Group>,
    pub mismatches: Vec<String>,
    /// Variants in which OpenSubdiv extrapolates, with the level.
    pub extrapolates: Vec<(String, usize)>,
}

/// Compares one variant. True if its limits can be compared too.
///
/// # Errors
/// What OpenSubdiv says when it refuses the mesh.
pub fn run(variant: &Variant, out: &mut Refinement) -> Result<bool, String> {
    let shape = &variant.shape;
    let most = MOST_FACES[usize::from(!variant.own)];
    let faces_at = |level: u32| shape.indices.len() << (2 * (level - 1));
    let levels = (1..=LEVELS).rev().find(|&level| faces_at(level) <= most).unwrap_or(1);
    let theirs: Vec<OsdLevel> = opensubdiv::refine(shape, levels, VertexOrder::VerticesFirst)?;
    let ours = match compare_refine::refine(shape, levels) {
        Ok(ours) => ours,
        Err(message) => {
            out.mismatches.push(format!("{}: refused here: {message}", variant.name()));
            return Ok(false);
        }
    };
    let until = first_extrapolation(&theirs);
    if let Some(level) = until {
        out.extrapolates.push((variant.name(), level));
    }
    let key = (!variant.own, scheme_name(shape.scheme).to_string(), variant.rules());
    let group = out.groups.entry(key).or_default();
    group.meshes += 1;
    group.deepest += usize::from(levels == LEVELS && until.is_none());
    for (number, (theirs, ours)) in theirs.iter().zip(&ours).take(until.unwrap_or(usize::MAX)).enumerate() {
        let theirs = view(theirs);
        let d = compare(ours, &theirs, shape.diagonal());
        group.levels += 1;
        group.vertices += theirs.positions.len();
        group.faces += theirs.faces.len();
        group.sharpness = group.sharpness.max(d.sharpness);
        let place = || format!("{} level {number}", shape.name);
        if d.f64 > group.f64 {
            (group.f64, group.f64_at) = (d.f64, place());
        }
        if d.f32 > group.f32 {
            (group.f32, group.f32_at) = (d.f32, place());
        }
        out.mismatches.extend(d.mismatches.iter().map(|m| format!("{} level {number}: {m}", variant.name())));
    }
    Ok(until.is_none())
}

impl Group {
    pub fn merge(&mut self, from: Self) {
        self.meshes += from.meshes;
        self.levels += from.levels;
        self.vertices += from.vertices;
        self.faces += from.faces;
        self.deepest += from.deepest;
        self.sharpness = self.sharpness.max(from.sharpness);
        if from.f64 > self.f64 {
            (self.f64, self.f64_at) = (from.f64, from.f64_at);
        }
        if from.f32 > self.f32 {
            (self.f32, self.f32_at) = (from.f32, from.f32_at);
        }
    }
}

impl Refinement {
    pub fn merge(&mut self, other: Self) {
        for (key, from) in other.groups {
            self.groups.entry(key).or_default().merge(from);
        }
        self.mismatches.extend(other.mismatches);
        self.extrapolates.extend(other.extrapolates);
    }
}
