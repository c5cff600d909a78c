//! The document: what was measured, on what, how, and whether goals are reached; everything from the records.

use super::case::CHARACTER;
use super::goals::{Behind, Outcome, behind, outcomes};
use super::machine;
use super::plot;
use super::record::{Entry, Record, Spread};
use super::rivals::name::*;
use super::sections::{SECTIONS, Section};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// One contest in a few lines, for the terminal.
pub fn brief(record: &Record) -> String {
    let Record { section, mesh, what, unit, count, entries } = record;
    let mut text = format!("{section} · {mesh} · {what} ({count} × {unit})\n");
    for e in entries {
        let told = match (&e.failed, &e.processor, e.value) {
            (Some(why), ..) => why.clone(),
            (_, Some(p), _) => format!("{:10.2} ns [{:.2} … {:.2}]", p.median, p.lower, p.upper),
            (_, _, Some(value)) => format!("{value:10.1}"),
            _ => String::new(),
        };
        let ratio = e.ratio.map_or_else(String::new, |r| format!("{:8.2} × ours", r.median));
        let _ = writeln!(text, "  {:26} {told:40} {ratio} {}", e.name, e.note);
    }
    text
}

/// Writes the document, and its figures into the folder `figures` beside it.
///
/// # Errors
/// What the system says.
pub fn write(document: &Path, records: &[Record], failures: &[String]) -> Result<(), String> {
    let save = |path: &Path, text: &str| {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        }
        fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
    };
    let figures = [("performance.svg", plot::overview(records)), ("performance-creases.svg", plot::creases(records))];
    for (name, svg) in &figures {
        save(&document.with_file_name("figures").join(name), svg)?;
    }
    save(document, &text(records, failures))
}

const INTRODUCTION: &str = "\
# Performance

Ours beside other implementations, on the same meshes with the same output, in single precision but for one section: every row in
one run with all who are named in it. Written by

    cargo run --release --manifest-path peers/Cargo.toml -- performance --write docs/performance.md

which takes a quarter of an hour; [peers/README.md](../peers/README.md) says what must be installed. Who is not there is
called absent.

- **Time** is processor time of the process on one thread, the caller's (the kernel's work for it included), because machines
  are shared; nothing is handed over to a pool. Threads are compared by the clock on the wall, where one thread is a pool of one.
- **Ratios** are others' time by ours: above 1 we are faster. All do the work in turn, round after round; a ratio is the
  median over the rounds of the ratio in each. Where it says so, quartiles stand beside it. Creases of all sharpnesses, and
  cages of all sizes, take turns too.
- **Cold** is from face lists, and from positions where the result has any, with everything built on the way; free memory
  goes back to the system before every run, so that everyone pays for fresh pages. **Warm** is new positions on a mesh whose
  tables are built.
- **Writing the output** is the floor: the time to write as many numbers, with nothing to compute, to fresh memory (cold)
  or memory used before (warm). Fresh memory costs most of it: our arrays ask for huge pages, where the system has them, and so does
  the floor; beside it stands the same in ordinary pages. Others take memory as it comes, but for one section where all
  have huge pages.
- Results are compared with ours first; a remark names a difference beyond rounding.
- Random places are 16 a face on average.
- `cage_…` are tori of quads with 6 % of extraordinary vertices of valence 3, 5 and 6, made by the program.
";

const RIVALS: &str = "\
## How the others are used

- **OpenSubdiv** is compiled from its own source without assertions, with the options above: what a release or a
  distribution's package has. `CXXFLAGS=-march=native` compiles it for the machine at hand.
- **OpenSubdiv Far**: `TopologyRefiner`, `RefineUniform` without topology that nothing needs, `PrimvarRefiner`. For
  tessellation also `Limit` with its tangents, which needs full topology at the last level; where creases are sharp still at
  that level, these are not the limit.
- **Far, isolation n**: `RefineAdaptive`, `PatchTable` with Gregory end caps and infinitely sharp patches, `PatchMap`. Places
  are found, bases evaluated and summed. It approximates near extraordinary vertices.
