//! Counting differences: by cause, by way of evaluation, by quantity.

use super::cause::Cause;
use super::vector::{angle_deg, cross, length, sub, unit, worse};
use super::witness::Witness;
use std::collections::BTreeMap;

/// Where OpenSubdiv's value comes from.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Method {
    /// `Far::PrimvarRefiner::Limit` at the vertices of levels 1 to 3.
    Limit,
    /// `Far::PatchTable`, features isolated to this level, Gregory end caps.
    Far(u32),
    /// The same with B-spline end caps.
    FarBSpline(u32),
    /// `Bfr::Surface`, approximation levels at smooth and sharp features.
    Bfr(u32, u32),
}

impl Method {
    pub const ALL: [Self; 7] = [
        Self::Limit,
        Self::Far(4),
        Self::Far(6),
        Self::Far(8),
        Self::FarBSpline(6),
        Self::Bfr(2, 6),
        Self::Bfr(10, 10),
    ];

    pub fn name(self) -> String {
        match self {
            Self::Limit => "Limit".into(),
            Self::Far(level) => format!("Far {level}"),
            Self::FarBSpline(level) => format!("Far {level}, B-spline"),
            Self::Bfr(smooth, sharp) => format!("Bfr {smooth}/{sharp}"),
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Quantity {
    /// As a share of the control points' box diagonal.
    Position,
    /// In degrees.
    Normal,
    /// Relative to the larger first derivative.
    First,
    /// Relative to the largest second derivative.
    Second,
}

impl Quantity {
    pub const ALL: [Self; 4] = [Self::Position, Self::Normal, Self::First, Self::Second];

    pub fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Normal => "normal",
            Self::First => "first derivatives",
            Self::Second => "second derivatives",
        }
    }

    /// Above this the two differ. Weights of fractional sharpness are rounded to single precision in OpenSubdiv.
    pub fn threshold(self, fractions: bool) -> f64 {
        match (self, fractions) {
            (Self::Position, false) => 1e-11,
            (Self::Position, true) => 1e-7,
            (Self::Normal, false) => 1e-5,
            (Self::Normal, true) => 1e-3,
            (Self::First, false) => 1e-8,
            (Self::First, true) => 1e-6,
            (Self::Second, false) => 1e-6,
            (Self::Second, true) => 1e-5,
        }
    }

    /// What the witness itself may be off by, and its sharpness in single precision.
    fn slack(self, fractions: bool) -> f64 {
        let exact: f64 = match self {
            Self::Position => 1e-12,
            Self::Normal => 1e-6,
            Self::First => 1e-6,
            Self::Second => 1e-3,
        };
        if fractions { exact.max(self.threshold(true)) } else { exact }
    }
}

/// Derivatives shorter than this share of the diagonal are rounding: of faces folded into a point, say.
const NOTHING: f64 = 1e-6;

/// A point of a surface as either side gives it.
#[derive(Clone, Copy, Debug)]
pub struct Value {
    pub position: [f64; 3],
    pub normal: Option<[f64; 3]>,
    pub first: Option<[[f64; 3]; 2]>,
    pub second: Option<[[f64; 3]; 3]>,
}

impl Value {
    /// Two values' distance in one quantity; none where one of them has none.
    pub fn apart(&self, other: &Self, quantity: Quantity, diagonal: f64) -> Option<f64> {
        let rows = |a: &[[f64; 3]], b: &[[f64; 3]]| {
            let size = a.iter().chain(b).map(|&x| length(x)).fold(NOTHING * diagonal, f64::max);
            a.iter().zip(b).map(|(&a, &b)| length(sub(a, b))).fold(0.0, worse) / size
        };
        match quantity {
            Quantity::Position => Some(length(sub(self.position, other.position)) / diagonal),
            Quantity::Normal => Some(angle_deg(self.normal?, other.normal?)),
            Quantity::First => Some(rows(&self.first?, &other.first?)),
            Quantity::Second => {
                let far = rows(&self.second?, &other.second?);
                // Where the surface is all but flat the second derivatives are rounding.
                let size = |v: &[[f64; 3]]| v.iter().map(|&x| length(x)).fold(0.0, f64::max);
                let (second, first) = (size(&self.second?).max(size(&other.second?)), size(&self.first?));
                Some(far * (second / second.max(1e-3 * first).max(NOTHING * diagonal)))
            }
        }
    }

    /// The same with second derivatives of the other sign.
    pub fn negated(&self) -> Self {
        Self { second: self.second.map(|rows| rows.map(|row| row.map(|x| -x))), ..*self }
    }

