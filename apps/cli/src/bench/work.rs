//! The pieces of work that are measured, each one function.

use rayon::prelude::*;
use subsurf::{
    ControlMesh, Face, LimitSurface, Location, MeshError, PatchTable, Rates, Real, Scheme, Tags, TessellateError,
    TessellateOptions, Tessellation, UniformRefinement,
};

/// Where cold work begins: faces as arrays in memory.
#[derive(Clone)]
pub struct FaceLists {
    vertex_count: usize,
    sizes: Vec<u32>,
    corners: Vec<u32>,
    tags: Tags,
    scheme: Scheme,
}

impl FaceLists {
    pub fn of(mesh: &ControlMesh, scheme: Scheme) -> Self {
        Self {
            vertex_count: mesh.vertex_count(),
            sizes: mesh.faces().map(|face| face.len() as u32).collect(),
            corners: mesh.corners().to_vec(),
            tags: mesh.tags().clone(),
            scheme,
        }
    }

    pub fn face_count(&self) -> usize {
        self.sizes.len()
    }

    fn control_mesh(self) -> Result<ControlMesh, MeshError> {
        ControlMesh::from_counts(self.vertex_count, &self.sizes, self.corners, self.tags)
    }

    /// The patch table, ready to evaluate.
    pub fn patch_table(self) -> Result<PatchTable, MeshError> {
        let scheme = self.scheme;
        PatchTable::new(&self.control_mesh()?, scheme)
    }

    /// What is kept to refine new positions.
    pub fn refinement(self, depth: u32) -> Result<UniformRefinement, MeshError> {
        let scheme = self.scheme;
        UniformRefinement::new(&self.control_mesh()?, scheme, depth)
    }

    /// Positions and faces of a level.
    pub fn refined<T: Real>(self, depth: u32, points: &[[T; 3]]) -> Result<RefinedMesh<T>, MeshError> {
        let refinement = self.refinement(depth)?;
        Ok(RefinedMesh { positions: refinement.refine(points), corners: refinement.corners() })
    }

    /// Positions, normals and faces of a tessellation.
    pub fn tessellated<T: Real>(
        self,
        rate: u32,
        points: &[[T; 3]],
    ) -> Result<Result<Tessellation<T>, TessellateError>, MeshError> {
        Ok(self.patch_table()?.surface(points).tessellate(&at_rate(rate)))
    }
}

/// A refined mesh; all its faces have four corners (three under Loop).
#[derive(Clone)]
pub struct RefinedMesh<T> {
    pub positions: Vec<[T; 3]>,
    corners: Vec<u32>,
}

impl<T: Real> RefinedMesh<T> {
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.positions[..]) + size_of_val(&self.corners[..])) as u64
    }

    /// Writes it all into `out`, which has its lengths: nothing that makes such a mesh can take less time.
    pub fn copy_into(&self, out: &mut Self) {
        copy(&self.positions, &mut out.positions);
        copy(&self.corners, &mut out.corners);
    }
}

fn copy<V: Copy + Send + Sync>(from: &[V], to: &mut [V]) {
    to.par_chunks_mut(SHARE).zip(from.par_chunks(SHARE)).for_each(|(to, from)| to.copy_from_slice(from));
}

/// Elements that a thread takes at a time.
const SHARE: usize = 1 << 14;

/// A uniform rate, with normals.
pub fn at_rate(rate: u32) -> TessellateOptions {
    TessellateOptions { rates: Rates::Uniform(rate), ..TessellateOptions::default() }
}

pub fn tessellation_bytes<T>(mesh: &Tessellation<T>) -> u64 {
    let indices = size_of_val(&mesh.corners[..]) + size_of_val(&mesh.normal_corners[..]);
    let points = size_of_val(&mesh.positions[..]) + size_of_val(&mesh.normals[..]);
    (indices + points + size_of_val(&mesh.face_offsets[..])) as u64
}

/// How places follow each other.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Order {
    ByFace,
    Random,
}

/// Random places on all patches that are no holes, the same in every run.
pub fn places(table: &PatchTable, count: u32, order: Order) -> Vec<Location> {
    let faces = (0..table.topology().face_count()).map(Face::new);
    let patches: Vec<(Face, u32)> = faces
        .flat_map(|face| (0..table.subfaces(face)).map(move |subface| (face, subface)))
        .filter(|&(face, subface)| table.patch_plan(table.patch(face, subface)).is_some())
        .collect();
    let mut state = 1;
    let mut out: Vec<Location> = (0..count)
        .map(|_| {
            let (face, subface) = patches[(random(&mut state) * patches.len() as f64) as usize];
            let [mut u, mut v] = [random(&mut state), random(&mut state)];
            if table.scheme() == Scheme::Loop && u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            Location { face, subface, u, v }
        })
        .collect();
    if order == Order::ByFace {
        out.sort_by_key(|at| (at.face, at.subface));
    }
    out
}

/// Equally distributed in [0, 1): splitmix64 (Steele, Lea, Flood 2014).
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
}

/// Positions and first derivatives at places.
pub fn evaluate<T: Real>(surface: &LimitSurface<'_, T, 3>, places: &[Location], out: &mut [[[T; 3]; 3]]) {
    surface.eval_into(places, out);
}
