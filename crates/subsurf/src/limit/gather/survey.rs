//! Which kinds of patches there are whose plans follow from the fans at their corners, found before any plan is made: chunk by chunk,
//! in parallel, then merged in the order of chunks. One patch of each kind is walked round.

use super::super::fan_class::{self, ByFace, FaceKey, FanClasses};
use super::super::fans::Fans;
use super::super::plan_key::{KeyHasher, Keys, Names, walk_plan};
use super::super::smooth_ring::{self, Valences, is_distinct};
use super::{Size, Start, others, valences};
use crate::index::Face;
use crate::topology::{NONE, Surroundings, Topology, Walk};
use rayon::prelude::*;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;
use std::ops::Range;

/// What the valences of a quad with smooth corners say: where its walk starts, and the plan if some ring names no vertex twice.
#[derive(Clone, Copy)]
pub(super) struct Smooth {
    pub start: u8,
    pub plan: u32,
}

type BySmooth<T> = HashMap<Valences, T, BuildHasherDefault<KeyHasher>>;

/// What the fans at the corners of a face say, from a certain corner on: at how many corners further walks start, and the plan.
#[derive(Clone, Copy)]
pub(super) struct Alike {
    start: usize,
    plan: u32,
}

/// The kinds of some faces, and how large their rings are.
pub(super) struct Survey {
    pub size: Size,
    kinds: Vec<Kind>,
    found: Vec<Found>,
}

/// Which of the survey's kinds a patch is that has not four smooth corners, from which corner on it looks so, and after how many
/// corners it looks the same again.
#[derive(Clone, Copy)]
pub(super) struct Found {
    kind: u32,
    turn: u8,
    period: u8,
}

/// A kind of patch, and the first patch of it.
#[derive(Clone, Copy)]
struct Kind {
    name: Name,
    face: Face,
    /// At which corner the name starts.
    turn: usize,
    /// False where the ring names a vertex twice.
    is_read: bool,
}

#[derive(Clone, Copy)]
enum Name {
    Smooth(Valences),
    Fans(FaceKey),
}

impl Survey {
    /// Surveys `faces`; `ring` is memory.
    pub fn of(
        t: &Topology,
        whole: usize,
        fans: &Fans,
        classes: &FanClasses<'_>,
        faces: Range<usize>,
        ring: &mut Vec<u32>,
    ) -> Self {
        let (mut size, mut kinds, mut found) = (Size::default(), Kinds::default(), Vec::new());
        let mut has_regular = false;
        for face in faces.map(Face::new) {
            if t.is_hole(face) {
                continue;
            }
            if let Some(valences) = valences(whole, &fans.valence, t.face_vertices(face)) {
                size.direct += smooth_ring::points(valences);
                if has_regular && valences == [4; 4] {
                    continue;
                }
                let kind = || {
                    ring.clear();
                    ring.resize(smooth_ring::points(valences), 0);
                    smooth_ring::read(t, face, 0, valences, ring);
                    Kind { name: Name::Smooth(valences), face, turn: 0, is_read: is_distinct(ring) }
                };
                has_regular |= kinds.smooth(valences, kind) && valences == [4; 4];
                continue;
            }
            size.others += others(t, whole, fans, face);
            let key = classes.of_face(t, face);
            for subface in 0..if t.sides(face) == whole { 1 } else { t.sides(face) } {
                let Some(key) = &key else {
                    found.push(Found { kind: NONE, turn: 0, period: 1 });
                    continue;
                };
                let (name, turn, period) = name(key, whole, subface);
                let kind = match kinds.fans.get(&name) {
                    Some(&kind) => kind,
                    None if is_read(t, face, turn, ring) => {
                        kinds.fans(name, Kind { name: Name::Fans(name), face, turn, is_read: true })
                    }
                    None => NONE,
                };
                found.push(Found { kind, turn: turn as u8, period: period as u8 });
            }
        }
        Self { size, kinds: kinds.list, found }
    }
}

/// Kinds in the order in which they come.
#[derive(Default)]
struct Kinds {
    list: Vec<Kind>,
    smooth: BySmooth<usize>,
    fans: ByFace<u32>,
}

impl Kinds {
    /// Takes a kind in, if it is new or its ring could not be read so far; true if it can be read.
    fn smooth(&mut self, valences: Valences, kind: impl FnOnce() -> Kind) -> bool {
        let next = self.list.len();
        let at = *self.smooth.entry(valences).or_insert(next);
        if at == next {
            self.list.push(kind());
        } else if !self.list[at].is_read {
            self.list[at] = kind();
        }
        self.list[at].is_read
    }

    /// Takes a kind in, if it is new; its number.
    fn fans(&mut self, name: FaceKey, kind: Kind) -> u32 {
        let next = self.list.len() as u32;
        let at = *self.fans.entry(name).or_insert(next);
        if at == next {
            self.list.push(kind);
        }
        at
    }
}

