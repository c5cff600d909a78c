//! The decomposition against its matrix, exact ranks, and powers computed in other ways.

use super::*;
use std::array;

/// `Σ weights[p] points[p]`, over the points that have a weight.
fn combine<const N: usize>(weights: &[f64], points: &[[f64; N]]) -> [f64; N] {
    weights.iter().zip(points).fold([0.0; N], |sum, (w, p)| array::from_fn(|x| sum[x] + w * p[x]))
}

/// A stored matrix times a column of points.
fn times<const N: usize>(matrix: &BlockTriangular, x: &[[f64; N]]) -> Vec<[f64; N]> {
    (0..matrix.points).map(|row| combine(matrix.row(row), x)).collect()
}

/// The limit `p` of the points `c`, and the points `d` with `A^m c = 1 p + scale^m d`.
fn power<const N: usize>(form: &EigenForm, m: u32, c: &[[f64; N]]) -> ([f64; N], Vec<[f64; N]>) {
    let limit = combine(form.left.row(0), c);
    let difference: Vec<[f64; N]> = c.iter().map(|c| array::from_fn(|x| c[x] - limit[x])).collect();
    let image = |p| {
        let mut row = vec![0.0; c.len()];
        row[p] = 1.0;
        form.apply(m, &mut row, false);
        combine(&row, &difference)
    };
    (limit, (0..c.len()).map(image).collect())
}

const SECTORS: [Kind; 2] = [Kind::Crease, Kind::Corner];

/// A local subdivision matrix, built from the masks.
struct Local {
    kind: Kind,
    n: usize,
    i: usize,
    ring: usize,
    points: usize,
    a: Vec<f64>,
}

impl Local {
    /// The matrix of face `i`. Sectors have weights in 64ths, which come out exactly.
    fn new(kind: Kind, n: usize, i: usize) -> Self {
        let closed = matches!(kind, Kind::Smooth | Kind::Dart);
        let edges = if closed { n } else { n + 1 };
        let ring = 1 + edges + n;
        let sharp = |e: usize| match kind {
            Kind::Smooth => false,
            Kind::Dart => e.is_multiple_of(n),
            _ => e == 0 || e == n,
        };
        let edge = |j: usize| 1 + 2 * (j % edges);
        let face = |j: usize| 2 + 2 * (j % n);
        let outer: Vec<(i32, i32)> = [(2, -1), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (-1, 2)]
            .into_iter()
            .filter(|&at| !(at == (2, -1) && sharp(i) || at == (-1, 2) && sharp(i + 1)))
            .collect();
        let points = ring + outer.len();
        let mut rows: Vec<Vec<f64>> = vec![];
        let mask = |weights: &[(usize, f64)]| {
            let mut row = vec![0.0; points];
            weights.iter().for_each(|&(p, w)| row[p] += w);
            row
        };
        let mean = |a: &[Vec<f64>]| -> Vec<f64> {
            (0..points).map(|p| a.iter().map(|row| row[p]).sum::<f64>() / a.len() as f64).collect()
        };

        // The ring: face points, then edge points, then the vertex.
        let point = |p: usize| mask(&[(p, 1.0)]);
        let face_row = |j: usize| mean(&[point(0), point(edge(j)), point(face(j)), point(edge(j + 1))]);
        let edge_row = |j: usize| match sharp(j) {
            true => mean(&[point(0), point(edge(j))]),
            false => mean(&[point(0), point(edge(j)), face_row((j + n - 1) % n), face_row(j)]),
        };
        let faces: Vec<_> = (0..n).map(face_row).collect();
        rows.push(match kind {
            Kind::Smooth | Kind::Dart => {
                let ring_edges: Vec<_> = (0..n).map(|j| point(edge(j))).collect();
                let (e, f, n) = (mean(&ring_edges), mean(&faces), n as f64);
                (0..points).map(|p| (n - 2.0) / n * point(0)[p] + (e[p] + f[p]) / n).collect()
            }
            Kind::Crease => mask(&[(0, 0.75), (edge(0), 0.125), (edge(n), 0.125)]),
            Kind::Corner | Kind::Pinned => point(0),
        });
        for j in 0..edges {
            rows.push(edge_row(j));
            rows.extend(faces.get(j).cloned());
        }

        // The outer points: cubic B-spline masks in the face's coordinates, along a sharp edge those of the curve.
        let index = |x: i32, y: i32| match (x, y) {
            (0, 0) => 0,
            (1, 0) => edge(i),
            (1, 1) => face(i),
            (0, 1) => edge(i + 1),
            (-1, 1) => face(i + 1),
            (-1, 0) => edge(i + 2),
            (0, -1) => edge(i + edges - 1),
            (1, -1) => face(i + n - 1),
            at => ring + outer.iter().position(|&o| o == at).expect("an outer point"),
        };
        let line = |at: i32, sharp: bool| match at.rem_euclid(2) {
            0 if sharp && at == 0 => vec![(0, 1.0)],
            0 => vec![(at / 2 - 1, 0.125), (at / 2, 0.75), (at / 2 + 1, 0.125)],
            _ => vec![(at.div_euclid(2), 0.5), (at.div_euclid(2) + 1, 0.5)],
        };
        for &(x, y) in &outer {
            let mut weights = vec![];
            for (column, wx) in line(x, sharp(i + 1)) {
                for (row, wy) in line(y, sharp(i)) {
                    weights.push((index(column, row), wx * wy));
                }
            }
            rows.push(mask(&weights));
        }
        Self { kind, n, i, ring, points, a: rows.concat() }
    }

