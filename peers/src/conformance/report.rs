//! The document: what was run, what agrees and to how many digits, where the two part and whom refinement goes to.

mod differences;

use super::Results;
use super::cause::Cause;
use super::channels::{RULES, rule_name};
use super::refinement::Group;
use super::tally::{Method, Quantity};
use crate::opensubdiv;
use std::fmt::Write;

/// A table of Markdown, row by row.
pub struct Table(String);

impl Table {
    pub fn new(columns: &[&str]) -> Self {
        let mut table = Self(String::new());
        table.row(columns);
        table.row(&vec!["---"; columns.len()]);
        table
    }

    pub fn row<T: AsRef<str>>(&mut self, cells: &[T]) {
        let cells: Vec<&str> = cells.iter().map(AsRef::as_ref).collect();
        self.0 += &format!("| {} |\n", cells.join(" | "));
    }
}

/// Two digits; 0 where nothing differs at all.
pub fn short(x: f64) -> String {
    if x == 0.0 { "0".into() } else { format!("{x:.1e}") }
}

/// 1234567 as 1,234,567.
pub fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().map(|g| std::str::from_utf8(g).expect("digits")).collect();
    groups.join(",")
}

pub fn text(results: &Results) -> String {
    let mut t = String::new();
    head(&mut t, results);
    refinement(&mut t, results);
    limits(&mut t, results);
    channels(&mut t, results);
    differences::write(&mut t, results);
    left_out(&mut t, results);
    faults(&mut t, results);
    t
}

fn write(t: &mut String, text: &str) {
    t.push_str(text);
}

fn head(t: &mut String, results: &Results) {
    let (version, shapes, variants) = (opensubdiv::version(), results.shapes, results.variants);
    let _ = write!(
        t,
        "# Conformance with OpenSubdiv

OpenSubdiv {version} and this library side by side, in double precision: {shapes} regression shapes of OpenSubdiv, each
under its own scheme and rules and under every other scheme and rule that makes a difference to it, {variants} meshes in
all. Written by a program, not by hand:

    cd peers
    cargo run --release -- conformance ../docs/conformance.md SHAPES

`SHAPES` is the folder `regression/shapes` of OpenSubdiv's sources (here that of version 3.6.0),
or any folder of OBJ files whose names begin with `catmark_`, `loop_` or `bilinear_`. `peers/README.md` tells what is
needed to build the program. [opensubdiv-differences.md](opensubdiv-differences.md) explains the differences that this
page measures; [from-opensubdiv.md](from-opensubdiv.md) helps to move code.

Lengths are shares of the diagonal of the control points' box.

"
    );
}

