use crate::program::Folder;
use std::f64::consts::PI;

/// The rows of a table, cell by cell, below a header that is checked.
fn rows(folder: &Folder, name: &str, header: &str) -> Vec<Vec<String>> {
    let text = folder.text(&format!("out/data/{name}.csv"));
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(header), "{name}");
    let rows: Vec<Vec<String>> = lines.map(|line| line.split(',').map(str::to_owned).collect()).collect();
    assert!(!rows.is_empty() && rows.iter().all(|row| row.len() == header.split(',').count()), "{name}");
    rows
}

fn number(cell: &str) -> f64 {
    cell.parse().unwrap_or_else(|_| panic!("{cell:?} is no number"))
}

#[test]
fn ratios_are_those_of_the_eigenvalues_of_stam_and_loop() {
    let folder = Folder::new();
    folder.run("figures out --only ratio").done();
    assert!(folder.text("out/ratio.svg").ends_with("</svg>\n"));
    let rows = rows(&folder, "ratio", "scheme,valence,lambda,mu,p_half,p_one,p_two,gradient");
    assert_eq!(rows.len(), 2 * 48);
    for row in rows.iter().filter(|row| number(&row[1]) > 4.0) {
        let n = number(&row[1]);
        let c = |k: f64| (2.0 * PI * k / n).cos();
        // The waves of frequency 1 and 2, and for triangles the round mode, which is larger at valence 5 alone.
        let (lambda, mu) = if row[0] == "catmull-clark" {
            let wave = |k: f64| (c(k) + 5.0 + ((c(k) + 9.0) * (c(k) + 1.0)).sqrt()) / 16.0;
            (wave(1.0), wave(2.0))
        } else {
            let wave = |k: f64| 0.375 + 0.25 * c(k);
            (wave(1.0), wave(2.0).max(wave(1.0).powi(2)))
        };
        for (p, cell) in [0.5, 1.0, 2.0].into_iter().zip(&row[4..7]) {
            let expected = mu.powf(p + 1.0) / (lambda * lambda);
            // Two formulas, each to a few roundings.
            assert!((number(cell) / expected - 1.0).abs() < 1e-12, "{row:?} {expected}");
        }
        assert!(number(&row[7]) < 1.0, "{row:?}");
    }
}

#[test]
fn a_fractional_crease_curve_is_the_blend_of_the_whole_ones_and_sharp_segments_agree() {
    let folder = Folder::new();
    folder.run("figures out --only crease-curves,profiles").done();
    let rows = rows(&folder, "crease-curves", "sharpness,t,segment,x,y");
    let curve = |sharpness: &str| -> Vec<[f64; 3]> {
        let own = rows.iter().filter(|row| row[0] == sharpness);
        own.map(|row| [number(&row[1]), number(&row[3]), number(&row[4])]).collect()
    };
    let [smooth, one, fraction, two] = ["0", "1", "1.7", "2"].map(curve);
    assert!(smooth.len() > 100 && [&one, &fraction, &two].iter().all(|c| c.len() == smooth.len()));
    for (((s, a), f), b) in smooth.iter().zip(&one).zip(&fraction).zip(&two) {
        let blend = [1, 2].map(|i| 0.3 * a[i] + 0.7 * b[i]);
        // Rounding of sums of numbers up to 2.3.
        assert!((0..2).all(|i| (f[i + 1] - blend[i]).abs() < 1e-14), "{f:?} {blend:?}");
        if s[0] <= 0.5 {
            assert!((1..3).all(|i| (a[i] - b[i]).abs() < 1e-14), "both sharp at {}", s[0]);
        }
    }
    assert!(smooth.iter().zip(&one).skip(1).all(|(s, a)| (s[1] - a[1]).abs() + (s[2] - a[2]).abs() > 1e-12));
}

#[test]
fn pictures_and_their_models_come_in_any_size_and_can_be_rendered_alone() {
    let folder = Folder::new();
    folder.run("figures out --only weights,loop-isophotes --size 150 --samples 1 -q").done();
    for name in ["weights", "loop-isophotes"] {
        let bytes = folder.read(&format!("out/{name}.png"));
        let width = u32::from_be_bytes(bytes[16..20].try_into().unwrap());
        // Panels are rounded down, gaps between them up.
        assert!(bytes.starts_with(b"\x89PNG") && (140..=165).contains(&width), "{name}: {width}");
    }
    let rows = rows(&folder, "weights", "blend,weights_level,u,b");
    let at_the_pole = |blend: &str| number(&rows.iter().find(|row| row[0] == blend && row[2] == "0").unwrap()[3]);
    // Sums of a few dozen weights.
    assert!(["a1", "a3", "a4"].iter().all(|blend| (at_the_pole(blend) - 1.0).abs() < 1e-12));
    assert!(at_the_pole("a2") < 0.9);
    folder.run("render out/data/pole-12.obj -o pole.png --size 64x48 --samples 1").done();
}

#[test]
fn only_known_figures_are_drawn_and_a_full_run_lists_them() {
    let folder = Folder::new();
    let run = folder.run("figures out --only nothing");
    assert!(run.status == 2 && run.stderr.contains("crease-cost"), "{}", run.stderr);
    let json = folder.run("figures out --only ratio --json").done().json();
    assert_eq!(json["files"].as_array().unwrap().len(), 2);
    folder.write("file", "");
    folder.run("figures file --only ratio").failed(&["file"]);
}
