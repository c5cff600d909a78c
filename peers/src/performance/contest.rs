//! One piece of work done by several programs, in turn, round after round, each beginning a round in turn; what each took, and
//! the ratio of each to ours of the same round. So what changes on the machine meanwhile changes both.

use super::clock::{self, Spent};
use super::record::{Entry, Record, Spread};
use std::any::Any;
use std::io::Write;
use std::time::Instant;

/// How long to go on.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    pub least_rounds: usize,
    pub most_rounds: usize,
    /// Seconds after which no further round begins, once there are enough.
    pub seconds: f64,
}

type Run<'a> = Box<dyn FnMut() -> Result<Spent, String> + 'a>;

struct Entrant<'a> {
    name: String,
    /// Or why it is named but not run.
    run: Result<Run<'a>, String>,
    note: String,
}

/// A piece of work, and who does it.
pub struct Contest<'a> {
    what: String,
    unit: &'static str,
    count: f64,
    entrants: Vec<Entrant<'a>>,
}

/// Nanoseconds that one measurement should take at least, so that clocks and their calls do not matter.
const LEAST_NS: f64 = 3e6;
const MOST_REPETITIONS: usize = 1000;

impl<'a> Contest<'a> {
    /// A contest about `count` things called `unit`. The first who enters is ours.
    pub fn new(what: impl Into<String>, unit: &'static str, count: usize) -> Self {
        Self { what: what.into(), unit, count: count as f64, entrants: Vec::new() }
    }

    /// Enters work with what it makes dropped off the clock.
    pub fn enter<R: 'static>(&mut self, name: &str, mut work: impl FnMut() -> Result<R, String> + 'a) -> &mut Self {
        self.enter_timed(name, move || {
            let (spent, result) = clock::spent(&mut work);
            result.map(|_| spent)
        })
    }

    /// The same on memory that nobody has touched: free memory goes back to the system before every run.
    pub fn enter_cold<R: 'static>(
        &mut self,
        name: &str,
        mut work: impl FnMut() -> Result<R, String> + 'a,
    ) -> &mut Self {
        self.enter_timed(name, move || {
            clock::release_free_memory();
            let (spent, result) = clock::spent(&mut work);
            let made: Box<dyn Any> = Box::new(result?);
            drop(made);
            Ok(spent)
        })
    }

    /// Enters work that keeps its own time.
    pub fn enter_timed(&mut self, name: &str, run: impl FnMut() -> Result<Spent, String> + 'a) -> &mut Self {
        self.entrants.push(Entrant { name: name.to_string(), run: Ok(Box::new(run)), note: String::new() });
        self
    }

    /// Names a rival that does not take part, and why.
    pub fn absent(&mut self, name: &str, why: impl Into<String>) -> &mut Self {
        self.entrants.push(Entrant { name: name.to_string(), run: Err(why.into()), note: String::new() });
        self
    }

    /// Adds a remark to the last one entered.
    pub fn noting(&mut self, note: impl Into<String>) -> &mut Self {
        self.entrants.last_mut().expect("someone has entered").note = note.into();
        self
    }

    /// Runs all in turn. `without` names those who are left out, and why.
    pub fn run(self, effort: Effort, without: &[(String, String)]) -> Record {
        Self::run_together(vec![self], effort, without).remove(0)
    }

    /// Runs several contests at once, a round of each in turn, so that their times can be compared with one another too:
    /// what changes on the machine meanwhile changes all. `effort` is for each of them.
    pub fn run_together(contests: Vec<Self>, effort: Effort, without: &[(String, String)]) -> Vec<Record> {
        let mut running: Vec<Running<'_>> =
            contests.into_iter().map(|contest| Running::new(contest, without)).collect();
        let seconds = effort.seconds * running.len() as f64;
        let start = Instant::now();
        let mut round = 0;
        while round < effort.least_rounds || round < effort.most_rounds && start.elapsed().as_secs_f64() < seconds {
            running.iter_mut().for_each(Running::round);
            round += 1;
        }
        running.into_iter().map(Running::record).collect()
    }
}

/// A contest under way.
struct Running<'a> {
    contest: Contest<'a>,
    /// Of every entrant.
    repetitions: Vec<usize>,
    /// What every entrant took, or nothing where it failed.
    rounds: Vec<Vec<Option<Spent>>>,
}

impl<'a> Running<'a> {
    fn new(mut contest: Contest<'a>, without: &[(String, String)]) -> Self {
        for entrant in &mut contest.entrants {
            if let Some((_, why)) = without.iter().find(|(name, _)| *name == entrant.name) {
                entrant.run = Err(why.clone());
            }
        }
        let repetitions = contest.entrants.iter_mut().map(first_run).collect();
        Self { contest, repetitions, rounds: Vec::new() }
    }

    /// Someone else begins each time: who comes after a pause pays for pages that the host has taken back.
    fn round(&mut self) {
        let order = order(self.rounds.len(), self.contest.entrants.len());
        let entrants = &mut self.contest.entrants;
        let mut round: Vec<Option<Spent>> = entrants.iter().map(|_| None).collect();
        for i in order {
            round[i] = measure(&mut entrants[i], self.repetitions[i]);
        }
        self.rounds.push(round);
    }

