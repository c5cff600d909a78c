//! The `subsurf` command line: exact Catmull-Clark limit surfaces as numbers, meshes and pictures.
//!
//! Each verb parses, calls the library and shows: one file for each. Exit status: 0 done, 1 the input is wrong or the
//! work could not be done, 2 wrong usage.

#![deny(unsafe_code)]

mod args;
mod baseline;
mod bench;
mod console;
mod eval;
mod failure;
mod figures;
mod heap;
mod info;
mod input;
mod interrupt;
mod manual;
mod memory;
mod normals;
mod oddities;
mod output;
mod refine;
mod render;
mod tessellate;

use args::{Cli, Common, Device, Verb};
use clap::Parser;
use console::Console;
use failure::Failure;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::parse_from(args::joined(std::env::args_os()));
    let console = Console::new(cli.common.quiet, cli.common.verbose);
    match run(&cli, &console) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Closed) => ExitCode::from(Failure::Closed.status()),
        Err(failure) => {
            console.error(&failure);
            ExitCode::from(failure.status())
        }
    }
}

fn run(cli: &Cli, console: &Console) -> Result<(), Failure> {
    let common = &cli.common;
    prepare(common)?;
    match &cli.verb {
        Verb::Info(args) => info::run(args, common, console),
        Verb::Refine(args) => refine::run(args, common, console),
        Verb::Tessellate(args) => tessellate::run(args, common, console),
        Verb::Eval(args) => eval::run(args, common, console),
        Verb::Render(args) => render::run(args, common, console),
        Verb::Bench(args) => bench::run(args, common, console),
        Verb::Figures(args) => figures::run(args, common, console),
        Verb::Completions(args) => manual::completions(args),
        Verb::Man(args) => manual::man(args),
    }
}

/// Threads, device and what an interrupt leaves.
fn prepare(common: &Common) -> Result<(), Failure> {
    if common.device == Device::Gpu {
        return Err(Failure::Gpu);
    }
    if let Some(threads) = common.threads.map(usize::from) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
        pool.map_err(|error| Failure::Threads { threads, reason: error.to_string() })?;
    }
    Ok(())
}
