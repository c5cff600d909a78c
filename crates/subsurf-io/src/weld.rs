//! One index per vertex, for formats that have no more: where normals or texture coordinates have indices of their
//! own, a vertex is split for each combination that occurs.

use crate::output::{OutputMesh, Real};
use std::borrow::Cow;

/// A mesh with one index for each corner.
pub struct Welded<'a> {
    /// Indices of position, normal and texture coordinate of each vertex, in the order of first use; `None` where
    /// nothing is split: then every vertex, used or not, has its own index throughout.
    vertices: Option<Vec<[u32; 3]>>,
    vertex_count: usize,
    /// The vertex of each corner.
    pub corners: Cow<'a, [u32]>,
}

impl Welded<'_> {
    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// Indices of position, normal and texture coordinate of each vertex.
    pub fn vertices(&self) -> impl Iterator<Item = [usize; 3]> {
        (0..self.vertex_count).map(|vertex| match &self.vertices {
            Some(vertices) => vertices[vertex].map(|index| index as usize),
            None => [vertex; 3],
        })
    }
}

/// In the lists below: no vertex.
const NONE: u32 = u32::MAX;

/// Welds `mesh`, which has been checked. `None` if there come to be more vertices than 32 bits can count.
pub fn weld<'a, T: Real>(mesh: &OutputMesh<'a, T>) -> Option<Welded<'a>> {
    let vertex_count = mesh.positions.len();
    let shared = mesh.normals.is_none_or(|normals| normals.is_shared(mesh.corners, vertex_count))
        && mesh.texture.is_none_or(|texture| texture.is_shared(mesh.corners, vertex_count));
    if shared {
        let fits = vertex_count < NONE as usize;
        return fits.then_some(Welded { vertices: None, vertex_count, corners: Cow::Borrowed(mesh.corners) });
    }
    // The vertices made of one position form a list: its first, then for each the next.
    let mut first = vec![NONE; vertex_count];
    let mut next: Vec<u32> = Vec::new();
    let mut vertices: Vec<[u32; 3]> = Vec::new();
    let normals = mesh.normals.map(|normals| normals.indices.unwrap_or(mesh.corners));
    let texture = mesh.texture.map(|texture| texture.indices.unwrap_or(mesh.corners));
    let mut corners = Vec::with_capacity(mesh.corners.len());
    for (corner, &position) in mesh.corners.iter().enumerate() {
        let key = [position, normals.map_or(0, |n| n[corner]), texture.map_or(0, |t| t[corner])];
        let mut vertex = first[position as usize];
        while vertex != NONE && vertices[vertex as usize] != key {
            vertex = next[vertex as usize];
        }
        if vertex == NONE {
            vertex = u32::try_from(vertices.len()).ok().filter(|&v| v != NONE)?;
            vertices.push(key);
            next.push(first[position as usize]);
            first[position as usize] = vertex;
        }
        corners.push(vertex);
    }
    Some(Welded { vertex_count: vertices.len(), vertices: Some(vertices), corners: Cow::Owned(corners) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{Attribute, FaceSizes};

    /// Two triangles over an edge, with an isolated vertex 0.
    const MESH: OutputMesh<'_, f32> = OutputMesh {
        positions: &[[0.0; 3]; 5],
        sizes: FaceSizes::Uniform(3),
        corners: &[4, 1, 2, 2, 1, 3],
        normals: None,
        texture: None,
        tags: None,
    };

    #[test]
    fn a_mesh_without_seams_keeps_all_its_vertices_in_order() {
        let normals = Some(Attribute { values: &[[0.0; 3]; 5], indices: None });
        let texture = Some(Attribute { values: &[[0.0; 2]; 5], indices: Some(MESH.corners) });
        let mesh = OutputMesh { normals, texture, ..MESH };
        let welded = weld(&mesh).unwrap();
        assert_eq!(welded.vertex_count(), 5);
        assert_eq!(welded.corners, MESH.corners);
    }

    #[test]
    fn a_seam_splits_its_vertices_in_the_order_of_first_use() {
        let texture = Some(Attribute { values: &[[0.0; 2]; 4], indices: Some(&[0, 1, 2, 2, 3, 0]) });
        let mesh = OutputMesh { texture, ..MESH };
        let welded = weld(&mesh).unwrap();
        let vertices: Vec<_> = welded.vertices().collect();
        assert_eq!(vertices, [[4, 0, 0], [1, 0, 1], [2, 0, 2], [1, 0, 3], [3, 0, 0]]);
        assert_eq!(welded.corners[..], [0, 1, 2, 2, 3, 4]);
    }
}
