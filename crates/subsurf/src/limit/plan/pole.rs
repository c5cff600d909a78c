//! The way from a face to a vertex of many faces, taken by values.

use super::{End, Leaf, LeafShape, Plan, Split, corners, turn_back};
use crate::limit::pole::is_pole;
use crate::limit::special::{PointWeights, SpecialVertex};
use crate::limit::turn::turned;
use crate::scheme::SplitKind;

/// A location in a leaf at a vertex of many faces.
pub(crate) struct AtPole<'a> {
    split: SplitKind,
    pub vertex: &'a SpecialVertex,
    leaf: &'a Leaf,
    way: Vec<(&'a Split, &'a [u32])>,
    /// Tells the leaves of a plan apart.
    pub path: u64,
    /// Parameters with the vertex at the origin.
    pub at: [f64; 2],
    turn: u8,
    speed: f64,
}

/// Longest way whose [path](AtPole::path) is told apart from others.
const LONGEST: usize = 31;

impl<'a> Plan<'a> {
    /// Where `(u, v)` lies, if that is at a vertex of many faces; parameters of a face whose corner `turn` is the plan's corner 0.
    pub fn at_pole(self, u: f64, v: f64, turn: u8) -> Option<AtPole<'a>> {
        let split = self.plans.split;
        let (mut way, mut path) = (Vec::new(), 1);
        let (end, at, _) = self.walk(u, v, turn, 0, |_, split, child| {
            way.push((split, split.ring(child)));
            path = path << 2 | u64::from(child.number);
        });
        let End::Leaf(leaf) = end else { return None };
        let LeafShape::Special { turn, vertex } = &leaf.shape else { return None };
        if !is_pole(vertex) || !leaf.creases.is_empty() || way.len() > LONGEST {
            return None;
        }
        let turn = (at.turn + turn) % corners(split) as u8;
        let (a, b) = turned(split, at.u, at.v, turn);
        Some(AtPole { split, vertex, leaf, way, path, at: [a, b], turn, speed: at.speed })
    }
}

impl AtPole<'_> {
    /// Values at the vertex's points from those at the ring of the face, in rows of `chunks` vectors.
    pub fn points<const W: usize>(&self, ring: Vec<[f64; W]>, chunks: usize) -> Vec<[f64; W]> {
        let combine = |terms: (&[u32], &[f64]), from: &[[f64; W]], out: &mut Vec<[f64; W]>| {
            let start = out.len();
            out.resize(start + chunks, [0.0; W]);
            for (&c, &w) in terms.0.iter().zip(terms.1) {
                for (out, from) in out[start..].iter_mut().zip(&from[c as usize * chunks..]) {
                    for l in 0..W {
                        out[l] += w * from[l];
                    }
                }
            }
        };
        let mut values = ring;
        for (split, rows) in &self.way {
            let mut below = Vec::with_capacity(rows.len() * chunks);
            rows.iter().for_each(|&row| combine(split.points.terms(row as usize), &values, &mut below));
            values = below;
        }
        let mut points = Vec::with_capacity(self.leaf.points.len() * chunks);
        (0..self.leaf.points.len()).for_each(|k| combine(self.leaf.points.terms(k), &values, &mut points));
        points
    }

    /// Rows of a jet in the parameters at the vertex, in those of the face; at the vertex derivatives are directions.
    pub fn in_face(&self, rows: PointWeights) -> PointWeights {
        let mut rows = turn_back(self.split, rows, self.turn);
        for (row, times) in rows.rows.iter_mut().zip([0, 1, 1, 2, 2, 2]) {
            let factor = self.speed.powi(times);
            row.iter_mut().for_each(|x| *x *= factor);
        }
        rows
    }
}
