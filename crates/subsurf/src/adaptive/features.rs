//! Which faces a feature makes irregular, and what kind of patch a face is. The rules are those of OpenSubdiv 3.7
//! (`far/topologyRefiner.cpp`, `far/patchBuilder.cpp`, `vtr/level.cpp`) with its infinitely-sharp patches on: a crease
//! or boundary that never decays is no feature where a spline patch can end at it.

use super::AdaptiveKind;
use super::sparse_level::{SparseLevel, faces_at_vertices};
use crate::index::{Edge, HalfEdge, Vertex};
use crate::scheme::{Scheme, SplitKind};
use crate::sharpness::is_semi_sharp;
use crate::tags::INFINITE_SHARPNESS;
use crate::topology::{EdgeFlags, Topology};

/// What stays the same about a vertex from level to level.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct VertexTag {
    /// Manifold, and of another number of faces than the regular one.
    pub extraordinary: bool,
    pub boundary: bool,
    pub non_manifold: bool,
    /// Infinitely sharp itself.
    pub pinned: bool,
    /// Has infinitely sharp edges.
    pub sharp_edges: bool,
    /// Has exactly two of them and is not pinned.
    pub crease: bool,
    /// What is infinitely sharp here is not all that a spline patch can end at.
    pub irregular: bool,
    /// Touches a face that is not whole; such faces exist in the control mesh only.
    pub beside_ngon: bool,
}

impl VertexTag {
    /// The tags of all vertices of a control mesh.
    pub fn of_control_mesh(t: &Topology, scheme: Scheme) -> Vec<Self> {
        let regular_faces = match scheme.split() {
            SplitKind::Quads => 4,
            SplitKind::Triangles => 6,
        };
        let faces = faces_at_vertices(t);
        let mut edges = vec![Spokes::default(); t.vertex_count()];
        for e in (0..t.edge_count()).map(Edge::new) {
            for v in t.edge_vertices(e) {
                let at = &mut edges[v.index()];
                at.all += 1;
                at.boundary += u32::from(t.is_boundary(e));
                at.sharp += u32::from(t.is_infinitely_sharp(e));
            }
        }
        let mut tags: Vec<Self> = (0..t.vertex_count())
            .map(|v| Self::of_vertex(t, Vertex::new(v), faces[v], edges[v], regular_faces))
            .collect();
        for (f, sides) in t.face_offsets().windows(2).enumerate().map(|(f, w)| (f, (w[1] - w[0]) as usize)) {
            if sides != scheme.patch_sides() {
                t.face_vertices((f as u32).into()).iter().for_each(|&v| tags[v as usize].beside_ngon = true);
            }
        }
        tags
    }

    fn of_vertex(t: &Topology, v: Vertex, faces: u32, edges: Spokes, regular_faces: u32) -> Self {
        let pinned = t.vertex_sharpness(v) >= INFINITE_SHARPNESS;
        let non_manifold = t.is_non_manifold_vertex(v);
        let boundary = edges.boundary > 0;
        let pinned_corner = pinned && faces == 1 && edges.all == 2;
        let usual = if boundary { regular_faces / 2 } else { regular_faces };
        let crease = !pinned && edges.sharp == 2;
        let corner = pinned || edges.sharp > 2;
        let mut tag = Self {
            extraordinary: !non_manifold && !pinned_corner && faces != usual,
            boundary,
            non_manifold,
            pinned,
            sharp_edges: edges.sharp > 0,
            crease,
            irregular: pinned || edges.sharp > 0,
            beside_ngon: false,
        };
        if edges.sharp > 0 && crease && !tag.extraordinary && !non_manifold {
            tag.irregular = !boundary && !goes_straight(t, v);
        } else if edges.sharp > 0 && corner && edges.sharp == edges.all && (edges.all > 2 || pinned) {
            // Sharp all round: every face has a corner of its own.
            tag.irregular = false;
        }
        tag
    }

