//! `pneudrive-sim`: virtual boards for any client of the bus.

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    pneudrive_sim::cli::Cli::parse().execute()
}