    /// The distance to what refinement gives.
    pub fn off_witness(&self, witness: &Witness, quantity: Quantity, diagonal: f64) -> Option<f64> {
        let relative = |ours: [[f64; 3]; 2], truth: [[f64; 3]; 2], least: f64| {
            let size = truth.iter().map(|&x| length(x)).fold(least.max(NOTHING * diagonal), f64::max);
            ours.iter().zip(truth).map(|(&a, b)| length(sub(a, b))).fold(0.0, worse) / size
        };
        match quantity {
            Quantity::Position => Some(length(sub(self.position, witness.limit())) / diagonal),
            Quantity::Normal => Some(angle_deg(self.normal?, witness.normal()?)),
            Quantity::First => {
                let [du, dv] = self.first?;
                let along = witness.along?;
                let ours = along.map(|a| [0, 1, 2].map(|k| a.direction[0] * du[k] + a.direction[1] * dv[k]));
                Some(relative(ours, along.map(|a| a.first), 0.0))
            }
            Quantity::Second => {
                let [uu, uv, vv] = self.second?;
                let along = witness.along?;
                let ours = along.map(|a| {
                    let [x, y] = a.direction;
                    [0, 1, 2].map(|k| x * x * uu[k] + 2.0 * x * y * uv[k] + y * y * vv[k])
                });
                let flat = 1e-3 * length(along[0].first).max(length(along[1].first));
                Some(relative(ours, along.map(|a| a.second), flat))
            }
        }
    }
}

/// From two tangents; none where one is rounding beside the other (a surface folded flat), or both are parallel.
pub fn normal([a, b]: [[f64; 3]; 2]) -> Option<[f64; 3]> {
    let (short, long) = (length(a).min(length(b)), length(a).max(length(b)));
    if short < 1e-10 * long {
        return None;
    }
    let (a, b) = (unit(a)?, unit(b)?);
    let n = cross(a, b);
    if length(n) > 1e-10 { unit(n) } else { None }
}

/// A place that was judged, for the report's tables of convergence.
#[derive(Clone, Debug)]
pub struct Case {
    pub place: String,
    pub own: bool,
    pub diagonal: f64,
    pub fractions: bool,
    pub difference: f64,
    pub ours: Value,
    pub theirs: Value,
    pub witness: Witness,
}

#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub samples: usize,
    /// The largest difference that does not count as one; of meshes without fractions as well.
    pub agreeing: f64,
    pub agreeing_exactly: f64,
    pub differing: usize,
    pub worst: f64,
    pub judged: usize,
    /// Farthest from refinement, among the judged.
    pub ours_off: f64,
    pub theirs_off: f64,
    /// Where refinement is nearer to OpenSubdiv.
    pub lost: Vec<String>,
    pub case: Option<Case>,
    /// Where refinement ended farthest from ours, and how far.
    pub slowest: Option<(f64, Case)>,
}

impl Tally {
    pub fn merge(&mut self, from: Self) {
        self.samples += from.samples;
        self.differing += from.differing;
        self.judged += from.judged;
        self.agreeing = self.agreeing.max(from.agreeing);
        self.agreeing_exactly = self.agreeing_exactly.max(from.agreeing_exactly);
        self.worst = worse(self.worst, from.worst);
        self.ours_off = worse(self.ours_off, from.ours_off);
        self.theirs_off = worse(self.theirs_off, from.theirs_off);
        self.lost.extend(from.lost);
        let rank = |c: &Option<Case>| c.as_ref().map(|c| (c.own, c.difference));
        if rank(&from.case) > rank(&self.case) {
            self.case = from.case;
        }
        let off = |c: &Option<(f64, Case)>| c.as_ref().map(|c| c.0);
        if off(&from.slowest) > off(&self.slowest) {
            self.slowest = from.slowest;
        }
    }
}

pub type Key = (Cause, Method, Quantity);

#[derive(Clone, Debug, Default)]
pub struct Tallies(pub BTreeMap<Key, Tally>);

impl Tallies {
    pub fn add(&mut self, key: Key, apart: f64, differs: bool, fractions: bool) {
        let tally = self.0.entry(key).or_default();
        tally.samples += 1;
        if differs {
            tally.differing += 1;
            tally.worst = worse(tally.worst, apart);
        } else {
            tally.agreeing = tally.agreeing.max(apart);
            if !fractions {
                tally.agreeing_exactly = tally.agreeing_exactly.max(apart);
            }
        }
    }

    /// Takes the witness's word on a place where the two differ.
    pub fn judge(&mut self, key: Key, case: Case) {
        let quantity = key.2;
        let off = |value: &Value| value.off_witness(&case.witness, quantity, case.diagonal);
        let (Some(ours), Some(theirs)) = (off(&case.ours), off(&case.theirs)) else { return };
        let tally = self.0.entry(key).or_default();
        tally.judged += 1;
        tally.ours_off = worse(tally.ours_off, ours);
        tally.theirs_off = worse(tally.theirs_off, theirs);
        if theirs < ours - quantity.slack(case.fractions) {
            tally.lost.push(format!("{}: ours off by {ours:.2e}, theirs by {theirs:.2e}", case.place));
        }
        if tally.slowest.as_ref().is_none_or(|old| ours > old.0) {
            tally.slowest = Some((ours, case.clone()));
        }
        let better = |old: &Case| (case.own, case.difference) > (old.own, old.difference);
        if tally.case.as_ref().is_none_or(better) {
            tally.case = Some(case);
        }
    }

    pub fn merge(&mut self, other: Self) {
        for (key, from) in other.0 {
            let to = self.0.entry(key).or_default();
            to.merge(from);
        }
    }
}
