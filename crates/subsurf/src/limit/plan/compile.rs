//! Compiles a plan: refines the face's surroundings until a known patch covers each part.

use super::super::corner::{Corner, Kind, corner, grid_points, special_points};
use super::super::linear_boundary::{self, LinearBoundary};
use super::super::local_step::child_vertex;
use super::super::rows::{Accumulator, Combination, Rows};
use super::super::triangle_points;
use super::{Leaf, LeafShape, Node, Plan, SpecialVertices};
use crate::index::{Edge, Face, HalfEdge};
use crate::refine::Level;
use crate::scheme::{Scheme, SplitKind};
use crate::tags::INFINITE_SHARPNESS;
use crate::topology::{Interpolation, Surroundings, Topology, Walk};

/// One level of explicit refinement round one face on the way down the tree.
struct Site {
    topology: Topology,
    /// The topology's vertices over the ring.
    points: Vec<Combination>,
}

impl Plan {
    /// The plan of the face whose `around`ings were taken from `t`. Of a face that is no quad, the plan covers the
    /// sub-face at the walk's first corner.
    pub fn new(t: &Topology, around: &Surroundings, scheme: Scheme, specials: &SpecialVertices) -> Self {
        let points = (0..around.ring.len() as u32).map(|i| vec![(i, 1.0)]).collect();
        let site = Site { topology: t.cut_out(around), points };
        let mut compiler = Compiler {
            ring: around.ring.len(),
            scheme,
            specials,
            nodes: Vec::new(),
            leaves: Vec::new(),
            walk: Walk::default(),
        };
        let root = if site.topology.sides(Face(0)) == scheme.patch_sides() {
            compiler.compile(&site, 0)
        } else {
            let children = compiler.children(&site, &[0]);
            compiler.compile(&children[0], 1)
        };
        Self { split: scheme.split(), ring: around.ring.len(), nodes: compiler.nodes, leaves: compiler.leaves, root }
    }
}

struct Compiler<'a> {
    ring: usize,
    scheme: Scheme,
    specials: &'a SpecialVertices,
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    walk: Walk,
}

/// More levels than `⌈sharpness⌉ + 2` ever needs; reaching it is a defect of the classification.
const DEEPEST: u32 = 16;

