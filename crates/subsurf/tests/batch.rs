//! Many locations at once: every sample's row is what single evaluation gives, with the same bits in any company.

mod random_mesh;

use random_mesh::{Mesh, for_all, recipe, triangle_recipe};
use subsurf::{ControlMesh, Exceptional, Location, PatchTable, Real, Scheme, shapes};

type Law = fn(&PatchTable, &[[f64; 3]], &[Location]) -> Result<(), String>;

/// Checks a law on all shapes and on random meshes, under all schemes.
fn everywhere(law: Law) {
    let check = |mesh: &ControlMesh, scheme, points: &[[f64; 3]], at: &[Location]| {
        law(&PatchTable::new(mesh, scheme).unwrap(), points, at).map_err(|e| format!("{scheme:?}: {e}"))
    };
    for (shape, scheme) in (shapes::all().into_iter())
        .flat_map(|shape| [(shape.clone(), Scheme::CatmullClark), (shape, Scheme::Bilinear)])
        .chain(shapes::all_triangles().into_iter().map(|shape| (shape, Scheme::Loop)))
    {
        let at = locations(&shape.mesh, scheme);
        check(&shape.mesh, scheme, &shape.positions, &at).unwrap_or_else(|e| panic!("{}: {e}", shape.name));
    }
    for_all(recipe(), 40, 5, |recipe| {
        let Mesh { mesh, positions } = recipe.mesh();
        let mut at = locations(&mesh, Scheme::CatmullClark);
        at.extend(recipe.locations(&mesh));
        check(&mesh, Scheme::CatmullClark, &positions, &at)
    });
    for_all(triangle_recipe(), 40, 6, |recipe| {
        let Mesh { mesh, positions } = recipe.mesh();
        check(&mesh, Scheme::Loop, &positions, &locations(&mesh, Scheme::Loop))
    });
}

/// Locations of up to sixty faces, several on each, the deep ones among them.
fn locations(mesh: &ControlMesh, scheme: Scheme) -> Vec<Location> {
    const PLACES: [(f64, f64); 12] = [
        (0.0, 0.0),
        (0.3, 0.6),
        (0.31, 0.62),
        (1.0, 0.0),
        (0.001, 0.0003),
        (1e-7, 3e-7),
        (0.5, 0.5),
        (0.0, 0.7),
        (0.1, 0.8),
        (0.0, 1.0),
        (0.05, 0.01),
        (0.01, 0.97),
    ];
    let step = 1 + mesh.face_count() / 60;
    let mut at = Vec::new();
    for face in (0..mesh.face_count()).step_by(step) {
        let sides = mesh.face_vertices(face).len();
        for subface in 0..if sides == 4 || scheme == Scheme::Loop { 1 } else { sides as u32 } {
            at.extend(PLACES.iter().map(|&(u, v)| Location { subface, ..Location::new(face as u32, u, v) }));
        }
    }
    at
}

fn rows<T: Real, const R: usize>(
    table: &PatchTable,
    points: &[[T; 3]],
    at: &[Location],
) -> (Vec<[[T; 3]; R]>, Vec<Exceptional>) {
    let mut rows = vec![[[T::default(); 3]; R]; at.len()];
    let exceptional = table.surface(points).eval_into(at, &mut rows);
    (rows, exceptional)
}

fn single(points: &[[f64; 3]]) -> Vec<[f32; 3]> {
    points.iter().map(|p| p.map(|x| x as f32)).collect()
}

fn require(ok: bool, what: impl Fn() -> String) -> Result<(), String> {
    if ok { Ok(()) } else { Err(what()) }
}

