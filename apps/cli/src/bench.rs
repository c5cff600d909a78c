//! `subsurf bench`: how fast this machine builds, refines, tessellates and evaluates a mesh.

mod work;

use crate::args::{Common, MeshArgs, Precision, TriangleRule};
use crate::console::{Console, heading, print, print_json};
use crate::failure::{Bytes, Failure};
use crate::heap::{Heap, heap_of};
use crate::input::Input;
use crate::memory;
use crate::refine::Counts;
use crate::tessellate::uniform_bytes;
use clap::Args;
use serde_json::{Value, json};
use std::fmt::Write;
use std::hint::black_box;
use std::time::{Duration, Instant};
use subsurf::TableSize;
use work::{FaceLists, Order};

const EXAMPLES: &str = "\
Examples:
  subsurf bench car.obj                          level 3, rate 8, 200000 samples
  subsurf bench car.obj --threads 1 --precision f64
  subsurf bench car.obj --level 5 --rate 16 --json | jq .refine

Cold work begins with lists of faces in memory; warm work has new positions for the same faces, and memory for the result.
Every time is the median of at least 5 runs on all threads, every peak the heap that a cold run takes at most, its result
included. Reading the file is left out.";

/// Measure building, refinement, tessellation and evaluation on this machine
#[derive(Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct BenchArgs {
    #[command(flatten)]
    mesh: MeshArgs,
    #[command(flatten)]
    rule: TriangleRule,
    /// Subdivision steps of `refine`
    #[arg(short, long, value_name = "N", default_value_t = 3)]
    level: u32,
    /// Facets along each side of a quad face (of a triangle under Loop)
    #[arg(short, long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    rate: u32,
    /// Random places to evaluate
    #[arg(short = 'n', long, value_name = "N", default_value_t = 200_000, value_parser = clap::value_parser!(u32).range(1..))]
    samples: u32,
}

/// Runs the verb.
pub fn run(args: &BenchArgs, common: &Common, console: &Console) -> Result<(), Failure> {
    let input = Input::load(&args.mesh, args.rule.triangles, console)?;
    let figures = match common.precision {
        Some(Precision::F64) => measure::<f64>(args, &input, console)?,
        Some(Precision::F32) | None => measure::<f32>(args, &input, console)?,
    };
    if common.json { print_json(&figures.json()) } else { print(&figures.text()) }
}

/// What is told of one run.
struct Figures {
    name: String,
    precision: &'static str,
    faces: usize,
    level: u32,
    rate: u32,
    samples: u32,
    build_s: f64,
    build_heap: Heap,
    size: TableSize,
    refine: Cost,
    tessellate: Cost,
    by_face_s: f64,
    random_s: f64,
    write_floor_s: f64,
}

/// What it costs to make a mesh.
#[derive(Clone, Copy, Debug)]
struct Cost {
    cold_s: f64,
    warm_s: f64,
    vertices: usize,
    output_bytes: u64,
    peak_bytes: u64,
}

/// Fewest runs of anything, and for how long further ones go on, up to the most.
const FEWEST_RUNS: usize = 5;
const ENOUGH: Duration = Duration::from_millis(200);
const MOST_RUNS: usize = 101;

