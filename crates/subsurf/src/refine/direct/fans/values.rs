//! The values of fans, level by level.

use super::super::rules::{Creases, rounded};
use super::super::squares::in_quad;
use super::Fans;
use crate::kernel::vectorized;
use crate::real::Real;
use crate::scheme::catmull_clark::smooth_neighbour;
use crate::topology::{NONE, Topology};
use rayon::prelude::*;

/// Fans of a task. Fixed; larger: uneven loads; smaller: overhead of tasks.
const CHUNK: usize = 256;
/// Values of fans at the levels between.
pub(in super::super) struct FanValues<T, const N: usize> {
    /// By fan, then by level from the second on: the vertex and the ends of its edges.
    kept: Vec<[T; N]>,
    /// The vertices at the last level.
    last: Vec<[T; N]>,
}

impl Fans {
    /// Values of all fans, from those of the levels where they start, 0 and 1.
    pub fn refine<T: Real, const N: usize>(
        &self,
        t: &Topology,
        creases: &Creases,
        levels: [&[[T; N]]; 2],
    ) -> FanValues<T, N> {
        let (fans, zero) = (self.owners.len(), [T::default(); N]);
        let between = self.between();
        let size = |fans: usize| (self.starts[fans][0] as usize + fans) * between;
        let mut out = FanValues { kept: vec![zero; size(fans)], last: vec![zero; fans] };
        let mut rest = &mut out.kept[..];
        let mut tasks = Vec::new();
        for (chunk, last) in out.last.chunks_mut(CHUNK).enumerate() {
            let first = chunk * CHUNK;
            let (part, tail) = rest.split_at_mut(size(first + last.len()) - size(first));
            rest = tail;
            tasks.push((first, part, last));
        }
        tasks.into_par_iter().for_each_init(Scratch::default, |scratch, (first, mut kept, last)| {
            vectorized(
                #[inline(always)]
                || {
                    for (last, fan) in last.iter_mut().zip(first..) {
                        let (part, tail) = kept.split_at_mut(size(fan + 1) - size(fan));
                        kept = tail;
                        *last = self.refine_fan(t, creases, levels, fan, scratch, part);
                    }
                },
            );
        });
        out
    }