#[test]
fn rows_of_doubles_are_the_jets_and_exceptions_are_special_vertices_and_holes() {
    everywhere(|table, points, at| {
        let surface = table.surface(points);
        let (all, exceptional) = rows::<f64, 6>(table, points, at);
        let (first, fewer) = rows::<f64, 3>(table, points, at);
        let jets: Vec<_> = at.iter().map(|&at| surface.eval_second(at)).collect();
        require(surface.eval_many(at) == jets, || "many jets differ from single ones".into())?;
        let on_singles = single(points);
        let surface_of_singles = table.surface(&on_singles);
        let jets: Vec<_> = at.iter().map(|&at| surface_of_singles.eval_second(at)).collect();
        require(surface_of_singles.eval_many(at) == jets, || "many jets of singles differ from single ones".into())?;
        let (positions, fewest) = rows::<f64, 1>(table, points, at);
        require(exceptional == fewer && fewer == fewest, || "exceptions depend on the orders".into())?;
        let mut expected = Vec::new();
        for (sample, &at) in at.iter().enumerate() {
            let Some(jet) = surface.eval_second(at) else {
                expected.push(Exceptional { sample, derivatives: None });
                require(all[sample] == [[0.0; 3]; 6], || format!("{at:?} lies in a hole"))?;
                continue;
            };
            if jet.second.is_none() {
                expected.push(Exceptional { sample, derivatives: Some(jet.derivatives) });
            }
            let [uu, uv, vv] = jet.second.unwrap_or_default();
            let row = [jet.position, jet.du, jet.dv, uu, uv, vv];
            require(all[sample] == row, || format!("{at:?}: {:?} {row:?}", all[sample]))?;
            require(first[sample] == row[..3], || format!("{at:?}: first derivatives"))?;
            require(positions[sample] == row[..1], || format!("{at:?}: position"))?;
        }
        require(exceptional == expected, || format!("{exceptional:?}, expected {expected:?}"))
    });
}

