//! Laws of face-varying and varying channels, on all shapes and on random meshes with random seams, under every rule.

mod random_mesh;

use random_mesh::{Mesh, for_all, recipe};
use std::collections::HashMap;
use subsurf::shapes;
use subsurf::{
    Channel, ChannelError, ControlMesh, Creasing, Derivatives, Face, FaceVarying, Facets, HalfEdge, Level,
    LimitStencilTable, Location, PatchTable, Rates, Rules, Scheme, StencilTable, TessellateOptions, Topology, Vertex,
};

const RULES: [FaceVarying; 6] = [
    FaceVarying::None,
    FaceVarying::CornersOnly,
    FaceVarying::CornersPlus1,
    FaceVarying::CornersPlus2,
    FaceVarying::Boundaries,
    FaceVarying::All,
];

type Law = fn(&ControlMesh, Scheme, &[[f64; 3]], u64) -> Result<(), String>;

/// Checks a law on all shapes and on as many random meshes; the last argument is a seed.
fn everywhere(cases: u32, law: Law) {
    for (i, shape) in shapes::all().into_iter().enumerate() {
        law(&shape.mesh, Scheme::CatmullClark, &shape.positions, i as u64)
            .unwrap_or_else(|e| panic!("{}: {e}", shape.name));
    }
    for (i, shape) in shapes::all_triangles().into_iter().enumerate() {
        law(&shape.mesh, Scheme::Loop, &shape.positions, i as u64).unwrap_or_else(|e| panic!("{}: {e}", shape.name));
    }
    for_all(recipe(), cases, 17, |recipe| {
        let Mesh { mesh, positions } = recipe.mesh();
        law(&mesh, Scheme::CatmullClark, &positions, positions.len() as u64)
    });
}

fn require(ok: bool, what: impl Fn() -> String) -> Result<(), String> {
    if ok { Ok(()) } else { Err(what()) }
}

/// A small generator of random numbers below `n` (splitmix64, Steele, Lea, Flood 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % n
    }
}

/// Faces fall into a few charts; corners of one vertex in one chart share a value, and some charts agree at a vertex.
fn random_seams(mesh: &ControlMesh, seed: u64) -> (Vec<u32>, Vec<[f64; 2]>) {
    let mut random = Random(seed);
    let charts = 1 + random.below(3);
    let chart: Vec<u64> = mesh.faces().map(|_| random.below(charts)).collect();
    let mut value_of = HashMap::new();
    let mut corners = Vec::new();
    for (f, face) in mesh.faces().enumerate() {
        for &v in face {
            // At one vertex in three all charts agree: seams end there.
            let chart = if v % 3 == 0 { 0 } else { chart[f] };
            let next = value_of.len() as u32;
            corners.push(*value_of.entry((v, chart)).or_insert(next));
        }
    }
    let values = (0..value_of.len()).map(|_| [0; 2].map(|_| random.below(1000) as f64 / 1000.0)).collect();
    (corners, values)
}

fn channel(t: &Topology, scheme: Scheme, values: usize, corners: &[u32], rule: FaceVarying) -> Channel {
    Channel::face_varying(t, scheme, values, corners, rule).unwrap()
}

#[test]
fn a_channel_with_the_vertices_topology_gives_the_vertices_result() {
    everywhere(40, |mesh, scheme, points, _| {
        let level = Level::new(mesh, scheme).map_err(|e| e.to_string())?;
        let table = PatchTable::new(mesh, scheme).unwrap();
        // Face-varying corners are kept unless the rule is "none"; the mesh's own are by its boundary rule.
        let channel = channel(level.topology(), scheme, points.len(), mesh.corners(), FaceVarying::None);
        require(channel.rows(points).len() == points.len(), || "values are parted".into())?;
        let (mut a, mut b) = (level.clone(), channel.level());
        let (mut va, mut vb) = (points.to_vec(), points.to_vec());
        for depth in 0..3 {
            b.topology().check()?;
            require(a.topology().corners() == b.topology().corners(), || format!("corners differ at {depth}"))?;
            require(va == vb, || format!("values differ at {depth}"))?;
            (va, vb) = (a.refine_values(&va), b.refine_values(&vb));
            (a, b) = (a.refine().unwrap(), b.refine().unwrap());
        }
        let own = channel.patch_table().unwrap();
        for face in (0..mesh.face_count()).step_by(1 + mesh.face_count() / 40) {
            let at = Location::new(face as u32, 0.3, 0.6);
            let jets = [table.surface(points).eval(at), own.surface(points).eval(at)];
            let [a, b] = jets.map(|jet| jet.map(|jet| (jet.position, jet.du, jet.dv)));
            require(a == b, || format!("{at:?}: {a:?} and {b:?}"))?;
        }
        Ok(())
    });
}

