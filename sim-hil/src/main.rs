//! `pneudrive-sim`: virtual boards for any client of the bus.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(pneudrive_sim::cli::main(std::env::args_os().collect()))
}
