//! Peak memory of a cold refinement, and what a surface that is ready keeps.

use super::super::clock::{Memory, memory_of};
use super::super::ours;
use super::super::record::{Entry, Record};
use super::super::rivals::faces::FaceSurfaces;
use super::super::rivals::kernels::{self, KernelMesh};
use super::super::rivals::name::*;
use super::super::rivals::patches::Patches;
use super::super::rivals::uniform::Uniform;
use super::{Context, Emit};

pub fn run(context: &Context<'_>, emit: Emit<'_>) -> Result<(), String> {
    let (case, mesh) = (context.case, &context.mesh);
    let control = context.control();
    let level = if case.faces() > 50_000 { 2 } else { 3 };
    let [vertices, faces] = case.refined_counts(level);
    let kernel_mesh = KernelMesh::new(&case.shape);
    let per_vertex = |memory: Memory| memory.peak as f64 / vertices as f64;
    let mut entries = vec![
        told(OURS, memory_of(|| Ok(ours::refine(case, level))), per_vertex),
        told(
            FAR,
            memory_of(|| {
                let refined = Uniform::new(mesh, &case.shape, level)?;
                let mut points = refined.points(control);
                refined.interpolate(control, &mut points);
                Ok((refined, points))
            }),
            per_vertex,
        ),
        told(
            KERNELS,
            memory_of(|| {
                let refined = kernel_mesh.refine(level)?;
                let points = kernels::interpolate(&refined, control)?;
                Ok((refined, points))
            }),
            per_vertex,
        ),
    ];
    let output = 12 * vertices + 16 * faces;
    entries.push(Entry::value(FLOOR, output as f64 / vertices as f64));
    emit(record(format!("level {level}, peak"), "bytes an output vertex", vertices, entries));

    let per_face = |memory: Memory| memory.kept as f64 / case.faces() as f64;
    let table = ours::build(case);
    let mut entries = vec![Entry::value(OURS, ours::table_bytes(&table) as f64 / case.faces() as f64)];
    for (name, isolation, most) in [(FAR_4, 4, 130_000), (FAR_6, 6, 30_000)] {
        entries.push(match context.at_most(most) {
            Ok(()) => told(name, memory_of(|| Patches::new(mesh, &case.shape, isolation)), per_face),
            Err(why) => Entry::absent(name, &why),
        });
    }
    let surfaces = || {
        let mut surfaces = FaceSurfaces::new(mesh, &case.shape)?;
        surfaces.init(true);
        Ok(surfaces)
    };
    entries.push(told(BFR_CACHED, memory_of(surfaces), per_face));
    emit(record("surface, kept".to_string(), "bytes a face", case.faces(), entries));
    Ok(())
}

fn told<R>(name: &str, measured: (Option<Memory>, Result<R, String>), of: impl Fn(Memory) -> f64) -> Entry {
    match measured {
        (_, Err(why)) => Entry::absent(name, &why),
        (None, Ok(_)) => Entry::absent(name, "not known"),
        (Some(memory), Ok(_)) => Entry::value(name, of(memory)),
    }
}

fn record(what: String, unit: &str, count: usize, entries: Vec<Entry>) -> Record {
    let unit = unit.to_string();
    Record { section: String::new(), mesh: String::new(), what, unit, count: count as f64, entries }
}
