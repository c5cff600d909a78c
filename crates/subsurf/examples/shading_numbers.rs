//! Numbers about shading normals, as markdown tables: eigenvalue ratios, blend weights and gradients round extraordinary
//! vertices, the rim of the blend, linear against spherical averages, and what each field costs.
//!
//!     cargo run --release -p subsurf --example shading_numbers [model.obj …]

#[path = "shading_numbers/model.rs"]
mod model;
#[path = "../tests/rings/mod.rs"]
mod rings;

use model::Model;
use rings::Centre;
use std::hint::black_box;
use std::time::Instant;
use subsurf::{
    Averaging, Blend, Face, Location, NormalField, PatchTable, Power, Rates, Scheme, ShadingNormals, ShadingOptions,
    Spectrum, TessellateOptions,
};

const SCHEMES: [Scheme; 2] = [Scheme::CatmullClark, Scheme::Loop];
const FIELDS: [(&str, NormalField); 6] = [
    ("n_L", NormalField::Limit),
    ("n_S", NormalField::Subdivided),
    ("A1", NormalField::Blended(Blend::A1)),
    ("A2", NormalField::Blended(Blend::A2)),
    ("A3", NormalField::Blended(Blend::A3)),
    ("A4", NormalField::Blended(Blend::A4)),
];
/// Rounds of timings; in each, every field takes its turn, so that what else the machine does hits all.
const ROUNDS: usize = 15;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    ratios();
    weights();
    gradients();
    rim();
    let named: Vec<String> = std::env::args().skip(1).collect();
    let assets = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets");
    let files = ["spot_control_mesh", "catmark_car", "mh_shoes03_semisharp", "fancy_teapot"];
    let files = if named.is_empty() { files.map(|f| format!("{assets}/{f}.obj")).into() } else { named };
    let models = files.iter().map(|f| Model::read(f)).collect::<Result<Vec<_>, _>>()?;
    averages(&models)?;
    costs(&models)?;
    Ok(())
}

fn with(field: NormalField) -> ShadingOptions {
    ShadingOptions { field, ..ShadingOptions::default() }
}

fn heading(title: &str, columns: &[&str]) {
    println!("\n**{title}**\n\n| {} |", columns.join(" | "));
    println!("|{}", "---:|".repeat(columns.len()));
}

fn ratios() {
    heading(
        "μ^(p+1)/λ², the published bound per level, and (μ/λ)², the true factor for every p",
        &["scheme", "n", "λ", "μ", "p = 1/2", "p = 1", "p = 2", "(μ/λ)²"],
    );
    for scheme in SCHEMES {
        for n in 3..=50 {
            let s = Spectrum::of_interior(scheme, n).expect("a smooth scheme");
            let [a, b, c] = [0.5, 1.0, 2.0].map(|p| s.theorem_ratio(p));
            let (lambda, mu, ratio) = (s.lambda, s.mu, s.gradient_ratio());
            println!("| {scheme:?} | {n} | {lambda:.6} | {mu:.6} | {a:.4} | {b:.4} | {c:.4} | {ratio:.4} |");
        }
    }
}

fn weights() {
    heading(
        "1 - b at the extraordinary vertex, and by what 1 - b shrinks per level towards it, at depth 6; λ: distances",
        &["scheme", "n", "A2: 1 - b", "A3: 1 - b", "A4: 1 - b", "A3: factor", "A4: factor", "λ"],
    );
    for scheme in SCHEMES {
        for n in (3..=20).filter(|n| scheme == Scheme::Loop && *n != 6 || scheme != Scheme::Loop && *n != 4) {
            let centre = Centre::new(scheme, n);
            let gap = |blend: Blend, r: f64| {
                1.0 - centre.shading(&with(NormalField::Blended(blend))).blend_weight(Location::new(0, r, 0.3 * r))
            };
            let factor = |blend| gap(blend, 0.5f64.powi(7)) / gap(blend, 0.5f64.powi(6));
            let lambda = Spectrum::of_interior(scheme, n).expect("a smooth scheme").lambda;
            let [a2, a3, a4] = [Blend::A2, Blend::A3, Blend::A4].map(|b| gap(b, 0.0));
            let (f3, f4) = (factor(Blend::A3), factor(Blend::A4));
            println!("| {scheme:?} | {n} | {a2:.4} | {a3:.0e} | {a4:.0e} | {f3:.4} | {f4:.4} | {lambda:.4} |");
        }
    }
}

fn gradients() {
    let names = FIELDS.map(|(name, _)| name);
    heading(
        "Largest distance of a gradient of the normal from their mean on ring m round the vertex, p = 1",
        &[&["scheme", "n", "m"], &names[..]].concat(),
    );
    for scheme in SCHEMES {
        for n in [3, 5, 8, 12] {
            let centre = Centre::new(scheme, n);
            let shadings = FIELDS.map(|(_, field)| centre.shading(&with(field)));
            for depth in [2, 8, 14, 20, 26] {
                let cells = shadings.each_ref().map(|s| format!("{:.1e}", centre.spread(s, depth)));
                println!("| {scheme:?} | {n} | {depth} | {} |", cells.join(" | "));
            }
        }
    }
}

