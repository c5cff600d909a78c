//! Points of three numbers, whose work is compiled with the crate, have the bits that rows of other widths have, whose work is
//! compiled here: no function takes another one's place.

mod every_scheme;
mod random_mesh;

use every_scheme::everywhere;
use subsurf::{
    ControlMesh, Jet, Level, LimitStencilOptions, LimitStencilTable, Location, Orders, PatchTable, Rates, Real, Scheme,
    StencilTable, TessellateOptions, UniformRefinement,
};

/// One more component, to be left out of account.
fn wider(rows: &[[f32; 3]]) -> Vec<[f32; 4]> {
    rows.iter().map(|&[x, y, z]| [x, y, z, y]).collect()
}

fn first<T: Real, const N: usize, const M: usize>(rows: &[[T; N]]) -> Vec<[T; M]> {
    rows.iter().map(|row| std::array::from_fn(|k| row[k])).collect()
}

fn same<T: Real, const N: usize, const M: usize>(
    what: &str,
    points: &[[T; N]],
    others: &[[T; M]],
) -> Result<(), String> {
    let agree = points.len() == others.len()
        && points
            .iter()
            .zip(others)
            .all(|(a, b)| (0..N.min(M)).all(|k| a[k].to_f64().to_bits() == b[k].to_f64().to_bits()));
    if agree { Ok(()) } else { Err(format!("{what}: {points:?} {others:?}")) }
}

fn places(table: &PatchTable, mesh: &ControlMesh) -> Vec<Location> {
    const PLACES: [(f64, f64); 5] = [(0.0, 0.0), (0.3, 0.6), (0.001, 0.0003), (0.0, 0.7), (0.1, 0.85)];
    let whole = if table.scheme() == Scheme::Loop { 3 } else { 4 };
    let mut out = Vec::new();
    for face in 0..mesh.face_count().min(40) as u32 {
        let sides = mesh.face_vertices(face as usize).len();
        for subface in 0..if sides == whole { 1 } else { sides as u32 } {
            out.extend(PLACES.iter().map(|&(u, v)| Location { subface, ..Location::new(face, u, v) }));
        }
    }
    out
}

#[test]
fn refinements_are_the_same() {
    fn check(mesh: &ControlMesh, points: &[[f32; 3]], scheme: Scheme) -> Result<(), String> {
        for depth in 1..=3 {
            let refinement = UniformRefinement::new(mesh, scheme, depth).unwrap();
            let (wide, pairs) = (wider(points), first::<_, 3, 2>(points));
            // The second time tables are at hand.
            for frame in 0..2 {
                let refined = refinement.refine(points);
                same(&format!("level {depth}, frame {frame}"), &refined, &refinement.refine(&wide))?;
                same(&format!("level {depth}, frame {frame}, pairs"), &refined, &refinement.refine(&pairs))?;
            }
        }
        Ok(())
    }
    everywhere(6, 31, |mesh, points, scheme| in_single(check, mesh, points, scheme));
}

