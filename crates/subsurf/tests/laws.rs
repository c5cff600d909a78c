//! Laws that hold on every mesh: on all shapes, and on random ones.

mod random_mesh;

use random_mesh::{Mesh, for_all, recipe};
use std::panic::{AssertUnwindSafe, catch_unwind};
use subsurf::shapes::{self, Shape};
use subsurf::{
    Boundary, ControlMesh, Corner, Crease, Derivatives, Edge, Face, Jet, Level, Location, Method, PatchTable, Rules,
    Scheme, Tags, Topology, Vertex,
};

type Law = fn(&ControlMesh, &[[f64; 3]]) -> Result<(), String>;

/// Checks a law on all shapes and on as many random meshes.
fn everywhere(cases: u32, law: Law) {
    for shape in shapes::all() {
        law(&shape.mesh, &shape.positions).unwrap_or_else(|e| panic!("{}: {e}", shape.name));
    }
    for_all(recipe(), cases, 11, |recipe| {
        let Mesh { mesh, positions } = recipe.mesh();
        law(&mesh, &positions)
    });
}

fn table(mesh: &ControlMesh) -> PatchTable {
    PatchTable::new(mesh, Scheme::CatmullClark).unwrap()
}

/// A few locations of every face, at most some hundred in all.
fn locations(mesh: &ControlMesh) -> Vec<Location> {
    const PLACES: [(f64, f64); 7] =
        [(0.0, 0.0), (0.3, 0.6), (1.0, 0.25), (1e-7, 3e-7), (0.5, 0.5), (0.0, 0.7), (0.9, 0.999)];
    let step = 1 + mesh.face_count() / 60;
    let mut at = Vec::new();
    for face in (0..mesh.face_count()).step_by(step) {
        let sides = mesh.face_vertices(face).len();
        for subface in 0..if sides == 4 { 1 } else { sides as u32 } {
            for k in 0..3 {
                let (u, v) = PLACES[(face + subface as usize + 3 * k) % 7];
                at.push(Location { face: Face::new(face), subface, u, v });
            }
        }
    }
    at
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn size(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    size(minus(a, b))
}

/// The larger of two errors; none is larger than one that is not a number.
fn worse(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

fn require(ok: bool, what: impl Fn() -> String) -> Result<(), String> {
    if ok { Ok(()) } else { Err(what()) }
}

/// Largest coordinate of the control points: the unit of errors.
fn unit(points: &[[f64; 3]]) -> f64 {
    points.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()))
}

#[test]
fn a_constant_is_reproduced_exactly_and_has_no_derivatives() {
    everywhere(30, |mesh, points| {
        let table = table(mesh);
        let constant = vec![[0.1, -7.3, 1e9]; points.len()];
        for at in locations(mesh) {
            let Some(jet) = table.surface(&constant).eval_second(at) else { continue };
            require(jet.position == constant[0], || format!("{at:?}: {:?}", jet.position))?;
            let zero = [[0.0; 3]; 3];
            require([jet.du, jet.dv] == zero[..2], || format!("{at:?}: {:?}", jet.du))?;
            require(jet.second.is_none_or(|d| d == zero), || format!("{at:?}: {:?}", jet.second))?;
        }
        Ok(())
    });
}

#[test]
fn affine_maps_commute_with_evaluation() {
    everywhere(30, |mesh, points| {
        let linear = |p: [f64; 3]| [p[0] - 2.0 * p[1], 0.5 * p[2] + p[0], 3.0 * p[1] - p[2]];
        let moved: Vec<[f64; 3]> = points.iter().map(|&p| minus(linear(p), [-5.0, 7.0, 0.25])).collect();
        let table = table(mesh);
        for at in locations(mesh) {
            let Some(a) = table.surface(points).eval(at) else { continue };
            let b = table.surface(&moved).eval(at).unwrap();
            let expected = minus(linear(a.position), [-5.0, 7.0, 0.25]);
            // Rounding of the moved points, a few units in the last place of 12.
            let error = apart(expected, b.position) / (unit(points) + 7.0);
            require(error < 1e-14, || format!("{at:?}: position off by {error:.1e}"))?;
            let scale = size(a.du).max(size(a.dv)).max(unit(points));
            let error = worse(apart(linear(a.du), b.du), apart(linear(a.dv), b.dv)) / scale;
            // The same rounding, larger by a patch's depth at shallow places.
            require(error < 1e-9, || format!("{at:?}: derivatives off by {error:.1e}"))?;
        }
        Ok(())
    });
}

