//! What a patch table takes in memory where very many faces meet, estimated before anything large is made.
//!
//! `n` faces round a vertex have rings of about `2 n` points each (`n` under Loop), and each ring that looks different from the
//! others has a plan of its own. How many look different follows from the list of spokes: one that repeats itself after `q` faces
//! tells `q` of them apart, a boundary or a single crease tells all of them apart. The same holds for the sub-faces of a face of `n`
//! corners, whose plans have some points over all corners each, and grow with the square by themselves. The estimate is above what
//! is taken, by up to five times where sharpness is finite.

use super::fans::Fans;
use super::plan_key::{KeyHasher, corner_signature};
use crate::index::{Face, HalfEdge, Vertex};
use crate::mesh::{MeshError, Pole};
use crate::scheme::Scheme;
use crate::sharpness::is_semi_sharp;
use crate::topology::{FaceOf, Topology};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::hash::Hasher;

/// Bytes that a [`PatchTable`](crate::PatchTable) may take while it is made for what grows with the square of the number of faces
/// round a manifold vertex, or of corners of a face: 4 GiB for one such place. Faces that look alike share what grows; several such
/// places that differ add up.
///
/// That admits a smooth vertex of some 14,000 quads or 20,000 triangles under Loop, a boundary vertex or dart of some 4,800 or
/// 4,500, and a face of some 500 corners that all look different. Larger ones are refused with
/// [`MeshError::PoleTooLarge`] before anything large is made. Uniform refinement has no such limit.
pub const MOST_POLE_BYTES: u64 = 4 << 30;

/// Bytes per point of a ring: four, and up to six more while rings are gathered.
const RING_BYTES: u64 = 10;

/// Bytes per point of a ring and generation of nodes of a plan, keys and temporary memory included: of quads, which are known by
/// fans, and of other faces, which are met by walks. The test `estimates_are_above_what_tables_take` holds them against the allocator.
const PLAN_BYTES: [u64; 2] = [80, 200];

/// Bytes of a plan per square of its face's corners: the points round the middle of the face, each over all corners.
const FACE_BYTES: u64 = 32;

/// Points of the faces at a vertex, and faces there or corners of a face, from which on it is counted. Smaller: time for vertices
/// whose memory is small beside the mesh's own; larger: many vertices below it could add up.
const MANY_POINTS: usize = 128;
const MANY_SIDES: usize = 64;

/// What one vertex or large face takes.
#[derive(Default)]
struct Charge {
    faces: usize,
    /// Points in the rings of all its faces.
    ring_points: u64,
    /// Bytes of the plans of faces that look different.
    plan_bytes: u64,
}

/// Where a half-edge lies round a vertex of many faces: the number of the vertex among these, and its place in what the spokes
/// repeat.
type Places = HashMap<u32, (u32, u32)>;

/// Refuses an edit after which the faces of `t` that are made anew would take more than [`MOST_POLE_BYTES`] at one place.
///
/// # Errors
/// As [`check`].
pub(crate) fn check_edit(t: &Topology, scheme: Scheme, is_new: impl Fn(Face) -> bool) -> Result<(), MeshError> {
    check_some(t, scheme, &Fans::new(t, Vec::new()), is_new, MOST_POLE_BYTES)
}

/// Refuses meshes whose rings and plans would take more than [`MOST_POLE_BYTES`] at one place. Numbers of vertices and faces are
/// those of `t`.
///
/// # Errors
/// [`MeshError::PoleTooLarge`] names the place that takes most.
pub(super) fn check(t: &Topology, scheme: Scheme, fans: &Fans) -> Result<(), MeshError> {
    check_some(t, scheme, fans, |_| true, MOST_POLE_BYTES)
}