#[test]
fn company_order_and_threads_change_no_bit() {
    everywhere(|table, points, at| {
        let points = single(points);
        let (all, _) = rows::<f32, 3>(table, &points, at);
        // A stride that is prime to the length visits all samples, neighbours far apart.
        let stride = (1..).map(|k| 37 * k + 1).find(|&s| gcd(s, at.len()) == 1).unwrap();
        let order: Vec<usize> = (0..at.len()).map(|i| i * stride % at.len()).collect();
        let shuffled: Vec<Location> = order.iter().map(|&i| at[i]).collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let (rows, exceptional) = pool.install(|| rows::<f32, 3>(table, &points, &shuffled));
        let is_sorted = exceptional.is_sorted_by_key(|e| e.sample);
        require(is_sorted, || "exceptions come in order".into())?;
        for (k, &i) in order.iter().enumerate() {
            require(rows[k] == all[i], || format!("{:?}: {:?} {:?}", at[i], rows[k], all[i]))?;
        }
        let surface = table.surface(&points);
        for i in (0..at.len()).step_by(7) {
            let mut alone = [[[0.0; 3]; 3]];
            surface.eval_into(&at[i..=i], &mut alone);
            require(alone[0] == all[i], || format!("{:?} alone: {:?} {:?}", at[i], alone[0], all[i]))?;
            let Some(mut patch) = surface.patch(at[i].face, at[i].subface) else { continue };
            let mut by_patch = [[[0.0; 3]; 3]; 2];
            patch.eval_into(&[[0.2, 0.1], [at[i].u, at[i].v]], &mut by_patch);
            require(by_patch[1] == all[i], || format!("{:?} by its patch: {:?} {:?}", at[i], by_patch[1], all[i]))?;
        }
        Ok(())
    });
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[test]
fn large_batches_in_random_order_have_the_bits_of_ordered_ones() {
    // More than one chunk, and enough samples that patches are brought together.
    let shape = shapes::interior_vertex(5);
    let table = PatchTable::new(&shape.mesh, Scheme::CatmullClark).unwrap();
    let points = single(&shape.positions);
    let faces = shape.mesh.face_count() as u32;
    let at: Vec<Location> = (0..20_000u32)
        .map(|i| Location::new(i * 7919 % faces, f64::from(i % 97) / 96.0, f64::from(i % 89) / 88.0))
        .collect();
    let mut sorted = at.clone();
    sorted.sort_by_key(|at| at.face);
    let mut order: Vec<usize> = (0..at.len()).collect();
    order.sort_by_key(|&i| at[i].face);
    let (random, _) = rows::<f32, 6>(&table, &points, &at);
    let (ordered, _) = rows::<f32, 6>(&table, &points, &sorted);
    order.iter().zip(&ordered).for_each(|(&i, row)| assert_eq!(*row, random[i]));
}

#[test]
fn components_know_nothing_of_each_other() {
    fn check<const N: usize>(table: &PatchTable, points: &[[f64; 3]], at: &[Location]) -> Result<(), String> {
        let many: Vec<[f64; N]> = points.iter().map(|p| std::array::from_fn(|c| p[c % 3] * (1.0 + c as f64))).collect();
        let mut all = vec![[[0.0; N]; 6]; at.len()];
        table.surface(&many).eval_into(at, &mut all);
        for c in 0..N {
            let one: Vec<[f64; 1]> = many.iter().map(|p| [p[c]]).collect();
            let mut alone = vec![[[0.0]; 6]; at.len()];
            table.surface(&one).eval_into(at, &mut alone);
            for (i, at) in at.iter().enumerate() {
                let row = all[i].map(|value| [value[c]]);
                require(row == alone[i], || format!("component {c} of {N}, {at:?}: {row:?} {:?}", alone[i]))?;
            }
        }
        Ok(())
    }
    for shape in [shapes::interior_vertex(5), shapes::cube()] {
        let table = PatchTable::new(&shape.mesh, Scheme::CatmullClark).unwrap();
        let at = locations(&shape.mesh, Scheme::CatmullClark);
        check::<2>(&table, &shape.positions, &at).unwrap();
        check::<3>(&table, &shape.positions, &at).unwrap();
        check::<4>(&table, &shape.positions, &at).unwrap();
        check::<9>(&table, &shape.positions, &at).unwrap();
    }
}

#[test]
fn single_precision_costs_a_few_ulps_of_the_ring() {
    everywhere(|table, points, at| {
        let points = single(points);
        // What the same control points give with sums in f64.
        let exact: Vec<[f64; 3]> = points.iter().map(|p| p.map(f64::from)).collect();
        let surface = table.surface(&exact);
        let extent = points.iter().flatten().fold(0f64, |m, x| m.max(f64::from(x.abs())));
        let (rows, exceptional) = rows::<f32, 3>(table, &points, at);
        for (i, (&at, row)) in at.iter().zip(&rows).enumerate() {
            if exceptional.iter().any(|e| e.sample == i) {
                continue;
            }
            let jet = surface.eval(at).unwrap();
            // Weights of derivatives grow towards special vertices by less than 2 per depth.
            let depth = (1.0 / at.u.max(at.v).max(1e-9)).max(1.0);
            for (row, (jet, scale)) in row.iter().zip([(jet.position, 1.0), (jet.du, depth), (jet.dv, depth)]) {
                for c in 0..3 {
                    let error = (f64::from(row[c]) - jet[c]).abs();
                    let most = 16.0 * f64::from(f32::EPSILON) * extent * scale.min(64.0);
                    require(error <= most, || format!("{at:?}: {row:?} {jet:?}"))?;
                }
            }
        }
        Ok(())
    });
}

#[test]
fn matrices_are_made_once_for_all_faces_of_a_plan() {
    let per_face: Vec<[f64; 2]> =
        (0..49).map(|k| [f64::from(k % 7) / 7.0 + 0.05, f64::from(k / 7) / 7.0 + 0.05]).collect();
    let all = |mesh: &ControlMesh| -> Vec<Location> {
        (0..mesh.face_count() as u32)
            .flat_map(|face| per_face.iter().map(move |&[u, v]| Location::new(face, u, v)))
            .collect()
    };
    // Quads round one vertex of valence 5, plain ones and boundaries.
    let shape = shapes::interior_vertex(5);
    let table = PatchTable::new(&shape.mesh, Scheme::CatmullClark).unwrap();
    let at = all(&shape.mesh);
    let before = table.evaluation_size();
    rows::<f64, 3>(&table, &shape.positions, &at);
    let after = table.evaluation_size();
    assert_eq!((before.matrices, before.bytes), (0, 0));
    // A piece of every plan at least.
    assert!(after.search_bytes >= before.search_bytes + 64 * table.size().plans, "{before:?} {after:?}");
    // A plan is one piece, or has three for every depth: seven rows of samples reach down to 0.05, so to depth 4.
    assert!(after.matrices <= 15 * table.size().plans, "{after:?}");
    rows::<f64, 6>(&table, &shape.positions, &at);
    table.surface(&shape.positions).eval_many(&at);
    assert_eq!(table.evaluation_size(), after, "nothing is made twice");
    rows::<f32, 3>(&table, &single(&shape.positions), &at);
    assert_eq!(table.evaluation_size().matrices, 2 * after.matrices, "once more in single precision");
}
