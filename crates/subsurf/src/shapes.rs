//! Tiny meshes, each named after the difficulty that it isolates. Tests, documentation and benchmarks share them.

use crate::mesh::ControlMesh;
use crate::tags::{Boundary, Corner, Crease, Creasing, Rules, Tags, Triangles};
use std::f64::consts::PI;

/// A mesh with positions.
#[derive(Clone, Debug)]
pub struct Shape {
    /// What it isolates.
    pub name: String,
    /// Faces and tags.
    pub mesh: ControlMesh,
    /// One point per vertex.
    pub positions: Vec<[f64; 3]>,
}

impl Shape {
    fn new(name: impl Into<String>, faces: &[Vec<u32>], positions: Vec<[f64; 3]>, tags: Tags) -> Self {
        let name = name.into();
        let counts: Vec<u32> = faces.iter().map(|f| f.len() as u32).collect();
        let mesh = ControlMesh::from_counts(positions.len(), &counts, faces.concat(), tags)
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        Self { name, mesh, positions }
    }

    /// The same shape with other tags.
    #[must_use]
    pub fn tagged(&self, name: impl Into<String>, tags: Tags) -> Self {
        let faces: Vec<Vec<u32>> = self.mesh.faces().map(<[u32]>::to_vec).collect();
        Self::new(name, &faces, self.positions.clone(), tags)
    }
}

impl Shape {
    /// The same shape with every face cut into triangles from its first corner, for Loop subdivision.
    #[must_use]
    pub fn triangulated(&self) -> Self {
        let mut faces = Vec::new();
        let mut holes = Vec::new();
        for (f, face) in self.mesh.faces().enumerate() {
            for i in 1..face.len() - 1 {
                if self.mesh.tags().holes.contains(&(f as u32)) {
                    holes.push(faces.len() as u32);
                }
                faces.push(vec![face[0], face[i], face[i + 1]]);
            }
        }
        let tags = Tags { holes, ..self.mesh.tags().clone() };
        Self::new(format!("{}, in triangles", self.name), &faces, self.positions.clone(), tags)
    }
}

/// A number in `[-1, 1)` that looks random and depends on `seed` alone.
fn noise(seed: u64) -> f64 {
    let mut x = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// A deterministic bump for point `i`.
fn bump(i: usize) -> f64 {
    0.3 * noise(i as u64)
}

/// The cube `[-1, 1]³`: closed, every vertex of valence 3.
pub fn cube() -> Shape {
    let positions = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * f64::from(b) - 1.0)).collect();
    let faces: Vec<Vec<u32>> =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]].map(|f| f.to_vec()).into();
    Shape::new("cube", &faces, positions, Tags::default())
}

/// `columns × rows` quads over the unit grid, bumpy: regular inside, with a boundary and four corners.
pub fn grid(columns: u32, rows: u32) -> Shape {
    let at = |x: u32, y: u32| y * (columns + 1) + x;
    let positions = (0..(columns + 1) * (rows + 1))
        .map(|i| [f64::from(i % (columns + 1)), f64::from(i / (columns + 1)), bump(i as usize)])
        .collect();
    let quad = |i: u32| {
        let (x, y) = (i % columns, i / columns);
        vec![at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]
    };
    let faces: Vec<Vec<u32>> = (0..columns * rows).map(quad).collect();
    Shape::new(format!("grid {columns}x{rows}"), &faces, positions, Tags::default())
}

/// A torus of `columns × rows` quads, bumpy and regular everywhere. Round three faces the neighbours of a face on both sides
/// are the same.
pub fn torus(columns: u32, rows: u32) -> Shape {
    let at = |x: u32, y: u32| y % rows * columns + x % columns;
    let angle = |i: u32, of: u32| 2.0 * PI * f64::from(i) / f64::from(of);
    let positions = (0..columns * rows)
        .map(|i| {
            let (round, across) = (angle(i % columns, columns), angle(i / columns, rows));
            let far = 2.0 + across.cos() + bump(i as usize);
            [far * round.cos(), far * round.sin(), across.sin()]
        })
        .collect();
    let quad = |i: u32| {
        let (x, y) = (i % columns, i / columns);
        vec![at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]
    };
    let faces: Vec<Vec<u32>> = (0..columns * rows).map(quad).collect();
    Shape::new(format!("torus {columns}x{rows}"), &faces, positions, Tags::default())
}

/// Two rings of quads round one vertex of valence `n`.
pub fn interior_vertex(n: u32) -> Shape {
    fan(format!("interior valence {n}"), n, true, 3)
}