    /// One fan through all levels; returns the vertex at the last.
    #[inline(always)]
    fn refine_fan<T: Real, const N: usize>(
        &self,
        t: &Topology,
        creases: &Creases,
        levels: [&[[T; N]]; 2],
        fan: usize,
        scratch: &mut Scratch<T, N>,
        mut kept: &mut [[T; N]],
    ) -> [T; N] {
        let [edges, faces] = self.range(fan);
        let (edges, faces) = (&self.edges[edges], &self.faces[faces]);
        let (first_centre, is_centre) = (t.vertex_count(), fan >= self.centres);
        let first_edge = first_centre + t.face_count();
        let start = self.starts_at(fan);
        let (level, smooth) = (levels[start], rounded::<T>(creases.rule(start, 0)).edge);
        let Scratch { ends, across, sums } = scratch;
        let mut own = level[self.owners[fan] as usize + if is_centre { first_centre } else { 0 }];
        ends.clear();
        across.clear();
        if start == 0 {
            ends.resize(edges.len(), own);
            for face in faces {
                let origin = |by: u32| level[t.origin[in_quad(t, face.h, by) as usize] as usize];
                [ends[face.sides[0] as usize], ends[face.sides[1] as usize]] = [origin(1), origin(3)];
                across.push(origin(2));
            }
        } else {
            ends.extend(edges.iter().map(|e| level[first_edge + e[0] as usize]));
            let diagonal =
                |h: u32| if is_centre { t.origin[h as usize] as usize } else { first_centre + t.face.get(h) as usize };
            across.extend(faces.iter().map(|face| level[diagonal(face.h)]));
        }
        let (quarter, each) = (T::from_f64(0.25), T::from_f64(smooth_neighbour(edges.len().max(1), 1.0)));
        if start > self.start {
            kept = keep(own, ends, kept);
        }
        for at in start..self.depth {
            let is_last = at + 1 == self.depth;
            // Face points, and their sums by edge and round the vertex, relative to it.
            sums.clear();
            sums.resize(edges.len(), [T::default(); N]);
            let mut all = [T::default(); N];
            for (face, across) in faces.iter().zip(&mut *across) {
                let [a, b] = [face.sides[0] as usize, face.sides[1] as usize];
                for c in 0..N {
                    across[c] = quarter * ((own[c] + across[c]) + (ends[a][c] + ends[b][c]));
                    let apart = across[c] - own[c];
                    sums[a][c] = sums[a][c] + apart;
                    sums[b][c] = sums[b][c] + apart;
                    all[c] = all[c] + apart;
                }
            }
            let next = if self.row_of[fan] != NONE {
                let value = |id: u32| match id as usize {
                    0 => own,
                    id if id <= ends.len() => ends[id - 1],
                    id => across[id - 1 - ends.len()],
                };
                self.rows[at - self.start].apply(self.row_of[fan] as usize, value)
            } else {
                let mut next = own;
                ends.iter().for_each(|end| (0..N).for_each(|c| all[c] = all[c] + (end[c] - own[c])));
                for c in 0..N {
                    next[c] = own[c] + each * all[c];
                }
                next
            };
            if is_last {
                return next;
            }
            for ((end, sum), edge) in ends.iter_mut().zip(&*sums).zip(edges) {
                let [weight, centroid] =
                    if edge[1] == 0 { smooth } else { rounded::<T>(creases.rule(at, edge[1])).edge };
                for c in 0..N {
                    end[c] = own[c] + (weight * (end[c] - own[c]) + centroid * sum[c]);
                }
            }
            own = next;
            kept = keep(own, ends, kept);
        }
        own
    }

    /// A fan's vertex and the ends of its edges at a level between the first and the last.
    #[inline(always)]
    pub fn kept<'a, T: Real, const N: usize>(
        &self,
        values: &'a FanValues<T, N>,
        fan: u32,
        level: usize,
    ) -> &'a [[T; N]] {
        let (start, end) = (self.starts[fan as usize][0] as usize, self.starts[fan as usize + 1][0] as usize);
        let points = end - start + 1;
        &values.kept[(start + fan as usize) * self.between() + (level - self.start - 1) * points..][..points]
    }

    /// The centre of a face that is no quad, at the last level.
    pub fn centre<T: Real, const N: usize>(&self, values: &FanValues<T, N>, f: u32) -> Option<[T; N]> {
        self.of_centre(f).map(|fan| values.last[fan as usize])
    }

    /// Puts control vertices where they belong.
    pub fn write<T: Real, const N: usize>(&self, values: &FanValues<T, N>, out: &mut [[T; N]]) {
        self.owners[..self.centres].iter().zip(&values.last).for_each(|(&v, &value)| out[v as usize] = value);
    }
}

/// Puts a fan's vertex and the ends of its edges before what comes next.
#[inline(always)]
fn keep<'a, T: Real, const N: usize>(own: [T; N], ends: &[[T; N]], kept: &'a mut [[T; N]]) -> &'a mut [[T; N]] {
    let (part, rest) = kept.split_at_mut(1 + ends.len());
    part[0] = own;
    part[1..].copy_from_slice(ends);
    rest
}

/// Memory that is used again and again: ends of edges, what lies across faces, sums by edge.
struct Scratch<T, const N: usize> {
    ends: Vec<[T; N]>,
    across: Vec<[T; N]>,
    sums: Vec<[T; N]>,
}

impl<T, const N: usize> Default for Scratch<T, N> {
    fn default() -> Self {
        Self { ends: Vec::new(), across: Vec::new(), sums: Vec::new() }
    }
}
