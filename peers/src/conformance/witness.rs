//! The judge between two limits: OpenSubdiv's own refinement, carried on round one point for as many levels as wanted.
//!
//! The limit at a point depends on the faces that touch the face (or vertex) where the point lies, with their sharpness.
//! So one step is: hand these few faces to OpenSubdiv as a mesh, refine it once (`Far::PrimvarRefiner`, double
//! precision), keep what touches the child. The faces' outer rim gets wrong rules, and is dropped before they tell. Once
//! the point is a vertex, its one-ring is refined on; the points are kept relative to the vertex, so that directions stay
//! exact at any depth.
//!
//! All masks are averages, so the limit never leaves the one-ring's hull: `radius`, the distance to the farthest ring
//! point, bounds how far the refined point can still move.

use super::place::{Place, places};
use super::vector::{cross, length, sub, unit};
use crate::opensubdiv::{self, OsdLevel, VertexOrder};
use crate::shape::{Scheme, Shape};
use subsurf::{Boundary, Corner, Crease};

/// A point's way to the limit.
#[derive(Clone, Debug)]
pub struct Witness {
    /// The refined vertex, level by level from the first one that has a vertex there.
    pub points: Vec<[f64; 3]>,
    /// Unit normal of its one-ring on the face's side of sharp edges, level by level; none where the ring is folded flat or OpenSubdiv's vertex is not
    /// manifold.
    pub normals: Vec<Option<[f64; 3]>>,
    /// Bound on how far the last of the points is from the limit.
    pub radius: f64,
    /// First and second derivatives along two directions of (u, v), by differences of refined points; at vertices inside
    /// a patch.
    pub along: Option<[Along; 2]>,
}

/// Derivatives in one direction.
#[derive(Clone, Copy, Debug)]
pub struct Along {
    /// The step in (u, v).
    pub direction: [f64; 2],
    pub first: [f64; 3],
    pub second: [f64; 3],
}

impl Witness {
    pub fn limit(&self) -> [f64; 3] {
        *self.points.last().expect("at least one level")
    }

    pub fn normal(&self) -> Option<[f64; 3]> {
        self.normals.last().copied().flatten()
    }
}

/// The few faces round a face or a vertex, as a mesh of their own. The face is number 0, the vertex number 0.
struct Neighbourhood {
    shape: Shape,
    /// Ends of several edges, which a mesh of its own would take for one.
    doubled: Vec<[u32; 2]>,
}

impl Neighbourhood {
    /// The faces of `level` that touch one of `seeds`, those of `first` foremost; `seeds` become vertices 0, 1, ….
    fn cut(like: &Shape, level: &OsdLevel, starts: &[usize], seeds: &[u32], first: Option<usize>) -> Self {
        let corners = |f: usize| &level.face_vertices[starts[f]..starts[f + 1]];
        let touching = (0..level.face_counts.len()).filter(|&f| corners(f).iter().any(|v| seeds.contains(v)));
        let faces: Vec<usize> = first.into_iter().chain(touching.filter(|&f| Some(f) != first)).collect();
        Self::of_faces(like, level, starts, seeds, &faces)
    }

    fn of_faces(like: &Shape, level: &OsdLevel, starts: &[usize], seeds: &[u32], faces: &[usize]) -> Self {
        let mut vertices = seeds.to_vec();
        let mut shape = Shape {
            name: like.name.clone(),
            scheme: like.scheme,
            positions: vec![],
            counts: vec![],
            indices: vec![],
            tags: subsurf::Tags { rules: like.tags.rules, ..subsurf::Tags::default() },
            channel: None,
        };
        // What the boundary rule does to corners is in their sharpness already.
        shape.tags.rules.boundary = Boundary::EdgeOnly;
        let (mut edges, mut doubled) = (vec![], vec![]);
        for &f in faces {
            let range = starts[f]..starts[f + 1];
            shape.counts.push(range.len() as u32);
            for c in range {
                let v = level.face_vertices[c];
                let local = vertices.iter().position(|&w| w == v).unwrap_or_else(|| {
                    vertices.push(v);
                    vertices.len() - 1
                });
                shape.indices.push(local as u32);
                edges.push(level.face_edges[c]);
            }
        }
        let local = |v: u32| vertices.iter().position(|&w| w == v).expect("a vertex of the faces") as u32;
        edges.sort_unstable();
        edges.dedup();
        let mut pairs = vec![];
        for e in edges {
            let sharpness = level.edge_sharpness[e as usize];
            let [a, b] = level.edges[e as usize].map(local);
            let pair = [a.min(b), a.max(b)];
            if pairs.contains(&pair) {
                doubled.push(pair);
            }
            pairs.push(pair);
            if sharpness > 0.0 {
                shape.tags.creases.push(Crease::new(a, b, f64::from(sharpness)));
            }
        }
        for (i, &v) in vertices.iter().enumerate() {
            let sharpness = level.vertex_sharpness[v as usize];
            if sharpness > 0.0 {
                shape.tags.corners.push(Corner::new(i as u32, f64::from(sharpness)));
            }
            shape.positions.push(level.positions[v as usize]);
        }
        Self { shape, doubled }
    }