/// The same mesh with vertices and faces in another order and faces that start at another corner.
struct Renumbered {
    mesh: ControlMesh,
    points: Vec<[f64; 3]>,
    face: Vec<usize>,
    turn: Vec<usize>,
}

fn renumber(mesh: &ControlMesh, points: &[[f64; 3]]) -> Renumbered {
    let shuffle = |n: usize| -> Vec<usize> {
        let step = (n / 3..).find(|s| s % 2 == 1 && gcd(*s, n) == 1).unwrap_or(1);
        (0..n).map(|i| (i * step + n / 2) % n).collect()
    };
    let (vertex, face) = (shuffle(points.len()), shuffle(mesh.face_count()));
    let mut faces = vec![Vec::new(); face.len()];
    let mut turn = vec![0; face.len()];
    for (f, corners) in mesh.faces().enumerate() {
        turn[f] = (f * 7 + 3) % corners.len();
        let mut turned: Vec<u32> = corners.iter().map(|&v| vertex[v as usize] as u32).collect();
        turned.rotate_left(turn[f]);
        faces[face[f]] = turned;
    }
    let mut moved = vec![[0.0; 3]; points.len()];
    points.iter().enumerate().for_each(|(v, &p)| moved[vertex[v]] = p);
    let old = mesh.tags();
    let of = |v: u32| vertex[v as usize] as u32;
    let tags = Tags {
        creases: old.creases.iter().map(|c| Crease::new(of(c.vertices[1]), of(c.vertices[0]), c.sharpness)).collect(),
        corners: old.corners.iter().map(|c| Corner::new(of(c.vertex), c.sharpness)).collect(),
        holes: old.holes.iter().map(|&f| face[f as usize] as u32).collect(),
        rules: old.rules,
    };
    let counts: Vec<u32> = faces.iter().map(|f| f.len() as u32).collect();
    let mesh = ControlMesh::from_counts(points.len(), &counts, faces.concat(), tags).unwrap();
    Renumbered { mesh, points: moved, face, turn }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

impl Renumbered {
    /// The same place, and what `(du, dv)` there are in the old parameters: signs and order.
    fn place(&self, at: Location, sides: usize) -> (Location, usize) {
        let f = at.face.index();
        let turn = self.turn[f];
        let face = Face::new(self.face[f]);
        if sides != 4 {
            let subface = (at.subface + (sides - turn) as u32) % sides as u32;
            return (Location { face, subface, ..at }, 0);
        }
        let (u, v) = match turn {
            0 => (at.u, at.v),
            1 => (at.v, 1.0 - at.u),
            2 => (1.0 - at.u, 1.0 - at.v),
            _ => (1.0 - at.v, at.u),
        };
        (Location { face, subface: 0, u, v }, turn)
    }
}

fn turned_back(jet: &Jet<3>, turn: usize) -> [[f64; 3]; 2] {
    let minus = |d: [f64; 3]| d.map(|x| -x);
    match turn {
        0 => [jet.du, jet.dv],
        1 => [minus(jet.dv), jet.du],
        2 => [minus(jet.du), minus(jet.dv)],
        _ => [jet.dv, minus(jet.du)],
    }
}

#[test]
fn renumbering_changes_nothing_but_rounding() {
    everywhere(60, |mesh, points| {
        let other = renumber(mesh, points);
        let (table, other_table) = (table(mesh), table(&other.mesh));
        for at in locations(mesh) {
            let (there, turn) = other.place(at, mesh.face_vertices(at.face.index()).len());
            let (a, b) = (table.surface(points).eval(at), other_table.surface(&other.points).eval(there));
            let (Some(a), Some(b)) = (a, b) else {
                require(a.is_none() && b.is_none(), || format!("{at:?} is a hole in one of two"))?;
                continue;
            };
            // Parameters near 1 lose what they have near 0: 1e-16 times a derivative.
            let error = apart(a.position, b.position) / unit(points);
            require(error < 1e-13, || format!("{at:?}: position moves by {error:.1e}"))?;
            if a.derivatives != Derivatives::Finite || b.derivatives != Derivatives::Finite || a.plane.is_none() {
                // At a vertex the answer is a direction, the same from all sides but for its frame.
                require(a.derivatives == b.derivatives, || {
                    format!("{at:?}: {:?} and {:?}", a.derivatives, b.derivatives)
                })?;
                continue;
            }
            let [du, dv] = turned_back(&b, turn);
            let scale = size(a.du).max(size(a.dv)).max(unit(points));
            let error = worse(apart(a.du, du), apart(a.dv, dv)) / scale;
            // At 1e-7 from a corner that becomes 1 - 1e-7, 1e-16 of the parameter is 1e-9 of the distance.
            require(error < 1e-7, || format!("{at:?}: derivatives change by {error:.1e}"))?;
        }
        Ok(())
    });
}

/// The next level as a control mesh of its own; none where its edges are not told apart by their vertices, or where the
/// rules for a mesh that is no manifold would see it differently.
fn refined(mesh: &ControlMesh, points: &[[f64; 3]]) -> Option<(ControlMesh, Vec<[f64; 3]>)> {
    let level = Level::new(mesh, Scheme::CatmullClark).unwrap();
    let next = level.refine().unwrap();
    let t = next.topology();
    let edges = || (0..t.edge_count() as u32).map(Edge);
    let vertices = || (0..t.vertex_count() as u32).map(Vertex);
    let pairs: std::collections::HashSet<[Vertex; 2]> = edges().map(|e| t.edge_vertices(e)).collect();
    if pairs.len() < t.edge_count() {
        return None;
    }
    let crease = |e: Edge| Crease::new(t.edge_vertices(e)[0].0, t.edge_vertices(e)[1].0, t.edge_sharpness(e));
    let tags = Tags {
        creases: edges().filter(|&e| t.edge_sharpness(e) > 0.0).map(crease).collect(),
        corners: vertices()
            .filter(|&v| t.vertex_sharpness(v) > 0.0)
            .map(|v| Corner::new(v.0, t.vertex_sharpness(v)))
            .collect(),
        holes: (0..t.face_count() as u32).filter(|&f| t.is_hole(Face(f))).collect(),
        rules: Rules { boundary: Boundary::EdgeOnly, ..mesh.tags().rules },
    };
    let counts: Vec<u32> = (0..t.face_count() as u32).map(|f| t.sides(Face(f)) as u32).collect();
    let refined = ControlMesh::from_counts(t.vertex_count(), &counts, t.corners().to_vec(), tags).unwrap();
    let again = Topology::new(&refined).unwrap();
    let same = vertices().all(|v| again.vertex_sharpness(v) == t.vertex_sharpness(v));
    same.then(|| (refined, level.refine_values(points)))
}

#[test]
fn refining_the_mesh_keeps_the_limit_surface() {
    everywhere(40, |mesh, points| {
        let Some((fine, fine_points)) = refined(mesh, points) else { return Ok(()) };
        let (coarse_table, fine_table) = (table(mesh), table(&fine));
        for at in locations(mesh) {
            let first = mesh.face_offsets()[at.face.index()];
            let (there, factor) = if mesh.face_vertices(at.face.index()).len() == 4 {
                let (cu, cv) = (at.u >= 0.5, at.v >= 0.5);
                let corner = [[0, 3], [1, 2]][usize::from(cu)][usize::from(cv)];
                let half = |x: f64, upper: bool| 2.0 * x - f64::from(u8::from(upper));
                (Location::new(first + corner, half(at.u, cu), half(at.v, cv)), 2.0)
            } else {
                (Location::new(first + at.subface, at.u, at.v), 1.0)
            };
            let a = coarse_table.surface(points).eval_second(at);
            let b = fine_table.surface(&fine_points).eval_second(there);
            let (Some(a), Some(b)) = (a, b) else {
                require(a.is_none() && b.is_none(), || format!("{at:?} is a hole on one level"))?;
                continue;
            };
            // Rounding of the refined points.
            let error = apart(a.position, b.position) / unit(points);
            require(error < 1e-14, || format!("{at:?}: position moves by {error:.1e}"))?;
            require(a.second.is_some() == b.second.is_some(), || format!("{at:?}: special on one level only"))?;
            let (Some(dd), Some(fine_dd)) = (a.second, b.second) else { continue };
            let scale = size(a.du).max(size(a.dv)).max(unit(points));
            let [du, dv] = [b.du, b.dv].map(|d| d.map(|x| factor * x));
            let error = worse(apart(a.du, du), apart(a.dv, dv)) / scale;
            // At 1e-7 of a vertex, rounding of the points is divided by 1e-7.
            require(error < 1e-8, || format!("{at:?}: derivatives change by {error:.1e}"))?;
            if at.u.max(at.v) > 0.1 {
                let scale = dd.iter().map(|&d| size(d)).fold(scale, f64::max);
                let error = (0..3).map(|k| apart(dd[k], fine_dd[k].map(|x| factor * factor * x))).fold(0.0, worse);
                require(error / scale < 1e-10, || format!("{at:?}: second derivatives change by {error:.1e}"))?;
            }
        }
        Ok(())
    });
}

/// Place `t` along a face's edge number `corner`.
fn on_edge(topology: &Topology, face: Face, corner: u32, t: f64) -> Location {
    let sides = topology.sides(face) as u32;
    if sides == 4 {
        let (u, v) = [(t, 0.0), (1.0, t), (1.0 - t, 1.0), (0.0, 1.0 - t)][corner as usize];
        return Location { face, subface: 0, u, v };
    }
    if t <= 0.5 {
        Location { face, subface: corner, u: 2.0 * t, v: 0.0 }
    } else {
        Location { face, subface: (corner + 1) % sides, u: 0.0, v: 2.0 * (1.0 - t) }
    }
}

#[test]
fn neighbours_agree_along_their_edge() {
    everywhere(40, |mesh, points| {
        let table = table(mesh);
        let (t, surface) = (table.topology(), table.surface(points));
        for h in (0..t.half_edge_count() as u32).map(subsurf::HalfEdge).step_by(1 + t.half_edge_count() / 300) {
            let Some(twin) = t.twin(h) else { continue };
            let place =
                |h: subsurf::HalfEdge, s: f64| on_edge(t, t.face(h), h.0 - t.face_offsets()[t.face(h).index()], s);
            for s in [0.0, 0.125, 0.5, 0.6875, 1.0] {
                let at = place(h, s);
                let (Some(a), Some(b)) = (surface.eval(at), surface.eval(place(twin, 1.0 - s))) else { continue };
                let error = apart(a.position, b.position) / unit(points);
                require(error < 1e-14, || format!("{at:?}: a gap of {error:.1e}"))?;
                let smooth = t.edge_sharpness(t.edge(h)) == 0.0 && a.unique_plane && b.unique_plane;
                let (Some(m), Some(n)) = (a.normal(), b.normal()) else { continue };
                // Rounding is divided by the sine of the tangents' angle; surfaces that fold back onto themselves have none.
                let steep = |j: &Jet<3>| {
                    size(j.du).max(size(j.dv)) < 1e-6 * unit(points)
                        || j.plane.is_none_or(|[p, q]| nearly_parallel(p, q))
                };
                if smooth && !steep(&a) && !steep(&b) {
                    let error = apart(m, n);
                    require(error < 1e-10, || format!("{at:?}: normals {error:.1e} apart"))?;
                }
            }
        }
        Ok(())
    });
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Also where one is nearly zero, as on a surface that folds back onto itself.
fn nearly_parallel(a: [f64; 3], b: [f64; 3]) -> bool {
    size(cross(a, b)) < 1e-3 * size(a).max(size(b)).powi(2)
}

#[test]
fn derivatives_match_differences() {
    everywhere(30, |mesh, points| {
        let table = table(mesh);
        let surface = table.surface(points);
        const H: f64 = 1e-5;
        for place in locations(mesh) {
            for (u, v) in [(0.37, 0.61), (0.81, 0.23)] {
                let at = |du: f64, dv: f64| Location { u: u + du, v: v + dv, ..place };
                let Some(jet) = surface.eval_second(at(0.0, 0.0)) else { continue };
                let difference = |p: Location, q: Location, what: fn(&Jet<3>) -> [f64; 3]| {
                    minus(what(&surface.eval(p).unwrap()), what(&surface.eval(q).unwrap())).map(|x| x / (2.0 * H))
                };
                let [along_u, along_v] = [(at(H, 0.0), at(-H, 0.0)), (at(0.0, H), at(0.0, -H))];
                let [uu, uv, vv] = jet.second.unwrap();
                let pairs = [
                    (jet.du, difference(along_u.0, along_u.1, |j| j.position)),
                    (jet.dv, difference(along_v.0, along_v.1, |j| j.position)),
                    (uu, difference(along_u.0, along_u.1, |j| j.du)),
                    (uv, difference(along_v.0, along_v.1, |j| j.du)),
                    (uv, difference(along_u.0, along_u.1, |j| j.dv)),
                    (vv, difference(along_v.0, along_v.1, |j| j.dv)),
                ];
                for (k, (exact, difference)) in pairs.into_iter().enumerate() {
                    // H² times a third or fourth derivative, up to 8^4 within a patch three levels down, and 1e-16 / H.
                    let error = apart(exact, difference) / unit(points);
                    require(error < 1e-5, || format!("{:?}: derivative {k} off by {error:.1e}", at(0.0, 0.0)))?;
                }
            }
        }
        Ok(())
    });
}

#[test]
fn the_limit_at_a_corner_is_the_limit_of_places_nearby() {
    everywhere(40, |mesh, points| {
        let table = table(mesh);
        let surface = table.surface(points);
        for place in locations(mesh) {
            let at = |u: f64, v: f64| Location { u, v, ..place };
            let Some(corner) = surface.position(at(0.0, 0.0)) else { continue };
            for (u, v) in [(1e-60, 0.0), (1e-60, 2e-60), (3e-70, 1e-60)] {
                // The slowest mode has shrunk by 0.66^200.
                let error = apart(corner, surface.position(at(u, v)).unwrap()) / unit(points);
                require(error < 1e-14, || format!("{:?}: {error:.1e} from the corner", at(u, v)))?;
            }
        }
        Ok(())
    });
}

#[test]
fn sub_faces_meet_at_corners_edge_middles_and_the_centre() {
    everywhere(40, |mesh, points| {
        let table = table(mesh);
        let surface = table.surface(points);
        for (f, face) in mesh.faces().enumerate().filter(|(_, f)| f.len() != 4) {
            let n = face.len() as u32;
            assert_eq!(table.subfaces(Face::new(f)), n);
            let at = |subface: u32, u: f64, v: f64| {
                surface.position(Location { face: Face::new(f), subface: subface % n, u, v })
            };
            let Some(centre) = at(0, 1.0, 1.0) else { continue };
            for j in 0..n {
                let gaps = [
                    apart(at(j, 1.0, 1.0).unwrap(), centre),
                    apart(at(j, 1.0, 0.0).unwrap(), at(j + 1, 0.0, 1.0).unwrap()),
                    apart(at(j, 1.0, 0.4).unwrap(), at(j + 1, 0.4, 1.0).unwrap()),
                ];
                require(gaps.iter().all(|g| g / unit(points) < 1e-14), || format!("face {f} sub-face {j}: {gaps:?}"))?;
            }
        }
        Ok(())
    });
}

#[test]
fn bilinear_sub_faces_start_at_the_corner_and_run_along_the_edges() {
    let shape = shapes::cone(5);
    let table = PatchTable::new(&shape.mesh, Scheme::Bilinear).unwrap();
    let surface = table.surface(&shape.positions);
    for (f, face) in shape.mesh.faces().enumerate() {
        let n = face.len();
        let middle =
            |a: u32, b: u32| [0, 1, 2].map(|k| 0.5 * (shape.positions[a as usize][k] + shape.positions[b as usize][k]));
        for j in 0..n {
            let at =
                |u: f64, v: f64| surface.position(Location { face: Face::new(f), subface: j as u32, u, v }).unwrap();
            assert!(apart(at(0.0, 0.0), shape.positions[face[j] as usize]) < 1e-15);
            assert!(apart(at(1.0, 0.0), middle(face[j], face[(j + 1) % n])) < 1e-15);
            assert!(apart(at(0.0, 1.0), middle(face[j], face[(j + n - 1) % n])) < 1e-15);
        }
    }
}

#[test]
fn holes_have_no_surface_and_everything_else_has() {
    everywhere(40, |mesh, points| {
        let table = table(mesh);
        for at in locations(mesh) {
            let hole = table.topology().is_hole(at.face);
            let surface = table.surface(points);
            let found = [surface.eval(at).is_some(), surface.eval_second(at).is_some(), surface.position(at).is_some()];
            require(found == [!hole; 3], || format!("{at:?}, hole {hole}: {found:?}"))?;
            require(table.patch_plan(table.patch(at.face, at.subface)).is_some() != hole, || format!("{at:?}"))?;
        }
        Ok(())
    });
}

#[test]
fn places_that_do_not_exist_panic() {
    let shape = shapes::cone(5);
    let table = table(&shape.mesh);
    let surface = table.surface(&shape.positions);
    let good = Location { face: Face(0), subface: 2, u: 0.5, v: 0.5 };
    assert!(surface.eval(good).is_some());
    let wrong = [
        Location { u: 1.0 + f64::EPSILON, ..good },
        Location { v: -1e-300, ..good },
        Location { u: f64::NAN, ..good },
        Location { v: f64::INFINITY, ..good },
        Location { subface: 3, ..good },
        Location { face: Face(6), ..good },
        Location { face: Face(u32::MAX), ..good },
    ];
    for at in wrong {
        assert!(catch_unwind(AssertUnwindSafe(|| surface.eval(at))).is_err(), "{at:?}");
        assert!(catch_unwind(AssertUnwindSafe(|| surface.position(at))).is_err(), "{at:?}");
    }
    assert!(catch_unwind(AssertUnwindSafe(|| table.surface(&shape.positions[1..]).points().len())).is_err());
}

/// The jet at vertex 0, from a face that starts there.
fn at_vertex(shape: &Shape, scale: f64, method: Method) -> Jet<3> {
    let table = PatchTable::with_method(&shape.mesh, Scheme::CatmullClark, method).unwrap();
    let face = shape.mesh.faces().position(|f| f[0] == 0).unwrap() as u32;
    table.surface(&shape.positions).eval(Location::new(face, 0.6 * scale, 0.8 * scale)).unwrap()
}

fn pinned(shape: &Shape) -> Shape {
    shape.tagged("pinned", Tags { corners: vec![Corner::new(0, 10.0)], ..Tags::default() })
}

fn rounded(shape: &Shape) -> Shape {
    let rules = Rules { boundary: Boundary::EdgeOnly, ..Rules::default() };
    shape.tagged("rounded", Tags { rules, ..Tags::default() })
}

#[test]
fn derivative_states_follow_the_valence() {
    let interior = |n| (shapes::interior_vertex(n), if n < 4 { Derivatives::Vanishes } else { Derivatives::Diverges });
    let boundary = |k| (shapes::boundary_vertex(k), if k < 3 { Derivatives::Finite } else { Derivatives::Diverges });
    let corner =
        |k| (pinned(&shapes::boundary_vertex(k)), if k < 2 { Derivatives::Finite } else { Derivatives::Diverges });
    let mut cases: Vec<(Shape, Derivatives)> = [2, 3, 5, 6, 8, 12].map(interior).to_vec();
    cases.push((shapes::interior_vertex(4), Derivatives::Finite));
    cases.extend([2, 3, 4, 5, 7].map(boundary));
    cases.extend([1, 2, 3, 4].map(corner));
    cases.push((rounded(&shapes::boundary_vertex(1)), Derivatives::Finite));
    for (shape, state) in cases {
        for method in [Method::Deflated, Method::Eigenbasis] {
            assert_eq!(at_vertex(&shape, 0.0, method).derivatives, state, "{} {method:?}", shape.name);
            // What the state says of the derivatives nearby; a defective eigenvalue 1/2 grows like the depth only.
            let length = |scale: f64| {
                let jet = at_vertex(&shape, scale, method);
                worse(size(jet.du), size(jet.dv))
            };
            let (near, nearer) = (length(2f64.powi(-60)), length(2f64.powi(-240)));
            match state {
                Derivatives::Finite => assert!((nearer / near - 1.0).abs() < 1e-6, "{}", shape.name),
                Derivatives::Vanishes => assert!(nearer < 1e-10 * near, "{}", shape.name),
                Derivatives::Diverges => assert!(nearer > 2.0 * near, "{}: {near} {nearer}", shape.name),
            }
        }
    }
}

#[test]
fn normals_nearby_converge_to_the_normal_at_a_vertex() {
    let spoke = |n: u32, s: f64| {
        let crease = vec![Crease::new(0, 1, s), Crease::new(1, 2, s), Crease::new(2, 3, s)];
        shapes::interior_vertex(n).tagged(format!("dart of {n}"), Tags { creases: crease, ..Tags::default() })
    };
    // Depth and bound. Interior vertices shrink the next mode by (μ/λ)^depth, 1e-16 at valence 12. Where the two leading
    // eigenvalues differ (darts, three or four faces at a crease, one at a rounded corner) du and dv draw together, and
    // their cross product is all rounding far below: less depth. Where the eigenvalue 1/2 has a block of two (crease
    // with 1 or 4 faces, corner with 2), normals come closer only as one over the depth.
    let mut cases: Vec<(Shape, i32, f64)> =
        [3, 5, 6, 8, 12].map(|n| (shapes::interior_vertex(n), -400, 1e-12)).to_vec();
    cases.extend([3, 4, 5, 6].map(|n| (spoke(n, 10.0), -40, 1e-3)));
    cases.extend([(2, -40, 1e-9), (3, -40, 1e-2), (4, -60, 0.2)].map(|(k, m, e)| (shapes::boundary_vertex(k), m, e)));
    cases.push((rounded(&shapes::boundary_vertex(1)), -30, 0.1));
    cases.push((pinned(&shapes::boundary_vertex(1)), -40, 1e-9));
    cases.push((pinned(&shapes::boundary_vertex(2)), -900, 2e-2));
    for (shape, depth, bound) in cases {
        for method in [Method::Deflated, Method::Eigenbasis] {
            let at = at_vertex(&shape, 0.0, method);
            assert!(at.unique_plane, "{}", shape.name);
            let near = at_vertex(&shape, 2f64.powi(depth), method);
            let normal =
                |jet: &Jet<3>| jet.normal().unwrap_or_else(|| panic!("{} {method:?}: no normal, {jet:?}", shape.name));
            let error = apart(normal(&at), normal(&near));

            assert!(error < bound, "{} {method:?}: normals {error:.1e} apart", shape.name);
        }
    }
}

#[test]
fn a_plane_is_said_to_be_unique_where_the_normal_does_not_depend_on_the_approach() {
    for k in 1..9 {
        let jet = |shape: &Shape| at_vertex(shape, 0.0, Method::Deflated);
        assert_eq!(jet(&rounded(&shapes::boundary_vertex(k))).unique_plane, k <= 4, "crease of {k} faces");
        assert_eq!(jet(&pinned(&shapes::boundary_vertex(k))).unique_plane, k <= 2, "corner of {k} faces");
        assert!(jet(&rounded(&shapes::boundary_vertex(k))).plane.is_some());
        assert!(jet(&pinned(&shapes::boundary_vertex(k))).plane.is_some());
    }
    for n in [3, 4, 5, 9] {
        let cone = at_vertex(&pinned(&shapes::interior_vertex(n)), 0.0, Method::Deflated);
        assert!(cone.plane.is_none() && cone.normal().is_none(), "a cone point of valence {n} has no plane");
    }
    let fold = at_vertex(&shapes::interior_vertex(2), 0.0, Method::Deflated);
    assert!(fold.plane.is_none(), "valence 2 has no plane");
}
