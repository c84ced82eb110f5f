//! `pneudrive-model`: the command line of the modelling toolkit.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(pneudrive_model_cli::main(std::env::args_os().collect()))
}
