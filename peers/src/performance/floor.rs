//! The floor: how long writing the same output takes, with nothing to compute. On fresh memory for work that makes its
//! output, in huge pages where the system has them and in ordinary ones; on memory that was used before for work that renews it.

/// Positions and quads, in vectors that are made.
pub fn fresh(vertices: usize, faces: usize) -> (Vec<[f32; 3]>, Vec<[u32; 4]>) {
    fill(subsurf_memory::with_capacity(vertices), subsurf_memory::with_capacity(faces), vertices, faces)
}

/// The same in pages as they come.
pub fn fresh_in_ordinary_pages(vertices: usize, faces: usize) -> (Vec<[f32; 3]>, Vec<[u32; 4]>) {
    fill(Vec::with_capacity(vertices), Vec::with_capacity(faces), vertices, faces)
}

fn fill(
    mut positions: Vec<[f32; 3]>,
    mut quads: Vec<[u32; 4]>,
    vertices: usize,
    faces: usize,
) -> (Vec<[f32; 3]>, Vec<[u32; 4]>) {
    positions.extend((0..vertices).map(|i| [i as f32; 3]));
    quads.extend((0..faces as u32).map(|i| [i; 4]));
    (positions, quads)
}

/// Rows of numbers, over what was there.
pub fn renew<T: Copy + From<f32>, const N: usize>(rows: &mut [[T; N]], frame: f32) {
    for (i, row) in rows.iter_mut().enumerate() {
        *row = [T::from(i as f32 + frame); N];
    }
    std::hint::black_box(rows);
}
