//! `pneudrive-host`: polls boards, shows and records their pressures.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
