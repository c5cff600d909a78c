//! `subsurf info`: what is in a control mesh.

mod census;

use crate::args::{BOUNDARIES, CREASINGS, Common, FACE_VARYINGS, MeshArgs, SCHEMES, TRIANGLES, TriangleRule, word};
use crate::baseline::{BaselineArgs, BaselineFacts};
use crate::console::{Console, heading, print, print_json};
use crate::failure::{Bytes, Failure};
use crate::input::Input;
use census::Census;
use clap::Args;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;
use subsurf::{Level, MeshError, Method, PatchTable, Rules, Scheme, TableSize, Topology};

const EXAMPLES: &str = "\
Examples:
  subsurf info spot.obj                    for reading
  subsurf info spot.obj --json | jq .edges      for scripts
  subsurf info open.obj --boundary none    under other rules
  subsurf info car.obj --baseline feature-adaptive     beside the patches of feature-adaptive refinement

Valence counts edges; vertices on non-manifold edges are left out. Vertices and faces in warnings count from 0.";

/// Say what a control mesh holds and what its surface needs
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct InfoArgs {
    #[command(flatten)]
    mesh: MeshArgs,
    #[command(flatten)]
    rule: TriangleRule,
    #[command(flatten)]
    baseline: BaselineArgs,
}

/// Runs the verb.
pub fn run(args: &InfoArgs, common: &Common, console: &Console) -> Result<(), Failure> {
    let input = Input::load(&args.mesh, args.rule.triangles, console)?;
    let facts = |topology: &Topology, size: Option<TableSize>| -> Result<Facts<'_>, Failure> {
        Ok(Facts {
            name: &input.name,
            scheme: input.scheme,
            census: Census::new(&input.scene, topology, input.scheme),
            rules: *topology.rules(),
            size,
            baseline: args.baseline.refine(topology, &input)?.as_ref().map(BaselineFacts::new),
        })
    };
    let facts = match PatchTable::with_method(&input.scene.mesh, input.scheme, Method::default()) {
        Ok(table) => facts(table.topology(), Some(table.size()))?,
        Err(error @ (MeshError::TooLarge { .. } | MeshError::PoleTooLarge { .. })) => {
            // The rest can still be told, and may say why.
            console.warn(&format_args!("{}: there is no patch table: {error}", input.name));
            let level = Level::new(&input.scene.mesh, input.scheme).map_err(|e| input.mesh_error(e))?;
            facts(level.topology(), None)?
        }
        Err(error) => return Err(input.mesh_error(error)),
    };
    if common.json { print_json(&facts.json()) } else { print(&facts.text()) }
}

/// Everything that is shown.
struct Facts<'a> {
    name: &'a str,
    scheme: Scheme,
    census: Census,
    rules: Rules,
    /// None where the mesh is too large for a patch table.
    size: Option<TableSize>,
    /// None where it was not asked for.
    baseline: Option<BaselineFacts>,
}

/// How often each number occurs.
pub type Histogram = BTreeMap<usize, usize>;

