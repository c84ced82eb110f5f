//! Man pages and shell completions: subcommands that every program of ours has.
//!
//! ```text
//!   a program's clap::Command ──▶ completions ──▶ standard output
//!                           └───▶ man ──▶ standard output, or pages for subcommands in a folder
//! ```
//!
//! ```
//! use clap::{CommandFactory, Parser, Subcommand};
//!
//! /// A program.
//! #[derive(Parser)]
//! #[command(name = "example")]
//! struct Cli {
//!     #[command(subcommand)]
//!     command: Command,
//! }
//!
//! #[derive(Subcommand)]
//! enum Command {
//!     #[command(flatten)]
//!     Manual(pneudrive_manual::Manual),
//! }
//!
//! let Command::Manual(manual) = Cli::parse_from(["example", "completions", "bash"]).command;
//! manual.run(Cli::command())?; // prints what the shell reads
//! # Ok::<(), pneudrive_manual::ManualError>(())
//! ```

use clap::{Args, Command, Subcommand};
use clap_complete::Shell;
use std::io::{ErrorKind, Write as _};
use std::path::PathBuf;

/// The subcommands, to be flattened into those of a program.
#[derive(Debug, Clone, PartialEq, Eq, Subcommand)]
pub enum Manual {
    /// Completions for a shell
    Completions(CompletionsArgs),
    /// Man pages
    Man(ManArgs),
}

/// Arguments of `completions`.
#[derive(Debug, Clone, PartialEq, Eq, Args)]
pub struct CompletionsArgs {
    /// For which shell; what is printed belongs where the shell looks for completions
    pub shell: Shell,
}

/// Arguments of `man`.
#[derive(Debug, Clone, PartialEq, Eq, Args)]
pub struct ManArgs {
    /// Write a page for the program and each subcommand into this folder; without it the program's
    /// page is printed
    #[arg(value_name = "FOLDER")]
    pub folder: Option<PathBuf>,
}

/// Why there are no pages or completions.
#[derive(Debug, thiserror::Error)]
pub enum ManualError {
    /// The folder cannot be written to.
    #[error("{}: {source}", folder.display())]
    Folder {
        /// As it was given.
        folder: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Standard output cannot be written to.
    #[error("standard output: {0}")]
    Output(std::io::Error),
}

impl ManualError {
    /// Exit status of a program that ends with this error: 2 for unusable arguments, 1 for a
    /// failure while running.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Folder { .. } => 2,
            Self::Output(_) => 1,
        }
    }
}

impl Manual {
    /// The subcommand as it is typed.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Completions(_) => "completions",
            Self::Man(_) => "man",
        }
    }

    /// Prints or writes what is asked for, of the program that `command` defines.
    ///
    /// # Errors
    /// The folder or standard output cannot be written to. A reader that has seen enough (`| head`)
    /// is no error.
    pub fn run(&self, mut command: Command) -> Result<(), ManualError> {
        let mut text = Vec::new();
        match self {
            Self::Completions(CompletionsArgs { shell }) => {
                let name = command.get_name().to_owned();
                clap_complete::generate(*shell, &mut command, name, &mut text);
            }
            Self::Man(ManArgs { folder: None }) => {
                clap_mangen::Man::new(command).render(&mut text).map_err(ManualError::Output)?;
            }
            Self::Man(ManArgs { folder: Some(folder) }) => {
                return clap_mangen::generate_to(command, folder)
                    .map_err(|source| ManualError::Folder { folder: folder.clone(), source });
            }
        }
        match std::io::stdout().write_all(&text) {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(ManualError::Output(error)),
            _ => Ok(()),
        }
    }
}

/// Lines of examples in the help of a command and its subcommands that are broken where help is 100
/// wide, as it is where it is not read on a terminal: who copies them gets half a command. For
/// programs' tests.
#[must_use]
pub fn broken_examples(command: &Command) -> Vec<String> {
    let helps = [command.get_after_help(), command.get_after_long_help()].into_iter().flatten();
    let text = helps.map(ToString::to_string).collect::<Vec<_>>().join("\n");
    let long = text.lines().filter(|line| line.starts_with("  ") && line.chars().count() > HELP_WIDTH);
    long.map(str::to_owned).chain(command.get_subcommands().flat_map(broken_examples)).collect()
}

/// Width of help that is not read on a terminal.
const HELP_WIDTH: usize = 100;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn examples_are_looked_at_in_subcommands_and_text_is_not() {
        let long =
            format!("Examples:\n  example {}\n  example short\n{}", "x".repeat(91), "text ".repeat(30));
        let command = Command::new("example").subcommand(Command::new("one").after_help(long));
        assert_eq!(broken_examples(&command), [format!("  example {}", "x".repeat(91))]);
    }
}
