//! Laws of stencil tables: they say what refinement and the limit surface say, on all shapes and on random meshes.

mod every_scheme;
mod random_mesh;

use every_scheme::everywhere;
use subsurf::shapes::{self, Shape};
use subsurf::{
    ControlMesh, Derivatives, Level, LimitStencilOptions, LimitStencilTable, Location, MeshError, Orders, Part,
    PatchTable, Real, Scheme, StencilError, StencilOptions, StencilTable,
};

const PARTS: [Part; 6] = [Part::Position, Part::Du, Part::Dv, Part::Duu, Part::Duv, Part::Dvv];

type Points = Vec<[f64; 3]>;
fn require(ok: bool, what: impl Fn() -> String) -> Result<(), String> {
    if ok { Ok(()) } else { Err(what()) }
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, |most, x| if x > most || x.is_nan() { x } else { most })
}

fn size(a: [f64; 3]) -> f64 {
    apart(a, [0.0; 3])
}

/// Largest coordinate of the control points: the unit of errors.
fn unit(points: &[[f64; 3]]) -> f64 {
    points.iter().map(|&p| size(p)).fold(0.0, f64::max)
}

/// Levels 0 to `depth` with their values.
fn refinements(mesh: &ControlMesh, points: &[[f64; 3]], scheme: Scheme, depth: usize) -> Vec<(Level, Points)> {
    let mut levels = vec![(Level::new(mesh, scheme).unwrap(), points.to_vec())];
    for k in 0..depth {
        let next = (levels[k].0.refine().unwrap(), levels[k].0.refine_values(&levels[k].1));
        levels.push(next);
    }
    levels
}

/// Deep enough for the rules of sharpness up to 2.5 to change on the way, but no deeper on larger meshes.
fn depth_for(mesh: &ControlMesh) -> usize {
    if mesh.face_count() < 40 { 4 } else { 2 }
}

#[test]
fn stencils_of_a_level_are_refinement() {
    everywhere(60, 23, |mesh, points, scheme| {
        let levels = refinements(mesh, points, scheme, depth_for(mesh));
        for (depth, (level, values)) in levels.iter().enumerate() {
            let table = StencilTable::<f64>::new(&levels[0].0, depth as u32).unwrap();
            require(table.len() == level.topology().vertex_count(), || format!("{} rows", table.len()))?;
            for (v, (&a, &b)) in table.apply(points).iter().zip(values).enumerate() {
                // Each of four levels adds up to a hundred terms, which sum to the unit, with 1e-16 each; they average.
                let error = apart(a, b) / unit(points);
                require(error < 1e-14, || format!("level {depth} vertex {v}: {error:.1e} from refinement"))?;
            }
        }
        Ok(())
    });
}

#[test]
fn any_level_may_hold_the_control_points() {
    everywhere(10, 23, |mesh, points, scheme| {
        let (levels, values): (Vec<_>, Vec<_>) = refinements(mesh, points, scheme, 3).into_iter().unzip();
        let options = StencilOptions::default();
        let from_one = StencilTable::<f64>::new(&levels[1], 2).unwrap();
        require(from_one == StencilTable::of_levels(&levels[1..], &options).unwrap(), || "levels at hand".to_owned())?;
        let same = StencilTable::<f64>::of_levels(&levels[3..], &options).unwrap().apply(&values[3]);
        require(same == values[3], || "a level over itself".to_owned())?;
        for (a, b) in from_one.apply(&values[1]).iter().zip(&values[3]) {
            // As above.
            let error = apart(*a, *b) / unit(points);
            require(error < 1e-14, || format!("{error:.1e} from refinement"))?;
        }
        Ok(())
    });
}

#[test]
fn stencils_of_all_levels_are_those_of_each_one_after_another() {
    everywhere(10, 23, |mesh, points, scheme| {
        let control = Level::new(mesh, scheme).unwrap();
        let options = StencilOptions { all_levels: true, ..StencilOptions::default() };
        let all = StencilTable::<f64>::with_options(&control, 3, &options).unwrap();
        let mut start = 0;
        for depth in 1..4 {
            let one = StencilTable::<f64>::new(&control, depth).unwrap();
            for row in 0..one.len() {
                let error = || format!("level {depth} vertex {row}");
                require(all.row(start + row).0 == one.row(row).0, error)?;
                // The same sums, in the order in which face points happen to be asked for.
                let (a, b) = (all.row(start + row).1, one.row(row).1);
                require(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15), error)?;
            }
            start += one.len();
        }
        require(all.len() == start && all.control_points() == points.len(), || format!("{} rows", all.len()))
    });
}

