//! The command line of `pneudrive-model`, for the program of that name and for packages that bring
//! it along: one file per command, and what they share.

#![forbid(unsafe_code)]

mod compare;
mod diagnose;
mod effects;
mod error;
mod export;
mod file_kind;
mod fit;
mod import;
mod input;
mod interrupt;
mod machine;
mod options;
mod origin;
mod output;
mod print;
mod progress;
mod repair;
mod show;
mod simulate;
mod target;
mod trends;
mod watch;
mod watch_words;

use std::ffi::OsString;
use std::sync::OnceLock;

use clap::{CommandFactory, Parser, Subcommand};
use pneudrive_manual::Manual;

use error::Failure;
use print::errln;

/// Pressure models of pneumatic chambers: fit them to recordings, simulate, compare.
#[derive(Debug, Parser)]
#[command(name = "pneudrive-model", version, max_term_width = 100, arg_required_else_help = true)]
#[command(
    after_help = "A recording is a CSV file (plain, gzip or zstd) with the columns t_s, b0_cmd0_kpa, b0_p0_kpa, b0_u0 ...; \
`import` makes one of any CSV.\nExit status: 0 done, 1 failed or interrupted while running, 2 unusable arguments or input."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

/// One variant per command. A new command is a file of its own with its arguments and a `run`, and
/// one line here and below.
#[derive(Debug, Subcommand)]
enum Command {
    Fit(fit::Args),
    Simulate(simulate::Args),
    Compare(compare::Args),
    Diagnose(diagnose::Args),
    Effects(effects::Args),
    #[command(subcommand)]
    Export(export::Command),
    Import(import::Args),
    Repair(repair::Args),
    Show(show::Args),
    Trends(trends::Args),
    Watch(watch::Args),
    #[command(flatten)]
    Manual(Manual),
}

/// The command line of this process, the program's name first. Not `std::env::args`: an interpreter
/// may run this.
static LINE: OnceLock<Vec<OsString>> = OnceLock::new();

/// Does what a command line says, the program's name first; once in a process. Returns the exit
/// status: 0 done, 1 failed or interrupted while running, 2 unusable arguments or input. Help and
/// arguments that are none end the process.
pub fn main(line: Vec<OsString>) -> u8 {
    match Cli::parse_from(LINE.get_or_init(|| line)).run() {
        // What could not be printed has been said.
        Ok(()) => u8::from(print::failed()),
        Err(failure) => {
            if failure.has_message() {
                errln!("error: {failure}");
            }
            failure.status()
        }
    }
}

/// The arguments as given, without the program's name.
fn arguments() -> &'static [OsString] {
    LINE.get().and_then(|line| line.get(1..)).unwrap_or_default()
}

impl Cli {
    /// Runs the chosen command.
    fn run(self) -> Result<(), Failure> {
        match self.command {
            Command::Fit(args) => args.run(),
            Command::Simulate(args) => args.run(),
            Command::Compare(args) => args.run(),
            Command::Diagnose(args) => args.run(),
            Command::Effects(args) => args.run(),
            Command::Export(command) => command.run(),
            Command::Import(args) => args.run(),
            Command::Repair(args) => args.run(),
            Command::Show(args) => args.run(),
            Command::Trends(args) => args.run(),
            Command::Watch(args) => args.run(),
            Command::Manual(manual) => Ok(manual.run(Self::command())?),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn examples_of_the_help_are_whole_lines() {
        assert_eq!(pneudrive_manual::broken_examples(&Cli::command()), Vec::<String>::new());
    }
}
