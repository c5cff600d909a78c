//! Laws of uniform refinement in one step: it says what refinement level by level says, on all shapes and on random meshes.

mod every_scheme;
mod random_mesh;

use every_scheme::everywhere;
use subsurf::shapes;
use subsurf::{
    Channel, ControlMesh, Corner, Crease, Creasing, Face, FaceVarying, Level, Real, Scheme, Tags, UniformRefinement,
};

/// So many copies of a mesh side by side: groups of faces have as many members each, which makes trees pay at any depth.
fn copies(mesh: &ControlMesh, points: &[[f64; 3]], count: u32) -> (ControlMesh, Vec<[f64; 3]>) {
    let vertices = mesh.vertex_count() as u32;
    let moved = |v: u32| (0..count).map(move |k| v + k * vertices);
    let sizes: Vec<u32> = mesh.faces().map(|f| f.len() as u32).collect();
    let corners = (0..count).flat_map(|k| mesh.corners().iter().map(move |&v| v + k * vertices)).collect();
    let tags = mesh.tags();
    let crease = |c: &Crease| {
        moved(0).map(|d| Crease::new(c.vertices[0] + d, c.vertices[1] + d, c.sharpness)).collect::<Vec<_>>()
    };
    let corner = |c: &Corner| moved(c.vertex).map(|v| Corner::new(v, c.sharpness)).collect::<Vec<_>>();
    let tags = Tags {
        creases: tags.creases.iter().flat_map(crease).collect(),
        corners: tags.corners.iter().flat_map(corner).collect(),
        holes: Vec::new(),
        rules: tags.rules,
    };
    let copy =
        ControlMesh::from_counts(mesh.vertex_count() * count as usize, &sizes.repeat(count as usize), corners, tags);
    (copy.unwrap(), points.repeat(count as usize))
}

fn require(ok: bool, what: impl Fn() -> String) -> Result<(), String> {
    if ok { Ok(()) } else { Err(what()) }
}

/// Deep enough for every kind of tile, but no deeper on larger meshes.
fn depth_for(mesh: &ControlMesh) -> u32 {
    if mesh.face_count() < 40 { 4 } else { 2 }
}

/// Faces as those of levels, and values as theirs up to `error` times the largest one.
fn check<T: Real, const N: usize>(control: &Level, values: &[[T; N]], depth: u32, error: f64) -> Result<(), String> {
    let refinement = UniformRefinement::from_topology(control.topology().clone(), control.scheme(), depth).unwrap();
    let (mut level, mut expected) = (control.clone(), values.iter().map(|v| v.map(T::to_f64)).collect::<Vec<_>>());
    let mut parent: Vec<u32> = (0..control.topology().face_count() as u32).collect();
    let unit = expected.iter().flatten().fold(0.0, |unit, x| f64::max(unit, x.abs()));
    for _ in 0..depth {
        parent = level.refine_face_values(&parent);
        expected = level.refine_values(&expected);
        level = level.refine().unwrap();
    }
    let t = level.topology();
    let counts = [refinement.vertex_count(), refinement.edge_count(), refinement.face_count()];
    require(counts == [t.vertex_count(), t.edge_count(), t.face_count()], || format!("depth {depth}: {counts:?}"))?;
    require(refinement.corners() == t.corners(), || format!("depth {depth}: faces"))?;
    require(refinement.face_offsets() == t.face_offsets(), || format!("depth {depth}: sizes of faces"))?;
    let same_parents = parent.iter().enumerate().all(|(f, &p)| refinement.control_face(Face::new(f)) == Face(p));
    require(same_parents, || format!("depth {depth}: control faces"))?;
    let refined = refinement.refine(values);
    for (v, (a, b)) in refined.iter().zip(&expected).enumerate() {
        let is_near = (0..N).all(|c| (a[c].to_f64() - b[c]).abs() / unit < error);
        require(is_near, || format!("depth {depth} vertex {v}: {a:?} and by levels {b:?}"))?;
    }
    // From the second time on tables are used that the first one does not make.
    require(refinement.refine(values) == refined, || format!("depth {depth}: other bits the second time"))
}

#[test]
fn one_step_is_refinement_level_by_level() {
    everywhere(60, 31, |mesh, points, scheme| {
        let control = Level::new(mesh, scheme).unwrap();
        for depth in 0..=depth_for(mesh) {
            // Each of four levels adds up to a hundred terms, which sum to the unit, with 1e-16 each; they average.
            check(&control, points, depth, 1e-14)?;
            // Three sums of some twenty terms with 6e-8 each, relative to a point as far away as twice the unit.
            let single: Vec<[f32; 3]> = points.iter().map(|p| p.map(|x| x as f32)).collect();
            check(&control, &single, depth, 1e-6)?;
        }
        Ok(())
    });
}

