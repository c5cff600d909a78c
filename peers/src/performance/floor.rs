//! The floor: how long writing the same output takes, with nothing to compute. On fresh memory for work that makes its
//! output, on memory that was used before for work that renews it.

/// Positions and quads, in vectors that are made.
pub fn fresh(vertices: usize, faces: usize) -> (Vec<[f32; 3]>, Vec<[u32; 4]>) {
    let positions = (0..vertices).map(|i| [i as f32; 3]).collect();
    let quads = (0..faces as u32).map(|i| [i; 4]).collect();
    (positions, quads)
}

/// Rows of numbers, over what was there.
pub fn renew<const N: usize>(rows: &mut [[f32; N]], frame: f32) {
    for (i, row) in rows.iter_mut().enumerate() {
        *row = [i as f32 + frame; N];
    }
    std::hint::black_box(rows);
}