- **Osd**: `CpuEvaluator`, which has a kernel for four floats a point (xyzw) and one for any number (xyz). Batches: places
  found before, then `EvalPatches`; a frame begins with all refined points.
- **Bfr**: a `Surface<float>` a face, with default approximation, patch points prepared before; cached: with its own cache of
  irregular topology.
- **Embree**: a committed scene on one thread, `rtcInterpolate1`, and in batches `rtcInterpolateN` of 1024. Its commit builds
  a tree of boxes for rays too.
- **subdiv-kernels**: `refine_uniform`, `interpolate`, composed stencils, and its limit evaluator on level 1. Its list of
  edges is made off the clock.
- **half-edge**: the refinement of Dupuy and Vanhoey, *A halfedge refinement rule for parallel Catmull-Clark subdivision*
  (2021), a program of its own. Its twins are linked off the clock, even where all others are cold.
";

const GOALS: &str = "
## Goals

Least to most over meshes, and how many of the measurements reach the goal; then the same of a program that does nothing but
write the output: the most that anyone could reach on this machine.

";

fn text(records: &[Record], failures: &[String]) -> String {
    let mut text = INTRODUCTION.to_string();
    text += "\n| | |\n|---|---|\n";
    for (name, value) in machine::description() {
        let _ = writeln!(text, "| {name} | {value} |");
    }
    text += "\n![All in nanoseconds, one dot per mesh and level](figures/performance.svg)\n";
    text += GOALS;
    text += "| | goal | measured | reached | writing alone | would reach |\n|---|---|---|---|---|---|\n";
    outcomes(records).iter().for_each(|o| text += &goal_row(o));
    text += &rivals_ahead(records);
    for section in &SECTIONS {
        let chosen: Vec<&Record> = records.iter().filter(|r| r.section == section.name).collect();
        if !chosen.is_empty() {
            text += &section_text(section, &chosen);
        }
    }
    text += &format!("\n{RIVALS}");
    if !failures.is_empty() {
        text += "\n## Not measured\n\n";
        failures.iter().for_each(|f| {
            let _ = writeln!(text, "- {f}");
        });
    }
    text
}

fn goal_row(outcome: &Outcome) -> String {
    let Outcome { goal, wanted, measured, floor, unit } = outcome;
    let Some(measured) = measured else {
        return format!("| {goal} | {wanted} | not measured | | | |\n");
    };
    let cells = |([least, most], [reached, all]): &([f64; 2], [usize; 2])| {
        let range = if all == &1 { figure(*least) } else { format!("{} … {}", figure(*least), figure(*most)) };
        let reached = match (reached, all) {
            (r, n) if r == n => "yes".to_string(),
            (0, _) => "no".to_string(),
            (r, n) => format!("{r} of {n}"),
        };
        format!("{range}{unit} | {reached}")
    };
    let floor = floor.as_ref().map_or(" | ".to_string(), cells);
    format!("| {goal} | {wanted} | {} | {floor} |\n", cells(measured))
}

/// Where another is faster than we are.
fn rivals_ahead(records: &[Record]) -> String {
    let (mut behind, count) = behind(records);
    if behind.is_empty() {
        return format!("\nIn none of {count} comparisons is another ahead.\n");
    }
    behind.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
    let mut text = format!("\nIn {} of {count} comparisons another is ahead:\n\n", behind.len());
    for Behind { what, rival, ratio } in &behind {
        let remark = if rival == HALF_EDGE && what.ends_with("cold") { ", its twins linked off the clock" } else { "" };
        let _ = writeln!(text, "- {what}: {rival}, {}×{remark}", figure(*ratio));
    }
    text
}

