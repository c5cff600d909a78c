//! What every half-edge's square does, in a byte: so that squares are told apart without looking at tables.

use super::super::fans::Fans;
use super::super::starts::Starts;
use crate::index::Edge;
use crate::topology::Topology;
use rayon::prelude::*;

/// What the half-edge at a corner of a control face says of the square there, in bits: it is the first of its edge; and runs
/// against it; its vertex is written here; its vertex has a fan; its edge is sharp; its vertex is a corner of quads alone.
pub(super) const OWNS_EDGE: u8 = 1;
pub(super) const BACKWARD: u8 = 2;
pub(super) const OWNS_VERTEX: u8 = 4;
pub(super) const HAS_FAN: u8 = 8;
pub(super) const IS_SHARP: u8 = 16;
pub(super) const IS_EARLY: u8 = 32;

/// By half-edge, what its square is.
pub(in super::super) fn flags(t: &Topology, starts: &Starts, fans: &Fans, is_linear: bool) -> Vec<u8> {
    let bit = |is: bool, bit: u8| u8::from(is) * bit;
    let of = |h: u32| {
        let (e, v) = (Edge(t.edge[h as usize]), t.origin[h as usize]);
        let has_fan = fans.of_vertex(v).is_some();
        let is_sharp = !is_linear && t.edge_sharpness.code(e.index()) != 0;
        let owns_vertex = !has_fan & (t.vertex_half_edge[v as usize] == h);
        let mut flags = bit(owns_vertex, OWNS_VERTEX) | bit(has_fan, HAS_FAN) | bit(is_sharp, IS_SHARP);
        flags |= bit(!starts.is_late(v), IS_EARLY);
        if t.edge_half_edge[e.index()] == h {
            flags |= OWNS_EDGE | bit(t.edge_vertices[e.index()][0] != v, BACKWARD);
        }
        flags
    };
    let mut out = subsurf_memory::with_capacity(t.half_edge_count());
    (0..t.half_edge_count() as u32).into_par_iter().with_min_len(SHARE).map(of).collect_into_vec(&mut out);
    out
}

/// Half-edges that a thread takes at least.
const SHARE: usize = 1 << 13;

/// Those of a quad's half-edges, the first one's lowest.
#[inline(always)]
pub(super) fn all_flags(flags: &[u8], first: u32) -> u32 {
    u32::from_le_bytes(*flags[first as usize..].first_chunk().expect("a quad has four sides"))
}

/// Which of these four have a flag, in as many bits.
#[inline(always)]
pub(super) fn with_flag(flags: u32, flag: u8) -> u32 {
    // Bits 0, 8, 16 and 24 move to 24, 25, 26 and 27.
    let found = flags >> flag.trailing_zeros() & 0x0101_0101;
    found.wrapping_mul(0x0102_0408) >> 24 & 15
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_of_four_half_edges_are_four_bits() {
        for found in 0..16u32 {
            for flag in [OWNS_EDGE, BACKWARD, OWNS_VERTEX, HAS_FAN, IS_SHARP, IS_EARLY] {
                let bytes = [0, 1, 2, 3].map(|k| if found >> k & 1 == 1 { flag } else { !flag });
                assert_eq!(with_flag(u32::from_le_bytes(bytes), flag), found);
            }
        }
    }
}
