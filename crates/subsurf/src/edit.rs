//! Editing while evaluating: a patch table whose mesh changes face by face and crease by crease. An edit rebuilds what it
//! touches, the faces round the changed ones, in a time that does not depend on the size of the mesh.
//!
//! Numbers stay: a face or vertex that no edit touches keeps its index. A face that is taken out leaves a hole, whose
//! index goes to the next face with as many corners; [`TableEditor::mesh`] gives the mesh without holes of this kind.

mod incidence;
mod poles;

use crate::index::{Face, HalfEdge, Vertex};
use crate::limit::{Known, Method, PatchTable};
use crate::mesh::{ControlMesh, MAX_COUNT, MeshError};
use crate::refine::scheme_topology;
use crate::scheme::{Scheme, SplitKind};
use crate::tags::{Corner, Crease, Creasing, Rules, Tags};
use crate::topology::{Piece, Topology, Walk};
use incidence::Incidence;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use thiserror::Error;

/// Why an edit was refused. The table is then as before.
#[derive(Clone, PartialEq, Debug, Error)]
#[non_exhaustive]
pub enum EditError {
    /// A crease between vertices that no edge joins.
    #[error("no edge joins vertices {a} and {b}")]
    NoEdge {
        /// First vertex.
        a: u32,
        /// Second vertex.
        b: u32,
    },
    /// A vertex that does not exist.
    #[error("there is no vertex {vertex}: the mesh has {vertices} (they count from 0)")]
    NoVertex {
        /// The vertex.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// A face that does not exist, or was taken out before.
    #[error("there is no face {face}")]
    NoFace {
        /// The face.
        face: u32,
    },
    /// A new face of fewer than three corners, or none but triangles under Loop.
    #[error("new face {face} has {sides} corners; {needed} are needed")]
    Sides {
        /// Position among the new faces.
        face: usize,
        /// Its number of corners.
        sides: usize,
        /// "at least 3", or "exactly 3" under Loop subdivision.
        needed: &'static str,
    },
    /// Sharpness that is no finite number.
    #[error("the sharpness is {sharpness}; use a finite number, 10 for infinitely sharp")]
    BadSharpness {
        /// The offending value.
        sharpness: f64,
    },
    /// More than 32-bit indices can name, or than fits into memory.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// What an edit did.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Edited {
    /// Numbers of the new faces, in the order in which they were given.
    pub added: Vec<Face>,
    /// Faces whose limit surface was made anew, ascending: what copies of the table elsewhere have to fetch.
    pub rebuilt: Vec<Face>,
    /// Nodes of patch trees that were not known before.
    pub nodes: usize,
}

/// A patch table that follows edits of its mesh.
///
/// ```
/// use subsurf::{Location, Scheme, TableEditor, shapes};
///
/// let cube = shapes::cube();
/// let mut editor = TableEditor::new(&cube.mesh, Scheme::CatmullClark)?;
/// editor.set_creases(&[(0, 1)], 2.5)?;
/// let edited = editor.replace_faces(&[0], &[&[0, 2, 3], &[0, 3, 1]])?; // two triangles for a quad
/// assert_eq!(edited.added.len(), 2);
/// let surface = editor.table().surface(&cube.positions);
/// assert!(surface.eval(Location { face: edited.added[0], subface: 0, u: 0.5, v: 0.5 }).is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct TableEditor {
    table: PatchTable,
    known: Known,
    incidence: Incidence,
    /// Sharpness as given; an edge that goes keeps its own, should it come back.
    creases: HashMap<[u32; 2], f64>,
    corners: HashMap<u32, f64>,
    holes: HashSet<u32>,
    rules: Rules,
    walk: Walk,
}

impl TableEditor {
    /// Builds the table of a mesh, ready to be edited.
    ///
    /// # Errors
    /// As [`PatchTable::new`].
    pub fn new(mesh: &ControlMesh, scheme: Scheme) -> Result<Self, MeshError> {
        let topology = scheme_topology(mesh, scheme)?;
        let incidence = Incidence::new(&topology);
        let (table, known) = PatchTable::with_known(topology, scheme, Method::default())?;
        let tags = mesh.tags();
        Ok(Self {
            known,
            incidence,
            creases: tags.creases.iter().map(|c| (sorted(c.vertices), c.sharpness)).collect(),
            corners: tags.corners.iter().map(|c| (c.vertex, c.sharpness)).collect(),
            holes: tags.holes.iter().copied().collect(),
            rules: *table.topology().rules(),
            table,
            walk: Walk::default(),
        })
    }

