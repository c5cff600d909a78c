//! `subsurf completions` and `subsurf man`: what a package installs beside the program.

use crate::args::Cli;
use crate::console::print;
use crate::failure::Failure;
use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;

const COMPLETIONS: &str = "\
Examples:
  subsurf completions bash > ~/.local/share/bash-completion/completions/subsurf
  subsurf completions zsh > ~/.zfunc/_subsurf
  subsurf completions fish > ~/.config/fish/completions/subsurf.fish";

/// Print a script that completes the command line
#[derive(Args, Clone, Debug)]
#[command(after_help = COMPLETIONS)]
pub struct CompletionsArgs {
    /// For which shell
    shell: Shell,
}

const MAN: &str = "\
Examples:
  subsurf man | man -l -                              read the page
  subsurf man tessellate > subsurf-tessellate.1       the page of one verb";

/// Print a manual page
#[derive(Args, Clone, Debug)]
#[command(after_help = MAN)]
pub struct ManArgs {
    /// One verb [default: the program]
    #[arg(value_parser = ["info", "refine", "tessellate", "eval", "render", "figures"])]
    verb: Option<String>,
}

/// Prints completions.
pub fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "subsurf", &mut script);
    print(&String::from_utf8_lossy(&script))
}

/// Prints a manual page.
pub fn man(args: &ManArgs) -> Result<(), Failure> {
    let mut command = Cli::command();
    command.build();
    let page = match &args.verb {
        None => command,
        Some(verb) => {
            let found: Option<&Command> = command.find_subcommand(verb);
            found.ok_or(Failure::Usage("there is no such verb"))?.clone()
        }
    };
    let mut text = Vec::new();
    Man::new(page).render(&mut text).map_err(Failure::StandardOutput)?;
    print(&String::from_utf8_lossy(&text))
}
