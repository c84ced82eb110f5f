//! `completions` and `man`: what the command line's definition also says.

use crate::cli::args::{CompletionsArgs, ManArgs};
use crate::cli::command_line::command;
use crate::cli::failure::Failure;
use clap::Command;
use std::io::Write as _;

/// Prints completions for a shell.
pub fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command(), "pneudrive-host", &mut text);
    print(&text)
}

/// Prints the program's man page, or writes one for it and each subcommand.
pub fn man(args: &ManArgs) -> Result<(), Failure> {
    let command = command();
    let Some(folder) = &args.folder else { return print(&page(command)?) };
    clap_mangen::generate_to(command, folder)
        .map_err(|error| Failure::input(format!("{}: {error}", folder.display())))
}

fn page(command: Command) -> Result<Vec<u8>, Failure> {
    let mut text = Vec::new();
    clap_mangen::Man::new(command).render(&mut text).map_err(Failure::running)?;
    Ok(text)
}

/// A reader that has seen enough is no failure.
fn print(text: &[u8]) -> Result<(), Failure> {
    match std::io::stdout().write_all(text) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::running(format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}
