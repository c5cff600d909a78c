//! The rows of a limit stencil table: weights over a patch's ring from its plan, in ascending order of control points,
//! written straight to their places in the table.

use super::csr::{self, Csr};
use super::limit::{LimitStencilOptions, LimitStencilTable, Orders, State};
use super::{StencilError, StencilTable};
use crate::kernel::vectorized;
use crate::limit::{AtVertex, Derivatives, Location, PatchTable, RingWeights};
use crate::real::Real;
use rayon::prelude::*;
use std::collections::HashMap;

/// Places a thread takes at a time. Larger: uneven loads; smaller: fewer special vertices that share their weights.
const CHUNK: usize = 4096;

/// Where the place of a row is, if it has one.
pub type PlaceOf<'a> = &'a (dyn Fn(usize) -> Option<Location> + Sync);

/// The table of `count` places; where there is none, the row of `refined` gives a position.
pub(crate) fn build<W: Real>(
    patches: &PatchTable,
    count: usize,
    place: PlaceOf<'_>,
    refined: Option<&StencilTable<f64>>,
    options: &LimitStencilOptions,
) -> Result<LimitStencilTable<W>, StencilError> {
    let row = |i: usize| refined.expect("rows for what has no place").row(i);
    let longest = |i: usize| match place(i) {
        Some(at) => patches.ring(patches.checked_patch(at)).len(),
        None => row(i).0.len(),
    };
    let chunks = count.div_ceil(CHUNK);
    let own = |chunk: usize| chunk * CHUNK..((chunk + 1) * CHUNK).min(count);
    let room: Vec<usize> = (0..chunks).into_par_iter().map(|chunk| own(chunk).map(longest).sum()).collect();
    let most = room.iter().sum();
    csr::check_count(most, options.most_weights)?;
    let parts = match options.orders {
        Orders::Position => 1,
        Orders::First => 3,
        Orders::Second => 6,
    };
    // As if no weight were zero; what was too much is taken back.
    let mut indices: Vec<u32> = subsurf_memory::zeroed(most);
    let mut weights: [Vec<W>; 6] = std::array::from_fn(|part| vec![W::default(); if part < parts { most } else { 0 }]);
    weights.iter_mut().for_each(subsurf_memory::advise);
    let mut states = vec![State::Hole; count];
    let mut offsets = vec![0u32; count + 1];

    let mut makers = Vec::with_capacity(chunks);
    let (mut free_indices, mut free_weights) = (&mut indices[..], weights.each_mut().map(Vec::as_mut_slice));
    for ((&room, states), ends) in room.iter().zip(states.chunks_mut(CHUNK)).zip(offsets[1..].chunks_mut(CHUNK)) {
        let indices = free_indices.split_off_mut(..room).expect("room was counted");
        let weights =
            free_weights.each_mut().map(|free| free.split_off_mut(..room.min(free.len())).expect("as indices"));
        makers.push(Maker { patches, parts, rows: Rows { indices, weights, states, ends, filled: 0, row: 0 } });
    }
    let used: Vec<usize> = (makers.into_par_iter().enumerate())
        .map(|(chunk, mut maker)| {
            let mut scratch = Scratch::default();
            for i in own(chunk) {
                match place(i) {
                    Some(at) => maker.add(at, &mut scratch),
                    None => {
                        let (points, weights) = row(i);
                        for (&point, &w) in points.iter().zip(weights) {
                            maker.rows.push(point, parts, |part| if part == 0 { w } else { 0.0 });
                        }
                        maker.rows.finish(State::Refined);
                    }
                }
            }
            maker.rows.filled
        })
        .collect();

    // Ends count from the start of a chunk so far; gaps close where weights were zero.
    let (mut start, mut end) = (0, 0);
    for ((&room, &used), ends) in room.iter().zip(&used).zip(offsets[1..].chunks_mut(CHUNK)) {
        ends.iter_mut().for_each(|e| *e += end as u32);
        if start != end {
            indices.copy_within(start..start + used, end);
            weights[..parts].iter_mut().for_each(|w| w.copy_within(start..start + used, end));
        }
        (start, end) = (start + room, end + used);
    }
    if end < most {
        indices.truncate(end);
        indices.shrink_to_fit();
        for weights in &mut weights[..parts] {
            weights.truncate(end);
            weights.shrink_to_fit();
        }
    }
    let control_points = patches.topology().vertex_count();
    Ok(LimitStencilTable { rows: Csr { offsets, indices, control_points }, weights, states })
}

/// The rows of some consecutive places, in the table's memory.
struct Rows<'a, W> {
    indices: &'a mut [u32],
    weights: [&'a mut [W]; 6],
    states: &'a mut [State],
    ends: &'a mut [u32],
    /// Number of entries so far.
    filled: usize,
    /// Number of finished rows.
    row: usize,
}

