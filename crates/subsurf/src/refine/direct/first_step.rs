//! Level 1 from the control mesh, all or in part: the only step that meets faces of any number of corners and triangles that are
//! smoothed.
//! Centroids first; edges and vertices take them from there.

use super::rules::{RowGrid, Special};
use super::starts::Needed;
use crate::index::{Edge, Face, HalfEdge, Vertex};
use crate::kernel::{RowRule, vectorized};
use crate::mask::{Mask, edge_mask, is_linear, vertex_mask};
use crate::real::Real;
use crate::scheme::Scheme;
use crate::scheme::catmull_clark::smooth_neighbour;
use crate::tags::Triangles;
use crate::threads;
use crate::topology::{FaceOf, NONE, Topology};

/// Vertices of a task. Fixed; larger: uneven loads; smaller: overhead of tasks.
const CHUNK: usize = 2048;

/// What the first step needs beside the topology.
pub(super) struct FirstStep {
    smooth: RowRule<f64>,
    is_linear: bool,
    edges: Special,
    vertices: Special,
    /// What is made; all where there is none.
    needed: Option<Needed>,
}

impl FirstStep {
    /// `special` are the vertices that do not follow the smooth rule.
    pub fn new(t: &Topology, scheme: Scheme, special: &[u32], grid: &mut RowGrid, needed: Option<Needed>) -> Self {
        let is_needed = |i: u32, of: fn(&Needed) -> &[u32]| {
            needed.as_ref().is_none_or(|needed| of(needed).binary_search(&i).is_ok())
        };
        let is_linear = is_linear(t, scheme);
        let (mut edges, mut vertices, mut mask) = (Special::default(), Special::default(), Mask::default());
        let first_centroid = t.vertex_count() as u32;
        let terms = |mask: &Mask| {
            let centroids = mask.faces.iter().map(|&(f, w)| (first_centroid + f, w));
            mask.vertices.iter().copied().chain(centroids).collect::<Vec<_>>()
        };
        if !is_linear {
            let has_smooth_triangles = t.rules().triangles == Triangles::Smooth;
            let at_triangle = |e: usize| {
                let h = HalfEdge(t.edge_half_edge[e]);
                has_smooth_triangles && [Some(h), t.twin(h)].iter().flatten().any(|&h| t.sides(t.face(h)) == 3)
            };
            let mut add = |e: usize| {
                if is_needed(e as u32, |needed| &needed.edges) {
                    edge_mask(t, scheme, Edge(e as u32), &mut mask);
                    edges.push(e as u32, terms(&mask).into_iter());
                }
            };
            if has_smooth_triangles {
                (0..t.edge_count()).filter(|&e| t.edge_sharpness.get(e) > 0.0 || at_triangle(e)).for_each(&mut add);
            } else {
                t.edge_sharpness.sharp().for_each(&mut add);
            }
            for &v in special.iter().filter(|v| is_needed(**v, |needed| &needed.vertices)) {
                vertex_mask(t, scheme, Vertex(v), &mut mask);
                vertices.push(v, terms(&mask).into_iter());
            }
        }
        Self { smooth: grid.rule(0.0), is_linear, edges, vertices, needed }
    }

    /// Level 1 in `out`.
    pub fn refine<T: Real, const N: usize>(&self, t: &Topology, values: &[[T; N]], out: &mut [[T; N]]) {
        let (vertices, rest) = out.split_at_mut(t.vertex_count());
        let (faces, edges) = rest.split_at_mut(t.face_count());
        let needed = self.needed.as_ref();
        let chunks = faces.chunks_mut(CHUNK).enumerate().collect();
        threads::for_each(chunks, |(chunk, out): (usize, &mut [[T; N]])| {
            let first = chunk * CHUNK;
            vectorized(
                #[inline(always)]
                || match needed.map(|needed| among(&needed.faces, first, out.len())) {
                    None => centroids(t, values, first, 0..out.len(), out),
                    Some(some) => centroids(t, values, first, offsets(some, first), out),
                },
            );
        });
        let faces = &*faces;
        let is_quads = matches!(t.face, FaceOf::Quads);
        let edges = edges.chunks_mut(CHUNK).enumerate().map(|(chunk, out)| (chunk, false, out));
        let vertices = vertices.chunks_mut(CHUNK / 2).enumerate().map(|(chunk, out)| (chunk, true, out));
        threads::for_each(edges.chain(vertices).collect(), |(chunk, is_vertices, out)| {
            let first = chunk * if is_vertices { CHUNK / 2 } else { CHUNK };
            let some = needed
                .map(|needed| among(if is_vertices { &needed.vertices } else { &needed.edges }, first, out.len()));
            vectorized(
                #[inline(always)]
                || match (is_vertices, some) {
                    (false, None) => self.edges(t, values, faces, first, 0..out.len(), out),
                    (false, Some(some)) => self.edges(t, values, faces, first, offsets(some, first), out),
                    (true, None) if is_quads => {
                        self.vertices::<T, N, true>(t, values, faces, first, 0..out.len(), out);
                    }
                    (true, None) => self.vertices::<T, N, false>(t, values, faces, first, 0..out.len(), out),
                    (true, Some(some)) => {
                        self.vertices::<T, N, false>(t, values, faces, first, offsets(some, first), out);
                    }
                },
            );
        });
    }

