//! Fans with the same rules, sixteen at a time, one in each lane: the operations of a single fan in the same order, so that the bits
//! do not depend on which way a fan goes.

use super::super::rules::{Creases, rounded};
use super::Fans;
use crate::kernel::{self, LANES, Lined, PART, Parts, Sixteen, by_component};
use crate::real::Real;
use crate::scheme::catmull_clark::smooth_neighbour;
use fearless_simd::{Simd, dispatch};

/// Memory that is used again and again: the points of sixteen fans, in the order of their numbers, and sums by edge.
#[derive(Default)]
pub(super) struct Lanes<T> {
    points: Lined<T>,
    sums: Lined<T>,
}

impl Fans {
    /// Some fans with the rules of `fan`, whose points these are at the level where they start; their vertices at the last level go to
    /// `last`.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn refine_alike<T: Real, const N: usize>(
        &self,
        creases: &Creases,
        levels: [&[[T; N]]; 2],
        fan: usize,
        numbers: &[[u32; LANES]],
        lanes: &mut Lanes<T>,
        kept: &mut [[T; N]],
        last: &mut [[T; N]],
    ) {
        let points = 1 + self.range(fan).map(|range| range.len()).iter().sum::<usize>();
        let each = self.kept_of(fan);
        dispatch!(kernel::level(), simd => simd.vectorize(
            #[inline(always)]
            || {
                for (batch, last) in last.chunks_mut(LANES).enumerate() {
                    let kept = &mut kept[LANES * batch * each..][..last.len() * each];
                    let numbers = &numbers[batch * points..][..points];
                    self.refine_sixteen(simd, creases, levels[self.starts_at(fan)], fan, numbers, lanes, kept, last);
                }
            }
        ));
    }

    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn refine_sixteen<T: Real, S: Simd, const N: usize>(
        &self,
        simd: S,
        creases: &Creases,
        level: &[[T; N]],
        fan: usize,
        numbers: &[[u32; LANES]],
        Lanes { points, sums }: &mut Lanes<T>,
        kept: &mut [[T; N]],
        last: &mut [[T; N]],
    ) {
        let zero = [[T::default(); LANES]; N];
        let [edges, faces] = self.range(fan);
        let (edges, faces) = (&self.edges[edges], &self.faces[faces]);
        points.reserve(N * LANES * numbers.len());
        sums.reserve(N * LANES * edges.len());
        let points = &mut points.sixteens::<N>()[..numbers.len()];
        let sums = &mut sums.sixteens::<N>()[..edges.len()];
        gather(simd, level, numbers, points);
        let start = self.starts_at(fan);
        let smooth = rounded::<T>(creases.rule(start, 0)).edge;
        let (own, rest) = points.split_at_mut(1);
        let (ends, across) = rest.split_at_mut(edges.len());
        let own = &mut own[0];
        let stride = if last.is_empty() { 0 } else { kept.len() / last.len() };
        let mut at_kept = 0;
        if start > self.start {
            keep(own, ends, &mut at_kept, stride, kept);
        }
        let quarter = T::splat(simd, T::from_f64(0.25));
        let each = T::splat(simd, T::from_f64(smooth_neighbour(edges.len().max(1), 1.0)));
        for at in start..self.depth {
            // Face points, and their sums by edge and round the vertex, relative to it.
            sums.fill(zero);
            let mut all = zero;
            for (face, across) in faces.iter().zip(&mut *across) {
                let [a, b] = [face.sides[0] as usize, face.sides[1] as usize];
                for c in 0..N {
                    let center = T::load(simd, &own[c]);
                    let diagonal = T::plus(simd, center, T::load(simd, &across[c]));
                    let sides = T::plus(simd, T::load(simd, &ends[a][c]), T::load(simd, &ends[b][c]));
                    let point = T::times(simd, quarter, T::plus(simd, diagonal, sides));
                    T::store(simd, point, &mut across[c]);
                    let apart = T::minus(simd, point, center);
                    add(simd, apart, &mut sums[a][c]);
                    add(simd, apart, &mut sums[b][c]);
                    add(simd, apart, &mut all[c]);
                }
            }
            let mut next = zero;
            for c in 0..N {
                let center = T::load(simd, &own[c]);
                let sum = match self.row(fan) {
                    Some(row) => {
                        let mut sum = T::splat(simd, T::default());
                        for &(id, weight) in &self.rows[at - self.start].terms(row)[1..] {
                            let point = match id as usize {
                                0 => &*own,
                                id if id <= ends.len() => &ends[id - 1],
                                id => &across[id - 1 - ends.len()],
                            };
                            let weight = T::splat(simd, T::from_f64(weight));
                            sum = T::plus(simd, sum, T::times(simd, weight, apart::<T, S>(simd, &point[c], center)));
                        }
                        sum
                    }
                    None => {
                        let mut sum = T::load(simd, &all[c]);
                        for end in &*ends {
                            sum = T::plus(simd, sum, apart::<T, S>(simd, &end[c], center));
                        }
                        T::times(simd, each, sum)
                    }
                };
                T::store(simd, T::plus(simd, center, sum), &mut next[c]);
            }
            if at + 1 == self.depth {
                for (lane, last) in last.iter_mut().enumerate() {
                    for c in 0..N {
                        last[c] = next[c][lane];
                    }
                }
                return;
            }
            for ((end, sum), edge) in ends.iter_mut().zip(&*sums).zip(edges) {
                let [weight, centroid] =
                    if edge[1] == 0 { smooth } else { rounded::<T>(creases.rule(at, edge[1])).edge };
                let (weight, centroid) = (T::splat(simd, weight), T::splat(simd, centroid));
                for c in 0..N {
                    let center = T::load(simd, &own[c]);
                    let far = T::times(simd, weight, apart::<T, S>(simd, &end[c], center));
                    let faces = T::times(simd, centroid, T::load(simd, &sum[c]));
                    T::store(simd, T::plus(simd, center, T::plus(simd, far, faces)), &mut end[c]);
                }
            }
            *own = next;
            keep(own, ends, &mut at_kept, stride, kept);
        }
    }
}

