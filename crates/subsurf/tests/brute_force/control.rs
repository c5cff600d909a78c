//! The control mesh as a polygon soup: its tags, and what its rules and its oddities make sharp.

use super::{Double, INFINITE, Rings, Soup, key, sides};
use std::collections::{HashMap, HashSet};
use subsurf::{Boundary, ControlMesh, Creasing, Scheme, Triangles};

impl Soup {
    /// The control mesh with its rules applied. No face may visit a vertex twice, and under Loop no two have the same
    /// vertices: their edge points would be joined by two edges.
    pub fn new(mesh: &ControlMesh, scheme: Scheme, positions: &[[f64; 3]]) -> Self {
        let tags = mesh.tags();
        let mut soup = Self {
            faces: mesh.faces().map(<[u32]>::to_vec).collect(),
            points: positions.iter().map(|p| p.map(Double::from)).collect(),
            vertex_sharpness: vec![0.0; positions.len()],
            edge_sharpness: HashMap::new(),
            holes: tags.holes.iter().map(|&f| f as usize).collect(),
            triangles: match scheme {
                Scheme::CatmullClark => false,
                Scheme::Loop => true,
                _ => panic!("no brute force for {scheme:?}"),
            },
            chaikin: tags.rules.creasing == Creasing::Chaikin,
            smooth_triangles: tags.rules.triangles == Triangles::Smooth,
            zero: [Double::ZERO; 3],
        };
        for f in &soup.faces {
            let distinct: HashSet<u32> = f.iter().copied().collect();
            assert_eq!(distinct.len(), f.len(), "a face visits a vertex twice");
        }
        for c in &tags.creases {
            soup.edge_sharpness.insert(key(c.vertices[0], c.vertices[1]), c.sharpness.clamp(0.0, INFINITE));
        }
        for c in &tags.corners {
            soup.vertex_sharpness[c.vertex as usize] = c.sharpness.clamp(0.0, INFINITE);
        }
        let rings = soup.rings();
        let is_boundary = |e: &(u32, u32)| rings.edge_faces[e].len() < 2;
        let odd: HashSet<(u32, u32)> = rings
            .edge_faces
            .keys()
            .copied()
            .filter(|e| rings.edge_faces[e].len() > 2 || soup.conflict(*e, &rings))
            .collect();
        let is_odd = |e: &(u32, u32)| odd.contains(e);
        if tags.rules.boundary == Boundary::None {
            let open: HashSet<u32> = rings
                .edge_faces
                .keys()
                .filter(|e| is_boundary(e) && soup.edge_sharpness.get(e).is_none_or(|&s| s < INFINITE))
                .flat_map(|e| [e.0, e.1])
                .collect();
            let holes: Vec<usize> =
                (0..soup.faces.len()).filter(|&f| soup.faces[f].iter().any(|v| open.contains(v))).collect();
            soup.holes.extend(holes);
        }
        let mut pinned = Vec::new();
        for (&v, edges) in &rings.vertex_edges {
            let sheets = soup.sheets(v, &rings);
            let odd: Vec<(u32, u32)> = edges.iter().copied().filter(is_odd).collect();
            let lone = rings.vertex_faces[&v].len() == 1 && tags.rules.boundary == Boundary::EdgeAndCorner;
            // A crease along which several sheets meet stays a crease.
            let along = odd.len() == 2
                && rings.vertex_faces[&v].len() > edges.len()
                && rings.edge_faces[&odd[0]].len() == rings.edge_faces[&odd[1]].len()
                && sheets.iter().all(|ends| ends.len() == 2 && odd.iter().all(|e| ends.contains(e)));
            if lone || (!odd.is_empty() && !along) || (odd.is_empty() && sheets.len() > 1) {
                pinned.push(v);
            }
        }
        let sharp: Vec<(u32, u32)> = rings.edge_faces.keys().copied().filter(|e| is_boundary(e) || is_odd(e)).collect();
        sharp.into_iter().for_each(|e| _ = soup.edge_sharpness.insert(e, INFINITE));
        pinned.into_iter().for_each(|v| soup.vertex_sharpness[v as usize] = INFINITE);
        soup.edge_sharpness.retain(|_, s| *s > 0.0);
        soup
    }

    /// True where two faces run through an edge in the same direction.
    fn conflict(&self, e: (u32, u32), rings: &Rings) -> bool {
        let forward = |f: usize| sides(&self.faces[f]).any(|s| s == e);
        let faces = &rings.edge_faces[&e];
        faces.len() == 2 && forward(faces[0]) == forward(faces[1])
    }

    /// The fans at a vertex, of faces joined through edges of two faces: for each fan the edges where it ends.
    fn sheets(&self, v: u32, rings: &Rings) -> Vec<Vec<(u32, u32)>> {
        let mut left: HashSet<usize> = rings.vertex_faces[&v].iter().copied().collect();
        let mut sheets = Vec::new();
        while let Some(&start) = left.iter().min() {
            let (mut ends, mut todo) = (Vec::new(), vec![start]);
            left.remove(&start);
            while let Some(f) = todo.pop() {
                for (a, b) in sides(&self.faces[f]).filter(|&(a, b)| a == v || b == v) {
                    let e = key(a, b);
                    if rings.edge_faces[&e].len() != 2 || self.conflict(e, rings) {
                        ends.push(e);
                        continue;
                    }
                    for &g in &rings.edge_faces[&e] {
                        if left.remove(&g) {
                            todo.push(g);
                        }
                    }
                }
            }
            sheets.push(ends);
        }
        sheets
    }
}