#[test]
fn a_channel_keeps_the_invariants_at_every_level() {
    everywhere(60, |mesh, scheme, _, seed| {
        let (corners, values) = random_seams(mesh, seed);
        let base = Level::new(mesh, scheme).map_err(|e| e.to_string())?;
        for rule in RULES {
            let mut level = channel(base.topology(), scheme, values.len(), &corners, rule).level();
            for depth in 0..3 {
                level.topology().check().map_err(|e| format!("{rule:?}, level {depth}: {e}"))?;
                level = level.refine().unwrap();
            }
        }
        Ok(())
    });
}

#[test]
fn away_from_seams_a_channels_edges_are_as_sharp_as_the_meshs_at_every_level() {
    everywhere(40, |mesh, scheme, _, seed| {
        for creasing in [Creasing::Uniform, Creasing::Chaikin] {
            let rules = Rules { creasing, ..mesh.tags().rules };
            let control = Level::new(&mesh.clone().with_rules(rules), scheme).map_err(|e| e.to_string())?;
            let (corners, values) = random_seams(mesh, seed);
            for rule in RULES {
                let mut level = control.clone();
                let mut refined = channel(control.topology(), scheme, values.len(), &corners, rule).level();
                for _ in 0..3 {
                    (level, refined) = (level.refine().unwrap(), refined.refine().unwrap());
                    let (mesh, channel) = (level.topology(), refined.topology());
                    for h in (0..mesh.half_edge_count() as u32).map(HalfEdge) {
                        let (a, b) = (mesh.edge(h), channel.edge(h));
                        if channel.is_boundary(b) {
                            continue;
                        }
                        let (s, own) = (mesh.edge_sharpness(a), channel.edge_sharpness(b));
                        // Averages may be summed in another order.
                        let what = || format!("{creasing:?}, {rule:?}, level {}, {a:?}: {s} and {own}", level.depth());
                        require((s - own).abs() < 1e-12, what)?;
                    }
                }
            }
        }
        Ok(())
    });
}

#[test]
fn refining_a_channel_keeps_its_limit() {
    everywhere(60, |mesh, scheme, _, seed| {
        let (corners, values) = random_seams(mesh, seed);
        let base = Level::new(mesh, scheme).map_err(|e| e.to_string())?;
        for rule in RULES {
            let channel = channel(base.topology(), scheme, values.len(), &corners, rule);
            let rows = channel.rows(&values);
            let coarse = channel.patch_table().unwrap();
            let level = channel.level();
            let (fine_rows, fine) = (level.refine_values(&rows), level.refine().unwrap());
            let fine = PatchTable::from_topology(fine.topology().clone(), scheme, Default::default()).unwrap();
            for f in (0..fine.topology().face_count()).step_by(1 + fine.topology().face_count() / 50) {
                for (u, v) in [(0.25, 0.5), (0.0, 0.375), (0.125, 0.0), (0.75, 0.0), (0.7, 0.1)] {
                    let at = Location::new(f as u32, u, v);
                    let up = parent_location(base.topology(), scheme, f, [u, v]);
                    let Some(a) = fine.surface(&fine_rows).eval(at) else { continue };
                    let b = coarse.surface(&rows).eval(up.0).unwrap();
                    for k in 0..2 {
                        let off = (a.position[k] - b.position[k]).abs();
                        // Rounding of one step, on values below 1.
                        require(off < 1e-14, || format!("{rule:?} {at:?} is {:?}: off by {off:.1e}", up.0))?;
                        if b.derivatives != Derivatives::Finite {
                            continue;
                        }
                        for (da, db) in [(a.du, b.du), (a.dv, b.dv)] {
                            let off = (da[k] - 0.5 * up.1 * db[k]).abs();
                            require(off < 1e-11 * (1.0 + da[k].abs()), || {
                                format!("{rule:?} {at:?} is {:?}: derivative off by {off:.1e}", up.0)
                            })?;
                        }
                    }
                }
            }
        }
        Ok(())
    });
}

