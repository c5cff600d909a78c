//! The edges of several shares as if one had met them all.

use super::super::NONE;
use super::FaceList;
use super::share::{Own, Share};
use rayon::prelude::*;

/// An edge of two shares: which, and its number in each.
struct Common {
    earlier: (u32, u32),
    later: (u32, u32),
}

/// Joins the edges that several shares have met, and numbers all in the order in which the faces name them; the first share takes
/// the edges of the others. Comes back with the first outgoing half-edges of all vertices.
///
/// There is nothing to be had where an edge with faces of several shares is not simply one of two faces in opposite directions:
/// what becomes of it depends on all its faces in turn. Shares and notes are as before then.
pub(super) fn join(list: FaceList<'_>, shares: &mut [Share], owns: &mut [Own<'_>]) -> Option<Vec<u32>> {
    let mut first_outgoing = subsurf_memory::zeroed(list.vertex_count);
    let blocks = first_outgoing.par_chunks_mut(BLOCK).enumerate();
    let found = blocks.map(|(block, outgoing)| common_edges(shares, owns, (block * BLOCK) as u32, outgoing));
    let mut found = found.collect::<Option<Vec<Vec<Common>>>>()?;
    found.push(common_crowded_edges(shares, owns)?);

    let mut merges: Vec<Merge> = shares.iter().map(|_| Merge::default()).collect();
    for Common { earlier, later } in found.into_iter().flatten() {
        let half_edge = |(share, edge): (u32, u32)| shares[share as usize].leader[edge as usize];
        let (h, twin) = (half_edge(earlier), half_edge(later));
        merges[earlier.0 as usize].twins.push((h, twin));
        merges[later.0 as usize].twins.push((twin, h));
        merges[later.0 as usize].dropped.push((later.1, earlier));
    }
    merges.par_iter_mut().for_each(|merge| merge.dropped.sort_unstable());
    let mut count = 0;
    for (merge, share) in merges.iter_mut().zip(shares.iter()) {
        merge.base = count;
        count += (share.leader.len() - merge.dropped.len()) as u32;
    }

    let (all, rest) = shares.split_first_mut()?;
    let first = all.leader.len();
    all.ends.resize(count as usize, [0; 2]);
    all.leader.resize(count as usize, 0);
    let (mut ends, mut leader) = (&mut all.ends[first..], &mut all.leader[first..]);
    let mut room = |share: &Share, merge: &Merge| {
        let kept = share.leader.len() - merge.dropped.len();
        (ends.split_off_mut(..kept).unwrap_or_default(), leader.split_off_mut(..kept).unwrap_or_default())
    };
    let room: Vec<_> = rest.iter().zip(&merges[1..]).map(|(share, merge)| room(share, merge)).collect();
    let (own, owns) = owns.split_first_mut()?;
    merges[0].set_twins(own);
    let merged = rest.par_iter().zip(owns).zip(&merges[1..]).zip(room);
    merged.for_each(|(((share, own), merge), (ends, leader))| {
        let edges = || {
            merge.copy_kept(&share.ends, ends);
            merge.copy_kept(&share.leader, leader);
        };
        let half_edges = || {
            merge.set_twins(own);
            let numbers = merge.numbers(share.leader.len(), &merges);
            own.edge.iter_mut().for_each(|edge| *edge = numbers[*edge as usize]);
        };
        rayon::join(edges, half_edges);
    });
    Some(first_outgoing)
}

/// Vertices that are looked at together.
const BLOCK: usize = 1 << 12;

