//! `peers compare-adaptive`: our feature-adaptive baseline against OpenSubdiv's, patch by patch: place, level, kind,
//! sides and sharpness; and the number of vertices by level. `peers compare-ptex`: Ptex numbers and neighbours.
//!
//! Both sides get sharpness rounded to single precision, which is what OpenSubdiv stores.

use crate::adaptive::{self, OsdPatch, PtexAdjacency};
use crate::compare_refine::round_sharpness;
use crate::random_shapes::random_shape;
use crate::shape::{Scheme, Shape, shapes};
use std::path::Path;
use subsurf::{AdaptiveKind, AdaptiveOptions, AdaptiveRefinement, ControlMesh, Face, PtexFaces, Topology};

/// All schemes.
const PREFIXES: [&str; 3] = ["catmark_", "bilinear_", "loop_"];
const ISOLATIONS: std::ops::RangeInclusive<u32> = 1..=6;

/// A patch as both sides can be brought to: Ptex face, level, position of corner 0 in units of its size, upside down,
/// kind, sides, sharpness.
type Patch = (u32, u32, [i64; 2], bool, AdaptiveKind, u8, f32);

/// All regression shapes, isolation levels 1 to 6, with and without single-crease patches.
pub fn regression_shapes(models: &Path) -> Result<(), String> {
    run(shapes(models, &PREFIXES)?.into_iter(), ISOLATIONS)
}

/// Any files.
pub fn files(isolation: u32, paths: &[&str]) -> Result<(), String> {
    let shapes: Result<Vec<Shape>, String> = paths.iter().map(|path| Shape::read(Path::new(path))).collect();
    run(shapes?.into_iter(), 1..=isolation)
}

/// Compares every shape; says what differs.
pub fn run(shapes: impl Iterator<Item = Shape>, isolations: std::ops::RangeInclusive<u32>) -> Result<(), String> {
    println!("{:32} level single   regular  boundary  s-crease   end cap  vertices", "shape");
    let (mut failures, mut tables, mut total) = (0, 0, 0);
    for shape in shapes.map(round_sharpness) {
        for isolation in isolations.clone() {
            for single_crease in [false, true] {
                let ours = ours(&shape, AdaptiveOptions { isolation, single_crease })?;
                let theirs = adaptive::refine(&shape, isolation, single_crease)?;
                let mut found = ours.patches().map(|p| of_ours(&ours, &p)).collect::<Vec<_>>();
                let mut expected: Vec<Patch> =
                    theirs.patches.iter().map(|p| of_theirs(p, shape.scheme, single_crease)).collect();
                sort(&mut found);
                sort(&mut expected);
                let differs = found != expected || ours.vertices() != theirs.vertices;
                let mut kinds = [0; 4];
                ours.counts().iter().for_each(|level| (0..4).for_each(|k| kinds[k] += level[k]));
                println!(
                    "{:32} {isolation:5} {:6} {:9} {:9} {:9} {:9} {:9}{}",
                    shape.name,
                    if single_crease { "yes" } else { "no" },
                    kinds[0],
                    kinds[1],
                    kinds[2],
                    kinds[3],
                    ours.vertices().iter().sum::<usize>(),
                    if differs { "  FAILED" } else { "" }
                );
                if differs {
                    tell(&found, &expected, ours.vertices(), &theirs.vertices);
                    failures += 1;
                }
                tables += 1;
                total += found.len();
            }
        }
    }
    println!("{tables} tables, {total} patches");
    if failures == 0 { Ok(()) } else { Err(format!("{failures} tables differ")) }
}

fn sort(patches: &mut [Patch]) {
    patches.sort_by(|a, b| a.partial_cmp(b).expect("sharpness is a number"));
}

fn tell(found: &[Patch], expected: &[Patch], ours: &[usize], theirs: &[usize]) {
    if ours != theirs {
        println!("    vertices by level: ours {ours:?}, theirs {theirs:?}");
    }
    println!("    patches: ours {}, theirs {}", found.len(), expected.len());
    let only = |a: &[Patch], b: &[Patch]| a.iter().find(|p| !b.contains(p)).copied();
    if let Some(patch) = only(found, expected) {
        println!("    only ours: {patch:?}");
    }
    if let Some(patch) = only(expected, found) {
        println!("    only theirs: {patch:?}");
    }
}