/// Where `(u, v)` of face `f` of level 1 lies on the mesh, and -1 where it is turned upside down.
fn parent_location(mesh: &Topology, scheme: Scheme, f: usize, [u, v]: [f64; 2]) -> (Location, f64) {
    if scheme == Scheme::Loop {
        let (u, v, sign) = match f % 4 {
            0 => (u / 2.0, v / 2.0, 1.0),
            1 => (u / 2.0 + 0.5, v / 2.0, 1.0),
            2 => (u / 2.0, v / 2.0 + 0.5, 1.0),
            // The middle's corners are those of sides 0, 1, 2 turned: E1 E2 E0.
            _ => (0.5 - u / 2.0, 0.5 - v / 2.0, -1.0),
        };
        return (Location::new((f / 4) as u32, u, v), sign);
    }
    let face = mesh.face_offsets().partition_point(|&o| o as usize <= f) - 1;
    let corner = f - mesh.face_offsets()[face] as usize;
    if mesh.sides(Face::new(face)) != 4 {
        return (Location { face: Face::new(face), subface: corner as u32, u, v }, 2.0);
    }
    let (x, y) = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5)][corner];
    (Location::new(face as u32, x + u / 2.0, y + v / 2.0), 1.0)
}

#[test]
fn linear_channels_interpolate_their_corners() {
    everywhere(20, |mesh, scheme, points, seed| {
        let (corners, values) = random_seams(mesh, seed);
        let base = Level::new(mesh, scheme).map_err(|e| e.to_string())?;
        let linear = channel(base.topology(), scheme, values.len(), &corners, FaceVarying::All);
        let varying = Channel::varying(base.topology(), scheme);
        let (rows, table, by_vertex) =
            (linear.rows(&values), linear.patch_table().unwrap(), varying.patch_table().unwrap());
        for f in 0..mesh.face_count() {
            let first = base.topology().face_offsets()[f] as usize;
            let n = mesh.face_vertices(f).len();
            let quad = scheme != Scheme::Loop && n == 4;
            let whole = quad || scheme == Scheme::Loop;
            let at = if whole {
                Location::new(f as u32, 0.25, 0.5)
            } else {
                Location { face: Face::new(f), subface: 1, u: 1.0, v: 1.0 }
            };
            let Some(jet) = table.surface(&rows).eval(at) else { continue };
            let weights = match (quad, whole) {
                (true, _) => vec![0.375, 0.125, 0.125, 0.375],
                (_, true) => vec![0.25, 0.25, 0.5],
                _ => vec![1.0 / n as f64; n],
            };
            for k in 0..2 {
                let expected: f64 = (0..n).map(|c| weights[c] * values[corners[first + c] as usize][k]).sum();
                require((jet.position[k] - expected).abs() < 1e-15, || {
                    format!("{at:?}: {} for {expected}", jet.position[k])
                })?;
            }
            let own = by_vertex.surface(points).eval(at).unwrap();
            let expected: f64 = (0..n).map(|c| weights[c] * points[mesh.face_vertices(f)[c] as usize][0]).sum();
            require((own.position[0] - expected).abs() < 1e-14 * (1.0 + expected.abs()), || format!("{at:?}"))?;
        }
        Ok(())
    });
}