fn section_text(section: &Section, records: &[&Record]) -> String {
    let mut text = format!("\n## {}\n", section.title);
    if section.name == "creases" {
        text += "\n![Cost of creases](figures/performance-creases.svg)\n";
    }
    if section.name == "threads" {
        return text + &threads(records);
    }
    // Rows of one table have the same unit.
    let mut units: Vec<&str> = records.iter().map(|r| r.unit.as_str()).collect();
    units.dedup();
    let units: Vec<&str> =
        units.iter().enumerate().filter(|(i, u)| !units[..*i].contains(u)).map(|(_, &u)| u).collect();
    for unit in units {
        let rows: Vec<&Record> = records.iter().filter(|r| r.unit == unit).copied().collect();
        text += &table(unit, &rows);
    }
    if section.name == "tessellate" {
        text += &frames(records);
    }
    text + &spreads(records)
}

/// How often a second everyone evaluates new positions of the character.
fn frames(records: &[&Record]) -> String {
    let animated = records.iter().filter(|r| r.mesh == CHARACTER && r.what.ends_with("normals, warm"));
    let mut text = String::new();
    for record in animated {
        let timed = record.entries.iter().filter(|e| e.name != FLOOR).filter_map(|e| Some((e, e.processor?)));
        let (names, cells): (Vec<&str>, Vec<String>) =
            timed.map(|(e, ns)| (e.name.as_str(), figure(1e9 / (ns.median * record.count)))).unzip();
        let _ = write!(text, "\n| frames per second, one thread | {} |\n|---|", names.join(" | "));
        text += &"--:|".repeat(names.len());
        let _ = write!(text, "\n| {}, {} | {} |\n", record.mesh, record.what, cells.join(" | "));
    }
    text
}

/// One row per contest, one column for everyone.
fn table(unit: &str, records: &[&Record]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for entry in records.iter().flat_map(|r| &r.entries) {
        if !names.contains(&entry.name.as_str()) {
            names.push(&entry.name);
        }
    }
    names.sort_by_key(|&name| [FLOOR, FLOOR_ORDINARY].contains(&name));
    let timed = records.iter().flat_map(|r| &r.entries).any(|e| e.processor.is_some());
    let unit = if timed { format!("ns per {unit}") } else { unit.to_string() };
    let mut text = format!("\n| {unit} | number | {} |\n|---|--:|", names.join(" | "));
    text += &"--:|".repeat(names.len());
    text.push('\n');
    let mut remarks: Vec<String> = Vec::new();
    for record in records {
        let _ = write!(text, "| {}, {} | {} ", record.mesh, record.what, thousands(record.count));
        for name in &names {
            let cell = record.entry(name).map_or_else(String::new, |e| cell(e, &mut remarks));
            let _ = write!(text, "| {cell} ");
        }
        text += "|\n";
    }
    for (i, remark) in remarks.iter().enumerate() {
        let _ = write!(text, "{}{} {remark}", if i == 0 { "\n" } else { "; " }, superscript(i + 1));
    }
    if remarks.is_empty() { text } else { text + ".\n" }
}

fn cell(entry: &Entry, remarks: &mut Vec<String>) -> String {
    let mut text = match (&entry.failed, entry.processor, entry.value) {
        (Some(why), ..) => return why.replace('|', "/"),
        (_, Some(p), _) if entry.name == OURS => format!("**{}**", figure(p.median)),
        (_, Some(p), _) => figure(p.median),
        (_, _, Some(value)) => figure(value),
        _ => String::new(),
    };
    if let Some(ratio) = entry.ratio {
        let _ = write!(text, " ({}×)", figure(ratio.median));
    }
    if !entry.note.is_empty() {
        let place = remarks.iter().position(|r| *r == entry.note).unwrap_or_else(|| {
            remarks.push(entry.note.clone());
            remarks.len() - 1
        });
        text += &superscript(place + 1);
    }
    text
}

/// Quartiles of all, folded away.
fn spreads(records: &[&Record]) -> String {
    let mut rows = String::new();
    for record in records {
        for e in &record.entries {
            let Some(p) = e.processor else { continue };
            let wall = e.wall.map_or_else(String::new, |w| figure(w.median));
            let quartiles = |s: Spread| format!("{} … {}", figure(s.lower), figure(s.upper));
            let ratio = e.ratio.map_or_else(String::new, quartiles);
            let (mesh, what, name, n) = (&record.mesh, &record.what, &e.name, p.rounds);
            let _ = writeln!(
                rows,
                "| {mesh}, {what} | {name} | {} | {} | {wall} | {ratio} | {n} |",
                figure(p.least),
                quartiles(p)
            );
        }
    }
    if rows.is_empty() {
        return rows;
    }
    let head =
        "| | | least | quartiles | wall, median | quartiles of the ratio | rounds |\n|---|---|--:|--:|--:|--:|--:|\n";
    format!("\n<details><summary>Spread</summary>\n\n{head}{rows}\n</details>\n")
}