    fn form(&self) -> EigenForm {
        EigenForm::new(self.kind, self.n, self.i, &self.a, self.ring).expect("smooth or sector")
    }

    fn apply<const N: usize>(&self, c: &[[f64; N]]) -> Vec<[f64; N]> {
        self.a.chunks_exact(self.points).map(|row| combine(row, c)).collect()
    }

    /// K points without structure.
    fn control_points(&self) -> Vec<[f64; 3]> {
        let mut state = 1 + (self.n * 100 + self.i) as u64;
        let mut number = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1u64 << 30) as f64 - 1.0
        };
        (0..self.points).map(|_| [number(), number(), number()]).collect()
    }

    fn name(&self) -> String {
        format!("{:?} {} face {}", self.kind, self.n, self.i)
    }
}

/// Smooth vertices and sectors, with some of their faces: the ends, next to the end, and the middle.
fn all_up_to(limit: usize) -> impl Iterator<Item = Local> {
    let sectors = SECTORS.into_iter().flat_map(move |kind| {
        (1..=limit).flat_map(move |k| {
            let mut faces = vec![0, 1, k / 2, k - 1];
            faces.sort_unstable();
            faces.dedup();
            faces.into_iter().filter(move |&i| i < k).map(move |i| Local::new(kind, k, i))
        })
    });
    let smooth = (2..=limit).flat_map(|n| [0, n / 2].map(|i| Local::new(Kind::Smooth, n, i)));
    smooth.chain(sectors)
}

/// The larger of two errors; none is larger than one that is not a number.
fn worse(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

fn largest<const N: usize>(c: impl IntoIterator<Item = [f64; N]>) -> f64 {
    c.into_iter().flatten().map(f64::abs).fold(0.0, worse)
}

fn distance<const N: usize>(a: &[[f64; N]], b: &[[f64; N]]) -> f64 {
    largest::<N>(a.iter().zip(b).map(|(a, b)| array::from_fn(|x| a[x] - b[x])))
}

#[test]
#[cfg_attr(not(shared_data), ignore = "needs the shared golden data")]
fn the_matrices_of_these_tests_are_the_golden_ones() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/golden/local_ops.json");
    let text = std::fs::read_to_string(path).expect("readable golden data");
    let cases: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let mut seen = 0;
    for case in cases.as_array().expect("a list") {
        let kind = match case["kind"].as_str().expect("a kind") {
            "smooth" => Kind::Smooth,
            "crease" => Kind::Crease,
            "corner" => Kind::Corner,
            _ => Kind::Dart,
        };
        if case["scheme"] != "cc" {
            continue;
        }
        let number = |key: &str| case[key].as_u64().expect("a number") as usize;
        let local = Local::new(kind, number("n"), number("i"));
        assert_eq!(local.ring, number("ring"), "{}", local.name());
        let golden: Vec<f64> = case["A"]
            .as_array()
            .expect("rows")
            .iter()
            .flat_map(|row| row.as_array().expect("a row"))
            .map(|entry| fraction(entry.as_str().expect("a fraction")))
            .collect();
        assert_eq!(golden.len(), local.a.len(), "{}", local.name());
        for (at, (a, b)) in local.a.iter().zip(&golden).enumerate() {
            assert!((a - b).abs() < 1e-16, "{} entry {at}: {a} {b}", local.name());
        }
        seen += 1;
    }
    assert_eq!(seen, 10);
}

