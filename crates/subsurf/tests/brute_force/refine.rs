//! One refinement step round face 0, and what is kept of it.

use super::masks::decay;
use super::point::{Point, over, plus, sum, times};
use super::{Double, Rings, Soup, key};
use std::collections::{BTreeMap, HashMap, HashSet};

impl Soup {
    /// Faces at the corners of the faces in `of`, those first.
    pub(super) fn grown(&self, of: &[usize], rings: &Rings) -> Vec<usize> {
        let mut list = of.to_vec();
        let mut known: HashSet<usize> = of.iter().copied().collect();
        for &f in of {
            for v in &self.faces[f] {
                for &g in &rings.vertex_faces[v] {
                    if known.insert(g) {
                        list.push(g);
                    }
                }
            }
        }
        list
    }

    /// Face `face` and two rings of faces round it, relative to its first corner.
    pub(super) fn cut_out(&self, face: usize, rings: &Rings) -> Self {
        let one = self.grown(&[face], rings);
        let two = self.grown(&one, rings);
        let mut new_of = HashMap::new();
        let mut old = Vec::new();
        let faces: Vec<Vec<u32>> = two
            .iter()
            .map(|&f| {
                let renumber = |&v: &u32| {
                    *new_of.entry(v).or_insert_with(|| {
                        old.push(v);
                        old.len() as u32 - 1
                    })
                };
                self.faces[f].iter().map(renumber).collect()
            })
            .collect();
        let base = self.points[old[0] as usize];
        let away = times(base, Double::from(-1.0));
        let mut edge_sharpness = HashMap::new();
        for (&(a, b), &s) in &self.edge_sharpness {
            if let (Some(&a), Some(&b)) = (new_of.get(&a), new_of.get(&b)) {
                edge_sharpness.insert(key(a, b), s);
            }
        }
        Self {
            faces,
            points: old.iter().map(|&v| plus(self.points[v as usize], away)).collect(),
            vertex_sharpness: old.iter().map(|&v| self.vertex_sharpness[v as usize]).collect(),
            edge_sharpness,
            holes: HashSet::new(),
            triangles: self.triangles,
            chaikin: self.chaikin,
            smooth_triangles: self.smooth_triangles,
            zero: plus(self.zero, base),
        }
    }

    /// One refinement step; the next face 0 is face 0's child at `corner`, or its middle one: 3, under Loop.
    pub(super) fn child(&self, corner: usize) -> Self {
        let rings = self.rings();
        // Vertices whose faces are all here.
        let inner: HashSet<u32> =
            self.grown(&[0], &rings).iter().flat_map(|&f| self.faces[f].iter().copied()).collect();
        let centroid = |f: &Vec<u32>| over(sum(f.iter().map(|&v| self.points[v as usize])), f.len());
        let face_points: Vec<Point> = self.faces.iter().map(centroid).collect();
        let mut points = face_points.clone();
        let mut sharpness = vec![0.0; points.len()];
        let mut edge_sharpness = HashMap::new();
        let mut vertex_of = BTreeMap::new();
        for &v in &inner {
            vertex_of.insert(v, points.len() as u32);
            points.push(self.vertex_point(v, &rings, &face_points));
            sharpness.push(decay(self.vertex_sharpness[v as usize]));
        }
        let mut edge_of = HashMap::new();
        for &e in rings.edge_faces.keys().filter(|e| inner.contains(&e.0) || inner.contains(&e.1)) {
            let new = points.len() as u32;
            edge_of.insert(e, new);
            points.push(self.edge_point_or_middle(e, &rings, &face_points, &inner));
            sharpness.push(0.0);
            for v in [e.0, e.1].into_iter().filter(|v| inner.contains(v)) {
                let half = self.half(e, v, &rings);
                if half > 0.0 {
                    edge_sharpness.insert(key(vertex_of[&v], new), half);
                }
            }
        }
        let mut faces = Vec::new();
        let mut own = 0;
        for (f, face) in self.faces.iter().enumerate() {
            let n = face.len();
            for (i, v) in face.iter().enumerate().filter(|(_, v)| inner.contains(v)) {
                let (after, before) = (face[(i + 1) % n], face[(i + n - 1) % n]);
                let (after, before) = (edge_of[&key(*v, after)], edge_of[&key(before, *v)]);
                let mut child = if self.triangles {
                    vec![vertex_of[v], after, before]
                } else {
                    vec![vertex_of[v], after, f as u32, before]
                };
                // Axes keep their direction, except in the sub-faces of polygons.
                if self.triangles || n == 4 {
                    child.rotate_right(i);
                }
                if f == 0 && i == corner {
                    own = faces.len();
                }
                faces.push(child);
            }
            let middle = |i: usize| edge_of.get(&key(face[i], face[(i + 1) % n])).copied();
            if let (true, [Some(a), Some(b), Some(c)]) = (self.triangles, [middle(1), middle(2), middle(0)]) {
                if f == 0 && corner == 3 {
                    own = faces.len();
                }
                faces.push(vec![a, b, c]);
            }
        }
        let refined = Self {
            faces,
            points,
            vertex_sharpness: sharpness,
            edge_sharpness,
            holes: HashSet::new(),
            triangles: self.triangles,
            chaikin: self.chaikin,
            smooth_triangles: self.smooth_triangles,
            zero: self.zero,
        };
        let rings = refined.rings();
        refined.cut_out(own, &rings)
    }
}
