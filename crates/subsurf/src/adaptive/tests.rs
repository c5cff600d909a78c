//! Laws of the baseline's patches. That they are OpenSubdiv's is tested in `tests/adaptive.rs`.

use super::*;
use crate::limit::{PatchKind, PatchTable};
use crate::shapes::{self, Shape};
use crate::tags::{Crease, Tags};

fn everything() -> Vec<(Shape, Scheme)> {
    let with = |scheme| move |shape: Shape| (shape, scheme);
    let mut all: Vec<_> = shapes::all().into_iter().map(with(Scheme::CatmullClark)).collect();
    all.extend(shapes::all().into_iter().map(with(Scheme::Bilinear)));
    all.extend(shapes::all_triangles().into_iter().chain([shapes::pillow()]).map(with(Scheme::Loop)));
    all
}

fn refined(shape: &Shape, scheme: Scheme, isolation: u32, single_crease: bool) -> AdaptiveRefinement {
    AdaptiveRefinement::new(&shape.mesh, scheme, AdaptiveOptions { isolation, single_crease })
        .unwrap_or_else(|e| panic!("{}: {e}", shape.name))
}

/// Every shape with isolation levels 1, 3 and 6, single-crease patches off and on.
fn for_each_table(mut check: impl FnMut(&str, &Shape, &AdaptiveRefinement)) {
    for (shape, scheme) in everything() {
        for (isolation, single_crease) in [1, 3, 6].into_iter().flat_map(|l| [(l, false), (l, true)]) {
            let table = refined(&shape, scheme, isolation, single_crease);
            check(&format!("{}, {scheme:?}, {:?}", shape.name, table.options()), &shape, &table);
        }
    }
}

/// The middle of a patch.
fn middle(patch: &AdaptivePatch, scheme: Scheme) -> Location {
    let half = if scheme == Scheme::Loop { 0.25 } else { 0.5 };
    let [u, v] = [patch.u, patch.v].map(|x| x + half * patch.size);
    Location { face: patch.face, subface: patch.subface, u, v }
}

#[test]
fn patches_tile_every_face_that_is_no_hole() {
    for_each_table(|what, shape, table| {
        let topology = scheme_topology(&shape.mesh, table.scheme()).unwrap();
        let ptex = table.ptex_faces();
        let mut area = vec![0.0; ptex.count()];
        for patch in table.patches() {
            area[ptex.id(patch.face, patch.subface) as usize] += patch.size * patch.size;
            assert_eq!(table.patch_at(middle(&patch, table.scheme())), Some(patch), "{what}: overlap");
        }
        for (id, &area) in area.iter().enumerate() {
            // Sums of powers of 1/4 down to 4^-6 are exact.
            let whole = if topology.is_hole(ptex.face(id as u32).0) { 0.0 } else { 1.0 };
            assert_eq!(area, whole, "{what}: Ptex face {id}");
        }
    });
}

#[test]
fn levels_end_at_the_isolation_level_and_size_halves_with_each() {
    for_each_table(|what, shape, table| {
        for patch in table.patches() {
            assert!(patch.level <= table.options().isolation, "{what}: {patch:?}");
            let whole = shape.mesh.face_vertices(patch.face.index()).len() == table.scheme().patch_sides();
            let halvings = patch.level - u32::from(!whole);
            assert_eq!(patch.size.abs(), 0.5f64.powi(halvings as i32), "{what}: {patch:?}");
            assert_eq!(patch.sharpness > 0.0, patch.kind == AdaptiveKind::SingleCrease, "{what}: {patch:?}");
        }
    });
}

#[test]
fn end_caps_and_dropped_sharpness_are_at_the_deepest_level_only() {
    for_each_table(|what, _, table| {
        let deepest = table.options().isolation;
        for patch in table.patches() {
            let single = patch.kind == AdaptiveKind::SingleCrease;
            assert!(patch.kind != AdaptiveKind::EndCap || patch.level == deepest, "{what}: {patch:?}");
            assert!(!patch.cut_short || patch.level == deepest || single, "{what}: {patch:?}");
        }
    });
}

#[test]
fn single_crease_patches_never_make_more_of_them() {
    for (shape, scheme) in everything() {
        for isolation in [1, 2, 4, 6] {
            let [off, on] = [false, true].map(|single| refined(&shape, scheme, isolation, single));
            assert!(on.patch_count() <= off.patch_count(), "{} {scheme:?} {isolation}", shape.name);
            assert!(on.size().refined_points <= off.size().refined_points, "{} {scheme:?} {isolation}", shape.name);
        }
    }
}

#[test]
fn what_never_decays_adds_the_same_number_of_patches_with_every_level() {
    // From level 2 on a face has one feature, at one corner; from 5 on all finite sharpness of the shapes but "just finite"
    // (9.5) is gone, which single-crease patches take over.
    for (shape, scheme) in everything() {
        // Along non-manifold edges OpenSubdiv refines to the end, though the patches there are regular.
        let topology = scheme_topology(&shape.mesh, scheme).unwrap();
        let non_manifold = topology.edge_flags.iter().any(|flags| flags.non_manifold);
        if non_manifold || scheme == Scheme::Loop && shape.name.contains("just finite") {
            continue;
        }
        let count = |isolation| refined(&shape, scheme, isolation, true).patch_count();
        let [five, six, seven] = [5, 6, 7].map(count);
        assert_eq!(seven - six, six - five, "{} {scheme:?}", shape.name);
    }
}