    /// False where edges at one of these vertices are not what they were in the mesh they are cut from.
    fn is_true_at(&self, vertices: &[u32]) -> bool {
        !self.doubled.iter().flatten().any(|v| vertices.contains(v))
    }

    /// Levels 0 and 1.
    fn refine(&self) -> Result<[OsdLevel; 2], String> {
        let levels = opensubdiv::refine(&self.shape, 1, VertexOrder::VerticesFirst)?;
        Ok(levels.try_into().expect("two levels"))
    }
}

/// Number of the first corner of every face, and of all corners.
pub fn face_starts(level: &OsdLevel) -> Vec<usize> {
    let ends = level.face_counts.iter().scan(0, |end, &n| {
        *end += n as usize;
        Some(*end)
    });
    std::iter::once(0).chain(ends).collect()
}

/// A level of a whole mesh, ready to be cut into neighbourhoods.
pub struct Start {
    level: OsdLevel,
    starts: Vec<usize>,
    places: Vec<Place>,
    depth: u32,
    faces_of: Vec<Vec<u32>>,
}

impl Start {
    /// # Errors
    /// What OpenSubdiv says when it refuses the mesh.
    pub fn new(shape: &Shape, depth: u32) -> Result<Self, String> {
        let level = opensubdiv::refine(shape, depth, VertexOrder::VerticesFirst)?.pop().expect("a level");
        let starts = face_starts(&level);
        let mut faces_of = vec![vec![]; level.positions.len()];
        for f in 0..level.face_counts.len() {
            level.face_vertices[starts[f]..starts[f + 1]].iter().for_each(|&v| faces_of[v as usize].push(f as u32));
        }
        let places = places(shape, depth).pop().expect("a level");
        Ok(Self { level, starts, places, depth, faces_of })
    }

    /// The limit of OpenSubdiv's refinement at `at` of a patch, whose coordinates must be multiples of a power of two.
    /// None in holes, and where several edges join the same two vertices, which no mesh of its own can tell.
    ///
    /// # Errors
    /// What OpenSubdiv says when it refuses a mesh.
    pub fn follow(
        &self,
        shape: &Shape,
        face: u32,
        subface: u32,
        at: [f64; 2],
        most: usize,
    ) -> Result<Option<Witness>, String> {
        let scheme = shape.scheme;
        let here = |p: &Place| p.face == face && p.subface == subface && p.contains(scheme, at);
        let Some(f) = self.places.iter().position(here) else { return Ok(None) };
        if self.level.holes[f] {
            return Ok(None);
        }
        let seeds = &self.level.face_vertices[self.starts[f]..self.starts[f + 1]];
        let mut faces: Vec<usize> =
            seeds.iter().flat_map(|&v| self.faces_of[v as usize].iter().map(|&f| f as usize)).collect();
        faces.sort_unstable();
        faces.dedup();
        faces.retain(|&g| g != f);
        faces.insert(0, f);
        let mut near = Neighbourhood::of_faces(shape, &self.level, &self.starts, seeds, &faces);
        let (mut place, mut depth) = (self.places[f], self.depth);
        let sides = if scheme == Scheme::Loop { 3 } else { 4 };
        loop {
            if let Some(corner) = (0..sides).find(|&c| place.corners[c] == at) {
                return follow_vertex(near, place, corner, most);
            }
            if !near.is_true_at(&near.shape.indices[..sides]) {
                return Ok(None);
            }
            assert!(depth < 40, "the place is a vertex of some level");
            let [_, level] = near.refine()?;
            let starts = face_starts(&level);
            let children = place.children(scheme);
            let child = (0..4).find(|&c| children[c].contains(scheme, at)).expect("one child has the place");
            place = children[child];
            let seeds = level.face_vertices[starts[child]..starts[child + 1]].to_vec();
            near = Neighbourhood::cut(shape, &level, &starts, &seeds, Some(child));
            depth += 1;
        }
    }
}