#[test]
fn evaluations_are_the_same() {
    fn jets<const N: usize, const M: usize>(what: &str, a: Option<Jet<N>>, b: Option<Jet<M>>) -> Result<(), String> {
        let (Some(a), Some(b)) = (&a, &b) else {
            return if a.is_none() && b.is_none() { Ok(()) } else { Err(format!("{what}: {a:?} {b:?}")) };
        };
        let rows = |[position, du, dv]: [&[f64]; 3], second: Option<[&[f64]; 3]>, plane: Option<[&[f64]; 2]>| {
            let all =
                [position, du, dv].into_iter().chain(second.into_iter().flatten()).chain(plane.into_iter().flatten());
            all.flat_map(|row| row[..3].iter().map(|x| x.to_bits())).collect::<Vec<_>>()
        };
        fn slices<const N: usize, const K: usize>(rows: &[[f64; N]; K]) -> [&[f64]; K] {
            rows.each_ref().map(<[f64; N]>::as_slice)
        }
        let of_a = rows([&a.position, &a.du, &a.dv], a.second.as_ref().map(slices), a.plane.as_ref().map(slices));
        let of_b = rows([&b.position, &b.du, &b.dv], b.second.as_ref().map(slices), b.plane.as_ref().map(slices));
        let agree = of_a == of_b && a.derivatives == b.derivatives && a.unique_plane == b.unique_plane;
        if agree { Ok(()) } else { Err(format!("{what}: {a:?} {b:?}")) }
    }
    fn batch<const R: usize>(
        table: &PatchTable,
        (points, wide): (&[[f32; 3]], &[[f32; 4]]),
        at: &[Location],
    ) -> Result<(), String> {
        let (mut rows, mut others) = (vec![[[0.0; 3]; R]; at.len()], vec![[[0.0; 4]; R]; at.len()]);
        let (surface, other) = (table.surface(points), table.surface(wide));
        assert_eq!(surface.eval_into(at, &mut rows), other.eval_into(at, &mut others));
        same(&format!("{R} rows"), rows.as_flattened(), others.as_flattened())?;
        let Some(&Location { face, subface, .. }) = at.first() else { return Ok(()) };
        let (Some(mut patch), Some(mut wide)) = (surface.patch(face, subface), other.patch(face, subface)) else {
            return Ok(());
        };
        let uv = [[0.25, 0.5], [0.0, 0.0], [0.125, 0.01]];
        let (mut rows, mut others) = (vec![[[0.0; 3]; R]; 3], vec![[[0.0; 4]; R]; 3]);
        assert_eq!(patch.eval_into(&uv, &mut rows), wide.eval_into(&uv, &mut others));
        same(&format!("{R} rows of a patch"), rows.as_flattened(), others.as_flattened())
    }
    fn check(mesh: &ControlMesh, points: &[[f32; 3]], scheme: Scheme) -> Result<(), String> {
        let table = PatchTable::new(mesh, scheme).unwrap();
        let (at, wide) = (places(&table, mesh), wider(points));
        let (surface, other) = (table.surface(points), table.surface(&wide));
        batch::<1>(&table, (points, &wide), &at)?;
        batch::<3>(&table, (points, &wide), &at)?;
        batch::<6>(&table, (points, &wide), &at)?;
        let (many, others) = (surface.eval_many(&at), other.eval_many(&at));
        for ((&at, a), b) in at.iter().zip(many).zip(others) {
            jets(&format!("many, {at:?}"), a, b)?;
            jets(&format!("{at:?}"), surface.eval(at), other.eval(at))?;
            jets(&format!("second, {at:?}"), surface.eval_second(at), other.eval_second(at))?;
            let positions = [surface.position(at).map(|p| vec![p]), other.position(at).map(|p| first(&[p]))];
            if positions[0] != positions[1] {
                return Err(format!("{at:?}: {positions:?}"));
            }
        }
        Ok(())
    }
    everywhere(6, 31, |mesh, points, scheme| in_single(check, mesh, points, scheme));
}

