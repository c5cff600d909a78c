//! Edits that would leave so many faces at a vertex that the table takes too much memory: they are refused before anything is
//! changed.

use super::{TableEditor, sorted};
use crate::index::{Face, Vertex};
use crate::limit::check_edit;
use crate::mesh::{ControlMesh, MeshError, Pole};
use crate::tags::{Corner, Crease, Creasing, Tags};
use crate::topology::Topology;
use std::collections::{BTreeSet, HashMap};

/// Faces at a vertex, or corners of a face, from which on an edit asks how much memory the table would take there. Smaller: time
/// for edits at vertices where that is little.
const MANY: usize = 60;

impl TableEditor {
    /// Refuses what would leave so many faces at a vertex, or corners at a face, that the table takes too much memory: faces at the
    /// touched vertices without the old ones and with the new ones, creases, corners and holes as they are noted.
    pub(super) fn check_poles(
        &self,
        touched: &BTreeSet<u32>,
        old: &BTreeSet<u32>,
        new: &[&[u32]],
    ) -> Result<(), MeshError> {
        let t = self.table.topology();
        let corners = self.corners_of_faces_at(touched);
        // Whether there are many at all is seen from the lists of faces.
        let added = |v: u32| new.iter().filter(|face| face.contains(&v)).count();
        let is_many = |&v: &u32| self.incidence.at(Vertex(v)).take(MANY).count() + added(v) >= MANY;
        let is_large = new.iter().any(|face| face.len() >= MANY);
        if !is_large && !corners.iter().any(is_many) {
            return Ok(());
        }
        let kept: Vec<Face> =
            self.faces_at(&corners).into_iter().filter(|face| !old.contains(face)).map(Face).collect();
        let lists = kept.iter().map(|&face| t.face_vertices(face)).chain(new.iter().copied());
        let vertices: BTreeSet<u32> = lists.clone().flatten().copied().collect();
        let vertices: Vec<u32> = vertices.into_iter().collect();
        let number: HashMap<u32, u32> = vertices.iter().copied().zip(0..).collect();
        let faces: Vec<Vec<u32>> = lists.map(|face| face.iter().map(|v| number[v]).collect()).collect();
        if faces.is_empty() {
            return Ok(());
        }
        let mut tags = Tags { rules: self.rules, ..Tags::default() };
        let mut sides = BTreeSet::new();
        for face in &faces {
            for (k, &a) in face.iter().enumerate() {
                let edge = sorted([a, face[(k + 1) % face.len()]]);
                let sharpness = self.creases.get(&sorted(edge.map(|v| vertices[v as usize])));
                if let Some(&s) = sharpness.filter(|_| edge[0] != edge[1] && sides.insert(edge)) {
                    tags.creases.push(Crease::new(edge[0], edge[1], s));
                }
            }
        }
        let corner = |v: &u32| self.corners.get(v).map(|&s| Corner::new(number[v], s));
        tags.corners = vertices.iter().filter_map(corner).collect();
        let holes = kept.iter().zip(0..).filter(|(face, _)| self.holes.contains(&face.0));
        tags.holes = holes.map(|(_, i)| i).collect();
        let topology = Topology::new(&ControlMesh::new(&faces, tags)?)?;
        let in_mesh = |face: u32| kept.get(face as usize).map_or(t.face_count() as u32, |face| face.0);
        // Under Chaikin's rule creases at far ends have a say.
        let touched = if self.rules.creasing == Creasing::Chaikin { &corners } else { touched };
        let is_new = |face: Face| topology.face_vertices(face).iter().any(|&v| touched.contains(&vertices[v as usize]));
        check_edit(&topology, self.table.scheme(), is_new).map_err(|error| match error {
            MeshError::PoleTooLarge { pole: Pole::Vertex { vertex, faces }, bytes, limit } => {
                let pole = Pole::Vertex { vertex: vertices[vertex as usize], faces };
                MeshError::PoleTooLarge { pole, bytes, limit }
            }
            MeshError::PoleTooLarge { pole: Pole::Face { face, corners }, bytes, limit } => {
                MeshError::PoleTooLarge { pole: Pole::Face { face: in_mesh(face), corners }, bytes, limit }
            }
            error => error,
        })
    }
}
