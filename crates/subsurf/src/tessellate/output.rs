//! Where the samples of a frame go.

use std::ops::Range;

/// Points and, where they are wanted, their normals. After those of all points there may be further ones.
pub(super) struct Output<'o, T, const N: usize> {
    pub points: &'o mut [[T; N]],
    pub normals: &'o mut [[T; 3]],
}

impl<'o, T: Copy, const N: usize> Output<'o, T, N> {
    /// The first `count` points, and the rest.
    pub fn split(self, count: usize) -> (Self, Self) {
        let (points, more_points) = self.points.split_at_mut(count);
        let (normals, more_normals) = self.normals.split_at_mut(count.min(self.normals.len()));
        (Self { points, normals }, Self { points: more_points, normals: more_normals })
    }

    /// The same for a shorter time.
    pub fn borrow(&mut self) -> Output<'_, T, N> {
        Output { points: &mut *self.points, normals: &mut *self.normals }
    }

    /// Fills the first points, which are left out from then on.
    pub fn put(&mut self, points: &[[T; N]], normals: &[[T; 3]]) {
        self.points[..points.len()].copy_from_slice(points);
        if !self.normals.is_empty() {
            self.normals[..normals.len()].copy_from_slice(normals);
        }
        self.skip(points.len());
    }

    /// [`put`](Self::put) of a short run among more points, in fours without a call: what comes later may be overwritten, and must
    /// be put later.
    #[inline(always)]
    pub fn put_few(&mut self, run: Range<usize>, points: &[[T; N]], normals: &[[T; 3]]) {
        copy_few(run.clone(), points, self.points);
        if !self.normals.is_empty() {
            copy_few(run.clone(), normals, self.normals);
        }
        self.skip(run.len());
    }

    #[inline(always)]
    pub fn skip(&mut self, count: usize) {
        self.points = &mut std::mem::take(&mut self.points)[count..];
        if !self.normals.is_empty() {
            self.normals = &mut std::mem::take(&mut self.normals)[count..];
        }
    }
}

#[inline(always)]
fn copy_few<P: Copy>(run: Range<usize>, from: &[P], to: &mut [P]) {
    let fours = run.len().next_multiple_of(4);
    match (from.get(run.start..run.start + fours), to.get_mut(..fours)) {
        (Some(from), Some(to)) => {
            for (to, from) in to.as_chunks_mut::<4>().0.iter_mut().zip(from.as_chunks::<4>().0) {
                *to = *from;
            }
        }
        _ => to[..run.len()].copy_from_slice(&from[run]),
    }
}

/// A run of normals, if there are any.
pub(super) fn of<T>(normals: &[[T; 3]], run: Range<usize>) -> &[[T; 3]] {
    if normals.is_empty() { &[] } else { &normals[run] }
}

/// Vertices in the order of their owners, for layouts that have another.
pub(super) struct Vertices<T, const N: usize> {
    pub points: Vec<[T; N]>,
    pub normals: Vec<[T; 3]>,
}

impl<T, const N: usize> Default for Vertices<T, N> {
    fn default() -> Self {
        Self { points: Vec::new(), normals: Vec::new() }
    }
}