/// Three rings of quads round a boundary vertex with `k` faces.
pub fn boundary_vertex(k: u32) -> Shape {
    fan(format!("boundary vertex with {k} faces"), k, false, 3)
}

/// `rings` rings of quads in `n` sectors round vertex 0; sector `s` is a skewed grid, `rings × rings` quads.
fn fan(name: String, n: u32, closed: bool, rings: u32) -> Shape {
    // Point (x, y) of sector s lies x steps along spoke s and y steps along spoke s + 1; (0, y) is spoke s + 1's point.
    let spokes = if closed { n } else { n + 1 };
    let inner = rings * rings;
    let at = |s: u32, x: u32, y: u32| match (x, y) {
        (0, 0) => 0,
        (x, 0) => 1 + (s % spokes) * rings + x - 1,
        (0, y) => 1 + ((s + 1) % spokes) * rings + y - 1,
        (x, y) => 1 + spokes * rings + s * inner + (y - 1) * rings + x - 1,
    };
    let mut positions = vec![[0.0; 3]; (1 + spokes * rings + n * inner) as usize];
    let turn = if closed { 2.0 * PI } else { f64::from(n).min(5.0) / 5.0 * 1.8 * PI };
    let angle = |s: u32| turn * f64::from(s) / f64::from(n);
    let mut faces = Vec::new();
    for s in 0..n {
        let (a, b) = (angle(s), angle(s + 1));
        for y in 0..=rings {
            for x in 0..=rings {
                let i = at(s, x, y) as usize;
                let (p, q) = (f64::from(x), f64::from(y));
                let radius = (p * p + q * q + p * q * 0.6).sqrt();
                let phi = if p + q == 0.0 { 0.0 } else { a + (b - a) * q / (p + q) };
                positions[i] = [radius * phi.cos(), radius * phi.sin(), bump(i) + 0.15 * radius];
                if x < rings && y < rings {
                    faces.push(vec![at(s, x, y), at(s, x + 1, y), at(s, x + 1, y + 1), at(s, x, y + 1)]);
                }
            }
        }
    }
    Shape::new(name, &faces, positions, Tags::default())
}

/// Triangles and one quad round a pole of valence `n`, closed below by one `n`-gon.
pub fn cone(n: u32) -> Shape {
    let mut positions = vec![[0.0, 0.0, 1.0]];
    positions.extend((0..n).map(|i| {
        let a = 2.0 * PI * f64::from(i) / f64::from(n);
        [a.cos(), a.sin(), bump(i as usize)]
    }));
    let mut faces: Vec<Vec<u32>> = (0..n).map(|i| vec![0, 1 + i, 1 + (i + 1) % n]).collect();
    faces.push((0..n).rev().map(|i| 1 + i).collect());
    Shape::new(format!("cone of {n} triangles over a {n}-gon"), &faces, positions, Tags::default())
}

/// Two quads glued back to back along their boundaries would be flat; two such pockets: interior vertices of valence 2.
pub fn interior_valence_two() -> Shape {
    // A cube whose front face carries an inner quad that touches it at two opposite corners of valence 2.
    let cube = cube();
    let mut positions = cube.positions;
    positions.push([-0.4, 0.4, 1.6]);
    positions.push([0.4, -0.4, 1.7]);
    let mut faces: Vec<Vec<u32>> = cube.mesh.faces().skip(2).map(<[u32]>::to_vec).collect();
    faces.push(vec![0, 2, 3, 1]);
    faces.extend([vec![4, 5, 9, 8], vec![8, 9, 5, 7], vec![4, 8, 7, 6]]);
    Shape::new("interior valence 2", &faces, positions, Tags::default())
}

/// Three sheets along one common edge chain: non-manifold edges, with a non-manifold crease vertex in the middle.
pub fn three_sheets() -> Shape {
    let mut positions: Vec<[f64; 3]> = (0..3).map(|i| [0.0, f64::from(i), 0.0]).collect();
    let mut faces = Vec::new();
    for sheet in 0..3u32 {
        let angle = 2.0 * PI * f64::from(sheet) / 3.0;
        for x in 1..3 {
            for y in 0..3 {
                let r = f64::from(x);
                positions.push([r * angle.cos(), f64::from(y), r * angle.sin() + bump(positions.len())]);
            }
        }
        let at = |x: u32, y: u32| if x == 0 { y } else { 3 + sheet * 6 + (x - 1) * 3 + y };
        for x in 0..2 {
            for y in 0..2 {
                faces.push(vec![at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]);
            }
        }
    }
    Shape::new("three sheets along a line", &faces, positions, Tags::default())
}

