//! Classes of vertices whose fans look alike: by them faces with equal surroundings are found without a walk round each.
//!
//! The *class* of a manifold vertex is its fan as a list: the sides of every face, the sharpness of every spoke and of the vertex,
//! from a start that does not depend on numbering. A corner of a face is known by the class and by how many spokes it lies after
//! the start. Corners with equal classes and places, all round a face, mean equal walks round it, unless the mesh is so small that
//! the walk comes back to vertices that it met: then rings name a vertex twice, which is looked for (see
//! [`read`]).

use super::fans::Fans;
use super::plan_key::KeyHasher;
use crate::index::{Face, HalfEdge, Vertex};
use crate::tags::Creasing;
use crate::topology::{Interpolation, NONE, Topology};
use rayon::prelude::*;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

/// Most faces at a vertex with a class. Larger: memory.
const MOST_FACES: usize = 12;

/// Least faces at an interior vertex with a class: below, faces at a corner are neighbours on both sides.
const LEAST_FACES: usize = 3;

/// Most corners of a face that is known by the classes of its corners.
pub(super) const MOST_SIDES: usize = 6;

/// What is known of the corners of a face: its number of sides, then every corner from one on.
pub(super) type FaceKey = [u32; MOST_SIDES + 1];

/// By face key.
pub(super) type ByFace<T> = HashMap<FaceKey, T, BuildHasherDefault<KeyHasher>>;

/// A fan as a list: faces, closed or not and sharpness of the vertex, then for every face its sides and its first spoke's
/// sharpness.
type Signature = [u32; MOST_FACES + 1];

/// The classes of all vertices.
pub(super) struct FanClasses<'a> {
    /// Valences of smooth vertices.
    pub valence: &'a [u8],
    /// By vertex, a row of `classes`, or [`NONE`]; empty where no vertex has one.
    row: Vec<u32>,
    classes: Vec<Class>,
}

/// The class of a vertex that is not smooth; a smooth one has its valence.
#[derive(Clone, Copy)]
struct Class {
    number: u32,
    /// The half-edge at which the list starts.
    start: u32,
    /// After how many faces the list repeats itself.
    period: u32,
}