    /// Vertices on the edges from number `first` on that are so many behind it.
    #[inline(always)]
    fn edges<T: Real, const N: usize>(
        &self,
        t: &Topology,
        values: &[[T; N]],
        faces: &[[T; N]],
        first: usize,
        edges: impl Iterator<Item = usize>,
        out: &mut [[T; N]],
    ) {
        let [end, centroid] = self.smooth.edge.map(T::from_f64);
        let (ends, sides) = (&t.edge_vertices[first..][..out.len()], &t.edge_half_edge[first..][..out.len()]);
        for i in edges {
            let [a, b] = [&values[ends[i][0] as usize], &values[ends[i][1] as usize]];
            let h = sides[i];
            let twin = t.twin[h as usize];
            // What has one face only is overwritten, or linear.
            let twin = if twin == NONE { h } else { twin };
            let [f, g] = [&faces[t.face.get(h) as usize], &faces[t.face.get(twin) as usize]];
            for c in 0..N {
                out[i][c] = end * (a[c] + b[c]) + centroid * (f[c] + g[c]);
            }
        }
        overwrite(&self.edges, values, faces, first, out);
    }

    #[inline(always)]
    fn vertices<T: Real, const N: usize, const QUADS: bool>(
        &self,
        t: &Topology,
        values: &[[T; N]],
        faces: &[[T; N]],
        first: usize,
        vertices: impl Iterator<Item = usize>,
        out: &mut [[T; N]],
    ) {
        let own = &values[first..][..out.len()];
        if self.is_linear {
            return out.copy_from_slice(own);
        }
        let half_edges = &t.vertex_half_edge[first..][..out.len()];
        for i in vertices {
            let (own, mut sum, mut valence) = (&own[i], [T::default(); N], 0);
            let first = half_edges[i];
            let mut h = first;
            while h != NONE {
                let (next, prev, face) = neighbours::<QUADS>(t, h);
                let (p, f) = (&values[t.origin[next as usize] as usize], &faces[face as usize]);
                for c in 0..N {
                    sum[c] = sum[c] + ((p[c] - own[c]) + (f[c] - own[c]));
                }
                valence += 1;
                h = t.twin[prev as usize];
                if h == first {
                    break;
                }
            }
            let each = T::from_f64(smooth_neighbour(valence.max(1), 1.0));
            for c in 0..N {
                out[i][c] = own[c] + each * sum[c];
            }
        }
        overwrite(&self.vertices, values, faces, first, out);
    }

    pub fn special(&self) -> usize {
        self.edges.owners.len() + self.vertices.owners.len()
    }

    pub fn bytes(&self) -> usize {
        let needed = self
            .needed
            .as_ref()
            .map_or(0, |Needed { faces, edges, vertices }| 4 * (faces.len() + edges.len() + vertices.len()));
        self.edges.bytes() + self.vertices.bytes() + needed
    }
}

/// The half-edge after another one, the one before it, and their face; `QUADS` where all faces are quads.
#[inline(always)]
fn neighbours<const QUADS: bool>(t: &Topology, h: u32) -> (u32, u32, u32) {
    if QUADS {
        return (h & !3 | (h + 1) & 3, h & !3 | h.wrapping_sub(1) & 3, h / 4);
    }
    (t.next(HalfEdge(h)).0, t.prev(HalfEdge(h)).0, t.face.get(h))
}

/// Those of some numbers, in ascending order, that are at least `first` and less than `count` beyond.
fn among(numbers: &[u32], first: usize, count: usize) -> &[u32] {
    let at = |end: usize| numbers.partition_point(|&i| (i as usize) < end);
    &numbers[at(first)..at(first + count)]
}

/// How far they are beyond.
#[inline(always)]
fn offsets(numbers: &[u32], first: usize) -> impl Iterator<Item = usize> {
    numbers.iter().map(
        #[inline(always)]
        move |&i| i as usize - first,
    )
}

/// Those of a task that have rules of their own.
#[inline(always)]
fn overwrite<T: Real, const N: usize>(
    special: &Special,
    values: &[[T; N]],
    faces: &[[T; N]],
    first: usize,
    out: &mut [[T; N]],
) {
    for row in special.among(first as u32..(first + out.len()) as u32) {
        let value = |id: u32| match values.get(id as usize) {
            Some(value) => *value,
            None => faces[id as usize - values.len()],
        };
        out[special.owners[row] as usize - first] = special.apply(row, value);
    }
}

#[inline(always)]
fn centroids<T: Real, const N: usize>(
    t: &Topology,
    values: &[[T; N]],
    first: usize,
    faces: impl Iterator<Item = usize>,
    out: &mut [[T; N]],
) {
    let quarter = T::from_f64(0.25);
    for i in faces {
        let (corners, out) = (t.face_vertices(Face::new(first + i)), &mut out[i]);
        if let [a, b, c, d] = *corners {
            let [a, b, c, d] = [a, b, c, d].map(|v| &values[v as usize]);
            for k in 0..N {
                out[k] = quarter * ((a[k] + b[k]) + (c[k] + d[k]));
            }
            continue;
        }
        let base = &values[corners[0] as usize];
        let (mut sum, each) = ([T::default(); N], T::from_f64(1.0 / corners.len() as f64));
        for v in &corners[1..] {
            let p = &values[*v as usize];
            for k in 0..N {
                sum[k] = sum[k] + (p[k] - base[k]);
            }
        }
        for k in 0..N {
            out[k] = base[k] + each * sum[k];
        }
    }
}