fn fraction(text: &str) -> f64 {
    let number = |text: &str| text.parse::<f64>().expect("an integer");
    text.split_once('/').map_or_else(|| number(text), |(a, b)| number(a) / number(b))
}

#[test]
fn the_decomposition_multiplies_to_the_matrix() {
    for local in all_up_to(50) {
        let form = local.form();
        let k = local.points;
        let (mut inverse_defect, mut defect) = (0.0f64, 0.0f64);
        for column in 0..k {
            let unit: Vec<[f64; 1]> = (0..k).map(|p| [f64::from(u8::from(p == column))]).collect();
            let coefficients = times(&form.left, &unit);
            inverse_defect = worse(inverse_defect, distance(&times(&form.right, &coefficients), &unit));
            let mut image = coefficients.clone();
            for block in form.blocks() {
                for row in block.start..block.start + block.size {
                    image[row][0] *= block.eigenvalue;
                    if row > block.start {
                        image[row][0] += coefficients[row - 1][0];
                    }
                }
            }
            defect = worse(defect, distance(&times(&form.right, &image), &local.apply(&unit)));
        }
        assert!(inverse_defect < 1e-12, "{}: T T⁻¹ is off by {inverse_defect:e}", local.name());
        assert!(defect < 1e-12, "{}: T J T⁻¹ is off by {defect:e}", local.name());
    }
}

#[test]
fn blocks_tile_the_columns_and_the_ring_comes_by_decreasing_magnitude() {
    for local in all_up_to(50) {
        let form = local.form();
        let mut next = 0;
        for block in form.blocks() {
            assert_eq!(block.start, next, "{}", local.name());
            next += block.size;
        }
        assert_eq!(next, local.points);
        let ring: Vec<_> = form.blocks().iter().take_while(|block| block.start < local.ring).collect();
        assert!(ring.windows(2).all(|pair| pair[0].eigenvalue.abs() >= pair[1].eigenvalue.abs()), "{}", local.name());
        assert_eq!(ring[0].eigenvalue, 1.0);
        assert!(ring[1].eigenvalue < 1.0);
    }
}

#[test]
fn boundaries_have_the_pattern_of_figure_4_with_its_corrections() {
    for edges in 2..=50 {
        let form = Local::new(Kind::Crease, edges - 1, 0).form();
        let found: Vec<_> = form.blocks().iter().filter(|block| block.size > 1).copied().collect();
        let expected = match edges % 4 {
            0 | 2 => vec![Block { eigenvalue: 0.25, size: 2, start: edges }],
            1 => vec![Block { eigenvalue: 0.5, size: 2, start: edges / 2 }],
            _ => vec![],
        };
        assert_eq!(found, expected, "{edges} edges");
    }
}

/// The dimension of the kernel of `scale (A - λ)` and of its square, where that matrix is integer: exact arithmetic modulo
/// a prime. The kernel over the rationals is at most as large.
fn kernels(local: &Local, eigenvalue: f64, scale: f64) -> [usize; 2] {
    const PRIME: i64 = (1 << 31) - 1;
    let k = local.points;
    let mut m: Vec<Vec<i64>> =
        local.a.chunks_exact(k).map(|row| row.iter().map(|x| integer(x * scale)).collect()).collect();
    for p in 0..k {
        m[p][p] -= integer(eigenvalue * scale);
    }
    let mut square = vec![vec![0i64; k]; k];
    for row in 0..k {
        for middle in (0..k).filter(|&middle| m[row][middle] != 0) {
            for column in 0..k {
                square[row][column] += m[row][middle] * m[middle][column];
            }
        }
    }
    [m, square].map(|mut m| {
        m.iter_mut().flatten().for_each(|x| *x = x.rem_euclid(PRIME));
        let mut rank = 0;
        for column in 0..k {
            let Some(pivot) = (rank..k).find(|&row| m[row][column] != 0) else { continue };
            m.swap(rank, pivot);
            let (above, below) = m.split_at_mut(rank + 1);
            let pivot = &above[rank];
            let inverse = power_modulo(pivot[column], PRIME - 2, PRIME);
            for row in below.iter_mut().filter(|row| row[column] != 0) {
                let factor = PRIME - row[column] * inverse % PRIME;
                for (x, y) in row[column..].iter_mut().zip(&pivot[column..]) {
                    *x = (*x + factor * y) % PRIME;
                }
            }
            rank += 1;
        }
        k - rank
    })
}