/// From a neighbourhood whose face 0 has the place at `corner`.
fn follow_vertex(near: Neighbourhood, place: Place, corner: usize, most: usize) -> Result<Option<Witness>, String> {
    let vertex = near.shape.indices[corner];
    if !near.is_true_at(&[vertex]) {
        return Ok(None);
    }
    let start = near.shape;
    let sides = start.counts[0] as usize;
    let own = &start.indices[..sides];
    let (ahead, behind) = (own[(corner + 1) % sides], own[(corner + sides - 1) % sides]);
    let offset = |to: usize| [0, 1].map(|k| place.corners[to][k] - place.corners[corner][k]);
    let directions = [offset((corner + 1) % sides), offset((corner + sides - 1) % sides)];

    // Level 0 of a refiner tells flags and edges in the form that cuts need.
    let scale = start.diagonal();
    let level = opensubdiv::refine(&start, 0, VertexOrder::VerticesFirst)?.pop().expect("level 0");
    let manifold = !level.vertex_non_manifold[vertex as usize];
    let mut near = Neighbourhood::cut(&start, &level, &face_starts(&level), &[vertex], None);
    // The ring's vertices keep their order of appearance; find the two arms again by position in the faces.
    let inside = inside_patch(start.scheme, place.corners[corner]);
    let mut arms = None;
    if manifold && inside {
        let order: Vec<[u32; 2]> = spokes(&level.face_counts, &level.face_vertices, vertex);
        arms = opposite(&order, ahead).zip(opposite(&order, behind)).map(|(a, b)| [ahead, a, behind, b]);
        let map = renumbering(&level, vertex);
        arms = arms.map(|arms| arms.map(|v| map.iter().position(|&w| w == v).expect("a ring vertex") as u32));
    }

    let mut origin = [0.0; 3];
    let mut witness = Witness { points: vec![], normals: vec![], radius: 0.0, along: None };
    let mut quotients: Vec<[[[f64; 3]; 2]; 2]> = vec![];
    for step in 0.. {
        // The vertex moves to the origin.
        let centre = near.shape.positions[0];
        near.shape.positions.iter_mut().for_each(|p| *p = sub(*p, centre));
        origin = [0, 1, 2].map(|k| origin[k] + centre[k]);
        witness.points.push(origin);
        witness.normals.push(if manifold { ring_normal(&near.shape) } else { None });
        witness.radius = near.shape.positions.iter().map(|&p| length(p)).fold(0.0, f64::max);
        if let Some([a, a_opposite, b, b_opposite]) = arms {
            let p = |v: u32| near.shape.positions[v as usize];
            let h = 0.5f64.powi(step);
            let quotient = |v, w| {
                [[0, 1, 2].map(|k| (p(v)[k] - p(w)[k]) / (2.0 * h)), [0, 1, 2].map(|k| (p(v)[k] + p(w)[k]) / (h * h))]
            };
            quotients.push([quotient(a, a_opposite), quotient(b, b_opposite)]);
        }
        if step as usize >= most || (step >= 12 && witness.radius < 1e-13 * scale) {
            break;
        }
        let [parent, level] = near.refine()?;
        if let Some(arms) = &mut arms {
            *arms = arms.map(|v| child_of_spoke(&parent, &level, v));
            let map = renumbering(&level, 0);
            *arms = arms.map(|v| map.iter().position(|&w| w == v).expect("a ring vertex") as u32);
        }
        near = Neighbourhood::cut(&near.shape, &level, &face_starts(&level), &[0], None);
        if !near.is_true_at(&[0]) {
            return Ok(None);
        }
    }
    // Errors of order h²: two quotients cancel it. Seven halvings leave 4^-14 and 2^7 roundings, of the second ones 4^7.
    if quotients.len() > 8 {
        let best = |arm: usize, kind: usize, n: usize| {
            let [coarse, fine] = [quotients[n - 1][arm][kind], quotients[n][arm][kind]];
            [0, 1, 2].map(|k| (4.0 * fine[k] - coarse[k]) / 3.0)
        };
        let along = |arm| Along { direction: directions[arm], first: best(arm, 0, 8), second: best(arm, 1, 6) };
        witness.along = Some([along(0), along(1)]);
    }
    Ok(Some(witness))
}

fn inside_patch(scheme: Scheme, [u, v]: [f64; 2]) -> bool {
    let beyond = if scheme == Scheme::Loop { u + v < 1.0 } else { u < 1.0 && v < 1.0 };
    u > 0.0 && v > 0.0 && beyond
}

/// Per face round `vertex`, the vertices after it and before it.
fn spokes(counts: &[u32], indices: &[u32], vertex: u32) -> Vec<[u32; 2]> {
    let (mut out, mut start) = (vec![], 0);
    for &n in counts {
        let face = &indices[start..start + n as usize];
        for i in 0..face.len() {
            if face[i] == vertex {
                out.push([face[(i + 1) % face.len()], face[(i + face.len() - 1) % face.len()]]);
            }
        }
        start += n as usize;
    }
    out
}