fn of_ours(table: &AdaptiveRefinement, p: &subsurf::AdaptivePatch) -> Patch {
    let unit = |x: f64| (x / p.size.abs()).round() as i64;
    let id = table.ptex_faces().id(p.face, p.subface);
    (id, p.level, [unit(p.u), unit(p.v)], p.size < 0.0, p.kind, p.sides, p.sharpness as f32)
}

fn of_theirs(p: &OsdPatch, scheme: Scheme, single_crease: bool) -> Patch {
    let turned = scheme == Scheme::Loop && p.u + p.v >= 1 << p.depth;
    let from = |x: i32| i64::from(if turned { (1 << p.depth) - x } else { x });
    // A triangle's sides are packed with the corners that touch a boundary: 3 bits, and which of the two they are.
    let (lower, upper) = (p.sides & 7, p.sides >> 3);
    let sides = match scheme {
        Scheme::Loop if upper == 1 => 0,
        Scheme::Loop => lower,
        _ => p.sides,
    } as u8;
    let kind = match (p.regular != 0, p.sharpness > 0.0 && single_crease, p.sides) {
        (false, ..) => AdaptiveKind::EndCap,
        (_, true, _) => AdaptiveKind::SingleCrease,
        (_, _, 0) => AdaptiveKind::Regular,
        _ => AdaptiveKind::Boundary,
    };
    // End caps carry whatever sharpness the patch before them in the table had (`Far::PatchTableBuilder` does not
    // reset it), which nothing reads.
    let (sides, sharpness) = if kind == AdaptiveKind::EndCap { (0, 0.0) } else { (sides, p.sharpness) };
    (p.ptex_face as u32, p.depth as u32, [from(p.u), from(p.v)], turned, kind, sides, sharpness)
}

fn ours(shape: &Shape, options: AdaptiveOptions) -> Result<AdaptiveRefinement, String> {
    AdaptiveRefinement::new(&mesh(shape)?, scheme(shape), options).map_err(|e| e.to_string())
}

fn scheme(shape: &Shape) -> subsurf::Scheme {
    match shape.scheme {
        Scheme::Bilinear => subsurf::Scheme::Bilinear,
        Scheme::CatmullClark => subsurf::Scheme::CatmullClark,
        Scheme::Loop => subsurf::Scheme::Loop,
    }
}

fn mesh(shape: &Shape) -> Result<ControlMesh, String> {
    ControlMesh::from_counts(shape.positions.len(), &shape.counts, shape.indices.clone(), shape.tags.clone())
        .map_err(|e| format!("{}: {e}", shape.name))
}

/// `count` random meshes made from the small regression shapes, isolation levels 1 to 4.
pub fn random(models: &Path, count: u64, first_seed: u64) -> Result<(), String> {
    let mut models = shapes(models, &PREFIXES)?;
    models.retain(|shape| shape.counts.len() < 100);
    run((first_seed..first_seed + count).map(|seed| random_shape(&models, seed)), 1..=4)
}

/// Isolation levels whose counts are committed: one that cuts sharpness short, one that seldom does.
const COMMITTED: [u32; 2] = [2, 5];
/// Shapes with at most so many Ptex faces have their neighbours committed.
const SMALL: usize = 24;