impl<'a> FanClasses<'a> {
    /// Those of all vertices.
    pub fn new(t: &Topology, fans: &'a Fans) -> Self {
        let valence = &fans.valence[..];
        let mut all = Self { valence, row: Vec::new(), classes: Vec::new() };
        let is_local = t.interpolation == Interpolation::Smooth && t.rules().creasing == Creasing::Uniform;
        // Most blocks have none.
        let blocks = valence.chunks(64).zip((0u32..).step_by(64)).filter(|(block, _)| block.contains(&0));
        let of_block =
            |(block, first): (&'a [u8], u32)| block.iter().zip(first..).filter(|(valence, _)| **valence == 0);
        let others: Vec<u32> = blocks.flat_map(of_block).map(|(_, v)| v).collect();
        // Else far ends of edges have a say, or boundaries do.
        if !is_local || others.is_empty() {
            return all;
        }
        let fans: Vec<_> = others.par_iter().with_min_len(2048).map(|&v| fan(t, Vertex(v))).collect();
        let mut numbers: HashMap<Signature, u32, BuildHasherDefault<KeyHasher>> = HashMap::default();
        all.row = subsurf_memory::with_capacity(t.vertex_count());
        all.row.resize(t.vertex_count(), NONE);
        for (v, fan) in others.into_iter().zip(fans) {
            let Some((signature, class)) = fan else { continue };
            let next = (MOST_FACES + 1 + numbers.len()) as u32;
            all.row[v as usize] = all.classes.len() as u32;
            all.classes.push(Class { number: *numbers.entry(signature).or_insert(next), ..class });
        }
        all
    }

    /// The corners of a face from corner 0 on, if all have classes.
    pub fn of_face(&self, t: &Topology, face: Face) -> Option<FaceKey> {
        let sides = t.sides(face);
        if sides > MOST_SIDES || self.row.is_empty() {
            return None;
        }
        let mut key = [0; MOST_SIDES + 1];
        key[0] = sides as u32;
        for c in 0..sides {
            key[c + 1] = self.of_corner(t, t.half_edge(face, c))?;
        }
        Some(key)
    }

    fn of_corner(&self, t: &Topology, h: HalfEdge) -> Option<u32> {
        let v = t.origin(h).index();
        if self.valence[v] != 0 {
            return Some(u32::from(self.valence[v]) << 4);
        }
        let class = self.classes.get(self.row[v] as usize)?;
        let (mut at, mut place) = (HalfEdge(class.start), 0);
        while at != h {
            at = t.turn_left(at)?;
            place += 1;
        }
        Some((class.number << 4) | (place % class.period))
    }
}

/// The key from the corner on that makes it least, that corner, and after how many corners the key repeats itself.
pub(super) fn least(key: &FaceKey) -> (FaceKey, usize, usize) {
    let sides = key[0] as usize;
    let (mut best, mut at, mut period) = (*key, 0, sides);
    for by in 1..sides {
        let other = turned(key, by);
        match other.cmp(&best) {
            std::cmp::Ordering::Less => (best, at) = (other, by),
            std::cmp::Ordering::Equal => period = period.min(by - at),
            std::cmp::Ordering::Greater => {}
        }
    }
    (best, at, period)
}

/// The key from another corner on.
#[inline]
pub(super) fn turned(key: &FaceKey, by: usize) -> FaceKey {
    let mut out = *key;
    let sides = key[0] as usize;
    for c in 0..sides {
        out[c + 1] = key[(c + by) % sides + 1];
    }
    out
}

/// Reads the ring of a face as a walk from corner `start` would list it, were the faces and vertices that it meets all different
/// ones: the face's own, then round each corner counter-clockwise and, where the fan is open, clockwise.
pub(super) fn read(t: &Topology, face: Face, start: usize, ring: &mut Vec<u32>) {
    let sides = t.sides(face);
    let corner = |i: usize| t.half_edge(face, (start + i) % sides);
    let last = sides - 1;
    ring.clear();
    (0..sides).for_each(|i| ring.push(t.origin(corner(i)).0));
    // From corner `i`, what follows the end of the spoke at which a face is met, up to that of the next spoke.
    let mut list = |from: HalfEdge, to: HalfEdge| {
        let mut at = from;
        while at != to {
            ring.push(t.origin(at).0);
            at = t.next(at);
        }
    };
    // The first and last faces round the last corner were met at corner 0 and at the corner before.
    let three_at_last = {
        let round = |h: HalfEdge| t.turn_left(h);
        round(corner(last)).and_then(round).and_then(round) == Some(corner(last))
    };
    for i in 0..sides {
        let own = corner(i);
        let (mut at, mut is_first) = (own, true);
        let is_closed = loop {
            let Some(h) = t.turn_left(at) else { break false };
            if h == own {
                break true;
            }
            let next = t.turn_left(h);
            let closes = next == Some(own);
            // Faces across the sides of the face are met at two corners.
            let was_met = (i > 0 && is_first) || (i == last && closes);
            if !was_met {
                let beside = closes || (i == last && next.and_then(|n| t.turn_left(n)) == Some(own));
                let from = t.next(t.next(h));
                // At the corner before the last one the last face may touch the first one again.
                let touches = closes && i + 1 == last && three_at_last && from != t.prev(h);
                list(
                    from,
                    if touches {
                        t.prev(t.prev(h))
                    } else if beside {
                        t.prev(h)
                    } else {
                        h
                    },
                );
            }
            (at, is_first) = (h, false);
        };
        if !is_closed {
            let (mut at, mut is_first) = (own, true);
            while let Some(h) = t.turn_right(at) {
                if !(i == last && is_first) {
                    let touches = is_first && i + 1 == last && three_at_last;
                    list(t.next(h), if touches { t.prev(t.prev(h)) } else { t.prev(h) });
                }
                (at, is_first) = (h, false);
            }
        }
    }
}

/// The fan of a vertex from the start on which all numberings agree; no class yet.
fn fan(t: &Topology, v: Vertex) -> Option<(Signature, Class)> {
    if t.is_non_manifold_vertex(v) || !t.foreign_sharpness(v).is_empty() {
        return None;
    }
    let (mut faces, mut starts, mut count) = ([0; MOST_FACES], [0; MOST_FACES], 0);
    let is_closed = t.walk_fan(v, |h| {
        if count < MOST_FACES {
            let sharpness = t.edge_sharpness.code(t.edge(h).index());
            faces[count] = (t.sides_at(h) as u32) << 8 | u32::from(sharpness);
            starts[count] = h.0;
        }
        count += 1;
    });
    let least = if is_closed { LEAST_FACES } else { 1 };
    let is_known = faces[..count.min(MOST_FACES)].iter().all(|face| face & 0xff != 0xff);
    let vertex = t.vertex_sharpness.code(v.index());
    if !(least..=MOST_FACES).contains(&count) || !is_known || vertex == u8::MAX {
        return None;
    }
    let mut signature = [0; MOST_FACES + 1];
    signature[0] = (count as u32) << 16 | u32::from(is_closed) << 8 | u32::from(vertex);
    let turned = |by: usize| faces[by..count].iter().chain(&faces[..by]);
    let (mut best, mut period) = (0, count);
    if is_closed {
        for by in 1..count {
            match turned(by).cmp(turned(best)) {
                std::cmp::Ordering::Less => best = by,
                std::cmp::Ordering::Equal => period = period.min(by - best),
                std::cmp::Ordering::Greater => {}
            }
        }
    }
    turned(best).zip(&mut signature[1..]).for_each(|(&face, out)| *out = face);
    Some((signature, Class { number: NONE, start: starts[best], period: period as u32 }))
}

#[cfg(test)]
mod tests {
    use super::super::smooth_ring::{MOST, is_distinct};
    use super::*;
    use crate::shapes;
    use crate::topology::{Surroundings, Walk};
    use std::collections::BTreeMap;