#[test]
fn rows_ascend_without_zeros_and_sum_to_one() {
    everywhere(30, 23, |mesh, _, scheme| {
        let table = StencilTable::<f64>::new(&Level::new(mesh, scheme).unwrap(), 2).unwrap();
        for row in 0..table.len() {
            let (points, weights) = table.row(row);
            require(points.windows(2).all(|w| w[0] < w[1]), || format!("row {row}: {points:?}"))?;
            // Masks have no negative weights, so nothing cancels.
            require(weights.iter().all(|&w| w > 0.0), || format!("row {row}: {weights:?}"))?;
            let sum: f64 = weights.iter().sum();
            // A hundred terms of 1e-16, twice.
            require((sum - 1.0).abs() < 2e-14, || format!("row {row} sums to 1 + {:.1e}", sum - 1.0))?;
        }
        Ok(())
    });
}

/// The places that matter on every patch: corners, sides, inside, and deep at a corner.
fn places(patches: &PatchTable, scheme: Scheme) -> Vec<Location> {
    const PLACES: [(f64, f64); 8] =
        [(0.0, 0.0), (0.3, 0.6), (1.0, 0.0), (1e-7, 3e-7), (0.5, 0.5), (0.0, 0.7), (0.1, 0.8999), (0.0, 1.0)];
    let mut at = Vec::new();
    let faces = patches.topology().face_count();
    for face in (0..faces as u32).step_by(1 + faces / 60) {
        for subface in 0..patches.subfaces(face.into()) {
            at.extend(PLACES.map(|(u, v)| Location { face: face.into(), subface, u, v }));
            if scheme != Scheme::Loop {
                at.push(Location { face: face.into(), subface, u: 1.0, v: 1.0 });
            }
        }
    }
    at
}

/// Rounding of a row whose weights are at most 1 in size: a few units of 1e-16, twice as large with each level that a
/// leaf lies below its face and each differentiation. Sharpness up to 10 makes leaves 12 levels down.
fn rounding(part: Part) -> f64 {
    let order = match part {
        Part::Position => 0,
        Part::Du | Part::Dv => 1,
        _ => 2,
    };
    1e-15 * 2f64.powi(12 * order)
}

fn with_orders(orders: Orders) -> LimitStencilOptions {
    LimitStencilOptions { orders, ..LimitStencilOptions::default() }
}

#[test]
fn limit_stencils_are_jets() {
    everywhere(40, 23, |mesh, points, scheme| {
        let patches = PatchTable::new(mesh, scheme).unwrap();
        let at = places(&patches, scheme);
        let table = LimitStencilTable::<f64>::with_options(&patches, &at, &with_orders(Orders::Second)).unwrap();
        let (first, second) = (table.frames(points), table.second_derivatives(points));
        for (i, &at) in at.iter().enumerate() {
            let Some(jet) = patches.surface(points).eval_second(at) else {
                let empty = first[i] == [[0.0; 3]; 3] && table.derivatives(i).is_none() && !table.has_second(i);
                require(empty, || format!("{at:?} lies in a hole: {:?}", first[i]))?;
                continue;
            };
            require(table.derivatives(i) == Some(jet.derivatives), || format!("{at:?}: {:?}", table.derivatives(i)))?;
            require(table.has_second(i) == jet.second.is_some(), || format!("{at:?}: second derivatives"))?;
            let directions = jet.plane.filter(|_| jet.derivatives != Derivatives::Finite);
            let [du, dv] = directions.unwrap_or([jet.du, jet.dv]);
            let mut pairs = vec![(first[i][0], jet.position), (first[i][1], du), (first[i][2], dv)];
            if let Some(dd) = jet.second {
                (0..3).for_each(|k| pairs.push((second[i][k], dd[k])));
            }
            for (&(a, b), part) in pairs.iter().zip(PARTS) {
                // The same weights, summed from another point in another order: up to a hundred terms, which average.
                let range = table.offsets()[i] as usize..table.offsets()[i + 1] as usize;
                let weights: f64 = table.weights(part)[range].iter().map(|w| w.abs()).sum();
                let error = apart(a, b) / (unit(points) * weights.max(1.0));
                require(error < 10.0 * rounding(part), || format!("{at:?} {part:?}: off by {error:.1e}"))?;
            }
        }
        Ok(())
    });
}

