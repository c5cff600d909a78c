//! The values of fans, level by level.

use super::super::rules::{Creases, rounded};
use super::super::squares::in_quad;
use super::tables::Kind;
use super::{FanCorner, FanTables, Fans};
use crate::kernel::{LANES, vectorized};
use crate::real::Real;
use crate::scheme::catmull_clark::smooth_neighbour;
use crate::threads;
use crate::topology::Topology;

/// Fans of a task. Fixed; larger: uneven loads; smaller: overhead of tasks.
const CHUNK: usize = 256;

/// Values of fans at the levels between.
pub(in super::super) struct FanValues<'a, T, const N: usize> {
    /// Fan by fan, then by level from the second on: the vertex and the ends of its edges.
    kept: Vec<[T; N]>,
    /// The vertices at the last level.
    last: Vec<[T; N]>,
    /// Where there are tables, fans come in their order.
    tables: Option<&'a FanTables>,
}

/// Fans that follow each other, with room for their values; where they have the same rules, the numbers of their points.
struct Task<'a, T, const N: usize> {
    first: usize,
    kept: &'a mut [[T; N]],
    last: &'a mut [[T; N]],
    numbers: Option<&'a [[u32; LANES]]>,
}

impl Fans {
    /// Values of all fans, from those of the levels where they start, 0 and 1.
    pub fn refine<'a, T: Real, const N: usize>(
        &self,
        t: &Topology,
        creases: &Creases,
        levels: [&[[T; N]]; 2],
        tables: Option<&'a FanTables>,
    ) -> FanValues<'a, T, N> {
        let (fans, zero) = (self.owners.len(), [T::default(); N]);
        let mut out = FanValues { kept: vec![zero; self.kept_before(fans)], last: vec![zero; fans], tables };
        let all = [Kind { fans: 0..fans, numbers: None }];
        let fan_at = |at: usize| tables.map_or(at, |tables| tables.order[at] as usize);
        let (mut kept, mut last) = (&mut out.kept[..], &mut out.last[..]);
        let mut tasks = Vec::new();
        for kind in tables.map_or(&all[..], |tables| &tables.kinds) {
            for first in kind.fans.clone().step_by(CHUNK) {
                let fans = first..(first + CHUNK).min(kind.fans.end);
                let (part, tail) = last.split_at_mut(fans.len());
                last = tail;
                let numbers = kind.numbers.zip(tables).map(|(start, tables)| {
                    let points = 1 + self.range(fan_at(first)).map(|range| range.len()).iter().sum::<usize>();
                    &tables.numbers[start + (first - kind.fans.start) / LANES * points..]
                });
                let size = fans.map(|at| self.kept_of(fan_at(at))).sum();
                let (own, tail) = kept.split_at_mut(size);
                kept = tail;
                tasks.push(Task { first, kept: own, last: part, numbers });
            }
        }
        threads::for_each_init(tasks, Default::default, |(scratch, lanes), task| {
            let Task { first, mut kept, last, numbers } = task;
            if let Some(numbers) = numbers {
                return self.refine_alike(creases, levels, fan_at(first), numbers, lanes, kept, last);
            }
            vectorized(
                #[inline(always)]
                || {
                    for (last, at) in last.iter_mut().zip(first..) {
                        let fan = fan_at(at);
                        let (part, tail) = std::mem::take(&mut kept).split_at_mut(self.kept_of(fan));
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
            let next = if let Some(row) = self.row(fan) {
                let value = |id: u32| match id as usize {
                    0 => own,
                    id if id <= ends.len() => ends[id - 1],
                    id => across[id - 1 - ends.len()],
                };
                self.rows[at - self.start].apply(row, value)
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
        values: &'a FanValues<'_, T, N>,
        corner: FanCorner,
        level: usize,
    ) -> &'a [[T; N]] {
        let points = corner.points as usize;
        &values.kept[corner.kept as usize + (level - self.start - 1) * points..][..points]
    }

    /// The centre of a face that is no quad, at the last level.
    pub fn centre<T: Real, const N: usize>(&self, values: &FanValues<'_, T, N>, f: u32) -> Option<[T; N]> {
        let place = |fan: u32| values.tables.map_or(fan, |tables| tables.places[fan as usize][0]);
        self.of_centre(f).map(|fan| values.last[place(fan) as usize])
    }

    /// Puts control vertices where they belong.
    pub fn write<T: Real, const N: usize>(&self, values: &FanValues<'_, T, N>, out: &mut [[T; N]]) {
        let Some(tables) = values.tables else {
            let own = self.owners[..self.centres].iter().zip(&values.last);
            return own.for_each(|(&v, &value)| out[v as usize] = value);
        };
        for (&fan, &value) in tables.order.iter().zip(&values.last).filter(|(fan, _)| (**fan as usize) < self.centres) {
            out[self.owners[fan as usize] as usize] = value;
        }
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
