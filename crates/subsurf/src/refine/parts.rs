//! A level's output cut into parts, one for each chunk of control faces: the vertices inside these faces and on the edges that they
//! are the first faces of. What one part belongs to no other writes, so that threads share nothing.

use super::numbering::{Owner, Region};
use super::uniform::zeroed;
use crate::real::Real;
use crate::threads::is_alone;
use crate::topology::Topology;
use rayon::prelude::*;
use std::ops::Range;

/// Control faces of a task at most, and vertices of the level that they should not exceed by much. Fixed; larger: uneven loads; smaller:
/// overhead of tasks.
const CHUNK: usize = 256;
const VERTICES: usize = 16 << 10;

/// Values of the vertices that some faces own.
pub(super) struct Task<'a, T, const N: usize> {
    pub faces: Range<usize>,
    /// The first of the edges that these faces own, in the order of owners.
    pub first_edge: usize,
    /// By region of faces, half-edges or edges: the part that belongs to these faces.
    pub parts: Vec<&'a mut [[T; N]]>,
    /// Where edges are not numbered in the order of their owners: their values, edge by edge.
    pub edges: &'a mut [[T; N]],
}

/// Writes a task's parts.
pub(super) trait Writer<T, const N: usize> {
    /// Returns the values of control vertices that the faces own.
    fn write(&mut self, task: Task<'_, T, N>) -> Vec<(u32, [T; N])>;
}

/// All values of a level of these regions; each thread has a writer. Vertices without a face keep their value.
pub(super) fn write_by_faces<T: Real, const N: usize, W: Writer<T, N>>(
    t: &Topology,
    regions: &[Region],
    values: &[[T; N]],
    out: &mut [[T; N]],
    writer: impl Fn() -> W + Sync + Send,
) {
    let owners = &t.edge_half_edge;
    let sorted = (!owners.is_sorted()).then(|| {
        let mut sorted: Vec<(u32, u32)> = owners.iter().zip(0..).map(|(&h, e)| (h, e)).collect();
        sorted.par_sort_unstable();
        sorted
    });
    let owned_before = |h: u32| match &sorted {
        None => owners.partition_point(|&owner| owner < h),
        Some(sorted) => sorted.partition_point(|&(owner, _)| owner < h),
    };
    let per_edge: usize = regions.iter().filter(|r| r.owner == Owner::Edges).map(|r| r.each).sum();
    let mut edge_values = zeroed(if sorted.is_some() { per_edge * t.edge_count() } else { 0 });

    // Cut the output into regions, and these into the parts of tasks.
    // Whole batches of sixteen faces.
    let chunk = (VERTICES * t.face_count() / out.len().max(1)).clamp(16, CHUNK) & !15;
    let (vertices, mut rest) = out.split_at_mut(t.vertex_count());
    vertices.copy_from_slice(values);
    let mut edge_rest = &mut edge_values[..];
    let mut edge_regions = Vec::new();
    let mut tasks: Vec<Task<'_, T, N>> = Vec::with_capacity(t.face_count().div_ceil(chunk));
    let mut edge = 0;
    for start in (0..t.face_count()).step_by(chunk) {
        let faces = start..(start + chunk).min(t.face_count());
        let end = owned_before(t.face_offset[faces.end]);
        let own = if sorted.is_some() { per_edge * (end - edge) } else { 0 };
        let (edges, tail) = edge_rest.split_at_mut(own);
        edge_rest = tail;
        tasks.push(Task { faces, first_edge: edge, parts: Vec::with_capacity(regions.len()), edges });
        edge = end;
    }
    let ends: Vec<usize> = tasks.iter().skip(1).map(|task| task.first_edge).chain([edge]).collect();
    for region in &regions[1..] {
        if region.owner == Owner::Edges && sorted.is_some() {
            let (part, tail) = rest.split_at_mut(region.each * t.edge_count());
            rest = tail;
            edge_regions.push(part);
        }
        for (task, &edge_end) in tasks.iter_mut().zip(&ends) {
            let count = match region.owner {
                Owner::Faces => task.faces.len(),
                Owner::HalfEdges => (t.face_offset[task.faces.end] - t.face_offset[task.faces.start]) as usize,
                Owner::Edges if sorted.is_none() => edge_end - task.first_edge,
                Owner::Edges | Owner::Vertices => 0,
            };
            let (part, tail) = rest.split_at_mut(region.each * count);
            rest = tail;
            task.parts.push(part);
        }
    }

    let mut put = |corners: Vec<(u32, [T; N])>| corners.iter().for_each(|&(v, value)| vertices[v as usize] = value);
    if is_alone() {
        // At once, from memory that is near.
        let mut writer = writer();
        tasks.into_iter().for_each(|task| put(writer.write(task)));
    } else {
        let corners: Vec<_> = tasks.into_par_iter().map_init(writer, Writer::write).collect();
        corners.into_iter().for_each(put);
    }
    if let Some(sorted) = sorted {
        let mut rank = vec![0u32; sorted.len()];
        sorted.iter().zip(0..).for_each(|(&(_, e), at)| rank[e as usize] = at);
        let mut skip = 0;
        for region in edge_regions {
            let each = region.len() / t.edge_count();
            region.par_chunks_mut(each).zip(&rank).with_min_len(CHUNK).for_each(|(part, &rank)| {
                part.copy_from_slice(&edge_values[per_edge * rank as usize + skip..][..each]);
            });
            skip += each;
        }
    }
}
