//! Nearest and any hit of a ray.
//!
//! Triangles are tested as in Woop, Benthin and Wald, "Watertight ray/triangle intersection", 2013: the triangle is
//! sheared so that the ray becomes the z-axis. The edge functions of two triangles that share an edge are then exact
//! negatives of each other, so no ray slips between them; a zero counts as inside for both.

use super::build::SAH_DEPTH;
use super::{Bvh, Child, Hit, LANES, Lanes, Leaf, Node, Ray};
use glam::Vec3;

/// Levels of four: the heuristic's, then halving by count of up to 2³⁰ triangles. Each leaves three children waiting.
const STACK: usize = 3 * (SAH_DEPTH + 16) + 1;

/// Room for the nodes that a ray still has to visit. Keep one per thread and reuse it.
#[derive(Clone, Debug)]
pub struct Stack([(Child, f32); STACK]);

impl Stack {
    /// An empty stack.
    pub fn new() -> Self {
        Self([(Child(0), 0.0); STACK])
    }
}

impl Default for Stack {
    fn default() -> Self {
        Self::new()
    }
}

/// What a ray needs, computed once.
struct Prepared {
    origin: [f32; 3],
    inverse: [f32; 3],
    /// Per axis, which side of a box the ray meets first: 0 lower, 1 upper.
    near: [usize; 3],
    /// Axes with `axes[2]` the largest of the direction, and the shear that makes the ray the z-axis.
    axes: [usize; 3],
    shear: [f32; 3],
}

impl Prepared {
    fn new(ray: &Ray) -> Self {
        // A zero becomes tiny, so that no 0 · ∞ arises.
        let direction = ray.direction.to_array();
        let safe = direction.map(|d| if d.abs() < 1e-18 { 1e-18f32.copysign(d) } else { d });
        let z = Vec3::from(direction).abs().max_position();
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        Self {
            origin: ray.origin.to_array(),
            inverse: safe.map(|d| 1.0 / d),
            near: safe.map(|d| usize::from(d < 0.0)),
            axes: [x, y, z],
            shear: [direction[x] / direction[z], direction[y] / direction[z], 1.0 / direction[z]],
        }
    }

    /// Where the ray enters each of the four boxes; infinite if it does not before `reach`.
    #[inline(always)]
    fn enter(&self, node: &Node, reach: f32) -> [f32; LANES] {
        let mut enter = [0.0f32; LANES];
        let mut leave = [reach; LANES];
        for axis in 0..3 {
            let near = &node.bounds[axis][self.near[axis]].0;
            let far = &node.bounds[axis][1 - self.near[axis]].0;
            for lane in 0..LANES {
                let t = (near[lane] - self.origin[axis]) * self.inverse[axis];
                enter[lane] = if t > enter[lane] { t } else { enter[lane] };
                let t = (far[lane] - self.origin[axis]) * self.inverse[axis];
                leave[lane] = if t < leave[lane] { t } else { leave[lane] };
            }
        }
        // Ize, "Robust BVH ray traversal", 2013: two ulps make the box test conservative.
        for lane in 0..LANES {
            enter[lane] =
                if enter[lane] <= leave[lane] * (1.0 + 2.0 * f32::EPSILON) { enter[lane] } else { f32::INFINITY };
        }
        enter
    }

    /// One corner of each of the four triangles, where the ray is the z-axis; z still to be scaled.
    #[inline(always)]
    fn sheared(&self, corner: &[Lanes; 3]) -> ([f32; LANES], [f32; LANES], [f32; LANES]) {
        let [ax, ay, az] = self.axes;
        let (mut x, mut y, mut z) = ([0.0f32; LANES], [0.0f32; LANES], [0.0f32; LANES]);
        for lane in 0..LANES {
            z[lane] = corner[az].0[lane] - self.origin[az];
            x[lane] = (corner[ax].0[lane] - self.origin[ax]) - self.shear[0] * z[lane];
            y[lane] = (corner[ay].0[lane] - self.origin[ay]) - self.shear[1] * z[lane];
        }
        (x, y, z)
    }

