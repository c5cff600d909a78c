//! What frames ask of fans again and again, kept from the second set of values on: fans with the same rules side by side, so that
//! sixteen are refined at once, the numbers of their control points, and where faces find their values.

use super::super::squares::in_quad;
use super::{FanCorner, Fans};
use crate::kernel::LANES;
use crate::topology::Topology;
use std::collections::BTreeMap;
use std::ops::Range;

/// Fans with fewer of the same rules are refined one by one. Larger: rare kinds wait for single numbers; smaller: lanes idle.
const FEW: usize = 4;
/// As are those with more faces. Larger: the points of a batch leave the nearest cache; smaller: the same at poles.
const WIDE: usize = 16;

/// Some fans that follow each other in [`FanTables::order`].
pub(super) struct Kind {
    pub fans: Range<usize>,
    /// Where they have the same rules, the first of [`FanTables::numbers`].
    pub numbers: Option<usize>,
}

/// Nothing of it depends on values.
pub(in super::super) struct FanTables {
    pub(super) kinds: Vec<Kind>,
    pub(super) order: Vec<u32>,
    /// By fan: its place in this order, and where its values start among all that are kept.
    pub(super) places: Vec<[u32; 2]>,
    /// By sixteen fans of a kind, then by point, then by fan: numbers at the level where they start.
    pub(super) numbers: Vec<[u32; LANES]>,
    /// Half-edges that have fans at their origins, in ascending order, and these.
    half_edges: Vec<u32>,
    corners: Vec<FanCorner>,
}

impl FanTables {
    /// `has_fan` tells half-edges whose faces look for the fan at their origin.
    pub fn new(t: &Topology, fans: &Fans, has_fan: impl Fn(u32) -> bool) -> Self {
        let mut alike: BTreeMap<Vec<u64>, Vec<u32>> = BTreeMap::new();
        let mut others = Vec::new();
        for fan in 0..fans.owners.len() as u32 {
            let [_, faces] = fans.range(fan as usize);
            match faces.len() {
                0..=WIDE => alike.entry(fans.rules(fan as usize)).or_default().push(fan),
                _ => others.push(fan),
            }
        }
        let mut out = Self {
            kinds: Vec::new(),
            order: Vec::with_capacity(fans.owners.len()),
            places: vec![[0; 2]; fans.owners.len()],
            numbers: Vec::new(),
            half_edges: Vec::new(),
            corners: Vec::new(),
        };
        for list in alike.into_values() {
            if list.len() < FEW {
                others.extend(list);
                continue;
            }
            let start = out.order.len();
            let numbers = Some(out.numbers.len());
            list.chunks(LANES).for_each(|batch| out.add_numbers(t, fans, batch));
            out.order.extend(list);
            out.kinds.push(Kind { fans: start..out.order.len(), numbers });
        }
        let start = out.order.len();
        out.order.extend(others);
        out.kinds.push(Kind { fans: start..out.order.len(), numbers: None });
        let mut kept = 0;
        for (place, &fan) in (0..).zip(&out.order) {
            out.places[fan as usize] = [place, kept];
            kept += fans.kept_of(fan as usize) as u32;
        }
        for h in (0..t.half_edge_count() as u32).filter(|&h| has_fan(h)) {
            if let Some(fan) = fans.of_vertex(t.origin[h as usize]) {
                out.half_edges.push(h);
                out.corners.push(fans.corner(Some(&out), fan, h));
            }
        }
        out.numbers.shrink_to_fit();
        out.half_edges.shrink_to_fit();
        out.corners.shrink_to_fit();
        out
    }

    /// The points of up to sixteen fans of a kind; the last one's fill the lanes that are left.
    fn add_numbers(&mut self, t: &Topology, fans: &Fans, batch: &[u32]) {
        let of = |fan: u32| fans.numbers(t, fan as usize);
        let all: Vec<Vec<u32>> = batch.iter().map(|&fan| of(fan)).collect();
        let lane = |lane: usize| &all[lane.min(all.len() - 1)];
        self.numbers.extend((0..all[0].len()).map(|k| std::array::from_fn(|l| lane(l)[k])));
    }

    /// Where the first of these half-edges from number `h` on is listed.
    pub fn first_from(&self, h: u32) -> usize {
        self.half_edges.partition_point(|&listed| listed < h)
    }

    /// The corner of a half-edge that is listed at `at` or behind; `at` moves there.
    #[inline(always)]
    pub fn corner(&self, h: u32, at: &mut usize) -> FanCorner {
        while self.half_edges[*at] < h {
            *at += 1;
        }
        self.corners[*at]
    }

    /// Heap memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.kinds[..])
            + 4 * (self.order.len() + self.half_edges.len())
            + size_of_val(&self.places[..])
            + size_of_val(&self.numbers[..])
            + size_of_val(&self.corners[..])
    }
}

impl Fans {
    /// All that the values of a fan depend on beside points: the same for two whose values are the same sums.
    fn rules(&self, fan: usize) -> Vec<u64> {
        let [edges, faces] = self.range(fan);
        let mut out = vec![self.starts_at(fan) as u64, edges.len() as u64];
        out.extend(self.edges[edges].iter().map(|edge| u64::from(edge[1])));
        out.extend(self.faces[faces].iter().map(|face| u64::from(face.sides[0]) << 32 | u64::from(face.sides[1])));
        if let Some(row) = self.row(fan) {
            for rows in &self.rows {
                out.push(rows.terms(row).len() as u64);
                out.extend(rows.terms(row).iter().flat_map(|&(id, weight)| [u64::from(id), weight.to_bits()]));
            }
        }
        out
    }

    /// The fan's vertex, the ends of its edges and what lies across its faces, at the level where it starts.
    fn numbers(&self, t: &Topology, fan: usize) -> Vec<u32> {
        let [edges, faces] = self.range(fan);
        let (edges, faces) = (&self.edges[edges], &self.faces[faces]);
        let first_centre = t.vertex_count() as u32;
        let first_edge = first_centre + t.face_count() as u32;
        let is_centre = fan >= self.centres;
        let mut out = vec![self.owners[fan] + if is_centre { first_centre } else { 0 }];
        if self.starts_at(fan) == 0 {
            let own = out[0];
            out.resize(1 + edges.len(), own);
            for face in faces {
                let origin = |by: u32| t.origin[in_quad(t, face.h, by) as usize];
                [out[1 + face.sides[0] as usize], out[1 + face.sides[1] as usize]] = [origin(1), origin(3)];
                out.push(origin(2));
            }
        } else {
            out.extend(edges.iter().map(|edge| first_edge + edge[0]));
            let across = |h: u32| if is_centre { t.origin[h as usize] } else { first_centre + t.face.get(h) };
            out.extend(faces.iter().map(|face| across(face.h)));
        }
        out
    }
}