#[inline(always)]
fn add<T: Real, S: Simd>(simd: S, x: T::Block<S>, to: &mut [T; LANES]) {
    T::store(simd, T::plus(simd, T::load(simd, to), x), to);
}

/// Sixteen numbers less others.
#[inline(always)]
fn apart<T: Real, S: Simd>(simd: S, x: &[T; LANES], from: T::Block<S>) -> T::Block<S> {
    T::minus(simd, T::load(simd, x), from)
}

/// The points of sixteen fans by number.
#[inline(always)]
fn gather<T: Real, S: Simd, const N: usize>(
    simd: S,
    level: &[[T; N]],
    numbers: &[[u32; LANES]],
    out: &mut [Sixteen<T, N>],
) {
    let parts = Parts::new(level, 0);
    for (numbers, out) in numbers.iter().zip(out) {
        if N == PART || N + 1 == PART {
            let components = by_component::<T, _>(
                simd,
                #[inline(always)]
                |lane| parts.at(numbers[lane] as usize),
            );
            for c in 0..N {
                T::store(simd, components[c], &mut out[c]);
            }
            continue;
        }
        for (lane, &number) in numbers.iter().enumerate() {
            (0..N).for_each(|c| out[c][lane] = level[number as usize][c]);
        }
    }
}

/// Puts the vertices and the ends of edges of some fans `at` where they belong among the `stride` values of each, and moves on.
#[inline(always)]
fn keep<T: Real, const N: usize>(
    own: &Sixteen<T, N>,
    ends: &[Sixteen<T, N>],
    at: &mut usize,
    stride: usize,
    kept: &mut [[T; N]],
) {
    for (lane, kept) in kept.chunks_exact_mut(stride).enumerate() {
        let kept = &mut kept[*at..][..1 + ends.len()];
        for c in 0..N {
            kept[0][c] = own[c][lane];
        }
        for (kept, end) in kept[1..].iter_mut().zip(ends) {
            for c in 0..N {
                kept[c] = end[c][lane];
            }
        }
    }
    *at += 1 + ends.len();
}
