//! What the user sees beside the result: warnings, notes and progress on standard error, text on standard output.

use crate::failure::Failure;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal, Write};

/// Where messages go, and how many of them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Console {
    pub quiet: bool,
    pub verbose: bool,
    /// Whether standard error takes colours.
    color: bool,
}

const BOLD: &str = "\x1b[1m";
const RED: &str = "\x1b[1;31m";
const YELLOW: &str = "\x1b[1;33m";
const BLUE: &str = "\x1b[1;34m";
const RESET: &str = "\x1b[0m";

impl Console {
    pub fn new(quiet: bool, verbose: bool) -> Self {
        Self { quiet, verbose, color: colors(&io::stderr()) }
    }

    /// What stopped the work.
    pub fn error(&self, message: &dyn std::fmt::Display) {
        self.line(RED, "error", message);
    }

    /// What was repaired or left out.
    pub fn warn(&self, message: &dyn std::fmt::Display) {
        if !self.quiet {
            self.line(YELLOW, "warning", message);
        }
    }

    /// What only the curious want to know.
    pub fn note(&self, message: &dyn std::fmt::Display) {
        if self.verbose && !self.quiet {
            self.line(BLUE, "note", message);
        }
    }

    fn line(&self, color: &str, label: &str, message: &dyn std::fmt::Display) {
        let (on, off) = if self.color { (color, RESET) } else { ("", "") };
        // A closed standard error leaves nobody to tell.
        let _ = writeln!(io::stderr(), "{on}{label}{off}: {message}");
    }

    /// A bar over `length` steps of `what`, drawn only on a terminal.
    pub fn progress(&self, what: &'static str, length: u64) -> ProgressBar {
        let bar = ProgressBar::with_draw_target(
            Some(length),
            if self.quiet || !io::stderr().is_terminal() {
                ProgressDrawTarget::hidden()
            } else {
                ProgressDrawTarget::stderr()
            },
        );
        let style = ProgressStyle::with_template("{msg:>12} {bar:40} {percent:>3} %  {eta}").expect("a valid template");
        bar.with_style(style.progress_chars("━╸─")).with_message(what)
    }
}

/// Whether `stream` takes colours: a terminal, and the user did not decline (<https://no-color.org>).
fn colors(stream: &impl IsTerminal) -> bool {
    stream.is_terminal()
        && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
        && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// A heading for standard output.
pub fn heading(text: &str) -> String {
    if colors(&io::stdout()) { format!("{BOLD}{text}{RESET}") } else { text.to_owned() }
}

/// Writes text to standard output.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(Failure::from_stdout)
}

/// Writes a machine-readable result to standard output.
pub fn print_json(value: &serde_json::Value) -> Result<(), Failure> {
    print(&format!("{value:#}\n"))
}
