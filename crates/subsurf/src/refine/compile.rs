//! Makes the nodes of [`TileTrees`](super::tile_trees::TileTrees), tier by tier: what lies round the faces of a tier is cut out and
//! refined as one topology, and children with equal surroundings become one face of the next tier.

use super::compose::{Placed, cells_of, corners};
use super::face_rings::Distinct;
use super::plain::{is_plain, plain_ring};
use super::refined_point::{Parent, refined_point};
use super::tile_trees::{Child, ChildKind, Node, Rows};
use crate::index::{Face, HalfEdge, Vertex};
use crate::mask::Mask;
use crate::scheme::{Scheme, SplitKind};
use crate::topology::{Cutter, NONE, Surroundings, Topology, Walk};
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::{Mutex, PoisonError};

/// Nodes a thread takes at a time. Fixed, so that nodes get the same numbers for any number of threads.
const CHUNK: usize = 16;

/// The faces that nodes of one tier are made for, one for each, and a topology that holds their surroundings.
pub(super) struct Source<'a> {
    pub t: Cow<'a, Topology>,
    pub faces: Vec<Face>,
}

impl Source<'_> {
    /// Without what does not surround the faces, where that is much.
    pub fn reduced(self) -> Self {
        // Nine faces lie round most quads.
        if 18 * self.faces.len() > self.t.face_count() {
            return self;
        }
        let t = &*self.t;
        let (mut walk, mut around) = (Walk::default(), Surroundings::default());
        let (mut part, mut own) = (Surroundings::default(), 0);
        let mut number = vec![NONE; t.face_count()];
        let mut is_listed = vec![false; t.vertex_count()];
        for &f in &self.faces {
            for &v in t.face_vertices(f) {
                if !std::mem::replace(&mut is_listed[v as usize], true) {
                    part.ring.push(v);
                }
            }
        }
        own += part.ring.len();
        for &f in &self.faces {
            t.surroundings(f, 0, &mut walk, &mut around);
            for g in around.faces.iter().map(|&h| t.face(HalfEdge(h))) {
                if number[g.index()] == NONE {
                    number[g.index()] = part.faces.len() as u32;
                    part.faces.push(t.first(g));
                }
            }
            for &v in &around.ring {
                if !std::mem::replace(&mut is_listed[v as usize], true) {
                    part.ring.push(v);
                }
            }
        }
        let faces = self.faces.iter().map(|f| Face(number[f.index()])).collect();
        Self { t: Cow::Owned(Cutter::part(t, &part, own)), faces }
    }
}

/// Makes the nodes of one tier.
pub(super) struct Compiler<'a> {
    pub t: &'a Topology,
    /// One level down; none where that is the last one.
    pub fine: Option<&'a Topology>,
    pub scheme: Scheme,
    /// Levels from here to the last one.
    pub left: u32,
}

/// The nodes of some faces, those of their children numbered within the chunk.
struct Compiled {
    nodes: Vec<Node>,
    /// Distinct keys of children in order of appearance, each with its first face.
    new: Vec<(Box<[u32]>, Face)>,
}

/// Memory that is used again and again.
#[derive(Default)]
struct Scratch {
    walk: Walk,
    around: Surroundings,
    fine_walk: Walk,
    mask: Mask,
    /// Position in the ring, by vertex.
    ring_slot: Vec<u32>,
    /// Position among the refined points, by vertex one level down.
    point_slot: Vec<u32>,
    points: Vec<u32>,
    point: Vec<(u32, f64)>,
}