/// The spoke across an interior vertex of even valence.
fn opposite(spokes: &[[u32; 2]], from: u32) -> Option<u32> {
    if spokes.len() % 2 == 1 {
        return None;
    }
    let mut at = from;
    for _ in 0..spokes.len() / 2 {
        at = spokes.iter().find(|s| s[0] == at)?[1];
    }
    Some(at)
}

/// The vertices of the faces round `vertex` in the order in which a cut numbers them.
fn renumbering(level: &OsdLevel, vertex: u32) -> Vec<u32> {
    let (mut order, mut start) = (vec![vertex], 0);
    for &n in &level.face_counts {
        let face = &level.face_vertices[start..start + n as usize];
        if face.contains(&vertex) {
            for v in face {
                if !order.contains(v) {
                    order.push(*v);
                }
            }
        }
        start += n as usize;
    }
    order
}

/// The vertex of the next level on the edge from vertex 0 to `end`.
fn child_of_spoke(parent: &OsdLevel, level: &OsdLevel, end: u32) -> u32 {
    let edge = parent.edges.iter().position(|e| *e == [0, end] || *e == [end, 0]).expect("a spoke is an edge") as u32;
    let origin = opensubdiv::Origin::Edge(edge);
    level.vertex_origins.iter().position(|o| *o == origin).expect("every edge has a child") as u32
}

/// Unit normal at vertex 0, which lies at the origin, of the faces between infinitely sharp edges that face 0 is among.
fn ring_normal(shape: &Shape) -> Option<[f64; 3]> {
    let spokes = spokes(&shape.counts, &shape.indices, 0);
    let sharp = |v: u32| {
        let is = |c: &Crease| c.vertices.contains(&0) && c.vertices.contains(&v) && c.sharpness >= 10.0;
        shape.tags.creases.iter().any(is)
    };
    let mut sector = vec![spokes[0]];
    let mut at = spokes[0][1];
    while let Some(&next) = spokes.iter().find(|s| s[0] == at).filter(|s| !sharp(at) && !sector.contains(s)) {
        sector.push(next);
        at = next[1];
    }
    at = spokes[0][0];
    while let Some(&before) = spokes.iter().find(|s| s[1] == at).filter(|s| !sharp(at) && !sector.contains(s)) {
        sector.push(before);
        at = before[0];
    }
    let (mut sum, mut size) = ([0.0; 3], 0.0);
    for [next, prev] in sector {
        let n = cross(shape.positions[next as usize], shape.positions[prev as usize]);
        sum = [0, 1, 2].map(|k| sum[k] + n[k]);
        size += length(n);
    }
    // A ring folded flat cancels to rounding.
    if length(sum) > 1e-6 * size { unit(sum) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_a_skewed_grid_the_limit_is_the_affine_map_itself() {
        // Vertex (i, j) lies at (2i + j, 3j, 1); face 4 is the middle one of 3 × 3.
        let points: String = (0..16).map(|k| format!("v {} {} 1\n", 2 * (k % 4) + k / 4, 3 * (k / 4))).collect();
        let face = |k: u32| {
            let v = k % 3 + 4 * (k / 3) + 1;
            format!("f {v} {} {} {}\n", v + 1, v + 5, v + 4)
        };
        let faces: String = (0..9).map(face).collect();
        let shape = Shape::parse("catmark_grid", &format!("{points}{faces}")).unwrap();
        let start = Start::new(&shape, 1).unwrap();
        let witness = start.follow(&shape, 4, 0, [0.375, 0.25], 60).unwrap().unwrap();
        assert!(witness.radius < 1e-12);
        let expected = [2.0 * 1.375 + 1.25, 3.0 * 1.25, 1.0];
        assert!(length(sub(witness.limit(), expected)) < 1e-14, "{:?}", witness.limit());
        assert!(length(sub(witness.normal().unwrap(), [0.0, 0.0, 1.0])) < 1e-14);
        for along in witness.along.unwrap() {
            let [u, v] = along.direction;
            // Seven halvings of a step of 1/8 leave 2^-10, and roundings 1e-16 times as many.
            assert!(length(sub(along.first, [2.0 * u + v, 3.0 * v, 0.0])) < 1e-12);
            assert!(length(along.second) < 1e-8);
        }
    }

    #[test]
    fn holes_have_no_limit() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nt hole 1/0/0 0";
        let shape = Shape::parse("catmark_hole", text).unwrap();
        let start = Start::new(&shape, 1).unwrap();
        assert!(start.follow(&shape, 0, 0, [0.5, 0.5], 60).unwrap().is_none());
    }
}