    /// The table as it is now. Faces that were taken out are holes in it.
    pub fn table(&self) -> &PatchTable {
        &self.table
    }

    /// The table, with no more edits to come.
    pub fn into_table(self) -> PatchTable {
        self.table
    }

    /// Gives edges this sharpness; 0 makes them smooth, 10 and more infinitely sharp.
    ///
    /// # Errors
    /// [`EditError::NoEdge`] names the first pair of vertices that no edge joins, [`EditError::BadSharpness`] a value
    /// that is no finite number; [`EditError::Mesh`] with [`MeshError::PoleTooLarge`] says that the table would take too much memory.
    pub fn set_creases(&mut self, edges: &[(u32, u32)], sharpness: f64) -> Result<Edited, EditError> {
        check_sharpness(sharpness)?;
        for &(a, b) in edges {
            if !self.has_edge(a, b) {
                return Err(EditError::NoEdge { a, b });
            }
        }
        let touched = edges.iter().flat_map(|&(a, b)| [a, b]).collect();
        let mut set = |&(a, b): &(u32, u32)| (sorted([a, b]), self.creases.insert(sorted([a, b]), sharpness));
        let before: Vec<([u32; 2], Option<f64>)> = edges.iter().map(&mut set).collect();
        if let Err(error) = self.check_poles(&touched, &BTreeSet::new(), &[]) {
            // The last change comes off first: an edge may be named twice.
            before.into_iter().rev().for_each(|(edge, s)| put_back(&mut self.creases, edge, s));
            return Err(error.into());
        }
        self.rebuild(touched, &[], Vec::new())
    }

    /// Gives a vertex this sharpness; 0 makes it smooth, 10 and more infinitely sharp.
    ///
    /// # Errors
    /// [`EditError::NoVertex`], [`EditError::BadSharpness`], [`EditError::Mesh`].
    pub fn set_corner(&mut self, vertex: u32, sharpness: f64) -> Result<Edited, EditError> {
        check_sharpness(sharpness)?;
        self.check_vertex(vertex)?;
        let before = self.corners.insert(vertex, sharpness);
        if let Err(error) = self.check_poles(&[vertex].into(), &BTreeSet::new(), &[]) {
            put_back(&mut self.corners, vertex, before);
            return Err(error.into());
        }
        self.rebuild([vertex].into(), &[], Vec::new())
    }

    /// Makes a face a hole, or part of the surface again.
    ///
    /// # Errors
    /// [`EditError::NoFace`], [`EditError::Mesh`].
    pub fn set_hole(&mut self, face: u32, hole: bool) -> Result<Edited, EditError> {
        self.check_face(face)?;
        let touched = self.table.topology().face_vertices(Face(face)).iter().copied().collect();
        let was_hole = if hole { !self.holes.insert(face) } else { self.holes.remove(&face) };
        if let Err(error) = self.check_poles(&touched, &BTreeSet::new(), &[]) {
            if was_hole {
                self.holes.insert(face)
            } else {
                self.holes.remove(&face)
            };
            return Err(error.into());
        }
        self.rebuild(touched, &[], Vec::new())
    }

    /// Adds a vertex that no face uses yet; surfaces need a control point for it from now on.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`] beyond 32-bit indices.
    pub fn add_vertex(&mut self) -> Result<Vertex, EditError> {
        check_count("vertices", self.table.topology().vertex_count() + 1)?;
        self.incidence.push_vertex();
        Ok(self.table.topology_mut().push_vertex())
    }