fn check_some(
    t: &Topology,
    scheme: Scheme,
    fans: &Fans,
    is_new: impl Fn(Face) -> bool,
    limit: u64,
) -> Result<(), MeshError> {
    // Faces at a vertex that is no manifold see those of their own fan alone; how many that are is not known here.
    let poles = fans.many_points(t, MANY_POINTS).filter(|&(v, _)| !t.is_non_manifold_vertex(Vertex(v)));
    let poles: BTreeMap<u32, usize> = poles.collect();
    let most_sides = || t.face_offset.windows(2).fold(0, |most, w| most.max(w[1] - w[0]));
    let has_large_faces = matches!(t.face, FaceOf::Listed(_)) && most_sides() as usize >= MANY_SIDES;
    if poles.is_empty() && !has_large_faces {
        return Ok(());
    }
    let mut places = Places::new();
    for &v in poles.keys() {
        let (spokes, period) = spokes(t, Vertex(v));
        // Others have many points for a large face.
        if spokes.len() < MANY_SIDES {
            continue;
        }
        places.extend(spokes.into_iter().zip(0..).map(|(h, place)| (h.0, (v, place % period))));
    }
    let (mut charges, mut looks) = (BTreeMap::<(bool, u32), Charge>::new(), HashSet::new());
    for face in (0..t.face_count()).map(Face::new).filter(|&face| !t.is_hole(face) && is_new(face)) {
        let sides = t.sides(face);
        let most = t.face_vertices(face).iter().filter_map(|v| Some((*poles.get(v)?, *v))).max();
        let ring = || super::gather::others(t, scheme.patch_sides(), fans, face) as u64;
        let plan_bytes = PLAN_BYTES[usize::from(sides != 4)];
        if sides >= MANY_SIDES {
            let ring = ring();
            let charge = charges.entry((false, face.0)).or_default();
            (charge.faces, charge.ring_points) = (sides, ring);
            // Its sub-faces look as different as its corners do.
            let corners: Vec<u64> = (0..sides).map(|c| look(t, t.half_edge(face, c), &places)).collect();
            let sides = sides as u64;
            let middle = if scheme == Scheme::Bilinear { 0 } else { FACE_BYTES * sides * sides };
            charge.plan_bytes =
                (ring / sides * plan_bytes).saturating_add(middle).saturating_mul(period(&corners) as u64);
            continue;
        }
        let Some((_, v)) = most else { continue };
        let ring = ring();
        let charge = charges.entry((true, v)).or_default();
        charge.faces += 1;
        charge.ring_points += ring;
        let first = (0..sides).find(|&c| t.origin(t.half_edge(face, c)).0 == v).unwrap_or(0);
        let mut hash = KeyHasher::default();
        (0..sides).for_each(|c| hash.write_u64(look(t, t.half_edge(face, (first + c) % sides), &places)));
        if looks.insert(hash.finish()) {
            charge.plan_bytes += ring * plan_bytes;
        }
    }
    let bytes = |(&(is_vertex, at), charge): (&(bool, u32), &Charge)| {
        let generations = if is_vertex { generations(t, Vertex(at)) } else { 1 };
        let plans = charge.plan_bytes.saturating_mul(generations);
        (plans.saturating_add(charge.ring_points.saturating_mul(RING_BYTES)), is_vertex, at)
    };
    match charges.iter().map(bytes).max() {
        Some((bytes, is_vertex, at)) if bytes > limit => {
            let count = charges[&(is_vertex, at)].faces;
            let pole = if is_vertex {
                Pole::Vertex { vertex: at, faces: count }
            } else {
                Pole::Face { face: at, corners: count }
            };
            Err(MeshError::PoleTooLarge { pole, bytes, limit })
        }
        _ => Ok(()),
    }
}