#[test]
fn limit_weights_sum_to_one_and_those_of_derivatives_to_zero() {
    everywhere(20, 23, |mesh, points, scheme| {
        let patches = PatchTable::new(mesh, scheme).unwrap();
        let at = places(&patches, scheme);
        let table = LimitStencilTable::<f64>::with_options(&patches, &at, &with_orders(Orders::Second)).unwrap();
        for row in (0..table.len()).filter(|&row| table.derivatives(row).is_some()) {
            let range = table.offsets()[row] as usize..table.offsets()[row + 1] as usize;
            for part in PARTS {
                let weights = &table.weights(part)[range.clone()];
                let (sum, large) = weights.iter().fold((0.0, 0.0), |(s, l), &w| (s + w, l + f64::abs(w)));
                let expected = if part == Part::Position { 1.0 } else { 0.0 };
                let error = (sum - expected) / f64::max(1.0, large);
                require(error.abs() < 10.0 * rounding(part), || format!("{:?} {part:?}: off by {error:.1e}", at[row]))?;
            }
        }
        let constant = vec![[0.1, -7.3, 1e9]; points.len()];
        let zero = table.first_derivatives(&constant).into_iter().flatten().flatten().all(|x| x == 0.0);
        require(zero, || "a constant has derivatives".to_owned())
    });
}

#[test]
fn limits_of_a_level_are_those_of_the_surface() {
    everywhere(20, 23, |mesh, points, scheme| {
        let patches = PatchTable::new(mesh, scheme).unwrap();
        for (depth, (level, values)) in refinements(mesh, points, scheme, 2).iter().enumerate() {
            let expected = patches.surface(points).limit_of_level(level, values);
            let table = LimitStencilTable::<f64>::of_level(&patches, level, &LimitStencilOptions::default()).unwrap();
            for (v, (&a, &b)) in table.positions(points).iter().zip(&expected).enumerate() {
                // As for refinement.
                let error = apart(a, b) / unit(points);
                require(error < 1e-14, || format!("level {depth} vertex {v}: off by {error:.1e}"))?;
            }
        }
        Ok(())
    });
}

#[test]
fn partial_updates_have_the_bits_of_a_full_one() {
    everywhere(20, 23, |mesh, points, scheme| {
        let table = StencilTable::<f64>::new(&Level::new(mesh, scheme).unwrap(), 2).unwrap();
        let patches = PatchTable::new(mesh, scheme).unwrap();
        let limit = LimitStencilTable::<f32>::new(&patches, &places(&patches, scheme)).unwrap();
        let (index, limit_index) = (table.dependents(), limit.dependents());
        let mut moved = points.to_vec();
        let mut out = table.apply(points);
        let (mut positions, mut frames) = (limit.positions(points), limit.frames(points));
        let last = points.len() as u32 - 1;
        for changed in [vec![], vec![last], vec![0, last / 2, 0], (0..=last).collect()] {
            changed.iter().for_each(|&v| moved[v as usize][v as usize % 3] += 0.25);
            let rows = table.update(&index, &moved, &changed, &mut out);
            require(out == table.apply(&moved), || format!("after {changed:?}"))?;
            let depends = |row: &usize| table.row(*row).0.iter().any(|p| changed.contains(p));
            let expected: Vec<u32> = (0..table.len()).filter(depends).map(|row| row as u32).collect();
            require(rows == expected, || format!("{rows:?} for {expected:?}"))?;
            limit.update_positions(&limit_index, &moved, &changed, &mut positions);
            limit.update_frames(&limit_index, &moved, &changed, &mut frames);
            require(positions == limit.positions(&moved), || format!("limit after {changed:?}"))?;
            require(frames == limit.frames(&moved), || format!("frames after {changed:?}"))?;
        }
        Ok(())
    });
}

#[test]
fn single_precision_is_double_precision_rounded() {
    everywhere(20, 23, |mesh, points, scheme| {
        let level = Level::new(mesh, scheme).unwrap();
        let (a, b) = (StencilTable::<f64>::new(&level, 2).unwrap(), StencilTable::<f32>::new(&level, 2).unwrap());
        require(a.offsets() == b.offsets() && a.indices() == b.indices(), || "structure".to_owned())?;
        require(a.weights().iter().zip(b.weights()).all(|(&a, &b)| f32::from_f64(a) == b), || "weights".to_owned())?;
        // A weight is off by 2^-24 of itself, and weights sum to one; far from the origin that costs nothing.
        let far: Points = points.iter().map(|p| p.map(|x| x + 1e6)).collect();
        for (a, b) in a.apply(&far).iter().zip(b.apply(&far)) {
            let error = apart(*a, b) / (2.0 * unit(points));
            // The last place of 1e6 beside it.
            require(error < 6e-8 + 1e-9, || format!("values differ by {error:.1e}"))?;
        }
        Ok(())
    });
}

