//! Locations in any order, brought together by patch: first into buckets of patches that follow each other, parameters and
//! all, then in order within a bucket, which the cache holds. So locations are read twice from end to end, and never all over
//! the place.

use super::jet::Location;
use super::patch_table::PatchTable;

/// Most buckets. Larger: more streams than the processor follows; smaller: buckets of large meshes leave the cache.
const MOST_BUCKETS: usize = 1 << 10;

/// Fewest patches of a bucket, as a power of two. Larger: buckets leave the cache; smaller: small meshes in tiny buckets.
const FEWEST: u32 = 6;

/// A location: bits of u and v, its patch and its number.
type Record = [u64; 3];

/// Locations by bucket; reusable memory.
#[derive(Default)]
pub(super) struct ByPatch {
    records: Vec<u64>,
    /// End of every bucket.
    ends: Vec<u32>,
    /// Patches of a bucket, as a power of two.
    shift: u32,
    order: Vec<u32>,
    counts: Vec<u32>,
}

/// A bucket: its locations, and their order by patch.
pub(super) struct Bucket<'a> {
    records: &'a [Record],
    order: &'a [u32],
}

impl ByPatch {
    /// Takes locations in.
    ///
    /// # Panics
    /// If one names no sub-face of the mesh.
    pub fn fill(&mut self, table: &PatchTable, locations: &[Location]) {
        let patch = |at: &Location| table.patch(at.face, at.subface);
        self.shift = FEWEST;
        while table.patch_count() >> self.shift >= MOST_BUCKETS {
            self.shift += 1;
        }
        self.ends.clear();
        self.ends.resize((table.patch_count() >> self.shift) + 2, 0);
        // Counts, one place late, then starts, which become ends as buckets fill.
        locations.iter().for_each(|at| self.ends[(patch(at) >> self.shift) + 1] += 1);
        for bucket in 1..self.ends.len() {
            self.ends[bucket] += self.ends[bucket - 1];
        }
        if self.records.len() < 3 * locations.len() {
            self.records = subsurf_memory::zeroed(3 * locations.len());
        }
        let records = self.records.as_chunks_mut::<3>().0;
        for (number, at) in locations.iter().enumerate() {
            let patch = patch(at);
            let to = &mut self.ends[patch >> self.shift];
            records[*to as usize] = [at.u.to_bits(), at.v.to_bits(), (patch as u64) << 32 | number as u64];
            *to += 1;
        }
    }

    /// Number of buckets.
    pub fn buckets(&self) -> usize {
        self.ends.len() - 1
    }

    /// The locations of a bucket in order.
    pub fn bucket(&mut self, bucket: usize) -> Bucket<'_> {
        let start = if bucket == 0 { 0 } else { self.ends[bucket - 1] as usize };
        let records = &self.records.as_chunks::<3>().0[start..self.ends[bucket] as usize];
        let patches = 1 << self.shift;
        self.order.clear();
        if records.len() < patches / 8 {
            self.order.extend(0..records.len() as u32);
            self.order.sort_unstable_by_key(|&i| records[i as usize][2]);
        } else {
            let local = |record: &Record| (record[2] >> 32) as usize & (patches - 1);
            self.counts.clear();
            self.counts.resize(patches + 1, 0);
            records.iter().for_each(|record| self.counts[local(record) + 1] += 1);
            for patch in 1..patches {
                self.counts[patch] += self.counts[patch - 1];
            }
            self.order.resize(records.len(), 0);
            for (i, record) in records.iter().enumerate() {
                let to = &mut self.counts[local(record)];
                self.order[*to as usize] = i as u32;
                *to += 1;
            }
        }
        Bucket { records, order: &self.order }
    }
}

impl Bucket<'_> {
    /// Number of locations.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Parameters, number and patch of the `k`-th location.
    #[inline(always)]
    pub fn place(&self, k: usize) -> ([f64; 2], u32, u32) {
        let [u, v, key] = self.records[self.order[k] as usize];
        ([f64::from_bits(u), f64::from_bits(v)], key as u32, (key >> 32) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::index::Face;
    use crate::scheme::Scheme;
    use crate::shapes;

    #[test]
    fn every_location_comes_once_and_patches_come_in_order() {
        let shape = shapes::grid(30, 20);
        let table = PatchTable::new(&shape.mesh, Scheme::CatmullClark).unwrap();
        let faces = shape.mesh.face_count() as u32;
        let mut by_patch = ByPatch::default();
        for count in [1, 5, 3000, 40] {
            let at: Vec<Location> =
                (0..count).map(|i| Location::new(i * 7919 % faces, f64::from(i) / 4096.0, 0.25)).collect();
            by_patch.fill(&table, &at);
            let (mut last, mut met) = (0, vec![false; at.len()]);
            for bucket in 0..by_patch.buckets() {
                let bucket = by_patch.bucket(bucket);
                for k in 0..bucket.len() {
                    let ([u, v], number, patch) = bucket.place(k);
                    let (patch, at) = (patch as usize, at[number as usize]);
                    assert_eq!((u, v, patch), (at.u, at.v, table.patch(Face(at.face.0), 0)));
                    assert!(last <= patch && !met[number as usize]);
                    (last, met[number as usize]) = (patch, true);
                }
            }
            assert!(met.iter().all(|&met| met));
        }
    }
}
