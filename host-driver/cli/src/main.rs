//! `pneudrive-host`: polls boards, shows and records their pressures.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(pneudrive_host_cli::main(std::env::args_os().collect()))
}