/// Half a unit in the last place of 1 in `f32`.
const HALF_UNIT: f64 = 1.0 / (1 << 24) as f64;

#[test]
fn sums_in_single_precision_lose_what_a_row_is_wide_and_nothing_far_from_the_origin() {
    everywhere(20, 23, |mesh, points, scheme| {
        let level = Level::new(mesh, scheme).unwrap();
        let (exact, table) =
            (StencilTable::<f64>::new(&level, 2).unwrap(), StencilTable::<f32>::new(&level, 2).unwrap());
        for away in [0.0, 1000.0] {
            let single: Vec<[f32; 3]> = points.iter().map(|p| p.map(|x| (x + away) as f32)).collect();
            let double: Points = single.iter().map(|p| p.map(f64::from)).collect();
            for (row, (a, b)) in exact.apply(&double).iter().zip(table.apply(&single)).enumerate() {
                let indices = table.row(row).0;
                let first = double[indices[0] as usize];
                let width = indices.iter().map(|&p| apart(double[p as usize], first)).fold(0.0, f64::max);
                let error = apart(*a, b.map(f64::from));
                // Of a term: its weight, its difference and their product; then the sum of all, of which one is zero. Weights
                // sum to one. A result lies within one width of the first point.
                let bound = HALF_UNIT * ((indices.len() + 4) as f64 * width + size(*a));
                require(error <= bound, || format!("row {row}, {away} away: off by {error:.1e} of {bound:.1e}"))?;
            }
        }
        let constant = vec![[0.1f32, -7.3, 1e9]; points.len()];
        require(table.apply(&constant).iter().all(|p| *p == constant[0]), || "a constant changes".to_owned())
    });
}

#[test]
fn tables_and_values_have_the_same_bits_on_any_number_of_threads() {
    let shape = shapes::grid(60, 50);
    let work = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let level = Level::new(&shape.mesh, Scheme::CatmullClark).unwrap();
            let table = StencilTable::<f32>::new(&level, 2).unwrap();
            let patches = PatchTable::new(&shape.mesh, Scheme::CatmullClark).unwrap();
            let fine = level.refine().unwrap();
            let limit = LimitStencilTable::<f64>::of_level(&patches, &fine, &LimitStencilOptions::default()).unwrap();
            let (mut points, frames) = (table.apply(&shape.positions), limit.frames(&shape.positions));
            let lower: Points = shape.positions.iter().map(|&[x, y, z]| [x, y, z - 1.0]).collect();
            let all: Vec<u32> = (0..lower.len() as u32).collect();
            assert_eq!(table.update(&table.dependents(), &lower, &all, &mut points).len(), points.len());
            assert!(points == table.apply(&lower), "a large update is a full one");
            (table, points, limit, frames)
        })
    };
    let one = work(1);
    for threads in [2, 7] {
        assert!(one == work(threads), "{threads} threads");
    }
}

#[test]
fn what_would_not_fit_is_refused_before_it_is_made() {
    let pole: Shape = shapes::interior_vertex(2_000);
    let level = Level::new(&pole.mesh, Scheme::CatmullClark).unwrap();
    let refuse = |depth: u32, most_weights: usize| {
        let options = StencilOptions { all_levels: depth % 2 == 1, most_weights };
        StencilTable::<f32>::with_options(&level, depth, &options).unwrap_err()
    };
    for depth in [6, 7, 31, u32::MAX] {
        let error = refuse(depth, usize::MAX);
        assert!(matches!(error, StencilError::TooLarge { .. }), "{error}");
        assert!(error.to_string().contains("use fewer levels"), "{error}");
    }
    assert!(matches!(refuse(1, 1000), StencilError::TooLarge { limit: 1000, .. }));
    let pole = Level::new(&shapes::interior_vertex(20_000).mesh, Scheme::CatmullClark).unwrap();
    let error = StencilTable::<f32>::new(&pole, 1).unwrap_err();
    assert!(matches!(error, StencilError::Mesh(MeshError::TooLarge { .. })), "{error}");

    let small = shapes::cube();
    let patches = PatchTable::new(&small.mesh, Scheme::CatmullClark).unwrap();
    let options = LimitStencilOptions { most_weights: 7, ..LimitStencilOptions::default() };
    let error = LimitStencilTable::<f32>::with_options(&patches, &[Location::new(0, 0.5, 0.5)], &options).unwrap_err();
    assert!(matches!(error, StencilError::TooLarge { count: 8, limit: 7, .. }), "{error}");
}
