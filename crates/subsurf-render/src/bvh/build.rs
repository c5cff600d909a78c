//! Top-down building by the binned surface area heuristic, in parallel.
//!
//! A node starts as one range of triangles and is split, largest box first, until it has four ranges. Minima, maxima
//! and counts do not depend on the order of the operands, so chunks may be binned by any thread.

use super::{Bvh, Child, LANES, Lanes, Leaf, Node};
use glam::Vec3;
use rayon::prelude::*;

const BINS: usize = 16;
/// Ranges of at least this many triangles are binned by several threads and their children built in parallel.
const PARALLEL: usize = 8192;
/// Below this depth ranges are halved by count: bounds the depth, and so the traversal's stack, on hostile input.
/// 2³⁰ triangles take 15 more levels of four.
pub(super) const SAH_DEPTH: usize = 24;

#[derive(Clone, Copy)]
struct Bounds {
    lower: Vec3,
    upper: Vec3,
}

impl Bounds {
    const EMPTY: Self = Self { lower: Vec3::INFINITY, upper: Vec3::NEG_INFINITY };

    fn join(self, other: Self) -> Self {
        Self { lower: self.lower.min(other.lower), upper: self.upper.max(other.upper) }
    }

    fn with(self, point: Vec3) -> Self {
        Self { lower: self.lower.min(point), upper: self.upper.max(point) }
    }