impl Compiler<'_> {
    /// Adds the tree of face 0 of `site`; returns its root.
    fn compile(&mut self, site: &Site, depth: u32) -> u32 {
        assert!(depth < DEEPEST, "the patch tree does not end");
        if let Some(leaf) = self.leaf(site) {
            self.leaves.push(leaf);
            self.nodes.push(Node::Leaf(self.leaves.len() as u32 - 1));
        } else {
            let children = self.children(site, &[0, 1, 2, 3]);
            let split: Vec<u32> = children.iter().map(|child| self.compile(child, depth + 1)).collect();
            self.nodes.push(Node::Split([split[0], split[1], split[2], split[3]]));
        }
        self.nodes.len() as u32 - 1
    }

    /// The sites of face 0's children at the given corners.
    fn children(&mut self, site: &Site, corners: &[usize]) -> Vec<Site> {
        let parent = Level::from_topology(site.topology.clone(), self.scheme);
        let refined = parent.refine().expect("surroundings are small");
        let (t, child) = (parent.topology(), refined.topology());
        let mut around = Surroundings::default();
        let mut sum = Accumulator::new(self.ring);
        let mut sites = Vec::with_capacity(corners.len());
        for &c in corners {
            // Face 0's children come first, corner by corner, the middle triangle last.
            let face = Face(c as u32);
            child.surroundings(face, 0, &mut self.walk, &mut around);
            let points = around
                .ring
                .iter()
                .map(|&v| {
                    child_vertex(t, self.scheme, v, &mut |p, w| {
                        site.points[p as usize].iter().for_each(|&(c, x)| sum.add(c, w * x));
                    });
                    sum.take()
                })
                .collect();
            sites.push(Site { topology: child.cut_out(&around), points });
        }
        sites
    }

    /// The leaf that covers face 0, if one does.
    fn leaf(&self, site: &Site) -> Option<Leaf> {
        let t = &site.topology;
        let own: Vec<HalfEdge> = (0..t.sides(Face(0))).map(|c| t.half_edge(Face(0), c)).collect();
        let split = self.scheme.split();
        if self.scheme == Scheme::Bilinear || t.interpolation == Interpolation::Linear {
            let corners: Vec<Combination> = own.iter().map(|&h| vec![(t.origin(h).0, 1.0)]).collect();
            return Some(self.make(site, LeafShape::Linear, &corners));
        }
        if (0..t.face_count() as u32).any(|f| t.sides(Face(f)) != self.scheme.patch_sides()) {
            return None;
        }
        if own.iter().any(|&h| has_finite_sharpness(t, h)) {
            if split == SplitKind::Triangles {
                return None;
            }
            let (side, sharpness) = single_crease_side(t, &own)?;
            // The crease along v = 1 runs between corners 2 and 3 of the turned quad.
            let turn = (side + 2) % 4;
            let grid = grid_points(t, own[turn], false).map(|p| p.expect("a full grid"));
            return Some(self.make(site, LeafShape::SingleCrease { turn: turn as u8, sharpness }, &grid));
        }
        if linear_boundary::has_side(t, Face(0)) {
            let form = LinearBoundary::new(t, self.scheme, self.specials);
            let ring: Vec<Combination> = (0..t.vertex_count() as u32).map(|v| vec![(v, 1.0)]).collect();
            return Some(self.make(site, LeafShape::LinearBoundary(Box::new(form)), &ring));
        }
        let special: Vec<(usize, Corner)> = own
            .iter()
            .enumerate()
            .map(|(j, &h)| (j, corner(t, h, split).0))
            .filter(|(_, corner)| !corner.is_regular())
            .collect();
        match special[..] {
            [] if split == SplitKind::Triangles => {
                Some(self.make(site, LeafShape::Regular, &triangle_points::patch_points(t, own[0])))
            }
            [] => {
                let grid = grid_points(t, own[0], false).map(|p| p.expect("a full grid"));
                Some(self.make(site, LeafShape::Regular, &grid))
            }
            [(j, corner)] => {
                let vertex = self.specials.get(corner);
                let points = match split {
                    SplitKind::Quads => special_points(t, own[j]),
                    SplitKind::Triangles => triangle_points::special_points(t, own[j]),
                };
                debug_assert_eq!(points.len(), vertex.points());
                Some(self.make(site, LeafShape::Special { turn: j as u8, vertex }, &points))
            }
            _ => None,
        }
    }

    /// A leaf whose control points are combinations of the site's vertices.
    fn make(&self, site: &Site, shape: LeafShape, points: &[Combination]) -> Leaf {
        let over_ring: Vec<Combination> = points
            .iter()
            .map(|point| {
                let terms = |&(v, w): &(u32, f64)| {
                    site.points[v as usize].iter().map(move |&(c, x)| (c, w * x)).collect::<Vec<_>>()
                };
                point.iter().flat_map(terms).collect()
            })
            .collect();
        Leaf { shape, points: Rows::new(self.ring, &over_ring) }
    }
}

fn is_finite_sharpness(s: f64) -> bool {
    s > 0.0 && s < INFINITE_SHARPNESS
}

/// True where sharpness at the origin of `h` will change.
fn has_finite_sharpness(t: &Topology, h: HalfEdge) -> bool {
    let v = t.origin(h);
    is_finite_sharpness(t.vertex_sharpness(v))
        || t.foreign_sharpness(v).iter().any(|&s| is_finite_sharpness(s))
        || t.sharp_edges(v).iter().any(|&e| is_finite_sharpness(t.edge_sharpness(Edge(e))))
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
