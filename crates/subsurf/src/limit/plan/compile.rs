//! Compiles plans: refines the surroundings of faces until a known patch covers each part, generation by generation, so
//! that surroundings that were met before are not compiled again.

use super::super::corner::{
    Corner, Kind, corner, grid_points, has_finite_sharpness, is_finite_sharpness, special_points,
};
use super::super::linear_boundary::{LinearEnds, has_side};
use super::super::local_step::child_vertex;
use super::super::plan_key::{Keys, canonical_corner};
use super::super::rows::{Accumulator, Combination, Rows};
use super::super::triangle_crease::TriangleCrease;
use super::super::triangle_points;
use super::sub_patches::SubPatches;
use super::{Body, Child, Leaf, LeafShape, Link, Node, Plans, SpecialVertices, Split};
use crate::index::{Edge, Face, HalfEdge};
use crate::limit::patch_table::Start;
use crate::refine::refined;
use crate::scheme::{Scheme, SplitKind};
use crate::topology::{Interpolation, Surroundings, Topology, Walk};
use rayon::prelude::*;
use std::collections::hash_map::Entry;
use std::sync::Arc;

/// More generations than any surroundings need: each drops one of at most ten different whole parts of sharpness or tells
/// faces apart that were met first; reaching it is a defect of the classification.
const DEEPEST: u32 = 48;

impl Plans {
    /// No plans yet.
    pub(in crate::limit) fn empty(scheme: Scheme) -> Self {
        Self { split: scheme.split(), nodes: Vec::new(), plans: Vec::new(), parts: SubPatches::new() }
    }

    /// Adds the plans of the faces at `places` of `mesh`, each a face with the corner that its walk starts at. `numbers` are
    /// those of the nodes that are there already.
    pub(in crate::limit) fn add(
        &mut self,
        mesh: &Topology,
        places: &[Start],
        scheme: Scheme,
        specials: &SpecialVertices,
        numbers: &mut Numbers,
    ) {
        let compiler = Compiler { mesh, scheme, specials };
        let starts: Vec<Raised> =
            places.par_iter().map_init(Walk::default, |walk, &place| compiler.start(place, walk)).collect();
        self.plans.extend(starts.into_iter().map(|start| numbers.link(start, None)));
        for _ in 0..DEEPEST {
            let open = std::mem::take(&mut numbers.open);
            if open.is_empty() {
                self.parts.grow(self.plans.len());
                return;
            }
            let made: Vec<Made> =
                open.par_iter().map_init(Walk::default, |walk, open| compiler.node(open, walk)).collect();
            // Nodes lie in the order in which their keys got their numbers.
            for Made { ring, body } in made {
                let body = match body {
                    MadeBody::Leaf(leaf) => Body::Leaf(leaf),
                    MadeBody::Refined { topology, points, children, ends } => {
                        let link = |MadeChild { low, high, turn, ring }: MadeChild| {
                            let low = numbers.link(low, Some(&topology));
                            let high = high.map_or(Link { raise: low.raise + 1, ..low }, |around| {
                                numbers.link(Raised { around, raise: 0 }, Some(&topology))
                            });
                            Child { links: [low, high], turn, ring }
                        };
                        let children = children.into_iter().map(link).collect();
                        Body::Split(Box::new(Split { points, children, ends }))
                    }
                };
                self.nodes.push(Node { ring, body });
            }
        }
        unreachable!("a patch tree does not end")
    }
}

/// Surroundings whose node is to be made, of the mesh or of a refined cut-out.
struct Open {
    of: Option<Arc<Topology>>,
    around: Surroundings,
}

/// Surroundings, lowered, and the raise that gives back what they are.
struct Raised {
    around: Surroundings,
    raise: u8,
}

/// Numbers of nodes by their keys.
#[derive(Default)]
pub(in crate::limit) struct Numbers {
    known: Keys,
    /// Numbered, but not made yet.
    open: Vec<Open>,
}

impl Numbers {
    fn link(&mut self, Raised { mut around, raise }: Raised, of: Option<&Arc<Topology>>) -> Link {
        let next = self.known.len() as u32;
        let node = match self.known.entry(std::mem::take(&mut around.key).into()) {
            Entry::Occupied(node) => *node.get(),
            Entry::Vacant(empty) => {
                self.open.push(Open { of: of.cloned(), around });
                *empty.insert(next)
            }
        };
        Link { node, raise }
    }
}

/// A node whose children have no numbers yet.
struct Made {
    ring: usize,
    body: MadeBody,
}

enum MadeBody {
    Leaf(Leaf),
    /// The refined surroundings, and all four children or the first alone.
    Refined {
        topology: Arc<Topology>,
        points: Rows,
        children: Vec<MadeChild>,
        ends: Option<LinearEnds>,
    },
}