/// By the clock on the wall, and how many times as fast as one thread.
fn threads(records: &[&Record]) -> String {
    let mut names: Vec<&str> = records.iter().flat_map(|r| &r.entries).map(|e| e.name.as_str()).collect();
    names.sort_by_key(|name| name.split(' ').next().and_then(|n| n.parse::<usize>().ok()));
    names.dedup();
    let mut text = format!("\n| ns, on the wall | {} |\n|---|", names.join(" | "));
    text += &"--:|".repeat(names.len());
    text.push('\n');
    for record in records {
        let _ = write!(text, "| {}, {}, per {} ", record.mesh, record.what, record.unit);
        let wall = |name: &str| Some(record.entry(name)?.wall?.median);
        for name in &names {
            let cell = match (wall(name), wall("1 thread")) {
                (Some(ns), Some(one)) if *name != "1 thread" => format!("{} ({:.2}×)", figure(ns), one / ns),
                (Some(ns), _) => figure(ns),
                _ => String::new(),
            };
            let _ = write!(text, "| {cell} ");
        }
        text += "|\n";
    }
    text + "\nThe results are the same bits on all.\n"
}

/// Three digits that count.
pub fn figure(x: f64) -> String {
    match x.abs() {
        a if a >= 1e6 => thousands((x / 10f64.powi(a.log10() as i32 - 2)).round() * 10f64.powi(a.log10() as i32 - 2)),
        a if a >= 100.0 => thousands(x.round()),
        a if a >= 10.0 => format!("{x:.1}"),
        _ => format!("{x:.2}"),
    }
}

fn thousands(x: f64) -> String {
    let digits = format!("{:.0}", x.abs());
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    if x < 0.0 { format!("-{text}") } else { text }
}

fn superscript(number: usize) -> String {
    let digit = |c: char| ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][c as usize - '0' as usize];
    number.to_string().chars().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_three_digits_that_count_and_commas() {
        let cases = [(0.4567, "0.46"), (1.234, "1.23"), (45.67, "45.7"), (456.7, "457"), (45_678.0, "45,678")];
        cases.iter().for_each(|(x, text)| assert_eq!(figure(*x), *text));
        assert_eq!(figure(1_234_567.0), "1,230,000");
        assert_eq!(superscript(12), "¹²");
    }

    #[test]
    fn a_table_names_who_is_absent_and_explains_remarks_once() {
        let entry = |name: &str, ns: f64, note: &str| Entry {
            name: name.to_string(),
            processor: Spread::of(vec![ns]),
            ratio: (name != OURS).then(|| Spread::of(vec![ns / 2.0])).flatten(),
            note: note.to_string(),
            ..Entry::default()
        };
        let record = Record {
            section: "refine".to_string(),
            mesh: "cube".to_string(),
            what: "level 2".to_string(),
            unit: "vertex".to_string(),
            count: 98.0,
            entries: vec![
                entry(OURS, 2.0, ""),
                entry(FLOOR, 1.0, ""),
                entry(FAR, 60.0, "differs"),
                entry(BFR, 80.0, "differs"),
                Entry::absent(EMBREE, "absent"),
            ],
        };
        let text = table("vertex", &[&record]);
        let row = text.lines().last().filter(|l| l.starts_with('¹')).expect("remarks come last");
        assert_eq!(row, "¹ differs.");
        assert!(
            text.contains("| cube, level 2 | 98 | **2.00** | 60.0 (30.0×)¹ | 80.0 (40.0×)¹ | absent | 1.00 (0.50×) |")
        );
    }
}