    /// Half of the surface area; 0 when empty.
    fn half_area(self) -> f32 {
        let d = (self.upper - self.lower).max(Vec3::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

#[derive(Clone, Copy)]
struct Item {
    bounds: Bounds,
    triangle: u32,
}

impl Item {
    /// Twice the centre of the box.
    fn center2(&self) -> Vec3 {
        self.bounds.lower + self.bounds.upper
    }
}

/// Boxes around the triangles and around their (doubled) centres.
#[derive(Clone, Copy)]
struct Extent {
    bounds: Bounds,
    centers2: Bounds,
}

impl Extent {
    const EMPTY: Self = Self { bounds: Bounds::EMPTY, centers2: Bounds::EMPTY };

    fn join(self, other: Self) -> Self {
        Self { bounds: self.bounds.join(other.bounds), centers2: self.centers2.join(other.centers2) }
    }

    fn of(items: &[Item]) -> Self {
        let serial = |items: &[Item]| {
            items.iter().fold(Self::EMPTY, |sum, item| Self {
                bounds: sum.bounds.join(item.bounds),
                centers2: sum.centers2.with(item.center2()),
            })
        };
        if items.len() < PARALLEL {
            return serial(items);
        }
        items.par_chunks(PARALLEL / 2).map(serial).reduce(|| Self::EMPTY, Self::join)
    }
}

/// A tree under construction. Indices count from the start of this part.
#[derive(Default)]
struct Part {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
}

impl Part {
    /// Appends `other`; gives the new address of its child `root`.
    fn append(&mut self, other: Self, root: Child) -> Child {
        let (nodes, leaves) = (self.nodes.len(), self.leaves.len());
        let moved = |child: Child| match child.as_leaf() {
            Some(leaf) => Child::leaf(leaf + leaves),
            None => Child::node(child.0 as usize + nodes),
        };
        self.leaves.extend(other.leaves);
        self.nodes.extend(other.nodes.into_iter().map(|node| Node { children: node.children.map(moved), ..node }));
        moved(root)
    }
}

struct Builder<'a> {
    positions: &'a [[f32; 3]],
    triangles: &'a [[u32; 3]],
}

pub(super) fn build(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Bvh {
    assert!(triangles.len() <= 1 << 30, "at most 2^30 triangles");
    let mut items: Vec<Item> = triangles
        .par_iter()
        .enumerate()
        .map(|(i, corners)| {
            let bounds =
                corners.iter().fold(Bounds::EMPTY, |sum, &corner| sum.with(Vec3::from(positions[corner as usize])));
            Item { bounds, triangle: i as u32 }
        })
        .collect();
    let builder = Builder { positions, triangles };
    let extent = Extent::of(&items);
    let mut part = Part::default();
    if !items.is_empty() {
        builder.node(&mut items, extent, 0, &mut part);
    }
    Bvh { nodes: part.nodes, leaves: part.leaves }
}

impl Builder<'_> {
    /// Builds the node over `items`, always an inner node, and all below it.
    fn node(&self, items: &mut [Item], extent: Extent, depth: usize, part: &mut Part) -> Child {
        // Split the range with the largest box until there are four.
        let parallel = items.len() >= PARALLEL;
        let mut ranges: Vec<(&mut [Item], Extent)> = vec![(items, extent)];
        while ranges.len() < LANES {
            let largest = (0..ranges.len())
                .filter(|&i| ranges[i].0.len() > LANES)
                .max_by(|&i, &j| ranges[i].1.bounds.half_area().total_cmp(&ranges[j].1.bounds.half_area()));
            let Some(largest) = largest else { break };
            let (range, extent) = ranges.remove(largest);
            let middle = split(range, extent, depth);
            let (left, right) = range.split_at_mut(middle);
            let (left_extent, right_extent) = (Extent::of(left), Extent::of(right));
            ranges.push((left, left_extent));
            ranges.push((right, right_extent));
        }

        // The node goes before its children, so that the root is node 0.
        let index = part.nodes.len();
        part.nodes.push(empty_node());
        let mut bounds = [Bounds::EMPTY; LANES];
        for (lane, (_, extent)) in ranges.iter().enumerate() {
            bounds[lane] = extent.bounds;
        }
        let mut children = [Child::leaf(0); LANES];
        if parallel {
            let parts: Vec<(Part, Child)> = ranges
                .into_par_iter()
                .map(|(items, extent)| {
                    let mut part = Part::default();
                    let child = self.child(items, extent, depth + 1, &mut part);
                    (part, child)
                })
                .collect();
            for (lane, (child_part, child)) in parts.into_iter().enumerate() {
                children[lane] = part.append(child_part, child);
            }
        } else {
            for (lane, (items, extent)) in ranges.into_iter().enumerate() {
                children[lane] = self.child(items, extent, depth + 1, part);
            }
        }
        let node = &mut part.nodes[index];
        node.children = children;
        for axis in 0..3 {
            node.bounds[axis] = [Lanes(bounds.map(|b| b.lower[axis])), Lanes(bounds.map(|b| b.upper[axis]))];
        }
        Child::node(index)
    }

    fn child(&self, items: &mut [Item], extent: Extent, depth: usize, part: &mut Part) -> Child {
        if items.len() > LANES {
            return self.node(items, extent, depth, part);
        }
        let mut leaf = Leaf { corners: [[Lanes([0.0; LANES]); 3]; 3], triangles: [0; LANES] };
        for (lane, item) in items.iter().enumerate() {
            leaf.triangles[lane] = item.triangle;
            for (k, &corner) in self.triangles[item.triangle as usize].iter().enumerate() {
                for axis in 0..3 {
                    leaf.corners[k][axis].0[lane] = self.positions[corner as usize][axis];
                }
            }
        }
        part.leaves.push(leaf);
        Child::leaf(part.leaves.len() - 1)
    }
}

fn empty_node() -> Node {
    let lanes = |x| Lanes([x; LANES]);
    Node { bounds: [[lanes(f32::INFINITY), lanes(f32::NEG_INFINITY)]; 3], children: [Child::leaf(0); LANES] }
}

/// Sorts `items` into two ranges, neither empty, and gives where the second starts.
fn split(items: &mut [Item], extent: Extent, depth: usize) -> usize {
    let size = extent.centers2.upper - extent.centers2.lower;
    let plane = if depth < SAH_DEPTH { best_plane(items, extent.centers2.lower, size) } else { None };
    if let Some((axis, bin)) = plane {
        let middle = partition(items, |item| bin_of(item, extent.centers2.lower, size)[axis] <= bin);
        if middle > 0 && middle < items.len() {
            return middle;
        }
    }
    // Equal centres, or too deep: halves by count along the longest axis.
    let axis = size.max_position();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| {
        a.center2()[axis].total_cmp(&b.center2()[axis]).then(a.triangle.cmp(&b.triangle))
    });
    middle
}

fn bin_of(item: &Item, lower: Vec3, size: Vec3) -> [usize; 3] {
    let scale = Vec3::splat(BINS as f32 * (1.0 - 1e-6)) / size.max(Vec3::splat(f32::MIN_POSITIVE));
    let bin = (item.center2() - lower) * scale;
    [bin.x, bin.y, bin.z].map(|b| (b as usize).min(BINS - 1))
}

type Histogram = [[(Bounds, u32); BINS]; 3];

/// The axis and the last bin of the left side with the least expected cost, or `None` if all centres are equal.
///
/// Cost = half area × number of leaves, on both sides: a leaf tests all its lanes whether or not they are filled.
fn best_plane(items: &[Item], lower: Vec3, size: Vec3) -> Option<(usize, usize)> {
    let serial = |items: &[Item]| {
        let mut bins: Histogram = [[(Bounds::EMPTY, 0); BINS]; 3];
        for item in items {
            for (axis, &bin) in bin_of(item, lower, size).iter().enumerate() {
                let slot = &mut bins[axis][bin];
                *slot = (slot.0.join(item.bounds), slot.1 + 1);
            }
        }
        bins
    };
    let join = |mut a: Histogram, b: Histogram| {
        for (a, b) in a.iter_mut().flatten().zip(b.iter().flatten()) {
            *a = (a.0.join(b.0), a.1 + b.1);
        }
        a
    };
    let bins = if items.len() < PARALLEL {
        serial(items)
    } else {
        items.par_chunks(PARALLEL / 2).map(serial).reduce(|| [[(Bounds::EMPTY, 0); BINS]; 3], join)
    };

    let mut best = None;
    let mut least = f32::INFINITY;
    for axis in 0..3 {
        if size[axis] <= 0.0 {
            continue;
        }
        // Right to left: cost of everything right of each plane.
        let mut right_cost = [0.0; BINS];
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for bin in (1..BINS).rev() {
            bounds = bounds.join(bins[axis][bin].0);
            count += bins[axis][bin].1;
            right_cost[bin - 1] = cost(bounds, count);
        }
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for bin in 0..BINS - 1 {
            bounds = bounds.join(bins[axis][bin].0);
            count += bins[axis][bin].1;
            let total = cost(bounds, count) + right_cost[bin];
            if count > 0 && (count as usize) < items.len() && total < least {
                (least, best) = (total, Some((axis, bin)));
            }
        }
    }
    best
}

fn cost(bounds: Bounds, count: u32) -> f32 {
    bounds.half_area() * count.div_ceil(LANES as u32) as f32
}

/// Moves the items that satisfy `left` to the front and gives their number.
fn partition(items: &mut [Item], left: impl Fn(&Item) -> bool) -> usize {
    let (mut start, mut end) = (0, items.len());
    while start < end {
        if left(&items[start]) {
            start += 1;
        } else {
            end -= 1;
            items.swap(start, end);
        }
    }
    start
}
