//! `pneudrive-model`: the command line of the modelling toolkit.

mod cli;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    match cli::Cli::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if failure.has_message() {
                eprintln!("error: {failure}");
            }
            ExitCode::from(failure.status())
        }
    }
}