    fn record(self) -> Record {
        let Contest { what, unit, count, entrants } = self.contest;
        let rounds = &self.rounds;
        let entries = entrants
            .iter()
            .enumerate()
            .map(|(i, entrant)| {
                let each = |of: fn(&Spent) -> f64| -> Vec<f64> {
                    rounds.iter().filter_map(|r| r[i].as_ref().map(|s| of(s) / count)).collect()
                };
                let ours = |round: &Vec<Option<Spent>>| round[0].map(|s| s.processor);
                let ratio = |round: &Vec<Option<Spent>>| Some(round[i]?.processor / ours(round)?);
                let failed = entrant.run.as_ref().err().cloned();
                let measured = failed.is_none();
                Entry {
                    name: entrant.name.clone(),
                    processor: measured.then(|| Spread::of(each(|s| s.processor))).flatten(),
                    wall: measured.then(|| Spread::of(each(|s| s.wall))).flatten(),
                    ratio: Spread::of(rounds.iter().filter_map(ratio).collect()).filter(|_| measured && i > 0),
                    value: None,
                    failed,
                    note: entrant.note.clone(),
                }
            })
            .collect();
        Record { section: String::new(), mesh: String::new(), what, unit: unit.to_string(), count, entries }
    }
}

/// In which order so many entrants take part in a round: a turn further every second round, and backwards in between, so that
/// everyone begins as often, and nobody has the same one before him each time.
fn order(round: usize, entrants: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..entrants).map(|k| (round / 2 + k) % entrants).collect();
    if round % 2 == 1 {
        order.reverse();
    }
    order
}

/// Runs once to warm up, and finds how many runs make one measurement. Says first who runs, so that whoever reads along
/// knows who brought the process down.
fn first_run(entrant: &mut Entrant<'_>) -> usize {
    println!("running {}", entrant.name);
    let _ = std::io::stdout().flush();
    let Ok(run) = &mut entrant.run else { return 1 };
    match run() {
        Ok(spent) => ((LEAST_NS / spent.wall.max(1.0)).ceil() as usize).clamp(1, MOST_REPETITIONS),
        Err(why) => {
            entrant.run = Err(why);
            1
        }
    }
}

fn measure(entrant: &mut Entrant<'_>, repetitions: usize) -> Option<Spent> {
    let mut sum = Spent::default();
    for _ in 0..repetitions {
        let run = entrant.run.as_mut().ok()?;
        match run() {
            Ok(spent) => sum += spent,
            Err(why) => {
                entrant.run = Err(why);
                return None;
            }
        }
    }
    let n = repetitions as f64;
    Some(Spent { processor: sum.processor / n, wall: sum.wall / n })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHORT: Effort = Effort { least_rounds: 3, most_rounds: 3, seconds: 0.0 };

    fn takes(ns: f64) -> impl FnMut() -> Result<Spent, String> {
        move || Ok(Spent { processor: ns, wall: 2.0 * ns })
    }

    #[test]
    fn times_are_per_thing_and_ratios_to_the_first_of_the_same_round() {
        let mut contest = Contest::new("work", "vertex", 10);
        contest.enter_timed("ours", takes(1e7)).enter_timed("rival", takes(2e7));
        let record = contest.run(SHORT, &[]);
        assert_eq!(record.entries[0].processor.unwrap().median, 1e6);
        assert_eq!(record.entries[0].ratio, None);
        assert_eq!(record.entries[1].wall.unwrap().median, 4e6);
        assert_eq!(record.entries[1].ratio.unwrap().median, 2.0);
    }

    #[test]
    fn everyone_begins_as_often() {
        for entrants in 1..6 {
            let first = |i| (0..2 * entrants).filter(|&round| order(round, entrants)[0] == i).count();
            assert!((0..entrants).all(|i| first(i) == 2), "{entrants} entrants");
        }
        assert_eq!(order(3, 3), [0, 2, 1]);
    }

    #[test]
    fn who_fails_is_named_and_the_others_go_on() {
        let mut contest = Contest::new("work", "vertex", 1);
        contest.enter_timed("ours", takes(1e7)).enter_timed("rival", || Err("refuses".to_string()));
        contest.enter_timed("crashes", takes(1.0)).absent("other", "absent");
        let record = contest.run(SHORT, &[("crashes".to_string(), "aborts".to_string())]);
        let failed: Vec<_> = record.entries.iter().map(|e| e.failed.as_deref()).collect();
        assert_eq!(failed, [None, Some("refuses"), Some("aborts"), Some("absent")]);
        assert!(record.entries[0].processor.is_some() && record.entries[2].ratio.is_none());
    }
    #[test]
    fn contests_run_together_take_turns() {
        let order = std::cell::RefCell::new(Vec::new());
        let contests = [1, 2].map(|k| {
            let mut contest = Contest::new(k.to_string(), "vertex", 1);
            let order = &order;
            contest.enter_timed("ours", move || {
                order.borrow_mut().push(k);
                Ok(Spent { processor: 1e7, wall: 1e7 })
            });
            contest
        });
        let records = Contest::run_together(contests.into(), SHORT, &[]);
        assert_eq!(records.iter().map(|r| r.what.as_str()).collect::<Vec<_>>(), ["1", "2"]);
        // Each runs once before the first round.
        assert_eq!(*order.borrow(), [1, 2, 1, 2, 1, 2, 1, 2]);
    }
}
