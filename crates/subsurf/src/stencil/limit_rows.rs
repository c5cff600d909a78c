//! The rows of a limit stencil table: weights over a patch's ring from its plan, in ascending order of control points.

use super::csr::{self, Csr};
use super::limit::{LimitStencilOptions, LimitStencilTable, Orders, State};
use super::{StencilError, StencilTable};
use crate::limit::{AtVertex, Derivatives, Location, PatchTable, RingWeights};
use crate::real::Real;
use rayon::prelude::*;
use std::collections::HashMap;
use std::rc::Rc;

/// Places a thread takes at a time. Larger: uneven loads; smaller: fewer places that share their weights.
const CHUNK: usize = 4096;

/// The table of `count` places; where there is none, the row of `refined` gives a position.
pub(super) fn build<W: Real>(
    patches: &PatchTable,
    count: usize,
    place: impl Fn(usize) -> Option<Location> + Sync,
    refined: Option<&StencilTable<f64>>,
    options: &LimitStencilOptions,
) -> Result<LimitStencilTable<W>, StencilError> {
    let ring = |at: Location| patches.ring(patches.checked_patch(at)).len();
    let row = |i: usize| refined.map_or(0, |refined| refined.row(i).0.len());
    let most = (0..count).into_par_iter().map(|i| place(i).map_or_else(|| row(i), ring)).sum();
    csr::check_count(most, options.most_weights)?;
    let parts = match options.orders {
        Orders::Position => 1,
        Orders::First => 3,
        Orders::Second => 6,
    };
    let chunks: Vec<Rows<W>> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut maker = Maker::new(patches, parts);
            for i in chunk * CHUNK..((chunk + 1) * CHUNK).min(count) {
                match place(i) {
                    Some(at) => maker.add(at),
                    None => {
                        let (points, weights) = refined.expect("rows for what has no place").row(i);
                        for (&point, &w) in points.iter().zip(weights) {
                            maker.push(point, |part| if part == 0 { w } else { 0.0 });
                        }
                        maker.finish(State::Refined);
                    }
                }
            }
            maker.rows
        })
        .collect();
    let offsets = csr::offsets(chunks.iter().flat_map(|c| c.lengths.iter().copied()), count, options.most_weights)?;
    let total = offsets[count] as usize;
    let mut indices = Vec::with_capacity(total);
    let mut weights: [Vec<W>; 6] = Default::default();
    weights[..parts].iter_mut().for_each(|w| w.reserve_exact(total));
    let mut states = Vec::with_capacity(count);
    for chunk in chunks {
        indices.extend_from_slice(&chunk.indices);
        weights.iter_mut().zip(&chunk.weights).for_each(|(all, w)| all.extend_from_slice(w));
        states.extend_from_slice(&chunk.states);
    }
    let control_points = patches.topology().vertex_count();
    Ok(LimitStencilTable { rows: Csr { offsets, indices, control_points }, weights, states })
}

/// The rows of some consecutive places.
struct Rows<W> {
    lengths: Vec<usize>,
    indices: Vec<u32>,
    weights: [Vec<W>; 6],
    states: Vec<State>,
}

/// Which weights over a ring a place has: plan, turn, and the bits of u and v.
type WeightsKey = (usize, u8, u64, u64);

struct Maker<'a, W> {
    patches: &'a PatchTable,
    parts: usize,
    known: HashMap<WeightsKey, Rc<RingWeights>>,
    /// The patch that was met last.
    patch: Option<usize>,
    /// Control points of its ring in ascending order, with their positions in the ring.
    ascending: Vec<(u32, usize)>,
    rows: Rows<W>,
    /// Number of entries of all finished rows.
    finished: usize,
}

impl<'a, W: Real> Maker<'a, W> {
    fn new(patches: &'a PatchTable, parts: usize) -> Self {
        let rows = Rows { lengths: Vec::new(), indices: Vec::new(), weights: Default::default(), states: Vec::new() };
        Self { patches, parts, known: HashMap::new(), patch: None, ascending: Vec::new(), rows, finished: 0 }
    }

    /// Adds the row of a place.
    fn add(&mut self, at: Location) {
        let patch = self.patches.checked_patch(at);
        let Some(plan) = self.patches.patch_plan(patch) else { return self.finish(State::Hole) };
        if self.patch != Some(patch) {
            self.patch = Some(patch);
            self.ascending.clear();
            self.ascending.extend(self.patches.ring(patch).iter().enumerate().map(|(slot, &point)| (point, slot)));
            self.ascending.sort_unstable();
        }
        let turn = self.patches.turn(patch);
        let key = (plan, turn, at.u.to_bits(), at.v.to_bits());
        let compute = || Rc::new(self.patches.plan(plan).weights(at.u, at.v, turn, self.parts));
        let weights = self.known.entry(key).or_insert_with(compute).clone();
        // Position, du, dv, and so on; some are empty at special vertices.
        let mut rows: [&[f64]; 6] = weights.rows.each_ref().map(Vec::as_slice);
        let mut state = State::Smooth;
        if let Some(AtVertex { derivatives, plane, .. }) = &weights.at_vertex {
            state = State::SpecialVertex(*derivatives);
            if let Some(plane) = plane.as_ref().filter(|_| *derivatives != Derivatives::Finite) {
                (rows[1], rows[2]) = (&plane[0], &plane[1]);
            }
            rows[3..].fill(&[]);
        }
        let ascending = std::mem::take(&mut self.ascending);
        for &(point, slot) in &ascending {
            self.push(point, |part| rows[part].get(slot).copied().unwrap_or(0.0));
        }
        self.ascending = ascending;
        self.finish(state);
    }

    /// Adds an entry to the row, unless all its weights are zero.
    fn push(&mut self, point: u32, weight: impl Fn(usize) -> f64) {
        if (0..self.parts).any(|part| weight(part) != 0.0) {
            self.rows.indices.push(point);
            (0..self.parts).for_each(|part| self.rows.weights[part].push(W::from_f64(weight(part))));
        }
    }

    fn finish(&mut self, state: State) {
        self.rows.lengths.push(self.rows.indices.len() - self.finished);
        self.finished = self.rows.indices.len();
        self.rows.states.push(state);
    }
}