/// The half-edges round a vertex, and after how many of them what is seen of their faces and sharpness repeats itself.
fn spokes(t: &Topology, v: Vertex) -> (Vec<HalfEdge>, u32) {
    let mut spokes = Vec::new();
    let is_closed = t.walk_fan(v, |h| spokes.push(h));
    let sides = |h: HalfEdge| (t.sides(t.face(h)) as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let seen = |&h: &HalfEdge| sides(h) ^ t.edge_sharpness(t.edge(h)).to_bits();
    let seen: Vec<u64> = spokes.iter().map(seen).collect();
    let period = if is_closed { period(&seen) } else { seen.len() };
    (spokes, period.max(1) as u32)
}

/// The least number of places by which a cyclic list may be turned so that it stays the same (Knuth, Morris and Pratt 1977).
fn period(list: &[u64]) -> usize {
    // Length of the longest proper end of each beginning that is a beginning itself.
    let mut border = vec![0; list.len()];
    for i in 1..list.len() {
        let mut k = border[i - 1];
        while k > 0 && list[i] != list[k] {
            k = border[k - 1];
        }
        border[i] = if list[i] == list[k] { k + 1 } else { 0 };
    }
    let period = list.len() - border.last().copied().unwrap_or(0);
    if period > 0 && list.len().is_multiple_of(period) { period } else { list.len() }
}

/// What tells a corner from others: at a vertex of many faces its place, which takes no walk round all of them.
fn look(t: &Topology, h: HalfEdge, places: &Places) -> u64 {
    match places.get(&h.0) {
        Some(&(v, place)) => u64::MAX ^ (u64::from(v) << 32 | u64::from(place)),
        None if t.is_non_manifold_vertex(t.origin(h)) => u64::from(h.0) << 24,
        None => corner_signature(t, h, 0),
    }
}

/// Nodes one below the other that a face at a vertex may have: one takes a step from all finite sharpness.
fn generations(t: &Topology, v: Vertex) -> u64 {
    let spokes = t.sharp_edges(v).iter().map(|&e| t.edge_sharpness(crate::index::Edge(e)));
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    for s in spokes.chain([t.vertex_sharpness(v)]).filter(|&s| is_semi_sharp(s)) {
        (least, most) = (least.min(s), most.max(s));
    }
    if most == 0.0 { 1 } else { (most.ceil() - least.floor()) as u64 + 2 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::ControlMesh;
    use crate::tags::{Crease, Tags};

    /// Quads round vertex 0, closed or not.
    fn fan(n: u32, is_closed: bool, creases: Vec<Crease>) -> Topology {
        let columns = if is_closed { 2 * n } else { 2 * n + 1 };
        let at = |i: u32| 1 + i % columns;
        let faces: Vec<[u32; 4]> = (0..n).map(|i| [0, at(2 * i), at(2 * i + 1), at(2 * i + 2)]).collect();
        Topology::new(&ControlMesh::new(&faces, Tags { creases, ..Tags::default() }).unwrap()).unwrap()
    }

    /// The bytes that are estimated, as a refusal tells.
    fn estimate(t: &Topology, scheme: Scheme) -> (Option<Pole>, u64) {
        match check_some(t, scheme, &Fans::new(t, Vec::new()), |_| true, 0) {
            Err(MeshError::PoleTooLarge { pole, bytes, .. }) => (Some(pole), bytes),
            _ => (None, 0),
        }
    }

    #[test]
    fn a_limit_admits_what_is_estimated_and_nothing_more() {
        let t = fan(200, false, Vec::new());
        let (pole, bytes) = estimate(&t, Scheme::CatmullClark);
        assert_eq!(pole, Some(Pole::Vertex { vertex: 0, faces: 200 }));
        let fans = Fans::new(&t, Vec::new());
        let with_limit = |limit| check_some(&t, Scheme::CatmullClark, &fans, |_| true, limit);
        assert!(with_limit(bytes).is_ok() && with_limit(bytes - 1).is_err());
        assert!(check(&t, Scheme::CatmullClark, &fans).is_ok());
    }

    #[test]
    fn each_place_is_asked_for_itself() {
        // Two fans with nothing in common.
        let one: Vec<[u32; 4]> = (0..200).map(|i| [0, 1 + 2 * i, 2 + 2 * i, 3 + 2 * i]).collect();
        let two: Vec<[u32; 4]> = one.iter().copied().chain(one.iter().map(|f| f.map(|v| v + 500))).collect();
        let of = |faces: &[[u32; 4]]| Topology::new(&ControlMesh::new(faces, Tags::default()).unwrap()).unwrap();
        assert_eq!(estimate(&of(&one), Scheme::CatmullClark).1, estimate(&of(&two), Scheme::CatmullClark).1);
    }

    #[test]
    fn faces_that_look_alike_are_counted_once() {
        let dart = |s: f64| vec![Crease::new(0, 1, s)];
        let points = |creases| estimate(&fan(300, true, creases), Scheme::CatmullClark).1;
        let smooth = points(Vec::new());
        let sharp = points(dart(10.0));
        let crossed = points((0..4).map(|k| Crease::new(0, 1 + 150 * k, 10.0)).collect());
        let semi_sharp = points(dart(2.5));
        assert!(
            smooth * 8 < sharp && 40 * (crossed - smooth) < 11 * (sharp - smooth) && sharp * 2 < semi_sharp,
            "{smooth} {sharp} {semi_sharp}"
        );
    }

    #[test]
    fn few_faces_are_not_counted() {
        assert_eq!(estimate(&fan(40, false, Vec::new()), Scheme::CatmullClark), (None, 0));
    }

    #[test]
    fn a_face_of_many_corners_is_named() {
        let n = 300;
        let mut faces: Vec<Vec<u32>> = (0..n).map(|i| vec![i, n + i, n + (i + 1) % n, (i + 1) % n]).collect();
        faces.push((0..n).collect());
        let t = Topology::new(&ControlMesh::new(&faces, Tags::default()).unwrap()).unwrap();
        let (pole, bytes) = estimate(&t, Scheme::CatmullClark);
        assert_eq!(pole, Some(Pole::Face { face: n, corners: 300 }));
        // All corners look alike: rings alone.
        assert!(bytes < 200 * 300 * 300, "{bytes}");
    }

    #[test]
    fn periods_are_those_of_turns() {
        assert_eq!([&[1][..], &[1, 1, 1], &[1, 2, 1, 2], &[1, 2, 1], &[1, 1, 2, 1, 1, 2]].map(period), [1, 1, 2, 3, 3]);
    }
}