    /// The tag of a vertex in the middle of an edge.
    pub fn on_edge(flags: EdgeFlags, infinitely_sharp: bool) -> Self {
        Self {
            boundary: flags.boundary,
            non_manifold: flags.non_manifold,
            sharp_edges: infinitely_sharp,
            crease: infinitely_sharp,
            irregular: infinitely_sharp && flags.non_manifold,
            ..Self::default()
        }
    }

    /// The tag of the vertex that continues this one a level down.
    pub fn inherited(self) -> Self {
        Self { beside_ngon: false, ..self }
    }
}

/// Edges at a vertex of a control mesh.
#[derive(Clone, Copy, Default)]
struct Spokes {
    all: u32,
    boundary: u32,
    sharp: u32,
}

/// True where the infinitely sharp edges of a regular interior vertex lie opposite one another.
fn goes_straight(t: &Topology, v: Vertex) -> bool {
    let Some(start) = t.outgoing(v) else { return false };
    let next = |&h: &HalfEdge| t.turn_left(h).filter(|&h| h != start);
    let sharp: Vec<bool> = std::iter::successors(Some(start), next).map(|h| t.is_infinitely_sharp(t.edge(h))).collect();
    let half = sharp.len() / 2;
    (0..half).all(|i| sharp[i] == sharp[i + half])
}

/// The sharp edges round a vertex on one level.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Around {
    sharp: u32,
    semi_sharp: u32,
    semi_sharp_sum: f64,
    least: f64,
    most: f64,
    /// Two sharp edges of one face meet here.
    pub turns: bool,
}

impl Around {
    /// Counts an edge of sharpness `s` > 0.
    pub fn add(&mut self, s: f64) {
        self.least = if self.sharp == 0 { s } else { self.least.min(s) };
        self.most = self.most.max(s);
        self.sharp += 1;
        if is_semi_sharp(s) {
            self.semi_sharp += 1;
            self.semi_sharp_sum += s;
        }
    }

    /// Number of sharp edges.
    pub fn sharp(&self) -> u32 {
        self.sharp
    }

    /// Number and total of semi-sharp edges.
    pub fn semi_sharp(&self) -> (u32, f64) {
        (self.semi_sharp, self.semi_sharp_sum)
    }

    /// True for exactly two edges, equally sharp and no sides of one face.
    fn is_even_crease(&self) -> bool {
        self.sharp == 2 && self.least == self.most && !self.turns
    }
}

/// One level with the sharp edges round its vertices.
pub(super) struct Features<'a> {
    pub level: &'a SparseLevel,
    pub around: &'a [Around],
    pub single_crease: bool,
    /// The deepest level.
    pub isolation: u32,
}

/// What becomes of a complete face.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Verdict {
    Refine,
    Patch(PatchShape),
}

/// A patch but for its place.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct PatchShape {
    pub kind: AdaptiveKind,
    /// Bit i: side i is infinitely sharp, or the crease of a single-crease patch.
    pub sides: u8,
    pub sharpness: f64,
    pub cut_short: bool,
}

