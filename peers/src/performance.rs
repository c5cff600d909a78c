//! `peers performance`: ours beside every rival, in one run, on the same meshes, as JSON lines; and from those the
//! document and its figures.
//!
//! Every section runs on every mesh in a process of its own, on one thread but where threads are the question: so memory
//! is fresh, and a rival that brings the process down is named and left out of a second try.

mod cage;
pub mod case;
mod clock;
mod contest;
mod floor;
mod goals;
mod machine;
mod ours;
mod places;
mod plot;
mod record;
mod report;
mod rivals;
mod sections;

use crate::opensubdiv::CShape;
use case::Case;
use contest::Effort;
use record::Record;
use sections::{Context, SECTIONS, Section};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

pub const USAGE: &str = "usage: peers performance [options]
  --models DIR        where models are; default ../shared/models, then the repository's assets
  --only SECTION,...  these sections alone: build refine huge-pages animation tessellate stencils limit limit-stencils
                      double creases memory threads edits scaling scaling-used
  --on MESH,...       these meshes alone: catmark_car mh_shoes03_semisharp makehuman_base ict_face_neutral cage_10k cage_100k
                      cage_1m; these two are on four cages at once, of which cage_1m stands for all
  --quick             fewer and smaller meshes, fewer rounds
  --repeats N         at most N rounds per contest; default 15
  --seconds S         no further round after S seconds; default 1.5
  --again             measure also what the results hold already
  --results FILE      JSON lines, kept as they come; default target/performance.jsonl beside the program's folder
  --write FILE.md     write the document and its figures (FILE's folder/figures); nothing is measured with --only none
Sections that the results hold already, with the same options, are not measured again.";

/// What was asked for.
#[derive(Clone, Debug)]
struct Options {
    models: Option<String>,
    only: Vec<String>,
    on: Vec<String>,
    quick: bool,
    repeats: usize,
    seconds: Option<f64>,
    again: bool,
    results: PathBuf,
    write: Option<PathBuf>,
}

/// Longest that one section may take on one mesh.
const PATIENCE: Duration = Duration::from_secs(400);

impl Options {
    fn parse(words: &[&str]) -> Result<Self, String> {
        let mut options = Self {
            models: None,
            only: Vec::new(),
            on: Vec::new(),
            quick: false,
            repeats: 15,
            seconds: None,
            again: false,
            results: Path::new(env!("CARGO_MANIFEST_DIR")).join("target/performance.jsonl"),
            write: None,
        };
        let mut words = words.iter();
        let list = |text: &str| text.split(',').map(str::to_string).collect();
        while let Some(&word) = words.next() {
            let mut value = || words.next().copied().ok_or_else(|| format!("{word} needs a value\n{USAGE}"));
            match word {
                "--models" => options.models = Some(value()?.to_string()),
                "--only" => options.only = list(value()?),
                "--on" => options.on = list(value()?),
                "--quick" => options.quick = true,
                "--repeats" => options.repeats = value()?.parse().map_err(|e| format!("--repeats: {e}"))?,
                "--seconds" => options.seconds = Some(value()?.parse().map_err(|e| format!("--seconds: {e}"))?),
                "--again" => options.again = true,
                "--results" => options.results = PathBuf::from(value()?),
                "--write" => options.write = Some(PathBuf::from(value()?)),
                _ => return Err(format!("{word}: no such option\n{USAGE}")),
            }
        }
        let known = |name: &String| name == "none" || SECTIONS.iter().any(|s| s.name == name);
        if let Some(name) = options.only.iter().find(|name| !known(name)) {
            return Err(format!("{name}: no such section\n{USAGE}"));
        }
        Ok(options)
    }

    fn effort(&self) -> Effort {
        let (least_rounds, seconds) = if self.quick { (2, 0.3) } else { (3, 1.5) };
        let seconds = self.seconds.unwrap_or(seconds);
        Effort { least_rounds: least_rounds.min(self.repeats.max(1)), most_rounds: self.repeats.max(1), seconds }
    }

    fn meshes(&self, section: &Section) -> Vec<&'static str> {
        let meshes = if self.quick && self.on.is_empty() { section.quick } else { section.meshes };
        let chosen = |mesh: &&&str| self.on.is_empty() || self.on.iter().any(|on| on == **mesh);
        meshes.iter().filter(chosen).copied().collect()
    }
}

/// The command.
///
/// # Errors
/// Wrong usage, or what could not be measured or written; all that could be is kept.
pub fn run(words: &[&str]) -> Result<(), String> {
    let options = Options::parse(words)?;
    let mut failures = Vec::new();
    for section in &SECTIONS {
        if !options.only.is_empty() && !options.only.iter().any(|name| name == section.name) {
            continue;
        }
        for mesh in options.meshes(section) {
            if let Err(why) = measure(&options, section, mesh) {
                eprintln!("{} on {mesh}: {why}", section.name);
                failures.push(format!("{} on {mesh}: {why}", section.name));
            }
        }
    }
    if let Some(document) = &options.write {
        report::write(document, &record::read(&options.results), &failures)?;
    }
    if failures.is_empty() { Ok(()) } else { Err(format!("not measured:\n{}", failures.join("\n"))) }
}