/// The mesh with a rule that averages sharpness along creases, one of which is semi-sharp: then sharpness differs along an edge,
/// and Catmull-Clark takes the trees that Loop always takes.
fn with_averaged_creases(mesh: &ControlMesh) -> ControlMesh {
    let mut tags = mesh.tags().clone();
    tags.rules.creasing = Creasing::Chaikin;
    if !tags.creases.iter().any(|c| c.sharpness > 0.0 && c.sharpness < 10.0) {
        let face = mesh.face_vertices(0);
        tags.creases.push(Crease::new(face[0], face[1], 1.5));
    }
    let sizes: Vec<u32> = mesh.faces().map(|f| f.len() as u32).collect();
    ControlMesh::from_counts(mesh.vertex_count(), &sizes, mesh.corners().to_vec(), tags).unwrap()
}

#[test]
fn trees_of_shared_groups_are_refinement_at_any_depth() {
    everywhere(25, 31, |mesh, points, scheme| {
        let mesh = if scheme == Scheme::CatmullClark { with_averaged_creases(mesh) } else { mesh.clone() };
        // A level has at least twice as many vertices as the control mesh faces.
        let (mesh, points) = copies(&mesh, points, 40);
        for depth in 1..=2 {
            let refinement = UniformRefinement::new(&mesh, scheme, depth).unwrap();
            let size = refinement.size();
            let has_trees = size.nodes >= size.groups && size.groups + size.regular_faces > 0;
            require(has_trees || scheme == Scheme::Bilinear, || format!("{size:?}"))?;
            check(&Level::new(&mesh, scheme).unwrap(), &points, depth, 1e-14)?;
        }
        Ok(())
    });
}

#[test]
fn the_work_of_trees_grows_with_the_kinds_of_faces_and_not_with_their_number() {
    let size = |n: u32, depth: u32| {
        let grid = shapes::grid(n, n).triangulated();
        let refinement = UniformRefinement::new(&grid.mesh, Scheme::Loop, depth).unwrap();
        let (points, faces) = (refinement.refine(&grid.positions), refinement.control().face_count());
        assert_eq!(points.len(), ((n << depth) as usize + 1).pow(2));
        (refinement.size(), faces)
    };
    let ((small, _), (large, faces)) = (size(12, 4), size(40, 4));
    // Corners, sides, what lies next to them, and what lies inside, each in two turns.
    assert_eq!((small.groups, small.nodes), (large.groups, large.nodes));
    assert!(large.groups <= 40, "{large:?}");
    assert_eq!(small.tree_bytes, large.tree_bytes);
    // Twelve points and two numbers for every face.
    assert!(large.ring_bytes <= 4 * 14 * faces + 400, "{large:?}");
    // Below the first two levels nothing new appears: each level has as many nodes as the one before.
    let nodes = |depth: u32| size(12, depth).0.nodes as i64;
    assert_eq!(nodes(7) - nodes(6), nodes(6) - nodes(5));
}

#[test]
fn without_trees_only_what_is_sharp_has_rules_of_its_own() {
    for n in [12, 40] {
        let grid = shapes::grid(n, n);
        for depth in 1..4 {
            let size = UniformRefinement::new(&grid.mesh, Scheme::CatmullClark, depth).unwrap().size();
            // The boundary's vertices at every level; where the first step is made by itself, its edges too.
            let boundary = 4 * n as usize;
            assert_eq!(size.special_points, boundary * (depth as usize).max(2));
            assert_eq!((size.nodes, size.tree_bytes), (0, 0));
            // A number for a vertex and a byte for a half-edge below the first level; less than 200 bytes for a special point.
            let half_edges = 4 * (n * n) as usize;
            assert!(size.ring_bytes <= 4 * half_edges + 200 * size.special_points, "{size:?}");
        }
    }
}

#[test]
fn any_level_may_hold_the_control_points() {
    everywhere(10, 31, |mesh, points, scheme| {
        let control = Level::new(mesh, scheme).unwrap();
        check(&control.refine().unwrap(), &control.refine_values(points), depth_for(mesh) - 1, 1e-14)
    });
}

#[test]
fn channels_are_refined_as_level_by_level() {
    everywhere(10, 31, |mesh, points, scheme| {
        let control = Level::new(mesh, scheme).unwrap();
        let t = control.topology();
        // Seams wherever one of five neighbours disagrees: three values to every vertex.
        let values: Vec<[f64; 2]> =
            (0..3 * points.len()).map(|i| [points[i / 3][0] + (i % 3) as f64, points[i / 3][1]]).collect();
        let corners: Vec<u32> = (0..t.face_count())
            .flat_map(|f| t.face_vertices(Face::new(f)).iter().map(move |&v| 3 * v + (f % 5 / 2) as u32))
            .collect();
        for rule in [FaceVarying::CornersPlus1, FaceVarying::Boundaries, FaceVarying::All] {
            let channel = Channel::face_varying(t, scheme, values.len(), &corners, rule).unwrap();
            check(&channel.level(), &channel.rows(&values), depth_for(mesh), 1e-14)
                .map_err(|e| format!("{rule:?}: {e}"))?;
        }
        check(&Channel::varying(t, scheme).level(), points, depth_for(mesh), 1e-14)
    });
}