    /// Takes faces out and puts others in. Either list may be empty. Creases and corners stay where they are.
    ///
    /// # Errors
    /// [`EditError::NoFace`], [`EditError::NoVertex`], [`EditError::Sides`], [`EditError::Mesh`]; nothing is changed then.
    pub fn replace_faces(&mut self, old: &[u32], new: &[&[u32]]) -> Result<Edited, EditError> {
        for &face in old {
            self.check_face(face)?;
        }
        let triangles = self.table.scheme().split() == SplitKind::Triangles;
        for (face, vertices) in new.iter().enumerate() {
            let sides = vertices.len();
            if sides < 3 || (triangles && sides != 3) {
                let needed = if triangles { "exactly 3" } else { "at least 3" };
                return Err(EditError::Sides { face, sides, needed });
            }
            vertices.iter().try_for_each(|&v| self.check_vertex(v))?;
        }
        let t = self.table.topology();
        let corners: usize = new.iter().map(|vertices| vertices.len()).sum();
        check_count("corners", t.half_edge_count() + corners)?;

        let old: BTreeSet<u32> = old.iter().copied().collect();
        let mut touched: BTreeSet<u32> = new.iter().flat_map(|vertices| vertices.iter().copied()).collect();
        let t = self.table.topology();
        let at_old = old.iter().flat_map(|&face| t.face_vertices(Face(face)).iter().copied());
        self.check_poles(&touched.iter().copied().chain(at_old).collect(), &old, new)?;
        let mut orphans = Vec::new();
        for face in old.into_iter().map(Face) {
            let t = self.table.topology_mut();
            for corner in 0..t.sides(face) {
                let h = t.half_edge(face, corner);
                touched.insert(t.origin(h).0);
                self.incidence.unlink(h, t.origin(h));
            }
            orphans.extend(t.take_out(face));
            self.holes.remove(&face.0);
            self.table.forget(face);
        }
        let mut added = Vec::new();
        for vertices in new {
            let t = self.table.topology_mut();
            let face = t.put_in(vertices);
            for corner in 0..vertices.len() {
                let h = t.half_edge(face, corner);
                self.incidence.link(h, t.origin(h));
            }
            self.table.make_room(face);
            added.push(face);
        }
        self.rebuild(touched, &orphans, added)
    }

    /// The control mesh as it is now, without the faces that were taken out: faces in the order of their numbers. Vertices
    /// keep theirs.
    ///
    /// # Errors
    /// [`MeshError::NoFaces`] where all were taken out.
    pub fn mesh(&self) -> Result<ControlMesh, MeshError> {
        let t = self.table.topology();
        let faces: Vec<Face> = (0..t.face_count() as u32).map(Face).filter(|&f| !t.is_removed(f)).collect();
        let counts: Vec<u32> = faces.iter().map(|&f| t.sides(f) as u32).collect();
        let corners = faces.iter().flat_map(|&f| t.face_vertices(f).iter().copied()).collect();
        let holes = faces.iter().enumerate().filter(|(_, f)| self.holes.contains(&f.0)).map(|(i, _)| i as u32);
        let mut tags = Tags { holes: holes.collect(), rules: self.rules, ..Tags::default() };
        let edges = self.creases.iter().filter(|(v, _)| self.has_edge(v[0], v[1]));
        tags.creases = edges.map(|(v, &s)| Crease::new(v[0], v[1], s)).collect();
        tags.creases.sort_by_key(|c| c.vertices);
        tags.corners = self.corners.iter().map(|(&v, &s)| Corner::new(v, s)).collect();
        tags.corners.sort_by_key(|c| c.vertex);
        ControlMesh::from_counts(t.vertex_count(), &counts, corners, tags)
    }

    fn check_vertex(&self, vertex: u32) -> Result<(), EditError> {
        let vertices = self.table.topology().vertex_count();
        if (vertex as usize) < vertices { Ok(()) } else { Err(EditError::NoVertex { vertex, vertices }) }
    }

    fn check_face(&self, face: u32) -> Result<(), EditError> {
        let t = self.table.topology();
        let exists = (face as usize) < t.face_count() && !t.is_removed(Face(face));
        if exists { Ok(()) } else { Err(EditError::NoFace { face }) }
    }

    fn has_edge(&self, a: u32, b: u32) -> bool {
        let t = self.table.topology();
        let in_range = [a, b].iter().all(|&v| (v as usize) < t.vertex_count());
        let neighbours = |h: HalfEdge| [t.origin(t.next(h)).0, t.origin(t.prev(h)).0];
        in_range && a != b && self.incidence.at(Vertex(a)).any(|h| neighbours(h).contains(&b))
    }