/// OpenSubdiv's counts and neighbours for the core's tests, which read the shapes of `dump-reference`.
pub fn dump(models: &Path, out: &Path) -> Result<(), String> {
    let mut text = format!(
        "{{\"provenance\": \"OpenSubdiv {}, written by `peers dump-adaptive`; do not edit. Shapes: ../opensubdiv. \
         tables: isolation level, single-crease patches on, vertices by level, patches by level [regular, boundary, \
         single crease, end cap]; useInfSharpPatch on, generateLegacySharpCornerPatches off. ptex: per Ptex face \
         [face, edge] across its four edges, or null.\"\n,\"shapes\": [\n",
        crate::opensubdiv::version()
    );
    for (i, shape) in shapes(models, &PREFIXES)?.into_iter().map(round_sharpness).enumerate() {
        let mut tables = Vec::new();
        for (isolation, single_crease) in COMMITTED.iter().flat_map(|&l| [(l, false), (l, true)]) {
            let theirs = adaptive::refine(&shape, isolation, single_crease)?;
            let mut counts = vec![[0; 4]; theirs.vertices.len()];
            for p in &theirs.patches {
                let (_, level, _, _, kind, ..) = of_theirs(p, shape.scheme, single_crease);
                counts[level as usize][kind as usize] += 1;
            }
            tables
                .push(format!("\n  [{isolation},{single_crease},{:?},{counts:?}]", theirs.vertices).replace(", ", ","));
        }
        let (_, across) = adaptive::ptex(&shape)?;
        let edge = |e: &Option<(u32, u8)>| e.map_or("null".to_string(), |(face, edge)| format!("[{face},{edge}]"));
        let row = |e: &[Option<(u32, u8)>; 4]| format!("[{}]", e.iter().map(edge).collect::<Vec<_>>().join(","));
        let small = across.len() <= SMALL && compare_ptex(&shape)?.1 == 0;
        let rows = across.iter().map(row).collect::<Vec<_>>().join(",");
        text.push_str(if i > 0 { ",\n" } else { "" });
        text.push_str(&format!(" {{\"shape\": \"{}\", \"tables\": [{}]", shape.name, tables.join(",")));
        text.push_str(&if small { format!(",\n  \"ptex\": [{rows}]}}") } else { "}".to_string() });
    }
    text.push_str("\n]}\n");
    std::fs::write(out, text).map_err(|e| format!("{}: {e}", out.display()))
}

/// Ptex numbers and neighbours of all regression shapes.
pub fn ptex(models: &Path) -> Result<(), String> {
    let (mut total, mut conflicts) = (0, 0);
    for shape in shapes(models, &PREFIXES)? {
        let (faces, across) = compare_ptex(&shape)?;
        total += faces;
        conflicts += across;
    }
    println!(
        "{total} Ptex faces have the same numbers and neighbours, but for {conflicts} edges that two faces run \
         through in the same direction: OpenSubdiv goes across them, we see boundaries"
    );
    Ok(())
}

/// Numbers of Ptex faces, and of edges with winding conflicts.
fn compare_ptex(shape: &Shape) -> Result<(usize, usize), String> {
    let (first, across): PtexAdjacency = adaptive::ptex(shape)?;
    let topology = Topology::new(&mesh(shape)?).map_err(|e| e.to_string())?;
    let ptex = PtexFaces::new(&topology, scheme(shape));
    let numbers: Vec<u32> = (0..shape.counts.len()).map(|f| ptex.id(Face::new(f), 0)).collect();
    if numbers != first || ptex.count() != across.len() {
        return Err(format!("{}: Ptex numbers differ", shape.name));
    }
    let mut conflicts = 0;
    for (id, theirs) in across.iter().enumerate() {
        let ours = ptex.neighbours(&topology, id as u32).map(|n| n.map(|n| (n.ptex_face, n.edge)));
        let (face, subface) = ptex.face(id as u32);
        for edge in 0..4 {
            let is_conflict = || {
                let start = if ptex.subfaces(face) == 1 { edge } else { subface as usize };
                let h = topology.half_edge(face, start);
                let h = if ptex.subfaces(face) > 1 && edge == 3 { topology.prev(h) } else { h };
                ours[edge].is_none() && topology.is_non_manifold_edge(topology.edge(h))
            };
            if ours[edge] != theirs[edge] {
                if !is_conflict() {
                    return Err(format!(
                        "{}: neighbours of Ptex face {id}: ours {ours:?}, theirs {theirs:?}",
                        shape.name
                    ));
                }
                conflicts += 1;
            }
        }
    }
    Ok((across.len(), conflicts))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_with_a_crease_has_opensubdivs_patches_and_neighbours() {
        let text = "v -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 -1\nv 1 -1 -1\n\
            f 1 2 4 3\nf 3 4 6 5\nf 5 6 8 7\nf 7 8 2 1\nf 2 8 6 4\nf 7 1 3 5\nt crease 2/1/0 0 1 2.5";
        let cube = Shape::parse("catmark_cube", text).unwrap();
        compare_ptex(&cube).unwrap();
        run([cube].into_iter(), ISOLATIONS).unwrap();
    }

    #[test]
    #[ignore = "needs ../shared/models; cargo test -- --ignored"]
    fn every_regression_shape_has_opensubdivs_patches_and_neighbours() {
        regression_shapes(&crate::shapes_folder()).unwrap();
        ptex(&crate::shapes_folder()).unwrap();
    }
}
