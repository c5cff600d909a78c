//! What is measured: sections, each on some meshes. One section on one mesh runs in a process of its own.

mod build;
mod creases;
mod double;
mod edits;
mod limit;
mod memory;
mod refine;
mod stencils;
mod tessellate;
mod threads;

use super::case::{CAR, CHARACTER, Case, HEAD, SHOES};
use super::contest::{Contest, Effort};
use super::record::Record;
use crate::opensubdiv::CShape;
pub use creases::IN_TURN;

/// What a section gets.
pub struct Context<'a> {
    pub case: &'a Case,
    /// The mesh in C's terms; nobody's time to make.
    pub mesh: CShape<'a>,
    pub effort: Effort,
    /// Who is left out, and why.
    pub without: Vec<(String, String)>,
    pub quick: bool,
}

/// Results as they come.
pub type Emit<'a> = &'a mut dyn FnMut(Record);

/// A part of the document.
pub struct Section {
    pub name: &'static str,
    pub title: &'static str,
    pub meshes: &'static [&'static str],
    /// Of a quick run.
    pub quick: &'static [&'static str],
    pub run: fn(&Context<'_>, Emit<'_>) -> Result<(), String>,
    /// Whether it makes pools of threads itself; all others run on one thread, the caller's, and nothing is handed over.
    pub has_pools: bool,
    /// What its processes find in their environment.
    pub environment: &'static [(&'static str, &'static str)],
}

/// Has glibc ask for huge pages for all that it hands out.
const HUGE_PAGES: &[(&str, &str)] = &[("GLIBC_TUNABLES", "glibc.malloc.hugetlb=1")];

/// Has glibc (2.36 was tried) keep all memory that it once had.
const USED_MEMORY: &[(&str, &str)] =
    &[("GLIBC_TUNABLES", "glibc.malloc.mmap_threshold=17179869184:glibc.malloc.trim_threshold=17179869184")];

const C10K: &str = "cage_10k";
const C100K: &str = "cage_100k";
const C1M: &str = "cage_1m";

/// In the order of the document.
pub const SECTIONS: [Section; 15] = [
    Section {
        name: "build",
        title: "Build: from face lists to a surface that is ready to evaluate",
        meshes: &[CAR, SHOES, CHARACTER, HEAD, C10K, C100K, C1M],
        quick: &[CAR, C10K],
        run: build::run,
        has_pools: false,
        environment: &[],
    },
    Section {
        name: "refine",
        title: "Uniform refinement, cold: from face lists and positions to positions and faces of a level",
        meshes: &[CAR, SHOES, CHARACTER, HEAD, C10K, C100K, C1M],
        quick: &[CAR, C10K],
        run: refine::cold,
        has_pools: false,
        environment: &[],
    },
    Section {
        name: "huge-pages",
        title: "The same where everyone's memory is in huge pages",
        meshes: &[CAR, CHARACTER, C100K, C1M],
        quick: &[C10K],
        run: refine::cold,
        has_pools: false,
        environment: HUGE_PAGES,
    },
    Section {
        name: "animation",
        title: "Uniform refinement, warm: new positions on the same mesh",
        meshes: &[CAR, SHOES, CHARACTER, HEAD, C10K, C100K, C1M],
        quick: &[CAR, C10K],
        run: refine::warm,
        has_pools: false,
        environment: &[],
    },
    Section {
        name: "tessellate",
        title: "Tessellation of the limit surface",
        meshes: &[CAR, SHOES, CHARACTER, HEAD, C100K],
        quick: &[CAR],
        run: tessellate::run,
        has_pools: false,
        environment: &[],
    },
    Section {
        name: "stencils",
        title: "Stencil tables",
        meshes: &[CAR, CHARACTER, HEAD, C10K, C100K],
        quick: &[CAR],
        run: stencils::refined,
        has_pools: false,
        environment: &[],
    },
    Section {
        name: "limit",
        title: "Evaluation: position and first derivatives at random places",
        meshes: &[CAR, SHOES, CHARACTER, HEAD, C100K],
        quick: &[CAR, C10K],
        run: limit::run,
        has_pools: false,
        environment: &[],
    },
    Section {
        name: "limit-stencils",
        title: "Limit stencils of position and first derivatives",
        meshes: &[CAR, SHOES, CHARACTER, C10K],
        quick: &[CAR],
        run: stencils::limit,
        has_pools: false,
        environment: &[],
    },
    Section {
        name: "double",
        title: "Double precision: new positions, and random places",
        meshes: &[CAR, SHOES, CHARACTER, HEAD, C100K],
        quick: &[CAR],
        run: double::run,
        has_pools: false,
        environment: &[],
    },
    Section {
        name: "creases",
        title: "Creases: the Car with all its creases at one sharpness",
        meshes: &[CAR],
        quick: &[CAR],
        run: creases::run,
        has_pools: false,
        environment: &[],
    },
    Section {
        name: "memory",
        title: "Memory",
        meshes: &[CAR, CHARACTER, HEAD, C10K, C100K],
        quick: &[CAR, C10K],
        run: memory::run,
        has_pools: false,
        environment: &[],
    },
    Section {
        name: "threads",
        title: "Threads",
        meshes: &[CHARACTER, C100K, C1M],
        quick: &[CHARACTER],
        run: threads::run,
        has_pools: true,
        environment: &[],
    },
    Section {
        name: "edits",
        title: "Local edits",
        meshes: &[CHARACTER, C100K, C1M],
        quick: &[C10K],
        run: edits::run,
        has_pools: false,
        environment: &[],
    },
    Section {
        name: "scaling",
        title: "Scaling: build and refinement of cages that grow",
        meshes: &[C1M],
        quick: &[C100K],
        run: build::scaling,
        has_pools: false,
        environment: &[],
    },
    Section {
        name: "scaling-used",
        title: "The same on memory that was used before",
        meshes: &[C1M],
        quick: &[C100K],
        run: build::scaling_in_used_memory,
        has_pools: false,
        environment: USED_MEMORY,
    },
];