/// Measures one section on one mesh in another process, and keeps what it says.
fn measure(options: &Options, section: &Section, mesh: &str) -> Result<(), String> {
    let mut kept = record::read(&options.results);
    if !options.again && kept.iter().any(|r| r.section == section.name && r.mesh == mesh) {
        return Ok(());
    }
    let start = Instant::now();
    let mut without: Vec<(String, String)> = Vec::new();
    loop {
        let (records, end) = part(options, section, mesh, &without)?;
        match end {
            End::Done => {
                kept.retain(|r| !records.iter().any(|new| (&new.section, &new.mesh) == (&r.section, &r.mesh)));
                records.iter().for_each(|r| println!("{}", report::brief(r)));
                kept.extend(records);
                record::write(&options.results, &kept)?;
                eprintln!("{} on {mesh}: {:.0} s", section.name, start.elapsed().as_secs_f64());
                return Ok(());
            }
            End::Failed { running: Some(name), why } if !without.iter().any(|(n, _)| *n == name) => {
                eprintln!("{} on {mesh}: {name} {why}; again without it", section.name);
                without.push((name, why));
            }
            End::Failed { why, .. } => return Err(why),
        }
    }
}

enum End {
    Done,
    /// Who ran last, if anyone was said to.
    Failed {
        running: Option<String>,
        why: String,
    },
}

/// Runs this program again for one part, and reads along.
fn part(
    options: &Options,
    section: &Section,
    mesh: &str,
    without: &[(String, String)],
) -> Result<(Vec<Record>, End), String> {
    let effort = options.effort();
    let mut command = Command::new(std::env::current_exe().map_err(|e| e.to_string())?);
    command.args(["performance-part", section.name, mesh]);
    command.arg(options.models.as_deref().unwrap_or(""));
    command.args([effort.least_rounds, effort.most_rounds].map(|n| n.to_string()));
    command.args([effort.seconds.to_string(), options.quick.to_string()]);
    without.iter().for_each(|(name, why)| {
        command.args([name, why]);
    });
    command
        .envs(section.environment.iter().copied())
        .env("OMP_NUM_THREADS", "1")
        .stdin(Stdio::null())
        .stdout(Stdio::piped());
    let mut child = command.spawn().map_err(|e| e.to_string())?;
    let lines = BufReader::new(child.stdout.take().expect("it is piped")).lines();
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || lines.map_while(Result::ok).try_for_each(|line| sender.send(line)));
    let (mut records, mut running, mut failure) = (Vec::new(), None, None);
    let deadline = Instant::now() + PATIENCE;
    loop {
        match receiver.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
            Ok(line) => match (line.strip_prefix("running "), line.strip_prefix("failed ")) {
                (Some(name), _) => running = Some(name.to_string()),
                (_, Some(why)) => failure = Some(why.to_string()),
                _ => records.extend(Record::from_line(&line)),
            },
            Err(mpsc::RecvTimeoutError::Disconnected) => break,
            Err(mpsc::RecvTimeoutError::Timeout) => {
                let _ = child.kill();
                let _ = child.wait();
                let why = format!("does not end within {} s", PATIENCE.as_secs());
                return Ok((records, End::Failed { running, why }));
            }
        }
    }
    let status = child.wait().map_err(|e| e.to_string())?;
    let end = match (status.success(), failure) {
        (true, None) => End::Done,
        (_, Some(why)) => End::Failed { running: None, why },
        (false, None) => End::Failed { running, why: format!("brings the process down ({status})") },
    };
    Ok((records, end))
}

/// What [`part`] starts: one section on one mesh, results as lines on standard output.
///
/// # Errors
/// If the words are not those of [`part`].
pub fn run_part(words: &[&str]) -> Result<(), String> {
    let [section, mesh, models, least, most, seconds, quick, without @ ..] = words else {
        return Err("not for use by hand".to_string());
    };
    let section = SECTIONS.iter().find(|s| s.name == *section).ok_or("no such section")?;
    let number = |word: &str| word.parse::<usize>().map_err(|e| e.to_string());
    let effort = Effort {
        least_rounds: number(least)?,
        most_rounds: number(most)?,
        seconds: seconds.parse().map_err(|e: std::num::ParseFloatError| e.to_string())?,
    };
    if !section.has_pools {
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global();
        alone.map_err(|e| e.to_string())?;
    }
    let folders = case::folders(Some(*models).filter(|m| !m.is_empty()));
    let result = Case::load(mesh, &folders).and_then(|case| {
        let context = Context {
            case: &case,
            mesh: CShape::new(&case.shape),
            effort,
            without: without.chunks_exact(2).map(|w| (w[0].to_string(), w[1].to_string())).collect(),
            quick: *quick == "true",
        };
        (section.run)(&context, &mut |mut record: Record| {
            record.section = section.name.to_string();
            if record.mesh.is_empty() {
                record.mesh = mesh.to_string();
            }
            println!("{}", record.to_line());
        })
    });
    if let Err(why) = result {
        println!("failed {why}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_named_and_sections_known() {
        let options = Options::parse(&["--only", "refine,limit", "--quick", "--repeats", "4"]).unwrap();
        assert_eq!((options.only.len(), options.quick, options.repeats), (2, true, 4));
        assert!(Options::parse(&["--only", "refinement"]).is_err());
        assert!(Options::parse(&["--repeats"]).is_err());
    }

    #[test]
    fn every_section_has_a_name_of_its_own_and_quick_meshes_among_its_meshes() {
        for (i, section) in SECTIONS.iter().enumerate() {
            assert!(SECTIONS[..i].iter().all(|s| s.name != section.name));
            assert!(!section.quick.is_empty() && !section.title.is_empty());
        }
    }
}