#[test]
fn linear_boundaries_are_straight_between_values() {
    // A fan with a boundary: under the rule "boundaries" the limit along a boundary edge is the chord.
    let shape = shapes::grid(3, 3);
    let table = PatchTable::new(&shape.mesh, Scheme::CatmullClark).unwrap();
    let t = table.topology();
    let count = shape.positions.len();
    let bent: Vec<[f64; 2]> = (0..count).map(|i| [(i * i % 7) as f64, (i * 5 % 11) as f64]).collect();
    let own = channel(t, Scheme::CatmullClark, count, shape.mesh.corners(), FaceVarying::Boundaries);
    let own = own.patch_table().unwrap();
    for h in (0..t.half_edge_count() as u32).map(HalfEdge) {
        if !t.is_boundary(t.edge(h)) {
            continue;
        }
        let corner = h.index() % 4;
        for s in [0.0, 0.125, 0.3, 0.5, 0.9, 1.0] {
            let (u, v) = [(s, 0.0), (1.0, s), (1.0 - s, 1.0), (0.0, 1.0 - s)][corner];
            let p = own.surface(&bent).eval(Location::new(t.face(h).0, u, v)).unwrap().position;
            let (a, b) = (bent[t.origin(h).index()], bent[t.origin(t.next(h)).index()]);
            for k in 0..2 {
                let chord = a[k] + s * (b[k] - a[k]);
                assert!((p[k] - chord).abs() < 1e-14, "side {corner} at {s}: {} for {chord}", p[k]);
            }
        }
    }
}

#[test]
fn values_that_several_vertices_share_part_when_refined() {
    // One texture coordinate for everything, as some exporters write it.
    let shape = shapes::cube();
    let table = PatchTable::new(&shape.mesh, Scheme::CatmullClark).unwrap();
    let all_zero = vec![0u32; table.topology().half_edge_count()];
    let channel = channel(table.topology(), Scheme::CatmullClark, 1, &all_zero, FaceVarying::CornersPlus1);
    let rows = channel.rows(&[[0.25f64, 0.75]]);
    assert_eq!(rows.len(), 8);
    assert_eq!(channel.seam_count(table.topology()), 0);
    let level = channel.level().refine().unwrap();
    assert_eq!(level.topology().vertex_count(), 26);
    assert!(channel.level().refine_values(&rows).iter().all(|uv| (uv[0] - 0.25).abs() + (uv[1] - 0.75).abs() < 1e-15));
}

#[test]
fn a_channel_that_does_not_fit_is_refused_by_name() {
    let shape = shapes::cube();
    let t = Topology::new(&shape.mesh).unwrap();
    let refuse = |corners: &[u32]| {
        Channel::face_varying(&t, Scheme::CatmullClark, 3, corners, FaceVarying::None).map(|_| ()).unwrap_err()
    };
    assert_eq!(refuse(&[0; 23]), ChannelError::CornerCount { given: 23, expected: 24 });
    let mut corners = [0; 24];
    corners[6] = 3;
    assert_eq!(refuse(&corners), ChannelError::ValueOutOfRange { face: 1, corner: 2, value: 3, values: 3 });
}

#[test]
fn a_refined_channel_is_made_of_its_own_corners_again() {
    // What is sharp follows from the indices alone, at every level: refined files read as the same channel. Not where a
    // seam runs along a non-manifold edge: its new vertices are smooth along it, those of a file are pinned.
    everywhere(60, |mesh, scheme, _, seed| {
        let (corners, values) = random_seams(mesh, seed);
        let base = Level::new(mesh, scheme).map_err(|e| e.to_string())?;
        for rule in RULES {
            let own = channel(base.topology(), scheme, values.len(), &corners, rule);
            let (fine, refined) = (base.refine().unwrap(), own.level().refine().unwrap());
            let t = refined.topology();
            let again = channel(fine.topology(), scheme, t.vertex_count(), t.corners(), rule);
            let again = again.topology();
            require(again.corners() == t.corners(), || format!("{rule:?}: corners differ"))?;
            if rule == FaceVarying::All || rule == FaceVarying::Boundaries {
                continue;
            }
            for (&v, &vertex) in t.corners().iter().zip(fine.topology().corners()) {
                if fine.topology().is_non_manifold_vertex(Vertex(vertex)) {
                    continue;
                }
                let [a, b] = [t, again].map(|t| t.vertex_sharpness(Vertex(v)));
                require(a == b, || format!("{rule:?}: value {v} has sharpness {a}, {b} when made again"))?;
            }
        }
        Ok(())
    });
}