fn integer(x: f64) -> i64 {
    let rounded = x.round();
    assert!((x - rounded).abs() < 1e-9, "{x} is not an integer");
    rounded as i64
}

fn power_modulo(base: i64, mut exponent: i64, prime: i64) -> i64 {
    let (mut result, mut square) = (1, base);
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = result * square % prime;
        }
        square = square * square % prime;
        exponent >>= 1;
    }
    result
}

/// The eigenvalues that two parts of a matrix can share; all others are simple or belong to a symmetric block.
const SHARED: [f64; 6] = [0.5, 0.25, 0.125, 0.0625, 0.03125, 0.015625];

#[test]
fn matrices_are_defective_exactly_where_the_form_says() {
    for local in all_up_to(50) {
        // The smooth vertex has weights in 4 n²-ths, everything else in 64ths.
        let scale = if local.kind == Kind::Smooth { (64 * local.n * local.n) as f64 } else { 64.0 };
        let form = local.form();
        for eigenvalue in SHARED {
            let of = |size: usize| {
                form.blocks().iter().filter(|block| block.eigenvalue == eigenvalue && block.size >= size).count()
            };
            if of(1) == 0 {
                continue;
            }
            // Kernel of (A - λ)^2 beyond that of A - λ: one dimension for every block of size 2 or more.
            let [first, second] = kernels(&local, eigenvalue, scale);
            assert_eq!([first, second - first], [of(1), of(2)], "{} at {eigenvalue}", local.name());
        }
    }
}

#[test]
fn sectors_have_the_blocks_of_the_known_table() {
    for kind in SECTORS {
        for k in 1..=50 {
            let form = Local::new(kind, k, k / 2).form();
            let at = |eigenvalue: f64| -> Vec<usize> {
                let mut sizes: Vec<_> = form
                    .blocks()
                    .iter()
                    .filter(|block| block.eigenvalue == eigenvalue)
                    .map(|block| block.size)
                    .collect();
                sizes.sort_unstable_by(|a, b| b.cmp(a));
                sizes
            };
            let (half, quarter): (&[usize], &[usize]) = match (kind, k % 4) {
                (Kind::Crease, 0) => (&[2], &[1, 1]),
                (Kind::Crease, 2) => (&[1, 1], &[1, 1]),
                (Kind::Crease, _) => (&[1], &[2]),
                (_, 0 | 2) => (&[2, 1], &[1]),
                _ => (&[1, 1], &[1]),
            };
            assert_eq!((&at(0.5)[..], &at(0.25)[..]), (half, quarter), "{kind:?} {k}");
        }
    }
}

#[test]
fn eigenvalues_that_are_not_shared_are_simple_in_sectors() {
    for local in all_up_to(50).filter(|local| local.kind != Kind::Smooth) {
        let form = local.form();
        let mut others: Vec<f64> = form.blocks().iter().map(|block| block.eigenvalue).collect();
        others.retain(|eigenvalue| !SHARED.contains(eigenvalue));
        others.sort_unstable_by(f64::total_cmp);
        assert!(others.windows(2).all(|pair| pair[1] - pair[0] > 1e-5), "{}", local.name());
    }
}

#[test]
fn the_smooth_ring_is_symmetric_in_its_weights_and_so_never_defective() {
    for n in 2..=50 {
        let local = Local::new(Kind::Smooth, n, 0);
        let weight = |p: usize| match p {
            0 => (n * n) as f64,
            p if p % 2 == 1 => 4.0,
            _ => 1.0,
        };
        for row in 0..local.ring {
            for column in 0..row {
                let [a, b] = [(row, column), (column, row)].map(|(p, q)| weight(p) * local.a[p * local.points + q]);
                assert!((a - b).abs() < 1e-14, "valence {n}: {row} {column}");
            }
        }
    }
}

/// `A^m c` split as by [`EigenForm::power`], by the deflated powers `R = (A - 1 lᵀ) / λ`.
struct Deflated {
    limit: Vec<f64>,
    /// R, R², R⁴, … R³².
    squares: Vec<Vec<f64>>,
    points: usize,
}