impl Context<'_> {
    fn run(&self, contest: Contest<'_>, emit: Emit<'_>) {
        emit(contest.run(self.effort, &self.without));
    }

    /// Contests whose times will be compared with one another.
    fn run_together(&self, contests: Vec<Contest<'_>>) -> Vec<Record> {
        Contest::run_together(contests, self.effort, &self.without)
    }

    /// Whether so many faces are few enough for a rival that takes long over each; who is left out says why.
    fn at_most(&self, faces: usize) -> Result<(), String> {
        self.at_most_of(self.case, faces)
    }

    /// The same of another mesh.
    fn at_most_of(&self, case: &Case, faces: usize) -> Result<(), String> {
        let most = if self.quick { faces / 3 } else { faces };
        if case.faces() <= most { Ok(()) } else { Err("not run: takes too long".to_string()) }
    }

    fn control(&self) -> &[[f32; 3]] {
        &self.case.control
    }
}

/// The larger of two errors; none is larger than one that is not a number.
fn worse(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// A remark where two lists of points differ by more than single precision explains, as multiples of the mesh's size.
fn agreement(case: &Case, ours: &[[f32; 3]], theirs: &[[f32; 3]]) -> String {
    if ours.len() != theirs.len() {
        return format!("has {} points, ours {}", theirs.len(), ours.len());
    }
    let pairs = ours.as_flattened().iter().zip(theirs.as_flattened());
    let most = pairs.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, worse);
    remark(most / case.shape.diagonal())
}

/// The same for lists in different orders: their means, and the means of their squares.
fn agreement_in_any_order(case: &Case, ours: &[[f32; 3]], theirs: &[[f32; 3]]) -> String {
    if ours.len() != theirs.len() {
        return format!("has {} points, ours {}", theirs.len(), ours.len());
    }
    let [ours, theirs] = [ours, theirs].map(moments);
    remark(moments_apart(&ours, &theirs) / case.shape.diagonal())
}

/// Mean, and root of the mean square, of every coordinate.
fn moments(points: &[[f32; 3]]) -> [f64; 6] {
    let n = points.len() as f64;
    std::array::from_fn(|i| {
        let each = points.iter().map(|p| f64::from(p[i % 3]));
        if i < 3 { each.sum::<f64>() / n } else { (each.map(|x| x * x).sum::<f64>() / n).sqrt() }
    })
}

fn moments_apart(ours: &[f64], theirs: &[f64]) -> f64 {
    ours.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, worse)
}

/// Sums of a few dozen terms in single precision stay below a few of its units, of which there are 2²³ in 1.
fn remark(apart: f64) -> String {
    if apart < 1e-5 { String::new() } else { format!("differs by {apart:.1e} of the size") }
}