    #[test]
    fn equal_classes_round_a_face_mean_equal_walks_and_rings_are_read_as_walks_list_them() {
        let (mut walk, mut around, mut ring) = (Walk::default(), Surroundings::default(), Vec::new());
        let mut read_rings = 0;
        for shape in shapes::all() {
            let t = Topology::new(&shape.mesh).unwrap();
            let fans = Fans::new(&t, Vec::new());
            let classes = FanClasses::new(&t, &fans);
            let mut walks: BTreeMap<FaceKey, Vec<u32>> = BTreeMap::new();
            for face in (0..t.face_count()).map(Face::new) {
                let Some(key) = classes.of_face(&t, face) else { continue };
                for start in 0..t.sides(face) {
                    read(&t, face, start, &mut ring);
                    if ring.len() > MOST || !is_distinct(&ring) {
                        continue;
                    }
                    t.surroundings(face, start, &mut walk, &mut around);
                    assert_eq!(ring, around.ring, "{} {face} from {start}", shape.name);
                    let known = walks.entry(turned(&key, start)).or_insert_with(|| around.key.clone());
                    assert_eq!(*known, around.key, "{} {face} from {start}", shape.name);
                    read_rings += 1;
                }
            }
        }
        assert!(read_rings > 100, "{read_rings}");
    }

    #[test]
    fn the_least_key_does_not_depend_on_where_a_face_starts() {
        for corners in [[5, 3, 4, 4], [7, 2, 7, 2], [1, 1, 1, 1], [2, 1, 1, 1]] {
            let key: FaceKey = [4, corners[0], corners[1], corners[2], corners[3], 0, 0];
            let (best, _, period) = least(&key);
            for by in 0..4 {
                let (same, at, p) = least(&turned(&key, by));
                assert_eq!((same, p), (best, period));
                assert_eq!(turned(&turned(&key, by), at), best);
            }
            assert_eq!(turned(&key, period), key);
        }
    }
}