#[test]
fn stencils_are_the_same() {
    fn apply<W: Real>(mesh: &ControlMesh, points: &[[f32; 3]], scheme: Scheme) -> Result<(), String> {
        let wide = wider(points);
        let level = Level::new(mesh, scheme).unwrap();
        let stencils = StencilTable::<W>::new(&level, 2).unwrap();
        same("stencils", &stencils.apply(points), &stencils.apply(&wide))?;
        // What other rows hold stays.
        let mark = 7.0;
        let (mut out, mut others) = (vec![[mark; 3]; stencils.len()], vec![[mark; 4]; stencils.len()]);
        let dependents = stencils.dependents();
        let moved = stencils.update(&dependents, points, &[0], &mut out);
        stencils.update(&dependents, &wide, &[0], &mut others);
        same("some stencils", &out, &others)?;
        stays(&moved, mark, &out)?;

        let table = PatchTable::new(mesh, scheme).unwrap();
        let options = LimitStencilOptions { orders: Orders::Second, ..LimitStencilOptions::default() };
        let at = places(&table, mesh);
        let limits = LimitStencilTable::<W>::with_options(&table, &at, &options).unwrap();
        same("limits", &limits.positions(points), &limits.positions(&wide))?;
        let [a, b] =
            [limits.first_derivatives(points).as_flattened().to_vec(), limits.frames(points).as_flattened().to_vec()];
        same("first derivatives", &a, limits.first_derivatives(&wide).as_flattened())?;
        same("frames", &b, limits.frames(&wide).as_flattened())?;
        let second = limits.second_derivatives(points);
        same("second derivatives", second.as_flattened(), limits.second_derivatives(&wide).as_flattened())?;
        let dependents = limits.dependents();
        let (mut out, mut others) = (vec![[[mark; 3]; 3]; at.len()], vec![[[mark; 4]; 3]; at.len()]);
        let moved = limits.update_frames(&dependents, points, &[1], &mut out);
        limits.update_frames(&dependents, &wide, &[1], &mut others);
        same("some frames", out.as_flattened(), others.as_flattened())?;
        let firsts: Vec<[f32; 3]> = out.iter().map(|frame| frame[0]).collect();
        stays(&moved, mark, &firsts)?;
        let (mut out, mut others) = (vec![[mark; 3]; at.len()], vec![[mark; 4]; at.len()]);
        let moved = limits.update_positions(&dependents, points, &[1], &mut out);
        limits.update_positions(&dependents, &wide, &[1], &mut others);
        same("some limits", &out, &others)?;
        stays(&moved, mark, &out)
    }
    fn stays(moved: &[u32], mark: f32, rows: &[[f32; 3]]) -> Result<(), String> {
        let is_left = |(i, row): (usize, &[f32; 3])| moved.contains(&(i as u32)) || *row == [mark; 3];
        if rows.iter().enumerate().all(is_left) { Ok(()) } else { Err(format!("{rows:?}, moved {moved:?}")) }
    }
    fn check(mesh: &ControlMesh, points: &[[f32; 3]], scheme: Scheme) -> Result<(), String> {
        apply::<f32>(mesh, points, scheme)?;
        apply::<f64>(mesh, points, scheme)
    }
    everywhere(6, 31, |mesh, points, scheme| in_single(check, mesh, points, scheme));
}

#[test]
fn tessellated_channels_are_the_same() {
    fn check(mesh: &ControlMesh, points: &[[f32; 3]], scheme: Scheme) -> Result<(), String> {
        let table = PatchTable::new(mesh, scheme).unwrap();
        let options = TessellateOptions { rates: Rates::Uniform(3), normals: false, ..TessellateOptions::default() };
        let made = table.surface(points).tessellate(&options).unwrap();
        let (pairs, single) = (first::<_, 3, 2>(points), first::<_, 3, 1>(points));
        let channel = made.channel(&table, table.surface(points)).unwrap();
        same("positions", &made.positions, &channel.values)?;
        same("pairs", &made.positions, &made.channel(&table, table.surface(&pairs)).unwrap().values)?;
        same("single", &made.positions, &made.channel(&table, table.surface(&single)).unwrap().values)
    }
    everywhere(6, 31, |mesh, points, scheme| in_single(check, mesh, points, scheme));
}

/// Checks shapes and random meshes under every scheme, in single precision: other widths take long to compile.
fn in_single(
    check: impl Fn(&ControlMesh, &[[f32; 3]], Scheme) -> Result<(), String>,
    mesh: &ControlMesh,
    points: &[[f64; 3]],
    scheme: Scheme,
) -> Result<(), String> {
    let rounded: Vec<[f32; 3]> = points.iter().map(|p| p.map(|x| x as f32)).collect();
    check(mesh, &rounded, scheme)
}