impl Features<'_> {
    /// What becomes of face `f`.
    pub fn verdict(&self, f: usize) -> Verdict {
        if self.level.depth < self.isolation && self.needs_refinement(f) {
            return Verdict::Refine;
        }
        Verdict::Patch(self.patch(f))
    }

    fn corner_vertices(&self, f: usize) -> impl Iterator<Item = usize> + Clone {
        self.level.vertex[self.level.corners(f)].iter().map(|&v| v as usize)
    }

    /// True where the vertex follows the smooth rule; a dart does not.
    fn is_smooth(&self, v: usize) -> bool {
        self.level.vertex_sharpness[v] == 0.0 && self.around[v].sharp == 0
    }

    fn is_semi_sharp(&self, v: usize) -> bool {
        self.around[v].semi_sharp > 0 || is_semi_sharp(self.level.vertex_sharpness[v])
    }

    fn needs_refinement(&self, f: usize) -> bool {
        let scheme = self.level.scheme();
        if self.level.corners(f).len() != scheme.patch_sides() {
            return true;
        }
        if scheme == Scheme::Bilinear {
            return false;
        }
        let vertices = self.corner_vertices(f);
        let tag = |v: usize| self.level.vertex_tag[v];
        if vertices.clone().any(|v| tag(v).beside_ngon || tag(v).non_manifold) {
            return true;
        }
        if vertices.clone().any(|v| tag(v).extraordinary && self.is_smooth(v)) {
            return true;
        }
        if vertices.clone().any(|v| self.is_semi_sharp(v)) {
            return !self.single_crease || self.single_crease_side(f).is_none();
        }
        vertices.clone().any(|v| tag(v).irregular)
    }

    fn patch(&self, f: usize) -> PatchShape {
        let corners = self.level.corners(f);
        let plain = PatchShape { kind: AdaptiveKind::Regular, sides: 0, sharpness: 0.0, cut_short: false };
        if self.level.scheme() == Scheme::Bilinear {
            return plain;
        }
        let cut_short = self.corner_vertices(f).any(|v| self.is_semi_sharp(v));
        if !corners.clone().all(|c| self.is_regular_corner(c)) {
            return PatchShape { kind: AdaptiveKind::EndCap, cut_short, ..plain };
        }
        let sharp_side = |c: usize| self.level.edge_sharpness[self.level.edge[c] as usize] >= INFINITE_SHARPNESS;
        let sides = corners.clone().enumerate().fold(0, |bits, (i, c)| bits | u8::from(sharp_side(c)) << i);
        // A triangle also reaches across its corners, to points beyond a boundary that it touches there only.
        let touches = |v: usize| self.level.vertex_tag[v].sharp_edges;
        let ends =
            sides != 0 || self.level.scheme().split() == SplitKind::Triangles && self.corner_vertices(f).any(touches);
        if ends {
            return PatchShape { kind: AdaptiveKind::Boundary, sides, cut_short, ..plain };
        }
        // Sharpness beyond the deepest level is dropped, so that the patch meets neighbours that were refined.
        let left = f64::from(self.isolation - self.level.depth);
        match self.single_crease_side(f).filter(|_| self.single_crease && left > 0.0) {
            None => PatchShape { cut_short, ..plain },
            Some((side, sharpness)) => PatchShape {
                kind: AdaptiveKind::SingleCrease,
                sides: 1 << side,
                sharpness: sharpness.min(left),
                cut_short: sharpness > left,
            },
        }
    }

    /// True where a spline patch reaches round this corner, whole or ending at infinitely sharp sides.
    fn is_regular_corner(&self, c: usize) -> bool {
        let tag = self.level.vertex_tag[self.level.vertex[c] as usize];
        let half_ring = if self.level.scheme().split() == SplitKind::Quads { 2 } else { 3 };
        let sector = self.level.sector[c];
        if tag.non_manifold {
            return sector == if tag.pinned { 1 } else { half_ring };
        }
        if tag.irregular {
            return tag.sharp_edges
                && !(tag.crease && tag.boundary)
                && sector == if tag.crease { half_ring } else { 1 };
        }
        !tag.extraordinary || tag.sharp_edges
    }

    /// The side of a quad along which a single crease runs, and its sharpness.
    ///
    /// All four vertices are regular and interior; the side's ends lie on a crease that goes on straight and equally
    /// sharp, the other two are smooth.
    fn single_crease_side(&self, f: usize) -> Option<(usize, f64)> {
        let corners = self.level.corners(f);
        if self.level.scheme().split() != SplitKind::Quads || corners.len() != 4 {
            return None;
        }
        let mut crease = [false; 4];
        for (i, v) in self.corner_vertices(f).enumerate() {
            let tag = self.level.vertex_tag[v];
            crease[i] = self.around[v].is_even_crease();
            let fits = crease[i] || self.around[v].sharp == 0;
            if !fits || tag.boundary || tag.extraordinary || tag.non_manifold || self.level.vertex_sharpness[v] > 0.0 {
                return None;
            }
        }
        let side =
            (0..4).find(|&i| crease[i] && crease[(i + 1) % 4] && !crease[(i + 2) % 4] && !crease[(i + 3) % 4])?;
        let s = self.level.edge_sharpness[self.level.edge[corners.start + side] as usize];
        (s > 0.0).then_some((side, s))
    }
}
