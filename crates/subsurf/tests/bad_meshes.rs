//! Meshes that are no manifolds, or hardly meshes: nothing panics, every number is finite, and where faces are at least
//! simple polygons the limit is still that of refinement.

mod brute_force;
mod random_mesh;

use brute_force::{Soup, apart, diagonal};
use proptest::prelude::*;
use random_mesh::{Parameter, SHARPNESS, edges_of, for_all, place, random_points};
use subsurf::{
    Boundary, ControlMesh, Corner, Crease, Creasing, Face, Level, Location, Method, PatchTable, Rules, Scheme, Tags,
    Topology, Triangles,
};

/// A random list of faces over a few vertices.
#[derive(Clone, Debug)]
struct Garbage {
    faces: Vec<Vec<u32>>,
    isolated: u32,
    creases: Vec<(u16, u8)>,
    corners: Vec<(u16, u8)>,
    holes: Vec<u16>,
    boundary: Boundary,
    chaikin: bool,
    smooth_triangles: bool,
    places: Vec<(u16, u8, Parameter, Parameter)>,
}

/// With `simple`, faces visit no vertex twice.
fn garbage(simple: bool) -> impl Strategy<Value = Garbage> {
    use proptest::collection::vec;
    let boundary = prop_oneof![Just(Boundary::None), Just(Boundary::EdgeOnly), Just(Boundary::EdgeAndCorner)];
    let faces = (4..12u32).prop_flat_map(move |n| {
        let face = if simple {
            let sides = 3..(n as usize + 1).min(6);
            proptest::sample::subsequence((0..n).collect::<Vec<u32>>(), sides).prop_shuffle().boxed()
        } else {
            vec(0..n, 3..6).boxed()
        };
        vec(face, 1..12)
    });
    let tags =
        (vec((any::<u16>(), any::<u8>()), 0..6), vec((any::<u16>(), any::<u8>()), 0..3), vec(any::<u16>(), 0..3));
    (faces, 0..3u32, tags, boundary, any::<(bool, bool)>(), vec(place(), 4)).prop_map(
        |(faces, isolated, (creases, corners, holes), boundary, (chaikin, smooth_triangles), places)| Garbage {
            faces,
            isolated,
            creases,
            corners,
            holes,
            boundary,
            chaikin,
            smooth_triangles,
            places,
        },
    )
}

impl Garbage {
    fn mesh(&self) -> ControlMesh {
        let vertices = self.faces.iter().flatten().max().map_or(0, |v| v + 1) + self.isolated;
        let edges: Vec<(u32, u32)> = edges_of(&self.faces).into_keys().filter(|(a, b)| a != b).collect();
        let value = |s: u8| SHARPNESS[usize::from(s) % SHARPNESS.len()];
        let crease = |&(e, s): &(u16, u8)| {
            let (a, b) = edges[usize::from(e) % edges.len()];
            Crease::new(a, b, value(s))
        };
        let tags = Tags {
            creases: if edges.is_empty() { Vec::new() } else { self.creases.iter().map(crease).collect() },
            corners: self.corners.iter().map(|&(v, s)| Corner::new(u32::from(v) % vertices, value(s))).collect(),
            holes: self.holes.iter().map(|&f| u32::from(f) % self.faces.len() as u32).collect(),
            rules: Rules {
                boundary: self.boundary,
                creasing: if self.chaikin { Creasing::Chaikin } else { Creasing::Uniform },
                triangles: if self.smooth_triangles { Triangles::Smooth } else { Triangles::CatmullClark },
                ..Rules::default()
            },
        };
        let counts: Vec<u32> = self.faces.iter().map(|f| f.len() as u32).collect();
        ControlMesh::from_counts(vertices as usize, &counts, self.faces.concat(), tags).expect("a valid mesh")
    }

    fn locations(&self) -> Vec<Location> {
        let place = |&(face, sub, u, v): &(u16, u8, Parameter, Parameter)| {
            let face = usize::from(face) % self.faces.len();
            let sides = self.faces[face].len();
            let subface = if sides == 4 { 0 } else { u32::from(sub) % sides as u32 };
            Location { face: Face::new(face), subface, u: u.value(), v: v.value() }
        };
        self.places.iter().map(place).collect()
    }
}

fn finite(what: &str, values: impl IntoIterator<Item = f64>) -> Result<(), String> {
    if values.into_iter().all(f64::is_finite) { Ok(()) } else { Err(format!("{what} is not finite")) }
}

fn survives(garbage: &Garbage) -> Result<(), String> {
    let mesh = garbage.mesh();
    let points = random_points(mesh.vertex_count(), 7);
    Topology::new(&mesh).map_err(|e| e.to_string())?.check()?;
    for scheme in [Scheme::CatmullClark, Scheme::Bilinear] {
        let mut level = Level::new(&mesh, scheme).map_err(|e| e.to_string())?;
        let mut values = points.clone();
        for _ in 0..2 {
            values = level.refine_values(&values);
            level = level.refine().map_err(|e| e.to_string())?;
            level.topology().check()?;
            finite("a refined point", values.iter().flatten().copied())?;
        }
        for method in [Method::Deflated, Method::Eigenbasis] {
            let table = PatchTable::with_method(&mesh, scheme, method).map_err(|e| e.to_string())?;
            let surface = table.surface(&points);
            for at in garbage.locations() {
                let Some(jet) = surface.eval_second(at) else { continue };
                finite("a position", jet.position)?;
                finite("a first derivative", [jet.du, jet.dv].concat())?;
                finite("a second derivative", jet.second.iter().flatten().flatten().copied())?;
                finite("a tangent", jet.plane.iter().flatten().flatten().copied())?;
                finite("a normal", jet.normal().into_iter().flatten())?;
                // Weights are those of an affine combination, never large: at most 6 at a location.
                let size = jet.position.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                if size > 6.0 {
                    return Err(format!("{at:?} lies at {:?}", jet.position));
                }
            }
        }
    }
    Ok(())
}

fn meets_refinement(garbage: &Garbage) -> Result<(), String> {
    let mesh = garbage.mesh();
    let points = random_points(mesh.vertex_count(), 7);
    let soup = Soup::new(&mesh, Scheme::CatmullClark, &points);
    for method in [Method::Deflated, Method::Eigenbasis] {
        let table = PatchTable::with_method(&mesh, Scheme::CatmullClark, method).map_err(|e| e.to_string())?;
        for at in garbage.locations() {
            match (table.surface(&points).position(at), soup.eval(at)) {
                (None, None) => {}
                (Some(p), Some(truth)) => {
                    let error = apart(p, truth.position) / diagonal(&points);
                    // Rounding, as on any other mesh.
                    if error.is_nan() || error > 1e-12 {
                        return Err(format!("{method:?} {at:?}: position off by {error:.1e}"));
                    }
                }
                (p, _) => return Err(format!("{at:?}: is it a hole? The table says {}", p.is_none())),
            }
        }
    }
    Ok(())
}

#[test]
fn no_list_of_faces_makes_anything_panic_or_infinite() {
    for_all(garbage(false), 400, 1, survives);
}

#[test]
fn any_list_of_simple_polygons_has_the_limit_of_its_refinement() {
    for_all(garbage(true), 300, 2, meets_refinement);
}

#[test]
#[ignore = "minutes"]
fn many_lists_of_faces_survive_and_have_the_limit_of_their_refinement() {
    for_all(garbage(false), 20_000, 3, survives);
    for_all(garbage(true), 20_000, 4, meets_refinement);
}
