//! The invariants of the half-edge tables. Tests call this on every topology that they touch.

use super::{FaceOf, NONE, Topology};
use crate::index::{Edge, Face, HalfEdge, Vertex};

impl Topology {
    /// Checks every invariant of the tables; the error names the first element that breaks one.
    ///
    /// # Errors
    /// A sentence: which invariant, which element.
    pub fn check(&self) -> Result<(), String> {
        let require = |ok: bool, what: &dyn Fn() -> String| if ok { Ok(()) } else { Err(what()) };
        let n = self.half_edge_count();
        let faces = if let FaceOf::Listed(face) = &self.face { face.len() } else { n };
        for (name, len) in [("face", faces), ("edge", self.edge.len()), ("twin", self.twin.len())] {
            require(len == n, &|| format!("{name} table has {len} rows for {n} half-edges"))?;
        }
        for f in 0..self.face_count() {
            let face = Face(f as u32);
            require(self.sides(face) >= 3, &|| format!("face {f} has {} sides", self.sides(face)))?;
        }
        for h in (0..n as u32).map(HalfEdge).filter(|&h| !self.is_removed(self.face(h))) {
            require(self.next(self.prev(h)) == h, &|| format!("next(prev({h})) differs"))?;
            require(self.face(self.next(h)) == self.face(h), &|| format!("next({h}) leaves the face"))?;
            require(self.origin[h.index()] < self.vertex_count as u32, &|| format!("origin({h}) out of range"))?;
            let (a, b) = (self.origin(h), self.origin(self.next(h)));
            let [p, q] = self.edge_vertices(self.edge(h));
            require((a, b) == (p, q) || (a, b) == (q, p), &|| format!("half-edge {h} does not lie on its edge"))?;
            if let Some(t) = self.twin(h) {
                require(self.twin(t) == Some(h), &|| format!("twin(twin({h})) differs"))?;
                require(t != h && self.edge(t) == self.edge(h), &|| format!("twin({h}) lies on another edge"))?;
                require(self.origin(t) == b && self.origin(self.next(t)) == a, &|| format!("twin({h}) runs astray"))?;
            }
            let flags = self.edge_flags[self.edge[h.index()] as usize];
            require(self.twin(h).is_some() != (flags.boundary || flags.non_manifold), &|| {
                format!("half-edge {h}: twin and flags {flags:?} disagree")
            })?;
            require(self.twin(h).is_some() || self.is_infinitely_sharp(self.edge(h)), &|| {
                format!("half-edge {h} has no twin, yet its edge is not sharp")
            })?;
        }
        for e in (0..self.edge_count() as u32).map(Edge) {
            let h = self.edge_half_edge[e.index()];
            if h == NONE && !self.edits.is_empty() {
                continue;
            }
            require(h != NONE && self.edge[h as usize] == e.0, &|| format!("edge {e} names a half-edge of another"))?;
            let s = self.edge_sharpness(e);
            require((0.0..=10.0).contains(&s), &|| format!("edge {e} has sharpness {s}"))?;
            for v in self.edge_vertices(e) {
                let listed = self.sharp_edges(v).contains(&e.0);
                require(listed == (s > 0.0), &|| format!("edge {e} of sharpness {s}, listed at vertex {v}: {listed}"))?;
            }
        }
        for v in (0..self.vertex_count as u32).map(Vertex) {
            let s = self.vertex_sharpness(v);
            require((0.0..=10.0).contains(&s), &|| format!("vertex {v} has sharpness {s}"))?;
            if let Some(h) = self.outgoing(v) {
                require(self.origin(h) == v, &|| format!("outgoing({v}) starts elsewhere"))?;
                let smooth = self.sharp_edges(v).len() < 2 && s == 0.0;
                require(!smooth || self.turn_right(h).is_some(), &|| format!("vertex {v} is smooth on a boundary"))?;
            }
        }
        Ok(())
    }
}