    /// Distance to each of the four triangles (infinite if missed or beyond `reach`), and two barycentric weights.
    #[inline(always)]
    fn meet(&self, leaf: &Leaf, reach: f32) -> ([f32; LANES], [f32; LANES], [f32; LANES]) {
        let sz = self.shear[2];
        let (a, b, c) =
            (self.sheared(&leaf.corners[0]), self.sheared(&leaf.corners[1]), self.sheared(&leaf.corners[2]));
        let (mut distance, mut wa, mut wb) = ([0.0f32; LANES], [0.0f32; LANES], [0.0f32; LANES]);
        for lane in 0..LANES {
            let u = c.0[lane] * b.1[lane] - c.1[lane] * b.0[lane];
            let v = a.0[lane] * c.1[lane] - a.1[lane] * c.0[lane];
            let w = b.0[lane] * a.1[lane] - b.1[lane] * a.0[lane];
            let det = u + v + w;
            let inverse = 1.0 / det;
            let t = (u * a.2[lane] + v * b.2[lane] + w * c.2[lane]) * sz * inverse;
            let inside = ((u >= 0.0) & (v >= 0.0) & (w >= 0.0)) | ((u <= 0.0) & (v <= 0.0) & (w <= 0.0));
            let hit = inside & (det != 0.0) & (t > 0.0) & (t <= reach);
            distance[lane] = if hit { t } else { f32::INFINITY };
            wa[lane] = u * inverse;
            wb[lane] = v * inverse;
        }
        (distance, wa, wb)
    }
}

impl Bvh {
    /// The nearest triangle that the ray meets, from either side; of two at the same distance, either one, but always the same one.
    pub fn nearest(&self, ray: &Ray, stack: &mut Stack) -> Option<Hit> {
        if self.nodes.is_empty() {
            return None;
        }
        let prepared = Prepared::new(ray);
        let stack = &mut stack.0;
        let mut best = None;
        let mut reach = ray.reach;
        let mut top = 1;
        stack[0] = (Child::node(0), 0.0);
        while top > 0 {
            top -= 1;
            let (child, entered) = stack[top];
            if entered > reach {
                continue;
            }
            if let Some(leaf) = child.as_leaf() {
                let leaf = &self.leaves[leaf];
                let (distance, wa, wb) = prepared.meet(leaf, reach);
                for lane in 0..LANES {
                    if distance[lane] <= reach && distance[lane] < f32::INFINITY {
                        reach = distance[lane];
                        let barycentric = [wa[lane], wb[lane], 1.0 - wa[lane] - wb[lane]];
                        best = Some(Hit { triangle: leaf.triangles[lane], barycentric, distance: reach });
                    }
                }
                continue;
            }
            let node = &self.nodes[child.0 as usize];
            let enter = prepared.enter(node, reach);
            // Farthest first onto the stack, by insertion.
            let bottom = top;
            for lane in 0..LANES {
                if enter[lane] < f32::INFINITY {
                    let mut slot = top;
                    while slot > bottom && stack[slot - 1].1 < enter[lane] {
                        stack[slot] = stack[slot - 1];
                        slot -= 1;
                    }
                    stack[slot] = (node.children[lane], enter[lane]);
                    top += 1;
                }
            }
        }
        best
    }

    /// Whether the ray meets any triangle within its reach.
    pub fn blocked(&self, ray: &Ray, stack: &mut Stack) -> bool {
        if self.nodes.is_empty() {
            return false;
        }
        let prepared = Prepared::new(ray);
        let stack = &mut stack.0;
        let mut top = 1;
        stack[0] = (Child::node(0), 0.0);
        while top > 0 {
            top -= 1;
            let child = stack[top].0;
            if let Some(leaf) = child.as_leaf() {
                if prepared.meet(&self.leaves[leaf], ray.reach).0.iter().any(|&t| t < f32::INFINITY) {
                    return true;
                }
                continue;
            }
            let node = &self.nodes[child.0 as usize];
            let enter = prepared.enter(node, ray.reach);
            for lane in 0..LANES {
                if enter[lane] < f32::INFINITY {
                    stack[top] = (node.children[lane], 0.0);
                    top += 1;
                }
            }
        }
        false
    }
}