#[test]
fn sharpness_doubles_what_a_crease_adds_but_for_single_crease_patches() {
    let count = |sharpness: f64, single_crease| {
        let row = [(10, 11), (11, 12), (12, 13), (13, 14)];
        let creases = row.map(|(a, b)| Crease::new(a, b, sharpness)).into();
        let shape = shapes::grid(4, 4).tagged("crease", Tags { creases, ..Tags::default() });
        refined(&shape, Scheme::CatmullClark, MAX_ISOLATION, single_crease).patch_count()
    };
    for s in 2..8 {
        let at = |single| [0.0, 1.0, 2.0].map(|more| count(f64::from(s) + more, single));
        let ([a, b, c], [d, e, f]) = (at(false), at(true));
        assert!(c - b > b - a && c - b <= 2 * (b - a), "{a} {b} {c}: exponential");
        assert_eq!(f - e, e - d, "linear, from the ends of the crease");
    }
}

#[test]
fn what_is_exactly_one_patch_here_is_one_patch_of_the_same_kind_in_the_patch_table() {
    for (shape, scheme) in everything() {
        let patches = PatchTable::new(&shape.mesh, scheme).unwrap();
        for patch in refined(&shape, scheme, 6, true).patches() {
            if patch.kind == AdaptiveKind::EndCap || patch.cut_short {
                continue;
            }
            let at = middle(&patch, scheme);
            let ours = patches.patch_kind(patches.patch(at.face, at.subface), at.u, at.v);
            let (kind, depth) = ours.unwrap_or_else(|| panic!("{}: a hole has a patch", shape.name));
            let halvings = -patch.size.abs().log2() as u32;
            assert!(depth <= halvings, "{}: our patch tree is deeper at {at:?}", shape.name);
            if depth == halvings && patch.kind == AdaptiveKind::SingleCrease {
                assert_eq!(kind, PatchKind::SingleCrease, "{} {at:?}", shape.name);
            } else if halvings == 0 {
                assert_eq!(kind, PatchKind::Regular, "{} {at:?}", shape.name);
            }
        }
    }
}

#[test]
fn levels_for_the_sharpness_of_a_mesh_cut_none_short() {
    for (shape, scheme) in everything() {
        let topology = scheme_topology(&shape.mesh, scheme).unwrap();
        for single_crease in [false, true] {
            let options = AdaptiveOptions::for_sharpness_of(&topology, single_crease);
            let table = AdaptiveRefinement::from_topology(&topology, scheme, options).unwrap();
            assert_eq!(table.size().cut_short, 0, "{} {options:?}", shape.name);
        }
    }
}

#[test]
fn a_place_in_a_hole_has_no_patch() {
    let holes = Tags { holes: vec![5], ..Tags::default() };
    let table = refined(&shapes::grid(4, 4).tagged("hole", holes), Scheme::CatmullClark, 3, true);
    assert_eq!(table.patch_at(Location::new(5, 0.3, 0.3)), None);
    assert!(table.patch_at(Location::new(4, 1.0, 1.0)).is_some());
}

#[test]
fn bilinear_faces_are_never_refined_but_for_n_gons() {
    for shape in shapes::all() {
        let levels = refined(&shape, Scheme::Bilinear, 6, true).counts();
        let polygons = shape.mesh.faces().any(|f| f.len() != 4);
        assert_eq!(levels.len(), if polygons { 2 } else { 1 }, "{}", shape.name);
        assert!(levels.iter().all(|kinds| kinds[1..] == [0; 3]), "{}", shape.name);
    }
}

#[test]
fn isolation_levels_out_of_range_quads_under_loop_and_too_many_faces_are_refused() {
    let cube = shapes::cube();
    let error = |scheme, isolation| {
        let options = AdaptiveOptions { isolation, single_crease: true };
        AdaptiveRefinement::new(&cube.mesh, scheme, options).unwrap_err()
    };
    assert_eq!(error(Scheme::CatmullClark, 0), AdaptiveError::Isolation { isolation: 0 });
    assert_eq!(error(Scheme::CatmullClark, 11), AdaptiveError::Isolation { isolation: 11 });
    assert_eq!(error(Scheme::Loop, 3), MeshError::NotATriangle { face: 0, sides: 4 }.into());
    let topology = scheme_topology(&cube.mesh, Scheme::CatmullClark).unwrap();
    let error = AdaptiveRefinement::find(&topology, Scheme::CatmullClark, AdaptiveOptions::default(), 23).unwrap_err();
    assert_eq!(error, AdaptiveError::TooManyFaces { level: 1, faces: 24, limit: 23 });
}