fn refinement(t: &mut String, results: &Results) {
    write(
        t,
        "## Refinement

Levels 0 to 5 (fewer where a level would have more than 60,000 faces, or 2,000,000 under a shape's own rules). Numbers of
vertices, edges and faces, their order and connectivity, holes and flags of non-manifold vertices and edges must be the
same; sharpness and positions are compared:

",
    );
    let columns = [
        "scheme",
        "boundary and other rules",
        "meshes",
        "to level 5",
        "vertices",
        "sharpness",
        "`f64`",
        "ours in `f32`",
    ];
    let mut all = Group::default();
    for (others, title) in [(false, "Under the shapes' own rules:"), (true, "Under other rules and schemes:")] {
        let mut table = Table::new(&columns);
        for ((other, scheme, rules), g) in &results.refinement.groups {
            if *other == others {
                let (meshes, deepest, vertices) = (grouped(g.meshes), grouped(g.deepest), grouped(g.vertices));
                table.row(&[
                    scheme,
                    rules,
                    &meshes,
                    &deepest,
                    &vertices,
                    &short(g.sharpness),
                    &short(g.f64),
                    &short(g.f32),
                ]);
                all.merge(g.clone());
            }
        }
        let _ = write!(t, "{title}\n\n{}\n", table.0);
    }
    let _ = write!(
        t,
        "In all {} levels with {} vertices and {} faces. Elements that do not match: {}. The largest differences are {}
in `f64` ({}) and {} between our `f32` and OpenSubdiv's `f64` ({}). Differences above
1e-14 come with fractional sharpness and Chaikin's averages, which OpenSubdiv forms in single precision.

",
        grouped(all.levels),
        grouped(all.vertices),
        grouped(all.faces),
        results.refinement.mismatches.len(),
        short(all.f64),
        all.f64_at,
        short(all.f32),
        all.f32_at,
    );
}

fn limits(t: &mut String, results: &Results) {
    write(
        t,
        "## Limit

OpenSubdiv has three ways to the limit; ours is one. Compared were

- `Limit`: `Far::PrimvarRefiner::Limit` at the vertices of levels 1, 2 and 3;
- `Far n`: `Far::PatchTable` with features isolated to level n and Gregory end caps (or B-spline ones), infinitely sharp
  patches on, legacy sharp corners off;
- `Bfr a/b`: `Bfr::Surface<double>` with approximation levels a at smooth and b at sharp features; 2/6 is the default,
  10/10 the finest

with `LimitSurface::eval_second`, on a grid of 5 × 5 places of each patch (at most 300 patches of a mesh) and at places
that close in on its corners, 2⁻³ to 2⁻⁹ away. Rows tell what the place is at, or nearest to. Cells give the largest
difference; where some places differ by more than rounding, their share stands behind it. Normals are in degrees;
derivatives are relative to the largest one. What is undefined on either side is left out: normals at cones and where
they depend on the direction, derivatives at extraordinary vertices.

",
    );
    for quantity in Quantity::ALL {
        let methods: Vec<Method> =
            Method::ALL.into_iter().filter(|&m| m != Method::Limit || quantity <= Quantity::Normal).collect();
        let names: Vec<String> = methods.iter().map(|m| m.name()).collect();
        let mut columns = vec![quantity.name(), "places"];
        columns.extend(names.iter().map(String::as_str));
        let mut table = Table::new(&columns);
        for cause in Cause::ALL {
            let tallies: Vec<_> = methods.iter().map(|&m| results.tallies.0.get(&(cause, m, quantity))).collect();
            if tallies.iter().all(Option::is_none) {
                continue;
            }
            let cell = |tally: &Option<&super::tally::Tally>| match tally {
                None => "–".to_string(),
                Some(y) if y.differing == 0 => short(y.agreeing),
                Some(y) => {
                    let share = 100.0 * y.differing as f64 / y.samples as f64;
                    format!("**{}** {}", short(y.worst), percent(share))
                }
            };
            let places: usize = tallies.iter().flatten().map(|y| y.samples).sum();
            let mut row = vec![cause.name().to_string(), grouped(places)];
            row.extend(tallies.iter().map(cell));
            table.row(&row);
        }
        let _ = writeln!(t, "{}", table.0);
    }
}

fn percent(share: f64) -> String {
    if share < 1.0 { "(< 1 %)".into() } else { format!("({share:.0} %)") }
}

fn channels(t: &mut String, results: &Results) {
    write(
        t,
        "## Face-varying values

Texture coordinates of the shapes that have them, under the six rules, compared at face corners (so that it does not
matter how values are numbered) on levels 1 to 4, as far as there are 100,000 corners. `LimitFaceVarying` on level 2
forms its sums with weights in single precision. Where it is off by more than that (for the reasons given below for
vertices; under bilinear subdivision because it rounds creases that refinement keeps), level 7, or the finest below it
that was refined, says who is right, past the end of all semi-sharpness: the last three columns.

",
    );
    let columns = [
        "scheme",
        "rule",
        "meshes",
        "face corners",
        "refined",
        "… with fractions",
        "limits",
        "agree to",
        "differ",
        "by",
        "judged",
        "ours off",
        "OpenSubdiv off",
    ];
    let mut table = Table::new(&columns);
    for ((scheme, rule), g) in &results.channels.groups {
        table.row(&[
            scheme.clone(),
            rule_name(RULES[*rule]).to_string(),
            grouped(g.meshes),
            grouped(g.corners),
            short(g.worst),
            short(g.worst_fraction),
            grouped(g.limits),
            short(g.limits_agreeing),
            grouped(g.limits_differing),
            short(g.limits_apart),
            grouped(g.limits_judged),
            short(g.ours_off),
            short(g.theirs_off),
        ]);
    }
    let _ = writeln!(t, "{}", table.0);
    let known = &results.channels.one_for_two;
    if !known.is_empty() {
        let _ = write!(
            t,
            "Left out of the table are {} meshes with values that alternate round a vertex (a, b, a, b), which OpenSubdiv counts
wrongly: it keeps a, whose faces do not hang together, sharp, and rounds b, whose faces do not either. Here both are sharp.
Only the rule \"none\" shows it ({}).

",
            known.len(),
            distinct(known)
        );
    }
}

/// Every name once.
fn distinct(names: &[String]) -> String {
    let names: std::collections::BTreeSet<&str> = names.iter().map(String::as_str).collect();
    names.into_iter().collect::<Vec<_>>().join(", ")
}

fn left_out(t: &mut String, results: &Results) {
    let extrapolates = &results.refinement.extrapolates;
    let names: Vec<String> = extrapolates.iter().map(|(name, level)| format!("{name} (level {level})")).collect();
    let chaikin = if names.is_empty() {
        "None of the meshes has the case in which Chaikin's rule makes OpenSubdiv extrapolate.".to_string()
    } else {
        format!("Levels in which Chaikin's rule makes OpenSubdiv extrapolate, and their limits: {}.", distinct(&names))
    };
    let _ = write!(
        t,
        "## Not run

- OpenSubdiv in single precision, its stencil tables, its GPU evaluators; legacy Gregory patches; single-crease patches,
  whose sharpness `Far::PatchTable::EvaluateBasis` does not take.
- {chaikin}
- `Limit` with tangents of meshes where a vertex has more faces than any vertex has edges, as on an edge of many faces:
  OpenSubdiv writes beyond its buffers there ({}).
- Judging by refinement where several edges join the same two vertices (a face that passes one edge twice), normals where
  the surface is folded flat, and limits of large meshes beyond level 1 (more than 6,000 vertices).

",
        distinct(&results.not_run)
    );
}

fn faults(t: &mut String, results: &Results) {
    let faults = results.faults();
    let _ = write!(
        t,
        "## Faults\n\nElements that do not match, samples where one side has a surface and the other none, places where refinement \
         goes to OpenSubdiv's value rather than ours: {}.\n",
        if faults.is_empty() { "none".into() } else { faults.len().to_string() }
    );
    faults.iter().for_each(|fault| {
        let _ = writeln!(t, "- {fault}");
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_grouped() {
        assert_eq!((short(0.0), short(1.26e-16)), ("0".into(), "1.3e-16".into()));
        assert_eq!(
            (grouped(0), grouped(999), grouped(1000), grouped(12345678)),
            ("0".into(), "999".into(), "1,000".into(), "12,345,678".into())
        );
    }
}