/// Median time in seconds of `work` on what `prepare` makes; preparation and the end of the result are not counted.
fn median_s<P, R>(mut prepare: impl FnMut() -> P, mut work: impl FnMut(P) -> R) -> f64 {
    let mut times = Vec::new();
    let begin = Instant::now();
    while times.len() < FEWEST_RUNS || (times.len() < MOST_RUNS && begin.elapsed() < ENOUGH) {
        let input = prepare();
        let start = Instant::now();
        let result = black_box(work(black_box(input)));
        times.push(start.elapsed().as_secs_f64());
        drop(result);
    }
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn measure<T: subsurf::Real>(args: &BenchArgs, input: &Input, console: &Console) -> Result<Figures, Failure> {
    let points = input.positions::<T>()?;
    let lists = FaceLists::of(&input.scene.mesh, input.scheme);
    let mesh_error = |e| input.mesh_error(e);
    let too_fine = |source| Failure::Tessellate { name: input.name.clone(), source };

    // Refuse before any work what would not fit; what fails below without a message failed here with one.
    let (table, build_heap) = heap_of(|| lists.clone().patch_table());
    let table = table.map_err(mesh_error)?;
    let size = table.size();
    if size.patches == 0 {
        return Err(Failure::OnlyHoles { name: input.name.clone() });
    }
    let counts = Counts::of(table.topology()).refined(args.level, input.scheme);
    let counts = counts.map_err(|(level, source)| Failure::Level { name: input.name.clone(), level, source })?;
    memory::check(&input.name, format!("level {}", args.level), counts.bytes(3 * size_of::<T>()))?;
    let facets = uniform_bytes(&table, args.rate, size_of::<T>());
    memory::check(&input.name, format!("rate {}", args.rate), facets)?;
    let places = u64::from(args.samples) * (2 * 24 + 9 * size_of::<T>() as u64);
    memory::check(&input.name, format!("{} samples", args.samples), places)?;

    let bar = console.progress("measuring", 7);
    let build_s = median_s(|| lists.clone(), |lists| lists.patch_table());
    bar.inc(1);

    let refinement = lists.clone().refinement(args.level).map_err(mesh_error)?;
    let mut values = vec![[T::default(); 3]; refinement.vertex_count()];
    let warm_s = median_s(|| (), |()| refinement.refine_into(&points, &mut values));
    drop((refinement, values));
    bar.inc(1);
    let (cold, Heap { peak: peak_bytes, .. }) = heap_of(|| lists.clone().refined(args.level, &points));
    let cold = cold.map_err(mesh_error)?;
    let (vertices, output_bytes) = (cold.positions.len(), cold.bytes());
    let cold_s = median_s(|| lists.clone(), |lists| lists.refined(args.level, &points));
    let refine = Cost { cold_s, warm_s, vertices, output_bytes, peak_bytes };
    bar.inc(1);
    let mut copy = cold.clone();
    let write_floor_s = median_s(|| (), |()| cold.copy_into(&mut copy));
    drop((cold, copy));
    bar.inc(1);

    let tessellator = table.tessellator(&points, &work::at_rate(args.rate)).map_err(too_fine)?;
    let [mut values, mut normals] =
        [tessellator.point_count(), tessellator.normal_count()].map(|count| vec![[T::default(); 3]; count]);
    let warm_s = median_s(|| (), |()| tessellator.evaluate_into(&points, &mut values, &mut normals));
    drop((tessellator, values, normals));
    bar.inc(1);
    let (cold, Heap { peak: peak_bytes, .. }) = heap_of(|| lists.clone().tessellated(args.rate, &points));
    let cold = cold.map_err(mesh_error)?.map_err(too_fine)?;
    let (vertices, output_bytes) = (cold.positions.len(), work::tessellation_bytes(&cold));
    drop(cold);
    let cold_s = median_s(|| lists.clone(), |lists| lists.tessellated(args.rate, &points));
    let tessellate = Cost { cold_s, warm_s, vertices, output_bytes, peak_bytes };
    bar.inc(1);

    let surface = table.surface(&points);
    let [by_face_s, random_s] = [Order::ByFace, Order::Random].map(|order| {
        let places = work::places(&table, args.samples, order);
        let mut jets = vec![[[T::default(); 3]; 3]; places.len()];
        median_s(|| (), |()| work::evaluate(&surface, &places, &mut jets))
    });
    bar.finish_and_clear();
    Ok(Figures {
        name: input.name.clone(),
        precision: if size_of::<T>() == 8 { "f64" } else { "f32" },
        faces: lists.face_count(),
        level: args.level,
        rate: args.rate,
        samples: args.samples,
        build_s,
        build_heap,
        size,
        refine,
        tessellate,
        by_face_s,
        random_s,
        write_floor_s,
    })
}

impl Cost {
    fn json(&self) -> Value {
        json!({
            "cold_s": self.cold_s,
            "warm_s": self.warm_s,
            "vertices": self.vertices,
            "peak_bytes": self.peak_bytes,
            "output_bytes": self.output_bytes,
        })
    }

    fn line(&self, label: &str, text: &mut String) {
        let per_vertex = |seconds: f64| format!("{:.1} ns", seconds * 1e9 / self.vertices as f64);
        let [cold, warm] = [self.cold_s, self.warm_s].map(|s| format!("{} ({})", seconds(s), per_vertex(s)));
        let memory = format!("{} for {}", Bytes(self.peak_bytes), Bytes(self.output_bytes));
        let _ = writeln!(text, "{label:<14}{:>10}  {cold:<22}{warm:<22}{memory}", self.vertices);
    }
}

impl Figures {
    fn table_bytes(&self) -> usize {
        self.size.patch_bytes + self.size.plan_bytes + self.size.topology_bytes
    }

    fn per_sample_ns(&self) -> [f64; 2] {
        [self.by_face_s, self.random_s].map(|s| s * 1e9 / f64::from(self.samples))
    }

    fn json(&self) -> Value {
        let [by_face_ns, random_ns] = self.per_sample_ns();
        let mut refine = self.refine.json();
        refine["level"] = json!(self.level);
        let mut tessellate = self.tessellate.json();
        tessellate["rate"] = json!(self.rate);
        json!({
            "file": self.name,
            "threads": rayon::current_num_threads(),
            "precision": self.precision,
            "faces": self.faces,
            "build_s": self.build_s,
            "build_peak_bytes": self.build_heap.peak,
            "build_kept_bytes": self.build_heap.kept,
            "table_bytes": self.table_bytes(),
            "plans": self.size.plans,
            "refine": refine,
            "tessellate": tessellate,
            "eval": { "samples": self.samples, "by_face_ns": by_face_ns, "random_ns": random_ns },
            "write_floor_s": self.write_floor_s,
        })
    }

    fn text(&self) -> String {
        let per_face = |x: f64| x / self.faces as f64;
        let threads = match rayon::current_num_threads() {
            1 => "1 thread".to_owned(),
            n => format!("{n} threads"),
        };
        let mut text = format!("{}\n", heading(&self.name));
        let [by_face, random] = self.per_sample_ns();
        let mut line = |label: &str, what: String| {
            let _ = writeln!(text, "{label:<14}{what}");
        };
        line("setting", format!("{threads}, {}", self.precision));
        line("faces", self.faces.to_string());
        let (time, peak) = (seconds(self.build_s), Bytes(self.build_heap.peak));
        line("build", format!("{time} ({:.0} ns a face), {peak} at the peak", per_face(self.build_s * 1e9)));
        let bytes = self.table_bytes();
        let per_face = per_face(bytes as f64);
        line("table", format!("{} ({per_face:.0} bytes a face), {} plans", Bytes(bytes as u64), self.size.plans));
        line("evaluation", format!("{by_face:.1} ns a sample by face, {random:.1} ns in random order"));
        let floor = self.write_floor_s * 1e9 / self.refine.vertices as f64;
        line("write floor", format!("{} ({floor:.1} ns a vertex)", seconds(self.write_floor_s)));
        let [cold, warm] = ["cold (a vertex)", "warm (a vertex)"];
        let _ = writeln!(text, "{:<14}{:>10}  {cold:<22}{warm:<22}peak", "", "vertices");
        self.refine.line(&format!("level {}", self.level), &mut text);
        self.tessellate.line(&format!("rate {}", self.rate), &mut text);
        text
    }
}

/// A time with three digits and a unit.
fn seconds(s: f64) -> String {
    let (value, unit) = match s {
        s if s >= 1.0 => (s, "s"),
        s if s >= 1e-3 => (s * 1e3, "ms"),
        s => (s * 1e6, "us"),
    };
    let digits = if value >= 100.0 { 0 } else { 2 - usize::from(value >= 10.0) };
    format!("{value:.digits$} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_have_a_unit_and_three_digits() {
        assert_eq!([1.5, 0.0234, 1.234e-4].map(seconds), ["1.50 s", "23.4 ms", "123 us"]);
    }

    #[test]
    fn a_median_is_of_five_runs_at_least() {
        let mut runs = 0;
        median_s(
            || (),
            |()| {
                runs += 1;
                std::thread::sleep(ENOUGH / 3);
            },
        );
        assert_eq!(runs, FEWEST_RUNS);
    }
}