impl Deflated {
    fn new(local: &Local, scale: f64) -> Self {
        let k = local.points;
        // The limit mask from its own closed form.
        let mut limit = vec![0.0; k];
        let n = local.n as f64;
        match local.kind {
            Kind::Smooth => {
                limit[..local.ring].iter_mut().enumerate().for_each(|(p, l)| *l = if p % 2 == 1 { 4.0 } else { 1.0 });
                limit[0] = n * n;
                limit.iter_mut().for_each(|l| *l /= n * (n + 5.0));
            }
            Kind::Crease => (limit[0], limit[1], limit[local.ring - 1]) = (4.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0),
            _ => limit[0] = 1.0,
        }
        let mut squares =
            vec![local.a.iter().enumerate().map(|(at, a)| (a - limit[at % k]) / scale).collect::<Vec<_>>()];
        for level in 0..5 {
            let r: &Vec<f64> = &squares[level];
            let mut square = vec![0.0; k * k];
            for row in 0..k {
                for middle in (0..k).filter(|middle| r[row * k + middle] != 0.0) {
                    let factor = r[row * k + middle];
                    let source = &r[middle * k..][..k];
                    square[row * k..][..k].iter_mut().zip(source).for_each(|(x, y)| *x += factor * y);
                }
            }
            squares.push(square);
        }
        Self { limit, squares, points: k }
    }

    fn power(&self, m: u32, c: &[[f64; 3]]) -> ([f64; 3], Vec<[f64; 3]>) {
        let limit = combine(&self.limit, c);
        let mut d: Vec<[f64; 3]> = c.iter().map(|c| array::from_fn(|x| c[x] - limit[x])).collect();
        for (bit, r) in self.squares.iter().enumerate().filter(|(bit, _)| m >> bit & 1 == 1) {
            assert!(bit < 6);
            d = r.chunks_exact(self.points).map(|row| combine(row, &d)).collect();
        }
        (limit, d)
    }
}

#[test]
fn powers_are_repeated_multiplication() {
    for local in all_up_to(50) {
        let form = local.form();
        let c = local.control_points();
        let mut repeated = c.clone();
        for m in 0..5u32 {
            let (limit, difference) = power(&form, m, &c);
            let scale = form.scale().powi(m as i32);
            let sum: Vec<[f64; 3]> = difference.iter().map(|d| array::from_fn(|x| limit[x] + scale * d[x])).collect();
            let error = distance(&sum, &repeated);
            assert!(error < 1e-13, "{} to the {m}: {error:e}", local.name());
            repeated = local.apply(&repeated);
        }
    }
}

#[test]
fn powers_agree_with_deflated_powers_at_every_depth() {
    for local in all_up_to(50) {
        let form = local.form();
        let deflated = Deflated::new(&local, form.scale());
        let c = local.control_points();
        for m in [0, 1, 2, 3, 7, 15, 25, 39] {
            let (p, d) = power(&form, m, &c);
            let (q, e) = deflated.power(m, &c);
            let position = distance(&[p], &[q]);
            let relative = distance(&d, &e) / largest(e);
            assert!(position < 1e-14, "{} limit: {position:e}", local.name());
            // Both err by up to 39 roundings of the ratio of eigenvalues: 3e-14 at most.
            assert!(relative < 1e-12, "{} to the {m}: {relative:e}", local.name());
        }
    }
}

#[test]
fn a_constant_has_no_difference_at_any_depth() {
    for local in all_up_to(12) {
        let (limit, difference) = power(&local.form(), 9, &vec![[3.0]; local.points]);
        assert!((limit[0] - 3.0).abs() < 1e-14, "{}", local.name());
        assert!(largest(difference) < 1e-14, "{}", local.name());
    }
}

#[test]
fn darts_have_no_form() {
    let local = Local::new(Kind::Dart, 5, 2);
    assert!(EigenForm::new(local.kind, local.n, local.i, &local.a, local.ring).is_none());
}

#[test]
fn storage_is_both_matrices_and_a_block_for_each_column() {
    for local in all_up_to(50) {
        let stored = local.form().storage_bytes();
        let outer = local.points - local.ring;
        let matrices = 2 * size_of::<f64>() * (local.points * local.points - local.ring * outer);
        assert!(stored <= matrices + local.points * size_of::<Block>(), "{}", local.name());
        assert!(stored < 3 * size_of::<f64>() * local.points * local.points, "{}", local.name());
    }
}