impl Compiler<'_> {
    /// Nodes of some faces in order, and the first face of every group of children.
    pub fn nodes(&self, faces: &[Face]) -> (Vec<Node>, Vec<Face>) {
        let pool = Mutex::new(Vec::new());
        let lock = || pool.lock().unwrap_or_else(PoisonError::into_inner);
        let chunks: Vec<Compiled> = faces
            .par_chunks(CHUNK)
            .map(|faces| {
                let mut scratch = lock().pop().unwrap_or_else(|| Scratch {
                    ring_slot: vec![NONE; self.t.vertex_count()],
                    point_slot: vec![NONE; Parent::count(self.t, self.scheme)],
                    ..Scratch::default()
                });
                let (mut known, mut new) = (Distinct::default(), Vec::new());
                let nodes = faces.iter().map(|&f| self.node(f, &mut known, &mut new, &mut scratch)).collect();
                lock().push(scratch);
                Compiled { nodes, new }
            })
            .collect();
        let (mut nodes, mut children, mut known) = (Vec::with_capacity(faces.len()), Vec::new(), Distinct::default());
        for Compiled { nodes: mut compiled, new } in chunks {
            let mut renumber = Vec::with_capacity(new.len());
            for (key, face) in new {
                let (number, is_new) = known.number_owned(key);
                renumber.push(number);
                children.extend(is_new.then_some(face));
            }
            for child in compiled.iter_mut().flat_map(|node| &mut node.children) {
                if let ChildKind::Node(number) = &mut child.kind {
                    *number = renumber[*number as usize];
                }
            }
            nodes.append(&mut compiled);
        }
        (nodes, children)
    }

    fn node(
        &self,
        f: Face,
        known: &mut Distinct<Box<[u32]>>,
        new: &mut Vec<(Box<[u32]>, Face)>,
        scratch: &mut Scratch,
    ) -> Node {
        let t = self.t;
        t.surroundings(f, 0, &mut scratch.walk, &mut scratch.around);
        scratch.around.ring.iter().zip(0..).for_each(|(&v, slot)| scratch.ring_slot[v as usize] = slot);
        let ring = std::mem::take(&mut scratch.around.ring);

        let split = self.scheme.split();
        let mut faces = faces_within(t, split, f);
        let (mut children, mut cells) = (Vec::new(), None);
        match self.fine {
            Some(fine) if self.left == 2 && faces.len() == 4 => cells = Some(self.cells(fine, faces, scratch)),
            Some(fine) => {
                children.extend(faces.map(|child| Self::child(fine, self.scheme, child, known, new, scratch)));
            }
            None => children.extend(faces.by_ref().map(|child| {
                let corners = child_corners(t, split, f, child);
                Child { kind: ChildKind::Corners, ring: scratch.slots(&corners) }
            })),
        }
        let asked = std::mem::take(&mut scratch.points);
        let mut points = Rows::default();
        for &v in &asked {
            scratch.point_slot[v as usize] = NONE;
            scratch.point.clear();
            let parent = Parent::of(t, self.scheme, v);
            refined_point(t, self.scheme, parent, &mut scratch.mask, &mut scratch.point);
            points.push(scratch.point.iter().map(|&(v, w)| (scratch.ring_slot[v as usize], w)));
        }
        let node = Node { ring: ring.len(), points, children, cells };
        (scratch.points, scratch.around.ring) = (asked, ring);
        scratch.points.clear();
        node
    }

    /// All vertices two levels down of a face with four children, over the points one level down.
    fn cells(&self, fine: &Topology, children: impl Iterator<Item = Face>, scratch: &mut Scratch) -> Rows {
        let split = self.scheme.split();
        let whole = Placed::alone(4);
        let mut vertex = [NONE; 25];
        for (c, child) in children.enumerate() {
            for (g, grandchild) in faces_within(fine, split, child).enumerate() {
                let at = whole.child(split, 4, c).child(split, 2, g);
                let names = child_corners(fine, split, child, grandchild);
                corners(split).iter().zip(names).for_each(|(&(i, j), v)| vertex[at.cell(i, j)] = v);
            }
        }
        let mut rows = Rows::default();
        for (i, j) in cells_of(split, 4) {
            let mut point = std::mem::take(&mut scratch.point);
            point.clear();
            let parent = Parent::of(fine, self.scheme, vertex[whole.cell(i, j)]);
            refined_point(fine, self.scheme, parent, &mut scratch.mask, &mut point);
            rows.push(point.iter().map(|&(v, w)| (scratch.slot(v), w)));
            scratch.point = point;
        }
        rows
    }

    fn child(
        t: &Topology,
        scheme: Scheme,
        face: Face,
        known: &mut Distinct<Box<[u32]>>,
        new: &mut Vec<(Box<[u32]>, Face)>,
        scratch: &mut Scratch,
    ) -> Child {
        let is_regular =
            scheme.split() == SplitKind::Quads && t.face_vertices(face).iter().all(|&v| is_plain(t, Vertex(v)));
        if is_regular {
            return Child { kind: ChildKind::Regular, ring: scratch.slots(&plain_ring(t, face)) };
        }
        let mut around = std::mem::take(&mut scratch.around);
        t.surroundings(face, 0, &mut scratch.fine_walk, &mut around);
        let (number, is_new) = known.number(&around.key);
        if is_new {
            new.push((around.key.clone().into(), face));
        }
        let ring = scratch.slots(&around.ring);
        scratch.around = around;
        Child { kind: ChildKind::Node(number), ring }
    }
}

impl Scratch {
    /// Positions of vertices one level down among the refined points, which they join.
    fn slots(&mut self, vertices: &[u32]) -> Box<[u32]> {
        vertices.iter().map(|&v| self.slot(v)).collect()
    }

    fn slot(&mut self, v: u32) -> u32 {
        let slot = &mut self.point_slot[v as usize];
        if *slot == NONE {
            *slot = self.points.len() as u32;
            self.points.push(v);
        }
        *slot
    }
}

/// The children of a face.
fn faces_within(t: &Topology, split: SplitKind, f: Face) -> impl ExactSizeIterator<Item = Face> {
    let range = match split {
        SplitKind::Quads => t.first(f)..t.first(f) + t.sides(f) as u32,
        SplitKind::Triangles => 4 * f.0..4 * f.0 + 4,
    };
    (range.start..range.end).map(Face)
}

/// The corners of a child, as the splits number them.
fn child_corners(t: &Topology, split: SplitKind, f: Face, child: Face) -> Vec<u32> {
    let vertices = t.vertex_count() as u32;
    if split == SplitKind::Triangles {
        let corner = child.0 % 4;
        let on_edge = |c: u32| vertices + t.edge(HalfEdge(t.first(f) + c % 3)).0;
        let mut corners = [1, 2, 0].map(on_edge);
        if corner < 3 {
            corners = [0, 1, 2].map(|c| if c == corner { t.face_vertices(f)[c as usize] } else { 0 });
            corners[(corner as usize + 1) % 3] = on_edge(corner);
            corners[(corner as usize + 2) % 3] = on_edge(corner + 2);
        }
        return corners.to_vec();
    }
    let h = HalfEdge(child.0);
    let on_edge = |h: HalfEdge| vertices + t.face_count() as u32 + t.edge(h).0;
    let mut corners = [t.origin(h).0, on_edge(h), vertices + f.0, on_edge(t.prev(h))];
    if t.sides(f) == 4 {
        corners.rotate_right((h.0 - t.first(f)) as usize);
    }
    corners.to_vec()
}