struct MadeChild {
    /// From the node as it is.
    low: Raised,
    /// From the node raised by 1, where that leads to another node.
    high: Option<Surroundings>,
    turn: u8,
    ring: Box<[u32]>,
}

struct Compiler<'a> {
    mesh: &'a Topology,
    scheme: Scheme,
    specials: &'a SpecialVertices,
}

impl Compiler<'_> {
    fn start(&self, (face, corner): Start, walk: &mut Walk) -> Raised {
        raised(self.mesh, Face(face), corner as usize, walk)
    }

    fn node(&self, open: &Open, walk: &mut Walk) -> Made {
        let t = open.of.as_deref().unwrap_or(self.mesh).cut_out(&open.around);
        let ring = t.vertex_count();
        let is_patch = t.sides(Face(0)) == self.scheme.patch_sides();
        if let Some(leaf) = is_patch.then(|| self.leaf(&t)).flatten() {
            return Made { ring, body: MadeBody::Leaf(leaf) };
        }
        let refined = Arc::new(refined(&t, self.scheme));
        let mut points = RefinedPoints::new(&t, &refined, self.scheme);
        let can_rise = t.excess(Face(0)) > 0;
        let count = if is_patch { 4 } else { 1 };
        // Face 0's children come first, corner by corner, the middle triangle last.
        let children = (0..count).map(Face).map(|face| {
            let turn = canonical_corner(&refined, face);
            let low = raised(&refined, face, turn, walk);
            let ring = low.around.ring.iter().map(|&v| points.row(v)).collect();
            // The step takes 1 from everything finite, or nothing where the node is raised by 1. Where the child has what
            // was lowest in the node, that leads to other surroundings; else to the same, raised.
            let high = (can_rise && refined.excess(face) == 0 && refined.is_semi_sharp(face)).then(|| {
                let mut around = Surroundings::default();
                refined.lowered_surroundings(face, turn, -1, walk, &mut around);
                around
            });
            MadeChild { low, high, turn: turn as u8, ring }
        });
        let children = children.collect();
        let points = points.rows;
        let ends = (is_patch && has_side(&t, Face(0))).then(|| LinearEnds::new(&t, self.scheme, self.specials));
        Made { ring, body: MadeBody::Refined { topology: refined, points, children, ends } }
    }

    /// The leaf that covers face 0 of `t`, if one does.
    fn leaf(&self, t: &Topology) -> Option<Leaf> {
        let own: Vec<HalfEdge> = (0..t.sides(Face(0))).map(|c| t.half_edge(Face(0), c)).collect();
        let split = self.scheme.split();
        if self.scheme == Scheme::Bilinear || t.interpolation == Interpolation::Linear {
            let corners: Vec<Combination> = own.iter().map(|&h| vec![(t.origin(h).0, 1.0)]).collect();
            return Some(make(t, LeafShape::Linear, corners, Vec::new()));
        }
        if has_side(t, Face(0)) || (0..t.face_count() as u32).any(|f| t.sides(Face(f)) != self.scheme.patch_sides()) {
            return None;
        }
        let mut creases = Vec::new();
        if own.iter().any(|&h| has_finite_sharpness(t, h)) {
            if t.interpolation == Interpolation::LinearBoundaries {
                return None;
            }
            if split == SplitKind::Quads {
                return single_crease(t, &own);
            }
            creases = TriangleCrease::all(t, &own)?;
        }
        let special: Vec<(usize, Corner)> = own
            .iter()
            .enumerate()
            .map(|(j, &h)| (j, corner(t, h, split).0))
            .filter(|(_, corner)| !corner.is_regular())
            .collect();
        match special[..] {
            [] => {
                let points = match split {
                    SplitKind::Quads => grid_points(t, own[0], false).map(|p| p.expect("a full grid")).to_vec(),
                    SplitKind::Triangles => triangle_points::patch_points(t, own[0]).to_vec(),
                };
                Some(make(t, LeafShape::Regular, points, creases))
            }
            [(j, corner)] => {
                let vertex = self.specials.get(corner);
                let points = match split {
                    SplitKind::Quads => special_points(t, own[j]),
                    SplitKind::Triangles => triangle_points::special_points(t, own[j]),
                };
                debug_assert_eq!(points.len(), vertex.points(), "{corner:?}");
                Some(make(t, LeafShape::Special { turn: j as u8, vertex }, points, creases))
            }
            _ => None,
        }
    }
}