/// Two grids that touch in one vertex only.
pub fn bow_tie() -> Shape {
    let one = grid(2, 2);
    let mut positions = one.positions.clone();
    let mut faces: Vec<Vec<u32>> = one.mesh.faces().map(<[u32]>::to_vec).collect();
    let shift = |v: u32| if v == 0 { 8 } else { 8 + v };
    positions.extend(one.positions[1..].iter().map(|p| [p[0] + 2.0, p[1] + 2.0, p[2] + bump(7)]));
    faces.extend(one.mesh.faces().map(|f| f.iter().map(|&v| shift(v)).collect::<Vec<u32>>()));
    Shape::new("bow tie", &faces, positions, Tags::default())
}

/// Two quads that run through their common edge in the same direction.
pub fn winding_conflict() -> Shape {
    let one = grid(2, 1);
    let faces = vec![vec![0, 1, 4, 3], vec![1, 4, 5, 2]];
    Shape::new("winding conflict", &faces, one.positions, Tags::default())
}

/// A quad that visits one vertex twice in a row, and one that uses an edge in both directions.
pub fn degenerate_faces() -> Shape {
    let mut positions = grid(2, 2).positions;
    positions.push([3.0, 3.0, 3.0]);
    let faces = vec![vec![0, 1, 4, 3], vec![1, 2, 5, 5], vec![3, 4, 7, 4], vec![4, 5, 8, 7]];
    Shape::new("degenerate faces and an isolated vertex", &faces, positions, Tags::default())
}

/// All shapes, in all their variants.
pub fn all() -> Vec<Shape> {
    let mut shapes = vec![cube(), grid(4, 3), interior_valence_two(), three_sheets(), bow_tie()];
    shapes.extend([winding_conflict(), degenerate_faces(), cone(5), cone(7)]);
    shapes.extend([3, 5, 6, 8, 12].map(interior_vertex));
    shapes.extend([1, 2, 3, 4, 5, 7].map(boundary_vertex));
    shapes.extend(tagged());
    shapes
}

/// Two rings of triangles round one vertex of valence `n`.
pub fn interior_triangles(n: u32) -> Shape {
    let at = |ring: u32, i: u32| if ring == 1 { 1 + i % n } else { 1 + n + i % (2 * n) };
    let mut positions = vec![[0.0, 0.0, 0.4]];
    for (ring, count) in [(1u32, n), (2, 2 * n)] {
        for i in 0..count {
            let a = 2.0 * PI * f64::from(i) / f64::from(count);
            let r = f64::from(ring);
            positions.push([r * a.cos(), r * a.sin(), bump(positions.len())]);
        }
    }
    let mut faces = Vec::new();
    for i in 0..n {
        faces.push(vec![0, at(1, i), at(1, i + 1)]);
        faces.push(vec![at(1, i), at(2, 2 * i), at(2, 2 * i + 1)]);
        faces.push(vec![at(1, i), at(2, 2 * i + 1), at(1, i + 1)]);
        faces.push(vec![at(1, i + 1), at(2, 2 * i + 1), at(2, 2 * i + 2)]);
    }
    Shape::new(format!("interior valence {n}, triangles"), &faces, positions, Tags::default())
}

/// Two triangles back to back: three vertices of valence 2. Not among [`all_triangles`]: its first level has two edges
/// between the same vertices, which no list of faces can say.
pub fn pillow() -> Shape {
    let positions = vec![[0.0, 0.0, 0.2], [1.0, 0.1, 0.0], [0.2, 0.9, -0.1]];
    Shape::new("pillow of two triangles", &[vec![0, 1, 2], vec![0, 2, 1]], positions, Tags::default())
}

/// All shapes that Loop subdivision takes, in all their variants.
pub fn all_triangles() -> Vec<Shape> {
    let mut shapes: Vec<Shape> = all().iter().map(Shape::triangulated).collect();
    shapes.extend([3, 4, 5, 6, 7, 12].map(interior_triangles));
    let fan = interior_triangles(6);
    let spokes = |list: &[(u32, f64)]| Tags {
        creases: list.iter().flat_map(|&(i, s)| [Crease::new(0, 1 + i, s), Crease::new(1 + i, 7 + 2 * i, s)]).collect(),
        ..Tags::default()
    };
    shapes.extend([
        fan.tagged("dart of valence 6, triangles", spokes(&[(0, 10.0)])),
        fan.tagged("semi-sharp crease, triangles", spokes(&[(0, 2.3), (3, 2.3)])),
        fan.tagged("crease through two triangles", spokes(&[(0, 10.0), (2, 10.0)])),
        fan.tagged("corner of two triangles", spokes(&[(0, 10.0), (2, 10.0), (4, 10.0)])),
    ]);
    shapes
}