impl Facts<'_> {
    fn scheme(&self) -> &'static str {
        word(SCHEMES, self.scheme)
    }

    fn json(&self) -> Value {
        let Self { census: c, rules, .. } = self;
        let histogram = |h: &Histogram| -> Value { h.iter().map(|(k, n)| (k.to_string(), json!(n))).collect() };
        let sharpness = |s: &census::Sharpness| json!({ "count": s.count, "infinite": s.infinite, "min": s.range.map(|r| r[0]), "max": s.range.map(|r| r[1]) });
        json!({
            "file": self.name,
            "scheme": self.scheme(),
            "faces": c.faces,
            "vertices": c.vertices,
            "edges": c.edges,
            "sides": histogram(&c.sides),
            "valences": { "interior": histogram(&c.interior), "boundary": histogram(&c.boundary) },
            "extraordinary_vertices": c.extraordinary,
            "boundary_edges": c.boundary_edges,
            "boundary_loops": c.boundary_loops,
            "components": c.components,
            "isolated_vertices": c.isolated,
            "euler_characteristic": c.euler,
            "creases": sharpness(&c.creases),
            "corners": sharpness(&c.corners),
            "holes": { "tagged": c.tagged_holes, "in_force": c.holes },
            "rules": {
                "boundary": word(BOUNDARIES, rules.boundary),
                "creasing": word(CREASINGS, rules.creasing),
                "face_varying": word(FACE_VARYINGS, rules.face_varying),
                "triangles": word(TRIANGLES, rules.triangles),
            },
            "channels": {
                "texture_coordinates": c.texture.map(|t| json!({ "values": t.values, "seam_edges": t.seam_edges })),
                "normals": c.normals,
            },
            "non_manifold_edges": c.non_manifold_edges,
            "non_manifold_vertices": c.non_manifold_vertices,
            "winding_conflicts": c.winding_conflicts,
            "degenerate_edges": c.degenerate_edges,
            "patches": self.size.map(|s| s.patches),
            "regular_patches": self.size.map(|s| s.regular_patches),
            "plans": self.size.map(|s| s.plans),
            "regular_plans": self.size.map(|s| s.regular_plans),
            "special_vertices": self.size.map(|s| s.special_vertices),
            "table_bytes": self.size.as_ref().map(table_bytes),
            "table_bytes_of": self.size.map(|s| {
                json!({ "patches": s.patch_bytes, "plans": s.plan_bytes, "topology": s.topology_bytes })
            }),
            "baseline": self.baseline.as_ref().map(BaselineFacts::json),
            "bounding_box": { "min": c.bounds[0], "max": c.bounds[1] },
        })
    }

    fn text(&self) -> String {
        let Self { census: c, rules, .. } = self;
        let mut page = Page(format!("{}\n", heading(self.name)));
        page.row("faces", c.faces, &sides(&c.sides));
        page.row("vertices", c.vertices, &counted(c.isolated, "without faces"));
        page.row("edges", c.edges, "");
        page.row("components", c.components, &format!("Euler characteristic {}", c.euler));
        let loops = if c.boundary_loops == 1 { "loop" } else { "loops" };
        page.row("boundary edges", c.boundary_edges, &counted(c.boundary_loops, loops));
        page.line("bounding box", &extent(c.bounds));
        page.section("Valence");
        page.line("interior", &histogram(&c.interior));
        page.line("boundary", &histogram(&c.boundary));
        let ordinary = match self.scheme {
            Scheme::Loop => Some("not 6 inside, not 4 on the boundary (or 2 at a corner)"),
            Scheme::Bilinear => None,
            _ => Some("not 4 inside, not 3 on the boundary (or 2 at a corner)"),
        };
        if let Some(ordinary) = ordinary {
            page.row("extraordinary", c.extraordinary, ordinary);
        }
        page.section("Tags");
        page.row("creases", c.creases.count, &c.creases.describe());
        page.row("corners", c.corners.count, &c.corners.describe());
        page.row("holes", c.holes, &counted(c.holes - c.tagged_holes, "by the boundary rule"));
        page.line("scheme", self.scheme());
        page.line(
            "rules",
            &format!(
                "boundary {}, creasing {}, triangles {}, face-varying {}",
                word(BOUNDARIES, rules.boundary),
                word(CREASINGS, rules.creasing),
                word(TRIANGLES, rules.triangles),
                word(FACE_VARYINGS, rules.face_varying)
            ),
        );
        page.section("Channels");
        match c.texture {
            None => page.line("texture", "none"),
            Some(t) => {
                let edges = if t.seam_edges == 1 { "edge" } else { "edges" };
                page.row("texture", t.values, &format!("values, {} seam {edges}", t.seam_edges));
            }
        }
        match c.normals {
            None => page.line("normals", "none"),
            Some(values) => page.row("normals", values, "values (not used by the surface)"),
        }
        page.section("Problems");
        page.row("non-manifold", c.non_manifold_edges, &format!("edges, {} vertices", c.non_manifold_vertices));
        page.row("winding", c.winding_conflicts, "edges between faces of opposite winding");
        if c.degenerate_edges > 0 {
            page.row("degenerate", c.degenerate_edges, "edges with equal ends");
        }
        if let Some(size) = &self.size {
            page.section("Patch table");
            let kinds = match self.scheme {
                Scheme::Loop => format!("{} of them one quartic patch", size.regular_patches),
                Scheme::Bilinear => "bilinear".to_owned(),
                _ => format!("{} of them one bicubic patch", size.regular_patches),
            };
            page.row("patches", size.patches, &kinds);
            page.row(
                "plans",
                size.plans,
                &format!("distinct, for {} kinds of special vertices", size.special_vertices),
            );
            page.line(
                "memory",
                &format!(
                    "{} (patches {}, plans {}, topology {})",
                    Bytes(table_bytes(size) as u64),
                    Bytes(size.patch_bytes as u64),
                    Bytes(size.plan_bytes as u64),
                    Bytes(size.topology_bytes as u64)
                ),
            );
        }
        if let Some(baseline) = &self.baseline {
            page.section("Baseline");
            for (label, count, text) in baseline.lines() {
                match count {
                    Some(count) => page.row(label, count, &text),
                    None => page.line(label, &text),
                }
            }
        }
        page.0
    }
}

fn table_bytes(size: &TableSize) -> usize {
    size.patch_bytes + size.plan_bytes + size.topology_bytes
}

/// Aligned lines.
struct Page(String);

impl Page {
    fn section(&mut self, title: &str) {
        let _ = writeln!(self.0, "\n{}", heading(title));
    }

    fn line(&mut self, label: &str, text: &str) {
        let _ = writeln!(self.0, "  {label:<15} {text}");
    }

    fn row(&mut self, label: &str, count: usize, text: &str) {
        let line = format!("  {label:<15} {count:>8}  {text}");
        let _ = writeln!(self.0, "{}", line.trim_end());
    }
}

fn counted(count: usize, what: &str) -> String {
    if count == 0 { String::new() } else { format!("{count} {what}") }
}

fn sides(histogram: &Histogram) -> String {
    let name = |(&sides, &count): (&usize, &usize)| {
        let plural = if count == 1 { "" } else { "s" };
        match sides {
            3 => format!("{count} triangle{plural}"),
            4 => format!("{count} quad{plural}"),
            _ => format!("{count} of {sides} sides"),
        }
    };
    histogram.iter().map(name).collect::<Vec<_>>().join(", ")
}

fn histogram(histogram: &Histogram) -> String {
    if histogram.is_empty() {
        return "none".to_owned();
    }
    histogram.iter().map(|(value, count)| format!("{value}: {count}")).collect::<Vec<_>>().join(", ")
}

fn extent([lower, upper]: [[f64; 3]; 2]) -> String {
    let point =
        |p: [f64; 3]| p.map(|x| format!("{x:.6}").trim_end_matches('0').trim_end_matches('.').to_owned()).join(", ");
    format!("({}) to ({})", point(lower), point(upper))
}