/// The edges of several shares that are filed under the vertices of a block, which begins with vertex `start`, and the first outgoing
/// half-edges of these. None if an edge is no simple one.
fn common_edges(shares: &[Share], owns: &[Own<'_>], start: u32, outgoing: &mut [u32]) -> Option<Vec<Common>> {
    let end = start + outgoing.len() as u32;
    outgoing.fill(NONE);
    // By vertex, how many shares have edges there: all at once, since most vertices have one.
    let mut count = [0u8; BLOCK];
    let mut near = Vec::new();
    for (i, share) in shares.iter().enumerate() {
        let (from, to) = (share.vertices.start.max(start), share.vertices.end.min(end));
        if from < to {
            let [ours, theirs] =
                [start, share.vertices.start].map(|start| (from - start) as usize..(to - start) as usize);
            let pairs = outgoing[ours.clone()].iter_mut().zip(&share.outgoing[theirs.clone()]);
            pairs.for_each(|(a, &b)| *a = b.min(*a));
            let pairs = count[ours].iter_mut().zip(&share.head[theirs]);
            pairs.for_each(|(count, &head)| *count = count.saturating_add(u8::from(head != NONE)));
            near.push(i);
        }
    }
    let mut common = Vec::new();
    let mut present = Vec::with_capacity(near.len());
    for (v, _) in (start..end).zip(&count).filter(|(_, count)| **count > 1) {
        present.clear();
        present.extend(near.iter().copied().filter(|&i| shares[i].first_at(v) != NONE));
        for (n, &later) in present.iter().enumerate().skip(1) {
            for edge in shares[later].chain(v) {
                common.extend(in_earlier(shares, owns, &present[..n], (later, edge))?);
            }
        }
    }
    Some(common)
}

/// The same at vertices whose chains are full.
fn common_crowded_edges(shares: &[Share], owns: &[Own<'_>]) -> Option<Vec<Common>> {
    let all: Vec<usize> = (0..shares.len()).collect();
    let crowded = shares.iter().enumerate().skip(1).flat_map(|(i, share)| share.crowded().map(move |edge| (i, edge)));
    let crowded: Vec<(usize, u32)> = crowded.collect();
    let found = crowded.par_iter().with_min_len(BLOCK).map(|&edge| in_earlier(shares, owns, &all[..edge.0], edge));
    Some(found.collect::<Option<Vec<_>>>()?.into_iter().flatten().collect())
}

/// The same edge of an earlier share, if there is one; none where what they are together is no simple edge.
fn in_earlier(
    shares: &[Share],
    owns: &[Own<'_>],
    earlier: &[usize],
    (later, edge): (usize, u32),
) -> Option<Option<Common>> {
    let [a, b] = shares[later].ends[edge as usize];
    let mut found = earlier.iter().filter_map(|&i| shares[i].find(a, b).map(|same| (i, same)));
    let Some((i, same)) = found.next() else { return Some(None) };
    let is_simple = found.next().is_none()
        && shares[i].ends[same as usize][0] != a
        && shares[i].is_single(same, &owns[i])
        && shares[later].is_single(edge, &owns[later]);
    is_simple.then_some(Some(Common { earlier: (i as u32, same), later: (later as u32, edge) }))
}

/// What becomes of the edges of a share.
#[derive(Default)]
struct Merge {
    /// Half-edges with twins in other shares.
    twins: Vec<(u32, u32)>,
    /// Edges that are those of earlier shares, ascending, and these.
    dropped: Vec<(u32, (u32, u32))>,
    /// Number of the first edge.
    base: u32,
}

impl Merge {
    fn set_twins(&self, own: &mut Own<'_>) {
        self.twins.iter().for_each(|&(h, twin)| own.set_twin(h, twin));
    }

    /// What is kept of a column of the edges.
    fn copy_kept<T: Copy>(&self, from: &[T], mut to: &mut [T]) {
        let mut start = 0;
        let ends = self.dropped.iter().map(|dropped| dropped.0 as usize).chain([from.len()]);
        for end in ends {
            let kept = &from[start..end];
            to.split_off_mut(..kept.len()).unwrap_or_default().copy_from_slice(kept);
            start = end + 1;
        }
    }

    /// Number of an edge that is kept.
    fn number(&self, edge: u32) -> u32 {
        self.base + edge - self.dropped.partition_point(|dropped| dropped.0 < edge) as u32
    }

    /// Numbers of all edges.
    fn numbers(&self, edges: usize, all: &[Merge]) -> Vec<u32> {
        let mut numbers = subsurf_memory::with_capacity(edges);
        let mut next = self.base;
        for &(edge, (share, same)) in &self.dropped {
            let kept = edge - numbers.len() as u32;
            numbers.extend(next..next + kept);
            next += kept;
            // An edge has one share before this one, which keeps it.
            numbers.push(all[share as usize].number(same));
        }
        let kept = (edges - numbers.len()) as u32;
        numbers.extend(next..next + kept);
        numbers
    }
}
