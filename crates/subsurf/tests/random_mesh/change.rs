//! Changes that make polygons, triangles and valences of all kinds.

use super::pick;
use proptest::prelude::*;
use std::collections::{BTreeMap, HashMap, HashSet};

/// A change of the mesh; one that would make it no manifold is left out.
#[derive(Clone, Copy, Debug)]
pub enum Change {
    /// Takes an edge out between two faces.
    Merge(u16),
    /// Cuts a face in two.
    Cut(u16, u8),
    /// Draws an edge together.
    Collapse(u16),
    /// Takes a face out.
    Delete(u16),
    /// Puts a vertex into a face.
    Poke(u16),
    /// Puts a vertex into an edge, so that its faces gain a corner.
    Bisect(u16),
    /// A second sheet along an edge: the edge then has three faces.
    Sheet(u16),
}

pub type Edges = BTreeMap<(u32, u32), Vec<usize>>;

/// Faces of every edge.
pub fn edges_of(faces: &[Vec<u32>]) -> Edges {
    let mut edges = Edges::new();
    for (f, face) in faces.iter().enumerate() {
        for i in 0..face.len() {
            let (a, b) = (face[i], face[(i + 1) % face.len()]);
            edges.entry((a.min(b), a.max(b))).or_default().push(f);
        }
    }
    edges
}

/// True where faces visit no vertex twice, edges have one face or two in opposite directions, and vertices one fan.
pub fn is_manifold(faces: &[Vec<u32>]) -> bool {
    let mut runs: HashMap<(u32, u32), usize> = HashMap::new();
    for (f, face) in faces.iter().enumerate() {
        if face.len() < 3 || face.iter().collect::<HashSet<_>>().len() < face.len() {
            return false;
        }
        for i in 0..face.len() {
            if runs.insert((face[i], face[(i + 1) % face.len()]), f).is_some() {
                return false;
            }
        }
    }
    let mut at: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    faces.iter().enumerate().for_each(|(f, face)| face.iter().for_each(|&v| at.entry(v).or_default().push(f)));
    at.iter().all(|(&v, list)| {
        let mut known = HashSet::from([list[0]]);
        let mut todo = vec![list[0]];
        while let Some(f) = todo.pop() {
            let face = &faces[f];
            let i = face.iter().position(|&w| w == v).unwrap();
            let (next, before) = (face[(i + 1) % face.len()], face[(i + face.len() - 1) % face.len()]);
            for g in [runs.get(&(next, v)), runs.get(&(v, before))].into_iter().flatten() {
                if known.insert(*g) {
                    todo.push(*g);
                }
            }
        }
        known.len() == list.len()
    })
}

pub fn change(faces: &[Vec<u32>], what: Change) -> Option<Vec<Vec<u32>>> {
    let edges: Vec<((u32, u32), Vec<usize>)> = edges_of(faces).into_iter().collect();
    let free = faces.iter().flatten().max().map_or(0, |v| v + 1);
    let mut out = faces.to_vec();
    // A face as a list that starts at vertex `v`.
    let from = |face: &[u32], v: u32| {
        let i = face.iter().position(|&w| w == v).unwrap();
        let mut list = face.to_vec();
        list.rotate_left(i);
        list
    };
    match what {
        Change::Merge(i) => {
            let &((a, b), ref both) = pick(&edges, i)?;
            let &[f, g] = &both[..] else { return None };
            // The face that runs from a to b, seen from b; then the other, seen from a.
            let forward = |f: &usize| from(&faces[*f], a)[1] == b;
            let (f, g) = if forward(&f) { (f, g) } else { (g, f) };
            let mut merged = from(&faces[f], b);
            let other = from(&faces[g], a);
            merged.extend_from_slice(&other[1..other.len() - 1]);
            if merged.len() > 12 {
                return None;
            }
            out[f] = merged;
            out.remove(g);
        }
        Change::Cut(i, corner) => {
            let f = usize::from(i) % faces.len();
            let n = faces[f].len();
            if n < 4 {
                return None;
            }
            let list = from(&faces[f], faces[f][usize::from(corner) % n]);
            let at = 2 + usize::from(corner) / n % (n - 3);
            out[f] = list[..=at].to_vec();
            out.push(list[at..].iter().copied().chain([list[0]]).collect());
        }
        Change::Collapse(i) => {
            let &((a, b), _) = pick(&edges, i)?;
            for face in &mut out {
                face.iter_mut().for_each(|v| *v = if *v == b { a } else { *v });
                face.dedup();
                if face.len() > 1 && face[0] == face[face.len() - 1] {
                    face.pop();
                }
            }
            out.retain(|face| face.len() > 2);
        }
        Change::Delete(i) => {
            if faces.len() < 3 {
                return None;
            }
            out.remove(usize::from(i) % faces.len());
        }
        Change::Poke(i) => {
            let f = usize::from(i) % faces.len();
            let face = out.remove(f);
            out.extend((0..face.len()).map(|k| vec![face[k], face[(k + 1) % face.len()], free]));
        }
        Change::Bisect(i) => {
            let &((a, b), _) = pick(&edges, i)?;
            for face in &mut out {
                let n = face.len();
                let joins = |k: &usize| {
                    let (p, q) = (face[*k], face[(k + 1) % n]);
                    (p.min(q), p.max(q)) == (a, b)
                };
                if let Some(k) = (0..n).find(joins) {
                    face.insert(k + 1, free);
                }
            }
        }
        Change::Sheet(i) => {
            let &((a, b), _) = pick(&edges, i)?;
            out.push(vec![a, b, free, free + 1]);
            return Some(out);
        }
    }
    (!out.is_empty() && out.len() < 700 && is_manifold(&out)).then_some(out)
}

pub fn a_change() -> impl Strategy<Value = Change> {
    let i = any::<u16>;
    prop_oneof![
        3 => i().prop_map(Change::Merge),
        2 => (i(), any::<u8>()).prop_map(|(f, c)| Change::Cut(f, c)),
        3 => i().prop_map(Change::Collapse),
        1 => i().prop_map(Change::Delete),
        1 => i().prop_map(Change::Poke),
        1 => i().prop_map(Change::Bisect),
        1 => i().prop_map(Change::Sheet),
    ]
}