#[test]
fn tessellated_channels_hold_the_limit_at_every_facet_corner() {
    everywhere(25, |mesh, scheme, points, seed| {
        let (corners, values) = random_seams(mesh, seed);
        let table = PatchTable::new(mesh, scheme).map_err(|e| e.to_string())?;
        for (rule, rates, facets) in [
            (FaceVarying::CornersPlus1, Rates::Uniform(4), Facets::Quads),
            (FaceVarying::All, Rates::Uniform(3), Facets::Triangles),
            (FaceVarying::None, Rates::EdgeLength(0.3), Facets::Quads),
        ] {
            let own = channel(table.topology(), scheme, values.len(), &corners, rule);
            let (rows, own) = (own.rows(&values), own.patch_table().unwrap());
            let options = TessellateOptions { rates, facets, places: true, ..TessellateOptions::default() };
            let Ok(fine) = table.surface(points).tessellate(&options) else { continue };
            let uv = fine.channel(&table, own.surface(&rows)).unwrap();
            require(uv.corners.len() == fine.corners.len(), || format!("{rule:?}: corners"))?;
            let places = fine.places.as_ref().unwrap();
            for (f, &(face, subface)) in places.facet.iter().enumerate() {
                for c in fine.face_offsets[f] as usize..fine.face_offsets[f + 1] as usize {
                    let [u, v] = places.corner_uv[c];
                    let at = Location { face: Face(face), subface, u, v };
                    let p = own.surface(&rows).position(at).unwrap();
                    let q = uv.values[uv.corners[c] as usize];
                    let off = (p[0] - q[0]).abs() + (p[1] - q[1]).abs();
                    // Shared samples are evaluated by one face for all.
                    require(off < 1e-13, || format!("{rule:?} {at:?}: {q:?} for {p:?}"))?;
                }
            }
        }
        Ok(())
    });
}

#[test]
fn stencils_of_a_channel_are_its_refinement_and_its_limit() {
    everywhere(25, |mesh, scheme, _, seed| {
        let (corners, values) = random_seams(mesh, seed);
        let base = Level::new(mesh, scheme).map_err(|e| e.to_string())?;
        for rule in RULES {
            let channel = channel(base.topology(), scheme, values.len(), &corners, rule);
            let (rows, table) = (channel.rows(&values), channel.patch_table().unwrap());
            let level = channel.level();
            let one = level.refine().unwrap();
            let refined = one.refine_values(&level.refine_values(&rows));
            let stencils = StencilTable::<f64>::new(&level, 2).unwrap().apply(&rows);
            require(stencils.len() == refined.len(), || format!("{rule:?}: {} rows", stencils.len()))?;
            for (v, (a, b)) in stencils.iter().zip(&refined).enumerate() {
                let off = (a[0] - b[0]).abs() + (a[1] - b[1]).abs();
                // Rounding of two levels, on values below 1.
                require(off < 1e-14, || format!("{rule:?}, value {v}: off by {off:.1e}"))?;
            }
            let faces = (0..mesh.face_count() as u32).filter(|&f| !base.topology().is_hole(Face(f)));
            let places: Vec<Location> = faces.map(|f| Location::new(f, 0.3, 0.6)).collect();
            let limits = LimitStencilTable::<f64>::new(&table, &places).unwrap().positions(&rows);
            for (at, limit) in places.iter().zip(limits) {
                let own = table.surface(&rows).position(*at).unwrap();
                let off = (limit[0] - own[0]).abs() + (limit[1] - own[1]).abs();
                require(off < 1e-14, || format!("{rule:?} {at:?}: off by {off:.1e}"))?;
            }
        }
        Ok(())
    });
}