/// Shapes whose difficulty is in their tags.
pub fn tagged() -> Vec<Shape> {
    let rules = |boundary| Rules { boundary, ..Rules::default() };
    let creases = |creases: &[(u32, u32, f64)]| Tags {
        creases: creases.iter().map(|&(a, b, s)| Crease::new(a, b, s)).collect(),
        ..Tags::default()
    };
    let row = |s: [f64; 4]| creases(&[(10, 11, s[0]), (11, 12, s[1]), (12, 13, s[2]), (13, 14, s[3])]);
    let grid4 = grid(4, 4);
    let (fan5, fan6) = (fan(String::new(), 5, true, 2), fan(String::new(), 6, true, 2));
    // Spoke s of a fan with two rings starts with vertices 1 + 2 s and 2 + 2 s.
    let spoke = |s: u32, sharpness: f64| [(0, 1 + 2 * s, sharpness), (1 + 2 * s, 2 + 2 * s, sharpness)];
    let spokes = |list: &[(u32, f64)]| creases(&list.iter().flat_map(|&(s, k)| spoke(s, k)).collect::<Vec<_>>());
    let mut shapes = vec![
        grid4.tagged("single crease, integer", row([2.0; 4])),
        grid4.tagged("single crease, fraction", row([1.7; 4])),
        grid4.tagged("single crease below one", row([0.3; 4])),
        grid4.tagged("single crease, infinite", row([10.0; 4])),
        grid4.tagged("single crease, just finite", row([9.5; 4])),
        grid4.tagged("crease of varying sharpness", row([0.5, 1.25, 2.5, 3.0])),
        grid4.tagged("crease that ends inside", creases(&[(10, 11, 2.5), (11, 12, 2.5)])),
        grid4.tagged("crease that turns", creases(&[(10, 11, 1.5), (11, 12, 1.5), (12, 17, 1.5), (17, 22, 1.5)])),
        grid4.tagged("crossing creases", {
            let mut tags = row([1.5; 4]);
            tags.creases.extend([(2, 7), (7, 12), (12, 17), (17, 22)].map(|(a, b)| Crease::new(a, b, 3.25)));
            tags
        }),
        grid4.tagged("Chaikin creasing", {
            let mut tags = row([4.0, 1.0, 2.5, 3.0]);
            tags.creases.push(Crease::new(12, 17, 1.5));
            tags.rules.creasing = Creasing::Chaikin;
            tags
        }),
        grid4.tagged(
            "corners",
            Tags { corners: vec![Corner::new(6, 1.5), Corner::new(12, 10.0), Corner::new(18, 0.4)], ..Tags::default() },
        ),
        grid4.tagged("holes", Tags { holes: vec![5, 6, 15], ..Tags::default() }),
        grid4.tagged("boundary none", Tags { rules: rules(Boundary::None), ..Tags::default() }),
        grid4.tagged("boundary edge-only", Tags { rules: rules(Boundary::EdgeOnly), ..Tags::default() }),
        grid(1, 1).tagged("one face, edge-only", Tags { rules: rules(Boundary::EdgeOnly), ..Tags::default() }),
        fan5.tagged("dart of valence 5", spokes(&[(0, 10.0)])),
        fan5.tagged("semi-sharp dart of valence 5", spokes(&[(0, 2.5)])),
        fan6.tagged("crease through valence 6", spokes(&[(0, 10.0), (2, 10.0)])),
        fan6.tagged("semi-sharp crease through valence 6", spokes(&[(0, 1.75), (3, 1.75)])),
        fan6.tagged("corner of three creases", spokes(&[(0, 10.0), (2, 10.0), (3, 2.5)])),
        fan5.tagged("pinned interior vertex", Tags { corners: vec![Corner::new(0, 10.0)], ..Tags::default() }),
        fan5.tagged("pinned vertex with one crease", {
            let mut tags = spokes(&[(0, 10.0)]);
            tags.corners.push(Corner::new(0, 10.0));
            tags
        }),
        three_sheets().tagged("three sheets with a crease across", creases(&[(1, 4, 1.5), (4, 7, 1.5)])),
        cone(6).tagged(
            "smoothed triangles",
            Tags { rules: Rules { triangles: Triangles::Smooth, ..Rules::default() }, ..Tags::default() },
        ),
    ];
    let cube_edges = [(0, 1), (1, 3), (3, 2), (2, 0), (4, 5), (5, 7), (7, 6), (6, 4), (0, 4), (1, 5), (2, 6), (3, 7)];
    shapes.push(cube().tagged("cube with all edges semi-sharp", creases(&cube_edges.map(|(a, b)| (a, b, 2.25)))));
    shapes
}