#[test]
fn constants_come_out_exactly_and_threads_change_no_bit() {
    everywhere(10, 31, |mesh, points, scheme| {
        let refinement = UniformRefinement::new(mesh, scheme, 3).unwrap();
        let constant = vec![[0.1f32, -7.3, 1e9]; points.len()];
        require(refinement.refine(&constant).iter().all(|v| *v == constant[0]), || "a constant changes".to_owned())?;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let here = refinement.refine(points);
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let there = |pool: &rayon::ThreadPool| {
            pool.install(|| UniformRefinement::new(mesh, scheme, 3).unwrap().refine(points)) == here
        };
        require(there(&pool) && there(&one), || "threads change bits".to_owned())
    });
}

#[test]
fn poles_and_large_polygons_are_refined_too() {
    for shape in [shapes::interior_vertex(70), shapes::cone(300), shapes::cone(40)] {
        let control = Level::new(&shape.mesh, Scheme::CatmullClark).unwrap();
        // More terms, but of masks whose weights are the smaller.
        check(&control, &shape.positions, 3, 1e-14).unwrap_or_else(|e| panic!("{}: {e}", shape.name));
    }
}

#[test]
fn a_large_polygon_may_lie_at_a_pole() {
    // A pole of n faces, the first of them a polygon of more corners than the pole has faces; in the second mesh the pole is
    // the polygon's last corner.
    for (n, last) in [(20u32, false), (20, true), (40, false)] {
        let ring = 3 * n;
        let (start, mut faces) = (ring + 1 - n, Vec::new());
        let rim = |i: u32| 1 + i % ring;
        // The polygon spans the rim from 0 to `start`; triangles the rest.
        let mut polygon: Vec<u32> = std::iter::once(0).chain((0..=start).map(rim)).collect();
        if last {
            polygon.rotate_left(1);
        }
        faces.push(polygon);
        faces.extend((start..ring).map(|i| vec![0, rim(i), rim(i + 1)]));
        assert_eq!(faces.len() as u32, n);
        let counts: Vec<u32> = faces.iter().map(|face| face.len() as u32).collect();
        let mesh = ControlMesh::from_counts(1 + ring as usize, &counts, faces.concat(), Tags::default()).unwrap();
        let points: Vec<[f64; 3]> = (0..=ring).map(f64::from).map(|a| [a.cos(), a.sin(), 0.1 * a % 1.0]).collect();
        let control = Level::new(&mesh, Scheme::CatmullClark).unwrap();
        for depth in [1, 2, 3, 4] {
            check(&control, &points, depth, 1e-14).unwrap_or_else(|e| panic!("{n} faces, {depth} levels: {e}"));
        }
    }
}

#[test]
fn quads_that_start_at_their_control_points_meet_those_beside_other_polygons() {
    let grid = shapes::grid(8, 8);
    let mut faces: Vec<Vec<u32>> = grid.mesh.faces().map(<[u32]>::to_vec).collect();
    let row = |y: usize, s: f64| faces[8 * y..8 * y + 8].iter().map(move |f| Crease::new(f[0], f[1], s));
    let creases = row(2, 1.5).chain(row(4, 10.0)).chain(row(6, 0.4)).collect();
    let tags = Tags { creases, corners: vec![Corner::new(40, 0.7)], ..Tags::default() };
    // Two quads side by side become a hexagon, and another one two triangles.
    let [left, right] = [faces[45].clone(), faces.remove(46)];
    faces[45] = vec![left[0], right[0], right[1], right[2], right[3], left[3]];
    let cut = faces[27].clone();
    faces[27] = cut[..3].to_vec();
    faces.push(vec![cut[2], cut[3], cut[0]]);
    let mesh = ControlMesh::new(&faces, tags).unwrap();
    for scheme in [Scheme::CatmullClark, Scheme::Bilinear] {
        let control = Level::new(&mesh, scheme).unwrap();
        for depth in 1..=4 {
            check(&control, &grid.positions, depth, 1e-14).unwrap_or_else(|e| panic!("{scheme:?}: {e}"));
        }
    }
}

#[test]
fn few_faces_may_go_deep() {
    for shape in shapes::tagged().into_iter().filter(|shape| shape.mesh.face_count() < 12) {
        for scheme in [Scheme::CatmullClark, Scheme::Bilinear] {
            let control = Level::new(&shape.mesh, scheme).unwrap();
            // Six levels of up to a hundred terms, which sum to the unit, with 1e-16 each; they average.
            check(&control, &shape.positions, 6, 1e-14).unwrap_or_else(|e| panic!("{} {scheme:?}: {e}", shape.name));
        }
    }
    // Poles and polygons of some size have no trees.
    let shape = shapes::cone(50);
    let control = Level::new(&shape.mesh, Scheme::CatmullClark).unwrap();
    check(&control, &shape.positions, 6, 1e-14).unwrap_or_else(|e| panic!("{}: {e}", shape.name));
}
