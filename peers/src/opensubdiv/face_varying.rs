//! OpenSubdiv's face-varying values: per level the value's index at every face corner, the values, and their limits.

use super::refiner::{PeerRefiner, Refiner};
use super::{Origin, VertexOrder};
use crate::shape::Shape;
use std::collections::HashSet;
use std::ffi::c_int;

unsafe extern "C" {
    fn peer_value_count(refiner: *const PeerRefiner, level: c_int) -> c_int;
    fn peer_value_indices(refiner: *const PeerRefiner, level: c_int, indices: *mut u32);
    fn peer_values(refiner: *const PeerRefiner, values: *mut [f64; 2]);
    fn peer_value_limits(refiner: *const PeerRefiner, values: *const [f64; 2], limits: *mut [f64; 2]);
}

/// A channel at one level, in OpenSubdiv's order.
#[derive(Clone, Debug)]
pub struct ChannelLevel {
    /// Index of the value at every face corner, the corners of face 0 first.
    pub indices: Vec<u32>,
    pub values: Vec<[f64; 2]>,
}

impl ChannelLevel {
    /// The value at every face corner, in which no numbering shows.
    pub fn at_corners(&self) -> Vec<[f64; 2]> {
        self.indices.iter().map(|&i| self.values[i as usize]).collect()
    }
}

/// The shape's channel, refined `levels` times under the rule of its tags; the result starts with level 0.
///
/// # Errors
/// What OpenSubdiv says when it refuses the mesh; a shape without a channel.
pub fn refine_channel(shape: &Shape, levels: u32) -> Result<Vec<ChannelLevel>, String> {
    let Some(channel) = &shape.channel else { return Err(format!("{}: no texture coordinates", shape.name)) };
    let refiner = Refiner::new(shape, levels, VertexOrder::default())?;
    // SAFETY: the levels exist, and the shape has a channel.
    let counts: Vec<usize> =
        (0..=levels).map(|l| unsafe { peer_value_count(refiner.0, l as c_int) } as usize).collect();
    let mut values = channel.values.clone();
    values.resize(counts.iter().sum(), [0.0; 2]);
    // SAFETY: the array holds all levels' values.
    unsafe { peer_values(refiner.0, values.as_mut_ptr()) };
    let mut start = 0;
    let mut out = vec![];
    for level in 0..=levels {
        let mut indices = vec![0; refiner.counts(level)[3]];
        // SAFETY: one index per face corner of the level.
        unsafe { peer_value_indices(refiner.0, level as c_int, indices.as_mut_ptr()) };
        let end = start + counts[level as usize];
        out.push(ChannelLevel { indices, values: values[start..end].to_vec() });
        start = end;
    }
    Ok(out)
}

/// True where OpenSubdiv 3.7 takes one value for two. Values round a vertex may alternate, a b a b; the list of distinct
/// ones that `Vtr::internal::FVarLevel::completeTopologyFromFaceValues` makes then gets b once more (it compares the
/// second time with a only), and b's faces, torn apart, pass for two spans that are whole.
///
/// # Errors
/// As [`refine_channel`].
pub fn takes_one_value_for_two(shape: &Shape) -> Result<bool, String> {
    let Some(channel) = &shape.channel else { return Ok(false) };
    let level = super::refine(shape, 1, VertexOrder::VerticesFirst)?.pop().expect("level 1");
    let refined = refine_channel(shape, 1)?.pop().expect("level 1");
    // Children of values at vertices come first, those of one vertex after the other; a vertex without faces has one.
    let old = |v: u32| matches!(level.vertex_origins[v as usize], Origin::Vertex(_));
    let corners = level.face_vertices.iter().zip(&refined.indices).filter(|(v, _)| old(**v));
    let counted: HashSet<u32> = corners.map(|(_, &value)| value).collect();
    let distinct: HashSet<(u32, u32)> = shape.indices.iter().copied().zip(channel.indices.iter().copied()).collect();
    Ok(counted.len() > distinct.len())
}

/// `PrimvarRefiner::LimitFaceVarying` of the values of `level`, in the order of that level's values.
///
/// # Errors
/// As [`refine_channel`].
pub fn limit_channel(shape: &Shape, level: u32) -> Result<Vec<[f64; 2]>, String> {
    let finest = refine_channel(shape, level)?.pop().expect("level 0 at least");
    let refiner = Refiner::new(shape, level, VertexOrder::default())?;
    let mut limits = vec![[0.0; 2]; finest.values.len()];
    // SAFETY: both arrays have the finest level's number of values.
    unsafe { peer_value_limits(refiner.0, finest.values.as_ptr(), limits.as_mut_ptr()) };
    Ok(limits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alternating_values_round_a_vertex_are_counted_twice() {
        let text = |values: [u32; 4]| {
            let [a, b, c, d] = values;
            let faces = format!("f 1/3 2/3 5/{a} 4/3\nf 2/3 3/3 6/3 5/{b}\nf 5/{c} 6/3 9/3 8/3\nf 4/3 5/{d} 8/3 7/3");
            let points: String = (0..9).map(|i| format!("v {} {} 0\n", i % 3, i / 3)).collect();
            Shape::parse("catmark_x", &format!("{points}vt 0 0\nvt 1 0\nvt 2 0\n{faces}")).unwrap()
        };
        assert!(takes_one_value_for_two(&text([1, 2, 1, 2])).unwrap());
        assert!(!takes_one_value_for_two(&text([1, 1, 2, 2])).unwrap());
    }
}
