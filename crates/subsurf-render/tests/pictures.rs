//! Laws of whole pictures, on small ones.

use subsurf_render::{
    Background, Camera, Faceted, Image, Legend, Options, Overlay, Phase, Polyline, RenderError, RenderMesh, SceneError,
    Show, Stroke, SurfaceAt, SurfacePoint, SurfaceShader, VertexNormals, View, palette, render,
};

/// A sphere of radius 1 by longitude and latitude, with poles on the y-axis.
fn sphere() -> RenderMesh {
    let (columns, rows) = (48u32, 24u32);
    let mut positions = Vec::new();
    for j in 0..=rows {
        for i in 0..columns {
            let a = i as f32 / columns as f32 * std::f32::consts::TAU;
            let b = j as f32 / rows as f32 * std::f32::consts::PI;
            positions.push([a.sin() * b.sin(), b.cos(), a.cos() * b.sin()]);
        }
    }
    let mut triangles = Vec::new();
    for j in 0..rows {
        for i in 0..columns {
            let k = (i + 1) % columns;
            let [a, b, c, d] = [(i, j), (i, j + 1), (k, j + 1), (k, j)].map(|(i, j)| j * columns + i);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    RenderMesh::from_triangles(positions, &triangles)
}

/// A square from −1 to 1 that faces +z.
fn square() -> RenderMesh {
    let positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    RenderMesh::from_triangles(positions, &[[0, 1, 2], [0, 2, 3]])
}

/// From 10 units in front, 4 units high, so that at z = 0 a picture of n rows has n / 4 pixels per unit.
fn front() -> Camera {
    Camera::At(View { eye: [0.0, 0.0, 10.0], target: [0.0; 3], fov_deg: 2.0 * 0.2f64.atan().to_degrees() })
}

fn small() -> Options {
    Options {
        width: 64,
        height: 64,
        camera: front(),
        background: Background::Transparent,
        floor: false,
        ..Options::default()
    }
}

fn picture(mesh: &RenderMesh, overlay: &Overlay, options: &Options) -> Image {
    render(mesh, &VertexNormals::averaged(mesh), overlay, options, None).expect("the input is right")
}

fn with_threads(threads: usize, work: impl FnOnce() -> Image + Send) -> Image {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start").install(work)
}

#[test]
fn one_thread_and_several_make_the_same_picture_to_the_bit() {
    let mesh = sphere();
    let edges: Vec<[u32; 2]> = mesh.triangles.iter().map(|t| [t.corners[0], t.corners[1]]).collect();
    let overlay = Overlay::cage(&mesh.positions, &edges);
    let options = Options { width: 120, height: 70, samples: 8, show: Show::Cage, ..Options::default() };
    let one = with_threads(1, || picture(&mesh, &overlay, &options));
    for threads in [2, 3] {
        assert!(one == with_threads(threads, || picture(&mesh, &overlay, &options)), "{threads} threads differ");
    }
}

#[test]
fn an_empty_transparent_background_has_alpha_zero_and_the_mesh_alpha_one() {
    let image = picture(&sphere(), &Overlay::default(), &small());
    for (x, y) in [(0, 0), (63, 0), (0, 63), (63, 63)] {
        assert_eq!(image.pixel(x, y), [0; 4]);
    }
    assert_eq!(image.pixel(32, 32)[3], 255);
}

#[test]
fn pixels_on_the_silhouette_are_covered_in_part() {
    // The square's right side at x = 1 is pixel column 48 of 64: turned a little, it crosses pixels at all offsets.
    let mut mesh = square();
    let (sin, cos) = 0.1f32.sin_cos();
    mesh.positions.iter_mut().for_each(|p| *p = [p[0] * cos - p[1] * sin, p[0] * sin + p[1] * cos, p[2]]);
    let image = picture(&mesh, &Overlay::default(), &small());
    let partly: Vec<u8> = image.pixels().iter().map(|p| p[3]).filter(|a| (1..255).contains(a)).collect();
    assert!(partly.len() > 100 && partly.iter().any(|&a| a < 64) && partly.iter().any(|&a| a > 192));
    // All in all the coverage is the square's area: 4 square units of 16 × 16 pixels.
    let covered: f64 = image.pixels().iter().map(|p| f64::from(p[3]) / 255.0).sum();
    assert!((covered - 1024.0).abs() < 4.0, "{covered}");
}

#[test]
fn a_plain_background_keeps_its_colour() {
    let options = Options { background: Background::Plain([12, 34, 56]), ..small() };
    assert_eq!(picture(&sphere(), &Overlay::default(), &options).pixel(1, 1), [12, 34, 56, 255]);
}

#[test]
fn the_floor_casts_shadow_only_below_the_mesh() {
    let options = Options { camera: Camera::Auto, floor: true, ..small() };
    let image = picture(&sphere(), &Overlay::default(), &options);
    let shadow = |rows: std::ops::Range<u32>| {
        rows.flat_map(|y| (0..64).map(move |x| (x, y)))
            .filter(|&(x, y)| image.pixel(x, y)[3] > 8 && image.pixel(x, y)[..3] == [0; 3])
            .count()
    };
    assert_eq!(shadow(0..24), 0);
    assert!(shadow(40..64) > 20);
}

#[test]
fn a_sphere_of_few_triangles_has_no_shadow_on_its_lit_side() {
    // Pixels near the light are brighter than those away from it, without dark spots between.
    let image = picture(&sphere(), &Overlay::default(), &Options { samples: 64, ..small() });
    for (x, y) in (24..36).flat_map(|x| (21..32).map(move |y| (x, y))) {
        assert!(image.pixel(x, y)[1] > 150, "({x}, {y}) is {:?}", image.pixel(x, y));
    }
}

#[test]
fn normals_are_shown_as_colours() {
    let image = picture(&sphere(), &Overlay::default(), &Options { show: Show::Normals, ..small() });
    let [r, g, b, _] = image.pixel(32, 32).map(i32::from);
    assert!((r - 128).abs() < 8 && (g - 128).abs() < 8 && b > 248, "{r} {g} {b}");
}

#[test]
fn the_shader_is_asked_with_the_face_and_parameters_of_the_hit() {
    /// Red is u, green is v, blue the face.
    struct Probe;
    impl SurfaceShader for Probe {
        fn normal(&self, _: &SurfaceAt) -> Option<[f64; 3]> {
            None
        }
        fn color(&self, point: &SurfacePoint) -> [f32; 3] {
            let at = point.at;
            // Triangle (0,1,2) has u along x, then v along y.
            let [x, y, _] = point.position.map(|x| f64::from(x + 1.0) / 2.0);
            let (u, v) = if at.face == 0 { (x - y, y) } else { (x, y - x) };
            assert!((at.u - u).abs() < 1e-4 && (at.v - v).abs() < 1e-4, "({x}, {y}) is {at:?}");
            [at.u as f32, at.v as f32, at.face as f32]
        }
    }
    render(&square(), &Probe, &Overlay::default(), &Options { show: Show::Patches, ..small() }, None)
        .expect("it renders");
}

#[test]
fn lines_in_front_are_drawn_and_lines_behind_are_faint_or_gone() {
    let line = |z: f32, hidden: f32| {
        let stroke = Stroke { color: [1.0, 0.0, 0.0], opacity: 1.0, hidden, width_px: 2.0 };
        Overlay { lines: vec![Polyline { points: vec![[-2.0, 0.0, z], [2.0, 0.0, z]], stroke }], ..Overlay::default() }
    };
    let red = |overlay: &Overlay| {
        let image = picture(&square(), overlay, &small());
        // Row 31 is just above the middle. One pixel on the square, one beside it.
        [28, 4].map(|x| i32::from(image.pixel(x, 31)[0]) - i32::from(image.pixel(x, 31)[1]))
    };
    assert_eq!(red(&line(0.0, 0.0)), [255, 255], "on the surface");
    assert_eq!(red(&line(0.5, 0.0)), [255, 255], "in front");
    let [behind, beside] = red(&line(-0.5, 0.0));
    assert!(behind < 40 && beside == 255, "behind: {behind}, {beside}");
    let [faint, _] = red(&line(-0.5, 0.4));
    assert!((60..220).contains(&faint), "faint: {faint}");
}

#[test]
fn lines_that_pass_the_eye_are_cut_off() {
    let mut overlay = Overlay::wireframe([vec![[0.0, -1.0, 50.0], [0.0, 1.0, -50.0]], vec![[0.0, 0.0, 20.0]; 3]]);
    overlay.lines.push(Polyline { points: vec![], stroke: Stroke::wire() });
    picture(&square(), &overlay, &small());
}

#[test]
fn a_legend_shows_its_colours() {
    let entries = (0..3).map(|i| (palette::category(i), format!("kind {i} of ünits"))).collect();
    let overlay = Overlay { legend: Some(Legend { entries, ..Legend::default() }), ..Overlay::default() };
    let image = picture(&square(), &overlay, &Options { width: 320, height: 180, ..small() });
    for i in 0..3 {
        let count =
            image.pixels().iter().filter(|p| palette::linear([p[0], p[1], p[2]]) == palette::category(i)).count();
        assert!(count >= 64, "swatch {i} has {count} pixels");
    }
    // Far too small for the text: cut off, no panic.
    picture(&square(), &overlay, &Options { width: 9, height: 5, ..small() });
}

#[test]
fn a_scale_shows_its_colours_and_those_between_under_its_title() {
    let scale = (0..3).map(|i| (palette::diverging(1.0 - i as f32), format!("{}", 1 - i))).collect();
    let legend = Legend { title: "a title".to_owned(), scale, ..Legend::default() };
    let plain = Options { width: 320, height: 180, ..small() };
    let with = |legend| picture(&square(), &Overlay { legend: Some(legend), ..Overlay::default() }, &plain);
    let image = with(legend.clone());
    // The bar's left column: 6 pixels of padding in a plate at 8, above the plate's lower side at 8 and its padding.
    let bar: Vec<[u8; 4]> =
        (0..180).map(|y| image.pixel(14, y)).filter(|p| p[..3].iter().any(|&x| x != p[0])).collect();
    let is_red_first = bar[0][0] > bar[0][2] && bar[bar.len() - 1][2] > bar[bar.len() - 1][0];
    assert!(is_red_first && bar.len() >= 28, "{bar:?}");
    let mut colors = bar;
    colors.dedup();
    assert!(colors.len() > 20, "{} colours", colors.len());
    assert_ne!(image, with(Legend { title: "a tilte".to_owned(), ..legend }));
}

#[test]
fn stripes_narrower_than_samples_are_grey_and_wide_ones_have_smooth_edges() {
    /// So many stripes per unit of x.
    struct Comb(f32);
    impl SurfaceShader for Comb {
        fn normal(&self, _: &SurfaceAt) -> Option<[f64; 3]> {
            None
        }
        fn phase(&self, point: &SurfacePoint) -> Option<Phase> {
            Some(Phase { stripes: self.0 * point.position[0], turn: f32::INFINITY })
        }
    }
    let options = Options { show: Show::Isophotes, samples: 4, ..small() };
    let row = |per_unit: f32| -> Vec<u8> {
        let image = render(&square(), &Comb(per_unit), &Overlay::default(), &options, None).expect("it renders");
        (18..46).map(|x| image.pixel(x, 30)[1]).collect()
    };
    let range = |row: &[u8]| (row.iter().min().copied(), row.iter().max().copied());
    // 16 pixels per unit, of two samples' width each: 5 stripes in a sample.
    let (least, most) = range(&row(160.0));
    assert!(most.zip(least).is_some_and(|(most, least)| most - least < 40), "{least:?} to {most:?}");
    // Stripes of 16 pixels: dark, light and at most four greys in between at each edge.
    let wide = row(1.0);
    let (least, most) = range(&wide);
    assert!(least < Some(70) && most > Some(220), "{wide:?}");
    let greys = wide.iter().filter(|&&x| x > least.unwrap_or(0) + 2 && x < most.unwrap_or(0) - 2).count();
    assert!((3..=12).contains(&greys), "{wide:?}");
}

#[test]
fn what_is_seen_is_what_covers_the_middles_of_pixels() {
    let mesh = square();
    let scene = subsurf_render::Scene::new(&mesh).expect("the square is right");
    // The camera sees 4 units in 64 pixels, of which the square takes 2.
    for (step, expected) in [(1, 32 * 32), (2, 16 * 16)] {
        let seen = scene.seen(&Overlay::default(), &small(), step).expect("the options are right");
        assert_eq!(seen.len(), expected);
        // Within the triangles, to rounding in single precision.
        assert!(seen.iter().all(|at| at.u >= -1e-6 && at.v >= -1e-6 && at.u + at.v <= 1.0 + 1e-6));
    }
    let away = Camera::At(View { eye: [0.0, 0.0, 10.0], target: [0.0, 0.0, 20.0], fov_deg: 30.0 });
    let seen = scene.seen(&Overlay::default(), &Options { camera: away, ..small() }, 1);
    assert_eq!(seen, Ok(Vec::new()));
}

#[test]
fn progress_ends_at_one() {
    let most = std::sync::Mutex::new(0.0f32);
    let progress = |x: f32| {
        let mut most = most.lock().expect("no panic");
        *most = most.max(x);
    };
    render(&square(), &Faceted, &Overlay::default(), &small(), Some(&progress)).expect("it renders");
    assert_eq!(*most.lock().expect("no panic"), 1.0);
}

#[test]
fn degenerate_triangles_are_no_problem() {
    let mut mesh = square();
    mesh.positions.push([0.5; 3]);
    mesh.triangles.push(subsurf_render::RenderTriangle { corners: [4, 4, 4], ..Default::default() });
    picture(&mesh, &Overlay::default(), &Options { camera: Camera::Auto, ..small() });
    let point = RenderMesh::from_triangles(vec![[3.0, 2.0, 1.0]], &[[0, 0, 0]]);
    picture(&point, &Overlay::default(), &Options { camera: Camera::Auto, floor: true, ..small() });
}

#[test]
fn wrong_input_is_named() {
    let error = |mesh: &RenderMesh, options: &Options| {
        render(mesh, &Faceted, &Overlay::default(), options, None).expect_err("the input is wrong")
    };
    let mesh = square();
    for (width, height) in [(0, 9), (9, 0), (16_385, 1), (16_384, 16_384)] {
        assert_eq!(error(&mesh, &Options { width, height, ..small() }), RenderError::Size { width, height });
    }
    assert_eq!(error(&mesh, &Options { samples: 0, ..small() }), RenderError::Samples { samples: 0 });
    assert_eq!(error(&RenderMesh::default(), &small()), RenderError::Scene(SceneError::NoTriangles));
    let mut broken = square();
    broken.positions[2][1] = f32::NAN;
    assert!(matches!(error(&broken, &small()), RenderError::Scene(SceneError::PositionNotFinite { vertex: 2, .. })));
    let mut broken = square();
    broken.triangles[1].corners[0] = 9;
    let expected = SceneError::VertexOutOfRange { triangle: 1, vertex: 9, vertices: 4 };
    assert_eq!(error(&broken, &small()), RenderError::Scene(expected));
    let camera = Camera::At(View { eye: [1.0; 3], target: [1.0; 3], fov_deg: 30.0 });
    assert!(matches!(error(&mesh, &Options { camera, ..small() }), RenderError::Camera { .. }));
    let overlay = Overlay::wireframe([vec![[f32::INFINITY; 3]]]);
    let result = render(&mesh, &Faceted, &overlay, &small(), None);
    assert_eq!(result, Err(RenderError::OverlayNotFinite { what: "line", index: 0 }));
}