/// Points of the next level over a node's points, each made when it is first asked for.
struct RefinedPoints<'a> {
    parent: &'a Topology,
    scheme: Scheme,
    rows: Rows,
    /// Row of every refined vertex.
    known: Vec<Option<u32>>,
    sum: Accumulator,
}

impl<'a> RefinedPoints<'a> {
    fn new(parent: &'a Topology, refined: &Topology, scheme: Scheme) -> Self {
        let points = parent.vertex_count();
        let known = vec![None; refined.vertex_count()];
        Self { parent, scheme, rows: Rows::empty(points), known, sum: Accumulator::new(points) }
    }

    fn row(&mut self, v: u32) -> u32 {
        let Self { parent, scheme, rows, known, sum } = self;
        *known[v as usize].get_or_insert_with(|| {
            child_vertex(parent, *scheme, v, &mut |p, w| sum.add(p, w));
            rows.push(sum);
            rows.len() as u32 - 1
        })
    }
}

/// What surrounds a face, its sharpness lowered as far as no rule of the next step notices.
fn raised(t: &Topology, face: Face, start: usize, walk: &mut Walk) -> Raised {
    let raise = t.excess(face).saturating_sub(1);
    let mut around = Surroundings::default();
    t.lowered_surroundings(face, start, raise as i8, walk, &mut around);
    Raised { around, raise }
}

/// The leaf along one semi-sharp side of a quad, if it has that form.
fn single_crease(t: &Topology, own: &[HalfEdge]) -> Option<Leaf> {
    let (side, sharpness) = single_crease_side(t, own)?;
    // The crease along v = 1 runs between corners 2 and 3 of the turned quad.
    let turn = (side + 2) % 4;
    let grid = grid_points(t, own[turn], false).map(|p| p.expect("a full grid")).to_vec();
    Some(make(t, LeafShape::SingleCrease { turn: turn as u8, sharpness }, grid, Vec::new()))
}

/// A leaf whose control points are combinations of the vertices of `t`, the creases' bends last.
fn make(
    t: &Topology,
    shape: LeafShape,
    mut points: Vec<Combination>,
    creases: Vec<(TriangleCrease, Vec<Combination>)>,
) -> Leaf {
    let patch_points = points.len();
    let creases = creases.into_iter().map(|(crease, bends)| {
        points.extend(bends);
        crease
    });
    let creases = creases.collect();
    Leaf { shape, points: Rows::new(t.vertex_count(), &points), patch_points, creases }
}

/// The only sharp side of a quad and its sharpness, where the closed form of one semi-sharp crease holds: both ends are
/// interior, of valence 4, and continued straight with the same sharpness; the opposite side is smooth or infinitely
/// sharp, with regular corners.
fn single_crease_side(t: &Topology, own: &[HalfEdge]) -> Option<(usize, f64)> {
    let sharpness = |h: HalfEdge| t.edge_sharpness(t.edge(h));
    let mut sides = (0..4).filter(|&j| is_finite_sharpness(sharpness(own[j])));
    let side = sides.next().filter(|_| sides.next().is_none())?;
    let s = sharpness(own[side]);
    let [next, opposite, before] = [1, 2, 3].map(|k| own[(side + k) % 4]);
    if sharpness(next) > 0.0 || sharpness(before) > 0.0 {
        return None;
    }
    for end in [own[side], next] {
        let v = t.origin(end);
        let goes_on = t.sharp_edges(v).len() == 2
            && t.vertex_sharpness(v) == 0.0
            && t.foreign_sharpness(v).is_empty()
            && spokes(t, end).is_some_and(|spokes| {
                // Of four spokes the sharp ones must face each other.
                let sharp: Vec<bool> = spokes.iter().map(|&e| t.edge_sharpness(e) == s).collect();
                sharp == [true, false, true, false] || sharp == [false, true, false, true]
            });
        if !goes_on {
            return None;
        }
    }
    for far in [opposite, before] {
        if has_finite_sharpness(t, far) {
            return None;
        }
        let c = corner(t, far, SplitKind::Quads).0;
        let plain = c.kind == Kind::Smooth && c.n == 4;
        let along = c.kind == Kind::Crease && c.n == 2 && t.is_infinitely_sharp(t.edge(opposite));
        if !plain && !along {
            return None;
        }
    }
    Some((side, s))
}

/// The four edges round the origin of `h`, if it is an interior vertex of valence 4.
fn spokes(t: &Topology, h: HalfEdge) -> Option<[Edge; 4]> {
    let a = t.turn_left(h)?;
    let b = t.turn_left(a)?;
    let c = t.turn_left(b)?;
    (t.turn_left(c)? == h && b != h).then(|| [h, a, b, c].map(|h| t.edge(h)))
}