fn rim() {
    heading(
        "b^p over the distance d to the rim of the blend (A4, valence 5): a slope that must vanish",
        &["d", "p = 1/4", "p = 0.3", "p = 1/3", "p = 0.4", "p = 1/2", "p = 1"],
    );
    let centre = Centre::new(Scheme::CatmullClark, 5);
    let shading = centre.shading(&ShadingOptions::default());
    for m in [2, 4, 6, 8, 10, 12] {
        let d = 0.5f64.powi(m);
        let b = shading.blend_weight(Location::new(2, 1.0 - d, 0.4));
        let cells = [0.25, 0.3, 1.0 / 3.0, 0.4, 0.5, 1.0].map(|p| format!("{:.2e}", b.powf(p) / d));
        println!("| 2^-{m} | {} |", cells.join(" | "));
    }
}

/// Places all over a mesh.
fn places(table: &PatchTable) -> Vec<Location> {
    let mut out = Vec::new();
    for face in (0..table.topology().face_count()).map(Face::new).filter(|&f| !table.topology().is_hole(f)) {
        for subface in 0..table.subfaces(face) {
            for k in 0..16 {
                let (u, v) = (f64::from(k % 4) / 4.0 + 0.1, f64::from(k / 4) / 4.0 + 0.1);
                out.push(Location { face, subface, u, v });
            }
        }
    }
    out
}

fn averages(models: &[Model]) -> Result<(), Box<dyn std::error::Error>> {
    heading(
        "Angle between n_S by linear and by spherical averages (so many levels), degrees: largest (mean)",
        &["model", "1 level", "2 levels", "3 levels", "n_S and n_L"],
    );
    for model in models {
        let patches = PatchTable::new(&model.mesh, Scheme::CatmullClark)?;
        let surface = patches.surface(&model.positions);
        let new = |averaging| {
            let options = ShadingOptions { averaging, crease_sharpness: 10.0, ..with(NormalField::Subdivided) };
            ShadingNormals::new(&patches, &model.positions, &options)
        };
        let linear = new(Averaging::Linear)?;
        let places = places(&patches);
        let against = |other: &dyn Fn(Location) -> Option<[f64; 3]>| {
            let angles = places.iter().filter_map(|&at| Some(angle(linear.subdivided(at)?, other(at)?)));
            let (count, sum, most) = angles.fold((0.0, 0.0, 0.0f64), |(n, s, m), a| (n + 1.0, s + a, m.max(a)));
            format!("{most:.2} ({:.3})", sum / count)
        };
        let mut cells = Vec::new();
        for levels in 1..=3 {
            let spherical = new(Averaging::Spherical(levels))?;
            cells.push(against(&|at| spherical.subdivided(at)));
        }
        cells.push(against(&|at| surface.eval(at)?.normal()));
        println!("| {} | {} |", model.name, cells.join(" | "));
    }
    Ok(())
}

fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let far = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
    2.0 * (0.5 * far).min(1.0).asin().to_degrees()
}

fn costs(models: &[Model]) -> Result<(), Box<dyn std::error::Error>> {
    for (title, is_mesh) in [
        (
            "Time of a tessellation at rate 8 over that with n_L, medians of pairs (A4 level 1: weights from level 1)",
            true,
        ),
        ("Time of one place, position and normal, over that with n_L", false),
    ] {
        let names = FIELDS.map(|(name, _)| name);
        heading(title, &[&["model"], &names[1..], &["A4 level 1"]].concat());
        for model in models {
            let patches = PatchTable::new(&model.mesh, Scheme::CatmullClark)?;
            let surface = patches.surface(&model.positions);
            let places = places(&patches);
            let places: Vec<Location> = places.iter().copied().step_by(places.len() / 5000 + 1).collect();
            let mut all: Vec<ShadingOptions> = FIELDS.iter().map(|(_, field)| with(*field)).collect();
            all.push(ShadingOptions { weights_level: 1, power: Power::Uniform(1.0), ..ShadingOptions::default() });
            let shadings = all
                .iter()
                .map(|options| ShadingNormals::new(&patches, &model.positions, options))
                .collect::<Result<Vec<_>, _>>()?;
            let options = TessellateOptions { rates: Rates::Uniform(8), ..TessellateOptions::default() };
            let time = |shading: &ShadingNormals<'_>| -> Result<f64, subsurf::TessellateError> {
                let start = Instant::now();
                if is_mesh {
                    black_box(surface.tessellate_shaded(&options, shading)?);
                } else {
                    for &at in &places {
                        black_box(surface.eval(at).and_then(|jet| shading.normal(at, &jet)));
                    }
                }
                Ok(start.elapsed().as_secs_f64())
            };
            let mut ratios = vec![Vec::new(); shadings.len()];
            for _ in 0..ROUNDS {
                for (shading, ratios) in shadings.iter().zip(&mut ratios) {
                    let base = time(&shadings[0])?;
                    ratios.push(time(shading)? / base);
                }
            }
            let median = |list: &mut Vec<f64>| {
                list.sort_by(f64::total_cmp);
                format!("{:.2}", list[list.len() / 2])
            };
            let cells: Vec<String> = ratios[1..].iter_mut().map(median).collect();
            println!("| {} | {} |", model.name, cells.join(" | "));
        }
    }
    Ok(())
}