    /// Makes tables and plans anew round the touched vertices.
    fn rebuild(&mut self, touched: BTreeSet<u32>, orphans: &[u32], added: Vec<Face>) -> Result<Edited, EditError> {
        let piece = self.piece(&touched)?;
        self.table.topology_mut().splice(&piece, orphans);
        let t = self.table.topology();
        let mut vertices = touched;
        if self.rules.creasing == Creasing::Chaikin {
            // Fractions of an edge's sharpness depend on all creases at its far end.
            vertices = self.corners_of_faces_at(&vertices);
        }
        let faces = self.faces_at(&vertices);
        let rebuilt: Vec<Face> = faces.into_iter().map(Face).filter(|&f| !t.is_hole(f)).collect();
        for face in self.faces_at(&vertices).into_iter().map(Face).filter(|&f| t.is_hole(f)).collect::<Vec<_>>() {
            self.table.forget(face);
        }
        let nodes = self.table.rebuild(&rebuilt, &mut self.known, &mut self.walk)?;
        Ok(Edited { added, rebuilt, nodes })
    }

    fn faces_at(&self, vertices: &BTreeSet<u32>) -> BTreeSet<u32> {
        let t = self.table.topology();
        vertices.iter().flat_map(|&v| self.incidence.at(Vertex(v))).map(|h| t.face(h).0).collect()
    }

    fn corners_of_faces_at(&self, vertices: &BTreeSet<u32>) -> BTreeSet<u32> {
        let t = self.table.topology();
        let corners = self.faces_at(vertices).into_iter().flat_map(|f| t.face_vertices(Face(f)).iter().copied());
        corners.chain(vertices.iter().copied()).collect()
    }

    /// The faces at the touched vertices and at the corners of those, as a topology.
    fn piece(&self, touched: &BTreeSet<u32>) -> Result<Piece, MeshError> {
        let t = self.table.topology();
        let faces: Vec<Face> = self.faces_at(&self.corners_of_faces_at(touched)).into_iter().map(Face).collect();
        let mut vertices: BTreeSet<u32> = faces.iter().flat_map(|&f| t.face_vertices(f).iter().copied()).collect();
        vertices.extend(touched);
        let vertices: Vec<u32> = vertices.into_iter().collect();
        let number: BTreeMap<u32, u32> = vertices.iter().enumerate().map(|(i, &v)| (v, i as u32)).collect();
        let half_edges: Vec<u32> = faces.iter().flat_map(|&f| t.first(f)..t.first(f) + t.sides(f) as u32).collect();
        let touched = touched.iter().map(|v| number[v]).collect();
        if faces.is_empty() {
            return Ok(Piece {
                topology: Topology::isolated(vertices.len(), self.rules),
                vertices,
                half_edges,
                touched,
            });
        }

        let counts: Vec<u32> = faces.iter().map(|&f| t.sides(f) as u32).collect();
        let corners: Vec<u32> = half_edges.iter().map(|&h| number[&t.origin(HalfEdge(h)).0]).collect();
        let mut tags = Tags { rules: self.rules, ..Tags::default() };
        let mut known = BTreeSet::new();
        for &h in &half_edges {
            let ends = [t.origin(HalfEdge(h)).0, t.origin(t.next(HalfEdge(h))).0];
            if ends[0] != ends[1]
                && known.insert(sorted(ends))
                && let Some(&s) = self.creases.get(&sorted(ends))
            {
                tags.creases.push(Crease::new(number[&ends[0]], number[&ends[1]], s));
            }
        }
        let corner = |v: &u32| self.corners.get(v).map(|&s| Corner::new(number[v], s));
        tags.corners = vertices.iter().filter_map(corner).collect();
        let is_hole = |(i, f): (usize, &Face)| self.holes.contains(&f.0).then_some(i as u32);
        tags.holes = faces.iter().enumerate().filter_map(is_hole).collect();
        let mesh = ControlMesh::from_counts(vertices.len(), &counts, corners, tags)?;
        Ok(Piece { topology: Topology::new(&mesh)?, vertices, half_edges, touched })
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Gives an entry the value that it had, if it had one.
fn put_back<K: Eq + std::hash::Hash>(all: &mut HashMap<K, f64>, key: K, before: Option<f64>) {
    match before {
        Some(value) => all.insert(key, value),
        None => all.remove(&key),
    };
}

fn check_sharpness(sharpness: f64) -> Result<(), EditError> {
    if sharpness.is_finite() { Ok(()) } else { Err(EditError::BadSharpness { sharpness }) }
}

fn check_count(what: &'static str, count: usize) -> Result<(), MeshError> {
    if count > MAX_COUNT { Err(MeshError::TooLarge { what, count, limit: MAX_COUNT }) } else { Ok(()) }
}