impl<W: Real> Rows<'_, W> {
    /// Adds an entry to the row, unless all its weights are zero.
    fn push(&mut self, point: u32, parts: usize, weight: impl Fn(usize) -> f64) {
        if (0..parts).any(|part| weight(part) != 0.0) {
            self.indices[self.filled] = point;
            (0..parts).for_each(|part| self.weights[part][self.filled] = W::from_f64(weight(part)));
            self.filled += 1;
        }
    }

    fn finish(&mut self, state: State) {
        self.ends[self.row] = self.filled as u32;
        self.states[self.row] = state;
        self.row += 1;
    }
}

/// Which weights over a ring a special vertex has: plan, turn, and the bits of u and v.
type WeightsKey = (usize, u8, u64, u64);

/// Memory that is used again.
#[derive(Default)]
struct Scratch {
    /// The patch that was met last, if any, and where the points of its ring come in ascending order.
    patch: Option<usize>,
    place: Vec<u32>,
    /// Weights of a place, row by row.
    weights: Vec<f64>,
    known: HashMap<WeightsKey, RingWeights>,
}

struct Maker<'a, W> {
    patches: &'a PatchTable,
    parts: usize,
    rows: Rows<'a, W>,
}

impl<W: Real> Maker<'_, W> {
    /// Adds the row of a place.
    fn add(&mut self, at: Location, scratch: &mut Scratch) {
        let Self { patches, parts, rows } = self;
        let patch = patches.checked_patch(at);
        let Some(number) = patches.patch_plan(patch) else { return rows.finish(State::Hole) };
        let (plan, turn, ring) = (patches.plan(number), patches.turn(patch), patches.ring(patch));
        let Scratch { patch: last, place, weights, known } = scratch;
        if last.replace(patch) != Some(patch) {
            place.clear();
            place.resize(ring.len(), 0);
            if ring.len() > MOST_COMPARED {
                let mut order: Vec<u32> = (0..ring.len() as u32).collect();
                order.sort_unstable_by_key(|&i| ring[i as usize]);
                order.iter().zip(0..).for_each(|(&i, rank)| place[i as usize] = rank);
            } else {
                vectorized(
                    #[inline(always)]
                    || ranks(ring, place),
                );
            }
        }
        let mut state = State::Smooth;
        if let Some(spot) = plan.spot(at.u, at.v, turn) {
            plan.weights_in_piece(&spot, *parts, weights);
        } else {
            let key = (number, turn, at.u.to_bits(), at.v.to_bits());
            let single = known.entry(key).or_insert_with(|| plan.weights(at.u, at.v, turn, *parts));
            // Position, du, dv, and so on; some are empty at special vertices.
            let mut single_rows: [&[f64]; 6] = single.rows.each_ref().map(Vec::as_slice);
            if let Some(AtVertex { derivatives, plane, .. }) = &single.at_vertex {
                state = State::SpecialVertex(*derivatives);
                if let Some(plane) = plane.as_ref().filter(|_| *derivatives != Derivatives::Finite) {
                    (single_rows[1], single_rows[2]) = (&plane[0], &plane[1]);
                }
                single_rows[3..].fill(&[]);
            }
            weights.clear();
            for (part, row) in single_rows[..*parts].iter().enumerate() {
                weights.extend_from_slice(row);
                weights.resize((part + 1) * ring.len(), 0.0);
            }
        }
        rows.add(ring, place, weights, *parts);
        rows.finish(state);
    }
}

impl<W: Real> Rows<'_, W> {
    /// Adds the entries of a row: weights over a ring, each point at its place.
    fn add(&mut self, ring: &[u32], place: &[u32], weights: &[f64], parts: usize) {
        let (start, n) = (self.filled, ring.len());
        let indices = &mut self.indices[start..start + n];
        for (&point, &place) in ring.iter().zip(place) {
            indices[place as usize] = point;
        }
        for (out, row) in self.weights[..parts].iter_mut().zip(weights.chunks_exact(n)) {
            let out = &mut out[start..start + n];
            for (&w, &place) in row.iter().zip(place) {
                out[place as usize] = W::from_f64(w);
            }
        }
        self.filled += n;
        // A point may count for nothing, next to boundaries and on their far side.
        let is_zero = |p: usize| weights.iter().skip(p).step_by(n).all(|&w| w == 0.0);
        if weights[..n].iter().enumerate().any(|(p, &w)| w == 0.0 && is_zero(p)) {
            let mut used = vec![false; n];
            (0..n).for_each(|p| used[place[p] as usize] = !is_zero(p));
            self.filled = start;
            for from in (0..n).filter(|&p| used[p]) {
                let (from, to) = (start + from, self.filled);
                self.indices[to] = self.indices[from];
                self.weights[..parts].iter_mut().for_each(|w| w[to] = w[from]);
                self.filled += 1;
            }
        }
    }
}

/// Largest ring whose points are all compared with each other, which vectors make fast; larger ones are sorted.
const MOST_COMPARED: usize = 256;

/// How many points of a ring are less than each: where it comes in ascending order.
#[inline(always)]
fn ranks(ring: &[u32], out: &mut [u32]) {
    for &point in ring {
        for i in 0..if ring.len() < out.len() { ring.len() } else { out.len() } {
            out[i] += u32::from(point < ring[i]);
        }
    }
}