/// What the fans at the corners of a face are looked up by, from which corner on, and after how many corners that repeats itself.
/// A face that is one patch may be turned; the walk round a sub-face starts at its own corner.
fn name(key: &FaceKey, whole: usize, subface: usize) -> (FaceKey, usize, usize) {
    let sides = key[0] as usize;
    if sides == whole { fan_class::least(key) } else { (fan_class::turned(key, subface), subface, sides) }
}

/// Reads the ring of a face from corner `start`; false where it takes a walk.
fn is_read(t: &Topology, face: Face, start: usize, ring: &mut Vec<u32>) -> bool {
    fan_class::read(t, face, start, ring);
    ring.len() <= smooth_ring::MOST && is_distinct(ring)
}

/// Kinds that a thread walks round at a time.
const KINDS: usize = 64;

/// Memory for walks.
#[derive(Default)]
struct Scratch {
    walk: Walk,
    around: Surroundings,
    ring: Vec<u32>,
}

/// Walks round one face of each of some kinds: keys one after the other; for each kind where the walk starts, whether rings of the
/// kind can be read, and where its key ends.
#[derive(Default)]
struct Walked {
    keys: Vec<u32>,
    ends: Vec<(usize, bool, usize)>,
}

/// What all chunks share.
pub(super) struct Shared {
    pub smooth: BySmooth<Smooth>,
    /// By kind of whole mesh.
    alike: Vec<Option<Alike>>,
    /// The plans of all kinds, and for each a walk that gives it.
    pub plans: Keys,
    pub starts: Vec<Start>,
    /// By chunk: what was found, and the kinds of the mesh by those of the chunk.
    chunks: Vec<(Vec<Found>, Vec<u32>)>,
}

impl Shared {
    pub fn new(t: &Topology, whole: usize, surveys: Vec<Survey>, names: &mut Names) -> Self {
        let mut kinds = Kinds::default();
        let mut chunks = Vec::with_capacity(surveys.len());
        for survey in surveys {
            let number = |kind: &Kind| match kind.name {
                Name::Smooth(valences) => {
                    kinds.smooth(valences, || *kind);
                    NONE
                }
                Name::Fans(name) => kinds.fans(name, *kind),
            };
            chunks.push((survey.found, survey.kinds.iter().map(number).collect()));
        }
        let walk = |scratch: &mut Scratch, kinds: &[Kind]| -> Walked {
            let mut out = Walked::default();
            for &Kind { name, face, turn, is_read } in kinds {
                let Scratch { walk, around, ring } = scratch;
                let start = walk_plan(t, face, (t.sides(face) != whole).then_some(turn), walk, around);
                let is_read = match name {
                    Name::Smooth(_) => is_read,
                    Name::Fans(_) => {
                        fan_class::read(t, face, start, ring);
                        *ring == around.ring
                    }
                };
                if is_read {
                    out.keys.extend_from_slice(&around.key);
                }
                out.ends.push((start, is_read, out.keys.len()));
            }
            out
        };
        let walks: Vec<Walked> = kinds.list.par_chunks(KINDS).map_init(Scratch::default, walk).collect();
        let (smooth, alike) = (BySmooth::default(), Vec::with_capacity(kinds.list.len()));
        let mut out = Self { smooth, alike, plans: Keys::default(), starts: Vec::new(), chunks };
        out.plans.reserve(kinds.list.len(), 16);
        for (kinds, Walked { keys, ends }) in kinds.list.chunks(KINDS).zip(walks) {
            let mut from = 0;
            for (kind, (start, is_read, end)) in kinds.iter().zip(ends) {
                let key = &keys[std::mem::replace(&mut from, end)..end];
                let plan = is_read.then(|| {
                    let (plan, is_new) = out.plans.insert(names.plan_key(key));
                    out.starts.extend(is_new.then_some((kind.face.0, start as u32)));
                    plan
                });
                let sides = t.sides(kind.face);
                out.alike.push(plan.map(|plan| Alike { start: (start + sides - kind.turn) % sides, plan }));
                if let Name::Smooth(valences) = kind.name {
                    out.smooth.insert(valences, Smooth { start: start as u8, plan: plan.unwrap_or(NONE) });
                }
            }
        }
        out
    }

    /// What was found in a chunk, patch by patch.
    pub fn found(&self, chunk: usize) -> impl Iterator<Item = Found> + '_ {
        let (found, kinds) = &self.chunks[chunk];
        found.iter().map(|&found| match found.kind {
            NONE => found,
            kind => Found { kind: kinds[kind as usize], ..found },
        })
    }

    /// The plan of a patch of a kind, and the corner that its walk starts at, if its ring can be read; it is left in `ring`.
    pub fn read(&self, t: &Topology, face: Face, found: Found, ring: &mut Vec<u32>) -> Option<(u32, usize)> {
        let &Alike { start, plan } = self.alike.get(found.kind as usize)?.as_ref()?;
        // Of corners that look the same the first one.
        let start = (usize::from(found.turn) + start) % usize::from(found.period);
        is_read(t, face, start, ring).then_some((plan, start))
    }
}
